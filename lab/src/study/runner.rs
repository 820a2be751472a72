//! Renders of all variants, levels and seeds, in turn, each held against the references as soon as it is done.
//!
//! A render whose ratio of passed to worked time is more than 5 % off the usual one of its kind shared its processors with
//! something else. It is repeated once, with the same seed, hence to the same picture: only its time counts anew.
//!
//! Measure: seconds, relMSE.
//! Range: a budget that runs out ends it early; so does whoever watches.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::fit::TimeLaw;
use super::prepared_scene::{PreparedScene, Shot};
use super::reference::References;
use super::report::{RunReport, StudyReport};
use super::schedule::Task;
use super::settings::{StudySettings, Watch};
use etendue::Result;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::sampler::hash::combine;

/// How far off the usual a render may be that nothing disturbed.
const DISTURBED: f64 = 0.05;

/// Renders that tell what is usual.
const USUAL: usize = 3;

/// What random numbers are for: each has seeds of its own.
#[derive(Debug, Clone, Copy)]
pub enum Purpose {
    /// The two references.
    Reference,
    /// Finding out what a render costs.
    WarmUp,
    /// The order of renders.
    Order,
    /// A render that is held against the references.
    Level,
    /// Error bars.
    Bars,
    /// Pictures to look at.
    Picture,
    /// Where variance comes from.
    Paths,
    /// What bounces cost.
    Bounces,
}

/// A seed for the `index`th of something.
pub fn seed_for(study: u64, purpose: Purpose, index: [u64; 3]) -> u64 {
    let [a, b, c] = index;
    let values = [0x5eed, purpose as u64, a, b, c];
    values.into_iter().fold(study, combine)
}

/// Renders tasks.
pub struct Runner<'a> {
    settings: &'a StudySettings,
    prepared: &'a PreparedScene,
    watch: &'a Watch<'a>,
    references: &'a References,
    laws: &'a [TimeLaw],
    /// All pictures, by variant and level.
    pub images: Vec<Vec<Vec<Image>>>,
    /// Renders so far.
    done: usize,
}

/// How a block of renders ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All are done.
    Whole,
    /// There was no time for so many of them.
    OutOfTime(usize),
    /// Somebody ended it.
    Cancelled,
}

impl<'a> Runner<'a> {
    /// Ready for levels of `doublings`.
    pub fn new(
        settings: &'a StudySettings,
        prepared: &'a PreparedScene,
        watch: &'a Watch<'a>,
        references: &'a References,
        laws: &'a [TimeLaw],
        doublings: &[u32],
    ) -> Self {
        let levels = |&k: &u32| vec![Vec::new(); k as usize + 1];
        Self {
            settings,
            prepared,
            watch,
            references,
            laws,
            images: doublings.iter().map(levels).collect(),
            done: 0,
        }
    }

    /// Renders a block, while more than `reserve` seconds are left.
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

    /// Renders once; `false` if it was cancelled.
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

    /// Holds a picture against the references and the earlier ones of its level.
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
        let level = &mut report.variants[task.variant].levels[task.level as usize];
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

/// The mean luminance of a picture.
pub fn luminance(image: &Image) -> f64 {
    let mean = image.mean().map(|channel| channel as f32);
    f64::from(Rgb::from(mean).luminance())
}

/// Whether something else took a processor from a render.
fn is_disturbed(earlier: &[RunReport], shot: &Shot) -> bool {
    let mut ratios: Vec<f64> = earlier
        .iter()
        .map(|run| run.seconds.wall / run.seconds.cpu)
        .collect();
    if ratios.len() < USUAL {
        return false;
    }
    ratios.sort_by(f64::total_cmp);
    let usual = ratios[ratios.len() / 2];
    let ratio = shot.seconds.wall / shot.seconds.cpu;
    (ratio / usual - 1.0).abs() > DISTURBED
}
