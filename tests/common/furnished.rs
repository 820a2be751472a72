//! Rooms with objects in them, each with a different kind of light transport.
//!
//! Measure: world units; radiance.
//! Range: as [`room`], except [`furnished`], which has 32 x 32 pixels.
//! Source: none needed.

use super::room::{LAMP, room};
use etendue::internals::scene::description::SceneDescription;

/// Six scenes in which integrators have to agree, with the largest relative standard error of the whole image at which a
/// comparison is conclusive.
pub fn six_scenes() -> [(&'static str, SceneDescription, f64); 6] {
    [
        ("matte", matte(), 0.01),
        ("glossy", glossy(), 0.02),
        ("small light", small_light(), 0.03),
        ("rough glass", glass(0.8), 0.02),
        ("smooth glass", glass(0.0), 0.01),
        ("outside", outside(), 0.01),
    ]
}

/// A room with two matte blocks.
pub fn matte() -> SceneDescription {
    room(&format!(
        "{LAMP}
[[shape]]
type = \"box\"
material = \"white\"
min = [-0.6, 0, -0.6]
max = [-0.1, 1.1, -0.1]
"
    ))
}

/// Rough metal, plastic with a smooth coat, and a lamp of two triangles.
pub fn glossy() -> SceneDescription {
    room(
        r#"
[[material]]
name = "metal"
type = "conductor"
preset = "gold"
roughness = 0.5

[[material]]
name = "plastic"
type = "plastic"
reflectance = [0.2, 0.3, 0.7]
roughness = 0

[[shape]]
type = "sphere"
material = "metal"
center = [-0.45, 0.45, -0.2]
radius = 0.45

[[shape]]
type = "sphere"
material = "plastic"
center = [0.5, 0.4, 0.1]
radius = 0.4

[[shape]]
type = "mesh"
material = "white"
emission = [9, 8, 6]
positions = [[-0.5, 1.99, -0.4], [0.4, 1.99, -0.5], [0.4, 1.99, 0.4], [-0.4, 1.99, 0.5]]
indices = [[0, 1, 2], [0, 2, 3]]
"#,
    )
}

/// A small bright sphere above a matte block, and a dim one that is larger.
pub fn small_light() -> SceneDescription {
    room(
        r#"
[[shape]]
type = "sphere"
material = "white"
emission = 60
center = [0.2, 1.6, 0]
radius = 0.1

[[shape]]
type = "disk"
material = "white"
emission = 4
center = [-0.99, 1, 0]
normal = [1, 0, 0]
radius = 0.3
"#,
    )
}

/// A large lamp and a ball of glass, smooth in one scene and rough in the other.
pub fn glass(roughness: f32) -> SceneDescription {
    room(&format!(
        r#"
[[material]]
name = "glass"
type = "dielectric"
roughness = {roughness}

[[shape]]
type = "sphere"
material = "glass"
center = [0.1, 0.6, 0.1]
radius = 0.5

[[shape]]
type = "rectangle"
material = "white"
emission = 4
corner = [-0.9, 1.99, -0.9]
edge_u = [1.8, 0, 0]
edge_v = [0, 0, 1.8]
"#
    ))
}

/// A constant sky, a lamp, a mirror.
pub fn outside() -> SceneDescription {
    room(&format!(
        "{LAMP}
[[material]]
name = \"mirror\"
type = \"mirror\"
reflectance = 0.9

[[shape]]
type = \"sphere\"
material = \"mirror\"
center = [0, 0.5, 0]
radius = 0.5

[[light]]
type = \"environment\"
radiance = [0.2, 0.3, 0.5]
"
    ))
}

/// A block and a mirror ball in a room with a lamp under a constant sky.
pub fn furnished() -> SceneDescription {
    let mut scene = room(&format!(
        "{LAMP}
[[material]]
name = \"mirror\"
type = \"mirror\"
reflectance = 0.9

[[shape]]
type = \"sphere\"
material = \"mirror\"
center = [0.45, 0.5, 0]
radius = 0.4

[[shape]]
type = \"box\"
material = \"white\"
min = [-0.6, 0, -0.6]
max = [-0.1, 1.1, -0.1]

[[light]]
type = \"environment\"
radiance = [0.2, 0.3, 0.5]
"
    ));
    scene.film.size = (32, 32);
    scene
}
