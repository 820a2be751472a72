//! The perspective camera, with a pinhole or a thin lens.
//!
//! Measure: film positions in pixels from the upper left corner of the image, y down; rays in normalised scene units.
//! Range: field of view in (0, pi); a lens of radius 0 is a pinhole, for any lens samples; any focus distance above 0,
//! including infinity.
//! Source: Kolb, Mitchell and Hanrahan 1995 for the thin lens. Tested below.

use crate::effects::{Effects, Switch};
use crate::math::functions::tan;
use crate::math::lanes::{LANES, Lanes, Lanes3, store, vectorised};
use crate::math::ray::Ray;
use crate::math::vec::{DVec2, DVec3, LaneVec3, Vec2, Vec3, Vector};
use crate::planted::planted;
use crate::sampling::warp;

/// The parameters of a camera, in normalised scene units.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraParameters {
    /// The positions, with unit vectors to the right, up and backwards, at equally spaced times from the opening of the
    /// shutter to its closing; a single one for a static camera.
    pub poses: Vec<(Vec3, [DVec3; 3])>,
    /// Whether the image is mirrored, left to right.
    pub is_mirrored: bool,
    /// Vertical field of view, in radians.
    pub fov: f64,
    /// Width and height of the whole image, in pixels.
    pub size: (u32, u32),
    /// Radius of the lens.
    pub lens_radius: f32,
    /// Distance of the focal plane, along the viewing axis.
    pub focus_distance: f32,
}

/// A camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// The pose when the shutter opens.
    pose: Pose,
    /// The poses at equally spaced times; empty for a static camera.
    motion: Vec<Pose>,
    lens_radius: f32,
    focus_distance: f32,
}

/// The pose of a camera at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pose {
    eye: Vec3,
    /// The direction to the upper left corner and the steps from one pixel to the next, at viewing depth 1.
    corner: Vec3,
    per_x: Vec3,
    per_y: Vec3,
    /// The half axes of the lens to the right and up.
    lens: [Vec3; 2],
}

impl Pose {
    /// Interpolates from `self` at 0 to `other` at 1. The steps are fine enough for linear interpolation.
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
    /// Creates a camera with these parameters.
    ///
    /// # Panics
    /// If there is no pose.
    pub fn new(p: &CameraParameters) -> Self {
        let (width, height) = (f64::from(p.size.0), f64::from(p.size.1));
        let half_height = tan(0.5 * p.fov);
        let half_width = half_height * width / height;
        let pose = |&(eye, [right, up, back]): &(Vec3, [DVec3; 3])| {
            // The direction of the image's right edge.
            let right = if p.is_mirrored { -right } else { right };
            Pose {
                eye,
                corner: (-half_width * right + half_height * up - back).as_vec3a(),
                per_x: (2.0 * half_width / width * right).as_vec3a(),
                per_y: (-2.0 * half_height / height * up).as_vec3a(),
                lens: [right, up].map(|axis| p.lens_radius * axis.as_vec3a()),
            }
        };
        let motion: Vec<Pose> = p.poses.iter().map(pose).collect();
        Self {
            pose: motion[0],
            motion: if motion.len() > 1 { motion } else { vec![] },
            lens_radius: p.lens_radius,
            focus_distance: p.focus_distance,
        }
    }

    /// Returns the camera with the same view for a film of `to` instead of `from` pixels: the view at each fraction of
    /// the width and height is unchanged.
    pub fn on_film(&self, from: (u32, u32), to: (u32, u32)) -> Self {
        let x = (f64::from(from.0) / f64::from(to.0)) as f32;
        let y = (f64::from(from.1) / f64::from(to.1)) as f32;
        let pose = |pose: &Pose| Pose {
            per_x: x * pose.per_x,
            per_y: y * pose.per_y,
            ..*pose
        };
        Self {
            pose: pose(&self.pose),
            motion: self.motion.iter().map(pose).collect(),
            ..*self
        }
    }

    /// The ray through a point of the film and a point of the lens, sampled by two uniform numbers, at a time of the
    /// shutter from 0 to 1. Its direction has unit length.
    #[inline]
    pub fn ray<E: Effects>(&self, film: Vec2, u_lens: Vec2, time: f32) -> Ray {
        if E::Motion::ON && !self.motion.is_empty() {
            return self.ray_from::<E, Vec3>(&self.pose_at(time), film, u_lens);
        }
        self.ray_from::<E, Vec3>(&self.pose, film, u_lens)
    }

