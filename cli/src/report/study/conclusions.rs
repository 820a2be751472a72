//! The conclusions of a study in a few sentences: which variant is most efficient, which are biased, the cost of a
//! smaller error.
//!
//! Measure: as in `study/summary.rs`.
//! Range: any summaries; if there are none, a sentence that too little was rendered.
//! Source: none needed. Tested below.

use super::Findings;
use super::wording::{number, percent, ranged, reached, seconds, signed_percent};
use etendue_lab::study::fit::Reached;
use etendue_lab::study::summary::{Summary, Tenth};

/// Returns the sentences, the most important first.
pub fn of_findings(findings: &Findings<'_>) -> Vec<String> {
    let all: Vec<&Summary> = findings.summaries.iter().map(|(_, s)| s).collect();
    let Some(&first) = all.first() else {
        return vec!["Too little was rendered for a conclusion.".to_owned()];
    };
    let mut sentences = Vec::new();
    let (wrong, right): (Vec<&Summary>, Vec<&Summary>) =
        all.iter().partition(|summary| summary.bias.is_found);
    sentences.extend(best(&right, first));
    for summary in &wrong {
        let pixels = match summary.bias.is_square_found {
            true => format!(
                ", its pixels by {} (root of relMSE)",
                percent(summary.bias.squared.value.max(0.0).sqrt())
            ),
            false => String::new(),
        };
        sentences.push(format!(
            "`{}` converges to a different image: its brightness is off by {}{pixels}, however long it renders.",
            summary.name,
            signed_percent(summary.bias.light[0], summary.bias.light[1]),
        ));
    }
    let best = right
        .iter()
        .max_by(|a, b| a.efficiency.value.total_cmp(&b.efficiency.value));
    if let Some(best) = best {
        sentences.extend(price(best));
    }
    sentences.extend(disturbance(findings));
    sentences
}

/// The share of disturbed renders above which a warning is given.
const MANY_DISTURBED: f64 = 0.1;

/// Returns a warning if other load on the machine disturbed many renders.
fn disturbance(findings: &Findings<'_>) -> Option<String> {
    let studies = &findings.report.variants;
    let disturbed: usize = studies.iter().map(|study| study.disturbed).sum();
    let levels = studies.iter().flat_map(|study| &study.levels);
    let all: usize = levels.map(|level| level.runs.len()).sum();
    (disturbed as f64 > MANY_DISTURBED * all as f64).then(|| {
        format!(
            "Other processes used the processors: {disturbed} of {all} renders were disturbed. Errors are valid, but times are longer than on an idle machine, and ratios of times less precise."
        )
    })
}

/// Returns a sentence about the most efficient of the unbiased variants.
fn best(right: &[&Summary], first: &Summary) -> Option<String> {
    let most = |a: &&&Summary, b: &&&Summary| a.efficiency.value.total_cmp(&b.efficiency.value);
    let best = right.iter().max_by(most)?;
    let rest = right.iter().filter(|other| other.name != best.name);
    let next = rest.max_by(most);
    if best.name != first.name {
        let ratio = ranged(&best.ratio, number);
        let by = match best.ratio.low > 1.0 {
            true => "is the most efficient",
            false => "seems the most efficient, but not significantly",
        };
        return Some(format!(
            "`{}` {by}: {ratio} times as efficient as `{}`.",
            best.name, first.name
        ));
    }
    let next = next?;
    let factor = 1.0 / next.ratio.value;
    let by = match next.ratio.high < 1.0 {
        true => "is the most efficient",
        false => "seems the most efficient, but not significantly",
    };
    Some(format!(
        "`{}` {by}: {} ({} to {}) times as efficient as `{}`.",
        best.name,
        number(factor),
        number(1.0 / next.ratio.high),
        number(1.0 / next.ratio.low),
        next.name
    ))
}

/// Returns a sentence about the cost of the best variant.
fn price(best: &Summary) -> Option<String> {
    let found = best
        .times
        .iter()
        .rev()
        .find(|(_, reached)| matches!(reached, Reached::At(_)));
    let now = found.map(|(target, time)| {
        let time = reached(time, false);
        format!(
            "`{}` reaches an error of {} in {time}",
            best.name,
            percent(*target)
        )
    });
    let last = best.levels.last()?;
    let longest = percent(last.rel_mse.value.max(0.0).sqrt());
    let tenth = match &best.tenth {
        Tenth::Costs(range) => Some(format!(
            "{} tenth of the {longest} that `{}` reached in {} would take {} ({} to {})",
            if now.is_some() { "a" } else { "A" },
            best.name,
            seconds(last.seconds),
            seconds(range.value),
            seconds(range.low),
            seconds(range.high)
        )),
        Tenth::Never(_) | Tenth::Unknown => None,
    };
    let text: Vec<String> = [now, tenth].into_iter().flatten().collect();
    (!text.is_empty()).then(|| text.join("; ") + ".")
}

#[cfg(test)]
mod tests {
    use super::super::sample::{findings, report};
    use super::*;

    #[test]
    fn who_is_wrong_and_what_better_costs_is_said() {
        let report = report();
        let text = of_findings(&findings(&report)).join("\n");
        for words in [
            "`bsdf, sobol` converges to a different image",
            "that `path, sobol` reached",
        ] {
            assert!(text.contains(words), "no {words} in {text}");
        }
        assert!(!text.contains("Other processes"));
        let mut busy = report.clone();
        busy.variants[0].disturbed = 12;
        let text = of_findings(&findings(&busy)).join("\n");
        assert!(text.contains("12 of 48 renders were disturbed"), "{text}");
        busy.variants.clear();
        assert!(of_findings(&findings(&busy))[0].contains("Too little"));
    }

    #[test]
    fn the_best_is_held_against_the_first_or_the_next() {
        let mut report = report();
        // A second unbiased variant, which takes twice the time.
        let mut slow = report.variants[0].clone();
        slow.variant.name = "slow".to_owned();
        let runs = slow.levels.iter_mut().flat_map(|level| &mut level.runs);
        runs.for_each(|run| run.seconds.wall *= 2.0);
        report.variants = vec![report.variants[0].clone(), slow.clone()];
        let first = of_findings(&findings(&report))[0].clone();
        assert!(
            first.contains("`path, sobol` is the most efficient: 2 ("),
            "{first}"
        );
        report.variants.reverse();
        let first = of_findings(&findings(&report))[0].clone();
        assert!(
            first.contains("`path, sobol` is the most efficient: 2 ("),
            "{first}"
        );
        assert!(first.contains("as `slow`"), "{first}");
    }
}
