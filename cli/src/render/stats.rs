//! The statistics of a render, with names that stay.
//!
//! Measure: seconds, bytes, counts; said by each name.
//! Range: what is not known is null.
//! Source: docs/accuracy.md for the error. Tested in `cli/tests/command/render.rs`.

use crate::denoise::DenoiseStats;
use crate::output::explain;
use etendue::internals::film::{ErrorEstimate, Film};
use etendue::internals::integrator::RayCounts;
use etendue::internals::render::{Predicted, Price, Rejected};
use serde::Serialize;

/// All of it.
#[derive(Debug, Clone, Serialize)]
pub struct Stats {
    pub version: &'static str,
    pub scene: String,
    pub width: u32,
    pub height: u32,
    pub spp: u64,
    pub integrator: &'static str,
    /// Why it is that one, where the choice was left to `auto`.
    pub auto: Option<String>,
    pub sampler: &'static str,
    /// How samples are given out to the pixels.
    pub adaptive: &'static str,
    pub backend: &'static str,
    pub precision: &'static str,
    /// Of the acceleration structure.
    pub quality: &'static str,
    pub seed: u64,
    pub threads: usize,
    pub kernel: &'static str,
    pub effects: Vec<&'static str>,
    pub time: Times,
    pub samples: u64,
    /// The least and the most samples of a pixel.
    pub spp_range: [u64; 2],
    pub rays: Rays,
    pub samples_per_second: f64,
    pub rays_per_second: f64,
    pub memory: Memory,
    pub error: Option<ErrorStats>,
    /// What ten times less error would cost.
    pub price: Option<PriceStats>,
    /// The error asked for.
    pub target: Option<TargetStats>,
    /// What the noise filter did.
    pub denoise: Option<DenoiseStats>,
    pub rejected: RejectedStats,
    pub image: ImageStats,
    pub bias: Vec<String>,
    pub interrupted: bool,
}

/// Seconds.
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
pub struct Rays {
    pub camera: u64,
    pub closest: u64,
    pub shadow: u64,
}

/// Bytes.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Memory {
    pub peak_rss: Option<u64>,
    pub accel: u64,
    /// What light paths bring to the film, where there are any.
    pub splats: u64,
    /// Of the irradiance cache, where there is one.
    pub cache: Option<u64>,
}

#[derive(Debug, Clone, Serialize)]
pub struct ErrorStats {
    pub rel_rmse: f64,
    /// `None` where the samples cannot tell one.
    pub rel_rmse_upper: Option<f64>,
    pub confidence: f64,
    /// Why there is no bound, and what is told in its place.
    pub doubt: Option<DoubtStats>,
    /// The share of pixels whose error bars are not to be trusted.
    pub uncalibrated_fraction: f64,
}

/// Seconds of rendering to an error.
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

/// Why there is no bound.
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
    /// What the pilot told.
    pub predicted: Option<PredictedStats>,
}

/// Samples per pixel and seconds in all.
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

impl From<RayCounts> for Rays {
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
    /// One JSON object, over several lines.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain data always serialises") + "\n"
    }
}

/// The largest amount of memory that the process has had so far, in bytes, where the system tells (Linux, proc(5)).
pub fn peak_rss() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}
