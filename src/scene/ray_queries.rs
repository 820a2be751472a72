//! The ray queries of a scene: the closest surface interaction, the transmittance of shadow rays, and the rays that leave a
//! surface.
//!
//! Measure: normalised units.
//! Range: a kernel for all effects of the scene; times from 0 to 1.
//! Source: docs/architecture.md. Tested in `tests/tracing/` and `tests/rendering/effects.rs`.

use super::interaction::Interaction;
use super::{Scene, ShapeTraits};
use crate::accel::lanes::RayLanes;
use crate::accel::{ExcludedPrimitive, Hit};
use crate::effects::{Effect, EffectState, Effects, Slot, Switch};
use crate::math::lanes::{ActiveLanes, LANES, Lanes};
use crate::math::ray::Ray;
use crate::math::robust::offset_point;
use crate::math::vec::{ONE_MINUS_EPSILON, Vec2, Vec3};
use crate::planted::planted;

impl Scene {
    /// Returns the closest interaction along a ray. The uniform number `u_alpha` decides hits on surfaces with alpha.
    #[inline]
    pub fn intersect<E: Effects>(
        &self,
        ray: &Ray,
        time: f32,
        excluded: Option<ExcludedPrimitive>,
        u_alpha: f32,
    ) -> Option<Interaction<E>> {
        let hit = self.accel.intersect(ray, time, excluded);
        self.surface_interaction(ray, time, excluded, u_alpha, hit)
    }

    /// Returns the closest interaction along a ray, given its closest hit.
    #[inline]
    pub fn surface_interaction<E: Effects>(
        &self,
        ray: &Ray,
        time: f32,
        excluded: Option<ExcludedPrimitive>,
        u_alpha: f32,
        hit: Option<Hit>,
    ) -> Option<Interaction<E>> {
        let (mut ray, mut u_alpha, mut closest) = (*ray, u_alpha, hit);
        let mut passed = None;
        loop {
            let hit = closest?;
            let mut surface = self
                .world
                .surface_at::<E>(hit.id, &ray, time, hit.t, hit.uv);
            let side = Some((hit.id, surface.ng.dot(ray.dir) < 0.0));
            if E::Alpha::ON && side == passed {
                // The distances of one hit may differ by rounding from one query to the next.
                ray.begin_after(hit.t);
                closest = self.accel.intersect(&ray, time, excluded);
                continue;
            }
            let shape = &self.shapes[hit.id.shape as usize];
            let material = &self.materials[shape.material as usize];
            let uv = EffectState::<E::Textures, Vec2>::new(|| {
                if shape.traits.has(ShapeTraits::TEXTURED) {
                    self.world.uv_at::<E>(hit.id, time, surface.p, hit.uv)
                } else {
                    Vec2::ZERO
                }
            });
            if E::Alpha::ON
                && let Some(alpha) = material.alpha(|| uv.or(Vec2::ZERO))
                && u_alpha >= alpha
            {
                // Rescaled to a uniform number, which decides at the surfaces behind. Rounding may make it 1, which
                // would pass through opaque surfaces.
                let rest = (u_alpha - alpha) / (1.0 - alpha);
                u_alpha = planted!("alpha-number-reused", u_alpha, rest.min(ONE_MINUS_EPSILON));
                passed = side;
                ray.begin_after(hit.t);
                closest = self.accel.intersect(&ray, time, excluded);
                continue;
            }
            if E::NormalMaps::ON
                && let Some(detail) = material.detail()
            {
                let tangents = self.world.tangents_at::<E>(hit.id, time, surface.p);
                surface.ns = detail.tilt(uv.or(Vec2::ZERO), surface.ns, surface.ng, tangents);
            }
            return Some(Interaction::new(
                &ray,
                &hit,
                &surface,
                material.transmits(),
                uv,
            ));
        }
    }

    /// Whether a shadow ray may go through surfaces: a kernel with alpha also renders scenes without.
    #[inline(always)]
    fn has_alpha<E: Effects>(&self) -> bool {
        E::Alpha::ON && self.effects.has(Effect::Alpha)
    }

    /// Returns the transmittance along a shadow ray: the product of 1 - alpha over the surfaces that it intersects.
    #[inline]
    pub fn visibility<E: Effects>(&self, ray: &Ray, time: f32) -> f32 {
        if !self.has_alpha::<E>() {
            return if self.accel.occluded(ray, time) {
                0.0
            } else {
                1.0
            };
        }
        let mut ray = *ray;
        let mut visible = 1.0;
        let mut passed: Option<Hit> = None;
        let is_entered = |hit: &Hit, ray: &Ray| {
            let surface = self.world.surface_at::<E>(hit.id, ray, time, hit.t, hit.uv);
            surface.ng.dot(ray.dir) < 0.0
        };
        while let Some(hit) = self.accel.intersect(&ray, time, None) {
            ray.begin_after(hit.t);
            // As in `surface_interaction`, a surface is passed once.
            let before = passed.replace(hit);
            if before.is_some_and(|it| {
                it.id == hit.id && is_entered(&it, &ray) == is_entered(&hit, &ray)
            }) {
                continue;
            }
            let p = ray.at(hit.t);
            let uv = || self.world.uv_at::<E>(hit.id, time, p, hit.uv);
            let Some(alpha) = self.material(hit.id).alpha(uv) else {
                return 0.0;
            };
            visible *= 1.0 - alpha;
            if visible <= 0.0 {
                return 0.0;
            }
        }
        visible
    }

    /// Returns the transmittance along the shadow ray of each active lane; 0 for the others. Of rays that are flagged as coherent,
    /// the result of one may depend on the others.
    #[inline]
    pub fn visibilities<E: Effects>(
        &self,
        active: &ActiveLanes<LANES>,
        rays: &mut RayLanes<LANES>,
        coherent: bool,
    ) -> Lanes<f32> {
        let mut visible = [0.0; LANES];
        if self.has_alpha::<E>() {
            for lane in active.each() {
                let (ray, time) = rays.get(lane);
                visible[lane] = self.visibility::<E>(&ray, time);
            }
            return visible;
        }
        self.accel.occluded_lanes(active, rays, coherent);
        for (lane, visible) in visible.iter_mut().enumerate() {
            let is_visible = active.has(lane) & (rays.t_max[lane] >= 0.0);
            *visible = if is_visible { 1.0 } else { 0.0 };
        }
        visible
    }

    /// Returns the ray that leaves an interaction along the unit vector `w`, reflected or transmitted, and the
    /// [`ExcludedPrimitive`] that prevents self-intersection.
    #[inline]
    pub fn spawn<E: Effects>(
        &self,
        at: &Interaction<E>,
        time: f32,
        w: Vec3,
        is_transmitted: bool,
    ) -> (Ray, ExcludedPrimitive) {
        let normal = at.exit_normal(is_transmitted);
        let free_distance = self
            .world
            .free_distance::<E>(at.id, time, at.p, w, normal == at.ng);
        let origin = offset_point(at.p, at.error, normal);
        (
            Ray::new(origin, w),
            ExcludedPrimitive {
                id: at.id,
                free_distance,
            },
        )
    }
}
