//! Exact answers that tests compare with.
//!
//! Measure: as said at each.
//! Range: as said at each.
//! Source: named at each.

use super::quadrature::integrate;
use etendue::math::vec::DVec3;
use std::f64::consts::TAU;

/// The directional albedo of a GGX-Smith mirror (F = 1, height-correlated, single scattering) of `alpha` 1, .5, .3 and
/// .1 seen along the normal. At alpha 1 it is 1 - ln 2, since D is 1 / pi and G1 2 mu / (1 + mu); the others are
/// quadratures.
pub const GGX_NORMAL_ALBEDO: [(f32, f64); 4] = [
    (1.0, 1.0 - std::f64::consts::LN_2),
    (0.5, 0.687_848_5),
    (0.3, 0.877_358_4),
    (0.1, 0.988_304_1),
];

/// The cosine-weighted mean of Fresnel's reflectance at a dielectric of index 1.5, from outside.
pub const FRESNEL_MEAN_OUTSIDE: f64 = 0.091_777_959_34;

/// The same from inside; 1 - F_inside = (1 - F_outside) / n^2.
pub const FRESNEL_MEAN_INSIDE: f64 = 0.596_345_759_71;

/// The normal reflectance of a dielectric: ((n - 1) / (n + 1))^2.
pub fn normal_reflectance(n: f64) -> f64 {
    ((n - 1.0) / (n + 1.0)).powi(2)
}

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

/// The solid angle of a triangle relative to the viewpoint: the integral of cos / r^2 over it where it looks small, else
/// the excess of its angles over pi.
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

/// The configuration factor of a rectangle a x b parallel to an element at distance c under one of its corners (C-11 of
/// Howell's catalogue).
pub fn parallel_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let part = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
    (part(a / c, b / c) + part(b / c, a / c)) / TAU
}

/// That of a rectangle of height a and width b at right angles to an element at distance c from its lower corner (C-12).
pub fn perpendicular_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / b, c / b);
    ((1.0 / y).atan() - y / x.hypot(y) * (1.0 / x.hypot(y)).atan()) / TAU
}

/// The form factor of a disc of radius r1 to a coaxial one of radius r2 at distance h (C-41).
pub fn coaxial_discs(r1: f64, r2: f64, h: f64) -> f64 {
    let x = 1.0 + (h * h + r2 * r2) / (r1 * r1);
    0.5 * (x - (x * x - 4.0 * (r2 / r1).powi(2)).sqrt())
}

/// Lambert's formula: the configuration factor of a polygon whose vertices are given relative to an element with normal z;
/// what is below the horizon is cut off.
pub fn lambert_polygon(vertices: &[DVec3]) -> f64 {
    let next = |v: &[DVec3], i: usize| v[(i + 1) % v.len()];
    let mut above = Vec::new();
    for (i, &a) in vertices.iter().enumerate() {
        let b = next(vertices, i);
        if a.z >= 0.0 {
            above.push(a);
        }
        if (a.z >= 0.0) != (b.z >= 0.0) {
            above.push(a + (b - a) * (a.z / (a.z - b.z)));
        }
    }
    let sum: f64 = (0..above.len())
        .map(|i| {
            let cross = above[i].cross(next(&above, i));
            let angle = cross.length().atan2(above[i].dot(next(&above, i)));
            angle * cross.z / cross.length().max(f64::MIN_POSITIVE)
        })
        .sum();
    sum.abs() / TAU
}
