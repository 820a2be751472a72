//! The statistics of a render, under stable names.
//!
//! Measure: seconds, bytes, counts; stated at each name.
//! Range: an unknown value is null.
//! Source: docs/accuracy.md for the error. Tested in `cli/tests/command/render.rs`.

use crate::denoise::DenoiseStats;
use crate::output::explain;
use etendue::internals::film::{ErrorEstimate, Film};
use etendue::internals::integrator::RayCounts;
use etendue::internals::render::{Predicted, Price, Rejected};
use serde::Serialize;

/// The statistics of a render.
#[derive(Debug, Clone, Serialize)]
pub struct Stats {
    pub version: &'static str,
    pub scene: String,
    pub width: u32,
    pub height: u32,
    pub spp: u64,
    pub integrator: &'static str,
    /// The reason for the integrator, if `auto` chose it.
    pub auto: Option<String>,
    /// The reconstruction filter, and how it is estimated.
    pub filter: String,
    /// The rule of Russian roulette.
    pub roulette: String,
    /// The number of light paths for each camera path, in words.
    pub light_paths: &'static str,
    /// The number of pixels that share their paths, or `off`.
    pub reuse: &'static str,
    pub sampler: &'static str,
    /// The distribution of samples over the pixels.
    pub adaptive: &'static str,
    pub backend: &'static str,
    pub precision: &'static str,
    /// The build quality of the acceleration structure.
    pub quality: &'static str,
    pub seed: u64,
    pub threads: usize,
    pub kernel: &'static str,
    pub effects: Vec<&'static str>,
    pub time: Times,
    pub samples: u64,
    /// The smallest and the largest sample count of a pixel.
    pub spp_range: [u64; 2],
    pub rays: RayStats,
    pub samples_per_second: f64,
    pub rays_per_second: f64,
    pub memory: Memory,
    pub error: Option<ErrorStats>,
    /// The cost of an error ten times smaller.
    pub price: Option<PriceStats>,
    /// The requested error.
    pub target: Option<TargetStats>,
    /// The statistics of the noise filter.
    pub denoise: Option<DenoiseStats>,
    pub rejected: RejectedStats,
    pub image: ImageStats,
    pub bias: Vec<String>,
    pub interrupted: bool,
}

/// The durations of the phases in seconds.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Times {
    pub load: f64,
    pub build: f64,
    pub render: f64,
    pub denoise: f64,
    pub write: f64,
    pub total: f64,
}

#[derive(Debug, Clone, Copy, Serialize)]
pub struct RayStats {
    pub camera: u64,
    pub closest: u64,
    pub shadow: u64,
}

/// The memory use in bytes.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Memory {
    pub peak_rss: Option<u64>,
    pub accel: u64,
    /// The splat buffer of light subpaths, 0 if there is none.
    pub splats: u64,
    /// The irradiance cache, if there is one.
    pub cache: Option<u64>,
}

#[derive(Debug, Clone, Serialize)]
pub struct ErrorStats {
    pub rel_rmse: f64,
    /// The upper bound; `None` if the samples do not yield one.
    pub rel_rmse_upper: Option<f64>,
    pub confidence: f64,
    /// The reason for a missing bound, with a lower bound in its place.
    pub doubt: Option<DoubtStats>,
    /// The share of pixels whose error bars are flagged as not reliable.
    pub uncalibrated_fraction: f64,
}

/// The predicted render time in seconds to reach an error.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PriceStats {
    pub rel_rmse: f64,
    pub seconds: f64,
    pub seconds_range: [f64; 2],
}

impl From<Price> for PriceStats {
    fn from(price: Price) -> Self {
        Self {
            rel_rmse: price.rel_rmse,
            seconds: price.seconds,
            seconds_range: price.range,
        }
    }
}

/// The reason why there is no upper bound.
#[derive(Debug, Clone, Serialize)]
pub struct DoubtStats {
    pub rel_rmse_at_least: f64,
    pub why: String,
}

#[derive(Debug, Clone, Copy, Serialize)]
pub struct TargetStats {
    pub rel_rmse: f64,
    pub confidence: f64,
    pub reached: bool,
    /// The pilot's prediction.
    pub predicted: Option<PredictedStats>,
}

/// The predicted total of samples per pixel and seconds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PredictedStats {
    pub pilot: u64,
    pub spp: u64,
    pub seconds: f64,
}

impl From<Predicted> for PredictedStats {
    fn from(predicted: Predicted) -> Self {
        Self {
            pilot: predicted.pilot,
            spp: predicted.spp,
            seconds: predicted.time.as_secs_f64(),
        }
    }
}

#[derive(Debug, Clone, Copy, Serialize)]
pub struct RejectedStats {
    pub count: u64,
    pub first: Option<RejectedSample>,
}

#[derive(Debug, Clone, Copy, Serialize)]
pub struct RejectedSample {
    pub x: u32,
    pub y: u32,
    pub sample: u64,
}

#[derive(Debug, Clone, Copy, Serialize)]
pub struct ImageStats {
    pub mean: [f64; 3],
}

impl From<RayCounts> for RayStats {
    fn from(rays: RayCounts) -> Self {
        Self {
            camera: rays.camera,
            closest: rays.closest,
            shadow: rays.shadow,
        }
    }
}

impl ErrorStats {
    pub fn new(error: ErrorEstimate, film: &Film) -> Self {
        let bound = error.upper_bound;
        Self {
            rel_rmse: error.rel_rmse,
            rel_rmse_upper: bound.is_finite().then_some(bound),
            confidence: error.confidence,
            doubt: error.doubt.map(|doubt| DoubtStats {
                rel_rmse_at_least: doubt.at_least(),
                why: explain(doubt),
            }),
            uncalibrated_fraction: film.error_bars().flagged_share(),
        }
    }
}

impl From<Rejected> for RejectedStats {
    fn from(rejected: Rejected) -> Self {
        let first = rejected.first.map(|s| RejectedSample {
            x: s.x,
            y: s.y,
            sample: s.sample,
        });
        Self {
            count: rejected.count,
            first,
        }
    }
}

impl ImageStats {
    pub fn of(film: &Film) -> Self {
        Self { mean: film.mean() }
    }
}

impl Stats {
    /// Returns one JSON object over several lines.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain data always serialises") + "\n"
    }
}

/// Returns the peak resident memory of the process in bytes, where the system reports it (Linux, proc(5)).
pub fn peak_rss() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
