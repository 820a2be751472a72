//! A typed reader of TOML that knows the position of every value and the valid keys of each table.
//!
//! Measure: none.
//! Range: every value is requested by type and range; a mismatch is an error with file, line and field.
//! Source: TOML 1.0, through the toml crate. Tested below and in `cli/tests/command/bad_input.rs`.

use super::wording::{shown, unknown_name};
use crate::error::{Error, Result};
use crate::math::vec::{DVec2, DVec3};
use crate::scene::description::Place;
use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a scene file, with its line starts.
#[derive(Debug)]
pub struct TomlDocument<'a> {
    file: &'a Path,
    text: &'a str,
    /// The offset in bytes of the start of each line.
    lines: Vec<usize>,
}

impl<'a> TomlDocument<'a> {
    /// Returns the document of a file with this content.
    pub fn new(file: &'a Path, text: &'a str) -> Self {
        let starts = text.match_indices('\n').map(|(newline, _)| newline + 1);
        let lines = std::iter::once(0).chain(starts).collect();
        Self { file, text, lines }
    }

    /// Parses the text as TOML.
    ///
    /// # Errors
    /// The parser's message, with the line.
    pub fn parse(&self) -> Result<Spanned<DeTable<'a>>> {
        DeTable::parse(self.text).map_err(|error| {
            let line = self.line(error.span().map_or(0, |span| span.start));
            Error::scene(error.message())
                .in_file(self.file)
                .at_line(line)
        })
    }

    /// Returns the line, counted from 1, of a byte offset.
    fn line(&self, offset: usize) -> usize {
        self.lines.partition_point(|&start| start <= offset)
    }

    fn error(&self, field: &str, span: &Range<usize>, message: impl Into<String>) -> Error {
        let error = Error::scene(message)
            .in_file(self.file)
            .at_line(self.line(span.start));
        if field.is_empty() {
            error
        } else {
            error.in_field(field)
        }
    }
}

/// A table that records which keys were requested.
pub struct Table<'a> {
    document: &'a TomlDocument<'a>,
    /// The path in the document, such as `shape[2]`; empty for the root table.
    path: String,
    table: &'a DeTable<'a>,
    span: Range<usize>,
    asked: RefCell<Vec<&'static str>>,
}

/// A value with its path and position.
#[derive(Clone)]
pub struct Value<'a> {
    document: &'a TomlDocument<'a>,
    path: String,
    value: &'a DeValue<'a>,
    span: Range<usize>,
}

impl<'a> Table<'a> {
    /// Returns the root table of the document.
    pub fn root(document: &'a TomlDocument<'a>, parsed: &'a Spanned<DeTable<'a>>) -> Self {
        Self {
            document,
            path: String::new(),
            table: parsed.get_ref(),
            span: 0..0,
            asked: RefCell::default(),
        }
    }

    /// Returns the value of a key, if present.
    pub fn optional(&self, key: &'static str) -> Option<Value<'a>> {
        self.asked.borrow_mut().push(key);
        let (_, value) = self.table.iter().find(|(name, _)| name.get_ref() == key)?;
        Some(Value {
            document: self.document,
            path: self.field(key),
            value: value.get_ref(),
            span: value.span(),
        })
    }

    /// Returns the value of a required key.
    ///
    /// # Errors
    /// If the key is missing.
    pub fn required(&self, key: &'static str) -> Result<Value<'a>> {
        self.optional(key)
            .ok_or_else(|| self.error(format!("`{key}` is missing")))
    }

    /// Whether the table has the key.
    pub fn has(&self, key: &'static str) -> bool {
        self.optional(key).is_some()
    }

    /// Returns the table's place in the file.
    pub fn place(&self) -> Place {
        Place::on_line(self.document.file, self.document.line(self.span.start))
    }

    /// Returns an error about the table as a whole.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.document.error(&self.path, &self.span, message)
    }

    /// Checks that every key of the table was requested.
    ///
    /// # Errors
    /// The first unknown key, with the most similar name among the requested ones.
    pub fn finish(&self) -> Result<()> {
        let asked = self.asked.borrow();
        let unknown = self
            .table
            .iter()
            .filter(|(key, _)| !asked.iter().any(|known| known == key.get_ref()));
        let Some((key, _)) = unknown.min_by_key(|(key, _)| key.span().start) else {
            return Ok(());
        };
        let message = unknown_name("key", key.get_ref(), &asked);
        Err(self.document.error(&self.path, &key.span(), message))
    }

    fn field(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        }
    }
}

