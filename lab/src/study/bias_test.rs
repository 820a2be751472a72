//! The test whether two images of the same scene have different expected values.
//!
//! It takes each pixel's standard error from the layers of `render --layers`. Pixels are independent, so the variance of a
//! mean over many of them is the sum of their variances over the squared count. An image without these layers is taken as
//! exact.
//!
//! Measure: means in units of the pixels.
//! Range: images of the same size. Pixels that either image flags are excluded. Both renders must use different random
//! numbers.
//! Source: docs/accuracy.md, "Comparing two images"; `study/difference.rs`. Tested below and in
//! `cli/tests/command/compare.rs`.

use super::difference::{Difference, MeanDifference, family_p_value, sidak};
use super::standard_errors::Bars;
use etendue::Result;
use etendue::internals::film::batches::BATCHES;
use etendue::internals::image::metrics;
use etendue::internals::image::tiles::ImageTile;
use etendue::internals::image::{LayeredImage, MetadataValue};
use serde::Serialize;

/// The significance of the test of bias, for all tests of a kind together.
pub const SIGNIFICANCE: f64 = 0.05;
/// The probability with which a detectable difference is found.
pub const POWER: f64 = 0.9;

/// The result of testing whether two images have different expected values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BiasTest {
    /// The fraction of pixels that were tested: those that neither image flags.
    pub tested: f64,
    /// Tests of the means of R, G and B.
    pub channels: [ChannelTest; 3],
    /// The p-value of all three together.
    pub p: f64,
    /// Number of tests, one per channel of a tile.
    pub tile_tests: usize,
    /// The p-value of all of them together.
    pub tiles_p: f64,
    /// The smallest relative difference that half of these tests detect.
    pub tiles_detectable: f64,
    /// The test with the least p-value.
    pub worst_tile: TileTest,
}

/// The test of the means of one channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChannelTest {
    /// The test.
    #[serde(flatten)]
    pub means: MeanDifference,
    /// The smallest relative difference that the test detects.
    pub detectable: f64,
}

/// The test of the means of one channel in one tile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TileTest {
    /// The tile.
    #[serde(flatten)]
    pub tile: ImageTile,
    /// 0 is red, 1 green, 2 blue.
    pub channel: usize,
    /// The test.
    #[serde(flatten)]
    pub means: MeanDifference,
}

impl BiasTest {
    /// Whether a bias was found, by either kind of test.
    pub fn is_found(&self) -> bool {
        // Two families share the significance.
        self.p.min(self.tiles_p) < sidak(SIGNIFICANCE, 2)
    }
}

/// Tests two images for bias, in tiles of `side` pixels a side; `None` if neither has standard errors, or nothing is
/// left to test: all pixels are flagged, or the images are equal without noise.
///
/// # Errors
/// If their sizes differ, or a standard error is negative or not finite.
pub fn bias_test(
    image: &LayeredImage,
    reference: &LayeredImage,
    side: u32,
) -> Result<Option<BiasTest>> {
    metrics::check_sizes(&image.image, &reference.image)?;
    let sides = [Bars::of(image)?, Bars::of(reference)?];
    if sides.iter().all(|bars| bars.errors.is_none()) {
        return Ok(None);
    }
    let (width, height) = (image.image.width(), image.image.height());
    let mut whole = [Difference::default(); 3];
    let mut tiles = Vec::new();
    for tile in ImageTile::all(width, height, side) {
        let differences = tile_differences(&sides, tile, width);
        for (c, difference) in differences.into_iter().enumerate() {
            whole[c] = whole[c].merge(difference);
            // A tile that is black without noise in both images cannot fail, so it is not a test.
            let means = difference.test().filter(MeanDifference::is_meaningful);
            tiles.extend(means.map(|means| TileTest {
                tile,
                channel: c,
                means,
            }));
        }
    }
    let pixels = f64::from(width) * f64::from(height);
    let tested = whole[0].count() as f64 / pixels;
    Ok(judge(tested, whole, &tiles))
}

