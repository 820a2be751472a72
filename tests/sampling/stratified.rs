//! The stratified sampler: strata and cells are filled, the mean is right, the variance small, decisions are uncorrelated.

use crate::common::verdict::assert_mean;
use etendue::internals::math::stats::Moments;
use etendue::internals::sampler::{Decision, Independent, Sampler, Stratified};

/// Numbers of samples, with the columns and rows of the cells that they fill.
const GRIDS: [(u64, usize, usize); 9] = [
    (1, 1, 1),
    (2, 1, 2),
    (16, 4, 4),
    (32, 4, 8),
    (64, 8, 8),
    (100, 10, 10),
    (1000, 25, 40),
    // More cells than samples.
    (7, 2, 4),
    (97, 9, 11),
];

/// The numbers of a decision for one set of samples.
fn set<const N: usize>(
    sampler: &mut impl Sampler,
    pixel: [u32; 2],
    samples: std::ops::Range<u64>,
    decision: Decision,
) -> Vec<[f64; N]> {
    samples
        .map(|sample| {
            sampler.start(pixel, sample);
            sampler.draw::<N>(decision).map(f64::from)
        })
        .collect()
}

/// The stratum of a number.
fn stratum(number: f64, strata: usize) -> usize {
    (number * strata as f64) as usize
}

/// Panics if one of `places` strata is taken twice; with as many strata as samples, each is then taken once.
#[track_caller]
fn assert_shared_out(what: &str, places: usize, taken: impl Iterator<Item = usize>) {
    let mut free = vec![true; places];
    for place in taken {
        assert!(
            std::mem::take(&mut free[place]),
            "{what}: two samples in stratum {place} of {places}"
        );
    }
}

#[test]
fn samples_fill_distinct_strata_rows_columns_and_cells() {
    for (n, columns, rows) in GRIDS {
        let mut sampler = Stratified::new(1, Some(n));
        let strata = n as usize;
        for (pixel, first) in [([0, 0], 0), ([3, 9], 0), ([5, 5], 12 * n)] {
            let samples = first..first + n;
            for decision in [
                Decision::Camera,
                Decision::Light(0),
                Decision::Light(70_000),
            ] {
                let what = format!("{n} samples of {pixel:?} from {first}, {decision:?}");
                let numbers = set::<4>(&mut sampler, pixel, samples.clone(), decision);
                for (u, v) in [(0, 1), (2, 3)] {
                    let rows_taken = numbers.iter().map(|s| stratum(s[u], strata));
                    assert_shared_out(&what, strata, rows_taken.clone());
                    let columns_taken = numbers.iter().map(|s| stratum(s[v], columns * rows));
                    assert_shared_out(&what, columns * rows, columns_taken);
                    let cell = |(s, row): (&[f64; 4], usize)| {
                        row / columns * columns + stratum(s[v], columns)
                    };
                    let cells = numbers.iter().zip(rows_taken).map(cell);
                    assert_shared_out(&what, columns * rows, cells);
                }
            }
            for decision in [Decision::Time, Decision::Alpha(2), Decision::Roulette(5)] {
                let numbers = set::<1>(&mut sampler, pixel, samples.clone(), decision);
                let taken = numbers.iter().map(|s| stratum(s[0], strata));
                assert_shared_out(&format!("{n} samples, {decision:?}"), strata, taken);
            }
        }
    }
}

/// A smooth function that is not a sum of functions of one number each; its integral over the unit square follows.
fn smooth(x: f64, y: f64) -> f64 {
    (1.0 + x * y) * (x + y).exp()
}

fn smooth_integral() -> f64 {
    1.0 + (std::f64::consts::E - 1.0).powi(2)
}

