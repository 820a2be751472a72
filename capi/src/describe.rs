//! What a scene consists of, as C structures, and what they mean.
//!
//! Measure: world units; degrees; radiance in W m^-2 sr^-1, intensity in W/sr, irradiance in W/m^2.
//! Range: as docs/scene-format.md says of the keys of the same names; what zeros stand for is said at each field.
//! Source: docs/scene-format.md.

use crate::memory::{Plain, Versioned, not_null, read_list, read_struct, text};
use crate::status::Failure;
use renderer::geometry::texture::Texture;
use renderer::image::Image;
use renderer::math::rgb::Rgb;
use renderer::math::vec::{DAffine3, DMat3, DVec2, DVec3};
use renderer::scene::description::{
    CameraDescription, ColourDescription, FilmDescription, FilterDescription, FilterKind,
    GeometryDescription, InstanceDescription, LightDescription, LightModel, MaterialDescription,
    MaterialModel, MeshDescription, Place, ShapeDescription,
};
use std::ffi::{c_char, c_void};
use std::sync::Arc;

/// A perspective camera.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdCamera {
    /// sizeof(EtdCamera)
    pub struct_size: usize,
    /// Where it is.
    pub eye: [f64; 3],
    /// What it looks at.
    pub target: [f64; 3],
    /// What is up; all zeros stand for y.
    pub up: [f64; 3],
    /// Vertical field of view in degrees, below 180; 0 stands for 40.
    pub fov: f64,
    /// Radius of the lens; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane in focus; 0 stands for that of the target.
    pub focus_distance: f64,
}

/// Reconstruction filters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdFilter {
    /// A bell.
    Gaussian = 0,
    /// The same weight everywhere.
    Box = 1,
    /// A triangle.
    Tent = 2,
    /// Mitchell and Netravali's, with lobes below 0.
    Mitchell = 3,
    /// Blackman and Harris's.
    BlackmanHarris = 4,
}

/// The picture.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdFilm {
    /// sizeof(EtdFilm)
    pub struct_size: usize,
    /// Pixels in a row, from 1 to 65536.
    pub width: u32,
    /// Rows, from 1 to 65536.
    pub height: u32,
    /// The reconstruction filter, an `EtdFilter`.
    pub filter: i32,
    /// Its radius in pixels, up to 32; 0 stands for the filter's own.
    pub filter_radius: f64,
}

/// A picture in the caller's memory, which is copied.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdImage {
    /// sizeof(EtdImage)
    pub struct_size: usize,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel, linear Rec. 709, row by row from the top.
    pub rgb: *const f32,
    /// Bytes from one pixel to the next; 0 stands for three floats without a gap.
    pub pixel_stride: usize,
    /// Multiplies every value; 0 stands for 1.
    pub scale: f32,
}

/// How a material scatters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdModel {
    /// Lambert: `color`.
    Diffuse = 0,
    /// A perfect mirror: `color`.
    Mirror = 1,
    /// Metal: `eta`, `k`, `roughness`.
    Conductor = 2,
    /// Glass and water: `ior`, `roughness`, and `color` as the tint of what is refracted.
    Dielectric = 3,
    /// A highlight over a matte part: `color`, `specular`, `exponent`.
    Phong = 4,
    /// A matte base under a clear coat: `color`, `ior`, `roughness`.
    Plastic = 5,
    /// The metallic-roughness model: `color`, `metallic`, `roughness`, `ior`, `transmission`.
    Principled = 6,
}

/// A material. Fields that its model does not name are not looked at.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdMaterial {
    /// sizeof(EtdMaterial)
    pub struct_size: usize,
    /// For messages; may be null.
    pub name: *const c_char,
    /// An `EtdModel`.
    pub model: i32,
    /// The share of light that is sent on, from 0 to 1 in each channel.
    pub color: [f32; 3],
    /// In place of `color`, by the texture coordinates of the shape; null for none.
    pub texture: *const EtdImage,
    /// The highlight's share; with `color` at most 1.
    pub specular: [f32; 3],
    /// The highlight's power of the cosine, up to 1e6.
    pub exponent: f32,
    /// From 0, smooth, to 1.
    pub roughness: f32,
    /// Refractive index, inside over outside; 0 stands for 1.5.
    pub ior: f32,
    /// From 0 to 1.
    pub metallic: f32,
    /// From 0 to 1.
    pub transmission: f32,
    /// Real part of a metal's refractive index, above 0.
    pub eta: [f32; 3],
    /// Imaginary part of it.
    pub k: [f32; 3],
    /// Other than 0: the back absorbs everything.
    pub one_sided: u32,
}

