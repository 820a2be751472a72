//! A topic of the course, and what it is given to run with.
//!
//! Measure: `effort` is a share of the samples that a whole lesson takes.
//! Range: effort in (0, 1]; verdicts of numbers hold at any effort that is tested, times and plots get rougher.
//! Source: none needed. Tested in `lab/tests/reports/lesson.rs`.

use super::page::Page;
use super::uniform::{Uniform, seed_of};
use etendue::Result;
use etendue::internals::math::stats::{Moments, Spread};
use etendue::internals::render::settings::available_threads;
use etendue::internals::render::{Progress, RenderObserver};
use rayon::prelude::*;
use std::time::Instant;

/// A topic of the course.
#[derive(Debug, Clone, Copy)]
pub struct Topic {
    /// What it is called on the command line.
    pub name: &'static str,
    /// Its title.
    pub title: &'static str,
    /// What it is about, in a sentence.
    pub summary: &'static str,
    /// Its share of the time that all topics take, roughly.
    pub weight: f64,
    /// Does its experiment.
    pub run: fn(&Lesson<'_>) -> Result<Page>,
}

/// How lessons are run.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Picks one of 2^64 sets of random numbers.
    pub seed: u64,
    /// Threads, at least 1.
    pub threads: usize,
    /// The share of the samples to take, in (0, 1].
    pub effort: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 0,
            threads: available_threads(),
            effort: 1.0,
        }
    }
}

/// Is told how a lesson goes on, and can end it.
pub trait LessonObserver: Sync {
    /// A share in [0, 1] of the topic is done.
    fn progress(&self, _fraction: f64) {}
    /// Whether the lesson should end as soon as it can; it is then discarded.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl LessonObserver for Unwatched {}

/// A topic while it runs.
pub struct Lesson<'a> {
    topic: &'static str,
    /// How it is run.
    pub settings: Settings,
    observer: &'a dyn LessonObserver,
}

/// Groups of samples for a standard error.
pub const GROUPS: usize = 64;

impl<'a> Lesson<'a> {
    pub(super) fn new(
        topic: &'static str,
        settings: Settings,
        observer: &'a dyn LessonObserver,
    ) -> Self {
        Self {
            topic,
            settings,
            observer,
        }
    }

    /// So many samples at full effort; never less than 16.
    pub fn samples(&self, full: usize) -> usize {
        ((full as f64 * self.settings.effort) as usize).max(16)
    }

    /// A seed of its own for each of these names and indices.
    pub fn seed(&self, experiment: &str, index: usize) -> u64 {
        seed_of(self.settings.seed, [self.topic, experiment], index as u64)
    }

    /// Random numbers of their own for each of these names and indices.
    pub fn uniform(&self, experiment: &str, index: usize) -> Uniform {
        Uniform::new(self.seed(experiment, index))
    }

    /// Does an experiment `count` times, each with random numbers of its own, on all threads; in order. When the
    /// lesson is cancelled the rest is left out.
    pub fn repeat<T: Send>(
        &self,
        experiment: &str,
        count: usize,
        run: impl Fn(&mut Uniform) -> T + Sync,
    ) -> Vec<T> {
        let once = |index| {
            let go_on = !self.observer.is_cancelled();
            go_on.then(|| run(&mut self.uniform(experiment, index)))
        };
        let all: Vec<Option<T>> = (0..count).into_par_iter().map(once).collect();
        all.into_iter().flatten().collect()
    }

    /// Takes `samples` of an estimator, divided into groups.
    pub fn sample(
        &self,
        experiment: &str,
        samples: usize,
        estimator: impl Fn(&mut Uniform) -> f64 + Sync,
    ) -> Samples {
        let each = samples.div_ceil(GROUPS).max(16);
        let groups = self.repeat(experiment, GROUPS, |uniform| {
            let start = Instant::now();
            let moments = Moments::of((0..each).map(|_| estimator(uniform)));
            (moments, start.elapsed().as_secs_f64() / each as f64)
        });
        Samples { groups }
    }

    /// A share in [0, 1] of the topic is done.
    pub fn progress(&self, fraction: f64) {
        self.observer.progress(fraction);
    }

    /// Whether what comes out will be discarded.
    pub fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}

/// A render of a lesson can be ended, too.
impl RenderObserver for Lesson<'_> {
    fn progress(&self, _progress: &Progress) {}

    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}

/// Samples in groups: each group's moments, and its seconds a sample.
#[derive(Debug, Clone)]
pub struct Samples {
    groups: Vec<(Moments, f64)>,
}

impl Samples {
    /// The moments of all samples.
    pub fn all(&self) -> Moments {
        let groups = self.groups.iter().map(|(moments, _)| *moments);
        groups.fold(Moments::default(), Moments::merge)
    }

    /// The moments of the groups' variances: their mean is the variance, and has a standard error.
    pub fn variances(&self) -> Moments {
        let groups = self.groups.iter();
        Moments::of(groups.filter_map(|(moments, _)| moments.variance()))
    }

    /// Seconds a sample: the median over the groups, for another program may have taken a thread from some.
    pub fn cost(&self) -> f64 {
        if self.groups.is_empty() {
            return f64::NAN;
        }
        Spread::of(self.groups.iter().map(|(_, seconds)| *seconds).collect()).median
    }
}
