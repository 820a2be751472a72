//! Rejection sampling: the distribution, the number of trials, and inputs of which nothing can be drawn.

use crate::common::TestRng;
use crate::common::chi_square::{ChiSquareTest, pearson, uniformity};
use crate::common::verdict::{assert_mean, sidak};
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{ONE_MINUS_EPSILON, Vec3};
use etendue::internals::sampling::warp;
use etendue_lab::course::direction::{
    BALL_IN_CUBE, PDF_HEMISPHERE_UNIFORM, sample_hemisphere_by_rejection,
    sample_sphere_by_rejection,
};
use etendue_lab::course::disk::{DISK_IN_SQUARE, sample_disk_by_rejection};
use etendue_lab::course::rejection::{
    BoundingBox, MAX_TRIALS, RejectionFailure, measure_efficiency, sample_density, sample_inside,
};
use std::f64::consts::{FRAC_2_PI, PI, TAU};

const DRAWS: u32 = 1 << 18;
/// The largest standard error that is accepted, relative to the measured quantity.
const POWER: f64 = 2e-3;

fn bounds<const D: usize>(min: f64, max: f64) -> BoundingBox<D> {
    BoundingBox::new([min; D], [max; D]).expect("a box")
}

fn square_norm<const D: usize>(p: &[f64; D]) -> f64 {
    p.iter().map(|x| x * x).sum()
}

#[test]
fn disk_rejection_sampling_is_uniform_with_exact_efficiency() {
    let mut rng = TestRng::new(1);
    let mut counts = vec![0; 24 * 24];
    let mut trials = Moments::default();
    for _ in 0..DRAWS {
        let drawn = sample_disk_by_rejection(&mut || rng.uniform()).expect("a point is accepted");
        let p = drawn.value.as_dvec2();
        trials.push(f64::from(drawn.trials));
        let ring = ((24.0 * p.length_squared()) as usize).min(23);
        let turn = ((24.0 * (p.y.atan2(p.x) / TAU + 0.5)) as usize).min(23);
        counts[24 * ring + turn] += 1;
    }
    let p = uniformity(&counts);
    assert!(p > 1e-3, "{p:.1e}");
    assert_mean("trials", &trials, 1.0 / DISK_IN_SQUARE, POWER);
}

#[test]
fn direction_rejection_sampling_is_uniform_at_exact_efficiency() {
    let test = ChiSquareTest::default();
    let mut trials = Moments::default();
    let sphere = test.run(
        |rng| {
            let drawn =
                sample_sphere_by_rejection(&mut || rng.uniform()).expect("a point is accepted");
            trials.push(f64::from(drawn.trials));
            Some(drawn.value)
        },
        |_| warp::PDF_SPHERE_UNIFORM,
    );
    let hemisphere = test.run(
        |rng| {
            let drawn =
                sample_hemisphere_by_rejection(&mut || rng.uniform()).expect("a point is accepted");
            trials.push(f64::from(drawn.trials));
            Some(drawn.value)
        },
        |w| {
            if w.z > 0.0 {
                PDF_HEMISPHERE_UNIFORM
            } else {
                0.0
            }
        },
    );
    for result in [sphere, hemisphere] {
        assert!(result.p_value > sidak(1e-3, 2), "{result:?}");
        assert!((result.integral - 1.0).abs() < 1e-3, "{result:?}");
    }
    assert_mean("trials", &trials, 1.0 / BALL_IN_CUBE, POWER);
}

#[test]
fn rejection_samples_are_uniform_in_the_set() {
    // Below the diagonal of a box, where x / a + y / b < 1.
    let (min, max) = ([-1.0, 2.0], [3.0, 2.5]);
    let box_2d = BoundingBox::new(min, max).expect("a box");
    let unit = |p: &[f64; 2]| [0, 1].map(|i| (p[i] - min[i]) / (max[i] - min[i]));
    let inside = |p: &[f64; 2]| unit(p).iter().sum::<f64>() < 1.0;
    let mut rng = TestRng::new(3);
    // In these coordinates the set is a square, and the mapping preserves ratios of areas.
    let mut counts = vec![0; 24 * 24];
    let mut trials = Moments::default();
    for _ in 0..DRAWS {
        let drawn = sample_inside(&box_2d, inside, MAX_TRIALS, &mut || rng.uniform_f64());
        let drawn = drawn.expect("a point is accepted");
        trials.push(f64::from(drawn.trials));
        let [x, y] = unit(&drawn.value);
        let cell = |x: f64| ((24.0 * x) as usize).min(23);
        counts[24 * cell(1.0 - (1.0 - x).powi(2)) + cell(y / (1.0 - x))] += 1;
    }
    let p = uniformity(&counts);
    assert!(p > 1e-3, "{p:.1e}");
    assert_mean("trials", &trials, 2.0, POWER);
}

