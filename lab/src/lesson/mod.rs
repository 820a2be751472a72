//! The classic course on Monte Carlo integration as experiments: each topic makes a claim, tests it, and compares the
//! numbers with their exact values.
//!
//! A topic returns a [`page::Page`], which is independent of HTML and terminals. Random numbers, distributions and
//! quadrature come from `sampling/` and `bsdf/`, images from `render/`: a lesson uses the renderer's own code, not a
//! copy of it.
//!
//! Measure: stated by each topic.
//! Range: settings as in [`topic::LessonSettings`]. All results except times and renders with a time budget are the same for
//! the same seed, on any number of threads.
//! Source: docs/lessons.md. Tested in `lab/tests/reports/lesson.rs`.

mod convergence;
mod dice;
mod direct;
mod disk;
mod error_curve;
mod hemisphere;
mod importance;
mod ladder;
mod lesson_scene;
mod light_paths;
mod lights;
mod mirrored_lamp;
pub mod number;
pub mod page;
mod pdf_cdf;
mod phong;
mod power;
mod quadrature;
mod reuse;
mod roulette;
mod shared_floor;
mod stratified;
pub mod topic;
mod uniform;
mod window;

use etendue::{Error, Result};
use page::Page;
use topic::{Lesson, LessonObserver, LessonSettings, Topic};

/// All topics, in the order of the course.
pub const TOPICS: &[Topic] = &[
    dice::TOPIC,
    pdf_cdf::TOPIC,
    power::TOPIC,
    disk::TOPIC,
    hemisphere::TOPIC,
    phong::TOPIC,
    quadrature::TOPIC,
    convergence::TOPIC,
    importance::TOPIC,
    stratified::TOPIC,
    roulette::TOPIC,
    window::TOPIC,
    direct::TOPIC,
    lights::TOPIC,
    light_paths::TOPIC,
    reuse::TOPIC,
    ladder::TOPIC,
];

/// Runs a topic; `None` if the observer cancelled it.
///
/// # Errors
/// Settings out of their range, a render that fails, or threads that cannot be started.
pub fn run(
    topic: &Topic,
    settings: &LessonSettings,
    observer: &dyn LessonObserver,
) -> Result<Option<Page>> {
    if settings.threads == 0 {
        return Err(Error::usage("threads must be at least 1"));
    }
    if !(settings.effort > 0.0 && settings.effort <= 1.0) {
        return Err(Error::usage("the effort must be above 0 and at most 1"));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .map_err(|error| Error::render("cannot start the threads").because(error))?;
    let lesson = Lesson::new(topic.name, *settings, observer);
    let page = pool.install(|| (topic.run)(&lesson))?;
    Ok((!observer.is_cancelled()).then_some(page))
}
