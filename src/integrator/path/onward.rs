//! Where paths go from their surfaces.
//!
//! Measure: normalised scene units; densities per steradian.
//! Range: any surface; a path ends where its BSDF scatters nothing, where the shading normal promises what the surface cannot
//! keep, by Russian roulette, or with light that is known.
//! Source: Veach 1997, section 10.4.1, for the roulette. Tested in `battery/` and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::{PathObserver, RayKind};
use super::super::steps::sample_direction;
use super::super::technique::Chosen;
use super::super::waiting::Waiting;
use super::seen::Seen;
use super::{PathIntegrator, Paths};
use crate::accel::Departure;
use crate::bsdf::{Numbers, has_lobes};
use crate::effects::{Effects, Slot, Switch};
use crate::math::ray::Ray;
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::interaction::Interaction;

impl<C: Chosen, K: Indirect> PathIntegrator<C, K> {
    /// Sends the paths on that do not end, and leaves their rays to be traced.
    pub(super) fn scatter<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        arrivals: &[Interaction<E>],
        seen: &[Seen<'_>],
    ) {
        let Waiting {
            going,
            drawn,
            directions,
            roulette,
            ..
        } = &mut *paths.waiting;
        drawn.clear();
        draw_directions::<E, S>(paths.samplers, going, paths.bounce, drawn);
        directions.clear();
        Numbers::add_each(drawn, directions);
        roulette.clear();
        let decision = planted!(
            "roulette-takes-a-spent-number",
            Decision::Bsdf(paths.bounce),
            Decision::Roulette(paths.bounce)
        );
        S::draw_each(paths.samplers, going, decision, |[u]| roulette.push(u));

        for (place, (at, seen)) in arrivals.iter().zip(seen).enumerate() {
            let number = paths.waiting.going[place];
            let numbers = paths.waiting.directions[place];
            let u_roulette = paths.waiting.roulette[place];
            let onward = self.goes_on(paths, number, at, seen, &numbers, u_roulette);
            if let Some((ray, departure)) = onward {
                let time = paths.states[number].time.or(0.0);
                let onward = &mut paths.waiting.onward;
                paths.waiting.going[onward.len()] = number;
                onward.push(&ray, time, Some(departure));
            }
        }
        paths.waiting.going.truncate(paths.waiting.onward.len());
    }

    /// The ray onward, and what it leaves; `None` where the path ends.
    #[inline(always)]
    fn goes_on<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        number: usize,
        at: &Interaction<E>,
        seen: &Seen<'_>,
        numbers: &Numbers,
        u_roulette: f32,
    ) -> Option<(Ray, Departure)> {
        let Seen { view, known, .. } = seen;
        let (bounce, technique) = (paths.bounce, self.technique.technique());
        let (path, observer) = (&mut paths.states[number], &mut *paths.observer);
        if let Some(known) = *known {
            let contribution = path.beta * known;
            observer.known(contribution);
            path.radiance += contribution;
            return None;
        }
        let Some(scattered) = sample_direction::<E>(view, technique, numbers) else {
            observer.absorbed();
            return None;
        };
        let wi = at.frame.to_world(scattered.wi);
        // A shading normal can promise what the surface cannot keep: light leaking through it.
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
        let (ray, departure) = path.leave(paths.scene, at, wi, scattered.pdf, goes_through);
        paths.samples[number].rays.closest += 1;
        let kind = RayKind::onward(bounce, path.scattered_from.is_none());
        observer.traced(kind, &ray, path.time.or(0.0));
        Some((ray, departure))
    }
}

/// Draws the numbers that choose a direction and, where there are several, the lobe.
#[inline]
fn draw_directions<E: Effects, S: Sampler>(
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
