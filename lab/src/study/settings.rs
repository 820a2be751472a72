//! What a study is asked to do, and who is told how it goes.
//!
//! Measure: seconds.
//! Range: at least one variant; all of them render the same picture.
//! Source: none needed. Tested in `lab/tests/reports/study.rs` and `cli/tests/command/study.rs`.

use super::report::StudyReport;
use super::schedule::Schedule;
use super::variant::Variant;
use etendue::internals::accel::AccelOptions;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::{Progress, RenderObserver};
use std::time::Instant;

/// What a study is asked to do.
#[derive(Debug, Clone)]
pub struct StudySettings {
    /// Seconds for all of it.
    pub budget: f64,
    /// Picks one of 2^64 sets of random numbers.
    pub seed: u64,
    /// What renders the references: it has to be unbiased.
    pub reference: IntegratorKind,
    /// How they trace.
    pub options: AccelOptions,
    /// What is compared; ratios are to the first.
    pub variants: Vec<Variant>,
    /// What is rendered, however long it takes; `None` for the best that the budget leaves time for. All pictures that are held
    /// against the references follow from it and the seed.
    pub schedule: Option<Schedule>,
}

/// Is told how a study goes on, and can end it.
pub trait StudyObserver: Sync {
    /// A share in [0, 1] of the time is used up; now this is rendered.
    fn progress(&self, _fraction: f64, _what: &str) {}
    /// Whether the study should end as soon as it can; what was measured so far is kept.
    fn is_cancelled(&self) -> bool {
        false
    }
    /// A part is done: all that was measured so far.
    fn report(&self, _report: &StudyReport) {}
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unattended;

impl StudyObserver for Unattended {}

/// The time of a study: what of the budget is left, and who is told.
pub struct Watch<'a> {
    observer: &'a dyn StudyObserver,
    start: Instant,
    budget: f64,
    /// Seconds after which nothing more is begun.
    limit: f64,
    what: String,
}

impl<'a> Watch<'a> {
    /// Begins.
    pub fn new(observer: &'a dyn StudyObserver, settings: &StudySettings) -> Self {
        Self {
            observer,
            start: Instant::now(),
            budget: settings.budget,
            limit: match settings.schedule {
                Some(_) => f64::INFINITY,
                None => settings.budget,
            },
            what: String::new(),
        }
    }

    /// From now on, this is done.
    pub fn begin(&mut self, what: &str) {
        self.what = what.to_owned();
        self.tell();
    }

    /// Seconds since it began.
    pub fn elapsed(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Seconds that are left, or less than 0.
    pub fn left(&self) -> f64 {
        self.limit - self.elapsed()
    }

    /// Passes a report on.
    pub fn report(&self, report: &StudyReport) {
        self.observer.report(report);
    }

    fn tell(&self) {
        // Until the end, something is left.
        let fraction = (self.elapsed() / self.budget).min(0.99);
        self.observer.progress(fraction, &self.what);
    }
}

impl RenderObserver for Watch<'_> {
    fn progress(&self, _progress: &Progress) {
        self.tell();
    }

    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}
