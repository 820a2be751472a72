//! The images of the strategies of bidirectional path tracing: the contributions of each strategy, before and after
//! they are weighted.
//!
//! Unweighted, each image of paths with equally many edges converges to the same light wherever its strategy can find
//! it, with a noise of its own; weighted, all images sum to the render.
//!
//! Measure: radiance.
//! Range: paths of a limited number of scattering events; 384 bytes a pixel for each strategy.
//! Source: Veach 1997, figure 10.2. Tested in `tests/rendering/strategies.rs`.

use super::dispatch;
use super::pixel_block::PixelBlock;
use super::sample_wavefront::{CameraRaySource, PacketIndex, SampleWavefront};
use super::settings::RenderSettings;
use super::{RenderInput, Threads};
use crate::effects::Effects;
use crate::effects::kernel::KernelJob;
use crate::error::{Error, Result};
use crate::film::Window;
use crate::film::batches::BATCHES;
use crate::film::filter::FilterSampling;
use crate::film::splats::{Splat, Splats, Strategy};
use crate::image::Image;
use crate::integrator::RayCounts;
use crate::integrator::bidirectional::{Bidirectional, Contribution, SubpathScratch};
use crate::integrator::kind::IntegratorKind;
use crate::integrator::observer::NullPathObserver;
use crate::math::lanes::Lanes;
use crate::math::rgb::Rgb;
use crate::sampler::{AnySampler, Batches};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Mutex;

/// The contributions of a pixel that a thread collects before it adds them to the images, which other threads wait for.
const MAX_CONTRIBUTIONS: usize = 4096;

/// The largest number of scattering events of paths whose strategies are shown.
const MAX_BOUNCES: u32 = 8;

/// The images of one strategy.
#[derive(Debug, Clone)]
pub struct StrategyImages {
    /// The strategy.
    pub strategy: Strategy,
    /// The image as if there were no other strategy.
    pub unweighted: Image,
    /// The share of the image, with MIS weights.
    pub weighted: Image,
}

/// Checks that the strategies of these settings can be shown, and returns the samples per pixel.
///
/// # Errors
/// A usage error that states the requirement.
pub fn check(settings: &RenderSettings) -> Result<u64> {
    let is_limited = settings
        .bounce_limit()
        .is_some_and(|most| most <= MAX_BOUNCES);
    let is_bidirectional = settings.integrator == IntegratorKind::Bidirectional;
    match settings.budget.spp {
        _ if !is_bidirectional && settings.integrator != IntegratorKind::Path => Err(Error::usage(
            "only path and bidirectional path tracing have strategies: give --integrator path or --integrator bdpt",
        )),
        _ if is_bidirectional && !is_limited => Err(Error::usage(format!(
            "each path length has its own strategies: limit it by --max-bounces {MAX_BOUNCES} or less, such as --max-bounces 3"
        ))),
        None => Err(Error::usage(
            "strategies are written after a fixed number of samples: give --spp",
        )),
        Some(spp) => Ok(spp),
    }
}

/// Renders the images of all strategies that contribute anything, with the samples of a render.
///
/// # Errors
/// The errors of [`check`].
pub fn strategies(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
) -> Result<Vec<StrategyImages>> {
    let spp = check(settings)?;
    let splats = StrategySplats {
        input: *input,
        window: settings.window,
        spp,
        by_strategy: Mutex::default(),
    };
    let kernel = dispatch::kernel(input.scene, settings);
    let integrator = dispatch::bidirectional(settings, settings.window.pixel_count() as f64);
    let sampler = dispatch::sampler(settings, Batches::new(BATCHES));
    let job = StrategiesJob {
        splats: &splats,
        tile_size: settings.tile_size,
        integrator,
        sampler: &sampler,
    };
    threads.run(|| dispatch::run_matte_or_everything(kernel, job));
    let by_strategy = splats.by_strategy.into_inner();
    let by_strategy = by_strategy.expect("no thread panics while it holds this");
    let image = |splats: &Splats| image_of(splats, settings.window, spp);
    let images = by_strategy
        .iter()
        .map(|(&strategy, [unweighted, weighted])| StrategyImages {
            strategy,
            unweighted: image(unweighted),
            weighted: image(weighted),
        });
    Ok(images.collect())
}

/// The image of the splats of all samples.
pub(super) fn image_of(splats: &Splats, window: Window, spp: u64) -> Image {
    splats.add_samples(0, spp * window.pixel_count());
    let pixels = 0..window.pixel_count() as usize;
    let pixels = pixels.map(|pixel| Rgb::from(splats.mean(pixel).map(|x| x as f32)));
    Image::new(window.width, window.height, pixels.collect())
}

