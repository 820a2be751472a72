//! Functions on the unit cube of any dimension whose integrals and variances are known: tests for quadrature and Monte
//! Carlo integration.
//!
//! Measure: none; the cube has the volume 1.
//! Range: dimensions from 1 to 12. From about 20 on, the integral of [`Integrand::HalfSpace`] loses digits to
//! cancellation.
//! Source: products and sums by Fubini; the ball's volume by its recurrence; the half space by Hall 1927, "The
//! Distribution of Means for Samples of Size N Drawn from a Population in which the Variate Takes Values Between 0 and
//! 1". Tested in `lab/tests/course/integration.rs`.

use std::f64::consts::{E, FRAC_PI_2, PI};

/// A function on the unit cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrand {
    /// The product of pi / 2 sin(pi x): smooth, with its maximum in the middle. Its integral is 1.
    Sine,
    /// The product of e^x / (e - 1): smooth, steepest towards one corner. Its integral is 1.
    Exponential,
    /// The mean of 3 x^2 over the coordinates: smooth, and a sum, so that each axis can be stratified independently.
    /// Its integral is 1.
    Squares,
    /// 1 within the unit ball about a corner, else 0; in one dimension 1 everywhere.
    Ball,
    /// 1 where the coordinates sum to less than d / 2 + 1 / 4, else 0: a slanted edge that cuts off about half of the
    /// volume in every dimension.
    HalfSpace,
}

impl Integrand {
    /// All integrands.
    pub const ALL: [Self; 5] = [
        Self::Sine,
        Self::Exponential,
        Self::Squares,
        Self::Ball,
        Self::HalfSpace,
    ];

    /// The value at a point `x`, whose length is the dimension.
    pub fn eval(self, x: &[f64]) -> f64 {
        let indicator = |is_inside: bool| f64::from(u8::from(is_inside));
        match self {
            Self::Sine => x.iter().map(|x| FRAC_PI_2 * (PI * x).sin()).product(),
            Self::Exponential => x.iter().map(|x| x.exp() / (E - 1.0)).product(),
            Self::Squares => 3.0 / x.len() as f64 * x.iter().map(|x| x * x).sum::<f64>(),
            Self::Ball => indicator(x.iter().map(|x| x * x).sum::<f64>() <= 1.0),
            Self::HalfSpace => indicator(x.iter().sum::<f64>() < half_space_bound(x.len() as u32)),
        }
    }

    /// The exact integral over the cube.
    pub fn integral(self, dimension: u32) -> f64 {
        match self {
            Self::Sine | Self::Exponential | Self::Squares => 1.0,
            Self::Ball => ball_in_corner(dimension),
            Self::HalfSpace => irwin_hall(dimension, half_space_bound(dimension)),
        }
    }

    /// The exact variance at uniform points: that of plain Monte Carlo with one sample.
    pub fn variance(self, dimension: u32) -> f64 {
        let d = dimension as i32;
        match self {
            Self::Sine => (PI * PI / 8.0).powi(d) - 1.0,
            Self::Exponential => (0.5 * (E + 1.0) / (E - 1.0)).powi(d) - 1.0,
            Self::Squares => 0.8 / f64::from(dimension),
            Self::Ball | Self::HalfSpace => {
                let share = self.integral(dimension);
                share * (1.0 - share)
            }
        }
    }

    /// Whether all derivatives exist everywhere; the other integrands are discontinuous.
    pub fn is_smooth(self) -> bool {
        !matches!(self, Self::Ball | Self::HalfSpace)
    }
}

/// The volume of the part of the unit ball that lies in one orthant: V_d / 2^d, where V_d = V_(d-2) 2 pi / d.
fn ball_in_corner(dimension: u32) -> f64 {
    match dimension {
        0 | 1 => 1.0,
        d => ball_in_corner(d - 2) * FRAC_PI_2 / f64::from(d),
    }
}

fn half_space_bound(dimension: u32) -> f64 {
    0.5 * f64::from(dimension) + 0.25
}

/// The probability that the sum of d uniform numbers is below t: sum over k <= t of (-1)^k (d over k) (t - k)^d / d!.
fn irwin_hall(dimension: u32, t: f64) -> f64 {
    let d = f64::from(dimension);
    let factorial: f64 = (1..=dimension).map(f64::from).product();
    let mut binomial = 1.0;
    let mut sum = 0.0;
    for k in (0..=dimension).map(f64::from).take_while(|&k| k < t) {
        sum += binomial * (t - k).powi(dimension as i32);
        binomial *= -(d - k) / (k + 1.0);
    }
    sum / factorial
}
