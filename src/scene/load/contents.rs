//! The materials, shapes, groups and notes collected while a scene is read.
//!
//! Measure: as in the description.
//! Range: names of materials are unique, and so are those of groups; indices are those of `materials` and `groups`.
//! Source: none needed. Tested in `tests/loading/scene_files.rs`.

use super::colour::TextureCache;
use super::ply;
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ColourDescription, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription,
    Note, Place, ShapeDescription,
};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Maximum number of notes: a file may cause one in every line.
const MAX_NOTES: usize = 20;

/// A mesh, and the colours of its vertices, if it has any.
type Ply = (Arc<MeshDescription>, Arc<Vec<Rgb>>);

/// The materials, shapes, groups, instances and notes read so far.
#[derive(Debug, Default)]
pub struct SceneContents {
    pub materials: Vec<MaterialDescription>,
    pub shapes: Vec<ShapeDescription>,
    pub groups: Vec<String>,
    pub instances: Vec<InstanceDescription>,
    pub textures: TextureCache,
    pub notes: Vec<Note>,
    /// The PLY files read so far: a mesh that several shapes have is stored once.
    plys: HashMap<PathBuf, Ply>,
    /// The shapes of models read so far, by file, and whether they have a material that is not the file's.
    models: HashMap<(PathBuf, bool), Vec<ShapeDescription>>,
    /// Materials that shapes can refer to by name: those of the scene file, not those of its models.
    named: HashMap<String, usize>,
    /// Groups that have a member.
    named_groups: HashMap<String, usize>,
    default_material: Option<usize>,
}

impl SceneContents {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: MaterialDescription) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a material that shapes can refer to by name; returns `false` if the name is taken.
    pub fn add_named_material(&mut self, material: MaterialDescription) -> bool {
        let name = material.name.clone();
        let index = self.add_material(material);
        self.named.insert(name, index).is_none()
    }

    /// Returns the material of this name.
    pub fn material_named(&self, name: &str) -> Option<usize> {
        self.named.get(name).copied()
    }

    /// Returns all material names in alphabetical order.
    pub fn material_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.named.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    /// Returns the group of this name, which is added if it does not exist.
    pub fn add_to_group(&mut self, name: &str) -> usize {
        if let Some(index) = self.group_named(name) {
            return index;
        }
        let index = self.groups.len();
        self.groups.push(name.to_owned());
        self.named_groups.insert(name.to_owned(), index);
        index
    }

    /// Returns the group of this name, if it has a member.
    pub fn group_named(&self, name: &str) -> Option<usize> {
        self.named_groups.get(name).copied()
    }

    /// Returns all group names in alphabetical order.
    pub fn group_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.groups.iter().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    /// Reads a PLY file, once.
    ///
    /// # Errors
    /// If it cannot be read or is invalid.
    pub fn ply(&mut self, path: &Path) -> Result<Ply> {
        if let Some(known) = self.plys.get(path) {
            return Ok(known.clone());
        }
        let model = ply::read_mesh(path)?;
        for note in model.notes {
            self.note(note);
        }
        let read = (Arc::new(model.mesh), Arc::new(model.colours));
        self.plys.insert(path.to_path_buf(), read.clone());
        Ok(read)
    }

    /// Returns the shapes of a model, which `read` reads unless it was read already; `material` replaces the materials of the
    /// file.
    ///
    /// # Errors
    /// If it cannot be read or is invalid.
    pub fn model(
        &mut self,
        path: &Path,
        material: Option<usize>,
        read: impl FnOnce(&mut Self) -> Result<Vec<ShapeDescription>>,
    ) -> Result<Vec<ShapeDescription>> {
        let key = (path.to_path_buf(), material.is_some());
        let mut shapes = match self.models.get(&key) {
            Some(known) => known.clone(),
            None => {
                let shapes = read(self)?;
                self.models.insert(key, shapes.clone());
                shapes
            }
        };
        if let Some(material) = material {
            shapes
                .iter_mut()
                .for_each(|shape| shape.material = material);
        }
        Ok(shapes)
    }

    /// Returns the grey default material, which is added on first use.
    pub fn default_material(&mut self) -> usize {
        if let Some(index) = self.default_material {
            return index;
        }
        let reflectance = ColourDescription::Constant(Rgb::grey(0.5));
        let model = MaterialModel::Diffuse { reflectance };
        let index = self.add_material(MaterialDescription::new("default", Place::default(), model));
        self.default_material = Some(index);
        index
    }

    /// Adds a note for the user. After the maximum number of notes there is one for all others, of their greatest kind.
    pub fn note(&mut self, note: Note) {
        if self.notes.len() < MAX_NOTES {
            self.notes.push(note);
        } else if let Some(rest) = self.notes.get_mut(MAX_NOTES) {
            rest.kind = rest.kind.max(note.kind);
        } else {
            self.notes
                .push(Note::of_scene(note.kind, "further notes are not shown"));
        }
    }
}
