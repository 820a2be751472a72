//! The meshes and images of a scene as files, each written once.
//!
//! Measure: none.
//! Range: files are written to a temporary folder and moved to their places once all of them are there. Files of other
//! names in the folder stay.
//! Source: none needed. Tested in `tests/loading/saving.rs`.

use super::ply;
use crate::error::{Error, Result};
use crate::geometry::texture_image::TextureImage;
use crate::image::atomic::write_atomically;
use crate::image::{self, ColourSpace, WriteOptions};
use crate::scene::description::MeshDescription;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;

/// The files of a scene.
#[derive(Debug)]
pub struct Assets {
    /// The folder that they will be in, and its name.
    folder: PathBuf,
    name: String,
    temporary: TempDir,
    files: Vec<String>,
    // The values keep what the keys point to alive, so that no address is taken twice.
    meshes: HashMap<*const MeshDescription, (String, Arc<MeshDescription>)>,
    images: HashMap<*const TextureImage, (ImageFile, Arc<TextureImage>)>,
}

/// An image file: its path from the scene file, and the encoding of its values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFile {
    pub path: String,
    pub space: ColourSpace,
}

impl Assets {
    /// Prepares to write files that will be in `folder`, whose name is `name`.
    ///
    /// # Errors
    /// If there is no folder that contains it, or it cannot be written to.
    pub fn new(folder: &Path, name: &str) -> Result<Self> {
        let parent = match folder.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let temporary = tempfile::Builder::new()
            .prefix(".etendue-")
            .suffix(".part")
            .tempdir_in(parent)
            .map_err(|error| Error::io("cannot write", folder, error))?;
        Ok(Self {
            folder: folder.to_path_buf(),
            name: name.to_owned(),
            temporary,
            files: vec![],
            meshes: HashMap::new(),
            images: HashMap::new(),
        })
    }

    /// Whether there is no file.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Writes a mesh, and returns its path from the scene file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn mesh(&mut self, mesh: &Arc<MeshDescription>) -> Result<String> {
        if let Some((known, _)) = self.meshes.get(&Arc::as_ptr(mesh)) {
            return Ok(known.clone());
        }
        let (file, path) = self.add(&format!("mesh-{}.ply", self.meshes.len() + 1));
        write_atomically(&file, |writer| ply::write(mesh, writer))?;
        let entry = (path.clone(), Arc::clone(mesh));
        self.meshes.insert(Arc::as_ptr(mesh), entry);
        Ok(path)
    }

    /// Writes an image.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn image(&mut self, texture: &Arc<TextureImage>) -> Result<ImageFile> {
        if let Some((known, _)) = self.images.get(&Arc::as_ptr(texture)) {
            return Ok(known.clone());
        }
        let image = &texture.to_image();
        let stem = format!("image-{}", self.images.len() + 1);
        let encoded = [ColourSpace::Srgb, ColourSpace::Linear]
            .into_iter()
            .find_map(|space| Some((space, image::exact_codes(image, space)?)));
        let written = match encoded {
            Some((space, codes)) => {
                let (file, path) = self.add(&format!("{stem}.png"));
                let size = (image.width(), image.height());
                write_atomically(&file, |writer| image::write_codes(writer, size, &codes))?;
                ImageFile { path, space }
            }
            None => {
                let (file, path) = self.add(&format!("{stem}.exr"));
                image::write(&file, image, &WriteOptions::default())?;
                let space = ColourSpace::Linear;
                ImageFile { path, space }
            }
        };
        let entry = (written.clone(), Arc::clone(texture));
        self.images.insert(Arc::as_ptr(texture), entry);
        Ok(written)
    }

    /// Returns the place where a file is written, and its path from the scene file.
    fn add(&mut self, file: &str) -> (PathBuf, String) {
        self.files.push(file.to_owned());
        let path = format!("{}/{file}", self.name);
        (self.temporary.path().join(file), path)
    }

    /// Moves all files to their folder, which exists unless there are none.
    ///
    /// # Errors
    /// If one cannot be moved.
    pub fn keep(self) -> Result<()> {
        for file in &self.files {
            let to = self.folder.join(file);
            std::fs::rename(self.temporary.path().join(file), &to)
                .map_err(|error| Error::io("cannot write", &to, error))?;
        }
        Ok(())
    }
}
