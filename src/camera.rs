//! A perspective camera: a pinhole, or a thin lens.
//!
//! Measure: film positions in pixels from the upper left corner of the picture, y down; rays in normalised scene units.
//! Range: field of view in (0, pi); a lens of radius 0 is a pinhole, whatever the lens numbers.
//! Source: Kolb, Mitchell and Hanrahan 1995 for the thin lens. Tested below.

use crate::effects::{Effects, Switch};
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
    pub fn ray<E: Effects>(&self, film: Vec2, u_lens: Vec2, _time: f32) -> Ray {
        let towards = self.corner + film.x * self.per_x + film.y * self.per_y;
        match &self.lens {
            _ if !E::Lens::ON => Ray::new(self.eye, towards.normalize()),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::kernel::types::Everything;

    fn camera(lens_radius: f32) -> Camera {
        Camera::new(&CameraParameters {
            eye: Vec3::new(0.0, 0.0, 5.0),
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
            fov: 90.0_f64.to_radians(),
            size: (200, 100),
            lens_radius,
            focus_distance: 3.0,
        })
    }

    #[test]
    fn rays_go_through_the_middle_and_the_corners_of_the_picture() {
        let towards = |x, y| {
            camera(0.0)
                .ray::<Everything>(Vec2::new(x, y), Vec2::ZERO, 0.0)
                .dir
        };
        assert!((towards(100.0, 50.0) + Vec3::Z).length() < 1e-6);
        // Half the height is tan 45 degrees, the width twice that; up is up.
        let corner = Vec3::new(-2.0, 1.0, -1.0).normalize();
        assert!((towards(0.0, 0.0) - corner).length() < 1e-6);
        let corner = Vec3::new(2.0, -1.0, -1.0).normalize();
        assert!((towards(200.0, 100.0) - corner).length() < 1e-6);
    }

    #[test]
    fn all_rays_of_a_lens_meet_in_the_plane_in_focus() {
        let film = Vec2::new(30.0, 80.0);
        let pinhole = camera(0.0).ray::<Everything>(film, Vec2::ZERO, 0.0);
        let meeting = pinhole.at(3.0 / -pinhole.dir.z);
        for (u, v) in [(0.0, 0.0), (0.9, 0.1), (0.5, 0.99), (0.3, 0.6)] {
            let ray = camera(0.5).ray::<Everything>(film, Vec2::new(u, v), 0.0);
            assert!((ray.origin - pinhole.origin).length() <= 0.5 + 1e-6);
            let there = ray.at((meeting.z - ray.origin.z) / ray.dir.z);
            assert!((there - meeting).length() < 1e-5, "{there} {meeting}");
        }
    }

    #[test]
    fn a_lens_of_radius_zero_is_a_pinhole() {
        let film = Vec2::new(30.0, 80.0);
        let pinhole = camera(0.0).ray::<Everything>(film, Vec2::ZERO, 0.0);
        assert_eq!(
            camera(0.0).ray::<Everything>(film, Vec2::new(0.7, 0.2), 0.0),
            pinhole
        );
    }
}
