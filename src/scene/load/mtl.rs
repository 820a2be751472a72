//! Material libraries of OBJ files, with Blender's physically based keys.
//!
//! What becomes of a material:
//! - `Tf` with a transmission of 1 and no metal is glass: a dielectric of index `Ni`, tinted by `Kd`;
//! - `Pr 1` and no metal is matte: diffuse. Blender writes its principled model, whose faint sheen at roughness 1 that
//!   loses;
//! - all else is the principled model of `Kd`, `Pm`, `Pr` and `Ni`.
//!
//! `Ke` makes a light of the shape, on the side of its geometric normal.
//!
//! Measure: reflectances in [0, 1], radiance for `Ke`.
//! Range: keys of other renderers (`Ka`, `Ks`, `Tr`, ...) are passed over; unknown ones are noted.
//! Source: Blender's exporter, `export_pbr_extensions`; without `Pr`, roughness = 1 - sqrt(Ns / 1000) as Blender
//! imports it. Tested in `tests/scene_loading.rs`.

use super::colour::Textures;
use super::read_text;
use super::reader::unknown_name;
use super::toml::Contents;
use crate::error::{Error, Result};
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::scene::description::{ColourDescription, MaterialDescription, MaterialModel, Place};
use std::path::Path;
use std::sync::Arc;

/// Keys that are known but say nothing to us.
const PASSED_OVER: &[&str] = &[
    "Ka",
    "Ks",
    "Tr",
    "illum",
    "Ps",
    "Pc",
    "Pcr",
    "aniso",
    "anisor",
    "sharpness",
    "map_Ka",
    "map_Ks",
    "map_Ns",
    "map_Ke",
    "map_d",
    "map_Pr",
    "map_Pm",
    "map_Bump",
    "map_bump",
    "bump",
    "norm",
    "disp",
    "decal",
    "refl",
];

/// A material as its lines say.
#[derive(Debug)]
struct Entry {
    name: String,
    line: usize,
    diffuse: Rgb,
    texture: Option<ColourDescription>,
    emission: Rgb,
    ior: f32,
    transmission: f32,
    metallic: f32,
    roughness: Option<f32>,
    shininess: f32,
    opacity: f32,
}

/// Reads a library into `contents`.
///
/// # Errors
/// Whatever is wrong with it, with its line.
pub fn load(path: &Path, contents: &mut Contents) -> Result<()> {
    let text = read_text(path)?;
    let mut entries: Vec<Entry> = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let Some(key) = content
            .split_whitespace()
            .next()
            .filter(|key| !key.starts_with('#'))
        else {
            continue;
        };
        let rest = content.trim_start()[key.len()..].trim();
        let at = |error: Error| error.in_file(path).at_line(line).in_field(key);
        if key == "newmtl" {
            if rest.is_empty() {
                return Err(at(Error::scene("expected a name")));
            }
            entries.push(Entry::new(rest, line));
            continue;
        }
        let Some(entry) = entries.last_mut() else {
            return Err(at(Error::scene("expected newmtl first")));
        };
        if !entry
            .set(key, rest, path, &mut contents.textures)
            .map_err(at)?
        {
            let known = [
                "newmtl", "Kd", "Ke", "Ni", "Ns", "d", "Tf", "map_Kd", "Pr", "Pm",
            ];
            let why = unknown_name("key", key, &known);
            contents.note(format!("{}:{line}: {why}", path.display()));
        }
    }
    for entry in entries {
        if entry.opacity < 1.0 {
            contents.note(format!(
                "{}:{}: {} is drawn opaque: `d` is not supported by this version",
                path.display(),
                entry.line,
                entry.name
            ));
        }
        let place = Place {
            file: path.to_path_buf(),
            line: Some(entry.line),
        };
        let emission = (!entry.emission.is_black()).then_some(entry.emission);
        let name = entry.name.clone();
        contents.add_material(
            MaterialDescription {
                name,
                place,
                model: entry.model(),
            },
            emission,
        );
    }
    Ok(())
}

