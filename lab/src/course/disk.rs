//! Points on the unit disk as sampled in the course: the wrong polar map, the right one, and rejection.
//!
//! Measure: densities per unit of area.
//! Range: u in [0, 1 - 2^-24] in each dimension; every point has a length of at most 1, up to rounding.
//! Source: inversion: the fraction of the disk within r is r^2, so that r = sqrt(u). Renderers use
//! [`sample_disk_concentric`], which also preserves the shape of strata. Tested in `lab/tests/course/warps.rs` and
//! `lab/tests/course/rejection.rs`.
//!
//! [`sample_disk_concentric`]: etendue::internals::sampling::warp::sample_disk_concentric

use super::rejection::{Accepted, MAX_TRIALS, sample_until};
use etendue::internals::math::trig::sin_cos_turns;
use etendue::internals::math::vec::{Vec2, Vec3};
use etendue::internals::sampling::warp::{invert_sphere_uniform, pdf_disk_concentric};
use std::f32::consts::PI;

/// The efficiency of [`sample_disk_by_rejection`]: the area of the disk over that of its square.
pub const DISK_IN_SQUARE: f64 = std::f64::consts::FRAC_PI_4;

/// The classic mistake: r = u, which is NOT uniform, as half of all points fall into a quarter of the area. Treating
/// its points as uniform is an error; with its own density it is a valid sampling method.
pub fn sample_disk_crowded_at_the_centre(u: Vec2) -> Vec2 {
    at_polar(u.x, u.y)
}

/// The density of [`sample_disk_crowded_at_the_centre`]: 1 / (2 pi r), infinite at the centre.
pub fn pdf_disk_crowded_at_the_centre(p: Vec2) -> f32 {
    let r = p.length();
    if r <= 1.0 { 1.0 / (2.0 * PI * r) } else { 0.0 }
}

/// The u that [`sample_disk_crowded_at_the_centre`] maps to `p`.
pub fn invert_disk_crowded_at_the_centre(p: Vec2) -> Vec2 {
    Vec2::new(p.length(), turns(p))
}

/// A uniform point: r = sqrt(u), phi = 2 pi v.
pub fn sample_disk_polar(u: Vec2) -> Vec2 {
    at_polar(u.x.sqrt(), u.y)
}

/// The density of [`sample_disk_polar`] and of [`sample_disk_by_rejection`]: 1 / pi inside.
pub fn pdf_disk_uniform(p: Vec2) -> f32 {
    pdf_disk_concentric(p)
}

/// The u that [`sample_disk_polar`] maps to `p`.
pub fn invert_disk_polar(p: Vec2) -> Vec2 {
    Vec2::new(p.length_squared(), turns(p))
}

/// A uniform point: the first random point of the square that lies in the disk. `None` if all of [`MAX_TRIALS`] points
/// lie outside, which happens with a broken generator only.
pub fn sample_disk_by_rejection(uniform: &mut impl FnMut() -> f32) -> Option<Accepted<Vec2>> {
    sample_until(MAX_TRIALS, || {
        let p = 2.0 * Vec2::new(uniform(), uniform()) - Vec2::ONE;
        (p.length_squared() <= 1.0).then_some(p)
    })
}

fn at_polar(r: f32, turns: f32) -> Vec2 {
    let (sin, cos) = sin_cos_turns(turns);
    r * Vec2::new(cos, sin)
}

/// The azimuth in turns, from 0 to 1.
fn turns(p: Vec2) -> f32 {
    invert_sphere_uniform(Vec3::new(p.x, p.y, 0.0)).y
}
