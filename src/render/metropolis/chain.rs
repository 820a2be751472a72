//! A Markov chain: from path to path with equally many edges, by steps through the random numbers that make them.
//!
//! The strategy is one of these numbers: the interval is divided evenly among the strategies that make paths with so
//! many edges.
//!
//! Measure: as in `mod.rs`.
//! Range: any number of steps; a chain is unbiased from the first step on.
//! Source: Hachisuka et al. 2014, section 4. Tested below and in `tests/rendering/metropolis.rs`.

use super::bootstrap::{Bootstrap, ChainStart};
use super::{CANCEL_INTERVAL, ChainContext, ChainPath, EvaluationScratch};
use crate::effects::Effects;
use crate::effects::kernel::KernelJob;
use crate::film::splats::{Splat, Strategy};
use crate::planted::planted;
use crate::render::tally::Tally;
use crate::sampler::{Decision, Primary, Sampler};

/// The job of one chain, for a kernel. It returns the number of steps taken.
pub struct ChainJob<'a> {
    pub context: &'a ChainContext<'a>,
    pub batch: u64,
    pub seed: u64,
    pub steps: u64,
    /// The mean brightness b of the batch.
    pub mean: f64,
    /// The path at which the chain starts.
    pub start: Option<ChainStart>,
    pub bootstrap: &'a Bootstrap,
}

impl KernelJob for ChainJob<'_> {
    type Output = (u64, Tally);

    fn run<E: Effects>(self) -> Self::Output {
        let mut tally = Tally::default();
        let steps = self.walk::<E>(&mut tally);
        (steps, tally)
    }
}

impl<'a> ChainJob<'a> {
    /// Runs the chain, and returns the number of steps taken.
    fn walk<E: Effects>(&self, tally: &mut Tally) -> u64 {
        let Some(start) = self.start else {
            return self.steps;
        };
        let edges = start.strategy.s + start.strategy.t - 1;
        let mut sampler = self.bootstrap.point(start.sample);
        let is_start = |u| strategy(u, edges) == start.strategy;
        sampler.draw_until(Decision::Strategy, is_start);
        let scratch = &mut EvaluationScratch::<E>::default();
        let current = self.evaluate(edges, &mut sampler, tally, scratch);
        let mut current = current.expect("a chain begins at a path that has been found");
        assert_eq!(
            current.brightness(),
            start.brightness,
            "a chain begins at the very path that it was chosen to"
        );
        sampler.accept();
        let mut sampler = sampler.reseeded(self.seed);
        // The weight of the current path so far.
        let mut current_weight = 0.0;
        let (film, filter) = (self.context.splats, self.context.filter);
        let mut splats = Vec::new();
        for step in 0..self.steps {
            if step % CANCEL_INTERVAL == 0 {
                film.add(filter, &splats);
                splats.clear();
                if (self.context.is_cancelled)() {
                    splats.extend(self.splat(&current, current_weight));
                    film.add(filter, &splats);
                    return step;
                }
            }
            sampler.propose();
            let proposed = self.evaluate(edges, &mut sampler, tally, scratch);
            let brightness = proposed.map_or(0.0, |it| it.brightness());
            let accepted = (brightness / current.brightness()).min(1.0);
            current_weight += 1.0 - accepted;
            match proposed {
                Some(proposed) if sampler.acceptance_number() < accepted => {
                    sampler.accept();
                    splats.extend(self.splat(&current, current_weight));
                    (current, current_weight) = (proposed, accepted);
                }
                proposed => {
                    sampler.reject();
                    if let Some(proposed) = proposed {
                        splats.extend(self.splat(&proposed, accepted));
                    }
                }
            }
        }
        splats.extend(self.splat(&current, current_weight));
        film.add(filter, &splats);
        self.steps
    }

    /// Evaluates the path of a point in primary sample space.
    fn evaluate<E: Effects>(
        &self,
        edges: usize,
        sampler: &mut Primary,
        tally: &mut Tally,
        scratch: &mut EvaluationScratch<'a, E>,
    ) -> Option<ChainPath> {
        let [u] = sampler.draw(Decision::Strategy);
        let by = strategy(u, edges);
        let paths = self.context.evaluate(Some(by), sampler, tally, scratch);
        paths.last().copied()
    }

    /// The splat of a path with the weight `counts`, and its batch; none without weight.
    fn splat(&self, path: &ChainPath, counts: f64) -> Option<(u64, Splat)> {
        (counts > 0.0).then(|| {
            let scale = (counts * self.mean / path.brightness()) as f32;
            let splat = Splat {
                film_position: path.film,
                value: scale * path.value,
            };
            (self.batch, splat)
        })
    }
}

/// The strategy that a random number selects, among those that make paths with `edges` edges.
fn strategy(u: f32, edges: usize) -> Strategy {
    // Light that the camera sees directly is found by one strategy alone.
    let strategies = if edges == 1 { 1 } else { edges + 1 };
    let position = planted!("strategies-have-uneven-shares", u * u, u);
    let s = (f64::from(position) * strategies as f64) as usize;
    Strategy {
        s,
        t: edges + 1 - s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strategies_are_equally_probable() {
        for edges in 1..=6 {
            let mut counts = [0_u32; 8];
            let cells = 840 * 8;
            for i in 0..cells {
                let by = strategy((i as f32 + 0.5) / cells as f32, edges);
                assert_eq!(by.s + by.t, edges + 1);
                assert!(by.t >= 1);
                counts[by.s] += 1;
            }
            let strategies = if edges == 1 { 1 } else { edges + 1 };
            let share = cells / strategies as u32;
            assert!(
                counts[..strategies].iter().all(|&count| count == share),
                "{counts:?}"
            );
        }
    }
}
