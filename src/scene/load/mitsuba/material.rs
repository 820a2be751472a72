//! The bsdfs of a Mitsuba scene as materials.
//!
//! Measure: reflectances without unit; Mitsuba's alpha is that of the microfacets, the square of our roughness.
//! Range: every bsdf of the documentation becomes the nearest material, with a note where the models differ; an unknown
//! type is an error.
//! Source: Mitsuba 3 documentation, "BSDFs". Tested in `tests/loading/mitsuba.rs` and by `scripts/against-mitsuba.py`.

use super::super::colour::most;
use super::super::contents::Contents;
use super::super::wording::unknown_name;
use super::metals;
use super::object::{Object, Value};
use super::spectra::Kind;
use super::texture;
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::math::vec::DAffine2;
use crate::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, NormalMapDescription, NoteKind,
};

/// A material, and the transform of texture coordinates that its textures require of the shape.
#[derive(Debug, Clone)]
pub struct Surface {
    pub material: usize,
    /// `None` if nothing in the material is textured.
    pub to_uv: Option<DAffine2>,
    /// Whether the surface is invisible.
    pub is_null: bool,
}

/// Reads a bsdf and adds its material.
///
/// # Errors
/// If the bsdf or a nested one is invalid.
pub fn material(bsdf: &Object, contents: &mut Contents) -> Result<Surface> {
    let mut reader = Reader {
        contents,
        to_uv: None,
    };
    let mut made = MaterialDescription {
        two_sided: false,
        ..MaterialDescription::new(
            bsdf.id.clone(),
            bsdf.place.clone(),
            reader.diffuse_grey(0.5),
        )
    };
    reader.read(bsdf, &mut made)?;
    if made.transmits() {
        made.two_sided = true;
    }
    Ok(Surface {
        to_uv: reader.to_uv,
        material: contents.add_material(made),
        is_null: bsdf.kind == "null",
    })
}

/// The types that are read.
const KNOWN: &[&str] = &[
    "diffuse",
    "dielectric",
    "thindielectric",
    "roughdielectric",
    "conductor",
    "roughconductor",
    "plastic",
    "roughplastic",
    "principled",
    "twosided",
    "mask",
    "normalmap",
    "bumpmap",
    "blendbsdf",
    "null",
];

/// Those that have no counterpart.
const REPLACED: &[&str] = &[
    "hair",
    "measured",
    "measured_polarized",
    "pplastic",
    "principledthin",
    "circular",
    "polarizer",
    "retarder",
];

pub(super) struct Reader<'a> {
    contents: &'a mut Contents,
    to_uv: Option<DAffine2>,
}

