//! Where shapes and groups stand, still or moving, and what a shape has beside its form.
//!
//! Measure: world units; times in the unit of the camera's shutter.
//! Range: as docs/scene-format.md says of `[[shape]]`, `[[instance]]` and motion.
//! Source: docs/scene-format.md.

use super::image::{EtdImage, texture_or};
use crate::memory::{Plain, Versioned, read_list, text};
use crate::status::Failure;
use renderer::description::{
    GeometryDescription, InstanceDescription, Key, Place, ShapeDescription,
};
use renderer::vec::{DAffine3, DMat3, DVec3};
use std::ffi::c_char;
use std::mem::offset_of;

/// The place of a shape or an instance at a time. Between two keys, translation and scale change evenly, and what is turned
/// turns evenly, the shorter way; before the first and after the last one, things stand still.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdKey {
    /// When, in the unit of the camera's shutter; above that of the key before.
    pub time: f64,
    /// Where: what is applied after the object's own `transform`, 12 numbers, row by row.
    pub transform: [f64; 12],
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
    /// In place of `emission`, by the texture coordinates of the shape; null for none.
    pub emission_texture: *const EtdImage,
    /// Where the shape is at which time; null for a shape that stands still. It moves while the camera's shutter is open.
    pub motion: *const EtdKey,
    /// Keys, in order of time.
    pub motion_count: usize,
    /// Bytes from one key to the next; 0 stands for keys without a gap.
    pub motion_stride: usize,
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
    /// Where the instance is at which time; null for one that stands still. It moves while the camera's shutter is open.
    pub motion: *const EtdKey,
    /// Keys, in order of time.
    pub motion_count: usize,
    /// Bytes from one key to the next; 0 stands for keys without a gap.
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
            // SAFETY: as above.
            motion: unsafe { motion(self.motion, self.motion_count, self.motion_stride) }?,
        })
    }
}

/// The index of a group: they are numbered from 1.
fn group(number: u32) -> Option<usize> {
    number.checked_sub(1).map(|index| index as usize)
}

/// The transform of three rows of four numbers.
pub fn affine(rows: &[f64; 12]) -> DAffine3 {
    let column = |c: usize| DVec3::new(rows[c], rows[4 + c], rows[8 + c]);
    DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    }
}

/// The same of a caller's numbers; null changes nothing.
///
/// # Safety
/// The pointer is null, or the numbers are there.
pub unsafe fn transform(rows: *const f64) -> Result<DAffine3, Failure> {
    if rows.is_null() {
        return Ok(DAffine3::IDENTITY);
    }
    // SAFETY: the caller's promise.
    let rows: Vec<[f64; 12]> = unsafe { read_list(rows.cast(), 1, 0, "transform") }?;
    Ok(affine(&rows[0]))
}

/// # Safety
/// The pointer is null, or all keys are there.
unsafe fn motion(keys: *const EtdKey, count: usize, stride: usize) -> Result<Vec<Key>, Failure> {
    // SAFETY: the caller's promise.
    let keys: Vec<EtdKey> = unsafe { read_list(keys.cast(), count, stride, "motion") }?;
    let place_at = |key: &EtdKey| Key {
        time: key.time,
        transform: affine(&key.transform),
    };
    Ok(keys.iter().map(place_at).collect())
}
