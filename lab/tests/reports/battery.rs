//! Runs the battery of hard cases on every backend, and tests that the battery detects errors.

use etendue::internals::accel::Backend;
use etendue_lab::battery::case::{Case, Effort, Trial};
use etendue_lab::battery::claim::{Claim, Relation};
use etendue_lab::battery::report::{BatteryReport, CaseReport};
use etendue_lab::battery::{BatteryObserver, BatterySettings, Unattended, cases, run};
use etendue_lab::verdict::Verdict;
use std::sync::atomic::{AtomicBool, Ordering};

/// Prints each finished case.
struct Told(&'static str);

impl BatteryObserver for Told {
    fn progress(&self, _: f64, done: &CaseReport) {
        println!("{}: {}", self.0, line(done));
    }
}

fn quick(cases: &[Case], backend: Backend) -> BatteryReport {
    let settings = BatterySettings {
        backend,
        ..BatterySettings::default()
    };
    run(cases, &settings, &Told(backend.name())).expect("threads to run on")
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

/// Whether `make nightly` runs, which has more time.
fn is_nightly() -> bool {
    std::env::var_os("ETENDUE_NIGHTLY").is_some()
}

#[test]
fn every_case_passes_on_every_backend() {
    let cases = cases(Effort::Quick);
    let mut failures = Vec::new();
    // The second layout of obvhs takes as long again, and rarely differs: by `make nightly`.
    let backends = if is_nightly() { Backend::ALL.len() } else { 2 };
    for &backend in Backend::ALL.iter().take(backends) {
        let report = quick(&cases, backend);
        let measured = report.results.len() + report.left_out.len();
        assert!(report.complete && measured == cases.len());
        for result in &report.results {
            if result.verdict != Verdict::Passed {
                failures.push(format!("{}: {}", backend.name(), line(result)));
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn the_battery_bites() {
    let measured = |numbers: Vec<f64>, claim| {
        let case = Case::new(1, "made up", claim, move |_| Ok(numbers.clone()));
        quick(&[case], Backend::ALL[0]).results[0].verdict
    };
    let noisy = |noise: f64| (0..32).map(|i| 1.0 + noise * f64::from(i).sin()).collect();
    assert_eq!(
        measured(noisy(1e-3), Claim::mean(1.0, 1e-3)),
        Verdict::Passed
    );
    // A wrong exact value fails; with noise that could hide it, the verdict is inconclusive.
    assert_eq!(
        measured(noisy(1e-3), Claim::mean(1.01, 1e-3)),
        Verdict::Failed
    );
    assert_eq!(
        measured(noisy(1.0), Claim::mean(1.01, 1e-3)),
        Verdict::Inconclusive
    );
    // A case that cannot be measured has failed.
    let error = |_: &Trial<'_>| Err(etendue::Error::render("no rays today"));
    let case = Case::new(1, "made up", Claim::exactly(0.0), error);
    let report = quick(&[case], Backend::ALL[0]);
    assert_eq!(report.results[0].verdict, Verdict::Failed);
    assert!(report.complete && !report.all_passed());
}

/// Every case, or every fourth but in `make nightly`, fails if its exact value is changed by 10 %, or by 1 if it is 0.
#[test]
fn no_case_passes_with_another_exact_number() {
    let step = if is_nightly() { 1 } else { 4 };
    let mut wrong: Vec<Case> = cases(Effort::Quick).into_iter().step_by(step).collect();
    // Upper bounds are lowered to a fifth. The changes also exceed the tolerance of 0.25 % of white materials.
    for case in &mut wrong {
        let exact = case.claim.exact;
        let away = if exact == 0.0 { 1.0 } else { 0.1 * exact };
        let down = case.claim.relation == Relation::AtMost;
        case.claim.exact = if down { 0.2 * exact } else { exact + away };
    }
    let report = quick(&wrong, Backend::ALL[0]);
    let passed = report
        .results
        .iter()
        .filter(|r| r.verdict != Verdict::Failed);
    let passed: Vec<String> = passed.map(line).collect();
    assert!(passed.is_empty(), "\n{}", passed.join("\n"));
}

#[test]
fn one_thread_finds_what_two_find() {
    let few = || {
        let mut cases = cases(Effort::Quick);
        cases.retain(|case| [21, 29, 34].contains(&case.row));
        cases
    };
    let with = |threads| {
        let settings = BatterySettings {
            threads,
            ..BatterySettings::default()
        };
        let report = run(&few(), &settings, &Unattended).expect("threads to run on");
        let bits = report.results.iter().map(|case| case.ours.to_bits());
        bits.collect::<Vec<_>>()
    };
    assert_eq!(with(1), with(2));
    let none = BatterySettings {
        threads: 0,
        ..BatterySettings::default()
    };
    assert!(run(&few(), &none, &Unattended).is_err());
}

#[test]
fn a_battery_that_is_cancelled_keeps_what_is_done() {
    struct Impatient(AtomicBool);
    impl BatteryObserver for Impatient {
        fn progress(&self, _: f64, _: &CaseReport) {
            self.0.store(true, Ordering::Relaxed);
        }
        fn is_cancelled(&self) -> bool {
            self.0.load(Ordering::Relaxed)
        }
    }
    let mut cases = cases(Effort::Quick);
    cases.retain(|case| case.row == 29);
    let settings = BatterySettings {
        threads: 1,
        ..BatterySettings::default()
    };
    let report = run(&cases, &settings, &Impatient(false.into())).expect("a thread to run on");
    assert_eq!(report.results.len(), 1);
    assert!(!report.complete && !report.all_passed());
}
