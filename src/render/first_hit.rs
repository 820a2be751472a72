//! What the camera sees first in each pixel: how much it reflects, where it faces, how far it is.
//!
//! The albedo is the share of light that the surface sends on to the camera, from all directions together: the mean of
//! f |cos| / pdf over directions of the BSDF, one for each sample.
//!
//! Measure: albedo in [0, 1] but for what a model's energy allows; unit normals in world axes, towards the viewer, averaged;
//! distances from the camera in world units.
//! Range: a pixel in which nothing is met is black, has no normal and an infinite distance; at edges, means over what is met.
//! Source: none needed. Tested in `tests/layers.rs`.

use super::camera_rays::{CameraRays, Pixel, blocks};
use super::dispatch::{SamplerJob, with_sampler};
use super::settings::RenderSettings;
use crate::effects::kernel::types::Everything;
use crate::film::filter::Filter;
use crate::integrator::observer::Unobserved;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use rayon::prelude::*;

/// The first hits of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// The share of light that is reflected or let through.
    pub albedo: Rgb,
    /// The mean of the shading normals.
    pub normal: Vec3,
    /// The mean of the distances.
    pub distance: f32,
}

/// The first hits of every pixel of the settings' window, row by row, as the means over the first `spp` samples of the
/// render.
pub fn first_hits(
    scene: &Scene,
    filter: &Filter,
    settings: &RenderSettings,
    spp: u64,
) -> Vec<FirstHit> {
    let job = Job {
        scene,
        filter,
        settings,
        spp,
    };
    with_sampler(settings, job)
}

struct Job<'a> {
    scene: &'a Scene,
    filter: &'a Filter,
    settings: &'a RenderSettings,
    spp: u64,
}

impl SamplerJob for Job<'_> {
    type Output = Vec<FirstHit>;

    fn run<S: Sampler>(self, sampler: S) -> Vec<FirstHit> {
        let positions: Vec<[u32; 2]> = self.settings.window.pixels().collect();
        positions
            .into_par_iter()
            .map_init(CameraRays::new, |rays, position| {
                self.pixel(position, &sampler, rays)
            })
            .collect()
    }
}

impl Job<'_> {
    fn pixel<S: Sampler>(
        &self,
        position: [u32; 2],
        sampler: &S,
        rays: &mut CameraRays<S>,
    ) -> FirstHit {
        let pixel = Pixel {
            scene: self.scene,
            filter: self.filter,
            position,
        };
        let (mut albedo, mut normal, mut distance) = (Rgb::BLACK, Vec3::ZERO, 0.0);
        let mut met = 0;
        for block in blocks(0..self.spp) {
            let traced = rays.trace::<Everything, _>(&pixel, sampler, block, &mut Unobserved);
            for (_, place) in traced {
                let (camera_ray, found, sampler) = rays.get(place);
                let [u_alpha] = sampler.draw(Decision::Alpha(0));
                let (ray, time) = (&camera_ray.ray, camera_ray.time);
                let Some(at) = self.scene.meet(ray, time, None, u_alpha, found) else {
                    continue;
                };
                met += 1;
                albedo += self.albedo(&at, sampler);
                let ns = at.frame.to_world(Vec3::Z);
                normal += if ns.dot(at.wo) < 0.0 { -ns } else { ns };
                distance += f64::from((at.p - ray.origin).length());
            }
        }
        if met == 0 {
            return FirstHit {
                albedo,
                normal,
                distance: f32::INFINITY,
            };
        }
        let distance = (distance / f64::from(met)) as f32;
        FirstHit {
            albedo: albedo * (1.0 / self.spp as f32),
            normal: normal / met as f32,
            distance: self.scene.normalisation.world_length(distance) as f32,
        }
    }

    fn albedo<S: Sampler>(&self, at: &Interaction<Everything>, sampler: &mut S) -> Rgb {
        let Some(bsdf) = self.scene.bsdf(at) else {
            return Rgb::BLACK;
        };
        let wo = at.frame.to_local(at.wo);
        let [u, v, u_lobe] = sampler.draw(Decision::Bsdf(0));
        let sample = bsdf.sample::<Everything>(wo, u_lobe, Vec2::new(u, v));
        sample.map_or(Rgb::BLACK, |sample| {
            // Radiance is thinned on the way in, the light that passes is not.
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
