//! The render options that the command line sets.
//!
//! Measure: as in `src/render/options.rs`.
//! Range: the values of the flags; `src/render/options.rs` rejects invalid combinations.
//! Source: none needed. Tested in `cli/tests/command/render.rs` and `cli/tests/command/bad_input.rs`.

use crate::args::RenderArguments;
use etendue::internals::render::options::RenderOptions;

/// Converts the flags to render options.
pub fn options(arguments: &RenderArguments) -> RenderOptions {
    let mut options = RenderOptions::default();
    options.integrator = arguments.integrator;
    options.sampler = arguments.sampler;
    options.seed = arguments.seed;
    options.spp = arguments.spp;
    options.time = arguments.time.or(arguments.max_time);
    options.error = arguments.error;
    options.confidence = Some(arguments.confidence);
    options.adaptive = arguments.adaptive;
    options.layers = arguments.layers || arguments.denoise.is_some();
    options.max_bounces = arguments.max_bounces;
    options.roulette = arguments.roulette;
    options.light_paths = arguments.light_paths;
    options.reuse = arguments.reuse;
    options.light_choice = arguments.light_choice;
    options.filter_sampling = arguments.filter_sampling;
    options.occlusion_distance = arguments.occlusion_distance;
    options.cache_error = arguments.cache_error;
    options.kernel = arguments.kernel;
    options.threads = Some(arguments.tracing.options().threads);
    options.crop = arguments.crop;
    options
}
