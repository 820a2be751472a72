//! Other ways to render a scene, each measured against the present one: another integrator, a faster precision, a limit
//! of bounces, the noise filter.
//!
//! Measure: the gain is the time of the present way over that of the other to an equal error, without unit.
//! Range: small images of equal time; gains of a few per cent are not resolved. Biased ways say what they leave out.
//! Source: relMSE as a render estimates it. Tested in `cli/tests/command/price.rs` and below.

use super::answers::SIGMAS;
use crate::study::bootstrap::Ranged;
use crate::study::prepared_scene::PreparedScene;
use etendue::Result;
use etendue::internals::accel::{AccelOptions, Precision};
use etendue::internals::image::LayeredImage;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::post::denoise::{Denoiser, NoisyImage};
use etendue::internals::render::settings::{Budget, RenderSettings};
use etendue::internals::render::{
    CONFIDENCE, RenderInput, RenderObserver, Rendered, Threads, check, render,
};
use etendue::internals::session::layers::layers;
use serde::Serialize;
use std::time::{Duration, Instant};

/// The limit of bounces that is tried.
const BOUNCES: u32 = 4;

/// The relative uncertainty of the ratio of two times.
const TIMING: f64 = 0.03;

/// The share of the light that a limit of bounces has to leave out to be worth naming.
const VISIBLE: f64 = 1e-5;

/// Another way to render the scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cheaper {
    /// The flags of `etendue render`.
    pub flags: String,
    /// The time of the present way over that of this one; `None` if it cannot be said.
    pub gain: Option<Ranged>,
    /// The bias of its image, in words.
    pub bias: Option<String>,
    /// Further facts.
    pub note: Option<String>,
}

impl Cheaper {
    /// Whether it is cheaper beyond doubt.
    pub fn is_sure(&self) -> bool {
        self.gain.is_some_and(|gain| gain.low > 1.0)
    }
}

/// The measurement of one way.
struct MeasuredSetting {
    /// relMSE times seconds, and its relative standard error; `None` if the error is in doubt.
    cost: Option<[f64; 2]>,
    seconds: f64,
    spp: f64,
    light: f64,
}

/// The measured settings, and the time for them.
pub struct CheaperSettings<'a> {
    /// The scene, on a small film.
    pub prepared: &'a PreparedScene,
    /// The present way.
    pub settings: &'a RenderSettings,
    /// The settings of which it was made by pilots.
    pub given: &'a RenderSettings,
    /// Its options of the acceleration structure.
    pub options: AccelOptions,
    /// Seconds for everything.
    pub seconds: f64,
    /// Cancels the measurement.
    pub observer: &'a dyn RenderObserver,
}

