//! Distributions that are constant piece by piece, over an interval and over a rectangle.
//!
//! Measure: densities over [0, 1) or [0, 1)^2, of which every piece is an equal part.
//! Range: weights at least 0 and finite, with a positive finite sum; u in [0, 1). A piece of weight 0 is never found,
//! nor is one that is lost beside the sum in double precision: its density is 0 as well.
//! Source: inversion of the distribution function; neighbours in u stay neighbours, so that strata are kept. Tested below.

/// A distribution over [0, 1).
#[derive(Debug, Clone)]
pub struct Piecewise1d {
    /// The sum of all weights before each piece, and of all weights.
    sums: Vec<f64>,
}

impl Piecewise1d {
    /// The distribution of these weights; `None` if one is negative, or their sum is not positive and finite.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let sums = prefix_sums(weights.iter().copied())?;
        is_positive(&sums).then_some(Self { sums })
    }

    /// The place for a uniform number.
    #[inline]
    pub fn sample(&self, u: f64) -> Place {
        Place::find(&self.sums, u)
    }

    /// The density at `x` in [0, 1).
    #[inline]
    pub fn pdf(&self, x: f64) -> f64 {
        let count = self.sums.len() - 1;
        self.pmf(piece_at(x, count)) * count as f64
    }

    /// The probability of a piece.
    #[inline]
    pub fn pmf(&self, piece: usize) -> f64 {
        share(&self.sums, piece)
    }

    /// The u that [`sample`](Self::sample) maps to `x`.
    pub fn invert(&self, x: f64) -> f64 {
        invert(&self.sums, x)
    }
}

/// A distribution over [0, 1)^2: first the row, then the column in it.
#[derive(Debug, Clone)]
pub struct Piecewise2d {
    rows: Piecewise1d,
    /// The sums of each row, one after the other.
    sums: Vec<f64>,
    width: usize,
}

impl Piecewise2d {
    /// The distribution of these weights, row by row, `width` of them each; `None` as for [`Piecewise1d::new`].
    ///
    /// # Panics
    /// If the last row is not complete, or `width` is 0.
    pub fn new(weights: impl ExactSizeIterator<Item = f64>, width: usize) -> Option<Self> {
        assert_eq!(weights.len() % width, 0, "rows have {width} weights each");
        let height = weights.len() / width;
        let mut weights = weights;
        let mut sums = Vec::with_capacity(height * (width + 1));
        let mut totals = Vec::with_capacity(height);
        for _ in 0..height {
            let row = prefix_sums(weights.by_ref().take(width))?;
            totals.push(row[width]);
            sums.extend(row);
        }
        Some(Self {
            rows: Piecewise1d::new(&totals)?,
            sums,
            width,
        })
    }

    /// The column and the row for two uniform numbers, one for each.
    #[inline]
    pub fn sample(&self, u: [f64; 2]) -> [Place; 2] {
        let row = self.rows.sample(u[1]);
        [Place::find(self.row(row.piece), u[0]), row]
    }

    /// The density at (x, y) in [0, 1)^2.
    #[inline]
    pub fn pdf(&self, [x, y]: [f64; 2]) -> f64 {
        let height = self.rows.sums.len() - 1;
        let pmf = self.pmf(piece_at(x, self.width), piece_at(y, height));
        pmf * (self.width * height) as f64
    }

    /// The probability of the piece in a column of a row.
    #[inline]
    pub fn pmf(&self, column: usize, row: usize) -> f64 {
        let in_rows = self.rows.pmf(row);
        // A row of no weight has no distribution of its own.
        if in_rows > 0.0 {
            in_rows * share(self.row(row), column)
        } else {
            0.0
        }
    }

    /// The sum of all weights.
    pub fn sum(&self) -> f64 {
        self.rows.sums[self.rows.sums.len() - 1]
    }

    /// The u that [`sample`](Self::sample) maps to (x, y), a point of positive density.
    pub fn invert(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let row = self.row(piece_at(y, self.rows.sums.len() - 1));
        [invert(row, x), self.rows.invert(y)]
    }

    #[inline]
    fn row(&self, row: usize) -> &[f64] {
        let stride = self.width + 1;
        &self.sums[row * stride..(row + 1) * stride]
    }
}

/// A place in a distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The piece.
    pub piece: usize,
    /// How far into it, in [0, 1): uniform.
    pub offset: f64,
}

impl Place {
    #[inline]
    fn find(sums: &[f64], u: f64) -> Self {
        let sum = sums[sums.len() - 1];
        let target = (u * sum).min(sum.next_down());
        // The last sum is above the target, the first is not: between them lies a piece of positive weight.
        let piece = sums.partition_point(|&before| before <= target) - 1;
        let (before, after) = (sums[piece], sums[piece + 1]);
        let offset = (target - before) / (after - before);
        Self {
            piece,
            offset: offset.min(1.0_f64.next_down()),
        }
    }
}

/// The sums before each weight, and of all; `None` if a weight is negative or no number.
fn prefix_sums(weights: impl Iterator<Item = f64>) -> Option<Vec<f64>> {
    let mut sums = Vec::with_capacity(weights.size_hint().0 + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for weight in weights {
        if !(weight >= 0.0) {
            return None;
        }
        sum += weight;
        sums.push(sum);
    }
    Some(sums)
}

fn is_positive(sums: &[f64]) -> bool {
    sums.last().is_some_and(|&sum| sum > 0.0 && sum.is_finite())
}

/// The share of a piece: by the sums, as it is found.
#[inline]
fn share(sums: &[f64], piece: usize) -> f64 {
    (sums[piece + 1] - sums[piece]) / sums[sums.len() - 1]
}

#[inline]
fn piece_at(x: f64, count: usize) -> usize {
    ((x * count as f64) as usize).min(count - 1)
}

fn invert(sums: &[f64], x: f64) -> f64 {
    let count = sums.len() - 1;
    let piece = piece_at(x, count);
    let offset = x * count as f64 - piece as f64;
    (sums[piece] + offset * (sums[piece + 1] - sums[piece])) / sums[count]
}
