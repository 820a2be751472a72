//! The settings of a render.
//!
//! Measure: pixels, samples per pixel, seconds.
//! Range: stated at each field; [`RenderSettings::validate`] names what is out of it.
//! Source: design of the command line. Tested below and in `cli/tests/command/bad_flags.rs`.

use crate::effects::{Effect, EffectSet, Kernel};
use crate::error::{Error, Result};
use crate::film::Window;
use crate::film::batches::BATCHES;
use crate::film::filter::{Filter, FilterSampling};
use crate::film::footprint::Footprint;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::integrator::light_paths::LightPathShare;
use crate::integrator::reuse::Reuse;
use crate::integrator::roulette::NoRoulette;
use crate::light::types::{LightChoice, MapRule};
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::description::{SceneDescription, Written};
use crate::scene::load::unknown_name;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The default number of samples per pixel.
const DEFAULT_SPP: u64 = 64;

/// The largest number of samples per pixel: beyond 2^47, random numbers would repeat (`sampler/mod.rs`).
const MOST_SPP: u64 = 1 << 46;
/// The default error bound of an irradiance cache.
pub const DEFAULT_CACHE_ERROR: f64 = 0.05;

/// The samples per pixel of an adaptive render's pilot, where that is not too large a share.
pub(super) const PILOT: u64 = 64;

/// The pilot ends at the latest when one part in this many of the budget is used up ...
pub(super) const LARGEST_SHARE_OF_PILOT: u64 = 4;

/// ... and continues up to one part in this many: a longer pilot estimates better, and no pixel gets fewer samples in
/// the end.
pub(super) const SHARE_OF_PILOT: u64 = 16;

/// The source of random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub enum SamplerKind {
    /// Independent numbers.
    Independent,
    /// Jittered strata, for the requested number of samples.
    Stratified,
    /// Owen-scrambled Sobol' points.
    #[default]
    Sobol,
}

impl SamplerKind {
    /// Every sampler.
    pub const ALL: &'static [Self] = &[Self::Sobol, Self::Stratified, Self::Independent];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::Sobol => "sobol",
        }
    }
}

/// The number of light paths for each camera path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum LightPathRule {
    /// A number that follows from the scene.
    Auto,
    /// This number.
    Share(LightPathShare),
}

impl Default for LightPathRule {
    fn default() -> Self {
        Self::Share(LightPathShare::None)
    }
}

impl LightPathRule {
    /// Every rule.
    pub const ALL: &'static [Self] = &[
        Self::Auto,
        Self::Share(LightPathShare::None),
        Self::Share(LightPathShare::Quarter),
        Self::Share(LightPathShare::Half),
        Self::Share(LightPathShare::One),
        Self::Share(LightPathShare::Two),
    ];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Share(share) => share.name(),
        }
    }
}

/// The limits of a render, which stops at the first that is reached.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Budget {
    /// The largest number of samples per pixel, at least 1: the mean over the pixels with two-phase sampling, the count
    /// of each with greedy sampling.
    pub spp: Option<u64>,
    /// The largest time, for the rendering alone. The last pass ends as near to it as passes allow.
    pub time: Option<Duration>,
    /// The error to reach.
    pub error: Option<ErrorTarget>,
}

impl Budget {
    /// A budget of `spp` samples per pixel.
    pub fn samples(spp: u64) -> Self {
        Self {
            spp: Some(spp),
            ..Self::default()
        }
    }

    /// A budget of this time.
    pub fn time(time: Duration) -> Self {
        Self {
            time: Some(time),
            ..Self::default()
        }
    }

    /// The samples per pixel of an adaptive render's pilot, as far as they are known before the first of them.
    pub fn pilot(self) -> u64 {
        let may_end_before = self.error.is_some() || self.time.is_some();
        let samples = self.spp.map_or(PILOT, |spp| {
            let long = if may_end_before {
                0
            } else {
                spp.div_ceil(SHARE_OF_PILOT)
            };
            PILOT.min(spp.div_ceil(LARGEST_SHARE_OF_PILOT)).max(long)
        });
        samples.max(1).next_multiple_of(BATCHES)
    }
}

