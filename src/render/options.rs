//! Render options of a user, which take precedence over the scene's own keys, and these over the defaults.
//!
//! Measure: as in `settings/`.
//! Range: a value out of its range is an error that names the option, or the scene's line.
//! Source: design of the command line. Tested below, in `cli/tests/command/render.rs` and
//! `cli/tests/command/bad_input.rs`.

use super::CONFIDENCE;
use super::settings::{Adaptive, BounceLimit, LightPathRule, PathReuseRule};
use super::settings::{Budget, ErrorTarget, RenderSettings, SamplerKind, available_threads};
use crate::effects::Kernel;
use crate::error::{Error, Result};
use crate::film::Window;
use crate::film::filter::FilterSampling;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::integrator::light_paths::LightPathShare;
use crate::integrator::technique::EmissionRule;
use crate::light::types::LightChoice;
use crate::scene::description::SceneDescription;
use std::time::Duration;

/// The render options of a user; `None` leaves a value to the scene, or to the default where the scene has none.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct RenderOptions {
    /// The integrator.
    pub integrator: Option<IntegratorKind>,
    /// The sampler.
    pub sampler: Option<SamplerKind>,
    /// The seed: picks one of 2^64 sets of random numbers.
    pub seed: Option<u64>,
    /// The largest number of samples per pixel, at least 1. The scene's default number does not limit a given time or
    /// error.
    pub spp: Option<u64>,
    /// The largest time.
    pub time: Option<Duration>,
    /// The error to reach: the root of relMSE, above 0 and below 1.
    pub error: Option<f64>,
    /// The probability with which the error is at most that; 95 % by default.
    pub confidence: Option<f64>,
    /// The distribution of samples over the pixels.
    pub adaptive: Option<Adaptive>,
    /// Whether to write layers beside the image: error bars, and the first hits.
    pub layers: bool,
    /// The limit of scattering events.
    pub max_bounces: Option<BounceLimit>,
    /// The rule of Russian roulette.
    pub roulette: Option<Roulette>,
    /// The selection of lights.
    pub light_choice: Option<LightChoice>,
    /// The number of light paths for each camera path.
    pub light_paths: Option<LightPathRule>,
    /// The number of pixels that share their paths; one with layers, since whatever reads layers takes the noise of pixels as
    /// independent.
    pub reuse: Option<PathReuseRule>,
    /// The estimator of the filter; with layers importance sampling unless given, since whatever reads layers takes the noise
    /// of pixels as independent.
    pub filter_sampling: Option<FilterSampling>,
    /// The largest distance of occlusion for ambient occlusion, in world units.
    pub occlusion_distance: Option<f64>,
    /// The largest relative error of indirect light from an irradiance cache, from 0 to below 1.
    pub cache_error: Option<f64>,
    /// The kernel.
    pub kernel: Option<Kernel>,
    /// The number of threads, at least 1; by default all that this process may use.
    pub threads: Option<usize>,
    /// The part of the image from (x0, y0) up to but not including (x1, y1).
    pub crop: Option<[u32; 4]>,
}

impl RenderOptions {
    /// The options with `spp` samples per pixel, and nothing else.
    pub fn samples(spp: u64) -> Self {
        Self {
            spp: Some(spp),
            ..Self::default()
        }
    }

    /// The render settings for a scene.
    ///
    /// # Errors
    /// An option that is out of its range or makes no sense, or an unknown name in the scene.
    pub fn settings(&self, description: &SceneDescription) -> Result<RenderSettings> {
        let of_scene = RenderSettings::of_scene(description)?;
        let of_scene = match self.layers {
            true => of_scene.with_layers(),
            false => of_scene,
        };
        let settings = RenderSettings {
            integrator: self.integrator.unwrap_or(of_scene.integrator),
            sampler: self.sampler.unwrap_or(of_scene.sampler),
            seed: self.seed.unwrap_or(of_scene.seed),
            budget: self.budget(of_scene.budget),
            adaptive: self.adaptive.unwrap_or(of_scene.adaptive),
            layers: self.layers,
            max_bounces: match self.max_bounces {
                Some(limit) => limit.max_bounces(),
                None => of_scene.max_bounces,
            },
            roulette: self.roulette.or(of_scene.roulette),
            light_choice: self.light_choice,
            light_paths: self.light_paths.unwrap_or(of_scene.light_paths),
            reuse: self.reuse.unwrap_or(of_scene.reuse),
            filter_sampling: self.filter_sampling.unwrap_or(of_scene.filter_sampling),
            occlusion_distance: self.occlusion_distance.or(of_scene.occlusion_distance),
            cache_error: self.cache_error.unwrap_or(of_scene.cache_error),
            kernel: self.kernel,
            threads: self.threads.unwrap_or_else(available_threads),
            window: self.window(description.film.size)?,
            ..of_scene
        };
        self.refuse_light_paths(&settings)?;
        self.refuse_reuse(&settings)?;
        refuse_endless(&settings)?;
        settings.validate(description.film.size)?;
        Ok(settings)
    }

    /// Refuses requested light paths that the settings cannot have.
    fn refuse_light_paths(&self, settings: &RenderSettings) -> Result<()> {
        let requested = self.light_paths.map(LightPathRule::share);
        if requested.unwrap_or_default() == LightPathShare::None {
            return Ok(());
        }
        if settings.adaptive == Adaptive::Greedy {
            return Err(Error::usage(
                "light paths contribute to any pixel, also to those that greedy sampling has stopped: use --adaptive, or --light-paths off",
            ));
        }
        if !matches!(
            settings.integrator,
            IntegratorKind::Path | IntegratorKind::Auto
        ) {
            return Err(Error::usage(format!(
                "only the integrator path has light paths beside camera paths, not {}: use --integrator path, or leave --light-paths out",
                settings.integrator.name()
            )));
        }
        Ok(())
    }

