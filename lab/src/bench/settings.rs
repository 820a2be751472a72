//! What a bench is asked to do, and who is told how it goes.
//!
//! Measure: rays, runs, seconds.
//! Range: said at each field; [`BenchSettings::validate`] names what is out of it.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::report::BenchReport;
use super::target::Target;
use etendue::internals::accel::{Backend, Precision};
use etendue::internals::render::settings::available_threads;
use etendue::internals::scene::description::SceneDescription;
use etendue::{Error, Result};

/// The settings of a bench.
#[derive(Debug, Clone)]
pub struct BenchSettings {
    /// Threads that render and trace, at least 1.
    pub threads: usize,
    /// Runs for the spread of every time but those of builds, at least 1; nine tell a median from noise.
    pub rounds: usize,
    /// Builds of each target, at least 1.
    pub build_rounds: usize,
    /// Rays recorded of a kind, at least 1.
    pub rays: usize,
    /// What is compared, at least one; the first one is the reference for the hits of the others.
    pub targets: Vec<Target>,
    /// How carefully our own render traces.
    pub precision: Precision,
    /// Seconds that one render should take.
    pub render_seconds: f64,
    /// Rays of a scene for which hits are compared.
    pub compared_rays: usize,
    /// Segments sent out of closed meshes, for each mesh, aim and target.
    pub segments: u64,
}

impl Default for BenchSettings {
    fn default() -> Self {
        Self {
            threads: available_threads(),
            rounds: 9,
            build_rounds: 3,
            rays: 1 << 17,
            targets: Target::all(Backend::ALL),
            precision: Precision::Fast,
            render_seconds: 1.0,
            compared_rays: 1_000_000,
            segments: 1_000_000,
        }
    }
}

impl BenchSettings {
    /// Whether the settings make sense.
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

    /// How our own render traces: through Embree if that is compared, else through the first backend that is.
    pub fn render_target(&self) -> Target {
        let embree = self.targets.iter().find(|target| target.is_embree());
        let backend = embree.unwrap_or(&self.targets[0]).backend;
        Target {
            backend,
            precision: self.precision,
            quality: backend.default_quality(),
        }
    }
}

/// A scene for a bench.
#[derive(Debug, Clone)]
pub struct GivenScene {
    /// Its name.
    pub name: String,
    /// What it is, in a sentence; empty for a user's own.
    pub description: String,
    /// What is in it.
    pub scene: SceneDescription,
    /// Seconds that reading or making it took.
    pub load: f64,
}

/// Is told how a bench goes on, and can end it.
pub trait BenchObserver: Sync {
    /// A share in [0, 1] of the work is done; now this is measured.
    fn progress(&self, _fraction: f64, _what: &str) {}
    /// Whether the bench should end as soon as it can; what was measured so far is kept.
    fn is_cancelled(&self) -> bool {
        false
    }
    /// A part is done: all that was measured so far.
    fn report(&self, _report: &BenchReport) {}
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unattended;

impl BenchObserver for Unattended {}