    /// The rays of all lanes, as [`ray`](Self::ray): sets their origins and directions.
    pub fn ray_lanes<E: Effects>(
        &self,
        film: &[Lanes<f32>; 2],
        u_lens: &[Lanes<f32>; 2],
        time: &Lanes<f32>,
        origin: &mut Lanes3,
        dir: &mut Lanes3,
    ) {
        if !E::Motion::ON || self.motion.is_empty() {
            return rays_of_static_camera::<E>(self, film, u_lens, origin, dir);
        }
        for lane in 0..LANES {
            let at = |of: &[Lanes<f32>; 2]| Vec2::new(of[0][lane], of[1][lane]);
            let ray = self.ray::<E>(at(film), at(u_lens), time[lane]);
            store(origin, lane, ray.origin);
            store(dir, lane, ray.dir);
        }
    }

    /// Samples a point of the lens, or the pinhole, by two uniform numbers, and returns the camera as seen from it.
    pub fn viewpoint<E: Effects>(&self, u_lens: Vec2, time: f32) -> Viewpoint {
        let pose = if E::Motion::ON && !self.motion.is_empty() {
            self.pose_at(time)
        } else {
            self.pose
        };
        let mut offset = Vec3::ZERO;
        if E::Lens::ON && self.lens_radius > 0.0 {
            let d = warp::sample_disk_concentric(u_lens);
            offset = d.x * pose.lens[0] + d.y * pose.lens[1];
        }
        Viewpoint {
            p: pose.eye + offset,
            shift: offset.as_dvec3() / f64::from(self.focus_distance),
            pose,
        }
    }

    fn pose_at(&self, time: f32) -> Pose {
        let position = time * (self.motion.len() - 1) as f32;
        let before = (position as usize).min(self.motion.len() - 2);
        let [a, b] = [before, before + 1].map(|i| &self.motion[i]);
        a.lerp(b, position - before as f32)
    }

    #[inline(always)]
    fn ray_from<E: Effects, V: Vector>(&self, pose: &Pose, film: Vec2, u_lens: Vec2) -> Ray<V> {
        let [corner, per_x, per_y] = [pose.corner, pose.per_x, pose.per_y].map(V::from);
        let eye = V::from(pose.eye);
        let normalize = |v: V| v / v.length();
        let towards = corner + per_x * film.x + per_y * film.y;
        if !E::Lens::ON || self.lens_radius <= 0.0 {
            return Ray::new(eye, normalize(towards));
        }
        let d = warp::sample_disk_concentric(u_lens);
        let [right, up] = pose.lens.map(V::from);
        let offset = right * d.x + up * d.y;
        // The square of a distance of 1e20 overflows single precision: for large focus distances the lens offset is
        // divided by the distance instead.
        let near = self.focus_distance.min(1.0);
        let across = offset * (near / self.focus_distance);
        let in_focus = planted!("focus-on-a-sphere", normalize(towards), towards);
        Ray::new(eye + offset, normalize(in_focus * near - across))
    }
}

vectorised! {
    /// The rays of a camera that does not move.
    fn rays_of_static_camera<E: Effects>(
        camera: &Camera,
        film: &[Lanes<f32>; 2],
        u_lens: &[Lanes<f32>; 2],
        origin: &mut Lanes3,
        dir: &mut Lanes3,
    ) {
        for lane in 0..LANES {
            let film = Vec2::new(film[0][lane], film[1][lane]);
            let u_lens = Vec2::new(u_lens[0][lane], u_lens[1][lane]);
            let ray: Ray<LaneVec3> = camera.ray_from::<E, LaneVec3>(&camera.pose, film, u_lens);
            store(origin, lane, ray.origin);
            store(dir, lane, ray.dir);
        }
    }
}

/// A point of the lens at a time: the end vertex of light paths that are connected to the camera.
#[derive(Debug, Clone, Copy)]
pub struct Viewpoint {
    /// The position.
    pub p: Vec3,
    pose: Pose,
    /// The direction from the centre of the lens minus that from this point, to the same point in focus, at viewing
    /// depth 1.
    shift: DVec3,
}

/// The point of the film that light through the lens falls on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FilmPoint {
    /// The position in pixels from the upper left corner of the image; it may be outside the image.
    pub position: Vec2,
    /// The area of the film, in pixels, per steradian about the ray.
    pub per_steradian: f64,
}

