//! A noisy image smoothed according to its own noise: the estimate of the truth in the denominator of relMSE.
//!
//! The image is decomposed into its mean over 5 x 5 pixels, the difference from it to the mean over 3 x 3 pixels, and
//! the difference from that to the pixel. Each difference is scaled by g = max(0, 1 - noise / energy), with its mean
//! square about the pixel as the energy and the variance that noise alone would give it as the noise: a Wiener filter
//! in two steps. In flat regions the result is a mean over 25 pixels, and at edges, or where there is little noise,
//! the pixel itself.
//!
//! Measure: that of the image; variances of its pixels.
//! Range: any image.
//! Source: Wiener 1949, by local statistics as in Lee 1980, "Digital Image Enhancement and Noise Filtering by Use of Local
//! Statistics". Tested below; its effect in `error.rs`.

use crate::math::plane::Plane;

/// Radii of the squares of 3 x 3 pixels and of 5 x 5.
const RADII: [usize; 2] = [1, 2];

/// The variance of a pixel minus its mean over 3 x 3 pixels, and of that mean minus the one over 5 x 5, for noise of
/// variance 1 in each pixel.
const OF_NOISE: [f32; 2] = [1.0 - 1.0 / 9.0, 1.0 / 9.0 - 1.0 / 25.0];

/// An image and the variance of its noise.
pub struct Smoothed {
    /// The image.
    pub picture: Plane,
    /// The variance of the pixels, averaged over either square about each.
    variances: [Plane; 2],
}

impl Smoothed {
    /// Builds it from an image and the variance of each of its pixels.
    pub fn new(picture: Plane, variance: &Plane) -> Self {
        Self {
            picture,
            variances: RADII.map(|radius| variance.box_mean(radius)),
        }
    }
}

/// Smooths an image whose noise has `times` the variance of `noise`.
pub fn local_truth(picture: &Plane, noise: &Smoothed, times: f32) -> Plane {
    let [near, far] = RADII.map(|radius| picture.box_mean(radius));
    let fine = kept(picture, &near, 0, noise, times);
    let coarse = kept(&near, &far, 1, noise, times);
    far.like(|i| far.values[i] + coarse[i] + fine[i])
}

/// The difference between an image and its mean, scaled by the share that is not noise.
fn kept(picture: &Plane, mean: &Plane, step: usize, noise: &Smoothed, times: f32) -> Vec<f32> {
    let difference = picture.like(|i| picture.values[i] - mean.values[i]);
    let squares = difference.like(|i| difference.values[i] * difference.values[i]);
    let energy = squares.box_mean(RADII[step]).values;
    let of_noise = &noise.variances[step].values;
    let share = |i: usize| {
        let noise = times * OF_NOISE[step] * of_noise[i];
        // Without energy, nothing is kept.
        (1.0 - noise / energy[i].max(f32::MIN_POSITIVE)).max(0.0)
    };
    let kept = difference.values.iter().enumerate();
    kept.map(|(i, x)| share(i) * x).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    const SIDE: usize = 64;

    /// The squared error of a smoothed image with normal noise of this standard deviation, over the variance of the
    /// noise.
    fn left(truth: impl Fn(usize) -> f32, deviation: f32) -> f32 {
        let mut rng = Pcg32::new(5, 7);
        let mut uniform = || rng.next_u32() as f32 / 4_294_967_296.0;
        let mut normal = || (0..12).map(|_| uniform()).sum::<f32>() - 6.0;
        let exact = Plane::filled(SIDE, SIDE, 0.0).like(truth);
        let values = exact.values.iter().map(|x| x + deviation * normal());
        let picture = Plane::new(SIDE, SIDE, values.collect());
        let variance = picture.like(|_| deviation * deviation);
        let smoothed = Smoothed::new(picture.clone(), &variance);
        let told = local_truth(&picture, &smoothed, 1.0);
        let squares = told.values.iter().zip(&exact.values);
        let mean = squares.map(|(a, b)| (a - b) * (a - b)).sum::<f32>() / (SIDE * SIDE) as f32;
        mean / (deviation * deviation)
    }

    #[test]
    fn flat_regions_are_averaged_and_edges_kept() {
        // A mean of 25 equal pixels would leave a twenty-fifth; the energy of the noise itself leaves more.
        let flat = left(|_| 1.0, 0.1);
        assert!(flat < 0.2, "{flat}");
        // A chessboard consists of edges far above the noise, which are kept.
        let board = left(|i| ((i % SIDE + i / SIDE) % 2) as f32, 0.01);
        assert!((0.9..1.1).contains(&board), "{board}");
        // One border between dark and bright.
        let border = left(|i| if i % SIDE < SIDE / 2 { 0.1 } else { 10.0 }, 0.1);
        assert!(border < 0.3, "{border}");
    }

    #[test]
    fn a_picture_without_noise_stays_as_it_is() {
        let picture = Plane::filled(9, 7, 0.0).like(|i| (i * i % 13) as f32);
        let smoothed = Smoothed::new(picture.clone(), &picture.like(|_| 0.0));
        let told = local_truth(&picture, &smoothed, 1.0);
        for (a, b) in told.values.iter().zip(&picture.values) {
            assert!((a - b).abs() < 1e-5);
        }
    }
}
