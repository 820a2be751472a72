//! Multiple importance sampling weights for two strategies, and for one more.
//!
//! Measure: both densities in the same measure; the weight has none.
//! Range: any densities from 0 to the largest `f32` of which the first is not 0. Only their ratio is squared, so that 0/0
//! cannot arise. A ratio that overflows gives the correct weight 0, one that underflows the correct weight 1.
//! Source: Veach and Guibas 1995, the power heuristic with exponent 2. Tested below.

use crate::math::measure::PdfSolidAngle;
use crate::planted::planted;

/// The power heuristic's weight of a sample drawn with density `p`, which another strategy draws with density `other`:
/// p^2 / (p^2 + q^2) = 1 / (1 + (q / p)^2).
#[inline]
pub fn power_heuristic(p: PdfSolidAngle, other: PdfSolidAngle) -> f32 {
    let ratio = other.0 / p.0;
    let power = planted!("balance-heuristic", ratio, ratio * ratio);
    1.0 / (1.0 + power)
}

/// The power heuristic's weight of a sample that one more strategy draws, too, whose density is `ratio` times that of the
/// sample. `weight` is its weight among the other strategies. Free of branches.
#[inline(always)]
pub fn power_heuristic_with_third(weight: f32, ratio: f32) -> f32 {
    let with = 1.0 / (1.0 / weight + ratio * ratio);
    if ratio > 0.0 { with } else { weight }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_heuristic_weights_sum_to_one_for_extreme_pdfs() {
        for i in -37..38 {
            for j in -37..38 {
                let p = PdfSolidAngle(10.0_f32.powi(i));
                let q = PdfSolidAngle(3.0 * 10.0_f32.powi(j));
                let sum = power_heuristic(p, q) + power_heuristic(q, p);
                assert!((sum - 1.0).abs() < 1e-6, "{p:?} {q:?} {sum}");
            }
        }
        assert_eq!(power_heuristic(PdfSolidAngle(1.0), PdfSolidAngle(0.0)), 1.0);
    }

    #[test]
    fn adding_a_strategy_gives_the_joint_power_heuristic_weight() {
        let (p, q) = (PdfSolidAngle(0.3), PdfSolidAngle(0.6));
        let [a, b] = [power_heuristic(p, q), power_heuristic(q, p)];
        // The third strategy has the density 0.9: squares of 1 : 2 : 3.
        assert!((power_heuristic_with_third(a, 3.0) - 1.0 / 14.0).abs() < 1e-7);
        assert!((power_heuristic_with_third(b, 1.5) - 4.0 / 14.0).abs() < 1e-7);
        assert_eq!(power_heuristic_with_third(a, 0.0), a);
        assert_eq!(
            (
                power_heuristic_with_third(a, 1e30),
                power_heuristic_with_third(0.0, 1.0)
            ),
            (0.0, 0.0)
        );
    }

    /// Weights of any exponent sum to one; this test is specific to exponent 2.
    #[test]
    fn power_heuristic_has_exponent_two() {
        let (once, twice) = (PdfSolidAngle(0.3), PdfSolidAngle(0.6));
        assert_eq!(power_heuristic(once, twice), 0.2);
        assert_eq!(power_heuristic(twice, once), 0.8);
    }
}
