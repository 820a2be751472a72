//! Intersection of a line with a triangle, in double precision.
//!
//! Measure: any unit of length; the parameter in multiples of the direction's length.
//! Range: any triangle and line; a line in the plane, or a degenerate triangle, has no intersection.
//! Source: Möller and Trumbore 1997 for the plane; Woop, Benthin and Wald 2013 for the triangle. Tested below and in
//! `lab/tests/bench/scenes.rs`.

use super::vec::{DVec3, Vec3};
use crate::planted::planted;

/// A line, prepared for watertight intersection: it cannot pass between triangles that share an edge or a vertex.
///
/// Vertices are projected along the line onto a plane across an axis, in which the line is the origin. The projection
/// of a vertex does not depend on the triangle that it belongs to, so neighbours leave no gap. The side of an edge on
/// which the origin lies is the sign of a difference of two products. Rounding is monotone, so that sign is right or
/// the difference is 0, which counts as inside on either side.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// The two axes of the plane, and the axis across it, along which the direction is longest.
    axes: [usize; 3],
    origin: DVec3,
    dir: DVec3,
    /// The displacement of the line in the plane per unit across it.
    shear: [f64; 2],
}

impl Line {
    /// Builds the line through a point in a direction.
    #[inline]
    pub fn new(origin: DVec3, dir: DVec3) -> Self {
        let longest = dir.abs().max_position();
        let axes = [(longest + 1) % 3, (longest + 2) % 3, longest];
        let [x, y, z] = axes.map(|axis| dir[axis]);
        Self {
            axes,
            origin,
            dir,
            shear: [x / z, y / z],
        }
    }

    /// Intersects a triangle: returns the parameter, and the barycentric coordinates of the second and third vertex.
    #[inline]
    pub fn intersect(&self, triangle: &[Vec3; 3]) -> Option<(f64, [f64; 2])> {
        let [a, b, c] = [0, 1, 2].map(|i| self.project(&triangle[i]));
        let side = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let sides = [side(b, c), side(c, a), side(a, b)];
        let inside = sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0);
        let area = sides[0] + sides[1] + sides[2];
        if !planted!("edges-open", inside && !sides.contains(&0.0), inside) || area == 0.0 {
            return None;
        }
        let t = self.intersect_plane_of(triangle, [a[2], b[2], c[2]])?;
        Some((t, [sides[1] / area, sides[2] / area]))
    }

    /// The parameter at the plane of a triangle that is hit. Where the plane is so steep that rounding matters, the
    /// parameter is clamped to those of the vertices, whose distances across the projection plane are `across`.
    /// `None` if the triangle is degenerate: its normal is then exactly 0, unless its vertices have very different
    /// magnitudes in single precision.
    #[inline]
    fn intersect_plane_of(&self, triangle: &[Vec3; 3], across: [f64; 3]) -> Option<f64> {
        let [a, b, c] = triangle.map(|vertex| vertex.as_dvec3());
        let normal = (b - a).cross(c - a);
        if normal == DVec3::ZERO {
            return None;
        }
        let [x, y, z] = across.map(|z| z / self.dir[self.axes[2]]);
        let t = (a - self.origin).dot(normal) / self.dir.dot(normal);
        // A NaN is replaced by its bound.
        Some(t.max(x.min(y).min(z)).min(x.max(y).max(z)))
    }

    /// The projection of a vertex along the line, and its distance across the plane.
    #[inline]
    fn project(&self, vertex: &Vec3) -> [f64; 3] {
        let (vertex, origin): (&[f32; 3], &[f64; 3]) = (vertex.as_ref(), self.origin.as_ref());
        let [x, y, z] = self.axes.map(|axis| f64::from(vertex[axis]) - origin[axis]);
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }
}

/// Intersects a line with a triangle's plane: returns the parameter, and the barycentric coordinates of the second
/// and third vertex, inside the triangle or not.
#[inline]
pub fn intersect_plane(
    [a, b, c]: [DVec3; 3],
    origin: DVec3,
    dir: DVec3,
) -> Option<(f64, [f64; 2])> {
    let (e1, e2) = (b - a, c - a);
    let p = dir.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let q = s.cross(e1);
    let uv = [s.dot(p) / determinant, dir.dot(q) / determinant];
    Some((e2.dot(q) / determinant, uv))
}

