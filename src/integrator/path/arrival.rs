//! Where paths have come to: what their surfaces emit, and whether they go on from there.
//!
//! Measure: radiance.
//! Range: any hit; a ray that meets nothing ends its path beyond the scene.
//! Source: the emission of the rendering equation, Kajiya 1986, weighted as in Veach 1997, section 9.2. Tested in `battery/`
//! and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::observer::PathObserver;
use super::super::steps::toss;
use super::super::technique::{Chosen, Technique};
use super::{PathIntegrator, PathState, Paths};
use crate::bsdf::{Bsdf, View};
use crate::effects::{Effects, Slot, Switch};
use crate::math::rgb::Rgb;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use std::borrow::Cow;

/// A path at a surface where it does not end.
pub(super) struct Arrival<E: Effects> {
    /// Which path.
    pub(super) number: usize,
    pub(super) at: Interaction<E>,
}

/// The BSDFs of the surfaces that paths have come to. They are large, and stay where they are: only those with a texture are
/// made for their point.
pub(super) struct Bsdfs<'a> {
    /// `None` for those of `own`.
    shared: Vec<Option<&'a Bsdf>>,
    own: Vec<Bsdf>,
}

impl<'a> Bsdfs<'a> {
    /// Those of these surfaces.
    #[inline]
    pub(super) fn of<E: Effects>(scene: &'a Scene, arrivals: &[Arrival<E>]) -> Self {
        let mut bsdfs = Self {
            shared: Vec::with_capacity(arrivals.len()),
            own: Vec::new(),
        };
        for arrival in arrivals {
            match scene.surface(&arrival.at) {
                Cow::Borrowed(bsdf) => bsdfs.shared.push(Some(bsdf)),
                Cow::Owned(bsdf) => {
                    bsdfs.shared.push(None);
                    bsdfs.own.push(bsdf);
                }
            }
        }
        bsdfs
    }

    /// Each of them, in the order of their surfaces.
    #[inline]
    pub(super) fn each(&self) -> impl Iterator<Item = &Bsdf> {
        let mut own = self.own.iter();
        self.shared.iter().map(move |shared| {
            let next = || own.next().expect("what is not shared is one's own");
            shared.unwrap_or_else(next)
        })
    }
}

/// How a path sees its surface.
pub(super) struct Seen<'a> {
    pub(super) view: View<'a>,
    /// Whether it looks for lights, if they are sampled at all.
    pub(super) looks: bool,
    /// Light that light sampling does not find here, where it is known: then the path ends.
    pub(super) known: Option<Rgb>,
}

impl<C: Chosen, K: Indirect> PathIntegrator<C, K> {
    /// Takes what is emitted where paths have come to, and tells which of them do not end there.
    pub(super) fn arrive<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        arrivals: &mut Vec<Arrival<E>>,
    ) {
        for place in 0..paths.waiting.going.len() {
            let number = paths.waiting.going[place];
            self.arrive_one(paths, number, arrivals);
        }
    }

    #[inline(always)]
    fn arrive_one<E: Effects, S: Sampler, O: PathObserver>(
        &self,
        paths: &mut Paths<'_, E, S, O>,
        number: usize,
        arrivals: &mut Vec<Arrival<E>>,
    ) {
        let (scene, bounce, technique) = (paths.scene, paths.bounce, self.technique.technique());
        let (path, sampler) = (&mut paths.states[number], &mut paths.samplers[number]);
        let observer = &mut *paths.observer;
        let (chosen, time) = (paths.waiting.chosen[number], path.time.or(0.0));
        let u_alpha = draw_alpha::<E, S>(sampler, bounce);
        let found = paths.samples[number].found;
        let Some(at) = scene.meet::<E>(&path.ray, time, path.departure.or(None), u_alpha, found)
        else {
            observer.escaped(path.ray.dir);
            let contribution = path.beta * beyond(scene, path, technique, chosen);
            path.radiance += contribution;
            observer.environment(contribution);
            return;
        };
        observer.arrived(&at, path.beta);

        // Emission, in the light of how else it could have been found.
        let emitted = scene.emitted(&at);
        let coin = toss::<S>(technique, emitted, sampler, bounce);
        if let Some(emitted) = emitted {
            let weight = path.weight_of_scattering(
                technique,
                |from| scene.light_pdf(from, time, &at),
                || chosen.is_some() && scene.light_of(&at) == chosen,
            );
            let contribution = path.beta * emitted * (weight * coin.taken);
            observer.emission(contribution, weight);
            path.radiance += contribution;
        }
        let is_last = self.max_bounces.is_some_and(|limit| bounce >= limit);
        if coin.ends || is_last || scene.is_dark(&at) {
            observer.absorbed();
            return;
        }
        path.beta *= coin.left;
        arrivals.push(Arrival { number, at });
    }

    /// How a path sees the surface that it has come to, after so many scattering events.
    #[inline]
    pub(super) fn see<'a, E: Effects>(
        &self,
        at: &Interaction<E>,
        bsdf: &'a Bsdf,
        bounce: u32,
    ) -> Seen<'a> {
        let is_limited = self.max_bounces.is_some();
        Seen {
            view: bsdf.seen_from::<E>(at.frame.to_local(at.wo)),
            // Delta lobes reflect no light that is found by sampling it.
            looks: !bsdf.is_delta::<E>(),
            known: self.indirect.reflected(at, bsdf, bounce, is_limited),
        }
    }
}

/// The number that decides where a surface is only partly there.
#[inline(always)]
fn draw_alpha<E: Effects, S: Sampler>(sampler: &mut S, bounce: u32) -> f32 {
    if !E::Alpha::ON {
        return 0.0;
    }
    let [u] = sampler.draw(Decision::Alpha(bounce));
    u
}

/// Radiance from beyond the scene along the path's ray.
#[inline]
fn beyond<E: Effects>(
    scene: &Scene,
    path: &PathState<E>,
    technique: Technique,
    chosen: Option<u32>,
) -> Rgb {
    if !E::Environment::ON {
        return Rgb::BLACK;
    }
    let mut radiance = scene.environment;
    if E::EnvironmentMap::ON
        && let Some(beyond) = scene.lights.beyond(path.ray.dir)
    {
        let is_chosen = || Some(beyond.light) == chosen;
        radiance +=
            beyond.radiance * path.weight_of_scattering(technique, |_| beyond.pdf, is_chosen);
    }
    radiance
}
