//! Renders all variants, levels and seeds in turn, and compares each render with the references as soon as it is done.
//!
//! A render whose ratio of wall-clock to processor time is more than 5 % off the usual one of its level shared its
//! processors with other processes. It is repeated once, with the same seed and hence the same image: only its time is
//! measured again.
//!
//! Measure: seconds, relMSE.
//! Range: ends early if the budget runs out or the observer cancels.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::fit::TimeLaw;
use super::prepared_scene::{PreparedScene, Shot};
use super::reference::References;
use super::report::{RunReport, StudyReport};
use super::schedule::{Schedule, Task};
use super::settings::{StudySettings, Watch};
use etendue::Result;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::CONFIDENCE;
use etendue::internals::render::convergence::Look;
use etendue::internals::sampler::hash::combine;

/// The maximum relative deviation from the usual ratio for an undisturbed render.
const DISTURBED: f64 = 0.05;

/// Number of renders needed to determine the usual ratio.
const MIN_RENDERS: usize = 3;

/// The purpose of random numbers: each has separate seeds.
#[derive(Debug, Clone, Copy)]
pub enum Purpose {
    /// The two references.
    Reference,
    /// Measuring the cost of a render.
    WarmUp,
    /// The order of renders.
    Order,
    /// A render that is compared with the references.
    Level,
    /// Error bars.
    Bars,
    /// Measuring the time by the number of threads.
    Scaling,
    /// Measuring the sources of variance.
    Paths,
    /// Measuring the cost of bounces.
    Bounces,
}

/// A seed derived from the study's, a purpose and an index.
pub fn seed_for(study: u64, purpose: Purpose, index: [u64; 3]) -> u64 {
    let [a, b, c] = index;
    let values = [0x5eed, purpose as u64, a, b, c];
    values.into_iter().fold(study, combine)
}

/// Renders the tasks of a schedule.
pub struct Runner<'a> {
    settings: &'a StudySettings,
    prepared: &'a PreparedScene,
    watch: &'a Watch<'a>,
    references: &'a References,
    laws: &'a [TimeLaw],
    /// All images, by variant and level.
    pub images: Vec<Vec<Vec<Image>>>,
    /// Number of renders so far.
    done: usize,
}

/// The outcome of a block of renders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All renders are done.
    Whole,
    /// This many renders were left out for lack of time.
    OutOfTime(usize),
    /// The observer cancelled it.
    Cancelled,
}

impl<'a> Runner<'a> {
    /// A runner for the levels of a schedule.
    pub fn new(
        settings: &'a StudySettings,
        prepared: &'a PreparedScene,
        watch: &'a Watch<'a>,
        references: &'a References,
        laws: &'a [TimeLaw],
        schedule: &Schedule,
    ) -> Self {
        let levels = |seeds: &Vec<u64>| vec![Vec::new(); seeds.len()];
        Self {
            settings,
            prepared,
            watch,
            references,
            laws,
            images: schedule.seeds.iter().map(levels).collect(),
            done: 0,
        }
    }

    /// Renders a block; leaves out tasks that would leave less than `reserve` seconds.
    ///
    /// # Errors
    /// As a render.
    pub fn block(
        &mut self,
        tasks: &[Task],
        reserve: f64,
        report: &mut StudyReport,
    ) -> Result<Ended> {
        let mut left_out = 0;
        for &task in tasks {
            let expected = self.laws[task.variant].at(f64::from(task.level).exp2());
            if self.watch.left() < expected + reserve {
                left_out += 1;
            } else if !self.task(task, reserve, report)? {
                return Ok(Ended::Cancelled);
            }
        }
        Ok(match left_out {
            0 => Ended::Whole,
            count => Ended::OutOfTime(count),
        })
    }

    /// Renders a task; returns `false` if it was cancelled.
    fn task(&mut self, task: Task, reserve: f64, report: &mut StudyReport) -> Result<bool> {
        let index = [task.variant as u64, u64::from(task.level), task.seed];
        let seed = seed_for(self.settings.seed, Purpose::Level, index);
        let variant = &self.settings.variants[task.variant];
        let spp = variant.settings.least_samples() << task.level;
        let settings = self.prepared.settings(variant, spp, seed);
        let Some(mut shot) = self.prepared.render(variant, &settings, self.watch)? else {
            return Ok(false);
        };
        let study = &mut report.variants[task.variant];
        let runs = &study.levels[task.level as usize].runs;
        let mut repeated = false;
        if is_disturbed(runs, &shot) {
            if self.watch.left() < shot.seconds.wall + reserve {
                study.disturbed += 1;
            } else {
                let Some(again) = self.prepared.render(variant, &settings, self.watch)? else {
                    return Ok(false);
                };
                repeated = true;
                study.repeated += 1;
                study.disturbed += usize::from(is_disturbed(runs, &again));
                shot = again;
            }
        }
        self.take(task, seed, &shot, repeated, report);
        Ok(true)
    }

    /// Compares an image with the references and the earlier images of its level, and adds the results to the report.
    fn take(
        &mut self,
        task: Task,
        seed: u64,
        shot: &Shot,
        repeated: bool,
        report: &mut StudyReport,
    ) {
        let image = shot.film.develop();
        let references = self.references;
        let earlier = &mut self.images[task.variant][task.level as usize];
        let row = earlier.iter().map(|old| references.product(&image, old));
        let row: Vec<f64> = row.collect();
        let column = earlier.iter().map(|old| references.product(old, &image));
        let column: Vec<f64> = column.collect();
        let [rel_mse, trimmed] = references.rel_mse(&image);
        let study = &mut report.variants[task.variant];
        if task.level as usize + 1 == study.levels.len() && study.look.is_none() {
            let spp = study.levels[task.level as usize].spp;
            let error = shot.film.error(CONFIDENCE);
            let error = error.filter(|error| error.doubt.is_none());
            study.look = error.map(|error| Look::new(spp as f64, &error));
        }
        let level = &mut study.levels[task.level as usize];
        level.gram.push(row, &column, rel_mse);
        level.runs.push(RunReport {
            seed,
            order: self.done,
            seconds: shot.seconds,
            repeated,
            rel_mse,
            trimmed,
            luminance: luminance(&image),
            rejected: shot.rejected,
        });
        self.done += 1;
        earlier.push(image);
    }
}

/// The mean luminance of an image.
pub fn luminance(image: &Image) -> f64 {
    // In double precision: light is compared to nearly the rounding of a single pixel.
    let weights = [
        Rgb::new(1.0, 0.0, 0.0),
        Rgb::new(0.0, 1.0, 0.0),
        Rgb::new(0.0, 0.0, 1.0),
    ];
    let weights = weights.map(|primary| f64::from(primary.luminance()));
    let channels = image.mean().into_iter().zip(weights);
    channels.map(|(channel, weight)| channel * weight).sum()
}

/// Whether other processes disturbed a render.
fn is_disturbed(earlier: &[RunReport], shot: &Shot) -> bool {
    let mut ratios: Vec<f64> = earlier
        .iter()
        .map(|run| run.seconds.wall / run.seconds.cpu)
        .collect();
    if ratios.len() < MIN_RENDERS {
        return false;
    }
    ratios.sort_by(f64::total_cmp);
    let usual = ratios[ratios.len() / 2];
    let ratio = shot.seconds.wall / shot.seconds.cpu;
    (ratio / usual - 1.0).abs() > DISTURBED
}
