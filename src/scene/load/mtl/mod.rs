//! Reads the material libraries (MTL) of OBJ files, including Blender's physically based keys. `material.rs` makes materials
//! from what is read.
//!
//! Measure: reflectances in [0, 1], radiance for `Ke`.
//! Range: keys without meaning here (`Ka`, `Ps`, ...) are ignored; unsupported textures and unknown keys are reported in a
//! note.
//! Source: Blender's exporter, `export_pbr_extensions`. Tested below and in
//! `tests/loading/scene_files.rs`.

mod material;
mod values;

use super::contents::SceneContents;
use super::wording::{shown, unknown_name};
use super::{beside, read_any_text};
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use crate::scene::description::{Note, NoteKind, Place};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use values::{colour, number, split_options};

/// Supported keys.
const READ: &[&str] = &[
    "newmtl", "Kd", "Ke", "Ks", "Ni", "Ns", "d", "Tf", "illum", "map_Kd", "map_Ke", "map_d",
    "norm", "Pr", "Pm", "Pc", "Pcr", "Tr", "map_Bump", "map_bump", "bump",
];

/// Supported keys whose values are textures.
const PICTURES: &[&str] = &["map_Kd", "map_Ke", "map_d", "norm", BUMPS];

/// The key of heights, which Blender also writes for normals.
const BUMPS: &str = "map_Bump";

/// Known keys that are ignored.
const PASSED_OVER: &[&str] = &["Ka", "Ps", "aniso", "anisor", "sharpness", "map_aat"];

/// Known textures that are not supported.
const NOT_DRAWN: &[&str] = &[
    "map_Ka", "map_Ks", "map_Ns", "map_Pr", "map_Pm", "map_Ps", "map_Tr", "disp", "decal", "refl",
];

/// A material as written in the library.
#[derive(Debug)]
pub struct MtlMaterial {
    name: String,
    place: Place,
    diffuse: Rgb,
    /// The texture files by key, with their lines.
    pictures: BTreeMap<&'static str, (PathBuf, usize)>,
    opacity: Option<f32>,
    /// 1 - opacity by `Tr`, which counts without an opacity.
    transparency: f32,
    emission: Rgb,
    ior: f32,
    transmission: Option<f32>,
    metallic: f32,
    /// The weight of a clear coat, and its roughness.
    coat: [f32; 2],
    /// The factor of normals, `-bm`.
    bump_strength: f32,
    roughness: Option<f32>,
    shininess: f32,
    /// Whether `Ks` is black.
    has_no_highlights: bool,
    illumination: Option<u32>,
}

/// Reads a library and adds its materials to `known`, by name.
///
/// # Errors
/// If a line is invalid.
pub fn read(
    path: &Path,
    known: &mut BTreeMap<String, MtlMaterial>,
    contents: &mut SceneContents,
) -> Result<()> {
    let text = read_any_text(path)?;
    let mut current: Option<MtlMaterial> = None;
    for (line, content) in (1..).zip(text.lines()) {
        let mut words = content.split_whitespace();
        let Some(key) = words.next().filter(|key| !key.starts_with('#')) else {
            continue;
        };
        let rest = content.trim_start()[key.len()..].trim();
        // Comments may stand behind numbers; the names of files and materials may have the sign.
        let names = ["newmtl", "norm", "bump"].contains(&key) || key.starts_with("map_");
        let comment = rest.find(" #").filter(|_| !names);
        let rest = comment.map_or(rest, |at| rest[..at].trim_end());
        let at = |error: Error| error.in_file(path).at_line(line).in_field(shown(key));
        if key == "newmtl" {
            if rest.is_empty() {
                return Err(at(Error::scene("expected a name")));
            }
            let next = MtlMaterial::new(rest, path, line);
            known.extend(
                current
                    .replace(next)
                    .map(|entry| (entry.name.clone(), entry)),
            );
            continue;
        }
        let Some(entry) = &mut current else {
            return Err(at(Error::scene("expected newmtl first")));
        };
        if let Some((kind, text)) = entry.set(key, rest, line).map_err(at)? {
            contents.note(Note::at(Place::on_line(path, line), kind, text));
        }
    }
    known.extend(current.map(|entry| (entry.name.clone(), entry)));
    Ok(())
}

impl MtlMaterial {
    fn new(name: &str, path: &Path, line: usize) -> Self {
        Self {
            name: name.to_owned(),
            place: Place::on_line(path, line),
            diffuse: Rgb::grey(0.8),
            pictures: BTreeMap::new(),
            opacity: None,
            transparency: 0.0,
            emission: Rgb::BLACK,
            ior: 1.5,
            transmission: None,
            metallic: 0.0,
            coat: [0.0; 2],
            bump_strength: 1.0,
            roughness: None,
            shininess: 0.0,
            has_no_highlights: false,
            illumination: None,
        }
    }

