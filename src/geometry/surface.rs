//! Surface points, with the properties that depend on the shape only.
//!
//! Measure: normalised scene units.
//! Range: `error` bounds the distance of `p` from the true surface in each coordinate, including the error of tracing.
//! Source: Pharr, Jakob, Humphreys, "Physically Based Rendering", section 6.8. Tested in `tests/tracing/rays.rs`.

use crate::math::vec::Vec3;

/// A point on a surface.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint<V = Vec3> {
    /// The position.
    pub p: V,
    /// The bound of the rounding error of each coordinate, including that of a ray query against the same primitive.
    pub error: V,
    /// Geometric normal, of unit length.
    pub ng: V,
    /// Shading normal, of unit length, on the side of `ng`.
    pub ns: V,
}
