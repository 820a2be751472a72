//! Every rule of selecting lights estimates the same integral, in every tile of the image: for few lights, each selected by
//! its own estimate, and for many in a tree, in front of matte, glossy and transmissive surfaces.

use super::integrators::{assert_same, rendered, settings};
use crate::common::nightly::samples_and_limit;
use crate::common::room::room;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::light::types::LightChoice;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::description::SceneDescription;

/// A ball of rough glass, and one of gold.
const OBJECTS: &str = r#"
[[material]]
name = "gold"
type = "conductor"
preset = "gold"
roughness = 0.4

[[material]]
name = "glass"
type = "dielectric"
roughness = 0.7

[[shape]]
type = "sphere"
material = "gold"
center = [-0.45, 0.45, -0.2]
radius = 0.4

[[shape]]
type = "sphere"
material = "glass"
center = [0.45, 0.4, 0.1]
radius = 0.35
"#;

/// Lamps of every kind, of different reach.
fn five_lamps() -> SceneDescription {
    room(&format!(
        r#"{OBJECTS}
[[shape]]
type = "rectangle"
material = "white"
emission = [9, 8, 6]
corner = [-0.2, 1.99, -0.2]
edge_u = [0.4, 0, 0]
edge_v = [0, 0, 0.4]

[[shape]]
type = "sphere"
material = "white"
emission = [30, 10, 5]
center = [0.8, 0.1, -0.8]
radius = 0.06

[[light]]
type = "point"
position = [-0.8, 0.3, 0.6]
intensity = [0.02, 0.05, 0.1]

[[light]]
type = "spot"
position = [0.5, 1.8, 0.5]
target = [0, 0, 0]
cone = 30
intensity = 1

[[light]]
type = "distant"
direction = [-0.2, -1, -1]
irradiance = 0.5
"#
    ))
}

/// Sixty lamps that look in different directions, near the floor and the walls.
fn sixty_lamps() -> SceneDescription {
    let mut more = String::from(OBJECTS);
    for i in 0..60 {
        let [x, y, z] = [0.618, 0.414, 0.732].map(|step| (step * f64::from(i)).fract());
        let [a, b] = [0.3, 0.7].map(|step| (step * f64::from(i)).fract() - 0.5);
        more += &format!(
            r#"
[[shape]]
type = "disk"
material = "white"
emission = {}
center = [{}, {}, {}]
normal = [{a}, {b}, {}]
radius = {}
"#,
            if i % 7 == 0 { 40 } else { 8 },
            1.8 * x - 0.9,
            1.8 * y + 0.1,
            1.8 * z - 0.9,
            a - b + 0.1,
            if i % 5 == 0 { 0.06 } else { 0.02 },
        );
    }
    room(&more)
}

#[test]
fn power_and_contribution_light_selection_agree() {
    let (spp, limit) = samples_and_limit(1 << 12, 0.03);
    for (name, scene) in [("five lamps", five_lamps()), ("sixty lamps", sixty_lamps())] {
        let by = |integrator, choice, seed, spp| {
            let settings = RenderSettings {
                light_choice: Some(choice),
                max_bounces: Some(4),
                ..settings(&scene, integrator, seed, spp)
            };
            rendered(&scene, &settings)
        };
        let power = by(IntegratorKind::Path, LightChoice::Power, 1, 2 * spp);
        for integrator in [IntegratorKind::Path, IntegratorKind::NextEvent] {
            let what = format!("{name}, {}", integrator.name());
            let other = by(integrator, LightChoice::Contribution, 2, spp);
            assert_same(&what, &other, &power, limit);
        }
    }
}
