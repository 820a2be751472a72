//! BSDFs with textured parameters: what does not depend on textures is computed once.
//!
//! Measure: as in `bsdf/types.rs`.
//! Range: materials that `load` accepts.
//! Source: none needed. Tested in `tests/scattering/materials.rs`.

use super::super::description::{
    ClearCoatDescription, ColourDescription, MaterialDescription, MaterialModel,
};
use super::colour::Colour;
use crate::bsdf::principled::PrincipledParameters;
use crate::bsdf::{
    Bsdf, ClearCoat, Coated, CoatedBase, Conductor, Dielectric, Diffuse, Mirror, Phong, Principled,
};
use crate::effects::{EffectSet, Effects, Switch};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::sync::Arc;

/// The least roughness where a map varies it. Below 0.01, microfacets would be a mirror.
const MIN_MAPPED_ROUGHNESS: f32 = 0.0101;

/// A BSDF whose parameters may be textured.
#[derive(Debug, Clone)]
pub(super) enum TexturedBsdf {
    /// A BSDF that is the same everywhere.
    Uniform(Bsdf),
    Diffuse(Colour),
    Mirror(Colour),
    /// The dielectric without its tint, and the tint.
    Dielectric(Dielectric, Colour),
    Phong {
        diffuse: Colour,
        specular: Colour,
        exponent: f32,
    },
    /// The BSDF without its base colour, and the base colour.
    Principled(Principled, Colour),
    /// The parameters without the base colour, the base colour, and the factors of roughness (green) and metallic
    /// (blue).
    PrincipledMapped(PrincipledParameters, Colour, Colour),
    /// A base, which is metal or principled, under its coat.
    Coated(Box<Self>, ClearCoat),
}

impl TexturedBsdf {
    /// The BSDF of a model, without maps.
    pub(super) fn new(model: &MaterialModel) -> Self {
        match model {
            MaterialModel::Diffuse { reflectance } => Self::Diffuse(Colour::new(reflectance)),
            MaterialModel::Mirror { reflectance } => Self::Mirror(Colour::new(reflectance)),
            MaterialModel::Conductor {
                eta,
                k,
                roughness,
                tint,
            } => Self::Uniform(Bsdf::Conductor(
                Conductor::new(*eta, *k, *roughness).tinted(*tint),
            )),
            MaterialModel::Dielectric {
                ior,
                roughness,
                tint,
            } => Self::Dielectric(
                Dielectric::new(*ior, *roughness, Rgb::WHITE),
                Colour::new(tint),
            ),
            MaterialModel::ThinDielectric { ior, tint } => {
                Self::Dielectric(Dielectric::thin(*ior, Rgb::WHITE), Colour::new(tint))
            }
            // Without a specular lobe, the material is diffuse.
            MaterialModel::Phong {
                diffuse, specular, ..
            } if specular.is_black() => Self::Diffuse(Colour::new(diffuse)),
            MaterialModel::Phong {
                diffuse,
                specular,
                exponent,
            } => Self::Phong {
                diffuse: Colour::new(diffuse),
                specular: Colour::new(specular),
                exponent: *exponent,
            },
            MaterialModel::Plastic {
                reflectance,
                ior,
                roughness,
            } => Self::principled(reflectance, 0.0, *roughness, *ior, 0.0),
            MaterialModel::Principled {
                base_color,
                metallic,
                roughness,
                ior,
                transmission,
            } => Self::principled(base_color, *metallic, *roughness, *ior, *transmission),
        }
    }

    fn principled(
        base_color: &ColourDescription,
        metallic: f32,
        roughness: f32,
        ior: f32,
        transmission: f32,
    ) -> Self {
        let parameters = PrincipledParameters {
            base_color: Rgb::WHITE,
            metallic,
            roughness,
            ior,
            transmission,
        };
        Self::Principled(Principled::new(&parameters), Colour::new(base_color))
    }

    /// Adds the map of roughness and metallic, if the description has one.
    pub(super) fn mapped(self, description: &MaterialDescription) -> Self {
        let (
            Some(map),
            MaterialModel::Principled {
                base_color,
                metallic,
                roughness,
                ior,
                transmission,
            },
        ) = (&description.metallic_roughness_map, &description.model)
        else {
            return self;
        };
        let map = Colour::new(&ColourDescription::Texture(Arc::clone(map)));
        let [_, rough, metal] = match map {
            Colour::Constant(factors) => factors.to_array(),
            // A smooth surface stays smooth.
            _ if *roughness == 0.0 && *metallic == 0.0 => [1.0; 3],
            _ => {
                let parameters = PrincipledParameters {
                    base_color: Rgb::WHITE,
                    metallic: *metallic,
                    roughness: *roughness,
                    ior: *ior,
                    transmission: *transmission,
                };
                return Self::PrincipledMapped(parameters, Colour::new(base_color), map);
            }
        };
        let (metallic, roughness) = (metal * metallic, rough * roughness);
        Self::principled(base_color, metallic, roughness, *ior, *transmission)
    }

