//! Plans the renders of a study within its budget: samples per pixel, number of seeds, length of the references.
//!
//! Every variant gets the same share of the time, so that fast ones reach more samples; time that is not enough for
//! another doubling goes to the references, which are shared by all.
//!
//! Measure: seconds, samples per pixel.
//! Range: a budget for at least three levels of samples with four seeds each; for a smaller one, the result is a
//! sufficient budget.
//! Source: docs/accuracy.md, "The study"; randomised blocks by Fisher 1935. Tested below.

use super::bootstrap::Dealer;
use super::fit::TimeLaw;
use serde::Serialize;

/// The minimum share of the time for both references.
const REFERENCES: f64 = 0.33;

/// The maximum share for all levels of all variants.
const LEVELS: f64 = 0.40;

/// The share for measuring the sources of time and variance.
pub const ANATOMY: f64 = 0.10;

/// Numbers of seeds of each level, with the minimum number of doublings for which they are used, the best first.
const SEEDS: [(u64, u32); 3] = [(16, 4), (8, 3), (4, 2)];

/// The minimum number of seeds for an estimate of the spread.
const FEWEST_SEEDS: u64 = 4;

/// The maximum number of doublings.
const MOST_DOUBLINGS: u32 = 20;

/// The minimum ratio of the samples of a reference to those of the longest render that is compared with it.
const REFERENCE_OVER_LEVEL: u64 = 4;

/// The minimum number of samples of a reference.
const LEAST_REFERENCE: u64 = 64;

/// The renders of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Schedule {
    /// Samples per pixel of each of the two references, in units of the minimum number for their integrator: 16 for
    /// `mlt`, else 1.
    pub reference_spp: u64,
    /// Number of seeds of each level.
    pub seeds: u64,
    /// Number of seeds of the last level of each variant.
    pub last_seeds: u64,
    /// The last level k of each variant: its levels have 1, 2, 4 ... 2^k samples per pixel, in units of its minimum.
    pub doublings: Vec<u32>,
}

/// One render of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Task {
    /// Index of the variant.
    pub variant: usize,
    /// The level, with 2^level samples per pixel.
    pub level: u32,
    /// Index of the seed.
    pub seed: u64,
}

impl Schedule {
    /// The best schedule for variants of these costs, or the seconds that would be enough for the smallest one.
    pub fn fit(costs: &[TimeLaw], reference: TimeLaw, seconds: f64) -> Result<Self, f64> {
        let share = LEVELS * seconds / costs.len() as f64;
        let most_spp = reference_spp(reference, REFERENCES * seconds / 2.0);
        for (seeds, least) in SEEDS {
            let doublings: Option<Vec<u32>> = costs
                .iter()
                .map(|&cost| {
                    (least..=MOST_DOUBLINGS)
                        .take_while(|&k| {
                            levels_time(cost, seeds, k) <= share
                                && REFERENCE_OVER_LEVEL << k <= most_spp
                        })
                        .last()
                })
                .collect();
            let Some(doublings) = doublings.filter(|_| most_spp >= LEAST_REFERENCE) else {
                continue;
            };
            let used: f64 = costs
                .iter()
                .zip(&doublings)
                .map(|(&cost, &k)| levels_time(cost, seeds, k))
                .sum();
            let left = LEVELS * seconds - used + REFERENCES * seconds;
            return Ok(Self {
                reference_spp: reference_spp(reference, left / 2.0),
                seeds,
                last_seeds: last_seeds(seeds),
                doublings,
            });
        }
        Err(enough(costs, reference))
    }

    /// All renders except the references: blocks with the same renders each, with separate seeds and in a random order.
    /// An end at any time thus leaves as many of each, and a machine that becomes slower affects all of them.
    pub fn blocks(&self, seed: u64) -> Vec<Vec<Task>> {
        let mut dealer = Dealer::new(seed);
        let block = |index: u64| {
            let mut tasks = Vec::new();
            for (variant, &k) in self.doublings.iter().enumerate() {
                let whole = (0..k).map(|level| (level, index));
                // The last level is in every second block, if it has half the seeds.
                let step = self.seeds / self.last_seeds;
                let last = index.is_multiple_of(step).then_some((k, index / step));
                tasks.extend(whole.chain(last).map(|(level, seed)| Task {
                    variant,
                    level,
                    seed,
                }));
            }
            dealer.shuffle(&mut tasks);
            tasks
        };
        (0..self.seeds).map(block).collect()
    }

    /// Number of images that are kept until the end.
    pub fn renders(&self) -> u64 {
        let of_variant = |&k: &u32| u64::from(k) * self.seeds + self.last_seeds;
        self.doublings.iter().map(of_variant).sum()
    }
}

fn last_seeds(seeds: u64) -> u64 {
    (seeds / 2).max(FEWEST_SEEDS)
}

