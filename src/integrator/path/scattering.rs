//! Scattering at the surfaces of paths: BSDF sampling, Russian roulette and extension rays.
//!
//! Measure: normalised scene units; densities per steradian.
//! Range: any surface; a path ends where its BSDF scatters nothing, where the sampled direction lies on different sides
//! of the shading and the geometric surface, by Russian roulette, or with cached indirect light.
//! Source: Veach 1997, section 10.4.1, for the roulette. Tested in `battery/` and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::{PathObserver, RayKind};
use super::super::technique::TechniqueSource;
use super::course::sample_direction;
use super::queues::PathQueues;
use super::shading_context::ShadingContext;
use super::{PathIntegrator, Paths};
use crate::accel::ExcludedPrimitive;
use crate::bsdf::{BsdfSampleInput, has_lobes};
use crate::effects::{Effects, Slot, Switch};
use crate::math::ray::Ray;
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::interaction::Interaction;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Scatters the active paths, and queues the extension rays of those that continue.
    #[inline(always)]
    pub(super) fn scatter<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        interactions: &[Interaction<E>],
        shading: &[ShadingContext<'_>],
    ) {
        let PathQueues {
            active,
            bsdf_u,
            bsdf_inputs,
            roulette,
            ..
        } = &mut *paths.queues;
        bsdf_u.clear();
        draw_bsdf_u::<E, S>(paths.samplers, active, paths.bounce, bsdf_u);
        bsdf_inputs.clear();
        BsdfSampleInput::add_each(bsdf_u, bsdf_inputs);
        roulette.clear();
        let decision = planted!(
            "roulette-takes-a-spent-number",
            Decision::Bsdf(paths.bounce),
            Decision::Roulette(paths.bounce)
        );
        S::draw_each(paths.samplers, active, decision, |[u]| roulette.push(u));

        for (place, (at, shading)) in interactions.iter().zip(shading).enumerate() {
            let path_index = paths.queues.active[place];
            let input = paths.queues.bsdf_inputs[place];
            let u_roulette = paths.queues.roulette[place];
            let extension = self.sample_bsdf(paths, path_index, at, shading, &input, u_roulette);
            if let Some((ray, excluded)) = extension {
                let time = paths.states[path_index].time.or(0.0);
                let extension_rays = &mut paths.queues.extension_rays;
                paths.queues.active[extension_rays.len()] = path_index;
                extension_rays.push(&ray, time, Some(excluded));
            }
        }
        let continuing = paths.queues.extension_rays.len();
        paths.queues.active.truncate(continuing);
    }

    /// Scatters one path, and returns its extension ray and the primitive that the ray leaves; `None` where the path
    /// ends.
    #[inline(always)]
    fn sample_bsdf<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        path_index: usize,
        at: &Interaction<E>,
        shading: &ShadingContext<'_>,
        numbers: &BsdfSampleInput,
        u_roulette: f32,
    ) -> Option<(Ray, ExcludedPrimitive)> {
        let ShadingContext {
            view,
            cached_indirect,
            ..
        } = shading;
        let (bounce, technique) = (paths.bounce, self.technique.technique());
        let (path, observer) = (&mut paths.states[path_index], &mut *paths.observer);
        if let Some(cached_indirect) = *cached_indirect {
            let contribution = path.beta * cached_indirect;
            observer.cached_indirect(contribution);
            path.radiance += contribution;
            return None;
        }
        let Some(scattered) = sample_direction::<E>(view, technique, numbers) else {
            observer.absorbed();
            return None;
        };
        let wi = at.frame.to_world(scattered.wi);
        // A direction sampled about the shading normal may be on the wrong side of the geometric surface: light would
        // leak.
        let goes_through = E::Transmission::ON && scattered.lobe.is_transmission();
        if !at.agrees(wi, goes_through) {
            observer.absorbed();
            return None;
        }
        path.beta *= scattered.weight;
        observer.scattered(wi, scattered.lobe, path.beta);

        let mut reflected = scattered.weight;
        if goes_through {
            reflected *= path.refract(view.bsdf().ior(), view.wo().z > 0.0);
        }
        let left = path.eta_scale.or(1.0) * path.beta;
        let survival = self.roulette.survival(bounce, reflected, left);
        if survival < 1.0 && !path.survives(survival, u_roulette) {
            observer.terminated(survival);
            return None;
        }
        let (ray, excluded) = path.spawn_ray(paths.scene, at, wi, scattered.pdf, goes_through);
        paths.samples[path_index].rays.closest += 1;
        let kind = RayKind::extension(bounce, path.scattered_from.is_none());
        observer.traced(kind, &ray, path.time.or(0.0));
        Some((ray, excluded))
    }
}

/// Draws the random numbers that choose a direction and, where there are several lobes, the lobe.
#[inline]
fn draw_bsdf_u<E: Effects, S: Sampler>(
    samplers: &mut [S],
    places: &[usize],
    bounce: u32,
    numbers: &mut Vec<[f32; 3]>,
) {
    let decision = Decision::Bsdf(bounce);
    if has_lobes::<E>() {
        S::draw_each(samplers, places, decision, |u| numbers.push(u));
    } else {
        S::draw_each(samplers, places, decision, |[u, v]| {
            numbers.push([u, v, 0.0])
        });
    }
}
