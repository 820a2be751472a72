//! Materials as they were written.
//!
//! Measure: reflectances without unit; roughness is perceptual.
//! Range: what `load` lets through: every reflectance in [0, 1].
//! Source: docs/scene-format.md. Tested through `load`.

use super::{ColourDescription, Place};
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use std::sync::Arc;

/// A named material.
#[derive(Debug, Clone)]
pub struct MaterialDescription {
    /// Its name, unique among the materials of its file.
    pub name: String,
    /// Where it was defined.
    pub place: Place,
    /// How it scatters.
    pub model: MaterialModel,
    /// The share of the surface that is there; where it is not, light passes straight on. Its luminance counts.
    pub alpha: ColourDescription,
    /// Tilts the shading normal.
    pub normal_map: Option<NormalMapDescription>,
    /// Whether both sides scatter; otherwise the back absorbs everything. True for what light passes through.
    pub two_sided: bool,
}

/// A picture of normals in tangent space.
#[derive(Debug, Clone)]
pub struct NormalMapDescription {
    /// x, y and z of the normal, each from [-1, 1] to [0, 1]: x along u, y along v, z away from the surface.
    pub texture: Arc<Texture>,
    /// Multiplies x and y, at least 0.
    pub strength: f32,
}

impl MaterialDescription {
    /// A material of a model, all there, flat, and two-sided.
    pub fn new(name: impl Into<String>, place: Place, model: MaterialModel) -> Self {
        Self {
            name: name.into(),
            place,
            model,
            alpha: ColourDescription::Constant(Rgb::WHITE),
            normal_map: None,
            two_sided: true,
        }
    }
}

/// The scattering models. Roughness is perceptual, in [0, 1]: the microfacet alpha is its square.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum MaterialModel {
    /// Lambert.
    Diffuse {
        /// Albedo.
        reflectance: ColourDescription,
    },
    /// A perfect mirror.
    Mirror {
        /// The share that it reflects.
        reflectance: ColourDescription,
    },
    /// Metal with a complex refractive index.
    Conductor {
        /// Real part of the index, per channel, above 0.
        eta: Rgb,
        /// Imaginary part, per channel, at least 0.
        k: Rgb,
        /// Roughness; 0 is smooth.
        roughness: f32,
    },
    /// Lambert with a highlight about the mirror direction. Both colours together are at most 1 everywhere.
    Phong {
        /// Albedo of the matte part.
        diffuse: ColourDescription,
        /// Albedo of the highlight, seen along the normal.
        specular: ColourDescription,
        /// The power of the cosine, from 0 to 1e6.
        exponent: f32,
    },
    /// A matte base under a clear coat.
    Plastic {
        /// Albedo of the base.
        reflectance: ColourDescription,
        /// Refractive index of the coat, at least 1.
        ior: f32,
        /// Roughness of the coat; 0 is smooth.
        roughness: f32,
    },
    /// Glass and water.
    Dielectric {
        /// Refractive index, inside over outside, above 0.
        ior: f32,
        /// Roughness; 0 is smooth.
        roughness: f32,
        /// Multiplies what is refracted.
        tint: ColourDescription,
    },
    /// The metallic-roughness model of glTF, with refraction.
    Principled {
        /// Albedo of the base, reflectance of the metal, tint of the glass.
        base_color: ColourDescription,
        /// 0 is dielectric, 1 is metal.
        metallic: f32,
        /// Roughness; 0 is smooth.
        roughness: f32,
        /// Refractive index of the dielectric, at least 1.
        ior: f32,
        /// The share of the dielectric's base that refracts instead of scattering.
        transmission: f32,
    },
}

impl MaterialModel {
    /// Whether light passes through, so that both sides scatter.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Dielectric { .. } => true,
            Self::Principled {
                metallic,
                transmission,
                ..
            } => (1.0 - metallic) * transmission > 0.0,
            _ => false,
        }
    }
}
