//! An exact flat disk.
//!
//! Measure: normalised scene units.
//! Range: radius above 0, normal of unit length.
//! Source: none needed. Tested in `tests/tracing.rs`.

use super::surface::SurfacePoint;
use crate::math::bounds::Bounds;
use crate::math::frame::Frame;
use crate::math::robust::gamma;
use crate::math::vec::{Vec2, Vec3};

/// A disk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// Centre.
    pub center: Vec3,
    /// Normal, of unit length.
    pub normal: Vec3,
    /// Radius.
    pub radius: f32,
}

impl Disk {
    /// The box around it.
    pub fn bounds(&self) -> Bounds {
        let n = self.normal.as_dvec3();
        // The rim reaches r sqrt(1 - n_i^2) along axis i.
        let reach = f64::from(self.radius) * (1.0 - n * n).max(glam::DVec3::ZERO).map(f64::sqrt);
        let center = self.center.as_dvec3();
        Bounds {
            min: center - reach,
            max: center + reach,
        }
    }

    /// The point of the disk's plane next to `near`.
    #[inline]
    pub fn surface_near(&self, near: Vec3) -> SurfacePoint {
        self.surface_at(self.in_frame(near))
    }

    /// The point at `d` in the frame of the normal, in units of length.
    #[inline]
    pub fn surface_at(&self, d: Vec2) -> SurfacePoint {
        let frame = Frame::from_normal(self.normal);
        SurfacePoint {
            p: self.center + d.x * frame.s + d.y * frame.t,
            error: gamma(8) * (self.center.abs() + Vec3::splat(self.radius)),
            ng: self.normal,
            ns: self.normal,
        }
    }

    /// The texture coordinate of a point of the disk: the square around it is [0, 1].
    #[inline]
    pub fn uv_at(&self, p: Vec3) -> Vec2 {
        0.5 * (self.in_frame(p) / self.radius + Vec2::ONE)
    }

    /// The directions in which u and v grow.
    pub fn tangents(&self) -> [Vec3; 2] {
        let frame = Frame::from_normal(self.normal);
        [frame.s, frame.t]
    }

    /// A point in the frame of the normal, in units of length.
    #[inline]
    fn in_frame(&self, p: Vec3) -> Vec2 {
        let frame = Frame::from_normal(self.normal);
        let offset = p - self.center;
        Vec2::new(offset.dot(frame.s), offset.dot(frame.t))
    }
}
