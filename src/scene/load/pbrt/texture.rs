//! Textures of a pbrt file: images, checkerboards, and what is computed from them.
//!
//! Measure: linear Rec. 709; texture coordinates in which v points up.
//! Range: textures over uv. Those of points in space, and functions of two textures that cannot be computed beforehand,
//! become their mean, with a note.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::library::Library;
use super::params::Parameters;
use super::textured::{Mapping, Textured};
use crate::error::Result;
use crate::geometry::texture::Texture;
use crate::geometry::uv_map::Wrap;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec2, Vec2};
use crate::scene::description::ColourDescription;
use crate::scene::load::wording::unknown_name;
use std::sync::Arc;

/// The type of a texture's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureType {
    /// Numbers.
    Float,
    /// Colours of surfaces.
    Colour,
}

impl Library {
    /// A parameter that is a number or a texture of numbers, of which every channel is the same.
    ///
    /// # Errors
    /// If it is neither.
    pub fn float(&self, params: &Parameters, name: &str, default: f64) -> Result<Textured> {
        let texture = params.texture(name)?;
        match self.texture(params, name, texture, TextureType::Float)? {
            Some(textured) => Ok(textured),
            None => Ok(Rgb::grey(params.number(name, default)? as f32).into()),
        }
    }

    /// A parameter that is a reflectance or a texture of reflectances.
    ///
    /// # Errors
    /// If it is neither.
    pub fn reflectance(&self, params: &Parameters, name: &str, default: f32) -> Result<Textured> {
        let texture = params.texture(name)?;
        match self.texture(params, name, texture, TextureType::Colour)? {
            Some(textured) => Ok(textured.clamped()),
            None => Ok(self
                .surface(params, name)?
                .unwrap_or(Rgb::grey(default))
                .into()),
        }
    }

    fn value(
        &self,
        params: &Parameters,
        name: &str,
        kind: TextureType,
        default: f32,
    ) -> Result<Textured> {
        match kind {
            TextureType::Float => self.float(params, name, f64::from(default)),
            TextureType::Colour => self.reflectance(params, name, default),
        }
    }

    fn texture(
        &self,
        params: &Parameters,
        name: &str,
        texture: Option<&str>,
        kind: TextureType,
    ) -> Result<Option<Textured>> {
        let Some(wanted) = texture else {
            return Ok(None);
        };
        let known = match kind {
            TextureType::Float => &self.floats,
            TextureType::Colour => &self.colours,
        };
        match known.get(wanted) {
            Some(found) => Ok(Some(found.clone())),
            None => {
                let mut names: Vec<&str> = known.keys().map(String::as_str).collect();
                names.sort_unstable();
                Err(params.error_of(name, unknown_name("texture", wanted, &names)))
            }
        }
    }

