//! Scenes: the description ([`description::SceneDescription`]) and the scene prepared for rendering ([`Scene`]).
//!
//! Measure: a description is in world units, a prepared scene in normalised units ([`normalisation`]).
//! Range: descriptions that pass the checks in `check/`; invalid input gives an error with its place.
//! Source: `docs/scene-format.md` and `docs/architecture.md`. Tested in `tests/loading/`.

mod build_geometry;
mod bump_map;
pub mod caustic_targets;
pub mod check;
mod compose;
pub mod description;
pub mod effects;
mod emitters;
mod extent;
pub mod footprint;
pub mod interaction;
pub mod keyframes;
mod light_queries;
pub mod load;
pub mod material;
mod medians;
mod mesh_rectangles;
mod normal_map;
pub mod normalisation;
mod placed;
pub mod placement;
pub mod prepare;
mod ray_queries;
pub mod save;
mod scene_lights;
mod shape_traits;
mod surface_detail;
mod update;

pub use shape_traits::ShapeTraits;

use crate::accel::{Accel, PrimitiveId};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::effects::{EffectSet, Effects, Slot, Switch};
use crate::geometry::texture::Texture;
use crate::geometry::world::World;
use crate::light::caustic_targets::CausticTargets;
use crate::light::select::Lights;
use crate::light::types::{BoundingSphere, Emission};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use interaction::Interaction;
use material::Material;
use normalisation::Normalisation;
use placed::TransformedAttributes;
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
    pub bounding_sphere: BoundingSphere,
    /// Spheres around the shapes that cast caustics, towards which light paths are sampled.
    pub caustic_targets: CausticTargets,
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
    shapes: Vec<ShapeAttributes>,
    materials: Vec<Material>,
    /// Emission of the shapes that emit.
    emitters: Vec<Emitter>,
    /// The primitive that each light lies on, where more than its position is needed: for lights with an emission
    /// texture or alpha, and lights of instances. Empty if there are none.
    light_primitives: Vec<Option<PrimitiveId>>,
    cache: PreparedCache,
}

/// Intermediate results of [`prepare`](prepare::prepare) that are kept for changes of the camera or of instances.
#[derive(Debug, Clone)]
struct PreparedCache {
    /// Half the diagonal of the bounding box of everything, in normalised units.
    radius: f64,
    /// The effects that all objects but the camera require.
    objects: EffectSet,
    /// The transformed shapes that belong to no group.
    ungrouped: Vec<TransformedAttributes>,
    /// The normalisation of each group.
    group_normalisations: Vec<Normalisation>,
    /// The transformed shapes of each group.
    groups: Vec<Vec<TransformedAttributes>>,
}

/// Attributes of a shape besides its geometry.
#[derive(Debug, Clone, Copy)]
struct ShapeAttributes {
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
    /// Its lights in [`Lights`].
    lights: EmitterLights,
}

/// The lights that lie on an emitter, by their indices.
#[derive(Debug, Clone)]
enum EmitterLights {
    /// None: only BSDF sampling can hit it.
    None,
    /// One for the whole shape.
    Whole(u32),
    /// The light of each primitive: one each, or one for two triangles that form a rectangle.
    OfPrimitives(Box<[u32]>),
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

    /// Returns the index in the scene's description of the shape with this number.
    pub fn described(&self, shape: u32) -> usize {
        self.shapes[shape as usize].described as usize
    }

    /// Returns the material of a primitive.
    #[inline]
    pub fn material(&self, id: PrimitiveId) -> &Material {
        &self.materials[self.shapes[id.shape as usize].material as usize]
    }

    /// Returns the BSDF of the side that is seen; `None` if that side absorbs everything.
    #[inline]
    pub fn bsdf_of_side<E: Effects>(&self, at: &Interaction<E>) -> Option<Cow<'_, Bsdf>> {
        (!self.is_absorbing_side::<E>(at)).then(|| self.bsdf::<E>(at))
    }

    /// Whether an interaction is on the back of a one-sided surface.
    #[inline]
    pub fn is_absorbing_side<E: Effects>(&self, at: &Interaction<E>) -> bool {
        E::OneSided::ON && at.is_behind() && self.material(at.id).is_one_sided()
    }

    /// Returns the BSDF at an interaction, whichever side is seen.
    #[inline]
    pub fn bsdf<E: Effects>(&self, at: &Interaction<E>) -> Cow<'_, Bsdf> {
        self.material(at.id).bsdf::<E>(at.uv.or(Vec2::ZERO))
    }
}