/// Seconds for the levels up to `k` doublings.
fn levels_time(cost: TimeLaw, seeds: u64, k: u32) -> f64 {
    let at = |level: u32| cost.at(f64::from(level).exp2());
    let whole: f64 = (0..k).map(at).sum();
    seeds as f64 * whole + last_seeds(seeds) as f64 * at(k)
}

/// Samples per pixel of a reference that takes `seconds`: a power of two, or one and a half times that, which suits
/// evenly distributed points.
fn reference_spp(cost: TimeLaw, seconds: f64) -> u64 {
    let most = ((seconds - cost.start) / cost.sample).clamp(0.0, 1e12);
    if most < 2.0 {
        return most as u64;
    }
    let power = most.log2().floor().exp2();
    (if 1.5 * power <= most {
        1.5 * power
    } else {
        power
    }) as u64
}

/// The seconds that are enough for the smallest schedule.
fn enough(costs: &[TimeLaw], reference: TimeLaw) -> f64 {
    let [.., (seeds, least)] = SEEDS;
    let longest = costs
        .iter()
        .map(|&cost| levels_time(cost, seeds, least))
        .fold(0.0, f64::max);
    let levels = costs.len() as f64 * longest / LEVELS;
    let spp = LEAST_REFERENCE.max(REFERENCE_OVER_LEVEL << least);
    let references = 2.0 * reference.at(spp as f64) / REFERENCES;
    levels.max(references)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn law(start: f64, sample: f64) -> TimeLaw {
        TimeLaw { start, sample }
    }

    /// The duration of a schedule if all renders follow the time laws.
    fn seconds(schedule: &Schedule, costs: &[TimeLaw], reference: TimeLaw) -> f64 {
        let of_task = |task: &Task| costs[task.variant].at(f64::from(task.level).exp2());
        let blocks = schedule.blocks(1);
        let levels: f64 = blocks.iter().flatten().map(of_task).sum();
        levels + 2.0 * reference.at(schedule.reference_spp as f64)
    }

    #[test]
    fn it_fits_and_uses_what_there_is() {
        let reference = law(0.002, 0.02);
        for costs in [
            vec![reference],
            vec![reference, law(0.001, 0.005)],
            vec![law(0.01, 0.3); 6],
        ] {
            for budget in [30.0, 300.0, 3000.0] {
                let Ok(schedule) = Schedule::fit(&costs, reference, budget) else {
                    assert!(costs.len() == 6 && budget < 100.0);
                    continue;
                };
                let taken = seconds(&schedule, &costs, reference) / budget;
                assert!((0.45..=LEVELS + REFERENCES).contains(&taken), "{taken}");
                assert!(schedule.doublings.iter().all(|&k| k >= 2));
            }
        }
    }

    #[test]
    fn more_time_means_more_seeds_then_more_samples() {
        let costs = [law(0.0, 0.02)];
        let at = |budget| Schedule::fit(&costs, costs[0], budget).expect("enough");
        let [little, much, more] = [8.0, 60.0, 600.0].map(at);
        assert!(little.seeds < 16 && much.seeds == 16 && more.seeds == 16);
        assert!(more.doublings[0] > much.doublings[0]);
        assert_eq!((more.last_seeds, little.last_seeds), (8, 4));
    }

    #[test]
    fn too_little_is_answered_by_what_is_enough() {
        let (costs, reference) = ([law(0.0, 1.0), law(0.1, 0.2)], law(0.0, 0.4));
        let enough = Schedule::fit(&costs, reference, 10.0).expect_err("too little");
        assert!(enough > 10.0);
        let schedule = Schedule::fit(&costs, reference, 1.001 * enough).expect("enough");
        assert!(schedule.seeds >= 4 && schedule.doublings.iter().all(|&k| k >= 2));
        assert!(Schedule::fit(&costs, reference, 0.8 * enough).is_err());
    }

    #[test]
    fn blocks_have_every_render_once_in_an_order_by_seed() {
        let schedule = Schedule {
            reference_spp: 64,
            seeds: 16,
            last_seeds: 8,
            doublings: vec![3, 5],
        };
        let blocks = schedule.blocks(7);
        let all: HashSet<Task> = blocks.iter().flatten().copied().collect();
        assert_eq!(all.len(), 16 * 3 + 8 + 16 * 5 + 8);
        assert_eq!(all.len() as u64, schedule.renders());
        assert_eq!(blocks.iter().flatten().count(), all.len());
        let of_seed = |seed: u64| schedule.blocks(seed)[0].clone();
        assert_eq!(of_seed(7), of_seed(7));
        assert_ne!(of_seed(7), of_seed(8));
        let lasts = |block: &Vec<Task>| {
            block
                .iter()
                .filter(|t| t.variant == 0 && t.level == 3)
                .count()
        };
        assert_eq!(
            blocks.iter().map(lasts).take(4).collect::<Vec<_>>(),
            [1, 0, 1, 0]
        );
    }
}
