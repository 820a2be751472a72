//! A mistake in a PLY file, and its place.
//!
//! Measure: lines count from 1, bytes from 0.
//! Range: any place.
//! Source: none needed. Tested in `tests/loading/ply.rs`.

/// A mistake in a file, and its place.
#[derive(Debug)]
pub struct Complaint {
    /// `None` if `why` names the byte.
    pub line: Option<usize>,
    /// The expectation that was not met.
    pub why: String,
}

impl Complaint {
    /// Returns a complaint about a line.
    pub fn at_line(line: usize, why: &str) -> Self {
        Self {
            line: Some(line),
            why: why.to_owned(),
        }
    }

    /// Returns a complaint about a byte.
    pub fn at_byte(byte: usize, why: &str) -> Self {
        Self {
            line: None,
            why: format!("at byte {byte}: {why}"),
        }
    }
}
