//! Renders the levels of all variants, one by one, with the time of each.
//!
//! A render whose ratio of wall-clock to processor time is more than 5 % off the usual one of its level shared its
//! processors with other processes. It is repeated once, with the same seed and hence the same image: only its time is
//! measured again.
//!
//! Measure: seconds.
//! Range: a render is given up if the observer cancels it.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::clock::Seconds;
use super::fit::TimeLaw;
use super::prepared_scene::PreparedScene;
use super::schedule::{Schedule, Task};
use super::settings::{StudyClock, StudySettings};
use etendue::Result;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::CONFIDENCE;
use etendue::internals::render::convergence::ErrorRecord;
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

/// A render of a level.
#[derive(Debug, Clone)]
pub struct LevelRender {
    /// The level and the index of its seed.
    pub task: Task,
    /// Its seed.
    pub seed: u64,
    /// Its image.
    pub image: Image,
    /// Its error as the render estimates it: of the longest level, unless it is in doubt.
    pub error_record: Option<ErrorRecord>,
    /// Its duration; for a repeated render, that of the second run.
    pub seconds: Seconds,
    /// Whether it was repeated.
    pub repeated: bool,
    /// Whether its time is that of a disturbed render.
    pub disturbed: bool,
    /// Number of samples that were not finite.
    pub rejected: u64,
}

/// Renders the tasks of a schedule.
pub struct Runner<'a> {
    settings: &'a StudySettings,
    prepared: &'a PreparedScene,
    clock: &'a StudyClock<'a>,
    /// The shard of the study, from 0.
    shard: u64,
    /// The times of all renders, by variant and level.
    times: Vec<Vec<Vec<Seconds>>>,
}

impl<'a> Runner<'a> {
    /// A runner for the levels of a schedule in one shard of a study.
    pub fn new(
        settings: &'a StudySettings,
        prepared: &'a PreparedScene,
        clock: &'a StudyClock<'a>,
        schedule: &Schedule,
        shard: u64,
    ) -> Self {
        let levels = |seeds: &Vec<u64>| vec![Vec::new(); seeds.len()];
        Self {
            settings,
            prepared,
            clock,
            shard,
            times: schedule.seeds.iter().map(levels).collect(),
        }
    }

    /// Whether a task would leave less than `reserve` seconds, if it takes as long as a law says.
    pub fn is_late(&self, task: Task, laws: &[TimeLaw], reserve: f64) -> bool {
        let expected = laws[task.variant].at(f64::from(task.level).exp2());
        self.clock.remaining() < expected + reserve
    }

    /// Renders a task; `None` if it was cancelled. A disturbed render is not repeated if that would leave less than
    /// `reserve` seconds.
    ///
    /// # Errors
    /// As a render.
    pub fn render(&mut self, task: Task, reserve: f64) -> Result<Option<LevelRender>> {
        let number = task.seed * self.settings.shards + self.shard;
        let index = [task.variant as u64, u64::from(task.level), number];
        let seed = seed_for(self.settings.seed, Purpose::Level, index);
        let variant = &self.settings.variants[task.variant];
        let spp = variant.settings.spp_step() << task.level;
        let settings = self.prepared.settings(variant, spp, seed);
        let levels = &mut self.times[task.variant];
        let is_longest = task.level as usize + 1 == levels.len();
        let times = &mut levels[task.level as usize];
        let mut repeated = false;
        let (shot, disturbed) = loop {
            let Some(shot) = self.prepared.render(variant, &settings, self.clock)? else {
                return Ok(None);
            };
            let disturbed = is_disturbed(times, shot.seconds);
            let is_last = repeated || self.clock.remaining() < shot.seconds.wall + reserve;
            if !disturbed || is_last {
                break (shot, disturbed);
            }
            repeated = true;
        };
        times.push(shot.seconds);
        let error = is_longest.then(|| shot.film.error(CONFIDENCE)).flatten();
        let error = error.filter(|error| error.doubt.is_none());
        Ok(Some(LevelRender {
            task,
            seed,
            image: shot.film.develop(),
            error_record: error.map(|error| ErrorRecord::new(spp as f64, &error)),
            seconds: shot.seconds,
            repeated,
            disturbed,
            rejected: shot.rejected,
        }))
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

/// Whether other processes disturbed a render, by the times of earlier ones of its level.
fn is_disturbed(earlier: &[Seconds], seconds: Seconds) -> bool {
    let ratio = |seconds: &Seconds| seconds.wall / seconds.cpu;
    let mut ratios: Vec<f64> = earlier.iter().map(ratio).collect();
    if ratios.len() < MIN_RENDERS {
        return false;
    }
    ratios.sort_by(f64::total_cmp);
    let usual = ratios[ratios.len() / 2];
    (ratio(&seconds) / usual - 1.0).abs() > DISTURBED
}
