//! Piecewise-constant distributions, over an interval and over a rectangle.
//!
//! Measure: densities over [0, 1) or [0, 1)^2, divided into pieces of equal size.
//! Range: weights at least 0 and finite, with a positive finite sum; u in [0, 1). A piece of weight 0 is never sampled,
//! nor is one whose weight is rounded away beside the sum in double precision: its density is 0 as well.
//! Source: inversion of the distribution function; neighbours in u stay neighbours, so that strata are kept. Tested below.

/// A piecewise-constant distribution over [0, 1).
#[derive(Debug, Clone)]
pub struct Piecewise1d {
    /// Prefix sums: the sum of all weights before each piece, and of all weights.
    sums: Vec<f64>,
}

impl Piecewise1d {
    /// Creates the distribution of the weights; `None` if one is negative, or their sum is not positive and finite.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let sums = prefix_sums(weights.iter().copied())?;
        is_positive(&sums).then_some(Self { sums })
    }

    /// Samples a place from a uniform number.
    #[inline]
    pub fn sample(&self, u: f64) -> PiecePlace {
        PiecePlace::find(&self.sums, u)
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

/// A piecewise-constant distribution over [0, 1)^2, sampled by row and then by column in the row.
#[derive(Debug, Clone)]
pub struct Piecewise2d {
    rows: Piecewise1d,
    /// The prefix sums of each row, one row after the other.
    sums: Vec<f64>,
    width: usize,
}

impl Piecewise2d {
    /// Creates the distribution of weights in rows of `width`; `None` as for [`Piecewise1d::new`].
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

    /// Samples the column and the row, from one uniform number each.
    #[inline]
    pub fn sample(&self, u: [f64; 2]) -> [PiecePlace; 2] {
        let row = self.rows.sample(u[1]);
        [PiecePlace::find(self.row(row.piece), u[0]), row]
    }

    /// The density at (x, y) in [0, 1)^2.
    #[inline]
    pub fn pdf(&self, [x, y]: [f64; 2]) -> f64 {
        let height = self.rows.sums.len() - 1;
        let pmf = self.pmf(piece_at(x, self.width), piece_at(y, height));
        pmf * (self.width * height) as f64
    }

    /// The probability of the piece at a column and a row.
    #[inline]
    pub fn pmf(&self, column: usize, row: usize) -> f64 {
        let in_rows = self.rows.pmf(row);
        // A row of weight 0 has no distribution of its own.
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

/// A sampled place in a distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PiecePlace {
    /// Index of the piece.
    pub piece: usize,
    /// Offset in the piece, uniform in [0, 1).
    pub offset: f64,
}

impl PiecePlace {
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

/// Computes the sums before each weight, and of all; `None` if a weight is negative or NaN.
fn prefix_sums(weights: impl Iterator<Item = f64>) -> Option<Vec<f64>> {
    let mut sums = Vec::with_capacity(weights.size_hint().0 + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for weight in weights {
        if weight.is_nan() || weight < 0.0 {
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

/// The probability of a piece, from the same sums as sampling uses.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LAST: f64 = 1.0 - 1.0 / 16_777_216.0;

    #[test]
    fn zero_weight_pieces_are_never_sampled() {
        for weights in [
            vec![0.0, 1.0, 0.0],
            vec![0.0, 0.0, 1e-300, 2.0, 0.0, 5e-324, 0.0],
            vec![0.0, 5e-324, 0.0],
            vec![0.0, 1e300, 1e-300, 0.0],
        ] {
            let distribution = Piecewise1d::new(&weights).expect("valid weights");
            let total: f64 = (0..weights.len()).map(|i| distribution.pmf(i)).sum();
            assert!((total - 1.0).abs() < 1e-12, "{weights:?}");
            for i in 0..=1000 {
                let place = distribution.sample((f64::from(i) / 1000.0).min(LAST));
                assert!(weights[place.piece] > 0.0, "{weights:?} {i}");
                assert!(distribution.pmf(place.piece) > 0.0, "{weights:?} {i}");
                assert!((0.0..1.0).contains(&place.offset), "{weights:?} {place:?}");
            }
        }
    }

    #[test]
    fn invalid_weights_are_rejected() {
        for weights in [
            vec![],
            vec![0.0],
            vec![1.0, -1.0, 3.0],
            vec![f64::NAN],
            vec![f64::INFINITY],
        ] {
            assert!(Piecewise1d::new(&weights).is_none(), "{weights:?}");
            let rows = weights.into_iter();
            assert!(Piecewise2d::new(rows, 1).is_none());
        }
    }

    #[test]
    fn sampling_is_monotone_and_proportional_to_weight() {
        let weights = [3.0, 0.0, 1.0, 4.0];
        let distribution = Piecewise1d::new(&weights).expect("valid weights");
        let mut counts = [0; 4];
        let mut before = 0.0;
        for i in 0..800 {
            let place = distribution.sample((f64::from(i) + 0.5) / 800.0);
            counts[place.piece] += 1;
            let x = place.piece as f64 + place.offset;
            assert!(x > before, "the order of u is kept");
            before = x;
        }
        assert_eq!(counts, [300, 0, 100, 400]);
    }

    proptest! {
        #[test]
        fn inversion_recovers_u_and_pdf_matches_weights(
            weights in prop::collection::vec(prop_oneof![Just(0.0), 0.01..10.0_f64], 12),
            u in (0.0..LAST, 0.0..LAST),
        ) {
            let Some(distribution) = Piecewise2d::new(weights.iter().copied(), 4) else {
                prop_assert!(weights.iter().all(|&w| w == 0.0));
                return Ok(());
            };
            let [column, row] = distribution.sample([u.0, u.1]);
            let x = (column.piece as f64 + column.offset) / 4.0;
            let y = (row.piece as f64 + row.offset) / 3.0;
            let back = distribution.invert([x, y]);
            prop_assert!((back[0] - u.0).abs() < 1e-9 && (back[1] - u.1).abs() < 1e-9, "{back:?}");
            let weight = weights[row.piece * 4 + column.piece];
            let expected = 12.0 * weight / weights.iter().sum::<f64>();
            let pmf = distribution.pmf(column.piece, row.piece);
            prop_assert!((12.0 * pmf / expected - 1.0).abs() < 1e-9);
            // On the border between two pieces, rounding may choose the other one.
            if column.offset > 1e-9 && column.offset < 1.0 - 1e-9 && row.offset > 1e-9 && row.offset < 1.0 - 1e-9 {
                prop_assert!((distribution.pdf([x, y]) / expected - 1.0).abs() < 1e-9);
            }
        }
    }
}
