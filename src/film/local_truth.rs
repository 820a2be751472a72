//! A noisy picture smoothed as far as its own noise asks for: what stands for the truth in the denominator of relMSE.
//!
//! The picture is taken apart into its means over 5 x 5 pixels, what those over 3 x 3 pixels add to them, and what each pixel
//! adds to that. Of either addition the share g = max(0, 1 - noise / energy) is kept, with its mean square about the pixel as
//! the energy and the variance that noise alone would give it: Wiener's filter, in two steps. In flat regions this is a mean
//! over 25 pixels, and at edges, or where there is little noise, the pixel itself.
//!
//! Measure: that of the picture; variances of its pixels.
//! Range: any picture.
//! Source: Wiener 1949, by local statistics as in Lee 1980, "Digital Image Enhancement and Noise Filtering by Use of Local
//! Statistics". Tested below; its effect in `error.rs`.

use crate::math::plane::Plane;

/// Squares of 3 x 3 pixels, and of 5 x 5.
const RADII: [usize; 2] = [1, 2];

/// The variance that noise of variance 1 in each pixel gives to a pixel less its mean over 3 x 3 pixels, and to that mean less
/// the one over 5 x 5.
const OF_NOISE: [f32; 2] = [1.0 - 1.0 / 9.0, 1.0 / 9.0 - 1.0 / 25.0];

/// A picture with what is known of its noise.
pub struct Smoothed {
    /// The picture.
    pub picture: Plane,
    /// The mean variance of a pixel about each, over either square.
    variances: [Plane; 2],
}

impl Smoothed {
    /// A picture, and the variance of each of its pixels.
    pub fn new(picture: Plane, variance: &Plane) -> Self {
        Self {
            picture,
            variances: RADII.map(|radius| variance.box_mean(radius)),
        }
    }
}

/// A picture with this many times the noise that is known, smoothed.
pub fn local_truth(picture: &Plane, noise: &Smoothed, times: f32) -> Plane {
    let [near, far] = RADII.map(|radius| picture.box_mean(radius));
    let fine = kept(picture, &near, 0, noise, times);
    let coarse = kept(&near, &far, 1, noise, times);
    far.like(|i| far.values[i] + coarse[i] + fine[i])
}

/// Of the difference of a picture and its mean, the share that is not noise.
fn kept(picture: &Plane, mean: &Plane, step: usize, noise: &Smoothed, times: f32) -> Vec<f32> {
    let difference = picture.like(|i| picture.values[i] - mean.values[i]);
    let squares = difference.like(|i| difference.values[i] * difference.values[i]);
    let energy = squares.box_mean(RADII[step]).values;
    let of_noise = &noise.variances[step].values;
    let share = |i: usize| {
        let noise = times * OF_NOISE[step] * of_noise[i];
        // Where there is no energy, there is nothing to keep.
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

    /// A picture with normal noise of this deviation, and the smoothed one's squared error over the variance of the noise.
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
        // Of 25 equal pixels a twenty-fifth is left, were it not for the energy that is there by chance.
        let flat = left(|_| 1.0, 0.1);
        assert!(flat < 0.2, "{flat}");
        // A chessboard has nothing but edges: what is there by far is kept.
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
