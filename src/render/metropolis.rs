//! Metropolis light transport: Markov chains in the space of the random numbers of bidirectional path tracing.
//!
//! Let I(u) be the brightness of all that one sample with the random numbers u finds, C_j(u) what of it falls on pixel j, and
//! b the integral of I. A chain whose points are distributed as I / b then estimates the pixel by the mean of
//!
//!   b C_j(u) / I(u).
//!
//! A step from u to v is accepted with probability a = min(1, I(v) / I(u)); whatever comes of it, v counts a and u counts
//! 1 - a (expected values). Nothing is adapted on the way.
//!
//! Chains of a batch begin at points that are chosen, in proportion to I, among as many independent ones as an eighth of
//! their steps, whose mean brightness is the batch's b. That makes even the shortest chain unbiased (Veach 1997, section
//! 11.3.1). With every pass all of this begins anew: b is known better the longer the render takes, and nothing but the sums of
//! the film has to be kept. Batches never share a number, so that their spread is the error of the picture.
//!
//! Measure: brightness is luminance, times pixels; steps, of which a sample per pixel is as many as there are pixels.
//! Range: any scene that bidirectional path tracing renders.
//! Source: Kelemen et al. 2002; Veach 1997, chapter 11. Tested in `tests/rendering/metropolis.rs`.

use super::dispatch::first_or_last;
use super::tile::{NonFiniteSample, Rejected};
use crate::effects::kernel::KernelJob;
use crate::effects::{Effects, Kernel, Switch};
use crate::film::Window;
use crate::film::bars::BATCHES;
use crate::film::filter::Filter;
use crate::film::splats::{SplatSink, Splats};
use crate::integrator::bidirectional::Bidirectional;
use crate::integrator::observer::Unobserved;
use crate::integrator::{CameraRay, Integrator, RayCounts};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::sampler::{Decision, Primary, Sampler, hash};
use crate::sampling::distribution::AliasTable;
use crate::scene::Scene;
use rayon::prelude::*;

/// Chains in a batch.
pub const CHAINS: u64 = 8;

/// Steps of a batch for each of the points that its chains may begin at ...
const STEPS_PER_START: u64 = 8;
/// ... of which there are so many at least.
const LEAST_STARTS: u64 = 64;

/// Steps, or points to begin at, after which it is asked whether to end.
const PATIENCE: u64 = 256;

/// What chains walk through.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    pub scene: &'a Scene,
    pub filter: &'a Filter,
    pub kernel: Kernel,
    pub window: Window,
    pub integrator: Bidirectional,
    /// Where everything goes.
    pub splats: &'a Splats,
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// What chains tell beside what they splat.
#[derive(Debug, Clone, Copy, Default)]
pub struct ChainOutcome {
    pub rays: RayCounts,
    pub rejected: Rejected,
}

impl ChainOutcome {
    fn merge(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.rejected.merge(other.rejected);
        self
    }
}

/// What one sample finds: where it falls on the film, and its brightness.
#[derive(Debug, Clone, Default)]
struct Found {
    places: Vec<(Vec2, Rgb)>,
    brightness: f64,
}

/// The part of the film from where light reaches any pixel: its first corner and its size.
fn reach(window: Window, filter: &Filter) -> (Vec2, Vec2) {
    let beyond = (filter.radius() as f32 - 0.5).max(0.0);
    let corner = Vec2::new(window.x as f32, window.y as f32) - beyond;
    let size = Vec2::new(window.width as f32, window.height as f32) + 2.0 * beyond;
    (corner, size)
}

/// The area of film, in pixels, that paths from the eye are spread over.
pub fn film_area(window: Window, filter: &Filter) -> f64 {
    let (_, size) = reach(window, filter);
    f64::from(size.x) * f64::from(size.y)
}

