//! The camera and the film.
//!
//! Measure: world units, degrees, pixels.
//! Range: as in docs/scene-format.md for `[camera]` and `[film]`.
//! Source: docs/scene-format.md.

use super::{choice, or_default};
use crate::memory::{Plain, Versioned, read_list};
use crate::status::Failure;
use renderer::description::{
    CameraDescription, FilmDescription, FilterDescription, FilterKind, Keyframe,
};
use renderer::vec::DVec3;
use std::mem::offset_of;

/// A perspective camera.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdCamera {
    /// sizeof(EtdCamera)
    pub struct_size: usize,
    /// Position of the camera.
    pub eye: [f64; 3],
    /// The point that the camera looks at.
    pub target: [f64; 3],
    /// The up direction; all zeros stand for y.
    pub up: [f64; 3],
    /// Vertical field of view in degrees, below 180; 0 stands for 40.
    pub fov: f64,
    /// Radius of the lens; 0 is a pinhole.
    pub lens_radius: f64,
    /// Distance of the plane of focus; 0 stands for that of the target, which is that of the first keyframe if the
    /// camera moves.
    pub focus_distance: f64,
    /// Two times: when the shutter opens and when it closes, in the unit of all keyframes. If they are equal, everything
    /// is static at that time. Null leaves the shutter unchanged; that of a new scene is { 0, 0 }.
    pub shutter: *const f64,
    /// Keyframes, which replace `eye`, `target` and `up`; null for a static camera.
    pub motion: *const EtdCameraKey,
    /// Number of keyframes, which are in order of time.
    pub motion_count: usize,
    /// Bytes from one keyframe to the next; 0 stands for no gap.
    pub motion_stride: usize,
}

/// A keyframe of a camera.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdCameraKey {
    /// The time; later than that of the previous keyframe.
    pub time: f64,
    /// Position of the camera.
    pub eye: [f64; 3],
    /// The point that the camera looks at.
    pub target: [f64; 3],
    /// The up direction; all zeros stand for y.
    pub up: [f64; 3],
}

/// Reconstruction filters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdFilter {
    /// Gaussian filter.
    Gaussian = 0,
    /// Box filter: constant weight.
    Box = 1,
    /// Tent (triangle) filter.
    Tent = 2,
    /// Mitchell-Netravali filter, with negative lobes.
    Mitchell = 3,
    /// Blackman-Harris filter.
    BlackmanHarris = 4,
}

/// The film.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdFilm {
    /// sizeof(EtdFilm)
    pub struct_size: usize,
    /// Width in pixels, from 1 to 65536.
    pub width: u32,
    /// Height in pixels, from 1 to 65536.
    pub height: u32,
    /// The reconstruction filter, an `EtdFilter`.
    pub filter: i32,
    /// The filter radius in pixels, up to 32; 0 stands for the filter's default.
    pub filter_radius: f64,
}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdCamera {
    const NAME: &'static str = "EtdCamera";
    const FIRST_SIZE: usize = offset_of!(EtdCamera, shutter);
}

// SAFETY: numbers without padding.
unsafe impl Plain for EtdCameraKey {}

// SAFETY: numbers.
unsafe impl Versioned for EtdFilm {
    const NAME: &'static str = "EtdFilm";
}

/// Returns a camera at `eye` that looks at `target`; an `up` of zeros stands for y.
fn look_at([eye, target, up]: [[f64; 3]; 3], fov: f64) -> renderer::Result<CameraDescription> {
    let [eye, target, up] = [eye, target, up].map(DVec3::from_array);
    let up = or_default(up, DVec3::Y);
    CameraDescription::look_at(eye, target, up, fov)
}

impl EtdCamera {
    /// Returns the description of the camera; `shutter` is the shutter so far, used if none is given.
    ///
    /// # Safety
    /// Its pointers are null, or valid.
    pub unsafe fn describe(&self, shutter: [f64; 2]) -> Result<CameraDescription, Failure> {
        let fov = or_default(self.fov, 40.0).to_radians();
        // SAFETY: the caller's promise.
        let keys: Vec<EtdCameraKey> = unsafe {
            let keys = self.motion.cast();
            read_list(keys, self.motion_count, self.motion_stride, "motion")
        }?;
        let first = match keys.first() {
            Some(key) => [key.eye, key.target, key.up],
            None => [self.eye, self.target, self.up],
        };
        let mut camera = look_at(first, fov)?;
        camera.motion = keys.iter().map(place_at).collect::<Result<_, _>>()?;
        camera.lens_radius = self.lens_radius;
        camera.focus_distance = or_default(self.focus_distance, camera.focus_distance);
        camera.shutter = if self.shutter.is_null() {
            shutter
        } else {
            // SAFETY: the caller's promise.
            unsafe { read_list(self.shutter.cast(), 1, 0, "shutter") }?[0]
        };
        Ok(camera)
    }
}

fn place_at(key: &EtdCameraKey) -> Result<Keyframe, Failure> {
    // The field of view does not matter: only the transform is used.
    let placed = look_at([key.eye, key.target, key.up], 1.0)?;
    Ok(Keyframe {
        time: key.time,
        transform: placed.to_world,
    })
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
        let radius = or_default(self.filter_radius, kind.default_radius());
        Ok(FilmDescription {
            size: (self.width, self.height),
            filter: FilterDescription { kind, radius },
        })
    }
}
