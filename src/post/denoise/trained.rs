//! The denoiser by Open Image Denoise, and an estimate of its error.
//!
//! The error of a network cannot be estimated from its own output. But of the halves A and B, F(A) is independent of
//! B: of
//!
//!   (F(A) - B)^2 + (F(B) - A)^2 - (A - B)^2
//!
//! the expectation is the sum of the squared errors of F(A) and F(B). Half of it is reported. The image of both
//! halves has less noise, so its error is likely to be smaller.
//!
//! Measure: linear radiance.
//! Range: any image; the time is that of filtering three images.
//! Source: cross-validation, as by Stone 1974. Tested in `cli/tests/command/denoise_oidn.rs`.

use super::Filtered;
use super::noisy::NoisyImage;
use crate::error::Result;
use crate::math::plane::Plane;
use crate::post::oidn;

/// Filters an image and its halves.
pub fn filter(noisy: &NoisyImage) -> Result<Filtered> {
    let (picture, halves) = (&noisy.picture, &noisy.halves);
    let [first, second] = halves;
    let mut colours = [picture, first, second].map(interleaved);
    oidn::filter(oidn::OidnImages {
        size: noisy.size(),
        colours: &mut colours,
        albedo: interleaved(&noisy.first.albedo),
        normal: interleaved(&noisy.first.normal),
    })?;
    let [filtered, f_a, f_b] = colours;
    let channels = |pixels: &[[f32; 3]]| [0, 1, 2].map(|c| picture[c].like(|i| pixels[i][c]));
    let risks = [0, 1, 2].map(|c| {
        picture[c].like(|i| {
            let [a, b] = [first, second].map(|half| half[c].values[i]);
            let square = |x: f32| x * x;
            0.5 * (square(f_a[i][c] - b) + square(f_b[i][c] - a) - square(a - b))
        })
    });
    let floor = picture.each_ref().map(|plane| plane.like(|_| 0.0));
    let filtered = channels(&filtered);
    Ok(Filtered::assessed(&filtered, &risks, &floor, noisy))
}

fn interleaved(channels: &[Plane; 3]) -> Vec<[f32; 3]> {
    let pixels = 0..channels[0].values.len();
    pixels
        .map(|i| channels.each_ref().map(|channel| channel.values[i]))
        .collect()
}
