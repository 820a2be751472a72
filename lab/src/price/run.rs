//! Measures a price: the pace at the scene's own size, the sources of the error and cheaper ways with small images, then
//! one render for the rest of the time, whose records of its own error give the answers.
//!
//! Measure: seconds.
//! Range: a budget for the pilot and one sample of each pixel; a smaller one, a black image and an unknown error are
//! errors that say so. An error of fewer than 16 samples is marked by a note. After a cancellation the report has the
//! results so far.
//! Source: docs/accuracy.md, "The price". Tested in `cli/tests/command/price.rs`.

use super::answers::PriceInput;
use super::cheaper::CheaperSettings;
use super::clock::{PriceClock, RenderClock};
use super::report::{PriceReport, PriceSettings};
use crate::study::error_sources::error_sources;
use crate::study::prepared_scene::PreparedScene;
use crate::study::reference::References;
use crate::study::settings::StudyObserver;
use crate::study::summary::TARGETS;
use crate::study::variance::remark;
use crate::study::variant::Variant;
use etendue::internals::accel::{AccelOptions, Precision};
use etendue::internals::film::Doubt;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::convergence::ErrorRecord;
use etendue::internals::render::settings::{
    Adaptive, Budget, ErrorTarget, RenderSettings, SamplerKind,
};
use etendue::internals::render::{CONFIDENCE, RenderObserver, Rendered, render};
use etendue::internals::sampler::hash::combine;
use etendue::internals::scene::description::SceneDescription;
use etendue::{Error, Result};
use std::time::{Duration, Instant};

/// The shares of the budget for the pace, the sources of the error, and cheaper ways.
const PACE_SHARE: f64 = 0.06;
const SOURCES_SHARE: f64 = 0.08;
const CHEAPER_SHARE: f64 = 0.36;

/// The least share for the longest render.
const MIN_SHARE: f64 = 0.1;

/// The number of samples per pixel that measure the pace.
const PACE_SPP: u64 = 8;

/// The samples per pixel that the longest render should reach: for fewer, a smaller image is rendered.
const ENOUGH_SPP: f64 = 96.0;

/// The numbers of pixels of small images, and of the smallest longest render.
const SMALL_PIXELS: f64 = 24_000.0;
const MIN_PIXELS: f64 = 6_000.0;

/// Minimum and maximum number of observed samples of a pixel.
const OBSERVED: [u64; 2] = [8, 64];

/// A relative standard error of the pace, which differs between renders on a machine with nothing else to do.
const PACE_ERROR: f64 = 0.02;

/// An error that no forecast reaches, so that the longest render records its error until its time is over.
const UNREACHED: f64 = 1e-9;

/// The offset of the seeds, which are combined with the user's.
const SEEDS: u64 = 0x0070_7269_6365;

/// Measures the price of a scene, from `start` on.
///
/// # Errors
/// A scene that is black or not valid, a budget too small, or a render that fails.
pub fn run(
    description: &SceneDescription,
    settings: &PriceSettings,
    start: Instant,
    observer: &dyn StudyObserver,
) -> Result<PriceReport> {
    let clock = PriceClock {
        observer,
        start,
        budget: settings.budget,
    };
    let options = settings.options;
    let prepared = PreparedScene::new(description, [options])?;
    // With the scene's seed, as `plan` has it, so that both choose alike.
    let given = RenderSettings {
        threads: options.threads,
        ..RenderSettings::of_scene(description)?
    };
    let integrator = settings.integrator.unwrap_or(given.integrator);
    let given = RenderSettings {
        integrator,
        ..given
    };
    let resolved = prepared.resolve_auto(&given, options, &clock)?;
    let base = RenderSettings {
        seed: combine(settings.seed, SEEDS),
        ..resolved.settings
    };
    let recommendation = resolved.recommendation;
    let preparation = clock.elapsed();
    let mut price = PriceMeasurement {
        report: blank(description, settings, &base, &prepared),
        description,
        settings,
        prepared,
        given,
        base,
        preparation,
        clock,
    };
    price.report.recommendation = recommendation;
    let whole = price.all()?;
    price.report.complete = whole.is_some();
    price.report.seconds = price.clock.elapsed();
    Ok(price.report)
}

fn blank(
    description: &SceneDescription,
    settings: &PriceSettings,
    base: &RenderSettings,
    prepared: &PreparedScene,
) -> PriceReport {
    PriceReport {
        version: env!("CARGO_PKG_VERSION"),
        scene: description.file.display().to_string(),
        full_size: description.film.size,
        size: description.film.size,
        threads: base.threads,
        integrator: base.integrator.name(),
        sampler: base.sampler.name(),
        recommendation: None,
        budget: settings.budget,
        seconds: 0.0,
        spp: 0,
        rel_rmse: None,
        doubt: None,
        pace: f64::NAN,
        answers: Vec::new(),
        error_sources: None,
        cheaper: Vec::new(),
        bias: base.bias(prepared.effects()),
        notes: description
            .notes
            .iter()
            .map(ToString::to_string)
            .chain(prepared.notes.iter().cloned())
            .collect(),
        complete: false,
    }
}

