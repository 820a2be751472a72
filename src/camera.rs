//! A perspective camera: a pinhole, or a thin lens.
//!
//! Measure: film positions in pixels from the upper left corner of the picture, y down; rays in normalised scene units.
//! Range: field of view in (0, pi); a lens of radius 0 is a pinhole and draws no lens numbers' worth of difference.
//! Source: Kolb, Mitchell and Hanrahan 1995 for the thin lens. Tested in `tests/determinism.rs`.

use crate::math::ray::Ray;
use crate::math::vec::{DVec3, Vec2, Vec3};
use crate::sampling::warp;

/// What a camera is made from, in normalised scene units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraParameters {
    /// Where it stands.
    pub eye: Vec3,
    /// Unit vectors to the right, up and backwards.
    pub axes: [DVec3; 3],
    /// Vertical field of view, in radians.
    pub fov: f64,
    /// Width and height of the whole picture, in pixels.
    pub size: (u32, u32),
    /// Radius of the lens.
    pub lens_radius: f32,
    /// Distance of the plane in focus, along the viewing axis.
    pub focus_distance: f32,
}

/// A camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: Vec3,
    /// Directions, of viewing depth 1, to the upper left corner, and from one pixel to the next.
    corner: Vec3,
    per_x: Vec3,
    per_y: Vec3,
    lens: Option<Lens>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Lens {
    /// The lens's half axes to the right and up.
    right: Vec3,
    up: Vec3,
    focus_distance: f32,
}

impl Camera {
    /// A camera with these parameters.
    pub fn new(p: &CameraParameters) -> Self {
        let [right, up, back] = p.axes;
        let (width, height) = (f64::from(p.size.0), f64::from(p.size.1));
        let half_height = (0.5 * p.fov).tan();
        let half_width = half_height * width / height;
        let lens = (p.lens_radius > 0.0).then(|| Lens {
            right: p.lens_radius * right.as_vec3(),
            up: p.lens_radius * up.as_vec3(),
            focus_distance: p.focus_distance,
        });
        Self {
            eye: p.eye,
            corner: (-half_width * right + half_height * up - back).as_vec3(),
            per_x: (2.0 * half_width / width * right).as_vec3(),
            per_y: (-2.0 * half_height / height * up).as_vec3(),
            lens,
        }
    }

    /// The ray through a point of the film and, given by two uniform numbers, a point of the lens. Its direction has
    /// unit length.
    #[inline]
    pub fn ray(&self, film: Vec2, u_lens: Vec2) -> Ray {
        let towards = self.corner + film.x * self.per_x + film.y * self.per_y;
        match &self.lens {
            None => Ray::new(self.eye, towards.normalize()),
            Some(lens) => {
                let d = warp::sample_disk_concentric(u_lens);
                let offset = d.x * lens.right + d.y * lens.up;
                let in_focus = lens.focus_distance * towards;
                Ray::new(self.eye + offset, (in_focus - offset).normalize())
            }
        }
    }
}
