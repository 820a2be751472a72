//! What a scene consists of, as C structures, and what they mean: one subject a file.
//!
//! Measure: world units; degrees; radiance in W m^-2 sr^-1, intensity in W/sr, irradiance in W/m^2.
//! Range: as docs/scene-format.md says of the keys of the same names; what zeros stand for is said at each field. Fields that
//! were added after the first version come last: programs that were built without them say by their smaller size that
//! they do not have them.
//! Source: docs/scene-format.md.

mod camera;
mod image;
mod light;
mod material;
mod mesh;
mod placement;

pub use camera::{EtdCamera, EtdFilm};
pub use light::EtdLight;
pub use material::EtdMaterial;
pub use mesh::EtdMesh;
pub use placement::{EtdInstance, EtdSurface, affine};

use crate::memory::read_list;
use crate::status::Failure;
use renderer::vec::DVec3;

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

/// Three numbers.
///
/// # Safety
/// The pointer is null, or they are there.
pub unsafe fn vec3(pointer: *const f64, what: &str) -> Result<DVec3, Failure> {
    // SAFETY: the caller's promise.
    let read: Vec<[f64; 3]> = unsafe { read_list(pointer.cast(), 1, 0, what) }?;
    Ok(DVec3::from_array(read[0]))
}

/// A number, or another one where it is 0.
fn or_default<T: PartialEq + Default>(number: T, default: T) -> T {
    if number == T::default() {
        default
    } else {
        number
    }
}
