//! Closed forms: the exact answers of the cases.
//!
//! Measure: as stated at each.
//! Range: as stated at each.
//! Source: named at each. Tested through the cases, and the numbers of the catalogue below.

use etendue::internals::math::vec::DVec3;
use std::f64::consts::{PI, TAU};

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

/// The cosine-weighted mean of the reflectance from inside; 1 - F_inside = (1 - F_outside) / n^2.
pub const FRESNEL_MEAN_INSIDE: f64 = 0.596_345_759_71;

/// The normal reflectance of a dielectric: ((n - 1) / (n + 1))^2.
pub fn normal_reflectance(n: f64) -> f64 {
    ((n - 1.0) / (n + 1.0)).powi(2)
}

/// The configuration factor of a rectangle a x b parallel to an element at distance c under one of its corners (C-11 of
/// Howell's catalogue).
pub fn parallel_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let part = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
    (part(a / c, b / c) + part(b / c, a / c)) / TAU
}

/// The configuration factor of a rectangle of height a and width b at right angles to an element at distance c from its
/// lower corner (C-12).
pub fn perpendicular_rectangle(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / b, c / b);
    ((1.0 / y).atan() - y / x.hypot(y) * (1.0 / x.hypot(y)).atan()) / TAU
}

/// The form factor of a disc of radius r1 to a coaxial one of radius r2 at distance h (C-41).
pub fn coaxial_discs(r1: f64, r2: f64, h: f64) -> f64 {
    let x = 1.0 + (h * h + r2 * r2) / (r1 * r1);
    0.5 * (x - (x * x - 4.0 * (r2 / r1).powi(2)).sqrt())
}

/// The configuration factor of a sphere whose centre is `x` radii away, more than 1, along the plane of the element.
pub fn perpendicular_sphere(x: f64) -> f64 {
    let root = (x * x - 1.0).sqrt();
    ((1.0 / root).atan() - root / (x * x)) / PI
}

/// Lambert's formula: the configuration factor of a polygon whose vertices are given relative to an element with normal
/// z; the polygon is clipped at the horizon.
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

/// The solid angle of the rectangle [x0, x1] x [y0, y1] at z = 0, seen from height h above the origin: a signed sum
/// over its corners of the solid angle of a rectangle with one corner right below.
pub fn rectangle_below([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], h: f64) -> f64 {
    let corner = |x: f64, y: f64| (x * y).atan2(h * (x * x + y * y + h * h).sqrt());
    corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
}

/// The fraction of a disc of radius 1 beyond the line at `x`, in [-1, 1].
pub fn disc_segment(x: f64) -> f64 {
    (x.acos() - x * (1.0 - x * x).sqrt()) / PI
}

/// The integral over the sphere of a panorama in which one texel in row `row` of `height` is 1, the others 0,
/// interpolated between texel centres: a tent function that is constant beyond the centre of a row at a pole.
pub fn bright_texel(row: u32, width: u32, height: u32) -> f64 {
    let step = PI / f64::from(height);
    let centre = (f64::from(row) + 0.5) * step;
    let at_pole = row == 0 || row + 1 == height;
    let over_theta = if at_pole {
        // Constant from the pole to half a step c, then linear down to 0 within one step h:
        // cos c - (sin (c + h) - sin c) / h, plus the constant part 1 - cos c.
        let c = 0.5 * step;
        1.0 - ((c + step).sin() - c.sin()) / step
    } else {
        centre.sin() * (2.0 * (0.5 * step).sin()).powi(2) / step
    };
    TAU / f64::from(width) * over_theta
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_match_catalogue_values() {
        let middle = |h| 4.0 * parallel_rectangle(1.0, 1.0, h);
        let square = |z: f64| {
            let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
            lambert_polygon(&corners.map(|(x, y)| DVec3::new(x, y, z)))
        };
        for (ours, catalogue) in [
            (0.5 * middle(1.0), 0.277_063),
            (1.0 - middle(1e-4), 8.183_099e-9),
            (parallel_rectangle(2.0, 2.0, 1e-4), 0.249_999_998_9),
            (perpendicular_rectangle(1.0, 1.0, 1.0), 0.055_734_197),
            (coaxial_discs(1.0, 1.0, 1.0), 0.381_966_011_3),
            (coaxial_discs(0.5, 1.0, 2.0), 0.192_235_936),
            (perpendicular_sphere(2.0), 0.028_834_442_8),
            (normal_reflectance(1.0001), 2.499_75e-9),
            (square(1.0), middle(1.0)),
            (disc_segment(0.0), 0.5),
        ] {
            assert!((ours / catalogue - 1.0).abs() < 2e-6, "{ours} {catalogue}");
        }
        let inside = 1.0 - (1.0 - FRESNEL_MEAN_OUTSIDE) / 2.25;
        assert!((inside / FRESNEL_MEAN_INSIDE - 1.0).abs() < 1e-9);
    }

    #[test]
    fn rectangle_solid_angles_tile_hemisphere_and_match_cube_face() {
        let strip = |y| rectangle_below([-1e6, 1e6], y, 0.5);
        let all = [[-1e6, -0.25], [-0.25, 0.5], [0.5, 1e6]].map(strip);
        assert!(
            (all.iter().sum::<f64>() / TAU - 1.0).abs() < 1e-5,
            "{all:?}"
        );
        // One face of a cube around the point.
        let side = rectangle_below([-0.5, 0.5], [-0.5, 0.5], 0.5);
        assert!((side / (4.0 * PI / 6.0) - 1.0).abs() < 1e-12, "{side}");
    }

    #[test]
    fn environment_map_texel_solid_angles_sum_to_4_pi() {
        let sum: f64 = (0..32).map(|row| 64.0 * bright_texel(row, 64, 32)).sum();
        assert!((sum / (4.0 * PI) - 1.0).abs() < 1e-12, "{sum}");
    }
}
