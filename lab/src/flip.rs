//! FLIP: the visible difference between two images when an observer alternates between them.
//!
//! Measure: from 0 (no visible difference) to 1; the mean over the pixels, at a viewing distance with 67 pixels per
//! degree: a monitor 0.7 m wide with 3840 pixels, 0.7 m away.
//! Range: images of the same size, as encoded in PNG: scaled by `exposure` stops, values above white clamped, and
//! mapped through the sRGB transfer function to 256 codes per channel.
//! Source: Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images"; NVIDIA's own code, through the
//! crate nv-flip. Tested below.

use etendue::Result;
use etendue::internals::image::Image;
use etendue::internals::image::codes;
use etendue::internals::image::metrics::check_sizes;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool};

/// The mean of FLIP over all pixels.
pub fn flip(image: &Image, reference: &Image, exposure: f32) -> Result<f64> {
    check_sizes(image, reference)?;
    let shown = |image: &Image| {
        FlipImageRgb8::with_data(image.width(), image.height(), &codes(image, exposure))
    };
    let map = nv_flip::flip(shown(reference), shown(image), DEFAULT_PIXELS_PER_DEGREE);
    Ok(f64::from(FlipPool::from_image(&map).mean()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::ErrorKind;
    use etendue::internals::math::rgb::Rgb;

    #[test]
    fn flip_is_zero_for_equal_images_and_near_one_black_vs_white() {
        let pixels = (0..13 * 7).map(|i| Rgb::grey(0.02 * i as f32)).collect();
        let image = Image::new(13, 7, pixels);
        assert_eq!(flip(&image, &image, 0.0).expect("same size"), 0.0);
        for (width, height) in [(1, 1), (64, 48), (1, 300)] {
            let [black, white] = [0.0, 1.0].map(|v| Image::filled(width, height, Rgb::grey(v)));
            let difference = flip(&black, &white, 0.0).expect("same size");
            // On the authors' scale, black against white is close to 1.
            assert!((0.9..=1.0).contains(&difference), "{difference}");
        }
    }

    #[test]
    fn flip_compares_images_after_exposure_and_clipping() {
        let [grey, bright, brighter] = [0.1, 2.0, 4.0].map(|v| Image::filled(16, 16, Rgb::grey(v)));
        let at = |a, b, exposure| flip(a, b, exposure).expect("same size");
        assert_eq!(at(&bright, &brighter, 0.0), 0.0);
        assert!(at(&bright, &brighter, -3.0) > 0.05);
        assert!(at(&grey, &bright, 0.0) > at(&bright, &brighter, -3.0));
    }

    #[test]
    fn mismatched_image_sizes_are_a_usage_error() {
        let black = Image::filled(2, 2, Rgb::BLACK);
        let other = Image::filled(4, 1, Rgb::BLACK);
        let error = flip(&other, &black, 0.0).expect_err("another size");
        assert_eq!(error.kind(), ErrorKind::Usage);
    }
}
