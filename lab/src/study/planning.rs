//! The part of a study that plans it: the cost of renders, the size of the image, the schedule.
//!
//! Measure: seconds, pixels, samples per pixel.
//! Range: the image has the scene's own size, unless that leaves fewer than eight doublings of the samples and a smaller
//! one was not ruled out: then it is made smaller, with a warning.
//! Source: docs/accuracy.md, "The study". Tested below and in `lab/tests/reports/study.rs`.

use super::fit::TimeLaw;
use super::own_size::{OwnError, OwnSize, own_times};
use super::reference::References;
use super::report::LevelReport;
use super::run::Study;
use super::runner::{Purpose, seed_for};
use super::schedule::Schedule;
use super::settings::StudyClock;
use etendue::internals::image::Image;
use etendue::internals::render::CONFIDENCE;
use etendue::internals::render::convergence::ErrorRecord;
use etendue::{Error, Result};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Maximum number of bytes of images that are kept.
const MAX_MEMORY: u64 = 4 << 30;

/// The share of the budget for measuring the cost of renders, and its maximum in seconds, over all variants.
const WARM_UP: (f64, f64) = (0.04, 8.0);

/// The share and the maximum where a smaller image may be studied: errors of the own size are estimated as well, which
/// takes about eight samples of each pixel.
const WARM_UP_OF_OWN_SIZE: (f64, f64) = (0.1, 20.0);

/// The number of doublings of the samples below which a smaller image is studied.
const MIN_DOUBLINGS: usize = 8;

/// The number of pixels below which an image is not made smaller.
const MIN_PIXELS: f64 = 16_000.0;

/// The share of the pixels that one step towards a smaller image keeps.
const SHRINKING: f64 = 0.7;

/// The number of images of its level with which a render is compared, on average, and the cost of its own error.
const COMPARISONS: f64 = 16.0;

/// The measured costs, in units of the minimum number of samples of each integrator.
pub(super) struct MeasuredCosts {
    /// The costs of each variant, with the comparison with the references.
    pub laws: Vec<TimeLaw>,
    reference: TimeLaw,
    /// Samples per pixel and seconds of the renders of each variant.
    points: Vec<Vec<[f64; 2]>>,
    /// The estimates of their errors.
    error_records: Vec<Vec<ErrorRecord>>,
}

impl MeasuredCosts {
    /// The largest size, at most `size`, with enough doublings in this many seconds, or the smallest allowed one. The costs
    /// are those at `size`.
    fn fitting_size(&self, size: (u32, u32), seconds: f64, shards: u64) -> (u32, u32) {
        let pixels = f64::from(size.0) * f64::from(size.1);
        let mut share = 1.0;
        while share * pixels > MIN_PIXELS {
            let scaled = |law: &TimeLaw| TimeLaw {
                start: share * law.start,
                sample: share * law.sample,
            };
            let laws: Vec<TimeLaw> = self.laws.iter().map(scaled).collect();
            let schedule = Schedule::fit(&laws, scaled(&self.reference), seconds, shards);
            let is_enough = schedule.is_ok_and(|schedule| {
                schedule.least_doublings() >= MIN_DOUBLINGS
                    && bytes(&schedule.of_shards(shards), share * pixels) <= MAX_MEMORY
            });
            if is_enough {
                break;
            }
            share = (SHRINKING * share).max(MIN_PIXELS / pixels);
        }
        let side = |side: u32| ((f64::from(side) * share.min(1.0).sqrt()).round() as u32).max(1);
        (side(size.0), side(size.1))
    }
}

