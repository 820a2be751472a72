//! The light queries of a scene: what a surface emits, which light it belongs to, and samples of lights with the texture, the
//! alpha and the instance of the shape that they lie on.
//!
//! Measure: radiance; densities by solid angle.
//! Range: a kernel for all effects of the scene; times from 0 to 1.
//! Source: `src/light/`. Tested in `tests/lights/`.

use super::interaction::Interaction;
use super::{Emitter, EmitterLights, Scene};
use crate::accel::PrimitiveId;
use crate::effects::{Effects, Slot, Switch};
use crate::light::lanes::{LightContextLanes, LightSampleLanes};
use crate::light::select::LightLanes;
use crate::light::types::{
    EmissionPdf, EmissionSample, LightChoice, LightSample, LightSampling, PointRule, Receiver,
    ShadowRayEnd,
};
use crate::math::lanes::{ActiveLanes, LANES, Lanes3, load};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};

impl Scene {
    /// Returns the radiance emitted along `wo`; `None` if the surface is not an emitter.
    #[inline]
    pub fn emitted<E: Effects>(&self, at: &Interaction<E>) -> Option<Rgb> {
        if !E::AreaLights::ON {
            return None;
        }
        let emitter = self.emitter(at.id)?;
        let radiance = emitter.emission.towards(at.wo.dot(at.ng));
        match &emitter.texture {
            Some(texture) if E::Textures::ON => {
                Some(radiance * texture.lookup(at.uv.or(Vec2::ZERO)))
            }
            _ => Some(radiance),
        }
    }

    /// Returns the light on which an emitting interaction lies; `None` if light sampling does not cover it.
    #[inline]
    pub fn light_of<E: Effects>(&self, at: &Interaction<E>) -> Option<u32> {
        match &self.emitter(at.id)?.lights {
            EmitterLights::None => None,
            EmitterLights::Whole(light) => Some(*light),
            EmitterLights::OfPrimitives(lights) => Some(lights[at.id.primitive as usize]),
        }
    }

    /// Returns the pdf with which light sampling at `from` would have sampled the emitting interaction `at`.
    #[inline]
    pub fn light_pdf<E: Effects>(
        &self,
        choice: LightChoice,
        from: &Receiver,
        time: f32,
        at: &Interaction<E>,
    ) -> PdfSolidAngle {
        self.light_of(at).map_or(PdfSolidAngle(0.0), |light| {
            let towards = at.p - from.p;
            self.lights
                .pdf::<E>(light, choice, from, time, towards, at.ng)
        })
    }

    /// Samples the incident direction at `p` from a given light; see [`Lights::sample`].
    #[inline]
    pub fn sample_light<E: Effects>(
        &self,
        selected: (u32, Pmf),
        rules: LightSampling,
        p: Vec3,
        time: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let mut sample = self.lights.sample::<E>(selected, rules, p, time, u)?;
        self.adapt_to_primitive::<E>(selected.0, time, &mut sample.radiance, &mut sample.end);
        Some(sample)
    }

    /// Samples the selected light of each active lane for the receiver `p`; see [`sample_light`](Self::sample_light).
    #[inline]
    pub fn sample_lights<E: Effects>(
        &self,
        active: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        rules: LightSampling,
        p: &Lanes3,
        lights: &mut LightLanes,
        samples: &mut LightSampleLanes,
    ) {
        let is_in_lanes = E::AreaLights::ON && rules.points == PointRule::SolidAngle;
        let scalar_lanes = if is_in_lanes {
            let is_adapted = |lane: usize| {
                let primitive = self.light_primitives.get(context.light[lane] as usize);
                primitive.is_some_and(Option::is_some)
            };
            let adapted = match self.light_primitives.is_empty() {
                true => ActiveLanes::NONE,
                false => active.and(is_adapted),
            };
            let others = active.without(&adapted);
            let rest = self
                .lights
                .sample_lanes(&others, context, p, lights, samples);
            rest.with(&adapted)
        } else {
            *active
        };
        for lane in scalar_lanes.each() {
            let selected = (context.light[lane], Pmf(context.pmf[lane]));
            let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
            let time = context.time[lane];
            let sample = self.sample_light::<E>(selected, rules, load(p, lane), time, u);
            samples.set(lane, sample.as_ref());
        }
    }

    /// Samples a ray that leaves a light, as [`Light::sample_emission`](crate::light::Light::sample_emission), by two
    /// numbers for its position and two for its direction.
    pub fn sample_emission<E: Effects>(
        &self,
        light: u32,
        time: f32,
        u_position: Vec2,
        u_direction: Vec2,
    ) -> Option<EmissionSample> {
        let sampled_light = self.lights.get(light);
        let sample = sampled_light.sample_emission::<E>(
            time,
            u_position,
            u_direction,
            &self.bounding_sphere,
        );
        let mut sample = sample?;
        self.adapt_to_primitive::<E>(light, time, &mut sample.radiance, &mut sample.end);
        (!sample.radiance.is_black()).then_some(sample)
    }

    /// The densities of [`Self::sample_emission`] for a ray that leaves a light at `end` along a unit vector.
    pub fn pdf_emission(
        &self,
        light: u32,
        time: f32,
        end: &ShadowRayEnd,
        direction: Vec3,
    ) -> EmissionPdf {
        let normal = match end {
            ShadowRayEnd::Surface(point, _) => point.ng,
            ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => Vec3::ZERO,
        };
        let light = self.lights.get(light);
        light.pdf_emission(time, normal, direction, &self.bounding_sphere)
    }

    /// Applies to a sampled point of a light what the light itself does not store: its texture, its alpha, and the error
    /// bound of an instance.
    #[inline]
    fn adapt_to_primitive<E: Effects>(
        &self,
        light: u32,
        time: f32,
        radiance: &mut Rgb,
        end: &mut ShadowRayEnd,
    ) {
        if (E::Textures::ON || E::Alpha::ON || E::Instances::ON)
            && !self.light_primitives.is_empty()
            && let Some(id) = self.light_primitives[light as usize]
            && let ShadowRayEnd::Surface(point, barycentric) = end
        {
            if let Some(error) = self.world.error_at::<E>(id, time, point.p) {
                point.error = error;
            }
            let uv = || self.world.uv_at::<E>(id, time, point.p, *barycentric);
            if let Some(texture) = self.emitter(id).and_then(|e| e.texture.as_ref()) {
                *radiance *= texture.lookup(uv());
            }
            // The rest of the light passes through and belongs to the surfaces behind.
            if let Some(alpha) = self.material(id).alpha(uv) {
                *radiance *= alpha;
            }
        }
    }

    #[inline]
    fn emitter(&self, id: PrimitiveId) -> Option<&Emitter> {
        let emitter = self.shapes[id.shape as usize].emitter?;
        Some(&self.emitters[emitter as usize])
    }
}
