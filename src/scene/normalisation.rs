//! Normalisation from world units: recentring, and scaling by a power of two.
//!
//! Centre and unit are medians over the primitives, where the detail is, and not those of the scene's bounding box,
//! which a single distant lamp would shift. Single precision thus keeps its accuracy near the detail, and a scene that
//! is moved far from the origin, or scaled by a power of two, is rendered with the same numbers.
//!
//! Measure: world units in, normalised units out.
//! Range: any finite scene; the identity without primitives.
//! Source: docs/accuracy.md, "Precision by construction". Tested below and in `tests/rendering/determinism.rs`.

use super::medians::{PrimitiveBoxes, medians};
use crate::math::bounds::Bounds;
use crate::math::vec::{DAffine3, DVec3, Vec3};
use crate::planted::planted;

/// The map from world to normalised units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normalisation {
    centre: DVec3,
    /// A power of two.
    scale: f64,
}

impl Normalisation {
    /// Computes the map for primitives with these boxes, in world units, and returns also the box around all, which is empty
    /// without primitives.
    pub fn of(boxes: &impl PrimitiveBoxes) -> (Self, Bounds) {
        let centre = medians(boxes, |b| b.centre().to_array());
        let (centre, whole) = centre.unwrap_or_default();
        let centre = DVec3::from_array(centre);
        let reach = |b: &Bounds| {
            let farthest = (b.max - centre).abs().max((b.min - centre).abs());
            [farthest.max_element()]
        };
        let reach = medians(boxes, reach);
        let unit = reach.map_or(1.0, |([reach], _)| power_of_two_above(reach));
        let scale = 1.0 / unit;
        (Self { centre, scale }, whole)
    }

    /// Maps a point, rounding to single precision last.
    pub fn point(&self, p: DVec3) -> Vec3 {
        let exact = planted!("rounded-before-centred", p.as_vec3a().as_dvec3(), p);
        ((exact - self.centre) * self.scale).as_vec3a()
    }

    /// Maps a length.
    pub fn length(&self, length: f64) -> f32 {
        (length * self.scale) as f32
    }

    /// Maps an area, or a quantity proportional to area.
    pub fn area(&self, area: f64) -> f64 {
        area * self.scale * self.scale
    }

    /// Returns the map as an affine transform.
    pub fn to_affine(&self) -> DAffine3 {
        DAffine3::from_scale(DVec3::splat(self.scale)) * DAffine3::from_translation(-self.centre)
    }

    /// Maps a normalised point back to world units.
    pub fn world_point(&self, p: Vec3) -> DVec3 {
        p.as_dvec3() / self.scale + self.centre
    }

    /// Maps a normalised length back to world units.
    pub fn world_length(&self, length: f32) -> f64 {
        f64::from(length) / self.scale
    }
}

/// Returns the smallest normal power of two above `x`; 1 if `x` is not positive, finite and normal. Exact, so that
/// scaling the scene by a power of two scales the unit by the same factor.
fn power_of_two_above(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    let exponent = x.to_bits() & EXPONENT;
    if !(x > 0.0 && x.is_finite()) || exponent == 0 {
        return 1.0;
    }
    f64::from_bits(exponent) * 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(scale: f64, offset: f64) -> Vec<Bounds> {
        (0..9)
            .map(|i| {
                let at = DVec3::new(f64::from(i), 1.0, -2.5) * scale + DVec3::splat(offset);
                Bounds {
                    min: at,
                    max: at + DVec3::splat(scale),
                }
            })
            .collect()
    }

    #[test]
    fn normalised_points_are_invariant_to_power_of_two_scaling() {
        let p = DVec3::new(0.3, -7.0, 1e-3);
        let reference = Normalisation::of(&scene(1.0, 0.0)).0.point(p);
        for k in -40..=40 {
            let scale = 2.0_f64.powi(k);
            assert_eq!(
                Normalisation::of(&scene(scale, 0.0)).0.point(p * scale),
                reference
            );
        }
    }

    #[test]
    fn scene_far_from_the_origin_keeps_its_precision() {
        let p = DVec3::new(0.25, -7.0, 0.5);
        let near = Normalisation::of(&scene(1.0, 0.0)).0.point(p);
        let far = Normalisation::of(&scene(1.0, 1e7))
            .0
            .point(p + DVec3::splat(1e7));
        assert!((near - far).abs().max_element() < 1e-7);
    }

    #[test]
    fn distant_outlier_does_not_change_the_normalisation() {
        let mut boxes = scene(1.0, 0.0);
        let before = Normalisation::of(&boxes).0;
        boxes.push(Bounds {
            min: DVec3::splat(1e10),
            max: DVec3::splat(2e10),
        });
        assert_eq!(Normalisation::of(&boxes).0, before);
        let p = before.point(DVec3::ONE);
        assert!((before.world_point(p) - DVec3::ONE).length() < 1e-6);
    }
}
