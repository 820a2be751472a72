//! The objects of a Mitsuba scene with their properties, and typed access to these.
//!
//! Measure: as written; transforms map column vectors.
//! Range: every property is requested by type; a mismatch is an error with file and line. A property that was not
//! requested is noted as left out.
//! Source: Mitsuba 3 documentation, "Scene XML file format". Tested in `tests/loading/mitsuba.rs`.

use super::super::contents::SceneContents;
use super::super::wording::shown;
use super::folders::Folders;
use super::spectra::{ColourMeaning, Spectral};
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{Note, NoteKind, Place};
use std::cell::Cell;
use std::path::PathBuf;
use std::rc::Rc;

/// A bsdf, a shape or another object.
#[derive(Debug)]
pub struct XmlObject {
    /// The name of the element, such as `bsdf`.
    pub tag: String,
    /// The attribute `type`.
    pub kind: String,
    /// The attribute `id`, or else the type.
    pub name: String,
    pub place: Place,
    /// The folders of the files that it names.
    pub folders: Rc<Folders>,
    pub properties: Vec<Property>,
}

/// A named value; nested objects need no name.
#[derive(Debug)]
pub struct Property {
    pub name: String,
    pub place: Place,
    pub value: Value,
    pub used: Cell<bool>,
}

/// The value of a property.
#[derive(Debug, Clone)]
pub enum Value {
    Number(f64),
    Boolean(bool),
    Text(String),
    Vector(DVec3),
    Colour(Rgb),
    Spectrum(Spectral),
    Transform(DAffine3),
    Object(Rc<XmlObject>),
}

impl XmlObject {
    /// Returns the property of this name, if present.
    pub fn get(&self, name: &str) -> Option<&Property> {
        let found = self
            .properties
            .iter()
            .find(|property| property.name == name);
        found.inspect(|property| property.used.set(true))
    }

    /// Returns a number.
    ///
    /// # Errors
    /// If the property has another type.
    pub fn number(&self, name: &str) -> Result<Option<f64>> {
        match self.get(name).map(|property| (property, &property.value)) {
            None => Ok(None),
            Some((_, Value::Number(number))) => Ok(Some(*number)),
            Some((property, _)) => Err(property.expected("a number")),
        }
    }

    /// Returns a number that passes `test`, or `default`; `what` describes such a number.
    ///
    /// # Errors
    /// If it has another type, or does not pass.
    pub fn number_where(
        &self,
        name: &str,
        default: f64,
        what: &str,
        test: impl Fn(f64) -> bool,
    ) -> Result<f64> {
        match self.number(name)? {
            None => Ok(default),
            Some(number) if test(number) => Ok(number),
            Some(number) => Err(self.error_at(name, &format!("expected {what}, found {number}"))),
        }
    }

    /// Returns a boolean, or `default`.
    ///
    /// # Errors
    /// If the property has another type.
    pub fn truth(&self, name: &str, default: bool) -> Result<bool> {
        match self.get(name).map(|property| (property, &property.value)) {
            None => Ok(default),
            Some((_, Value::Boolean(truth))) => Ok(*truth),
            Some((property, _)) => Err(property.expected("true or false")),
        }
    }

    /// Returns a text.
    ///
    /// # Errors
    /// If the property has another type.
    pub fn text(&self, name: &str) -> Result<Option<&str>> {
        match self.get(name).map(|property| (property, &property.value)) {
            None => Ok(None),
            Some((_, Value::Text(text))) => Ok(Some(text)),
            Some((property, _)) => Err(property.expected("a string")),
        }
    }

    /// Returns the file that the property `filename` names.
    ///
    /// # Errors
    /// If there is none, or it has another type.
    pub fn file(&self) -> Result<PathBuf> {
        let name = self.text("filename")?;
        let name = name.ok_or_else(|| self.error("expected a `filename`"))?;
        Ok(self.folders.find(name))
    }

    /// Returns the numbers of a text, between spaces or commas.
    ///
    /// # Errors
    /// If there is none, or it has another type.
    pub fn list(&self, name: &str) -> Result<Vec<f64>> {
        let text = self.text(name)?;
        let text = text.ok_or_else(|| self.error(&format!("expected a `{name}`")))?;
        let words = text.split(|c: char| c == ',' || c.is_whitespace());
        let number = |word: &str| {
            let number = word.parse().ok().filter(|x: &f64| x.is_finite());
            number.ok_or_else(|| {
                let why = format!("expected finite numbers, found {}", shown(word));
                self.error_at(name, &why)
            })
        };
        words.filter(|word| !word.is_empty()).map(number).collect()
    }