/// The time of a render at the scene's own size.
#[derive(Debug, Clone, Copy)]
struct OwnSizeTime {
    /// Seconds before the first sample, such as those of filling an irradiance cache.
    start: f64,
    /// Seconds of a sample of each pixel.
    pace: f64,
}

/// A price that is being measured. Each step returns `None` if it was cancelled.
struct PriceMeasurement<'a> {
    description: &'a SceneDescription,
    settings: &'a PriceSettings,
    prepared: PreparedScene,
    /// The settings before pilots chose, which other integrators start from.
    given: RenderSettings,
    base: RenderSettings,
    /// Seconds for loading the scene, building its acceleration structure and the pilots, which a render takes, too.
    preparation: f64,
    clock: PriceClock<'a>,
    report: PriceReport,
}

impl PriceMeasurement<'_> {
    fn all(&mut self) -> Result<Option<()>> {
        let size = self.prepared.size();
        let pixels = f64::from(size.0) * f64::from(size.1);
        let pace = Budget {
            spp: Some(PACE_SPP),
            ..Budget::time(Duration::from_secs_f64(PACE_SHARE * self.settings.budget))
        };
        let (first, before) = self.render_whatever(&self.prepared, pace, 0)?;
        if first.cancelled {
            return Ok(None);
        }
        if first.film.mean() == [0.0; 3] {
            return Err(Error::render(
                "the image is black after its first samples: relative errors are undefined",
            ));
        }
        if self.clock.elapsed() > self.settings.budget {
            return Err(self.too_small());
        }
        let pace = |rendered: &Rendered, before: f64| {
            let seconds = rendered.elapsed.as_secs_f64();
            // A clock that was read late leaves nothing.
            (seconds - before).max(1e-3 * seconds) / rendered.spp.max(1) as f64
        };
        let mut own = OwnSizeTime {
            start: before,
            pace: pace(&first, before),
        };
        let small = self.prepared.on_film(scaled(size, SMALL_PIXELS / pixels));
        let of_small = own.pace * (SMALL_PIXELS / pixels).min(1.0);
        if self.sources(&small, of_small)?.is_none() || self.cheaper(small)?.is_none() {
            return Ok(None);
        }
        // On a busy machine the steps before may have taken all of the time.
        let left = self.clock.remaining().max(MIN_SHARE * self.settings.budget);
        let share = ((left - own.start).max(MIN_SHARE * left) / own.pace / ENOUGH_SPP)
            .max(MIN_PIXELS / pixels)
            .min(1.0);
        let longest = match share < 1.0 {
            true => self.prepared.on_film(scaled(size, share)),
            false => self.prepared.on_film(size),
        };
        self.report.size = longest.size();
        let until = Budget {
            error: Some(ErrorTarget {
                rel_rmse: UNREACHED,
                confidence: CONFIDENCE,
            }),
            ..Budget::time(Duration::from_secs_f64(left))
        };
        let (rendered, before) = self.render_whatever(&longest, until, 1)?;
        if longest.size() == size {
            own = OwnSizeTime {
                start: before,
                pace: pace(&rendered, before),
            };
        }
        self.answer(&rendered, own)?;
        Ok((!rendered.cancelled).then_some(()))
    }

    /// Renders with the measured settings, `None` if it was cancelled.
    fn render(
        &self,
        prepared: &PreparedScene,
        until: Budget,
        seed: u64,
    ) -> Result<Option<Rendered>> {
        let (rendered, _) = self.render_whatever(prepared, until, seed)?;
        Ok((!rendered.cancelled).then_some(rendered))
    }

    /// Renders with the measured settings; the second number is that of the seconds before the first sample.
    fn render_whatever(
        &self,
        prepared: &PreparedScene,
        until: Budget,
        seed: u64,
    ) -> Result<(Rendered, f64)> {
        let settings = RenderSettings {
            budget: until,
            seed: combine(self.base.seed, seed),
            ..self.on_film(prepared)
        };
        let scene = prepared.scene(self.settings.options);
        let render_clock = RenderClock::new(&self.clock);
        let rendered = render(
            scene,
            prepared.filter(),
            prepared.size(),
            &settings,
            &render_clock,
        )?;
        Ok((rendered, render_clock.before()))
    }

    /// The settings for images of another size.
    fn on_film(&self, prepared: &PreparedScene) -> RenderSettings {
        RenderSettings {
            window: RenderSettings::new(prepared.size(), 1).window,
            ..self.base.clone()
        }
    }

    /// Measures the sources of the error.
    fn sources(&mut self, small: &PreparedScene, pace: f64) -> Result<Option<()>> {
        self.clock.begin("sources of the error");
        let seconds = SOURCES_SHARE * self.settings.budget;
        // Observed paths are followed one at a time, twice, in several times the time of a render.
        let spp = (seconds / (6.0 * pace)) as u64;
        if spp < OBSERVED[0] {
            self.report
                .notes
                .push("no time for the sources of the error: give a larger --budget".to_owned());
            return Ok(Some(()));
        }
        let spp = spp.clamp(OBSERVED[0], OBSERVED[1]);
        let Some(image) = self.render(small, Budget::samples(spp), 2)? else {
            return Ok(None);
        };
        let image = image.film.develop();
        // One noisy image in both places: it only scales errors.
        let Some(references) = References::new(image.clone(), image) else {
            return Ok(Some(()));
        };
        let variant = Variant::new(self.on_film(small), self.settings.options);
        let seed = combine(self.base.seed, 3);
        let found = error_sources(small, self.description, &variant, &references, (spp, seed));
        let integrator = self.base.integrator;
        if integrator.splats() || integrator == IntegratorKind::IrradianceCache {
            let name = integrator.name();
            let note = format!("{name} does not tell which paths its error comes from");
            self.report.notes.push(note);
        } else if let Some(remark) = remark(&self.base) {
            self.report.notes.push(remark.to_owned());
        }
        self.report.error_sources = found;
        Ok((!self.clock.is_cancelled()).then_some(()))
    }

    /// Measures other ways to render the scene.
    fn cheaper(&mut self, small: PreparedScene) -> Result<Option<()>> {
        self.clock.begin("cheaper ways");
        let options = self.settings.options;
        let fast = AccelOptions {
            precision: Precision::Fast,
            ..options
        };
        let build = small.builds.first().map_or(0.0, |(_, seconds)| *seconds);
        let seconds = CHEAPER_SHARE * self.settings.budget - build;
        if seconds < 0.5 * CHEAPER_SHARE * self.settings.budget {
            self.report
                .notes
                .push("no time for cheaper ways: give a larger --budget".to_owned());
            return Ok(Some(()));
        }
        let size = small.size();
        let small = match options == fast {
            true => small,
            false => PreparedScene::new(self.description, [options, fast])?.on_film(size),
        };
        let settings = self.on_film(&small);
        let given = RenderSettings {
            window: settings.window,
            ..self.given.clone()
        };
        let comparison = CheaperSettings {
            prepared: &small,
            settings: &settings,
            given: &given,
            options,
            seconds,
            observer: &self.clock,
        };
        self.report.cheaper = comparison.all()?;
        Ok((!self.clock.is_cancelled()).then_some(()))
    }

    /// Computes the answers from the longest render.
    fn answer(&mut self, rendered: &Rendered, own: OwnSizeTime) -> Result<()> {
        let Some(error) = rendered.error(CONFIDENCE) else {
            return match rendered.cancelled {
                true => Ok(()),
                false => Err(self.too_small()),
            };
        };
        let mut error_records = rendered.error_records.clone();
        if error_records.is_empty() {
            let spp = rendered.spp;
            error_records.push(ErrorRecord::new(
                rendered.equivalent_spp.unwrap_or(spp as f64),
                &error,
            ));
            let note = format!("the error is that of {spp} samples only: give a larger --budget");
            self.report.notes.push(note);
        }
        let (width, height) = self.report.full_size;
        let doubt = error.doubt.map(in_words);
        let facts = PriceInput {
            error_records: &error_records,
            spp: rendered.spp as f64,
            equivalent_spp: rendered.equivalent_spp.unwrap_or(rendered.spp as f64),
            pixels: u64::from(width) * u64::from(height),
            // Unevenly distributed samples reach powers of two in no step.
            in_steps: self.base.sampler == SamplerKind::Sobol
                && self.base.adaptive == Adaptive::Off,
            start: self.preparation + own.start,
            pace: own.pace,
            pace_error: PACE_ERROR,
            doubt: doubt.as_deref(),
        };
        self.report.answers = TARGETS.map(|target| facts.row(target)).to_vec();
        self.report.doubt = doubt;
        self.report.rel_rmse = Some(error.rel_rmse);
        self.report.spp = rendered.spp;
        self.report.pace = own.pace;
        Ok(())
    }

    fn too_small(&self) -> Error {
        Error::usage(format!(
            "a budget of {} s is too small to estimate the error of this scene: give a larger --budget",
            self.settings.budget
        ))
    }
}

/// The reason of a doubt, in words.
fn in_words(doubt: Doubt) -> String {
    match doubt {
        Doubt::FewPixels { .. } | Doubt::OneSample { .. } => {
            "rare bright paths dominate the error, and the samples so far cannot tell how many were missed".to_owned()
        }
        Doubt::Rising { .. } => "the error has not fallen as it should: rare bright paths".to_owned(),
    }
}

/// A size with this share of the pixels, at most all.
fn scaled((width, height): (u32, u32), share: f64) -> (u32, u32) {
    let scale = share.min(1.0).sqrt();
    let side = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
    (side(width), side(height))
}
