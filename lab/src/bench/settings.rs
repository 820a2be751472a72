//! The settings of a bench, and the observer of its progress.
//!
//! Measure: rays, runs, seconds.
//! Range: stated at each field; [`BenchSettings::validate`] reports values out of range.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::report::BenchReport;
use super::target::BenchTarget;
use etendue::internals::accel::{Backend, Precision};
use etendue::internals::render::settings::available_threads;
use etendue::internals::scene::description::SceneDescription;
use etendue::{Error, Result};

/// The settings of a bench.
#[derive(Debug, Clone)]
pub struct BenchSettings {
    /// Threads that render and trace, at least 1.
    pub threads: usize,
    /// Runs for the spread of every time except those of builds, at least 1; nine give a reliable median.
    pub rounds: usize,
    /// Builds of each target, at least 1.
    pub build_rounds: usize,
    /// Rays recorded of a kind, at least 1.
    pub rays: usize,
    /// The targets to compare, at least one; the first one is the reference for the hits of the others.
    pub targets: Vec<BenchTarget>,
    /// The intersection precision of our own render.
    pub precision: Precision,
    /// Intended seconds of one render.
    pub render_seconds: f64,
    /// Number of rays of a scene for which hits are compared.
    pub compared_rays: usize,
    /// Number of segments traced out of closed meshes, for each mesh, aim and target.
    pub segments: u64,
}

impl Default for BenchSettings {
    fn default() -> Self {
        Self {
            threads: available_threads(),
            rounds: 9,
            build_rounds: 3,
            rays: 1 << 17,
            targets: BenchTarget::all(Backend::ALL),
            precision: Precision::Fast,
            render_seconds: 1.0,
            compared_rays: 1_000_000,
            segments: 1_000_000,
        }
    }
}

impl BenchSettings {
    /// Checks that the settings are in their ranges.
    ///
    /// # Errors
    /// A usage error that names the setting.
    pub fn validate(&self) -> Result<()> {
        let at_least_one = [
            (self.threads, "threads"),
            (self.rounds, "rounds"),
            (self.build_rounds, "rounds of building"),
            (self.rays, "rays"),
            (self.targets.len(), "targets"),
        ];
        match at_least_one.iter().find(|(count, _)| *count == 0) {
            Some((_, name)) => Err(Error::usage(format!("{name} must be at least 1"))),
            None => Ok(()),
        }
    }

    /// The target of our own render: Embree if it is compared, else the first backend that is.
    pub fn render_target(&self) -> BenchTarget {
        let embree = self.targets.iter().find(|target| target.is_embree());
        let backend = embree.unwrap_or(&self.targets[0]).backend;
        BenchTarget {
            backend,
            precision: self.precision,
            quality: backend.default_quality(),
        }
    }
}

/// A scene for a bench.
#[derive(Debug, Clone)]
pub struct GivenScene {
    /// Name of the scene.
    pub name: String,
    /// A sentence about the scene; empty for a user's own.
    pub description: String,
    /// The description of the scene.
    pub scene: SceneDescription,
    /// Seconds of reading or generating it.
    pub load: f64,
}

/// Receives the progress of a bench, and can cancel it.
pub trait BenchObserver: Sync {
    /// Reports the fraction of the work done, in [0, 1], and what is measured now.
    fn progress(&self, _fraction: f64, _what: &str) {}
    /// Whether the bench should end as soon as possible; results so far are kept.
    fn is_cancelled(&self) -> bool {
        false
    }
    /// Reports all results so far, after each completed part.
    fn report(&self, _report: &BenchReport) {}
}

/// An observer that ignores all events.
#[derive(Debug, Clone, Copy, Default)]
pub struct NullBenchObserver;

impl BenchObserver for NullBenchObserver {}
