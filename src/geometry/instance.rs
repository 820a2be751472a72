//! A group of shapes placed in the world, standing still or moving while the shutter is open.
//!
//! Measure: from the group's units to normalised scene units; time goes from 0, when the shutter opens, to 1.
//! Range: at least one transform, each of which can be inverted. Between two it may collapse for an instant, at which
//! nothing is hit.
//! Source: Embree's motion blur: the entries of the matrix are interpolated. Tested below and in `tests/tracing.rs`.

use crate::math::bounds::Bounds;
use crate::math::vec::{DAffine3, DMat3, DVec3};

/// A group of shapes, placed in the world.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The group's index.
    pub group: usize,
    /// Group to world at equally spaced times from 0 to 1; a single one stands still. Between two, every entry of the
    /// matrix changes evenly, so that every point moves in a straight line. Its entries are single-precision numbers.
    pub steps: Vec<DAffine3>,
}

impl Instance {
    /// Group to world at a time.
    ///
    /// # Panics
    /// If there are no steps.
    #[inline]
    pub fn at(&self, time: f32) -> DAffine3 {
        if let [still] = self.steps[..] {
            return still;
        }
        let (from, to, share) = self.between(time);
        let lerp = |a: DVec3, b: DVec3| (1.0 - share) * a + share * b;
        DAffine3 {
            matrix3: columns(|k| lerp(from.matrix3.col(k), to.matrix3.col(k))),
            translation: lerp(from.translation, to.translation),
        }
    }

    /// The sizes of the numbers that the transform at a time is a mean of: what rounding in the mean grows with.
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

    /// The box around everything that is in `bounds` of the group, over the whole motion: between two steps points move
    /// in straight lines and stay in the box around both ends.
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

    /// The steps before and after a time, and how far it is between them. In single precision as Embree has it: with
    /// many steps, a rounding of the time is more than one of the transform.
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
    fn motion_goes_straight_from_step_to_step_and_ends_at_the_last() {
        let at = |time| walk().at(time).translation;
        assert_eq!(at(0.0), DVec3::ZERO);
        assert_eq!(at(0.25), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(at(0.5), DVec3::new(4.0, 0.0, 0.0));
        assert_eq!(at(0.875), DVec3::new(4.0, 6.0, 0.0));
        assert_eq!(at(1.0), DVec3::new(4.0, 8.0, 0.0));
    }

    #[test]
    fn the_box_of_a_motion_holds_every_stop() {
        let unit = Bounds::around([DVec3::ZERO, DVec3::ONE]);
        let swept = walk().bounds_of(&unit);
        assert_eq!(swept.min, DVec3::ZERO);
        assert_eq!(swept.max, DVec3::new(5.0, 9.0, 1.0));
        assert!(walk().bounds_of(&Bounds::default()).is_empty());
    }
}
