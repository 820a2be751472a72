//! A point on a surface that a path has come to, with the way back and the ways onward.
//!
//! Measure: normalised scene units; `wo` in world axes, BSDF directions in the shading frame.
//! Range: any hit of the scene's own acceleration structure.
//! Source: shading normals after Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System",
//! appendix A.3. Tested below and in `tests/tracing.rs`.

use crate::accel::{Departure, Hit, PrimitiveId};
use crate::geometry::surface::SurfacePoint;
use crate::math::frame::Frame;
use crate::math::ray::Ray;
use crate::math::robust::{gamma, offset_point};
use crate::math::vec::{Vec2, Vec3, reflect};

/// A point of a path.
#[derive(Debug, Clone, Copy)]
pub struct Interaction {
    /// The primitive.
    pub id: PrimitiveId,
    /// Where it is.
    pub p: Vec3,
    /// Bound of the rounding error of `p`.
    pub error: Vec3,
    /// Geometric normal.
    pub ng: Vec3,
    /// Shading frame.
    pub frame: Frame,
    /// Texture coordinate.
    pub uv: Vec2,
    /// Unit vector back along the path.
    pub wo: Vec3,
}

impl Interaction {
    /// The interaction of a ray at a hit. On a surface that light passes through, the frame's normal points outwards;
    /// on others to the side that the ray came from.
    #[inline]
    pub fn new(ray: &Ray, hit: &Hit, surface: &SurfacePoint, transmits: bool) -> Self {
        let wo = -ray.dir;
        // Seen from behind, both normals are turned to the viewer while the shading normal is mended.
        let side = if wo.dot(surface.ng) < 0.0 { -1.0 } else { 1.0 };
        let ns = mend_shading_normal(wo, side * surface.ng, side * surface.ns);
        let ns = if transmits { side * ns } else { ns };
        Self {
            id: hit.id,
            p: surface.p,
            error: surface.error,
            ng: surface.ng,
            frame: Frame::from_normal(ns),
            uv: surface.uv,
            wo,
        }
    }

    /// Whether a direction is on the same side of the true surface as the viewer.
    #[inline]
    pub fn is_reflection(&self, w: Vec3) -> bool {
        w.dot(self.ng) * self.wo.dot(self.ng) > 0.0
    }

    /// The ray that leaves along the unit vector `w`, and what it leaves.
    #[inline]
    pub fn spawn(&self, w: Vec3, free_distance: f32) -> (Ray, Departure) {
        let origin = offset_point(self.p, self.error, self.ng, w);
        (
            Ray::new(origin, w),
            Departure {
                id: self.id,
                free_distance,
            },
        )
    }

    /// The segment to a point of another surface, in direction `w`, open at both ends.
    #[inline]
    pub fn segment_to(&self, other: &SurfacePoint, w: Vec3) -> Ray {
        let from = offset_point(self.p, self.error, self.ng, w);
        // A ray's rounding grows with its length: at its end it adds to that of the surface.
        let rounding = gamma(8) * (other.p - self.p).abs();
        let to = offset_point(other.p, other.error + rounding, other.ng, -w);
        Ray::between(from, to)
    }
}

/// The shading normal, tilted just so far towards `ng` that the mirror image of `wo` does not go below the surface: a
/// reflection seen in an interpolated normal stays a reflection, and no viewer sees a surface from behind. `wo` is on
/// the side of `ng`.
#[inline]
fn mend_shading_normal(wo: Vec3, ng: Vec3, ns: Vec3) -> Vec3 {
    let mirrored = reflect(wo, ns);
    let below = mirrored.dot(ng);
    if below >= 0.0 && wo.dot(ns) > 0.0 {
        return ns;
    }
    let tangent = (mirrored - below * ng).normalize_or_zero();
    (wo + tangent).normalize_or(ng)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mended_normal_reflects_above_the_surface_and_faces_the_viewer() {
        let ng = Vec3::Z;
        for i in 0..200 {
            for j in 0..50 {
                let (a, b) = (i as f32 * 0.1, j as f32 * 0.0314);
                let wo = Vec3::new(b.sin() * a.cos(), b.sin() * a.sin(), b.cos());
                let ns = Vec3::new(0.8, 0.0, 0.6);
                let mended = mend_shading_normal(wo, ng, ns);
                assert!((mended.length() - 1.0).abs() < 1e-5);
                assert!(mended.dot(wo) > 0.0 || b > 1.5, "{wo} {mended}");
                assert!(reflect(wo, mended).dot(ng) > -1e-3, "{wo} {mended}");
            }
        }
    }

    #[test]
    fn a_harmless_normal_stays() {
        let ns = Vec3::new(0.1, 0.0, 0.99).normalize();
        assert_eq!(mend_shading_normal(Vec3::Z, Vec3::Z, ns), ns);
    }
}
