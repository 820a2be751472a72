//! A scene as it was written: nothing derived, nothing rounded, every object with the place it came from.
//!
//! Measure: world units and radians, radiance in W m^-2 sr^-1; double precision.
//! Range: what `load` lets through: every number finite, every index in range, every reflectance in [0, 1].
//! Source: docs/scene-format.md. Tested through `load` and in `tests/bad_input.rs`.

pub use crate::film::filter::{FilterDescription, FilterKind};
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DVec2, DVec3};
use std::path::PathBuf;
use std::sync::Arc;

/// A whole scene.
#[derive(Debug, Clone)]
pub struct SceneDescription {
    /// The file it was read from.
    pub file: PathBuf,
    /// Where it is seen from.
    pub camera: CameraDescription,
    /// The picture to make.
    pub film: FilmDescription,
    /// What the scene asks of the renderer; flags override it.
    pub render: RenderDescription,
    /// All materials; shapes refer to them by index.
    pub materials: Vec<MaterialDescription>,
    /// All shapes.
    pub shapes: Vec<ShapeDescription>,
    /// Radiance that arrives from everywhere beyond the scene; black without an environment light.
    pub environment: Rgb,
    /// What the loader decided or repaired, for the user to know: one sentence each.
    pub notes: Vec<String>,
}

/// The place of an object in a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// The line, counted from 1, where known.
    pub line: Option<usize>,
}

/// A value with its place in the scene's file, for errors that only a later floor can find.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written<T> {
    /// The value.
    pub value: T,
    /// The line, counted from 1.
    pub line: usize,
}

/// A perspective camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraDescription {
    /// Camera to world: the camera looks along its -z, its y is up. Orthonormal.
    pub to_world: DAffine3,
    /// Vertical field of view, in radians, in (0, pi).
    pub fov: f64,
    /// Radius of the lens in world units; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane in focus along the viewing axis, above 0.
    pub focus_distance: f64,
}

/// The picture.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmDescription {
    /// Width and height in pixels, each at least 1.
    pub size: (u32, u32),
    /// The reconstruction filter.
    pub filter: FilterDescription,
}

/// The `[render]` table: every entry absent unless written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RenderDescription {
    /// The integrator's name.
    pub integrator: Option<Written<String>>,
    /// Samples per pixel, at least 1.
    pub spp: Option<u64>,
    /// The sampler's name.
    pub sampler: Option<Written<String>>,
    /// Scattering events at most.
    pub max_bounces: Option<u32>,
    /// The seed.
    pub seed: Option<u64>,
}

/// A colour that may vary over a surface.
#[derive(Debug, Clone)]
pub enum ColourDescription {
    /// The same everywhere.
    Constant(Rgb),
    /// Looked up by uv.
    Texture(Arc<Texture>),
}

/// A named material.
#[derive(Debug, Clone)]
pub struct MaterialDescription {
    /// Its name, unique among the materials of its file.
    pub name: String,
    /// Where it was defined.
    pub place: Place,
    /// How it scatters.
    pub model: MaterialModel,
}

/// The scattering models. Roughness is perceptual, in [0, 1]: the microfacet alpha is its square.
#[derive(Debug, Clone)]
pub enum MaterialModel {
    /// Lambert.
    Diffuse {
        /// Albedo.
        reflectance: ColourDescription,
    },
    /// A perfect mirror.
    Mirror {
        /// The share that it reflects.
        reflectance: ColourDescription,
    },
    /// Metal with a complex refractive index.
    Conductor {
        /// Real part of the index, per channel, above 0.
        eta: Rgb,
        /// Imaginary part, per channel, at least 0.
        k: Rgb,
        /// Roughness; 0 is smooth.
        roughness: f32,
    },
    /// Glass and water.
    Dielectric {
        /// Refractive index, inside over outside, above 0.
        ior: f32,
        /// Roughness; 0 is smooth.
        roughness: f32,
        /// Multiplies what is refracted.
        tint: ColourDescription,
    },
    /// The metallic-roughness model of glTF, with refraction.
    Principled {
        /// Albedo of the base, reflectance of the metal, tint of the glass.
        base_color: ColourDescription,
        /// 0 is dielectric, 1 is metal.
        metallic: f32,
        /// Roughness; 0 is smooth.
        roughness: f32,
        /// Refractive index of the dielectric, at least 1.
        ior: f32,
        /// The share of the dielectric's base that refracts instead of scattering.
        transmission: f32,
    },
}

/// One shape with one material.
#[derive(Debug, Clone)]
pub struct ShapeDescription {
    /// A name for messages, such as the OBJ group's.
    pub name: String,
    /// Where it was written.
    pub place: Place,
    /// Its form, before the transform.
    pub geometry: GeometryDescription,
    /// Shape to world.
    pub transform: DAffine3,
    /// Index into [`SceneDescription::materials`].
    pub material: usize,
    /// Emitted radiance; `None` does not emit.
    pub emission: Option<Rgb>,
    /// Whether both sides emit; otherwise the side that the geometric normal points to.
    pub two_sided_emission: bool,
}

/// The forms.
#[derive(Debug, Clone)]
pub enum GeometryDescription {
    /// Triangles.
    Mesh(Arc<MeshDescription>),
    /// A sphere; its normal points outwards. Its transform may not stretch it unevenly.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius, above 0.
        radius: f64,
    },
    /// A parallelogram; its normal is edge_u x edge_v.
    Rectangle {
        /// One corner.
        corner: DVec3,
        /// From the corner to the next one.
        edge_u: DVec3,
        /// From the corner to the other next one.
        edge_v: DVec3,
    },
    /// A flat disk.
    Disk {
        /// Centre.
        center: DVec3,
        /// Normal, of any length but 0.
        normal: DVec3,
        /// Radius, above 0.
        radius: f64,
    },
    /// An axis-aligned box; its normals point outwards.
    Box {
        /// Lowest corner.
        min: DVec3,
        /// Highest corner.
        max: DVec3,
    },
}

/// Triangles with shared vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshDescription {
    /// Vertices.
    pub positions: Vec<DVec3>,
    /// A shading normal for each vertex, of any length; or none at all.
    pub normals: Vec<DVec3>,
    /// A texture coordinate for each vertex; or none at all. v points up.
    pub uvs: Vec<DVec2>,
    /// Three vertices a triangle; the geometric normal is (b - a) x (c - a).
    pub indices: Vec<[u32; 3]>,
}
