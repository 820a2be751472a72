//! Pairs of triangles of a mesh that form a rectangle: lamps that modelling programs export as a face of four corners.
//!
//! A rectangle is one light in place of two, so that a scene with one lamp needs no selection.
//!
//! Measure: the unit of the corners.
//! Range: consecutive triangles, as a face is cut up; four corners that are those of a rectangle up to rounding to single
//! precision. Any other pair is no rectangle.
//! Source: none needed. Tested below and in `scene/prepare.rs`.

use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::vec::Vec3;

/// The largest cosine of an angle that counts as a right one.
const RIGHT_ANGLE: f64 = 1e-6;

/// The corner and the edges of the rectangle that two triangles form, with the normal edge_u x edge_v of both; `None` if
/// they form none.
pub fn rectangle_of(first: [Vec3; 3], second: [Vec3; 3]) -> Option<[Vec3; 3]> {
    let turns = |[a, b, c]: [Vec3; 3]| [[a, b, c], [b, c, a], [c, a, b]];
    let pairs = turns(first).into_iter().flat_map(|one| {
        let others = turns(second);
        others.into_iter().map(move |other| (one, other))
    });
    // The triangles a b c and a c d share the diagonal a c, in opposite directions.
    let quad =
        |([a, b, c], [e, f, d]): ([Vec3; 3], [Vec3; 3])| (a == e && c == f).then_some([a, b, c, d]);
    let [a, b, c, d] = pairs.into_iter().find_map(quad)?;
    let rounding = UNIT_ROUNDOFF * (a.abs() + b.abs() + c.abs() + d.abs());
    let [u, v] = [b - a, d - a];
    let [exact_u, exact_v] = [b, d].map(|p| p.as_dvec3() - a.as_dvec3());
    let gap = (a.as_dvec3() + exact_u + exact_v - c.as_dvec3()).abs();
    let is_parallelogram = gap.cmple(rounding.as_dvec3()).all();
    let is_right = exact_u.dot(exact_v).abs() <= RIGHT_ANGLE * exact_u.length() * exact_v.length();
    (is_parallelogram && is_right).then_some([a, u, v])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::{DMat3, DVec3};

    /// The corners of a face of edges 3 and 2, turned and moved.
    fn face(turn: f64) -> [Vec3; 4] {
        let turn = DMat3::from_rotation_x(turn) * DMat3::from_rotation_z(0.7 * turn);
        [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]].map(|[x, y]| {
            let p = turn * DVec3::new(x, y, 0.5) + DVec3::new(0.1, -0.7, 5.0);
            p.as_vec3a()
        })
    }

    #[test]
    fn both_ways_to_cut_a_rectangle_are_found_in_any_order() {
        for turn in 0..50 {
            let [a, b, c, d] = face(0.1 * f64::from(turn));
            let normal = (b - a).cross(d - a);
            for [first, second] in [
                [[a, b, c], [a, c, d]],
                [[b, c, a], [d, a, c]],
                [[c, d, a], [b, c, a]],
                [[a, b, d], [b, c, d]],
                [[d, b, c], [a, b, d]],
            ] {
                let found = rectangle_of(first, second);
                let [corner, u, v] = found.expect("two halves of a rectangle");
                let corners = [a, b, c, d];
                for p in [corner, corner + u, corner + u + v, corner + v] {
                    assert!(corners.iter().any(|q| q.distance(p) < 1e-5), "{turn}");
                }
                assert!((u.cross(v) - normal).length() < 1e-4 * normal.length());
            }
        }
    }

    #[test]
    fn triangles_that_form_no_rectangle_are_not_paired() {
        let [a, b, c, d] = face(0.3);
        let off = |p: Vec3, by: f32| p + by * (b - a);
        for (first, second) in [
            ([a, b, c], [a, d, c]),
            ([a, b, c], [a, b, c]),
            ([a, b, c], [a, c, off(d, 1e-4)]),
            ([a, off(b, 1e-4), c], [a, c, d]),
            ([a, b, c], [a, c, d + 1e-4 * (b - a).cross(d - a)]),
            // A parallelogram.
            ([a, b, off(c, 0.1)], [a, off(c, 0.1), off(d, 0.1)]),
            // A kite.
            ([a, b, c], [a, c, b + 1.2 * (d - b)]),
            ([a, b, c], [d, off(d, 0.5), off(d, 0.7) + (a - b).cross(d)]),
        ] {
            assert_eq!(rectangle_of(first, second), None, "{first:?} {second:?}");
        }
    }
}
