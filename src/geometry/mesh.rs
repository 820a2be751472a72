//! Triangles with shared vertices.
//!
//! Measure: normalised scene units.
//! Range: at least one triangle; indices in range and triangles not degenerate, as `prepare` ensures.
//! Source: error bounds by Pharr, Jakob, Humphreys, section 6.8.2. Tested in `tests/tracing/rays.rs`.

use super::surface::SurfacePoint;
use crate::math::bounds::Bounds;
use crate::math::robust::{gamma, never_zero};
use crate::math::vec::{Vec2, Vec3, Vec4, Vector};
use crate::planted::planted;
use rayon::prelude::*;

/// The least number of triangles or vertices that a thread takes: the lists of small meshes are not divided between threads.
pub const MIN_PER_THREAD: usize = 4096;

/// A vertex with its attributes, in half a cache line. Its position comes first, where Embree reads it.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct MeshVertex {
    position_and_u: Vec4,
    normal_and_v: Vec4,
}

impl MeshVertex {
    /// Makes a vertex; normal and texture coordinate are zero in a mesh without them.
    pub fn new(position: Vec3, normal: Vec3, uv: Vec2) -> Self {
        Self {
            position_and_u: position.extend(uv.x),
            normal_and_v: normal.extend(uv.y),
        }
    }

    /// The position.
    #[inline(always)]
    pub fn position(&self) -> Vec3 {
        Vec3::from_vec4(self.position_and_u)
    }

    /// The unit normal; zero if the mesh has none.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        Vec3::from_vec4(self.normal_and_v)
    }

    /// The texture coordinate; zero if the mesh has none.
    #[inline(always)]
    pub fn uv(&self) -> Vec2 {
        Vec2::new(self.position_and_u.w, self.normal_and_v.w)
    }
}

/// A triangle mesh.
#[derive(Debug, Clone)]
pub struct Mesh {
    vertices: Vec<MeshVertex>,
    indices: Vec<[u32; 3]>,
    has_normals: bool,
    has_uvs: bool,
    bounds: Bounds,
}

impl Mesh {
    /// Creates a mesh. `normals` (of unit length) and `uvs` have one entry per vertex, or are empty.
    ///
    /// # Panics
    /// If an index or the length of a list does not fit the positions.
    pub fn new(
        positions: Vec<Vec3>,
        normals: Vec<Vec3>,
        uvs: Vec<Vec2>,
        indices: Vec<[u32; 3]>,
    ) -> Self {
        let count = positions.len();
        assert!(normals.is_empty() || normals.len() == count);
        assert!(uvs.is_empty() || uvs.len() == count);
        let has = [!normals.is_empty(), !uvs.is_empty()];
        let vertex = |(i, position)| {
            let normal = normals.get(i).copied().unwrap_or(Vec3::ZERO);
            MeshVertex::new(position, normal, uvs.get(i).copied().unwrap_or(Vec2::ZERO))
        };
        let vertices = positions.into_iter().enumerate().map(vertex);
        Self::from_vertices(vertices.collect(), has, indices)
    }

    /// Creates a mesh of vertices that have normals (of unit length) and texture coordinates if `has` says so.
    ///
    /// # Panics
    /// If an index does not fit the vertices.
    pub fn from_vertices(
        vertices: Vec<MeshVertex>,
        [has_normals, has_uvs]: [bool; 2],
        indices: Vec<[u32; 3]>,
    ) -> Self {
        let count = vertices.len();
        let triangles = indices.par_iter().with_min_len(MIN_PER_THREAD);
        let around = |triangle: &[u32; 3]| {
            assert!(triangle.iter().all(|&i| (i as usize) < count));
            Bounds::around(triangle.map(|i| vertices[i as usize].position().as_dvec3()))
        };
        let bounds = triangles.map(around).reduce(Bounds::default, Bounds::union);
        Self {
            vertices,
            indices,
            has_normals,
            has_uvs,
            bounds,
        }
    }

    /// The vertices.
    pub fn vertices(&self) -> &[MeshVertex] {
        &self.vertices
    }

