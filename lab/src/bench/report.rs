//! What a bench finds out, as it is written to `bench.json`.
//!
//! Measure: seconds, bytes, nanoseconds, said at each field.
//! Range: a bench that was interrupted has the scenes and the parts that were done by then.
//! Source: docs/bench.md. Tested in `lab/tests/bench/report.rs`.

use super::target::{Target, Variant};
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::math::stats::Spread;
use serde::{Serialize, Serializer};

/// All of a bench.
#[derive(Debug, Clone, Default, Serialize)]
pub struct BenchReport {
    /// Of the program.
    pub version: &'static str,
    /// What it ran on.
    pub machine: Machine,
    /// Threads that rendered and traced.
    pub threads: usize,
    /// Runs for each spread, but for those of builds.
    pub rounds: usize,
    /// Builds for each spread.
    pub build_rounds: usize,
    /// Whether everything was measured.
    pub complete: bool,
    /// Scene by scene.
    pub scenes: Vec<SceneReport>,
    /// Rays that left closed meshes, scene by scene of those made for it.
    pub leaks: Vec<LeakReport>,
}

/// What a bench ran on.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Machine {
    /// The processor's name; empty where it cannot be found out.
    pub processor: String,
    /// Processors that this process may use.
    pub processors: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Version and file of the Embree that was loaded; empty in a build without.
    pub embree: String,
}

/// One scene.
#[derive(Debug, Clone, Serialize)]
pub struct SceneReport {
    /// Its name.
    pub name: String,
    /// What it is, in a sentence; empty for a user's own.
    pub description: String,
    /// Primitives, each group counted once.
    pub primitives: usize,
    /// Building.
    pub builds: Vec<BuildReport>,
    /// Rays recorded from its render, by kind; what is not in the scene is left out.
    pub rays: Vec<RayCount>,
    /// Tracing them.
    pub traces: Vec<TraceReport>,
    /// Whether the backends agree.
    pub agreement: Vec<AgreementReport>,
    /// Our own render against the floor; `None` without Embree.
    pub overhead: Option<OverheadReport>,
}

/// How many rays of a kind there are.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct RayCount {
    /// The kind.
    #[serde(serialize_with = "kind_name")]
    pub kind: RayKind,
    /// In a sample of the render, on average.
    pub per_sample: f64,
    /// Recorded, and traced again in each run.
    pub recorded: usize,
}

/// Building one target.
#[derive(Debug, Clone, Serialize)]
pub struct BuildReport {
    /// What was built.
    #[serde(flatten)]
    pub target: Target,
    /// With so many threads.
    pub threads: usize,
    /// Seconds.
    pub seconds: Spread,
    /// Bytes of the structure.
    pub bytes: usize,
    /// Nodes; `None` where the library does not tell.
    pub nodes: Option<usize>,
}

/// Tracing all recorded rays of a kind in one way.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(into = "WrittenTrace")]
pub struct TraceReport {
    /// The rays.
    pub kind: RayKind,
    /// The way.
    pub variant: Variant,
    /// Nanoseconds of one core a ray.
    pub nanoseconds: Spread,
}

/// With what a reader would have to compute.
#[derive(Serialize)]
struct WrittenTrace {
    #[serde(serialize_with = "kind_name")]
    kind: RayKind,
    #[serde(flatten)]
    variant: Variant,
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

/// Hits of one target against those of another one, ray by ray.
#[derive(Debug, Clone, Serialize)]
pub struct AgreementReport {
    /// The one.
    pub target: Target,
    /// The other.
    pub reference: Target,
    /// Rays compared.
    pub rays: u64,
    /// The same primitive, or none, at the same place.
    pub identical: u64,
    /// Another primitive, at the same distance but for rounding.
    pub ties: u64,
    /// A hit within rounding of an edge, or of an end of the ray, that one of them counts and the other does not.
    pub edges: u64,
    /// What rounding does not explain.
    pub real: u64,
    /// The first of those, in words that are enough to trace it again.
    pub first_real: Option<String>,
}

/// Segments from inside a closed mesh that met nothing on their way out.
#[derive(Debug, Clone, Serialize)]
pub struct LeakReport {
    /// The mesh, in words.
    pub mesh: String,
    /// How the segments were aimed: anywhere, at edges, at vertices.
    pub aim: String,
    /// What traced them.
    pub target: Target,
    /// Segments traced.
    pub segments: u64,
    /// Those that leaked.
    pub leaks: u64,
}

/// How far a render is from the time that the best of Embree alone takes for its rays.
#[derive(Debug, Clone, Serialize)]
pub struct OverheadReport {
    /// How the render traced.
    pub target: Target,
    /// Samples per pixel of each render on all threads; one thread takes its share of them.
    pub spp: u64,
    /// Nanoseconds of one core a sample, on all threads.
    pub sample: Spread,
    /// Nanoseconds a sample on one thread.
    pub sample_alone: Spread,
    /// The floor: nanoseconds of one core for a sample's rays, each kind in the way that is best for it.
    pub floor: f64,
    /// The best way for each kind.
    pub best: Vec<TraceReport>,
    /// Render over floor.
    pub factor: Spread,
    /// Where the time of a sample goes; they sum up to the median of [`Self::sample`].
    pub parts: Vec<PartReport>,
    /// Seconds before the first sample: loading, and building.
    pub load: f64,
    /// See [`Self::load`].
    pub build: f64,
}

impl OverheadReport {
    /// How many times as fast as one thread all of them are.
    pub fn speedup(&self, threads: usize) -> f64 {
        threads as f64 * self.sample_alone.median / self.sample.median
    }
}

/// A part of the work for a sample.
#[derive(Debug, Clone, Serialize)]
pub struct PartReport {
    /// What it is.
    pub part: &'static str,
    /// Nanoseconds a sample, without what measuring them takes.
    pub nanoseconds: f64,
}

fn kind_name<S: Serializer>(kind: &RayKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(kind.name())
}
