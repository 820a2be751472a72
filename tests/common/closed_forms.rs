//! Closed forms that tests compare with, in addition to those of the battery.
//!
//! Measure: as said at each.
//! Range: as said at each.
//! Source: named at each.

use super::quadrature::integrate;
use etendue::internals::math::vec::DVec3;
pub use etendue_lab::battery::closed_forms::*;

/// The solid angle of a rectangle at `corner`, relative to the viewpoint: the sum over its corners, with signs, of
/// atan(x y / (z sqrt(x^2 + y^2 + z^2))). Below 1e-3 sr, where that cancels, the integral of cos / r^2 by Gauss-Legendre
/// points.
pub fn rectangle_solid_angle(corner: DVec3, edges: [DVec3; 2]) -> f64 {
    let axes = edges.map(DVec3::normalize);
    let z = corner.dot(axes[0].cross(axes[1])).abs();
    let [x, y] = [0, 1].map(|i| {
        let from = corner.dot(axes[i]);
        [from, from + edges[i].length()]
    });
    let part = |x: f64, y: f64| (x * y).atan2(z * (x * x + y * y + z * z).sqrt());
    let omega = part(x[1], y[1]) - part(x[0], y[1]) - part(x[1], y[0]) + part(x[0], y[0]);
    let nearest = [x, y].map(|[a, b]| 0.0_f64.clamp(a, b));
    let distance = DVec3::new(nearest[0], nearest[1], z).length();
    let size = (x[1] - x[0]).max(y[1] - y[0]);
    if omega > 1e-3 || size > distance {
        return omega;
    }
    integrate(
        |x| integrate(|y| z / (x * x + y * y + z * z).powf(1.5), y[0], y[1], 1),
        x[0],
        x[1],
        1,
    )
}

/// The solid angle of a triangle relative to the viewpoint: the integral of cos / r^2 over it if it subtends a small
/// angle, else the excess of its angles over pi.
pub fn triangle_solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (e1, e2) = (b - a, c - a);
    let normal = e1.cross(e2);
    let distance = a.length().min(b.length()).min(c.length());
    if 2.0 * e1.length().max(e2.length()) < distance {
        // b1 = s, b2 = t (1 - s).
        let density = |s: f64, t: f64| {
            let p = a + s * e1 + t * (1.0 - s) * e2;
            (1.0 - s) * p.dot(normal).abs() / p.length().powi(3)
        };
        return integrate(|s| integrate(|t| density(s, t), 0.0, 1.0, 2), 0.0, 1.0, 2);
    }
    let angle = |a: DVec3, b: DVec3, c: DVec3| {
        let (n, m) = (a.cross(b), a.cross(c));
        n.cross(m).length().atan2(n.dot(m))
    };
    angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - std::f64::consts::PI
}
