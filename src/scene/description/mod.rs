//! The scene description: the content of a scene file, without derived values or rounding, every object with its place
//! in the file.
//!
//! Measure: world units and radians, radiance in W m^-2 sr^-1; double precision.
//! Range: guaranteed by `load`: every number finite, every index in range, every reflectance in [0, 1].
//! Source: docs/scene-format.md. Tested through `load` and in `cli/tests/command/bad_input.rs`.

mod light;
mod material;
mod note;

use crate::error::{Error, Result};
pub use crate::film::filter::{FilterDescription, FilterKind};
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::transform::look_at;
use crate::math::vec::{DAffine3, DVec2, DVec3};
pub use light::{LightDescription, LightModel};
pub use material::{
    BumpMapDescription, ClearCoatDescription, MaterialDescription, MaterialModel,
    NormalMapDescription,
};
pub use note::{Note, NoteKind};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A whole scene.
#[derive(Debug, Clone, Serialize)]
pub struct SceneDescription {
    /// The file that it was read from.
    #[serde(skip)]
    pub file: PathBuf,
    /// The camera.
    pub camera: CameraDescription,
    /// The film: image size and reconstruction filter.
    pub film: FilmDescription,
    /// Render settings from the scene file; command-line flags override them.
    #[serde(skip)]
    pub render: RenderDescription,
    /// All materials; shapes refer to them by index.
    pub materials: Vec<MaterialDescription>,
    /// All shapes, including those of groups.
    pub shapes: Vec<ShapeDescription>,
    /// The names of all groups; shapes and instances refer to them by index.
    pub groups: Vec<String>,
    /// The instances of groups.
    pub instances: Vec<InstanceDescription>,
    /// Lights that are not shapes.
    pub lights: Vec<LightDescription>,
    /// Notes on decisions of the loader, approximations and omissions, to be shown to the user.
    #[serde(skip)]
    pub notes: Vec<Note>,
}

impl SceneDescription {
    /// Returns an empty scene without lights.
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

    /// Returns the sum of the radiances of all constant environments.
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
    /// The line, counted from 1, if known.
    pub line: Option<usize>,
}

impl Place {
    /// The place of what concerns a whole file.
    pub(crate) fn of_file(file: &Path) -> Self {
        Self {
            file: file.to_path_buf(),
            line: None,
        }
    }

    /// A line of a file, counted from 1.
    pub(crate) fn on_line(file: &Path, line: usize) -> Self {
        Self {
            file: file.to_path_buf(),
            line: Some(line),
        }
    }

    /// Returns an error about what was written at this place.
    pub fn error(&self, message: impl Into<String>) -> Error {
        let mut error = Error::scene(message);
        // Objects made in code have no file.
        if !self.file.as_os_str().is_empty() {
            error = error.in_file(&self.file);
        }
        match self.line {
            Some(line) => error.at_line(line),
            None => error,
        }
    }
}

/// A value with its line in the scene file, for errors that are only found after loading.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WithLine<T> {
    /// The value.
    pub value: T,
    /// The line, counted from 1.
    pub line: usize,
}

/// A perspective camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraDescription {
    /// Camera to world: the camera looks along its -z axis, and its y axis is up. Orthonormal.
    pub to_world: DAffine3,
    /// Whether the image is mirrored, left to right.
    pub is_mirrored: bool,
    /// Vertical field of view, in radians, in (0, pi).
    pub fov: f64,
    /// Radius of the lens in world units; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the focal plane along the viewing axis, above 0.
    pub focus_distance: f64,
    /// Keyframes of the camera's transform, which replace `to_world`; empty for a static camera.
    pub motion: Vec<Keyframe>,
    /// Times at which the shutter opens and closes, in the unit of the keyframes' times.
    pub shutter: [f64; 2],
    /// The place in the scene file.
    #[serde(skip)]
    pub place: Place,
}

impl CameraDescription {
    /// Returns a static pinhole camera.
    pub fn pinhole(to_world: DAffine3, fov: f64) -> Self {
        Self {
            to_world,
            is_mirrored: false,
            fov,
            lens_radius: 0.0,
            focus_distance: 1.0,
            motion: vec![],
            shutter: [0.0; 2],
            place: Place::default(),
        }
    }

    /// Returns a pinhole camera at `eye` that looks at `target`, with `up` upwards. The focus distance is that of
    /// `target`.
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

/// A keyframe: a transform at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Keyframe {
    /// The time, in the unit of the camera's shutter; keys are in order of time.
    pub time: f64,
    /// The transform that is applied after the object's own. For a camera: camera to world.
    pub transform: DAffine3,
}

/// The film.
#[derive(Debug, Clone, PartialEq, Serialize)]
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

