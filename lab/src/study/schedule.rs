//! Plans the renders of a study within its budget: samples per pixel, number of seeds, length of the references.
//!
//! Every variant gets the same share of the time, so that fast ones reach more samples. Each level of a variant takes
//! about as long as the others, with the fewest seeds for the longest renders: half of the share measures them, a single
//! one takes about an eighth to a sixteenth. Time that is not enough for another doubling goes to the references, which
//! are shared by all.
//!
//! Measure: seconds, samples per pixel.
//! Range: a budget for at least three levels of samples; for a smaller one, the result is a sufficient budget.
//! Source: docs/accuracy.md, "The study"; randomised blocks by Fisher 1935. Tested below.

use super::bootstrap::Dealer;
use super::fit::TimeLaw;
use serde::{Deserialize, Serialize};

/// The minimum share of the time for both references.
const REFERENCES: f64 = 0.27;

/// The maximum share for all levels of all variants.
const LEVELS: f64 = 0.55;

/// The share for measuring the sources of time and variance.
pub const COST_SOURCES: f64 = 0.08;

/// The share for measuring the gain by threads, if it was requested.
pub const SCALING: f64 = 0.03;

/// Numbers of seeds of the levels, from the longest renders on: the last number is that of all shorter ones. With the
/// first list levels take the same time; the second reaches longer renders within the same share.
const SEEDS: [&[u64]; 2] = [&[4, 8, 16], &[4, 4, 4, 6, 8, 12, 16]];

/// The number of blocks: the largest number of seeds.
const BLOCKS: u64 = 16;

/// The minimum and maximum number of doublings.
const DOUBLINGS: [u32; 2] = [2, 24];

/// The minimum number of samples of a reference.
const MIN_REFERENCE: u64 = 64;

/// The renders of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// Samples per pixel of each of the two references, in units of the minimum number for their integrator: one for each
    /// batch for `mlt`, else 1.
    pub reference_spp: u64,
    /// Number of seeds of each level of each variant. Its levels have 1, 2, 4 ... samples per pixel, in units of its
    /// minimum.
    pub seeds: Vec<Vec<u64>>,
}

/// One render of a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Task {
    /// Index of the variant.
    pub variant: usize,
    /// The level, with 2^level samples per pixel.
    pub level: u32,
    /// Index of the seed.
    pub seed: u64,
}

impl Schedule {
    /// The best schedule for variants of these costs, or the seconds that would be enough for the smallest one. The seeds
    /// are divided among `shards` machines, and the schedule is that of each of them, with this time of its own.
    pub fn fit(
        costs: &[TimeLaw],
        reference: TimeLaw,
        seconds: f64,
        shards: u64,
    ) -> Result<Self, f64> {
        let share = LEVELS * seconds / costs.len() as f64;
        let of_variant = |&cost: &TimeLaw| levels(cost, share, shards);
        let seeds: Option<Vec<Vec<u64>>> = costs.iter().map(of_variant).collect();
        let least = reference_spp(reference, REFERENCES * seconds / 2.0);
        let Some(seeds) = seeds.filter(|_| least >= MIN_REFERENCE) else {
            return Err(enough(costs, reference, shards));
        };
        let used = costs.iter().zip(&seeds).map(|(&it, seeds)| time(it, seeds));
        let left = LEVELS * seconds - used.sum::<f64>() + REFERENCES * seconds;
        Ok(Self {
            reference_spp: reference_spp(reference, left / 2.0),
            seeds,
        })
    }

    /// The schedule of this many shards together, each of which has this one.
    pub fn of_shards(&self, shards: u64) -> Self {
        let seeds = self.seeds.iter();
        let all = seeds.map(|levels| levels.iter().map(|count| shards * count).collect());
        Self {
            reference_spp: shards * self.reference_spp,
            seeds: all.collect(),
        }
    }

