//! Upper estimate of the memory needed to prepare a scene, from counts before anything is built.
//!
//! Measure: bytes, at the peak, in addition to the description.
//! Range: any scene. The estimate is from one to four times the actual peak; a small scene is never refused.
//! Source: measured over all backends, precisions and qualities: a triangle takes up to 372 bytes, or 452 if it shares
//! no vertices, with obvhs and eight children per node, and 102 and 169 with Embree, without what Embree's build takes for a while.
//! Tested in `tests/scene_memory.rs`.

use super::description::{
    ColourDescription, GeometryDescription, LightModel, SceneDescription, ShapeDescription,
};
use super::placement::SceneLayout;
use crate::accel::Backend;
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::memory;

/// A triangle: its indices, and its part of the acceleration structure during the build, by obvhs and by Embree.
const TRIANGLE: u64 = 480;
const TRIANGLE_OF_EMBREE: u64 = 320;

/// A vertex: its attributes in single precision, and what Embree takes for each.
const VERTEX: u64 = 80;

/// A light: an emitting triangle or a whole emitting shape; and its position at each motion step.
const LIGHT: u64 = 600;
const MOVING_LIGHT: u64 = 64;

/// A shape, in the world or in a group.
const SHAPE: u64 = 2048;

/// A placement of a group, each of its motion steps, and each shape of the group in it.
const PLACEMENT: u64 = 1536;
const STEP: u64 = 320;
const PLACED_SHAPE: u64 = 128;

/// A texel of an environment map: its entries in the sampling distribution and in the compensated one.
const TEXEL: u64 = 20;

/// Checks that there is enough memory to prepare a scene.
///
/// # Errors
/// If there is not.
pub fn check(description: &SceneDescription, layout: &SceneLayout, backend: Backend) -> Result<()> {
    let bytes = of_scene(description, layout, backend);
    memory::check(bytes, || "the scene".to_owned())
}

/// Returns the estimate for a mesh that does not emit, with the backend that takes the most.
pub fn mesh_build_memory(vertices: usize, triangles: usize) -> u64 {
    of_mesh(vertices, triangles, TRIANGLE)
}

fn of_mesh(vertices: usize, triangles: usize, of_triangle: u64) -> u64 {
    let [vertices, triangles] = [(vertices, VERTEX), (triangles, of_triangle)]
        .map(|(count, each)| (count as u64).saturating_mul(each));
    SHAPE.saturating_add(vertices).saturating_add(triangles)
}

/// Returns the estimate for a whole scene.
pub fn of_scene(description: &SceneDescription, layout: &SceneLayout, backend: Backend) -> u64 {
    let of_triangle = match backend.is_embree() {
        true => TRIANGLE_OF_EMBREE,
        false => TRIANGLE,
    };
    let shapes_of = |indices: &[usize]| {
        let shapes = indices.iter().map(|&index| &description.shapes[index]);
        shapes.fold(Sum::default(), |sum, shape| Sum {
            shapes: sum.shapes + 1,
            made: sum.made.saturating_add(of_shape(shape, of_triangle)),
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

/// Totals over the shapes of the world or of a group.
#[derive(Default)]
struct Sum {
    shapes: u64,
    /// Memory of the shapes, independent of the number of placements.
    made: u64,
    /// Number of lights per placement.
    lights: u64,
}

fn of_shape(shape: &ShapeDescription, of_triangle: u64) -> u64 {
    match &shape.geometry {
        GeometryDescription::Mesh(mesh) => {
            of_mesh(mesh.positions.len(), mesh.indices.len(), of_triangle)
        }
        GeometryDescription::Box { .. } => of_mesh(24, 12, of_triangle),
        GeometryDescription::Rectangle { .. } => of_mesh(4, 2, of_triangle),
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
            Texture::Image { image, .. } | Texture::Placed { image, .. } => {
                image.texel_count() as u64
            }
            Texture::Checker { .. } => 0,
        },
        _ => 0,
    });
    TEXEL * texels.sum::<u64>()
}
