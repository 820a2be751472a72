//! An exact flat disk.
//!
//! Measure: normalised scene units.
//! Range: radius above 0, normal of unit length.
//! Source: none needed. Tested in `tests/tracing/rays.rs`.

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
    /// The unit vectors along which the texture coordinates u and v increase, orthogonal to the normal and each other.
    pub axes: [Vec3; 2],
}

impl Disk {
    /// Creates a disk with axes that are derived from its normal, of unit length.
    pub fn new(center: Vec3, normal: Vec3, radius: f32) -> Self {
        let frame = Frame::from_normal(normal);
        Self {
            center,
            normal,
            radius,
            axes: [frame.s, frame.t],
        }
    }

    /// The bounding box.
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

    /// The point of the disk's plane closest to `near`.
    #[inline]
    pub fn surface_near(&self, near: Vec3) -> SurfacePoint {
        self.surface_at(self.in_frame(near))
    }

    /// The point with the coordinates `d` along the axes, in units of length.
    #[inline]
    pub fn surface_at(&self, d: Vec2) -> SurfacePoint {
        let [s, t] = self.axes;
        SurfacePoint {
            p: self.center + d.x * s + d.y * t,
            error: gamma(8) * (self.center.abs() + Vec3::splat(self.radius)),
            ng: self.normal,
            ns: self.normal,
        }
    }

    /// The texture coordinate of a point of the disk: [0, 1] covers the square around the disk.
    #[inline]
    pub fn uv_at(&self, p: Vec3) -> Vec2 {
        0.5 * (self.in_frame(p) / self.radius + Vec2::ONE)
    }

    /// The derivatives of a point of the disk by u and v.
    pub fn tangents(&self) -> [Vec3; 2] {
        self.axes.map(|axis| 2.0 * self.radius * axis)
    }

    /// The coordinates of a point along the axes, in units of length.
    #[inline]
    fn in_frame(&self, p: Vec3) -> Vec2 {
        let [s, t] = self.axes;
        let offset = p - self.center;
        Vec2::new(offset.dot(s), offset.dot(t))
    }
}
