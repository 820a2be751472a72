//! The shapes of glTF meshes: the triangles of a primitive with its material.
//!
//! Measure: the file's own units.
//! Range: any mesh; a primitive without triangles is left out with a note. Vertex colours that vary become a texture of
//! their own where the material has no other, and are replaced by their mean elsewhere.
//! Source: glTF 2.0, chapter 3.7. Tested in `tests/loading/gltf.rs`.

use super::super::contents::SceneContents;
use super::super::vertex_colours;
use super::super::wording::shown;
use super::buffers::Asset;
use super::material::{GltfMaterial, MaterialReader, VertexColour, base_color_factor};
use super::material_textures::MaterialTextures;
use super::mesh::{Meshes, PrimitiveMesh, VertexColours};
use super::of_file;
use super::texture::ImageCache;
use super::thin::{has_border, is_thin, memory_for};
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ColourDescription, GeometryDescription, MeshDescription, NoteKind, Place, ShapeDescription,
};
use gltf::Mesh;
use gltf::material::AlphaMode;
use std::collections::HashMap;
use std::sync::Arc;

/// A material of the file, or the default one, with a colour of vertices, and whether it is that of a sheet.
type MaterialKey = (Option<usize>, [u32; 4], bool);

/// A material of the scene, and what shapes with it emit.
type Known = (usize, Option<ColourDescription>, bool);

/// A primitive with triangles: its place in the JSON, its material, the material's textures and its mesh.
type LoadedPrimitive<'a> = (String, gltf::Material<'a>, MaterialTextures, PrimitiveMesh);

/// A material with its textures, and whether it is that of a sheet.
struct PrimitiveMaterial<'a> {
    material: &'a gltf::Material<'a>,
    textures: &'a MaterialTextures,
    is_thin: bool,
}

/// Reads primitives.
pub struct Primitives<'a> {
    asset: &'a Asset<'a>,
    meshes: Meshes,
    images: ImageCache,
    known: HashMap<MaterialKey, Known>,
    /// Whether the meshes at these addresses, which stay in `meshes`, have a border together.
    borders: HashMap<Vec<*const MeshDescription>, bool>,
}

/// The name of a mesh.
pub fn name(mesh: &Mesh<'_>) -> String {
    let unnamed = || format!("mesh {}", mesh.index());
    mesh.name()
        .filter(|name| !name.is_empty())
        .map_or_else(unnamed, shown)
}

impl<'a> Primitives<'a> {
    pub fn new(asset: &'a Asset<'a>) -> Self {
        Self {
            asset,
            meshes: Meshes::new(asset),
            images: ImageCache::default(),
            known: HashMap::new(),
            borders: HashMap::new(),
        }
    }

    /// Adds the shapes of a mesh.
    ///
    /// # Errors
    /// If a primitive or its material is invalid.
    pub fn add(&mut self, mesh: &Mesh<'_>, contents: &mut SceneContents) -> Result<()> {
        let name = name(mesh);
        let mut left_out = 0;
        let mut parts = vec![];
        for primitive in mesh.primitives() {
            let field = format!("meshes[{}].primitives[{}]", mesh.index(), primitive.index());
            let material = primitive.material();
            let textures = MaterialTextures::of(&material);
            let uv_set = textures.uv_set();
            let read = self.meshes.read(self.asset, &primitive, uv_set, &field)?;
            match read.filter(|read| !read.mesh.indices.is_empty()) {
                Some(read) => parts.push((field, material, textures, read)),
                None => left_out += 1,
            }
        }
        // The parts of a solid that differ in their material are closed only together.
        let may_be_thin = parts.iter().any(|(_, material, ..)| is_thin(material));
        let is_open = may_be_thin && self.has_border(&parts)?;
        for (field, material, textures, read) in parts {
            if read.mesh.uvs.is_empty() && !textures.is_empty() {
                let text =
                    format!("{name} has no texture coordinates: its textures are not placed");
                contents.note(of_file(self.asset.path, NoteKind::Approximation, text));
            }
            let primitive = PrimitiveMaterial {
                material: &material,
                textures: &textures,
                is_thin: is_open && is_thin(&material),
            };
            let (mesh, (material, emission, two_sided_emission)) =
                self.surface(&primitive, &read, &field, contents)?;
            contents.shapes.push(ShapeDescription {
                material,
                emission,
                two_sided_emission,
                ..ShapeDescription::new(
                    name.clone(),
                    Place::of_file(self.asset.path),
                    GeometryDescription::Mesh(mesh),
                )
            });
        }
        if left_out > 0 {
            let text = format!("{name}: {left_out} primitives without triangles were left out");
            contents.note(of_file(self.asset.path, NoteKind::Omission, text));
        }
        Ok(())
    }

