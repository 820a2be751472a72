//! The settings of a render in C.
//!
//! Measure: samples per pixel, seconds.
//! Range: as the flags of `etendue render`; zeros stand for the settings of the scene, and then for the defaults.
//! Source: `etendue help render`.

use crate::memory::{Versioned, text};
use crate::status::Failure;
use renderer::Adaptive;
use renderer::BounceLimit;
use renderer::FilterSampling;
use renderer::IntegratorKind;
use renderer::LightPathRule;
use renderer::ParseRouletteError;
use renderer::PathReuseRule;
use renderer::RenderOptions;
use renderer::SamplerKind;
use std::ffi::c_char;
use std::mem::offset_of;
use std::time::Duration;

/// `EtdSettings.flags`: `seed` is given.
pub const ETD_HAS_SEED: u32 = 1;
/// `EtdSettings.flags`: `max_bounces` is given.
pub const ETD_HAS_MAX_BOUNCES: u32 = 2;
/// `EtdSettings.flags`: render layers, which can be read and written besides the image. The sample count is rounded up
/// to a multiple of 4.
pub const ETD_LAYERS: u32 = 4;
/// `EtdSettings.flags`: `crop` is given.
pub const ETD_HAS_CROP: u32 = 8;

const ALL_FLAGS: u32 = ETD_HAS_SEED | ETD_HAS_MAX_BOUNCES | ETD_LAYERS | ETD_HAS_CROP;

/// Settings of a render. Zeros and null stand for the settings of the scene, and then for the defaults.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdSettings {
    /// sizeof(EtdSettings)
    pub struct_size: usize,
    /// A sum of flags such as `ETD_HAS_SEED`.
    pub flags: u32,
    /// Maximum number of scattering events, with `ETD_HAS_MAX_BOUNCES`; `UINT32_MAX` for no limit. A limit causes bias.
    pub max_bounces: u32,
    /// Samples per pixel.
    pub spp: u64,
    /// Maximum time in seconds.
    pub seconds: f64,
    /// Target error, the square root of relMSE, such as 0.01.
    pub error: f64,
    /// Confidence level of the target error; 0 stands for 0.95.
    pub confidence: f64,
    /// Seed, which selects one of 2^64 sets of random numbers, with `ETD_HAS_SEED`.
    pub seed: u64,
    /// The integrator, such as "path" or "ambient-occlusion".
    pub integrator: *const c_char,
    /// The sampler: "sobol", "stratified" or "independent".
    pub sampler: *const c_char,
    /// Adaptive sampling: "off", "two-phase" or "greedy".
    pub adaptive: *const c_char,
    /// Russian roulette: "none", "albedo", "throughput", "window", or "window=1/N" with N from 1 to 64.
    pub roulette: *const c_char,
    /// Maximum distance, in world units, of occluders for ambient occlusion.
    pub occlusion_distance: f64,
    /// Admissible relative error of "irradiance-cache", as a fraction of the indirect light, such as 0.05; below 1.
    pub cache_error: f64,
    /// With `ETD_HAS_CROP`, x0, y0, x1, y1: only the pixels from (x0, y0) up to but not including (x1, y1) are rendered.
    pub crop: [u32; 4],
    /// Light paths for each camera path of "path": "auto", "off", "1/4", "1/2", "1" or "2"; with "caustics:" before a
    /// number, they are connected to the lens beyond glossy and smooth surfaces only.
    pub light_paths: *const c_char,
    /// Estimator of the filter: "splatting" or "importance".
    pub filter_sampling: *const c_char,
    /// Pixels that share the paths of "path": "auto", "off", "4" or "16".
    pub reuse: *const c_char,
}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdSettings {
    const NAME: &'static str = "EtdSettings";
    const FIRST_SIZE: usize = offset_of!(EtdSettings, light_paths);
}

