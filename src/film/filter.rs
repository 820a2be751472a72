//! Reconstruction filters, in two forms: a sample contributes to every pixel that its filter covers (`footprint.rs`), or it
//! belongs to one pixel, and its offset has a pdf proportional to the absolute value of the filter.
//!
//! Measure: pixels, from the centre of the pixel; f has unit integral over the plane.
//! Range: u in [0, 1 - 2^-24]; offsets in [-radius, radius]. A radius that is not a positive number panics.
//! Source: Ernst, Stamminger and Greiner 2006, "Filter Importance Sampling". Tested below.

mod shape;

pub use shape::{FilterDescription, FilterKind, MAX_RADIUS};

use super::footprint::Footprint;
use crate::math::lanes::{LANES, Lanes, each_lane, vectorised};
use crate::math::vec::Vec2;
use serde::Serialize;
use shape::profile;

/// The estimator of a pixel filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub enum FilterSampling {
    /// Samples are distributed uniformly and contribute to every pixel that the filter covers. Neighbouring pixels have
    /// correlated noise.
    #[default]
    Splatting,
    /// Positions are sampled from the filter of one pixel, to which the sample belongs. The noise of pixels is independent.
    Importance,
}

impl FilterSampling {
    /// Both estimators.
    pub const ALL: &'static [Self] = &[Self::Splatting, Self::Importance];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Splatting => "splatting",
            Self::Importance => "importance",
        }
    }
}

/// Number of table cells over [0, radius]. A multiple of 14, so that Mitchell's filter has its knot (at 1/2) and its
/// change of sign (at 4/7) between two cells: within a cell, no filter changes its sign.
const CELLS: usize = 448;

/// Number of steps of the guide table: enough that the cell of a step is mostly the right one.
const STEPS: usize = 4 * CELLS;

/// A separable filter f(x) f(y), tabulated for sampling and evaluation.
///
/// The profile f is linear between tabulated values, which differ from the named shape by less than 10^-4 of its
/// peak. Sampling and evaluation use the same table, so their ratio is exact.
#[derive(Debug, Clone)]
pub struct Filter {
    radius: f64,
    /// f at the ends of the cells, with unit integral over [-radius, radius].
    values: Vec<f64>,
    /// Sampling data of each cell.
    cells: Vec<Cell>,
    /// The cell at the start of each of `STEPS` equal steps of the cumulative share.
    guide: Vec<u16>,
    /// The radius in single precision, for sampling.
    reach: f32,
    /// Whether the filter is a box, whose offsets are uniform.
    is_box: bool,
    /// The weights of samples that contribute to several pixels.
    footprint: Option<Footprint>,
}

/// Sampling data of one cell of the table.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// The share of the integral of |f| from 0 to the cell's end.
    to: f32,
    /// The reciprocal of the cell's own share.
    scale: f32,
    /// Values of |f| at both ends of the cell, up to a factor.
    a: f32,
    b: f32,
    /// The weight of a sample in the cell for one axis, with the sign of f.
    weight: f32,
}

/// A sampled offset and its weight.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FilterSample {
    /// The offset from the centre of the pixel, in pixels.
    pub offset: Vec2,
    /// The filter value over the pdf of the offset: 1 for filters without negative lobes, else of either sign with
    /// mean 1.
    pub weight: f32,
}

impl Filter {
    /// Builds the filter of a description.
    ///
    /// # Panics
    ///
    /// If the radius is not a positive number.
    pub fn new(description: &FilterDescription) -> Self {
        let FilterDescription { kind, radius } = *description;
        assert!(
            radius > 0.0 && radius.is_finite(),
            "the radius of a filter is a positive number"
        );
        let mut values: Vec<f64> = (0..=CELLS)
            .map(|i| profile(kind, i as f64 / CELLS as f64))
            .collect();

        // Trapezoids are exact for a function that is linear in each cell.
        let areas: Vec<f64> = values
            .windows(2)
            .map(|ends| 0.5 * (ends[0] + ends[1]))
            .collect();
        let integral: f64 = areas.iter().sum();
        let total: f64 = areas.iter().map(|area| area.abs()).sum();
        let mut cumulative = vec![0.0];
        let mut sum = 0.0;
        for area in areas {
            sum += area.abs();
            cumulative.push(sum / total);
        }

        let cell_of = |share: f64| cumulative[1..CELLS].partition_point(|&end| end <= share);
        let guide = (0..STEPS)
            .map(|step| cell_of(step as f64 / STEPS as f64) as u16)
            .collect();
        let unit = 2.0 * integral * radius / CELLS as f64;
        values.iter_mut().for_each(|value| *value /= unit);
        // The integral of |f| over that of f, in one dimension: 1 without negative lobes.
        let excess = total / integral;
        let cells = (0..CELLS)
            .map(|i| Cell {
                to: cumulative[i + 1] as f32,
                scale: (1.0 / (cumulative[i + 1] - cumulative[i])) as f32,
                a: values[i].abs() as f32,
                b: values[i + 1].abs() as f32,
                weight: excess.copysign(values[i] + values[i + 1]) as f32,
            })
            .collect();
        let mut filter = Self {
            radius,
            values,
            cells,
            guide,
            reach: radius as f32,
            is_box: kind == FilterKind::Box,
            footprint: None,
        };
        if !filter.is_box {
            filter.footprint = Footprint::new(radius, |x| filter.evaluate_axis(x));
        }
        filter
    }

