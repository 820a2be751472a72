//! All samplers: uniform, independent where they should be, stratified where they can be, and addressed by decision.

use crate::common::chi_square::uniformity;
use crate::common::verdict::sidak;
use etendue::internals::math::lanes::{ActiveLanes, LANES};
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::ONE_MINUS_EPSILON;
use etendue::internals::sampler::{
    Batches, Decision, Independent, LaneStates, Sampler, Sobol, Stratified,
};

/// Decisions of all kinds, also where the independent sampler changes its stream (bounce 8191) and far beyond.
const DECISIONS: [Decision; 25] = [
    Decision::Camera,
    Decision::Time,
    Decision::Strategy,
    Decision::LightPath,
    Decision::Alpha(0),
    Decision::Alpha(9),
    Decision::Emission(0),
    Decision::Emission(9),
    Decision::Light(0),
    Decision::Bsdf(0),
    Decision::Roulette(0),
    Decision::Light(1),
    Decision::Bsdf(1),
    Decision::Bsdf(2),
    Decision::Light(8190),
    Decision::Bsdf(8190),
    Decision::Light(8191),
    Decision::Bsdf(8191),
    Decision::Light(20_000),
    Decision::Bsdf(1_000_003),
    Decision::Light(u32::MAX),
    Decision::Source,
    Decision::LightPathBsdf(0),
    Decision::Lens(0),
    Decision::LightPathBsdf(1_000_003),
];

fn count(decision: Decision) -> usize {
    match decision {
        Decision::Camera | Decision::Light(_) | Decision::Source => 4,
        Decision::Bsdf(_) | Decision::LightPathBsdf(_) | Decision::SourceDirection => 3,
        Decision::Lens(_) => 2,
        Decision::Time
        | Decision::Strategy
        | Decision::LightPath
        | Decision::Alpha(_)
        | Decision::Emission(_)
        | Decision::Roulette(_)
        | Decision::LightPathAlpha(_)
        | Decision::LightPathRoulette(_) => 1,
    }
}

/// All numbers of a decision, as integers below 2^24; those beyond its count are 0.
fn numbers<S: Sampler>(sampler: &mut S, decision: Decision) -> [u32; 4] {
    let mut numbers = match count(decision) {
        4 => sampler.draw(decision),
        3 => {
            let [a, b, c] = sampler.draw(decision);
            [a, b, c, 0.0]
        }
        2 => {
            let [a, b] = sampler.draw(decision);
            [a, b, 0.0, 0.0]
        }
        _ => {
            let [a] = sampler.draw(decision);
            [a, 0.0, 0.0, 0.0]
        }
    };
    for u in &mut numbers {
        assert!((0.0..=ONE_MINUS_EPSILON).contains(u), "{decision:?} {u}");
        *u *= 16_777_216.0;
        assert_eq!(u.fract(), 0.0, "{decision:?}");
    }
    numbers.map(|u| u as u32)
}

/// p-values of the uniformity of the numbers in 256 bins, and of pairs of them in 16 x 16.
#[derive(Default)]
struct PValues(Vec<(String, f64)>);

impl PValues {
    fn single(&mut self, what: String, numbers: impl IntoIterator<Item = u32>) {
        let mut bins = [0; 256];
        numbers
            .into_iter()
            .for_each(|x| bins[x as usize >> 16] += 1);
        self.0.push((what, uniformity(&bins)));
    }

    fn pair(&mut self, what: String, pairs: impl IntoIterator<Item = (u32, u32)>) {
        let high = |(x, y): (u32, u32)| (x >> 20 << 20) | (y >> 4);
        self.single(what, pairs.into_iter().map(high));
    }

    /// Checks all p-values at a joint significance of 0.1 %.
    fn check(&self) {
        let threshold = sidak(1e-3, self.0.len());
        for (what, p) in &self.0 {
            assert!(*p > threshold, "{what}: {p:.1e}");
        }
        println!("{} chi-square tests", self.0.len());
    }
}

/// First sample indices of the tested ranges: 0, 2^16, and before 2^32, where the Sobol' sequence restarts.
const STARTS: [u64; 3] = [0, 1 << 16, (1 << 32) - (1 << 13)];

