//! How paths see the surfaces that they have come to.
//!
//! Measure: as [`Bsdf`].
//! Range: any surface.
//! Source: none needed. Tested in `battery/` and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::technique::Chosen;
use super::PathIntegrator;
use crate::bsdf::{Bsdf, View};
use crate::effects::Effects;
use crate::math::rgb::Rgb;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use std::borrow::Cow;

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
    pub(super) fn of<E: Effects>(scene: &'a Scene, arrivals: &[Interaction<E>]) -> Self {
        let mut bsdfs = Self {
            shared: Vec::with_capacity(arrivals.len()),
            own: Vec::new(),
        };
        for at in arrivals {
            match scene.surface(at) {
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
