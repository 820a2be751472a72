//! Metropolis light transport: Markov chains in the space of the random numbers of bidirectional path tracing.
//!
//! Let paths with n edges that strategy s makes of the random numbers u add C_{n,s,j}(u) to pixel j, weights included,
//! let I_{n,s}(u) be the brightness of that, and b_n the integral over u of the sum over s of I_{n,s}. A chain keeps n
//! fixed and mutates u and s. If its states are distributed as I_{n,s} / b_n, paths of n edges are estimated by the
//! mean of
//!
//!   b_n C_{n,s,j}(u) / I_{n,s}(u).
//!
//! A step from (u, s) to (v, r) is accepted with probability a = min(1, I_{n,r}(v) / I_{n,s}(u)); in either case, the
//! proposed state has the weight a and the current one 1 - a (expected values). Nothing is adapted during the render.
//! Steps are cheap, as each makes one path by one strategy.
//!
//! A round of a batch begins with independent samples that make paths by all strategies (`bootstrap.rs`). Their mean
//! brightness is b, and chains start at their paths in proportion to brightness, so that a share b_n / b of them has n
//! edges, and even the shortest chain is unbiased (Veach 1997, section 11.3.1). Every round repeats all of this: b is
//! known better the longer the render takes, and nothing but the sums of the film has to be kept. Rounds end after every
//! fourth sample per pixel, at the latest, so that any division of a render has the same rounds. Batches never share a
//! random number, so that their spread is the error of the image.
//!
//! Measure: brightness is luminance, times pixels; steps, of which one sample per pixel is as many as there are pixels.
//! Range: any scene that bidirectional path tracing renders. A round keeps some 10 MB for each batch in progress.
//! Source: Kelemen et al. 2002; Hachisuka et al. 2014, "Multiplexed Metropolis Light Transport"; Veach 1997, chapter
//! 11. Tested in `tests/rendering/metropolis.rs`.

mod bootstrap;
mod chain;

use super::dispatch::run_matte_or_everything;
use super::tally::{NonFiniteSample, Rejected, Tally};
use crate::effects::{Effects, Kernel, Switch};
use crate::film::Window;
use crate::film::batches::BATCHES;
use crate::film::filter::Filter;
use crate::film::splats::{Splats, Strategy};
use crate::integrator::CameraRay;
use crate::integrator::bidirectional::{Bidirectional, Contribution, SubpathScratch};
use crate::integrator::observer::NullPathObserver;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::{Decision, Primary, Sampler, hash};
use crate::scene::Scene;
use rayon::prelude::*;

/// The largest number of steps in a round, which bounds its memory.
const ROUND: u64 = 1 << 17;

/// The number of steps in a chain: more of them explore other parts of the image less well than new starts do.
const LENGTH: u64 = 128;

/// The least number of chains in a round.
const MIN_CHAINS: u64 = 128;

/// The number of steps, or of bootstrap samples, between checks for cancellation.
const CANCEL_INTERVAL: u64 = 256;

/// The context of Markov chains.
#[derive(Clone, Copy)]
pub struct ChainContext<'a> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub kernel: Kernel,
    pub window: Window,
    pub integrator: Bidirectional,
    /// The splats of the film, which take all contributions.
    pub splats: &'a Splats,
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// A path that contributes to the film.
#[derive(Debug, Clone, Copy)]
struct ChainPath {
    /// The strategy that made the path.
    strategy: Strategy,
    /// The place on the film.
    film: Vec2,
    /// The contribution, weighted.
    value: Rgb,
}

impl ChainPath {
    fn brightness(&self) -> f64 {
        self.value.luminance().into()
    }
}

/// The part of the film from which light reaches any pixel: its first corner and its size.
fn reach(window: Window, filter: &Filter) -> (Vec2, Vec2) {
    let beyond = (filter.radius() as f32 - 0.5).max(0.0);
    let corner = Vec2::new(window.x as f32, window.y as f32) - beyond;
    let size = Vec2::new(window.width as f32, window.height as f32) + 2.0 * beyond;
    (corner, size)
}

/// The area of film, in pixels, over which camera subpaths are spread.
pub fn film_area(window: Window, filter: &Filter) -> f64 {
    let (_, size) = reach(window, filter);
    f64::from(size.x) * f64::from(size.y)
}

/// The batches, each as independent of the others as renders with other seeds.
pub fn batches() -> impl ParallelIterator<Item = u64> {
    let batches = (0..BATCHES as u32).into_par_iter().with_max_len(1);
    batches.map(u64::from)
}

/// The memory of an evaluation, which the next one uses, too.
struct EvaluationScratch<'a, E: Effects> {
    subpaths: SubpathScratch<'a, E>,
    paths: Vec<ChainPath>,
}

impl<E: Effects> Default for EvaluationScratch<'_, E> {
    fn default() -> Self {
        Self {
            subpaths: SubpathScratch::default(),
            paths: Vec::new(),
        }
    }
}

