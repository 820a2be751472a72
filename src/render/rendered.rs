//! A render so far: its film, its counts, its estimated error, and the price of a smaller one.
//!
//! Measure: samples per pixel, seconds, roots of relMSE.
//! Range: from a render that has not begun to a finished one.
//! Source: docs/accuracy.md. Tested in `tests/rendering/`.

use super::adaptive::allocation::Allocation;
use super::budget::PlannerState;
use super::convergence::{ErrorRecord, PowerLaw, without_bound_if_rising};
use super::predicted::Predicted;
use super::settings::{ErrorTarget, RenderSettings};
use super::tally::Rejected;
use crate::film::filter::Filter;
use crate::film::{ErrorEstimate, Film};
use crate::integrator::RayCounts;
use crate::integrator::irradiance_cache::IrradianceCache;
use std::sync::Arc;
use std::time::Duration;

/// The state of a render so far.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The sums of all pixels.
    pub film: Film,
    /// The index of the first sample, above 0 in a shard.
    pub first: u64,
    /// Complete samples per pixel, the mean where pixels differ; some tiles have more after an interruption.
    pub spp: u64,
    /// The number of uniformly distributed samples per pixel with the same error, for an adaptive render; `None` where
    /// samples are distributed uniformly.
    pub equivalent_spp: Option<f64>,
    /// The allocation of samples to the pixels of an adaptive render, once its pilot is over.
    #[doc(hidden)]
    pub allocation: Option<Arc<Allocation>>,
    /// Whether the samples are a shard, to be merged with others.
    pub is_shard: bool,
    /// Whether this is the pilot, or a part of the pilot, of an adaptive render whose other samples are taken elsewhere.
    pub is_pilot: bool,
    /// Whether some pixels of an adaptive render have more samples than at its level, after an interruption.
    pub is_uneven: bool,
    /// Time that the rendering took.
    pub elapsed: Duration,
    /// Rays traced.
    pub rays: RayCounts,
    /// Samples that were not finite.
    pub rejected: Rejected,
    /// Whether the observer cancelled the render.
    pub cancelled: bool,
    /// Whether the render ended because the requested error was reached.
    pub reached: bool,
    /// The pilot's forecast for the requested error.
    pub predicted: Option<Predicted>,
    /// The records of the error during the render.
    #[doc(hidden)]
    pub error_records: Vec<ErrorRecord>,
    /// The state of the planner.
    #[doc(hidden)]
    pub planner: Option<PlannerState>,
    /// The irradiance cache, if there is one.
    #[doc(hidden)]
    pub cache: Option<IrradianceCache>,
}

impl Rendered {
    /// A render that has not begun.
    pub fn empty(settings: &RenderSettings, filter: &Filter) -> Self {
        Self {
            film: Film::of_layout(&settings.film_layout(filter)),
            first: 0,
            spp: 0,
            equivalent_spp: None,
            allocation: None,
            is_shard: false,
            is_pilot: false,
            is_uneven: false,
            elapsed: Duration::ZERO,
            rays: RayCounts::default(),
            rejected: Rejected::default(),
            cancelled: false,
            reached: false,
            predicted: None,
            error_records: Vec::new(),
            planner: None,
            cache: None,
        }
    }

    /// The estimated error of the image, with an upper bound of this confidence, judged also by how the error has
    /// fallen; `None` before it can be estimated.
    pub fn error(&self, confidence: f64) -> Option<ErrorEstimate> {
        let error = self.film.error(confidence)?;
        Some(without_bound_if_rising(
            error,
            self.even_spp(),
            &self.error_records,
        ))
    }

    /// Whether the bound of the error is at most the requested one.
    pub fn meets(&self, target: ErrorTarget) -> bool {
        let error = self.error(target.confidence);
        error.is_some_and(|error| error.upper_bound <= target.rel_rmse)
    }

    /// The number of uniformly distributed samples per pixel with this error, by which estimates of the error are
    /// compared.
    fn even_spp(&self) -> f64 {
        self.equivalent_spp.unwrap_or(self.spp as f64)
    }

    /// The price of dividing the error, as estimated here, by a factor, at the pace and by the power law of this
    /// render; `None` without an error, or if the error is in doubt.
    pub fn price(&self, error: &ErrorEstimate, factor: f64) -> Option<Price> {
        if error.doubt.is_some() || error.rel_rmse == 0.0 {
            return None;
        }
        let last = ErrorRecord::new(self.even_spp(), error);
        let before = self
            .error_records
            .iter()
            .filter(|record| record.samples < last.samples);
        let error_records: Vec<ErrorRecord> = before.copied().chain([last]).collect();
        let seconds = self.elapsed.as_secs_f64();
        let [least, likely, most] = PowerLaw::of(&error_records)
            .samples_for(factor)
            .map(|grown| seconds * grown);
        Some(Price {
            rel_rmse: error.rel_rmse / factor,
            seconds: likely,
            range: [least, most],
        })
    }
}

/// The time that a render takes to reach an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Price {
    /// The root of relMSE to be reached.
    pub rel_rmse: f64,
    /// The likely seconds of rendering, from the first sample on.
    pub seconds: f64,
    /// The least and the most seconds that the records of this render allow.
    pub range: [f64; 2],
}