impl CheaperSettings<'_> {
    /// Measures all other ways; those before a cancellation.
    ///
    /// # Errors
    /// As a render.
    pub fn all(&self) -> Result<Vec<Cheaper>> {
        let others = self.integrators();
        let is_robust = self.options.precision == Precision::Robust;
        let has_bounces = self.settings.max_bounces.is_none();
        let ways = 3 + others.len() + usize::from(is_robust) + usize::from(has_bounces);
        let slice = Budget::time(Duration::from_secs_f64(self.seconds / ways as f64));
        let Some((base, _)) = self.measured(self.settings, self.options, slice)? else {
            return Ok(Vec::new());
        };
        let mut all = Vec::new();
        for integrator in others {
            let given = RenderSettings {
                integrator,
                ..self.given.clone()
            };
            let resolved = self
                .prepared
                .resolve_auto(&given, self.options, self.observer)?;
            let settings = resolved.settings;
            let Some((other, _)) = self.measured(&settings, self.options, slice)? else {
                return Ok(all);
            };
            all.push(Cheaper {
                flags: format!("--integrator {}", integrator.name()),
                gain: gain(&base, &other),
                bias: None,
                note: other
                    .cost
                    .is_none()
                    .then(|| "its error is in doubt: rare bright paths".to_owned()),
            });
        }
        if is_robust {
            let fast = AccelOptions {
                precision: Precision::Fast,
                ..self.options
            };
            let Some((other, _)) = self.measured(self.settings, fast, slice)? else {
                return Ok(all);
            };
            all.push(Cheaper {
                flags: "--precision fast".to_owned(),
                // Paths and errors do not differ, only the pace.
                gain: Some(around(
                    other.spp / other.seconds / (base.spp / base.seconds),
                    TIMING,
                )),
                bias: None,
                note: Some("may miss an edge between triangles".to_owned()),
            });
        }
        if has_bounces {
            let settings = RenderSettings {
                max_bounces: Some(BOUNCES),
                ..self.settings.clone()
            };
            // Of as many samples with the same random numbers, so that the light differs by the limit only.
            let as_many = Budget::samples(base.spp as u64);
            let Some((other, _)) = self.measured(&settings, self.options, as_many)? else {
                return Ok(all);
            };
            let lost = 1.0 - other.light / base.light;
            all.extend((lost > VISIBLE).then(|| Cheaper {
                flags: format!("--max-bounces {BOUNCES}"),
                gain: gain(&base, &other),
                bias: Some(format!(
                    "leaves out about {:.2} % of the light",
                    100.0 * lost
                )),
                note: None,
            }));
        }
        // The filter reads layers, which not every integrator has.
        let noisy = self.settings.with_layers();
        if noisy.validate(self.prepared.size()).is_ok()
            && let Some((_, rendered)) = self.measured(&noisy, self.options, slice)?
        {
            all.extend(self.denoised(&base, &noisy, &rendered)?);
        }
        Ok(all)
    }

    /// The other integrators for the same light.
    fn integrators(&self) -> Vec<IntegratorKind> {
        let kinds = [
            IntegratorKind::Path,
            IntegratorKind::Bidirectional,
            IntegratorKind::Metropolis,
        ];
        let others = kinds.into_iter().filter(|&integrator| {
            let settings = RenderSettings {
                integrator,
                ..self.settings.clone()
            };
            integrator != self.settings.integrator
                && settings.validate(self.prepared.size()).is_ok()
                && check(self.prepared.scene(self.options), &settings).is_ok()
        });
        others.collect()
    }

    /// Renders until the budget is used up; `None` if it was cancelled.
    fn measured(
        &self,
        settings: &RenderSettings,
        options: AccelOptions,
        budget: Budget,
    ) -> Result<Option<(MeasuredSetting, Rendered)>> {
        let settings = RenderSettings {
            budget,
            ..settings.clone()
        };
        let scene = self.prepared.scene(options);
        let size = self.prepared.size();
        let rendered = render(
            scene,
            self.prepared.filter(),
            size,
            &settings,
            self.observer,
        )?;
        if rendered.cancelled {
            return Ok(None);
        }
        let seconds = rendered.elapsed.as_secs_f64();
        let error = rendered
            .error(CONFIDENCE)
            .filter(|error| error.doubt.is_none());
        let measured = MeasuredSetting {
            cost: error.map(|error| [error.rel_rmse.powi(2) * seconds, error.uncertainty]),
            seconds,
            spp: rendered.spp as f64,
            light: rendered.film.mean().iter().sum(),
        };
        Ok(Some((measured, rendered)))
    }

    /// The noise filter of an image with layers; `None` if the filter cannot estimate its error.
    fn denoised(
        &self,
        base: &MeasuredSetting,
        settings: &RenderSettings,
        rendered: &Rendered,
    ) -> Result<Option<Cheaper>> {
        let before = rendered
            .error(CONFIDENCE)
            .filter(|_| rendered.film.has_all_batches());
        let Some(before) = before.filter(|error| error.rel_rmse > 0.0) else {
            return Ok(None);
        };
        let start = Instant::now();
        let scene = self.prepared.scene(self.options);
        let input = RenderInput {
            scene,
            filter: self.prepared.filter(),
            size: self.prepared.size(),
        };
        let threads = Threads::new(settings.threads)?;
        let filtered = threads.run(|| {
            let picture = LayeredImage {
                layers: layers(&input, settings, rendered)?,
                ..LayeredImage::from(rendered.film.develop())
            };
            Denoiser::NonLocalMeans.filter(&NoisyImage::new(&picture)?)
        })?;
        let more = start.elapsed().as_secs_f64();
        let seconds = rendered.elapsed.as_secs_f64();
        Ok(filtered.error.map(|after| {
            let filtered = MeasuredSetting {
                cost: Some([after.powi(2) * (seconds + more), before.uncertainty]),
                seconds: seconds + more,
                spp: rendered.spp as f64,
                light: base.light,
            };
            Cheaper {
                flags: "--denoise".to_owned(),
                gain: gain(base, &filtered),
                bias: Some("mixes neighbouring pixels, less so the less noise there is".to_owned()),
                note: Some(format!(
                    "measured at an error of {:.1} %, then about {:.1} %: it gains less at smaller errors",
                    100.0 * before.rel_rmse,
                    100.0 * after
                )),
            }
        }))
    }
}

/// The gain by another way; `None` where an error is in doubt.
fn gain(base: &MeasuredSetting, other: &MeasuredSetting) -> Option<Ranged> {
    let [[base, base_error], [other, other_error]] = [base.cost?, other.cost?];
    let error = base_error.hypot(other_error).hypot(TIMING);
    (base > 0.0 && other > 0.0).then(|| around(base / other, error))
}

/// A number with its interval by its relative standard error.
fn around(value: f64, error: f64) -> Ranged {
    let margin = (SIGMAS * error).min(3.0);
    Ranged {
        value,
        low: value * (-margin).exp(),
        high: value * margin.exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(rel_mse: Option<f64>, seconds: f64) -> MeasuredSetting {
        MeasuredSetting {
            cost: rel_mse.map(|mse| [mse * seconds, 0.05]),
            seconds,
            spp: 64.0,
            light: 1.0,
        }
    }

    #[test]
    fn half_the_squared_error_in_equal_time_is_a_gain_of_two() {
        let base = measured(Some(0.02), 1.0);
        let gain = gain(&base, &measured(Some(0.01), 1.0)).expect("both errors are known");
        assert!((gain.value - 2.0).abs() < 1e-12 && gain.low > 1.5 && gain.high < 2.5);
        assert_eq!(super::gain(&base, &measured(None, 1.0)), None);
        assert_eq!(super::gain(&measured(Some(0.0), 1.0), &base), None);
    }
}