    /// The least number of doublings of a variant.
    pub fn least_doublings(&self) -> usize {
        let doublings = self.seeds.iter().map(|seeds| seeds.len().saturating_sub(1));
        doublings.min().unwrap_or(0)
    }

    /// All renders except the references: blocks with as many renders of each level as its number of seeds allows, in a
    /// random order. An end at any time thus leaves as large a part of each level, and a machine that becomes slower
    /// affects all of them.
    pub fn blocks(&self, seed: u64) -> Vec<Vec<Task>> {
        let mut dealer = Dealer::new(seed);
        let block = |index: u64| {
            let mut tasks = Vec::new();
            for (variant, seeds) in self.seeds.iter().enumerate() {
                for (level, &count) in (0..).zip(seeds) {
                    // The seeds whose turn has come in this block, of `count` spread over all blocks.
                    let before = |index: u64| (index * count).div_ceil(BLOCKS);
                    tasks.extend((before(index)..before(index + 1)).map(|seed| Task {
                        variant,
                        level,
                        seed,
                    }));
                }
            }
            dealer.shuffle(&mut tasks);
            tasks
        };
        (0..BLOCKS).map(block).collect()
    }

    /// Number of images that are kept until the end.
    pub fn renders(&self) -> u64 {
        let seeds = self.seeds.iter().flatten();
        seeds.fold(0_u64, |sum, &count| sum.saturating_add(count))
    }
}

/// The number of seeds of each level of the longest schedule that takes at most `share` seconds, with equal time for all
/// levels if there is time enough.
fn levels(cost: TimeLaw, share: f64, shards: u64) -> Option<Vec<u64>> {
    let [least, most] = DOUBLINGS;
    let of_lists = |k: u32| SEEDS.map(|list| seeds(list, k, shards));
    let fitting = |k: u32| of_lists(k).into_iter().find(|it| time(cost, it) <= share);
    (least..=most).rev().find_map(fitting)
}

/// The number of seeds of the levels up to `k` doublings in each of several shards, by a list that begins at the last level.
fn seeds(list: &[u64], k: u32, shards: u64) -> Vec<u64> {
    let all = list.iter().chain(list.last().into_iter().cycle());
    let of_shard = all.map(|count| count.div_ceil(shards));
    let mut seeds: Vec<u64> = of_shard.take(k as usize + 1).collect();
    seeds.reverse();
    seeds
}

