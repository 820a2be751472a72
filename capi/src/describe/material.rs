//! Materials.
//!
//! Measure: fractions without unit; roughness is perceptual.
//! Range: as in docs/scene-format.md for `[[material]]`.
//! Source: docs/scene-format.md.

use super::image::{EtdImage, texture, texture_or};
use super::{choice, or_default};
use crate::memory::{Versioned, text};
use crate::status::Failure;
use renderer::Rgb;
use renderer::description::{
    BumpMapDescription, ClearCoatDescription, MaterialDescription, MaterialModel,
    NormalMapDescription, Place,
};
use std::ffi::c_char;
use std::mem::offset_of;

/// Scattering models.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdModel {
    /// Lambertian reflection: `color`.
    Diffuse = 0,
    /// A perfect mirror: `color`.
    Mirror = 1,
    /// Metal with a complex refractive index: `eta`, `k`, `roughness`.
    Conductor = 2,
    /// A dielectric such as glass or water: `ior`, `roughness`, and `color` as the tint of refracted light.
    Dielectric = 3,
    /// A specular lobe over a diffuse one: `color`, `specular`, `exponent`.
    Phong = 4,
    /// A diffuse base under a dielectric coat: `color`, `ior`, `roughness`.
    Plastic = 5,
    /// The metallic-roughness model: `color`, `metallic`, `roughness`, `ior`, `transmission`.
    Principled = 6,
    /// A smooth pane of a dielectric: `ior`, and `color` as the tint of transmitted light.
    ThinDielectric = 7,
}

/// A material. Fields that are not listed at its model are ignored; sides, alpha and normals apply to every model.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdMaterial {
    /// sizeof(EtdMaterial)
    pub struct_size: usize,
    /// Name for messages; may be null.
    pub name: *const c_char,
    /// An `EtdModel`.
    pub model: i32,
    /// Reflectance or tint, from 0 to 1 in each channel.
    pub color: [f32; 3],
    /// Replaces `color`, indexed by the texture coordinates of the shape; null for none.
    pub texture: *const EtdImage,
    /// Albedo of the specular lobe; at most 1 when added to `color`.
    pub specular: [f32; 3],
    /// Exponent of the cosine of the specular lobe, up to 1e6.
    pub exponent: f32,
    /// Roughness, from 0 (smooth) to 1.
    pub roughness: f32,
    /// Refractive index, inside over outside; 0 stands for 1.5.
    pub ior: f32,
    /// Metalness, from 0 to 1.
    pub metallic: f32,
    /// Transmission, from 0 to 1.
    pub transmission: f32,
    /// Real part of a metal's refractive index, above 0.
    pub eta: [f32; 3],
    /// Imaginary part of a metal's refractive index.
    pub k: [f32; 3],
    /// Other than 0: the back absorbs everything.
    pub one_sided: u32,
    /// Replaces `alpha`, indexed by the texture coordinates of the shape: the luminance of each pixel, from 0 to 1, is
    /// used; null for none.
    pub alpha_texture: *const EtdImage,
    /// Replaces `specular`, indexed by the texture coordinates of the shape; null for none.
    pub specular_texture: *const EtdImage,
    /// A normal map, indexed by the texture coordinates of the shape: red is along u, green along v, blue away from the
    /// surface, each mapped from [-1, 1] to [0, 1]; null for none.
    pub normal_map: *const EtdImage,
    /// Factor for red and green of the normals; 0 stands for 1.
    pub normal_strength: f32,
    /// Coverage of the surface (opacity), up to 1; light passes straight through the rest. 0 stands for 1.
    pub alpha: f32,
    /// A bump map, indexed by the texture coordinates of the shape: the luminance of each pixel, from 0 to 1 or beyond, is a
    /// height; null for none, as beside `normal_map`.
    pub bump_map: *const EtdImage,
    /// The height of a value of 1, in world units; below 0, bumps become dents.
    pub bump_height: f32,
    /// The fraction of the surface under a clear coat, from 0 (none) to 1, of a conductor or of a principled material
    /// without transmission.
    pub clear_coat: f32,
    /// Roughness of the clear coat, from 0 (smooth) to 1.
    pub clear_coat_roughness: f32,
    /// Refractive index of the clear coat, at least 1; 0 stands for 1.5.
    pub clear_coat_ior: f32,
}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdMaterial {
    const NAME: &'static str = "EtdMaterial";
    const FIRST_SIZE: usize = offset_of!(EtdMaterial, alpha_texture);
}