/// The distribution of samples over the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub enum Adaptive {
    /// Equal counts for all pixels.
    #[default]
    Off,
    /// Two-phase sampling: counts by the errors that a pilot estimates, without bias.
    TwoPhase,
    /// Greedy sampling: each pixel until its own samples seem good enough. Biased.
    Greedy,
}

impl Adaptive {
    /// Every distribution.
    pub const ALL: &'static [Self] = &[Self::TwoPhase, Self::Greedy, Self::Off];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::TwoPhase => "two-phase",
            Self::Greedy => "greedy",
        }
    }

    /// The bias of the image, in words.
    pub fn bias(self) -> Option<String> {
        (self == Self::Greedy).then(|| {
            "greedy adaptive sampling: a pixel stops when its own samples are similar, even if by chance"
                .to_owned()
        })
    }
}

/// An error to reach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorTarget {
    /// The root of relMSE, above 0 and below 1.
    pub rel_rmse: f64,
    /// The probability with which the error is below that, above 0 and below 1.
    pub confidence: f64,
}

/// The settings of a render. Those that are not skipped by `serde` change bits of the image: state files keep them, and
/// only sums of equal settings are merged.
#[derive(Debug, Clone, Serialize)]
pub struct RenderSettings {
    /// The integrator.
    pub integrator: IntegratorKind,
    /// The source of random numbers.
    pub sampler: SamplerKind,
    /// The seed: picks one of 2^64 sets of random numbers.
    pub seed: u64,
    /// The limits of the render; at least one has to be given.
    #[serde(skip)]
    pub budget: Budget,
    /// The distribution of samples over the pixels.
    pub adaptive: Adaptive,
    /// Whether layers are to be written beside the image. They need equal sample counts in all batches: the count is
    /// rounded up.
    #[serde(skip)]
    pub layers: bool,
    /// The largest number of scattering events; `None` for no limit.
    pub max_bounces: Option<u32>,
    /// The rule of Russian roulette; `None` for the integrator's own.
    pub roulette: Option<Roulette>,
    /// The selection of lights; `None` for the integrator's own.
    pub light_choice: Option<LightChoice>,
    /// The number of light paths for each camera path of `path`.
    pub light_paths: LightPathRule,
    /// The number of pixels that share their paths, in renders by `path`: see [`Self::reuse`].
    pub reuse: Reuse,
    /// The estimator of the filter, where both are possible: see [`Self::reach`].
    pub filter_sampling: FilterSampling,
    /// The largest distance of occlusion for ambient occlusion, in world units; `None` for any distance.
    pub occlusion_distance: Option<f64>,
    /// The largest relative error of indirect light from an irradiance cache, from 0, which disables it, to below 1.
    pub cache_error: f64,
    /// The kernel; `None` for the smallest that has all effects of the scene. It changes nothing but the speed.
    #[serde(skip)]
    pub kernel: Option<Kernel>,
    /// The number of threads, at least 1.
    #[serde(skip)]
    pub threads: usize,
    /// The part of the image to render.
    pub window: Window,
    /// The edge of a tile in pixels, at least 1. It changes nothing but the speed.
    #[serde(skip)]
    pub tile_size: u32,
}

impl RenderSettings {
    /// The default settings for a whole image of this size and this many samples per pixel. The noise of pixels is
    /// independent, as statistics over pixels require; the filter of a scene's render is splatted ([`Self::of_scene`]).
    pub fn new(size: (u32, u32), spp: u64) -> Self {
        Self {
            integrator: IntegratorKind::default(),
            sampler: SamplerKind::default(),
            seed: 0,
            budget: Budget::samples(spp),
            adaptive: Adaptive::Off,
            layers: false,
            max_bounces: None,
            roulette: None,
            light_choice: None,
            light_paths: LightPathRule::default(),
            reuse: Reuse::default(),
            filter_sampling: FilterSampling::Importance,
            occlusion_distance: None,
            cache_error: DEFAULT_CACHE_ERROR,
            kernel: None,
            threads: available_threads(),
            window: Window {
                x: 0,
                y: 0,
                width: size.0,
                height: size.1,
            },
            tile_size: 16,
        }
    }

