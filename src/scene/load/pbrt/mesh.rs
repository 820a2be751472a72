//! Meshes of a pbrt file: orientation, texture coordinates, and bilinear patches cut into triangles.
//!
//! Measure: the shape's own units.
//! Range: indices below the number of points.
//! Source: pbrt-v4's file format for texture coordinates and the sides of normals. Tested in `tests/loading/pbrt/`.

use super::textured::Mapping;
use crate::math::vec::{DVec2, DVec3};
use crate::scene::description::MeshDescription;
use crate::scene::load::revolution::fields;

/// Fields along each side of a bilinear patch that is not flat.
const PATCH_FIELDS: u32 = 6;
/// Meshes of more patches than this are fine enough: two triangles for each.
const MAX_CUT_PATCHES: usize = 256;

/// Changes to the mesh of a shape.
#[derive(Debug, Clone, Copy)]
pub struct Finish {
    /// Whether the outside is turned in.
    pub reverse: bool,
    /// Whether the material has textures, and how they change texture coordinates.
    pub textured: Option<Mapping>,
}

/// Gives the triangles of a mesh the side and the texture coordinates that pbrt gives them.
pub fn finish(mesh: &mut MeshDescription, finish: &Finish) {
    if mesh.normals.is_empty() {
        if finish.reverse {
            mesh.indices.iter_mut().for_each(|t| t.swap(1, 2));
        }
    } else {
        if finish.reverse {
            mesh.normals
                .iter_mut()
                .for_each(|normal| *normal = -*normal);
        }
        // A triangle's outside is where the normals of its vertices are.
        let (positions, normals) = (&mesh.positions, &mesh.normals);
        for triangle in &mut mesh.indices {
            let [a, b, c] = triangle.map(|i| positions[i as usize]);
            let sum: DVec3 = triangle
                .iter()
                .map(|&i| normals[i as usize].normalize_or_zero())
                .sum();
            if (b - a).cross(c - a).dot(sum) < 0.0 {
                triangle.swap(1, 2);
            }
        }
    }
    let Some(mapping) = finish.textured else {
        return;
    };
    if mesh.uvs.is_empty() {
        separate(mesh);
    }
    if mapping != Mapping::default() {
        let change = |uv: &mut DVec2| *uv = *uv * mapping.scale + mapping.delta;
        mesh.uvs.iter_mut().for_each(change);
    }
}

/// Gives every triangle vertices of its own, with the texture coordinates of meshes that have none in pbrt.
fn separate(mesh: &mut MeshDescription) {
    let corners = mesh.indices.as_flattened();
    let of = |values: &[DVec3]| -> Vec<DVec3> {
        match values.is_empty() {
            true => vec![],
            false => corners.iter().map(|&i| values[i as usize]).collect(),
        }
    };
    let (positions, normals) = (of(&mesh.positions), of(&mesh.normals));
    let count = mesh.indices.len();
    let uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE].repeat(count);
    let indices = (0..count as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    *mesh = MeshDescription {
        positions,
        normals,
        uvs,
        indices,
    };
}

/// Cuts bilinear patches into triangles; the corners of each are those at (0, 0), (1, 0), (0, 1) and (1, 1). Returns also
/// whether one that is not flat was cut.
pub fn cut_patches(corners: MeshDescription, patches: &[[u32; 4]]) -> (MeshDescription, bool) {
    let flat = |patch: &[u32; 4]| {
        let [p00, p10, p01, p11] = patch.map(|i| corners.positions[i as usize]);
        let (u, v) = (p10 - p00, p01 - p00);
        let size = u.length().max(v.length());
        // With normals or texture coordinates, only those of a parallelogram are linear, too.
        (p11 - p10 - v).length() <= 1e-6 * size
            || (corners.normals.is_empty()
                && corners.uvs.is_empty()
                && (p11 - p00).dot(u.cross(v)).abs() <= 1e-6 * size.powi(3))
    };
    let fine = patches.len() > MAX_CUT_PATCHES;
    let (simple, curved): (Vec<_>, Vec<_>) = patches.iter().partition(|patch| fine || flat(patch));
    let halves = |&[a, b, c, d]: &[u32; 4]| [[a, b, d], [a, d, c]];
    let mut mesh = MeshDescription {
        indices: simple.iter().flat_map(halves).collect(),
        ..corners
    };
    if mesh.uvs.is_empty() && !curved.is_empty() {
        // Curved patches get texture coordinates when they are cut, so all vertices have some.
        mesh.uvs = vec![DVec2::ZERO; mesh.positions.len()];
    }
    let more = curved.len() * ((PATCH_FIELDS + 1) * (PATCH_FIELDS + 1)) as usize;
    mesh.positions.reserve_exact(more);
    mesh.uvs.reserve_exact(more);
    mesh.indices
        .reserve_exact(curved.len() * (2 * PATCH_FIELDS * PATCH_FIELDS) as usize);
    for patch in &curved {
        cut(&mut mesh, patch);
    }
    let is_approximate = !curved.is_empty()
        || patches
            .iter()
            .any(|patch| fine && !is_parallelogram(&mesh, patch));
    (mesh, is_approximate)
}

fn is_parallelogram(mesh: &MeshDescription, patch: &[u32; 4]) -> bool {
    let [p00, p10, p01, p11] = patch.map(|i| mesh.positions[i as usize]);
    (p11 - p10 - p01 + p00).length() <= 1e-6 * (p11 - p00).length()
}

/// Adds one curved patch.
fn cut(mesh: &mut MeshDescription, patch: &[u32; 4]) {
    let first = mesh.positions.len() as u32;
    let corners = patch.map(|i| i as usize);
    let step = |index: u32| f64::from(index) / f64::from(PATCH_FIELDS);
    let given = mesh.uvs[corners[0]] != mesh.uvs[corners[3]];
    for (u, v) in
        (0..=PATCH_FIELDS).flat_map(|y| (0..=PATCH_FIELDS).map(move |x| (step(x), step(y))))
    {
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let mix = |values: &[DVec3]| -> DVec3 {
            corners
                .iter()
                .zip(weights)
                .map(|(&i, w)| w * values[i])
                .sum()
        };
        let position = mix(&mesh.positions);
        mesh.positions.push(position);
        if !mesh.normals.is_empty() {
            let normal = mix(&mesh.normals);
            mesh.normals.push(normal);
        }
        let uv = match given {
            true => corners
                .iter()
                .zip(weights)
                .map(|(&i, w)| w * mesh.uvs[i])
                .sum(),
            false => DVec2::new(u, v),
        };
        mesh.uvs.push(uv);
    }
    mesh.indices
        .extend(fields([PATCH_FIELDS; 2]).map(|triangle| triangle.map(|i| first + i)));
}
