//! The filter by non-local means: a strict one, and where they are better beyond doubt, a lenient one or none.
//!
//! Colours are compared as they are, textures included. Dividing them by the albedo first, so that a texture does not
//! stand in the way, was tried: docs/accuracy.md has the numbers.
//!
//! Measure: linear radiance.
//! Range: any picture.
//! Source: `means.rs`, `choice.rs`. Tested in `tests/rendering/denoise.rs`.

use super::Filtered;
use super::choice::{choose, measure, risks, whole};
use super::guides::features;
use super::means::{Comparison, Halves, Means, means};
use super::noisy::Noisy;
use super::prefilter::prefiltered;

/// How far away pixels are that are averaged.
const REACH: usize = 9;

/// The radius of patches.
const PATCH: usize = 1;

/// Strictly, patches are alike whose distance is as likely as not between equal ones: those that differ by an eighth more
/// than their noise have no weight.
const STRICT: f32 = 32.0;
/// Leniently, those that differ by as much again as their noise have none.
const LENIENT: f32 = 4.0;

/// Filters a picture.
pub fn filter(noisy: &Noisy) -> Filtered {
    let halves = Halves {
        values: noisy.halves.clone(),
        variance: noisy
            .variance
            .each_ref()
            .map(|plane| plane.like(|i| 2.0 * plane.values[i])),
    };
    let comparison = Comparison {
        reach: REACH,
        patch: PATCH,
        strictness: vec![STRICT, LENIENT],
    };
    let mut candidates = means(&halves, &features(&prefiltered(&noisy.first)), &comparison);
    let measure = measure(&whole(&candidates[0]));
    candidates.push(Means::unfiltered(&halves));
    let mixed = choose(&candidates, &noisy.halves, &measure);
    let picture = whole(&mixed);
    // What the halves differ by is noise that is left.
    let [a, b] = &mixed.values;
    let floor = [0, 1, 2].map(|c| {
        a[c].like(|i| {
            let d = 0.5 * (a[c].values[i] - b[c].values[i]);
            d * d
        })
    });
    let risks = risks(&mixed, &noisy.halves);
    Filtered::assessed(&picture, &risks, &floor, noisy)
}
