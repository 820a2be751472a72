//! Where a line meets a triangle, in double precision.
//!
//! Measure: any unit of length; the parameter in multiples of the direction's length.
//! Range: any triangle and line; a line in the plane, or a degenerate triangle, meets nothing.
//! Source: Möller and Trumbore 1997. Tested below.

use super::vec::DVec3;

/// Where a line meets a triangle's plane: the parameter, and the barycentric coordinates of the second and third
/// vertex, inside the triangle or not.
#[inline]
pub fn meet_plane([a, b, c]: [DVec3; 3], origin: DVec3, dir: DVec3) -> Option<(f64, [f64; 2])> {
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

/// Barycentric coordinates moved into the triangle.
#[inline]
pub fn clamp_to_triangle(uv: [f64; 2]) -> [f64; 2] {
    let [u, v] = uv.map(|x| x.clamp(0.0, 1.0));
    let excess = (u + v).max(1.0);
    [u / excess, v / excess]
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
    fn a_line_meets_the_plane_where_it_should() {
        let found = meet_plane(
            TRIANGLE,
            DVec3::new(1.0, 2.0, 0.0),
            DVec3::new(0.0, 0.0, 0.5),
        );
        assert_eq!(found, Some((4.0, [0.25, 0.5])));
        assert_eq!(meet_plane(TRIANGLE, DVec3::ZERO, DVec3::X), None);
    }

    #[test]
    fn clamping_ends_inside() {
        assert_eq!(clamp_to_triangle([0.25, 0.5]), [0.25, 0.5]);
        assert_eq!(clamp_to_triangle([-1.0, 2.0]), [0.0, 1.0]);
        assert_eq!(clamp_to_triangle([1.0, 1.0]), [0.5, 0.5]);
    }
}
