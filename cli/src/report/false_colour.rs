//! False colours: a diverging palette for signed numbers and a sequential palette for numbers from 0 up.
//!
//! Measure: numbers relative to a scale that the caller chooses; linear Rec. 709, which a PNG stores as exactly the
//! palette's codes.
//! Range: a number beyond the scale has the colour of its end. NaN is black, which is not in any palette.
//! Source: the palettes RdBu of ColorBrewer and viridis of Matplotlib, both suitable for colour-blind people, in the
//! crate colorous. Tested below.

use colorous::{Color, Gradient, RED_BLUE, VIRIDIS};
use etendue::internals::image::Image;
use etendue::internals::image::srgb::to_linear;
use etendue::internals::math::rgb::Rgb;

/// Returns the colour of a number from -1 (blue) over 0 (nearly white) to 1 (red).
pub fn signed(value: f64) -> Rgb {
    // The palette has red at 0.
    colour(RED_BLUE, 0.5 - 0.5 * value)
}

/// Returns the colour of a number from 0 (dark violet) to 1 (yellow).
pub fn sequential(value: f64) -> Rgb {
    colour(VIRIDIS, value)
}

fn colour(palette: Gradient, place: f64) -> Rgb {
    if place.is_nan() {
        return Rgb::BLACK;
    }
    let Color { r, g, b } = palette.eval_continuous(place.clamp(0.0, 1.0));
    Rgb::from([r, g, b].map(|code| to_linear(f64::from(code) / 255.0) as f32))
}

/// Builds an image of numbers, one per pixel, each divided by `scale` and coloured by a palette.
///
/// # Panics
/// If the number of values is not `width * height`, or 0.
pub fn map(
    numbers: &[f64],
    (width, height): (u32, u32),
    scale: f64,
    palette: fn(f64) -> Rgb,
) -> Image {
    let pixels = numbers.iter().map(|number| palette(number / scale));
    Image::new(width, height, pixels.collect())
}

/// Returns a robust scale: the 99 % quantile of the absolute values. If that is 0, returns the largest absolute value,
/// and if all are 0, returns 1.
pub fn robust_scale(numbers: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = numbers.iter().map(|number| number.abs()).collect();
    sizes.retain(|size| size.is_finite());
    if sizes.is_empty() {
        return 1.0;
    }
    let place = (0.99 * (sizes.len() - 1) as f64).ceil() as usize;
    let (_, &mut quantile, above) = sizes.select_nth_unstable_by(place, f64::total_cmp);
    if quantile > 0.0 {
        return quantile;
    }
    let greatest = above.iter().copied().fold(0.0, f64::max);
    if greatest > 0.0 { greatest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::image::{ColourSpace, png_bytes};

    #[test]
    fn signed_map_is_red_above_blue_below_and_grey_at_zero() {
        let [dark, right, bright] = [-0.7, 0.0, 0.7].map(|value| signed(value).to_array());
        assert!(dark[2] > 2.0 * dark[0], "{dark:?}");
        assert!(bright[0] > 2.0 * bright[2], "{bright:?}");
        assert!(right.iter().all(|channel| *channel > 0.8), "{right:?}");
        assert_eq!(signed(9.0), signed(1.0));
        assert_eq!(signed(f64::NEG_INFINITY), signed(-1.0));
        assert_eq!(signed(f64::NAN), Rgb::BLACK);
    }

    #[test]
    fn sequential_map_luminance_is_increasing() {
        let steps = (0..=20).map(|i| sequential(f64::from(i) / 20.0).luminance());
        let steps: Vec<f32> = steps.collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{steps:?}");
        assert_eq!(sequential(-1.0), sequential(0.0));
    }

    #[test]
    fn png_contains_the_exact_palette_codes() {
        let picture = map(&[-2.0, 0.0, 1.0, 2.0], (4, 1), 2.0, signed);
        let read = Image::decode(&png_bytes(&picture, 0.0), ColourSpace::Linear);
        let read = read.expect("an image");
        for (pixel, value) in read.pixels().iter().zip([-1.0, 0.0, 0.5, 1.0]) {
            let Color { r, g, b } = RED_BLUE.eval_continuous(0.5 - 0.5 * value);
            let codes = pixel
                .to_array()
                .map(|channel| (255.0 * channel).round() as u8);
            assert_eq!(codes, [r, g, b]);
        }
    }

    #[test]
    fn robust_scale_is_the_99th_percentile() {
        let mut numbers: Vec<f64> = (0..=1000).map(|i| f64::from(i) / 1000.0).collect();
        assert_eq!(robust_scale(&numbers), 0.99);
        numbers[1000] = f64::INFINITY;
        numbers[999] = -1e30;
        assert!((robust_scale(&numbers) - 0.99).abs() < 2e-3);
        numbers.fill(0.0);
        assert_eq!(robust_scale(&numbers), 1.0);
        numbers[5] = -3.0;
        assert_eq!(robust_scale(&numbers), 3.0);
        assert_eq!(robust_scale(&[f64::NAN]), 1.0);
    }
}
