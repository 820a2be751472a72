//! The lessons: each topic's numbers against their exact values, by their own verdicts; the content of its page; and that
//! its numbers depend on nothing but the seed.

use etendue_lab::lesson::page::{Finding, Page};
use etendue_lab::lesson::topic::{LessonObserver, LessonSettings, NullLessonObserver, Topic};
use etendue_lab::lesson::{TOPICS, run};
use etendue_lab::plot::Plot;
use etendue_lab::verdict::Verdict;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The share of the full sample count; every verdict keeps its statistical power.
const EFFORT: f64 = 0.1;

fn settings(seed: u64) -> LessonSettings {
    LessonSettings {
        seed,
        effort: EFFORT,
        ..LessonSettings::default()
    }
}

fn page(topic: &Topic, settings: &LessonSettings) -> Page {
    let page = run(topic, settings, &NullLessonObserver).expect("the topic runs");
    page.expect("the lesson was not cancelled")
}

fn topic(name: &str) -> &'static Topic {
    let found = TOPICS.iter().find(|topic| topic.name == name);
    found.expect("there is such a topic")
}

fn plots(page: &Page) -> impl Iterator<Item = &Plot> {
    page.findings.iter().flat_map(|finding| match finding {
        Finding::Plots { plots } => plots.as_slice(),
        _ => &[],
    })
}

/// Runs a topic, and checks that every number passes and that the page is complete.
fn holds(name: &str) -> Page {
    let topic = topic(name);
    let page = page(topic, &settings(0));
    assert!(page.numbers().count() >= 3, "{name}: too few numbers");
    for number in page.numbers() {
        assert_eq!(number.verdict, Verdict::Passed, "{name}: {number:?}");
    }
    assert!(plots(&page).count() >= 1, "{name}: no plot");
    for plot in plots(&page) {
        let drawn = plot.series.iter().flat_map(|series| &series.points);
        let finite = drawn.filter(|point| point.iter().all(|x| x.is_finite()));
        assert!(
            finite.count() > 1,
            "{name}: too few finite points in {}",
            plot.title
        );
        assert!(!plot.reading.is_empty(), "{name}: {}", plot.title);
    }
    assert!(!page.claim.is_empty() && !page.experiment.is_empty() && !page.formulas.is_empty());
    page
}

/// Defines a test for each topic, so that they run in parallel.
macro_rules! topics_hold {
    ($($test:ident: $name:literal),* $(,)?) => {
        $(#[test]
        fn $test() {
            holds($name);
        })*

        #[test]
        fn every_topic_is_tested() {
            let names: Vec<&str> = TOPICS.iter().map(|topic| topic.name).collect();
            assert_eq!(names, [$($name),*]);
        }
    };
}

topics_hold! {
    dice: "dice",
    pdf_cdf: "pdf-cdf",
    power_function: "power-function",
    disk: "disk",
    hemisphere: "hemisphere",
    phong: "phong",
    quadrature: "quadrature",
    convergence: "convergence",
    importance: "importance",
    stratified: "stratified",
    roulette: "roulette",
    window: "window",
    direct: "direct",
    lights: "lights",
    light_paths: "light-paths",
    reuse: "reuse",
    ladder: "ladder",
}

/// The names and measured values of a page's numbers, without timings.
fn numbers(page: &Page) -> Vec<(String, f64)> {
    page.numbers()
        .map(|number| (number.name.clone(), number.ours))
        .collect()
}

#[test]
fn results_depend_on_the_seed_but_not_on_thread_count() {
    let dice = topic("dice");
    let with = |seed: u64, threads: usize| {
        let settings = LessonSettings {
            threads,
            ..settings(seed)
        };
        page(dice, &settings)
    };
    let (one, two, other) = (with(7, 1), with(7, 2), with(8, 2));
    assert_eq!(numbers(&one), numbers(&two));
    assert_eq!(
        plots(&one).collect::<Vec<_>>(),
        plots(&two).collect::<Vec<_>>()
    );
    assert_ne!(numbers(&one), numbers(&other));
}

#[test]
fn out_of_range_settings_are_usage_errors() {
    for wrong in [
        LessonSettings {
            threads: 0,
            ..settings(0)
        },
        LessonSettings {
            effort: 0.0,
            ..settings(0)
        },
        LessonSettings {
            effort: 1.5,
            ..settings(0)
        },
        LessonSettings {
            effort: f64::NAN,
            ..settings(0)
        },
    ] {
        let error = run(topic("dice"), &wrong, &NullLessonObserver).expect_err("out of range");
        assert_eq!(error.kind(), etendue::ErrorKind::Usage);
    }
}

/// Cancels a lesson after `patience` calls of `is_cancelled`.
struct Impatient {
    patience: u32,
    asked: AtomicU32,
    ended: AtomicBool,
}

impl LessonObserver for Impatient {
    fn is_cancelled(&self) -> bool {
        let asked = self.asked.fetch_add(1, Ordering::Relaxed);
        if asked >= self.patience {
            self.ended.store(true, Ordering::Relaxed);
        }
        self.ended.load(Ordering::Relaxed)
    }
}

#[test]
fn cancelled_lesson_returns_no_page() {
    for topic in TOPICS {
        for patience in [0, 3] {
            let observer = Impatient {
                patience,
                asked: AtomicU32::new(0),
                ended: AtomicBool::new(false),
            };
            let page = run(topic, &settings(0), &observer).expect("cancelling is no error");
            assert!(page.is_none(), "{}", topic.name);
        }
    }
}
