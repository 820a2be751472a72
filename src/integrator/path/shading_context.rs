//! How paths see the surfaces that they have come to.
//!
//! Measure: as [`Bsdf`].
//! Range: any surface.
//! Source: none needed. Tested in `battery/` and `tests/rendering/integrators.rs`.

use super::super::indirect::Indirect;
use super::super::technique::TechniqueSource;
use super::PathIntegrator;
use crate::bsdf::{BoundBsdf, Bsdf};
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
    pub(super) fn of<E: Effects>(scene: &'a Scene, interactions: &[Interaction<E>]) -> Self {
        let mut bsdfs = Self {
            shared: Vec::with_capacity(interactions.len()),
            own: Vec::new(),
        };
        for at in interactions {
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
pub(super) struct ShadingContext<'a> {
    pub(super) view: BoundBsdf<'a>,
    /// Whether it looks for lights, if they are sampled at all.
    pub(super) samples_lights: bool,
    /// Light that light sampling does not find here, where it is known: then the path ends.
    pub(super) cached_indirect: Option<Rgb>,
}

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// How a path sees the surface that it has come to, after so many scattering events.
    #[inline]
    pub(super) fn shading_context<'a, E: Effects>(
        &self,
        at: &Interaction<E>,
        bsdf: &'a Bsdf,
        bounce: u32,
    ) -> ShadingContext<'a> {
        let is_limited = self.max_bounces.is_some();
        ShadingContext {
            view: bsdf.seen_from::<E>(at.frame.to_local(at.wo)),
            // Delta lobes reflect no light that is found by sampling it.
            samples_lights: !bsdf.is_delta::<E>(),
            cached_indirect: self.indirect.reflected(at, bsdf, bounce, is_limited),
        }
    }
}
