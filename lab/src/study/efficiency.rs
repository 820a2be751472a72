//! The efficiency of renders: 1 / (relMSE x seconds), and the ratio of two efficiencies.
//!
//! Measure: 1 / seconds; ratios without unit.
//! Range: at least two renders. Without noise the efficiency is infinite, and its interval is not a number.
//! Source: the logarithm of a mean has nearly the relative standard error of the mean; degrees of freedom by Welch and
//! Satterthwaite, as in `gram.rs`. Tested below.

use super::bootstrap::Ranged;
use super::gram::Estimate;
use super::report::LevelReport;
use etendue::internals::math::stats::Moments;

/// 1 / (relMSE x seconds), or the ratio of two of them.
pub(super) struct Efficiency {
    value: f64,
    /// The standard error of its logarithm, whose value is 0.
    log: Estimate,
}

impl Efficiency {
    /// Computes the efficiency of the renders of a level; `None` for less than two.
    pub fn of(level: &LevelReport) -> Option<Self> {
        let seconds = Moments::of(level.runs.iter().map(|run| run.seconds.wall));
        let errors = level.gram.mse()?;
        let relative = |value: f64, standard_error: f64, freedom: f64| {
            let estimate = Estimate {
                value: 0.0,
                standard_error,
                freedom,
            };
            (1.0 / value, estimate)
        };
        Some(Self {
            value: 1.0 / (errors.value * seconds.mean()),
            log: Estimate::sum(&[
                relative(errors.value, errors.standard_error, errors.freedom),
                relative(
                    seconds.mean(),
                    seconds.standard_error()?,
                    seconds.count() as f64 - 1.0,
                ),
            ]),
        })
    }

    /// The ratio to another efficiency.
    pub fn over(&self, base: &Self) -> Self {
        Self {
            value: self.value / base.value,
            log: Estimate::sum(&[(1.0, self.log), (-1.0, base.log)]),
        }
    }

    /// With the interval by Student's distribution: of four renders, 95 % of the means of a bootstrap hold the truth in
    /// 85 % only.
    pub fn ranged(&self) -> Ranged {
        let margin = self.log.margin(0.95);
        Ranged {
            value: self.value,
            low: self.value * (-margin).exp(),
            high: self.value * margin.exp(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bootstrap::Dealer;
    use super::super::synthetic::{self, SyntheticRender};
    use super::*;
    use etendue::internals::math::stats::normal_quantile;

    /// Four renders with a relMSE of 0.01 and a second each, both with a deviation of a tenth.
    fn level(dealer: &mut Dealer) -> LevelReport {
        let mut noise = || {
            let uniform = (dealer.below(1 << 40) as f64 + 0.5) / (1_u64 << 40) as f64;
            1.0 + 0.1 * normal_quantile(uniform)
        };
        synthetic::level(0, |_| SyntheticRender {
            rel_mse: 0.01 * noise(),
            product: 0.0,
            seconds: noise(),
            luminance: 0.5,
        })
    }

    #[test]
    fn efficiency_intervals_of_four_renders_have_nominal_coverage() {
        let mut dealer = Dealer::new(4);
        let mut efficiency = || Efficiency::of(&level(&mut dealer)).expect("four renders");
        let trials = 2000;
        let (mut held, mut ratios) = (0, 0);
        for _ in 0..trials {
            let (one, two) = (efficiency(), efficiency());
            held += u32::from(one.ranged().holds(100.0));
            ratios += u32::from(two.over(&one).ranged().holds(1.0));
        }
        // The share of 2000 is known to 0.5 %; the degrees of freedom of a sum are an approximation.
        for held in [held, ratios] {
            let share = f64::from(held) / f64::from(trials);
            assert!((0.93..0.985).contains(&share), "{share}");
        }
    }
}
