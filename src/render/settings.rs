//! What a render is asked to do.
//!
//! Measure: pixels, samples per pixel, seconds.
//! Range: said at each field; [`RenderSettings::validate`] names what is out of it.
//! Source: design of the command line. Tested below and in `cli/tests/command/bad_flags.rs`.

use crate::effects::{EffectSet, Kernel};
use crate::error::{Error, Result};
use crate::film::Window;
use crate::film::batches::BATCHES;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::scene::description::{SceneDescription, Written};
use crate::scene::load::unknown_name;
use std::time::Duration;

/// Samples per pixel where nobody says.
const DEFAULT_SPP: u64 = 64;

/// Samples per pixel at most: beyond 2^47, random numbers would repeat (`sampler/mod.rs`).
const MOST_SPP: u64 = 1 << 46;
/// The bound of an irradiance cache where nobody says.
pub const DEFAULT_CACHE_ERROR: f64 = 0.05;

/// Samples per pixel of an adaptive render's pilot, where that is not too large a share.
pub(super) const PILOT: u64 = 64;

/// It ends where this share of the budget is used up at the latest ...
pub(super) const LARGEST_SHARE_OF_PILOT: u64 = 4;

/// ... and goes on up to this one: the longer it is, the better it tells, and no pixel gets less in the end.
pub(super) const SHARE_OF_PILOT: u64 = 16;

/// Where random numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum SamplerKind {
    /// Independent numbers.
    Independent,
    /// Jittered strata, for the number of samples that is asked for.
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

/// When to stop: at the first of what is given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Budget {
    /// Samples per pixel at most, at least 1: in the mean over the pixels with two-phase sampling, in each with greedy.
    pub spp: Option<u64>,
    /// Time at most, for the rendering alone. The last pass ends as near to it as passes allow.
    pub time: Option<Duration>,
    /// The error that is good enough.
    pub error: Option<ErrorTarget>,
}

impl Budget {
    /// So many samples per pixel.
    pub fn samples(spp: u64) -> Self {
        Self {
            spp: Some(spp),
            ..Self::default()
        }
    }

    /// So much time.
    pub fn time(time: Duration) -> Self {
        Self {
            time: Some(time),
            ..Self::default()
        }
    }

    /// Samples per pixel of an adaptive render's pilot, as far as they are known before the first of them.
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

/// How samples are given out to the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Adaptive {
    /// The same number to each.
    #[default]
    Off,
    /// By the errors that a pilot shows, without bias.
    TwoPhase,
    /// To each until it seems good enough by its own samples. Biased.
    Greedy,
}

impl Adaptive {
    /// Every way.
    pub const ALL: &'static [Self] = &[Self::TwoPhase, Self::Greedy, Self::Off];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::TwoPhase => "two-phase",
            Self::Greedy => "greedy",
        }
    }

    /// What biases the picture, in words.
    pub fn bias(self) -> Option<String> {
        (self == Self::Greedy).then(|| {
            "greedy adaptive sampling: a pixel stops when its own samples are alike, also by chance"
                .to_owned()
        })
    }
}

/// An error to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorTarget {
    /// The root of relMSE, above 0 and below 1.
    pub rel_rmse: f64,
    /// The probability with which it is below that, above 0 and below 1.
    pub confidence: f64,
}

/// The settings of a render.
#[derive(Debug, Clone)]
pub struct RenderSettings {
    /// The estimator.
    pub integrator: IntegratorKind,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Picks one of 2^64 sets of random numbers.
    pub seed: u64,
    /// When to stop; at least one of its limits has to be given.
    pub budget: Budget,
    /// How samples are given out to the pixels.
    pub adaptive: Adaptive,
    /// Whether layers are to be written beside the picture. They take as many samples in each batch: the count is rounded up.
    pub layers: bool,
    /// Scattering events at most; `None` does not limit them.
    pub max_bounces: Option<u32>,
    /// When paths end by chance; `None` for the integrator's own way.
    pub roulette: Option<Roulette>,
    /// How far, in world units, something may be and still count for ambient occlusion; `None` for any distance.
    pub occlusion_distance: Option<f64>,
    /// The share of indirect light up to which an irradiance cache may be wrong, from 0, which is never, to below 1.
    pub cache_error: f64,
    /// The code that runs; `None` takes the smallest that has all effects of the scene. It changes nothing but the speed.
    pub kernel: Option<Kernel>,
    /// Threads, at least 1.
    pub threads: usize,
    /// The part of the picture to render.
    pub window: Window,
    /// Edge of a tile in pixels, at least 1. It changes nothing but the speed.
    pub tile_size: u32,
}

