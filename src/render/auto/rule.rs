//! Which integrator a scene is rendered by: a rule over what is known of it, and the reason in words.
//!
//! Measure: inefficiency, relMSE times work, of which only ratios say anything.
//! Range: any facts; the choice is never a biased integrator.
//! Source: efficiency as in Veach 1997, section 2.2. Tested below, and what it comes to in docs/accuracy.md.

use crate::integrator::kind::IntegratorKind;

/// So many times less efficient than `bdpt` has `path` to be before it is left, and the better of both than `mlt`: a pilot is a
/// small sample, the error bars of `path` are those of its own pixels, and what a chain has not found yet it does not tell.
pub const MARGIN: f64 = 1.25;

/// An integrator that could render the scene, and how it did in the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The integrator.
    pub integrator: IntegratorKind,
    /// relMSE times work of its pilot; infinite where it found no light.
    pub inefficiency: f64,
}

/// What the rule goes by.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Whether `path` misses light altogether: that of lights without a size, by way of smooth surfaces.
    pub is_missed_by_path: bool,
    /// Whether smooth surfaces throw light where looking for lamps does not find it.
    pub has_smooth_surfaces: bool,
    /// All that can render the scene with these settings, `path` first.
    pub candidates: Vec<Candidate>,
}

/// The choice, and why.
pub fn choose(facts: &Facts) -> (IntegratorKind, String) {
    use IntegratorKind::{Bidirectional, Metropolis, Path};
    let of = |kind| {
        let found = facts.candidates.iter().find(|it| it.integrator == kind);
        found.map_or(f64::INFINITY, |it| it.inefficiency)
    };
    let (path, bidirectional, chains) = (of(Path), of(Bidirectional), of(Metropolis));
    if !facts.candidates.iter().any(|it| it.integrator != Path) {
        return (Path, "these settings are for path alone".to_owned());
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
fn why(facts: &Facts, best: IntegratorKind, ratio: f64) -> String {
    let name = best.name();
    if facts.is_missed_by_path {
        return "paths from the eye do not find what point, spot and distant lights throw by way of smooth surfaces".to_owned();
    }
    if best == IntegratorKind::Path {
        return "nothing else did so much better in a pilot that it would be worth it".to_owned();
    }
    // Which of both, a pilot does not tell.
    let cause = if facts.has_smooth_surfaces {
        "some light is hard to reach from the eye, as it is thrown by smooth surfaces, or comes through a gap or out of a shade"
    } else {
        "some light is hard to reach from the eye, as through a gap or out of a shade"
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

    fn facts(is_missed_by_path: bool, inefficiencies: &[f64]) -> Facts {
        let kinds = [Path, Bidirectional, Metropolis];
        let candidates = kinds.into_iter().zip(inefficiencies);
        Facts {
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
    fn the_choice_follows_the_facts() {
        let none = f64::INFINITY;
        for (missed, inefficiencies, choice) in [
            // Alike, somewhat better, better.
            (false, &[1.0, 1.0, 1.0][..], Path),
            (false, &[1.0, 0.9, 0.85], Path),
            (false, &[1.0, 0.5, 0.45], Bidirectional),
            (false, &[1.0, 0.5, 0.2], Metropolis),
            // Chains that are better than path, which is the best of the others, or hardly.
            (false, &[1.0, 2.0, 0.4], Metropolis),
            (false, &[1.0, 2.0, 0.9], Path),
            // What path misses, its efficiency does not make up for.
            (true, &[1.0, 9.0, 9.0], Bidirectional),
            (true, &[1.0, 9.0, 4.0], Metropolis),
            // Settings that leave path alone, whatever it misses.
            (false, &[1.0], Path),
            (true, &[1.0], Path),
            // No light was found, by chains or by anybody.
            (false, &[1.0, 0.5, none], Bidirectional),
            (false, &[none, none, none], Path),
            (true, &[none, none, none], Bidirectional),
        ] {
            let (chosen, why) = choose(&facts(missed, inefficiencies));
            assert_eq!(chosen, choice, "{missed} {inefficiencies:?}: {why}");
        }
    }

    #[test]
    fn the_reason_says_what_it_goes_by() {
        let says = |facts: &Facts, words: &str| {
            let (_, why) = choose(facts);
            assert!(why.contains(words), "no `{words}` in `{why}`");
        };
        says(&facts(false, &[1.0, 0.25, 0.2]), "bdpt had 4.0 times less");
        says(&facts(false, &[1.0, 0.25, 0.2]), "gap");
        says(&facts(true, &[1.0, 0.25, 0.2]), "point, spot and distant");
        says(&facts(false, &[1.0]), "path alone");
        let smooth = Facts {
            has_smooth_surfaces: true,
            ..facts(false, &[1.0, 0.25, 0.01])
        };
        says(&smooth, "thrown by smooth surfaces");
        says(&smooth, "mlt had 100.0 times less");
    }
}
