//! The results of a bench, as written to `bench.json`.
//!
//! Measure: seconds, bytes, nanoseconds, as stated at each field.
//! Range: a bench that was interrupted has the scenes and the parts completed by then.
//! Source: docs/bench.md. Tested in `lab/tests/bench/report.rs`.

use super::target::{BenchTarget, TracingMode, backend_name};
use etendue::internals::accel::Backend;
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::math::stats::Spread;
use serde::{Serialize, Serializer};

/// The report of a whole bench.
#[derive(Debug, Clone, Default, Serialize)]
pub struct BenchReport {
    /// Version of the program.
    pub version: &'static str,
    /// The machine that it ran on.
    pub machine: Machine,
    /// Threads that rendered and traced.
    pub threads: usize,
    /// Runs for each spread, except those of builds.
    pub rounds: usize,
    /// Builds for each spread.
    pub build_rounds: usize,
    /// Whether everything was measured.
    pub complete: bool,
    /// The results of each scene.
    pub scenes: Vec<SceneReport>,
    /// Leak tests of the closed meshes.
    pub leaks: Vec<LeakReport>,
}

/// The machine on which a bench ran.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Machine {
    /// The processor's name; empty if unknown.
    pub processor: String,
    /// Processors that this process may use.
    pub processors: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Version and file of the loaded Embree; empty in a build without it.
    pub embree: String,
}

/// The results of one scene.
#[derive(Debug, Clone, Serialize)]
pub struct SceneReport {
    /// Its name.
    pub name: String,
    /// A sentence about the scene; empty for a user's own.
    pub description: String,
    /// Number of primitives, those of each group counted once.
    pub primitives: usize,
    /// Build times and sizes.
    pub builds: Vec<BuildReport>,
    /// Rays recorded from its render, by kind; kinds that do not occur are left out.
    pub rays: Vec<RayCount>,
    /// Times of tracing these rays.
    pub traces: Vec<TraceReport>,
    /// Times of tracing them by obvhs itself, where it can represent the scene.
    pub obvhs_itself: Vec<ObvhsReport>,
    /// Comparison of the backends' hits.
    pub agreement: Vec<AgreementReport>,
    /// Our own render compared with the floor; `None` without Embree.
    pub overhead: Option<OverheadReport>,
}

/// The number of rays of a kind.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct RayCount {
    /// The kind.
    #[serde(serialize_with = "kind_name")]
    pub kind: RayKind,
    /// Average number per sample of the render.
    pub per_sample: f64,
    /// Number of rays recorded, and traced again in each run.
    pub recorded: usize,
}

/// Time and size of building one target.
#[derive(Debug, Clone, Serialize)]
pub struct BuildReport {
    /// The target.
    #[serde(flatten)]
    pub target: BenchTarget,
    /// Number of threads.
    pub threads: usize,
    /// Seconds.
    pub seconds: Spread,
    /// Bytes of the structure.
    pub bytes: usize,
    /// Number of nodes; `None` if the library does not report it.
    pub nodes: Option<usize>,
}

/// The time of tracing all recorded rays of a kind in one way.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(into = "WrittenTrace")]
pub struct TraceReport {
    /// The kind of the rays.
    pub kind: RayKind,
    /// The way of tracing.
    pub variant: TracingMode,
    /// Nanoseconds of one core a ray.
    pub nanoseconds: Spread,
}

/// The serialised form of a [`TraceReport`], with the rate derived from it.
#[derive(Serialize)]
struct WrittenTrace {
    #[serde(serialize_with = "kind_name")]
    kind: RayKind,
    #[serde(flatten)]
    variant: TracingMode,
    nanoseconds: Spread,
    millions_per_second: f64,
}

impl From<TraceReport> for WrittenTrace {
    fn from(trace: TraceReport) -> Self {
        Self {
            kind: trace.kind,
            variant: trace.variant,
            nanoseconds: trace.nanoseconds,
            millions_per_second: trace.millions_per_second(),
        }
    }
}

impl TraceReport {
    /// Millions of rays a second and core, by the median.
    pub fn millions_per_second(&self) -> f64 {
        1e3 / self.nanoseconds.median
    }
}

/// The time of tracing all recorded rays of a kind by the loops of obvhs itself.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ObvhsReport {
    /// The kind of the rays.
    #[serde(serialize_with = "kind_name")]
    pub kind: RayKind,
    /// The backend of ours that has this layout.
    #[serde(serialize_with = "backend_name")]
    pub layout: Backend,
    /// Whether the builder split triangles.
    pub is_split: bool,
    /// Nanoseconds of one core a ray.
    pub nanoseconds: Spread,
}

/// The hits of one target compared with those of another one, ray by ray.
#[derive(Debug, Clone, Serialize)]
pub struct AgreementReport {
    /// The target that is compared.
    pub target: BenchTarget,
    /// The target that it is compared with.
    pub reference: BenchTarget,
    /// Rays compared.
    pub rays: u64,
    /// Rays with the same primitive at the same place, or with a miss in both.
    pub identical: u64,
    /// Rays that hit different primitives at the same distance within rounding.
    pub ties: u64,
    /// Rays with a hit within rounding of an edge, or of an end of the ray, that only one of the targets reports.
    pub edges: u64,
    /// Rays whose difference is not explained by rounding.
    pub real: u64,
    /// Description of the first real difference, with enough digits to trace the ray again.
    pub first_real: Option<String>,
}

/// Segments from inside a closed mesh that left it without a hit.
#[derive(Debug, Clone, Serialize)]
pub struct LeakReport {
    /// The name of the mesh.
    pub mesh: String,
    /// The aim of the segments: anywhere, at edges, at vertices.
    pub aim: String,
    /// The target that traced them.
    pub target: BenchTarget,
    /// Segments traced.
    pub segments: u64,
    /// Segments without a hit.
    pub leaks: u64,
}

/// The time of a render compared with the time that Embree alone needs for its rays when used in the fastest way.
#[derive(Debug, Clone, Serialize)]
pub struct OverheadReport {
    /// The target with which the render traced.
    pub target: BenchTarget,
    /// Samples per pixel of each render on all threads; the render on one thread has 1 / threads of them.
    pub spp: u64,
    /// Nanoseconds of one core a sample, on all threads.
    pub sample: Spread,
    /// Nanoseconds a sample on one thread.
    pub sample_alone: Spread,
    /// The floor: nanoseconds of one core for a sample's rays, each kind in the fastest way.
    pub floor: f64,
    /// The fastest way for each kind.
    pub best: Vec<TraceReport>,
    /// The overhead factor: time of the render over the floor.
    pub factor: Spread,
    /// The times of the parts of a sample; they sum to the median of [`Self::sample`].
    pub parts: Vec<PartReport>,
    /// Seconds of loading before the first sample.
    pub load: f64,
    /// Seconds of building before the first sample, after [`Self::load`].
    pub build: f64,
}

impl OverheadReport {
    /// The speedup of all threads over one thread.
    pub fn speedup(&self, threads: usize) -> f64 {
        threads as f64 * self.sample_alone.median / self.sample.median
    }
}

/// The time of one part of the work for a sample.
#[derive(Debug, Clone, Serialize)]
pub struct PartReport {
    /// The name of the part.
    pub part: &'static str,
    /// Nanoseconds a sample, without the cost of measuring.
    pub nanoseconds: f64,
}

fn kind_name<S: Serializer>(kind: &RayKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kind.name())
}
