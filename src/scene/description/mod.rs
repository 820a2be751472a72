//! A scene as it was written: nothing derived, nothing rounded, every object with the place it came from.
//!
//! Measure: world units and radians, radiance in W m^-2 sr^-1; double precision.
//! Range: what `load` lets through: every number finite, every index in range, every reflectance in [0, 1].
//! Source: docs/scene-format.md. Tested through `load` and in `cli/tests/command/bad_input.rs`.

mod light;
mod material;

use crate::error::{Error, Result};
pub use crate::film::filter::{FilterDescription, FilterKind};
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::transform::look_at;
use crate::math::vec::{DAffine3, DVec2, DVec3};
pub use light::{LightDescription, LightModel};
pub use material::{MaterialDescription, MaterialModel, NormalMapDescription};
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
    /// All shapes, those of groups among them.
    pub shapes: Vec<ShapeDescription>,
    /// The names of all groups; shapes and instances refer to them by index.
    pub groups: Vec<String>,
    /// Where groups are placed.
    pub instances: Vec<InstanceDescription>,
    /// Lights that are no shapes.
    pub lights: Vec<LightDescription>,
    /// What the loader decided or repaired, for the user to know: one sentence each.
    pub notes: Vec<String>,
}

impl SceneDescription {
    /// An empty scene of a black world.
    pub fn new(file: impl Into<PathBuf>, camera: CameraDescription) -> Self {
        Self {
            file: file.into(),
            camera,
            film: FilmDescription::default(),
            render: RenderDescription::default(),
            materials: vec![],
            shapes: vec![],
            groups: vec![],
            instances: vec![],
            lights: vec![],
            notes: vec![],
        }
    }

    /// The sum of the environments that are the same in all directions.
    pub fn constant_environment(&self) -> Rgb {
        let constants = self.lights.iter().map(|light| match &light.model {
            LightModel::Environment { radiance, .. } => radiance.constant(),
            _ => None,
        });
        constants.flatten().fold(Rgb::BLACK, |sum, sky| sum + sky)
    }
}

/// The place of an object in a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// The line, counted from 1, where known.
    pub line: Option<usize>,
}

impl Place {
    /// An error about what was written there.
    pub fn error(&self, message: impl Into<String>) -> Error {
        let mut error = Error::scene(message);
        // What was made in code stands in no file.
        if !self.file.as_os_str().is_empty() {
            error = error.in_file(&self.file);
        }
        match self.line {
            Some(line) => error.at_line(line),
            None => error,
        }
    }
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
    /// Where it is at which time, in place of `to_world`; empty for a camera that stands still.
    pub motion: Vec<Key>,
    /// When the shutter opens and closes, in the unit of all keys' times.
    pub shutter: [f64; 2],
    /// Where it was written.
    pub place: Place,
}

impl CameraDescription {
    /// A pinhole that stands still.
    pub fn pinhole(to_world: DAffine3, fov: f64) -> Self {
        Self {
            to_world,
            fov,
            lens_radius: 0.0,
            focus_distance: 1.0,
            motion: vec![],
            shutter: [0.0; 2],
            place: Place::default(),
        }
    }

    /// A pinhole at `eye` that looks at `target`, in focus there should it get a lens, with `up` above.
    ///
    /// # Errors
    /// If eye and target are the same point, or `up` is along the line between them.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov: f64) -> Result<Self> {
        let Some(to_world) = look_at(eye, target, up) else {
            return Err(Error::scene(
                "eye and target are the same point, or up is along the line between them",
            )
            .in_field("camera"));
        };
        Ok(Self {
            focus_distance: eye.distance(target),
            ..Self::pinhole(to_world, fov)
        })
    }
}

/// A place at a time, of something that moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// When, in the unit of the camera's shutter; keys are in order.
    pub time: f64,
    /// Where: what is applied after the object's own transform. For a camera: camera to world.
    pub transform: DAffine3,
}

/// The picture.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmDescription {
    /// Width and height in pixels, each at least 1.
    pub size: (u32, u32),
    /// The reconstruction filter.
    pub filter: FilterDescription,
}

impl Default for FilmDescription {
    fn default() -> Self {
        Self {
            size: (768, 512),
            filter: FilterDescription {
                kind: FilterKind::Gaussian,
                radius: FilterKind::Gaussian.default_radius(),
            },
        }
    }
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
    /// The name of a way for paths to end by chance.
    pub roulette: Option<Written<String>>,
    /// The name of a way to give samples out to the pixels.
    pub adaptive: Option<Written<String>>,
    /// How far, in world units, something may be and still count for ambient occlusion; above 0.
    pub occlusion_distance: Option<f64>,
    /// The share of indirect light up to which an irradiance cache may be wrong, from 0 to below 1.
    pub cache_error: Option<f64>,
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

impl ColourDescription {
    /// The colour, if it is the same everywhere.
    pub fn constant(&self) -> Option<Rgb> {
        match self {
            Self::Constant(colour) => Some(*colour),
            Self::Texture(texture) => texture.constant(),
        }
    }

    /// Whether it is black everywhere.
    pub fn is_black(&self) -> bool {
        self.constant().is_some_and(|colour| colour.is_black())
    }
}

impl From<Rgb> for ColourDescription {
    fn from(colour: Rgb) -> Self {
        Self::Constant(colour)
    }
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
    /// Shape to world, or to its group.
    pub transform: DAffine3,
    /// What is applied after the transform, by time; empty for a shape that stands still.
    pub motion: Vec<Key>,
    /// The group that it belongs to, an index into [`SceneDescription::groups`]; `None` stands in the world itself.
    pub group: Option<usize>,
    /// Index into [`SceneDescription::materials`].
    pub material: usize,
    /// Emitted radiance; `None` does not emit.
    pub emission: Option<ColourDescription>,
    /// Whether both sides emit; otherwise the side that the geometric normal points to.
    pub two_sided_emission: bool,
}

/// A group of shapes, placed once more.
#[derive(Debug, Clone)]
pub struct InstanceDescription {
    /// A name for messages.
    pub name: String,
    /// Where it was written.
    pub place: Place,
    /// The group that is placed, an index into [`SceneDescription::groups`].
    pub of: usize,
    /// The group that the instance belongs to; `None` stands in the world itself. Never a circle.
    pub group: Option<usize>,
    /// Group to world, or to the group that the instance belongs to.
    pub transform: DAffine3,
    /// What is applied after the transform, by time; empty for an instance that stands still.
    pub motion: Vec<Key>,
}

impl ShapeDescription {
    /// A shape that does not emit, of the scene's first material, where it was made.
    pub fn new(name: impl Into<String>, place: Place, geometry: GeometryDescription) -> Self {
        Self {
            name: name.into(),
            place,
            geometry,
            transform: DAffine3::IDENTITY,
            motion: vec![],
            group: None,
            material: 0,
            emission: None,
            two_sided_emission: false,
        }
    }
}

/// The forms.
#[derive(Debug, Clone)]
#[non_exhaustive]
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
