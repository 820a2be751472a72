//! Surface interaction: a point of a path on a surface, with its frame and the rays that leave it.
//!
//! Measure: normalised scene units; `wo` in world axes, BSDF directions in the shading frame.
//! Range: any hit returned by the scene's acceleration structure.
//! Source: shading normals after Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System",
//! appendix A.3. Tested below and in `tests/tracing/rays.rs`.

pub mod lanes;

use crate::accel::{Hit, PrimitiveId};
use crate::effects::{EffectState, Effects, Slot, Switch};
use crate::geometry::surface::SurfacePoint;
use crate::light::types::{Receiver, ShadowRayEnd};
use crate::math::frame::Frame;
use crate::math::ray::Ray;
use crate::math::robust::{gamma, offset_point};
use crate::math::vec::{Vec2, Vec3, Vector, reflect};
use crate::planted::planted;

/// A surface interaction, with the fields that a kernel for the effects `E` needs.
#[derive(Debug, Clone, Copy)]
pub struct Interaction<E: Effects, V: Vector = Vec3> {
    /// The primitive.
    pub id: PrimitiveId,
    /// Position.
    pub p: V,
    /// Bound on the rounding error of `p`.
    pub error: V,
    /// Geometric normal, as defined by the shape.
    pub ng: V,
    /// +1 if `wo` is on the side of `ng`, -1 otherwise.
    side: f32,
    /// Whether the shading normal equals the geometric one, so that every direction is on the same side of both.
    is_flat: EffectState<E::ShadingNormals, bool>,
    /// Shading normal, as defined by the shape, on the side of `ng`.
    ns: EffectState<E::ShadingNormals, V>,
    /// Shading frame.
    pub frame: Frame<V>,
    /// Texture coordinate.
    pub uv: EffectState<E::Textures, Vec2>,
    /// Unit vector back along the path.
    pub wo: V,
}

impl<E: Effects, V: Vector> Interaction<E, V> {
    /// Returns the interaction of a ray at a hit. On a transmissive surface the frame's normal points outwards, on
    /// others to the side that the ray came from.
    #[inline(always)]
    pub fn new(
        ray: &Ray<V>,
        hit: &Hit,
        surface: &SurfacePoint<V>,
        transmits: bool,
        uv: EffectState<E::Textures, Vec2>,
    ) -> Self {
        let wo = -ray.dir;
        let is_flat = !E::ShadingNormals::ON || surface.ns == surface.ng;
        let (side, frame) = side_and_frame::<E, V>(wo, surface.ng, surface.ns, is_flat, transmits);
        Self {
            id: hit.id,
            p: surface.p,
            error: surface.error,
            ng: surface.ng,
            side,
            is_flat: Slot::new(|| is_flat),
            ns: Slot::new(|| surface.ns),
            frame,
            uv,
            wo,
        }
    }

    /// Returns the interaction at the same point for another unit vector `wo`.
    #[inline]
    pub fn with_wo(&self, wo: V, transmits: bool) -> Self {
        let (is_flat, ns) = (self.is_flat.or(true), self.ns.or(self.ng));
        let (side, frame) = side_and_frame::<E, V>(wo, self.ng, ns, is_flat, transmits);
        Self {
            side,
            frame,
            wo,
            ..*self
        }
    }

    /// Whether the shading normal equals the geometric one.
    #[inline]
    pub fn is_flat(&self) -> bool {
        self.is_flat.or(true)
    }

    /// Whether the shading normal has to be tilted for the unit vector `w`, on either side: the BSDF is then not reciprocal.
    /// Free of branches.
    #[inline(always)]
    pub fn is_tilted_for(&self, w: V) -> bool {
        let ns = self.ns.or(self.ng);
        let side = if w.dot(self.ng) < 0.0 { -1.0 } else { 1.0 };
        !self.is_flat.or(true) & !is_reflected_outwards(w, self.ng * side, ns * side)
    }

    /// Whether `wo` is on the back of the surface.
    #[inline]
    pub fn is_behind(&self) -> bool {
        self.side < 0.0
    }

    /// Whether `w`, reflected or transmitted in the shading frame, is on the corresponding side of the geometric
    /// surface. If both normals are equal, a grazing direction may only differ by rounding, which is ignored.
    #[inline(always)]
    pub fn is_consistent_side(&self, w: V, is_transmitted: bool) -> bool {
        let is_flat = planted!("sides-unchecked", true, self.is_flat.or(true));
        is_flat || (w.dot(self.ng) * self.side < 0.0) == is_transmitted
    }

    /// Returns the geometric normal on the side on which a reflected or transmitted direction leaves.
    #[inline(always)]
    pub fn exit_normal(&self, is_transmitted: bool) -> V {
        let side = if is_transmitted {
            -self.side
        } else {
            self.side
        };
        self.ng * side
    }

