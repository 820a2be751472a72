//! The first hits of the camera rays of each pixel: albedo, normal and distance.
//!
//! The albedo is the share of light that the surface scatters to the camera, from all directions together: the mean of
//! f |cos| / pdf over BSDF samples, one for each camera sample.
//!
//! Measure: albedo in [0, 1], except where a BSDF model does not conserve energy; unit normals in world axes, towards
//! the viewer, averaged; distances from the camera in world units.
//! Range: a pixel without a hit is black, has no normal and an infinite distance; at edges, means over the hits.
//! Source: none needed. Tested in `cli/tests/command/layers.rs`.

use super::dispatch::sampler;
use super::pixel_block::PixelBlock;
use super::sample_wavefront::{CameraRaySource, PacketIndex, SampleWavefront};
use super::settings::RenderSettings;
use crate::effects::kernel::types::Everything;
use crate::film::Window;
use crate::film::filter::{Filter, FilterSampling};
use crate::integrator::CameraRay;
use crate::integrator::observer::NullPathObserver;
use crate::math::lanes::{LANES, Lanes};
use crate::math::rgb::Rgb;
use crate::math::stats::Moments;
use crate::math::vec::{Vec2, Vec3};
use crate::sampler::{AnySampler, Batches, Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use rayon::prelude::*;

/// The first hits of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FirstHit {
    /// The share of light that is reflected or transmitted.
    pub albedo: Rgb,
    /// The mean of the shading normals.
    pub normal: Vec3,
    /// The mean of the distances.
    pub distance: f32,
    /// The standard errors of these means.
    pub standard_errors: FirstHitErrors,
}

/// The number of parts over which the samples of a pixel are distributed in turn. Their spread gives the noise of
/// means.
const PARTS: usize = 16;

/// Standard errors of the means over the first hits of a pixel, from the spread of its parts; 0 for fewer than two
/// parts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FirstHitErrors {
    /// The error of the albedo: the root of the mean square over its channels.
    pub albedo: f32,
    /// The error of the normal: the length of the vector of its components' errors.
    pub normal: f32,
    /// The error of the distance.
    pub distance: f32,
}

/// Sums over some of the samples of a pixel.
#[derive(Debug, Clone, Copy, Default)]
struct FirstHitSums {
    albedo: Rgb,
    normal: Vec3,
    distance: f64,
    /// The number of samples.
    count: u32,
    /// The number of samples with a hit.
    hits: u32,
}

impl FirstHitSums {
    fn add(&mut self, other: &Self) {
        self.albedo += other.albedo;
        self.normal += other.normal;
        self.distance += other.distance;
        self.count += other.count;
        self.hits += other.hits;
    }

    /// The means: of albedo over all samples, of normal and distance over those with a hit, if there are any.
    fn means(&self) -> (Rgb, Option<(Vec3, f64)>) {
        let albedo = self.albedo * (1.0 / self.count.max(1) as f32);
        let of_hits = (self.hits > 0).then(|| {
            (
                self.normal / self.hits as f32,
                self.distance / f64::from(self.hits),
            )
        });
        (albedo, of_hits)
    }
}

/// The standard errors of the means over all parts.
fn standard_errors(parts: &[FirstHitSums]) -> FirstHitErrors {
    let mut moments = [Moments::default(); 7];
    let mut push = |at: usize, x: f64| moments[at].push(x);
    for part in parts.iter().filter(|part| part.count > 0) {
        let (albedo, of_hits) = part.means();
        for (c, x) in albedo.to_array().into_iter().enumerate() {
            push(c, x.into());
        }
        let Some((normal, distance)) = of_hits else {
            continue;
        };
        for (c, x) in normal.to_array().into_iter().enumerate() {
            push(3 + c, x.into());
        }
        push(6, distance);
    }
    let variance = |at: usize| {
        let error = moments[at].standard_error().unwrap_or(0.0);
        error * error
    };
    let sum = |from: usize| variance(from) + variance(from + 1) + variance(from + 2);
    FirstHitErrors {
        albedo: (sum(0) / 3.0).sqrt() as f32,
        normal: sum(3).sqrt() as f32,
        distance: variance(6).sqrt() as f32,
    }
}

