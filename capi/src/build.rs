//! How a scene is to be traced, and what it took to make it ready.
//!
//! Measure: seconds, counts.
//! Range: the backends of this build.
//! Source: none needed.

use crate::describe::choice;
use crate::memory::Versioned;
use crate::status::Failure;
use renderer::{AccelOptions, Backend, Precision};
use renderer::{Work, tracing};

/// Libraries that trace rays.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdBackend {
    /// The preferred one of this build.
    Default = 0,
    /// Intel Embree.
    Embree = 1,
    /// obvhs with two children a node.
    ObvhsBvh2 = 2,
    /// obvhs with eight children a node.
    ObvhsCwbvh = 3,
}

/// How carefully rays are traced.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdPrecision {
    /// Watertight along edges.
    Robust = 0,
    /// About a third faster; may miss an edge.
    Fast = 1,
}

/// How a scene is traced. Zeros stand for the defaults.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdTracing {
    /// sizeof(EtdTracing)
    pub struct_size: usize,
    /// An `EtdBackend`.
    pub backend: i32,
    /// An `EtdPrecision`.
    pub precision: i32,
    /// Threads that build and render; 0 stands for all that the process may use.
    pub threads: u32,
}

/// What was done so far to make a scene ready.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdWork {
    /// sizeof(EtdWork), to be set before the call.
    pub struct_size: usize,
    /// How often everything was made ready since the last commit, all acceleration structures built: 1 after it, and once more
    /// for a change that can do with no less.
    pub builds: u64,
    /// How often groups were placed anew, with nothing built but the structure above them.
    pub placements: u64,
    /// How often the camera or the film was replaced, with nothing built.
    pub cameras: u64,
    /// Seconds that the last of these took.
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

/// More threads than any machine has.
const MOST_THREADS: u32 = 4096;

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
        if self.threads > MOST_THREADS {
            return Err(Failure::argument(format!(
                "threads: {}, but there may be {MOST_THREADS} at most",
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
