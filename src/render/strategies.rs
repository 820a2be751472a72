//! The images of the strategies of bidirectional path tracing: the contributions of each strategy, before and after
//! they are weighted.
//!
//! Unweighted, each image of paths with equally many edges converges to the same light wherever its strategy can find
//! it, with a noise of its own; weighted, all images sum to the render.
//!
//! Measure: radiance.
//! Range: paths of a limited number of scattering events; 192 bytes a pixel for each strategy.
//! Source: Veach 1997, figure 10.2. Tested in `tests/rendering/strategies.rs`.

use super::dispatch;
use super::pixel_block::PixelBlock;
use super::sample_wavefront::{CameraRaySource, PacketIndex, SampleWavefront};
use super::settings::RenderSettings;
use super::{RenderInput, Threads};
use crate::effects::Effects;
use crate::effects::kernel::KernelJob;
use crate::error::{Error, Result};
use crate::film::batches::BATCHES;
use crate::film::filter::FilterSampling;
use crate::film::splats::{Splats, Strategy};
use crate::film::{Film, Window};
use crate::image::Image;
use crate::integrator::RayCounts;
use crate::integrator::bidirectional::{Bidirectional, Contribution};
use crate::integrator::kind::IntegratorKind;
use crate::integrator::observer::NullPathObserver;
use crate::math::lanes::Lanes;
use crate::math::rgb::Rgb;
use crate::sampler::{AnySampler, Batches};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Mutex;

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
        .most_bounces()
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
    view: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
) -> Result<Vec<StrategyImages>> {
    let spp = check(settings)?;
    let pictures = StrategySplats {
        view: *view,
        window: settings.window,
        spp,
        found: Mutex::default(),
    };
    let film = Film::new(settings.window, settings.tile_size);
    let kernel = dispatch::kernel(view.scene, settings);
    let integrator = dispatch::bidirectional(settings, settings.window.pixel_count() as f64);
    let sampler = dispatch::sampler(settings, Batches::new(BATCHES));
    threads.run(|| {
        film.tiles().par_iter().with_max_len(1).for_each(|tile| {
            let job = Job {
                pictures: &pictures,
                window: tile.window,
                integrator,
                sampler: &sampler,
            };
            dispatch::run_matte_or_everything(kernel, job);
        });
    });
    let found = pictures.found.into_inner();
    let found = found.expect("no thread panics while it holds this");
    let picture = |splats: &Splats| image_of(splats, settings.window, spp);
    let pictures = found
        .iter()
        .map(|(&strategy, [unweighted, weighted])| StrategyImages {
            strategy,
            unweighted: picture(unweighted),
            weighted: picture(weighted),
        });
    Ok(pictures.collect())
}

/// The image of the splats of all samples.
pub(super) fn image_of(splats: &Splats, window: Window, spp: u64) -> Image {
    splats.add_paths(0, spp * window.pixel_count());
    let pixels = 0..window.pixel_count() as usize;
    let pixels = pixels.map(|pixel| Rgb::from(splats.mean(pixel).map(|x| x as f32)));
    Image::new(window.width, window.height, pixels.collect())
}

/// The images under construction.
struct StrategySplats<'a> {
    view: RenderInput<'a>,
    window: Window,
    spp: u64,
    /// The splats of each strategy, unweighted and weighted.
    found: Mutex<BTreeMap<Strategy, [Splats; 2]>>,
}

/// The job of sampling a tile.
struct Job<'a> {
    pictures: &'a StrategySplats<'a>,
    window: Window,
    integrator: Bidirectional,
    sampler: &'a AnySampler,
}

impl KernelJob for Job<'_> {
    type Output = ();

    fn run<E: Effects>(self) {
        let StrategySplats { view, window, .. } = *self.pictures;
        let RenderInput { scene, filter, .. } = view;
        let reaches = |film| Splats::covers(window, filter, film);
        let source = CameraRaySource {
            scene,
            filter,
            filter_sampling: FilterSampling::Importance,
            sampler: self.sampler,
        };
        let mut camera_rays = SampleWavefront::<E>::new();
        for block in PixelBlock::covering(self.window, 1) {
            let lanes = block.lanes_in(self.window);
            let mut contributions: Lanes<Vec<Contribution>> = Default::default();
            for sample in 0..self.pictures.spp {
                camera_rays.clear();
                let index = PacketIndex { block, sample };
                camera_rays.add(&source, index, lanes, &mut NullPathObserver);
                camera_rays.trace(scene);
                for lane in lanes.each() {
                    let weight = camera_rays.weight(0, lane);
                    let (camera_ray, hit) = camera_rays.samples(0).camera_ray(lane);
                    self.integrator.contributions::<E, _, _>(
                        scene,
                        camera_rays.sampler(0, lane),
                        &camera_ray,
                        hit,
                        &mut RayCounts::default(),
                        &mut NullPathObserver,
                        &reaches,
                        |mut it| {
                            if it.film.is_none() {
                                it.unweighted *= weight;
                            }
                            contributions[lane].push(it);
                        },
                    );
                }
            }
            for lane in lanes.each() {
                self.pictures.add(block.pixel(lane), &contributions[lane]);
            }
        }
    }
}

impl StrategySplats<'_> {
    fn add(&self, pixel: [u32; 2], contributions: &[Contribution]) {
        let mut found = self
            .found
            .lock()
            .expect("no thread panics while it holds this");
        // The sums are divided by the samples of all pixels, of which each pixel has one in `pixel_count`.
        let share = self.window.pixel_count() as f32;
        for contribution in contributions {
            let new = || [0, 1].map(|_| Splats::new(self.window));
            let pictures = found.entry(contribution.strategy).or_insert_with(new);
            let values = [contribution.unweighted, contribution.value()];
            for (picture, value) in pictures.iter().zip(values) {
                match contribution.film {
                    Some(film) => picture.add(self.view.filter, 0, film, value),
                    None => picture.add_to_pixel(0, pixel, share * value),
                }
            }
        }
    }
}