    /// Whether the parts of a mesh have a border together.
    fn has_border(&mut self, parts: &[LoadedPrimitive<'_>]) -> Result<bool> {
        let meshes: Vec<_> = parts.iter().map(|part| Arc::clone(&part.3.mesh)).collect();
        let key = meshes.iter().map(Arc::as_ptr).collect();
        if let Some(&known) = self.borders.get(&key) {
            return Ok(known);
        }
        // Many meshes may share their parts: what they take bounds the time of comparing them, too.
        let bytes = memory_for(&meshes);
        if let Some((field, ..)) = parts.first() {
            self.meshes.take(self.asset, field, bytes)?;
        }
        let found = has_border(&meshes);
        self.borders.insert(key, found);
        Ok(found)
    }

    /// Returns the mesh and the material of a primitive.
    fn surface(
        &mut self,
        primitive: &PrimitiveMaterial<'_>,
        read: &PrimitiveMesh,
        field: &str,
        contents: &mut SceneContents,
    ) -> Result<(Arc<MeshDescription>, Known)> {
        let (factor, alpha) = match &read.colours {
            VertexColours::Same(colour, alpha) => (*colour, *alpha),
            VertexColours::Varying(colours, mean, alpha) => {
                if primitive.textures.is_empty() {
                    return self.coloured(primitive, (read, colours, *alpha), field, contents);
                }
                let text =
                    format!("{field}: colours of vertices multiply a texture: their mean is used");
                contents.note(of_file(self.asset.path, NoteKind::Approximation, text));
                (*mean, *alpha)
            }
        };
        let [r, g, b] = factor.to_array();
        let channels = [r, g, b, alpha].map(f32::to_bits);
        let key = (primitive.material.index(), channels, primitive.is_thin);
        if let Some(known) = self.known.get(&key) {
            return Ok((Arc::clone(&read.mesh), known.clone()));
        }
        let vertices = VertexColour {
            factor,
            alpha,
            texture: None,
        };
        let surface = self.read(primitive, &vertices, contents)?;
        let known = added(surface, contents);
        self.known.insert(key, known.clone());
        Ok((Arc::clone(&read.mesh), known))
    }

    /// Returns a mesh and a material with a texture of the vertices' colours.
    fn coloured(
        &mut self,
        primitive: &PrimitiveMaterial<'_>,
        (read, colours, alpha): (&PrimitiveMesh, &[Rgb], f32),
        field: &str,
        contents: &mut SceneContents,
    ) -> Result<(Arc<MeshDescription>, Known)> {
        if alpha < 1.0 && primitive.material.alpha_mode() != AlphaMode::Opaque {
            let text = format!("{field}: the mean of the alpha of vertices is used");
            contents.note(of_file(self.asset.path, NoteKind::Approximation, text));
        }
        let [r, g, b, _] = base_color_factor(primitive.material);
        let factor = Rgb::new(r, g, b).map(|x| x.clamp(0.0, 1.0));
        let colours: Vec<Rgb> = colours.iter().map(|&colour| factor * colour).collect();
        self.meshes.take(
            self.asset,
            field,
            vertex_colours::BYTES as usize * read.mesh.indices.len(),
        )?;
        let mut mesh = MeshDescription::clone(&read.mesh);
        let texture = vertex_colours::to_texture(&mut mesh, &colours)?;
        let vertices = VertexColour {
            factor: Rgb::WHITE,
            alpha,
            texture: Some(texture),
        };
        let surface = self.read(primitive, &vertices, contents)?;
        Ok((Arc::new(mesh), added(surface, contents)))
    }

    fn read(
        &mut self,
        primitive: &PrimitiveMaterial<'_>,
        vertices: &VertexColour,
        contents: &mut SceneContents,
    ) -> Result<GltfMaterial> {
        let mut notes = vec![];
        let mut reader = MaterialReader {
            asset: self.asset,
            images: &mut self.images,
            material: primitive.material,
            textures: primitive.textures,
            is_thin: primitive.is_thin,
            notes: &mut notes,
        };
        let surface = reader.surface(vertices)?;
        notes.into_iter().for_each(|note| contents.note(note));
        Ok(surface)
    }
}

fn added(surface: GltfMaterial, contents: &mut SceneContents) -> Known {
    let material = contents.add_material(surface.material);
    (material, surface.emission, surface.two_sided_emission)
}
