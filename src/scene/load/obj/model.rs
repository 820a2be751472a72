//! A parsed OBJ file, and the meshes of its parts.
//!
//! Measure: the file's own units, in double precision; lines and the indices of corners count from 1, as in the file; colours of
//! vertices are sRGB values.
//! Range: a part has a vertex for each combination of position, texture coordinates and normal that its corners name, in the
//! order of first use.
//! Source: the OBJ format, appendix B1 of Wavefront's Advanced Visualizer manual. Tested in `lines` and
//! `tests/loading/obj_by_tobj.rs`.

use super::super::polygon::Fans;
use super::vertices::{Corner, Vertices};
use crate::geometry::mesh::MIN_PER_THREAD;
use crate::math::vec::{DVec2, DVec3};
use crate::scene::description::MeshDescription;
use rayon::prelude::*;

/// A parsed OBJ file.
#[derive(Debug, Default)]
pub struct ObjModel {
    /// The positions of all vertices.
    pub positions: Vec<DVec3>,
    /// All texture coordinates; v points up.
    pub uvs: Vec<DVec2>,
    /// All normals, of any length.
    pub normals: Vec<DVec3>,
    /// All faces, grouped by part.
    pub parts: Vec<FaceGroup>,
    /// The names given by `o` and `g`.
    pub groups: Vec<String>,
    /// The files named by `mtllib`, with their lines.
    pub libraries: Vec<(usize, String)>,
    /// The materials named by `usemtl`, each with its first line.
    pub materials: Vec<(usize, String)>,
    /// Number of points and lines that were left out.
    pub left_out: usize,
    /// The colours of vertices, with the indices of their positions, counted from 0 and ascending.
    pub colours: Vec<(usize, [f64; 3])>,
}

/// The faces of one group and one material, with texture coordinates and normals for all corners or for none.
#[derive(Debug)]
pub struct FaceGroup {
    /// Index into [`ObjModel::groups`]; `None` before the first group.
    pub group: Option<usize>,
    /// Index into [`ObjModel::materials`].
    pub material: Option<usize>,
    /// The line of the first face.
    pub line: usize,
    /// Whether the corners have texture coordinates and normals.
    pub complete: [bool; 2],
    /// The faces, in one list for each chunk of the file that has some.
    pub faces: Vec<FaceList>,
}

/// Consecutive faces.
#[derive(Debug, Default)]
pub struct FaceList {
    /// The number of corners of each face, at least three.
    pub arities: Vec<u32>,
    /// The indices of positions, texture coordinates and normals of all corners; empty for what the part does not have.
    pub corners: [Vec<u32>; 3],
}

impl FaceGroup {
    /// The number of corners.
    pub fn corner_count(&self) -> usize {
        self.faces.iter().map(|list| list.corners[0].len()).sum()
    }
}

impl FaceList {
    /// Adds a face of at least three corners, with the kinds of indices that `complete` says its part has.
    pub fn push(&mut self, face: &[Corner], complete: [bool; 2]) {
        self.arities.push(face.len() as u32);
        let is_kept = [true, complete[0], complete[1]];
        for (kind, indices) in self.corners.iter_mut().enumerate() {
            if is_kept[kind] {
                indices.extend(face.iter().map(|corner| corner[kind]));
            }
        }
    }

    /// Returns a corner, with 0 for what the part does not have.
    #[inline]
    pub fn corner(&self, index: usize) -> Corner {
        let indices = self.corners.each_ref();
        indices.map(|indices| indices.get(index).copied().unwrap_or(0))
    }
}

/// The mesh of a part.
#[derive(Debug)]
pub struct PartMesh {
    pub mesh: MeshDescription,
    /// The number of polygons that are not covered by their triangles.
    pub uncovered: usize,
    /// The colours of all vertices, if they are wanted.
    pub colours: Vec<[f64; 3]>,
}

impl ObjModel {
    /// The number of positions, texture coordinates and normals.
    pub fn counts(&self) -> [usize; 3] {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    /// Makes room for as many positions, texture coordinates and normals in all.
    pub fn reserve(&mut self, counts: [usize; 3]) {
        let [positions, uvs, normals] = counts;
        self.positions
            .reserve_exact(positions - self.positions.len());
        self.uvs.reserve_exact(uvs - self.uvs.len());
        self.normals.reserve_exact(normals - self.normals.len());
    }

    /// Whether vertices have colours, all of them within [0, 1].
    pub fn has_valid_colours(&self) -> bool {
        let is_valid = |colour: &[f64; 3]| colour.iter().all(|x| (0.0..=1.0).contains(x));
        !self.colours.is_empty() && self.colours.iter().all(|(_, colour)| is_valid(colour))
    }

    /// Returns the colour of a position, which is white without one.
    fn colour(&self, position: usize) -> [f64; 3] {
        let found = self.colours.binary_search_by_key(&position, |(of, _)| *of);
        found.map_or([1.0; 3], |index| self.colours[index].1)
    }

    /// Cuts the faces of a part into triangles, and numbers their vertices.
    pub fn mesh(&self, part: &FaceGroup, with_colours: bool) -> PartMesh {
        let corner_count = part.corner_count();
        let mut vertices = Vertices::of_corners(corner_count.min(self.positions.len()));
        let faces: usize = part.faces.iter().map(|list| list.arities.len()).sum();
        let mut triangles = Vec::with_capacity(corner_count - 2 * faces);
        let mut fans = Fans::default();
        for list in &part.faces {
            let mut at = 0;
            for &arity in &list.arities {
                let start = triangles.len();
                let mut number = |index| vertices.number(list.corner(index));
                let (first, mut last) = (number(at), number(at + 1));
                let end = at + arity as usize;
                for index in at + 2..end {
                    let next = number(index);
                    triangles.push([first, last, next]);
                    last = next;
                }
                if arity > 3 {
                    fans.push(start..triangles.len());
                }
                at = end;
            }
        }
        let corners = vertices.into_corners();
        let corners = corners.par_iter().with_min_len(MIN_PER_THREAD);
        let of_kind = |kind: usize| corners.clone().map(move |corner| corner[kind] as usize - 1);
        let positions: Vec<DVec3> = of_kind(0).map(|index| self.positions[index]).collect();
        let uncovered = fans.cut_concave(&mut triangles, &positions);
        let [has_uv, has_normal] = part.complete;
        let mut part = PartMesh {
            mesh: MeshDescription {
                indices: triangles,
                positions,
                normals: Vec::new(),
                uvs: Vec::new(),
            },
            uncovered,
            colours: Vec::new(),
        };
        if has_uv {
            part.mesh.uvs = of_kind(1).map(|index| self.uvs[index]).collect();
        }
        if has_normal {
            part.mesh.normals = of_kind(2).map(|index| self.normals[index]).collect();
        }
        if with_colours {
            part.colours = of_kind(0).map(|index| self.colour(index)).collect();
        }
        part
    }
}
