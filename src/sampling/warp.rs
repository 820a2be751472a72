//! Maps from uniform numbers in [0, 1) to directions and points, each with its density.
//!
//! Measure: densities per steradian or per unit of area, as stated at each function.
//! Range: u in [0, 1 - 2^-24] in each dimension; every result is finite and inside its domain.
//! Source: named at each function. Round trips and chi-square tests in `tests/sampling/warps.rs`.

use crate::math::functions::atan2;
use crate::math::lanes::{LANES, Lanes, store, vectorised};
use crate::math::trig::{sin_cos_eighth, sin_cos_turns};
use crate::math::vec::{LaneVec3, Vec2, Vec3, Vector};
use crate::planted::planted;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// Samples a uniform point on the unit disk by the concentric map, which keeps neighbours together.
///
/// Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
#[inline(always)]
pub fn sample_disk_concentric(u: Vec2) -> Vec2 {
    let Vec2 { x, y } = 2.0 * u - Vec2::ONE;
    // Four quadrants of the square, each around one axis, from which the angle is measured.
    let along_x = x.abs() > y.abs();
    let radius = if along_x { x } else { y };
    let across = if along_x { y } else { x };
    // At the centre both are 0, and their ratio is taken as 0.
    let share = across / if radius == 0.0 { 1.0 } else { radius };
    let (sin, cos) = sin_cos_eighth(FRAC_PI_4 * share);
    radius
        * if along_x {
            Vec2::new(cos, sin)
        } else {
            Vec2::new(sin, cos)
        }
}

/// Density of [`sample_disk_concentric`] per unit of area: 1 / pi inside.
#[inline]
pub fn pdf_disk_concentric(p: Vec2) -> f32 {
    if p.length_squared() <= 1.0 {
        FRAC_1_PI
    } else {
        0.0
    }
}

/// The u that [`sample_disk_concentric`] maps to `p`.
pub fn invert_disk_concentric(p: Vec2) -> Vec2 {
    let radius = p.length();
    let mut angle = atan2(p.y, p.x);
    if angle < -FRAC_PI_4 {
        angle += 2.0 * PI;
    }
    // Four quadrants of the square, each around one axis.
    let offset = if angle < FRAC_PI_4 {
        Vec2::new(radius, angle * radius / FRAC_PI_4)
    } else if angle < 3.0 * FRAC_PI_4 {
        Vec2::new(-(angle - FRAC_PI_2) * radius / FRAC_PI_4, radius)
    } else if angle < 5.0 * FRAC_PI_4 {
        Vec2::new(-radius, -(angle - PI) * radius / FRAC_PI_4)
    } else {
        Vec2::new((angle - 3.0 * FRAC_PI_2) * radius / FRAC_PI_4, -radius)
    };
    0.5 * (offset + Vec2::ONE)
}

/// Samples a direction on the upper hemisphere with density cos / pi, by projecting the disk up (Malley's method).
#[inline(always)]
pub fn sample_hemisphere_cosine(u: Vec2) -> Vec3 {
    lift(u).into()
}

vectorised! {
    /// [`sample_hemisphere_cosine`] for each lane.
    pub fn sample_hemisphere_cosine_lanes(u: &[Lanes<f32>; 2], directions: &mut [Lanes<f32>; 3]) {
        let [u, v] = u;
        for lane in 0..LANES {
            store(directions, lane, lift(Vec2::new(u[lane], v[lane])));
        }
    }
}

/// Samples a point of the disk and projects it up to the hemisphere.
#[inline(always)]
fn lift(u: Vec2) -> LaneVec3 {
    let d = sample_disk_concentric(u);
    // Rounding can put the disk's rim at 1 + eps; a tangential direction would have density 0.
    let z = (1.0 - d.length_squared())
        .max(f32::EPSILON * f32::EPSILON)
        .sqrt();
    LaneVec3::new(d.x, d.y, z)
}

/// Density of [`sample_hemisphere_cosine`] per steradian.
#[inline]
pub fn pdf_hemisphere_cosine(cos: f32) -> f32 {
    cos.max(0.0) * FRAC_1_PI
}

/// The u that [`sample_hemisphere_cosine`] maps to `w`.
pub fn invert_hemisphere_cosine(w: Vec3) -> Vec2 {
    invert_disk_concentric(Vec2::new(w.x, w.y))
}

/// Samples a uniform direction on the sphere, by inversion: z is uniform in [-1, 1] (Archimedes).
#[inline]
pub fn sample_sphere_uniform(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    // 1 - z^2 without cancellation at the poles.
    let r = (4.0 * u.x * (1.0 - u.x)).sqrt();
    let (sin, cos) = sin_cos_turns(u.y);
    Vec3::new(r * cos, r * sin, z)
}

/// Density of [`sample_sphere_uniform`] per steradian.
pub const PDF_SPHERE_UNIFORM: f32 = 0.25 * FRAC_1_PI;

/// The u that [`sample_sphere_uniform`] maps to `w`.
pub fn invert_sphere_uniform(w: Vec3) -> Vec2 {
    let phi = atan2(w.y, w.x);
    let phi = if phi < 0.0 { phi + 2.0 * PI } else { phi };
    Vec2::new(0.5 * (1.0 - w.z), phi / (2.0 * PI))
}

/// Samples a uniform direction in the cone around z whose half angle has `1 - cos = one_minus_cos`. This parameter is
/// exact also for small cones.
///
/// Pharr, Jakob and Humphreys, "Physically Based Rendering", uniform cone.
#[inline(always)]
pub fn sample_cone_uniform<V: Vector>(u: Vec2, one_minus_cos: f32) -> V {
    let h = u.x * one_minus_cos;
    let sin = (h * (2.0 - h)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = sin_cos_turns(u.y);
    V::new(sin * cos_phi, sin * sin_phi, 1.0 - h)
}

/// Density of [`sample_cone_uniform`] per steradian, inside the cone.
#[inline]
pub fn pdf_cone_uniform(one_minus_cos: f32) -> f32 {
    1.0 / (planted!("cone-pdf-off-by-two", 4.0, 2.0) * PI * one_minus_cos)
}

/// The u that [`sample_cone_uniform`] maps to `w`.
pub fn invert_cone_uniform(w: Vec3, one_minus_cos: f32) -> Vec2 {
    // 1 - cos = sin^2 / (1 + cos) does not cancel.
    let h = (w.x * w.x + w.y * w.y) / (1.0 + w.z);
    Vec2::new(h / one_minus_cos, invert_sphere_uniform(w).y)
}

/// Samples a uniform point in a triangle; returns its barycentric coordinates (b1, b2).
///
/// Basu and Owen 2015 would preserve strata better; this is the folded square of Heitz 2019, "A Low-Distortion Map
/// Between Triangle and Square", which keeps neighbours together and has no square root.
#[inline]
pub fn sample_triangle_uniform(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let x = 0.5 * u.x;
        Vec2::new(x, u.y - x)
    } else {
        let y = 0.5 * u.y;
        Vec2::new(u.x - y, y)
    }
}

/// The u that [`sample_triangle_uniform`] maps to `b`.
pub fn invert_triangle_uniform(b: Vec2) -> Vec2 {
    if b.y > b.x {
        Vec2::new(2.0 * b.x, b.y + b.x)
    } else {
        Vec2::new(b.x + b.y, 2.0 * b.y)
    }
}
