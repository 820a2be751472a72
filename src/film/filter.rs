//! Reconstruction filters, by importance sampling: a sample's place is drawn from the filter around its pixel, so that
//! it belongs to that pixel alone.
//!
//! Measure: pixels from the pixel's centre.
//! Range: a radius above 0; u in [0, 1 - 2^-24].
//! Source: Ernst, Stamminger and Greiner 2006, "Filter Importance Sampling"; Mitchell and Netravali 1988; Harris 1978
//! for the window. Tested below and in `tests/sampling.rs`.

use crate::math::vec::Vec2;
use std::f64::consts::PI;

/// The shapes of reconstruction filters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilterKind {
    /// Constant.
    Box,
    /// Linear to zero.
    Tent,
    /// A Gaussian of standard deviation radius / 3, lowered to reach zero at the radius.
    Gaussian,
    /// Mitchell and Netravali with B = C = 1/3: has negative lobes.
    Mitchell,
    /// The four-term Blackman-Harris window.
    BlackmanHarris,
}

impl FilterKind {
    /// Every filter, by its name in scenes.
    pub const ALL: &'static [(&'static str, Self)] = &[
        ("box", Self::Box),
        ("tent", Self::Tent),
        ("gaussian", Self::Gaussian),
        ("mitchell", Self::Mitchell),
        ("blackman-harris", Self::BlackmanHarris),
    ];

    /// The radius that is used unless another one is written, in pixels.
    pub fn default_radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
        }
    }

    /// The filter's value at `x` in [-1, 1] of its radius, up to a factor.
    fn profile(self, x: f64) -> f64 {
        let x = x.abs();
        match self {
            Self::Box => 1.0,
            Self::Tent => 1.0 - x,
            Self::Gaussian => {
                let gaussian = |x: f64| (-4.5 * x * x).exp();
                gaussian(x) - gaussian(1.0)
            }
            Self::Mitchell => mitchell(2.0 * x),
            Self::BlackmanHarris => {
                let phase = PI * (1.0 + x);
                let cosine = |k: f64| (k * phase).cos();
                0.35875 - 0.48829 * cosine(1.0) + 0.14128 * cosine(2.0) - 0.01168 * cosine(3.0)
            }
        }
    }
}

/// Mitchell and Netravali's eq. 8 for B = C = 1/3, on [0, 2].
fn mitchell(x: f64) -> f64 {
    if x < 1.0 {
        (7.0 * x - 12.0) * x * x + 16.0 / 3.0
    } else {
        ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0
    }
}

/// A reconstruction filter: a kind and its radius in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterDescription {
    /// The shape.
    pub kind: FilterKind,
    /// Half the width of the support, in pixels, above 0.
    pub radius: f64,
}

/// A place on the film for one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterSample {
    /// From the pixel's centre, in pixels.
    pub offset: Vec2,
    /// The filter over the density of the place: exactly 1 for filters without negative lobes, 1 on average for others.
    pub weight: f32,
}

/// A filter, ready to be sampled: the product of the same function of x and of y.
#[derive(Debug, Clone)]
pub struct Filter {
    radius: f64,
    kind: FilterKind,
    /// The integral of the profile over [-1, 1].
    integral: f64,
    /// Equal shares of the integral of |profile|: entry i is where i / CELLS of it lie to the left.
    quantiles: Vec<f32>,
    /// What a sample weighs, but for its sign: the integral of |profile| over that of the profile.
    scale: f32,
}

/// Cells of the table of quantiles, and steps of the integration.
const CELLS: usize = 1024;
const STEPS: usize = 64 * CELLS;

impl Filter {
    /// Tabulates a filter.
    pub fn new(description: &FilterDescription) -> Self {
        let kind = description.kind;
        let at = |step: usize| (step as f64 + 0.5) / STEPS as f64 * 2.0 - 1.0;
        let width = 2.0 / STEPS as f64;
        let integral = (0..STEPS).map(|i| kind.profile(at(i))).sum::<f64>() * width;
        let absolute = (0..STEPS).map(|i| kind.profile(at(i)).abs()).sum::<f64>() * width;
        let mut quantiles = vec![-1.0; CELLS + 1];
        let (mut cell, mut so_far) = (1, 0.0);
        for step in 0..STEPS {
            let share = kind.profile(at(step)).abs() * width / absolute;
            while cell < CELLS && so_far + share >= cell as f64 / CELLS as f64 {
                let within = (cell as f64 / CELLS as f64 - so_far) / share;
                quantiles[cell] = ((step as f64 + within) / STEPS as f64 * 2.0 - 1.0) as f32;
                cell += 1;
            }
            so_far += share;
        }
        quantiles[CELLS] = 1.0;
        Self {
            radius: description.radius,
            kind,
            integral,
            quantiles,
            scale: (absolute / integral) as f32,
        }
    }

