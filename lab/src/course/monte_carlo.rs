//! Monte Carlo integration: plain, stratified, and with importance sampling.
//!
//! Measure: that of the integrand; the domain is the unit cube, or the support of a density.
//! Range: any dimension from 1. Variances fall as 1/N for plain and importance sampling; jittered sampling gains a
//! further factor of N^(-2/d) for smooth integrands, or N^(-1/d) for those with an edge. No stratified variance is
//! above the plain one with as many calls, except for a factor of N / (N - 1) with Latin hypercubes.
//! Source: Owen, "Monte Carlo Theory, Methods and Examples", chapters 2 and 8 to 10; McKay, Beckman and Conover 1979
//! for Latin hypercubes, their bound by Owen 1997. Tested in `lab/tests/course/integration.rs`.

use super::grid::Grid;
use super::quadrature::CubatureResult;
use crate::planted::planted;
use etendue::internals::math::stats::Moments;

/// The mean of f at uniform points of the unit cube, with the moments for its standard error.
pub fn integrate_plain(
    f: impl Fn(&[f64]) -> f64,
    dimension: u32,
    calls: usize,
    uniform: &mut impl FnMut() -> f64,
) -> Moments {
    let mut at = vec![0.0; dimension as usize];
    Moments::of((0..calls).map(|_| {
        at.fill_with(&mut *uniform);
        f(&at)
    }))
}

/// Stratified sampling: jittered if `calls` allows a grid of two cells along each axis, else a Latin hypercube. One run
/// gives no error estimate; several do. `None` without calls or dimensions.
pub fn integrate_stratified(
    f: impl Fn(&[f64]) -> f64,
    dimension: u32,
    calls: usize,
    uniform: &mut impl FnMut() -> f64,
) -> Option<CubatureResult> {
    match Grid::of_calls(calls, dimension, 2) {
        Some(grid) => Some(jitter(f, grid, uniform)),
        None => integrate_latin_hypercube(f, dimension, calls, uniform),
    }
}

/// Jittered sampling: one uniform point in each cell of the finest grid of at most `calls` cells; `None` without calls
/// or dimensions.
pub fn integrate_jittered(
    f: impl Fn(&[f64]) -> f64,
    dimension: u32,
    calls: usize,
    uniform: &mut impl FnMut() -> f64,
) -> Option<CubatureResult> {
    let grid = Grid::of_calls(calls, dimension, 1)?;
    Some(jitter(f, grid, uniform))
}

fn jitter(
    f: impl Fn(&[f64]) -> f64,
    grid: Grid,
    uniform: &mut impl FnMut() -> f64,
) -> CubatureResult {
    let (per_axis, calls) = (grid.per_axis() as f64, grid.count());
    let mut at = vec![0.0; grid.dimension()];
    let sum = grid.sum(|cell| {
        for (x, &i) in at.iter_mut().zip(cell) {
            *x = (i as f64 + uniform()) / per_axis;
        }
        f(&at)
    });
    CubatureResult {
        value: sum / calls as f64,
        calls,
    }
}

/// Latin hypercube sampling: along each axis one point in each of `calls` intervals, which are matched at random.
/// `None` without calls or dimensions.
pub fn integrate_latin_hypercube(
    f: impl Fn(&[f64]) -> f64,
    dimension: u32,
    calls: usize,
    uniform: &mut impl FnMut() -> f64,
) -> Option<CubatureResult> {
    if calls == 0 || dimension == 0 {
        return None;
    }
    let intervals: Vec<Vec<usize>> = (0..dimension).map(|_| shuffled(calls, uniform)).collect();
    let mut at = vec![0.0; dimension as usize];
    let mut sum = 0.0;
    for call in 0..calls {
        for (x, axis) in at.iter_mut().zip(&intervals) {
            *x = (axis[call] as f64 + uniform()) / calls as f64;
        }
        sum += f(&at);
    }
    Some(CubatureResult {
        value: sum / calls as f64,
        calls,
    })
}

/// A random permutation of the numbers below `count` (Fisher and Yates).
fn shuffled(count: usize, uniform: &mut impl FnMut() -> f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        let choices = planted!("shuffle-in-one-cycle", last, last + 1);
        let other = (uniform() * choices as f64) as usize;
        order.swap(last, other.min(last));
    }
    order
}

/// Importance sampling: the mean of f / p over points that `draw` returns with their densities p.
///
/// Where f is 0 the ratio is 0. A density of 0 where f is not 0 gives an infinite mean: it cannot sample f.
pub fn integrate_importance<X>(
    f: impl Fn(&X) -> f64,
    calls: usize,
    mut draw: impl FnMut() -> (X, f64),
) -> Moments {
    Moments::of((0..calls).map(|_| {
        let (x, pdf) = draw();
        let value = f(&x);
        if value == 0.0 { 0.0 } else { value / pdf }
    }))
}
