//! A case of the battery: a claim, and how it is measured.
//!
//! Measure: said by each case.
//! Range: any backend and seed; what a case needs of them it says in its name.
//! Source: docs/hard-cases.md. Tested in `lab/tests/reports/battery.rs`.

use super::claim::Claim;
use super::patch::{Look, see};
pub use super::trial::{Effort, Trial};
use etendue::Result;
use etendue::internals::accel::Backend;
use etendue::internals::scene::description::SceneDescription;
use serde::Serialize;

/// What other renderers gave for the same case, as published in docs/hard-cases.md; "-" where it was not run.
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
    /// What it is, in a few words.
    pub name: String,
    /// What is claimed.
    pub claim: Claim,
    /// What others gave, where that is known.
    pub peers: Option<Peers>,
    /// About how long it takes with full effort, in units of the usual case.
    pub cost: f64,
    known: Option<(&'static str, &'static str)>,
    measure: Measure,
}

impl Case {
    /// A case that `measure` yields independent numbers of.
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

    /// A case about what each pixel sees of a scene.
    pub fn seen(
        row: u32,
        name: impl Into<String>,
        claim: Claim,
        scene: SceneDescription,
        look: Look,
    ) -> Self {
        Self::new(row, name, claim, move |trial| see(trial, &scene, look))
    }

    /// The same case of a subject.
    pub fn about(self, subject: &'static str) -> Self {
        Self { subject, ..self }
    }

    /// The same case, known to take that many times as long as others with full effort.
    pub fn costing(self, cost: f64) -> Self {
        Self { cost, ..self }
    }

    /// The same case, of which it is known that a backend fails it, and why: its name, and a sentence.
    pub fn known_to_fail(self, known: Option<(&'static str, &'static str)>) -> Self {
        Self { known, ..self }
    }

    /// Why a backend is known to fail it, if it is.
    pub fn known_failure(&self, backend: Backend) -> Option<&'static str> {
        let (name, why) = self.known?;
        (name == backend.name()).then_some(why)
    }

    /// The same case with what others gave.
    pub fn beside(self, peers: Peers) -> Self {
        Self {
            peers: Some(peers),
            ..self
        }
    }

    /// Independent numbers of what the case is about.
    ///
    /// # Errors
    /// What the scene or the backend says.
    pub fn measure(&self, trial: &Trial<'_>) -> Result<Vec<f64>> {
        (self.measure)(trial)
    }
}
