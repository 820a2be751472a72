//! Pearson's chi-square test of sampled directions against the claimed density.
//!
//! The sphere is divided into cells of about equal probability by halving a pilot sample at its medians, so that cells adapt
//! to a peak of any width. The claimed density is integrated over each cell, a second sample is counted, and
//! sum (observed - expected)^2 / expected follows chi-square.
//!
//! Measure: densities per steradian; cells are rectangles in (height below the pole, azimuth), which preserve area.
//! Range: cells with an expected count below 5 are pooled. "No sample" (or a delta) is one more cell.
//! Source: Pearson 1900. Tested on right densities and planted bugs in `tests/sampling/harness.rs`.

use super::TestRng;
use super::quadrature::{Adaptive, Rectangle};
use etendue::internals::math::vec::Vec3;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::{PI, TAU};

/// The settings of the test.
#[derive(Debug, Clone, Copy)]
pub struct ChiSquareTest {
    /// The number of directions counted; a quarter as many form the pilot sample.
    pub samples: u32,
    /// Each hemisphere has 2^levels cells.
    pub levels: u32,
    /// The probability of "no sample", if the model states it; otherwise one minus the integral of the density.
    pub probability_of_none: Option<f64>,
    /// The seed of both samples.
    pub seed: u64,
}

impl Default for ChiSquareTest {
    fn default() -> Self {
        Self {
            samples: 1 << 16,
            levels: 7,
            probability_of_none: None,
            seed: 1,
        }
    }
}

/// The result of the test.
#[derive(Debug, Clone, Copy)]
pub struct ChiSquareResult {
    /// The probability of at least this deviation if the density is right.
    pub p_value: f64,
    /// The integral of the claimed density over the sphere.
    pub integral: f64,
    /// The share of draws that returned no sample.
    pub none: f64,
}

/// One hemisphere: upper or lower.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hemisphere {
    Upper,
    Lower,
}

/// A direction in area-preserving coordinates: 1 - |z| without cancellation, and the azimuth in [0, 2 pi).
#[derive(Debug, Clone, Copy)]
struct Point {
    hemisphere: Hemisphere,
    coordinates: [f64; 2],
}

impl Point {
    fn of(w: Vec3) -> Self {
        let w = w.as_dvec3();
        let below_pole = (w.x * w.x + w.y * w.y) / (1.0 + w.z.abs());
        let azimuth = w.y.atan2(w.x);
        let azimuth = if azimuth < 0.0 {
            azimuth + TAU
        } else {
            azimuth
        };
        Self {
            hemisphere: if w.z < 0.0 {
                Hemisphere::Lower
            } else {
                Hemisphere::Upper
            },
            coordinates: [below_pole.min(1.0), azimuth.min(TAU.next_down())],
        }
    }
}

fn direction(hemisphere: Hemisphere, below_pole: f64, azimuth: f64) -> Vec3 {
    let r = (below_pole * (2.0 - below_pole)).max(0.0).sqrt();
    let z = 1.0 - below_pole;
    let z = if hemisphere == Hemisphere::Lower {
        -z
    } else {
        z
    };
    Vec3::new(
        (r * azimuth.cos()) as f32,
        (r * azimuth.sin()) as f32,
        z as f32,
    )
}

/// A binary tree of cells over one hemisphere.
enum Cells {
    Leaf(usize),
    Split {
        axis: usize,
        at: f64,
        sides: Box<[Cells; 2]>,
    },
}

impl Cells {
    /// Halves `points` at the median `levels` times, along both axes in turn; leaves are appended to `leaves`.
    fn build(
        points: &mut [[f64; 2]],
        domain: Rectangle,
        levels: u32,
        leaves: &mut Vec<Rectangle>,
    ) -> Self {
        if levels == 0 {
            leaves.push(domain);
            return Self::Leaf(leaves.len() - 1);
        }
        let axis = (levels % 2) as usize;
        let (low, high) = if axis == 0 { domain.x } else { domain.y };
        points.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
        let middle = points.len() / 2;
        let median = points.get(middle).map_or(f64::NAN, |p| p[axis]);
        // Few or equal points: halve the cell instead.
        let inside = median > low && median < high;
        let at = if inside && points.len() >= 8 {
            median
        } else {
            0.5 * (low + high)
        };
        let split = points.partition_point(|p| p[axis] < at);
        let (below, above) = points.split_at_mut(split);
        let (mut lower, mut upper) = (domain, domain);
        if axis == 0 {
            (lower.x.1, upper.x.0) = (at, at);
        } else {
            (lower.y.1, upper.y.0) = (at, at);
        }
        let sides = Box::new([
            Self::build(below, lower, levels - 1, leaves),
            Self::build(above, upper, levels - 1, leaves),
        ]);
        Self::Split { axis, at, sides }
    }

