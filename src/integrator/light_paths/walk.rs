//! The walk of a light path from surface to surface, each of which is connected to the lens.
//!
//! Measure: radiance times the number of light paths.
//! Range: any scene; without a bounce limit a path ends by absorption, by leaving the scene, or by roulette.
//! Source: Veach 1997, section 10.3.4. Tested in `tests/rendering/light_paths.rs`.

use super::LightPaths;
use super::source::LightPathSource;
use super::weights::{End, LightRatios, of_camera};
use crate::effects::{Effects, Switch};
use crate::film::splats::{Splat, SplatList};
use crate::integrator::bidirectional::vertex::{Densities, Scattering, Vertex};
use crate::integrator::bidirectional::walk::{Step, SubpathKind, Walker};
use crate::integrator::observer::Unobserved;
use crate::integrator::{RayCounts, Roulette};
use crate::light::types::{LightChoice, MapRule, ShadowRayEnd};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;

/// The rules by which light paths are traced, and by which the camera paths that find the same paths are.
#[derive(Debug, Clone, Copy)]
pub struct LightPathRules {
    /// The number of light paths.
    pub paths: LightPaths,
    /// The largest number of scattering events.
    pub max_bounces: Option<u32>,
    /// The rule of Russian roulette.
    pub roulette: Roulette,
    /// The selection of lights by light sampling.
    pub light_choice: LightChoice,
    /// The density of directions to an environment map by light sampling.
    pub map: MapRule,
}

/// A light path at a surface.
struct LightPath<'a, E: Effects> {
    source: LightPathSource,
    vertex: Vertex<'a, E>,
    /// The ratios of the path up to the surface, without it.
    ratios: LightRatios,
    is_first: bool,
}

impl LightPathRules {
    /// Whether a sample has a light path, by its random numbers where not every sample has one. Their number varies a
    /// little, but never depends on other samples, so that it needs no count.
    #[inline]
    pub fn has_path<S: Sampler>(&self, sampler: &mut S) -> bool {
        let number = self.paths.share.number();
        number >= 1.0 || {
            let [u] = sampler.draw(Decision::LightPath);
            u < number
        }
    }

