//! The numbers of a PLY body, one after the other, in each of its encodings.
//!
//! Measure: bytes from the start of the file; lines from 1.
//! Range: any bytes; an error has the line (ascii) or the byte (binary), and what was expected.
//! Source: Turk, "The PLY Polygon File Format" (1994). Tested in `tests/loading/ply.rs`.

use super::complaint::Complaint;
use super::header::{PlyProperty, Scalar};
use crate::scene::load::wording::shown;

/// Reads numbers in the order of the file.
pub trait NumberReader {
    /// Returns the next number, in double precision, which holds every number of the format.
    ///
    /// # Errors
    /// If the file ends, or something else is written there.
    fn next(&mut self, scalar: Scalar) -> Result<f64, Complaint>;

    /// The next number as an index or a length; `None` if it is not a whole number of at least 0.
    ///
    /// # Errors
    /// As [`Self::next`].
    fn next_index(&mut self, scalar: Scalar) -> Result<Option<u32>, Complaint> {
        let number = self.next(scalar)?;
        let index = number as u32;
        Ok((f64::from(index) == number).then_some(index))
    }

    /// Returns the next `count` records of `size` bytes, without moving on; `None` if the body is not binary or too short.
    fn records(&self, size: usize, count: usize) -> Option<Records<'_>>;

    /// Moves on by this number of bytes of a binary body.
    fn advance(&mut self, bytes: usize);

    /// Returns a complaint about the last number.
    fn wrong(&self, why: &str) -> Complaint;

    /// Skips a property.
    ///
    /// # Errors
    /// If the file ends before it, or something else is written there.
    fn skip(&mut self, property: &PlyProperty) -> Result<(), Complaint> {
        let Some(length) = property.length else {
            return self.next(property.scalar).map(|_| ());
        };
        for _ in 0..self.length(property, length)? {
            self.next(property.scalar)?;
        }
        Ok(())
    }

    /// Returns the length of a list.
    ///
    /// # Errors
    /// As [`Self::next`], and if it is negative or not whole.
    fn length(&mut self, property: &PlyProperty, length: Scalar) -> Result<u32, Complaint> {
        self.next_index(length)?.ok_or_else(|| {
            let name = &property.name;
            self.wrong(&format!("expected the length of the list `{name}`"))
        })
    }
}

/// Binary records of the same size, which can be read in any order.
pub struct Records<'a> {
    bytes: &'a [u8],
    is_big: bool,
    size: usize,
    /// The number of records.
    pub count: usize,
}

impl Records<'_> {
    /// Returns a number of a record by its offset in bytes; NaN beyond the last record.
    #[inline]
    pub fn number(&self, record: usize, offset: usize, scalar: Scalar) -> f64 {
        let bytes = self.bytes.get(record * self.size + offset..);
        bytes
            .and_then(|bytes| number(bytes, scalar, self.is_big))
            .unwrap_or(f64::NAN)
    }
}

/// The numbers of a binary body; `BIG` is its byte order.
pub struct Binary<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
    /// The byte of the last number.
    last: usize,
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    /// Returns the numbers from byte `at` on.
    pub fn new(bytes: &'a [u8], at: usize) -> Self {
        Self {
            bytes,
            at,
            last: at,
        }
    }
}

impl<const BIG: bool> NumberReader for Binary<'_, BIG> {
    #[inline]
    fn next(&mut self, scalar: Scalar) -> Result<f64, Complaint> {
        self.last = self.at;
        let number = number(&self.bytes[self.at..], scalar, BIG)
            .ok_or_else(|| self.wrong("the file ends before its last element"))?;
        self.at += scalar.size();
        Ok(number)
    }

    fn records(&self, size: usize, count: usize) -> Option<Records<'_>> {
        let end = self.at.checked_add(size.checked_mul(count)?)?;
        let bytes = self.bytes.get(self.at..end)?;
        Some(Records {
            bytes,
            is_big: BIG,
            size,
            count,
        })
    }

    fn advance(&mut self, bytes: usize) {
        self.at += bytes;
    }

    fn wrong(&self, why: &str) -> Complaint {
        Complaint::at_byte(self.last, why)
    }
}

/// Returns the number at the start of some bytes, if they are enough.
#[inline]
fn number(bytes: &[u8], scalar: Scalar, is_big: bool) -> Option<f64> {
    Some(match scalar {
        Scalar::I8 => f64::from(i8::from_le_bytes(little_endian(bytes, is_big)?)),
        Scalar::U8 => f64::from(u8::from_le_bytes(little_endian(bytes, is_big)?)),
        Scalar::I16 => f64::from(i16::from_le_bytes(little_endian(bytes, is_big)?)),
        Scalar::U16 => f64::from(u16::from_le_bytes(little_endian(bytes, is_big)?)),
        Scalar::I32 => f64::from(i32::from_le_bytes(little_endian(bytes, is_big)?)),
        Scalar::U32 => f64::from(u32::from_le_bytes(little_endian(bytes, is_big)?)),
        Scalar::F32 => f64::from(f32::from_le_bytes(little_endian(bytes, is_big)?)),
        Scalar::F64 => f64::from_le_bytes(little_endian(bytes, is_big)?),
    })
}

#[inline]
fn little_endian<const N: usize>(bytes: &[u8], is_big: bool) -> Option<[u8; N]> {
    let mut bytes = *bytes.first_chunk()?;
    if is_big {
        bytes.reverse();
    }
    Some(bytes)
}

/// The numbers of an ascii body, separated by white space.
pub struct Ascii<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Ascii<'a> {
    /// Returns the numbers from byte `at` on, which is the first after this many lines.
    pub fn new(bytes: &'a [u8], at: usize, lines: usize) -> Self {
        let line = lines + 1;
        Self { bytes, at, line }
    }
}

impl NumberReader for Ascii<'_> {
    fn next(&mut self, _: Scalar) -> Result<f64, Complaint> {
        let mut start = self.at;
        while let Some(byte) = self
            .bytes
            .get(start)
            .filter(|byte| byte.is_ascii_whitespace())
        {
            self.line += usize::from(*byte == b'\n');
            start += 1;
        }
        let rest = &self.bytes[start..];
        let length = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..length.unwrap_or(rest.len())];
        self.at = start + word.len();
        if word.is_empty() {
            return Err(self.wrong("the file ends before its last element"));
        }
        let number = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| {
            let word = String::from_utf8_lossy(word);
            self.wrong(&format!("expected a number, found {}", shown(&word)))
        })
    }

    fn records(&self, _: usize, _: usize) -> Option<Records<'_>> {
        None
    }

    fn advance(&mut self, bytes: usize) {
        self.at += bytes;
    }

    fn wrong(&self, why: &str) -> Complaint {
        Complaint::at_line(self.line, why)
    }
}
