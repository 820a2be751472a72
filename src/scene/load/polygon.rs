//! Cuts polygons into triangles.
//!
//! Measure: positions in the file's own units.
//! Range: any polygon. One that crosses itself, or has more than 1024 corners, keeps the triangles around its first corner.
//! Source: ear cutting in the plane of the polygon's largest projection, through earcut. Tested below.

use crate::math::vec::DVec3;
use crate::scene::description::{Note, NoteKind, Place};
use earcut::Earcut;
use std::ops::Range;

/// The largest number of corners of a polygon that is cut into ears.
const MAX_CORNERS: usize = 1024;

/// The largest sum, over the polygons of a mesh, of the squares of their numbers of corners: a bound of the time that cutting
/// takes, which grows at least as fast.
const MAX_WORK: usize = 1 << 30;

/// Polygons of more than three corners, each read as the triangles around its first corner, in the order of a mesh.
#[derive(Debug, Default)]
pub struct Fans(Vec<Range<usize>>);

impl Fans {
    /// Adds a polygon: the triangles of these indices, of which there are at least two.
    pub fn push(&mut self, triangles: Range<usize>) {
        debug_assert!(self.0.last().is_none_or(|last| last.end <= triangles.start));
        self.0.push(triangles);
    }

    /// Replaces the triangles of each polygon that they do not cover, as it is concave at a corner that the first one
    /// does not see. All others stay as they are. Returns the number of polygons that are not covered.
    pub fn cut_concave(&self, triangles: &mut Vec<[u32; 3]>, positions: &[DVec3]) -> usize {
        let mut earcut = Earcut::new();
        let mut ears = Vec::new();
        let (mut work, mut uncovered) = (0_usize, 0);
        // A cut polygon may have fewer triangles, since corners on a straight edge need none.
        let (mut read, mut written) = (0, 0);
        for fan in &self.0 {
            let polygon = Polygon::new(&triangles[fan.clone()], positions);
            if polygon.is_covered() {
                continue;
            }
            uncovered += 1;
            let count = fan.len() + 2;
            work = work.saturating_add(count.saturating_mul(count));
            if count > MAX_CORNERS || work > MAX_WORK {
                continue;
            }
            let corners: Vec<u32> = polygon.corners().collect();
            let points = corners
                .iter()
                .map(|&i| polygon.projected(positions[i as usize]));
            earcut.earcut(points, &[], &mut ears);
            let cut: Vec<[u32; 3]> = ears
                .as_chunks()
                .0
                .iter()
                .map(|ear: &[u32; 3]| polygon.oriented(ear.map(|i| corners[i as usize])))
                .collect();
            if !polygon.has_area_of(&cut) {
                continue;
            }
            uncovered -= 1;
            triangles.copy_within(read..fan.start, written);
            written += fan.start - read;
            triangles[written..written + cut.len()].copy_from_slice(&cut);
            written += cut.len();
            read = fan.end;
        }
        let end = triangles.len();
        triangles.copy_within(read..end, written);
        triangles.truncate(written + end - read);
        uncovered
    }
}

/// The note on polygons that are not covered by their triangles; `None` without any.
pub fn note_on_uncovered(count: usize, place: Place) -> Option<Note> {
    let text = format!(
        "{count} concave polygons that cross themselves or have many corners were cut around their first corner"
    );
    (count > 0).then(|| Note::at(place, NoteKind::Approximation, text))
}

/// A polygon as the triangles around its first corner.
struct Polygon<'a> {
    fan: &'a [[u32; 3]],
    positions: &'a [DVec3],
    /// The sum of the triangles' normals, each as long as twice the area; independent of how the polygon is cut.
    normal: DVec3,
}

impl<'a> Polygon<'a> {
    fn new(fan: &'a [[u32; 3]], positions: &'a [DVec3]) -> Self {
        let normal = DVec3::ZERO;
        let polygon = Self {
            fan,
            positions,
            normal,
        };
        let normal = fan.iter().map(|&triangle| polygon.cross(triangle)).sum();
        Self { normal, ..polygon }
    }

