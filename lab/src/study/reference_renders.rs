//! The part of a study that renders its two references.
//!
//! Measure: radiance, seconds, samples per pixel.
//! Range: references of several shards are their means, each shard with as many samples.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::clock::Seconds;
use super::reference::References;
use super::report::ReferenceReport;
use super::run::Study;
use super::runner::{Purpose, luminance, seed_for};
use super::settings::StudyClock;
use super::variant::Variant;
use etendue::internals::film::filter::FilterSampling;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::{Error, Result};

/// One shard's renders of both references.
#[derive(Debug, Clone)]
pub struct ReferenceRenders {
    /// Their samples per pixel.
    pub spp: u64,
    /// Their images.
    pub images: [Image; 2],
    /// The duration of each.
    pub seconds: [Seconds; 2],
    /// Their seeds.
    pub seeds: [u64; 2],
}

impl Study<'_> {
    /// The variant that renders the references, with Sobol' points where the integrator supports them.
    pub(super) fn reference_variant(&self) -> Variant {
        let settings = RenderSettings {
            integrator: self.settings.reference,
            sampler: SamplerKind::Sobol,
            light_paths: self.settings.reference_light_paths,
            occlusion_distance: None,
            // As most variants have: with a sample in one pixel alone, both references may miss the edge of a small lamp.
            filter_sampling: FilterSampling::default(),
            threads: self.settings.options.threads,
            ..RenderSettings::new(self.prepared.size(), 1)
        };
        Variant::new(settings, self.settings.options)
    }

    /// Renders both references of a shard, of `spp` samples per pixel in units of the minimum number of their integrator;
    /// `None` if it was cancelled.
    pub(super) fn reference_renders(
        &self,
        spp: u64,
        shard: u64,
        clock: &StudyClock<'_>,
    ) -> Result<Option<ReferenceRenders>> {
        let variant = self.reference_variant();
        let spp = spp * variant.settings.spp_step();
        let seeds =
            [0, 1].map(|index| seed_for(self.settings.seed, Purpose::Reference, [index, shard, 0]));
        let mut shots = Vec::new();
        for seed in seeds {
            let settings = self.prepared.settings(&variant, spp, seed);
            let Some(shot) = self.prepared.render(&variant, &settings, clock)? else {
                return Ok(None);
            };
            shots.push(shot);
        }
        Ok(Some(ReferenceRenders {
            spp,
            images: [0, 1].map(|index: usize| shots[index].film.develop()),
            seconds: [0, 1].map(|index: usize| shots[index].seconds),
            seeds,
        }))
    }

    /// The references of all shards, and their part of the report.
    pub(super) fn references(&mut self, shards: &[ReferenceRenders]) -> Result<References> {
        let variant = self.reference_variant();
        let mean_of = |index: usize| mean(shards.iter().map(|shard| &shard.images[index]));
        let [one, two] = [0, 1].map(mean_of);
        let luminances = [luminance(&one), luminance(&two)];
        let references = References::new(one, two).ok_or_else(|| {
            Error::render("the references are black: relative errors are undefined")
        })?;
        let seconds = |index: usize| {
            let of_shard = shards.iter().map(|shard| shard.seconds[index]);
            of_shard.fold(Seconds::default(), |sum, each| Seconds {
                wall: sum.wall + each.wall,
                cpu: sum.cpu + each.cpu,
            })
        };
        self.report.images.reference = Some(references.mean().clone());
        self.report.reference = Some(ReferenceReport {
            integrator: variant.settings.integrator.name(),
            sampler: variant.settings.sampler.name(),
            spp: shards.iter().map(|shard| shard.spp).sum(),
            seconds: [0, 1].map(seconds),
            seeds: shards[0].seeds,
            luminances,
            luminance_error: references.luminance_error(),
            noise: references.noise(),
        });
        Ok(references)
    }
}

/// The mean of images of one size, of which there is at least one.
fn mean<'a>(images: impl ExactSizeIterator<Item = &'a Image>) -> Image {
    let scale = 1.0 / images.len() as f64;
    let mut size = (0, 0);
    let mut sums: Vec<[f64; 3]> = Vec::new();
    for image in images {
        size = (image.width(), image.height());
        sums.resize(image.pixels().len(), [0.0; 3]);
        for (sum, pixel) in sums.iter_mut().zip(image.pixels()) {
            let pixel = pixel.to_array().map(f64::from);
            *sum = std::array::from_fn(|c| sum[c] + scale * pixel[c]);
        }
    }
    let pixels = sums.iter().map(|sum| {
        let [r, g, b] = sum.map(|x| x as f32);
        Rgb::new(r, g, b)
    });
    Image::new(size.0, size.1, pixels.collect())
}
