//! Grids over the unit cube of any dimension, as fine as a number of calls allows.
//!
//! Measure: counts.
//! Range: any dimension from 1; there is no grid if the calls do not allow `least` places along each axis.
//! Source: counting in base m. Tested below.

/// A grid of m places (nodes or cells) along each of d axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    per_axis: usize,
    dimension: u32,
}

impl Grid {
    /// The finest grid of at most `calls` places; `None` if it has fewer than `least` along an axis, or no axis.
    pub fn of_calls(calls: usize, dimension: u32, least: usize) -> Option<Self> {
        let is_paid = |m: usize| m.checked_pow(dimension).is_some_and(|all| all <= calls);
        if dimension == 0 || !is_paid(least) {
            return None;
        }
        // Bisection, since a floating-point root may round to either side of an integer.
        let (mut per_axis, mut most) = (least, calls);
        while per_axis < most {
            let middle = per_axis + (most - per_axis).div_ceil(2);
            if is_paid(middle) {
                per_axis = middle;
            } else {
                most = middle - 1;
            }
        }
        Some(Self {
            per_axis,
            dimension,
        })
    }

    /// The dimension d.
    pub fn dimension(self) -> usize {
        self.dimension as usize
    }

    /// Restricts the grid to at most `per_axis` places along each axis.
    pub fn coarsened_to(self, per_axis: usize) -> Self {
        Self {
            per_axis: per_axis.min(self.per_axis),
            ..self
        }
    }

    /// The number of places along each axis, m.
    pub fn per_axis(self) -> usize {
        self.per_axis
    }

    /// The number of all places, m^d.
    pub fn count(self) -> usize {
        self.per_axis.pow(self.dimension)
    }

    /// The sum of `term` over all places, each given by its d indices below m.
    pub fn sum(self, mut term: impl FnMut(&[usize]) -> f64) -> f64 {
        let mut place = vec![0; self.dimension()];
        let mut sum = 0.0;
        loop {
            sum += term(&place);
            let Some(axis) = place.iter().position(|&i| i + 1 < self.per_axis) else {
                return sum;
            };
            place[axis] += 1;
            place[..axis].fill(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_is_the_finest_within_the_call_budget() {
        for dimension in 1..=12 {
            for m in 2_usize..=if dimension < 7 { 20 } else { 5 } {
                let all = m.pow(dimension);
                for (calls, expected) in
                    [(all - 1, m - 1), (all, m), ((m + 1).pow(dimension) - 1, m)]
                {
                    let grid = Grid::of_calls(calls, dimension, 1).expect("at least one place");
                    assert_eq!(grid.per_axis(), expected, "{calls} {dimension}");
                }
                assert_eq!(Grid::of_calls(all - 1, dimension, m), None);
            }
        }
        let huge = Grid::of_calls(usize::MAX, 1, 1).expect("one axis");
        assert_eq!(huge.count(), usize::MAX);
        assert_eq!(Grid::of_calls(100, 0, 1), None);
        assert_eq!(Grid::of_calls(0, 3, 1), None);
    }

    #[test]
    fn grid_sum_visits_every_cell_once() {
        let grid = Grid::of_calls(27, 3, 2).expect("three along each axis");
        let mut seen = vec![0; 27];
        let sum = grid.sum(|place| {
            seen[place[0] + 3 * place[1] + 9 * place[2]] += 1;
            1.0
        });
        assert_eq!((seen, sum), (vec![1; 27], 27.0));
    }
}
