//! An image with one channel, with means and extrema over squares of pixels.
//!
//! Measure: that of the values.
//! Range: at least one pixel. Squares are cut off at the border; [`Plane::at`] continues the border beyond it.
//! Source: none needed. Tested below.

/// An image with one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// The width in pixels.
    pub width: usize,
    /// The height in pixels.
    pub height: usize,
    /// The values, row by row.
    pub values: Vec<f32>,
}

impl Plane {
    /// Builds a plane with this value everywhere.
    pub fn filled(width: usize, height: usize, value: f32) -> Self {
        Self {
            width,
            height,
            values: vec![value; width * height],
        }
    }

    /// Builds a plane from its values, row by row.
    pub fn new(width: usize, height: usize, values: Vec<f32>) -> Self {
        debug_assert_eq!(values.len(), width * height);
        Self {
            width,
            height,
            values,
        }
    }

    /// Builds a plane of the same size, with values computed from each pixel's index.
    pub fn like(&self, value: impl Fn(usize) -> f32) -> Self {
        Self {
            width: self.width,
            height: self.height,
            values: (0..self.values.len()).map(value).collect(),
        }
    }

    /// The quotient of each pixel and that of another plane of the same size.
    pub fn divided_by(&self, other: &Self) -> Self {
        self.like(|index| self.values[index] / other.values[index])
    }

    /// The value at a position that may lie beyond the border.
    pub fn at(&self, x: isize, y: isize) -> f32 {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        self.values[y * self.width + x]
    }

    /// The mean over the square of `2 radius + 1` pixels a side about each pixel, or the part of it that lies within
    /// the plane.
    pub fn box_mean(&self, radius: usize) -> Self {
        let mut means = self.box_fold(radius, |a, b| a + b);
        let columns = (0..self.width).map(|x| extent(x, self.width, radius) as f32);
        let columns: Vec<f32> = columns.collect();
        for (y, row) in means.values.chunks_exact_mut(self.width).enumerate() {
            let rows = extent(y, self.height, radius) as f32;
            for (value, columns) in row.iter_mut().zip(&columns) {
                *value /= rows * columns;
            }
        }
        means
    }

    /// The mean over the square of [`box_mean`](Self::box_mean) without the pixel itself; the pixel's own value where
    /// the plane has no other.
    pub fn mean_of_others(&self, radius: usize) -> Self {
        // Subtracting the pixel from the sum would leave only rounding error for a pixel much brighter than all
        // others.
        let sums = self.punctured_sums(radius);
        self.like(
            |index| match square_size(index, self.width, self.height, radius) {
                1 => self.values[index],
                size => sums[index] / (size - 1) as f32,
            },
        )
    }

    /// The mean over the pixels more than `inner` and at most `outer` rows or columns away; the pixel's own value where the
    /// plane has none of them.
    pub fn mean_around(&self, inner: usize, outer: usize) -> Self {
        if inner == 0 {
            return self.mean_of_others(outer);
        }
        self.like(|index| {
            let (x, y) = (index % self.width, index / self.width);
            let (mut sum, mut count) = (0.0, 0);
            // Term by term: a difference of two sums would leave only rounding error next to a much brighter pixel.
            for row in y.saturating_sub(outer)..(y + outer + 1).min(self.height) {
                for column in x.saturating_sub(outer)..(x + outer + 1).min(self.width) {
                    if row.abs_diff(y) > inner || column.abs_diff(x) > inner {
                        sum += self.values[row * self.width + column];
                        count += 1;
                    }
                }
            }
            match count {
                0 => self.values[index],
                count => sum / count as f32,
            }
        })
    }

    /// The minimum over the square of `2 radius + 1` pixels a side about each pixel.
    pub fn box_min(&self, radius: usize) -> Self {
        self.box_fold(radius, f32::min)
    }

    /// Combines the values of the square about each pixel, first down the columns, then along the rows.
    fn box_fold(&self, radius: usize, combine: impl Fn(f32, f32) -> f32) -> Self {
        let columns = self.fold_columns(radius, &combine);
        let mut values = Vec::with_capacity(columns.len());
        for row in columns.chunks_exact(self.width) {
            fold_row(row, radius, &combine, &mut values);
        }
        Self { values, ..*self }
    }

    /// Combines the values up to `radius` rows above and below each pixel.
    fn fold_columns(&self, radius: usize, combine: &impl Fn(f32, f32) -> f32) -> Vec<f32> {
        let mut folded = Vec::with_capacity(self.values.len());
        for y in 0..self.height {
            let rows = y.saturating_sub(radius)..(y + radius + 1).min(self.height);
            let start = folded.len();
            folded.extend_from_slice(self.row(rows.start));
            for other in rows.start + 1..rows.end {
                for (sum, &x) in folded[start..].iter_mut().zip(self.row(other)) {
                    *sum = combine(*sum, x);
                }
            }
        }
        folded
    }

