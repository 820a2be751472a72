//! The conclusions of a study in a few sentences: what accuracy costs, which variant is most efficient, which are biased.
//!
//! Measure: as in `study/summary.rs`.
//! Range: any summaries; if there are none, a sentence that too little was rendered.
//! Source: none needed. Tested below.

use super::Findings;
use super::wording::{number, percent, ranged, seconds_ranged, short_answer, signed_percent};
use crate::recommendation::advice;
use etendue_lab::study::answer::Answer;
use etendue_lab::study::bootstrap::Ranged;
use etendue_lab::study::summary::Summary;

/// Returns the sentences, the most important first.
pub fn of_findings(findings: &Findings<'_>) -> Vec<String> {
    let all: Vec<&Summary> = findings.summaries.iter().map(|(_, s)| s).collect();
    let Some(base) = all.iter().find(|summary| summary.is_base) else {
        return vec!["Too little was rendered for a conclusion.".to_owned()];
    };
    // Without noise there is no efficiency to compare.
    let is_exact = all.iter().any(|summary| summary.is_exact());
    let mut sentences: Vec<String> = price(findings).into_iter().collect();
    let (wrong, right): (Vec<&Summary>, Vec<&Summary>) =
        all.iter().partition(|summary| summary.bias.is_found);
    sentences.extend(best(&right, base).filter(|_| !is_exact));
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
    sentences.extend(integrators(findings).filter(|_| !is_exact));
    sentences.extend(disturbance(findings));
    sentences
}

