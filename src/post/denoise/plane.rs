//! One number a pixel, and the sums over squares of pixels that filters are made of.
//!
//! Measure: that of the numbers.
//! Range: at least one pixel; beyond the border, pixels are those of the border.
//! Source: none needed. Tested below.

/// One number a pixel, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

impl Plane {
    /// The same number everywhere.
    pub fn filled(width: usize, height: usize, value: f32) -> Self {
        Self {
            width,
            height,
            values: vec![value; width * height],
        }
    }

    /// The numbers row by row.
    pub fn new(width: usize, height: usize, values: Vec<f32>) -> Self {
        debug_assert_eq!(values.len(), width * height);
        Self {
            width,
            height,
            values,
        }
    }

    /// A plane of the same size, from each pixel's index.
    pub fn like(&self, value: impl Fn(usize) -> f32) -> Self {
        Self {
            width: self.width,
            height: self.height,
            values: (0..self.values.len()).map(value).collect(),
        }
    }

    /// The number at a place that may lie beyond the border.
    pub fn at(&self, x: isize, y: isize) -> f32 {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        self.values[y * self.width + x]
    }

    /// The mean over the square of `2 radius + 1` pixels a side about each pixel, or what of it lies within the plane.
    pub fn box_mean(&self, radius: usize) -> Self {
        let across = means_of_lines(&self.values, self.width, radius);
        let turned = turned(&across, self.width);
        let down = means_of_lines(&turned, self.height, radius);
        Self {
            width: self.width,
            height: self.height,
            values: self::turned(&down, self.height),
        }
    }
}

/// The mean over `radius` numbers to either side, along lines of this length. Sums are exact enough in double precision to
/// be carried along.
fn means_of_lines(values: &[f32], length: usize, radius: usize) -> Vec<f32> {
    let mut means = Vec::with_capacity(values.len());
    for line in values.chunks_exact(length) {
        let mut sums = Vec::with_capacity(length + 1);
        let mut sum = 0.0;
        sums.push(sum);
        for &x in line {
            sum += f64::from(x);
            sums.push(sum);
        }
        means.extend((0..length).map(|i| {
            let (from, to) = (i.saturating_sub(radius), (i + radius + 1).min(length));
            ((sums[to] - sums[from]) / (to - from) as f64) as f32
        }));
    }
    means
}

/// Columns as rows.
fn turned(values: &[f32], width: usize) -> Vec<f32> {
    let columns = (0..width).map(|x| values[x..].iter().step_by(width).copied());
    columns.flatten().collect()
}

/// A part of a plane with a margin, whose pixels beyond the border are those of the border.
#[derive(Debug, Clone)]
pub struct Part {
    stride: usize,
    values: Vec<f32>,
}

impl Part {
    /// `size` pixels from a corner on, and the margin about them.
    pub fn of(plane: &Plane, corner: [usize; 2], size: [usize; 2], margin: usize) -> Self {
        let stride = size[0] + 2 * margin;
        let rows = size[1] + 2 * margin;
        let start = corner.map(|at| at as isize - margin as isize);
        let values = (0..rows as isize)
            .flat_map(|y| (0..stride as isize).map(move |x| plane.at(start[0] + x, start[1] + y)));
        Self {
            stride,
            values: values.collect(),
        }
    }

    /// `length` numbers of a row from a column on.
    pub fn row(&self, [x, y]: [usize; 2], length: usize) -> &[f32] {
        &self.values[y * self.stride + x..][..length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_over_what_lies_within() {
        let plane = Plane::new(3, 2, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let mean = plane.box_mean(1);
        assert_eq!(mean.values, [3.0, 3.5, 4.0, 3.0, 3.5, 4.0]);
        assert_eq!(plane.box_mean(0), plane);
        assert_eq!(plane.box_mean(9).values, [3.5; 6]);
    }

    #[test]
    fn beyond_the_border_is_the_border() {
        let plane = Plane::new(2, 2, vec![1.0, 2.0, 3.0, 4.0]);
        assert_eq!(
            [plane.at(-3, 0), plane.at(5, 5), plane.at(1, 0)],
            [1.0, 4.0, 2.0]
        );
    }
}
