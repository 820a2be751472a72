//! An axis-aligned box in double precision, for scene loading.
//!
//! Measure: the units of the points added.
//! Range: empty until the first point; an empty box has no centre and no extent.
//! Source: none needed. Tested below.

use super::vec::{DAffine3, DVec3};

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lowest corner; above `max` while empty.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            min: DVec3::INFINITY,
            max: DVec3::NEG_INFINITY,
        }
    }
}

impl Bounds {
    /// The box around all points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::default(), Self::with)
    }

    /// The box extended to contain `p`.
    pub fn with(self, p: DVec3) -> Self {
        Self {
            min: self.min.min(p),
            max: self.max.max(p),
        }
    }

    /// The box around both boxes.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The box around the corners of the transformed box; empty if the box is.
    pub fn transformed(&self, transform: &DAffine3) -> Self {
        if self.is_empty() {
            return *self;
        }
        Self::around((0..8).map(|corner| {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 0 {
                    self.min[axis]
                } else {
                    self.max[axis]
                }
            };
            transform.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
        }))
    }

    /// Whether the box is empty: no point has been added.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether all coordinates of the box are at most `reach` from 0. A NaN is not; an empty box is.
    pub fn is_within(&self, reach: f64) -> bool {
        let within = |p: DVec3| p.abs().cmple(DVec3::splat(reach)).all();
        *self == Self::default() || (within(self.min) && within(self.max))
    }

    /// The middle, for a box that is not empty.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// The lengths of the sides, for a box that is not empty.
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_start_empty_and_enclose_the_given_points() {
        assert!(Bounds::default().is_empty());
        let bounds = Bounds::around([DVec3::ZERO, DVec3::new(2.0, 4.0, 6.0)]);
        assert!(!bounds.is_empty());
        assert_eq!(bounds.centre(), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(bounds.extent(), DVec3::new(2.0, 4.0, 6.0));
    }

    #[test]
    fn transformed_bounds_enclose_all_corners_and_stay_empty() {
        let moved = DAffine3::from_translation(DVec3::X) * DAffine3::from_scale(-DVec3::ONE);
        let bounds = Bounds::around([DVec3::ZERO, DVec3::new(2.0, 4.0, 6.0)]);
        let expected = [DVec3::new(-1.0, -4.0, -6.0), DVec3::X];
        assert_eq!(bounds.transformed(&moved), Bounds::around(expected));
        assert!(Bounds::default().transformed(&moved).is_empty());
    }
}