#[test]
fn measured_efficiency_matches_volume_fraction_of_the_box() {
    let mut rng = TestRng::new(4);
    let n = 2_000_000;
    let mut uniform = || rng.uniform_f64();
    let disk = measure_efficiency(
        &bounds(-1.0, 1.0),
        |p: &[f64; 2]| square_norm(p) <= 1.0,
        n,
        &mut uniform,
    );
    assert_mean("disk", &disk, PI / 4.0, POWER);
    let ball = measure_efficiency(
        &bounds(-1.0, 1.0),
        |p: &[f64; 3]| square_norm(p) <= 1.0,
        n,
        &mut uniform,
    );
    assert_mean("ball", &ball, PI / 6.0, POWER);
    // The efficiency falls with the dimension: pi^2 / 32, pi^3 / 384.
    let ball = measure_efficiency(
        &bounds(-1.0, 1.0),
        |p: &[f64; 4]| square_norm(p) <= 1.0,
        n,
        &mut uniform,
    );
    assert_mean("4-ball", &ball, PI.powi(2) / 32.0, POWER);
    let ball = measure_efficiency(
        &bounds(-1.0, 1.0),
        |p: &[f64; 6]| square_norm(p) <= 1.0,
        2 * n,
        &mut uniform,
    );
    assert_mean("6-ball", &ball, PI.powi(3) / 384.0, POWER);
    // In a box of another size: the area of the set is the efficiency times the area of the box.
    let wide: BoundingBox<2> = bounds(-2.0, 1.0);
    let disk = measure_efficiency(&wide, |p: &[f64; 2]| square_norm(p) <= 1.0, n, &mut uniform);
    assert_mean("disk in a wide box", &disk, PI / wide.volume(), POWER);
    assert_eq!(wide.volume(), 9.0);
}

#[test]
fn rejection_samples_follow_a_bounded_density() {
    const CELLS: usize = 100;
    let hill = |p: &[f64; 1]| (PI * p[0]).sin();
    let mut rng = TestRng::new(5);
    let mut trials = Moments::default();
    let mut cells: Vec<_> = (0..CELLS)
        .map(|i| {
            let [low, high] = [i, i + 1].map(|k| (PI * k as f64 / CELLS as f64).cos());
            (f64::from(DRAWS) * 0.5 * (low - high), 0.0)
        })
        .collect();
    for _ in 0..DRAWS {
        let drawn = sample_density(&bounds(0.0, 1.0), hill, 1.0, MAX_TRIALS, &mut || {
            rng.uniform_f64()
        });
        let drawn = drawn.expect("a point is accepted");
        trials.push(f64::from(drawn.trials));
        cells[((CELLS as f64 * drawn.value[0]) as usize).min(CELLS - 1)].1 += 1.0;
    }
    let p = pearson(&mut cells);
    assert!(p > 1e-3, "{p:.1e}");
    // The mean of sin over half a turn.
    assert_mean("trials", &trials, 1.0 / FRAC_2_PI, POWER);
}

#[test]
fn rejection_sampling_stops_if_nothing_is_accepted() {
    let mut rng = TestRng::new(6);
    let mut asked = 0;
    let mut counting = || {
        asked += 1;
        rng.uniform_f64()
    };
    let none = sample_inside(&bounds::<3>(0.0, 1.0), |_| false, 1000, &mut counting);
    assert_eq!((none, asked), (None, 3000));
    let mut rng = TestRng::new(7);
    let mut uniform = || rng.uniform_f64();
    let unit = bounds::<1>(0.0, 1.0);
    let none = sample_density(&unit, |_| 0.0, 1.0, 1000, &mut uniform);
    assert_eq!(none, Err(RejectionFailure::All));
    assert_eq!(sample_inside(&unit, |_| true, 0, &mut uniform), None);
    // A generator that always returns a corner of the box, or the centre, which has no direction.
    assert_eq!(
        sample_disk_by_rejection(&mut || ONE_MINUS_EPSILON).map(|d| d.trials),
        None
    );
    for stuck in [0.0, 0.5, ONE_MINUS_EPSILON] {
        assert_eq!(sample_sphere_by_rejection(&mut || stuck), None, "{stuck}");
    }
}

#[test]
fn density_outside_its_bound_is_reported_as_an_error() {
    let unit = bounds::<1>(0.0, 1.0);
    for wrong in [1.5, -0.1, f64::NAN, f64::INFINITY] {
        let drawn = sample_density(&unit, |_| wrong, 1.0, 100, &mut || 0.25);
        assert_eq!(drawn, Err(RejectionFailure::OutOfBounds([0.25])), "{wrong}");
    }
}

#[test]
fn invalid_boxes_are_rejected_and_extreme_samples_stay_inside() {
    assert_eq!(BoundingBox::new([0.0], [-1.0]), None);
    assert_eq!(BoundingBox::new([0.0, 0.0], [1.0, f64::INFINITY]), None);
    assert_eq!(BoundingBox::new([f64::NAN], [1.0]), None);
    let tilted = BoundingBox::new([-1e3, 1e-3], [0.1, 2e-3]).expect("a box");
    for x in [0.0, ONE_MINUS_EPSILON] {
        for y in [0.0, ONE_MINUS_EPSILON] {
            let [x, y] = tilted.sample([f64::from(x), f64::from(y)]);
            assert!((-1e3..=0.1).contains(&x) && (1e-3..=2e-3).contains(&y));
        }
    }
    // The corners of the ball's box are outside it, the middles of its faces inside.
    let mut numbers = [0.0, 0.5, 0.5].into_iter();
    let drawn = sample_sphere_by_rejection(&mut || numbers.next().expect("three"));
    assert_eq!(drawn.map(|d| d.value), Some(Vec3::NEG_X));
}