    /// Returns the normal of a triangle, as long as twice its area.
    fn cross(&self, triangle: [u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|i| self.positions[i as usize]);
        (b - a).cross(c - a)
    }

    /// Whether the triangles around the first corner cover the polygon: none of them is turned over.
    fn is_covered(&self) -> bool {
        !self
            .fan
            .iter()
            .any(|&triangle| self.cross(triangle).dot(self.normal) < 0.0)
    }

    fn corners(&self) -> impl Iterator<Item = u32> {
        let [first, second, _] = self.fan[0];
        [first, second]
            .into_iter()
            .chain(self.fan.iter().map(|triangle| triangle[2]))
    }

    /// Projects a point along the axis on which the normal is longest.
    fn projected(&self, point: DVec3) -> [f64; 2] {
        let size = self.normal.abs();
        if size.x >= size.y && size.x >= size.z {
            [point.y, point.z]
        } else if size.y >= size.z {
            [point.z, point.x]
        } else {
            [point.x, point.y]
        }
    }

    /// Turns a triangle to the polygon's side.
    fn oriented(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        if self.cross([a, b, c]).dot(self.normal) < 0.0 {
            [a, c, b]
        } else {
            [a, b, c]
        }
    }

    /// Whether oriented triangles have the polygon's area, in projection along its normal; not so if it crosses itself.
    fn has_area_of(&self, triangles: &[[u32; 3]]) -> bool {
        let covered: f64 = triangles
            .iter()
            .map(|&t| self.cross(t).dot(self.normal))
            .sum();
        let whole = self.normal.length_squared();
        (covered - whole).abs() <= 1e-6 * whole
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cuts a polygon in the plane x + y + z = 0, with corners given in two coordinates.
    fn cut(corners: &[[f64; 2]], crosses: bool) -> (Vec<[u32; 3]>, Vec<DVec3>) {
        let positions: Vec<DVec3> = corners
            .iter()
            .map(|&[x, y]| DVec3::new(x, y, -x - y))
            .collect();
        let last = corners.len() as u32 - 1;
        let around = (1..last).map(|i| [0, i, i + 1]);
        // Triangles before and after, which stay.
        let mut triangles = vec![[1, 2, 0]];
        triangles.extend(around);
        let mut fans = Fans::default();
        fans.push(1..triangles.len());
        triangles.push([2, 0, 1]);
        let uncovered = fans.cut_concave(&mut triangles, &positions);
        assert_eq!(uncovered, usize::from(crosses));
        assert_eq!(triangles.remove(0), [1, 2, 0]);
        assert_eq!(triangles.pop(), Some([2, 0, 1]));
        (triangles, positions)
    }

    /// Sum of the areas of all triangles, where each is counted positive, and the length of the sum of their normals, halved.
    fn areas(triangles: &[[u32; 3]], positions: &[DVec3]) -> (f64, f64) {
        let cross = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a)
        };
        let each = triangles.iter().map(|t| cross(t).length() / 2.0).sum();
        let whole = triangles.iter().map(cross).sum::<DVec3>().length() / 2.0;
        (each, whole)
    }

    #[test]
    fn convex_polygons_are_cut_around_their_first_corner() {
        let (triangles, _) = cut(
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.5], [0.0, 1.0]],
            false,
        );
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        let arrow = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 3.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        for polygon in [&arrow[..], &comb[..]] {
            for first in 0..polygon.len() {
                for reversed in [false, true] {
                    let mut corners = polygon.to_vec();
                    corners.rotate_left(first);
                    if reversed {
                        corners.reverse();
                    }
                    let (triangles, positions) = cut(&corners, false);
                    let (each, whole) = areas(&triangles, &positions);
                    assert!(
                        (each - whole).abs() < 1e-12,
                        "{corners:?}: {each} of {whole}"
                    );
                }
            }
        }
    }

    #[test]
    fn polygons_that_cross_themselves_stay_fans() {
        let star = [
            [0.0, 3.0],
            [2.0, -3.0],
            [-3.0, 1.0],
            [3.0, 1.0],
            [-2.0, -3.0],
        ];
        let (triangles, _) = cut(&star, true);
        assert_eq!(triangles.len(), 3);
    }
}