/// Clamps barycentric coordinates to the triangle.
#[inline]
pub fn clamp_to_triangle(uv: [f64; 2]) -> [f64; 2] {
    let [u, v] = uv.map(|x| x.clamp(0.0, 1.0));
    let excess = (u + v).max(1.0);
    [u / excess, v / excess]
}

/// The barycentric coordinates of the triangle's point nearest to the given point of its plane. In a needle this is
/// not the point with the nearest coordinates: a small distance across it is a large share of its width.
pub fn nearest_in_triangle([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> [f64; 2] {
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
        return [u, v];
    }
    let p = a + u * (b - a) + v * (c - a);
    let along = |from: DVec3, to: DVec3| {
        let edge = to - from;
        let share = ((p - from).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        (share, p.distance_squared(from + share * edge))
    };
    let (ab, bc, ca) = (along(a, b), along(b, c), along(c, a));
    let candidates = [
        ([ab.0, 0.0], ab.1),
        ([1.0 - bc.0, bc.0], bc.1),
        ([0.0, 1.0 - ca.0], ca.1),
    ];
    let nearest = candidates.into_iter().min_by(|x, y| x.1.total_cmp(&y.1));
    nearest.map_or([u, v], |(coordinates, _)| coordinates)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [
        DVec3::new(0.0, 0.0, 2.0),
        DVec3::new(4.0, 0.0, 2.0),
        DVec3::new(0.0, 4.0, 2.0),
    ];

    #[test]
    fn line_plane_intersection_returns_parameter_and_barycentrics() {
        let hit = intersect_plane(
            TRIANGLE,
            DVec3::new(1.0, 2.0, 0.0),
            DVec3::new(0.0, 0.0, 0.5),
        );
        assert_eq!(hit, Some((4.0, [0.25, 0.5])));
        assert_eq!(intersect_plane(TRIANGLE, DVec3::ZERO, DVec3::X), None);
    }

    #[test]
    fn line_intersects_triangle_from_both_sides_along_every_axis() {
        for turns in 0..3 {
            let turn = |p: DVec3| (0..turns).fold(p, |p, _| DVec3::new(p.z, p.x, p.y));
            let triangle = TRIANGLE.map(|p| turn(p).as_vec3a());
            let meet = |x, y, z, dz| {
                let (origin, dir) = (DVec3::new(x, y, z), DVec3::new(0.0, 0.0, dz));
                Line::new(turn(origin), turn(dir)).intersect(&triangle)
            };
            assert_eq!(meet(1.0, 2.0, 0.0, 0.5), Some((4.0, [0.25, 0.5])));
            assert_eq!(meet(1.0, 2.0, 0.0, -0.5), Some((-4.0, [0.25, 0.5])));
            assert_eq!(meet(1.0, 2.0, 4.0, -0.5), Some((4.0, [0.25, 0.5])));
            for (x, y) in [(-1.0, 2.0), (2.0, -1.0), (3.0, 2.0)] {
                assert_eq!(meet(x, y, 0.0, 1.0), None);
            }
            // Vertices and edges are inside.
            assert_eq!(meet(4.0, 0.0, 0.0, 1.0), Some((2.0, [1.0, 0.0])));
            assert_eq!(meet(2.0, 2.0, 0.0, 1.0), Some((2.0, [0.5, 0.5])));
        }
    }

    #[test]
    fn edge_on_zero_direction_and_degenerate_triangles_never_hit() {
        let [a, b, c] = TRIANGLE.map(|p| p.as_vec3a());
        let up = Line::new(DVec3::new(1.0, 1.0, 0.0), DVec3::Z);
        let edge_on = Line::new(DVec3::new(-1.0, 1.0, 2.0), DVec3::X);
        let nowhere = Line::new(DVec3::new(1.0, 1.0, 2.0), DVec3::ZERO);
        assert!(up.intersect(&[a, b, c]).is_some());
        assert_eq!(edge_on.intersect(&[a, b, c]), None);
        assert_eq!(nowhere.intersect(&[a, b, c]), None);
        let not_a_number = [Vec3::NAN; 3];
        assert_eq!(up.intersect(&not_a_number), None);
        // Rounding gives these triangles an area in the projection along nearly every line.
        let ends = [Vec3::new(0.125, 0.25, 0.75), Vec3::new(0.5, 1.75, 3.125)];
        let middle = 0.5 * (ends[0] + ends[1]);
        for degenerate in [[ends[0], ends[0], ends[1]], [ends[0], middle, ends[1]]] {
            for i in 0..1000 {
                let origin = DVec3::new(1.3, 0.01 * f64::from(i), -0.7);
                for vertex in degenerate {
                    let line = Line::new(origin, vertex.as_dvec3() - origin);
                    assert_eq!(line.intersect(&degenerate), None, "{line:?}");
                }
            }
        }
    }

    /// Lines aimed at the vertex in the middle of a fan of triangles, and at its edges. In Plücker coordinates
    /// rounding would decide six signs; if these were independent, all would be the same once in 32 lines.
    #[test]
    fn intersection_is_watertight_in_a_triangle_fan() {
        let mut numbers =
            (0_u32..).map(|i| (i.wrapping_mul(2_654_435_769) >> 8) as f32 / 16_777_216.0);
        let mut next = |scale: f32| scale * (2.0 * numbers.next().expect("endless") - 1.0);
        for round in 0..20_000 {
            let scale = [1.0, 1e-3, 1e6][round % 3];
            let hub = Vec3::new(next(scale), next(scale), next(1.0));
            let rim: Vec<_> = (0..6)
                .map(|k| {
                    let (sin, cos) = (std::f32::consts::FRAC_PI_3 * k as f32).sin_cos();
                    hub + Vec3::new(cos, sin, next(0.2))
                })
                .collect();
            let origin = Vec3::new(next(0.4), next(0.4), 1.0 + next(0.2)) + hub;
            for target in [hub, hub + 0.5 * (rim[round % 6] - hub)] {
                // The exact direction, that of single precision, which misses by rounding, and the normalised exact
                // one.
                let exactly = target.as_dvec3() - origin.as_dvec3();
                for dir in [exactly, (target - origin).as_dvec3(), exactly.normalize()] {
                    let line = Line::new(origin.as_dvec3(), dir);
                    let is_hit =
                        (0..6).any(|k| line.intersect(&[hub, rim[k], rim[(k + 1) % 6]]).is_some());
                    assert!(is_hit, "{line:?} at {target}");
                }
            }
        }
    }

    #[test]
    fn clamped_barycentrics_lie_inside_the_triangle() {
        assert_eq!(clamp_to_triangle([0.25, 0.5]), [0.25, 0.5]);
        assert_eq!(clamp_to_triangle([-1.0, 2.0]), [0.0, 1.0]);
        assert_eq!(clamp_to_triangle([1.0, 1.0]), [0.5, 0.5]);
    }

    #[test]
    fn nearest_point_is_accurate_in_a_needle_triangle() {
        let needle = [
            DVec3::ZERO,
            DVec3::new(1.0, 0.0, 0.0),
            DVec3::new(1.0, 1e-3, 0.0),
        ];
        let at = |[u, v]: [f64; 2]| {
            needle[0] + u * (needle[1] - needle[0]) + v * (needle[2] - needle[0])
        };
        // A millionth below the long edge, a millionth beyond the short one, nearest to a vertex, and inside.
        for (x, y, expected) in [
            (0.5, -1e-6, DVec3::new(0.5, 0.0, 0.0)),
            (1.0 + 1e-6, 5e-4, DVec3::new(1.0, 5e-4, 0.0)),
            (-1.0, -1.0, DVec3::ZERO),
            (0.5, 2e-4, DVec3::new(0.5, 2e-4, 0.0)),
        ] {
            let v = y / 1e-3;
            let nearest = at(nearest_in_triangle(needle, [x - v, v]));
            assert!(nearest.distance(expected) < 1e-12, "{x} {y}: {nearest}");
        }
    }
}
