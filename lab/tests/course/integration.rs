//! Tests of the course's numerical integration: orders of the rules, unbiased estimators, and variances as in theory.

use crate::common::TestRng;
use crate::common::verdict::assert_mean;
use etendue::internals::math::stats::Moments;
use etendue_lab::course::integrands::Integrand;
use etendue_lab::course::monte_carlo::{
    integrate_importance, integrate_jittered, integrate_latin_hypercube, integrate_plain,
    integrate_stratified,
};
use etendue_lab::course::piecewise_linear::PiecewiseLinear;
use etendue_lab::course::power::{pdf_power, sample_power};
use etendue_lab::course::quadrature::{CubatureResult, QuadratureRule};
use std::cell::RefCell;
use std::f64::consts::{E, FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};

/// The largest standard error for which a comparison of means is conclusive, relative to the exact value.
const POWER: f64 = 2e-3;
/// The limit for variances, which need more samples than means.
const VARIANCE_POWER: f64 = 2e-2;

/// A generator of uniform numbers of 48 bits.
fn generator(seed: u64) -> impl FnMut() -> f64 {
    let mut rng = TestRng::new(seed);
    move || rng.uniform_f64()
}

#[test]
fn quadrature_rules_are_exact_for_their_polynomials() {
    let line = |x: f64| 3.0 * x - 1.0;
    let cubic = |x: f64| x * x * x - 2.0 * x * x + 5.0;
    let (range, over_line, over_cubic) = ([-1.0, 3.0], 8.0, 20.0 - 2.0 * 28.0 / 3.0 + 20.0);
    for nodes in 2..=20 {
        let by_lines = QuadratureRule::Trapezoid
            .integrate(line, range, nodes)
            .expect("two nodes");
        assert!((by_lines - over_line).abs() < 1e-12, "{nodes}");
        let by_parabolas = QuadratureRule::Simpson.integrate(cubic, range, nodes);
        assert_eq!(by_parabolas.is_some(), nodes % 2 == 1);
        assert!(
            (by_parabolas.unwrap_or(over_cubic) - over_cubic).abs() < 1e-12,
            "{nodes}"
        );
        let cubic_by_lines = QuadratureRule::Trapezoid.integrate(cubic, range, nodes);
        assert!((cubic_by_lines.expect("two nodes") - over_cubic).abs() > 1e-3);
    }
    for nodes in [0, 1] {
        assert_eq!(
            QuadratureRule::Trapezoid.integrate(line, range, nodes),
            None
        );
        assert_eq!(QuadratureRule::Simpson.integrate(line, range, nodes), None);
    }
}

/// The result of the composite rules for one factor of the products, with node spacing h, in closed form: sums of sines
/// and of geometric series.
fn factor_by_rule(rule: QuadratureRule, integrand: Integrand, h: f64) -> f64 {
    let e = h.exp();
    match (rule, integrand) {
        (QuadratureRule::Trapezoid, Integrand::Sine) => FRAC_PI_2 * h / (FRAC_PI_2 * h).tan(),
        (QuadratureRule::Simpson, Integrand::Sine) => {
            // (4 T(h) - T(2 h)) / 3.
            let lines = |h: f64| factor_by_rule(QuadratureRule::Trapezoid, integrand, h);
            (4.0 * lines(h) - lines(2.0 * h)) / 3.0
        }
        (QuadratureRule::Trapezoid, _) => 0.5 * h * (e + 1.0) / (e - 1.0),
        (QuadratureRule::Simpson, _) => h / 3.0 * (1.0 + 4.0 * e + e * e) / (e * e - 1.0),
    }
}

