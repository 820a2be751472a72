//! What the command line asks of a render.
//!
//! Measure: as in `render/wishes.rs`.
//! Range: what flags say; what makes no sense together is found there.
//! Source: none needed. Tested in `tests/command/render.rs` and `tests/loading/bad_input.rs`.

use super::args::RenderArguments;
use crate::render::wishes::Wishes;

/// The wishes that these flags are.
pub fn wishes(arguments: &RenderArguments) -> Wishes {
    Wishes {
        integrator: arguments.integrator,
        sampler: arguments.sampler,
        seed: arguments.seed,
        spp: arguments.spp,
        time: arguments.time.or(arguments.max_time),
        error: arguments.error,
        confidence: Some(arguments.confidence),
        adaptive: arguments.adaptive,
        layers: arguments.layers || arguments.denoise.is_some(),
        max_bounces: arguments.max_bounces,
        roulette: arguments.roulette,
        occlusion_distance: arguments.occlusion_distance,
        cache_error: arguments.cache_error,
        kernel: arguments.kernel,
        threads: Some(arguments.tracing.options().threads),
        crop: arguments.crop,
    }
}
