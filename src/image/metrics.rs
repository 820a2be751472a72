//! How far one picture is from another.
//!
//! Measure: [`mse`] in squared radiance, [`rel_mse`] without unit.
//! Range: pictures of one size; others are a usage error.
//! Source: relMSE as in docs/accuracy.md, with an epsilon that follows the exposure. Tested below.

use super::Image;
use crate::error::{Error, Result};

/// The mean over pixels and channels of (x - r)^2.
///
/// # Errors
/// Pictures of different sizes.
pub fn mse(image: &Image, reference: &Image) -> Result<f64> {
    mean_over(image, reference, |x, r| (x - r) * (x - r))
}

/// The mean over pixels and channels of (x - r)^2 / (r^2 + eps), with eps = 0.01 mean(r)^2.
///
/// # Errors
/// Pictures of different sizes, or a black reference.
pub fn rel_mse(image: &Image, reference: &Image) -> Result<f64> {
    let mean = mean_over(reference, reference, |x, _| x)?;
    if mean == 0.0 {
        return Err(Error::usage(
            "the reference is black: there is no relative error",
        ));
    }
    let epsilon = 0.01 * mean * mean;
    mean_over(image, reference, |x, r| {
        (x - r) * (x - r) / (r * r + epsilon)
    })
}

fn mean_over(image: &Image, reference: &Image, f: impl Fn(f64, f64) -> f64) -> Result<f64> {
    let size = |image: &Image| (image.width, image.height);
    if size(image) != size(reference) {
        return Err(Error::usage(format!(
            "pictures of different sizes: {:?} and {:?}",
            size(image),
            size(reference)
        )));
    }
    let pairs = image.pixels.iter().zip(&reference.pixels);
    let values = pairs.flat_map(|(x, r)| {
        let (x, r) = (x.to_array(), r.to_array());
        [0, 1, 2].map(|c| f(f64::from(x[c]), f64::from(r[c])))
    });
    Ok(values.sum::<f64>() / (3.0 * image.pixels.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rgb::Rgb;

    #[test]
    fn ten_percent_off_is_ten_percent() {
        let picture = |value: f32| Image::new(2, 2, vec![Rgb::grey(value); 4]);
        let error = rel_mse(&picture(1.1), &picture(1.0)).expect("same size");
        assert!((error.sqrt() - 0.1 / 1.01_f64.sqrt()).abs() < 1e-6);
        assert!((mse(&picture(3.0), &picture(1.0)).expect("same size") - 4.0).abs() < 1e-12);
        assert!(mse(&picture(1.0), &Image::new(1, 1, vec![Rgb::BLACK])).is_err());
        assert!(rel_mse(&picture(1.0), &picture(0.0)).is_err());
    }
}