#[test]
fn tensor_product_rules_match_per_axis_factors() {
    for dimension in 1..=12 {
        for (rule, least) in [
            (QuadratureRule::Trapezoid, 2_usize),
            (QuadratureRule::Simpson, 3),
        ] {
            // Dimension 12 needs at least 2^12 and 3^12 calls.
            for calls in [1000, 4096, if dimension == 12 { 531_441 } else { 40_000 }] {
                for integrand in [Integrand::Sine, Integrand::Exponential] {
                    let f = |x: &[f64]| {
                        assert!(x.iter().all(|x| (0.0..=1.0).contains(x)));
                        integrand.eval(x)
                    };
                    let what = format!("{rule:?} {integrand:?} d = {dimension}, {calls} calls");
                    let Some(estimate) = rule.integrate_cube(f, dimension, calls) else {
                        assert!(least.pow(dimension) > calls, "{what}");
                        continue;
                    };
                    assert!(estimate.calls <= calls, "{what}");
                    let nodes = (1..).find(|n: &usize| n.pow(dimension) == estimate.calls);
                    let nodes = nodes.expect("a perfect power");
                    let is_finest = (nodes + least - 1).pow(dimension) > calls;
                    assert!(is_finest, "{what}: {nodes}");
                    let h = 1.0 / (nodes - 1) as f64;
                    let exact = factor_by_rule(rule, integrand, h).powi(dimension as i32);
                    let error = (estimate.value - exact).abs();
                    assert!(error < 1e-11 * (exact.abs() + 1.0), "{what}: {error:e}");
                }
            }
        }
    }
    assert_eq!(
        QuadratureRule::Trapezoid.integrate_cube(|_| 1.0, 0, 100),
        None
    );
    assert_eq!(QuadratureRule::Simpson.integrate_cube(|_| 1.0, 3, 26), None);
}

#[test]
fn quadrature_error_converges_with_the_order_of_the_rule() {
    // Halving the spacing divides the error by 4 for the trapezoidal rule and by 16 for Simpson's, in every dimension.
    for (rule, factor) in [
        (QuadratureRule::Trapezoid, 4.0),
        (QuadratureRule::Simpson, 16.0),
    ] {
        for dimension in 1..=3 {
            let error = |nodes: usize| {
                let calls = nodes.pow(dimension);
                let f = |x: &[f64]| Integrand::Exponential.eval(x);
                let estimate = rule
                    .integrate_cube(f, dimension, calls)
                    .expect("enough calls");
                assert_eq!(estimate.calls, calls);
                (estimate.value - 1.0).abs()
            };
            let ratio = error(17) / error(33);
            assert!(
                (ratio / factor - 1.0).abs() < 0.02,
                "{rule:?} {dimension}: {ratio}"
            );
        }
    }
}

#[test]
fn stated_integrals_and_variances_match_quadrature() {
    for integrand in Integrand::ALL {
        for dimension in 1..=2 {
            // Simpson's rule loses its order for discontinuous integrands.
            let tolerance = if integrand.is_smooth() { 1e-8 } else { 2e-3 };
            let value = |f: &dyn Fn(&[f64]) -> f64| {
                let estimate = QuadratureRule::Simpson.integrate_cube(f, dimension, 401 * 401);
                estimate.expect("enough calls").value
            };
            let integral = integrand.integral(dimension);
            let mean = value(&|x| integrand.eval(x));
            assert!((mean - integral).abs() < tolerance, "{integrand:?}: {mean}");
            let variance = value(&|x| (integrand.eval(x) - integral).powi(2));
            let error = (variance - integrand.variance(dimension)).abs();
            assert!(error < tolerance, "{integrand:?} {dimension}: {variance}");
        }
    }
    let share = |integrand: Integrand, dimension| integrand.integral(dimension);
    assert!((share(Integrand::Ball, 2) - FRAC_PI_4).abs() < 1e-15);
    assert!((share(Integrand::Ball, 3) - FRAC_PI_6).abs() < 1e-15);
    // V_12 = pi^6 / 720.
    assert!((share(Integrand::Ball, 12) * 4096.0 * 720.0 / PI.powi(6) - 1.0).abs() < 1e-14);
    assert_eq!(share(Integrand::HalfSpace, 1), 0.75);
    // The unit square without the triangle outside the half-space.
    assert!((share(Integrand::HalfSpace, 2) - (1.0 - 0.5 * 0.75 * 0.75)).abs() < 1e-15);
}

