//! Attributes of shapes besides their geometry, instances of groups, and keyframes.
//!
//! Measure: world units; times in the unit of the camera's shutter.
//! Range: as docs/scene-format.md says of `[[shape]]`, `[[instance]]` and motion.
//! Source: docs/scene-format.md.

use super::image::{EtdImage, texture_or};
use crate::memory::{Plain, Versioned, read_list, text};
use crate::status::Failure;
use renderer::description::{
    GeometryDescription, InstanceDescription, Keyframe, Place, ShapeDescription,
};
use renderer::vec::{DAffine3, DMat3, DVec3};
use std::ffi::c_char;
use std::mem::offset_of;

/// A keyframe of a shape or an instance. Between two keyframes, translation and scale are interpolated linearly, and
/// rotations at constant speed, the shorter way; before the first and after the last one, the transform is constant.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdKey {
    /// The time, in the unit of the camera's shutter; later than that of the previous keyframe.
    pub time: f64,
    /// The transform that is applied after the object's own `transform`: 12 numbers, row by row.
    pub transform: [f64; 12],
}

/// Attributes of a shape besides its geometry.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdSurface {
    /// sizeof(EtdSurface)
    pub struct_size: usize,
    /// Name for messages; may be null.
    pub name: *const c_char,
    /// The material, as numbered by `etd_scene_add_material`.
    pub material: u32,
    /// The group that contains the shape, as numbered by `etd_scene_add_group`; 0 for the world itself.
    pub group: u32,
    /// Emitted radiance; the shape does not emit if all are zero.
    pub emission: [f32; 3],
    /// Other than 0: both sides emit; 0: only the side of the geometric normal.
    pub two_sided_emission: u32,
    /// Shape to world, or to its group: the three upper rows of a matrix, row by row, 12 numbers; null for the identity.
    pub transform: *const f64,
    /// Replaces `emission`, indexed by the texture coordinates of the shape; null for none.
    pub emission_texture: *const EtdImage,
    /// Keyframes; null for a static shape. The shape moves while the camera's shutter is open.
    pub motion: *const EtdKey,
    /// Number of keyframes, which are in order of time.
    pub motion_count: usize,
    /// Bytes from one keyframe to the next; 0 stands for no gap.
    pub motion_stride: usize,
}

/// An instance of a group.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdInstance {
    /// sizeof(EtdInstance)
    pub struct_size: usize,
    /// Name for messages; may be null.
    pub name: *const c_char,
    /// The instanced group, as numbered by `etd_scene_add_group`.
    pub of: u32,
    /// The group that contains the instance; 0 for the world itself.
    pub group: u32,
    /// Group to world, or to the group that contains the instance: 12 numbers, row by row; null for the identity.
    pub transform: *const f64,
    /// Keyframes; null for a static instance. The instance moves while the camera's shutter is open.
    pub motion: *const EtdKey,
    /// Number of keyframes, which are in order of time.
    pub motion_count: usize,
    /// Bytes from one keyframe to the next; 0 stands for no gap.
    pub motion_stride: usize,
}

// SAFETY: numbers without padding.
unsafe impl Plain for EtdKey {}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdSurface {
    const NAME: &'static str = "EtdSurface";
    const FIRST_SIZE: usize = offset_of!(EtdSurface, emission_texture);
}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdInstance {
    const NAME: &'static str = "EtdInstance";
    const FIRST_SIZE: usize = offset_of!(EtdInstance, motion);
}

impl EtdSurface {
    /// Returns the description of a shape with this geometry.
    ///
    /// # Safety
    /// Its pointers are null, or valid.
    pub unsafe fn describe(
        &self,
        geometry: GeometryDescription,
    ) -> Result<ShapeDescription, Failure> {
        // SAFETY: the caller's promise.
        let name = unsafe { text(self.name, "name") }?.unwrap_or("shape");
        // SAFETY: as above.
        let emission = unsafe { texture_or(self.emission_texture, self.emission.into()) }?;
        Ok(ShapeDescription {
            material: self.material as usize,
            group: group(self.group),
            emission: (!emission.is_black()).then_some(emission),
            two_sided_emission: self.two_sided_emission != 0,
            // SAFETY: as above.
            transform: unsafe { transform(self.transform) }?,
            // SAFETY: as above.
            motion: unsafe { motion(self.motion, self.motion_count, self.motion_stride) }?,
            ..ShapeDescription::new(name, Place::default(), geometry)
        })
    }
}

impl EtdInstance {
    /// # Safety
    /// Its pointers are null, or valid.
    pub unsafe fn describe(&self) -> Result<InstanceDescription, Failure> {
        let Some(of) = group(self.of) else {
            return Err(Failure::argument(
                "of: expected the number of a group, from 1",
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
            // SAFETY: as above.
            motion: unsafe { motion(self.motion, self.motion_count, self.motion_stride) }?,
        })
    }
}

/// Converts the number of a group, counted from 1, to its index; `None` for the world.
fn group(number: u32) -> Option<usize> {
    number.checked_sub(1).map(|index| index as usize)
}

/// Converts three rows of four numbers to a transform.
pub fn affine(rows: &[f64; 12]) -> DAffine3 {
    let column = |c: usize| DVec3::new(rows[c], rows[4 + c], rows[8 + c]);
    DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    }
}

/// Reads a transform of the caller; null stands for the identity.
///
/// # Safety
/// The pointer is null, or 12 numbers may be read.
pub unsafe fn transform(rows: *const f64) -> Result<DAffine3, Failure> {
    if rows.is_null() {
        return Ok(DAffine3::IDENTITY);
    }
    // SAFETY: the caller's promise.
    let rows: Vec<[f64; 12]> = unsafe { read_list(rows.cast(), 1, 0, "transform") }?;
    Ok(affine(&rows[0]))
}

/// # Safety
/// The pointer is null, or all keyframes may be read.
unsafe fn motion(
    keys: *const EtdKey,
    count: usize,
    stride: usize,
) -> Result<Vec<Keyframe>, Failure> {
    // SAFETY: the caller's promise.
    let keys: Vec<EtdKey> = unsafe { read_list(keys.cast(), count, stride, "motion") }?;
    let place_at = |key: &EtdKey| Keyframe {
        time: key.time,
        transform: affine(&key.transform),
    };
    Ok(keys.iter().map(place_at).collect())
}
