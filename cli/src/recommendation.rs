//! The recommended integrator for a scene, in words and for JSON.
//!
//! Measure: relMSE times work, over that of `path`.
//! Range: any recommendation.
//! Source: docs/accuracy.md, "Which integrator". Tested in `cli/tests/command/auto.rs`.

use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::auto::{
    LightPathChoice, PathReuseChoice, Recommendation, WeightWindowChoice,
};
use etendue_lab::study::bootstrap::Ranged;
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
    /// The light paths beside `path`, if a pilot chose their number.
    pub light_paths: Option<LightPathReport>,
    /// The pixels that share the paths of `path`, if a pilot chose their number.
    pub reuse: Option<ReuseReport>,
    /// The roulette of `path`, if a pilot chose its weight window.
    pub roulette: Option<RouletteReport>,
}

/// A number of light paths that a pilot has chosen.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct LightPathReport {
    /// The number for each camera path, in words.
    pub number: &'static str,
    /// The squared error of as many samples without light paths, over that with them; null if camera paths alone miss light.
    pub squared_error_without: Option<f64>,
}

/// A number of pixels that share their paths, which a pilot has chosen.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ReuseReport {
    /// The number, or `off`.
    pub pixels: &'static str,
    /// The squared error of as many samples without shared paths, over that with them.
    pub squared_error_without: f64,
    /// The squared error at equal cost without shared paths, over that with them.
    pub gain: f64,
}

/// A rule of roulette whose weight window a pilot has chosen.
#[derive(Debug, Clone, Serialize)]
pub struct RouletteReport {
    /// The rule.
    pub rule: String,
    /// The number of rays with the smaller window over that with the larger one.
    pub rays_of_smaller_window: f64,
    /// The ratio up to which the smaller window is chosen.
    pub max_rays_of_smaller_window: f64,
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
            light_paths: recommendation.choices.light_paths.map(Into::into),
            reuse: recommendation.choices.reuse.map(Into::into),
            roulette: recommendation.choices.weight_window.map(Into::into),
        }
    }
}

/// The ratio of squared errors above which camera paths alone do not converge.
const MISSES: f64 = 1e4;

impl From<LightPathChoice> for LightPathReport {
    fn from(choice: LightPathChoice) -> Self {
        Self {
            number: choice.rule.name(),
            squared_error_without: (choice.ratio < MISSES).then_some(choice.ratio),
        }
    }
}

impl LightPathReport {
    /// Returns the number and its reason.
    pub fn describe(&self) -> String {
        let number = self.number;
        match self.squared_error_without {
            Some(ratio) => format!(
                "{number} for each camera path (camera paths alone have {ratio:.2} times the squared error in a pilot)"
            ),
            None => format!("{number} for each camera path (camera paths alone miss light)"),
        }
    }
}

impl From<PathReuseChoice> for ReuseReport {
    fn from(choice: PathReuseChoice) -> Self {
        Self {
            pixels: choice.reuse.name(),
            squared_error_without: choice.ratio,
            gain: choice.gain,
        }
    }
}

impl ReuseReport {
    /// Returns the number and its reason.
    pub fn describe(&self) -> String {
        format!(
            "{} (without, a pilot has {:.2} times the squared error, at equal cost {:.2} times)",
            self.pixels, self.squared_error_without, self.gain
        )
    }
}

impl From<WeightWindowChoice> for RouletteReport {
    fn from(choice: WeightWindowChoice) -> Self {
        Self {
            rule: choice.roulette.to_string(),
            rays_of_smaller_window: choice.rays_of_smaller,
            max_rays_of_smaller_window: choice.max_rays,
        }
    }
}

impl RouletteReport {
    /// Returns the rule and its reason.
    pub fn describe(&self) -> String {
        format!(
            "{} (the smaller window has {:.2} times the rays of the larger one in a pilot, and is taken up to {} times)",
            self.rule, self.rays_of_smaller_window, self.max_rays_of_smaller_window
        )
    }
}

/// Returns the sentence that is printed before a render.
pub fn sentence(recommendation: &Recommendation) -> String {
    let name = recommendation.integrator.name();
    format!("auto: {name}, as {}", recommendation.why)
}

/// Returns the advice on the integrator from the measured gains of others over the present one, each the factor by which
/// it is faster with its interval. What `auto` selects by its pilot is named wherever a longer measurement disagrees.
pub fn advice(present: &str, gains: &[(&str, Ranged)], auto: Option<&Recommendation>) -> String {
    let sure = gains.iter().filter(|(_, gain)| gain.low > 1.0);
    let best = sure.max_by(|a, b| a.1.value.total_cmp(&b.1.value));
    let Some((name, gain)) = best else {
        return match auto {
            Some(auto) if auto.integrator.name() == present => format!(
                "no other integrator is faster beyond doubt, and `--integrator auto` selects {present}, too"
            ),
            Some(auto) => format!(
                "no other integrator is faster than {present} beyond doubt; the short pilot of `--integrator auto` selects {}",
                auto.integrator.name()
            ),
            None => format!("no other integrator is faster than {present} beyond doubt"),
        };
    };
    let times = format!("{:.2} ({:.2} to {:.2})", gain.value, gain.low, gain.high);
    let faster = format!("{name} is {times} times as fast as {present}");
    match auto.map(|auto| auto.integrator.name()) {
        Some(auto) if auto == *name => format!("{faster}, and `--integrator auto` selects it, too"),
        Some(auto) => format!(
            "{faster}: name it by --integrator {name}, as the short pilot of `--integrator auto` selects {auto}"
        ),
        None => format!("{faster}: --integrator {name}"),
    }
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
        let light_paths = self.light_paths.map(|it| it.describe());
        lines.extend(light_paths.map(|it| format!("light paths beside path: {it}")));
        let reuse = self.reuse.map(|it| it.describe());
        lines.extend(reuse.map(|it| format!("pixels of path that share paths: {it}")));
        let roulette = self.roulette.as_ref().map(RouletteReport::describe);
        lines.extend(roulette.map(|it| format!("roulette of path: {it}")));
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::render::auto::PathChoices;

    fn auto(integrator: IntegratorKind) -> Recommendation {
        Recommendation {
            integrator,
            why: String::new(),
            candidates: vec![],
            option: None,
            choices: PathChoices::default(),
        }
    }

    #[test]
    fn advice_matches_measured_gains_and_mentions_auto_choice() {
        let gain = |value: f64| Ranged {
            value,
            low: 0.8 * value,
            high: 1.2 * value,
        };
        let path = auto(IntegratorKind::Path);
        let bdpt = auto(IntegratorKind::Bidirectional);
        for (gains, auto, words) in [
            (
                vec![("bdpt", gain(0.5))],
                Some(&path),
                "auto` selects path, too",
            ),
            (
                vec![("bdpt", gain(1.1))],
                Some(&bdpt),
                "pilot of `--integrator auto` selects bdpt",
            ),
            (
                vec![("bdpt", gain(3.0))],
                Some(&bdpt),
                "bdpt is 3.00 (2.40 to 3.60) times as fast as path, and",
            ),
            (
                vec![("bdpt", gain(3.0))],
                Some(&path),
                "name it by --integrator bdpt",
            ),
            (
                vec![("mlt", gain(9.0)), ("bdpt", gain(3.0))],
                None,
                "mlt is 9.00",
            ),
            (vec![], None, "no other integrator"),
        ] {
            let text = advice("path", &gains, auto);
            assert!(text.contains(words), "no {words} in {text}");
        }
    }
}
