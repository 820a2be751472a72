//! A perspective camera: a pinhole, or a thin lens.
//!
//! Measure: film positions in pixels from the upper left corner of the picture, y down; rays in normalised scene units.
//! Range: field of view in (0, pi); a lens of radius 0 is a pinhole, whatever the lens numbers; any focus distance above 0,
//! infinity too.
//! Source: Kolb, Mitchell and Hanrahan 1995 for the thin lens. Tested below.

use crate::effects::{Effects, Switch};
use crate::math::ray::Ray;
use crate::math::vec::{DVec3, Vec2, Vec3};
use crate::planted::planted;
use crate::sampling::warp;

/// What a camera is made from, in normalised scene units.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraParameters {
    /// Where it stands, with unit vectors to the right, up and backwards: at equally spaced times from the opening of the
    /// shutter to its closing, or once if it stands still.
    pub poses: Vec<(Vec3, [DVec3; 3])>,
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
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// When the shutter opens.
    pose: Pose,
    /// At equally spaced times; empty for a camera that stands still.
    motion: Vec<Pose>,
    lens_radius: f32,
    focus_distance: f32,
}

/// A camera at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pose {
    eye: Vec3,
    /// Directions, of viewing depth 1, to the upper left corner, and from one pixel to the next.
    corner: Vec3,
    per_x: Vec3,
    per_y: Vec3,
    /// The lens's half axes to the right and up.
    lens: [Vec3; 2],
}

impl Pose {
    /// The way from `self` at 0 to `other` at 1. Steps are fine enough for straight lines.
    fn lerp(&self, other: &Self, t: f32) -> Self {
        let between = |a: Vec3, b: Vec3| a + t * (b - a);
        Self {
            eye: between(self.eye, other.eye),
            corner: between(self.corner, other.corner),
            per_x: between(self.per_x, other.per_x),
            per_y: between(self.per_y, other.per_y),
            lens: [0, 1].map(|i| between(self.lens[i], other.lens[i])),
        }
    }
}

impl Camera {
    /// A camera with these parameters.
    ///
    /// # Panics
    /// If it has no pose.
    pub fn new(p: &CameraParameters) -> Self {
        let (width, height) = (f64::from(p.size.0), f64::from(p.size.1));
        let half_height = (0.5 * p.fov).tan();
        let half_width = half_height * width / height;
        let pose = |&(eye, [right, up, back]): &(Vec3, [DVec3; 3])| Pose {
            eye,
            corner: (-half_width * right + half_height * up - back).as_vec3a(),
            per_x: (2.0 * half_width / width * right).as_vec3a(),
            per_y: (-2.0 * half_height / height * up).as_vec3a(),
            lens: [right, up].map(|axis| p.lens_radius * axis.as_vec3a()),
        };
        let motion: Vec<Pose> = p.poses.iter().map(pose).collect();
        Self {
            pose: motion[0],
            motion: if motion.len() > 1 { motion } else { vec![] },
            lens_radius: p.lens_radius,
            focus_distance: p.focus_distance,
        }
    }

    /// The ray through a point of the film and, given by two uniform numbers, a point of the lens, at a time of the
    /// shutter from 0 to 1. Its direction has unit length.
    #[inline]
    pub fn ray<E: Effects>(&self, film: Vec2, u_lens: Vec2, time: f32) -> Ray {
        if E::Motion::ON && !self.motion.is_empty() {
            return self.ray_from::<E>(&self.pose_at(time), film, u_lens);
        }
        self.ray_from::<E>(&self.pose, film, u_lens)
    }

    fn pose_at(&self, time: f32) -> Pose {
        let position = time * (self.motion.len() - 1) as f32;
        let before = (position as usize).min(self.motion.len() - 2);
        let [a, b] = [before, before + 1].map(|i| &self.motion[i]);
        a.lerp(b, position - before as f32)
    }

    #[inline]
    fn ray_from<E: Effects>(&self, pose: &Pose, film: Vec2, u_lens: Vec2) -> Ray {
        let towards = pose.corner + film.x * pose.per_x + film.y * pose.per_y;
        if !E::Lens::ON || self.lens_radius <= 0.0 {
            return Ray::new(pose.eye, towards.normalize());
        }
        let d = warp::sample_disk_concentric(u_lens);
        let offset = d.x * pose.lens[0] + d.y * pose.lens[1];
        // Squares of a distance of 1e20 leave single precision: far off, the lens is measured in it instead.
        let near = self.focus_distance.min(1.0);
        let across = near / self.focus_distance * offset;
        let in_focus = planted!("focus-on-a-sphere", towards.normalize(), towards);
        Ray::new(pose.eye + offset, (near * in_focus - across).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::kernel::types::Everything;

    fn camera(lens_radius: f32) -> Camera {
        Camera::new(&CameraParameters {
            poses: vec![(Vec3::new(0.0, 0.0, 5.0), [DVec3::X, DVec3::Y, DVec3::Z])],
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
    fn focused_on_infinity_all_rays_of_a_lens_are_parallel() {
        let film = Vec2::new(30.0, 80.0);
        let pinhole = camera(0.0).ray::<Everything>(film, Vec2::ZERO, 0.0);
        for focus_distance in [1e19, 1e30, f32::INFINITY] {
            let mut camera = camera(0.5);
            camera.focus_distance = focus_distance;
            let ray = camera.ray::<Everything>(film, Vec2::new(0.9, 0.3), 0.0);
            assert_eq!(ray.dir, pinhole.dir, "{focus_distance}");
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
