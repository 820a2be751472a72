//! Scenes: the description ([`description::SceneDescription`]) and the scene prepared for rendering ([`Scene`]).

mod build_geometry;
pub mod check;
mod compose;
pub mod description;
pub mod effects;
mod emitters;
mod extent;
pub mod footprint;
pub mod guides;
pub mod interaction;
pub mod keyframes;
pub mod load;
pub mod material;
pub mod normal_map;
pub mod normalisation;
mod placed;
pub mod placement;
pub mod prepare;
pub mod save;
mod scene_lights;
mod shape_traits;

pub use shape_traits::ShapeTraits;

use crate::accel::lanes::RayLanes;
use crate::accel::{Accel, ExcludedPrimitive, Hit, PrimitiveId};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::effects::{EffectSet, Effects, Slot, State, Switch};
use crate::geometry::texture::Texture;
use crate::geometry::world::World;
use crate::light::guides::Guides;
use crate::light::lanes::{LightContextLanes, LightSampleLanes};
use crate::light::select::{LightLanes, Lights};
use crate::light::types::{
    BoundingSphere, Emission, EmissionSample, LightChoice, LightSample, LightSampling, PointRule,
    Receiver, ShadowRayEnd,
};
use crate::math::lanes::ActiveLanes;
use crate::math::lanes::{LANES, Lanes, Lanes3, load};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::robust::offset_point;
use crate::math::vec::{ONE_MINUS_EPSILON, Vec2, Vec3};
use crate::planted::planted;
use interaction::Interaction;
use material::Material;
use normalisation::Normalisation;
use placed::Form;
use std::borrow::Cow;
use std::sync::Arc;

/// A scene prepared for rendering: normalised, in single precision, with its acceleration structure.
///
/// Its queries are called by a kernel for effects `E`, which must include all effects of the scene. Times run from 0,
/// when the shutter opens, to 1.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The camera.
    pub camera: Camera,
    /// The lights that can be sampled.
    pub lights: Lights,
    /// Bounding sphere of all shapes.
    pub around: BoundingSphere,
    /// The shapes towards which light paths are sampled.
    pub guides: Guides,
    /// Radiance of the constant environment; that of an environment map is returned by [`Lights::environment`].
    pub environment: Rgb,
    /// Map from world units to normalised units.
    pub normalisation: Normalisation,
    /// The geometry of all shapes and instances.
    pub world: Arc<World>,
    /// The acceleration structure; copies of a scene share it.
    pub accel: Arc<Accel>,
    /// The effects that the scene requires of a kernel.
    pub effects: EffectSet,
    shapes: Vec<Shape>,
    materials: Vec<Material>,
    /// Emission of the shapes that emit.
    emitters: Vec<Emitter>,
    /// For each light the primitive that it lies on, where more than its position is needed: for lights with an emission
    /// texture or alpha, and lights of instances. Empty if there are none.
    light_primitives: Vec<Option<PrimitiveId>>,
    kept: PreparedCache,
}

/// Intermediate results of [`prepare`](prepare::prepare) that are kept for changes of the camera or of instances.
#[derive(Debug, Clone)]
struct PreparedCache {
    /// Half the diagonal of the bounding box of everything, in normalised units.
    radius: f64,
    /// The effects that all objects but the camera require.
    objects: EffectSet,
    /// The forms of the shapes that belong to no group.
    still: Vec<Form>,
    /// The normalisation of each group.
    frames: Vec<Normalisation>,
    /// The forms of the shapes of each group.
    groups: Vec<Vec<Form>>,
}

/// Attributes of a shape besides its geometry.
#[derive(Debug, Clone, Copy)]
struct Shape {
    /// Index in the description; a shape of a group has the same in all instances.
    described: u32,
    material: u32,
    /// Index of its emitter.
    emitter: Option<u32>,
    traits: ShapeTraits,
}

/// The emission of a shape.
#[derive(Debug, Clone)]
struct Emitter {
    emission: Emission,
    /// Factor for the emission.
    texture: Option<Arc<Texture>>,
    /// Index of its first light in [`Lights`]; `None` if only BSDF sampling can hit it.
    first_light: Option<u32>,
    /// Whether each primitive is a light of its own, instead of one light for all.
    per_primitive: bool,
}

impl Scene {
    /// Returns the scene on a film of `to` instead of `from` pixels. Shapes and acceleration structures are shared.
    pub fn on_film(&self, from: (u32, u32), to: (u32, u32)) -> Self {
        Self {
            camera: self.camera.on_film(from, to),
            ..self.clone()
        }
    }

    /// Returns the scene on a film of the same aspect ratio with about `pixels` pixels, or with its own number if that
    /// is smaller; and the size of that film.
    pub fn reduced(&self, size: (u32, u32), pixels: f64) -> (Self, (u32, u32)) {
        let scale = (pixels / (f64::from(size.0) * f64::from(size.1))).sqrt();
        let side = |side: u32| ((f64::from(side) * scale.min(1.0)).round() as u32).max(1);
        let to = (side(size.0), side(size.1));
        (self.on_film(size, to), to)
    }

    /// Returns the closest interaction along a ray. The uniform number `u_alpha` decides hits on surfaces with alpha.
    #[inline]
    pub fn intersect<E: Effects>(
        &self,
        ray: &Ray,
        time: f32,
        excluded: Option<ExcludedPrimitive>,
        u_alpha: f32,
    ) -> Option<Interaction<E>> {
        let found = self.accel.intersect(ray, time, excluded);
        self.surface_interaction(ray, time, excluded, u_alpha, found)
    }