impl RenderSettings {
    /// The default settings for a whole picture of this size and this many samples per pixel.
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

    /// What a scene asks for, and the defaults where it does not say.
    ///
    /// # Errors
    /// A name that there is not, with its line.
    pub fn of_scene(description: &SceneDescription) -> Result<Self> {
        let render = &description.render;
        let integrators = IntegratorKind::ALL.iter().map(|&i| (i.name(), i));
        let integrator = chosen(description, "integrator", &render.integrator, integrators)?;
        let samplers = SamplerKind::ALL.iter().map(|&s| (s.name(), s));
        let sampler = chosen(description, "sampler", &render.sampler, samplers)?;
        let ways = Adaptive::ALL.iter().map(|&a| (a.name(), a));
        let adaptive = chosen(description, "adaptive", &render.adaptive, ways)?;
        let ways = Roulette::ALL.iter().map(|&r| (r.name(), r));
        let roulette = chosen(description, "roulette", &render.roulette, ways)?;
        let spp = render.spp.unwrap_or(DEFAULT_SPP);
        Ok(Self {
            integrator: integrator.unwrap_or_default(),
            sampler: sampler.unwrap_or_default(),
            seed: render.seed.unwrap_or(0),
            adaptive: adaptive.unwrap_or_default(),
            max_bounces: render.max_bounces,
            roulette,
            occlusion_distance: render.occlusion_distance,
            cache_error: render.cache_error.unwrap_or(DEFAULT_CACHE_ERROR),
            ..Self::new(description.film.size, spp)
        })
    }

    /// The same by `path` where the choice is left to `auto`: for those who do not look for the best.
    pub fn by_name(mut self) -> Self {
        if self.integrator == IntegratorKind::Auto {
            self.integrator = IntegratorKind::Path;
        }
        self
    }

    /// Whether the settings make sense for a picture of this size.
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
                    "the integrator {} has no adaptive sampling, as its paths from the lights go to pixels of their own choosing: take --adaptive off, or --integrator path",
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

    /// Scattering events at most, by these settings and by what the integrator is for.
    pub fn most_bounces(&self) -> Option<u32> {
        let limits = [self.max_bounces, self.integrator.most_bounces()];
        limits.into_iter().flatten().min()
    }

    /// What counts of samples are rounded up to a multiple of: where batches are compared one by one, or are all that there is,
    /// to that of the batches.
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

    /// How many samples the strata of a pixel are for, if that is known: in adaptive renders each has its own number, and
    /// strata are those of the pilot, again and again.
    pub fn samples_of_strata(&self) -> Option<u64> {
        match self.adaptive {
            Adaptive::Off => self.budget.spp,
            Adaptive::TwoPhase | Adaptive::Greedy => Some(self.budget.pilot()),
        }
    }

    /// When paths end by chance.
    pub fn roulette(&self) -> Roulette {
        self.roulette.unwrap_or(self.integrator.roulette())
    }

    /// What biases the picture of a scene with these effects, in words; empty for an unbiased one.
    pub fn bias(&self, effects: EffectSet) -> Vec<String> {
        let limit = self
            .max_bounces
            .map(|n| format!("max_bounces {n}: light that scatters more often is missing"));
        let integrator = self.integrator.bias(effects);
        let is_cached =
            self.integrator == IntegratorKind::IrradianceCache && self.cache_error > 0.0;
        let cache = is_cached.then(|| {
            format!(
                "irradiance-cache: indirect light on matte surfaces is interpolated, within about {} % of it, which error bars do not tell",
                100.0 * self.cache_error
            )
        });
        let all = [integrator, cache, self.adaptive.bias(), limit];
        all.into_iter().flatten().collect()
    }
}

/// A choice that the scene names, among those that there are.
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

/// The threads that this process may use.
pub fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

#[cfg(test)]
mod tests {
    use super::*;

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