impl<'a> Value<'a> {
    /// Returns the line of the value.
    pub fn line(&self) -> usize {
        self.document.line(self.span.start)
    }

    /// Returns an error about the value.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.document.error(&self.path, &self.span, message)
    }

    /// Returns an error that names what was expected and what was found.
    pub fn expected(&self, what: &str) -> Error {
        let found = match self.value {
            DeValue::Table(_) => "a table".to_owned(),
            DeValue::Array(array) => format!("a list of {}", array.len()),
            _ => shown(
                self.document
                    .text
                    .get(self.span.clone())
                    .unwrap_or_default(),
            ),
        };
        self.error(format!("expected {what}, found {found}"))
    }

    /// Whether the value is a list.
    pub fn is_list(&self) -> bool {
        self.value.is_array()
    }

    /// Whether the value is a number.
    pub fn is_number(&self) -> bool {
        self.value.is_integer() || self.value.is_float()
    }

    /// Whether the value is a string.
    pub fn is_text(&self) -> bool {
        self.value.is_str()
    }

    /// Returns the value as a finite number.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn number(&self) -> Result<f64> {
        let number = match self.value {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(_) => self.integer().map(|integer| integer as f64),
            _ => None,
        };
        number
            .filter(|n: &f64| n.is_finite())
            .ok_or_else(|| self.expected("a finite number"))
    }

    /// Returns the value as a number that passes `test`; `what` describes such a number.
    ///
    /// # Errors
    /// If it does not pass.
    pub fn number_where(&self, what: &str, test: impl Fn(f64) -> bool) -> Result<f64> {
        let number = self.number().map_err(|_| self.expected(what))?;
        if test(number) {
            Ok(number)
        } else {
            Err(self.expected(what))
        }
    }

    /// Returns the value as an angle in radians: a number of degrees that passes `test`, or a table of `radians`, for which
    /// there may be no such number.
    ///
    /// # Errors
    /// If it does not pass.
    pub fn angle_where(&self, what: &str, test: impl Fn(f64) -> bool) -> Result<f64> {
        if !self.value.is_table() {
            let degrees = self.number_where(what, |x: f64| test(x.to_radians()))?;
            return Ok(degrees.to_radians());
        }
        let table = self.table()?;
        let radians = table.required("radians")?.number_where(what, test)?;
        table.finish()?;
        Ok(radians)
    }

    /// Returns the value as a number that is finite and passes `test` in single precision, which shading uses.
    ///
    /// # Errors
    /// If it does not pass.
    pub fn single_where(&self, what: &str, test: impl Fn(f32) -> bool) -> Result<f32> {
        let single = |x: f64| x as f32;
        self.number_where(what, |x| single(x).is_finite() && test(single(x)))
            .map(single)
    }

    /// Returns the value as an integer from `least` to `most`.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn whole(&self, least: u64, most: u64) -> Result<u64> {
        let found = self
            .integer()
            .and_then(|integer| u64::try_from(integer).ok());
        let inside = found.filter(|integer| (least..=most).contains(integer));
        inside.ok_or_else(|| {
            if most == u64::MAX {
                self.expected(&format!("a whole number of at least {least}"))
            } else {
                self.expected(&format!("a whole number from {least} to {most}"))
            }
        })
    }

    fn integer(&self) -> Option<i128> {
        let integer = self.value.as_integer()?;
        i128::from_str_radix(integer.as_str(), integer.radix()).ok()
    }

    /// Returns the value as a string.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn text(&self) -> Result<&'a str> {
        self.value
            .as_str()
            .ok_or_else(|| self.expected("a string in quotes"))
    }

    /// Returns the value as a boolean.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn truth(&self) -> Result<bool> {
        self.value
            .as_bool()
            .ok_or_else(|| self.expected("true or false"))
    }

    /// Returns the entry of `names` that the value names.
    ///
    /// # Errors
    /// If it is none of them; the error suggests the most similar.
    pub fn one_of<T: Copy>(&self, names: &[(&str, T)]) -> Result<T> {
        let text = self.text()?;
        let known: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        let found = names.iter().find(|(name, _)| *name == text);
        found
            .map(|(_, value)| *value)
            .ok_or_else(|| self.error(unknown_name("name", text, &known)))
    }

    /// Returns the entries of a list.
    ///
    /// # Errors
    /// If the value is not a list.
    pub fn list(&self) -> Result<Vec<Self>> {
        let array = self
            .value
            .as_array()
            .ok_or_else(|| self.expected("a list"))?;
        let entries = array.iter().enumerate().map(|(index, entry)| Self {
            document: self.document,
            path: format!("{}[{index}]", self.path),
            value: entry.get_ref(),
            span: entry.span(),
        });
        Ok(entries.collect())
    }

    /// Returns the value as a list of exactly `N` finite numbers.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        let expected = || self.expected(&format!("a list of {N} numbers"));
        let entries = self.list().map_err(|_| expected())?;
        let numbers = entries
            .iter()
            .map(Self::number)
            .collect::<Result<Vec<_>>>()?;
        numbers.try_into().map_err(|_| expected())
    }

    /// Returns the value as a point or a direction.
    ///
    /// # Errors
    /// If it is not a list of three finite numbers.
    pub fn vec3(&self) -> Result<DVec3> {
        self.numbers().map(DVec3::from_array)
    }

    /// Returns the value as a texture coordinate.
    ///
    /// # Errors
    /// If it is not a list of two numbers within single precision.
    pub fn vec2(&self) -> Result<DVec2> {
        let pair = DVec2::from_array(self.numbers()?);
        if pair.as_vec2().is_finite() {
            Ok(pair)
        } else {
            Err(self.expected("two numbers within single precision"))
        }
    }

    /// Returns the value as a table.
    ///
    /// # Errors
    /// If it is anything else.
    pub fn table(&self) -> Result<Table<'a>> {
        let table = self
            .value
            .as_table()
            .ok_or_else(|| self.expected("a table"))?;
        Ok(Table {
            document: self.document,
            path: self.path.clone(),
            table,
            span: self.span.clone(),
            asked: RefCell::default(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, read: impl Fn(&Table<'_>) -> Result<()>) -> String {
        let document = TomlDocument::new(Path::new("a.toml"), text);
        let result = document.parse().and_then(|parsed| {
            let table = Table::root(&document, &parsed);
            read(&table).and_then(|()| table.finish())
        });
        result
            .err()
            .map_or(String::new(), |error| error.to_string())
    }

    #[test]
    fn errors_name_file_line_field_and_what_was_expected() {
        let radius = |table: &Table<'_>| {
            table
                .required("radius")?
                .number_where("a number above 0", |x| x > 0.0)
                .map(|_| ())
        };
        assert_eq!(check("radius = 1", radius), "");
        assert_eq!(
            check("\nradius = -1", radius),
            "a.toml:2: radius: expected a number above 0, found -1"
        );
        for (text, found) in [
            ("'x'", "'x'"),
            ("nan", "nan"),
            ("inf", "inf"),
            ("[1]", "a list of 1"),
        ] {
            let message = check(&format!("radius = {text}"), radius);
            assert_eq!(
                message,
                format!("a.toml:1: radius: expected a number above 0, found {found}")
            );
        }
        assert_eq!(check("", radius), "a.toml:1: `radius` is missing");
    }

    #[test]
    fn unknown_key_error_suggests_the_nearest_known_key() {
        let radius = |table: &Table<'_>| table.optional("radius").map_or(Ok(()), |_| Ok(()));
        assert_eq!(
            check("a = 1\nradius = 1", radius),
            "a.toml:1: unknown key `a`; expected one of: radius"
        );
        assert_eq!(
            check("radius = 1\nraduis = 2", radius),
            "a.toml:2: unknown key `raduis`; did you mean `radius`? Expected one of: radius"
        );
    }

    #[test]
    fn integers_are_read_with_full_64_bit_precision() {
        let seed = |table: &Table<'_>| {
            let seed = table.required("seed")?.whole(0, u64::MAX)?;
            assert_eq!(seed, u64::MAX);
            Ok(())
        };
        assert_eq!(check("seed = 18446744073709551615", seed), "");
        assert!(check("seed = -1", seed).contains("a whole number of at least 0"));
        assert!(check("seed = 1.5", seed).contains("a whole number of at least 0"));
    }

    #[test]
    fn toml_syntax_error_is_reported_with_its_line() {
        assert!(check("a = 1\nb = = 2", |_| Ok(())).starts_with("a.toml:2: "));
    }
}