/// What a shape has beside its form.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdSurface {
    /// sizeof(EtdSurface)
    pub struct_size: usize,
    /// For messages; may be null.
    pub name: *const c_char,
    /// The material, as `etd_scene_add_material` numbers them.
    pub material: u32,
    /// The group that the shape belongs to, as `etd_scene_add_group` numbers them; 0 stands in the world itself.
    pub group: u32,
    /// Emitted radiance; all zeros do not emit.
    pub emission: [f32; 3],
    /// Other than 0: both sides emit, else the side that the geometric normal points to.
    pub two_sided_emission: u32,
    /// Shape to world, or to its group: the three upper rows of a matrix, row by row, 12 numbers; null leaves the shape as it is.
    pub transform: *const f64,
}

/// Kinds of numbers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdFormat {
    /// 32-bit floats.
    Float32 = 0,
    /// 64-bit floats.
    Float64 = 1,
}

/// Triangles with shared vertices, in the caller's memory, which is copied. Strides are bytes from one item to the next; 0 stands
/// for items without a gap. Addresses need no alignment.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdMesh {
    /// sizeof(EtdMesh)
    pub struct_size: usize,
    /// x, y and z of each vertex.
    pub positions: *const c_void,
    /// Vertices, below 2^32.
    pub vertex_count: usize,
    /// Bytes from one position to the next.
    pub position_stride: usize,
    /// An `EtdFormat`, of positions alone: other numbers are 32-bit floats.
    pub position_format: i32,
    /// A shading normal for each vertex, of any length; null for none.
    pub normals: *const f32,
    /// Bytes from one normal to the next.
    pub normal_stride: usize,
    /// u and v of each vertex, v up; null for none.
    pub uvs: *const f32,
    /// Bytes from one texture coordinate to the next.
    pub uv_stride: usize,
    /// Three vertices of each triangle; the geometric normal is (b - a) x (c - a).
    pub indices: *const u32,
    /// Triangles, below 2^32.
    pub triangle_count: usize,
    /// Bytes from one triangle to the next.
    pub index_stride: usize,
}

/// A group of shapes, placed once more.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdInstance {
    /// sizeof(EtdInstance)
    pub struct_size: usize,
    /// For messages; may be null.
    pub name: *const c_char,
    /// The group that is placed, as `etd_scene_add_group` numbers them.
    pub of: u32,
    /// The group that the instance belongs to; 0 stands in the world itself.
    pub group: u32,
    /// Group to world, or to the group that the instance belongs to: 12 numbers, row by row; null leaves it where it is.
    pub transform: *const f64,
}

/// Lights that are no shapes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdLightKind {
    /// Light from everywhere beyond the scene: `value` is radiance, or `panorama`.
    Environment = 0,
    /// A point: `value` is intensity, `position`.
    Point = 1,
    /// A point that shines into a cone: as a point, with `target`, `cone`, `penumbra`.
    Spot = 2,
    /// Parallel light: `value` is irradiance, `direction`.
    Distant = 3,
}

/// A light that is no shape. Fields that its kind does not name are not looked at.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdLight {
    /// sizeof(EtdLight)
    pub struct_size: usize,
    /// An `EtdLightKind`.
    pub kind: i32,
    /// Radiance, intensity or irradiance, at least 0.
    pub value: [f32; 3],
    /// In place of `value`, all around: its middle is seen along -z, its right half towards +x, its top along +y; null for
    /// none.
    pub panorama: *const EtdImage,
    /// Where the light is.
    pub position: [f64; 3],
    /// Where a spot points.
    pub target: [f64; 3],
    /// Where distant light goes.
    pub direction: [f64; 3],
    /// Angle from a spot's axis to its edge in degrees, up to 180.
    pub cone: f64,
    /// The outer part of that angle over which a spot falls off, in degrees.
    pub penumbra: f64,
}

