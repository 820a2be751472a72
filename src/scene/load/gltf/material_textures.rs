//! The textures of a material of glTF, and the set of texture coordinates that they are for.
//!
//! Measure: none.
//! Range: any material. `material.rs` replaces a texture for other coordinates than the first one's by its mean.
//! Source: glTF 2.0, chapter 3.9. Tested in `tests/loading/gltf.rs`.

use super::texture::TextureReference;
use gltf::Material;

/// The textures of a material.
#[derive(Debug, Default)]
pub struct MaterialTextures {
    pub base_color: Option<TextureReference>,
    pub metallic_roughness: Option<TextureReference>,
    pub normals: Option<TextureReference>,
    pub emission: Option<TextureReference>,
    pub transmission: Option<TextureReference>,
}

impl MaterialTextures {
    /// Returns the textures of a material.
    pub fn of(material: &Material<'_>) -> Self {
        let pbr = material.pbr_metallic_roughness();
        let transmission = material.transmission();
        let (base_color, metallic_roughness) = match material.pbr_specular_glossiness() {
            Some(surface) => (surface.diffuse_texture(), None),
            None => (pbr.base_color_texture(), pbr.metallic_roughness_texture()),
        };
        Self {
            base_color: base_color.as_ref().map(TextureReference::new),
            metallic_roughness: metallic_roughness.as_ref().map(TextureReference::new),
            normals: material
                .normal_texture()
                .as_ref()
                .map(TextureReference::of_normals),
            emission: material
                .emissive_texture()
                .as_ref()
                .map(TextureReference::new),
            transmission: transmission
                .and_then(|it| it.transmission_texture())
                .as_ref()
                .map(TextureReference::new),
        }
    }

    /// The texture coordinates of the first texture.
    pub fn uv_set(&self) -> u32 {
        self.all().next().map_or(0, |reference| reference.uv_set)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }

    fn all(&self) -> impl Iterator<Item = &TextureReference> {
        let all = [
            &self.base_color,
            &self.metallic_roughness,
            &self.normals,
            &self.emission,
            &self.transmission,
        ];
        all.into_iter().flatten()
    }
}
