//! The samples of one tile of a render, with an observer of their paths.
//!
//! Measure: samples.
//! Range: any tile of a film and any sample indices; the sums are bit for bit those of the render with the same settings.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::dispatch;
use super::sample_range::SampleRange;
use super::sample_wavefront::CameraRaySource;
use super::settings::RenderSettings;
use super::tile::{ObservedTileJob, SampleSource};
use crate::film::Tile;
use crate::film::batches::BATCHES;
use crate::film::filter::{Filter, FilterSampling};
use crate::integrator::irradiance_cache::IrradianceCache;
use crate::integrator::observer::PathObserver;
use crate::sampler::Batches;
use crate::scene::Scene;
use std::ops::Range;

/// Adds the samples of `range` to every pixel of a tile, in the order of a render, and reports their paths to
/// `observer`. `cache` is that of [`cache_prepass`](super::cache_prepass::cache_prepass), if there is one.
pub fn observe_tile(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    cache: Option<&IrradianceCache>,
    tile: &mut Tile,
    range: Range<u64>,
    observer: &mut dyn PathObserver,
) {
    let sampler = dispatch::sampler(settings, Batches::new(BATCHES));
    let filter_sampling = match tile.splatted {
        Some(_) => FilterSampling::Splatting,
        None => FilterSampling::Importance,
    };
    let job = ObservedTileJob {
        source: SampleSource {
            rays: CameraRaySource {
                scene,
                filter,
                filter_sampling,
                sampler: &sampler,
            },
            splats: None,
            gains: None,
        },
        tile,
        sample_range: SampleRange::Same(range),
        observer,
    };
    dispatch::dispatch_to_matte_or_everything(scene, settings, cache, job);
}
