//! Options of the acceleration structure, and statistics about preparing a scene.
//!
//! Measure: seconds, counts.
//! Range: the backends of this build.
//! Source: none needed.

use crate::describe::choice;
use crate::memory::Versioned;
use crate::status::Failure;
use renderer::{AccelOptions, Backend, Precision};
use renderer::{Work, tracing};

/// The ray tracing libraries.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdBackend {
    /// The default backend of this build.
    Default = 0,
    /// Intel Embree.
    Embree = 1,
    /// obvhs with two children per node.
    ObvhsBvh2 = 2,
    /// obvhs with eight children per node.
    ObvhsCwbvh = 3,
}

/// Precision of ray intersection.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdPrecision {
    /// Watertight at edges.
    Robust = 0,
    /// About a third faster; may miss hits at edges.
    Fast = 1,
}

/// Options of ray tracing. Zeros stand for the defaults.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdTracing {
    /// sizeof(EtdTracing)
    pub struct_size: usize,
    /// An `EtdBackend`.
    pub backend: i32,
    /// An `EtdPrecision`.
    pub precision: i32,
    /// Threads that build and render; 0 stands for all threads available to the process.
    pub threads: u32,
}

/// Statistics about preparing a scene.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdWork {
    /// sizeof(EtdWork), to be set before the call.
    pub struct_size: usize,
    /// Number of full builds since the last commit, including all acceleration structures: 1 after it, plus 1 for each
    /// change that requires a full build.
    pub builds: u64,
    /// Number of updates of instances, in which only the top-level structure was built.
    pub placements: u64,
    /// Number of updates of the camera or the film, in which nothing was built.
    pub cameras: u64,
    /// Seconds that the last of these operations took.
    pub seconds: f64,
}

// SAFETY: numbers.
unsafe impl Versioned for EtdTracing {
    const NAME: &'static str = "EtdTracing";
}

// SAFETY: numbers.
unsafe impl Versioned for EtdWork {
    const NAME: &'static str = "EtdWork";
}

/// Upper limit for the number of threads.
const MAX_THREADS: u32 = 4096;

impl EtdTracing {
    pub fn options(&self) -> Result<AccelOptions, Failure> {
        let default = tracing();
        const BACKENDS: &[(i32, Option<&str>)] = &[
            (EtdBackend::Default as i32, None),
            (EtdBackend::Embree as i32, Some("embree")),
            (EtdBackend::ObvhsBvh2 as i32, Some("obvhs-bvh2")),
            (EtdBackend::ObvhsCwbvh as i32, Some("obvhs-cwbvh")),
        ];
        const PRECISIONS: &[(i32, Precision)] = &[
            (EtdPrecision::Robust as i32, Precision::Robust),
            (EtdPrecision::Fast as i32, Precision::Fast),
        ];
        let backend = match choice(self.backend, BACKENDS, "backend")? {
            None => default.backend,
            Some(name) => {
                let found = Backend::ALL.iter().find(|backend| backend.name() == name);
                let missing =
                    || Failure::argument(format!("backend: this library was built without {name}"));
                *found.ok_or_else(missing)?
            }
        };
        if self.threads > MAX_THREADS {
            return Err(Failure::argument(format!(
                "threads: {}, expected at most {MAX_THREADS}",
                self.threads
            )));
        }
        Ok(AccelOptions {
            backend,
            precision: choice(self.precision, PRECISIONS, "precision")?,
            threads: match self.threads {
                0 => default.threads,
                threads => threads as usize,
            },
            ..default
        })
    }
}

impl From<Work> for EtdWork {
    fn from(work: Work) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            builds: work.builds,
            placements: work.placements,
            cameras: work.cameras,
            seconds: work.last.as_secs_f64(),
        }
    }
}