    /// A place for a sample.
    #[inline]
    pub fn sample(&self, u: Vec2) -> FilterSample {
        let (x, weight_x) = self.sample_1d(u.x);
        let (y, weight_y) = self.sample_1d(u.y);
        FilterSample {
            offset: self.radius as f32 * Vec2::new(x, y),
            weight: weight_x * weight_y,
        }
    }

    /// The filter's value at an offset in pixels; its integral is 1.
    pub fn evaluate(&self, offset: Vec2) -> f64 {
        let value = |x: f32| {
            let x = f64::from(x) / self.radius;
            if x.abs() > 1.0 {
                0.0
            } else {
                self.kind.profile(x) / (self.integral * self.radius)
            }
        };
        value(offset.x) * value(offset.y)
    }

    #[inline]
    fn sample_1d(&self, u: f32) -> (f32, f32) {
        let scaled = u * CELLS as f32;
        let cell = (scaled as usize).min(CELLS - 1);
        let (from, to) = (self.quantiles[cell], self.quantiles[cell + 1]);
        let x = from + (scaled - cell as f32) * (to - from);
        let negative = self.kind == FilterKind::Mitchell && x.abs() > MITCHELL_ZERO;
        (x, if negative { -self.scale } else { self.scale })
    }
}

/// Where Mitchell's filter changes its sign, as a share of the radius: the root of its outer cubic in (1, 2), which is
/// 8 / 7, halved.
const MITCHELL_ZERO: f32 = 4.0 / 7.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::ONE_MINUS_EPSILON;

    fn filters() -> impl Iterator<Item = Filter> {
        FilterKind::ALL.iter().map(|&(_, kind)| {
            Filter::new(&FilterDescription {
                kind,
                radius: kind.default_radius(),
            })
        })
    }

    #[test]
    fn mitchell_changes_its_sign_where_it_says() {
        let zero = f64::from(MITCHELL_ZERO);
        assert!(mitchell(2.0 * zero).abs() < 1e-6);
        assert!(mitchell(2.0 * zero - 1e-3) > 0.0 && mitchell(2.0 * zero + 1e-3) < 0.0);
    }

    #[test]
    fn weights_are_one_on_average_and_exactly_one_without_negative_lobes() {
        for filter in filters() {
            let n = 1 << 12;
            let mean = (0..n)
                .map(|i| f64::from(filter.sample_1d((i as f32 + 0.5) / n as f32).1))
                .sum::<f64>()
                / f64::from(n);
            assert!((mean - 1.0).abs() < 1e-3, "{:?} {mean}", filter.kind);
            if filter.kind != FilterKind::Mitchell {
                assert_eq!(
                    filter.sample(Vec2::new(0.3, 0.9)).weight,
                    1.0,
                    "{:?}",
                    filter.kind
                );
            }
        }
    }

    #[test]
    fn places_follow_the_filter() {
        // The mean of |x| and of x^2 under the filter, by quadrature and by samples.
        for filter in filters() {
            let n = 1 << 16;
            let grid = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
            for moment in [1, 2] {
                let sampled = (0..n)
                    .map(|i| {
                        let (x, weight) = filter.sample_1d(grid(i) as f32);
                        f64::from(x).abs().powi(moment) * f64::from(weight)
                    })
                    .sum::<f64>()
                    / f64::from(n);
                let exact = (0..n)
                    .map(|i| {
                        let x = 2.0 * grid(i) - 1.0;
                        x.abs().powi(moment) * filter.kind.profile(x) / filter.integral
                    })
                    .sum::<f64>()
                    * 2.0
                    / f64::from(n);
                assert!(
                    (sampled - exact).abs() < 1e-3,
                    "{:?}: {sampled} {exact}",
                    filter.kind
                );
            }
        }
    }

    #[test]
    fn places_stay_within_the_radius_and_the_integral_is_one() {
        for filter in filters() {
            for u in [0.0, 0.5, ONE_MINUS_EPSILON] {
                let offset = filter
                    .sample(Vec2::new(u, 1.0 - u.max(f32::EPSILON)))
                    .offset;
                assert!(offset.abs().max_element() <= filter.radius as f32);
            }
            let n = 200;
            let step = 2.0 * filter.radius / f64::from(n);
            let at = |i: i32| (-filter.radius + (f64::from(i) + 0.5) * step) as f32;
            let integral: f64 = (0..n)
                .flat_map(|i| (0..n).map(move |j| (i, j)))
                .map(|(i, j)| filter.evaluate(Vec2::new(at(i), at(j))) * step * step)
                .sum();
            assert!(
                (integral - 1.0).abs() < 1e-3,
                "{:?} {integral}",
                filter.kind
            );
        }
    }
}
