//! A material: its textures looked up at a hit, it becomes a BSDF.
//!
//! Measure: as in `bsdf/types.rs`.
//! Range: what `load` lets through.
//! Source: none needed. Tested in `tests/scene_loading.rs`.

use super::description::{ColourDescription, MaterialModel};
use crate::bsdf::principled::PrincipledParameters;
use crate::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, Mirror, Principled};
use crate::geometry::texture::Texture;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::sync::Arc;

/// A colour that may vary over a surface; textures of one colour have become that colour.
#[derive(Debug, Clone)]
enum Colour {
    Constant(Rgb),
    Texture(Arc<Texture>),
}

impl Colour {
    fn new(description: &ColourDescription) -> Self {
        match description {
            ColourDescription::Constant(colour) => Self::Constant(*colour),
            ColourDescription::Texture(texture) => match texture.constant() {
                Some(colour) => Self::Constant(colour),
                None => Self::Texture(Arc::clone(texture)),
            },
        }
    }

    #[inline]
    fn at(&self, uv: Vec2) -> Rgb {
        match self {
            Self::Constant(colour) => *colour,
            Self::Texture(texture) => texture.lookup(uv),
        }
    }
}

/// A material, ready to be looked up. What does not depend on textures is computed once.
#[derive(Debug, Clone)]
pub struct Material {
    kind: Kind,
    transmits: bool,
}

#[derive(Debug, Clone)]
enum Kind {
    /// The same BSDF everywhere.
    Uniform(Bsdf),
    Diffuse(Colour),
    Mirror(Colour),
    Dielectric {
        ior: f32,
        roughness: f32,
        tint: Colour,
    },
    Principled {
        base_color: Colour,
        parameters: PrincipledParameters,
    },
}

impl Material {
    /// The material of a model.
    pub fn new(model: &MaterialModel) -> Self {
        let (kind, transmits) = match model {
            MaterialModel::Diffuse { reflectance } => {
                (Kind::Diffuse(Colour::new(reflectance)), false)
            }
            MaterialModel::Mirror { reflectance } => {
                (Kind::Mirror(Colour::new(reflectance)), false)
            }
            MaterialModel::Conductor { eta, k, roughness } => {
                let conductor = Conductor::new(*eta, *k, *roughness);
                (Kind::Uniform(Bsdf::Conductor(conductor)), false)
            }
            MaterialModel::Dielectric {
                ior,
                roughness,
                tint,
            } => {
                let tint = Colour::new(tint);
                (
                    Kind::Dielectric {
                        ior: *ior,
                        roughness: *roughness,
                        tint,
                    },
                    true,
                )
            }
            MaterialModel::Principled {
                base_color,
                metallic,
                roughness,
                ior,
                transmission,
            } => {
                let parameters = PrincipledParameters {
                    base_color: Rgb::BLACK,
                    metallic: *metallic,
                    roughness: *roughness,
                    ior: *ior,
                    transmission: *transmission,
                };
                let base_color = Colour::new(base_color);
                let transmits = *transmission > 0.0 && *metallic < 1.0;
                (
                    Kind::Principled {
                        base_color,
                        parameters,
                    },
                    transmits,
                )
            }
        };
        let material = Self { kind, transmits };
        if material.is_textured() {
            return material;
        }
        Self {
            kind: Kind::Uniform(material.bsdf(Vec2::ZERO)),
            transmits,
        }
    }

    fn is_textured(&self) -> bool {
        match &self.kind {
            Kind::Uniform(_) => false,
            Kind::Diffuse(colour)
            | Kind::Mirror(colour)
            | Kind::Dielectric { tint: colour, .. }
            | Kind::Principled {
                base_color: colour, ..
            } => matches!(colour, Colour::Texture(_)),
        }
    }

    /// How it scatters at a texture coordinate.
    #[inline]
    pub fn bsdf(&self, uv: Vec2) -> Bsdf {
        match &self.kind {
            Kind::Uniform(bsdf) => *bsdf,
            Kind::Diffuse(reflectance) => Bsdf::Diffuse(Diffuse::new(reflectance.at(uv))),
            Kind::Mirror(reflectance) => Bsdf::Mirror(Mirror::new(reflectance.at(uv))),
            Kind::Dielectric {
                ior,
                roughness,
                tint,
            } => Bsdf::Dielectric(Dielectric::new(*ior, *roughness, tint.at(uv))),
            Kind::Principled {
                base_color,
                parameters,
            } => {
                let base_color = base_color.at(uv);
                Bsdf::Principled(Principled::new(&PrincipledParameters {
                    base_color,
                    ..*parameters
                }))
            }
        }
    }

    /// Whether light passes through its surface, so that its two sides differ.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmits
    }
}