    /// Adds a clear coat, if the description has one that covers anything.
    pub(super) fn coated(self, coat: Option<&ClearCoatDescription>) -> Self {
        match coat {
            Some(&ClearCoatDescription {
                weight,
                roughness,
                ior,
            }) if weight > 0.0 => {
                Self::Coated(Box::new(self), ClearCoat::new(weight, roughness, ior))
            }
            _ => self,
        }
    }

    /// Precomputes the BSDF if it does not vary.
    pub(super) fn folded(self) -> Self {
        if self.is_textured() {
            self
        } else {
            Self::Uniform(self.bsdf(Vec2::ZERO))
        }
    }

    /// The effects that the BSDF requires of a kernel.
    pub(super) fn effects(&self) -> EffectSet {
        match self {
            // Any part may be a dielectric. Glass may be smooth where opaque lobes still are rough.
            Self::PrincipledMapped(parameters, ..) => {
                let at =
                    |roughness| Principled::new(&mapped_parameters(parameters, roughness, 0.0));
                at(0.0).effects() | at(1.0).effects()
            }
            Self::Coated(base, coat) => base.effects() | coat.effects(),
            _ => self.bsdf(Vec2::ZERO).effects(),
        }
    }

    /// Whether all lobes are deltas, see [`Bsdf::is_delta`]. Textures do not change it.
    #[inline]
    pub(super) fn is_delta<E: Effects>(&self) -> bool {
        E::Specular::ON
            && match self {
                Self::Uniform(bsdf) => bsdf.is_delta::<E>(),
                Self::Diffuse(_) | Self::Phong { .. } | Self::PrincipledMapped(..) => false,
                Self::Mirror(_) => true,
                Self::Dielectric(model, _) => model.is_delta(),
                Self::Principled(model, _) => model.is_delta(),
                Self::Coated(base, coat) => coat.is_delta() && base.is_delta::<E>(),
            }
    }

    /// Whether any parameter may vary.
    pub(super) fn is_textured(&self) -> bool {
        match self {
            Self::Uniform(_) => false,
            Self::PrincipledMapped(..) => true,
            Self::Diffuse(colour)
            | Self::Mirror(colour)
            | Self::Dielectric(_, colour)
            | Self::Principled(_, colour) => colour.is_textured(),
            Self::Phong {
                diffuse, specular, ..
            } => diffuse.is_textured() || specular.is_textured(),
            Self::Coated(base, _) => base.is_textured(),
        }
    }

    /// The BSDF at a texture coordinate.
    #[inline]
    pub(super) fn bsdf(&self, uv: Vec2) -> Bsdf {
        match self {
            Self::Uniform(bsdf) => *bsdf,
            Self::Diffuse(reflectance) => Bsdf::Diffuse(Diffuse::new(reflectance.at(uv))),
            Self::Mirror(reflectance) => Bsdf::Mirror(Mirror::new(reflectance.at(uv))),
            Self::Dielectric(glass, tint) => Bsdf::Dielectric(glass.tinted(tint.at(uv))),
            Self::Phong {
                diffuse,
                specular,
                exponent,
            } => Bsdf::Phong(Phong::new(diffuse.at(uv), specular.at(uv), *exponent)),
            Self::Principled(surface, base_color) => {
                Bsdf::Principled(surface.coloured(base_color.at(uv)))
            }
            Self::PrincipledMapped(parameters, base_color, map) => {
                Bsdf::Principled(mapped(parameters, base_color.at(uv), map.at(uv)))
            }
            Self::Coated(base, coat) => match base.bsdf(uv) {
                Bsdf::Conductor(base) => under(CoatedBase::Conductor(base), coat),
                Bsdf::Principled(base) => under(CoatedBase::Principled(base), coat),
                // The scene's check refuses coats of other models.
                bare => bare,
            },
        }
    }
}

fn under(base: CoatedBase, coat: &ClearCoat) -> Bsdf {
    Bsdf::Coated(Coated::new(base, *coat))
}

/// The BSDF whose parameters a map varies, at a point.
#[inline]
pub(super) fn mapped(parameters: &PrincipledParameters, base_color: Rgb, map: Rgb) -> Principled {
    let [_, roughness, metallic] = map.to_array();
    Principled::new(&PrincipledParameters {
        base_color,
        ..mapped_parameters(parameters, roughness, metallic)
    })
}

/// Multiplies roughness and metallic by factors in [0, 1]. Opaque lobes stay rough, so that they are no deltas wherever
/// the texture is black.
#[inline]
fn mapped_parameters(
    parameters: &PrincipledParameters,
    roughness: f32,
    metallic: f32,
) -> PrincipledParameters {
    PrincipledParameters {
        roughness: (roughness * parameters.roughness).clamp(MIN_MAPPED_ROUGHNESS, 1.0),
        metallic: (metallic * parameters.metallic).clamp(0.0, 1.0),
        ..*parameters
    }
}
