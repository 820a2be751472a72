//! A topic of the course, with the settings and tools for running it.
//!
//! Measure: `effort` is the fraction of the samples of a full lesson.
//! Range: effort in (0, 1]; verdicts of numbers hold at any tested effort, times and plots become noisier.
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
    /// Name on the command line.
    pub name: &'static str,
    /// Its title.
    pub title: &'static str,
    /// Summary in one sentence.
    pub summary: &'static str,
    /// Approximate share of the time of all topics.
    pub weight: f64,
    /// Runs the experiment.
    pub run: fn(&Lesson<'_>) -> Result<Page>,
}

/// The settings of a lesson.
#[derive(Debug, Clone, Copy)]
pub struct LessonSettings {
    /// Selects one of 2^64 sets of random numbers.
    pub seed: u64,
    /// Number of threads, at least 1.
    pub threads: usize,
    /// The fraction of the samples to take, in (0, 1].
    pub effort: f64,
}

impl Default for LessonSettings {
    fn default() -> Self {
        Self {
            seed: 0,
            threads: available_threads(),
            effort: 1.0,
        }
    }
}

/// Receives the progress of a lesson, and can cancel it.
pub trait LessonObserver: Sync {
    /// Reports the completed fraction of the topic, in [0, 1].
    fn progress(&self, _fraction: f64) {}
    /// Whether the lesson should end as soon as possible; it is then discarded.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// An observer that ignores all events.
#[derive(Debug, Clone, Copy, Default)]
pub struct NullLessonObserver;

impl LessonObserver for NullLessonObserver {}

/// A running topic.
pub struct Lesson<'a> {
    topic: &'static str,
    /// The settings of the run.
    pub settings: LessonSettings,
    observer: &'a dyn LessonObserver,
}

/// Number of groups of samples for a standard error.
pub const GROUPS: usize = 64;

impl<'a> Lesson<'a> {
    pub(super) fn new(
        topic: &'static str,
        settings: LessonSettings,
        observer: &'a dyn LessonObserver,
    ) -> Self {
        Self {
            topic,
            settings,
            observer,
        }
    }

    /// The number of samples for the current effort, given that of full effort; at least 16.
    pub fn samples(&self, full: usize) -> usize {
        ((full as f64 * self.settings.effort) as usize).max(16)
    }

    /// A distinct seed for each experiment and index.
    pub fn seed(&self, experiment: &str, index: usize) -> u64 {
        seed_of(self.settings.seed, [self.topic, experiment], index as u64)
    }

    /// A distinct stream of random numbers for each experiment and index.
    pub fn uniform(&self, experiment: &str, index: usize) -> Uniform {
        Uniform::new(self.seed(experiment, index))
    }

    /// Runs an experiment `count` times on all threads, each time with its own random numbers, and returns the results
    /// in order. After cancellation the remaining runs are left out.
    pub fn repeat<T: Send>(
        &self,
        experiment: &str,
        count: usize,
        run: impl Fn(&mut Uniform) -> T + Sync,
    ) -> Vec<T> {
        let once = |index| {
            let keep_going = !self.observer.is_cancelled();
            keep_going.then(|| run(&mut self.uniform(experiment, index)))
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
    ) -> GroupedSamples {
        let each = samples.div_ceil(GROUPS).max(16);
        let groups = self.repeat(experiment, GROUPS, |uniform| {
            let start = Instant::now();
            let moments = Moments::of((0..each).map(|_| estimator(uniform)));
            (moments, start.elapsed().as_secs_f64() / each as f64)
        });
        GroupedSamples { groups }
    }

    /// Reports the completed fraction of the topic, in [0, 1].
    pub fn progress(&self, fraction: f64) {
        self.observer.progress(fraction);
    }

    /// Whether the lesson was cancelled, so that its results will be discarded.
    pub fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}

/// Lets the renders of a lesson be cancelled, too.
impl RenderObserver for Lesson<'_> {
    fn progress(&self, _progress: &Progress) {}

    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}

/// Samples in groups: the moments of each group, and its seconds a sample.
#[derive(Debug, Clone)]
pub struct GroupedSamples {
    groups: Vec<(Moments, f64)>,
}

impl GroupedSamples {
    /// The moments of all samples.
    pub fn all(&self) -> Moments {
        let groups = self.groups.iter().map(|(moments, _)| *moments);
        groups.fold(Moments::default(), Moments::merge)
    }

    /// The moments of the groups' variances: their mean estimates the variance, with a standard error.
    pub fn variances(&self) -> Moments {
        let groups = self.groups.iter();
        Moments::of(groups.filter_map(|(moments, _)| moments.variance()))
    }

    /// Seconds a sample: the median over the groups, since other programs may have interrupted some.
    pub fn cost(&self) -> f64 {
        if self.groups.is_empty() {
            return f64::NAN;
        }
        Spread::of(self.groups.iter().map(|(_, seconds)| *seconds).collect()).median
    }
}