fn samples_are_uniform<S: Sampler>(mut sampler: S, p: &mut PValues, name: &str) {
    for start in STARTS {
        let samples: Vec<[[u32; 4]; DECISIONS.len()]> = (start..start + (1 << 14))
            .map(|sample| {
                sampler.start([3, 5], sample);
                DECISIONS.map(|decision| numbers(&mut sampler, decision))
            })
            .collect();
        for (i, decision) in DECISIONS.into_iter().enumerate() {
            for d in 0..count(decision) {
                let what = format!("{name} from {start}, {decision:?} {d}");
                p.single(what.clone(), samples.iter().map(|s| s[i][d]));
                for e in 0..d {
                    p.pair(
                        format!("{what} {e}"),
                        samples.iter().map(|s| (s[i][d], s[i][e])),
                    );
                }
            }
        }
    }
}

/// One sample of each of many pixels: neighbouring pixels are independent, and so are the decisions of one pixel.
///
/// Within one pixel the pairs of two Sobol' decisions are shuffled strata, not independent; over pixels they have to be.
/// The same holds for stratified ones.
fn pixels_are_uniform<S: Sampler>(mut sampler: S, p: &mut PValues, name: &str) {
    let size = 128;
    let drawn: Vec<[[u32; 4]; DECISIONS.len()]> = (0..size * size)
        .map(|i| {
            sampler.start([i % size, i / size], 70_000);
            DECISIONS.map(|decision| numbers(&mut sampler, decision))
        })
        .collect();
    for (i, decision) in DECISIONS.into_iter().enumerate() {
        let what = format!("{name} pixels, {decision:?}");
        p.single(what.clone(), drawn.iter().map(|s| s[i][0]));
        for distance in [1, 2, size as usize, size as usize + 1] {
            let pairs = drawn
                .iter()
                .zip(&drawn[distance..])
                .map(|(a, b)| (a[i][0], b[i][0]));
            p.pair(format!("{what} and {distance} on"), pairs);
        }
        for d in 0..count(decision) {
            for (j, other) in DECISIONS.into_iter().enumerate().take(i) {
                let e = d % count(other);
                let pairs = drawn.iter().map(|s| (s[i][d], s[j][e]));
                p.pair(format!("{what} {d}, {other:?} {e}"), pairs);
            }
        }
    }
}

#[test]
fn numbers_and_pairs_are_uniform() {
    let mut p = PValues::default();
    samples_are_uniform(Independent::new(1), &mut p, "independent");
    samples_are_uniform(Sobol::new(1), &mut p, "sobol");
    samples_are_uniform(Stratified::new(1, None), &mut p, "stratified");
    samples_are_uniform(Stratified::new(1, Some(97)), &mut p, "stratified by 97");
    pixels_are_uniform(Independent::new(2), &mut p, "independent");
    pixels_are_uniform(Sobol::new(2), &mut p, "sobol");
    for n in [1, 7, 16, 100] {
        pixels_are_uniform(
            Stratified::new(2, Some(n)),
            &mut p,
            &format!("stratified by {n}"),
        );
    }
    p.check();
}

#[test]
fn successive_independent_samples_are_independent() {
    // They come from one stream, in which numbers a power of two apart are correlated.
    let mut sampler = Independent::new(3);
    let mut p = PValues::default();
    for decision in [Decision::Camera, Decision::Bsdf(1), Decision::Light(9000)] {
        let numbers: Vec<u32> = (0..1 << 18)
            .map(|sample| {
                sampler.start([0, 0], sample);
                numbers(&mut sampler, decision)[0]
            })
            .collect();
        for lag in [1, 2, 3, 4, 1 << 8, 1 << 12, 1 << 16] {
            let pairs = numbers.iter().zip(&numbers[lag..]).map(|(&a, &b)| (a, b));
            p.pair(format!("{decision:?} lag {lag}"), pairs);
        }
        let low = |x: u32| x << 16 & 0xff_0000;
        p.single(
            format!("{decision:?} low bits"),
            numbers.into_iter().map(low),
        );
    }
    p.check();
}

/// The mean, over the samples of a pixel, of the product of two decisions' numbers: if they are shuffled independently, its
/// variance is about that of shuffled strata, (1/12)^2 / (n - 1). In one and the same order, leading digits would agree in all
/// samples or in none, and the variance would be more than ten times as large.
#[test]
fn sobol_decisions_are_shuffled_independently() {
    let n = 16;
    let mut sampler = Sobol::new(5);
    for decision in [Decision::Camera, Decision::Bsdf(1), Decision::Light(2)] {
        let products = Moments::of((0..1 << 12).map(|pixel| {
            let product = |sample| {
                sampler.start([pixel, 7], sample);
                let [[a], [b]] = [Decision::Light(1), decision].map(|d| sampler.draw(d));
                f64::from(a) * f64::from(b)
            };
            (0..n).map(product).sum::<f64>() / n as f64
        }));
        let shuffled = (1.0 / 12.0_f64).powi(2) / (n - 1) as f64;
        let ratio = products.variance().expect("4096 pixels") / shuffled;
        println!("{decision:?}: {ratio:.2} of the variance of shuffled strata");
        assert!(ratio < 4.0, "{decision:?}: {ratio}");
    }
}