    /// Returns the closest interaction along a ray, given its closest hit.
    #[inline]
    pub fn surface_interaction<E: Effects>(
        &self,
        ray: &Ray,
        time: f32,
        excluded: Option<ExcludedPrimitive>,
        u_alpha: f32,
        found: Option<Hit>,
    ) -> Option<Interaction<E>> {
        let (mut ray, mut u_alpha, mut found) = (*ray, u_alpha, found);
        loop {
            let hit = found?;
            let mut surface = self
                .world
                .surface_at::<E>(hit.id, &ray, time, hit.t, hit.uv);
            let shape = &self.shapes[hit.id.shape as usize];
            let material = &self.materials[shape.material as usize];
            let uv = State::<E::Textures, Vec2>::new(|| {
                if shape.traits.has(ShapeTraits::IS_TEXTURED) {
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
                ray.t_min = hit.t.next_up();
                found = self.accel.intersect(&ray, time, excluded);
                continue;
            }
            if E::NormalMaps::ON
                && let Some(map) = material.normal_map()
            {
                let tangents = self.world.tangents_at::<E>(hit.id, time, surface.p);
                surface.ns = map.tilt(uv.or(Vec2::ZERO), surface.ns, surface.ng, tangents);
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

    /// Returns the transmittance along a shadow ray: the product of 1 - alpha over the surfaces that it intersects.
    #[inline]
    pub fn visibility<E: Effects>(&self, ray: &Ray, time: f32) -> f32 {
        if !E::Alpha::ON {
            return if self.accel.occluded(ray, time) {
                0.0
            } else {
                1.0
            };
        }
        let mut ray = *ray;
        let mut visible = 1.0;
        while let Some(hit) = self.accel.intersect(&ray, time, None) {
            let p = ray.at(hit.t);
            let uv = || self.world.uv_at::<E>(hit.id, time, p, hit.uv);
            let Some(alpha) = self.material(hit.id).alpha(uv) else {
                return 0.0;
            };
            visible *= 1.0 - alpha;
            if visible <= 0.0 {
                return 0.0;
            }
            ray.t_min = hit.t.next_up();
        }
        visible
    }

    /// Returns the transmittance along the shadow ray of each active lane; 0 for the others.
    #[inline]
    pub fn visibilities<E: Effects>(
        &self,
        active: &ActiveLanes<LANES>,
        rays: &mut RayLanes<LANES>,
    ) -> Lanes<f32> {
        let mut visible = [0.0; LANES];
        if E::Alpha::ON {
            for lane in active.each() {
                let (ray, time) = rays.get(lane);
                visible[lane] = self.visibility::<E>(&ray, time);
            }
            return visible;
        }
        self.accel.occluded_lanes(active, rays);
        for (lane, visible) in visible.iter_mut().enumerate() {
            let is_visible = active.has(lane) & (rays.t_max[lane] >= 0.0);
            *visible = if is_visible { 1.0 } else { 0.0 };
        }
        visible
    }

    /// Returns the index in the scene's description of the shape with this number.
    pub fn described(&self, shape: u32) -> usize {
        self.shapes[shape as usize].described as usize
    }

    /// Returns the material of a primitive.
    #[inline]
    pub fn material(&self, id: PrimitiveId) -> &Material {
        &self.materials[self.shapes[id.shape as usize].material as usize]
    }

    /// Returns the BSDF at an interaction; `None` if the surface absorbs everything.
    #[inline]
    pub fn bsdf<E: Effects>(&self, at: &Interaction<E>) -> Option<Cow<'_, Bsdf>> {
        (!self.is_dark::<E>(at)).then(|| self.surface::<E>(at))
    }

    /// Whether an interaction is on the back of a one-sided surface.
    #[inline]
    pub fn is_dark<E: Effects>(&self, at: &Interaction<E>) -> bool {
        E::OneSided::ON && at.is_behind() && self.material(at.id).is_one_sided()
    }

    /// Returns the BSDF at an interaction, whichever side is seen.
    #[inline]
    pub fn surface<E: Effects>(&self, at: &Interaction<E>) -> Cow<'_, Bsdf> {
        self.material(at.id).bsdf::<E>(at.uv.or(Vec2::ZERO))
    }

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
        let emitter = self.emitter(at.id)?;
        let offset = if emitter.per_primitive {
            at.id.primitive
        } else {
            0
        };
        emitter.first_light.map(|first| first + offset)
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
        choice: (u32, Pmf),
        rules: LightSampling,
        p: Vec3,
        time: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let mut sample = self.lights.sample::<E>(choice, rules, p, time, u)?;
        self.adapt_to_primitive::<E>(choice.0, time, &mut sample.radiance, &mut sample.end);
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
        let is_in_lanes = E::AreaLights::ON
            && rules.points == PointRule::SolidAngle
            && self.light_primitives.is_empty();
        let singly = if is_in_lanes {
            self.lights
                .sample_lanes(active, context, p, lights, samples)
        } else {
            *active
        };
        for lane in singly.each() {
            let choice = (context.light[lane], Pmf(context.pmf[lane]));
            let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
            let time = context.time[lane];
            let sample = self.sample_light::<E>(choice, rules, load(p, lane), time, u);
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
        let found = self.lights.get(light);
        let sample = found.sample_emission::<E>(time, u_position, u_direction, &self.around);
        let mut sample = sample?;
        self.adapt_to_primitive::<E>(light, time, &mut sample.radiance, &mut sample.end);
        (!sample.radiance.is_black()).then_some(sample)
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

    /// Returns the ray that leaves an interaction along the unit vector `w`, reflected or transmitted, and the
    /// [`ExcludedPrimitive`] that prevents self-intersection.
    #[inline]
    pub fn spawn<E: Effects>(
        &self,
        at: &Interaction<E>,
        time: f32,
        w: Vec3,
        goes_through: bool,
    ) -> (Ray, ExcludedPrimitive) {
        let normal = at.exit_normal(goes_through);
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