/// The sums of the images of all strategies.
struct StrategySplats<'a> {
    input: RenderInput<'a>,
    window: Window,
    spp: u64,
    /// The splats of each strategy, unweighted and weighted.
    by_strategy: Mutex<BTreeMap<Strategy, [Splats; 2]>>,
}

/// The job of sampling tiles on rayon's current threads.
struct StrategiesJob<'a> {
    splats: &'a StrategySplats<'a>,
    tile_size: u32,
    integrator: Bidirectional,
    sampler: &'a AnySampler,
}

impl KernelJob for StrategiesJob<'_> {
    type Output = ();

    fn run<E: Effects>(self) {
        // Every thread takes the next tile when it is done with one, and keeps its memory.
        let tiles = self.splats.window.tiles(self.tile_size).par_bridge();
        tiles.for_each_init(TileScratch::<E>::default, |scratch, tile| {
            self.tile(tile, scratch);
        });
    }
}

/// The memory of a thread, which it keeps from tile to tile.
struct TileScratch<'a, E: Effects> {
    wavefront: SampleWavefront,
    subpaths: SubpathScratch<'a, E>,
    /// The contributions of the samples of each pixel of a block.
    contributions: Lanes<Vec<Contribution>>,
}

impl<E: Effects> Default for TileScratch<'_, E> {
    fn default() -> Self {
        Self {
            wavefront: SampleWavefront::default(),
            subpaths: SubpathScratch::default(),
            contributions: Lanes::default(),
        }
    }
}

impl<'a> StrategiesJob<'a> {
    /// Samples the pixels of a tile.
    fn tile<E: Effects>(&self, tile: Window, scratch: &mut TileScratch<'a, E>) {
        let StrategySplats { input, window, .. } = *self.splats;
        let RenderInput { scene, filter, .. } = input;
        let reaches = |film| Splats::covers(window, filter, film);
        let source = CameraRaySource {
            scene,
            filter,
            filter_sampling: FilterSampling::Importance,
            sampler: self.sampler,
        };
        let TileScratch {
            wavefront,
            subpaths,
            contributions,
        } = scratch;
        for block in PixelBlock::covering(tile, 1) {
            let lanes = block.lanes_in(tile);
            for sample in 0..self.splats.spp {
                wavefront.clear();
                let index = PacketIndex { block, sample };
                wavefront.add::<E, _>(&source, index, lanes, &mut NullPathObserver);
                wavefront.trace(scene);
                for lane in lanes.each() {
                    let weight = wavefront.weight(0, lane);
                    let (camera_ray, hit) = wavefront.samples(0).camera_ray(lane);
                    self.integrator.contributions::<E, _, _>(
                        scene,
                        wavefront.sampler(0, lane),
                        &camera_ray,
                        hit,
                        &mut RayCounts::default(),
                        subpaths,
                        &mut NullPathObserver,
                        &reaches,
                        |mut it| {
                            if it.film.is_none() {
                                it.unweighted *= weight;
                            }
                            contributions[lane].push(it);
                        },
                    );
                    if contributions[lane].len() >= MAX_CONTRIBUTIONS {
                        self.splats.add(block.pixel(lane), &mut contributions[lane]);
                    }
                }
            }
            for lane in lanes.each() {
                self.splats.add(block.pixel(lane), &mut contributions[lane]);
            }
        }
    }
}

impl StrategySplats<'_> {
    /// Adds the contributions of samples of a pixel, and removes them from the list.
    fn add(&self, pixel: [u32; 2], contributions: &mut Vec<Contribution>) {
        let mut by_strategy = self
            .by_strategy
            .lock()
            .expect("no thread panics while it holds this");
        // The sums are divided by the samples of all pixels, of which each pixel has one in `pixel_count`.
        let share = self.window.pixel_count() as f32;
        for contribution in contributions.drain(..) {
            let new = || [0, 1].map(|_| Splats::new(self.window));
            let splats = by_strategy.entry(contribution.strategy).or_insert_with(new);
            let values = [contribution.unweighted, contribution.value()];
            for (splats, value) in splats.iter().zip(values) {
                match contribution.film {
                    Some(film_position) => {
                        let splat = Splat {
                            film_position,
                            value,
                        };
                        splats.add(self.input.filter, &[(0, splat)]);
                    }
                    None => splats.add_to_pixel(0, pixel, share * value),
                }
            }
        }
    }
}