macro_rules! versioned {
    ($($name:ident),*) => {$(
        // SAFETY: numbers and pointers, of which zeros are values.
        unsafe impl Versioned for $name {
            const NAME: &'static str = stringify!($name);
        }
    )*};
}

versioned!(
    EtdCamera,
    EtdFilm,
    EtdImage,
    EtdMaterial,
    EtdSurface,
    EtdMesh,
    EtdInstance,
    EtdLight
);

impl EtdCamera {
    pub fn describe(&self) -> Result<CameraDescription, Failure> {
        let [eye, target, up] = [self.eye, self.target, self.up].map(DVec3::from_array);
        let up = if up == DVec3::ZERO { DVec3::Y } else { up };
        let fov = if self.fov == 0.0 { 40.0 } else { self.fov };
        let mut camera = CameraDescription::look_at(eye, target, up, fov.to_radians())?;
        camera.lens_radius = self.lens_radius;
        if self.focus_distance != 0.0 {
            camera.focus_distance = self.focus_distance;
        }
        Ok(camera)
    }
}

impl EtdFilm {
    pub fn describe(&self) -> Result<FilmDescription, Failure> {
        const KINDS: &[(i32, FilterKind)] = &[
            (EtdFilter::Gaussian as i32, FilterKind::Gaussian),
            (EtdFilter::Box as i32, FilterKind::Box),
            (EtdFilter::Tent as i32, FilterKind::Tent),
            (EtdFilter::Mitchell as i32, FilterKind::Mitchell),
            (EtdFilter::BlackmanHarris as i32, FilterKind::BlackmanHarris),
        ];
        let kind = choice(self.filter, KINDS, "filter")?;
        let radius = if self.filter_radius == 0.0 {
            kind.default_radius()
        } else {
            self.filter_radius
        };
        Ok(FilmDescription {
            size: (self.width, self.height),
            filter: FilterDescription { kind, radius },
        })
    }
}

impl EtdMaterial {
    /// # Safety
    /// Its pointers are null, or what they point to is there.
    pub unsafe fn describe(&self) -> Result<MaterialDescription, Failure> {
        // SAFETY: the caller's promise.
        let name = unsafe { text(self.name, "name") }?.unwrap_or("material");
        let color = if self.texture.is_null() {
            Rgb::from(self.color).into()
        } else {
            // SAFETY: as above.
            ColourDescription::Texture(unsafe { texture(self.texture) }?)
        };
        let roughness = self.roughness;
        let ior = if self.ior == 0.0 { 1.5 } else { self.ior };
        const MODELS: &[(i32, EtdModel)] = &[
            (EtdModel::Diffuse as i32, EtdModel::Diffuse),
            (EtdModel::Mirror as i32, EtdModel::Mirror),
            (EtdModel::Conductor as i32, EtdModel::Conductor),
            (EtdModel::Dielectric as i32, EtdModel::Dielectric),
            (EtdModel::Phong as i32, EtdModel::Phong),
            (EtdModel::Plastic as i32, EtdModel::Plastic),
            (EtdModel::Principled as i32, EtdModel::Principled),
        ];
        let model = match choice(self.model, MODELS, "model")? {
            EtdModel::Diffuse => MaterialModel::Diffuse { reflectance: color },
            EtdModel::Mirror => MaterialModel::Mirror { reflectance: color },
            EtdModel::Conductor => MaterialModel::Conductor {
                eta: self.eta.into(),
                k: self.k.into(),
                roughness,
            },
            EtdModel::Dielectric => MaterialModel::Dielectric {
                ior,
                roughness,
                tint: color,
            },
            EtdModel::Phong => MaterialModel::Phong {
                diffuse: color,
                specular: Rgb::from(self.specular).into(),
                exponent: self.exponent,
            },
            EtdModel::Plastic => MaterialModel::Plastic {
                reflectance: color,
                ior,
                roughness,
            },
            EtdModel::Principled => MaterialModel::Principled {
                base_color: color,
                metallic: self.metallic,
                roughness,
                ior,
                transmission: self.transmission,
            },
        };
        Ok(MaterialDescription {
            two_sided: self.one_sided == 0,
            ..MaterialDescription::new(name, Place::default(), model)
        })
    }
}

