//! Scenes: as written ([`description::SceneDescription`]), and ready to be rendered ([`Scene`]).

mod build_geometry;
pub mod check;
mod compose;
pub mod description;
pub mod effects;
mod emitters;
mod extent;
pub mod footprint;
pub mod interaction;
pub mod keyframes;
pub mod load;
pub mod material;
pub mod normal_map;
pub mod normalisation;
mod placed;
pub mod placement;
pub mod prepare;
mod scene_lights;

use crate::accel::packet::RayPacket;
use crate::accel::{Accel, ExcludedPrimitive, Hit, PrimitiveId};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::effects::{EffectSet, Effects, Slot, State, Switch};
use crate::geometry::texture::Texture;
use crate::geometry::world::World;
use crate::light::select::Lights;
use crate::light::types::{
    BoundingSphere, Emission, EmissionSample, LightSample, LightSampleContext, PointRule,
    ShadowRayEnd,
};
use crate::math::lanes::LANES;
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

/// A scene, ready to be rendered: normalised, in single precision, its acceleration structure built.
///
/// Its questions are asked by a kernel for effects `E`, which have to include all that the scene calls for. Times go from
/// 0, when the shutter opens, to 1.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Where it is seen from.
    pub camera: Camera,
    /// What surfaces are lit by.
    pub lights: Lights,
    /// Holds all shapes.
    pub around: BoundingSphere,
    /// Radiance from everywhere beyond the scene, but for what [`Lights::beyond`] tells.
    pub environment: Rgb,
    /// From world units to those of the scene.
    pub normalisation: Normalisation,
    /// All shapes.
    pub world: Arc<World>,
    /// Ray queries; copies of a scene share it.
    pub accel: Arc<Accel>,
    /// What it calls for.
    pub effects: EffectSet,
    shapes: Vec<Shape>,
    materials: Vec<Material>,
    /// Shapes that emit.
    emitters: Vec<Emitter>,
    /// For each light of which its place is not all, the primitive that it is: those that vary over their surface, by a
    /// texture or by being partly there, and those of instances. Empty if there are none.
    light_primitives: Vec<Option<PrimitiveId>>,
    kept: PreparedCache,
}

/// What a scene keeps of its making, for changes that leave its shapes as they are.
#[derive(Debug, Clone)]
struct PreparedCache {
    /// Half the diagonal of the box around everything, in normalised units.
    radius: f64,
    /// What all objects but the camera call for.
    objects: EffectSet,
    /// Of the shapes that stand in the world themselves.
    still: Vec<Form>,
    /// The frame of each group.
    frames: Vec<Normalisation>,
    /// Of the shapes of each group.
    groups: Vec<Vec<Form>>,
}

/// What the scene knows of a shape beyond its geometry.
#[derive(Debug, Clone, Copy)]
struct Shape {
    /// Its index in the description: shapes of groups are there once, whatever places them.
    described: u32,
    material: u32,
    /// Index of what it emits.
    emitter: Option<u32>,
    /// Whether its material or its emission needs texture coordinates.
    textured: bool,
}

/// What a shape emits.
#[derive(Debug, Clone)]
struct Emitter {
    emission: Emission,
    /// Multiplies the emission.
    texture: Option<Arc<Texture>>,
    /// Its first light in [`Lights`]; `None` if only scattered rays find it.
    first_light: Option<u32>,
    /// Whether each primitive is a light of its own, or all of them one.
    per_primitive: bool,
}

impl Scene {
    /// The same scene on a film of `to` instead of `from` pixels. Shapes and structures are shared.
    pub fn on_film(&self, from: (u32, u32), to: (u32, u32)) -> Self {
        Self {
            camera: self.camera.on_film(from, to),
            ..self.clone()
        }
    }

    /// The same scene on a film of the same shape with about so many pixels, or with those that it has if they are fewer; and
    /// the size of that film.
    pub fn reduced(&self, size: (u32, u32), pixels: f64) -> (Self, (u32, u32)) {
        let scale = (pixels / (f64::from(size.0) * f64::from(size.1))).sqrt();
        let side = |side: u32| ((f64::from(side) * scale.min(1.0)).round() as u32).max(1);
        let to = (side(size.0), side(size.1));
        (self.on_film(size, to), to)
    }

    /// What a ray meets first. `u_alpha`, a uniform number, decides where a surface is only partly there.
    #[inline]
    pub fn intersect<E: Effects>(
        &self,
        ray: &Ray,
        time: f32,
        departure: Option<ExcludedPrimitive>,
        u_alpha: f32,
    ) -> Option<Interaction<E>> {
        let found = self.accel.intersect(ray, time, departure);
        self.surface_interaction(ray, time, departure, u_alpha, found)
    }

