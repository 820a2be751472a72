//! The parameters of a pbrt statement.
//!
//! Measure: as in the file.
//! Range: numbers are finite. A parameter of another type than expected, and a wrong number of values, are errors with
//! the parameter's line.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::gamut::Gamut;
use super::parameter::{Parameter, TYPES, Values};
use crate::error::{Error, Result};
use crate::math::vec::{DVec2, DVec3};
use crate::scene::description::Place;
use crate::scene::load::wording::{shown, unknown_name};
use std::rc::Rc;

const POINTS3: &[&str] = &["point3", "point", "vector3", "vector", "normal", "normal3"];

/// The parameters of a statement, and the defaults for those that it leaves out.
#[derive(Debug)]
pub struct Parameters {
    /// The place of the statement.
    pub place: Place,
    own: Vec<Rc<Parameter>>,
    defaults: Vec<Rc<Parameter>>,
    gamut: Gamut,
}

impl Parameters {
    /// The parameters of a statement at `place`, with `defaults` for those that it leaves out.
    pub fn new(
        place: Place,
        own: Vec<Rc<Parameter>>,
        defaults: Vec<Rc<Parameter>>,
        gamut: Gamut,
    ) -> Self {
        Self {
            place,
            own,
            defaults,
            gamut,
        }
    }