    /// Reads a `Texture` statement.
    ///
    /// # Errors
    /// If a parameter is not as the class requires, or an image cannot be used.
    pub fn make_texture(
        &mut self,
        class: &str,
        kind: TextureType,
        params: &Parameters,
    ) -> Result<Textured> {
        match class {
            "constant" => self.value(params, "value", kind, 1.0),
            "scale" => {
                let texture = self.value(params, "tex", kind, 1.0)?;
                let scale = self.float(params, "scale", 1.0)?;
                Ok(self.both(params, &texture, &scale, |a, b| a * b))
            }
            "mix" => self.mix(kind, params),
            "imagemap" => self.image_map(kind, params),
            "checkerboard" => self.checkerboard(kind, params),
            "bilerp" => {
                let mut sum = Rgb::BLACK;
                for (corner, default) in [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)] {
                    sum += self.value(params, corner, kind, default)?.mean();
                }
                Ok(self.mean_instead(params, class, 0.25 * sum))
            }
            "directionmix" => {
                let first = self.value(params, "tex1", kind, 0.0)?.mean();
                let second = self.value(params, "tex2", kind, 1.0)?.mean();
                Ok(self.mean_instead(params, class, 0.5 * (first + second)))
            }
            "dots" => {
                let inside = self.value(params, "inside", kind, 1.0)?.mean();
                let outside = self.value(params, "outside", kind, 0.0)?.mean();
                Ok(self.mean_instead(params, class, 0.5 * (inside + outside)))
            }
            "fbm" | "windy" | "wrinkled" | "marble" | "ptex" => {
                Ok(self.mean_instead(params, class, Rgb::grey(0.5)))
            }
            _ => {
                let known = [
                    "bilerp",
                    "checkerboard",
                    "constant",
                    "directionmix",
                    "dots",
                    "fbm",
                    "imagemap",
                    "marble",
                    "mix",
                    "ptex",
                    "scale",
                    "windy",
                    "wrinkled",
                ];
                Err(params.error(unknown_name("texture class", class, &known)))
            }
        }
    }

    fn mean_instead(&mut self, params: &Parameters, class: &str, mean: Rgb) -> Textured {
        let [r, g, b] = mean.to_array();
        let message = format!("texture class `{class}` became one colour: {r:.3}, {g:.3}, {b:.3}");
        self.approximated(&params.place, message);
        mean.into()
    }

    /// A function of two textures, or if need be of the first and the mean of the second.
    fn both(
        &mut self,
        params: &Parameters,
        a: &Textured,
        b: &Textured,
        f: impl Fn(Rgb, Rgb) -> Rgb,
    ) -> Textured {
        a.with(b, &f).unwrap_or_else(|| {
            let message =
                "two textures that differ in size or mapping: the second one became its mean";
            self.approximated(&params.place, message);
            let mean = b.mean();
            a.map(|colour| f(colour, mean))
        })
    }

    fn mix(&mut self, kind: TextureType, params: &Parameters) -> Result<Textured> {
        let first = self.value(params, "tex1", kind, 0.0)?;
        let second = self.value(params, "tex2", kind, 1.0)?;
        let amount = self.float(params, "amount", 0.5)?;
        if amount.colour.constant().is_none()
            && first.colour.constant().is_some()
            && second.colour.constant().is_some()
        {
            let (a, b) = (first.mean(), second.mean());
            return Ok(amount.map(|t| a + t * (b - a)));
        }
        let t = amount.mean();
        if amount.colour.constant().is_none() {
            self.approximated(
                &params.place,
                "the amount of a mix of textures became its mean",
            );
        }
        Ok(self.both(params, &first, &second, |a, b| a + t * (b - a)))
    }

    fn checkerboard(&mut self, kind: TextureType, params: &Parameters) -> Result<Textured> {
        let colours = [
            self.value(params, "tex1", kind, 1.0)?,
            self.value(params, "tex2", kind, 0.0)?,
        ];
        if params.whole("dimension", 2, [2, 3])? == 3 {
            let mean = 0.5 * (colours[0].mean() + colours[1].mean());
            return Ok(self.mean_instead(params, "checkerboard of 3 dimensions", mean));
        }
        if colours
            .iter()
            .any(|colour| colour.colour.constant().is_none())
        {
            self.approximated(
                &params.place,
                "a checkerboard's textures became their means",
            );
        }
        let mapping = self.mapping(params)?;
        // The repetitions of a checkerboard need no change of texture coordinates.
        let (repeat, mapping) = if mapping.delta == DVec2::ZERO {
            (mapping.scale.as_vec2(), Mapping::default())
        } else {
            (Vec2::ONE, mapping)
        };
        let colours = colours.map(|colour| colour.mean());
        let colour = ColourDescription::Texture(Arc::new(Texture::Checker { colours, repeat }));
        Ok(Textured { colour, mapping })
    }

    fn image_map(&mut self, kind: TextureType, params: &Parameters) -> Result<Textured> {
        let mapping = self.mapping(params)?;
        let mut scale = params.number("scale", 1.0)? as f32;
        if scale < 0.0 {
            let what = "values below 0 are taken as 0";
            self.approximated(&params.place_of("scale"), what);
            scale = 0.0;
        }
        let wrap = match params.choice("wrap", &["repeat", "clamp", "black", "octahedralsphere"])? {
            "repeat" => Wrap::Repeat,
            "clamp" => Wrap::Clamp,
            _ => {
                let what = "the image repeats beyond its edges";
                self.approximated(&params.place_of("wrap"), what);
                Wrap::Repeat
            }
        };
        // How lookups are filtered: bilinear here.
        params.choice("filter", &["bilinear", "point", "trilinear", "EWA", "ewa"])?;
        params.number("maxanisotropy", 8.0)?;
        let invert = params.truth("invert", false)?;
        let alpha = match kind {
            TextureType::Float => self.alpha_of(params, "filename")?,
            _ => None,
        };
        let image = match alpha {
            Some(alpha) => alpha,
            None => self.image(params, "filename")?,
        };
        let texture = Texture::Image { image, scale }.continued(wrap);
        let mut textured = Textured {
            colour: ColourDescription::Texture(Arc::new(texture)),
            mapping,
        };
        if invert {
            textured = textured.map(|colour| colour.map(|x| (1.0 - x).max(0.0)));
        }
        if kind == TextureType::Float {
            // A number is the mean of the channels.
            textured = textured.map(|colour| {
                let [r, g, b] = colour.to_array();
                if r == g && g == b {
                    colour
                } else {
                    Rgb::grey((r + g + b) / 3.0)
                }
            });
        }
        Ok(textured)
    }

    /// Reads how texture coordinates are changed.
    fn mapping(&mut self, params: &Parameters) -> Result<Mapping> {
        let mapping = params.choice("mapping", &["uv", "spherical", "cylindrical", "planar"])?;
        if mapping != "uv" {
            let message =
                format!("mapping `{mapping}` became that by the shapes' own texture coordinates");
            self.approximated(&params.place_of("mapping"), message);
        }
        let is_fine = |x: f64| (x as f32).is_finite();
        let number = |name, default| {
            params.number_where(name, default, "a number within single precision", is_fine)
        };
        Ok(Mapping {
            scale: DVec2::new(number("uscale", 1.0)?, number("vscale", 1.0)?),
            delta: DVec2::new(number("udelta", 0.0)?, number("vdelta", 0.0)?),
        })
    }
}
