//! A parameter of a pbrt statement: `"type name" value` or `"type name" [ values ]`.
//!
//! Measure: as in the file.
//! Range: numbers are finite. Values of another kind than the type's are errors with their line.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::gamut::Gamut;
use super::tokens::{Token, Tokens};
use crate::scene::load::wording::{LineError, shown, unknown_name};
use std::cell::Cell;
use std::rc::Rc;

/// The types of parameters, with the number of values that make one element.
pub const TYPES: &[(&str, usize)] = &[
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
    pub gamut: Cell<Option<Gamut>>,
    /// Whether anything has asked for it.
    pub is_used: Cell<bool>,
}

/// Reads the parameters that follow in the tokens.
///
/// # Errors
/// If one has no type or name, or its values are not of its type.
pub fn read(tokens: &mut Tokens<'_>) -> std::result::Result<Vec<Rc<Parameter>>, LineError> {
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
) -> std::result::Result<Parameter, LineError> {
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

    /// Its numbers, if it has any.
    pub fn numbers(&self) -> &[f64] {
        match &self.values {
            Values::Numbers(numbers) => numbers,
            _ => &[],
        }
    }
}
