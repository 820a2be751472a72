//! What memory a scene takes at most while it is made ready, told from counts before anything is made.
//!
//! Measure: bytes, at the peak, beside what the description holds already.
//! Range: any scene. What is told is from once to four times what is taken; a small scene is never refused.
//! Source: measured over all backends, precisions and qualities: a triangle takes up to 372 bytes, 484 with vertices of its own,
//! of obvhs with eight children a node, and 187 and 200 of Embree. Tested in `tests/scene_memory.rs`.

use super::description::{
    ColourDescription, GeometryDescription, LightModel, SceneDescription, ShapeDescription,
};
use super::placement::Layout;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::memory;

/// A triangle: its box, its copy in single precision, and its share of the structure while that is built.
const TRIANGLE: u64 = 480;

/// A vertex: its copy in single precision.
const VERTEX: u64 = 48;

/// A light: a triangle of a shape that emits, or the whole shape; and where it is at each step of its motion.
const LIGHT: u64 = 600;
const MOVING_LIGHT: u64 = 64;

/// A shape, in the world or in a group.
const SHAPE: u64 = 2048;

/// A placement of a group, each of its steps, and each shape of the group once more.
const PLACEMENT: u64 = 1536;
const STEP: u64 = 320;
const PLACED_SHAPE: u64 = 128;

/// A texel of a panorama: how likely light comes from there.
const TEXEL: u64 = 12;

/// Makes sure that there is memory to make a scene ready.
///
/// # Errors
/// If there is not.
pub fn check(description: &SceneDescription, layout: &Layout) -> Result<()> {
    memory::check(of_scene(description, layout), || "the scene".to_owned())
}

/// A mesh that does not emit.
pub fn of_mesh(vertices: usize, triangles: usize) -> u64 {
    let [vertices, triangles] = [(vertices, VERTEX), (triangles, TRIANGLE)]
        .map(|(count, each)| (count as u64).saturating_mul(each));
    SHAPE.saturating_add(vertices).saturating_add(triangles)
}

/// A whole scene.
pub fn of_scene(description: &SceneDescription, layout: &Layout) -> u64 {
    let shapes_of = |indices: &[usize]| {
        let shapes = indices.iter().map(|&index| &description.shapes[index]);
        shapes.fold(Sum::default(), |sum, shape| Sum {
            shapes: sum.shapes + 1,
            made: sum.made.saturating_add(of_shape(shape)),
            lights: sum.lights.saturating_add(lights_of(shape)),
        })
    };
    let world = shapes_of(&layout.shapes);
    let groups: Vec<Sum> = layout.groups.iter().map(|it| shapes_of(it)).collect();
    let placements = layout.placements.iter().map(|placement| {
        let group = &groups[placement.group];
        let steps = placement.steps.len() as u64;
        let scene_lights = group.lights.saturating_mul(LIGHT + MOVING_LIGHT * steps);
        (PLACEMENT + STEP * steps + PLACED_SHAPE * group.shapes).saturating_add(scene_lights)
    });
    let scene_lights = world.lights.saturating_mul(LIGHT);
    let made = [world.made, scene_lights, of_panoramas(description)];
    let groups = groups.iter().map(|group| group.made);
    let parts = made.into_iter().chain(groups).chain(placements);
    parts.fold(0, u64::saturating_add)
}

/// Shapes that stand together.
#[derive(Default)]
struct Sum {
    shapes: u64,
    /// What they take once, however often they are placed.
    made: u64,
    /// The lights that they are wherever they are placed.
    lights: u64,
}

fn of_shape(shape: &ShapeDescription) -> u64 {
    match &shape.geometry {
        GeometryDescription::Mesh(mesh) => of_mesh(mesh.positions.len(), mesh.indices.len()),
        GeometryDescription::Box { .. } => of_mesh(24, 12),
        GeometryDescription::Rectangle { .. } => of_mesh(4, 2),
        GeometryDescription::Sphere { .. } | GeometryDescription::Disk { .. } => SHAPE,
    }
}

fn lights_of(shape: &ShapeDescription) -> u64 {
    let emits = shape.emission.as_ref().is_some_and(|it| !it.is_black());
    match &shape.geometry {
        _ if !emits => 0,
        GeometryDescription::Mesh(mesh) => mesh.indices.len() as u64,
        GeometryDescription::Box { .. } => 12,
        GeometryDescription::Rectangle { .. } => 2,
        GeometryDescription::Sphere { .. } | GeometryDescription::Disk { .. } => 1,
    }
}

fn of_panoramas(description: &SceneDescription) -> u64 {
    let texels = description.lights.iter().map(|light| match &light.model {
        LightModel::Environment {
            radiance: ColourDescription::Texture(texture),
            ..
        } => match texture.as_ref() {
            Texture::Image { image, .. } => image.pixels().len() as u64,
            Texture::Checker { .. } => 0,
        },
        _ => 0,
    });
    TEXEL * texels.sum::<u64>()
}