/// The mean of the smooth function over the first `n` samples of each of many pixels.
fn means(mut sampler: impl Sampler, n: u64, pixels: u32, [x, y]: [usize; 2]) -> Moments {
    Moments::of((0..pixels).map(|pixel| {
        let numbers = set::<4>(&mut sampler, [pixel, 7], 0..n, Decision::Light(1));
        numbers.iter().map(|s| smooth(s[x], s[y])).sum::<f64>() / n as f64
    }))
}

#[test]
fn stratified_mean_is_unbiased_for_various_sample_counts() {
    for pair in [[0, 1], [2, 3], [1, 2]] {
        for (n, _, _) in GRIDS {
            let pixels = (1 << 14) / n as u32;
            let means = means(Stratified::new(2, Some(n)), n, pixels.max(64), pair);
            assert_mean(
                &format!("{n} samples, {pair:?}"),
                &means,
                smooth_integral(),
                5e-3,
            );
        }
    }
}

#[test]
fn single_stratified_samples_give_unbiased_means() {
    // The last samples are the most likely to be biased if not all cells of a set are filled.
    for n in [7, 97] {
        for sample in [0, n / 2, n - 1] {
            let values = (0..1 << 16).map(|seed| {
                let mut sampler = Stratified::new(seed, Some(n));
                sampler.start([1, 2], sample);
                let [x, y] = sampler.draw(Decision::Bsdf(0)).map(f64::from);
                smooth(x, y)
            });
            let what = format!("sample {sample} of {n}");
            assert_mean(&what, &Moments::of(values), smooth_integral(), 3e-3);
        }
    }
}

#[test]
fn stratified_variance_is_4x_below_independent_sampling() {
    // A ratio of variances of 512 means each has a standard error of sqrt(4 / 511), 9 %: a factor of 4 is far beyond.
    let variance = |moments: Moments| moments.variance().expect("512 pixels");
    for n in [256, 251] {
        let independent = variance(means(Independent::new(3), n, 512, [0, 1]));
        for pair in [[0, 1], [2, 3]] {
            let stratified = variance(means(Stratified::new(3, Some(n)), n, 512, pair));
            let gain = independent / stratified;
            println!("{n} samples, {pair:?}: {gain:.0} times less variance");
            assert!(gain >= 4.0, "{n} samples, {pair:?}: {gain}");
        }
    }
}

#[test]
fn decisions_and_neighbouring_pixels_are_uncorrelated() {
    // If the orders of strata were correlated, the mean of a product of two numbers would not be 1/4. If the correlation
    // were positive in some pixels and negative in others, the variance of the mean over a set would exceed that of
    // shuffled strata: (1/12)^2 / (n - 1) and what the sets' own means add.
    let n = 16;
    let mut sampler = Stratified::new(4, Some(n));
    let mut first = |pixel, decision| set::<1>(&mut sampler, pixel, 0..n, decision);
    let here = (Decision::Light(1), [0, 0]);
    for (decision, step) in [
        (Decision::Camera, [0, 0]),
        (Decision::Time, [0, 0]),
        (Decision::Bsdf(1), [0, 0]),
        (Decision::Light(2), [0, 0]),
        (here.0, [1, 0]),
        (here.0, [0, 1]),
        (here.0, [1, 1]),
    ] {
        let products = (0..1 << 12).map(|pixel| {
            let a = first([pixel, 3], here.0);
            let b = first([pixel + step[0], 3 + step[1]], decision);
            a.iter().zip(&b).map(|(a, b)| a[0] * b[0]).sum::<f64>() / n as f64
        });
        let products = Moments::of(products);
        let what = format!("{decision:?} at {step:?}");
        assert_mean(&what, &products, 0.25, 2e-3);
        let expected = (1.0 / 12.0_f64).powi(2) / (n - 1) as f64;
        let ratio = products.variance().expect("4096 pixels") / expected;
        // The standard error of a variance of 4096 numbers is 2 %.
        println!("{what}: {ratio:.3} of the variance of shuffled strata");
        assert!((0.85..1.15).contains(&ratio), "{what}: {ratio}");
    }
}
