//! Meshes as Mitsuba has them: its cube and rectangle, orientation, normals and texture coordinates.
//!
//! Measure: units of the shape.
//! Range: any mesh with valid indices. Where a shape has vertex normals, these decide which side of a triangle is its
//! front, as in Mitsuba, and not the order of its corners.
//! Source: Mitsuba 3 documentation, "Shapes"; smooth normals: Thürmer and Wüthrich 1998, "Computing Vertex Normals from
//! Polygonal Facets". Tested in `tests/loading/mitsuba.rs`.

use crate::math::transform::angle;
use crate::math::vec::{DAffine2, DMat3, DVec2, DVec3};
use crate::scene::description::MeshDescription;

/// The steps that finish a mesh.
#[derive(Debug, Clone, Copy)]
pub struct MeshOptions {
    /// Whether the normals are reversed.
    pub flip: bool,
    /// The transform of texture coordinates, if the material has textures.
    pub to_uv: Option<DAffine2>,
    /// The linear part of the transform to the world. Where it mirrors, triangles show their other side, unless the
    /// file has normals.
    pub to_world: DMat3,
    /// Whether vertex normals are discarded.
    pub face_normals: bool,
    /// Whether v points up in the file.
    pub flip_v: bool,
}

impl MeshOptions {
    /// The options without what does not change a mesh that has normals or not: only normals that are computed depend on the
    /// whole transform, and only triangles without normals on whether it mirrors.
    pub fn reduced(self, has_normals: bool) -> Self {
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        Self {
            to_world: match (self.face_normals, has_normals) {
                (true, _) if self.to_world.determinant() < 0.0 => mirror,
                (true, _) | (false, true) => DMat3::IDENTITY,
                (false, false) => self.to_world,
            },
            flip_v: self.flip_v && self.to_uv.is_some(),
            ..self
        }
    }
}

/// Returns a mesh with our conventions.
pub fn finished(mut mesh: MeshDescription, options: &MeshOptions) -> MeshDescription {
    finish(&mut mesh, options);
    mesh
}

/// Gives a mesh our conventions.
pub fn finish(mesh: &mut MeshDescription, options: &MeshOptions) {
    if options.face_normals {
        mesh.normals.clear();
    } else if mesh.normals.is_empty() {
        mesh.normals = smooth_normals(mesh, options.to_world);
    }
    let is_mirrored = options.to_world.determinant() < 0.0;
    let normals = &mesh.normals;
    let positions = &mesh.positions;
    for triangle in &mut mesh.indices {
        let corners = triangle.map(|i| i as usize);
        let reverse = match normals.is_empty() {
            true => is_mirrored,
            false => {
                let mean: DVec3 = corners.iter().map(|&i| normals[i]).sum();
                face_normal(corners.map(|i| positions[i])).dot(mean) < 0.0
            }
        };
        if reverse != options.flip {
            triangle.swap(1, 2);
        }
    }
    if options.flip {
        mesh.normals
            .iter_mut()
            .for_each(|normal| *normal = -*normal);
    }
    match options.to_uv {
        // Nothing refers to them.
        None => mesh.uvs.clear(),
        Some(to_uv) => {
            for uv in &mut mesh.uvs {
                let v = if options.flip_v { 1.0 - uv.y } else { uv.y };
                let of_texture = to_uv.transform_point2(DVec2::new(uv.x, v));
                *uv = DVec2::new(of_texture.x, 1.0 - of_texture.y);
            }
        }
    }
}

fn face_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Returns the normals of vertices: those of the triangles around them in the world, weighted by their angles.
fn smooth_normals(mesh: &MeshDescription, to_world: DMat3) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.indices {
        let corners = triangle.map(|i| i as usize);
        let points = corners.map(|i| to_world * mesh.positions[i]);
        let Some(normal) = face_normal(points).try_normalize() else {
            continue;
        };
        for i in 0..3 {
            let (to_next, to_last) = (
                points[(i + 1) % 3] - points[i],
                points[(i + 2) % 3] - points[i],
            );
            normals[corners[i]] += angle(to_next, to_last) * normal;
        }
    }
    // Normals are transformed to the world by the inverse transpose. A vertex of no triangle, or whose triangles cancel,
    // gets any.
    let to_object = to_world.transpose();
    normals
        .iter()
        .map(|normal| (to_object * *normal).normalize_or(DVec3::Z))
        .collect()
}

/// Mitsuba's rectangle: from -1 to 1 in x and y, facing z.
pub fn rectangle() -> MeshDescription {
    face([DVec3::X, DVec3::Y, DVec3::ZERO])
}

/// A square spanned by the first two vectors around the third one.
fn face([u, v, center]: [DVec3; 3]) -> MeshDescription {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    MeshDescription {
        positions: corners.map(|(x, y)| center + x * u + y * v).to_vec(),
        normals: vec![u.cross(v); 4],
        uvs: corners
            .map(|(x, y)| DVec2::new(0.5 * (x + 1.0), 0.5 * (y + 1.0)))
            .to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Mitsuba's cube: from -1 to 1 on every axis, facing outwards, each side with texture coordinates from 0 to 1.
pub fn cube() -> MeshDescription {
    /// The normal of each side, and the directions of Mitsuba's u and v, whose v points down an image.
    const SIDES: [[DVec3; 3]; 6] = [
        [DVec3::NEG_Y, DVec3::Z, DVec3::X],
        [DVec3::Y, DVec3::NEG_X, DVec3::NEG_Z],
        [DVec3::X, DVec3::Y, DVec3::NEG_Z],
        [DVec3::Z, DVec3::Y, DVec3::X],
        [DVec3::NEG_X, DVec3::Y, DVec3::Z],
        [DVec3::NEG_Z, DVec3::NEG_Y, DVec3::X],
    ];
    let mut cube = MeshDescription::default();
    for [normal, u, v] in SIDES {
        let mut side = face([v, u, normal]);
        for uv in &mut side.uvs {
            *uv = DVec2::new(uv.y, uv.x);
        }
        let first = cube.positions.len() as u32;
        cube.positions.extend(side.positions);
        cube.normals.extend(side.normals);
        cube.uvs.extend(side.uvs);
        cube.indices.extend(
            side.indices
                .iter()
                .map(|corners| corners.map(|i| first + i)),
        );
    }
    cube
}
