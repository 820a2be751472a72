//! A path under construction.
//!
//! Measure: normalised scene units; radiance; densities per steradian.
//! Range: any path; what only some kernels need of it takes no room in the others.
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

/// A path under construction, with what the effects `E` need of it.
#[derive(Debug, Clone, Copy)]
pub struct PathState<E: Effects> {
    /// The ray onward.
    pub ray: Ray,
    /// What the ray leaves, for who looks behind a surface that is only partly there.
    pub departure: State<E::Alpha, Option<ExcludedPrimitive>>,
    /// When, from 0 to 1 while the shutter is open.
    pub time: State<E::Motion, f32>,
    /// What radiance along the ray counts.
    pub beta: Rgb,
    /// What has been found.
    pub radiance: Rgb,
    /// Radiance is thinned by eta^2 inside glass and restored on the way out: no reason to end a path.
    pub eta_scale: State<E::Transmission, f32>,
    /// Where the path scattered last, and with which density; `None` from the camera and from delta lobes.
    pub scattered_from: Option<(Vec3, PdfSolidAngle)>,
}

impl<E: Effects> PathState<E> {
    /// A path that begins with a ray, which leaves something or comes from the camera.
    #[inline]
    pub fn new(ray: Ray, departure: Option<ExcludedPrimitive>, time: f32) -> Self {
        Self {
            ray,
            departure: Slot::new(|| departure),
            time: Slot::new(|| time),
            beta: Rgb::WHITE,
            radiance: Rgb::BLACK,
            eta_scale: Slot::new(|| 1.0),
            scattered_from: None,
        }
    }

    /// Multiplies the throughput that roulette goes by, on the way through a surface of index `eta`, inside over outside,
    /// and tells the factor.
    #[inline]
    pub(super) fn refract(&mut self, eta: f32, enters: bool) -> f32 {
        let eta = if enters { eta } else { 1.0 / eta };
        self.eta_scale.update(|scale| scale * eta * eta);
        eta * eta
    }

    /// Whether it goes on, with probability `survival`, as the uniform number `u` decides: then its throughput makes up for
    /// those that end here.
    #[inline]
    pub(super) fn survives(&mut self, survival: f32, u: f32) -> bool {
        if u >= survival {
            return false;
        }
        let lifted = planted!("roulette-on-radiance", &mut self.radiance, &mut self.beta);
        *lifted *= planted!("roulette-without-division", 1.0, 1.0 / survival);
        true
    }

    /// Sends it on from a surface along `wi`, which was found with density `pdf`, and tells its ray and what that leaves.
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
        let (ray, departure) = scene.spawn(at, self.time.or(0.0), wi, goes_through);
        (self.ray, self.departure) = (ray, Slot::new(|| Some(departure)));
        (ray, departure)
    }

    /// The weight of light found by scattering, where light sampling finds it with density `p_light`.
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