    /// An error about the whole statement.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.place.error(message)
    }

    /// An error about a parameter, or about the statement if it leaves that out.
    pub fn error_of(&self, name: &str, message: impl Into<String>) -> Error {
        let error = Error::scene(message).in_field(shown(name));
        let line = self.find(name).map(|found| found.line).or(self.place.line);
        let error = error.in_file(&self.place.file);
        match line {
            Some(line) => error.at_line(line),
            None => error,
        }
    }

    /// The place of a parameter, or of the statement if it leaves that out.
    pub fn place_of(&self, name: &str) -> Place {
        Place {
            file: self.place.file.clone(),
            line: self.find(name).map(|found| found.line).or(self.place.line),
        }
    }

    /// Whether a parameter is given.
    pub fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    /// The colour space of the `rgb` values of a parameter.
    pub fn gamut_of(&self, name: &str) -> Gamut {
        self.find(name)
            .and_then(|found| found.gamut.get())
            .unwrap_or(self.gamut)
    }

    /// The names of the parameters that nothing has asked for.
    pub fn unused(&self) -> impl Iterator<Item = (&str, usize)> {
        let unused = self.own.iter().filter(|parameter| !parameter.is_used.get());
        unused.map(|parameter| (parameter.name.as_str(), parameter.line))
    }

    fn find(&self, name: &str) -> Option<&Parameter> {
        let all = self.own.iter().chain(&self.defaults);
        let found = all
            .map(Rc::as_ref)
            .find(|parameter| parameter.name == name)?;
        found.is_used.set(true);
        Some(found)
    }

    /// A parameter of one of these types.
    ///
    /// # Errors
    /// If it has another type.
    pub fn of_type(&self, name: &str, types: &[&str]) -> Result<Option<&Parameter>> {
        let Some(found) = self.find(name) else {
            return Ok(None);
        };
        if types.contains(&found.kind) {
            return Ok(Some(found));
        }
        let expected = types.join(" or ");
        Err(self.error_of(
            name,
            format!(
                "expected a parameter of type {expected}, found {}",
                found.kind
            ),
        ))
    }

    /// All numbers of a parameter; a whole multiple of those of one element.
    fn list(&self, name: &str, types: &[&str]) -> Result<&[f64]> {
        let Some(found) = self.of_type(name, types)? else {
            return Ok(&[]);
        };
        let width = TYPES.iter().find(|(known, _)| *known == found.kind);
        let width = width.map_or(1, |(_, width)| *width);
        let count = found.numbers().len();
        if count % width != 0 {
            let message = format!("expected a multiple of {width} numbers, found {count}");
            return Err(self.error_of(name, message));
        }
        Ok(found.numbers())
    }

    /// The only number of a parameter.
    ///
    /// # Errors
    /// If it has another type or more than one value.
    pub fn number(&self, name: &str, default: f64) -> Result<f64> {
        match (self.has(name), self.list(name, &["float", "integer"])?) {
            (false, _) => Ok(default),
            (true, [only]) => Ok(*only),
            (true, more) => {
                Err(self.error_of(name, format!("expected one number, found {}", more.len())))
            }
        }
    }

    /// A number for which `test` holds.
    ///
    /// # Errors
    /// As [`number`](Self::number); and if it does not hold, with `what` was expected.
    pub fn number_where(
        &self,
        name: &str,
        default: f64,
        what: &str,
        test: impl Fn(f64) -> bool,
    ) -> Result<f64> {
        let value = self.number(name, default)?;
        if test(value) {
            Ok(value)
        } else {
            Err(self.error_of(name, format!("expected {what}, found {value}")))
        }
    }

    /// A whole number from `least` to `most`.
    ///
    /// # Errors
    /// As [`number`](Self::number); and if it is out of range.
    pub fn whole(&self, name: &str, default: u32, [least, most]: [u32; 2]) -> Result<u32> {
        let what = format!("a whole number from {least} to {most}");
        let value = self.number_where(name, f64::from(default), &what, |x| {
            x.fract() == 0.0 && (f64::from(least)..=f64::from(most)).contains(&x)
        })?;
        Ok(value as u32)
    }

    /// All numbers of a parameter of type float.
    ///
    /// # Errors
    /// If it has another type.
    pub fn numbers(&self, name: &str) -> Result<&[f64]> {
        self.list(name, &["float", "integer"])
    }

    /// A list of indices, each below `count`.
    ///
    /// # Errors
    /// If it has another type, or an index is not below `count`.
    pub fn indices(&self, name: &str, count: usize) -> Result<Vec<u32>> {
        let list = self.list(name, &["integer"])?;
        match list
            .iter()
            .find(|&&index| index < 0.0 || index >= count as f64)
        {
            Some(bad) => {
                Err(self.error_of(name, format!("vertex {bad}, but there are {count} points")))
            }
            None => Ok(list.iter().map(|&index| index as u32).collect()),
        }
    }

    /// Whether a flag is set.
    ///
    /// # Errors
    /// If it is not one truth value.
    pub fn truth(&self, name: &str, default: bool) -> Result<bool> {
        match self.of_type(name, &["bool"])?.map(|found| &found.values) {
            None => Ok(default),
            Some(Values::Truths(truths)) if truths.len() == 1 => Ok(truths[0]),
            Some(_) => Err(self.error_of(name, "expected true or false")),
        }
    }

    /// The only string of a parameter.
    ///
    /// # Errors
    /// If it is not one string.
    pub fn text(&self, name: &str) -> Result<Option<&str>> {
        self.text_of(name, &["string"])
    }

    /// The name of the texture that a parameter refers to, if it does.
    ///
    /// # Errors
    /// If it is not one string.
    pub fn texture(&self, name: &str) -> Result<Option<&str>> {
        match self.find(name) {
            Some(found) if found.kind == "texture" => self.text_of(name, &["texture"]),
            _ => Ok(None),
        }
    }

    fn text_of(&self, name: &str, types: &[&str]) -> Result<Option<&str>> {
        match self.of_type(name, types)?.map(|found| &found.values) {
            None => Ok(None),
            Some(Values::Texts(texts)) if texts.len() == 1 => Ok(Some(&texts[0])),
            Some(_) => Err(self.error_of(name, "expected one string")),
        }
    }

    /// All strings of a parameter.
    ///
    /// # Errors
    /// If it has another type.
    pub fn texts(&self, name: &str) -> Result<&[String]> {
        Ok(
            match self.of_type(name, &["string"])?.map(|found| &found.values) {
                Some(Values::Texts(texts)) => texts,
                _ => &[],
            },
        )
    }

    /// One of the named choices, the first of which is the default.
    ///
    /// # Errors
    /// If it is none of them.
    pub fn choice<'a>(&self, name: &str, choices: &[&'a str]) -> Result<&'a str> {
        let Some(text) = self.text(name)? else {
            return Ok(choices[0]);
        };
        let found = choices.iter().find(|choice| **choice == text);
        found
            .copied()
            .ok_or_else(|| self.error_of(name, unknown_name("value", text, choices)))
    }

    /// A list of points, vectors or normals.
    ///
    /// # Errors
    /// If it has another type, or not three numbers for each.
    pub fn points(&self, name: &str) -> Result<Vec<DVec3>> {
        let (triples, _) = self.list(name, POINTS3)?.as_chunks();
        Ok(triples.iter().copied().map(DVec3::from_array).collect())
    }

    /// One point or vector.
    ///
    /// # Errors
    /// If it is not one.
    pub fn point(&self, name: &str, default: DVec3) -> Result<DVec3> {
        match (self.has(name), self.points(name)?.as_slice()) {
            (false, _) => Ok(default),
            (true, [only]) => Ok(*only),
            (true, _) => Err(self.error_of(name, "expected three numbers")),
        }
    }

    /// A list of points in the plane.
    ///
    /// # Errors
    /// If it has another type, or not two numbers for each.
    pub fn points2(&self, name: &str) -> Result<Vec<DVec2>> {
        // Files of pbrt-v3 give texture coordinates as floats.
        let (pairs, _) = self
            .list(name, &["point2", "vector2", "float"])?
            .as_chunks();
        Ok(pairs.iter().copied().map(DVec2::from_array).collect())
    }
}