    /// Half the width of the support, in pixels.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The weights of samples that contribute to several pixels; `None` for boxes, which are the same in both forms, and for
    /// radii too large or too small for them.
    pub fn footprint(&self) -> Option<&Footprint> {
        self.footprint.as_ref()
    }

    /// The variance of light that varies little over a pixel by importance sampling, over that by splatting: 1 / ∫f².
    pub fn gain_of_splatting(&self) -> f64 {
        // Simpson's rule is exact for the square of a function that is linear in each cell.
        let squares = self.values.windows(2).map(|ends| {
            let [a, b] = [ends[0], ends[1]];
            (a * a + a * b + b * b) / 3.0
        });
        let of_axis = 2.0 * squares.sum::<f64>() * self.radius / CELLS as f64;
        of_axis.powi(2).recip()
    }

    /// Samples an offset with pdf |f| over its integral.
    #[inline]
    pub fn sample(&self, u: Vec2) -> FilterSample {
        let (x, x_weight) = self.sample_axis(u.x);
        let (y, y_weight) = self.sample_axis(u.y);
        FilterSample {
            offset: Vec2::new(x, y),
            weight: x_weight * y_weight,
        }
    }

    /// The filter value at an offset; 0 outside of the support.
    pub fn evaluate(&self, offset: Vec2) -> f32 {
        (self.evaluate_axis(offset.x.into()) * self.evaluate_axis(offset.y.into())) as f32
    }

    /// Samples an offset for each lane's pair of random numbers; equal to [`sample`](Self::sample) for each. Returns the
    /// offsets along both axes, and the weights.
    pub fn sample_lanes(&self, u: &[Lanes<f32>; 2]) -> ([Lanes<f32>; 2], Lanes<f32>) {
        let mut weights = [1.0; LANES];
        if self.is_box {
            let uniform = |u: &Lanes<f32>| u.map(|u| uniform_within(self.reach, u));
            return (u.each_ref().map(uniform), weights);
        }
        let offsets = u.each_ref().map(|u| {
            let mut cells = [[0.0; LANES]; 6];
            for lane in 0..LANES {
                let (signed, cell) = self.cell(u[lane]);
                let entry = &self.cells[cell];
                let of_cell = [entry.to, entry.scale, entry.a, entry.b, signed, cell as f32];
                for (cells, of_cell) in cells.iter_mut().zip(of_cell) {
                    cells[lane] = of_cell;
                }
                weights[lane] *= entry.weight;
            }
            let mut offsets = [[0.0; LANES]];
            offsets_within(self.reach, &cells, &mut offsets);
            offsets[0]
        });
        (offsets, weights)
    }

    /// Samples one coordinate and its factor of the weight. The map from `u` is monotone, so stratification is
    /// preserved.
    #[inline]
    fn sample_axis(&self, u: f32) -> (f32, f32) {
        if self.is_box {
            return (uniform_within(self.reach, u), 1.0);
        }
        let (signed, cell) = self.cell(u);
        let entry = &self.cells[cell];
        let within = [entry.to, entry.scale, entry.a, entry.b, signed, cell as f32];
        (offset_within(self.reach, within), entry.weight)
    }

