//! The header of a PLY file: the encoding of its body, and its elements with their properties.
//!
//! Measure: none; lines count from 1.
//! Range: any header; an error has the line and what was expected.
//! Source: Turk, "The PLY Polygon File Format" (1994). Tested in `tests/loading/ply.rs`.

use super::complaint::Complaint;
use crate::scene::load::wording::{shown, unknown_name};
use std::borrow::Cow;

/// The encoding of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyEncoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// The number of bytes in a binary body.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The largest value of a colour channel of this type; colours in floating point are at most 1.
    pub fn full(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32767.0,
            Self::U16 => 65535.0,
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }

    fn named(name: &str) -> Result<Self, String> {
        const NAMES: &[(&str, Scalar)] = &[
            ("char", Scalar::I8),
            ("uchar", Scalar::U8),
            ("short", Scalar::I16),
            ("ushort", Scalar::U16),
            ("int", Scalar::I32),
            ("uint", Scalar::U32),
            ("float", Scalar::F32),
            ("double", Scalar::F64),
            ("int8", Scalar::I8),
            ("uint8", Scalar::U8),
            ("int16", Scalar::I16),
            ("uint16", Scalar::U16),
            ("int32", Scalar::I32),
            ("uint32", Scalar::U32),
            ("float32", Scalar::F32),
            ("float64", Scalar::F64),
        ];
        let found = NAMES.iter().find(|(known, _)| *known == name);
        found.map(|(_, scalar)| *scalar).ok_or_else(|| {
            let known: Vec<&str> = NAMES.iter().map(|(known, _)| *known).collect();
            unknown_name("type", name, &known)
        })
    }
}

/// A property of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlyProperty {
    pub name: String,
    /// The type of the list's length, if the property is a list.
    pub length: Option<Scalar>,
    /// The type of the value or of each entry.
    pub scalar: Scalar,
}

/// A kind of records, which follow one another in the body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<PlyProperty>,
    /// The line of its declaration.
    pub line: usize,
}

impl Element {
    /// Returns the index of the first property with one of these names.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        let is_one = |property: &PlyProperty| names.contains(&property.name.as_str());
        self.properties.iter().position(is_one)
    }

    /// The smallest number of bytes that a record takes in this encoding.
    pub fn least_size(&self, encoding: BodyEncoding) -> usize {
        let sizes = self.properties.iter().map(|property| match encoding {
            // A digit; a separator follows all numbers but the last.
            BodyEncoding::Ascii => 1,
            _ => property.length.unwrap_or(property.scalar).size(),
        });
        sizes.sum()
    }
}

/// A parsed header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlyHeader {
    pub encoding: BodyEncoding,
    pub elements: Vec<Element>,
    /// The image that a comment names, as MeshLab writes it, and the line of the comment.
    pub texture_file: Option<(String, usize)>,
    /// The number of lines, which is also that of the last one.
    pub lines: usize,
    /// The number of bytes.
    pub size: usize,
}

impl PlyHeader {
    /// Parses the header at the beginning of a file.
    ///
    /// # Errors
    /// The first line that is not as the format requires.
    pub fn parse(bytes: &[u8]) -> Result<Self, Complaint> {
        let mut lines = Lines {
            bytes,
            at: 0,
            line: 0,
        };
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut texture_file = None;
        if lines.next()? != "ply" {
            return Err(lines.wrong("expected a PLY file, which begins with `ply`"));
        }
        loop {
            let text = lines.next()?;
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            match words.as_slice() {
                ["end_header"] => break,
                ["comment", "TextureFile", ..] => {
                    let (_, name) = text.split_once("TextureFile").unwrap_or_default();
                    texture_file.get_or_insert_with(|| (name.trim().to_owned(), lines.line));
                }
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, "1.0"] => {
                    encoding = Some(match *name {
                        "ascii" => BodyEncoding::Ascii,
                        "binary_little_endian" => BodyEncoding::LittleEndian,
                        "binary_big_endian" => BodyEncoding::BigEndian,
                        _ => {
                            let known = ["ascii", "binary_little_endian", "binary_big_endian"];
                            return Err(lines.wrong(&unknown_name("format", name, &known)));
                        }
                    });
                }
                ["element", name, count] => elements.push(Element {
                    name: shown(name),
                    count: count.parse().map_err(|_| {
                        lines.wrong(&format!(
                            "expected a number of records, found {}",
                            shown(count)
                        ))
                    })?,
                    properties: Vec::new(),
                    line: lines.line,
                }),
                ["property", kind @ .., name] => {
                    let property = property(kind, name).map_err(|why| lines.wrong(&why))?;
                    let Some(element) = elements.last_mut() else {
                        return Err(lines.wrong("expected an element before its properties"));
                    };
                    element.properties.push(property);
                }
                _ => {
                    let why = format!(
                        "expected format, element, property, comment or end_header, found `{}`",
                        shown(&text)
                    );
                    return Err(lines.wrong(&why));
                }
            }
        }
        let Some(encoding) = encoding else {
            return Err(lines.wrong("expected a line `format` in the header"));
        };
        Ok(Self {
            encoding,
            elements,
            texture_file,
            lines: lines.line,
            size: lines.at,
        })
    }
}

fn property(kind: &[&str], name: &str) -> Result<PlyProperty, String> {
    let (length, scalar) = match kind {
        ["list", length, scalar] => {
            let length_type = Scalar::named(length)?;
            if matches!(length_type, Scalar::F32 | Scalar::F64) {
                return Err(format!(
                    "expected a type of whole numbers for the length, found {length}"
                ));
            }
            (Some(length_type), Scalar::named(scalar)?)
        }
        [scalar] => (None, Scalar::named(scalar)?),
        _ => return Err("expected a type and a name, or `list`, two types and a name".to_owned()),
    };
    Ok(PlyProperty {
        name: shown(name),
        length,
        scalar,
    })
}

/// The lines of the header.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

/// The largest length of a line of the header, in bytes; a file without lines is no PLY file.
const MAX_LINE_LENGTH: usize = 4096;

impl<'a> Lines<'a> {
    /// Returns the next line; characters that are not UTF-8, which comments may have, are replaced.
    fn next(&mut self) -> Result<Cow<'a, str>, Complaint> {
        self.line += 1;
        let rest = &self.bytes[self.at..];
        let length = rest
            .iter()
            .take(MAX_LINE_LENGTH)
            .position(|&byte| byte == b'\n')
            .ok_or_else(|| self.wrong("expected a header that ends with `end_header`"))?;
        self.at += length + 1;
        Ok(String::from_utf8_lossy(rest[..length].trim_ascii_end()))
    }

    fn wrong(&self, why: &str) -> Complaint {
        Complaint::at_line(self.line, why)
    }
}
