//! Scenes: as written ([`description::SceneDescription`]), and ready to be rendered ([`Scene`]).

pub mod description;
pub mod interaction;
pub mod load;
pub mod material;
pub mod normalisation;
pub mod prepare;

use crate::accel::{Accel, Departure, PrimitiveId};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::geometry::Geometry;
use crate::light::select::Lights;
use crate::light::types::Emission;
use crate::math::measure::PdfSolidAngle;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::robust::offset_point;
use crate::math::vec::Vec3;
use interaction::Interaction;
use material::Material;
use normalisation::Normalisation;
use std::sync::Arc;

/// A scene, ready to be rendered: normalised, in single precision, its acceleration structure built.
#[derive(Debug)]
pub struct Scene {
    /// Where it is seen from.
    pub camera: Camera,
    /// What surfaces are lit by.
    pub lights: Lights,
    /// Radiance from everywhere beyond the scene.
    pub environment: Rgb,
    /// From world units to those of the scene.
    pub normalisation: Normalisation,
    /// All shapes, by the ids that hits carry.
    pub geometries: Arc<[Geometry]>,
    /// Ray queries.
    pub accel: Accel,
    shapes: Vec<Shape>,
    materials: Vec<Material>,
}

/// What the scene knows of a shape beyond its geometry.
#[derive(Debug, Clone, Copy)]
struct Shape {
    material: u32,
    emission: Option<ShapeEmission>,
}

/// A shape that emits.
#[derive(Debug, Clone, Copy)]
struct ShapeEmission {
    emission: Emission,
    /// Its first light in [`Lights`].
    first_light: u32,
    /// Whether each primitive is a light of its own, or all of them one.
    per_primitive: bool,
}

impl Scene {
    /// What a ray meets first.
    #[inline]
    pub fn intersect(&self, ray: &Ray, departure: Option<Departure>) -> Option<Interaction> {
        let hit = self.accel.intersect(ray, departure)?;
        let geometry = &self.geometries[hit.id.geometry as usize];
        let surface = geometry.surface_at(hit.id.primitive, ray, hit.t, hit.uv);
        let transmits = self.material(hit.id).transmits();
        Some(Interaction::new(ray, &hit, &surface, transmits))
    }

    /// The material of a primitive.
    #[inline]
    pub fn material(&self, id: PrimitiveId) -> &Material {
        &self.materials[self.shapes[id.geometry as usize].material as usize]
    }

    /// How an interaction's surface scatters.
    #[inline]
    pub fn bsdf(&self, at: &Interaction) -> Bsdf {
        self.material(at.id).bsdf(at.uv)
    }

    /// Radiance that an interaction's surface emits back along the path; `None` if it is no emitter.
    #[inline]
    pub fn emitted(&self, at: &Interaction) -> Option<Rgb> {
        let shape = self.shapes[at.id.geometry as usize].emission?;
        Some(shape.emission.towards(at.wo.dot(at.ng)))
    }

    /// The density with which light sampling at `from` would have found the emitting interaction `at`.
    #[inline]
    pub fn light_pdf(&self, from: Vec3, at: &Interaction) -> PdfSolidAngle {
        let Some(shape) = self.shapes[at.id.geometry as usize].emission else {
            return PdfSolidAngle(0.0);
        };
        let offset = if shape.per_primitive {
            at.id.primitive
        } else {
            0
        };
        self.lights
            .pdf(shape.first_light + offset, from, at.p - from, at.ng)
    }

    /// The ray that leaves an interaction along the unit vector `w`, reflected or through the surface, and what it
    /// leaves.
    #[inline]
    pub fn spawn(&self, at: &Interaction, w: Vec3, goes_through: bool) -> (Ray, Departure) {
        let normal = at.exit_normal(goes_through);
        let geometry = &self.geometries[at.id.geometry as usize];
        let free_distance = geometry.free_distance(at.p, w, normal == at.ng);
        let origin = offset_point(at.p, at.error, normal);
        (
            Ray::new(origin, w),
            Departure {
                id: at.id,
                free_distance,
            },
        )
    }
}
