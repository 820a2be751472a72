//! A study as CSV: one line per render.
//!
//! Measure: seconds, samples per pixel, relMSE; stated in the header.
//! Range: any report. Texts are quoted, as names of variants contain commas.
//! Source: RFC 4180. Tested below.

use etendue_lab::study::report::StudyReport;
use std::fmt::Write;

const HEAD: &str = "variant,integrator,sampler,backend,precision,light_paths,reuse,kernel,max_bounces,spp,seed,order,\
                    seconds,cpu_seconds,repeated,rel_mse,rel_mse_trimmed,luminance,rejected\n";

/// Returns all renders that were compared with the references.
pub fn of_report(report: &StudyReport) -> String {
    let mut text = HEAD.to_owned();
    for study in &report.variants {
        let variant = &study.variant;
        let limit = variant.max_bounces.map(|limit| limit.to_string());
        let settings = [
            &quoted(&variant.name),
            variant.integrator,
            variant.sampler,
            variant.backend,
            variant.precision,
            variant.light_paths,
            variant.reuse,
            variant.kernel.unwrap_or_default(),
            &limit.unwrap_or_default(),
        ]
        .join(",");
        for level in &study.levels {
            for run in &level.runs {
                writeln!(
                    text,
                    "{settings},{},{},{},{},{},{},{},{},{},{}",
                    level.spp,
                    run.seed,
                    run.order,
                    run.seconds.wall,
                    run.seconds.cpu,
                    run.repeated,
                    run.rel_mse,
                    run.trimmed,
                    run.luminance,
                    run.rejected
                )
                .expect("writing to a string cannot fail");
            }
        }
    }
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::super::sample::report;

    #[test]
    fn csv_has_one_row_per_render() {
        let report = report();
        let text = super::of_report(&report);
        let mut lines = text.lines();
        let columns = lines.next().expect("a head").split(',').count();
        let first = lines.next().expect("a render");
        assert!(first.starts_with("\"path, sobol\",path,sobol,"), "{first}");
        let name = first.replace("\"path, sobol\"", "name");
        assert_eq!(name.split(',').count(), columns);
        let runs = report.variants.iter().flat_map(|v| &v.levels);
        assert_eq!(
            lines.count() + 1,
            runs.map(|level| level.runs.len()).sum::<usize>()
        );
    }
}
