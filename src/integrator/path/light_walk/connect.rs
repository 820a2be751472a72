//! The connections of a light path's surfaces to the lens.
//!
//! Measure: radiance times the number of camera samples, by which the splat buffer divides.
//! Range: surfaces that are not smooth; a pinhole or a lens.
//! Source: Veach 1997, section 10.3.3. Tested in `tests/rendering/light_paths.rs`.

use super::super::super::indirect::Indirect;
use super::super::super::light_paths::weights::{
    DirectionPdf, LightRatios, camera_vertex_ratio, vertex_ratio,
};
use super::super::super::light_paths::{LightPathSplat, LightPathSplats};
use super::super::super::observer::NullPathObserver;
use super::super::super::technique::TechniqueSource;
use super::super::block::PathBlock;
use super::super::shading::StageScratch;
use super::super::{PathIntegrator, PathWavefront};
use super::LightPathStart;
use super::towards_camera::{TowardsCamera, towards_camera};
use crate::camera::FilmPoint;
use crate::effects::{Effects, Switch};
use crate::film::splats::Splat;
use crate::light::types::ShadowRayEnd;
use crate::math::lanes::{ActiveLanes, LANES, load, store};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::interaction::Interaction;

/// A surface that is connected to a point of the lens.
#[derive(Debug, Clone, Copy, Default)]
struct Connection {
    lens: Vec3,
    film: FilmPoint,
    /// The importance that arrives at the surface.
    importance: f32,
    /// The ratio of the densities of a light path and of a camera path at the lens.
    camera_vertex_ratio: f32,
}

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Connects the surfaces of a block to points of the lens.
    pub(super) fn connect<E: Effects, S: Sampler>(
        &self,
        wavefront: &mut PathWavefront<'_, S, NullPathObserver>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
        starts: &[Option<LightPathStart>],
        splats: &mut LightPathSplats<'_>,
    ) {
        let scene = wavefront.scene;
        let may_be_seen = block.active.without(&stage.bsdfs.delta);
        let mut seen = self.light_path_lanes(block, &may_be_seen);
        let caustic = seen.and(|lane| block.is_caustic(lane));
        block.meet_surfaces(&stage.at.traits);
        let mut to_lens = [[0.0; LANES]; 3];
        let mut connections = [Connection::default(); LANES];
        for lane in seen.each() {
            let p = load(&stage.at.p, lane);
            let connection = self.sample_lens(wavefront, block, lane, p);
            let connection = connection.filter(|it| (splats.reaches)(it.film.position));
            seen.set(lane, connection.is_some());
            if let Some(connection) = connection {
                connections[lane] = connection;
                store(&mut to_lens, lane, (connection.lens - p).normalize());
            }
        }
        if !seen.any() {
            return;
        }
        let StageScratch {
            at,
            bsdfs,
            direct_light,
            ..
        } = stage;
        let towards = towards_camera::<E>(scene, &seen, at, bsdfs, &to_lens, false);
        let lights = &mut *direct_light;
        lights.shadow_ray_lanes = ActiveLanes::NONE;
        let mut gains = [Rgb::BLACK; LANES];
        for lane in towards.active.each() {
            let Some(start) = &starts[block.sample_index[lane] as usize] else {
                continue;
            };
            let connection = connections[lane];
            let at: Interaction<E> = at.get(lane);
            let w: Vec3 = load(&to_lens, lane);
            let cosines = [w, at.wo].map(|w| w.dot(at.ng));
            let ratios = self.ratios(wavefront, block, lane, start, &towards, cosines);
            let weight = ratios.weight(connection.camera_vertex_ratio);
            let flux = start.first_ray.flux * load::<Rgb>(&block.beta, lane);
            let of_camera = connection.importance / self.light_paths.share.number();
            let value = flux * load::<Rgb>(&towards.factor, lane) * (of_camera * weight);
            if value.is_black() {
                continue;
            }
            store(&mut lights.contribution, lane, value);
            if splats.with_gains {
                let unweighted = value * (1.0 / weight);
                let gain = ratios.gain(connection.camera_vertex_ratio);
                gains[lane] = unweighted * unweighted * gain;
            }
            let end = ShadowRayEnd::Point(connection.lens);
            let ray = at.ray_to(&end, w, towards.is_transmitted.has(lane));
            lights.shadow.set(lane, &ray);
            lights.shadow.time[lane] = block.packet.rays.time[lane];
            lights.shadow_ray_lanes.set(lane, true);
            block.count_rays(lane, false, true);
        }
        let visible = scene.visibilities::<E>(&lights.shadow_ray_lanes, &mut lights.shadow, false);
        for lane in lights.shadow_ray_lanes.each() {
            if visible[lane] > 0.0 {
                let value = load::<Rgb>(&lights.contribution, lane) * visible[lane];
                let film_position = connections[lane].film.position;
                splats.splats.push(LightPathSplat {
                    sample_index: block.sample_index[lane],
                    splat: Splat {
                        film_position,
                        value,
                    },
                    gain: gains[lane] * visible[lane],
                    is_caustic: caustic.has(lane),
                });
            }
        }
    }

    /// The ratios of the densities of scattering and of light sampling to that of a light path that is connected to the lens,
    /// given the cosines towards the lens and the light.
    fn ratios<E: Effects, S: Sampler>(
        &self,
        wavefront: &PathWavefront<'_, S, NullPathObserver>,
        block: &PathBlock<E>,
        lane: usize,
        start: &LightPathStart,
        towards: &TowardsCamera,
        [cos_to_camera, cos_to_light]: [f32; 2],
    ) -> LightRatios {
        let to_camera = DirectionPdf {
            pdf: 1.0,
            cos: cos_to_camera,
        };
        let to_light = |pdf: f32| DirectionPdf {
            pdf,
            cos: cos_to_light,
        };
        let ratio = block.light_path_ratio().map_or(0.0, |ratios| ratios[lane]);
        let by_scattering = ratio * vertex_ratio(to_light(towards.pdf_to_light[lane]), to_camera);
        let by_nee = if wavefront.bounce == 0 {
            let receiver = towards.receivers[lane].as_ref();
            let nee = self.density_of_nee(wavefront.scene, start, receiver, block, lane);
            ratio * vertex_ratio(to_light(nee), to_camera)
        } else {
            by_scattering * start.nee_over_scattering
        };
        let can_be_hit = start.first_ray.can_be_hit();
        LightRatios {
            by_scattering: if can_be_hit { by_scattering } else { 0.0 },
            by_nee,
        }
    }

    /// Samples a point of the lens for `p`; `None` if `p` is not on the film.
    fn sample_lens<E: Effects, S: Sampler>(
        &self,
        wavefront: &mut PathWavefront<'_, S, NullPathObserver>,
        block: &PathBlock<E>,
        lane: usize,
        p: Vec3,
    ) -> Option<Connection> {
        let (camera, time) = (&wavefront.scene.camera, block.packet.rays.time[lane]);
        let mut u_lens = [0.0; 2];
        if E::Lens::ON {
            let sampler = &mut wavefront.samplers[block.sample_index[lane] as usize];
            u_lens = sampler.draw(Decision::Lens(wavefront.bounce));
        }
        let lens = camera.viewpoint::<E>(Vec2::from(u_lens), time);
        let offset = lens.p - p;
        let distance2 = offset.length_squared();
        let to_film = -offset / distance2.sqrt();
        let film = lens.film_point(to_film)?;
        let per_steradian = if E::Lens::ON {
            // Rays through the middle of the lens give the density of rays through any of its points.
            let middle = camera.viewpoint::<E>(Vec2::splat(0.5), time);
            middle.film_point(to_film)?.per_steradian
        } else {
            film.per_steradian
        };
        let over_film_density = self.light_paths.expected_count();
        let importance = planted!(
            "light-paths-without-importance",
            1.0,
            film.per_steradian as f32
        );
        Some(Connection {
            lens: lens.p,
            film,
            importance: importance / distance2,
            camera_vertex_ratio: camera_vertex_ratio(
                over_film_density,
                distance2,
                per_steradian as f32,
            ),
        })
    }
}