impl EtdSettings {
    /// # Safety
    /// Its pointers are null, or NUL-terminated strings.
    pub unsafe fn options(&self) -> Result<RenderOptions, Failure> {
        if self.flags & !ALL_FLAGS != 0 {
            let unknown = self.flags & !ALL_FLAGS;
            return Err(Failure::argument(format!("flags: unknown bits {unknown}")));
        }
        let has = |flag: u32| self.flags & flag != 0;
        let mut options = RenderOptions::default();
        // SAFETY: the caller's promise.
        unsafe {
            let integrators = IntegratorKind::ALL.iter().map(|&it| (it.name(), it));
            options.integrator = named(self.integrator, integrators, "integrator")?;
            let samplers = SamplerKind::ALL.iter().map(|&it| (it.name(), it));
            options.sampler = named(self.sampler, samplers, "sampler")?;
            let ways = Adaptive::ALL.iter().map(|&it| (it.name(), it));
            options.adaptive = named(self.adaptive, ways, "adaptive")?;
            let rules = LightPathRule::ALL.iter().map(|&it| (it.name(), it));
            options.light_paths = named(self.light_paths, rules, "light_paths")?;
            let rules = PathReuseRule::ALL.iter().map(|&it| (it.name(), it));
            options.reuse = named(self.reuse, rules, "reuse")?;
            let estimators = FilterSampling::ALL.iter().map(|&it| (it.name(), it));
            options.filter_sampling = named(self.filter_sampling, estimators, "filter_sampling")?;
            let roulette = text(self.roulette, "roulette")?.map(str::parse);
            options.roulette = roulette.transpose().map_err(|error: ParseRouletteError| {
                Failure::argument(format!("roulette: {error}"))
            })?;
        }
        options.seed = has(ETD_HAS_SEED).then_some(self.seed);
        options.max_bounces = has(ETD_HAS_MAX_BOUNCES).then_some(match self.max_bounces {
            u32::MAX => BounceLimit::Unlimited,
            limit => BounceLimit::AtMost(limit),
        });
        options.layers = has(ETD_LAYERS);
        options.crop = has(ETD_HAS_CROP).then_some(self.crop);
        options.spp = (self.spp != 0).then_some(self.spp);
        options.time = duration(self.seconds)?;
        options.error = given(self.error, "error")?;
        options.confidence = given(self.confidence, "confidence")?;
        options.occlusion_distance = given(self.occlusion_distance, "occlusion_distance")?;
        options.cache_error = given(self.cache_error, "cache_error")?;
        Ok(options)
    }
}

/// Converts a number of seconds; `None` if it is 0.
fn duration(seconds: f64) -> Result<Option<Duration>, Failure> {
    let Some(seconds) = given(seconds, "seconds")? else {
        return Ok(None);
    };
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) => Ok(Some(time)),
        Err(_) => Err(Failure::argument("seconds: too large")),
    }
}

/// Returns a number above 0; `None` if it is 0.
fn given(number: f64, what: &str) -> Result<Option<f64>, Failure> {
    if number == 0.0 {
        return Ok(None);
    }
    if number > 0.0 {
        return Ok(Some(number));
    }
    Err(Failure::argument(format!(
        "{what}: expected a number above 0, or 0 for none, found {number}"
    )))
}

/// Returns a choice by its name; `None` if the name is null.
///
/// # Safety
/// The pointer is null, or a NUL-terminated string.
unsafe fn named<T>(
    name: *const c_char,
    mut all: impl Iterator<Item = (&'static str, T)> + Clone,
    what: &str,
) -> Result<Option<T>, Failure> {
    // SAFETY: the caller's promise.
    let Some(name) = (unsafe { text(name, what) })? else {
        return Ok(None);
    };
    let names: Vec<&str> = all.clone().map(|(name, _)| name).collect();
    match all.find(|(known, _)| *known == name) {
        Some((_, choice)) => Ok(Some(choice)),
        None => Err(Failure::argument(format!(
            "{what}: there is no {name:?}, only {}",
            names.join(", ")
        ))),
    }
}
