//! The local bias of an image: for each tile, the probability that its mean differs from that of the references by
//! chance.
//!
//! Measure: probabilities, one for each tile of 8 x 8 pixels; without bias they are uniform in [0, 1].
//! Range: at least two renders; tiles without noise cannot be tested and are left out.
//! Source: Welch's t-test on the mean luminance of a tile. The variance of the references' mean is computed from their
//! difference in each of its pixels, and from the correlation of neighbours. Tested below.

use super::reference::{References, TILE};
use etendue::internals::image::Image;
use etendue::internals::image::tiles::ImageTile;
use etendue::internals::math::stats::{Moments, student_p_value};

/// The p-values of all tiles.
pub fn p_values(references: &References, renders: &[Image]) -> Vec<f64> {
    let Some(first) = renders.first() else {
        return Vec::new();
    };
    let (width, height) = (first.width(), first.height());
    let correlation = references.correlation();
    let variance = references.variance_of_mean();
    let variance: Vec<[f64; 3]> = variance
        .iter()
        .map(|of_pixel| of_pixel.map(|v| correlation * v))
        .collect();
    let of_tile = |tile: ImageTile| {
        let columns = tile.x..tile.x + tile.width;
        let rows = tile.y..tile.y + tile.height;
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| (y * width + x) as usize));
        let pixels: Vec<usize> = pixels.collect();
        p_value(&pixels, references.mean(), &variance, renders)
    };
    ImageTile::all(width, height, TILE)
        .filter_map(of_tile)
        .collect()
}

fn p_value(
    pixels: &[usize],
    reference: &Image,
    variance: &[[f64; 3]],
    renders: &[Image],
) -> Option<f64> {
    let count = pixels.len() as f64;
    let sum = |image: &Image| {
        let pixels = pixels.iter().map(|&i| image.pixels()[i].to_array());
        pixels.flatten().map(f64::from).sum::<f64>() / count
    };
    let means = Moments::of(renders.iter().map(sum));
    let of_renders = means.standard_error()?.powi(2);
    // The channels of a pixel are correlated: the standard deviation of their sum is at most the sum of their standard
    // deviations.
    let of_pixel = |&i: &usize| variance[i].iter().map(|v| v.sqrt()).sum::<f64>().powi(2);
    let of_reference = pixels.iter().map(of_pixel).sum::<f64>() / (count * count);
    let both = of_renders + of_reference;
    if both == 0.0 {
        return None;
    }
    let freedom = both * both
        / (of_renders.powi(2) / (means.count() as f64 - 1.0) + of_reference.powi(2) / count);
    let t = (means.mean() - sum(reference)).abs() / both.sqrt();
    Some(student_p_value(t, freedom))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::bootstrap::Dealer;
    use etendue::internals::math::rgb::Rgb;
    use etendue::internals::math::stats::normal_quantile;

    /// An image in which squares of this edge share their noise.
    fn picture(dealer: &mut Dealer, mean: f64, sigma: f64, edge: usize) -> Image {
        let mut number = || {
            let uniform = (dealer.below(1 << 40) as f64 + 0.5) / (1_u64 << 40) as f64;
            Rgb::grey((mean + sigma * normal_quantile(uniform)) as f32)
        };
        let numbers: Vec<Rgb> = (0..64 * 40).map(|_| number()).collect();
        let pixel = |i: usize| numbers[i / 64 / edge * 64 + i % 64 / edge];
        Image::new(64, 40, (0..64 * 40).map(pixel).collect())
    }

    fn shares(bias: f64, edge: usize) -> [f64; 2] {
        let mut dealer = Dealer::new(9);
        let mut all = Vec::new();
        for _ in 0..20 {
            let [one, two] = [0; 2].map(|_| picture(&mut dealer, 1.0, 0.1, edge));
            let references = References::new(one, two).expect("light");
            let renders: Vec<Image> = (0..8)
                .map(|_| picture(&mut dealer, 1.0 + bias, 0.2, edge))
                .collect();
            all.extend(p_values(&references, &renders));
        }
        assert_eq!(all.len(), 20 * 8 * 5);
        [0.5, 0.05].map(|level| {
            let below = all.iter().filter(|&&p| p < level).count();
            below as f64 / all.len() as f64
        })
    }

    #[test]
    fn tile_p_values_are_uniform_without_bias_and_detect_bias() {
        // Five standard deviations of shares of 800 tiles.
        for edge in [1, 2] {
            let [half, few] = shares(0.0, edge);
            assert!(
                (half - 0.5).abs() < 0.09 && (few - 0.05).abs() < 0.039,
                "{edge}: {half} {few}"
            );
        }
        let [_, found] = shares(0.06, 1);
        assert!(found > 0.9, "{found}");
    }

    #[test]
    fn noise_free_tiles_yield_no_p_values() {
        let grey = Image::filled(8, 8, Rgb::grey(1.0));
        let references = References::new(grey.clone(), grey.clone()).expect("light");
        assert!(p_values(&references, &[grey.clone(), grey]).is_empty());
        assert!(p_values(&references, &[]).is_empty());
    }
}
