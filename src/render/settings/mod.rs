//! The settings of a render.
//!
//! Measure: pixels, samples per pixel, seconds.
//! Range: stated at each field; [`RenderSettings::validate`] names what is out of it.
//! Source: design of the command line. Tested in the files of this folder and in `cli/tests/command/bad_flags.rs`.

mod bias;
mod choices;
mod limits;
mod of_scene;
mod rules;
mod validate;

pub use choices::{Adaptive, BounceLimit, LightPathRule, PathReuseRule, SamplerKind};
pub(super) use limits::{ADAPTIVE_PILOT, MIN_PILOT_DIVISOR, PILOT_DIVISOR};
pub use limits::{Budget, ErrorTarget};
pub use of_scene::DEFAULT_CACHE_ERROR;
pub use validate::MAX_SPP;

use crate::effects::Kernel;
use crate::film::Window;
use crate::film::filter::FilterSampling;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::integrator::reuse::PathReuse;
use crate::light::types::LightChoice;
use serde::Serialize;

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
    /// Whether a pilot chooses the weight window of `path` where no rule of roulette is named.
    #[serde(skip)]
    pub has_window_pilot: bool,
    /// The selection of lights; `None` for the integrator's own.
    pub light_choice: Option<LightChoice>,
    /// The number of light paths for each camera path of `path`.
    pub light_paths: LightPathRule,
    /// The number of pixels that share their paths, in renders by `path`: see [`Self::reuse`].
    pub reuse: PathReuseRule,
    /// The estimator of the filter, where both are possible: see [`Self::border_size`].
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
    /// independent, as statistics over pixels require, and no pilot chooses anything: the filter of a scene's render is
    /// splatted, and pilots choose its weight window, its light paths and the pixels that share paths ([`Self::of_scene`]).
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
            has_window_pilot: false,
            light_choice: None,
            light_paths: LightPathRule::OFF,
            reuse: PathReuseRule::Pixels(PathReuse::Off),
            filter_sampling: FilterSampling::Importance,
            occlusion_distance: None,
            cache_error: DEFAULT_CACHE_ERROR,
            kernel: None,
            threads: available_threads(),
            window: Window::whole(size),
            tile_size: 16,
        }
    }

    /// The settings with `path` in place of `auto`, for callers that do not need the best integrator.
    pub fn with_path_for_auto(mut self) -> Self {
        if self.integrator == IntegratorKind::Auto {
            self.integrator = IntegratorKind::Path;
        }
        self
    }
}

/// The number of threads that this process may use.
pub fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