    /// The positions of the vertices.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Vec3> {
        self.vertices.iter().map(MeshVertex::position)
    }

    /// The bounding box of all triangles, without unused vertices.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Whether the vertices have normals.
    #[inline(always)]
    pub fn has_normals(&self) -> bool {
        self.has_normals
    }

    /// The vertex indices, three per triangle.
    pub fn indices(&self) -> &[[u32; 3]] {
        &self.indices
    }

    /// The vertices of one triangle, with their attributes.
    #[inline(always)]
    pub fn corners(&self, primitive: u32) -> [&MeshVertex; 3] {
        self.indices[primitive as usize].map(|i| &self.vertices[i as usize])
    }

    /// The positions of the vertices of one triangle.
    #[inline]
    pub fn triangle(&self, primitive: u32) -> [Vec3; 3] {
        self.corners(primitive).map(MeshVertex::position)
    }

    /// The surface point with barycentric coordinates (u, v) of the second and third vertex of a triangle.
    #[inline]
    pub fn surface_at(&self, primitive: u32, [u, v]: [f32; 2]) -> SurfacePoint {
        let corners = self.corners(primitive);
        let [a, b, c] = corners.map(MeshVertex::position);
        let mut point = triangle_point([a, b, c], [u, v]);
        if may_be_outside(&point, [a, b, c], [u, v]) {
            point = inset(point, [a, b, c]);
        }
        let ng = point.ng;
        let ns = if self.has_normals {
            shading_normal(corners.map(MeshVertex::normal), ng, [u, v])
        } else {
            ng
        };
        SurfacePoint { ns, ..point }
    }

    /// The error bound that holds for all points of one triangle.
    pub fn greatest_error(&self, primitive: u32) -> Vec3 {
        greatest_error(self.triangle(primitive))
    }

    /// The partial derivatives of the position by u and v on one triangle, from the linear function p(u, v); zero where
    /// the texture coordinates of the corners are collinear.
    pub fn tangents_at(&self, primitive: u32) -> [Vec3; 2] {
        let [a, b, c] = self.triangle(primitive);
        let [p1, p2] = [b - a, c - a];
        let corner = |k: f32, l: f32| self.uv_at(primitive, [k, l]);
        let [t1, t2] = [
            corner(1.0, 0.0) - corner(0.0, 0.0),
            corner(0.0, 1.0) - corner(0.0, 0.0),
        ];
        let determinant = t1.perp_dot(t2);
        if determinant == 0.0 {
            return [Vec3::ZERO; 2];
        }
        let along_u = (t2.y * p1 - t1.y * p2) / determinant;
        let along_v = (t1.x * p2 - t2.x * p1) / determinant;
        [along_u, along_v]
    }

    /// The texture coordinate at barycentric coordinates (u, v); the barycentric coordinates themselves if the mesh has
    /// none.
    #[inline]
    pub fn uv_at(&self, primitive: u32, [u, v]: [f32; 2]) -> Vec2 {
        let [a, b, c] = self.triangle_uvs(primitive);
        (1.0 - u - v) * a + u * b + v * c
    }

    /// The texture coordinates of the vertices of one triangle: barycentric coordinates if the mesh has none.
    #[inline]
    pub fn triangle_uvs(&self, primitive: u32) -> [Vec2; 3] {
        self.uvs_of(self.corners(primitive))
    }

    /// The texture coordinates of a triangle with these vertices, as [`Self::triangle_uvs`].
    #[inline(always)]
    pub fn uvs_of(&self, corners: [&MeshVertex; 3]) -> [Vec2; 3] {
        if self.has_uvs {
            corners.map(MeshVertex::uv)
        } else {
            [Vec2::ZERO, Vec2::X, Vec2::Y]
        }
    }
}

/// The shading normal interpolated between those of a triangle's vertices, on the side of `ng`. Free of branches.
#[inline(always)]
pub fn shading_normal<V: Vector>([na, nb, nc]: [V; 3], ng: V, [u, v]: [f32; 2]) -> V {
    let [nb, nc] = planted!("normals-of-exchanged-corners", [nc, nb], [nb, nc]);
    let ns = (na * (1.0 - u - v) + nb * u + nc * v).normalize_or(ng);
    if ns.dot(ng) < 0.0 { -ns } else { ns }
}

/// Whether a point with these barycentric coordinates may lie beyond an edge of its triangle, within its error bound.
#[inline(always)]
pub fn may_be_outside<V: Vector>(
    point: &SurfacePoint<V>,
    [a, b, c]: [V; 3],
    [u, v]: [f32; 2],
) -> bool {
    let (e1, e2) = (b - a, c - a);
    // The distance from an edge is its barycentric coordinate times twice the area over its length; `longest` is an
    // upper bound of the length.
    let longest = (e1.abs() + e2.abs()).element_sum();
    let nearest = u.min(v).min(1.0 - u - v);
    nearest * e1.cross(e2).length() < point.error.element_sum() * longest
}

