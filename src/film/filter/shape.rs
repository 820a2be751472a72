//! The shapes of reconstruction filters: their names, radii and profiles.
//!
//! Measure: radii in pixels; profiles of any scale, over the distance from the centre in radii.
//! Range: radii above 0 and up to `MAX_RADIUS`; distances in [0, 1].
//! Source: named at each. Tested below.

use crate::math::functions::{cos, exp};
use serde::Serialize;
use std::f64::consts::PI;

/// A reconstruction filter: a kind and its radius in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FilterDescription {
    /// The shape.
    pub kind: FilterKind,
    /// Half the width of the support, in pixels, above 0.
    pub radius: f64,
}

/// The largest radius of a filter, in pixels.
pub const MAX_RADIUS: f64 = 32.0;

/// The shapes of reconstruction filters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub enum FilterKind {
    /// Constant.
    Box,
    /// Linear to zero.
    Tent,
    /// A Gaussian lowered to reach zero at the radius.
    Gaussian,
    /// Mitchell and Netravali with B = C = 1/3: has negative lobes.
    Mitchell,
    /// The four-term Blackman-Harris window.
    BlackmanHarris,
}

impl FilterDescription {
    /// The name of the kind and the radius, as on the command line.
    pub fn name(&self) -> String {
        let kind = FilterKind::ALL.iter().find(|(_, kind)| *kind == self.kind);
        let (name, _) = kind.expect("every kind has a name");
        format!("{name}:{}", self.radius)
    }
}

impl FilterKind {
    /// All filters with their names in scenes.
    pub const ALL: &'static [(&'static str, Self)] = &[
        ("box", Self::Box),
        ("tent", Self::Tent),
        ("gaussian", Self::Gaussian),
        ("mitchell", Self::Mitchell),
        ("blackman-harris", Self::BlackmanHarris),
    ];

    /// The default radius in pixels.
    pub fn default_radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
        }
    }
}

/// The shape of a filter at the distance `t` from its centre, in radii; t in [0, 1]. Any scale.
pub(super) fn profile(kind: FilterKind, t: f64) -> f64 {
    match kind {
        FilterKind::Box => 1.0,
        FilterKind::Tent => 1.0 - t,
        // The radius is three standard deviations.
        FilterKind::Gaussian => exp(-4.5 * t * t) - exp(-4.5),
        FilterKind::Mitchell => mitchell(2.0 * t),
        FilterKind::BlackmanHarris => blackman_harris(t),
    }
}

/// The profile of Mitchell and Netravali 1988, "Reconstruction Filters in Computer Graphics", eq. 8 with B = C = 1/3,
/// times 18; x in [0, 2]. The outer piece is factored, so that its zeros, 8/7 and 2, are exact.
fn mitchell(x: f64) -> f64 {
    if x < 1.0 {
        21.0 * x * x * x - 36.0 * x * x + 16.0
    } else {
        (x - 2.0) * (x - 2.0) * (8.0 - 7.0 * x)
    }
}

/// The minimum four-term window of Harris 1978, "On the Use of Windows for Harmonic Analysis"; t in [0, 1] from its
/// centre to its end, where it is 6e-5.
fn blackman_harris(t: f64) -> f64 {
    let angle = PI * t;
    0.35875 + 0.48829 * cos(angle) + 0.14128 * cos(2.0 * angle) + 0.01168 * cos(3.0 * angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mitchell_profile_matches_the_published_cubic() {
        let (b, c) = (1.0 / 3.0, 1.0 / 3.0);
        for x in (0..100).map(|i| (f64::from(i) + 0.5) / 50.0) {
            let published = if x < 1.0 {
                (12.0 - 9.0 * b - 6.0 * c) * x.powi(3)
                    + (-18.0 + 12.0 * b + 6.0 * c) * x.powi(2)
                    + (6.0 - 2.0 * b)
            } else {
                (-b - 6.0 * c) * x.powi(3)
                    + (6.0 * b + 30.0 * c) * x.powi(2)
                    + (-12.0 * b - 48.0 * c) * x
                    + (8.0 * b + 24.0 * c)
            };
            assert!((mitchell(x) - 3.0 * published).abs() < 1e-12);
        }
    }
}