impl<'a> ChainContext<'a> {
    /// Runs `steps` steps of a batch in rounds, with the random numbers of `seed`. `walked` is called with the number
    /// of steps of each chain.
    pub fn batch(&self, batch: u64, seed: u64, steps: u64, walked: &(dyn Fn(u64) + Sync)) -> Tally {
        let seed = hash::combine(seed, batch);
        let mut tally = Tally::default();
        for first in (0..steps).step_by(ROUND as usize) {
            let seed = hash::combine(seed, first);
            let round = self.round(batch, seed, ROUND.min(steps - first), walked);
            tally.merge(round);
        }
        tally
    }

    fn round(&self, batch: u64, seed: u64, steps: u64, walked: &(dyn Fn(u64) + Sync)) -> Tally {
        let (bootstrap, tally) =
            bootstrap::Bootstrap::evaluate(self, hash::combine(seed, u64::MAX), steps);
        if (self.is_cancelled)() {
            return tally;
        }
        let mean = bootstrap.mean();
        let count = (steps / LENGTH).max(MIN_CHAINS);
        let chosen = bootstrap.choose(count, hash::combine(seed, u64::MAX - 1));
        let chains = (0..count as u32).into_par_iter().with_max_len(1);
        let of_chains = chains.map(u64::from).map(|chain| {
            let job = chain::ChainJob {
                context: self,
                batch,
                seed: hash::combine(seed, chain),
                steps: steps * (chain + 1) / count - steps * chain / count,
                mean,
                // Where no sample found light, b is 0, and so is the estimate.
                start: chosen.get(chain as usize).copied(),
                bootstrap: &bootstrap,
            };
            let (own_steps, tally) = run_matte_or_everything(self.kernel, job);
            self.splats.add_samples(batch, own_steps);
            walked(own_steps);
            tally
        });
        let none = Tally::default;
        of_chains.reduce(none, Tally::merged).merged(tally)
    }

    /// Evaluates the paths of a point in primary sample space, by one strategy or, if none is given, by all.
    fn evaluate<'s, E: Effects>(
        &self,
        by: Option<Strategy>,
        sampler: &mut Primary,
        tally: &mut Tally,
        scratch: &'s mut EvaluationScratch<'a, E>,
    ) -> &'s [ChainPath] {
        let [x, y, u, v] = sampler.draw(Decision::Camera);
        let time = if E::Motion::ON {
            let [time] = sampler.draw(Decision::Time);
            time
        } else {
            0.0
        };
        let (corner, size) = reach(self.window, self.filter);
        let film = corner + Vec2::new(x, y) * size;
        let ray = self.scene.camera.ray::<E>(film, Vec2::new(u, v), time);
        let camera_ray = CameraRay { ray, time };
        let reaches = |film| self.splats.reaches(self.filter, film);
        let EvaluationScratch { subpaths, paths } = scratch;
        paths.clear();
        let take = |it: Contribution| self.take(&it, film, paths);
        let (scene, rays, integrator) = (self.scene, &mut tally.rays, self.integrator);
        if let Some(by) = by {
            let found = integrator.by_strategy::<E, _>(
                by,
                scene,
                sampler,
                &camera_ray,
                rays,
                subpaths,
                &reaches,
            );
            found.into_iter().flatten().for_each(take);
        } else {
            let (hit, observer) = (
                scene.accel.intersect(&ray, time, None),
                &mut NullPathObserver,
            );
            integrator.contributions::<E, _, _>(
                scene,
                sampler,
                &camera_ray,
                hit,
                rays,
                subpaths,
                observer,
                &reaches,
                take,
            );
        }
        paths.retain(|it| {
            let is_finite = it.brightness().is_finite();
            if !is_finite {
                tally.rejected.merge(rejected(it.film));
            }
            is_finite && it.brightness() > 0.0
        });
        paths
    }

    /// Adds a contribution of a sample whose camera ray goes through `film` to the sample's paths.
    fn take(&self, it: &Contribution, film: Vec2, paths: &mut Vec<ChainPath>) {
        let (film, over) = match it.film {
            Some(film) => (film, 1.0),
            None => (film, self.integrator.film_area as f32),
        };
        let value = it.unweighted * (it.weight * over);
        // The environment has two parts, constant and sampled, of the same strategy.
        let same = |last: &&mut ChainPath| last.strategy == it.strategy;
        if let Some(last) = paths.last_mut().filter(same) {
            last.value += value;
        } else if self.splats.reaches(self.filter, film) {
            paths.push(ChainPath {
                strategy: it.strategy,
                film,
                value,
            });
        }
    }
}

/// The record of a path whose contribution is not finite.
fn rejected(film: Vec2) -> Rejected {
    let first = NonFiniteSample {
        x: film.x.max(0.0) as u32,
        y: film.y.max(0.0) as u32,
        sample: 0,
    };
    Rejected {
        count: 1,
        first: Some(first),
    }
}
