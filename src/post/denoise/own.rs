//! The denoiser by non-local means: a strict filter, and where they are significantly better, a lenient one or none.
//!
//! Colours are compared with textures included. Dividing them by the albedo first, to remove textures, was tried:
//! docs/accuracy.md has the numbers.
//!
//! Measure: linear radiance.
//! Range: any image.
//! Source: `means.rs`, `choice.rs`. Tested in `tests/rendering/denoise.rs`.

use super::Filtered;
use super::choice::{choose, measure, risks, whole};
use super::guides::features;
use super::means::{ComparisonParameters, Halves, Means, means};
use super::noisy::NoisyImage;
use super::prefilter::prefiltered;

/// The radius of the search window, in pixels.
const REACH: usize = 9;

/// The radius of patches, in pixels.
const PATCH: usize = 1;

/// The strictness of the strict filter: it averages patches whose distance is as likely as not between equal ones.
/// Patches that differ by an eighth more than their noise have no weight.
const STRICT: f32 = 32.0;
/// The strictness of the lenient filter: patches that differ by twice their noise have no weight.
const LENIENT: f32 = 4.0;

/// Filters an image.
pub fn filter(noisy: &NoisyImage) -> Filtered {
    let halves = Halves {
        values: noisy.halves.clone(),
        variance: noisy
            .variance
            .each_ref()
            .map(|plane| plane.like(|i| 2.0 * plane.values[i])),
    };
    let comparison = ComparisonParameters {
        reach: REACH,
        patch: PATCH,
        strictness: vec![STRICT, LENIENT],
    };
    let mut candidates = means(&halves, &features(&prefiltered(&noisy.first)), &comparison);
    let measure = measure(&whole(&candidates[0]));
    candidates.push(Means::unfiltered(&halves));
    let mixed = choose(&candidates, &noisy.halves, &measure);
    let picture = whole(&mixed);
    // The difference between the filtered halves is remaining noise.
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
