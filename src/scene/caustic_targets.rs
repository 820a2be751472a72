//! The caustic targets of light paths in a scene: spheres around the shapes that cast caustics.
//!
//! Metal, mirrors and glass cast caustics if they are smooth enough; a coat reflects too little. A wrong decision adds
//! noise and no bias.
//!
//! Measure: normalised units.
//! Range: any scene; an instance that moves is enclosed in all of its places.
//! Source: none needed. Tested in `tests/rendering/light_paths.rs`.

use super::description::{MaterialDescription, MaterialModel, SceneDescription};
use super::{Scene, ShapeAttributes};
use crate::geometry::texture::Texture;
use crate::geometry::world::World;
use crate::light::caustic_targets::{CausticTargets, MAX_TARGETS};
use crate::light::types::BoundingSphere;
use crate::math::bounds::Bounds;
use crate::math::rgb::Rgb;

/// The largest perceptual roughness of a surface that casts caustics.
const MAX_ROUGHNESS: f32 = 0.35;

/// The least exponent of a Phong lobe that casts caustics: about as wide as a lobe of the largest roughness.
const MIN_EXPONENT: f32 = 100.0;

/// The least share of metal or glass in a surface that casts caustics.
const MIN_SHARE: f32 = 0.3;

/// Whether a material casts caustics.
pub fn casts_caustics(material: &MaterialDescription) -> bool {
    let is_smooth = |roughness: f32| roughness <= MAX_ROUGHNESS;
    match &material.model {
        MaterialModel::Diffuse { .. } | MaterialModel::Plastic { .. } => false,
        MaterialModel::Mirror { .. } | MaterialModel::ThinDielectric { .. } => true,
        MaterialModel::Conductor { roughness, .. }
        | MaterialModel::Dielectric { roughness, .. } => is_smooth(*roughness),
        MaterialModel::Phong {
            specular, exponent, ..
        } => {
            *exponent >= MIN_EXPONENT
                && specular
                    .constant()
                    .is_none_or(|it| it.max_channel() >= MIN_SHARE)
        }
        MaterialModel::Principled {
            metallic,
            roughness,
            transmission,
            ..
        } => {
            let map = material.metallic_roughness_map.as_deref();
            let [_, rough, metal] = map.map_or(Rgb::WHITE, Texture::mean).to_array();
            is_smooth(rough * roughness) && transmission.max(metal * metallic) >= MIN_SHARE
        }
    }
}

/// Returns the caustic targets of a scene.
pub(super) fn caustic_targets(
    description: &SceneDescription,
    shapes: &[ShapeAttributes],
    world: &World,
) -> CausticTargets {
    let mut boxes = Vec::new();
    for (number, shape) in (0..).zip(shapes) {
        let described = &description.shapes[shape.described as usize];
        let geometry = world.geometry(number);
        if geometry.primitive_count() == 0
            || !casts_caustics(&description.materials[described.material])
        {
            continue;
        }
        let bounds = geometry.bounds();
        let placement = world.placement(number);
        boxes.push(placement.map_or(bounds, |instance| instance.bounds_of(&bounds)));
    }
    if boxes.len() > MAX_TARGETS {
        boxes = vec![boxes.into_iter().fold(Bounds::default(), Bounds::union)];
    }
    let sphere = |bounds: Bounds| BoundingSphere {
        center: bounds.centre().as_vec3a(),
        // Rounded up, so that rays to the corners are within.
        radius: ((0.5 * bounds.extent().length()) as f32).next_up(),
    };
    CausticTargets::new(boxes.into_iter().map(sphere).collect())
}

impl Scene {
    /// Whether light paths may pay: a shape casts caustics, and there is a light that paths can begin at.
    pub fn casts_caustics(&self) -> bool {
        !self.caustic_targets.is_empty() && !self.lights.is_empty()
    }
}
