//! One-dimensional densities sampled by inversion: the power function, and tabulated functions.

use crate::common::TestRng;
use crate::common::chi_square::{pearson, uniformity};
use crate::common::quadrature::integrate;
use crate::common::verdict::sidak;
use etendue::internals::math::vec::ONE_MINUS_EPSILON;
use etendue_lab::course::piecewise_linear::PiecewiseLinear;
use etendue_lab::course::power::{invert_power, pdf_power, sample_power, sample_power_as_maximum};
use std::f64::consts::PI;

const DRAWS: u32 = 1 << 17;
/// Extreme uniform numbers, where sampling functions fail first.
const EXTREMES: [f32; 4] = [0.0, 1.0 / 16_777_216.0, 0.5, ONE_MINUS_EPSILON];
/// Exponents of the power function.
const POWERS: [f64; 7] = [0.0, 0.5, 1.0, 2.0, 10.0, 1e3, 1e6];

/// The p-value of the uniformity of numbers in [0, 1].
fn line_uniformity(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut counts = vec![0; 512];
    numbers.for_each(|x| counts[((512.0 * x) as usize).min(511)] += 1);
    uniformity(&counts)
}

#[test]
fn power_samples_follow_pdf_by_inversion_and_by_maximum() {
    let mut checks = Vec::new();
    for (seed, n) in (0..).zip(POWERS) {
        // x^(n + 1) is uniform.
        let mut rng = TestRng::new(seed);
        let draws = (0..DRAWS).map(|_| sample_power(rng.uniform_f64(), n).powf(n + 1.0));
        checks.push((format!("inversion, n = {n}"), line_uniformity(draws)));
        let integral = integrate(|x| pdf_power(x, n), (-30.0 / (n + 1.0)).exp(), 1.0, 400);
        assert!((integral - 1.0).abs() < 1e-8, "{n}: {integral}");
        assert_eq!((pdf_power(-0.5, n), pdf_power(1.5, n)), (0.0, 0.0));
    }
    for n in [0, 1, 2, 5, 20] {
        let mut rng = TestRng::new(100 + n);
        let draws = (0..DRAWS).map(|_| {
            let numbers = (0..=n).map(|_| rng.uniform_f64());
            let x = sample_power_as_maximum(numbers).expect("at least one number");
            x.powf(n as f64 + 1.0)
        });
        checks.push((format!("maximum, n = {n}"), line_uniformity(draws)));
    }
    assert_eq!(sample_power_as_maximum([]), None);
    for (what, p) in &checks {
        assert!(*p > sidak(1e-3, checks.len()), "{what}: {p:.1e}");
    }
}

#[test]
fn power_sampling_inverts_and_stays_in_the_domain() {
    for n in POWERS {
        for u in EXTREMES.map(f64::from).into_iter().chain([0.1, 0.7, 0.999]) {
            let x = sample_power(u, n);
            assert!((0.0..=1.0).contains(&x) && pdf_power(x, n) > 0.0, "{n} {u}");
            assert!(pdf_power(x, n).is_finite());
            let back = invert_power(x, n);
            // Near 1, x itself has no more significant digits than this.
            assert!(
                (back - u).abs() <= 1e-15 * (n + 10.0),
                "{n}: {u} {back} {x}"
            );
        }
    }
}

/// Tabulated functions, some with pieces and nodes of density 0.
fn polylines() -> Vec<([f64; 2], Vec<f64>)> {
    vec![
        ([0.0, 1.0], vec![1.0, 1.0]),
        ([0.0, 1.0], vec![0.0, 2.0]),
        ([-1.0, 1.0], vec![5.0, 0.0]),
        (
            [-2.0, 3.0],
            vec![0.0, 1.0, 4.0, 0.0, 0.0, 2.0, 2.0, 1e-3, 0.0],
        ),
        ([1e3, 1e3 + 1.0], vec![3.0, 1e-12, 3.0, 1e4]),
        (
            [0.0, PI],
            (0..=64).map(|i| (PI * f64::from(i) / 64.0).sin()).collect(),
        ),
    ]
}

/// The polyline's value and its area up to x, node by node.
fn polyline(range: [f64; 2], values: &[f64], x: f64) -> (f64, f64) {
    let step = (range[1] - range[0]) / (values.len() - 1) as f64;
    let mut area = 0.0;
    for (i, ends) in values.windows(2).enumerate() {
        let start = range[0] + step * i as f64;
        let part = ((x - start) / step).clamp(0.0, 1.0);
        let value = ends[0] + part * (ends[1] - ends[0]);
        area += step * part * 0.5 * (ends[0] + value);
        if part < 1.0 || i + 2 == values.len() {
            return (value, area);
        }
    }
    unreachable!("a polyline has a last piece")
}