impl Entry {
    fn new(name: &str, line: usize) -> Self {
        Self {
            name: name.to_owned(),
            line,
            diffuse: Rgb::grey(0.8),
            texture: None,
            emission: Rgb::BLACK,
            ior: 1.5,
            transmission: 0.0,
            metallic: 0.0,
            roughness: None,
            shininess: 0.0,
            opacity: 1.0,
        }
    }

    /// Takes one line in; `false` for a key that is not known.
    fn set(&mut self, key: &str, rest: &str, path: &Path, textures: &mut Textures) -> Result<bool> {
        let share = || number(rest, "a number from 0 to 1", |x| (0.0..=1.0).contains(&x));
        match key {
            "Kd" => self.diffuse = colour(rest, 1.0)?,
            "Ke" => self.emission = colour(rest, f32::MAX)?,
            "Ni" => self.ior = number(rest, "a number of at least 1", |x| x >= 1.0)?,
            "Ns" => self.shininess = number(rest, "a number of at least 0", |x| x >= 0.0)?,
            "d" => self.opacity = share()?,
            "Tf" => self.transmission = colour(rest, 1.0)?.max_channel(),
            "Pr" => self.roughness = Some(share()?),
            "Pm" => self.metallic = share()?,
            "map_Kd" => {
                if rest.starts_with('-') || rest.is_empty() {
                    return Err(Error::scene("expected a file; options are not supported"));
                }
                let file = path.parent().unwrap_or(Path::new("")).join(rest);
                let texture = textures
                    .read(&file, ColourSpace::Srgb, 1.0)
                    .map_err(|error| {
                        let kind = error.kind();
                        Error::scene(error.to_string()).of_kind(kind)
                    })?;
                self.texture = Some(ColourDescription::Texture(Arc::new(texture)));
            }
            _ => return Ok(PASSED_OVER.contains(&key)),
        }
        Ok(true)
    }

    fn model(self) -> MaterialModel {
        let roughness = self
            .roughness
            .unwrap_or(1.0 - (self.shininess / 1000.0).clamp(0.0, 1.0).sqrt());
        let base_color = self
            .texture
            .unwrap_or(ColourDescription::Constant(self.diffuse));
        let ior = self.ior;
        if self.metallic == 0.0 && self.transmission == 1.0 {
            MaterialModel::Dielectric {
                ior,
                roughness,
                tint: base_color,
            }
        } else if self.metallic == 0.0 && self.transmission == 0.0 && roughness == 1.0 {
            MaterialModel::Diffuse {
                reflectance: base_color,
            }
        } else {
            MaterialModel::Principled {
                base_color,
                metallic: self.metallic,
                roughness,
                ior,
                transmission: self.transmission,
            }
        }
    }
}

/// One finite number that passes `test`.
fn number(text: &str, what: &str, test: impl Fn(f32) -> bool) -> Result<f32> {
    let found = text.split_whitespace().next().unwrap_or("nothing");
    let number = found
        .parse()
        .ok()
        .filter(|&x: &f32| x.is_finite() && test(x));
    number.ok_or_else(|| Error::scene(format!("expected {what}, found {found}")))
}

/// Three numbers from 0 to `most`, or one for all of them.
fn colour(text: &str, most: f32) -> Result<Rgb> {
    let expected = || {
        let limit = if most == f32::MAX {
            "of at least 0".to_owned()
        } else {
            format!("from 0 to {most}")
        };
        Error::scene(format!("expected three numbers {limit}, found {text}"))
    };
    let channels: Vec<f32> = text
        .split_whitespace()
        .map(str::parse)
        .collect::<std::result::Result<_, _>>()
        .map_err(|_| expected())?;
    let colour = match channels.as_slice() {
        [grey] => Rgb::grey(*grey),
        [r, g, b] => Rgb::new(*r, *g, *b),
        _ => return Err(expected()),
    };
    let valid = colour.to_array().iter().all(|x| (0.0..=most).contains(x));
    if valid { Ok(colour) } else { Err(expected()) }
}
