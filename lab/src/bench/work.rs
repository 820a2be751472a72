//! Estimates the duration of a bench, so that the remaining time can be shown from the beginning.
//!
//! Measure: seconds on a current processor, within a factor of a few.
//! Range: any scene.
//! Source: measured times of the stages on the machine of docs/bench.md. Only the progress display depends on it.

use super::settings::BenchSettings;
use super::target::BenchTarget;
use etendue::internals::accel::Quality;
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};

/// Seconds to place a primitive.
const PLACING: f64 = 5e-7;

/// Seconds of one core to trace a ray.
const TRACING: f64 = 2e-7;

/// Seconds of one core to choose a segment out of a mesh and trace it.
const LEAVING: f64 = 1e-6;

/// Seconds of one core to compare a hit.
const COMPARING: f64 = 1e-6;

/// Estimated seconds of the stages.
#[derive(Debug, Clone, Copy)]
pub struct StageTimes {
    /// Preparing the scene.
    pub prepare: f64,
    /// All builds.
    pub build: f64,
    /// Tracing the rays of one kind in all ways.
    pub trace_of_kind: f64,
    /// Comparing hits.
    pub compare: f64,
    /// All renders.
    pub render: f64,
}

impl StageTimes {
    /// Estimates the work on one scene.
    pub fn of(scene: &SceneDescription, settings: &BenchSettings) -> Self {
        let primitives = scene.shapes.iter().map(|s| primitives(&s.geometry));
        let primitives = primitives.sum::<usize>() as f64;
        let (threads, rounds) = (settings.threads as f64, settings.rounds as f64 + 1.0);
        let targets = settings.targets.iter();
        let building = primitives * targets.clone().map(building).sum::<f64>();
        let variants = targets.map(|t| t.variants().len()).sum::<usize>() as f64;
        let others = settings.targets.len() as f64 - 1.0;
        Self {
            prepare: primitives * PLACING,
            build: building * (1.0 + 1.0 / threads) * settings.build_rounds as f64,
            trace_of_kind: settings.rays as f64 * variants * rounds * TRACING / threads,
            compare: settings.compared_rays as f64 * others * COMPARING / threads,
            render: 2.0 * rounds * settings.render_seconds,
        }
    }

    /// The sum over all stages.
    pub fn total(&self) -> f64 {
        let tracing = self.trace_of_kind * RayKind::ALL.len() as f64;
        self.prepare + self.build + tracing + self.compare + self.render
    }
}

/// Seconds of one core to build a structure, per triangle, by quality.
fn building(target: &BenchTarget) -> f64 {
    match target.quality {
        Quality::Medium => 1e-6,
        Quality::High => 4e-6,
    }
}

/// Seconds of the leak tests.
pub fn leaks(settings: &BenchSettings) -> f64 {
    // Six meshes of about 50 000 triangles, three aims.
    let tracing = 3.0 * settings.segments as f64 * LEAVING;
    let targets = settings.targets.iter();
    let seconds = targets.map(|target| 6.0 * (tracing + 5e4 * building(target)));
    seconds.sum::<f64>() / settings.threads as f64
}

/// Primitives of a shape.
fn primitives(geometry: &GeometryDescription) -> usize {
    match geometry {
        GeometryDescription::Mesh(mesh) => mesh.indices.len(),
        _ => 1,
    }
}
