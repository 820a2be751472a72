//! Functions that add the parts of a scene.
//!
//! Measure: as in `describe/`.
//! Range: parts that `load` accepts; others are not added. Parts that are added to a committed scene take effect at the
//! next commit.
//! Source: none needed.

use crate::describe::{EtdInstance, EtdLight, EtdMaterial, EtdMesh, EtdSurface, vec3};
use crate::memory::{read_struct, text, write};
use crate::scene::{EtdScene, SCENES, Scene};
use crate::status::{CallResult, EtdStatus};
use renderer::description::GeometryDescription;
use std::ffi::c_char;
use std::sync::Arc;

/// Adds a shape and writes its number.
///
/// # Safety
/// The surface is null, or valid as its size says; the number may be written, or its pointer is null.
unsafe fn add_shape(
    scene: &Scene,
    surface: *const EtdSurface,
    geometry: GeometryDescription,
    number: *mut u32,
) -> CallResult {
    // SAFETY: the caller's promise.
    unsafe {
        let shape = read_struct(surface)?.describe(geometry)?;
        let index = scene.describe().add_shape(shape)?;
        write_number(number, index)
    }
}

/// Writes the number of a new object, unless the pointer is null.
///
/// # Safety
/// The number may be written, or its pointer is null.
unsafe fn write_number(number: *mut u32, index: usize) -> CallResult {
    if !number.is_null() {
        // SAFETY: the caller's promise.
        unsafe { write(number, index as u32, "number")? };
    }
    Ok(EtdStatus::Ok)
}

/// Adds a material and writes its number, counted from 0, unless `number` is null. Textures are copied.
///
/// # Safety
/// `material` is null, or a structure of its `struct_size`, whose pointers are null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_material(
    scene: *mut EtdScene,
    material: *const EtdMaterial,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let material = unsafe { read_struct(material)?.describe() }?;
        let index = scene.describe().add_material(material)?;
        // SAFETY: as above.
        unsafe { write_number(number, index) }
    })
}

/// Adds a triangle mesh and writes the number of the shape, counted from 0, unless `number` is null. All buffers are
/// copied.
///
/// # Safety
/// `surface` and `mesh` are null, or structures of their `struct_size`, whose pointers are null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_mesh(
    scene: *mut EtdScene,
    surface: *const EtdSurface,
    mesh: *const EtdMesh,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let mesh = unsafe { read_struct(mesh)?.describe() }?;
        let geometry = GeometryDescription::Mesh(Arc::new(mesh));
        // SAFETY: as above.
        unsafe { add_shape(scene, surface, geometry, number) }
    })
}

/// Adds a sphere around `center`, three numbers, and writes the number of the shape unless `number` is null.
///
/// # Safety
/// As `etd_scene_add_mesh`; `center` is null, or three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_sphere(
    scene: *mut EtdScene,
    surface: *const EtdSurface,
    center: *const f64,
    radius: f64,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let center = unsafe { vec3(center, "center") }?;
        let geometry = GeometryDescription::Sphere { center, radius };
        // SAFETY: as above.
        unsafe { add_shape(scene, surface, geometry, number) }
    })
}

/// Adds a disk around `center`, with a normal of any length, and writes the number of the shape unless `number` is null.
///
/// # Safety
/// As `etd_scene_add_sphere`; likewise for `normal`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_disk(
    scene: *mut EtdScene,
    surface: *const EtdSurface,
    center: *const f64,
    normal: *const f64,
    radius: f64,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let geometry = unsafe {
            GeometryDescription::Disk {
                center: vec3(center, "center")?,
                normal: vec3(normal, "normal")?,
                radius,
            }
        };
        // SAFETY: as above.
        unsafe { add_shape(scene, surface, geometry, number) }
    })
}

/// Adds a parallelogram with the normal edge_u x edge_v, and writes the number of the shape unless `number` is null.
///
/// # Safety
/// As `etd_scene_add_sphere`; likewise for the corner and the edges.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_rectangle(
    scene: *mut EtdScene,
    surface: *const EtdSurface,
    corner: *const f64,
    edge_u: *const f64,
    edge_v: *const f64,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let geometry = unsafe {
            GeometryDescription::Rectangle {
                corner: vec3(corner, "corner")?,
                edge_u: vec3(edge_u, "edge_u")?,
                edge_v: vec3(edge_v, "edge_v")?,
            }
        };
        // SAFETY: as above.
        unsafe { add_shape(scene, surface, geometry, number) }
    })
}

/// Adds an axis-aligned box whose normals point outwards, and writes the number of the shape unless `number` is null.
///
/// # Safety
/// As `etd_scene_add_sphere`; likewise for both corners.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_box(
    scene: *mut EtdScene,
    surface: *const EtdSurface,
    min: *const f64,
    max: *const f64,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let geometry = unsafe {
            GeometryDescription::Box {
                min: vec3(min, "min")?,
                max: vec3(max, "max")?,
            }
        };
        // SAFETY: as above.
        unsafe { add_shape(scene, surface, geometry, number) }
    })
}

/// Adds an empty group and writes its number, counted from 1: 0 stands for the world itself. `name` is for messages and
/// may be null.
///
/// # Safety
/// `name` is null, or a NUL-terminated string; `number` is null, or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_group(
    scene: *mut EtdScene,
    name: *const c_char,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let name = unsafe { text(name, "name") }?.unwrap_or("group");
        let index = scene.describe().add_group(name);
        // SAFETY: as above.
        unsafe { write_number(number, index + 1) }
    })
}

/// Adds an instance of a group and writes its number, counted from 0, unless `number` is null.
///
/// # Safety
/// `instance` is null, or a structure of its `struct_size`, whose pointers are null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_instance(
    scene: *mut EtdScene,
    instance: *const EtdInstance,
    number: *mut u32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let instance = unsafe { read_struct(instance)?.describe() }?;
        let index = scene.describe().add_instance(instance)?;
        // SAFETY: as above.
        unsafe { write_number(number, index) }
    })
}

/// Adds a light that is not a shape. Its environment map is copied; a scene has at most one.
///
/// # Safety
/// `light` is null, or a structure of its `struct_size`, whose pointers are null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_add_light(
    scene: *mut EtdScene,
    light: *const EtdLight,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let light = unsafe { read_struct(light)?.describe() }?;
        scene.describe().add_light(light)?;
        Ok(EtdStatus::Ok)
    })
}
