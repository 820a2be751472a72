//! Medians of numbers of a scene's primitives, which are computed and not stored.
//!
//! Measure: that of the numbers.
//! Range: any number of primitives. The result is exact: a sample of the primitives only tells which numbers are compared.
//! Source: Floyd and Rivest, "Expected Time Bounds for Selection" (1975). Tested below.

use crate::math::bounds::Bounds;

/// The boxes of primitives.
pub trait PrimitiveBoxes: Sync {
    /// Number of primitives, with those whose box is empty.
    fn count(&self) -> usize;

    /// Returns the boxes that are not empty, of one in `every` primitives of each shape.
    fn sample(&self, every: usize) -> Vec<Bounds>;

    /// Combines all boxes that are not empty, in any order.
    fn fold<T: Send>(
        &self,
        new: impl Fn() -> T + Sync,
        add: impl Fn(&mut T, &Bounds) + Sync,
        merge: impl Fn(&mut T, T),
    ) -> T;
}

/// The number of primitives up to which all are compared.
const SAMPLE_SIZE: usize = 1 << 14;

/// Returns the lower medians of some numbers of each box, and the box around all; `None` if there is no box.
pub fn medians<const N: usize>(
    boxes: &impl PrimitiveBoxes,
    numbers: impl Fn(&Bounds) -> [f64; N] + Sync + Send,
) -> Option<([f64; N], Bounds)> {
    let every = (boxes.count() / SAMPLE_SIZE).max(1);
    let sample = boxes.sample(every);
    let columns = std::array::from_fn(|column| {
        let mut values: Vec<f64> = sample.iter().map(|b| numbers(b)[column]).collect();
        values.sort_unstable_by(f64::total_cmp);
        values
    });
    if every == 1 {
        let middle = sample.len().checked_sub(1)? / 2;
        let medians = columns.map(|values: Vec<f64>| values[middle]);
        let whole = sample.into_iter().fold(Bounds::default(), Bounds::union);
        return Some((medians, whole));
    }
    // Six standard deviations of the rank of the median.
    let margin = 3 * (sample.len().isqrt() + 1);
    let between = columns.map(|values| {
        let middle = values.len() / 2;
        let low = middle.checked_sub(margin).and_then(|i| values.get(i));
        let high = values.get(middle + margin);
        [
            *low.unwrap_or(&f64::NEG_INFINITY),
            *high.unwrap_or(&f64::INFINITY),
        ]
    });
    within(boxes, &numbers, between).or_else(|| {
        let all = [[f64::NEG_INFINITY, f64::INFINITY]; N];
        within(boxes, &numbers, all)
    })
}

/// For a column of numbers, how many are below a range, and those within it.
struct Column {
    below: usize,
    within: Vec<f64>,
}

/// The number of some boxes, the box around them, and their columns of numbers.
struct Totals<const N: usize> {
    count: usize,
    whole: Bounds,
    columns: [Column; N],
}

/// Returns the medians, if each is within its range, and the box around all.
fn within<const N: usize>(
    boxes: &impl PrimitiveBoxes,
    numbers: &(impl Fn(&Bounds) -> [f64; N] + Sync + Send),
    ranges: [[f64; 2]; N],
) -> Option<([f64; N], Bounds)> {
    let new = || Totals {
        count: 0,
        whole: Bounds::default(),
        columns: std::array::from_fn(|_| Column {
            below: 0,
            within: Vec::new(),
        }),
    };
    let add = |totals: &mut Totals<N>, bounds: &Bounds| {
        let values = numbers(bounds);
        for ((column, value), [low, high]) in totals.columns.iter_mut().zip(values).zip(ranges) {
            if value < low {
                column.below += 1;
            } else if value <= high {
                column.within.push(value);
            }
        }
        totals.count += 1;
        totals.whole = totals.whole.union(*bounds);
    };
    let merge = |totals: &mut Totals<N>, more: Totals<N>| {
        for (column, other) in totals.columns.iter_mut().zip(more.columns) {
            column.below += other.below;
            column.within.extend(other.within);
        }
        totals.count += more.count;
        totals.whole = totals.whole.union(more.whole);
    };
    let totals = boxes.fold(new, add, merge);
    let middle = totals.count.checked_sub(1)? / 2;
    let mut medians = [0.0; N];
    for (median, mut column) in medians.iter_mut().zip(totals.columns) {
        let place = middle.checked_sub(column.below)?;
        if place >= column.within.len() {
            return None;
        }
        *median = *column
            .within
            .select_nth_unstable_by(place, f64::total_cmp)
            .1;
    }
    Some((medians, totals.whole))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::DVec3;

    impl PrimitiveBoxes for Vec<Bounds> {
        fn count(&self) -> usize {
            self.len()
        }

        fn sample(&self, every: usize) -> Vec<Bounds> {
            self.iter().step_by(every).copied().collect()
        }

        fn fold<T: Send>(
            &self,
            new: impl Fn() -> T + Sync,
            add: impl Fn(&mut T, &Bounds) + Sync,
            merge: impl Fn(&mut T, T),
        ) -> T {
            let mut all = new();
            for half in self.chunks(self.len().div_ceil(2).max(1)) {
                let mut of_half = new();
                half.iter().for_each(|bounds| add(&mut of_half, bounds));
                merge(&mut all, of_half);
            }
            all
        }
    }

    #[test]
    fn medians_of_many_boxes_are_those_of_the_sorted_numbers() {
        let point = |x: usize, count: usize| {
            // Every sampled number of the second column is the same; those of the third are far from the others.
            let every = count / SAMPLE_SIZE;
            let third = if every > 1 && x.is_multiple_of(every) {
                -9.0
            } else {
                x as f64
            };
            let p = DVec3::new((x * 7919 % count) as f64, (x % 3 / 2) as f64, third);
            Bounds { min: p, max: p }
        };
        for count in [0, 1, 2, 1000, 2 * SAMPLE_SIZE, 3 * SAMPLE_SIZE + 1, 100_003] {
            let boxes: Vec<Bounds> = (0..count).map(|x| point(x, count)).collect();
            let found = medians(&boxes, |b| b.centre().to_array());
            let sorted = |axis: usize| {
                let mut values: Vec<f64> = boxes.iter().map(|b| b.min[axis]).collect();
                values.sort_unstable_by(f64::total_cmp);
                values[(count - 1) / 2]
            };
            let whole = boxes.iter().copied().fold(Bounds::default(), Bounds::union);
            let expected = (count > 0).then(|| ([0, 1, 2].map(sorted), whole));
            assert_eq!(found, expected, "{count}");
        }
    }
}