    /// The same, given the closest hit on the ray.
    #[inline]
    pub fn surface_interaction<E: Effects>(
        &self,
        ray: &Ray,
        time: f32,
        departure: Option<ExcludedPrimitive>,
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
                if shape.textured {
                    self.world.uv_at::<E>(hit.id, time, surface.p, hit.uv)
                } else {
                    Vec2::ZERO
                }
            });
            if E::Alpha::ON
                && let Some(alpha) = material.alpha(|| uv.or(Vec2::ZERO))
                && u_alpha >= alpha
            {
                // Uniform again: what is behind is decided with the rest of the number. Rounding may make it 1, which
                // would pass through what is all there.
                let rest = (u_alpha - alpha) / (1.0 - alpha);
                u_alpha = planted!("alpha-number-reused", u_alpha, rest.min(ONE_MINUS_EPSILON));
                ray.t_min = hit.t.next_up();
                found = self.accel.intersect(&ray, time, departure);
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

    /// The share of light that comes along a ray to its end.
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

    /// The same for each ray of a packet.
    #[inline]
    pub fn visibilities<E: Effects>(&self, rays: &mut RayPacket) -> [f32; LANES] {
        let mut visible = [0.0; LANES];
        if E::Alpha::ON {
            for (lane, visible) in visible.iter_mut().enumerate().take(rays.len()) {
                let (ray, time) = rays.get(lane);
                *visible = self.visibility::<E>(&ray, time);
            }
            return visible;
        }
        let mut occluded = [false; LANES];
        self.accel.occluded_packet(rays, &mut occluded);
        for (visible, occluded) in visible.iter_mut().zip(occluded) {
            *visible = if occluded { 0.0 } else { 1.0 };
        }
        visible
    }

    /// The index in the scene's description of the shape with this number.
    pub fn described(&self, shape: u32) -> usize {
        self.shapes[shape as usize].described as usize
    }

    /// The material of a primitive.
    #[inline]
    pub fn material(&self, id: PrimitiveId) -> &Material {
        &self.materials[self.shapes[id.shape as usize].material as usize]
    }

    /// How an interaction's surface scatters; `None` if it absorbs everything.
    #[inline]
    pub fn bsdf<E: Effects>(&self, at: &Interaction<E>) -> Option<Cow<'_, Bsdf>> {
        (!self.is_dark::<E>(at)).then(|| self.surface::<E>(at))
    }

    /// Whether an interaction sees the back of a surface that has but one side.
    #[inline]
    pub fn is_dark<E: Effects>(&self, at: &Interaction<E>) -> bool {
        E::OneSided::ON && at.is_behind() && self.material(at.id).is_one_sided()
    }

    /// How an interaction's surface scatters, whichever side is seen.
    #[inline]
    pub fn surface<E: Effects>(&self, at: &Interaction<E>) -> Cow<'_, Bsdf> {
        self.material(at.id).bsdf::<E>(at.uv.or(Vec2::ZERO))
    }

    /// Radiance that an interaction's surface emits back along the path; `None` if it is no emitter.
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

    /// The light that an emitting interaction is on; `None` for one that only scattered rays find.
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

    /// The density with which light sampling at `from` would have found the emitting interaction `at`.
    #[inline]
    pub fn light_pdf<E: Effects>(
        &self,
        from: Vec3,
        time: f32,
        at: &Interaction<E>,
    ) -> PdfSolidAngle {
        self.light_of(at).map_or(PdfSolidAngle(0.0), |light| {
            self.lights.pdf::<E>(light, from, time, at.p - from, at.ng)
        })
    }

    /// A direction from which a light shines on `p`, as [`Lights::sample`].
    #[inline]
    pub fn sample_light<E: Effects>(
        &self,
        choice: (u32, Pmf),
        points: PointRule,
        p: Vec3,
        time: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let mut sample = self.lights.sample::<E>(choice, points, p, time, u)?;
        self.adapt_to_primitive::<E>(choice.0, time, &mut sample.radiance, &mut sample.end);
        Some(sample)
    }

    /// The same for each of some places, in their order.
    #[inline]
    pub fn sample_lights<E: Effects>(
        &self,
        questions: &[LightSampleContext],
        points: PointRule,
        samples: &mut Vec<Option<LightSample>>,
    ) {
        samples.clear();
        self.lights.sample_each::<E>(questions, points, samples);
        if self.light_primitives.is_empty() {
            return;
        }
        for (question, sample) in questions.iter().zip(samples) {
            if let Some(LightSample { radiance, end, .. }) = sample {
                self.adapt_to_primitive::<E>(question.light, question.time, radiance, end);
            }
        }
    }

    /// A ray of light as it leaves a light, as [`Light::sample_emission`](crate::light::Light::sample_emission), by two
    /// numbers for where it passes and two for where it goes.
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

    /// What the light itself does not know of a point on it: its texture, whether it is there, and the error bound of an
    /// instance.
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
            // A ray meets the lamp where it is there; what shines through the rest is another matter.
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

    /// The ray that leaves an interaction along the unit vector `w`, reflected or through the surface, and what it
    /// leaves.
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
