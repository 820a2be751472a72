//! Numbers of pixels as colours: signed errors on a scale that diverges, standard errors on one that grows.
//!
//! Measure: shares; colours as linear light.
//! Range: what is beyond the ends of a scale has the colour of its end.
//! Source: blue and orange, told apart by colour-blind people too (Okabe and Ito 2008). Tested below.

use crate::image::Image;
use crate::math::rgb::Rgb;

const BELOW: Rgb = Rgb::new(0.0, 0.16, 0.75);
const ABOVE: Rgb = Rgb::new(0.83, 0.13, 0.0);
const NONE: Rgb = Rgb::new(0.93, 0.93, 0.93);

/// Signed errors: from `-end`, blue, by white to `end`, red.
pub fn signed(width: u32, errors: &[f32], end: f32) -> Image {
    coloured(width, errors, |error| {
        let share = (error / end).clamp(-1.0, 1.0);
        let colour = if share < 0.0 { BELOW } else { ABOVE };
        between(NONE, colour, share.abs())
    })
}

/// Sizes: from 0, black, to `end`, white.
pub fn sizes(width: u32, sizes: &[f32], end: f32) -> Image {
    coloured(width, sizes, |size| {
        let share = (size / end).clamp(0.0, 1.0);
        // Even steps of lightness.
        Rgb::new(share.powf(1.5), share.powf(2.4), share.powf(3.2))
    })
}

fn coloured(width: u32, values: &[f32], colour: impl Fn(f32) -> Rgb) -> Image {
    let pixels: Vec<Rgb> = values.iter().map(|&value| colour(value)).collect();
    let height = pixels.len() as u32 / width.max(1);
    Image::new(width, height, pixels)
}

fn between(a: Rgb, b: Rgb, share: f32) -> Rgb {
    (1.0 - share) * a + share * b
}

/// The next of 1, 2 and 5 times a power of ten above a number.
pub fn round_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(x.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    steps.into_iter().find(|&step| step >= x).unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_differ_and_ends_hold() {
        let image = signed(5, &[-9.0, -1.0, 0.0, 1.0, 9.0], 1.0);
        let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|x| image.get(x, 0));
        assert_eq!((a, b, c, d, e), (BELOW, BELOW, NONE, ABOVE, ABOVE));
        let image = sizes(2, &[0.0, 7.0], 1.0);
        assert_eq!((image.get(0, 0), image.get(1, 0)), (Rgb::BLACK, Rgb::WHITE));
    }

    #[test]
    fn scales_end_at_round_numbers() {
        for (x, end) in [
            (0.013, 0.02),
            (0.3, 0.5),
            (7.0, 10.0),
            (1.0, 1.0),
            (0.0, 1.0),
        ] {
            assert!((round_up(x) - end).abs() < 1e-12, "{x}");
        }
    }
}
