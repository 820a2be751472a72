//! The tables of a study, each with a sentence that explains it.
//!
//! Measure: stated in each sentence.
//! Range: any findings; a table that was not measured has no rows.
//! Source: none needed. Tested in `cli/tests/command/study.rs`.

use super::wording::{
    answer, number, percent, probability, ranged, rough, seconds, signed_percent,
};
use super::{Findings, answers, conclusions};
use crate::report::bench::tables as machine_tables;
use crate::report::table::{Table, numbers, words, wrapped};
use etendue_lab::study::bootstrap::Ranged;
use etendue_lab::study::costs::BOUNCE_ROUNDS;
use etendue_lab::study::summary::Summary;
use etendue_lab::study::variance::{ClassShare, LightFoundBy, is_longest};

/// Returns all tables as Markdown.
pub fn markdown(findings: &Findings<'_>) -> String {
    let report = findings.report;
    let interrupted = match report.complete {
        true => "",
        false => ", which was interrupted: what was not measured is left out",
    };
    let mut text = format!(
        "# Study of {}\n\nMeasured by `{}`{interrupted}.\n\n",
        report.scene, findings.command
    );
    for sentence in conclusions::of_findings(findings) {
        text += &format!("- {sentence}\n");
    }
    text.push('\n');
    let mut tables = vec![answers::one_by_one(findings)];
    tables.extend(answers::for_threads(findings));
    tables.extend([
        efficiency(findings),
        bias(findings),
        tenth(findings),
        paths(findings),
        bounces(findings),
        effects(findings),
        environment(findings),
        warnings(findings),
    ]);
    for table in tables.iter().filter(|table| !table.rows.is_empty()) {
        text += &table.markdown(2);
    }
    text
}

/// Returns the table of the efficiency of each variant.
pub fn efficiency(findings: &Findings<'_>) -> Table {
    let base = findings.summaries.iter().find(|(_, it)| it.is_base);
    let base = base.map_or("the first", |(_, summary)| &summary.name);
    let row = |(_, summary): &(usize, Summary)| {
        let last = summary.levels.last();
        let slope = summary.slope.as_ref();
        // The efficiency of a biased variant is not comparable, since it converges to another image.
        let of_unbiased = |range: &Ranged| match summary.bias.is_found {
            true => "biased".to_owned(),
            false if summary.is_exact() => "exact".to_owned(),
            false => ranged(range, number),
        };
        let trimmed = last.map(|last| 1.0 - last.trimmed / last.rel_mse.value);
        vec![
            summary.name.clone(),
            of_unbiased(&summary.efficiency),
            of_unbiased(&summary.ratio),
            slope.map_or("-".to_owned(), |slope| {
                ranged(&slope.b, |b| format!("{b:.2}"))
            }),
            slope
                .and_then(|slope| slope.lack_of_fit)
                .map_or("-".to_owned(), probability),
            trimmed.map_or("-".to_owned(), percent),
            seconds(summary.time.start),
            seconds(summary.time.sample),
        ]
    };
    Table {
        title: "Efficiency".to_owned(),
        caption: format!(
            "1 / (relMSE × seconds) of the longest renders, more is better, and its ratio to that of `{base}`, the first without a bias that was found. relMSE falls as 1 / tᵇ with the slope b: 1 for independent samples, more for low-discrepancy samples, less for a biased variant; a small p of fit rejects the power law. Outliers: the share of relMSE in the worst 0.1 % of the pixels. Time is start + N × sample, both for a whole image of the size that was rendered."
        ),
        head: vec![
            words("variant"),
            numbers("efficiency"),
            numbers("× first"),
            numbers("slope b"),
            numbers("p of fit"),
            numbers("outliers"),
            numbers("start"),
            numbers("sample"),
        ],
        rows: findings.summaries.iter().map(row).collect(),
    }
}

/// Returns the table of bias and of the coverage of the error bars of each variant.
pub fn bias(findings: &Findings<'_>) -> Table {
    let row = |(index, summary): &(usize, Summary)| {
        let (bias, study) = (&summary.bias, &findings.report.variants[*index]);
        let bars = study.bars.as_ref();
        let covered = bars.and_then(|bars| bars.coverage.iter().find(|c| c.confidence == 0.95));
        vec![
            summary.name.clone(),
            // Contains a non-breaking space.
            if bias.is_found {
                "found"
            } else {
                "none\u{a0}found"
            }
            .to_owned(),
            probability(bias.p),
            match bias.is_square_found {
                true => percent(bias.squared.value.max(0.0).sqrt()),
                false => format!("< {}", percent(bias.at_most)),
            },
            signed_percent(bias.light[0], bias.light[1]),
            covered
                .filter(|covered| covered.trusted.count > 0)
                .map_or("-".to_owned(), |covered| percent(covered.trusted.value())),
            bars.map_or("-".to_owned(), |bars| percent(bars.flagged)),
        ]
    };
    Table {
        title: "Bias and error bars".to_owned(),
        caption: "Bias is the error that remains however long a render runs. It is found if its p-value is below 0.001, in the squared errors of pixels or in the brightness of the whole image; its size is the root of its share of relMSE, or an upper bound with 95 % confidence; light is the relative difference in brightness of the whole image. The last columns are how often 95 % bars contain the reference, and the share of pixels whose bars are flagged as unreliable."
            .to_owned(),
        head: vec![
            words("variant"),
            words("bias"),
            numbers("p"),
            numbers("size"),
            numbers("light"),
            numbers("95 % coverage"),
            numbers("flagged"),
        ],
        rows: findings.summaries.iter().map(row).collect(),
    }
}

