//! A tabulated density: samples of a function, interpolated linearly and inverted exactly.
//!
//! Measure: densities per unit of x.
//! Range: at least two values, each at least 0 and finite, over a finite range; u in [0, 1). Outside the range the
//! density is 0. Where the function is 0 at a node, rounding may return the node itself, at density 0.
//! Source: inversion of the distribution function: first the piece, by [`Piecewise1d`], then the root of a quadratic.
//! Tested in `lab/tests/course/inversion.rs`.

use etendue::internals::sampling::piecewise::Piecewise1d;

/// A density proportional to a polyline over equally spaced nodes.
#[derive(Debug, Clone)]
pub struct PiecewiseLinear {
    range: [f64; 2],
    values: Vec<f64>,
    /// The distribution of the pieces, by their areas.
    pieces: Piecewise1d,
}

/// A position on the polyline.
struct SegmentPlace {
    piece: usize,
    /// Position within the piece, from 0 to 1.
    offset: f64,
}

impl PiecewiseLinear {
    /// The density with these values at nodes from one end of the range to the other. `None` if there are fewer than
    /// two, one is negative or not finite, all are 0, or the range is empty or not finite.
    pub fn new(range: [f64; 2], values: &[f64]) -> Option<Self> {
        let width = range[1] - range[0];
        let is_valid =
            width > 0.0 && width.is_finite() && values.iter().all(|&v| v >= 0.0 && v.is_finite());
        let greatest = values.iter().copied().fold(0.0, f64::max);
        if !is_valid || greatest == 0.0 {
            return None;
        }
        // Divided by the greatest, so that no area underflows or overflows.
        let values: Vec<f64> = values.iter().map(|v| v / greatest).collect();
        let areas: Vec<f64> = values
            .windows(2)
            .map(|ends| mean(ends[0], ends[1]))
            .collect();
        Some(Self {
            range,
            pieces: Piecewise1d::new(&areas)?,
            values,
        })
    }

    /// The density of a function sampled at the ends of `pieces` equal pieces of the range; `None` as for
    /// [`new`](Self::new).
    pub fn tabulate(f: impl Fn(f64) -> f64, range: [f64; 2], pieces: usize) -> Option<Self> {
        let node = |i: usize| {
            let at = i as f64 / pieces as f64;
            (1.0 - at) * range[0] + at * range[1]
        };
        let values: Vec<f64> = (0..=pieces).map(|i| f(node(i))).collect();
        Self::new(range, &values)
    }

    /// The x for a uniform number, which increases with u.
    pub fn sample(&self, u: f64) -> f64 {
        let found = self.pieces.sample(u);
        let offset = sample_linear(found.offset, self.ends(found.piece));
        let at = (found.piece as f64 + offset) / self.count() as f64;
        // Interpolating between the ends, instead of stepping from the start, stays within the range.
        ((1.0 - at) * self.range[0] + at * self.range[1]).clamp(self.range[0], self.range[1])
    }

    /// The density at `x`.
    pub fn pdf(&self, x: f64) -> f64 {
        let Some(place) = self.place(x) else {
            return 0.0;
        };
        let probability = self.pieces.pmf(place.piece);
        if probability == 0.0 {
            return 0.0;
        }
        let [a, b] = self.ends(place.piece);
        let in_piece = (a + place.offset * (b - a)) / mean(a, b);
        let width = (self.range[1] - self.range[0]) / self.count() as f64;
        probability * in_piece / width
    }

    /// The u that [`sample`](Self::sample) maps to `x`: the distribution function, 0 below the range and 1 above it.
    pub fn invert(&self, x: f64) -> f64 {
        let Some(place) = self.place(x) else {
            return if x < self.range[0] { 0.0 } else { 1.0 };
        };
        let share = invert_linear(place.offset, self.ends(place.piece));
        self.pieces
            .invert((place.piece as f64 + share) / self.count() as f64)
    }

    fn count(&self) -> usize {
        self.values.len() - 1
    }

    /// The values at both ends of a piece.
    fn ends(&self, piece: usize) -> [f64; 2] {
        [self.values[piece], self.values[piece + 1]]
    }

    /// The position of `x` on the polyline; `None` outside the range.
    fn place(&self, x: f64) -> Option<SegmentPlace> {
        let [a, b] = self.range;
        (a..=b).contains(&x).then(|| {
            let at = (x - a) / (b - a) * self.count() as f64;
            let piece = (at as usize).min(self.count() - 1);
            SegmentPlace {
                piece,
                offset: at - piece as f64,
            }
        })
    }
}

fn mean(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}

/// The x in [0, 1] up to which a line from a to b has the fraction `u` of its area: a x + (b - a) x^2 / 2 = u (a + b) /
/// 2, by the root without cancellation where a and b are close.
fn sample_linear(u: f64, [a, b]: [f64; 2]) -> f64 {
    // Scaled, since squares of tiny numbers underflow.
    let greatest = a.max(b);
    let (a, b) = (a / greatest, b / greatest);
    let divisor = a + (a * a + u * ((b - a) * (b + a))).sqrt();
    // On a line that starts at 0, u = 0 is x = 0.
    if divisor > 0.0 {
        (u * (a + b) / divisor).min(1.0)
    } else {
        0.0
    }
}

/// The fraction of the area under a line from a to b that lies below x in [0, 1].
fn invert_linear(x: f64, [a, b]: [f64; 2]) -> f64 {
    let area = mean(a, b);
    if area > 0.0 {
        x * (a + 0.5 * x * (b - a)) / area
    } else {
        x
    }
}
