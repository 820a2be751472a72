//! Prefiltering of the guides: with depth of field or motion, first-hit features are as noisy as the light from them,
//! and noisy through the same samples. Weights from such guides would depend on the noise that they are to average.
//!
//! Albedo, normal and the reciprocal of the distance are each filtered by non-local means as colours are, but without
//! halves, which guides do not have.
//!
//! Measure: as in `guides.rs`.
//! Range: guides without noise stay as they are.
//! Source: Rousselle, Manzi and Zwicker 2013, section 4.2. Tested in `tests/rendering/denoise.rs`.

use super::guides::FirstHitLayers;
use super::means::{ComparisonParameters, Halves, means};
use crate::math::plane::Plane;

/// The radius of the search window, in pixels.
const REACH: usize = 4;

/// The radius of patches, in pixels.
const PATCH: usize = 1;

/// The strictness: guides are piecewise smooth, so patches have no weight where noise is less than half of their
/// squared distance.
const STRICTNESS: f32 = 4.0;

/// The guides with reduced noise, and the standard errors of the remaining noise.
pub fn prefiltered(layers: &FirstHitLayers) -> FirstHitLayers {
    let [of_albedo, of_normal, of_distance] = &layers.errors;
    let (albedo, albedo_error) = cleaned(&layers.albedo, of_albedo, 1.0);
    // The error of a normal is that of all three components together.
    let (normal, normal_error) = cleaned(&layers.normal, of_normal, 3.0);
    let distance = &layers.distance;
    let near = distance.like(|i| 1.0 / distance.values[i]);
    let near_error = near.like(|i| of_distance.values[i] * near.values[i] * near.values[i]);
    let three = [near.clone(), near.clone(), near];
    let ([near, ..], near_error) = cleaned(&three, &near_error, 1.0);
    let distance = near.like(|i| 1.0 / near.values[i]);
    let distance_error = near.like(|i| {
        // Where nothing is hit, the error remains unchanged.
        if near.values[i] > 0.0 {
            near_error.values[i] / (near.values[i] * near.values[i])
        } else {
            of_distance.values[i]
        }
    });
    FirstHitLayers {
        albedo,
        normal,
        distance,
        errors: [albedo_error, normal_error, distance_error],
    }
}

/// Filters one guide and estimates its remaining error; `error` is that of `parts` channels together.
fn cleaned(channels: &[Plane; 3], error: &Plane, parts: f32) -> ([Plane; 3], Plane) {
    let variance = error.like(|i| error.values[i] * error.values[i] / parts);
    let same = Halves {
        values: [channels.clone(), channels.clone()],
        variance: [variance.clone(), variance.clone(), variance],
    };
    let comparison = ComparisonParameters {
        reach: REACH,
        patch: PATCH,
        strictness: vec![STRICTNESS],
    };
    let mut filtered = means(&same, &[], &comparison);
    let filtered = filtered.pop().expect("one filter for one strictness");
    let [cleaned, _] = filtered.values;
    // A mean of n equal numbers, with weights of 1 / n, has an n-th of the variance.
    let left = error.like(|i| error.values[i] * filtered.own[0].values[i].sqrt());
    (cleaned, left)
}
