//! Runs cases in parallel, each case on a single thread.
//!
//! Measure: seconds.
//! Range: any cases. A cancelled battery reports the completed cases. Verdicts depend on the seed and the effort, never
//! on the number of threads.
//! Source: none needed. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Trial};
use super::claim::Judged;
use super::report::{BatteryReport, CaseReport, LeftOut};
use crate::bench::machine::machine;
use crate::verdict::Verdict;
use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::internals::render::settings::available_threads;
use etendue::{Error, Result};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The settings of a battery.
#[derive(Debug, Clone)]
pub struct BatterySettings {
    /// The backend that traces rays.
    pub backend: Backend,
    /// Precision of its intersections.
    pub precision: Precision,
    /// Quality of its structures; `None` for the backend's default.
    pub quality: Option<Quality>,
    /// Number of threads, at least 1.
    pub threads: usize,
    /// Seed of the random numbers.
    pub seed: u64,
    /// The effort.
    pub effort: Effort,
    /// Whether to measure cases, too, that the backend is known to fail.
    pub known_failures: bool,
}

impl Default for BatterySettings {
    fn default() -> Self {
        Self {
            backend: Backend::ALL[0],
            precision: Precision::default(),
            quality: None,
            threads: available_threads(),
            seed: 0,
            effort: Effort::Quick,
            known_failures: false,
        }
    }
}

/// Receives the progress of a battery, from any of its threads, and can cancel it.
pub trait BatteryObserver: Sync {
    /// Reports the completed fraction of the work, in [0, 1], and the case completed last.
    fn progress(&self, _fraction: f64, _done: &CaseReport) {}
    /// Whether the battery should end as soon as possible; completed cases are kept.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// An observer that ignores all events.
#[derive(Debug, Clone, Copy, Default)]
pub struct NullBatteryObserver;

impl BatteryObserver for NullBatteryObserver {}

/// Measures all cases.
///
/// # Errors
/// If the number of threads is 0. An error within a case is that case's failure.
pub fn run(
    cases: &[Case],
    settings: &BatterySettings,
    observer: &dyn BatteryObserver,
) -> Result<BatteryReport> {
    if settings.threads == 0 {
        return Err(Error::usage("threads must be at least 1"));
    }
    let is_known =
        |case: &&Case| !settings.known_failures && case.known_failure(settings.backend).is_some();
    let (left_out, cases): (Vec<_>, Vec<_>) = cases.iter().partition(is_known);
    let left_out = left_out.into_iter().filter_map(|case| {
        let why = case.known_failure(settings.backend)?;
        let (row, name) = (case.row, case.name.clone());
        Some(LeftOut { row, name, why })
    });
    let battery = Battery::new(&cases, settings, observer);
    std::thread::scope(|scope| {
        for _ in 0..settings.threads.min(cases.len()) {
            scope.spawn(|| battery.work());
        }
    });
    let queue = battery.queue.into_inner();
    let queue = queue.unwrap_or_else(PoisonError::into_inner);
    let complete = queue.results.iter().all(Option::is_some);
    Ok(BatteryReport {
        version: env!("CARGO_PKG_VERSION"),
        machine: machine(),
        backend: settings.backend.name(),
        precision: settings.precision.name(),
        effort: settings.effort,
        seed: settings.seed,
        threads: settings.threads,
        complete,
        results: queue.results.into_iter().flatten().collect(),
        left_out: left_out.collect(),
    })
}

struct Battery<'a> {
    cases: &'a [&'a Case],
    settings: &'a BatterySettings,
    observer: &'a dyn BatteryObserver,
    queue: Mutex<Queue>,
}

struct Queue {
    /// Indices of cases that have not been started; the next one is the last.
    open: Vec<usize>,
    /// Costs of all cases, and of the completed ones.
    cost: f64,
    done: f64,
    results: Vec<Option<CaseReport>>,
}

impl<'a> Battery<'a> {
    fn new(
        cases: &'a [&'a Case],
        settings: &'a BatterySettings,
        observer: &'a dyn BatteryObserver,
    ) -> Self {
        let mut open: Vec<usize> = (0..cases.len()).rev().collect();
        // Long cases first, so that none runs alone at the end.
        open.sort_by(|&a, &b| cases[a].cost.total_cmp(&cases[b].cost));
        let queue = Queue {
            open,
            cost: cases.iter().map(|case| case.cost).sum(),
            done: 0.0,
            results: cases.iter().map(|_| None).collect(),
        };
        Self {
            cases,
            settings,
            observer,
            queue: Mutex::new(queue),
        }
    }

    /// Measures cases until none are left.
    fn work(&self) {
        while !self.observer.is_cancelled() {
            let Some(index) = self.lock().open.pop() else {
                return;
            };
            let report = self.measure(self.cases[index]);
            if self.observer.is_cancelled() {
                return;
            }
            let fraction = {
                let mut queue = self.lock();
                queue.done += self.cases[index].cost;
                queue.results[index] = Some(report.clone());
                queue.done / queue.cost
            };
            self.observer.progress(fraction, &report);
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn measure(&self, case: &Case) -> CaseReport {
        let is_cancelled = || self.observer.is_cancelled();
        let trial = Trial {
            options: AccelOptions {
                backend: self.settings.backend,
                precision: self.settings.precision,
                quality: self.settings.quality,
                threads: 1,
            },
            seed: self.settings.seed,
            effort: self.settings.effort,
            is_cancelled: &is_cancelled,
        };
        let start = Instant::now();
        let measured = case.measure(&trial);
        let seconds = start.elapsed().as_secs_f64();
        let (numbers, judged, failure) = match measured {
            Ok(numbers) => {
                let judged = case.claim.judge(&numbers);
                (numbers, judged, None)
            }
            Err(error) => (
                Vec::new(),
                Judged {
                    ours: f64::NAN,
                    standard_error: None,
                    verdict: Verdict::Failed,
                },
                Some(error.to_string()),
            ),
        };
        CaseReport {
            row: case.row,
            subject: case.subject,
            name: case.name.clone(),
            claim: case.claim,
            numbers,
            ours: judged.ours,
            error: judged.ours - case.claim.exact,
            standard_error: judged.standard_error,
            verdict: judged.verdict,
            failure,
            seconds,
            peers: case.peers,
        }
    }
}
