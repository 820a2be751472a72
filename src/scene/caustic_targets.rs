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

/// The largest perceptual roughness of a glossy surface. In suzanne-room, whose floor has 0.4, the squared error is the same as
/// if all surfaces were glossy; if only those that cast caustics are, it is larger by 17 %.
const MAX_GLOSSY_ROUGHNESS: f32 = 0.5;

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

/// Whether a material has a lobe that is so much narrower than a diffuse one that light paths may find what it throws better
/// than camera paths do.
pub fn is_glossy(material: &MaterialDescription) -> bool {
    let is_coated = material.clear_coat.is_some_and(|coat| coat.weight > 0.0);
    let is_narrow = |roughness: f32| roughness <= MAX_GLOSSY_ROUGHNESS;
    let of_base = match &material.model {
        MaterialModel::Diffuse { .. } => false,
        MaterialModel::Mirror { .. }
        | MaterialModel::ThinDielectric { .. }
        | MaterialModel::Phong { .. } => true,
        MaterialModel::Conductor { roughness, .. }
        | MaterialModel::Dielectric { roughness, .. }
        | MaterialModel::Plastic { roughness, .. } => is_narrow(*roughness),
        MaterialModel::Principled { roughness, .. } => {
            let map = material.metallic_roughness_map.as_deref();
            let [_, of_map, _] = map.map_or(Rgb::WHITE, Texture::mean).to_array();
            is_narrow(of_map * roughness)
        }
    };
    of_base || is_coated
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
    let spheres: Vec<BoundingSphere> = grouped(boxes).into_iter().map(sphere_around).collect();
    CausticTargets::new(&spheres)
}

/// The sphere around a box.
fn sphere_around(bounds: Bounds) -> BoundingSphere {
    BoundingSphere {
        center: bounds.centre().as_vec3a(),
        // Rounded up, so that rays to the corners are within.
        radius: ((0.5 * bounds.extent().length()) as f32).next_up(),
    }
}

/// Boxes around at most [`MAX_TARGETS`] groups of boxes: the largest group is divided until there are as many.
fn grouped(boxes: Vec<Bounds>) -> Vec<Bounds> {
    let around = |group: &[Bounds]| group.iter().fold(Bounds::default(), |a, &b| a.union(b));
    let mut groups = vec![boxes];
    let mut indivisible = Vec::new();
    while groups.len() + indivisible.len() < MAX_TARGETS {
        let extent = |group: &[Bounds]| around(group).extent().length();
        let by_extent = |&a: &usize, &b: &usize| extent(&groups[a]).total_cmp(&extent(&groups[b]));
        let Some(largest) = (0..groups.len()).max_by(by_extent) else {
            break;
        };
        let [before, beyond] = divided(groups.swap_remove(largest));
        if before.is_empty() || beyond.is_empty() {
            indivisible.push([before, beyond].concat());
        } else {
            groups.extend([before, beyond]);
        }
    }
    groups.extend(indivisible);
    let occupied = groups.iter().filter(|group| !group.is_empty());
    occupied.map(|group| around(group)).collect()
}

/// Divides boxes by their centres, in the middle of the longest axis of these. Boxes with the same centre stay together.
fn divided(boxes: Vec<Bounds>) -> [Vec<Bounds>; 2] {
    let mut centres = Bounds::default();
    for it in &boxes {
        centres = centres.union(Bounds {
            min: it.centre(),
            max: it.centre(),
        });
    }
    let axis = centres.extent().max_position();
    let middle = centres.centre()[axis];
    let (before, beyond) = boxes.into_iter().partition(|it| it.centre()[axis] < middle);
    [before, beyond]
}

impl Scene {
    /// Whether light paths may pay: a shape casts caustics, and there is a light that paths can begin at.
    pub fn casts_caustics(&self) -> bool {
        !self.caustic_targets.is_empty() && !self.lights.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn cube(x: f64, edge: f64) -> Bounds {
        let min = DVec3::new(x, 0.0, 0.0);
        Bounds {
            min,
            max: min + DVec3::splat(edge),
        }
    }

    #[test]
    fn few_boxes_stay_and_many_are_grouped_where_they_are_near() {
        assert!(grouped(vec![]).is_empty());
        let row = |count: u32, step: f64| (0..count).map(move |i| cube(step * f64::from(i), 0.5));
        let few: Vec<Bounds> = row(MAX_TARGETS as u32, 1.0).collect();
        assert_eq!(grouped(few).len(), MAX_TARGETS);
        let boxes: Vec<Bounds> = row(1000, 1.0).collect();
        let groups = grouped(boxes.clone());
        assert_eq!(groups.len(), MAX_TARGETS);
        let encloses = |group: &Bounds, it: &Bounds| group.union(*it) == *group;
        let is_enclosed = |it: &Bounds| groups.iter().any(|group| encloses(group, it));
        assert!(boxes.iter().all(is_enclosed));
        assert!(groups.iter().all(|group| group.extent().x < 64.0));
    }

    #[test]
    fn boxes_with_the_same_centre_stay_together() {
        assert_eq!(grouped(vec![cube(1.0, 2.0); 100]), [cube(1.0, 2.0)]);
        let two = [vec![cube(0.0, 1.0); 50], vec![cube(9.0, 1.0); 50]].concat();
        assert_eq!(grouped(two).len(), 2);
    }
}