impl Study<'_> {
    /// Measures the cost of renders and plans them; `None` if it was cancelled.
    pub(super) fn plan(
        &mut self,
        clock: &StudyClock<'_>,
    ) -> Result<Option<(MeasuredCosts, Schedule)>> {
        let may_shrink = self.settings.may_shrink && self.settings.schedule.is_none();
        let share = match may_shrink {
            true => WARM_UP_OF_OWN_SIZE,
            false => WARM_UP,
        };
        let Some(mut costs) = self.warm_up(share, clock)? else {
            return Ok(None);
        };
        if may_shrink {
            let size = costs.fitting_size(
                self.prepared.size(),
                clock.remaining(),
                self.settings.shards,
            );
            if size != self.prepared.size() {
                let full = self.prepared.size();
                self.shrink(size);
                let Some(again) = self.warm_up(WARM_UP, clock)? else {
                    return Ok(None);
                };
                let pixels = |(width, height)| f64::from(width) * f64::from(height);
                let share = pixels(full) / pixels(size);
                let small = self.report.variants.iter().map(|study| study.warm_up);
                let own = own_times(&costs.points, &small.collect::<Vec<_>>(), share);
                let errors = costs.error_records.iter().zip(&again.error_records);
                let errors = errors.map(|(own, small)| OwnError::of(own, small));
                let variants = self.report.variants.iter_mut();
                for (study, (own, error)) in variants.zip(own.into_iter().zip(errors)) {
                    study.own_size = Some(OwnSize { error, ..own });
                }
                costs = again;
            }
        }
        let schedule = self.schedule(&costs, clock)?;
        Ok(Some((costs, schedule)))
    }

    fn shrink(&mut self, size: (u32, u32)) {
        let (width, height) = size;
        self.report.warn(format!(
            "the scene's own size would leave fewer than {MIN_DOUBLINGS} doublings of the samples in this time: {width} × {height} pixels were rendered, and times are converted to the scene's own size by a pace between the one measured there and that of as many pixels of this image, errors by the ratio of both sizes' estimates after a few samples"
        ));
        self.on_film(size);
    }

    /// Changes the size of the image.
    pub(super) fn on_film(&mut self, size: (u32, u32)) {
        self.prepared = Rc::new(self.prepared.on_film(size));
        self.description.film.size = size;
        self.report.size = size;
    }

    /// Measures the cost of each variant and of the reference, in this share of the budget and at most so many seconds. The
    /// first render of each warms up the caches and is discarded.
    fn warm_up(
        &mut self,
        (share, most): (f64, f64),
        clock: &StudyClock<'_>,
    ) -> Result<Option<MeasuredCosts>> {
        let reference = self.reference_variant();
        let variants = self.settings.variants.iter().chain([&reference]);
        let seconds = (share * self.settings.budget).min(most);
        let each = seconds / (self.settings.variants.len() + 1) as f64;
        let (mut laws, mut all_points, mut all_records) = (Vec::new(), Vec::new(), Vec::new());
        let mut comparison = 0.0;
        for (index, variant) in variants.enumerate() {
            let (mut points, mut error_records) = (Vec::new(), Vec::new());
            let spp_step = variant.settings.spp_step();
            let (mut times, mut spent) = (1, 0.0);
            loop {
                let number = points.len() as u64;
                let place = [index as u64, number, 0];
                let seed = seed_for(self.settings.seed, Purpose::WarmUp, place);
                let settings = self.prepared.settings(variant, times * spp_step, seed);
                let Some(shot) = self.prepared.render(variant, &settings, clock)? else {
                    return Ok(None);
                };
                points.push([times as f64, shot.seconds.wall]);
                let error = shot.film.error(CONFIDENCE);
                error_records
                    .extend(error.map(|error| ErrorRecord::new((times * spp_step) as f64, &error)));
                spent += shot.seconds.wall;
                // The next render takes about twice as long.
                if points.len() > 2 && 2.0 * shot.seconds.wall + spent > each {
                    comparison = seconds_to_compare(shot.film.develop());
                    break;
                }
                if points.len() > 1 {
                    times *= 2;
                }
            }
            let law = TimeLaw::of(&points[1..]).ok_or_else(|| Error::render("no time passed"))?;
            if let Some(study) = self.report.variants.get_mut(index) {
                study.warm_up = TimeLaw {
                    sample: law.sample / spp_step as f64,
                    ..law
                };
            }
            laws.push(law);
            let of_samples = |&[times, seconds]: &[f64; 2]| [times * spp_step as f64, seconds];
            all_points.push(points[1..].iter().map(of_samples).collect());
            all_records.push(error_records);
        }
        let reference = laws.pop().expect("the reference is the last");
        for law in &mut laws {
            law.start += comparison;
        }
        all_points.pop();
        all_records.pop();
        Ok(Some(MeasuredCosts {
            laws,
            reference,
            points: all_points,
            error_records: all_records,
        }))
    }

    fn schedule(&mut self, costs: &MeasuredCosts, clock: &StudyClock<'_>) -> Result<Schedule> {
        let (width, height) = self.prepared.size();
        let schedule = match &self.settings.schedule {
            Some(given) => Ok(given.clone()),
            None => Schedule::fit(
                &costs.laws,
                costs.reference,
                clock.remaining(),
                self.settings.shards,
            ),
        };
        let schedule = schedule.map_err(|enough| {
            let enough = Duration::from_secs_f64((1.1 * enough + clock.elapsed()).ceil());
            Error::usage(format!(
                "a budget of {} s is too small: {} variants of {width} x {height} pixels take at least {} s; give more by --budget, a smaller image by --size, or vary less",
                self.settings.budget,
                costs.laws.len(),
                enough.as_secs()
            ))
        })?;
        let all = schedule.of_shards(self.settings.shards);
        let bytes = bytes(&all, f64::from(width) * f64::from(height));
        if bytes > MAX_MEMORY {
            return Err(Error::usage(format!(
                "{} images of {width} x {height} pixels take {:.1} GB of memory; give a smaller image by --size, or a smaller budget",
                all.renders(),
                bytes as f64 / 1e9
            )));
        }
        self.begin_levels(&schedule);
        Ok(schedule)
    }

    /// Gives each variant its levels, without renders.
    pub(super) fn begin_levels(&mut self, schedule: &Schedule) {
        let variants = self.report.variants.iter_mut().zip(&self.settings.variants);
        for ((study, variant), seeds) in variants.zip(&schedule.seeds) {
            let spp_step = variant.settings.spp_step();
            let level = |level: usize| LevelReport {
                spp: spp_step << level,
                ..LevelReport::default()
            };
            study.levels = (0..seeds.len()).map(level).collect();
        }
    }
}