/// Returns the table of the cost of a tenth of the error.
pub fn tenth(findings: &Findings<'_>) -> Table {
    let row = |(_, summary): &(usize, Summary)| {
        let last = summary.levels.last();
        let now = last.map(|last| (summary.own_error * last.rel_mse.value.max(0.0)).sqrt());
        vec![
            summary.name.clone(),
            now.map_or("-".to_owned(), percent),
            last.map_or("-".to_owned(), |last| {
                seconds(summary.own_time.at(last.spp as f64))
            }),
            now.map_or("-".to_owned(), |now| percent(0.1 * now)),
            answer(&summary.tenth),
        ]
    };
    Table {
        title: "Cost of a tenth of the error".to_owned(),
        caption: "The error of the longest renders, and the time for a tenth of it, at the scene's own size: by the law of independent samples where that fits, a hundred times as long; by the steeper slope where it was steeper so far, with a hundred times as the upper end, since it need not stay so. Time does not reduce bias: the light lost by a limit of bounces or by the technique, and the rounding of single precision (about 10⁻⁶), remain."
            .to_owned(),
        head: vec![
            words("variant"),
            numbers("error"),
            numbers("time"),
            numbers("a tenth"),
            words("time for a tenth"),
        ],
        rows: findings.summaries.iter().map(row).collect(),
    }
}

/// Returns the conclusions and the answers for a terminal.
pub fn answers_in_words(findings: &Findings<'_>) -> String {
    let mut text = format!("{}\n\n", findings.report.scene);
    for sentence in conclusions::of_findings(findings) {
        text += &wrapped(&format!("- {sentence}"), 80);
    }
    text.push('\n');
    let tables = [
        Some(answers::one_by_one(findings)),
        answers::for_threads(findings),
    ];
    for table in tables
        .into_iter()
        .flatten()
        .filter(|table| !table.rows.is_empty())
    {
        text += &format!(
            "{}\n\n{}\n{}\n",
            table.title,
            wrapped(&table.caption, 80),
            table.grid()
        );
    }
    text
}

/// Describes a class of paths.
pub fn path_class(bounces: usize, found: LightFoundBy) -> String {
    let more = if is_longest(bounces) { " or more" } else { "" };
    match found {
        LightFoundBy::Seen => "seen directly".to_owned(),
        LightFoundBy::Scattering => format!("{bounces}{more}, BSDF sampled"),
        LightFoundBy::LightSampling => format!("{bounces}{more}, light sampled"),
    }
}

/// Whether a class of paths has at least a thousandth of the variance or of the light.
pub fn matters(class: &ClassShare) -> bool {
    class.variance.abs().max(class.energy.abs()) >= 1e-3
}

/// Returns the table of the variance of each variant by class of paths.
pub fn paths(findings: &Findings<'_>) -> Table {
    let mut rows = Vec::new();
    for study in &findings.report.variants {
        let classes = study.paths.iter().flat_map(|paths| &paths.classes);
        let classes = classes.filter(|class| matters(class));
        rows.extend(classes.map(|class| {
            vec![
                study.variant.name.clone(),
                path_class(class.bounces, class.found),
                signed_percent(class.variance, 2.0 * class.variance_error),
                percent(class.energy),
            ]
        }));
    }
    Table {
        title: "Where the variance comes from".to_owned(),
        caption: "Shares of the variance of one sample and of the light, by the number of bounces and by the technique that found the light. A class with much variance and little light calls for a better technique; a share below 0 offsets others; classes of less than 0.1 % of both are left out. ± has a confidence of 95 %."
            .to_owned(),
        head: vec![
            words("variant"),
            words("paths, by bounces"),
            numbers("of the variance"),
            numbers("of the light"),
        ],
        rows,
    }
}