fn nothing_repeats<S: Sampler>(samplers: [S; 2]) {
    let mut tuples = Vec::new();
    for mut sampler in samplers {
        for pixel in [
            [0, 0],
            [1, 0],
            [0, 1],
            [1, 1],
            [640, 480],
            [480, 640],
            [65_535, 65_535],
            [u32::MAX, 0],
        ] {
            for sample in (0..1 << 11).chain((1 << 32)..(1 << 32) + (1 << 11)) {
                sampler.start(pixel, sample);
                for decision in DECISIONS.into_iter().filter(|&d| count(d) >= 3) {
                    let [a, b, c, _] = numbers(&mut sampler, decision);
                    tuples.push([a, b, c]);
                }
            }
        }
    }
    // The expected number of chance collisions of n tuples of 72 bits is n^2 / 2^73 < 1e-9.
    let drawn = tuples.len();
    tuples.sort_unstable();
    tuples.dedup();
    assert_eq!(tuples.len(), drawn);
}

#[test]
fn sample_triples_do_not_repeat_across_pixels_and_seeds() {
    nothing_repeats([Independent::new(0), Independent::new(1)]);
    nothing_repeats([Sobol::new(0), Sobol::new(1)]);
    nothing_repeats([Stratified::new(0, None), Stratified::new(1, None)]);
}

fn order_does_not_matter<S: Sampler>(mut sampler: S) {
    let addresses: Vec<_> = [[0, 0], [7, 1], [1, 7]]
        .into_iter()
        .flat_map(|pixel| [0, 1, 2, 65_536, 1 << 33].map(|sample| (pixel, sample)))
        .flat_map(|(pixel, sample)| DECISIONS.map(|decision| (pixel, sample, decision)))
        .collect();
    let mut fresh = |(pixel, sample, decision): ([u32; 2], u64, Decision)| {
        sampler.start(pixel, sample);
        numbers(&mut sampler, decision)
    };
    let alone: Vec<_> = addresses.iter().map(|&address| fresh(address)).collect();
    // A stride that has no factor in common with the count visits every address, out of order.
    let n = addresses.len();
    for k in 0..n {
        let i = k * 101 % n;
        assert_eq!(fresh(addresses[i]), alone[i], "{:?}", addresses[i]);
    }
    // All of a sample's decisions in turn, forwards, backwards, and every third.
    let samples = addresses.chunks(DECISIONS.len());
    for (sample, alone) in samples.zip(alone.chunks(DECISIONS.len())) {
        sampler.start(sample[0].0, sample[0].1);
        let forwards = 0..DECISIONS.len();
        let order = forwards
            .clone()
            .chain(forwards.clone().rev())
            .chain(forwards.step_by(3));
        for i in order {
            assert_eq!(
                numbers(&mut sampler, DECISIONS[i]),
                alone[i],
                "{:?}",
                sample[i]
            );
        }
    }
}

#[test]
fn sample_values_do_not_depend_on_draw_order() {
    order_does_not_matter(Independent::new(4));
    order_does_not_matter(Sobol::new(4));
    order_does_not_matter(Stratified::new(4, Some(100)));
}

/// The quality parameter t of a (t, m, 2)-net: the least t such that all boxes of area 2^(t - m) hold the same number of the
/// 2^m `points`.
fn quality(points: &[(u32, u32)]) -> u32 {
    let m = points.len().trailing_zeros();
    let balanced = |bits: u32| {
        (0..=bits).all(|x_bits| {
            let mut boxes = vec![0; 1 << bits];
            for &(x, y) in points {
                // Both have 24 bits.
                let cell = (x >> (24 - x_bits)) << (bits - x_bits) | y >> (24 - (bits - x_bits));
                boxes[cell as usize] += 1;
            }
            boxes.iter().all(|&n| n == points.len() >> bits)
        })
    };
    (0..=m)
        .find(|t| balanced(m - t))
        .expect("one box holds all")
}

