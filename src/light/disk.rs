//! A disk light, sampled by area: solid angle sampling of a disk has no elementary inversion.
//!
//! Measure: densities per steradian.
//! Range: any receiver off the disk's plane.
//! Source: Shirley and Chiu 1997 for the map. Tested in `tests/lights/light.rs`.

use super::types::{Emission, LightSample, ShadowRayEnd};
use crate::geometry::disk::Disk;
use crate::geometry::surface::SurfacePoint;
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::vec::{Vec2, Vec3};
use crate::sampling::warp;
use std::f64::consts::PI;

/// An emitting disk.
#[derive(Debug, Clone, Copy)]
pub struct DiskLight {
    disk: Disk,
    emission: Emission,
}

impl DiskLight {
    /// Creates a light from a disk.
    pub fn new(disk: Disk, emission: Emission) -> Self {
        Self { disk, emission }
    }

    /// The disk.
    pub fn disk(&self) -> &Disk {
        &self.disk
    }

    /// Radiant power in normalised units.
    pub fn power(&self) -> f64 {
        self.emission.power(self.area())
    }

    /// The emission of the surface.
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// Samples a point uniformly by area.
    pub fn point(&self, u: Vec2) -> SurfacePoint {
        let d = self.disk.radius * warp::sample_disk_concentric(u);
        self.disk.surface_at(d)
    }

    /// The density of [`point`](Self::point).
    pub fn pdf_area(&self) -> PdfArea {
        PdfArea((1.0 / self.area()) as f32)
    }

    /// Samples a point on the light for the receiver `p`.
    #[inline]
    pub fn sample(&self, p: Vec3, u: Vec2) -> Option<LightSample> {
        let point = self.point(u);
        let towards = point.p - p;
        let wi = towards.normalize();
        let cos = -wi.dot(point.ng);
        Some(LightSample {
            wi,
            radiance: self.emission.towards(cos),
            pdf: Some(self.pdf(towards.length_squared(), cos)?),
            end: ShadowRayEnd::Surface(point, [0.0; 2]),
        })
    }

    /// The density of [`sample`](Self::sample) at the point at squared distance `distance2` whose normal has cosine `cos`
    /// with the direction to the receiver.
    #[inline]
    pub fn pdf(&self, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        self.pdf_area().to_solid_angle(distance2, cos)
    }

    fn area(&self) -> f64 {
        let radius = f64::from(self.disk.radius);
        PI * radius * radius
    }
}
