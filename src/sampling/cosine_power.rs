//! Sampling of the Phong lobe: directions about z with a density in proportion to a power of the cosine.
//!
//! Measure: densities per steradian. Angles are given as 1 - cos, because the cosine itself has no digits of small angles.
//! Range: exponents n from 0 (the uniform hemisphere) to 1e6; u in [0, 1 - 2^-24] in each dimension. The density is 0
//! from 90 degrees on.
//! Source: Lafortune and Willems 1994, "Using the Modified Phong Reflectance Model for Physically Based Rendering", eq.
//! 8. Tested in `lab/tests/course/warps.rs`, and in `bsdf/phong.rs` against double precision.

use super::warp::invert_sphere_uniform;
use crate::math::functions::{exp, exp_m1, ln_1p};
use crate::math::trig::sin_cos_turns;
use crate::math::vec::{Vec2, Vec3};
use std::f32::consts::PI;

/// 1 - cos of the angle between two unit vectors, as half of their squared chord, which is precise for small angles.
#[inline]
pub fn one_minus_cos(a: Vec3, b: Vec3) -> f32 {
    0.5 * (a - b).length_squared()
}

/// cos^n of an angle below 90 degrees, else 0.
#[inline]
pub fn cosine_power(one_minus_cos: f32, n: f32) -> f32 {
    if one_minus_cos < 1.0 {
        exp(n * ln_1p(-one_minus_cos))
    } else {
        0.0
    }
}

/// Samples a direction about z with density (n + 1) / (2 pi) cos^n: cos = (1 - u)^(1 / (n + 1)).
#[inline]
pub fn sample_cosine_power(u: Vec2, n: f32) -> Vec3 {
    let one_minus_cos = -exp_m1(ln_1p(-u.x) / (n + 1.0));
    let sin = (one_minus_cos * (2.0 - one_minus_cos)).sqrt();
    let (sin_phi, cos_phi) = sin_cos_turns(u.y);
    Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - one_minus_cos)
}

/// Density of [`sample_cosine_power`] per steradian.
#[inline]
pub fn pdf_cosine_power(one_minus_cos: f32, n: f32) -> f32 {
    (n + 1.0) * (cosine_power(one_minus_cos, n) / (2.0 * PI))
}

/// The u that [`sample_cosine_power`] maps to `w`: 1 - cos^(n + 1), and the azimuth.
pub fn invert_cosine_power(w: Vec3, n: f32) -> Vec2 {
    let log_cos = ln_1p(-one_minus_cos(w, Vec3::Z));
    Vec2::new(-exp_m1((n + 1.0) * log_cos), invert_sphere_uniform(w).y)
}