/// The sums over the pixels of a tile that neither image flags.
fn tile_differences(sides: &[Bars; 2], tile: ImageTile, width: u32) -> [Difference; 3] {
    // The degrees of freedom of the pixel's own batches: variance that neighbours add to a pixel is missing from their
    // own.
    let freedom = (BATCHES - 1) as f64;
    let mut differences = [Difference::default(); 3];
    for index in tile.indices(width) {
        if sides.iter().any(|bars| bars.is_flagged(index)) {
            continue;
        }
        for (c, difference) in differences.iter_mut().enumerate() {
            let [a, b] = [0, 1].map(|i: usize| sides[i].estimate(index, c));
            difference.push(a, b, freedom);
        }
    }
    differences
}

/// Combines the tests; `None` if nothing was tested.
fn judge(tested: f64, whole: [Difference; 3], tiles: &[TileTest]) -> Option<BiasTest> {
    let significance = sidak(SIGNIFICANCE, whole.len());
    let channel = |difference: Difference| {
        let means = difference.test()?;
        Some(ChannelTest {
            means,
            detectable: means.detectable(significance, POWER),
        })
    };
    let [r, g, b] = whole.map(channel);
    let channels = [r?, g?, b?];
    let least = channels.iter().map(|channel| channel.means.p);
    let least = least.fold(1.0, f64::min);
    let by_p = |a: &&TileTest, b: &&TileTest| a.means.p.total_cmp(&b.means.p);
    let worst_tile = *tiles.iter().min_by(by_p)?;
    let of_tiles = sidak(SIGNIFICANCE, tiles.len());
    let mut detectable: Vec<f64> = tiles
        .iter()
        .map(|tile| tile.means.detectable(of_tiles, POWER))
        .collect();
    detectable.sort_by(f64::total_cmp);
    Some(BiasTest {
        tested,
        channels,
        p: family_p_value(least, channels.len()),
        tile_tests: tiles.len(),
        tiles_p: family_p_value(worst_tile.means.p, tiles.len()),
        tiles_detectable: detectable[detectable.len() / 2],
        worst_tile,
    })
}