/// Returns the table of the cost of each bounce of the first variant.
pub fn bounces(findings: &Findings<'_>) -> Table {
    let first = findings.report.variants.first();
    let row = |cost: &etendue_lab::study::lengths::BounceCost| {
        let bounces = match cost.bounces {
            Some(0) => "emitters only".to_owned(),
            Some(limit) => format!("bounce {limit}"),
            None => "all further bounces".to_owned(),
        };
        let [median, min, max] = [cost.time.median, cost.time.min, cost.time.max].map(percent);
        vec![
            bounces,
            format!("{median} ({min} to {max})"),
            percent(cost.energy),
        ]
    };
    let costs = first.map_or(Default::default(), |study| study.bounces.as_slice());
    Table {
        title: "What each bounce costs".to_owned(),
        caption: format!(
            "The share of the time and of the light of `{}` that each bounce adds: renders with increasing limits and the same random numbers, in turn; the median of {} rounds, with minimum and maximum. A limit would lose the light of the bounces beyond it.",
            first.map_or("", |study| &study.variant.name),
            BOUNCE_ROUNDS
        ),
        head: vec![
            words("up to"),
            numbers("of the time"),
            numbers("of the light"),
        ],
        rows: costs.iter().map(row).collect(),
    }
}

/// Returns the table of the cost of each effect of the scene.
pub fn effects(findings: &Findings<'_>) -> Table {
    let row = |share: &etendue_lab::study::report::EffectShare| {
        let [median, min, max] = [share.time.median, share.time.min, share.time.max].map(percent);
        vec![
            share.effect.to_owned(),
            format!("{median} ({min} to {max})"),
            signed_percent(share.energy[0], share.energy_margin),
        ]
    };
    Table {
        title: "What each effect costs".to_owned(),
        caption: "The share of the time and of the light that is gone without the effect, by rendering with and without it in turn (`etendue plan --cost` measures the same for longer), with the integrator `path` at its defaults whatever the variants are, without light paths and shared paths. Below 0, it saves time: paths end sooner with it. Times are the median of few rounds, with minimum and maximum; ± has a confidence of 95 %."
            .to_owned(),
        head: vec![words("effect"), numbers("of the time"), numbers("of the light")],
        rows: findings.report.effects.iter().map(row).collect(),
    }
}

/// Returns the table of the machine and the method of measurement.
pub fn environment(findings: &Findings<'_>) -> Table {
    let report = findings.report;
    let mut rows = machine_tables::machine_rows(findings.machine, report.version);
    let mut add = |what: &str, which: String| rows.push(vec![what.to_owned(), which]);
    add("threads of the renders", report.threads.to_string());
    add("seed of the study", report.seed.to_string());
    add(
        "time",
        format!(
            "{} of a budget of {}",
            seconds(report.seconds),
            seconds(report.budget)
        ),
    );
    if let Some(reference) = &report.reference {
        let [one, two] = reference.seconds.map(|s| seconds(s.wall));
        add(
            "references",
            format!(
                "two of {} samples per pixel by {}, {}, without a limit of bounces, in {one} and {two}; the error of each is {} (root of relMSE)",
                reference.spp,
                reference.integrator,
                reference.sampler,
                percent(reference.noise.rel_mse.sqrt())
            ),
        );
    }
    for (index, summary) in &findings.summaries {
        let study = &report.variants[*index];
        let runs: usize = summary.levels.iter().map(|level| level.runs).sum();
        let seeds: Vec<String> = summary
            .levels
            .iter()
            .map(|level| level.runs.to_string())
            .collect();
        let were = |count: usize| if count == 1 { "was" } else { "were" };
        add(
            &summary.name,
            format!(
                "{runs} renders ({} from the shortest to the longest), of which {} {} repeated because another process used a processor, and {} remained disturbed; {} processors busy on average; structure built in {}",
                seeds.join(", "),
                study.repeated,
                were(study.repeated),
                study.disturbed,
                rough(summary.processors),
                seconds(study.build)
            ),
        );
    }
    Table {
        title: "How it was measured".to_owned(),
        caption: "Times of another machine differ; ratios differ much less. `study.json` has every render, `study.csv` a line for each."
            .to_owned(),
        head: vec![words("what"), words("which")],
        rows,
    }
}

/// Returns the table of notes and warnings.
pub fn warnings(findings: &Findings<'_>) -> Table {
    let report = findings.report;
    let runs = report.variants.iter().flat_map(|study| &study.levels);
    let rejected: u64 = runs
        .flat_map(|level| &level.runs)
        .map(|run| run.rejected)
        .sum();
    let biases = report.variants.iter().flat_map(|study| {
        let name = &study.variant.name;
        let all = study.variant.bias.iter();
        all.map(move |bias| format!("biased by its settings: {name}: {bias}"))
    });
    let all = report.warnings.iter().cloned().chain(biases);
    let mut rows: Vec<Vec<String>> = all.map(|warning| vec![warning]).collect();
    rows.push(vec![match rejected {
        0 => "all samples were finite".to_owned(),
        count => format!("{count} samples were not finite, and were left out"),
    }]);
    Table {
        title: "Notes and warnings".to_owned(),
        caption: "Messages from reading and rendering the scene.".to_owned(),
        head: vec![words("what")],
        rows,
    }
}