impl Reader<'_> {
    fn diffuse_grey(&self, grey: f32) -> MaterialModel {
        MaterialModel::Diffuse {
            reflectance: Rgb::grey(grey).into(),
        }
    }

    fn read(&mut self, bsdf: &Object, made: &mut MaterialDescription) -> Result<()> {
        match bsdf.kind.as_str() {
            "diffuse" => {
                made.model = MaterialModel::Diffuse {
                    reflectance: self.reflectance(bsdf, "reflectance", 0.5)?,
                };
            }
            "dielectric" | "roughdielectric" | "thindielectric" => self.dielectric(bsdf, made)?,
            "conductor" | "roughconductor" => self.conductor(bsdf, made)?,
            "plastic" | "roughplastic" => self.plastic(bsdf, made)?,
            "principled" => self.principled(bsdf, made)?,
            "twosided" => {
                let mut sides = bsdf.children("bsdf");
                let front = sides
                    .next()
                    .ok_or_else(|| bsdf.error("expected a nested bsdf"))?;
                if sides
                    .next()
                    .is_some_and(|back| !std::rc::Rc::ptr_eq(back, front))
                {
                    self.note(bsdf, NoteKind::Approximation, "the back is like the front");
                }
                self.read(front, made)?;
                made.two_sided = true;
            }
            "mask" => {
                let opacity = self.colour(bsdf, "opacity", Rgb::grey(0.5), Kind::Colour)?;
                made.alpha = match opacity.constant() {
                    Some(opacity) => opacity.map(|x| x.min(1.0)).into(),
                    None => opacity,
                };
                self.nested(bsdf, made)?;
            }
            "normalmap" => {
                self.nested(bsdf, made)?;
                made.normal_map = self.normal_map(bsdf)?;
            }
            "bumpmap" => {
                self.nested(bsdf, made)?;
                bsdf.children("texture").for_each(drop);
                bsdf.number("scale")?;
                self.note(
                    bsdf,
                    NoteKind::Omission,
                    "bumps are not supported: the surface is smooth",
                );
            }
            "blendbsdf" => self.blend(bsdf, made)?,
            "null" => made.alpha = Rgb::BLACK.into(),
            other if REPLACED.contains(&other) => {
                self.note(
                    bsdf,
                    NoteKind::Approximation,
                    "not supported: replaced by diffuse grey",
                );
                return Ok(());
            }
            other => {
                return Err(bsdf.error(&unknown_name("bsdf", other, &[KNOWN, REPLACED].concat())));
            }
        }
        bsdf.note_unused(&["sample_visible", "nonlinear"], self.contents);
        Ok(())
    }

    pub(super) fn note(&mut self, bsdf: &Object, kind: NoteKind, text: &str) {
        self.contents.note(bsdf.note(kind, text));
    }

    fn nested(&mut self, bsdf: &Object, made: &mut MaterialDescription) -> Result<()> {
        let inner = bsdf.children("bsdf").next();
        let inner = inner.ok_or_else(|| bsdf.error("expected a nested bsdf"))?;
        self.read(inner, made)
    }

    /// A colour or a texture; the transform of the first texture's coordinates holds for all.
    pub(super) fn colour(
        &mut self,
        bsdf: &Object,
        name: &str,
        default: Rgb,
        kind: Kind,
    ) -> Result<ColourDescription> {
        let Some(property) = bsdf.get(name) else {
            return Ok(default.into());
        };
        let Value::Object(texture) = &property.value else {
            return Ok(property.colour(kind)?.into());
        };
        let (colour, to_uv) = texture::texture(texture, kind, self.contents)?;
        if let Some(to_uv) = to_uv {
            let known = *self.to_uv.get_or_insert(to_uv);
            if known != to_uv {
                self.note(
                    texture,
                    NoteKind::Approximation,
                    "gets the `to_uv` of the material's first texture",
                );
            }
        }
        Ok(colour)
    }

    /// A colour whose channels are at most 1.
    pub(super) fn reflectance(
        &mut self,
        bsdf: &Object,
        name: &str,
        default: f32,
    ) -> Result<ColourDescription> {
        let colour = self.colour(bsdf, name, Rgb::grey(default), Kind::Colour)?;
        if most(&colour).max_channel() <= 1.0 {
            return Ok(colour);
        }
        Err(bsdf.error_at(name, "expected a reflectance of at most 1 in every channel"))
    }

    /// A factor that our model has not: notes it unless it is 1.
    fn factor(&mut self, bsdf: &Object, name: &str) -> Result<()> {
        let factor = self.reflectance(bsdf, name, 1.0)?;
        if factor.constant() != Some(Rgb::WHITE) {
            self.note(
                bsdf,
                NoteKind::Approximation,
                &format!("`{name}` is not supported: taken as 1"),
            );
        }
        Ok(())
    }

    /// Roughness from `alpha`, of which a texture counts by its mean and two axes by their geometric mean.
    pub(super) fn roughness(&mut self, bsdf: &Object) -> Result<f32> {
        if !bsdf.kind.starts_with("rough") {
            return Ok(0.0);
        }
        let of_bsdf = bsdf.text("distribution")?.unwrap_or("beckmann");
        if of_bsdf != "ggx" {
            self.note(
                bsdf,
                NoteKind::Approximation,
                &format!("distribution `{of_bsdf}` is replaced by GGX"),
            );
        }
        let mut alpha_of = |name: &str, default: f64| self.share(bsdf, name, default);
        let alpha = alpha_of("alpha", 0.1)?;
        let (u, v) = (alpha_of("alpha_u", alpha)?, alpha_of("alpha_v", alpha)?);
        if u != v {
            self.note(
                bsdf,
                NoteKind::Approximation,
                "anisotropy is not supported: the geometric mean is used",
            );
        }
        Ok((u * v).sqrt().sqrt() as f32)
    }

    fn ior(&self, bsdf: &Object, inside: &str) -> Result<f32> {
        let index = |name: &str, default: &str| -> Result<f64> {
            let index = match bsdf.get(name).map(|property| &property.value) {
                None => metals::medium(default),
                Some(Value::Number(number)) => Some(*number),
                Some(Value::Text(text)) => Some(metals::medium(text).ok_or_else(|| {
                    let known: Vec<&str> = metals::MEDIA.iter().map(|(name, _)| *name).collect();
                    bsdf.error_at(name, &unknown_name("medium", text, &known))
                })?),
                Some(_) => None,
            };
            let in_range = |n: &f64| (0.01..=100.0).contains(n);
            index
                .filter(in_range)
                .ok_or_else(|| bsdf.error_at(name, "expected a refractive index from 0.01 to 100"))
        };
        Ok((index("int_ior", inside)? / index("ext_ior", "air")?) as f32)
    }

    fn dielectric(&mut self, bsdf: &Object, made: &mut MaterialDescription) -> Result<()> {
        self.factor(bsdf, "specular_reflectance")?;
        let ior = self.ior(bsdf, "bk7")?;
        let tint = self.reflectance(bsdf, "specular_transmittance", 1.0)?;
        made.model = match bsdf.kind.as_str() {
            "thindielectric" => MaterialModel::ThinDielectric { ior, tint },
            _ => MaterialModel::Dielectric {
                ior,
                roughness: self.roughness(bsdf)?,
                tint,
            },
        };
        Ok(())
    }

    fn plastic(&mut self, bsdf: &Object, made: &mut MaterialDescription) -> Result<()> {
        self.factor(bsdf, "specular_reflectance")?;
        let ior = self.ior(bsdf, "polypropylene")?;
        if ior < 1.0 {
            return Err(bsdf.error_at("int_ior", "expected an index above that outside"));
        }
        let text = "our plastic compensates the energy between coat and base in another way";
        self.note(bsdf, NoteKind::Approximation, text);
        made.model = MaterialModel::Plastic {
            reflectance: self.reflectance(bsdf, "diffuse_reflectance", 0.5)?,
            ior,
            roughness: self.roughness(bsdf)?,
        };
        Ok(())
    }

    /// A number from 0 to 1, or the mean of a texture, with a note.
    fn share(&mut self, bsdf: &Object, name: &str, default: f64) -> Result<f64> {
        let colour = self.colour(bsdf, name, Rgb::grey(default as f32), Kind::Colour)?;
        let share = match colour.constant() {
            Some(share) => f64::from(share.luminance()),
            None => {
                self.note(
                    bsdf,
                    NoteKind::Approximation,
                    &format!("`{name}` is replaced by its mean"),
                );
                texture::mean(&colour)
            }
        };
        if (0.0..=1.0).contains(&share) {
            Ok(share)
        } else {
            Err(bsdf.error_at(name, "expected a number from 0 to 1"))
        }
    }

    fn principled(&mut self, bsdf: &Object, made: &mut MaterialDescription) -> Result<()> {
        let mut share = |name: &str, default: f64| -> Result<f32> {
            Ok(self.share(bsdf, name, default)? as f32)
        };
        let (metallic, roughness) = (share("metallic", 0.0)?, share("roughness", 0.5)?);
        let (transmission, specular) = (share("spec_trans", 0.0)?, share("specular", 0.5)?);
        let ior = match bsdf.number("eta")? {
            Some(eta) if (1.0..=100.0).contains(&eta) => eta as f32,
            Some(_) => return Err(bsdf.error_at("eta", "expected a number from 1 to 100")),
            // The reflectance at normal incidence is 0.08 times `specular`.
            None => {
                let root = (0.08 * specular).sqrt();
                (1.0 + root) / (1.0 - root)
            }
        };
        self.note(
            bsdf,
            NoteKind::Approximation,
            "replaced by the principled model of glTF",
        );
        made.model = MaterialModel::Principled {
            base_color: self.reflectance(bsdf, "base_color", 0.5)?,
            metallic,
            roughness,
            ior,
            transmission,
        };
        Ok(())
    }

    fn normal_map(&mut self, bsdf: &Object) -> Result<Option<NormalMapDescription>> {
        let texture = bsdf.children("texture").next();
        let texture = texture.ok_or_else(|| bsdf.error("expected a nested texture"))?;
        let (colour, to_uv) = texture::texture(texture, Kind::Normals, self.contents)?;
        self.to_uv = self.to_uv.or(to_uv);
        Ok(match colour {
            ColourDescription::Texture(texture) => Some(NormalMapDescription {
                texture,
                strength: 1.0,
            }),
            ColourDescription::Constant(_) => None,
        })
    }

    /// Two diffuse surfaces of constant colour blend exactly; of others, the one with the greater weight remains.
    fn blend(&mut self, bsdf: &Object, made: &mut MaterialDescription) -> Result<()> {
        let sides: Vec<_> = bsdf.children("bsdf").collect();
        let [first, second] = sides.as_slice() else {
            return Err(bsdf.error("expected two nested bsdfs"));
        };
        let weight = self.colour(bsdf, "weight", Rgb::grey(0.5), Kind::Colour)?;
        let weight = texture::mean(&weight).clamp(0.0, 1.0) as f32;
        let mut other = made.clone();
        self.read(first, made)?;
        self.read(second, &mut other)?;
        if let (
            MaterialModel::Diffuse { reflectance: a },
            MaterialModel::Diffuse { reflectance: b },
        ) = (&mut made.model, &other.model)
            && let (Some(x), Some(y)) = (a.constant(), b.constant())
        {
            *a = x.lerp(y, weight).into();
            return Ok(());
        }
        if weight > 0.5 {
            *made = other;
        }
        self.note(
            bsdf,
            NoteKind::Approximation,
            "replaced by the one of greater weight",
        );
        Ok(())
    }
}
