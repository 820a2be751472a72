//! Materials: evaluate their textures at a hit to yield a BSDF.
//!
//! Measure: as in `bsdf/types.rs`.
//! Range: materials that `load` accepts.
//! Source: none needed. Tested in `tests/loading/scene_files.rs` and `tests/scattering/materials.rs`.

use super::description::{ColourDescription, MaterialDescription, MaterialModel};
use super::normal_map::NormalMap;
use super::shape_traits::ShapeTraits;
use crate::bsdf::albedo::RowPlace;
use crate::bsdf::principled::PrincipledParameters;
use crate::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, Mirror, Phong, Principled};
use crate::effects::{Effect, EffectSet, Effects, Switch, beyond_kernel};
use crate::geometry::packed::{PackedImage, PackedImages};
use crate::geometry::texture::Texture;
use crate::geometry::uv_map::UvMap;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::borrow::Cow;
use std::sync::Arc;

/// The least roughness where a map varies it. Below 0.01, microfacets would be a mirror.
const LEAST_MAPPED_ROUGHNESS: f32 = 0.0101;

/// A colour that may vary over a surface; constant textures are stored as constants.
#[derive(Debug, Clone)]
enum Colour {
    Constant(Rgb),
    Texture(Arc<Texture>),
    /// A packed image and its scale.
    Packed(Arc<PackedImage>, f32),
    /// A packed image, its tint and its place.
    PackedPlaced(Arc<PackedImage>, Rgb, UvMap),
}

impl Colour {
    fn new(description: &ColourDescription) -> Self {
        match (description, description.constant()) {
            (_, Some(colour)) => Self::Constant(colour),
            (ColourDescription::Constant(colour), None) => Self::Constant(*colour),
            (ColourDescription::Texture(texture), None) => Self::Texture(Arc::clone(texture)),
        }
    }

    /// Replaces an image texture by a packed one, for faster lookups.
    fn pack(&mut self, images: &mut PackedImages) {
        let Self::Texture(texture) = self else { return };
        *self = match texture.as_ref() {
            Texture::Image { image, scale } => Self::Packed(images.pack(image), *scale),
            Texture::Placed {
                image,
                tint,
                uv_map,
            } => Self::PackedPlaced(images.pack(image), *tint, *uv_map),
            Texture::Checker { .. } => return,
        };
    }

    fn is_textured(&self) -> bool {
        !matches!(self, Self::Constant(_))
    }

    #[inline]
    fn at(&self, uv: Vec2) -> Rgb {
        match self {
            Self::Constant(colour) => *colour,
            Self::Texture(texture) => texture.lookup(uv),
            Self::Packed(image, scale) => *scale * image.lookup(uv),
            Self::PackedPlaced(image, tint, uv_map) => {
                *tint * image.lookup(uv_map.apply(image.size(), uv))
            }
        }
    }
}

/// A material prepared for lookups. Everything that does not depend on textures is precomputed.
#[derive(Debug, Clone)]
pub struct Material {
    kind: Kind,
    transmits: bool,
    one_sided: bool,
    /// Opacity; `None` if the surface is opaque.
    alpha: Option<Colour>,
    /// The alpha from which the surface is present, if it is not present in part.
    alpha_cutoff: Option<f32>,
    normal_map: Option<NormalMap>,
}

#[derive(Debug, Clone)]
enum Kind {
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
}

impl Material {
    /// Returns the material of a description.
    pub fn new(description: &MaterialDescription) -> Self {
        let alpha = Colour::new(&description.alpha);
        let present_from = description.alpha_cutoff.unwrap_or(1.0);
        let all_there =
            matches!(&alpha, Colour::Constant(alpha) if alpha.luminance() >= present_from);
        let kind = Kind::new(&description.model).mapped(description);
        Self {
            transmits: kind.effects().has(Effect::Transmission),
            kind: kind.folded(),
            one_sided: !description.two_sided,
            alpha: (!all_there).then_some(alpha),
            alpha_cutoff: description.alpha_cutoff,
            normal_map: description.normal_map.as_ref().and_then(NormalMap::new),
        }
    }

