//! The one place where settings become types: which kernel runs.
//!
//! Measure: none.
//! Range: every combination of settings.
//! Source: none needed. Tested in `tests/determinism.rs`.

use super::settings::{IntegratorKind, RenderSettings, SamplerKind};
use super::tile::{self, Outcome};
use crate::film::Tile;
use crate::film::filter::Filter;
use crate::integrator::path::PathIntegrator;
use crate::sampler::{Independent, Sobol};
use crate::scene::Scene;
use std::ops::Range;

/// The integrator that the settings ask for.
pub fn integrator(settings: &RenderSettings) -> PathIntegrator {
    match settings.integrator {
        IntegratorKind::Path => PathIntegrator {
            max_bounces: settings.max_bounces,
            roulette: settings.roulette,
        },
    }
}

/// Takes the samples of `range` in every pixel of a tile.
pub fn sample_tile(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    tile: &mut Tile,
    range: Range<u64>,
) -> Outcome {
    let integrator = integrator(settings);
    let seed = settings.seed;
    match settings.sampler {
        SamplerKind::Independent => tile::sample_tile(
            scene,
            filter,
            integrator,
            Independent::new(seed),
            tile,
            range,
        ),
        SamplerKind::Sobol => {
            tile::sample_tile(scene, filter, integrator, Sobol::new(seed), tile, range)
        }
    }
}
