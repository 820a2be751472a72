//! The images of the three strategies of path tracing beside light paths: the light that is found by scattering, by light
//! sampling, and by light paths, each with its MIS weights.
//!
//! The three images sum to a render in which each sample belongs to one pixel, and each pixel has paths of its own.
//!
//! Measure: radiance.
//! Range: the integrator `path`, with or without light paths; 192 bytes a pixel for each strategy.
//! Source: `integrator/light_paths/mod.rs`. Tested in `tests/rendering/strategies.rs`.

use super::dispatch;
use super::estimator::Estimator;
use super::light_wavefront::LightWavefront;
use super::pixel_block::PixelBlock;
use super::sample_wavefront::{CameraRaySource, PacketIndex, SampleWavefront};
use super::settings::{PathReuseRule, RenderSettings};
use super::strategies;
use super::{RenderInput, Threads};
use crate::effects::Effects;
use crate::effects::kernel::KernelJob;
use crate::error::Result;
use crate::film::Window;
use crate::film::batches::BATCHES;
use crate::film::filter::FilterSampling;
use crate::film::splats::{SplatList, Splats};
use crate::image::Image;
use crate::integrator::Integrator;
use crate::integrator::light_paths::LightPathSplats;
use crate::integrator::observer::PathObserver;
use crate::integrator::path::PathIntegrator;
use crate::integrator::reuse::PathReuse;
use crate::math::rgb::Rgb;
use crate::sampler::{AnySampler, Batches};
use rayon::prelude::*;

/// A strategy by which `path` finds a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathStrategy {
    /// A scattered ray of a camera path hits the light, or leaves the scene.
    Scattering,
    /// Light sampling at a vertex of a camera path.
    LightSampling,
    /// A light path whose last surface is connected to the lens.
    LightPaths,
}

impl PathStrategy {
    /// Every strategy.
    pub const ALL: [Self; 3] = [Self::Scattering, Self::LightSampling, Self::LightPaths];

    /// The name in files, by the vertices of the light subpath (s) or of the camera subpath (t).
    pub fn name(self) -> &'static str {
        match self {
            Self::Scattering => "s0",
            Self::LightSampling => "s1",
            Self::LightPaths => "t1",
        }
    }
}

/// Renders the weighted image of each strategy, in the order of [`PathStrategy::ALL`].
///
/// # Errors
/// The errors of [`strategies::check`].
pub fn path_strategies(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
) -> Result<[Image; 3]> {
    let spp = strategies::check(settings)?;
    let settings = &RenderSettings {
        reuse: PathReuseRule::Pixels(PathReuse::Off),
        ..settings.clone()
    };
    let splats = PathStrategy::ALL.map(|_| Splats::new(settings.window));
    let sampler = dispatch::sampler(settings, Batches::new(BATCHES));
    let integrator = dispatch::path_with_all(settings);
    let kernel = dispatch::kernel(input.scene, settings);
    let job = PathStrategiesJob {
        input: *input,
        splats: &splats,
        image: settings.window,
        tile_size: settings.tile_size,
        spp,
        integrator,
        sampler: &sampler,
    };
    threads.run(|| dispatch::run_matte_or_everything(kernel, job));
    Ok(splats.map(|it| strategies::image_of(&it, settings.window, spp)))
}

/// The job of sampling tiles on rayon's current threads.
struct PathStrategiesJob<'a> {
    input: RenderInput<'a>,
    splats: &'a [Splats; 3],
    image: Window,
    tile_size: u32,
    spp: u64,
    integrator: PathIntegrator,
    sampler: &'a AnySampler,
}

impl KernelJob for PathStrategiesJob<'_> {
    type Output = ();

    fn run<E: Effects>(self) {
        let RenderInput { scene, filter, .. } = self.input;
        let reaches = |film| Splats::covers(self.image, filter, film);
        let new = || TileScratch::<E> {
            wavefront: SampleWavefront::default(),
            estimator: Estimator::new(scene, self.integrator),
            light_wavefront: LightWavefront::default(),
            light_path_splats: LightPathSplats {
                reaches: &reaches,
                with_gains: false,
                splats: Vec::new(),
            },
        };
        // Every thread takes the next tile when it is done with one, and keeps its memory.
        let tiles = self.image.tiles(self.tile_size).par_bridge();
        tiles.for_each_init(new, |scratch, tile| self.tile(tile, scratch));
    }
}

/// The memory of a thread, which it keeps from tile to tile.
struct TileScratch<'a, E: Effects> {
    wavefront: SampleWavefront,
    estimator: Estimator<'a, E, PathIntegrator>,
    light_wavefront: LightWavefront,
    light_path_splats: LightPathSplats<'a>,
}

impl PathStrategiesJob<'_> {
    /// Samples the pixels of a tile.
    fn tile<E: Effects>(&self, tile: Window, scratch: &mut TileScratch<'_, E>) {
        let RenderInput { scene, filter, .. } = self.input;
        let source = CameraRaySource {
            scene,
            filter,
            filter_sampling: FilterSampling::Importance,
            sampler: self.sampler,
        };
        let TileScratch {
            wavefront,
            estimator,
            light_wavefront,
            light_path_splats,
        } = scratch;
        for block in PixelBlock::covering(tile, 1) {
            let lanes = block.lanes_in(tile);
            for sample in 0..self.spp {
                wavefront.clear();
                let index = PacketIndex { block, sample };
                let mut found = Found::default();
                wavefront.add::<E, _>(&source, index, lanes, &mut found);
                wavefront.trace(scene);
                for lane in lanes.each() {
                    found = Found::default();
                    let splats = &mut SplatList::none();
                    wavefront.estimate_one(0, lane, estimator, &mut found, splats);
                    let weight = wavefront.weight(0, lane);
                    for (strategy, value) in [
                        (PathStrategy::Scattering, found.by_scattering),
                        (PathStrategy::LightSampling, found.by_light_sampling),
                    ] {
                        self.add(strategy, &index, lane, weight * value);
                    }
                }
                let share = estimator.integrator.light_paths().share;
                light_wavefront.clear();
                wavefront.add_light_paths(share, tile, light_wavefront);
                light_wavefront.trace(estimator, light_path_splats);
                let splats = light_path_splats
                    .splats
                    .drain(..)
                    .map(|it| (sample, it.splat));
                let splats: Vec<_> = splats.filter(|(_, it)| it.value.is_finite()).collect();
                self.splats[PathStrategy::LightPaths as usize].add(filter, &splats);
            }
        }
    }

    /// Adds the light that a sample has found by a strategy to its pixel.
    fn add(&self, strategy: PathStrategy, index: &PacketIndex, lane: usize, value: Rgb) {
        if value.is_finite() {
            // The sums are divided by the samples of all pixels, of which each pixel has one in `pixel_count`.
            let value = self.image.pixel_count() as f32 * value;
            let pixel = index.block.pixel(lane);
            self.splats[strategy as usize].add_to_pixel(index.sample, pixel, value);
        }
    }
}

/// The light that a camera path has found.
#[derive(Default)]
struct Found {
    by_scattering: Rgb,
    by_light_sampling: Rgb,
}

impl PathObserver for Found {
    fn environment(&mut self, contribution: Rgb) {
        self.by_scattering += contribution;
    }

    fn emission(&mut self, contribution: Rgb, _weight: f32) {
        self.by_scattering += contribution;
    }

    fn light(&mut self, contribution: Rgb, _weight: f32, visible: f32) {
        self.by_light_sampling += visible * contribution;
    }
}
