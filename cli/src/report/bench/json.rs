//! A benchmark as JSON: the report and the numbers derived from it.
//!
//! Measure: as stated in the report; ratios of times.
//! Range: any report; non-finite numbers are `null`.
//! Source: none needed. Tested in `cli/tests/command/bench.rs`.

use super::compare::{self, Fastest, Mean};
use etendue_lab::bench::report::{BenchReport, SceneReport};
use serde::Serialize;

/// The JSON document.
#[derive(Serialize)]
struct BenchDocument<'a> {
    command: &'a str,
    #[serde(flatten)]
    report: &'a BenchReport,
    derived: Derived<'a>,
}

#[derive(Serialize)]
struct Derived<'a> {
    /// The backend that ratios are relative to.
    reference: Option<&'static str>,
    /// The means over all scenes.
    mean: Vec<Mean>,
    scenes: Vec<DerivedScene<'a>>,
}

#[derive(Serialize)]
struct DerivedScene<'a> {
    name: &'a str,
    fastest: Vec<Fastest<'a>>,
    mean: Vec<Mean>,
    /// The speedup of the render with all threads over one thread.
    speedup: Option<f64>,
}

/// Returns the report with its command as one object.
pub fn of_report(report: &BenchReport, command: &str) -> String {
    let backends = compare::backends(&report.scenes);
    let scenes = report.scenes.iter();
    let document = BenchDocument {
        command,
        report,
        derived: Derived {
            reference: backends.first().map(|backend| backend.name()),
            mean: compare::overall(report),
            scenes: scenes
                .map(|scene| scene_of(scene, report.threads))
                .collect(),
        },
    };
    let json = serde_json::to_string_pretty(&document).expect("plain data always serialises");
    json + "\n"
}

fn scene_of(scene: &SceneReport, threads: usize) -> DerivedScene<'_> {
    DerivedScene {
        name: &scene.name,
        fastest: compare::fastest(scene),
        mean: compare::means(scene),
        speedup: scene
            .overhead
            .as_ref()
            .map(|overhead| overhead.speedup(threads)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::report;
    use serde_json::Value;

    #[test]
    fn json_contains_report_and_derived_values() {
        let text = super::of_report(&report(), "etendue bench box");
        let json: Value = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(
            (&json["command"], &json["version"]),
            (&"etendue bench box".into(), &"1.2.3".into())
        );
        let trace = &json["scenes"][0]["traces"][1];
        assert_eq!(
            (&trace["kind"], &trace["width"]),
            (&"camera".into(), &1.into())
        );
        assert_eq!(
            (&trace["precision"], &trace["coherent"]),
            (&"fast".into(), &false.into())
        );
        assert_eq!(trace["nanoseconds"]["median"], 50.0);
        assert_eq!(trace["millions_per_second"], 20.0);
        let derived = &json["derived"]["scenes"][0];
        assert_eq!(derived["fastest"][1]["times_reference"], 2.0);
        assert_eq!(derived["fastest"][1]["nanoseconds"]["median"], 100.0);
        // Two threads, each of which takes 600 ns for what a single one does in 500 ns.
        let speedup = derived["speedup"].as_f64().expect("a number");
        assert!((speedup - 2.0 * 500.0 / 600.0).abs() < 1e-12, "{speedup}");
    }
}