    /// Reads one line; returns the kind and the text of a note for the user, if any.
    fn set(&mut self, key: &str, rest: &str, line: usize) -> Result<Option<(NoteKind, String)>> {
        let mut omission = None;
        let mut is_clamped = false;
        let mut share = |number: f32| {
            is_clamped |= number > 1.0;
            number.min(1.0)
        };
        let key = match key {
            "map_bump" | "bump" => BUMPS,
            key => key,
        };
        match key {
            "Kd" => self.diffuse = Rgb::from(colour(rest)?.to_array().map(&mut share)),
            "Ke" => self.emission = colour(rest)?,
            "Ni" => self.ior = number(rest)?,
            "Ns" => self.shininess = number(rest)?,
            "Tf" => self.transmission = Some(share(colour(rest)?.max_channel())),
            "Pr" => self.roughness = Some(share(number(rest)?)),
            "Pm" => self.metallic = share(number(rest)?),
            "Pc" => self.coat[0] = share(number(rest)?),
            "Pcr" => self.coat[1] = share(number(rest)?),
            // Other values than black have no meaning here, so that they may be of any kind.
            "Ks" => self.has_no_highlights = colour(rest).is_ok_and(Rgb::is_black),
            "illum" => {
                let model = rest.split_whitespace().next().unwrap_or(rest).parse();
                let expected =
                    |_| Error::scene(format!("expected a whole number, found {}", shown(rest)));
                self.illumination = Some(model.map_err(expected)?);
            }
            "d" => {
                let rest = rest.strip_prefix("-halo ").unwrap_or(rest);
                self.opacity = Some(share(number(rest)?));
            }
            "Tr" => self.transparency = share(number(rest)?),
            _ if PASSED_OVER.contains(&key) => {}
            _ if NOT_DRAWN.contains(&key) => {
                omission = Some(format!("{key} is not supported by this version; left out"));
            }
            _ => {
                let Some(picture) = PICTURES.iter().find(|picture| **picture == key) else {
                    return Ok(Some((NoteKind::Omission, unknown_name("key", key, READ))));
                };
                let (options, file) = split_options(rest);
                if file.is_empty() {
                    let text = "an image without a file; left out";
                    return Ok(Some((NoteKind::Omission, text.to_owned())));
                }
                let path = found(&self.place.file, file);
                let strength = ["norm", BUMPS]
                    .contains(picture)
                    .then(|| options.strip_prefix("-bm ")?.trim().parse().ok())
                    .flatten()
                    .filter(|strength: &f32| strength.is_finite());
                if let Some(strength) = strength {
                    self.bump_strength = strength;
                } else if !options.is_empty() {
                    omission = Some(format!(
                        "the options {} of an image are not supported",
                        shown(options)
                    ));
                }
                self.pictures.insert(picture, (path, line));
            }
        }
        if is_clamped {
            let text = format!("{key} {} is above 1 and counts as 1", shown(rest));
            return Ok(Some((NoteKind::Approximation, text)));
        }
        Ok(omission.map(|text| (NoteKind::Omission, text)))
    }
}

/// The file of an image: of this name, or else of its last part, since libraries name folders of the computer that they
/// were written on.
fn found(library: &Path, name: &str) -> PathBuf {
    let written = beside(library, name);
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let near = beside(library, last);
    if !written.is_file() && near.is_file() {
        near
    } else {
        written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_values_are_rejected() {
        let mut entry = MtlMaterial::new("m", Path::new("m.mtl"), 1);
        for (key, rest) in [
            ("Kd", "1 1"),
            ("Kd", "1 1 1 1"),
            ("Kd", "-1 0 0"),
            ("Kd", "x 0 0"),
            ("Kd", ""),
            ("Ke", "-1 0 0"),
            ("Ke", "1e39 0 0"),
            ("Ke", "nan 0 0"),
            ("Ni", "inf"),
            ("Pr", "-0.5"),
            ("d", ""),
            ("illum", "2.5"),
        ] {
            assert!(entry.set(key, rest, 2).is_err(), "{key} {rest}");
        }
    }

    #[test]
    fn shares_above_one_count_as_one_with_a_note() {
        let mut entry = MtlMaterial::new("m", Path::new("m.mtl"), 1);
        for (key, rest) in [
            ("Kd", "1.2 0.5 0"),
            ("Pr", "1.5"),
            ("d", "2"),
            ("Tf", "0 3 0"),
        ] {
            let note = entry.set(key, rest, 2).expect("a valid line");
            let (kind, text) = note.expect("a note");
            assert_eq!(kind, NoteKind::Approximation);
            assert!(text.contains("above 1"), "{text}");
        }
        assert_eq!(entry.diffuse, Rgb::new(1.0, 0.5, 0.0));
        assert_eq!(entry.roughness, Some(1.0));
        assert_eq!(entry.opacity, Some(1.0));
        assert_eq!(entry.transmission, Some(1.0));
        assert!(entry.set("Kd", "1", 2).expect("a valid line").is_none());
    }
}
