//! The recommended integrator for a scene, in words and for JSON.
//!
//! Measure: relMSE times work, over that of `path`.
//! Range: any recommendation.
//! Source: docs/accuracy.md, "Which integrator". Tested in `cli/tests/command/auto.rs`.

use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::auto::Recommendation;
use serde::Serialize;

/// A recommendation in its printed form.
#[derive(Debug, Serialize)]
pub struct RecommendationReport {
    pub recommended: &'static str,
    pub why: String,
    /// The candidates of the pilot, including the recommended one; empty if no pilot was needed.
    pub held_against: Vec<HeldAgainst>,
    /// A biased integrator that is worth trying.
    pub option: Option<String>,
}

#[derive(Debug, Serialize)]
pub struct HeldAgainst {
    pub integrator: &'static str,
    /// relMSE times work, over that of `path`; null if no light was found.
    pub inefficiency: Option<f64>,
}

impl From<&Recommendation> for RecommendationReport {
    fn from(recommendation: &Recommendation) -> Self {
        let candidates = &recommendation.candidates;
        let path = candidates
            .iter()
            .find(|it| it.integrator == IntegratorKind::Path);
        let of_path = path.map_or(f64::NAN, |it| it.inefficiency);
        let held_against = candidates.iter().map(|it| {
            let ratio = it.inefficiency / of_path;
            HeldAgainst {
                integrator: it.integrator.name(),
                inefficiency: ratio.is_finite().then_some(ratio),
            }
        });
        Self {
            recommended: recommendation.integrator.name(),
            why: recommendation.why.clone(),
            held_against: held_against.collect(),
            option: recommendation.option.clone(),
        }
    }
}

/// Returns the sentence that is printed before a render.
pub fn sentence(recommendation: &Recommendation) -> String {
    let name = recommendation.integrator.name();
    format!("auto: {name}, as {}", recommendation.why)
}

impl RecommendationReport {
    /// Returns the lines that `etendue plan` prints.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "integrator: --integrator auto selects {}: {}",
            self.recommended, self.why
        )];
        if !self.held_against.is_empty() {
            let of_one = |it: &HeldAgainst| match it.inefficiency {
                Some(ratio) => format!("{} {ratio:.2}", it.integrator),
                None => format!("{} found no light", it.integrator),
            };
            let all: Vec<String> = self.held_against.iter().map(of_one).collect();
            let all = all.join(", ");
            lines.push(format!(
                "squared error at equal work in a pilot, relative to path: {all}"
            ));
        }
        lines.extend(self.option.clone());
        lines
    }
}