impl Stage<'_> {
    /// One pass of a batch: `steps` steps by the numbers of `seed`. `walked` is told of those of each chain.
    pub fn batch(
        &self,
        batch: u64,
        seed: u64,
        steps: u64,
        walked: &(dyn Fn(u64) + Sync),
    ) -> ChainOutcome {
        let seed = hash::combine(seed, batch);
        let start = |index: u64| Primary::new(hash::combine(seed, 2 * index));
        let starts = (steps / STEPS_PER_START).max(LEAST_STARTS);
        let (brightness, outcome) = self.look_at_starts(starts, &start);
        if (self.is_cancelled)() {
            return outcome;
        }
        let looked = planted!(
            "brightness-of-what-chains-see",
            brightness.iter().filter(|&&it| it > 0.0).count() as u64,
            starts
        );
        let mean = brightness.iter().sum::<f64>() / looked as f64;
        let chains = (0..CHAINS as u32).into_par_iter().with_max_len(1);
        let of_chains = chains.map(u64::from).map(|chain| {
            let steps = steps * (chain + 1) / CHAINS - steps * chain / CHAINS;
            let job = ChainJob {
                stage: self,
                batch,
                seed: hash::combine(seed, 2 * chain + 1),
                steps,
                mean,
                brightness: &brightness,
                start: &start,
            };
            let outcome = first_or_last(self.kernel, job);
            walked(steps);
            outcome
        });
        of_chains
            .reduce(ChainOutcome::default, ChainOutcome::merge)
            .merge(outcome)
    }

    /// The brightness of each point that chains may begin at.
    fn look_at_starts(
        &self,
        count: u64,
        start: &(impl Fn(u64) -> Primary + Sync),
    ) -> (Vec<f64>, ChainOutcome) {
        let chunks = (0..count.div_ceil(PATIENCE)).into_par_iter().map(|chunk| {
            let mut outcome = ChainOutcome::default();
            let all = chunk * PATIENCE..((chunk + 1) * PATIENCE).min(count);
            if (self.is_cancelled)() {
                return (Vec::new(), outcome);
            }
            let brightness = all.map(|index| {
                let (found, of_look) = self.look(&mut start(index));
                outcome = outcome.merge(of_look);
                found.brightness
            });
            (brightness.collect::<Vec<f64>>(), outcome)
        });
        let chunks: Vec<_> = chunks.collect();
        let none = (Vec::new(), ChainOutcome::default());
        chunks.into_iter().fold(none, |(mut all, outcome), chunk| {
            all.extend(chunk.0);
            (all, outcome.merge(chunk.1))
        })
    }

    /// What a point of the space finds.
    fn look(&self, sampler: &mut Primary) -> (Found, ChainOutcome) {
        first_or_last(self.kernel, Look(self, sampler))
    }

    fn look_by<E: Effects>(&self, sampler: &mut Primary, outcome: &mut ChainOutcome) -> Found {
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
        let found = self.scene.accel.intersect(&ray, time, None);
        let mut all = Places {
            stage: self,
            places: Vec::new(),
        };
        let camera_ray = CameraRay { ray, time };
        let radiance = self.integrator.radiance_and_splats::<E, _, _, _>(
            self.scene,
            sampler,
            &camera_ray,
            found,
            &mut outcome.rays,
            &mut Unobserved,
            &mut all,
        );
        all.add(film, radiance * self.integrator.film_area as f32);
        let places = all.places;
        let brightness = |(_, value): &(Vec2, Rgb)| f64::from(value.luminance());
        let brightness: f64 = places.iter().map(brightness).sum();
        if !brightness.is_finite() {
            let first = NonFiniteSample {
                x: film.x.max(0.0) as u32,
                y: film.y.max(0.0) as u32,
                sample: 0,
            };
            outcome.rejected.merge(Rejected {
                count: 1,
                first: Some(first),
            });
            return Found::default();
        }
        Found { places, brightness }
    }
}

/// Gathers what a sample finds.
struct Places<'a> {
    stage: &'a Stage<'a>,
    places: Vec<(Vec2, Rgb)>,
}

