//! Test scenes: a room, and a floor below a lamp.
//!
//! Measure: world units; radiance.
//! Range: the room is rendered in 16 x 16 pixels with a box filter; the floor in 32 pixels that all see one point.
//! Source: none needed.

use super::scene::{diffuse, patch_scene, rectangle, surface};
use super::scene_folder::load_text;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};

/// A box that is open in front, with one red wall.
const ROOM: &str = r#"version = 1
[camera]
eye = [0, 1, 3.6]
target = [0, 1, 0]
fov = 36

[film]
size = [16, 16]
filter = "box"

[[material]]
name = "white"
type = "diffuse"
reflectance = 0.75

[[material]]
name = "red"
type = "diffuse"
reflectance = [0.6, 0.1, 0.1]

[[shape]]
type = "mesh"
material = "white"
positions = [[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1], [-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]]
indices = [[0, 3, 2], [0, 2, 1], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5]]

[[shape]]
type = "rectangle"
material = "red"
corner = [-1, 0, 1]
edge_u = [0, 0, -2]
edge_v = [0, 2, 0]
"#;

/// A lamp below its ceiling.
pub const LAMP: &str = r#"
[[shape]]
type = "rectangle"
material = "white"
emission = [9, 8, 6]
corner = [-0.4, 1.99, -0.4]
edge_u = [0.8, 0, 0]
edge_v = [0, 0, 0.8]
"#;

/// The room, with additional tables in its scene file.
pub fn room(more: &str) -> SceneDescription {
    load_text(&format!("{ROOM}{more}"))
}

/// The room with its lamp and a gold ball of the given roughness.
pub fn with_metal_ball(roughness: f64, center: [f64; 3], radius: f64) -> SceneDescription {
    room(&format!(
        r#"{LAMP}
[[material]]
name = "metal"
type = "conductor"
preset = "gold"
roughness = {roughness}

[[shape]]
type = "sphere"
material = "metal"
center = {center:?}
radius = {radius}
"#
    ))
}

/// The room with a mirror under a point light, whose reflection in it no camera path finds.
pub fn with_mirrored_point_light() -> SceneDescription {
    room(
        r#"
[[material]]
name = "mirror"
type = "mirror"

[[shape]]
type = "sphere"
material = "mirror"
center = [0.3, 0.5, 0]
radius = 0.5

[[light]]
type = "point"
position = [-0.6, 1.5, 0.2]
intensity = [2, 2, 2]
"#,
    )
}

/// A floor of albedo 0.5 below an emissive shape; the camera sees one point of the floor.
pub fn floor_below(lamp: GeometryDescription) -> SceneDescription {
    let mut scene = patch_scene(DVec3::new(0.0, 0.5, 0.8), DVec3::ZERO, diffuse(0.5));
    let ground = rectangle([-1.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.0, 0.0, -2.0]);
    scene.shapes.push(surface(ground, 0.0));
    scene.shapes.push(surface(lamp, 1.0));
    scene
}
