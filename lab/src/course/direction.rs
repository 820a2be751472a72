//! Directions as sampled in the course: by rejection, by mirroring the lower hemisphere, and by inversion.
//!
//! Measure: densities per steradian. The hemisphere is the one about z.
//! Range: u in [0, 1 - 2^-24] in each dimension; every direction has unit length up to rounding, and a positive
//! density.
//! Source: the cap of height h has the area 2 pi h (Archimedes), and the fraction 1 - cos^2 of a cosine distribution.
//! The sphere by inversion and the cosine by Malley's method are in [`warp`]. Tested in `lab/tests/course/warps.rs` and
//! `lab/tests/course/rejection.rs`.
//!
//! [`warp`]: etendue::internals::sampling::warp

use super::rejection::{Accepted, MAX_TRIALS, sample_until};
use etendue::internals::math::trig::sin_cos_turns;
use etendue::internals::math::vec::{Vec2, Vec3};
use etendue::internals::sampling::warp::{
    invert_cone_uniform, invert_sphere_uniform, sample_cone_uniform,
};
use std::f32::consts::FRAC_1_PI;

/// The efficiency of [`sample_sphere_by_rejection`]: the volume of the ball over that of its cube.
pub const BALL_IN_CUBE: f64 = std::f64::consts::FRAC_PI_6;

/// The pdf of a uniform direction on the hemisphere.
pub const PDF_HEMISPHERE_UNIFORM: f32 = 0.5 * FRAC_1_PI;

/// A uniform direction: that of the first random point of the cube that lies in the ball. `None` if all of
/// [`MAX_TRIALS`] points lie outside, which happens with a broken generator only.
pub fn sample_sphere_by_rejection(uniform: &mut impl FnMut() -> f32) -> Option<Accepted<Vec3>> {
    sample_until(MAX_TRIALS, || {
        let p = 2.0 * Vec3::new(uniform(), uniform(), uniform()) - Vec3::ONE;
        let length2 = p.length_squared();
        // The centre, and points whose squared length underflows, have no direction.
        (length2 <= 1.0 && length2.is_normal()).then(|| p.normalize())
    })
}

/// A uniform direction on the hemisphere: one of the sphere, mirrored if it points down.
pub fn sample_hemisphere_by_rejection(uniform: &mut impl FnMut() -> f32) -> Option<Accepted<Vec3>> {
    sample_sphere_by_rejection(uniform).map(|drawn| Accepted {
        value: Vec3::new(drawn.value.x, drawn.value.y, drawn.value.z.abs()),
        ..drawn
    })
}

/// A uniform direction on the hemisphere, by inversion: the cosine is uniform, 1 - u.
pub fn sample_hemisphere_uniform(u: Vec2) -> Vec3 {
    sample_cone_uniform(u, 1.0)
}

/// The u that [`sample_hemisphere_uniform`] maps to `w`.
pub fn invert_hemisphere_uniform(w: Vec3) -> Vec2 {
    invert_cone_uniform(w, 1.0)
}

/// A direction on the hemisphere with density cos / pi, by inversion: theta = acos(sqrt(1 - u)), of which only the sine
/// and cosine are needed.
///
/// Its density is [`pdf_hemisphere_cosine`](etendue::internals::sampling::warp::pdf_hemisphere_cosine).
pub fn sample_hemisphere_cosine_by_inversion(u: Vec2) -> Vec3 {
    let (sin, cos) = (u.x.sqrt(), (1.0 - u.x).sqrt());
    let (sin_phi, cos_phi) = sin_cos_turns(u.y);
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// The u that [`sample_hemisphere_cosine_by_inversion`] maps to `w`.
pub fn invert_hemisphere_cosine_by_inversion(w: Vec3) -> Vec2 {
    Vec2::new(w.x * w.x + w.y * w.y, invert_sphere_uniform(w).y)
}