/// Moves a point in its plane away from each edge by its error bound. Beyond an edge of a closed mesh the point would
/// lie behind the neighbouring triangle, and a ray from it would leak out.
#[cold]
fn inset(point: SurfacePoint, triangle: [Vec3; 3]) -> SurfacePoint {
    let [a, b, c] = triangle;
    let mut p = point.p;
    for (from, to, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
        let inwards = point.ng.cross(to - from).normalize_or_zero();
        let height = (opposite - from).dot(inwards);
        // At most to the centroid of a narrow triangle.
        let wanted = point.error.dot(inwards.abs()).min(height / 3.0);
        p += (wanted - (p - from).dot(inwards)).max(0.0) * inwards;
    }
    // The rounding error of the move is added.
    let error = point.error + gamma(4) * p.abs();
    SurfacePoint { p, error, ..point }
}

/// The error bound that holds for all points of a triangle: it is largest at a corner.
pub fn greatest_error(triangle: [Vec3; 3]) -> Vec3 {
    let error = |corner| triangle_point(triangle, corner).error;
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    corners.map(error).into_iter().fold(Vec3::ZERO, Vec3::max)
}

/// A point of a flat triangle with its error bound; the shading normal is the geometric normal.
#[inline(always)]
pub fn triangle_point<V: Vector>([a, b, c]: [V; 3], [u, v]: [f32; 2]) -> SurfacePoint<V> {
    let (e1, e2) = (b - a, c - a);
    let (wa, ub, vc) = (a * (1.0 - u - v), b * u, c * v);
    let p = wa + ub + vc;
    // gamma_7 bounds the interpolation. A ray query computes the distance from the plane as (a - origin) . ng, whose
    // rounding error is proportional to the edges: gamma_6 of them, in robust and in fast mode.
    let interpolation = (wa.abs() + ub.abs() + vc.abs()) * gamma(7);
    let query = (e1.abs() + e2.abs()) * gamma(6);
    let cross = e1.cross(e2);
    let twice_area = cross.length();
    let ng = cross / twice_area;
    let tilt = normal_error(e1, e2).dot(e1.abs() * u + e2.abs() * v) / twice_area;
    let tilt = ng.abs() * planted!("slivers-as-others", 0.0, tilt);
    SurfacePoint {
        p,
        error: never_zero(
            interpolation + query + tilt,
            e1.abs().max(e2.abs()).max_element(),
        ),
        ng,
        ns: ng,
    }
}

/// The error bound of each coordinate of (b - a) x (c - a), in addition to its own rounding. It is small except for
/// slivers, whose area is small compared to the products of their edges. The error tilts the plane about a.
///
/// A ray query subtracts two products for each coordinate, from one of two pairs of edges, whichever subtracts less. In
/// p - q, the rounded edges contribute 2 u (|p| + |q|), the rounded q another u |q|, and |p| is |q| plus the
/// difference: 5 u |q|. This holds for Embree's robust mode. Its fast mode uses only the first pair, so that the bound
/// does not hold in a needle whose long edges both begin at a. Nor does it hold for rays so close to the plane that the
/// tilt puts them on its other side, at cosines of about 10^-6.
#[inline(always)]
fn normal_error<V: Vector>(e1: V, e2: V) -> V {
    let e3 = e2 - e1;
    let (at_a, at_b) = (e2.zxy() * e1.yzx(), e1.zxy() * e3.yzx());
    at_a.abs().min(at_b.abs()) * gamma(5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_at_corners_returns_vertex_normals_and_uvs() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let normals = [(0.0, 0.0), (0.6, 0.0), (0.0, 0.8)];
        let normals =
            normals.map(|(x, y): (f32, f32)| Vec3::new(x, y, (1.0 - x * x - y * y).sqrt()));
        let uvs = vec![Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::new(0.0, 0.25)];
        let mesh = Mesh::new(positions, normals.to_vec(), uvs.clone(), vec![[0, 1, 2]]);
        for (corner, at) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
            let surface = mesh.surface_at(0, at);
            assert!(
                (surface.ns - normals[corner]).length() < 1e-6,
                "{surface:?}"
            );
            assert_eq!(mesh.uv_at(0, at), uvs[corner]);
        }
    }
}