    /// Returns the point of the surface with its geometric normal, as the end of a shadow ray.
    #[inline(always)]
    pub fn surface_point(&self) -> SurfacePoint<V> {
        SurfacePoint {
            p: self.p,
            error: self.error,
            ng: self.ng,
            ns: self.ng,
        }
    }

    /// Returns the shadow ray in direction `w` to a point of a surface, open at both ends. Free of branches.
    #[inline(always)]
    pub fn ray_to_surface(&self, other: &SurfacePoint<V>, w: V, is_transmitted: bool) -> Ray<V> {
        let from = offset_point(self.p, self.error, self.exit_normal(is_transmitted));
        // A ray's rounding error grows with its length: at its end it adds to that of the surface.
        let length = planted!("long-rays-exact", V::splat(0.0), (other.p - self.p).abs());
        let error = other.error + length * gamma(8);
        let normal = if other.ng.dot(w) < 0.0 {
            other.ng
        } else {
            -other.ng
        };
        Ray::between(from, offset_point(other.p, error, normal))
    }
}

impl<E: Effects> Interaction<E> {
    /// The point as a receiver of light, on a surface that transmits or not.
    #[inline]
    pub fn receiver(&self, transmits: bool) -> Receiver {
        Receiver {
            p: self.p,
            normal: if transmits { Vec3::ZERO } else { self.frame.n },
        }
    }

    /// Returns the shadow ray in direction `w` to the end of a light sample, open at both ends.
    #[inline]
    pub fn ray_to(&self, end: &ShadowRayEnd, w: Vec3, is_transmitted: bool) -> Ray {
        let from = || offset_point(self.p, self.error, self.exit_normal(is_transmitted));
        match end {
            ShadowRayEnd::Surface(other, _) => self.ray_to_surface(other, w, is_transmitted),
            ShadowRayEnd::Point(point) => Ray::to_point(from(), *point),
            ShadowRayEnd::Infinity => Ray::new(from(), w),
        }
    }
}

/// Returns the side of a surface on which `wo` is, and the shading frame for it.
#[inline(always)]
fn side_and_frame<E: Effects, V: Vector>(
    wo: V,
    ng: V,
    ns: V,
    is_flat: bool,
    transmits: bool,
) -> (f32, Frame<V>) {
    // On the back, both normals are flipped to the side of `wo` while the shading normal is corrected.
    let side = if wo.dot(ng) < 0.0 { -1.0 } else { 1.0 };
    let normal = if E::ShadingNormals::ON && !is_flat {
        correct_shading_normal(wo, ng * side, ns * side)
    } else {
        ng * side
    };
    let is_outwards = E::Transmission::ON && transmits;
    let normal = normal * if is_outwards { side } else { 1.0 };
    (side, Frame::from_normal(normal))
}

/// Returns the shading normal, tilted towards `ng` by as little as needed for the mirror direction of `wo` not to be
/// below the surface: reflections at interpolated normals stay above it, and `wo` is never on the back of the normal.
/// `wo` is on the side of `ng`.
#[inline(always)]
fn correct_shading_normal<V: Vector>(wo: V, ng: V, ns: V) -> V {
    if is_reflected_outwards(wo, ng, ns) {
        return ns;
    }
    let mirrored = reflect(wo, ns);
    let tangent = (mirrored - ng * mirrored.dot(ng)).normalize_or(V::splat(0.0));
    (wo + tangent).normalize_or(ng)
}

/// Whether a mirror with the normal `ns` reflects `wo` to the side of `ng`, and `wo` is on the front of it.
#[inline(always)]
fn is_reflected_outwards<V: Vector>(wo: V, ng: V, ns: V) -> bool {
    (reflect(wo, ns).dot(ng) >= 0.0) & (wo.dot(ns) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corrected_normal_faces_viewer_and_reflects_above_surface() {
        let ng = Vec3::Z;
        for i in 0..200 {
            for j in 0..50 {
                let (a, b) = (i as f32 * 0.1, j as f32 * 0.0314);
                let wo = Vec3::new(b.sin() * a.cos(), b.sin() * a.sin(), b.cos());
                let ns = Vec3::new(0.8, 0.0, 0.6);
                let mended = correct_shading_normal(wo, ng, ns);
                assert!((mended.length() - 1.0).abs() < 1e-5);
                assert!(mended.dot(wo) > 0.0 || b > 1.5, "{wo} {mended}");
                assert!(reflect(wo, mended).dot(ng) > -1e-3, "{wo} {mended}");
            }
        }
    }

    #[test]
    fn valid_shading_normal_is_unchanged() {
        let ns = Vec3::new(0.1, 0.0, 0.99).normalize();
        assert_eq!(correct_shading_normal(Vec3::Z, Vec3::Z, ns), ns);
    }
}
