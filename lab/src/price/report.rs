//! The report of a price: its answers, the sources of the error, and the cheaper ways.
//!
//! Measure: seconds, samples per pixel, roots of relMSE; stated at each field.
//! Range: a price that was interrupted has the results so far.
//! Source: docs/accuracy.md, "The price". Tested in `cli/tests/command/price.rs`.

use super::answers::PriceRow;
use super::cheaper::Cheaper;
use crate::study::error_sources::ErrorSources;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::auto::Recommendation;
use serde::Serialize;

/// The settings of a price.
#[derive(Debug, Clone, Copy)]
pub struct PriceSettings {
    /// Seconds for everything, from the start of the command.
    pub budget: f64,
    /// The integrator; `auto` for the recommended one; `None` for that of the scene.
    pub integrator: Option<IntegratorKind>,
    /// Selects one of 2^64 sets of random numbers.
    pub seed: u64,
    /// Options of the acceleration structure.
    pub options: etendue::internals::accel::AccelOptions,
}

/// The price of a scene.
#[derive(Debug, Clone, Serialize)]
pub struct PriceReport {
    /// Version of the program.
    pub version: &'static str,
    /// The scene's file.
    pub scene: String,
    /// Size of the scene's image.
    pub full_size: (u32, u32),
    /// Size of the rendered image.
    pub size: (u32, u32),
    /// Number of threads.
    pub threads: usize,
    /// The integrator that was measured.
    pub integrator: &'static str,
    /// The sampler.
    pub sampler: &'static str,
    /// The recommended integrator and the reason, if `auto` was requested.
    #[serde(skip)]
    pub recommendation: Option<Recommendation>,
    /// Requested and elapsed seconds.
    pub budget: f64,
    /// Elapsed seconds.
    pub seconds: f64,
    /// Samples per pixel of the longest render.
    pub spp: u64,
    /// Its error, as far as it can be estimated.
    pub rel_rmse: Option<f64>,
    /// The reason why smaller errors cannot be foreseen, if there is one.
    pub doubt: Option<String>,
    /// Seconds of a sample of each pixel at the scene's own size.
    pub pace: f64,
    /// The time and the samples to each error.
    pub answers: Vec<PriceRow>,
    /// The sources of the error.
    pub error_sources: Option<ErrorSources>,
    /// Other ways to render it, with what they gain.
    pub cheaper: Vec<Cheaper>,
    /// Known biases of the measured settings.
    pub bias: Vec<String>,
    /// Notes, such as of what there was no time for.
    pub notes: Vec<String>,
    /// Whether everything was measured.
    pub complete: bool,
}
