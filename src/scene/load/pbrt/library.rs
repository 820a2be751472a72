//! The definitions of a pbrt file so far: the contents of the scene, and textures by name.
//!
//! Measure: as in the description.
//! Range: file names are relative to the folder of the main file, as in pbrt.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::parameter::Values;
use super::params::Parameters;
use super::textured::Textured;
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use crate::math::vec::DVec3;
use crate::scene::description::{Note, NoteKind, Place};
use crate::scene::load::contents::SceneContents;
use crate::scene::load::mesh_files::MeshFiles;
use crate::scene::load::read_text;
use crate::scene::load::spectrum::{self, NamedSpectrum, Spectrum};
use crate::scene::load::wording::{shown, unknown_name};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The definitions so far.
#[derive(Debug, Default)]
pub struct Library {
    pub contents: SceneContents,
    pub mesh_files: MeshFiles,
    /// The folder of the main file.
    pub folder: PathBuf,
    /// Textures of type `float`.
    pub floats: HashMap<String, Textured>,
    /// Textures of type `spectrum`.
    pub colours: HashMap<String, Textured>,
}

/// A spectrum as a parameter states it.
enum SpectrumParameter {
    Rgb(DVec3),
    Blackbody(f64),
    Named(NamedSpectrum),
    Sampled(Spectrum),
}

impl Library {
    /// Notes that something became the most similar that there is.
    pub fn approximated(&mut self, place: &Place, text: impl Into<String>) {
        self.note(NoteKind::Approximation, place, text);
    }

    /// Notes that something was left out.
    pub fn omitted(&mut self, place: &Place, text: impl Into<String>) {
        self.note(NoteKind::Omission, place, text);
    }

    /// Notes a decision that does not change the image.
    pub fn decided(&mut self, place: &Place, text: impl Into<String>) {
        self.note(NoteKind::Decision, place, text);
    }

    fn note(&mut self, kind: NoteKind, place: &Place, text: impl Into<String>) {
        self.contents.note(Note::at(place.clone(), kind, text));
    }

    /// The path of a file that a parameter names.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The colour of light: as given in `rgb`, else of luminance 1. `None` if the parameter is left out.
    ///
    /// # Errors
    /// If it is no spectrum.
    pub fn light(&self, params: &Parameters, name: &str) -> Result<Option<Rgb>> {
        let Some(given) = self.given(params, name)? else {
            return Ok(None);
        };
        let colour = match given {
            SpectrumParameter::Rgb(rgb) => Some(params.gamut_of(name).light(rgb)),
            SpectrumParameter::Blackbody(kelvin) => spectrum::blackbody(kelvin),
            SpectrumParameter::Named(NamedSpectrum::Light(colour)) => Some(colour),
            SpectrumParameter::Named(NamedSpectrum::Index(index)) => {
                let luminance = index.luminance();
                (luminance > 0.0).then(|| index / luminance)
            }
            SpectrumParameter::Sampled(samples) => samples.light(),
        };
        let finite = colour.filter(|colour| colour.is_finite());
        finite
            .map(Some)
            .ok_or_else(|| params.error_of(name, "expected a spectrum of visible light"))
    }

    /// The colour of a surface, from 0 to 1. `None` if the parameter is left out.
    ///
    /// # Errors
    /// If it is no spectrum, or has a channel above 1.
    pub fn surface(&self, params: &Parameters, name: &str) -> Result<Option<Rgb>> {
        let Some(given) = self.given(params, name)? else {
            return Ok(None);
        };
        Ok(Some(match given {
            SpectrumParameter::Rgb(rgb) if rgb.max_element() > 1.0 => {
                return Err(
                    params.error_of(name, "expected a reflectance, at most 1 in every channel")
                );
            }
            SpectrumParameter::Rgb(rgb) => params.gamut_of(name).surface(rgb),
            SpectrumParameter::Named(
                NamedSpectrum::Light(colour) | NamedSpectrum::Index(colour),
            ) => colour.map(|x| x.min(1.0)),
            SpectrumParameter::Sampled(samples) => samples.surface(),
            SpectrumParameter::Blackbody(kelvin) => {
                let colour = spectrum::blackbody(kelvin)
                    .ok_or_else(|| params.error_of(name, "expected a temperature that glows"))?;
                colour / colour.max_channel()
            }
        }))
    }

    /// A refractive index in each channel: its real or its imaginary part. `None` if the parameter is left out.
    ///
    /// # Errors
    /// If it is no spectrum.
    pub fn index(&self, params: &Parameters, name: &str) -> Result<Option<Rgb>> {
        let Some(given) = self.given(params, name)? else {
            return Ok(None);
        };
        Ok(Some(match given {
            SpectrumParameter::Rgb(rgb) => params.gamut_of(name).light(rgb),
            SpectrumParameter::Named(NamedSpectrum::Index(index) | NamedSpectrum::Light(index)) => {
                index
            }
            SpectrumParameter::Sampled(samples) => samples.index(),
            SpectrumParameter::Blackbody(_) => {
                return Err(params.error_of(name, "expected a refractive index"));
            }
        }))
    }

