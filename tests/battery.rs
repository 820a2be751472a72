//! The battery of hard cases on every backend, and that it bites.

use etendue::accel::Backend;
use etendue::battery::case::{Case, Effort};
use etendue::battery::claim::{Claim, Verdict};
use etendue::battery::report::{BatteryReport, CaseReport};
use etendue::battery::{BatterySettings, Unattended, cases, run};

fn quick(cases: &[Case], backend: Backend) -> BatteryReport {
    let settings = BatterySettings {
        backend,
        ..BatterySettings::default()
    };
    run(cases, &settings, &Unattended).expect("threads to run on")
}

fn line(case: &CaseReport) -> String {
    format!(
        "row {}, {}: {:?}, {:.9e}, exact {:.9e}, off by {:.1e}, standard error {:.1e} of {:.1e}, {:.2} s {}",
        case.row,
        case.name,
        case.verdict,
        case.ours,
        case.claim.exact,
        case.error,
        case.standard_error.unwrap_or(f64::NAN),
        case.claim.power_limit.unwrap_or(f64::NAN),
        case.seconds,
        case.failure.as_deref().unwrap_or(""),
    )
}

#[test]
fn every_case_passes_on_every_backend() {
    let cases = cases(Effort::Quick);
    let mut failures = Vec::new();
    for &backend in Backend::ALL {
        let report = quick(&cases, backend);
        assert!(report.complete && report.results.len() == cases.len());
        for result in &report.results {
            println!("{}: {}", backend.name(), line(result));
            if result.verdict != Verdict::Passed {
                failures.push(format!("{}: {}", backend.name(), line(result)));
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}
