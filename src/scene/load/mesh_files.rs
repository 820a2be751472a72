//! The mesh files of a scene: shapes that refer to one file, and change its meshes in the same way, share these.
//!
//! Measure: as in the description.
//! Range: a file is read at most twice, however many shapes refer to it. From the second reading on, which is for a shape that
//! changes the meshes in another way than the first, they are also kept as they are in the file: at most half as much
//! memory again as all shapes of the file have.
//! Source: none needed. Tested below and in `tests/loading/shared_meshes.rs`.

use super::contents::SceneContents;
use crate::error::Result;
use crate::memory;
use crate::scene::description::MeshDescription;
use std::collections::HashMap;
use std::fmt::Debug;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The meshes of a file.
#[derive(Debug, Clone, Default)]
pub struct FileMeshes {
    pub parts: Vec<MeshDescription>,
    /// Whether the file asks for the normals of its faces.
    pub is_faceted: bool,
}

/// Facts about a file that decide how its meshes are changed.
#[derive(Debug, Clone, Copy)]
pub struct MeshFacts {
    /// Whether every mesh has normals.
    pub have_normals: bool,
    pub is_faceted: bool,
}

/// Meshes that shapes share.
type SharedMeshes = Vec<Arc<MeshDescription>>;

/// The mesh files read so far.
#[derive(Debug, Default)]
pub struct MeshFiles(HashMap<(PathBuf, usize), MeshFile>);

/// A file that was read.
#[derive(Debug)]
struct MeshFile {
    facts: MeshFacts,
    /// Its meshes, by how they were changed.
    changed: HashMap<String, SharedMeshes>,
    /// Its meshes as they are.
    original: Option<FileMeshes>,
}

impl MeshFile {
    fn new(meshes: &FileMeshes) -> Self {
        let have_normals = meshes.parts.iter().all(|mesh| !mesh.normals.is_empty());
        Self {
            facts: MeshFacts {
                have_normals,
                is_faceted: meshes.is_faceted,
            },
            changed: HashMap::new(),
            original: None,
        }
    }
}

impl MeshFiles {
    /// Returns the meshes of a file, changed by `change`. `read` reads the file, of which `index` is the part that it reads;
    /// `changes` returns what `change` depends on, all of which its debug format has to show.
    ///
    /// # Errors
    /// If the file cannot be read, or there is no memory for a further copy.
    pub fn meshes<C: Debug>(
        &mut self,
        (path, index): (&Path, usize),
        contents: &mut SceneContents,
        read: impl Fn(&mut SceneContents) -> Result<FileMeshes>,
        changes: impl Fn(MeshFacts) -> C,
        change: impl Fn(&mut MeshDescription, &C),
    ) -> Result<SharedMeshes> {
        // A file may have several names.
        let unique = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let key = (unique, index);
        let changed = |meshes: FileMeshes, changes: &C| -> SharedMeshes {
            let change = |mut mesh| {
                change(&mut mesh, changes);
                Arc::new(mesh)
            };
            meshes.parts.into_iter().map(change).collect()
        };
        let Some(file) = self.0.get_mut(&key) else {
            let meshes = read(contents)?;
            let mut file = MeshFile::new(&meshes);
            let changes = changes(file.facts);
            let shared = changed(meshes, &changes);
            file.changed.insert(format!("{changes:?}"), shared.clone());
            self.0.insert(key, file);
            return Ok(shared);
        };
        let changes = changes(file.facts);
        let how = format!("{changes:?}");
        if let Some(shared) = file.changed.get(&how) {
            return Ok(shared.clone());
        }
        let original = match &mut file.original {
            Some(original) => original,
            none => {
                let notes = contents.notes.len();
                let meshes = read(contents)?;
                // The first reading gave the notes already.
                contents.notes.truncate(notes);
                none.insert(meshes)
            }
        };
        let bytes = original.parts.iter().map(bytes_of).sum();
        memory::check(bytes, || format!("the mesh of {}", path.display()))?;
        let shared = changed(original.clone(), &changes);
        file.changed.insert(how, shared.clone());
        Ok(shared)
    }
}

/// The bytes that a mesh takes.
fn bytes_of(mesh: &MeshDescription) -> u64 {
    let bytes = size_of_val(&*mesh.positions)
        + size_of_val(&*mesh.normals)
        + size_of_val(&*mesh.uvs)
        + size_of_val(&*mesh.indices);
    bytes as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::DVec3;
    use std::cell::Cell;

    #[test]
    fn mesh_file_is_read_twice_at_most_and_shared_by_equal_changes() {
        let (mut files, mut contents) = (MeshFiles::default(), SceneContents::default());
        let readings = Cell::new(0);
        let mut meshes = |index: usize, by: f64| {
            let read = |_: &mut SceneContents| {
                readings.set(readings.get() + 1);
                let parts = vec![MeshDescription {
                    positions: vec![DVec3::ONE],
                    ..MeshDescription::default()
                }];
                Ok(FileMeshes {
                    parts,
                    is_faceted: false,
                })
            };
            let change = |mesh: &mut MeshDescription, by: &f64| mesh.positions[0] *= *by;
            let file = (Path::new("none.ply"), index);
            let found = files.meshes(file, &mut contents, read, |_| by, change);
            found.expect("it is read").remove(0)
        };
        let first = meshes(0, 2.0);
        assert!(Arc::ptr_eq(&first, &meshes(0, 2.0)));
        for by in [3.0, 4.0, 5.0, 3.0] {
            assert_eq!(meshes(0, by).positions, [DVec3::splat(by)]);
        }
        assert!(Arc::ptr_eq(&first, &meshes(0, 2.0)));
        let other = meshes(1, 2.0);
        assert_eq!(other, first);
        assert!(!Arc::ptr_eq(&first, &other));
        assert_eq!(readings.get(), 3);
    }
}