impl Viewpoint {
    /// The film point of the ray from this viewpoint along the unit vector `w`; `None` if the ray points backwards.
    ///
    /// The film is a plane at the distance h from the lens. A ray at the angle theta to its normal intersects it at the
    /// distance h / cos theta, where a steradian covers an area of h^2 / cos^3 theta.
    #[inline]
    pub fn film_point(&self, w: Vec3) -> Option<FilmPoint> {
        let [corner, per_x, per_y] = [self.pose.corner, self.pose.per_x, self.pose.per_y];
        let [corner, per_x, per_y] = [corner, per_x, per_y].map(|v| v.as_dvec3());
        let normal = per_x.cross(per_y);
        let pixel = normal.length();
        // The normal of a mirrored film points backwards: both numbers are then negative for a ray that points forwards.
        let height = (corner - self.shift).dot(normal) / pixel;
        let w = w.as_dvec3();
        let cos = w.dot(normal) / pixel;
        if cos * height <= 0.0 {
            return None;
        }
        let towards = height / cos * w + self.shift - corner;
        let x = towards.cross(per_y).dot(normal) / (pixel * pixel);
        let y = per_x.cross(towards).dot(normal) / (pixel * pixel);
        let cubed = planted!("film-without-tilt", 1.0, (cos * cos * cos).abs());
        Some(FilmPoint {
            position: DVec2::new(x, y).as_vec2(),
            per_steradian: height * height / (pixel * cubed),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::kernel::types::Everything;
    use crate::math::lanes::load;

    fn camera(lens_radius: f32) -> Camera {
        camera_that(lens_radius, false)
    }

    fn camera_that(lens_radius: f32, is_mirrored: bool) -> Camera {
        Camera::new(&CameraParameters {
            poses: vec![(Vec3::new(0.0, 0.0, 5.0), [DVec3::X, DVec3::Y, DVec3::Z])],
            is_mirrored,
            fov: 90.0_f64.to_radians(),
            size: (200, 100),
            lens_radius,
            focus_distance: 3.0,
        })
    }

    #[test]
    fn changing_the_film_size_keeps_rays_and_scales_per_steradian() {
        let (fine, coarse) = (camera(0.5), camera(0.5).on_film((200, 100), (50, 20)));
        let u = Vec2::new(0.3, 0.8);
        for (x, y) in [(0.0, 0.0), (100.0, 50.0), (60.0, 90.0)] {
            let ray = fine.ray::<Everything>(Vec2::new(x, y), u, 0.0);
            let same = coarse.ray::<Everything>(Vec2::new(x / 4.0, y / 5.0), u, 0.0);
            assert!(ray.origin == same.origin && (ray.dir - same.dir).length() < 1e-6);
            let seen = |camera: &Camera| {
                let viewpoint = camera.viewpoint::<Everything>(u, 0.0);
                viewpoint
                    .film_point(ray.dir)
                    .expect("it is before the camera")
            };
            // A coarse pixel covers 20 fine pixels.
            let ratio = seen(&fine).per_steradian / seen(&coarse).per_steradian;
            assert!((ratio - 20.0).abs() < 1e-4, "{ratio}");
        }
    }

    #[test]
    fn lane_rays_equal_single_rays() {
        let numbers = |step: usize| {
            std::array::from_fn(|lane| (0.618_034 * (step * lane + step) as f32).fract())
        };
        let film = [
            numbers(1).map(|x: f32| 200.0 * x),
            numbers(3).map(|y: f32| 100.0 * y),
        ];
        let (lens, time) = ([numbers(5), numbers(7)], numbers(11));
        let mut moving = camera(0.5);
        let pose = Pose {
            eye: Vec3::new(1.0, -0.2, 5.0),
            ..moving.pose
        };
        moving.motion = vec![moving.pose, pose];
        for camera in [camera(0.0), camera(0.5), moving] {
            let (mut origin, mut dir) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
            camera.ray_lanes::<Everything>(&film, &lens, &time, &mut origin, &mut dir);
            for lane in 0..LANES {
                let at = |of: &[Lanes<f32>; 2]| Vec2::new(of[0][lane], of[1][lane]);
                let alone = camera.ray::<Everything>(at(&film), at(&lens), time[lane]);
                assert_eq!(load::<Vec3>(&origin, lane), alone.origin);
                assert_eq!(load::<Vec3>(&dir, lane), alone.dir);
            }
        }
    }

    #[test]
    fn pinhole_rays_match_the_field_of_view_at_centre_and_corners() {
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
    fn thin_lens_rays_converge_in_the_plane_of_focus() {
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
    fn thin_lens_rays_are_parallel_when_focused_at_infinity() {
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
    fn mirrored_camera_sees_the_image_mirrored() {
        let mirrored = camera_that(0.5, true);
        let u_lens = Vec2::new(0.3, 0.8);
        for (x, y) in [(0.0, 0.0), (30.0, 80.0), (190.0, 10.0)] {
            let ray = mirrored.ray::<Everything>(Vec2::new(x, y), u_lens, 0.0);
            let straight = camera(0.5).ray::<Everything>(Vec2::new(x, y), u_lens, 0.0);
            let flipped = Vec3::new(-1.0, 1.0, 1.0);
            assert!((ray.dir - flipped * straight.dir).length() < 1e-6);
            assert!((ray.origin - flipped * straight.origin).length() < 1e-6);
            let area = |camera: &Camera, w: Vec3| {
                let viewpoint = camera.viewpoint::<Everything>(u_lens, 0.0);
                let found = viewpoint.film_point(w).expect("it goes forwards");
                found.per_steradian
            };
            let ratio = area(&mirrored, ray.dir) / area(&camera(0.5), straight.dir);
            assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
        }
    }

    #[test]
    fn film_point_is_the_inverse_of_camera_ray_generation() {
        for (lens_radius, is_mirrored) in [(0.0, false), (0.5, false), (0.0, true), (0.5, true)] {
            for focus_distance in [0.7, 3.0, f32::INFINITY] {
                let mut camera = camera_that(lens_radius, is_mirrored);
                camera.focus_distance = focus_distance;
                for i in 0..200 {
                    let u = |k: f32| (k * i as f32).fract();
                    let film = Vec2::new(200.0 * u(0.618), 100.0 * u(0.414));
                    let u_lens = Vec2::new(u(0.732), u(0.236));
                    let ray = camera.ray::<Everything>(film, u_lens, 0.0);
                    let viewpoint = camera.viewpoint::<Everything>(u_lens, 0.0);
                    assert_eq!(viewpoint.p, ray.origin);
                    let found = viewpoint.film_point(ray.dir).expect("it goes forwards");
                    let off = (found.position - film).length();
                    assert!(off < 1e-3, "{film} {found:?}");
                    assert_eq!(viewpoint.film_point(-ray.dir), None);
                }
            }
        }
    }

    /// The solid angle of a small square of film is approximated by the parallelogram that the directions of its
    /// corners span.
    #[test]
    fn film_area_per_steradian_matches_finite_differences() {
        for lens_radius in [0.0, 0.5] {
            let camera = camera(lens_radius);
            for (x, y) in [(100.0, 50.0), (3.0, 90.0), (190.0, 10.0)] {
                for u_lens in [Vec2::new(0.5, 0.5), Vec2::new(0.9, 0.2)] {
                    let dir = |dx: f32, dy: f32| {
                        let film = Vec2::new(x + dx, y + dy);
                        let ray = camera.ray::<Everything>(film, u_lens, 0.0);
                        ray.dir.as_dvec3()
                    };
                    let across = dir(2.0, 0.0) - dir(-2.0, 0.0);
                    let down = dir(0.0, 2.0) - dir(0.0, -2.0);
                    let steradians = across.cross(down).length();
                    let viewpoint = camera.viewpoint::<Everything>(u_lens, 0.0);
                    let found = viewpoint.film_point(dir(0.0, 0.0).as_vec3a());
                    let claimed = found.expect("it goes forwards").per_steradian;
                    // Curvature over 4 of 100 pixels, squared.
                    assert!((claimed * steradians / 16.0 - 1.0).abs() < 2e-3);
                }
            }
        }
    }

    #[test]
    fn zero_radius_lens_ray_is_independent_of_the_lens_sample() {
        let film = Vec2::new(30.0, 80.0);
        let pinhole = camera(0.0).ray::<Everything>(film, Vec2::ZERO, 0.0);
        assert_eq!(
            camera(0.0).ray::<Everything>(film, Vec2::new(0.7, 0.2), 0.0),
            pinhole
        );
    }
}