    /// The sums over the square about each pixel, without the pixel: the columns to either side, and the pixels above
    /// and below it.
    fn punctured_sums(&self, radius: usize) -> Vec<f32> {
        let add = |a, b| a + b;
        let columns = self.fold_columns(radius, &add);
        let mut sums = Vec::with_capacity(self.values.len());
        for (y, columns) in columns.chunks_exact(self.width).enumerate() {
            let above = y.saturating_sub(radius)..y;
            let below = y + 1..(y + radius + 1).min(self.height);
            for x in 0..self.width {
                let own_column: f32 = above
                    .clone()
                    .chain(below.clone())
                    .map(|row| self.values[row * self.width + x])
                    .sum();
                let left = &columns[x.saturating_sub(radius)..x];
                let right = &columns[x + 1..(x + radius + 1).min(self.width)];
                sums.push(left.iter().chain(right).sum::<f32>() + own_column);
            }
        }
        sums
    }

    fn row(&self, y: usize) -> &[f32] {
        &self.values[y * self.width..][..self.width]
    }
}

/// Combines the values up to `radius` pixels to either side of each pixel of a row.
fn fold_row(row: &[f32], radius: usize, combine: &impl Fn(f32, f32) -> f32, folded: &mut Vec<f32>) {
    let start = folded.len();
    folded.extend_from_slice(row);
    let folded = &mut folded[start..];
    for offset in 1..=radius.min(row.len() - 1) {
        let rest = row.len() - offset;
        for (sum, &x) in folded[..rest].iter_mut().zip(&row[offset..]) {
            *sum = combine(*sum, x);
        }
        for (sum, &x) in folded[offset..].iter_mut().zip(&row[..rest]) {
            *sum = combine(*sum, x);
        }
    }
}

/// The number of pixels within the plane of the square of this radius about a pixel.
fn square_size(index: usize, width: usize, height: usize, radius: usize) -> usize {
    extent(index % width, width, radius) * extent(index / width, height, radius)
}

/// The number of pixels within a row or column of this length at most `radius` away from the one at `at`.
fn extent(at: usize, length: usize, radius: usize) -> usize {
    (at + radius + 1).min(length) - at.saturating_sub(radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_mean_averages_only_pixels_inside_the_plane() {
        let plane = Plane::new(3, 2, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let mean = plane.box_mean(1);
        assert_eq!(mean.values, [3.0, 3.5, 4.0, 3.0, 3.5, 4.0]);
        assert_eq!(plane.box_mean(0), plane);
        assert_eq!(plane.box_mean(9).values, [3.5; 6]);
    }

    #[test]
    fn mean_of_others_excludes_the_centre_pixel() {
        let (width, height) = (7, 5);
        let values: Vec<f32> = (0..35).map(|i| ((i * i) % 11) as f32).collect();
        let plane = Plane::new(width, height, values);
        for radius in [1, 3, 9] {
            let others = plane.mean_of_others(radius);
            for index in 0..plane.values.len() {
                let mut bright = plane.clone();
                bright.values[index] = 1e30;
                let (x, y) = (index % width, index / width);
                let near = |i: &usize| {
                    (i % width).abs_diff(x) <= radius && (i / width).abs_diff(y) <= radius
                };
                let around: Vec<f32> = (0..35)
                    .filter(|i| *i != index)
                    .filter(near)
                    .map(|i| plane.values[i])
                    .collect();
                let expected = around.iter().sum::<f32>() / around.len() as f32;
                assert!((others.values[index] - expected).abs() < 1e-5);
                assert_eq!(
                    bright.mean_of_others(radius).values[index],
                    others.values[index]
                );
            }
        }
        let alone = Plane::new(1, 1, vec![4.0]);
        assert_eq!(alone.mean_of_others(3), alone);
    }

    #[test]
    fn box_min_covers_only_pixels_inside_the_plane() {
        let plane = Plane::new(4, 2, vec![4.0, 9.0, 9.0, 3.0, 5.0, 9.0, 9.0, 9.0]);
        let least = plane.box_min(1);
        assert_eq!(least.values, [4.0, 4.0, 3.0, 3.0, 4.0, 4.0, 3.0, 3.0]);
        assert_eq!(plane.box_min(8).values, [3.0; 8]);
    }

    #[test]
    fn lookups_beyond_the_border_are_clamped() {
        let plane = Plane::new(2, 2, vec![1.0, 2.0, 3.0, 4.0]);
        assert_eq!(
            [plane.at(-3, 0), plane.at(5, 5), plane.at(1, 0)],
            [1.0, 4.0, 2.0]
        );
    }
}