    /// Refuses requested reuse of paths that the settings cannot have.
    fn refuse_reuse(&self, settings: &RenderSettings) -> Result<()> {
        if !self.reuse.is_some_and(PathReuseRule::is_requested) {
            return Ok(());
        }
        if settings.adaptive != Adaptive::Off {
            return Err(Error::usage(
                "pixels that share paths take equally many samples, unlike adaptive sampling: use --adaptive=off, or --reuse off",
            ));
        }
        if settings.layers {
            return Err(Error::usage(
                "whatever reads layers takes the noise of pixels as independent, which shared paths do not leave: leave the layers out, or use --reuse off",
            ));
        }
        if settings.light_path_share() != LightPathShare::None {
            return Err(Error::usage(
                "the weights of light paths take each path as its own pixel's: use --light-paths off, or --reuse off",
            ));
        }
        if !matches!(
            settings.integrator,
            IntegratorKind::Path | IntegratorKind::Auto
        ) {
            return Err(Error::usage(format!(
                "only the integrator path shares paths between pixels, not {}: use --integrator path, or leave --reuse out",
                settings.integrator.name()
            )));
        }
        Ok(())
    }

    /// The requested limits, over those of the scene.
    fn budget(&self, of_scene: Budget) -> Budget {
        let has_other_limit = self.time.is_some() || self.error.is_some();
        Budget {
            spp: self.spp.or(of_scene.spp.filter(|_| !has_other_limit)),
            time: self.time,
            error: self.error.map(|rel_rmse| ErrorTarget {
                rel_rmse,
                confidence: self.confidence.unwrap_or(CONFIDENCE),
            }),
        }
    }

    /// The requested part of an image of this size.
    fn window(&self, (width, height): (u32, u32)) -> Result<Window> {
        match self.crop {
            None => Ok(Window::whole((width, height))),
            Some([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 && x1 <= width && y1 <= height => {
                Ok(Window {
                    x: x0,
                    y: y0,
                    width: x1 - x0,
                    height: y1 - y0,
                })
            }
            Some([x0, y0, x1, y1]) => Err(Error::usage(format!(
                "--crop {x0},{y0},{x1},{y1} is not a part of the image of {width}x{height} pixels"
            ))),
        }
    }
}

/// Refuses settings with which a path may never end.
///
/// # Errors
/// A usage error.
pub fn refuse_endless(settings: &RenderSettings) -> Result<()> {
    match may_be_endless(settings) {
        true => Err(Error::usage(
            "without roulette a path between white walls never ends: give --max-bounces too, such as --max-bounces 1000",
        )),
        false => Ok(()),
    }
}

/// Whether nothing but absorption ends a path.
fn may_be_endless(settings: &RenderSettings) -> bool {
    let ends_at_random = settings.integrator.technique().is_some_and(
        |technique| matches!(technique.emission, EmissionRule::Termination { unlit, .. } if unlit > 0.0),
    );
    let ends = ends_at_random || settings.integrator == IntegratorKind::AmbientOcclusion;
    settings.roulette() == Roulette::None && settings.bounce_limit().is_none() && !ends
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::DAffine3;
    use crate::scene::description::CameraDescription;

    fn scene() -> SceneDescription {
        let camera = CameraDescription::pinhole(DAffine3::IDENTITY, 1.0);
        let mut scene = SceneDescription::new("test", camera);
        scene.film.size = (8, 4);
        scene.render.spp = Some(7);
        scene.render.seed = Some(3);
        scene
    }

    #[test]
    fn options_override_the_scene_which_overrides_defaults() {
        let by_default = RenderOptions::default().settings(&scene()).expect("valid");
        assert_eq!((by_default.budget.spp, by_default.seed), (Some(7), 3));
        let options = RenderOptions {
            seed: Some(5),
            ..RenderOptions::samples(9)
        };
        let settings = options.settings(&scene()).expect("valid");
        assert_eq!((settings.budget.spp, settings.seed), (Some(9), 5));
        let options = RenderOptions {
            error: Some(0.1),
            ..RenderOptions::default()
        };
        assert_eq!(options.settings(&scene()).expect("valid").budget.spp, None);
    }

    #[test]
    fn limit_of_bounces_replaces_that_of_the_scene_or_removes_it() {
        let mut scene = scene();
        scene.render.max_bounces = Some(5);
        for (given, expected) in [
            (None, Some(5)),
            (Some(BounceLimit::AtMost(0)), Some(0)),
            (Some(BounceLimit::Unlimited), None),
        ] {
            let options = RenderOptions {
                max_bounces: given,
                ..RenderOptions::default()
            };
            let settings = options.settings(&scene).expect("valid");
            assert_eq!(settings.max_bounces, expected, "{given:?}");
        }
    }

    #[test]
    fn invalid_options_are_usage_errors() {
        let options = |change: &dyn Fn(&mut RenderOptions)| {
            let mut options = RenderOptions::default();
            change(&mut options);
            options
        };
        for wrong in [
            options(&|w| w.spp = Some(0)),
            options(&|w| w.threads = Some(0)),
            options(&|w| w.cache_error = Some(1.0)),
            options(&|w| w.error = Some(f64::NAN)),
            options(&|w| w.crop = Some([0, 0, 9, 4])),
            options(&|w| w.crop = Some([3, 0, 3, 4])),
            options(&|w| w.adaptive = Some(Adaptive::Greedy)),
            options(&|w| w.roulette = Some(Roulette::None)),
        ] {
            let error = wrong.settings(&scene()).expect_err("out of its range");
            assert_eq!(error.kind(), crate::ErrorKind::Usage, "{wrong:?}");
        }
    }
}
