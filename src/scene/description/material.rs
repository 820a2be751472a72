//! Descriptions of materials.
//!
//! Measure: reflectances without unit; roughness is perceptual.
//! Range: guaranteed by `load`: every reflectance in [0, 1].
//! Source: docs/scene-format.md. Tested through `load`.

use super::{ColourDescription, Place};
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use serde::Serialize;
use std::sync::Arc;

/// A named material.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct MaterialDescription {
    /// The name, unique among the materials of its file.
    #[serde(skip)]
    pub name: String,
    /// The place of its definition.
    #[serde(skip)]
    pub place: Place,
    /// The scattering model.
    pub model: MaterialModel,
    /// Coverage of the surface (opacity); light passes straight through the rest. Only its luminance is used.
    pub alpha: ColourDescription,
    /// If given, the surface is present where `alpha` is at least this, and absent elsewhere.
    pub alpha_cutoff: Option<f32>,
    /// The normal map that tilts the shading normal.
    pub normal_map: Option<NormalMapDescription>,
    /// The bump map that tilts the shading normal, of a material without a normal map.
    pub bump_map: Option<BumpMapDescription>,
    /// Factors of the principled model's `roughness` (green) and `metallic` (blue), which vary over the surface. Other
    /// models ignore it.
    pub metallic_roughness_map: Option<Arc<Texture>>,
    /// The clear coat of a conductor or of an opaque principled surface.
    pub clear_coat: Option<ClearCoatDescription>,
    /// Whether both sides scatter; otherwise the back absorbs everything. True for transmissive materials.
    pub two_sided: bool,
}

/// A clear coat: a layer of a dielectric over the surface.
#[derive(Debug, Clone, Copy, Serialize, PartialEq)]
pub struct ClearCoatDescription {
    /// The fraction of the surface that is coated, from 0 to 1.
    pub weight: f32,
    /// Roughness of the coat; 0 is smooth.
    pub roughness: f32,
    /// Refractive index of the coat, at least 1.
    pub ior: f32,
}

/// A tangent-space normal map.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct NormalMapDescription {
    /// x, y and z of the normal, each mapped from [-1, 1] to [0, 1]: x along u, y along v, z away from the surface.
    pub texture: Arc<Texture>,
    /// Factor for x and y, at least 0.
    pub strength: f32,
    /// Whether y is always to the left of x, seen from outside, as in Mitsuba, and not along v.
    pub is_right_handed: bool,
}

/// A bump map: heights of the surface that only shading sees.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct BumpMapDescription {
    /// The heights, of which the luminance is used.
    pub texture: Arc<Texture>,
    /// The height of a value of 1 along the shading normal, in world units.
    pub height: f32,
}

impl MaterialDescription {
    /// Returns a material of this model: opaque, without a map of normals or heights, and two-sided.
    pub fn new(name: impl Into<String>, place: Place, model: MaterialModel) -> Self {
        Self {
            name: name.into(),
            place,
            model,
            alpha: ColourDescription::Constant(Rgb::WHITE),
            alpha_cutoff: None,
            normal_map: None,
            bump_map: None,
            metallic_roughness_map: None,
            clear_coat: None,
            two_sided: true,
        }
    }
}

impl MaterialDescription {
    /// Whether the material transmits light anywhere, so that both sides scatter.
    pub fn transmits(&self) -> bool {
        match (&self.model, &self.metallic_roughness_map) {
            // The map may make any part of a metal a dielectric.
            (MaterialModel::Principled { transmission, .. }, Some(_)) => *transmission > 0.0,
            (model, _) => model.transmits(),
        }
    }
}

/// The scattering models. Roughness is perceptual, in [0, 1]: the microfacet alpha is its square.
#[derive(Debug, Clone, Serialize, PartialEq)]
#[non_exhaustive]
pub enum MaterialModel {
    /// Lambertian reflection.
    Diffuse {
        /// Albedo.
        reflectance: ColourDescription,
    },
    /// A perfect mirror.
    Mirror {
        /// The reflectance.
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
        /// Factor for the reflected light.
        tint: Rgb,
    },
    /// Lambertian reflection plus a lobe around the mirror direction. The two colours sum to at most 1 everywhere.
    Phong {
        /// Albedo of the diffuse lobe.
        diffuse: ColourDescription,
        /// Albedo of the specular lobe at normal incidence.
        specular: ColourDescription,
        /// The exponent of the cosine, from 0 to 1e6.
        exponent: f32,
    },
    /// A diffuse base under a dielectric coat.
    Plastic {
        /// Albedo of the base.
        reflectance: ColourDescription,
        /// Refractive index of the coat, at least 1.
        ior: f32,
        /// Roughness of the coat; 0 is smooth.
        roughness: f32,
    },
    /// A dielectric such as glass or water.
    Dielectric {
        /// Refractive index, inside over outside, above 0.
        ior: f32,
        /// Roughness; 0 is smooth.
        roughness: f32,
        /// Factor for the refracted light.
        tint: ColourDescription,
    },
    /// A smooth pane of a dielectric, with air on both sides, such as the glass of a window.
    ThinDielectric {
        /// Refractive index, above 0.
        ior: f32,
        /// Factor for the transmitted light.
        tint: ColourDescription,
    },
    /// The metallic-roughness model of glTF, with refraction.
    Principled {
        /// Albedo of the diffuse base, reflectance of the metal, tint of the refracted light.
        base_color: ColourDescription,
        /// 0 is dielectric, 1 is metal.
        metallic: f32,
        /// Roughness; 0 is smooth.
        roughness: f32,
        /// Refractive index of the dielectric, at least 1.
        ior: f32,
        /// The fraction of the dielectric base that refracts instead of scattering diffusely.
        transmission: f32,
    },
}

impl MaterialModel {
    /// Whether the model may have a clear coat: metal, and principled surfaces that transmit nothing.
    pub fn takes_clear_coat(&self) -> bool {
        match self {
            Self::Conductor { .. } => true,
            Self::Principled { transmission, .. } => *transmission == 0.0,
            _ => false,
        }
    }

    /// Whether the model transmits light, without a map of its parameters.
    fn transmits(&self) -> bool {
        match self {
            Self::Dielectric { .. } | Self::ThinDielectric { .. } => true,
            Self::Principled {
                metallic,
                transmission,
                ..
            } => (1.0 - metallic) * transmission > 0.0,
            _ => false,
        }
    }
}
