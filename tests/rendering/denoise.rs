//! The noise filter on images with known pixels: its bias, its reduction of noise, and its estimate of its own error.

use crate::common::TestRng;
use etendue::internals::image::{Image, Layer, LayeredImage};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::post::denoise::{Denoiser, Filtered, NoisyImage};

/// The number of batches to which the samples of a pixel are distributed; half of the batches make the half image.
const BATCHES: usize = 16;

/// An image with known pixels.
struct Truth {
    size: [usize; 2],
    pixel: fn(f32, f32) -> [f32; 3],
}

/// Draws a sample of noise with mean 0 and variance 1.
type Noise = fn(&mut TestRng) -> f32;

fn uniform(rng: &mut TestRng) -> f32 {
    12.0_f32.sqrt() * (rng.uniform() - 0.5)
}

/// One sample in a hundred is ten; the others are slightly negative, so that the mean is 0.
fn fireflies(rng: &mut TestRng) -> f32 {
    let x = if rng.uniform() < 0.01 { 1.0 } else { 0.0 };
    (x - 0.01) / (0.01_f32 * 0.99).sqrt()
}

impl Truth {
    fn pixels(&self) -> Vec<[f32; 3]> {
        let [width, height] = self.size;
        let places = (0..width * height).map(|i| (i % width, i / width));
        let pixels =
            places.map(|(x, y)| (self.pixel)(x as f32 / width as f32, y as f32 / height as f32));
        pixels.collect()
    }

    /// The image from `n` samples per pixel, whose noise is `share` times the pixel's brightness.
    fn noisy(&self, n: usize, share: f32, noise: Noise, seed: u64) -> LayeredImage {
        let mut rng = TestRng::new(seed);
        let truth = self.pixels();
        let per_batch = n / BATCHES;
        let mut planes: [Vec<f32>; 9] = Default::default();
        for pixel in &truth {
            for (c, &mu) in pixel.iter().enumerate() {
                let means: Vec<f64> = (0..BATCHES)
                    .map(|_| {
                        let noise: f32 = (0..per_batch).map(|_| noise(&mut rng)).sum();
                        f64::from(mu * (1.0 + share * noise / per_batch as f32))
                    })
                    .collect();
                let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
                let (whole, half) = (mean(&means), mean(&means[..BATCHES / 2]));
                let squares: f64 = means.iter().map(|x| (x - whole) * (x - whole)).sum();
                planes[c].push(whole as f32);
                planes[3 + c].push(half as f32);
                planes[6 + c].push((squares / (BATCHES * (BATCHES - 1)) as f64).sqrt() as f32);
            }
        }
        self.layered(planes)
    }

    /// An image with the layers of its half image, its standard errors, and the first hits of a flat white wall.
    fn layered(&self, planes: [Vec<f32>; 9]) -> LayeredImage {
        let [width, height] = self.size;
        let pixels = (0..width * height).map(|i| Rgb::from([0, 1, 2].map(|c| planes[c][i])));
        let image = Image::new(width as u32, height as u32, pixels.collect());
        let mut picture = LayeredImage::from(image);
        let names = ["half.R", "half.G", "half.B", "se.R", "se.G", "se.B"];
        for (name, samples) in names.into_iter().zip(&planes[3..]) {
            let (name, samples) = (name.to_owned(), samples.clone());
            picture.layers.push(Layer { name, samples });
        }
        for (name, value) in [
            ("albedo.R", 0.8),
            ("albedo.G", 0.8),
            ("albedo.B", 0.8),
            ("normal.X", 0.0),
            ("normal.Y", 0.0),
            ("normal.Z", 1.0),
            ("depth.Z", 4.0),
            ("se.albedo", 0.0),
            ("se.normal", 0.0),
            ("se.depth", 0.0),
        ] {
            let (name, samples) = (name.to_owned(), vec![value; width * height]);
            picture.layers.push(Layer { name, samples });
        }
        picture
    }
}

fn filtered(picture: &LayeredImage) -> Filtered {
    let noisy = NoisyImage::new(picture).expect("all layers are there");
    let filtered = Denoiser::NonLocalMeans.filter(&noisy);
    filtered.expect("this filter cannot fail")
}

/// The relative mean squared error (relMSE) over pixels and channels.
fn rel_mse(image: &Image, truth: &[[f32; 3]]) -> f64 {
    let pixels: Vec<Rgb> = truth.iter().map(|&pixel| Rgb::from(pixel)).collect();
    let reference = Image::new(image.width(), image.height(), pixels);
    etendue::internals::image::metrics::rel_mse(image, &reference).expect("the same size")
}

/// A wall with a gradient of light, the edge of a shadow, a texture, a thin line and a dim channel.
fn wall(x: f32, y: f32) -> [f32; 3] {
    let slope = 0.3 + 0.4 * x;
    let shadow = if x + 0.3 * y > 0.7 { 0.3 } else { 1.0 };
    let texture = if y > 0.6 {
        1.0 + 0.1 * (60.0 * x).sin()
    } else {
        1.0
    };
    let line = if (y - 0.3).abs() < 0.01 { 1.5 } else { 1.0 };
    let light = slope * shadow * texture * line;
    [light, 0.7 * light, 0.1 * light]
}