impl Places<'_> {
    fn add(&mut self, film: Vec2, value: Rgb) {
        if !value.is_black() && self.reaches(film) {
            self.places.push((film, value));
        }
    }
}

impl SplatSink for Places<'_> {
    fn reaches(&self, film: Vec2) -> bool {
        self.stage.splats.reaches(self.stage.filter, film)
    }

    fn splat(&mut self, film: Vec2, value: Rgb) {
        self.add(film, value);
    }
}

/// One look, by a kernel.
struct Look<'a>(&'a Stage<'a>, &'a mut Primary);

impl KernelJob for Look<'_> {
    type Output = (Found, ChainOutcome);
    fn run<E: Effects>(self) -> Self::Output {
        let mut outcome = ChainOutcome::default();
        (self.0.look_by::<E>(self.1, &mut outcome), outcome)
    }
}

/// One chain, by a kernel.
struct ChainJob<'a, F> {
    stage: &'a Stage<'a>,
    batch: u64,
    seed: u64,
    steps: u64,
    /// The batch's b.
    mean: f64,
    /// The brightness of each point that the chain may begin at.
    brightness: &'a [f64],
    /// Such a point.
    start: &'a F,
}

impl<F: Fn(u64) -> Primary> KernelJob for ChainJob<'_, F> {
    type Output = ChainOutcome;

    fn run<E: Effects>(self) -> ChainOutcome {
        let mut outcome = ChainOutcome::default();
        let steps = self.walk::<E>(&mut outcome);
        self.stage.splats.add_paths(self.batch, steps);
        outcome
    }
}

impl<F: Fn(u64) -> Primary> ChainJob<'_, F> {
    /// Walks, and tells how far.
    fn walk<E: Effects>(&self, outcome: &mut ChainOutcome) -> u64 {
        // Where no light was found, b is 0, and so is the estimate.
        let Some(choice) = AliasTable::new(self.brightness) else {
            return self.steps;
        };
        let bits = hash::mix(self.seed);
        let u = [bits >> 40, bits & 0xff_ffff].map(|bits| bits as f32 / 16_777_216.0);
        let (index, _) = choice.sample(u);
        let mut sampler = (self.start)(index as u64);
        let mut here = self.stage.look_by::<E>(&mut sampler, outcome);
        assert_eq!(
            here.brightness, self.brightness[index],
            "a chain begins where it was chosen to"
        );
        sampler.accept();
        let mut sampler = sampler.reseeded(self.seed);
        // What the present point counts so far.
        let mut held = 0.0;
        for step in 0..self.steps {
            if step % PATIENCE == 0 && (self.stage.is_cancelled)() {
                self.add(&here, held);
                return step;
            }
            sampler.propose();
            let there = self.stage.look_by::<E>(&mut sampler, outcome);
            let accepted = (there.brightness / here.brightness).min(1.0);
            held += 1.0 - accepted;
            if sampler.verdict() < accepted {
                sampler.accept();
                self.add(&here, held);
                (here, held) = (there, accepted);
            } else {
                sampler.reject();
                self.add(&there, accepted);
            }
        }
        self.add(&here, held);
        self.steps
    }

    /// Brings what a point has found to the film, as often as it counts.
    fn add(&self, found: &Found, counts: f64) {
        if counts <= 0.0 || found.brightness <= 0.0 {
            return;
        }
        let scale = (counts * self.mean / found.brightness) as f32;
        let stage = self.stage;
        for &(film, value) in &found.places {
            stage
                .splats
                .add(stage.filter, self.batch, film, scale * value);
        }
    }
}

/// Batches, each as independent of the others as renders of other seeds.
pub fn batches() -> impl ParallelIterator<Item = u64> {
    let batches = (0..BATCHES as u32).into_par_iter().with_max_len(1);
    batches.map(u64::from)
}
