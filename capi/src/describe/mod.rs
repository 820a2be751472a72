//! The parts of a scene as C structures, and their conversion to descriptions: one subject per file.
//!
//! Measure: world units; degrees; radiance in W m^-2 sr^-1, intensity in W/sr, irradiance in W/m^2.
//! Range: as in docs/scene-format.md for keys of the same names; the meaning of zeros is stated at each field. Fields
//! added after the first version come last: programs that were built without them are recognised by the smaller size of
//! their structures.
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

/// Returns the choice with this number.
pub fn choice<T: Copy>(number: i32, all: &[(i32, T)], what: &str) -> Result<T, Failure> {
    let found = all.iter().find(|(known, _)| *known == number);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        Failure::argument(format!("{what}: {number}, expected 0 to {}", all.len() - 1))
    })
}

/// Reads a vector of three numbers.
///
/// # Safety
/// The pointer is null, or three numbers may be read.
pub unsafe fn vec3(pointer: *const f64, what: &str) -> Result<DVec3, Failure> {
    // SAFETY: the caller's promise.
    let read: Vec<[f64; 3]> = unsafe { read_list(pointer.cast(), 1, 0, what) }?;
    Ok(DVec3::from_array(read[0]))
}

/// Returns the number, or the default if it is 0.
fn or_default<T: PartialEq + Default>(number: T, default: T) -> T {
    if number == T::default() {
        default
    } else {
        number
    }
}
