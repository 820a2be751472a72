//! Sampling of a discrete distribution in constant time, by an alias table.
//!
//! Measure: probabilities.
//! Range: weights at least 0 and finite, with a positive sum; an item of weight 0, or of a probability below the normal
//! numbers of single precision, is never sampled.
//! Source: Walker 1977; Vose 1991, "A Linear Algorithm for Generating Random Numbers with a Given Distribution".
//! Tested below.

use crate::math::measure::Pmf;
use crate::planted::planted;

/// The spacing of uniform random numbers.
const STEP: f64 = 1.0 / 16_777_216.0;

/// Joins two uniform numbers to one of twice the digits: the midpoint of the interval that both stand for, as two zeros
/// must not select an item of tiny probability.
#[inline(always)]
pub fn joined([high, low]: [f32; 2]) -> f64 {
    f64::from(high) + (f64::from(low) + 0.5 * STEP) * STEP
}

/// An alias table.
#[derive(Debug, Clone)]
pub struct AliasTable {
    slots: Vec<AliasSlot>,
}

#[derive(Debug, Clone, Copy)]
struct AliasSlot {
    /// Below this remainder the slot's own item is chosen, else its alias.
    threshold: f64,
    alias: u32,
    pmf: f32,
}

impl AliasTable {
    /// Builds the table of the weights; `None` if there are none, if their sum is not positive and finite, or if one of
    /// them is negative.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let sum: f64 = weights.iter().sum();
        let valid = sum.is_finite() && sum > 0.0 && weights.iter().all(|&w| w >= 0.0);
        if !valid || u32::try_from(weights.len()).is_err() {
            return None;
        }
        let count = weights.len() as f64;
        let mut slots: Vec<AliasSlot> = weights
            .iter()
            .enumerate()
            .map(|(i, &w)| AliasSlot {
                threshold: w / sum * count,
                alias: i as u32,
                pmf: (w / sum) as f32,
            })
            .collect();
        // The reciprocal of a denormal probability may not be finite.
        for slot in &mut slots {
            if slot.pmf < f32::MIN_POSITIVE {
                (slot.threshold, slot.pmf) = (0.0, 0.0);
            }
        }
        let (mut small, mut large): (Vec<usize>, Vec<usize>) =
            (0..slots.len()).partition(|&i| slots[i].threshold < 1.0);
        while let (Some(&poor), Some(&rich)) = (small.last(), large.last()) {
            small.pop();
            slots[poor].alias = planted!("alias-off-by-one", rich.saturating_sub(1), rich) as u32;
            slots[rich].threshold -= 1.0 - slots[poor].threshold;
            if slots[rich].threshold < 1.0 {
                large.pop();
                small.push(rich);
            }
        }
        // Remaining thresholds are 1 up to rounding, except those of probability 0, whose slots go to the heaviest item.
        let heaviest = (0..slots.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b]))?;
        for i in small.into_iter().chain(large) {
            if slots[i].pmf > 0.0 {
                slots[i].threshold = 1.0;
            } else {
                slots[i].alias = heaviest as u32;
            }
        }
        Some(Self { slots })
    }

    /// Samples an item; returns it with its probability. Two uniform numbers give enough digits for a million items.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> (usize, Pmf) {
        if self.slots.len() == 1 {
            return (0, Pmf(1.0));
        }
        let scaled = joined(u) * self.slots.len() as f64;
        let index = (scaled as usize).min(self.slots.len() - 1);
        let slot = &self.slots[index];
        let chosen = if scaled - (index as f64) < slot.threshold {
            index
        } else {
            slot.alias as usize
        };
        (chosen, self.pmf(chosen))
    }

    /// The probability of an item.
    #[inline]
    pub fn pmf(&self, item: usize) -> Pmf {
        Pmf(self.slots[item].pmf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::ONE_MINUS_EPSILON;

    /// The exact probability of each item: the share of [0, 1) that maps to it.
    fn shares(table: &AliasTable) -> Vec<f64> {
        let count = table.slots.len();
        let mut shares = vec![0.0; count];
        for (i, slot) in table.slots.iter().enumerate() {
            shares[i] += slot.threshold.min(1.0) / count as f64;
            shares[slot.alias as usize] += (1.0 - slot.threshold.min(1.0)) / count as f64;
        }
        shares
    }

    #[test]
    fn alias_table_probabilities_are_proportional_to_weights() {
        let weights = [0.0, 3.0, 1e-30, 0.5, 0.0, 7.25, 0.0];
        let table = AliasTable::new(&weights).expect("valid weights");
        let sum: f64 = weights.iter().sum();
        for (i, share) in shares(&table).into_iter().enumerate() {
            assert!((share - weights[i] / sum).abs() < 1e-15, "item {i}");
            assert!((f64::from(table.pmf(i).0) - weights[i] / sum).abs() < 1e-7);
        }
    }

    #[test]
    fn zero_weight_items_are_never_sampled() {
        for weights in [
            vec![0.0, 1.0, 0.0],
            vec![0.0, 1e-300, 0.0, 0.3, 0.3, 0.3, 0.0],
        ] {
            let table = AliasTable::new(&weights).expect("valid weights");
            for i in 0..=1000 {
                let u = (i as f32 / 1000.0).min(ONE_MINUS_EPSILON);
                for second in [0.0, ONE_MINUS_EPSILON] {
                    let (item, pmf) = table.sample([u, second]);
                    assert!(weights[item] > 0.0 && pmf.0 > 0.0, "{item}");
                }
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
            assert!(AliasTable::new(&weights).is_none(), "{weights:?}");
        }
    }
}
