//! The settings and the samples of a pilot, and the weights of relMSE for their variances.
//!
//! Measure: radiance; relative variance.
//! Range: any tiles of films without a footprint.
//! Source: none needed. Tested through the pilots.

use super::super::dispatch;
use super::super::gain_sums::GainSums;
use super::super::sample_range::SampleRange;
use super::super::sample_wavefront::CameraRaySource;
use super::super::settings::{Adaptive, Budget, RenderSettings, SamplerKind};
use super::super::tile::{PassJob, SampleSource};
use super::super::{RenderObserver, Threads};
use crate::error::Result;
use crate::film::Tile;
use crate::film::batches::BATCHES;
use crate::film::filter::{Filter, FilterDescription, FilterKind, FilterSampling};
use crate::film::splats::Splats;
use crate::image::Image;
use crate::integrator::RayCounts;
use crate::math::plane::Plane;
use crate::sampler::Batches;
use crate::scene::Scene;

/// The settings of a pilot for a choice that the settings of a render leave open.
pub fn pilot_settings(settings: &RenderSettings, seed: u64, spp: u64) -> RenderSettings {
    RenderSettings {
        // Shards and renders with other seeds have to make the same choice.
        seed,
        // Variances of single samples add up.
        sampler: SamplerKind::Independent,
        budget: Budget::samples(spp),
        adaptive: Adaptive::Off,
        layers: false,
        kernel: None,
        ..settings.clone()
    }
}

/// Takes the settings' samples per pixel in tiles, with splats and the gains by light paths where they are wanted, through a
/// box filter. Returns the numbers of rays.
///
/// # Errors
/// A kernel that lacks an effect of the scene.
pub fn take_samples(
    scene: &Scene,
    threads: &Threads,
    settings: &RenderSettings,
    (tiles, splats, gains): (Vec<&mut Tile>, Option<&Splats>, Option<&GainSums>),
    observer: &dyn RenderObserver,
) -> Result<RayCounts> {
    dispatch::check(scene, settings)?;
    let kind = FilterKind::Box;
    let radius = kind.default_radius();
    let filter = Filter::new(&FilterDescription { kind, radius });
    let sampler = dispatch::sampler(settings, Batches::new(BATCHES));
    let spp = settings.budget.spp.unwrap_or_default();
    let job = PassJob {
        source: SampleSource {
            rays: CameraRaySource {
                scene,
                filter: &filter,
                filter_sampling: FilterSampling::Importance,
                sampler: &sampler,
            },
            splats,
            gains,
        },
        tiles: tiles
            .into_iter()
            .map(|tile| (tile, SampleRange::Same(0..spp)))
            .collect(),
        is_cancelled: &|| observer.is_cancelled(),
        tile_done: &|_| (),
    };
    let tally = threads.run(|| dispatch::dispatch(scene, settings, None, job));
    Ok(tally.rays)
}

/// The weights of the variances of each pixel in relMSE, given the mean of the image: 1 / (r^2 + eps) with the truth r as a
/// mean over 25 pixels.
pub fn relative_weights(image: &Image, mean: f64) -> Vec<[f64; 3]> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let truths: [Plane; 3] = std::array::from_fn(|c| {
        let values = image.pixels().iter().map(|pixel| pixel.to_array()[c]);
        Plane::new(width, height, values.collect()).box_mean(2)
    });
    let weight = |truth: f32| 1.0 / (f64::from(truth).powi(2) + 0.01 * mean * mean);
    (0..width * height)
        .map(|pixel| std::array::from_fn(|c| weight(truths[c].values[pixel])))
        .collect()
}