    /// Returns the material with packed images, for faster lookups.
    pub fn packed(mut self, images: &mut PackedImages) -> Self {
        let colours = self.kind.colours_mut().into_iter().flatten();
        for colour in colours.chain(&mut self.alpha) {
            colour.pack(images);
        }
        self
    }

    /// The reflectance at a texture coordinate, if the BSDF is diffuse.
    #[inline]
    pub fn diffuse<E: Effects>(&self, uv: Vec2) -> Option<Rgb> {
        match &self.kind {
            Kind::Uniform(Bsdf::Diffuse(bsdf)) => Some(bsdf.reflectance()),
            Kind::Diffuse(colour) if E::Textures::ON => Some(colour.at(uv)),
            _ => None,
        }
    }

    /// The BSDF at a texture coordinate with its place in the table of albedos, if it is principled, rough and opaque.
    #[inline]
    pub fn principled<E: Effects>(&self, uv: Vec2) -> Option<(Cow<'_, Principled>, RowPlace)> {
        match &self.kind {
            Kind::Uniform(Bsdf::Principled(bsdf)) => {
                Some((Cow::Borrowed(bsdf), bsdf.place_in_lanes()?))
            }
            Kind::Principled(bsdf, colour) if E::Textures::ON => {
                let place = bsdf.place_in_lanes()?;
                Some((Cow::Owned(bsdf.coloured(colour.at(uv))), place))
            }
            Kind::PrincipledMapped(parameters, colour, map) if E::Textures::ON => {
                let bsdf = mapped(parameters, colour.at(uv), map.at(uv));
                let place = bsdf.place_in_lanes()?;
                Some((Cow::Owned(bsdf), place))
            }
            _ => None,
        }
    }

    /// Whether all lobes of the BSDF are deltas, see [`Bsdf::is_delta`]. Textures do not change it.
    #[inline]
    pub fn is_delta<E: Effects>(&self) -> bool {
        E::Specular::ON
            && match &self.kind {
                Kind::Uniform(bsdf) => bsdf.is_delta::<E>(),
                Kind::Diffuse(_) | Kind::Phong { .. } | Kind::PrincipledMapped(..) => false,
                Kind::Mirror(_) => true,
                Kind::Dielectric(model, _) => model.is_delta(),
                Kind::Principled(model, _) => model.is_delta(),
            }
    }

    /// Whether the material has an opacity below 1 anywhere.
    #[inline]
    pub fn has_alpha(&self) -> bool {
        self.alpha.is_some()
    }

    /// Returns the effects that the material requires of a kernel.
    pub fn effects(&self) -> EffectSet {
        self.kind
            .effects()
            .with_if(Effect::Textures, self.is_textured())
            .with_if(Effect::OneSided, self.one_sided)
            .with_if(Effect::Alpha, self.alpha.is_some())
            .with_if(Effect::NormalMaps, self.normal_map.is_some())
            .with_if(Effect::ShadingNormals, self.normal_map.is_some())
    }

    /// The traits of a shape with this material that follow from it.
    pub fn traits(&self) -> ShapeTraits {
        ShapeTraits::default()
            .with_if(ShapeTraits::IS_ONE_SIDED, self.one_sided)
            .with_if(ShapeTraits::TRANSMITS, self.transmits)
            .with_if(ShapeTraits::IS_TEXTURED, self.is_textured())
            .with_if(ShapeTraits::HAS_ALPHA, self.alpha.is_some())
            .with_if(ShapeTraits::HAS_NORMAL_MAP, self.normal_map.is_some())
    }

    /// Whether the material needs texture coordinates.
    pub fn is_textured(&self) -> bool {
        let alpha_varies = self.alpha.as_ref().is_some_and(Colour::is_textured);
        self.kind.is_textured() || alpha_varies || self.normal_map.is_some()
    }