/// Computes the first hits of every pixel of the settings' window, row by row, as the means over the first `spp`
/// samples of the render.
pub fn first_hits(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    spp: u64,
) -> Vec<FirstHit> {
    let job = FirstHitJob {
        scene,
        filter,
        spp,
        window: settings.window,
        sampler: sampler(settings, Batches::new(PARTS as u64)),
    };
    let window = settings.window;
    let blocks: Vec<PixelBlock> = PixelBlock::covering(window, 1).collect();
    let of_blocks: Vec<Lanes<FirstHit>> = blocks
        .par_iter()
        .map_init(SampleWavefront::default, |wavefront, &block| {
            job.block(block, wavefront)
        })
        .collect();
    let mut first_hits = vec![FirstHit::default(); window.pixel_count() as usize];
    for (block, of_block) in blocks.into_iter().zip(of_blocks) {
        for lane in block.lanes_in(window).each() {
            first_hits[window.index(block.pixel(lane))] = of_block[lane];
        }
    }
    first_hits
}

struct FirstHitJob<'a> {
    scene: &'a Scene,
    filter: &'a Filter,
    spp: u64,
    window: Window,
    sampler: AnySampler,
}

impl FirstHitJob<'_> {
    fn block(&self, block: PixelBlock, wavefront: &mut SampleWavefront) -> Lanes<FirstHit> {
        let source = CameraRaySource {
            scene: self.scene,
            filter: self.filter,
            filter_sampling: FilterSampling::Importance,
            sampler: &self.sampler,
        };
        let lanes = block.lanes_in(self.window);
        let mut parts = [[FirstHitSums::default(); PARTS]; LANES];
        for sample in 0..self.spp {
            wavefront.clear();
            let index = PacketIndex { block, sample };
            wavefront.add::<Everything, _>(&source, index, lanes, &mut NullPathObserver);
            wavefront.trace(self.scene);
            for lane in lanes.each() {
                let (CameraRay { ray, time }, hit) = wavefront.samples(0).camera_ray(lane);
                let sampler = wavefront.sampler(0, lane);
                let [u_alpha] = sampler.draw(Decision::Alpha(0));
                let part = &mut parts[lane][sample as usize % PARTS];
                part.count += 1;
                let Some(at) = self
                    .scene
                    .surface_interaction(&ray, time, None, u_alpha, hit)
                else {
                    continue;
                };
                let ns = at.frame.to_world(Vec3::Z);
                part.add(&FirstHitSums {
                    albedo: self.albedo(&at, sampler),
                    normal: if ns.dot(at.wo) < 0.0 { -ns } else { ns },
                    distance: f64::from((at.p - ray.origin).length()),
                    count: 0,
                    hits: 1,
                });
            }
        }
        parts.map(|parts| self.first_hit(&parts))
    }

    /// The first hit of a pixel, given the sums of its parts.
    fn first_hit(&self, parts: &[FirstHitSums; PARTS]) -> FirstHit {
        let mut all = FirstHitSums::default();
        for part in parts {
            all.add(part);
        }
        let (albedo, of_hits) = all.means();
        let (normal, distance) = of_hits.unwrap_or((Vec3::ZERO, f64::INFINITY));
        let world = |length: f32| self.scene.normalisation.world_length(length) as f32;
        let errors = standard_errors(parts);
        FirstHit {
            albedo,
            normal,
            distance: world(distance as f32),
            standard_errors: FirstHitErrors {
                distance: world(errors.distance),
                ..errors
            },
        }
    }

    fn albedo(&self, at: &Interaction<Everything>, sampler: &mut AnySampler) -> Rgb {
        let Some(bsdf) = self.scene.bsdf_of_side(at) else {
            return Rgb::BLACK;
        };
        let wo = at.frame.to_local(at.wo);
        let [u, v, u_lobe] = sampler.draw(Decision::Bsdf(0));
        let sample = bsdf.sample::<Everything>(wo, u_lobe, Vec2::new(u, v));
        sample.map_or(Rgb::BLACK, |sample| {
            // Radiance is divided by eta^2 on the way in, the light that passes is not.
            let eta = if wo.z > 0.0 {
                bsdf.ior()
            } else {
                1.0 / bsdf.ior()
            };
            let eta = if sample.lobe.is_transmission() {
                eta
            } else {
                1.0
            };
            sample.weight * (eta * eta)
        })
    }
}
