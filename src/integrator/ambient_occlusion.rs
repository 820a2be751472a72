//! Ambient occlusion: the unoccluded share of the hemisphere over a surface, weighted by the cosine.
//!
//!   A(x) = 1/pi  integral over the hemisphere of  V(x, w, d) cos(w) dw,
//!
//! where V is 1 if nothing is hit along w within the distance d. With cosine-weighted directions, each sample is V.
//!
//! Measure: none, in [0, 1]; the distance in normalised units.
//! Range: any scene; a camera ray that hits nothing is black, as there is no surface.
//! Source: Zhukov, Iones and Kronin 1998, "An Ambient Light Illumination Model". Tested in `tests/rendering/integrators.rs`.

use super::observer::{PathObserver, RayKind};
use super::{CameraRay, Integrator, RayCounts};
use crate::accel::Hit;
use crate::effects::{Effects, Switch};
use crate::light::types::ShadowRayEnd;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::{Decision, Sampler};
use crate::sampling::warp::sample_hemisphere_cosine;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// The ambient occlusion of the surfaces that the camera sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmbientOcclusion {
    /// The largest distance at which something occludes; infinite for any distance.
    pub distance: f32,
}

impl Integrator for AmbientOcclusion {
    type Scratch<'a, E: Effects> = ();

    fn radiance<E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        rays: &mut RayCounts,
        _scratch: &mut (),
        observer: &mut O,
    ) -> Rgb {
        let CameraRay { ray, time } = *camera_ray;
        rays.camera += 1;
        let u_alpha = if E::Alpha::ON {
            let [u] = sampler.draw(Decision::Alpha(0));
            u
        } else {
            0.0
        };
        let at: Option<Interaction<E>> = scene.surface_interaction(&ray, time, None, u_alpha, hit);
        let Some(at) = at else {
            observer.escaped(ray.dir);
            return Rgb::BLACK;
        };
        observer.arrived(&(&at).into(), Rgb::WHITE);
        let [u, v] = sampler.draw(Decision::Bsdf(0));
        let mut w = sample_hemisphere_cosine(Vec2::new(u, v));
        w.z = w.z.copysign(at.frame.to_local(at.wo).z);
        let w = at.frame.to_world(w);
        if !at.is_consistent_side(w, false) {
            observer.absorbed();
            return Rgb::BLACK;
        }
        let mut ray = at.ray_to(&ShadowRayEnd::Infinity, w, false);
        ray.t_max = self.distance;
        rays.shadow += 1;
        observer.traced(RayKind::Shadow, &ray, time);
        let radiance = scene.visibility::<E>(&ray, time) * Rgb::WHITE;
        observer.environment(radiance);
        radiance
    }
}