const WALL: Truth = Truth {
    size: [100, 72],
    pixel: wall,
};

const FLAT: Truth = Truth {
    size: [70, 66],
    pixel: |_, _| [0.3, 0.7, 1.1],
};

#[test]
fn denoising_leaves_a_constant_image_unchanged() {
    for error in [0.0, 0.25] {
        let count = FLAT.size[0] * FLAT.size[1];
        let planes = std::array::from_fn(|i| {
            let value = if i < 6 { [0.3, 0.7, 1.1][i % 3] } else { error };
            vec![value; count]
        });
        let picture = FLAT.layered(planes);
        let filtered = filtered(&picture);
        assert_eq!(filtered.image, picture.image);
        assert_eq!(filtered.error, Some(0.0));
    }
}

/// The weights from one half are independent of the noise in the other: where the truth is flat, filtered values have its
/// mean, also where rare samples carry much of it. 36 images determine the mean to 0.1 %, so that 0.7 % would be detected.
#[test]
fn denoising_preserves_the_mean_of_uniform_and_firefly_noise() {
    for noise in [uniform as Noise, fireflies] {
        let means: Vec<f64> = (0..36)
            .map(|seed| filtered(&FLAT.noisy(16, 1.0, noise, seed)).image.mean()[1] / 0.7)
            .collect();
        let moments = etendue::internals::math::stats::Moments::of(means);
        let error = moments.standard_error().expect("36 pictures");
        assert!(error < 1.5e-3, "too noisy for a conclusion: {error}");
        let z = (moments.mean() - 1.0) / error;
        assert!(
            z.abs() < 4.5,
            "mean {} at {z} standard errors",
            moments.mean()
        );
    }
}

#[test]
fn denoising_reduces_noise_and_estimates_the_error() {
    for (noise, n) in [(uniform as Noise, 16), (uniform, 256), (fireflies, 256)] {
        let truth = WALL.pixels();
        let picture = WALL.noisy(n, 1.0, noise, 3);
        let filtered = filtered(&picture);
        let (before, after) = (
            rel_mse(&picture.image, &truth),
            rel_mse(&filtered.image, &truth),
        );
        assert!(after < before / 4.0, "{n}: {before} before, {after} after");
        let ratio = filtered.error.expect("it is not black") / after.sqrt();
        assert!((0.65..1.5).contains(&ratio), "{n}: {ratio}");
        // Also for single pixels: the sum over the image of the squares of the stated errors.
        let stated: f64 = filtered
            .errors
            .pixels()
            .iter()
            .map(|it| f64::from(it.to_array()[0]).powi(2))
            .sum();
        let pairs = filtered.image.pixels().iter().zip(&truth);
        let actual: f64 = pairs
            .map(|(x, mu)| f64::from(x.to_array()[0] - mu[0]).powi(2))
            .sum();
        let ratio = (stated / actual).sqrt();
        assert!((0.65..1.6).contains(&ratio), "{n}: {ratio}");
    }
}

/// While the variance of the noise falls by a factor of 4096, the squared error falls by more than 1000, which a constant bias
/// would prevent; and it stays below that of the unfiltered image.
#[test]
fn denoising_bias_vanishes_with_the_noise() {
    let truth = WALL.pixels();
    let errors = [16, 256, 4096, 65_536].map(|n| {
        // The noise of n samples is that of 16 samples with a smaller variance.
        let share = (16.0 / n as f32).sqrt();
        let picture = WALL.noisy(16, share, uniform, 5);
        let after = rel_mse(&filtered(&picture).image, &truth);
        (rel_mse(&picture.image, &truth), after)
    });
    for (before, after) in errors {
        assert!(after <= 1.02 * before, "{errors:?}");
    }
    let [(_, first), .., (_, last)] = errors;
    assert!(last < first / 1000.0, "{errors:?}");
}

#[test]
fn denoised_image_is_independent_of_thread_count() {
    let picture = WALL.noisy(16, 1.0, fireflies, 7);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads start").install(|| filtered(&picture))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn denoising_does_not_cross_normal_discontinuities() {
    // Two walls with different normals: the noise of one does not reach the other.
    let mut picture = FLAT.noisy(16, 1.0, uniform, 9);
    let [width, height] = FLAT.size;
    let is_left = |i: usize| i % width < width / 2;
    for layer in &mut picture.layers {
        for i in 0..width * height {
            match layer.name.as_str() {
                "normal.X" if is_left(i) => layer.samples[i] = 1.0,
                "normal.Z" if is_left(i) => layer.samples[i] = 0.0,
                // The right half has no noise, and other values.
                name if !is_left(i) && name.starts_with("se.") => layer.samples[i] = 0.0,
                name if !is_left(i) && name.starts_with("half.") => layer.samples[i] = 0.5,
                _ => {}
            }
        }
    }
    for i in (0..width * height).filter(|&i| !is_left(i)) {
        picture.image.pixels_mut()[i] = Rgb::grey(0.5);
    }
    let filtered = filtered(&picture);
    for i in (0..width * height).filter(|&i| !is_left(i)) {
        assert_eq!(filtered.image.pixels()[i], Rgb::grey(0.5));
    }
}