#[test]
fn plain_monte_carlo_matches_exact_mean_and_variance() {
    for (seed, integrand) in (1..).zip(Integrand::ALL) {
        for dimension in [1, 2, 3, 5, 8, 12] {
            let (mean, variance) = (integrand.integral(dimension), integrand.variance(dimension));
            // A variance with a standard error of 2 % needs at least 5000 samples.
            let calls = (1.1 * variance / (POWER * mean).powi(2)).max(2e4);
            if calls > 4e6 {
                continue;
            }
            let what = format!("{integrand:?} d = {dimension}");
            let mut uniform = generator(1000 * seed + u64::from(dimension));
            let squares = RefCell::new(Moments::default());
            let f = |x: &[f64]| {
                let value = integrand.eval(x);
                squares.borrow_mut().push((value - mean).powi(2));
                value
            };
            let numbers = integrate_plain(f, dimension, calls as usize, &mut uniform);
            assert_eq!(numbers.count(), calls as u64);
            assert_mean(&what, &numbers, mean, POWER);
            // Variances of rare events and of the steepest products need more samples than means.
            if squares.borrow().standard_error() < Some(VARIANCE_POWER * variance) {
                assert_mean(&what, &squares.borrow(), variance, VARIANCE_POWER);
            }
        }
    }
}

type Integrator = fn(Integrand, u32, usize, &mut dyn FnMut() -> f64) -> Option<CubatureResult>;

const STRATIFIED: Integrator = |integrand, dimension, calls, uniform| {
    integrate_stratified(|x| integrand.eval(x), dimension, calls, &mut || uniform())
};
const JITTERED: Integrator = |integrand, dimension, calls, uniform| {
    integrate_jittered(|x| integrand.eval(x), dimension, calls, &mut || uniform())
};
const LATIN: Integrator = |integrand, dimension, calls, uniform| {
    integrate_latin_hypercube(|x| integrand.eval(x), dimension, calls, &mut || uniform())
};

/// The results of independent runs, their squared deviations from the exact value, and the number of calls per run.
fn runs(
    integrator: Integrator,
    (integrand, dimension, calls): (Integrand, u32, usize),
    count: u32,
) -> (Moments, Moments, usize) {
    let mut uniform = generator(u64::from(dimension) + 100 * calls as u64);
    let (mut values, mut squares) = (Moments::default(), Moments::default());
    let mut spent = 0;
    for _ in 0..count {
        let estimate =
            integrator(integrand, dimension, calls, &mut uniform).expect("a valid number of calls");
        assert!(estimate.calls <= calls);
        spent = estimate.calls;
        values.push(estimate.value);
        squares.push((estimate.value - integrand.integral(dimension)).powi(2));
    }
    (values, squares, spent)
}

#[test]
fn stratified_estimates_are_unbiased_with_bounded_variance() {
    for integrand in Integrand::ALL {
        for (dimension, calls) in [(1, 50), (2, 100), (3, 300), (5, 250), (8, 200), (12, 100)] {
            let what = format!("{integrand:?} d = {dimension}");
            let (exact, variance) = (integrand.integral(dimension), integrand.variance(dimension));
            let needed = 1.1 * variance / (POWER * exact).powi(2);
            if needed > 4e6 {
                continue;
            }
            // A grid may use only half of the calls. 2000 runs determine the variance within 5 %.
            let count = (2.0 * needed / calls as f64).max(2000.0) as u32;
            let (values, squares, spent) = runs(STRATIFIED, (integrand, dimension, calls), count);
            let plain = variance / spent as f64;
            assert_mean(&what, &values, exact, POWER);
            // Owen's bound for Latin hypercubes also holds for jittered grids; the noise of the estimate is allowed for.
            let bound = plain * spent as f64 / (spent as f64 - 1.0);
            let noise = 5.2 * squares.standard_error().expect("many runs");
            let found = squares.mean();
            assert!(found <= bound + noise, "{what}: {found:e} {bound:e}");
            // Stratification clearly gains in 1D, and in 2D for smooth integrands. The 1D ball is the whole interval.
            let gains = dimension == 1 || (dimension == 2 && integrand.is_smooth());
            if gains && plain > 0.0 {
                assert!(found < 0.2 * plain, "{what}: {found:e} {plain:e}");
            }
        }
    }
}