    /// Returns a point or a vector.
    ///
    /// # Errors
    /// If the property has another type.
    pub fn vector(&self, name: &str) -> Result<Option<DVec3>> {
        match self.get(name).map(|property| (property, &property.value)) {
            None => Ok(None),
            Some((_, Value::Vector(vector))) => Ok(Some(*vector)),
            Some((property, _)) => Err(property.expected("a point or a vector")),
        }
    }

    /// Returns the transform `to_world`, or another one; the identity if it is absent.
    ///
    /// # Errors
    /// If the property has another type.
    pub fn transform(&self, name: &str) -> Result<DAffine3> {
        match self.get(name).map(|property| (property, &property.value)) {
            None => Ok(DAffine3::IDENTITY),
            Some((_, Value::Transform(transform))) => Ok(*transform),
            Some((property, _)) => Err(property.expected("a transform")),
        }
    }

    /// Returns all nested objects of a tag, whatever their names.
    pub fn children<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a Rc<XmlObject>> {
        self.properties
            .iter()
            .filter_map(move |property| match &property.value {
                Value::Object(object) if object.tag == tag => {
                    property.used.set(true);
                    Some(object)
                }
                _ => None,
            })
    }

    /// The element and the name of the object, for messages.
    pub fn title(&self) -> String {
        match self.tag.as_str() {
            "scene" => "the scene".to_owned(),
            tag => format!("{tag} `{}`", self.name),
        }
    }

    /// Returns an error about a property, or about the object if it has none of this name.
    pub fn error_at(&self, name: &str, why: &str) -> crate::Error {
        let place = self
            .get(name)
            .map_or(&self.place, |property| &property.place);
        place.error(format!("`{name}` of {}: {why}", self.title()))
    }

    /// Returns an error about the object.
    pub fn error(&self, why: &str) -> crate::Error {
        self.place.error(format!("{}: {why}", self.title()))
    }

    /// Returns a note about the object.
    pub fn note(&self, kind: NoteKind, text: &str) -> Note {
        Note::at(
            self.place.clone(),
            kind,
            format!("{}: {text}", self.title()),
        )
    }

    /// Notes that properties are left out, unless they are 0, which has no effect.
    pub fn note_unless_zero(&self, names: &[&str], contents: &mut SceneContents) {
        for name in names {
            let value = self.get(name).map(|property| &property.value);
            if !matches!(value, None | Some(Value::Number(0.0))) {
                let text = format!("`{name}` is not supported: left out");
                contents.note(self.note(NoteKind::Omission, &text));
            }
        }
    }

    /// Notes the properties that nothing requested; `harmless` ones do not change the image.
    pub fn note_unused(&self, harmless: &[&str], contents: &mut SceneContents) {
        for property in &self.properties {
            let is_harmless = harmless.contains(&property.name.as_str());
            if property.used.replace(true) || is_harmless {
                continue;
            }
            let what = match &property.value {
                Value::Object(object) => format!("{} `{}`", object.tag, shown(&object.kind)),
                _ => format!("`{}`", shown(&property.name)),
            };
            contents.note(Note::at(
                property.place.clone(),
                NoteKind::Omission,
                format!("{}: {what} is not supported: left out", self.title()),
            ));
        }
    }
}

impl Property {
    /// Returns a number, a colour or a spectrum as a colour.
    ///
    /// # Errors
    /// If the property is anything else.
    pub fn colour(&self, kind: ColourMeaning) -> Result<Rgb> {
        match &self.value {
            Value::Number(number) if *number >= 0.0 && (*number as f32).is_finite() => {
                Ok(Rgb::grey(*number as f32))
            }
            Value::Colour(colour) => Ok(*colour),
            Value::Spectrum(spectrum) => Ok(spectrum.colour(kind)),
            _ => Err(self.expected("a colour of at least 0")),
        }
    }

    /// Returns an error that names what was expected.
    pub fn expected(&self, what: &str) -> crate::Error {
        let name = shown(&self.name);
        self.place.error(format!("expected {what} for `{name}`"))
    }
}