/// Seconds for all renders of a variant.
fn time(cost: TimeLaw, seeds: &[u64]) -> f64 {
    let levels = (0..).zip(seeds);
    let of_level = levels.map(|(level, &count)| count as f64 * cost.at(f64::from(level).exp2()));
    of_level.sum()
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
fn enough(costs: &[TimeLaw], reference: TimeLaw, shards: u64) -> f64 {
    let [_, frugal] = SEEDS;
    let shortest = seeds(frugal, DOUBLINGS[0], shards);
    let of_variant = costs.iter().map(|&cost| time(cost, &shortest));
    let levels = costs.len() as f64 * of_variant.fold(0.0, f64::max) / LEVELS;
    let references = 2.0 * reference.at(MIN_REFERENCE as f64) / REFERENCES;
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
    fn schedule_fits_and_uses_the_budget() {
        let reference = law(0.002, 0.02);
        for costs in [
            vec![reference],
            vec![reference, law(0.001, 0.005)],
            vec![law(0.01, 0.3); 6],
        ] {
            for budget in [30.0, 300.0, 3000.0] {
                let Ok(schedule) = Schedule::fit(&costs, reference, budget, 1) else {
                    assert!(costs.len() == 6 && budget < 100.0);
                    continue;
                };
                let taken = seconds(&schedule, &costs, reference) / budget;
                assert!((0.5..=LEVELS + REFERENCES).contains(&taken), "{taken}");
                assert!(schedule.least_doublings() >= 2);
                let of_references = 2.0 * reference.at(schedule.reference_spp as f64);
                // A power of two, or one and a half times that, of at least a quarter of the budget.
                assert!(of_references > 0.66 * 0.25 * budget, "{of_references}");
            }
        }
    }

    #[test]
    fn longest_level_takes_the_largest_share_of_time() {
        let cost = law(0.0, 0.02);
        for budget in [60.0, 100.0, 600.0, 1700.0] {
            let schedule = Schedule::fit(&[cost], cost, budget, 1).expect("enough");
            let seeds = &schedule.seeds[0];
            assert_eq!((seeds[0], seeds[seeds.len() - 1]), (16, 4));
            let share = LEVELS * budget;
            let longest = cost.at(((seeds.len() - 1) as f64).exp2());
            assert!((share / 20.0..share / 8.0).contains(&longest), "{longest}");
            // The two longest levels take about as long as each other, the shorter ones all less.
            let of_level = |level: usize| seeds[level] as f64 * cost.at((level as f64).exp2());
            let last = of_level(seeds.len() - 1);
            assert!((0..seeds.len()).all(|level| of_level(level) <= last));
            assert!(of_level(seeds.len() - 2) >= 0.5 * last);
        }
    }

    #[test]
    fn seeds_are_divided_among_shards_for_longer_renders() {
        let cost = law(0.0, 0.02);
        let whole = Schedule::fit(&[cost], cost, 100.0, 1).expect("enough");
        for shards in [2, 4, 5, 16, 100] {
            let one = Schedule::fit(&[cost], cost, 100.0, shards).expect("enough");
            let all = one.of_shards(shards);
            assert!(all.seeds[0].iter().all(|&count| count >= 4));
            assert!(one.least_doublings() >= whole.least_doublings());
            assert_eq!(all.reference_spp, shards * one.reference_spp);
            assert!(seconds(&one, &[cost], cost) <= 100.0 * (LEVELS + REFERENCES));
        }
        let one = Schedule::fit(&[cost], cost, 100.0, 16).expect("enough");
        assert!(one.seeds[0].iter().all(|&count| count == 1));
        assert!(one.least_doublings() >= whole.least_doublings() + 2);
    }

    #[test]
    fn insufficient_budget_is_rejected_with_a_sufficient_one() {
        let (costs, reference) = ([law(0.0, 1.0), law(0.1, 0.2)], law(0.0, 0.4));
        let enough = Schedule::fit(&costs, reference, 10.0, 1).expect_err("too little");
        assert!(enough > 10.0);
        let schedule = Schedule::fit(&costs, reference, 1.001 * enough, 1).expect("enough");
        assert!(
            schedule.least_doublings() >= 2 && schedule.seeds.iter().flatten().all(|&n| n >= 4)
        );
        assert!(Schedule::fit(&costs, reference, 0.8 * enough, 1).is_err());
    }

    #[test]
    fn blocks_contain_every_render_once_in_seeded_order() {
        let schedule = Schedule {
            reference_spp: 64,
            seeds: vec![vec![16, 8, 4], vec![16, 12, 8, 6, 4, 4]],
        };
        let blocks = schedule.blocks(7);
        let all: HashSet<Task> = blocks.iter().flatten().copied().collect();
        assert_eq!(all.len() as u64, 28 + 50);
        assert_eq!(all.len() as u64, schedule.renders());
        assert_eq!(blocks.iter().flatten().count(), all.len());
        let of_seed = |seed: u64| schedule.blocks(seed)[0].clone();
        assert_eq!(of_seed(7), of_seed(7));
        assert_ne!(of_seed(7), of_seed(8));
        // The first block has every level, and after half of the blocks there is half of each.
        assert_eq!(blocks[0].len(), 9);
        let half: HashSet<Task> = blocks[..8].iter().flatten().copied().collect();
        let count = |level: u32| {
            half.iter()
                .filter(|it| it.variant == 1 && it.level == level)
                .count()
        };
        assert_eq!([0, 1, 2, 3, 4, 5].map(count), [8, 6, 4, 3, 2, 2]);
    }
}