/// The variance of 3 x^2 within an interval of width h, averaged over all intervals of [0, 1]: h^2 - h^4 / 5.
fn squares_in_interval(h: f64) -> f64 {
    h * h - h.powi(4) / 5.0
}

#[test]
fn jittered_and_latin_hypercube_variances_match_closed_form() {
    let case = |dimension, calls| (Integrand::Squares, dimension, calls);
    for (dimension, per_axis) in [(1_u32, 2_usize), (1, 10), (2, 5), (3, 3), (5, 2)] {
        let calls = per_axis.pow(dimension);
        let (values, squares, spent) = runs(JITTERED, case(dimension, calls), 40_000);
        assert_eq!(spent, calls);
        let h = 1.0 / per_axis as f64;
        let exact = squares_in_interval(h) / (f64::from(dimension) * calls as f64);
        let what = format!("jittered {dimension} {per_axis}");
        assert_mean(&what, &values, 1.0, POWER);
        assert_mean(&what, &squares, exact, VARIANCE_POWER);
    }
    // For a sum of 1D functions, a Latin hypercube stratifies each axis into as many strata as there are calls.
    for (dimension, calls) in [(1, 10), (2, 7), (5, 20), (12, 30)] {
        let (values, squares, _) = runs(LATIN, case(dimension, calls), 40_000);
        let h = 1.0 / calls as f64;
        let exact = squares_in_interval(h) / (f64::from(dimension) * calls as f64);
        let what = format!("Latin {dimension} {calls}");
        assert_mean(&what, &values, 1.0, POWER);
        assert_mean(&what, &squares, exact, VARIANCE_POWER);
    }
}

#[test]
fn every_stratum_gets_one_sample() {
    let points_of = |latin: bool, dimension: u32, calls: usize| {
        let points = RefCell::new(Vec::new());
        let f = |x: &[f64]| {
            points.borrow_mut().push(x.to_vec());
            0.0
        };
        let mut uniform = generator(5);
        let estimate = if latin {
            integrate_latin_hypercube(f, dimension, calls, &mut uniform)
        } else {
            integrate_stratified(f, dimension, calls, &mut uniform)
        };
        assert_eq!(
            points.borrow().len(),
            estimate.expect("a valid number of calls").calls
        );
        points.into_inner()
    };
    // 70 calls give 4^3 = 64 cells.
    let mut cells: Vec<Vec<u32>> = points_of(false, 3, 70)
        .iter()
        .map(|p| p.iter().map(|x| (4.0 * x) as u32).collect())
        .collect();
    cells.sort();
    cells.dedup();
    assert_eq!(cells.len(), 64);
    // With fewer calls than two cells along each of 12 axes need, stratified sampling uses a Latin hypercube, too.
    for latin in [true, false] {
        let points = points_of(latin, 12, 100);
        for axis in 0..12 {
            let mut intervals: Vec<u32> = points.iter().map(|p| (100.0 * p[axis]) as u32).collect();
            assert!(
                !intervals.is_sorted(),
                "the permutation of each axis is random"
            );
            intervals.sort_unstable();
            assert_eq!(intervals, (0..100).collect::<Vec<_>>());
        }
    }
    for nothing in [(0, 100), (3, 0)] {
        let mut uniform = generator(6);
        let none = integrate_stratified(|_| 1.0, nothing.0, nothing.1, &mut uniform);
        assert_eq!(none, None);
        let none = integrate_jittered(|_| 1.0, nothing.0, nothing.1, &mut uniform);
        assert_eq!(none, None);
    }
}

#[test]
fn extreme_inputs_stay_in_the_unit_cube() {
    for u in [0.0, 1.0 - 1.0 / 16_777_216.0, 1.0_f64.next_down()] {
        let f = |x: &[f64]| {
            assert!(x.iter().all(|x| (0.0..=1.0).contains(x)), "{u} {x:?}");
            1.0
        };
        for integrate in [
            integrate_stratified,
            integrate_jittered,
            integrate_latin_hypercube,
        ] {
            for (dimension, calls) in [(1, 7), (3, 30), (12, 20)] {
                let estimate =
                    integrate(f, dimension, calls, &mut || u).expect("a valid number of calls");
                assert_eq!(estimate.value, 1.0);
            }
        }
    }
}

