//! Ray queries.
//!
//! Measure: world units; radiance.
//! Range: finite rays; an invalid ray is an error that names it, and nothing is written.
//! Source: none needed.

use crate::memory::{Plain, checked_stride, not_null, read_list, read_struct_or_zeros, write_list};
use crate::scene::{EtdScene, SCENES};
use crate::settings::EtdSettings;
use crate::status::{EtdStatus, Failure};
use renderer::vec::DVec3;
use renderer::{QueryRay, SurfaceHit};
use std::ffi::c_void;

/// A ray in world space.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdRay {
    /// Origin.
    pub origin: [f64; 3],
    /// Direction, of any length but 0.
    pub direction: [f64; 3],
    /// Hits at this distance or nearer are ignored.
    pub min_distance: f64,
    /// Hits beyond this distance are ignored; 0 stands for any distance.
    pub max_distance: f64,
    /// The time, from 0, when the shutter opens, to 1.
    pub time: f64,
}

/// The closest hit of a ray.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct EtdHit {
    /// 1 for a hit, 0 for a miss; on a miss, all other fields are 0.
    pub met: u32,
    /// The shape's number.
    pub shape: u32,
    /// Index of the primitive in the shape, not counting those without area.
    pub primitive: u32,
    /// Reserved; 0.
    pub reserved: u32,
    /// Distance from the origin.
    pub distance: f64,
    /// Position.
    pub position: [f64; 3],
    /// Geometric normal of unit length, on the front of the shape.
    pub normal: [f64; 3],
    /// Shading normal: towards the ray, or outwards on transmissive materials.
    pub shading_normal: [f64; 3],
    /// Texture coordinates; 0 if no texture of the shape uses them.
    pub uv: [f64; 2],
}

// SAFETY: numbers without padding.
unsafe impl Plain for EtdRay {}

impl From<EtdRay> for QueryRay {
    fn from(ray: EtdRay) -> Self {
        Self {
            origin: DVec3::from_array(ray.origin),
            direction: DVec3::from_array(ray.direction),
            min_distance: ray.min_distance,
            max_distance: match ray.max_distance {
                0.0 => f64::INFINITY,
                far => far,
            },
            time: ray.time,
        }
    }
}

impl From<Option<SurfaceHit>> for EtdHit {
    fn from(met: Option<SurfaceHit>) -> Self {
        let Some(met) = met else {
            return Self::default();
        };
        Self {
            met: 1,
            shape: met.shape as u32,
            primitive: met.primitive,
            reserved: 0,
            distance: met.distance,
            position: met.position.to_array(),
            normal: met.geometric_normal.to_array(),
            shading_normal: met.shading_normal.to_array(),
            uv: met.uv.to_array(),
        }
    }
}

/// Reads rays of the caller.
///
/// # Safety
/// The pointer is null, or all rays may be read.
unsafe fn read_rays(
    rays: *const EtdRay,
    count: usize,
    stride: usize,
) -> Result<Vec<QueryRay>, Failure> {
    checked_stride::<EtdRay>(count, stride, "rays")?;
    let each = size_of::<EtdRay>() + size_of::<QueryRay>() + size_of::<EtdHit>();
    let bytes = (count as u64).saturating_mul(each as u64);
    renderer::memory::check(bytes, || format!("{count} rays"))?;
    // SAFETY: the caller's promise.
    let rays: Vec<EtdRay> = unsafe { read_list(rays.cast(), count, stride, "rays") }?;
    Ok(rays.into_iter().map(QueryRay::from).collect())
}

/// Returns an error about one of several rays.
fn of_ray(index: usize) -> impl Fn(renderer::Error) -> Failure {
    move |error| {
        let failure = Failure::from(error);
        Failure::new(failure.status, format!("ray {index}: {}", failure.text))
    }
}

/// Finds the closest hit of each of `count` rays. Strides are bytes from one item to the next; 0 stands for items
/// without a gap. May be called from any number of threads at once. A surface with alpha is hit where alpha is above one
/// half.
///
/// # Safety
/// The pointers are null, or `count` rays may be read, and `count` hits may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_intersect(
    scene: *const EtdScene,
    rays: *const EtdRay,
    count: usize,
    ray_stride: usize,
    hits: *mut EtdHit,
    hit_stride: usize,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let rays = unsafe { read_rays(rays, count, ray_stride) }?;
        checked_stride::<EtdHit>(count, hit_stride, "hits")?;
        let met: Vec<EtdHit> = scene.ready.read(|session| {
            let ask = |(index, ray)| session.intersect(ray).map_err(of_ray(index));
            let met = rays.iter().enumerate().map(ask);
            met.map(|met| met.map(EtdHit::from)).collect()
        })?;
        // SAFETY: the caller's promise.
        unsafe { write_list(hits.cast(), hit_stride, met.into_iter(), "hits") }?;
        Ok(EtdStatus::Ok)
    })
}

/// Tests each of `count` rays for occlusion: writes 1 or 0 for each, without a gap. May be called from any number of
/// threads at once.
///
/// # Safety
/// The pointers are null, or `count` rays may be read, and `count` bytes may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_occluded(
    scene: *const EtdScene,
    rays: *const EtdRay,
    count: usize,
    ray_stride: usize,
    occluded: *mut u8,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let rays = unsafe { read_rays(rays, count, ray_stride) }?;
        let found: Vec<u8> = scene.ready.read(|session| {
            let ask = |(index, ray)| session.occluded(ray).map_err(of_ray(index));
            let found = rays.iter().enumerate().map(ask);
            found.map(|found| found.map(u8::from)).collect()
        })?;
        // SAFETY: the caller's promise.
        unsafe { write_list(occluded.cast(), 0, found.into_iter(), "occluded") }?;
        Ok(EtdStatus::Ok)
    })
}

/// Estimates the incident radiance at the origin of each of `count` rays with `spp` samples, on the scene's threads:
/// red, green and blue for each ray, without a gap. If `standard_errors` is not null, their standard errors are written,
/// too, and `spp` is rounded up to a multiple of 4. Limits, crop, the flag for layers, `adaptive`, `light_paths` and
/// `reuse` in `settings`, which may be null, are ignored.
///
/// # Safety
/// The pointers are null, or valid; three floats for each ray may be written to the last two.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_radiance(
    scene: *const EtdScene,
    settings: *const EtdSettings,
    rays: *const EtdRay,
    count: usize,
    ray_stride: usize,
    spp: u64,
    radiance: *mut f32,
    standard_errors: *mut f32,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let mut options = unsafe { read_struct_or_zeros(settings)?.options() }?;
        (options.time, options.error, options.crop) = (None, None, None);
        options.layers = !standard_errors.is_null();
        let rays = unsafe { read_rays(rays, count, ray_stride) }?;
        if count > 0 {
            not_null(radiance, "radiance")?;
        }
        let along = scene.ready.read(|session| {
            let along = session.radiance(&options, &rays, spp);
            along.map_err(Failure::from)
        })?;
        let means = along.iter().map(|it| it.mean.to_array());
        let errors = along.iter().map(|it| {
            let errors = it.standard_error.map(|error| error.to_array());
            errors.unwrap_or([f32::NAN; 3])
        });
        // SAFETY: the caller's promise.
        unsafe {
            write_list(radiance.cast::<c_void>(), 0, means, "radiance")?;
            if !standard_errors.is_null() {
                write_list(standard_errors.cast(), 0, errors, "standard_errors")?;
            }
        }
        Ok(EtdStatus::Ok)
    })
}