    /// The settings of a scene, and the defaults where it has none.
    ///
    /// # Errors
    /// An unknown name, with its line.
    pub fn of_scene(description: &SceneDescription) -> Result<Self> {
        let render = &description.render;
        let integrators = IntegratorKind::ALL.iter().map(|&i| (i.name(), i));
        let integrator = chosen(description, "integrator", &render.integrator, integrators)?;
        let samplers = SamplerKind::ALL.iter().map(|&s| (s.name(), s));
        let sampler = chosen(description, "sampler", &render.sampler, samplers)?;
        let ways = Adaptive::ALL.iter().map(|&a| (a.name(), a));
        let adaptive = chosen(description, "adaptive", &render.adaptive, ways)?;
        let roulette = roulette_of(description)?;
        let rules = LightPathRule::ALL.iter().map(|&rule| (rule.name(), rule));
        let light_paths = chosen(description, "light_paths", &render.light_paths, rules)?;
        let reuses = Reuse::ALL.iter().map(|&reuse| (reuse.name(), reuse));
        let reuse = chosen(description, "reuse", &render.reuse, reuses)?;
        let spp = render.spp.unwrap_or(DEFAULT_SPP);
        Ok(Self {
            integrator: integrator.unwrap_or_default(),
            sampler: sampler.unwrap_or_default(),
            seed: render.seed.unwrap_or(0),
            adaptive: adaptive.unwrap_or_default(),
            filter_sampling: FilterSampling::default(),
            max_bounces: render.max_bounces,
            roulette,
            light_paths: light_paths.unwrap_or_default(),
            reuse: reuse.unwrap_or_default(),
            occlusion_distance: render.occlusion_distance,
            cache_error: render.cache_error.unwrap_or(DEFAULT_CACHE_ERROR),
            ..Self::new(description.film.size, spp)
        })
    }

    /// The settings with `path` in place of `auto`, for callers that do not need the best integrator.
    pub fn by_name(mut self) -> Self {
        if self.integrator == IntegratorKind::Auto {
            self.integrator = IntegratorKind::Path;
        }
        self
    }