    /// Traces one light path at a time of the shutter, and adds its splats where they count.
    pub fn trace<E: Effects, S: Sampler>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        time: f32,
        rays: &mut RayCounts,
        splats: &mut SplatList<'_>,
    ) {
        let Some(source) = LightPathSource::sample::<E, S>(scene, sampler, time) else {
            return;
        };
        let mut walker = Walker {
            scene,
            time,
            roulette: self.roulette,
            sampler,
            rays,
            observer: &mut Unobserved,
        };
        let rule = self.roulette.survival();
        let (mut ray, mut beta, mut left) = (source.sample.ray(), source.flux, Rgb::WHITE);
        let (mut excluded, mut ratios) = (None, None);
        for bounce in 0..self.max_bounces.unwrap_or(u32::MAX) {
            walker.rays.closest += 1;
            let found = scene.accel.intersect(&ray, time, excluded);
            let u_alpha = walker.u_alpha::<E>(SubpathKind::Light, bounce);
            let at = scene.surface_interaction::<E>(&ray, time, excluded, u_alpha, found);
            let Some(at) = at else {
                return;
            };
            let u = walker.u_connection::<E>(SubpathKind::Light, bounce);
            let begun = || LightRatios::new(source.density(scene, at.p), source.can_be_met());
            let mut path = LightPath {
                source,
                vertex: Vertex::new(scene, at, beta, Densities::default(), u),
                ratios: ratios.unwrap_or_else(begun),
                is_first: bounce == 0,
            };
            let splat = self.connect(scene, time, &path, splats.reaches, walker.rays);
            splats.splats.extend(splat);
            if self.max_bounces == Some(bounce + 1) {
                return;
            }
            let Some(step) = walker.step(&mut path.vertex, SubpathKind::Light, bounce) else {
                return;
            };
            ratios = Some(self.ratios_beyond(scene, time, &path, &step));
            beta *= step.factor;
            left *= step.reflected;
            let survival = rule.probability(bounce, step.reflected, left);
            if survival < 1.0 {
                let [u] = walker.sampler.draw(Decision::LightPathRoulette(bounce));
                if u >= survival {
                    return;
                }
                let correction = rule.correction(survival);
                beta *= correction;
                left *= correction;
            }
            let through = step.scattering.goes_through;
            let (next, left_behind) = scene.spawn(&path.vertex.at, time, step.w, through);
            (ray, excluded) = (next, Some(left_behind));
        }
    }

    /// The ratios of densities beyond a surface, from which the path continues by a step.
    fn ratios_beyond<E: Effects>(
        &self,
        scene: &Scene,
        time: f32,
        path: &LightPath<'_, E>,
        step: &Step,
    ) -> LightRatios {
        if path.vertex.is_delta {
            return path.ratios.beyond_delta(path.is_first);
        }
        let to_eye = End {
            pdf: step.forwards.0,
            cos: step.w.dot(path.vertex.at.ng),
        };
        self.ratios_with(scene, time, path, step.w, &step.scattering, to_eye)
    }

    /// The ratios of densities beyond a surface that scatters towards the camera along the unit vector `w`.
    fn ratios_with<E: Effects>(
        &self,
        scene: &Scene,
        time: f32,
        path: &LightPath<'_, E>,
        w: Vec3,
        scattering: &Scattering,
        to_eye: End,
    ) -> LightRatios {
        let Vertex { at, transmits, .. } = &path.vertex;
        let to_light = End {
            pdf: scattering.pdf_to_light.0,
            cos: at.wo.dot(at.ng),
        };
        let by_nee = path.is_first.then(|| {
            let receiver = at.facing(w, *transmits).receiver(*transmits);
            let (choice, map) = (self.light_choice, self.map);
            path.source
                .density_of_nee::<E>(scene, choice, map, &receiver, time)
        });
        path.ratios.beyond(to_light, to_eye, by_nee)
    }

    /// Connects a surface to a point of the lens. Returns the splat, if light reaches the film there.
    fn connect<E: Effects>(
        &self,
        scene: &Scene,
        time: f32,
        path: &LightPath<'_, E>,
        reaches: &dyn Fn(Vec2) -> bool,
        rays: &mut RayCounts,
    ) -> Option<Splat> {
        let vertex = &path.vertex;
        if !vertex.is_connectible() {
            return None;
        }
        let lens = scene
            .camera
            .viewpoint::<E>(Vec2::new(vertex.u[0], vertex.u[1]), time);
        let way = lens.p - vertex.at.p;
        let distance2 = way.length_squared();
        let w = way / distance2.sqrt();
        let film = lens.film_point(-w)?;
        if !reaches(film.position) {
            return None;
        }
        let scattering = vertex.scattering(scene, w, vertex.at.wo)?;
        let per_steradian = if E::Lens::ON {
            // Rays through the middle of the lens give the density of rays through any of its points.
            let middle = scene.camera.viewpoint::<E>(Vec2::splat(0.5), time);
            middle.film_point(-w)?.per_steradian
        } else {
            film.per_steradian
        };
        let to_eye = End {
            pdf: 1.0,
            cos: w.dot(vertex.at.ng),
        };
        let ratios = self.ratios_with(scene, time, path, w, &scattering, to_eye);
        let of_camera = of_camera(
            self.paths.over_film_density(),
            distance2,
            per_steradian as f32,
        );
        let weight = ratios.weight(of_camera);
        let importance = planted!(
            "light-paths-without-importance",
            1.0,
            film.per_steradian as f32
        );
        let of_eye = scattering.adjoint * importance / (distance2 * self.paths.share.number());
        let value = vertex.beta * scattering.to_eye * (of_eye * weight);
        if value.is_black() {
            return None;
        }
        rays.shadow += 1;
        let end = ShadowRayEnd::Point(lens.p);
        let ray = vertex.at.ray_to(&end, w, scattering.goes_through);
        let visible = scene.visibility::<E>(&ray, time);
        (visible > 0.0).then(|| Splat {
            film: film.position,
            value: value * visible,
        })
    }
}
