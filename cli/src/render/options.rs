//! What the command line asks of a render.
//!
//! Measure: as in `render/wishes.rs`.
//! Range: what flags say; what makes no sense together is found there.
//! Source: none needed. Tested in `cli/tests/command/render.rs` and `cli/tests/command/bad_input.rs`.

use crate::args::RenderArguments;
use etendue::internals::render::wishes::Wishes;

/// The wishes that these flags are.
pub fn wishes(arguments: &RenderArguments) -> Wishes {
    let mut wishes = Wishes::default();
    wishes.integrator = arguments.integrator;
    wishes.sampler = arguments.sampler;
    wishes.seed = arguments.seed;
    wishes.spp = arguments.spp;
    wishes.time = arguments.time.or(arguments.max_time);
    wishes.error = arguments.error;
    wishes.confidence = Some(arguments.confidence);
    wishes.adaptive = arguments.adaptive;
    wishes.layers = arguments.layers || arguments.denoise.is_some();
    wishes.max_bounces = arguments.max_bounces;
    wishes.roulette = arguments.roulette;
    wishes.occlusion_distance = arguments.occlusion_distance;
    wishes.cache_error = arguments.cache_error;
    wishes.kernel = arguments.kernel;
    wishes.threads = Some(arguments.tracing.options().threads);
    wishes.crop = arguments.crop;
    wishes
}
