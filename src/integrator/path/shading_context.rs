//! Shading contexts: the BSDFs at the surfaces of paths, as seen from the directions in which the paths arrived.
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

/// The BSDFs at the surfaces of a wavefront. They are large and stay in the scene: only those with a texture are made
/// for their point.
pub(super) struct Bsdfs<'a> {
    /// The BSDFs in the scene; `None` for those of `own`.
    shared: Vec<Option<&'a Bsdf>>,
    own: Vec<Bsdf>,
}

impl<'a> Bsdfs<'a> {
    /// Collects the BSDFs of these interactions.
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

    /// The BSDFs, in the order of their interactions.
    #[inline]
    pub(super) fn each(&self) -> impl Iterator<Item = &Bsdf> {
        let mut own = self.own.iter();
        self.shared.iter().map(move |shared| {
            let next = || own.next().expect("what is not shared is one's own");
            shared.unwrap_or_else(next)
        })
    }
}

/// The shading context of a path at its surface.
pub(super) struct ShadingContext<'a> {
    pub(super) view: BoundBsdf<'a>,
    /// Whether the path samples lights here, if its technique samples lights at all.
    pub(super) samples_lights: bool,
    /// The reflected indirect light, which light sampling does not find, where it is cached: the path then ends.
    pub(super) cached_indirect: Option<Rgb>,
}

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Builds the shading context of a path at its surface, after `bounce` scattering events.
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
            // Delta lobes reflect no light that light sampling finds.
            samples_lights: !bsdf.is_delta::<E>(),
            cached_indirect: self.indirect.reflected(at, bsdf, bounce, is_limited),
        }
    }
}