    /// Returns the cumulative share from the centre, with the sign of its side, and the cell that contains it.
    #[inline]
    fn cell(&self, u: f32) -> (f32, usize) {
        let signed = 2.0 * u - 1.0;
        let share = signed.abs();
        // A share of 1 belongs to the last step.
        let step = ((share * STEPS as f32) as usize).min(STEPS - 1);
        let mut cell = usize::from(self.guide[step]);
        // Mostly at most one cell further; without a branch, which would be unpredictable.
        cell = (cell + usize::from(self.cells[cell].to <= share)).min(CELLS - 1);
        while self.cells[cell].to <= share && cell + 1 < CELLS {
            cell += 1;
        }
        (signed, cell)
    }

    /// The factor of one axis in the filter's value, at an offset along it.
    #[inline]
    pub fn evaluate_axis(&self, x: f64) -> f64 {
        let position = x.abs() / self.radius * CELLS as f64;
        if position > CELLS as f64 {
            return 0.0;
        }
        let cell = (position as usize).min(CELLS - 1);
        let within = position - cell as f64;
        self.values[cell] * (1.0 - within) + self.values[cell + 1] * within
    }
}

/// A uniformly distributed coordinate.
#[inline(always)]
fn uniform_within(reach: f32, u: f32) -> f32 {
    reach * (2.0 * u - 1.0)
}

/// The coordinate of a share within a cell. The numbers are those of [`Cell`] but the weight, the signed share and
/// the index of the cell.
#[inline(always)]
fn offset_within(reach: f32, [to, scale, a, b, signed, cell]: [f32; 6]) -> f32 {
    let within = invert_linear(1.0 - (to - signed.abs()) * scale, a, b);
    let distance = (cell + within) / CELLS as f32 * reach;
    distance.copysign(signed)
}

vectorised! {
    /// Computes [`offset_within`] for each lane.
    fn offsets_within(reach: f32, asked: &[Lanes<f32>; 6], offsets: &mut [Lanes<f32>; 1]) {
        each_lane(asked, offsets, |asked| [offset_within(reach, asked)]);
    }
}

