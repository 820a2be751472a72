//! Rendered images: the integrators, their samples, their error bars, and post-processing.

#[path = "../common/mod.rs"]
mod common;

mod adaptive;
mod adaptive_pixels;
mod adaptive_shards;
mod auto;
mod bidirectional;
mod denoise;
mod determinism;
mod effects;
mod error_bars;
mod filters;
mod integrators;
mod irradiance_cache;
mod lens;
mod light_choice;
mod light_paths;
mod metamorphic;
mod metropolis;
mod motion;
mod pixels;
mod resume;
mod reuse;
mod roulette;
mod session;
mod state;
mod state_headers;
mod strategies;
