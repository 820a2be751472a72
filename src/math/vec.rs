//! The vector types: glam's, in single precision for tracing and shading, in double precision for loading.
//!
//! `Vec3` has four lanes in one SIMD register, the last of which is unused. `LaneVec3` has three numbers, for loops
//! over lanes, which keep the components of as many vectors as there are lanes in three registers.
//!
//! Measure: positions in normalised scene units, directions of unit length unless said otherwise.
//! Range: that of `f32` and `f64`.
//! Source: glam. Tested there and below.

pub use glam::{
    DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, Mat3, Vec2, Vec3 as LaneVec3, Vec3A as Vec3,
    Vec3Swizzles, Vec4,
};

/// The largest `f32` below one: the greatest value that a uniform random number takes.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// The mirror image of `w` about the unit vector `n`; both point away from the surface.
#[inline]
pub fn reflect(w: Vec3, n: Vec3) -> Vec3 {
    2.0 * w.dot(n) * n - w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_keeps_the_angle_and_changes_the_side() {
        let n = Vec3::new(0.0, 0.0, 1.0);
        let w = Vec3::new(0.6, 0.0, 0.8);
        assert!((reflect(w, n) - Vec3::new(-0.6, 0.0, 0.8)).length() < 1e-6);
    }
}