    /// The refractive index of a dielectric, a number or a spectrum, of which the value at the helium d line counts.
    ///
    /// # Errors
    /// If it is neither, or not above 0.
    pub fn ior(&mut self, params: &Parameters, name: &str) -> Result<f32> {
        let is_number = params.of_type(name, &["float", "integer", "spectrum", "rgb"])?;
        let ior = match is_number.map(|found| found.kind) {
            None | Some("float" | "integer") => params.number(name, 1.5)?,
            _ => {
                let at_d_line = match self.given(params, name)? {
                    Some(SpectrumParameter::Sampled(samples)) => samples.at(spectrum::D_LINE),
                    Some(SpectrumParameter::Rgb(rgb)) => rgb.y,
                    Some(SpectrumParameter::Named(NamedSpectrum::Index(index))) => {
                        f64::from(index.to_array()[1])
                    }
                    _ => return Err(params.error_of(name, "expected a refractive index")),
                };
                self.approximated(
                    &params.place_of(name),
                    "no dispersion: the index at 587.6 nm is used for all colours",
                );
                at_d_line
            }
        };
        let ior = ior as f32;
        if ior > 0.0 && ior.is_finite() {
            Ok(ior)
        } else {
            Err(params.error_of(
                name,
                format!("expected a refractive index above 0, found {ior}"),
            ))
        }
    }

    fn given(&self, params: &Parameters, name: &str) -> Result<Option<SpectrumParameter>> {
        let Some(found) = params.of_type(name, &["rgb", "blackbody", "spectrum"])? else {
            return Ok(None);
        };
        Ok(Some(match (&found.values, found.kind) {
            (Values::Numbers(rgb), "rgb") => match rgb.as_slice() {
                [r, g, b] if rgb.iter().all(|x| (0.0..=f64::from(f32::MAX)).contains(x)) => {
                    SpectrumParameter::Rgb(DVec3::new(*r, *g, *b))
                }
                _ => return Err(params.error_of(name, "expected three numbers of at least 0")),
            },
            (Values::Numbers(kelvins), "blackbody") => match kelvins.as_slice() {
                [kelvin] if *kelvin > 0.0 => SpectrumParameter::Blackbody(*kelvin),
                _ => {
                    return Err(
                        params.error_of(name, "expected one temperature above 0, in kelvins")
                    );
                }
            },
            (Values::Numbers(numbers), _) => {
                let (pairs, rest) = numbers.as_chunks();
                if !rest.is_empty() {
                    return Err(params.error_of(name, "expected pairs of wavelength and value"));
                }
                let samples = Spectrum::new(pairs.to_vec());
                SpectrumParameter::Sampled(samples.map_err(|why| params.error_of(name, why))?)
            }
            (Values::Texts(texts), _) => match texts.as_slice() {
                [text] => self.named(params, name, text)?,
                _ => return Err(params.error_of(name, "expected one name of a spectrum")),
            },
            (Values::Truths(_), _) => return Err(params.error_of(name, "expected a spectrum")),
        }))
    }

    /// A spectrum by name, or else from a file.
    fn named(&self, params: &Parameters, name: &str, text: &str) -> Result<SpectrumParameter> {
        if let Some(named) = spectrum::named(text) {
            return Ok(SpectrumParameter::Named(named));
        }
        let path = self.path(text);
        if !Path::exists(&path) {
            let message = unknown_name("spectrum", text, &spectrum::names());
            return Err(params.error_of(name, format!("{message}, or a file")));
        }
        let content = read_text(&path).map_err(|error| self.about(params, name, &error))?;
        let samples = Spectrum::parse(&content).map_err(|(line, why)| {
            let error = Error::scene(why).in_file(&path).at_line(line);
            self.about(params, name, &error)
        })?;
        Ok(SpectrumParameter::Sampled(samples))
    }

    /// An error about a file, as one about the parameter that names it.
    pub fn about(&self, params: &Parameters, name: &str, error: &Error) -> Error {
        params
            .error_of(name, error.to_string())
            .of_kind(error.kind())
    }

    /// Notes parameters of a statement that have no meaning here.
    pub fn note_unused(&mut self, params: &Parameters) {
        let unused: Vec<(String, usize)> = params
            .unused()
            .map(|(name, line)| (shown(name), line))
            .collect();
        for (name, line) in unused {
            let place = Place::on_line(&params.place.file, line);
            self.decided(&place, format!("parameter `{name}` was ignored"));
        }
    }
}
