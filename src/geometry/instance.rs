//! Instances: groups of shapes placed in the world, static or moving while the shutter is open.
//!
//! Measure: transforms from the group's units to normalised scene units; time runs from 0, when the shutter opens, to
//! 1.
//! Range: at least one transform; at every time the transform is invertible in single precision, see
//! [`Instance::is_invertible`].
//! Source: Embree's motion blur: the entries of the matrix are interpolated; Farouki 2012, "The Bernstein polynomial basis",
//! for bounds of the determinant. Tested below and in `tests/tracing/instance_rays.rs`.

use crate::math::bounds::Bounds;
use crate::math::robust::gamma;
use crate::math::vec::{DAffine3, DMat3, DVec3};

/// A group of shapes, placed in the world.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The index of the group.
    pub group: usize,
    /// The group-to-world transforms at equally spaced times from 0 to 1; a single one for a static instance. Between
    /// two steps every entry of the matrix is interpolated linearly, so that every point moves in a straight line. The
    /// entries are representable in single precision.
    pub steps: Vec<DAffine3>,
}

impl Instance {
    /// The group-to-world transform at a time.
    ///
    /// # Panics
    /// If there are no steps.
    #[inline]
    pub fn at(&self, time: f32) -> DAffine3 {
        if let [still] = self.steps[..] {
            return still;
        }
        let (from, to, share) = self.between(time);
        // With equal steps the transform is exact.
        let lerp = |a: DVec3, b: DVec3| a + share * (b - a);
        DAffine3 {
            matrix3: columns(|k| lerp(from.matrix3.col(k), to.matrix3.col(k))),
            translation: lerp(from.translation, to.translation),
        }
    }

    /// The entrywise maximum of the magnitudes of the two steps that the transform at a time interpolates. The rounding
    /// error of the interpolation is proportional to it.
    #[inline]
    pub fn magnitude_at(&self, time: f32) -> DAffine3 {
        let abs = |m: &DAffine3| DAffine3 {
            matrix3: m.matrix3.abs(),
            translation: m.translation.abs(),
        };
        if let [still] = &self.steps[..] {
            return abs(still);
        }
        let (from, to, _) = self.between(time);
        let (from, to) = (abs(from), abs(to));
        DAffine3 {
            matrix3: columns(|k| from.matrix3.col(k).max(to.matrix3.col(k))),
            translation: from.translation.max(to.translation),
        }
    }

    /// Whether the transform can be inverted in single precision at every time. Embree inverts it for each ray, and
    /// crashes on the NaN that a singular transform yields. For example, half a turn between two steps collapses all
    /// points to the axis midway.
    pub fn is_invertible(&self) -> bool {
        let pairs = self.steps.windows(2).map(|pair| (&pair[0], &pair[1]));
        let single = self.steps.iter().map(|step| (step, step));
        let finite = self.steps.iter().all(|step| step.is_finite());
        finite
            && single.chain(pairs).all(|(a, b)| {
                let coefficients = determinant_coefficients(&a.matrix3, &b.matrix3);
                let side = coefficients[0].0.signum();
                // A lower bound of the determinant after rounding errors, reduced by the smallest divisor of single
                // precision.
                let lowest = |(determinant, size): (f64, f64)| {
                    side * determinant - f64::from(gamma(8)) * size - f64::from(f32::MIN_POSITIVE)
                };
                let fits = coefficients
                    .iter()
                    .all(|&(_, size)| size < f64::from(f32::MAX));
                fits && is_positive(coefficients.map(lowest), 32)
            })
    }

    /// The bounding box, over the whole motion, of the contents of `bounds` in the group: between two steps points move
    /// in straight lines and stay in the bounding box of both ends.
    pub fn bounds_of(&self, bounds: &Bounds) -> Bounds {
        if bounds.is_empty() {
            return Bounds::default();
        }
        let corners = (0..8).map(|i| {
            let at_max = |axis: u32| i >> axis & 1 == 1;
            DVec3::select(
                glam::BVec3::new(at_max(0), at_max(1), at_max(2)),
                bounds.max,
                bounds.min,
            )
        });
        let placed =
            corners.flat_map(|corner| self.steps.iter().map(move |m| m.transform_point3(corner)));
        Bounds::around(placed)
    }

    /// The steps before and after a time, and the interpolation weight of the second. Computed in single precision as
    /// in Embree: with many steps, a rounding error of the time outweighs one of the transform.
    #[inline]
    fn between(&self, time: f32) -> (&DAffine3, &DAffine3, f64) {
        let segments = self.steps.len() - 1;
        let scaled = time * segments as f32;
        let segment = scaled.floor().clamp(0.0, (segments - 1) as f32);
        let before = segment as usize;
        (
            &self.steps[before],
            &self.steps[before + 1],
            f64::from(scaled - segment),
        )
    }
}