    fn find(&self, point: [f64; 2]) -> usize {
        match self {
            Self::Leaf(index) => *index,
            Self::Split { axis, at, sides } => sides[usize::from(point[*axis] >= *at)].find(point),
        }
    }
}

impl ChiSquareTest {
    /// Tests `sample` against `pdf`.
    pub fn run(
        &self,
        mut sample: impl FnMut(&mut TestRng) -> Option<Vec3>,
        pdf: impl Fn(Vec3) -> f32,
    ) -> ChiSquareResult {
        let mut rng = TestRng::new(self.seed);
        let pilot: Vec<Point> = (0..self.samples / 4)
            .filter_map(|_| sample(&mut rng).map(Point::of))
            .collect();
        let mut leaves = Vec::new();
        let mut trees = Vec::new();
        let mut expected = Vec::new();
        // The tolerance is a hundredth of the noise in a cell.
        let cells = f64::from(2_u32 << self.levels);
        let quadrature = Adaptive::new(0.01 / (cells * f64::from(self.samples)).sqrt(), 40);
        for hemisphere in [Hemisphere::Upper, Hemisphere::Lower] {
            let mut points: Vec<[f64; 2]> = pilot
                .iter()
                .filter(|p| p.hemisphere == hemisphere)
                .map(|p| p.coordinates)
                .collect();
            let domain = Rectangle {
                x: (0.0, 1.0),
                y: (0.0, TAU),
            };
            // A hemisphere without pilot samples needs no fine cells, but its density still counts.
            let levels = if points.is_empty() { 2 } else { self.levels };
            trees.push(Cells::build(&mut points, domain, levels, &mut leaves));
            let density = |s: f64, phi: f64| f64::from(pdf(direction(hemisphere, s, phi)));
            let first = expected.len();
            expected.extend(
                leaves[first..]
                    .iter()
                    .map(|&leaf| quadrature.integrate(&density, leaf)),
            );
        }
        let mut observed = vec![0_u32; leaves.len()];
        let mut none = 0_u32;
        for _ in 0..self.samples {
            match sample(&mut rng).map(Point::of) {
                None => none += 1,
                Some(point) => {
                    let tree = &trees[usize::from(point.hemisphere == Hemisphere::Lower)];
                    observed[tree.find(point.coordinates)] += 1;
                }
            }
        }
        self.compare(&expected, &observed, none)
    }

    fn compare(&self, expected: &[f64], observed: &[u32], none: u32) -> ChiSquareResult {
        let n = f64::from(self.samples);
        let integral: f64 = expected.iter().sum();
        let expected_none = self
            .probability_of_none
            .unwrap_or((1.0 - integral).max(0.0));
        let mut cells: Vec<(f64, f64)> = expected
            .iter()
            .zip(observed)
            .map(|(&e, &o)| (n * e, f64::from(o)))
            .chain([(n * expected_none, f64::from(none))])
            .collect();
        let p_value = pearson(&mut cells);
        ChiSquareResult {
            p_value,
            integral,
            none: f64::from(none) / n,
        }
    }
}

/// The probability of at least the deviation of `cells`, pairs of expected and observed counts, if the expected counts are right.
pub fn pearson(cells: &mut [(f64, f64)]) -> f64 {
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut statistic, mut used) = (0.0, 0_u32);
    let mut pool = (0.0, 0.0);
    for &(e, o) in &*cells {
        pool = (pool.0 + e, pool.1 + o);
        if pool.0 >= 5.0 {
            statistic += (pool.1 - pool.0).powi(2) / pool.0;
            used += 1;
            pool = (0.0, 0.0);
        }
    }
    // The remaining cells expect almost no samples: many observed there fail the test.
    let leftover_ok = pool.1 <= 20.0;
    match ChiSquared::new(f64::from(used.max(2) - 1)) {
        Ok(distribution) if leftover_ok => distribution.sf(statistic),
        _ => 0.0,
    }
}

/// The p-value of [`pearson`] for counts with equal expectations.
pub fn uniformity(observed: &[u32]) -> f64 {
    let total: f64 = observed.iter().map(|&o| f64::from(o)).sum();
    let expected = total / observed.len() as f64;
    let mut cells: Vec<_> = observed.iter().map(|&o| (expected, f64::from(o))).collect();
    pearson(&mut cells)
}

/// The solid angle of the sphere, for uniform densities.
pub const SPHERE: f64 = 4.0 * PI;