/// Inverts the cumulative distribution at `u` for a density on [0, 1] that is linear from `a` to `b`, not both 0.
#[inline(always)]
fn invert_linear(u: f32, a: f32, b: f32) -> f32 {
    // The root of a x + (b - a) x^2 / 2 = u (a + b) / 2, in the form that does not cancel.
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    let place = u * (a + b) / (a + root);
    if a + root > 0.0 {
        place.clamp(0.0, 1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::ONE_MINUS_EPSILON;

    const KINDS: [(FilterKind, f64); 6] = [
        (FilterKind::Box, 0.5),
        (FilterKind::Box, 1.3),
        (FilterKind::Tent, 1.0),
        (FilterKind::Gaussian, 1.5),
        (FilterKind::Mitchell, 2.0),
        (FilterKind::BlackmanHarris, 2.0),
    ];

    fn filters() -> impl Iterator<Item = (FilterKind, Filter)> {
        KINDS.into_iter().map(|(kind, radius)| {
            let filter = Filter::new(&FilterDescription { kind, radius });
            (kind, filter)
        })
    }

    /// The midpoints of `count` equal steps of [0, 1].
    fn midpoints(count: u32) -> impl Iterator<Item = f64> {
        (0..count).map(move |i| (f64::from(i) + 0.5) / f64::from(count))
    }

    #[test]
    fn tabulated_filter_matches_its_profile_and_integrates_to_one() {
        for (kind, filter) in filters() {
            let radius = filter.radius();
            let integral: f64 = midpoints(10_000)
                .map(|t| 2.0 * radius * profile(kind, t))
                .sum::<f64>()
                / 1e4;
            let peak = filter.evaluate_axis(0.0);
            let mut sum = 0.0;
            for t in midpoints(10_000) {
                let value = filter.evaluate_axis(radius * t);
                let exact = profile(kind, t) / integral;
                assert!((value - exact).abs() < 1e-4 * peak, "{kind:?} at {t}");
                assert_eq!(value, filter.evaluate_axis(-radius * t));
                sum += 2.0 * radius * value / 1e4;
            }
            assert!((sum - 1.0).abs() < 1e-7, "{kind:?}: {sum}");
            assert_eq!(filter.evaluate_axis(1.001 * radius), 0.0);
        }
    }

    #[test]
    fn splatting_gain_matches_closed_forms_for_box_and_tent() {
        let gain =
            |kind, radius| Filter::new(&FilterDescription { kind, radius }).gain_of_splatting();
        assert!((gain(FilterKind::Box, 0.5) - 1.0).abs() < 1e-12);
        // Along an axis the square of a tent of radius r integrates to 2 / (3 r).
        assert!((gain(FilterKind::Tent, 1.0) - 2.25).abs() < 1e-12);
        assert!((gain(FilterKind::Tent, 2.0) - 9.0).abs() < 1e-12);
    }

    /// The integral of |f| over that of f, in one dimension.
    fn excess(filter: &Filter) -> f64 {
        filter.cells[0].weight.into()
    }

    /// Equidistant numbers leave only rounding error: in each bin, the share of the samples, times the excess and the
    /// sign, is the integral of f over the bin, up to 2^-16, one sample, at either end of each of its pieces.
    #[test]
    fn weighted_sample_histogram_matches_the_filter() {
        const SAMPLES: u32 = 1 << 16;
        const BINS: usize = 50;
        for (kind, filter) in filters() {
            let width = 2.0 * filter.radius() / BINS as f64;
            let mut shares = [0.0; BINS];
            for u in midpoints(SAMPLES) {
                let (x, weight) = filter.sample_axis(u as f32);
                let bin = ((f64::from(x) + filter.radius()) / width) as usize;
                shares[bin.min(BINS - 1)] += f64::from(weight) / f64::from(SAMPLES);
            }
            for (bin, share) in shares.into_iter().enumerate() {
                let integral: f64 = midpoints(1000)
                    .map(|t| filter.evaluate_axis((bin as f64 + t) * width - filter.radius()))
                    .sum::<f64>()
                    * width
                    / 1000.0;
                let bound = 5.0 / f64::from(SAMPLES) + 1e-6;
                assert!(
                    (share - integral).abs() < bound,
                    "{kind:?}, bin {bin}: {share} {integral}"
                );
            }
        }
    }

    #[test]
    fn weights_are_one_or_average_to_one_with_negative_lobes() {
        for (kind, filter) in filters() {
            let weights: Vec<f64> = midpoints(1 << 16)
                .map(|u| filter.sample_axis(u as f32).1.into())
                .collect();
            if kind == FilterKind::Mitchell {
                let mean = weights.iter().sum::<f64>() / weights.len() as f64;
                // Two changes of sign on either side, each at one of 65536 samples.
                assert!(
                    (mean - 1.0).abs() < 4.0 * 2.0 * excess(&filter) / 65536.0,
                    "{mean}"
                );
                assert!(
                    excess(&filter) > 1.0 && weights.iter().all(|w| w.abs() == excess(&filter))
                );
            } else {
                assert!(weights.iter().all(|&weight| weight == 1.0), "{kind:?}");
            }
        }
    }

    #[test]
    fn sample_mapping_is_monotone_symmetric_and_within_the_radius() {
        for (_, filter) in filters() {
            let radius = filter.radius() as f32;
            let sample = |u| filter.sample(Vec2::splat(u)).offset.x;
            assert_eq!(sample(0.0), -radius);
            assert_eq!(sample(0.5), 0.0);
            let last = sample(ONE_MINUS_EPSILON);
            assert!(last > 0.9 * radius && last <= radius);
            let mut before = -radius;
            for i in 0..=4096_u32 {
                let u = (i as f32 / 4096.0).min(ONE_MINUS_EPSILON);
                let x = sample(u);
                assert!(x >= before && x <= radius);
                before = x;
                if i > 0 && i < 4096 {
                    assert_eq!(x, -sample(1.0 - u));
                }
            }
        }
    }

    #[test]
    fn lane_samples_equal_single_samples() {
        for (kind, filter) in filters() {
            for turn in 0..200 {
                let u = |i: usize| (0.618_034 * (i + 16 * turn) as f32).fract();
                let u = [1, 3].map(|step| std::array::from_fn(|lane| u(step * lane + step)));
                let ([x, y], weights) = filter.sample_lanes(&u);
                for lane in 0..LANES {
                    let alone = filter.sample(Vec2::new(u[0][lane], u[1][lane]));
                    let offset = Vec2::new(x[lane], y[lane]);
                    let weight = weights[lane];
                    assert_eq!(FilterSample { offset, weight }, alone, "{kind:?}");
                }
            }
        }
    }

    #[test]
    fn sample_weight_is_the_filter_value_over_the_2d_pdf() {
        for (_, filter) in filters() {
            let sample = filter.sample(Vec2::new(0.02, 0.6));
            let density = f64::from(filter.evaluate(sample.offset).abs()) / excess(&filter).powi(2);
            let expected = filter.evaluate(sample.offset) / density as f32;
            assert!((sample.weight - expected).abs() < 1e-5);
        }
    }
}