#[test]
fn piecewise_linear_samples_follow_their_pdf() {
    const CELLS: usize = 128;
    let lines = polylines();
    for (seed, (range, values)) in (200..).zip(&lines) {
        let (a, width) = (range[0], range[1] - range[0]);
        let density = PiecewiseLinear::new(*range, values).expect("a valid polyline");
        let (_, area) = polyline(*range, values, range[1]);
        let pieces = values.len() - 1;
        let integral = integrate(|x| density.pdf(x), a, range[1], 4 * pieces);
        assert!((integral - 1.0).abs() < 1e-9, "{values:?}: {integral}");
        let mut cells = Vec::new();
        for i in 0..CELLS {
            let [low, high] = [i, i + 1].map(|k| a + width * k as f64 / CELLS as f64);
            let share = (polyline(*range, values, high).1 - polyline(*range, values, low).1) / area;
            cells.push((f64::from(DRAWS) * share, 0.0));
            let middle = 0.5 * (low + high);
            let exact = polyline(*range, values, middle).0 / area;
            let error = (density.pdf(middle) - exact).abs();
            assert!(error < 1e-9 * (exact + 1e-3), "{values:?} {middle}");
        }
        let mut rng = TestRng::new(seed);
        for _ in 0..DRAWS {
            let u = rng.uniform_f64();
            let x = density.sample(u);
            let back = density.invert(x);
            assert!((back - u).abs() < 1e-9, "{values:?}: {u} {back}");
            cells[(((x - a) / width * CELLS as f64) as usize).min(CELLS - 1)].1 += 1.0;
        }
        let p = pearson(&mut cells);
        assert!(p > sidak(1e-3, lines.len()), "{values:?}: {p:.1e}");
        assert_eq!(
            (density.pdf(a - 1.0), density.pdf(range[1] + 1.0)),
            (0.0, 0.0)
        );
        assert_eq!(
            (density.invert(a - 1.0), density.invert(range[1] + 1.0)),
            (0.0, 1.0)
        );
    }
}

#[test]
fn piecewise_linear_handles_extremes_and_rejects_invalid_input() {
    let tiny = ([0.0, 1.0], vec![0.0, 5e-324, 0.0, 5e-324]);
    let huge = ([0.0, 1.0], vec![0.0, 8e307, 1e-300, 0.0, 4e307]);
    for (range, values) in polylines().into_iter().chain([tiny, huge]) {
        let density = PiecewiseLinear::new(range, &values).expect("a valid polyline");
        let mut before = range[0];
        for u in EXTREMES
            .map(f64::from)
            .into_iter()
            .chain([1.0_f64.next_down()])
        {
            let x = density.sample(u);
            assert!((before..=range[1]).contains(&x), "{values:?} {u} {x}");
            assert!(density.pdf(x).is_finite() && density.invert(x).is_finite());
            before = x;
        }
    }
    for values in [
        vec![],
        vec![1.0],
        vec![0.0, 0.0],
        vec![1.0, -1.0, 3.0],
        vec![1.0, f64::NAN],
        vec![1.0, f64::INFINITY],
    ] {
        assert!(PiecewiseLinear::new([0.0, 1.0], &values).is_none());
    }
    for range in [
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, f64::INFINITY],
        [f64::NAN, 1.0],
    ] {
        assert!(PiecewiseLinear::new(range, &[1.0, 1.0]).is_none());
    }
}

#[test]
fn tabulated_pdf_error_is_within_the_interpolation_bound() {
    let sine =
        PiecewiseLinear::tabulate(f64::sin, [0.0, PI], 64).expect("the sine is a valid density");
    // Between nodes linear interpolation of the sine is off by at most h^2 / 8, and the area by as much.
    let bound = 3.0 * (PI / 64.0).powi(2) / 8.0;
    for i in 1..1000 {
        let x = PI * f64::from(i) / 1000.0;
        assert!((sine.pdf(x) - 0.5 * x.sin()).abs() < bound, "{x}");
        assert!(
            (sine.invert(x) - 0.5 * (1.0 - x.cos())).abs() < bound,
            "{x}"
        );
    }
}
