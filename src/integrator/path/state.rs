//! The state of a path under construction.
//!
//! Measure: normalised scene units; radiance; densities per steradian.
//! Range: any path; state that only some kernels need takes no memory in the others.
//! Source: none needed. Tested in `tests/rendering/effects.rs`.

use super::super::technique::Technique;
use crate::accel::ExcludedPrimitive;
use crate::effects::{Effects, Slot, State};
use crate::math::measure::PdfSolidAngle;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// The state of a path under construction, with what the effects `E` need of it.
#[derive(Debug, Clone, Copy)]
pub struct PathState<E: Effects> {
    /// The current ray.
    pub ray: Ray,
    /// The primitive that the ray leaves, which is needed to continue the ray behind a surface with alpha.
    pub excluded: State<E::Alpha, Option<ExcludedPrimitive>>,
    /// The time, from 0 to 1 while the shutter is open.
    pub time: State<E::Motion, f32>,
    /// The path throughput: the factor of the radiance along the ray.
    pub beta: Rgb,
    /// The radiance found so far.
    pub radiance: Rgb,
    /// The factor by which Russian roulette corrects the throughput: transmission divides it by eta^2 on the way into
    /// glass and restores it on the way out, which is no reason to end a path.
    pub eta_scale: State<E::Transmission, f32>,
    /// The point of the last scattering event, and the density of its direction; `None` from the camera and from delta
    /// lobes.
    pub scattered_from: Option<(Vec3, PdfSolidAngle)>,
}

impl<E: Effects> PathState<E> {
    /// Begins a path with a ray, which leaves a primitive or comes from the camera.
    #[inline]
    pub fn new(ray: Ray, excluded: Option<ExcludedPrimitive>, time: f32) -> Self {
        Self {
            ray,
            excluded: Slot::new(|| excluded),
            time: Slot::new(|| time),
            beta: Rgb::WHITE,
            radiance: Rgb::BLACK,
            eta_scale: Slot::new(|| 1.0),
            scattered_from: None,
        }
    }

    /// Multiplies `eta_scale` on transmission through a surface of index `eta`, inside over outside, and returns the
    /// factor.
    #[inline]
    pub(super) fn refract(&mut self, eta: f32, enters: bool) -> f32 {
        let eta = if enters { eta } else { 1.0 / eta };
        self.eta_scale.update(|scale| scale * eta * eta);
        eta * eta
    }

    /// Plays Russian roulette with the uniform number `u`: returns whether the path survives, with probability
    /// `survival`. The throughput of a survivor is divided by that probability.
    #[inline]
    pub(super) fn survives(&mut self, survival: f32, u: f32) -> bool {
        if u >= survival {
            return false;
        }
        let lifted = planted!("roulette-on-radiance", &mut self.radiance, &mut self.beta);
        *lifted *= planted!("roulette-without-division", 1.0, 1.0 / survival);
        true
    }

    /// Spawns the extension ray from a surface along `wi`, which was sampled with density `pdf`, and returns it with
    /// the primitive that it leaves.
    #[inline(always)]
    pub(super) fn spawn_ray(
        &mut self,
        scene: &Scene,
        at: &Interaction<E>,
        wi: Vec3,
        pdf: Option<PdfSolidAngle>,
        goes_through: bool,
    ) -> (Ray, ExcludedPrimitive) {
        let forgotten = planted!(
            "mirror-weighted-as-what-it-shows",
            self.scattered_from,
            None
        );
        self.scattered_from = pdf.map(|p_bsdf| (at.p, p_bsdf)).or(forgotten);
        let (ray, excluded) = scene.spawn(at, self.time.or(0.0), wi, goes_through);
        (self.ray, self.excluded) = (ray, Slot::new(|| Some(excluded)));
        (ray, excluded)
    }

    /// The MIS weight of light found by scattering, where light sampling has the density `p_light`.
    #[inline]
    pub(super) fn weight_of_scattering(
        &self,
        technique: Technique,
        p_light: impl FnOnce(Vec3) -> PdfSolidAngle,
        is_chosen: impl FnOnce() -> bool,
    ) -> f32 {
        match self.scattered_from {
            Some((from, p_bsdf)) => {
                technique.weight_of_scattering(p_bsdf, || p_light(from), is_chosen)
            }
            None => 1.0,
        }
    }
}