    /// Checks that the settings make sense for an image of this size.
    ///
    /// # Errors
    /// A usage error that names the setting.
    pub fn validate(&self, (width, height): (u32, u32)) -> Result<()> {
        let Window {
            x,
            y,
            width: w,
            height: h,
        } = self.window;
        let fits = |start: u32, length: u32, size: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= size)
        };
        if !(fits(x, w, width) && fits(y, h, height)) {
            return Err(Error::usage(format!(
                "the window from ({x}, {y}) of {w} x {h} pixels is not within the picture of {width} x {height}"
            )));
        }
        let is_share = |x: f64| x > 0.0 && x < 1.0;
        match self.budget {
            Budget {
                spp: None,
                time: None,
                error: None,
            } => Err(Error::usage(
                "neither samples per pixel nor a time nor an error to stop at was given",
            )),
            Budget { spp: Some(spp), .. } if !(1..=MOST_SPP).contains(&spp) => Err(Error::usage(
                "samples per pixel must be at least 1, and at most 2^46",
            )),
            Budget {
                error: Some(target),
                ..
            } if !(is_share(target.rel_rmse) && is_share(target.confidence)) => Err(Error::usage(
                "the error to reach and its confidence must be above 0 and below 1",
            )),
            Budget { error: None, .. } if self.adaptive == Adaptive::Greedy => Err(Error::usage(
                "greedy adaptive sampling needs an error at which a pixel stops: give --error, such as --error 5%",
            )),
            _ if self.adaptive != Adaptive::Off && self.integrator.splats() => {
                Err(Error::usage(format!(
                    "the integrator {} has no adaptive sampling, as its light subpaths contribute to any pixel: use --adaptive off, or --integrator path",
                    self.integrator.name()
                )))
            }
            _ if !(0.0..1.0).contains(&self.cache_error) => Err(Error::usage(
                "the error of an irradiance cache must be from 0 to below 1",
            )),
            _ if self.threads == 0 => Err(Error::usage("threads must be at least 1")),
            _ if self.tile_size == 0 => Err(Error::usage("the tile size must be at least 1")),
            _ => Ok(()),
        }
    }

    /// The number of pixels on either side of its own to which a sample contributes by this filter; 0 if it belongs to its own
    /// alone. That is so for filters without a footprint; for adaptive renders, whose pixels differ in the count that a
    /// sample's weight is divided by; and with light paths, which splat by the filter themselves.
    pub fn reach(&self, filter: &Filter) -> u32 {
        let is_splatted = self.filter_sampling == FilterSampling::Splatting
            && self.adaptive == Adaptive::Off
            && !self.splats();
        let footprint = filter.footprint().filter(|_| is_splatted);
        footprint.map_or(0, Footprint::reach)
    }

    /// The largest number of scattering events, by these settings and by the integrator.
    pub fn most_bounces(&self) -> Option<u32> {
        let limits = [self.max_bounces, self.integrator.most_bounces()];
        limits.into_iter().flatten().min()
    }

    /// The number of which sample counts are rounded up to a multiple: that of the batches where these are compared one
    /// by one or are all that there is, otherwise 1.
    pub fn least_samples(&self) -> u64 {
        let in_whole_rounds = self.layers
            || self.budget.error.is_some()
            || self.adaptive != Adaptive::Off
            || self.integrator == IntegratorKind::Metropolis;
        match in_whole_rounds {
            true => BATCHES,
            false => 1,
        }
    }

    /// The number of samples over which a pixel's strata are spread, if it is known: in adaptive renders, where counts
    /// differ, that of the pilot, whose strata are repeated.
    pub fn samples_of_strata(&self) -> Option<u64> {
        match self.adaptive {
            Adaptive::Off => self.budget.spp,
            Adaptive::TwoPhase | Adaptive::Greedy => Some(self.budget.pilot()),
        }
    }

    /// The rule of Russian roulette.
    pub fn roulette(&self) -> Roulette {
        self.roulette.unwrap_or(self.integrator.roulette())
    }

    /// The selection of lights.
    pub fn light_choice(&self) -> LightChoice {
        self.light_choice.unwrap_or(self.integrator.light_choice())
    }

    /// The number of light paths for each camera path: none but beside `path` with equal sample counts, and none by `auto`,
    /// which has to be replaced before a scene is rendered (`render/auto/`).
    pub fn light_path_share(&self) -> LightPathShare {
        let may_have = self.integrator == IntegratorKind::Path && self.adaptive == Adaptive::Off;
        match self.light_paths {
            LightPathRule::Share(share) if may_have => share,
            _ => LightPathShare::None,
        }
    }

    /// The number of light paths for each camera path by which `auto` is replaced in a scene: none where no shape throws
    /// light, and none where the counts of camera paths differ.
    pub fn settle_light_paths(&mut self, scene: &Scene) {
        if self.light_paths == LightPathRule::Auto {
            let may_pay = scene.throws_light()
                && self.integrator == IntegratorKind::Path
                && self.adaptive == Adaptive::Off
                && self.most_bounces().is_none_or(|most| most > 1);
            self.light_paths = LightPathRule::Share(if may_pay {
                LightPathShare::Half
            } else {
                LightPathShare::None
            });
        }
    }

    /// The number of pixels that share their paths: one but by `path` with equal sample counts and without light paths,
    /// whose weights take each path as its own pixel's.
    pub fn reuse(&self) -> Reuse {
        let may_share = self.integrator == IntegratorKind::Path
            && self.adaptive == Adaptive::Off
            && self.light_path_share() == LightPathShare::None;
        if may_share { self.reuse } else { Reuse::Off }
    }

    /// The effects that a render of a scene with these effects needs.
    pub fn effects(&self, of_scene: EffectSet) -> EffectSet {
        let has_light_paths = self.light_path_share() != LightPathShare::None;
        of_scene
            .without(Effect::LightPaths)
            .without(Effect::Reuse)
            .with_if(Effect::LightPaths, has_light_paths)
            .with_if(Effect::Reuse, self.reuse().is_on())
    }

    /// Whether samples contribute to other pixels, too, by splats.
    pub fn splats(&self) -> bool {
        self.integrator.splats() || self.light_path_share() != LightPathShare::None
    }

    /// The density of directions to an environment map: compensated where BSDF sampling finds all of its light, too.
    pub fn map_rule(&self) -> MapRule {
        let has_both = self.integrator == IntegratorKind::Path;
        if planted!("compensated-alone", true, has_both) {
            MapRule::Compensated
        } else {
            MapRule::Radiance
        }
    }

    /// The light that the integrator leaves out of the image of a scene with these effects, in words.
    pub fn bias_of_integrator(&self, effects: EffectSet) -> Option<String> {
        self.integrator.bias(self.effects(effects))
    }

    /// The biases of the image of a scene with these effects, in words; empty for an unbiased one.
    pub fn bias(&self, effects: EffectSet) -> Vec<String> {
        let limit = self
            .max_bounces
            .map(|n| format!("max_bounces {n}: light that scatters more often is missing"));
        let integrator = self.bias_of_integrator(effects);
        let is_cached =
            self.integrator == IntegratorKind::IrradianceCache && self.cache_error > 0.0;
        let cache = is_cached.then(|| {
            format!(
                "irradiance-cache: indirect light on matte surfaces is interpolated, with an error of up to about {} % that error bars do not include",
                100.0 * self.cache_error
            )
        });
        let all = [integrator, cache, self.adaptive.bias(), limit];
        all.into_iter().flatten().collect()
    }
}