    /// Returns the BSDF at a texture coordinate.
    #[inline]
    pub fn bsdf<E: Effects>(&self, uv: Vec2) -> Cow<'_, Bsdf> {
        match &self.kind {
            Kind::Uniform(bsdf) => Cow::Borrowed(bsdf),
            textured if E::Textures::ON => Cow::Owned(textured.bsdf(uv)),
            _ => beyond_kernel(),
        }
    }

    /// Whether the material transmits light, so that its two sides differ.
    #[inline]
    pub fn transmits(&self) -> bool {
        self.transmits
    }

    /// Whether the back absorbs everything.
    #[inline]
    pub fn is_one_sided(&self) -> bool {
        self.one_sided
    }

    /// Returns alpha (opacity) at a texture coordinate, in [0, 1]; `None` if the surface is opaque.
    #[inline]
    pub fn alpha(&self, uv: impl FnOnce() -> Vec2) -> Option<f32> {
        let alpha = match self.alpha.as_ref()? {
            Colour::Constant(alpha) => *alpha,
            varying => varying.at(uv()),
        };
        let alpha = alpha.luminance().clamp(0.0, 1.0);
        Some(match self.alpha_cutoff {
            Some(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            None => alpha,
        })
    }

    /// Whether the surface has alpha below 1.
    pub fn is_masked(&self) -> bool {
        self.alpha.is_some()
    }

    /// Returns the normal map, if any.
    #[inline]
    pub fn normal_map(&self) -> Option<&NormalMap> {
        self.normal_map.as_ref()
    }
}

impl Kind {
    fn new(model: &MaterialModel) -> Self {
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
    fn mapped(self, description: &MaterialDescription) -> Self {
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

    /// Precomputes the BSDF if it does not vary.
    fn folded(self) -> Self {
        if self.is_textured() {
            self
        } else {
            Self::Uniform(self.bsdf(Vec2::ZERO))
        }
    }

    fn effects(&self) -> EffectSet {
        match self {
            // Any part may be a dielectric, and every part is rough.
            Self::PrincipledMapped(parameters, ..) => {
                Principled::new(&mapped_parameters(parameters, 1.0, 0.0)).effects()
            }
            _ => self.bsdf(Vec2::ZERO).effects(),
        }
    }

    /// Returns the colours that may be textured.
    fn colours_mut(&mut self) -> [Option<&mut Colour>; 2] {
        match self {
            Self::Uniform(_) => [None, None],
            Self::PrincipledMapped(_, colour, map) => [Some(colour), Some(map)],
            Self::Diffuse(colour)
            | Self::Mirror(colour)
            | Self::Dielectric(_, colour)
            | Self::Principled(_, colour) => [Some(colour), None],
            Self::Phong {
                diffuse, specular, ..
            } => [Some(diffuse), Some(specular)],
        }
    }

    fn is_textured(&self) -> bool {
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
        }
    }

    #[inline]
    fn bsdf(&self, uv: Vec2) -> Bsdf {
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
        }
    }
}

/// The BSDF whose parameters a map varies, at a point.
#[inline]
fn mapped(parameters: &PrincipledParameters, base_color: Rgb, map: Rgb) -> Principled {
    let [_, roughness, metallic] = map.to_array();
    Principled::new(&PrincipledParameters {
        base_color,
        ..mapped_parameters(parameters, roughness, metallic)
    })
}

/// Multiplies roughness and metallic by factors in [0, 1]. The surface stays rough, so that no part of it is a delta and
/// the effects of a kernel do not depend on the texture.
#[inline]
fn mapped_parameters(
    parameters: &PrincipledParameters,
    roughness: f32,
    metallic: f32,
) -> PrincipledParameters {
    PrincipledParameters {
        roughness: (roughness * parameters.roughness).clamp(LEAST_MAPPED_ROUGHNESS, 1.0),
        metallic: (metallic * parameters.metallic).clamp(0.0, 1.0),
        ..*parameters
    }
}
