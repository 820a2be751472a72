//! The settings of a study, and the observer of its progress.
//!
//! Measure: seconds.
//! Range: at least one variant; all of them render the same image.
//! Source: none needed. Tested in `lab/tests/reports/study.rs` and `cli/tests/command/study.rs`.

use super::report::StudyReport;
use super::schedule::Schedule;
use super::variant::Variant;
use etendue::internals::accel::AccelOptions;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::LightPathRule;
use etendue::internals::render::{Progress, RenderObserver};
use std::time::Instant;

/// The settings of a study.
#[derive(Debug, Clone)]
pub struct StudySettings {
    /// Seconds for the whole study.
    pub budget: f64,
    /// Selects one of 2^64 sets of random numbers.
    pub seed: u64,
    /// The integrator of the references, which has to be unbiased.
    pub reference: IntegratorKind,
    /// The light paths of references by `path`. A study replaces them by what a pilot chooses: camera paths alone miss the
    /// caustics of point lights.
    pub reference_light_paths: LightPathRule,
    /// The options of their acceleration structure.
    pub options: AccelOptions,
    /// The variants to compare; ratios are to the first in which no bias is found.
    pub variants: Vec<Variant>,
    /// Whether a smaller image may be rendered if the time is too short for one of this size.
    pub may_shrink: bool,
    /// Another number of threads, for which times are to be predicted.
    pub for_threads: Option<usize>,
    /// The renders, regardless of their time; `None` for the best schedule within the budget. It determines all images
    /// that are compared with the references, together with the seed.
    pub schedule: Option<Schedule>,
    /// The number of machines among which the renders are divided; 1 for a study on this machine alone.
    pub shards: u64,
}

/// Receives the progress of a study, and can cancel it.
pub trait StudyObserver: Sync {
    /// Reports the fraction of the time used, in [0, 1], and what is rendered now.
    fn progress(&self, _fraction: f64, _what: &str) {}
    /// Whether the study should end as soon as possible; results so far are kept.
    fn is_cancelled(&self) -> bool {
        false
    }
    /// Reports all results so far, after each completed part.
    fn report(&self, _report: &StudyReport) {}
}

/// An observer that ignores all events.
#[derive(Debug, Clone, Copy, Default)]
pub struct NullStudyObserver;

impl StudyObserver for NullStudyObserver {}

/// The clock of a study: the remaining budget, and the observer.
pub struct StudyClock<'a> {
    observer: &'a dyn StudyObserver,
    start: Instant,
    budget: f64,
    /// Seconds after which no further render is started.
    limit: f64,
    what: String,
}

impl<'a> StudyClock<'a> {
    /// A clock that runs since `start`.
    pub fn new(start: Instant, observer: &'a dyn StudyObserver, settings: &StudySettings) -> Self {
        Self {
            observer,
            start,
            budget: settings.budget,
            limit: match settings.schedule {
                Some(_) => f64::INFINITY,
                None => settings.budget,
            },
            what: String::new(),
        }
    }

    /// Begins a step and reports its name.
    pub fn begin(&mut self, what: &str) {
        self.what = what.to_owned();
        self.report_progress();
    }

    /// Seconds since the start.
    pub fn elapsed(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Remaining seconds, negative after the end of the budget.
    pub fn remaining(&self) -> f64 {
        self.limit - self.elapsed()
    }

    /// Passes a report to the observer.
    pub fn report(&self, report: &StudyReport) {
        self.observer.report(report);
    }

    fn report_progress(&self) {
        // The fraction stays below 1 until the end.
        let fraction = (self.elapsed() / self.budget).min(0.99);
        self.observer.progress(fraction, &self.what);
    }
}

impl RenderObserver for StudyClock<'_> {
    fn progress(&self, _progress: &Progress) {
        self.report_progress();
    }

    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}