impl EtdMaterial {
    /// # Safety
    /// Its pointers are null, or valid.
    pub unsafe fn describe(&self) -> Result<MaterialDescription, Failure> {
        // SAFETY: the caller's promise.
        let name = unsafe { text(self.name, "name") }?.unwrap_or("material");
        let alpha = Rgb::grey(or_default(self.alpha, 1.0));
        let normal_map = if self.normal_map.is_null() {
            None
        } else {
            Some(NormalMapDescription {
                // SAFETY: the caller's promise.
                texture: unsafe { texture(self.normal_map) }?,
                strength: or_default(self.normal_strength, 1.0),
                is_right_handed: false,
            })
        };
        let bump_map = if self.bump_map.is_null() {
            None
        } else {
            Some(BumpMapDescription {
                // SAFETY: the caller's promise.
                texture: unsafe { texture(self.bump_map) }?,
                height: self.bump_height,
            })
        };
        let clear_coat = (self.clear_coat != 0.0).then(|| ClearCoatDescription {
            weight: self.clear_coat,
            roughness: self.clear_coat_roughness,
            ior: or_default(self.clear_coat_ior, 1.5),
        });
        Ok(MaterialDescription {
            clear_coat,
            // SAFETY: as above.
            alpha: unsafe { texture_or(self.alpha_texture, alpha) }?,
            normal_map,
            bump_map,
            two_sided: self.one_sided == 0,
            // SAFETY: as above.
            ..MaterialDescription::new(name, Place::default(), unsafe { self.model() }?)
        })
    }

    /// # Safety
    /// As [`EtdMaterial::describe`].
    unsafe fn model(&self) -> Result<MaterialModel, Failure> {
        const MODELS: &[(i32, EtdModel)] = &[
            (EtdModel::Diffuse as i32, EtdModel::Diffuse),
            (EtdModel::Mirror as i32, EtdModel::Mirror),
            (EtdModel::Conductor as i32, EtdModel::Conductor),
            (EtdModel::Dielectric as i32, EtdModel::Dielectric),
            (EtdModel::Phong as i32, EtdModel::Phong),
            (EtdModel::Plastic as i32, EtdModel::Plastic),
            (EtdModel::Principled as i32, EtdModel::Principled),
            (EtdModel::ThinDielectric as i32, EtdModel::ThinDielectric),
        ];
        // SAFETY: the caller's promise.
        let color = unsafe { texture_or(self.texture, self.color.into()) }?;
        let roughness = self.roughness;
        let ior = or_default(self.ior, 1.5);
        Ok(match choice(self.model, MODELS, "model")? {
            EtdModel::Diffuse => MaterialModel::Diffuse { reflectance: color },
            EtdModel::Mirror => MaterialModel::Mirror { reflectance: color },
            EtdModel::Conductor => MaterialModel::Conductor {
                eta: self.eta.into(),
                k: self.k.into(),
                roughness,
                tint: Rgb::WHITE,
            },
            EtdModel::Dielectric => MaterialModel::Dielectric {
                ior,
                roughness,
                tint: color,
            },
            EtdModel::ThinDielectric => MaterialModel::ThinDielectric { ior, tint: color },
            EtdModel::Phong => MaterialModel::Phong {
                diffuse: color,
                // SAFETY: as above.
                specular: unsafe { texture_or(self.specular_texture, self.specular.into()) }?,
                exponent: self.exponent,
            },
            EtdModel::Plastic => MaterialModel::Plastic {
                reflectance: color,
                ior,
                roughness,
            },
            EtdModel::Principled => MaterialModel::Principled {
                base_color: color,
                metallic: self.metallic,
                roughness,
                ior,
                transmission: self.transmission,
            },
        })
    }
}
