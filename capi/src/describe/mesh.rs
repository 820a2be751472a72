//! Triangle meshes.
//!
//! Measure: units of the shape.
//! Range: fewer than 2^32 vertices and triangles.
//! Source: docs/scene-format.md.

use super::choice;
use crate::memory::{Plain, Versioned, read_list, room};
use crate::status::Failure;
use renderer::description::MeshDescription;
use renderer::mesh_build_memory;
use renderer::vec::{DVec2, DVec3};
use std::ffi::c_void;

/// Number formats.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdFormat {
    /// 32-bit floats.
    Float32 = 0,
    /// 64-bit floats.
    Float64 = 1,
}

/// A triangle mesh in the caller's memory, which is copied. Strides are bytes from one item to the next; 0 stands for
/// items without a gap. Addresses need no alignment.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdMesh {
    /// sizeof(EtdMesh)
    pub struct_size: usize,
    /// x, y and z of each vertex.
    pub positions: *const c_void,
    /// Number of vertices, below 2^32.
    pub vertex_count: usize,
    /// Bytes from one position to the next.
    pub position_stride: usize,
    /// An `EtdFormat`, of positions only: all other attributes are 32-bit floats.
    pub position_format: i32,
    /// Shading normals, one per vertex, of any length; null for none.
    pub normals: *const f32,
    /// Bytes from one normal to the next.
    pub normal_stride: usize,
    /// Texture coordinates u and v, one pair per vertex, v up; null for none.
    pub uvs: *const f32,
    /// Bytes from one texture coordinate to the next.
    pub uv_stride: usize,
    /// Three vertex indices per triangle; the geometric normal is (b - a) x (c - a).
    pub indices: *const u32,
    /// Number of triangles, below 2^32.
    pub triangle_count: usize,
    /// Bytes from one triangle to the next.
    pub index_stride: usize,
}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdMesh {
    const NAME: &'static str = "EtdMesh";
}

impl EtdMesh {
    /// # Safety
    /// Its pointers are null, or valid.
    pub unsafe fn describe(&self) -> Result<MeshDescription, Failure> {
        let count = self.vertex_count;
        if u32::try_from(count).is_err() || u32::try_from(self.triangle_count).is_err() {
            return Err(Failure::argument(
                "a mesh has fewer than 2^32 vertices and triangles",
            ));
        }
        // Includes the memory to build the mesh later.
        renderer::memory::check(mesh_build_memory(count, self.triangle_count), || {
            format!(
                "a mesh of {count} vertices and {} triangles",
                self.triangle_count
            )
        })?;
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

/// # Safety
/// The pointer is null, or all items may be read.
unsafe fn list<T: Plain, U>(
    pointer: *const c_void,
    count: usize,
    stride: usize,
    what: &str,
    convert: impl Fn(T) -> U,
) -> Result<Vec<U>, Failure> {
    // SAFETY: the caller's promise.
    let read: Vec<T> = unsafe { read_list(pointer, count, stride, what) }?;
    let mut items = room(count, what)?;
    items.extend(read.into_iter().map(convert));
    Ok(items)
}

/// Reads a list like [`list`]; null stands for an empty one.
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
