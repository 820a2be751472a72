//! Thin sheets of glTF: the surfaces whose transmission passes a sheet instead of entering a solid, and their model.
//!
//! Measure: none.
//! Range: by the format, every surface without a thickness is a sheet. As exporters, such as Blender's, write solids without
//! one, only those of meshes with a border count here: an edge of a single triangle. Vertices at one position count as one,
//! since files have several of them where normals differ.
//! Source: KHR_materials_transmission and KHR_materials_volume. Tested below and in `tests/loading/gltf_odd.rs`.

use crate::scene::description::{MaterialModel, MeshDescription};
use gltf::Material;
use std::sync::Arc;

/// Whether a material transmits light, and by the format through a sheet.
pub fn is_thin(material: &Material<'_>) -> bool {
    let metallic = material.pbr_metallic_roughness();
    let is_metal =
        metallic.metallic_factor() >= 1.0 && metallic.metallic_roughness_texture().is_none();
    let factor = material.transmission().map(|it| it.transmission_factor());
    let volume = material.extension_value("KHR_materials_volume");
    let thickness = volume.and_then(|it| it.get("thicknessFactor")?.as_f64());
    !is_metal && factor.is_some_and(|factor| factor > 0.0) && !thickness.is_some_and(|it| it > 0.0)
}

/// The model of a sheet that has the parameters of a solid; `None` if there is none that is as clear.
pub fn sheet(solid: &MaterialModel) -> Option<MaterialModel> {
    match solid {
        MaterialModel::Principled {
            base_color,
            metallic: 0.0,
            roughness: 0.0,
            ior,
            transmission: 1.0,
        } => Some(MaterialModel::ThinDielectric {
            ior: *ior,
            tint: base_color.clone(),
        }),
        _ => None,
    }
}

/// The memory in bytes that [`has_border`] takes for these meshes.
pub fn memory_for(meshes: &[Arc<MeshDescription>]) -> usize {
    let bytes = |mesh: &Arc<MeshDescription>| {
        let vertex = size_of::<[u64; 3]>() + 2 * size_of::<usize>();
        vertex * mesh.positions.len() + size_of::<[[usize; 2]; 3]>() * mesh.indices.len()
    };
    meshes.iter().map(bytes).sum()
}

/// Whether the meshes together have an edge of a single triangle.
pub fn has_border(meshes: &[Arc<MeshDescription>]) -> bool {
    let positions = meshes.iter().flat_map(|mesh| &mesh.positions);
    // The sum makes the two zeros one.
    let positions = positions.map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
    let positions: Vec<[u64; 3]> = positions.collect();
    let places = places(&positions);
    let mut edges =
        Vec::with_capacity(3 * meshes.iter().map(|mesh| mesh.indices.len()).sum::<usize>());
    let mut first = 0;
    for mesh in meshes {
        for corners in &mesh.indices {
            let [a, b, c] = corners.map(|corner| places[first + corner as usize]);
            if a != b && b != c && c != a {
                edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
            }
        }
        first += mesh.positions.len();
    }
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).any(|edge| edge.len() == 1)
}

/// A number for each vertex: equal ones at equal positions.
fn places(positions: &[[u64; 3]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_unstable_by_key(|&vertex| positions[vertex]);
    let mut places = vec![0; positions.len()];
    for pair in order.windows(2) {
        let (last, next) = (pair[0], pair[1]);
        places[next] = places[last] + usize::from(positions[last] != positions[next]);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::DVec3;

    /// Two triangles on either side of a plane, of separate vertices.
    fn halves() -> [Arc<MeshDescription>; 2] {
        let half = |zero, indices| {
            Arc::new(MeshDescription {
                positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, zero)],
                normals: vec![],
                uvs: vec![],
                indices: vec![indices],
            })
        };
        [half(0.0, [0, 1, 2]), half(-0.0, [0, 2, 1])]
    }

    #[test]
    fn closed_mesh_of_separate_parts_has_no_border() {
        let [front, back] = halves();
        assert!(has_border(&[Arc::clone(&front)]));
        assert!(!has_border(&[Arc::clone(&front), Arc::clone(&back)]));
        let far = |mesh: &MeshDescription| MeshDescription {
            positions: mesh.positions.iter().map(|&p| p + DVec3::Z).collect(),
            ..mesh.clone()
        };
        assert!(has_border(&[front, Arc::new(far(&back))]));
        assert!(!has_border(&[]));
    }
}