/// Integrates 3 x^2 with the density (n + 1) x^n: the second moment of the estimator is 9 / ((n + 1) (5 - n)).
#[test]
fn importance_sampling_variance_matches_closed_form() {
    let f = |x: &f64| 3.0 * x * x;
    for (seed, n) in (1..).zip([0.0_f64, 1.0, 2.0, 3.0, 3.8]) {
        let mut uniform = generator(seed);
        let exact = 9.0 / ((n + 1.0) * (5.0 - n)) - 1.0;
        let numbers = integrate_importance(f, 1_000_000, || {
            let x = sample_power(uniform(), n);
            (x, pdf_power(x, n))
        });
        assert_mean(&format!("n = {n}"), &numbers, 1.0, POWER);
        let variance = numbers.variance().expect("a million samples");
        if n == 2.0 {
            // The density is proportional to the integrand.
            assert!(variance < 1e-28, "{variance:e}");
        } else if n < 2.0 {
            // For n >= 3 the variance's own variance is infinite.
            let error = (variance / exact - 1.0).abs();
            assert!(error < 0.01, "{n}: {variance} {exact}");
        }
    }
    // A product of good 1D densities is also good in five dimensions: variance 1.125^5 - 1 instead of 1.8^5 - 1.
    let mut uniform = generator(7);
    let numbers = integrate_importance(
        |x: &[f64; 5]| x.iter().map(f).product(),
        400_000,
        || {
            let x = std::array::from_fn(|_| sample_power(uniform(), 1.0));
            (x, x.iter().map(|&x| pdf_power(x, 1.0)).product())
        },
    );
    assert_mean("five dimensions", &numbers, 1.0, POWER);
    let variance = numbers.variance().expect("many samples") / (1.125_f64.powi(5) - 1.0);
    assert!((variance - 1.0).abs() < 0.02, "{variance}");
}

#[test]
fn tabulated_pdf_reduces_variance_a_thousandfold() {
    for (seed, integrand) in [(1, Integrand::Sine), (2, Integrand::Exponential)] {
        let density = PiecewiseLinear::tabulate(|x| integrand.eval(&[x]), [0.0, 1.0], 16);
        let density = density.expect("a positive function");
        let mut uniform = generator(seed);
        let numbers = integrate_importance(
            |&x| integrand.eval(&[x]),
            20_000,
            || {
                let x = density.sample(uniform());
                (x, density.pdf(x))
            },
        );
        assert_mean(&format!("{integrand:?}"), &numbers, 1.0, 1e-4);
        let gain = integrand.variance(1) / numbers.variance().expect("many samples");
        assert!(gain > 1e3, "{integrand:?}: {gain}");
    }
    assert!((Integrand::Exponential.eval(&[1.0]) - E / (E - 1.0)).abs() < 1e-15);
}

#[test]
fn zero_pdf_where_integrand_is_nonzero_gives_non_finite_mean() {
    let never = integrate_importance(|_: &f64| 1.0, 20, || (0.5, 0.0));
    assert!(!never.mean().is_finite());
    let nothing_to_miss = integrate_importance(|_: &f64| 0.0, 20, || (0.5, 0.0));
    assert_eq!(nothing_to_miss.mean(), 0.0);
}

/// Two points of a Latin hypercube in 2D lie on either diagonal with probability 1/2.
#[test]
fn latin_hypercube_pairings_are_equally_likely() {
    let mut rng = TestRng::new(31);
    let mut uniform = || f64::from(rng.uniform());
    let is_rising = |x: &[f64]| f64::from(u8::from((x[0] < 0.5) == (x[1] < 0.5)));
    let rising = Moments::of((0..4096).map(|_| {
        let estimate = integrate_latin_hypercube(is_rising, 2, 2, &mut uniform);
        estimate.expect("two calls").value
    }));
    assert_mean("rising diagonals", &rising, 0.5, 0.02);
}