/// The choice that the scene names, among those that exist.
fn chosen<T>(
    description: &SceneDescription,
    key: &str,
    wanted: &Option<Written<String>>,
    mut all: impl Iterator<Item = (&'static str, T)> + Clone,
) -> Result<Option<T>> {
    let Some(wanted) = wanted else {
        return Ok(None);
    };
    let names: Vec<&str> = all.clone().map(|(name, _)| name).collect();
    match all.find(|(name, _)| *name == wanted.value) {
        Some((_, choice)) => Ok(Some(choice)),
        None => Err(Error::scene(unknown_name("name", &wanted.value, &names))
            .in_file(&description.file)
            .at_line(wanted.line)
            .in_field(format!("render.{key}"))),
    }
}

/// The rule of Russian roulette of a scene.
fn roulette_of(description: &SceneDescription) -> Result<Option<Roulette>> {
    let Some(wanted) = &description.render.roulette else {
        return Ok(None);
    };
    let roulette = wanted.value.parse().map_err(|error| {
        let message = match error {
            NoRoulette::Name => unknown_name("name", &wanted.value, Roulette::NAMES),
            NoRoulette::Window => error.to_string(),
        };
        Error::scene(message)
            .in_file(&description.file)
            .at_line(wanted.line)
            .in_field("render.roulette")
    });
    roulette.map(Some)
}

/// The number of threads that this process may use.
pub fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elsewhere no other technique, or only a cache, finds what a compensated density leaves out.
    #[test]
    fn only_path_compensates_the_density_of_environment_maps() {
        for &integrator in IntegratorKind::ALL {
            let settings = RenderSettings {
                integrator,
                ..RenderSettings::new((1, 1), 1)
            };
            let is_compensated = settings.map_rule() == MapRule::Compensated;
            assert_eq!(is_compensated, integrator == IntegratorKind::Path);
        }
    }

    #[test]
    fn settings_out_of_their_range_are_usage_errors() {
        let fine = RenderSettings::new((8, 4), 1);
        assert!(fine.validate((8, 4)).is_ok());
        let window = |x, y, width, height| RenderSettings {
            window: Window {
                x,
                y,
                width,
                height,
            },
            ..fine.clone()
        };
        let budget = |spp, time| RenderSettings {
            budget: Budget {
                spp,
                time,
                error: None,
            },
            ..fine.clone()
        };
        for wrong in [
            window(0, 0, 9, 4),
            window(8, 0, 1, 1),
            window(0, 0, 0, 4),
            window(u32::MAX, 0, 2, 1),
            budget(None, None),
            budget(Some(0), None),
            budget(Some(u64::MAX), None),
            RenderSettings {
                threads: 0,
                ..fine.clone()
            },
            RenderSettings {
                tile_size: 0,
                ..fine.clone()
            },
        ] {
            let error = wrong
                .validate((8, 4))
                .expect_err("something is out of its range");
            assert_eq!(error.kind(), crate::ErrorKind::Usage, "{wrong:?}");
        }
        assert!(
            budget(None, Some(Duration::from_secs(1)))
                .validate((8, 4))
                .is_ok()
        );
    }

    #[test]
    fn a_bounce_limit_is_named_as_bias() {
        let mut settings = RenderSettings::new((8, 4), 1);
        assert!(settings.bias(EffectSet::NONE).is_empty());
        settings.max_bounces = Some(3);
        assert!(settings.bias(EffectSet::NONE)[0].contains("max_bounces 3"));
    }
}
