//! The render options that the command line sets.
//!
//! Measure: as in `src/render/options.rs`.
//! Range: the values of the flags; `src/render/options.rs` rejects invalid combinations.
//! Source: none needed. Tested in `cli/tests/command/render.rs` and `cli/tests/command/bad_input.rs`.

use crate::args::RenderArguments;
use etendue::internals::render::options::RenderOptions;

/// Converts the flags to render options.
pub fn options(arguments: &RenderArguments) -> RenderOptions {
    let mut options = arguments.settings.options();
    options.seed = arguments.seed;
    options.spp = arguments.spp;
    options.time = arguments.time.or(arguments.max_time);
    options.error = arguments.error;
    options.confidence = Some(arguments.confidence);
    options.adaptive = arguments.adaptive;
    options.layers = arguments.layers || arguments.denoise.is_some();
    options.threads = Some(arguments.tracing.options().threads);
    options.kernel = arguments.kernel;
    options.crop = arguments.crop;
    options
}