impl EtdSurface {
    /// A shape of this form.
    ///
    /// # Safety
    /// Its pointers are null, or what they point to is there.
    pub unsafe fn describe(
        &self,
        geometry: GeometryDescription,
    ) -> Result<ShapeDescription, Failure> {
        // SAFETY: the caller's promise.
        let name = unsafe { text(self.name, "name") }?.unwrap_or("shape");
        let emission = Rgb::from(self.emission);
        Ok(ShapeDescription {
            material: self.material as usize,
            group: group(self.group),
            emission: (!emission.is_black()).then(|| emission.into()),
            two_sided_emission: self.two_sided_emission != 0,
            // SAFETY: as above.
            transform: unsafe { transform(self.transform) }?,
            ..ShapeDescription::new(name, Place::default(), geometry)
        })
    }
}

impl EtdMesh {
    /// # Safety
    /// Its pointers are null, or what they point to is there.
    pub unsafe fn describe(&self) -> Result<MeshDescription, Failure> {
        let count = self.vertex_count;
        if u32::try_from(count).is_err() || u32::try_from(self.triangle_count).is_err() {
            return Err(Failure::argument(
                "a mesh has fewer than 2^32 vertices and triangles",
            ));
        }
        const FORMATS: &[(i32, EtdFormat)] = &[
            (EtdFormat::Float32 as i32, EtdFormat::Float32),
            (EtdFormat::Float64 as i32, EtdFormat::Float64),
        ];
        let single = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let stride = self.position_stride;
        // SAFETY: all lists are there by the caller's promise.
        unsafe {
            Ok(MeshDescription {
                positions: match choice(self.position_format, FORMATS, "position_format")? {
                    EtdFormat::Float32 => list(self.positions, count, stride, "positions", single)?,
                    EtdFormat::Float64 => {
                        let double = DVec3::from_array;
                        list(self.positions, count, stride, "positions", double)?
                    }
                },
                normals: optional(self.normals, count, self.normal_stride, "normals", single)?,
                uvs: optional(self.uvs, count, self.uv_stride, "uvs", |uv: [f32; 2]| {
                    DVec2::from_array(uv.map(f64::from))
                })?,
                indices: read_list(
                    self.indices.cast(),
                    self.triangle_count,
                    self.index_stride,
                    "indices",
                )?,
            })
        }
    }
}

impl EtdInstance {
    /// # Safety
    /// Its pointers are null, or what they point to is there.
    pub unsafe fn describe(&self) -> Result<InstanceDescription, Failure> {
        let Some(of) = group(self.of) else {
            return Err(Failure::argument(
                "of: expected a group, which are numbered from 1",
            ));
        };
        // SAFETY: the caller's promise.
        let name = unsafe { text(self.name, "name") }?.unwrap_or("instance");
        Ok(InstanceDescription {
            name: name.to_owned(),
            place: Place::default(),
            of,
            group: group(self.group),
            // SAFETY: as above.
            transform: unsafe { transform(self.transform) }?,
            motion: vec![],
        })
    }
}

impl EtdLight {
    /// # Safety
    /// Its pointers are null, or what they point to is there.
    pub unsafe fn describe(&self) -> Result<LightDescription, Failure> {
        const KINDS: &[(i32, EtdLightKind)] = &[
            (EtdLightKind::Environment as i32, EtdLightKind::Environment),
            (EtdLightKind::Point as i32, EtdLightKind::Point),
            (EtdLightKind::Spot as i32, EtdLightKind::Spot),
            (EtdLightKind::Distant as i32, EtdLightKind::Distant),
        ];
        let value = Rgb::from(self.value);
        let position = DVec3::from_array(self.position);
        let model = match choice(self.kind, KINDS, "kind")? {
            EtdLightKind::Environment => LightModel::Environment {
                radiance: if self.panorama.is_null() {
                    value.into()
                } else {
                    // SAFETY: the caller's promise.
                    ColourDescription::Texture(unsafe { texture(self.panorama) }?)
                },
                to_world: DMat3::IDENTITY,
            },
            EtdLightKind::Point => LightModel::Point {
                position,
                intensity: value,
            },
            EtdLightKind::Spot => LightModel::Spot {
                position,
                target: DVec3::from_array(self.target),
                intensity: value,
                cone: self.cone.to_radians(),
                penumbra: self.penumbra.to_radians(),
            },
            EtdLightKind::Distant => LightModel::Distant {
                direction: DVec3::from_array(self.direction),
                irradiance: value,
            },
        };
        Ok(LightDescription {
            place: Place::default(),
            model,
        })
    }
}

