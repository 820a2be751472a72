//! Uniform sampling of a triangle by the square-root map, as courses derive it.
//!
//! Measure: barycentric coordinates (b1, b2); densities per unit of b1 b2, in which the triangle has area 1/2. Per unit
//! of surface area the density is 1 / area.
//! Range: u in [0, 1 - 2^-24] in each dimension; every point lies in the triangle.
//! Source: inversion: b1 has the density 2 (1 - b1), and b2 is uniform in [0, 1 - b1]. Turk 1990, "Generating Random
//! Points in Triangles". Tested in `lab/tests/course/warps.rs`. Rendering uses the folded square of `warp.rs`.

use crate::math::vec::Vec2;

/// Samples a uniform point: b1 = 1 - sqrt(1 - u), b2 = v sqrt(1 - u).
pub fn sample_triangle_by_root(u: Vec2) -> Vec2 {
    let rest = (1.0 - u.x).sqrt();
    // 1 - sqrt(1 - u) = u / (1 + sqrt(1 - u)) does not cancel.
    let b1 = u.x / (1.0 + rest);
    Vec2::new(b1, (u.y * rest).min(1.0 - b1))
}

/// Density of [`sample_triangle_by_root`] at (b1, b2).
pub fn pdf_triangle_uniform(b: Vec2) -> f32 {
    if b.min_element() >= 0.0 && b.x + b.y <= 1.0 {
        2.0
    } else {
        0.0
    }
}

/// The u that [`sample_triangle_by_root`] maps to `b`; at b1 = 1, where v is undetermined, its second number is 0.
pub fn invert_triangle_by_root(b: Vec2) -> Vec2 {
    let rest = 1.0 - b.x;
    let v = if rest > 0.0 { b.y / rest } else { 0.0 };
    Vec2::new(b.x * (2.0 - b.x), v)
}