/// The reason why the test of bias is not valid for two images, if it can be detected.
pub fn same_random_numbers(image: &LayeredImage, reference: &LayeredImage) -> Option<String> {
    let fact = |name| Some((image.fact(name)?, reference.fact(name)?));
    let same = |name| fact(name).is_some_and(|(a, b)| a == b);
    let (seed, _) = fact("seed").filter(|(a, b)| a == b)?;
    let seed = match seed {
        MetadataValue::Text(seed) => seed.clone(),
        other => format!("{other:?}"),
    };
    same("sampler").then(|| {
        format!(
            "both images were rendered with seed {seed}: their errors are not independent, and the \
             bias test is not valid"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::synthetic::rendered;
    use etendue::internals::image::Layer;
    use etendue::internals::math::rgb::Rgb;

    fn test(image: &LayeredImage, reference: &LayeredImage) -> BiasTest {
        let test = bias_test(image, reference, 8).expect("same size");
        test.expect("there are standard errors")
    }

    #[test]
    fn false_positive_rate_of_the_bias_test_is_nominal() {
        let trials = 200;
        let found = (0..trials).filter(|&trial| {
            let [a, b] = [2 * trial, 2 * trial + 1].map(|seed| rendered(seed, 0.0));
            test(&a, &b).is_found()
        });
        // 10 are expected, with a standard deviation of 3; more than 22 in one of 4000 runs of this test.
        let found = found.count();
        assert!((1..=22).contains(&found), "{found}");
    }

    #[test]
    fn bias_test_locates_a_detectable_bias_in_one_tile() {
        let reference = rendered(1000, 0.0);
        let detectable = test(&rendered(1001, 0.0), &reference).tiles_detectable;
        assert!((0.01..0.1).contains(&detectable), "{detectable}");
        let biased = test(&rendered(1002, 2.0 * detectable), &reference);
        assert!(biased.is_found() && biased.tiles_p < 0.01, "{biased:?}");
        assert_eq!(
            (biased.worst_tile.tile.x, biased.worst_tile.tile.y),
            (16, 16)
        );
        assert_eq!(biased.tile_tests, 45);
    }

    #[test]
    fn uniform_bias_of_one_percent_is_detected() {
        let brighter = |mut image: LayeredImage| {
            image
                .image
                .pixels_mut()
                .iter_mut()
                .for_each(|pixel| *pixel *= 1.01);
            image
        };
        let trials = 20;
        let mut found = 0;
        for trial in 0..trials {
            let reference = rendered(3000 + 2 * trial, 0.0);
            let test = test(&brighter(rendered(3001 + 2 * trial, 0.0)), &reference);
            let detectable = test.channels.map(|channel| channel.detectable);
            assert!(
                detectable.iter().all(|d| (0.003..0.015).contains(d)),
                "{detectable:?}"
            );
            found += u32::from(test.is_found());
        }
        // The best channel alone finds it with a probability above 0.9.
        assert!(found >= 17, "{found}");
    }

    #[test]
    fn bias_test_handles_flagged_pixels_and_exact_references() {
        let mut image = rendered(1, 0.0);
        let exact = LayeredImage::from(rendered(2, 0.0).image);
        assert!(bias_test(&exact, &exact, 8).expect("same size").is_none());
        let against_exact = test(&image, &exact).channels[0].means.standard_error;
        let against_noisy = test(&image, &rendered(2, 0.0)).channels[0]
            .means
            .standard_error;
        assert!(against_noisy > 1.3 * against_exact);

        // A flagged firefly is not tested.
        image.image.pixels_mut()[5] = Rgb::grey(1e6);
        assert!(test(&image, &exact).tiles_p < 1e-9);
        let mut flags = vec![0.0; image.image.pixels().len()];
        flags[5] = 1.0;
        let flag = |samples| Layer {
            name: "flag.Y".to_owned(),
            samples,
        };
        image.layers.push(flag(flags.clone()));
        let tested = test(&image, &rendered(2, 0.0));
        assert!(tested.tiles_p > 1e-3 && tested.tested == 1.0 - 1.0 / 960.0);
        flags.fill(1.0);
        image.layers.last_mut().expect("a layer").samples = flags;
        assert!(bias_test(&image, &exact, 8).expect("same size").is_none());
    }

    #[test]
    fn invalid_standard_error_layers_are_rejected() {
        let good = rendered(1, 0.0);
        let mut bad = good.clone();
        bad.layers[1].samples[41] = f32::NAN;
        let error = bias_test(&good, &bad, 8).expect_err("not a number");
        assert!(error.to_string().contains("pixel (1, 1)"), "{error}");
        let mut half = good.clone();
        half.layers.pop();
        let error = bias_test(&half, &good, 8).expect_err("one is missing");
        assert!(error.to_string().contains("se.B"), "{error}");
    }

    #[test]
    fn equal_seeds_of_compared_images_are_detected() {
        let with_seed = |seed: &str| {
            let mut image = rendered(1, 0.0);
            let text = |text: &str| MetadataValue::Text(text.to_owned());
            image.metadata = vec![
                ("etendue.seed".to_owned(), text(seed)),
                ("etendue.sampler".to_owned(), text("sobol")),
            ];
            image
        };
        let same = same_random_numbers(&with_seed("7"), &with_seed("7"));
        assert!(same.expect("they are the same").contains("seed 7"));
        assert_eq!(same_random_numbers(&with_seed("7"), &with_seed("8")), None);
        assert_eq!(
            same_random_numbers(&rendered(1, 0.0), &with_seed("8")),
            None
        );
    }
}
