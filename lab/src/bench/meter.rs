//! How far a bench has come, by the seconds that its stages are likely to take.
//!
//! Measure: seconds, roughly, and shares of them in [0, 1].
//! Range: any stages; where a guess is bad, the share jumps at the end of its stage.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::settings::BenchObserver;
use etendue::internals::render::RenderObserver;

/// The progress of a whole bench.
pub struct Meter<'a> {
    observer: &'a dyn BenchObserver,
    total: f64,
    done: f64,
}

/// One stage of it.
pub struct ProgressStage<'a> {
    observer: &'a dyn BenchObserver,
    what: String,
    total: f64,
    begin: f64,
    seconds: f64,
}

impl<'a> Meter<'a> {
    /// A bench that will take so many seconds.
    pub fn new(observer: &'a dyn BenchObserver, total: f64) -> Self {
        let done = 0.0;
        Self {
            observer,
            total,
            done,
        }
    }

    /// Begins a stage that will take so many seconds of them.
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
        stage.go_on(0.0);
        stage
    }
}

impl ProgressStage<'_> {
    /// Tells how much of the stage is done; `false` if the bench is to end.
    pub fn go_on(&self, share: f64) -> bool {
        let fraction = (self.begin + self.seconds * share) / self.total;
        self.observer.progress(fraction.min(1.0), &self.what);
        !self.observer.is_cancelled()
    }
}

/// Renders within the stage can be cancelled; their own progress is too fine to be told.
impl RenderObserver for ProgressStage<'_> {
    fn is_cancelled(&self) -> bool {
        self.observer.is_cancelled()
    }
}