/// A choice by its number.
pub fn choice<T: Copy>(number: i32, all: &[(i32, T)], what: &str) -> Result<T, Failure> {
    let found = all.iter().find(|(known, _)| *known == number);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        Failure::argument(format!(
            "{what}: {number}, but there are 0 to {}",
            all.len() - 1
        ))
    })
}

/// The index of a group: they are numbered from 1.
fn group(number: u32) -> Option<usize> {
    number.checked_sub(1).map(|index| index as usize)
}

/// Three rows of four numbers; null changes nothing.
///
/// # Safety
/// The pointer is null, or the numbers are there.
pub unsafe fn transform(rows: *const f64) -> Result<DAffine3, Failure> {
    if rows.is_null() {
        return Ok(DAffine3::IDENTITY);
    }
    // SAFETY: the caller's promise.
    let m: Vec<[f64; 4]> = unsafe { read_list(rows.cast(), 3, 0, "transform") }?;
    let column = |c: usize| DVec3::new(m[0][c], m[1][c], m[2][c]);
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    })
}

/// Three numbers.
///
/// # Safety
/// The pointer is null, or they are there.
pub unsafe fn vec3(pointer: *const f64, what: &str) -> Result<DVec3, Failure> {
    // SAFETY: the caller's promise.
    let read: Vec<[f64; 3]> = unsafe { read_list(pointer.cast(), 1, 0, what) }?;
    Ok(DVec3::from_array(read[0]))
}

/// # Safety
/// The pointer is null, or all items are there.
unsafe fn list<T: Plain, U>(
    pointer: *const c_void,
    count: usize,
    stride: usize,
    what: &str,
    convert: impl Fn(T) -> U,
) -> Result<Vec<U>, Failure> {
    // SAFETY: the caller's promise.
    let read: Vec<T> = unsafe { read_list(pointer, count, stride, what) }?;
    let mut items = crate::memory::room(count, what)?;
    items.extend(read.into_iter().map(convert));
    Ok(items)
}

/// The same, where null stands for none.
///
/// # Safety
/// As [`list`].
unsafe fn optional<T: Plain, U>(
    pointer: *const f32,
    count: usize,
    stride: usize,
    what: &str,
    convert: impl Fn(T) -> U,
) -> Result<Vec<U>, Failure> {
    if pointer.is_null() {
        return Ok(vec![]);
    }
    // SAFETY: the caller's promise.
    unsafe { list(pointer.cast(), count, stride, what, convert) }
}

/// A copy of a picture.
///
/// # Safety
/// The pointer is null, or the structure and what it points to are there.
unsafe fn texture(pointer: *const EtdImage) -> Result<Arc<Texture>, Failure> {
    // SAFETY: the caller's promise.
    let image = unsafe { read_struct(pointer) }?;
    let (width, height) = (image.width as usize, image.height as usize);
    let is_side = |side| (1..=renderer::image::MAX_SIDE).contains(&side);
    if !(is_side(width) && is_side(height)) {
        return Err(Failure::argument(format!(
            "EtdImage: {width} x {height} pixels, but there are 1 to 65536 on each side"
        )));
    }
    not_null(image.rgb, "EtdImage: rgb")?;
    let stride = image.pixel_stride;
    // SAFETY: as above.
    let pixels: Vec<[f32; 3]> =
        unsafe { read_list(image.rgb.cast(), width * height, stride, "rgb") }?;
    let mut colours = crate::memory::room(pixels.len(), "rgb")?;
    colours.extend(pixels.into_iter().map(Rgb::from));
    Ok(Arc::new(Texture::Image {
        image: Arc::new(Image::new(image.width, image.height, colours)),
        scale: if image.scale == 0.0 { 1.0 } else { image.scale },
    }))
}
