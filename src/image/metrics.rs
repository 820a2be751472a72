//! How far a picture is from a reference.
//!
//! Measure: `mse` in squared units of the pixels, `rel_mse` without unit; both are means over pixels and channels.
//! Range: pictures of the same size, another one is an error of usage. The relative error is 0 for equal pictures and
//! infinite where a reference that is black everywhere is missed.
//! Source: relMSE as in docs/accuracy.md, with an epsilon that follows the exposure. Tested below.

use super::Image;
use crate::error::{Error, Result};

/// The mean of (x - r)^2.
pub fn mse(image: &Image, reference: &Image) -> Result<f64> {
    mean_over_channels(image, reference, |x, r| (x - r) * (x - r))
}

/// The mean of (x - r)^2 / (r^2 + eps) with eps = 0.01 mean(r)^2, so that it does not depend on the exposure.
pub fn rel_mse(image: &Image, reference: &Image) -> Result<f64> {
    let mean = reference.mean().iter().sum::<f64>() / 3.0;
    let epsilon = 0.01 * mean * mean;
    mean_over_channels(image, reference, |x, r| {
        let squared = (x - r) * (x - r);
        // Before 0 / 0.
        if squared == 0.0 {
            0.0
        } else {
            squared / (r * r + epsilon)
        }
    })
}

fn mean_over_channels(
    image: &Image,
    reference: &Image,
    error: impl Fn(f64, f64) -> f64,
) -> Result<f64> {
    let size = |image: &Image| (image.width(), image.height());
    if size(image) != size(reference) {
        return Err(Error::usage(format!(
            "cannot compare pictures of different sizes: {} x {} and {} x {} pixels",
            image.width(),
            image.height(),
            reference.width(),
            reference.height()
        )));
    }
    let sum: f64 = image
        .pixels()
        .iter()
        .zip(reference.pixels())
        .flat_map(|(x, r)| x.to_array().into_iter().zip(r.to_array()))
        .map(|(x, r)| error(x.into(), r.into()))
        .sum();
    Ok(sum / (3 * image.pixels().len()) as f64)
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample_image;
    use super::*;
    use crate::ErrorKind;
    use crate::math::rgb::Rgb;

    #[test]
    fn a_constant_error_has_its_closed_form() {
        let reference = Image::filled(3, 2, Rgb::grey(2.0));
        let image = Image::filled(3, 2, Rgb::grey(2.5));
        assert_eq!(mse(&image, &reference).expect("same size"), 0.25);
        let relative = rel_mse(&image, &reference).expect("same size");
        assert!((relative - 0.25 / (4.0 + 0.04)).abs() < 1e-12);
    }

    #[test]
    fn the_relative_error_does_not_depend_on_the_exposure() {
        let brighter = |image: &Image, gain: f32| {
            let pixels = image.pixels().iter().map(|&pixel| gain * pixel).collect();
            Image::new(image.width(), image.height(), pixels)
        };
        let reference = sample_image();
        let mut image = reference.clone();
        image.pixels_mut()[40] = Rgb::WHITE;
        let relative = rel_mse(&image, &reference).expect("same size");
        assert!(relative > 0.0);
        let scaled = rel_mse(&brighter(&image, 1024.0), &brighter(&reference, 1024.0));
        assert!((scaled.expect("same size") - relative).abs() < 1e-12 * relative);
    }

    #[test]
    fn black_references_and_other_sizes_are_defined() {
        let black = Image::filled(2, 2, Rgb::BLACK);
        assert_eq!(rel_mse(&black, &black).expect("same size"), 0.0);
        let grey = Image::filled(2, 2, Rgb::grey(0.1));
        assert_eq!(rel_mse(&grey, &black).expect("same size"), f64::INFINITY);
        let other = Image::filled(4, 1, Rgb::BLACK);
        let error = mse(&other, &black).expect_err("another size");
        assert_eq!(error.kind(), ErrorKind::Usage);
    }
}
