//! Writes a mesh as a binary PLY file, in double precision.
//!
//! Measure: the units of the mesh.
//! Range: any mesh; its vertices and triangles stay in their order.
//! Source: Turk, "The PLY Polygon File Format" (1994). Tested in `tests/loading/saving.rs`.

use crate::scene::description::MeshDescription;
use std::io::{self, Write};

/// Writes a mesh.
///
/// # Errors
/// If the writer fails.
pub fn write(mesh: &MeshDescription, writer: &mut impl Write) -> io::Result<()> {
    let (has_normals, has_uvs) = (!mesh.normals.is_empty(), !mesh.uvs.is_empty());
    writeln!(writer, "ply\nformat binary_little_endian 1.0")?;
    writeln!(writer, "element vertex {}", mesh.positions.len())?;
    let columns = [("x y z", true), ("nx ny nz", has_normals), ("u v", has_uvs)];
    for (names, _) in columns.iter().filter(|(_, is_there)| *is_there) {
        for name in names.split(' ') {
            writeln!(writer, "property double {name}")?;
        }
    }
    writeln!(writer, "element face {}", mesh.indices.len())?;
    writeln!(
        writer,
        "property list uchar uint vertex_indices\nend_header"
    )?;
    for (i, position) in mesh.positions.iter().enumerate() {
        let normal = mesh.normals.get(i).map(|it| it.to_array());
        let uv = mesh.uvs.get(i).map(|it| it.to_array());
        let columns = [
            &position.to_array()[..],
            normal.as_ref().map_or(&[], |it| it),
            uv.as_ref().map_or(&[], |it| it),
        ];
        for number in columns.into_iter().flatten() {
            writer.write_all(&number.to_le_bytes())?;
        }
    }
    for corners in &mesh.indices {
        writer.write_all(&[3])?;
        for corner in corners {
            writer.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}