/// The memory of all images of a schedule.
fn bytes(schedule: &Schedule, pixels: f64) -> u64 {
    (schedule.renders() as f64 * pixels * size_of::<[f32; 3]>() as f64) as u64
}

/// Seconds to compare an image with the references and the other images of its level; 0 for a black one.
fn seconds_to_compare(image: Image) -> f64 {
    let other = image.clone();
    let Some(references) = References::new(image.clone(), other) else {
        return 0.0;
    };
    let start = Instant::now();
    std::hint::black_box(references.product(&image, &image));
    COMPARISONS * start.elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Renders of 640 x 480 pixels, each sample of which takes this many seconds.
    fn costs(sample: f64) -> MeasuredCosts {
        let law = TimeLaw { start: 0.0, sample };
        MeasuredCosts {
            laws: vec![law; 2],
            reference: law,
            points: Vec::new(),
            error_records: Vec::new(),
        }
    }

    #[test]
    fn image_size_fits_the_time_budget_within_bounds() {
        let own = (640, 480);
        assert_eq!(costs(1e-4).fitting_size(own, 10.0, 1), own);
        let (width, height) = costs(2e-3).fitting_size(own, 10.0, 1);
        assert!((150..640).contains(&width), "{width}");
        // The proportions stay, to a pixel.
        let expected = f64::from(width) * 480.0 / 640.0;
        assert!((f64::from(height) - expected).abs() <= 1.0, "{height}");
        // The smallest size is kept where the time is too short even for that.
        let (width, height) = costs(10.0).fitting_size(own, 10.0, 1);
        let pixels = f64::from(width * height);
        assert!((pixels / MIN_PIXELS - 1.0).abs() < 0.02, "{pixels}");
        assert_eq!(costs(1.0).fitting_size(own, -1.0, 1), (width, height));
        // An image of few pixels keeps its size, however short the time.
        assert_eq!(costs(10.0).fitting_size((16, 16), 0.1, 1), (16, 16));
    }
}
