//! One known hit, traced before any other: an Embree built with more instance levels than its headers say would write
//! past the end of every hit, and cannot be asked.
//!
//! Measure: none.
//! Range: every device.
//! Source: embree4-sys asserts the headers' side at compile time. Tested by every test that builds a scene.

use super::handles::{Device, Scene};
use super::new_ray_hit;
use crate::error::{Error, Result};
use crate::math::ray::Ray;
use crate::math::vec::Vec3;
use embree4_sys::{RTC_INVALID_GEOMETRY_ID, RTCHit};
use std::sync::Arc;

/// Traces past a sphere and at it, and looks at every field that is read later.
///
/// # Errors
/// That the library does not fit its headers.
pub fn check(device: &Arc<Device>) -> Result<()> {
    const ID: u32 = 3;
    let mut scene = Scene::new(Arc::clone(device), false)?;
    scene.attach_sphere(ID, [0.0, 0.0, 0.0, 1.0]);
    let scene = scene.commit()?;

    let mut at = Guarded::new(&Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z));
    scene.intersect(at.ray_hit());
    let hit = at.ray_hit().hit;
    // Instruction sets differ in the last digits.
    let found = (at.ray_hit().ray.tfar - 2.0).abs() < 1e-5
        && (hit.geomID, hit.primID) == (ID, 0)
        && hit.instID == [RTC_INVALID_GEOMETRY_ID];

    let mut past = Guarded::new(&Ray::new(Vec3::new(3.0, 0.0, -3.0), Vec3::Z));
    scene.intersect(past.ray_hit());
    let missed = past.ray_hit().hit.geomID == RTC_INVALID_GEOMETRY_ID;

    if found && missed && at.is_intact() && past.is_intact() {
        return Ok(());
    }
    Err(Error::render(format!(
        "the Embree library does not fit the headers that this program was built with \
         (its hits are not the {} bytes of one instance level); rebuild against the installed Embree",
        size_of::<RTCHit>()
    )))
}

/// A ray and its hit, with room behind them for what a library of another layout would write.
#[repr(C)]
struct Guarded {
    ray_hit: embree4_sys::RTCRayHit,
    guard: [u32; 64],
}

impl Guarded {
    const CANARY: u32 = 0xC0FF_EE00;

    fn new(ray: &Ray) -> Box<Self> {
        Box::new(Self {
            ray_hit: new_ray_hit(ray, 0.0),
            guard: [Self::CANARY; 64],
        })
    }

    fn ray_hit(&mut self) -> &mut embree4_sys::RTCRayHit {
        &mut self.ray_hit
    }

    fn is_intact(&self) -> bool {
        self.guard.iter().all(|&word| word == Self::CANARY)
    }
}
