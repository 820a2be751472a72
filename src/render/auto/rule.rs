//! The rule that chooses the integrator for a scene from facts about it, and the reason in words.
//!
//! Measure: inefficiency, relMSE times work, of which only ratios have a meaning.
//! Range: any facts; the choice is never a biased integrator.
//! Source: efficiency as in Veach 1997, section 2.2. Tested below; its choices are in docs/accuracy.md.

use crate::integrator::kind::IntegratorKind;

/// The ratio of inefficiencies above which `bdpt` replaces `path`, and `mlt` the better of both: a pilot is a small
/// sample, the error bars of `path` are those of its own pixels, and a chain does not show the light that it has not
/// found yet.
pub const MARGIN: f64 = 1.25;

/// An integrator that could render the scene, and its inefficiency in the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The integrator.
    pub integrator: IntegratorKind,
    /// The relMSE times the work of its pilot; infinite where it found no light.
    pub inefficiency: f64,
}

/// The facts that the rule uses.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleInput {
    /// Whether `path` misses light altogether: that of delta lights by way of specular surfaces.
    pub is_missed_by_path: bool,
    /// Whether specular surfaces cast light that light sampling does not find.
    pub has_smooth_surfaces: bool,
    /// All integrators that can render the scene with these settings, `path` first.
    pub candidates: Vec<Candidate>,
}

/// Chooses the integrator, and gives the reason.
pub fn choose(facts: &RuleInput) -> (IntegratorKind, String) {
    use IntegratorKind::{Bidirectional, Metropolis, Path};
    let of = |kind| {
        let found = facts.candidates.iter().find(|it| it.integrator == kind);
        found.map_or(f64::INFINITY, |it| it.inefficiency)
    };
    let (path, bidirectional, chains) = (of(Path), of(Bidirectional), of(Metropolis));
    if !facts.candidates.iter().any(|it| it.integrator != Path) {
        return (Path, "only path supports these settings".to_owned());
    }
    let (second, second_name) = if facts.is_missed_by_path || path > MARGIN * bidirectional {
        (bidirectional, Bidirectional)
    } else {
        (path, Path)
    };
    let best = if second > MARGIN * chains {
        Metropolis
    } else {
        second_name
    };
    (best, why(facts, best, of(best) / path))
}

/// The reason in words, where `ratio` is the choice's inefficiency over that of `path`.
fn why(facts: &RuleInput, best: IntegratorKind, ratio: f64) -> String {
    let name = best.name();
    if facts.is_missed_by_path {
        return "camera subpaths do not find light of point, spot and distant lights that arrives by way of smooth surfaces".to_owned();
    }
    if best == IntegratorKind::Path {
        return "no other integrator had a sufficiently smaller error in a pilot".to_owned();
    }
    // A pilot does not distinguish the two causes.
    let cause = if facts.has_smooth_surfaces {
        "camera subpaths rarely find some of the light, as it comes by way of smooth surfaces, through a gap or out of a lampshade"
    } else {
        "camera subpaths rarely find some of the light, as through a gap or out of a lampshade"
    };
    format!(
        "in a pilot {name} had {:.1} times less squared error than path for the same work: {cause}",
        1.0 / ratio
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use IntegratorKind::{Bidirectional, Metropolis, Path};

    fn facts(is_missed_by_path: bool, inefficiencies: &[f64]) -> RuleInput {
        let kinds = [Path, Bidirectional, Metropolis];
        let candidates = kinds.into_iter().zip(inefficiencies);
        RuleInput {
            is_missed_by_path,
            has_smooth_surfaces: false,
            candidates: candidates
                .map(|(integrator, &inefficiency)| Candidate {
                    integrator,
                    inefficiency,
                })
                .collect(),
        }
    }

    #[test]
    fn integrator_is_chosen_by_inefficiency_and_missed_light() {
        let none = f64::INFINITY;
        for (missed, inefficiencies, choice) in [
            // Alike, somewhat better, better.
            (false, &[1.0, 1.0, 1.0][..], Path),
            (false, &[1.0, 0.9, 0.85], Path),
            (false, &[1.0, 0.5, 0.45], Bidirectional),
            (false, &[1.0, 0.5, 0.2], Metropolis),
            // Chains that are better than path, the best of the others, clearly or hardly.
            (false, &[1.0, 2.0, 0.4], Metropolis),
            (false, &[1.0, 2.0, 0.9], Path),
            // The efficiency of path does not make up for the light that it misses.
            (true, &[1.0, 9.0, 9.0], Bidirectional),
            (true, &[1.0, 9.0, 4.0], Metropolis),
            // Settings that allow path alone, whatever it misses.
            (false, &[1.0], Path),
            (true, &[1.0], Path),
            // No light was found, by chains or by any integrator.
            (false, &[1.0, 0.5, none], Bidirectional),
            (false, &[none, none, none], Path),
            (true, &[none, none, none], Bidirectional),
        ] {
            let (chosen, why) = choose(&facts(missed, inefficiencies));
            assert_eq!(chosen, choice, "{missed} {inefficiencies:?}: {why}");
        }
    }

    #[test]
    fn reported_reason_names_the_deciding_factor() {
        let says = |facts: &RuleInput, words: &str| {
            let (_, why) = choose(facts);
            assert!(why.contains(words), "no `{words}` in `{why}`");
        };
        says(&facts(false, &[1.0, 0.25, 0.2]), "bdpt had 4.0 times less");
        says(&facts(false, &[1.0, 0.25, 0.2]), "gap");
        says(&facts(true, &[1.0, 0.25, 0.2]), "point, spot and distant");
        says(&facts(false, &[1.0]), "only path");
        let smooth = RuleInput {
            has_smooth_surfaces: true,
            ..facts(false, &[1.0, 0.25, 0.01])
        };
        says(&smooth, "by way of smooth surfaces");
        says(&smooth, "mlt had 100.0 times less");
    }
}
