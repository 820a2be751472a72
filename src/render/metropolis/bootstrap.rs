//! The bootstrap of Markov chains: they start at paths of independent samples, chosen in proportion to their
//! brightness.
//!
//! Paths are in the order of their number of edges, and chains start at equal distances along the cumulative
//! brightness, the first of them anywhere: each chain may start at any path, in proportion to its brightness, and all
//! chains together have each number of edges in proportion to its share of the brightness, to within one chain.
//!
//! Measure: brightness is luminance, times pixels.
//! Range: any samples; those that find no light are included in the mean, but no chain starts there.
//! Source: Veach 1997, section 11.3.1; Kitagawa 1996 for choosing at equal distances. Tested below and in
//! `tests/rendering/metropolis.rs`.

use super::{CANCEL_INTERVAL, ChainContext, ChainPath, EvaluationScratch, run_matte_or_everything};
use crate::effects::Effects;
use crate::effects::kernel::KernelJob;
use crate::film::splats::Strategy;
use crate::planted::planted;
use crate::render::tally::Tally;
use crate::sampler::{Primary, hash};
use rayon::prelude::*;
use std::ops::Range;

/// The number of steps of a round for each bootstrap sample.
const STEPS_PER_SAMPLE: u64 = 8;
/// The least number of bootstrap samples of a round.
const MIN_SAMPLES: u64 = 256;

/// A path at which a chain may start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainStart {
    /// The sample that made the path.
    pub sample: u32,
    /// The strategy that made the path.
    pub strategy: Strategy,
    /// The brightness of the path.
    pub brightness: f64,
}

/// The paths of independent samples.
pub struct Bootstrap {
    seed: u64,
    samples: u64,
    /// The paths, in the order of their number of edges.
    paths: Vec<ChainStart>,
}

impl Bootstrap {
    /// Evaluates the independent samples of a round with `steps` steps.
    pub fn evaluate(context: &ChainContext<'_>, seed: u64, steps: u64) -> (Self, Tally) {
        let samples = (steps / STEPS_PER_SAMPLE).max(MIN_SAMPLES);
        let mut bootstrap = Self {
            seed,
            samples,
            paths: Vec::new(),
        };
        let chunks = (0..samples.div_ceil(CANCEL_INTERVAL)).into_par_iter();
        let chunks = chunks.map(|chunk| {
            let job = ChunkJob {
                context,
                bootstrap: &bootstrap,
                samples: chunk * CANCEL_INTERVAL..((chunk + 1) * CANCEL_INTERVAL).min(samples),
            };
            run_matte_or_everything(context.kernel, job)
        });
        let chunks: Vec<_> = chunks.collect();
        let mut tally = Tally::default();
        for (paths, of_chunk) in chunks {
            tally.merge(of_chunk);
            bootstrap.paths.extend(paths);
        }
        bootstrap
            .paths
            .sort_by_key(|it| it.strategy.s + it.strategy.t);
        (bootstrap, tally)
    }

    /// The point in primary sample space of a sample.
    pub fn point(&self, sample: u32) -> Primary {
        Primary::new(self.seed_of(sample))
    }

    fn seed_of(&self, sample: u32) -> u64 {
        hash::combine(self.seed, sample.into())
    }

    /// The mean brightness of all samples.
    pub fn mean(&self) -> f64 {
        let samples = planted!(
            "brightness-of-what-chains-see",
            self.paths.len().max(1) as u64,
            self.samples
        );
        self.total() / samples as f64
    }

    fn total(&self) -> f64 {
        self.paths.iter().map(|it| it.brightness).sum()
    }

    /// Chooses the starts of `chains` chains; none, if no sample has found any light.
    pub fn choose(&self, chains: u64, seed: u64) -> Vec<ChainStart> {
        let Some(last) = self.paths.last() else {
            return Vec::new();
        };
        let first = (hash::mix(seed) >> 11) as f64 * f64::EPSILON / 2.0;
        let mut ends = Vec::with_capacity(self.paths.len());
        let mut sum = 0.0;
        for path in &self.paths {
            sum += path.brightness;
            ends.push(sum);
        }
        let along = |chain| {
            let place = (first + chain as f64 / chains as f64).fract() * sum;
            let index = ends.partition_point(|&end| end <= place);
            *self.paths.get(index).unwrap_or(last)
        };
        (0..chains).map(along).collect()
    }
}

/// The job of evaluating some of the samples, for a kernel.
struct ChunkJob<'a> {
    context: &'a ChainContext<'a>,
    bootstrap: &'a Bootstrap,
    samples: Range<u64>,
}

impl KernelJob for ChunkJob<'_> {
    type Output = (Vec<ChainStart>, Tally);

    fn run<E: Effects>(self) -> Self::Output {
        let context = self.context;
        let (mut paths, mut tally) = (Vec::new(), Tally::default());
        let (mut point, mut scratch) = (Primary::new(0), EvaluationScratch::<E>::default());
        for sample in self.samples.take_while(|_| !(context.is_cancelled)()) {
            let sample = sample as u32;
            point.restart(self.bootstrap.seed_of(sample));
            let evaluated = context.evaluate(None, &mut point, &mut tally, &mut scratch);
            paths.extend(evaluated.iter().map(|it| ChainStart::new(sample, it)));
        }
        (paths, tally)
    }
}

impl ChainStart {
    fn new(sample: u32, path: &ChainPath) -> Self {
        Self {
            sample,
            strategy: path.strategy,
            brightness: path.brightness(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain starts at each path with a probability in proportion to its brightness, and all chains together have
    /// each path in proportion to its brightness, to within one chain.
    #[test]
    fn bootstrap_paths_are_chosen_proportionally_to_brightness() {
        let brightness = [3.0, 0.5, 1.5, 5.0];
        let paths = brightness
            .iter()
            .enumerate()
            .map(|(i, &brightness)| ChainStart {
                sample: i as u32,
                strategy: Strategy { s: i, t: 2 },
                brightness,
            });
        let bootstrap = Bootstrap {
            seed: 0,
            samples: 20,
            paths: paths.collect(),
        };
        assert_eq!(bootstrap.mean(), 0.5);
        let rounds = 20_000;
        let mut of_first_chain = [0.0; 4];
        for seed in 0..rounds {
            let chosen = bootstrap.choose(20, seed);
            of_first_chain[chosen[0].sample as usize] += 1.0;
            for (i, brightness) in brightness.iter().enumerate() {
                let count = chosen.iter().filter(|it| it.sample == i as u32).count();
                assert!((count as f64 - 2.0 * brightness).abs() <= 1.0, "{count}");
            }
        }
        for (count, brightness) in of_first_chain.iter().zip(brightness) {
            let share = brightness / 10.0;
            let deviation = (share * (1.0 - share) * rounds as f64).sqrt();
            assert!((count - share * rounds as f64).abs() < 5.0 * deviation);
        }
    }
}