/// The `[render]` table; every entry is `None` unless written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RenderDescription {
    /// The integrator's name.
    pub integrator: Option<WithLine<String>>,
    /// Samples per pixel, at least 1.
    pub spp: Option<u64>,
    /// The sampler's name.
    pub sampler: Option<WithLine<String>>,
    /// Maximum number of scattering events.
    pub max_bounces: Option<u32>,
    /// The name of the Russian roulette method.
    pub roulette: Option<WithLine<String>>,
    /// The number of light paths for each camera path, by name.
    pub light_paths: Option<WithLine<String>>,
    /// The number of pixels that share their paths, by name.
    pub reuse: Option<WithLine<String>>,
    /// The name of the adaptive sampling method.
    pub adaptive: Option<WithLine<String>>,
    /// Maximum distance, in world units, of occluders for ambient occlusion; above 0.
    pub occlusion_distance: Option<f64>,
    /// Admissible relative error of the irradiance cache, as a fraction of the indirect light, from 0 to below 1.
    pub cache_error: Option<f64>,
    /// The seed.
    pub seed: Option<u64>,
}

/// A colour that may vary over a surface.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub enum ColourDescription {
    /// A constant.
    Constant(Rgb),
    /// A texture, indexed by uv.
    Texture(Arc<Texture>),
}

impl ColourDescription {
    /// Returns the colour if it is constant.
    pub fn constant(&self) -> Option<Rgb> {
        match self {
            Self::Constant(colour) => Some(*colour),
            Self::Texture(texture) => texture.constant(),
        }
    }

    /// Returns the largest value in each channel.
    pub(crate) fn brightest(&self) -> Rgb {
        match self {
            Self::Constant(colour) => *colour,
            Self::Texture(texture) => texture.brightest(),
        }
    }

    /// Whether the colour is black everywhere.
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
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct ShapeDescription {
    /// A name for messages, such as that of the OBJ group.
    #[serde(skip)]
    pub name: String,
    /// The place in the scene file.
    #[serde(skip)]
    pub place: Place,
    /// The geometry, before the transform.
    pub geometry: GeometryDescription,
    /// Shape to world, or to the shape's group.
    pub transform: DAffine3,
    /// Keyframes of what is applied after the transform; empty for a static shape.
    pub motion: Vec<Keyframe>,
    /// The group that contains it, an index into [`SceneDescription::groups`]; `None` for the world itself.
    pub group: Option<usize>,
    /// Index into [`SceneDescription::materials`].
    pub material: usize,
    /// Emitted radiance; `None` if it does not emit.
    pub emission: Option<ColourDescription>,
    /// Whether both sides emit; otherwise only the side of the geometric normal.
    pub two_sided_emission: bool,
}

/// An instance of a group.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct InstanceDescription {
    /// A name for messages.
    #[serde(skip)]
    pub name: String,
    /// The place in the scene file.
    #[serde(skip)]
    pub place: Place,
    /// The instanced group, an index into [`SceneDescription::groups`].
    pub of: usize,
    /// The group that contains the instance; `None` for the world itself. Never cyclic.
    pub group: Option<usize>,
    /// Group to world, or to the group that contains the instance.
    pub transform: DAffine3,
    /// Keyframes of what is applied after the transform; empty for a static instance.
    pub motion: Vec<Keyframe>,
}

impl ShapeDescription {
    /// Returns a shape that does not emit, with the scene's first material and an identity transform.
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

/// The geometry types.
#[derive(Debug, Clone, Serialize, PartialEq)]
#[non_exhaustive]
pub enum GeometryDescription {
    /// A triangle mesh.
    Mesh(Arc<MeshDescription>),
    /// A sphere; its normal points outwards. Its transform must scale uniformly.
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
        /// The edge from the corner to a neighbouring corner.
        edge_u: DVec3,
        /// The edge from the corner to the other neighbouring corner.
        edge_v: DVec3,
    },
    /// A disk.
    Disk {
        /// Centre.
        center: DVec3,
        /// Normal, of any length but 0.
        normal: DVec3,
        /// Radius, above 0.
        radius: f64,
    },
    /// An axis-aligned box in object space; its normals point outwards.
    Box {
        /// Minimum corner.
        min: DVec3,
        /// Maximum corner.
        max: DVec3,
    },
}

/// A triangle mesh with shared vertices.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct MeshDescription {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Shading normals, one per vertex, of any length; or empty.
    pub normals: Vec<DVec3>,
    /// Texture coordinates, one per vertex; or empty. v points up.
    pub uvs: Vec<DVec2>,
    /// Three vertex indices per triangle; the geometric normal is (b - a) x (c - a).
    pub indices: Vec<[u32; 3]>,
}
