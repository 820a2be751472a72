//! `etendue plan --shards`: how many shards of what length bring an image to an error, by a pilot.
//!
//! Measure: samples per pixel, seconds on a machine like this one with all its threads.
//! Range: scenes whose error the pilot can estimate; where it is in doubt, the report says so and has no numbers.
//! Source: the forecast of `src/render/convergence.rs`. Tested in `cli/tests/command/plan.rs`.

use super::args::PlanArguments;
use super::durations::format_duration;
use super::output::format_percent;
use etendue::Result;
use etendue::internals::render::settings::Adaptive;
use etendue::internals::render::{CONFIDENCE, RenderObserver};
use etendue::internals::session::Session;
use etendue::internals::state::State;
use serde::Serialize;
use std::time::Duration;

/// The samples per pixel of the pilot, enough for two estimates of the error.
const PILOT_SPP: u64 = 256;
/// The longest time of the pilot.
const MAX_PILOT_TIME: Duration = Duration::from_secs(60);

/// The shards that bring an image to an error.
#[derive(Debug, Serialize)]
pub struct ShardPlan {
    /// The error to reach.
    rel_rmse: f64,
    /// The samples per pixel of the pilot, and its error.
    pilot_spp: u64,
    pilot_rel_rmse: Option<f64>,
    /// The samples per pixel of the render; `None` if the error after the pilot is in doubt.
    spp: Option<u64>,
    /// The time of all shards together, in seconds.
    seconds: Option<f64>,
    /// The number of shards, and the samples per pixel of each.
    shards: Option<u64>,
    spp_of_shard: Option<u64>,
}

impl ShardPlan {
    /// Renders a pilot of the whole image, and plans by it; `None` without `--shards`, or if the pilot was cancelled.
    pub fn new(
        arguments: &PlanArguments,
        session: &Session,
        observer: &dyn RenderObserver,
    ) -> Result<Option<Self>> {
        let Some(target) = arguments.error else {
            return Ok(None);
        };
        let mut options = arguments.settings.options();
        options.spp = Some(PILOT_SPP);
        options.time = Some(MAX_PILOT_TIME);
        options.adaptive = Some(Adaptive::Off);
        let rendering = session.render(&options, observer)?;
        let rendered = rendering.rendered();
        if rendered.cancelled {
            return Ok(None);
        }
        let error = rendering.error(CONFIDENCE);
        let state = State {
            header: rendering.header(session)?.of(rendered, &[]),
            film: rendered.film.clone(),
            layers: vec![],
            allocation: None,
        };
        let spp = state.needed_spp(target, CONFIDENCE);
        let of_sample = rendered.elapsed.as_secs_f64() / rendered.spp as f64;
        let least = |spp: u64| spp.div_ceil(4);
        let shards = spp.map(|spp| {
            let seconds = spp as f64 * of_sample;
            let count = (seconds / arguments.shard_time.as_secs_f64()).ceil() as u64;
            count.clamp(1, least(spp))
        });
        Ok(Some(Self {
            rel_rmse: target,
            pilot_spp: rendered.spp,
            pilot_rel_rmse: error.map(|error| error.rel_rmse),
            spp,
            seconds: spp.map(|spp| spp as f64 * of_sample),
            shards,
            spp_of_shard: spp.zip(shards).map(|(spp, shards)| spp.div_ceil(shards)),
        }))
    }

    /// The plan in words.
    pub fn describe(&self) -> String {
        let pilot = match self.pilot_rel_rmse {
            Some(error) => format!("{} after {} spp", format_percent(error), self.pilot_spp),
            None => format!("unknown after {} spp", self.pilot_spp),
        };
        let target = format_percent(self.rel_rmse);
        let (Some(spp), Some(seconds), Some(shards), Some(length)) =
            (self.spp, self.seconds, self.shards, self.spp_of_shard)
        else {
            return format!(
                "shards to {target}: no forecast, since the error is {pilot} and in doubt: render more, and let `etendue merge --error` tell"
            );
        };
        let each = Duration::from_secs_f64(seconds / shards as f64);
        let noun = if shards == 1 { "shard" } else { "shards" };
        format!(
            "shards to {target}: about {spp} spp in all, {} on this machine; as {shards} {noun} of {length} spp, {} each; the error is {pilot}",
            format_duration(Duration::from_secs_f64(seconds.min(1e15))),
            format_duration(each)
        )
    }
}
