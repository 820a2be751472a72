//! A case of the battery: a claim, and its measurement.
//!
//! Measure: stated by each case.
//! Range: any backend and seed; special requirements are stated in the name of a case.
//! Source: docs/hard-cases.md. Tested in `lab/tests/reports/battery.rs`.

use super::claim::Claim;
use super::patch::{PatchSettings, see};
pub use super::trial::{Effort, Trial};
use etendue::Result;
use etendue::internals::accel::Backend;
use etendue::internals::scene::description::SceneDescription;
use serde::Serialize;

/// Results of other renderers for the same case, as published in docs/hard-cases.md; "-" where it was not run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Peers {
    /// Mitsuba 3.9.1, scalar_rgb.
    pub mitsuba: &'static str,
    /// Cycles in Blender 5.0.1, CPU.
    pub cycles: &'static str,
    /// LuxCore 2.11.2, PATHCPU.
    pub luxcore: &'static str,
}

type Measure = Box<dyn Fn(&Trial<'_>) -> Result<Vec<f64>> + Send + Sync>;

/// One case.
pub struct Case {
    /// Its row in the catalogue of docs/hard-cases.md.
    pub row: u32,
    /// The subject that it belongs to.
    pub subject: &'static str,
    /// A short name.
    pub name: String,
    /// The claim.
    pub claim: Claim,
    /// Results of other renderers, where known.
    pub peers: Option<Peers>,
    /// Approximate duration with full effort, in units of a usual case.
    pub cost: f64,
    known: Option<(&'static str, &'static str)>,
    measure: Measure,
}

impl Case {
    /// A case for which `measure` returns independent numbers.
    pub fn new(
        row: u32,
        name: impl Into<String>,
        claim: Claim,
        measure: impl Fn(&Trial<'_>) -> Result<Vec<f64>> + Send + Sync + 'static,
    ) -> Self {
        Self {
            row,
            subject: "",
            name: name.into(),
            claim,
            peers: None,
            cost: 1.0,
            known: None,
            measure: Box::new(measure),
        }
    }

    /// A case about the radiance in each pixel of a scene.
    pub fn seen(
        row: u32,
        name: impl Into<String>,
        claim: Claim,
        scene: SceneDescription,
        patch: PatchSettings,
    ) -> Self {
        Self::new(row, name, claim, move |trial| see(trial, &scene, patch))
    }

    /// Assigns the case to a subject.
    pub fn about(self, subject: &'static str) -> Self {
        Self { subject, ..self }
    }

    /// States the case's duration relative to others with full effort.
    pub fn costing(self, cost: f64) -> Self {
        Self { cost, ..self }
    }

    /// Marks the case as known to fail with a backend: the backend's name, and a sentence with the reason.
    pub fn known_to_fail(self, known: Option<(&'static str, &'static str)>) -> Self {
        Self { known, ..self }
    }

    /// The reason of a known failure with `backend`, if there is one.
    pub fn known_failure(&self, backend: Backend) -> Option<&'static str> {
        let (name, why) = self.known?;
        (name == backend.name()).then_some(why)
    }

    /// Adds the results of other renderers.
    pub fn beside(self, peers: Peers) -> Self {
        Self {
            peers: Some(peers),
            ..self
        }
    }

    /// Returns independent measurements of the number that the case is about.
    ///
    /// # Errors
    /// An error of the scene or the backend.
    pub fn measure(&self, trial: &Trial<'_>) -> Result<Vec<f64>> {
        (self.measure)(trial)
    }
}
