//! The parameters of a pbrt statement: `"type name" value` or `"type name" [ values ]`.
//!
//! Measure: as in the file.
//! Range: numbers are finite. A parameter of another type than expected, and a wrong number of values, are errors with
//! the parameter's line.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt.rs`.

use super::gamut::Gamut;
use super::tokens::{Complaint, Token, Tokens};
use crate::error::{Error, Result};
use crate::math::vec::{DVec2, DVec3};
use crate::scene::description::Place;
use crate::scene::load::wording::{shown, unknown_name};
use std::cell::Cell;
use std::rc::Rc;

/// The types of parameters, with the number of values that make one element.
const TYPES: &[(&str, usize)] = &[
    ("integer", 1),
    ("float", 1),
    ("point2", 2),
    ("vector2", 2),
    ("point3", 3),
    ("vector3", 3),
    ("normal", 3),
    ("normal3", 3),
    ("point", 3),
    ("vector", 3),
    ("bool", 1),
    ("string", 1),
    ("texture", 1),
    ("rgb", 3),
    ("blackbody", 1),
    ("spectrum", 1),
];

const POINTS3: &[&str] = &["point3", "point", "vector3", "vector", "normal", "normal3"];

/// The values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Truths(Vec<bool>),
}

/// A parameter.
#[derive(Debug)]
pub struct Parameter {
    pub kind: &'static str,
    pub name: String,
    pub values: Values,
    pub line: usize,
    /// The colour space of its `rgb` values, if it is a default set by `Attribute`.
    gamut: Cell<Option<Gamut>>,
    is_used: Cell<bool>,
}

/// The parameters of a statement, and the defaults for those that it leaves out.
#[derive(Debug)]
pub struct Parameters {
    /// The place of the statement.
    pub place: Place,
    own: Vec<Rc<Parameter>>,
    defaults: Vec<Rc<Parameter>>,
    gamut: Gamut,
}

/// Reads the parameters that follow in the tokens.
///
/// # Errors
/// If one has no type or name, or its values are not of its type.
pub fn read(tokens: &mut Tokens<'_>) -> std::result::Result<Vec<Rc<Parameter>>, Complaint> {
    let mut parameters = vec![];
    while let Some(Token::Quoted(_)) = tokens.peek()? {
        if let Some((Token::Quoted(declaration), line)) = tokens.next()? {
            parameters.push(Rc::new(parameter(&declaration, line, tokens)?));
        }
    }
    Ok(parameters)
}

/// Reads the values of a parameter whose declaration was read.
fn parameter(
    declaration: &str,
    line: usize,
    tokens: &mut Tokens<'_>,
) -> std::result::Result<Parameter, Complaint> {
    let (kind, name) = declared(declaration).map_err(|why| (line, why))?;
    let mut values = match kind {
        "string" | "texture" => Values::Texts(vec![]),
        "bool" => Values::Truths(vec![]),
        _ => Values::Numbers(vec![]),
    };
    let missing = |line| (line, format!("expected values of `{}`", shown(declaration)));
    match tokens.next()? {
        Some((Token::Open, _)) => loop {
            match tokens.next()? {
                Some((Token::Close, _)) => break,
                Some((token, line)) => {
                    push(&mut values, kind, &token).map_err(|why| (line, why))?
                }
                None => return Err((line, "expected `]`, found the end of the file".to_owned())),
            }
        },
        Some((token, line)) => push(&mut values, kind, &token).map_err(|why| (line, why))?,
        None => return Err(missing(line)),
    }
    Ok(Parameter {
        kind,
        name,
        values,
        line,
        gamut: Cell::new(None),
        is_used: Cell::new(false),
    })
}

/// Splits a declaration into the type and the name.
pub fn declared(declaration: &str) -> std::result::Result<(&'static str, String), String> {
    let mut words = declaration.split_ascii_whitespace();
    let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
        let found = shown(declaration);
        return Err(format!(
            "expected a parameter's type and name, found `{found}`"
        ));
    };
    let known = TYPES.iter().find(|(known, _)| *known == kind);
    let Some(&(kind, _)) = known else {
        let names: Vec<&str> = TYPES.iter().map(|(name, _)| *name).collect();
        return Err(unknown_name("parameter type", kind, &names));
    };
    Ok((kind, name.to_owned()))
}

/// Adds a value of a parameter of this type.
fn push(values: &mut Values, kind: &str, token: &Token<'_>) -> std::result::Result<(), String> {
    if let (Values::Numbers(numbers), Token::Quoted(_)) = (&values, token)
        && kind == "spectrum"
        && numbers.is_empty()
    {
        *values = Values::Texts(vec![]);
    }
    match (values, token) {
        (Values::Numbers(numbers), Token::Word(word)) => {
            let value = number(word)?;
            if kind == "integer" && (value.fract() != 0.0 || value.abs() > f64::from(i32::MAX)) {
                return Err(format!(
                    "expected an integer of 32 bits, found `{}`",
                    shown(word)
                ));
            }
            numbers.push(value);
        }
        (Values::Texts(texts), Token::Quoted(text)) => texts.push(text.clone().into_owned()),
        (Values::Truths(truths), Token::Word(word)) if matches!(*word, "true" | "false") => {
            truths.push(*word == "true");
        }
        (values, token) => {
            let expected = match values {
                Values::Numbers(_) => "a number",
                Values::Texts(_) => "a string in quotes",
                Values::Truths(_) => "true or false",
            };
            return Err(format!("expected {expected}, found {}", quote(Some(token))));
        }
    }
    Ok(())
}

/// Reads a number, which has to be finite.
pub fn number(word: &str) -> std::result::Result<f64, String> {
    // Rust also reads words such as `inf` and `nan`.
    let digits = word.bytes().any(|byte| byte.is_ascii_digit());
    let value: Option<f64> = word.parse().ok();
    let value = value.filter(|value| digits && value.is_finite());
    value.ok_or_else(|| format!("expected a number, found `{}`", shown(word)))
}

/// Shows a token, or the end of the file, in a message.
pub fn quote(token: Option<&Token<'_>>) -> String {
    match token {
        None => "the end of the file".to_owned(),
        Some(Token::Open) => "`[`".to_owned(),
        Some(Token::Close) => "`]`".to_owned(),
        Some(Token::Quoted(text)) => format!("`\"{}\"`", shown(text)),
        Some(Token::Word(word)) => format!("`{}`", shown(word)),
    }
}

impl Parameter {
    /// Fixes the colour space of a default to that of the statement that sets it.
    pub fn fix_gamut(&self, gamut: Gamut) {
        self.gamut.set(Some(gamut));
    }

    fn numbers(&self) -> &[f64] {
        match &self.values {
            Values::Numbers(numbers) => numbers,
            _ => &[],
        }
    }
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
        line.map_or_else(|| Error::scene(""), |line| error.at_line(line))
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