#[test]
fn sobol_points_are_stratified_in_power_of_two_prefixes() {
    let mut sampler = Sobol::new(5);
    for (pixel, decision) in [
        ([0, 0], Decision::Camera),
        ([9, 4], Decision::Light(0)),
        ([2, 2], Decision::Light(30_000)),
    ] {
        let points: Vec<[u32; 4]> = (0..1 << 12)
            .map(|sample| {
                sampler.start(pixel, sample);
                numbers(&mut sampler, decision)
            })
            .collect();
        for m in 0..=12 {
            let prefix = &points[..1 << m];
            for d in 0..4 {
                let mut strata: Vec<u32> = prefix.iter().map(|p| p[d] >> (24 - m)).collect();
                strata.sort_unstable();
                assert!(
                    strata.into_iter().eq(0..1 << m),
                    "{decision:?} {d}, 2^{m} points"
                );
            }
            // The first two dimensions have the best t, 0; t of the others is at most the sum of the
            // polynomials' degrees less one.
            for (a, b, limit) in [(0, 1, 0), (0, 2, 1), (1, 2, 1), (2, 3, 3)] {
                let pairs: Vec<_> = prefix.iter().map(|p| (p[a], p[b])).collect();
                let t = quality(&pairs);
                assert!(t <= limit, "{decision:?} {a} {b}, 2^{m} points: t = {t}");
            }
        }
    }
}

#[test]
fn sobol_variance_decreases_faster_than_n_to_minus_1_3() {
    // The variance over pixels of the mean of (1 + x y) e^(x + y), at 2^4 and at 2^12 samples.
    let variance = |m: u32, dimensions: [usize; 2]| {
        let means = (0..64).map(|pixel| {
            let mut sampler = Sobol::new(6);
            let mut sum = 0.0;
            for sample in 0..1 << m {
                sampler.start([pixel, 0], sample);
                let u: [f32; 4] = sampler.draw(Decision::Light(0));
                let [x, y] = dimensions.map(|d| f64::from(u[d]));
                sum += (1.0 + x * y) * (x + y).exp();
            }
            sum / f64::from(1 << m)
        });
        Moments::of(means).variance().expect("64 pixels")
    };
    // The pairs used for the film, the choice of a light, its point, and the direction of the BSDF.
    for dimensions in [[0, 1], [2, 3], [1, 2]] {
        let slope = (variance(12, dimensions) / variance(4, dimensions)).log2() / 8.0;
        println!("dimensions {dimensions:?}: variance ~ N^{slope:.2}");
        assert!(slope < -1.3, "{dimensions:?} {slope}");
    }
}

/// Compares the numbers that samplers draw alone with those drawn in lanes, for sixteen pixels.
fn draw_alike<S: Sampler, const N: usize>(
    sampler: &S,
    sample: u64,
    count: usize,
    decision: Decision,
) {
    let pixels = [0, 1].map(|axis| std::array::from_fn(|lane| 3 + (lane as u32 >> (2 * axis)) % 4));
    let mut started = sampler.start_lanes(&pixels, sample);
    // Two of three lanes, whose samplers are in reverse order.
    let mut active = ActiveLanes::<LANES>::NONE;
    (0..count).for_each(|lane| active.set(lane, lane % 3 != 1));
    let places = std::array::from_fn(|lane| (LANES - 1 - lane) as u32);
    let mut numbers = [[0.0; LANES]; N];
    let states = LaneStates::gather(&started, &active, &places);
    S::draw_lanes(
        &mut started,
        &active,
        &places,
        &states,
        decision,
        &mut numbers,
    );
    for lane in active.each() {
        let mut sampler = sampler.clone();
        sampler.start(pixels.map(|pixels| pixels[places[lane] as usize]), sample);
        let alone: [f32; N] = sampler.draw(decision);
        let drawn = numbers.each_ref().map(|numbers| numbers[lane]);
        assert_eq!(drawn, alone, "{sample}, {decision:?}");
    }
}

fn side_by_side<S: Sampler>(sampler: S) {
    for sample in STARTS.into_iter().chain([(1 << 32) - 1, 77]) {
        for count in 0..=LANES {
            for decision in [Decision::Camera, Decision::Bsdf(3), Decision::Light(70_000)] {
                draw_alike::<S, 1>(&sampler, sample, count, decision);
                draw_alike::<S, 2>(&sampler, sample, count, decision);
                draw_alike::<S, 3>(&sampler, sample, count, decision);
                draw_alike::<S, 4>(&sampler, sample, count, decision);
            }
        }
    }
}

#[test]
fn sampler_draws_in_lanes_are_identical_to_scalar_draws() {
    side_by_side(Independent::new(5));
    side_by_side(Stratified::new(5, Some(64)));
    side_by_side(Sobol::new(5));
    side_by_side(Sobol::new(5).in_batches(Batches::new(16)));
}
