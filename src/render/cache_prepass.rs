//! The prepass before the first sample, which fills an irradiance cache.
//!
//! The first sample of some pixels is traced to the first surface where the cache may be used, and where no record
//! counts there, one is made. Pixels are taken from coarse to fine, in groups within which no pixel sees the others'
//! records: these are made on all threads and inserted one by one, in the order of their pixels, so that the cache is
//! the same on any number of threads. Between the last pixels, paths are traced where no record counts.
//!
//! Measure: pixels; records.
//! Range: `irradiance-cache` with a bound above 0; others need no prepass. At most one record for 12 pixels, of about
//! 200 bytes each.
//! Source: Ward, Rubinstein and Clear 1988, whose prepass Radiance calls the overture. Tested in `tests/rendering/irradiance_cache.rs`.

use super::dispatch::{kernel, path, run_matte_or_everything, sampler};
use super::pixel_block::PixelBlock;
use super::sample_wavefront::{CameraRaySource, PacketIndex, SampleWavefront};
use super::settings::RenderSettings;
use crate::effects::Effects;
use crate::effects::kernel::KernelJob;
use crate::film::batches::BATCHES;
use crate::film::filter::{Filter, FilterSampling};
use crate::integrator::RayCounts;
use crate::integrator::indirect::Uncached;
use crate::integrator::irradiance_cache::{
    CacheLookup, GatherScratch, IrradianceCache, LookupResult,
};
use crate::integrator::kind::IntegratorKind;
use crate::integrator::observer::NullPathObserver;
use crate::integrator::technique::Weighted;
use crate::math::lanes::ActiveLanes;
use crate::sampler::{AnySampler, Batches};
use crate::scene::Scene;
use rayon::prelude::*;

/// The sides of the squares, from pass to pass.
const STRIDES: [u32; 5] = [64, 32, 16, 8, 4];

/// The number of pixels in a group: enough for many threads, few enough to rarely make a record twice.
const GROUP: usize = 64;

/// A callback with the progress of a prepass, from 0 to 1, and the number of records; returns whether to continue.
pub type PrepassProgress<'a> = &'a dyn Fn(f64, usize) -> bool;

/// Fills the cache for a render that uses one, and counts the rays. An interrupted prepass leaves the records so far.
pub fn cache_prepass(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    progress: PrepassProgress<'_>,
) -> (Option<IrradianceCache>, RayCounts) {
    let mut rays = RayCounts::default();
    if settings.integrator != IntegratorKind::IrradianceCache {
        return (None, rays);
    }
    let mut cache = IrradianceCache::new(settings.cache_error);
    if settings.cache_error == 0.0 {
        return (Some(cache), rays);
    }
    let groups = groups(settings);
    for (done, positions) in groups.iter().enumerate() {
        if !progress(done as f64 / groups.len() as f64, cache.records().len()) {
            return (Some(cache), rays);
        }
        let pass = LookupPass {
            scene,
            filter,
            settings,
            cache: &cache,
            makes_records: true,
            positions,
        };
        for result in pass.results().into_iter().flatten() {
            if let LookupResult::New(record, its_rays) = result {
                rays += its_rays;
                cache.insert(record);
            }
        }
    }
    // Reports the end of the prepass. Cancellation is checked again before the first tile.
    progress(1.0, cache.records().len());
    (Some(cache), rays)
}

/// The number of records that count where the first sample of each pixel of the window would use the cache, row by row;
/// 0 where it would not.
pub fn cover(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    cache: &IrradianceCache,
) -> Vec<usize> {
    let positions: Vec<[u32; 2]> = settings.window.pixels().collect();
    let pass = LookupPass {
        scene,
        filter,
        settings,
        cache,
        makes_records: false,
        positions: &positions,
    };
    let count = |result: Option<LookupResult>| match result {
        Some(LookupResult::Known(count)) => count,
        Some(LookupResult::New(..)) | None => 0,
    };
    pass.results().into_iter().map(count).collect()
}

/// The pixels of all passes: the centres of ever smaller squares, without repetition.
fn groups(settings: &RenderSettings) -> Vec<Vec<[u32; 2]>> {
    let mut groups = Vec::new();
    for stride in STRIDES {
        let is_middle = |position: &[u32; 2]| position.iter().all(|i| i % stride == stride / 2);
        let pixels: Vec<[u32; 2]> = settings.window.pixels().filter(is_middle).collect();
        groups.extend(pixels.chunks(GROUP).map(<[_]>::to_vec));
    }
    groups
}

/// Lookups in the cache at some pixels of an image.
struct LookupPass<'a> {
    scene: &'a Scene,
    filter: &'a Filter,
    settings: &'a RenderSettings,
    cache: &'a IrradianceCache,
    makes_records: bool,
    positions: &'a [[u32; 2]],
}

impl LookupPass<'_> {
    fn results(&self) -> Vec<Option<LookupResult>> {
        run_matte_or_everything(kernel(self.scene, self.settings), self)
    }

    fn pixel<E: Effects>(
        &self,
        position: [u32; 2],
        sampler: &AnySampler,
        (wavefront, scratch): &mut (SampleWavefront, GatherScratch<E, AnySampler>),
    ) -> Option<LookupResult> {
        let lookup = CacheLookup {
            cache: self.cache,
            scene: self.scene,
            integrator: path(self.settings, Weighted, Uncached),
            makes_records: self.makes_records,
        };
        let source = CameraRaySource {
            scene: self.scene,
            filter: self.filter,
            filter_sampling: FilterSampling::Importance,
            sampler,
        };
        let block = PixelBlock::of(position);
        let lane = block.lane(position);
        let mut requested = ActiveLanes::NONE;
        requested.set(lane, true);
        wavefront.clear();
        let index = PacketIndex { block, sample: 0 };
        wavefront.add::<E, _>(&source, index, requested, &mut NullPathObserver);
        wavefront.trace(self.scene);
        let (camera_ray, hit) = wavefront.samples(0).camera_ray(lane);
        let sampler = wavefront.sampler(0, lane);
        // No image is so large that these are pixels of it, too.
        let sequence_pixel = position.map(|i| !i);
        lookup.on_path::<E, _>(sampler, &camera_ray, hit, sequence_pixel, scratch)
    }
}

impl KernelJob for &LookupPass<'_> {
    type Output = Vec<Option<LookupResult>>;

    fn run<E: Effects>(self) -> Self::Output {
        let sampler = sampler(self.settings, Batches::new(BATCHES));
        let positions = self.positions.par_iter();
        let memory = || (SampleWavefront::default(), GatherScratch::default());
        positions
            .map_init(memory, |memory, &position| {
                self.pixel::<E>(position, &sampler, memory)
            })
            .collect()
    }
}