/// Returns the advice on the integrator, if several were compared.
fn integrators(findings: &Findings<'_>) -> Option<String> {
    let auto = findings.recommendation?;
    let kind = |index: usize| findings.report.variants[index].variant.integrator;
    let right = findings
        .summaries
        .iter()
        .filter(|(_, it)| !it.bias.is_found);
    // Ratios are to the first variant without bias.
    let (base, _) = right.clone().find(|(_, it)| it.is_base)?;
    let others = right.filter(|(index, _)| kind(*index) != kind(*base));
    let gains: Vec<(&str, Ranged)> = others.map(|(index, it)| (kind(*index), it.ratio)).collect();
    let advice = advice(kind(*base), &gains, Some(auto));
    Some(format!("On the integrator: {advice}."))
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
fn best(right: &[&Summary], base: &Summary) -> Option<String> {
    let most = |a: &&&Summary, b: &&&Summary| a.efficiency.value.total_cmp(&b.efficiency.value);
    let best = right.iter().max_by(most)?;
    let rest = right.iter().filter(|other| other.name != best.name);
    let next = rest.max_by(most);
    if best.name != base.name {
        let ratio = ranged(&best.ratio, number);
        let by = match best.ratio.low > 1.0 {
            true => "is the most efficient",
            false => "seems the most efficient, but not significantly",
        };
        return Some(format!(
            "`{}` {by}: {ratio} times as efficient as `{}`.",
            best.name, base.name
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

/// The error whose price is told first, and those told after it.
const FIRST_ERROR: f64 = 0.01;
const OTHER_ERRORS: [f64; 2] = [0.1, 0.001];

/// Returns the variant that reaches [`FIRST_ERROR`] first, of those without a known bias if there are any, with its answer.
pub fn quickest<'a>(findings: &'a Findings<'_>) -> Option<(&'a Summary, &'a Answer)> {
    let all = findings.summaries.iter();
    let answered = all.filter_map(|(index, summary)| {
        let (_, answer) = summary
            .answers
            .iter()
            .find(|(target, _)| *target == FIRST_ERROR)?;
        let study = &findings.report.variants[*index];
        let is_biased = summary.bias.is_found || !study.variant.bias.is_empty();
        Some((is_biased, answer.seconds()?, summary, answer))
    });
    let quickest = answered.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    quickest.map(|(_, _, summary, answer)| (summary, answer))
}

/// Returns the sentence about the time to 1 % and to other errors, by the quickest variant.
fn price(findings: &Findings<'_>) -> Option<String> {
    let (summary, first) = quickest(findings)?;
    let report = findings.report;
    let (width, height) = report.full_size;
    let time = match first {
        Answer::Measured(range) | Answer::Law(range) => {
            let about = if matches!(first, Answer::Law(_)) {
                "about "
            } else {
                ""
            };
            format!("{about}{}", seconds_ranged(range))
        }
        Answer::Exact(_) => {
            return Some(format!(
                "`{}` has no noise in this scene: its image is exact after {}.",
                summary.name,
                short_answer(first)?
            ));
        }
        other => short_answer(other)?,
    };
    let others = OTHER_ERRORS.iter().filter_map(|error| {
        let (_, answer) = summary.answers.iter().find(|(target, _)| target == error)?;
        Some(format!("{} {}", percent(*error), short_answer(answer)?))
    });
    let others: Vec<String> = others.collect();
    let others = match others.is_empty() {
        true => String::new(),
        false => format!("; {}", others.join(", ")),
    };
    let among = match findings.summaries.len() {
        1 => String::new(),
        count => format!(", the quickest of {count} variants"),
    };
    Some(format!(
        "An error of {} takes {time} by `{}`{among}, for {width} × {height} pixels on {} threads{others}.",
        percent(FIRST_ERROR),
        summary.name,
        report.threads
    ))
}

#[cfg(test)]
mod tests {
    use super::super::sample::{findings, report};
    use super::*;

    #[test]
    fn conclusions_report_bias_time_to_error_and_disturbance() {
        let report = report();
        let text = of_findings(&findings(&report)).join("\n");
        for words in [
            "`bsdf, sobol` converges to a different image",
            "An error of 1 % takes about",
            "by `path, sobol`, the quickest of 2 variants, for 16 × 16 pixels on 2 threads; 10 % ",
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
    fn biased_first_variant_is_no_base_of_comparison() {
        let mut report = report();
        let mut slow = report.variants[0].clone();
        slow.variant.name = "slow".to_owned();
        let runs = slow.levels.iter_mut().flat_map(|level| &mut level.runs);
        runs.for_each(|run| run.seconds.wall *= 2.0);
        // The biased variant comes first.
        report.variants.reverse();
        report.variants.push(slow);
        let text = of_findings(&findings(&report)).join("\n");
        assert!(
            text.contains("`path, sobol` is the most efficient: 2 ("),
            "{text}"
        );
        assert!(text.contains("times as efficient as `slow`"), "{text}");
    }

    #[test]
    fn noise_free_variants_are_not_compared() {
        let mut report = report();
        report.variants.push(report.variants[0].clone());
        for study in &mut report.variants {
            study.variant.name += " exact";
            for level in &mut study.levels {
                let mut gram = etendue_lab::study::gram::Gram::default();
                for seed in 0..level.runs.len() {
                    gram.push(vec![0.0; seed], &vec![0.0; seed], 0.0);
                }
                level.gram = gram;
            }
        }
        let found = findings(&report);
        let text = of_findings(&found).join("\n");
        assert!(text.contains("its image is exact after"), "{text}");
        assert!(!text.contains("efficient"), "{text}");
        let efficiency = super::super::tables::efficiency(&found);
        assert!(efficiency.rows.iter().all(|row| row[1] == "exact"));
    }

    #[test]
    fn best_variant_is_compared_with_first_or_runner_up() {
        let mut report = report();
        // A second unbiased variant, which takes twice the time.
        let mut slow = report.variants[0].clone();
        slow.variant.name = "slow".to_owned();
        let runs = slow.levels.iter_mut().flat_map(|level| &mut level.runs);
        runs.for_each(|run| run.seconds.wall *= 2.0);
        report.variants = vec![report.variants[0].clone(), slow.clone()];
        let first = of_findings(&findings(&report))[1].clone();
        assert!(
            first.contains("`path, sobol` is the most efficient: 2 ("),
            "{first}"
        );
        report.variants.reverse();
        let first = of_findings(&findings(&report))[1].clone();
        assert!(
            first.contains("`path, sobol` is the most efficient: 2 ("),
            "{first}"
        );
        assert!(first.contains("as `slow`"), "{first}");
    }
}
