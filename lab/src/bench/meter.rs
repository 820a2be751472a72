//! The progress of a bench, weighted by the estimated seconds of its stages.
//!
//! Measure: seconds, roughly, and fractions of them in [0, 1].
//! Range: any stages; if an estimate is poor, the fraction jumps at the end of its stage.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::settings::BenchObserver;
use etendue::internals::render::RenderObserver;

/// The progress of a whole bench.
pub struct Meter<'a> {
    observer: &'a dyn BenchObserver,
    total: f64,
    done: f64,
}

/// One stage of a bench.
pub struct ProgressStage<'a> {
    observer: &'a dyn BenchObserver,
    what: String,
    total: f64,
    begin: f64,
    seconds: f64,
}

impl<'a> Meter<'a> {
    /// The progress of a bench with an estimated duration of `total` seconds.
    pub fn new(observer: &'a dyn BenchObserver, total: f64) -> Self {
        let done = 0.0;
        Self {
            observer,
            total,
            done,
        }
    }

    /// Begins a stage with an estimated duration of `seconds`.
    pub fn stage(&mut self, what: String, seconds: f64) -> ProgressStage<'a> {
        let begin = self.done;
        self.done += seconds;
        let stage = ProgressStage {
            observer: self.observer,
            what,
            total: self.total,
            begin,
            seconds,
        };
        stage.advance(0.0);
        stage
    }
}

impl ProgressStage<'_> {
    /// Reports the completed fraction of the stage; returns `false` if the bench was cancelled.
    pub fn advance(&self, share: f64) -> bool {
        let fraction = (self.begin + self.seconds * share) / self.total;
        self.observer.progress(fraction.min(1.0), &self.what);
        !self.observer.is_cancelled()
    }
}

/// Lets renders within the stage be cancelled; their own progress is too fine to be reported.
impl RenderObserver for ProgressStage<'_> {
    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}
