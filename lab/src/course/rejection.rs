//! Rejection sampling: random points of a box until one lies inside a set, or under the graph of a density.
//!
//! Measure: the fraction of the box that the set or the density fills is the efficiency, a probability; 1 / efficiency
//! is the mean number of trials.
//! Range: any bounded set, any bounded density. Trials are limited: with efficiency e all of T trials fail with
//! probability (1 - e)^T, and for an empty set the result after T trials is `None`.
//! Source: von Neumann 1951, "Various Techniques Used in Connection with Random Digits". Tested in
//! `lab/tests/course/rejection.rs`.

use etendue::internals::math::stats::Moments;

/// Enough trials for sets that fill half of their box: all fail with a probability of 2^-256.
pub const MAX_TRIALS: u32 = 256;

/// An accepted sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accepted<T> {
    /// The first accepted value.
    pub value: T,
    /// Number of trials, including the accepted one.
    pub trials: u32,
}

/// The reason why no sample of a density was drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RejectionFailure<const D: usize> {
    /// None of the trials was accepted.
    All,
    /// At this point the density was negative, above its bound, or NaN: samples would not follow it.
    OutOfBounds([f64; D]),
}

/// A box of D dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingBox<const D: usize> {
    min: [f64; D],
    max: [f64; D],
}

impl<const D: usize> BoundingBox<D> {
    /// The box between two corners; `None` if an edge is negative or not finite.
    pub fn new(min: [f64; D], max: [f64; D]) -> Option<Self> {
        let is_valid = min.iter().zip(&max).all(|(a, b)| {
            let edge = b - a;
            edge >= 0.0 && edge.is_finite()
        });
        is_valid.then_some(Self { min, max })
    }

    /// The volume: length or area in one or two dimensions.
    pub fn volume(&self) -> f64 {
        self.min.iter().zip(&self.max).map(|(a, b)| b - a).product()
    }

    /// Maps D uniform numbers to a point of the box.
    pub fn sample(&self, u: [f64; D]) -> [f64; D] {
        std::array::from_fn(|i| (1.0 - u[i]) * self.min[i] + u[i] * self.max[i])
    }
}

/// Proposes values until one is accepted, at most `most_trials` times.
pub fn sample_until<T>(
    most_trials: u32,
    mut propose: impl FnMut() -> Option<T>,
) -> Option<Accepted<T>> {
    (1..=most_trials).find_map(|trials| propose().map(|value| Accepted { value, trials }))
}

/// A uniform point of the set inside the box; `None` if none of the trials lay inside.
pub fn sample_inside<const D: usize>(
    bounds: &BoundingBox<D>,
    inside: impl Fn(&[f64; D]) -> bool,
    most_trials: u32,
    uniform: &mut impl FnMut() -> f64,
) -> Option<Accepted<[f64; D]>> {
    sample_until(most_trials, || {
        let point = bounds.sample(std::array::from_fn(|_| uniform()));
        inside(&point).then_some(point)
    })
}

/// A point of the box with a density proportional to `density`, which is at most `bound`: a uniform point under its
/// graph.
///
/// The efficiency is the density's mean over the box, divided by the bound.
pub fn sample_density<const D: usize>(
    bounds: &BoundingBox<D>,
    density: impl Fn(&[f64; D]) -> f64,
    bound: f64,
    most_trials: u32,
    uniform: &mut impl FnMut() -> f64,
) -> Result<Accepted<[f64; D]>, RejectionFailure<D>> {
    let drawn = sample_until(most_trials, || {
        let point = bounds.sample(std::array::from_fn(|_| uniform()));
        let height = density(&point);
        if !(0.0..=bound).contains(&height) {
            return Some(Err(RejectionFailure::OutOfBounds(point)));
        }
        (bound * uniform() < height).then_some(Ok(point))
    });
    let Some(Accepted { value, trials }) = drawn else {
        return Err(RejectionFailure::All);
    };
    value.map(|value| Accepted { value, trials })
}

/// Measures the efficiency: the fraction of `trials` points of the box that lie inside, as moments of numbers 0 and 1.
/// Times the box's volume it estimates that of the set.
pub fn measure_efficiency<const D: usize>(
    bounds: &BoundingBox<D>,
    inside: impl Fn(&[f64; D]) -> bool,
    trials: usize,
    uniform: &mut impl FnMut() -> f64,
) -> Moments {
    Moments::of((0..trials).map(|_| {
        let point = bounds.sample(std::array::from_fn(|_| uniform()));
        f64::from(u8::from(inside(&point)))
    }))
}
