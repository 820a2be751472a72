//! Runs the battery of hard cases on every backend, and tests that the battery detects errors.

use crate::common::nightly::is_nightly;
use etendue::internals::accel::Backend;
use etendue_lab::battery::case::{Case, Effort, Trial};
use etendue_lab::battery::claim::{Claim, Relation};
use etendue_lab::battery::report::{BatteryReport, CaseReport};
use etendue_lab::battery::{BatteryObserver, BatterySettings, NullBatteryObserver, cases, run};
use etendue_lab::verdict::Verdict;
use std::sync::OnceLock;
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

/// All cases but those of Markov chains, which take most of the time; and in `make nightly` all.
fn cases_to_measure() -> Vec<Case> {
    let mut some = cases(Effort::Quick);
    some.retain(|case| is_nightly() || !case.name.ends_with("by mlt"));
    some
}

/// The measurements of the cases on the default backend, which two tests share.
fn all_measured() -> &'static BatteryReport {
    static REPORT: OnceLock<BatteryReport> = OnceLock::new();
    REPORT.get_or_init(|| quick(&cases_to_measure(), Backend::ALL[0]))
}

/// Fails if a case of the report was not measured or has not passed.
fn assert_passed(report: &BatteryReport, cases: usize) {
    let measured = report.results.len() + report.left_out.len();
    assert!(report.complete && measured == cases);
    let failures = report
        .results
        .iter()
        .filter(|result| result.verdict != Verdict::Passed);
    let failures: Vec<String> = failures.map(line).collect();
    assert!(
        failures.is_empty(),
        "{}:\n{}",
        report.backend,
        failures.join("\n")
    );
}

#[test]
fn every_case_passes_on_the_default_backend() {
    assert_passed(all_measured(), cases_to_measure().len());
}

/// Every sixteenth case, beginning with another one for each backend; and in `make nightly` every case. The hits of rays, which
/// differ from one backend to the next, are tested in `tests/tracing/` on all of them.
#[test]
fn cases_pass_on_every_other_backend() {
    let step = if is_nightly() { 1 } else { 16 };
    for (index, &backend) in Backend::ALL.iter().enumerate().skip(1) {
        let cases = cases_to_measure().into_iter();
        let some: Vec<Case> = cases.skip(index % step).step_by(step).collect();
        assert_passed(&quick(&some, backend), some.len());
    }
}

#[test]
fn wrong_exact_values_and_failed_measurements_fail() {
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

/// The measured numbers of every case contradict an exact value that is changed by 10 %, or by 1 if it is 0. Upper bounds
/// are lowered to a fifth. The changes also exceed the tolerance of 0.25 % of white materials.
#[test]
fn every_case_fails_with_a_perturbed_exact_value() {
    let passed = all_measured().results.iter().filter(|result| {
        let exact = result.claim.exact;
        let wrong = match result.claim.relation {
            Relation::AtMost => 0.2 * exact,
            Relation::Equal if exact == 0.0 => 1.0,
            Relation::Equal => 1.1 * exact,
        };
        let claim = Claim {
            exact: wrong,
            ..result.claim
        };
        claim.judge(&result.numbers).verdict != Verdict::Failed
    });
    let passed: Vec<String> = passed.map(line).collect();
    assert!(passed.is_empty(), "\n{}", passed.join("\n"));
}

#[test]
fn results_are_bit_identical_on_one_and_two_threads() {
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
        let report = run(&few(), &settings, &NullBatteryObserver).expect("threads to run on");
        let bits = report.results.iter().map(|case| case.ours.to_bits());
        bits.collect::<Vec<_>>()
    };
    assert_eq!(with(1), with(2));
    let none = BatterySettings {
        threads: 0,
        ..BatterySettings::default()
    };
    assert!(run(&few(), &none, &NullBatteryObserver).is_err());
}

#[test]
fn cancelled_battery_keeps_completed_cases() {
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