/// The determinant of (1 - f) A + f B as a cubic in Bernstein form, and the same sum of products with all signs
/// positive.
fn determinant_coefficients(a: &DMat3, b: &DMat3) -> [(f64, f64); 4] {
    let mut coefficients = [(0.0, 0.0); 4];
    for subset in 0..8_usize {
        let mixed = columns(|k| [a, b][subset >> k & 1].col(k));
        let count = subset.count_ones() as usize;
        let binomial = [1.0, 3.0, 3.0, 1.0][count];
        coefficients[count].0 += mixed.determinant() / binomial;
        coefficients[count].1 += permanent(&mixed.abs()) / binomial;
    }
    coefficients
}

/// The permanent of a matrix, that is, the determinant with sums in place of differences.
fn permanent(m: &DMat3) -> f64 {
    let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis];
    a.x * (b.y * c.z + b.z * c.y) + a.y * (b.z * c.x + b.x * c.z) + a.z * (b.x * c.y + b.y * c.x)
}

/// Whether a cubic in Bernstein form is positive on [0, 1], by subdivision until the signs of its coefficients decide.
/// A cubic too close to 0 for `depth` subdivisions to decide counts as not positive.
fn is_positive([a, b, c, d]: [f64; 4], depth: u32) -> bool {
    if !(a > 0.0 && d > 0.0) {
        return false;
    }
    if b > 0.0 && c > 0.0 {
        return true;
    }
    let mean = |x: f64, y: f64| 0.5 * (x + y);
    let (ab, bc, cd) = (mean(a, b), mean(b, c), mean(c, d));
    let (abc, bcd) = (mean(ab, bc), mean(bc, cd));
    let middle = mean(abc, bcd);
    depth > 0
        && is_positive([a, ab, abc, middle], depth - 1)
        && is_positive([middle, bcd, cd, d], depth - 1)
}

#[inline]
fn columns(column: impl Fn(usize) -> DVec3) -> DMat3 {
    DMat3::from_cols(column(0), column(1), column(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk() -> Instance {
        let stops = [
            DVec3::ZERO,
            DVec3::new(4.0, 0.0, 0.0),
            DVec3::new(4.0, 8.0, 0.0),
        ];
        Instance {
            group: 0,
            steps: stops.map(DAffine3::from_translation).to_vec(),
        }
    }

    #[test]
    fn motion_interpolates_linearly_between_steps() {
        let at = |time| walk().at(time).translation;
        assert_eq!(at(0.0), DVec3::ZERO);
        assert_eq!(at(0.25), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(at(0.5), DVec3::new(4.0, 0.0, 0.0));
        assert_eq!(at(0.875), DVec3::new(4.0, 6.0, 0.0));
        assert_eq!(at(1.0), DVec3::new(4.0, 8.0, 0.0));
    }

    #[test]
    fn motion_bounds_enclose_every_step() {
        let unit = Bounds::around([DVec3::ZERO, DVec3::ONE]);
        let swept = walk().bounds_of(&unit);
        assert_eq!(swept.min, DVec3::ZERO);
        assert_eq!(swept.max, DVec3::new(5.0, 9.0, 1.0));
        assert!(walk().bounds_of(&Bounds::default()).is_empty());
    }

    #[test]
    fn motion_is_not_invertible_if_singular_at_any_time() {
        let is_invertible = |steps: &[DAffine3]| {
            let steps = steps.to_vec();
            Instance { group: 0, steps }.is_invertible()
        };
        let turned = |degrees: f64| DAffine3::from_rotation_y(degrees.to_radians());
        let scaled = |y: f64| DAffine3::from_scale(DVec3::new(1.0, y, 1.0));
        assert!(is_invertible(&[turned(0.0), turned(170.0)]));
        assert!(!is_invertible(&[turned(0.0), turned(180.0)]));
        assert!(is_invertible(&[turned(0.0), turned(90.0), turned(180.0)]));
        assert!(is_invertible(&[scaled(-1.0)]));
        assert!(!is_invertible(&[scaled(-1.0), scaled(1.0)]));
        assert!(!is_invertible(&[scaled(0.0)]));
        assert!(!is_invertible(&[DAffine3::from_scale(DVec3::splat(1e-13))]));
        assert!(!is_invertible(&[DAffine3::from_scale(DVec3::splat(1e13))]));
        assert!(!is_invertible(&[scaled(f64::NAN)]));
    }
}
