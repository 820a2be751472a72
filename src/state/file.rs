//! The frame of a state file: magic number, format, header, body and checksum.
//!
//! Measure: bytes, little-endian.
//! Range: any bytes; those that no render writes are refused.
//! Source: `mod.rs` has the layout. Tested in `tests/rendering/state.rs` and `tests/fuzz_corpus.rs`.

use super::body;
use super::header::{StateHeader, damaged};
use crate::error::{Error, ErrorKind, Result};
use crate::film::Film;
use crate::image::Layer;
use crate::image::atomic::{ExistingFile, write_durably};
use crate::memory;
use crate::render::adaptive::allocation::Allocation;
use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;

/// The first bytes of a state file.
const MAGIC: &[u8; 8] = b"ETDSTATE";

/// The number of this format; another one is refused.
pub const FORMAT: u32 = 2;

/// The bytes before the header.
pub(super) const BEFORE_HEADER: usize = 16;

/// The bytes of the checksum.
pub(super) const CHECKSUM: usize = blake3::OUT_LEN;

/// The largest header, in bytes: a longer one is not from a render.
const MAX_HEADER: u32 = 1 << 26;

/// Writes a state to a file, whole or not at all.
pub fn write(
    header: &StateHeader,
    film: &Film,
    layers: &[Layer],
    allocation: Option<&Allocation>,
    path: &Path,
    existing: ExistingFile,
) -> Result<()> {
    let text = serde_json::to_vec(header)
        .map_err(|error| Error::render("cannot write the header").because(error))?;
    write_durably(path, existing, |writer| {
        let mut summed = Summed {
            writer,
            hasher: blake3::Hasher::new(),
        };
        summed.write_all(MAGIC)?;
        summed.write_all(&FORMAT.to_le_bytes())?;
        let length = u32::try_from(text.len()).map_err(io::Error::other)?;
        summed.write_all(&length.to_le_bytes())?;
        summed.write_all(&text)?;
        let mut buffered = io::BufWriter::with_capacity(1 << 17, &mut summed);
        body::write(film, layers, allocation, &mut buffered)?;
        buffered.flush()?;
        drop(buffered);
        let checksum = summed.hasher.finalize();
        summed.writer.write_all(checksum.as_bytes())
    })
}

/// A writer that hashes all bytes.
struct Summed<W> {
    writer: W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.writer.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Appends the checksum to bytes, as at the end of a state file.
pub fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    let checksum = blake3::hash(&bytes);
    bytes.extend(checksum.as_bytes());
    bytes
}

/// Opens a file. Returns its length, too.
///
/// # Errors
/// A file that cannot be read, or is not a regular one: a pipe would be waited for.
fn open(path: &Path) -> Result<(fs::File, u64)> {
    let cannot_read = |error| Error::io("cannot read", path, error);
    let metadata = fs::metadata(path).map_err(cannot_read)?;
    if !metadata.is_file() {
        return Err(cannot_read(io::Error::other("not a regular file")));
    }
    let file = fs::File::open(path).map_err(cannot_read)?;
    Ok((file, metadata.len()))
}

/// Reads the bytes of a file.
///
/// # Errors
/// A file that cannot be read, and too little memory.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let cannot_read = |error| Error::io("cannot read", path, error);
    let (mut file, length) = open(path)?;
    memory::check(length, || format!("the file {}", path.display()))?;
    let length = usize::try_from(length).map_err(|_| cannot_read(too_large()))?;
    let mut bytes = vec![];
    bytes
        .try_reserve_exact(length)
        .map_err(|_| cannot_read(too_large()))?;
    file.read_to_end(&mut bytes).map_err(cannot_read)?;
    Ok(bytes)
}

fn too_large() -> io::Error {
    io::ErrorKind::OutOfMemory.into()
}

/// Whether the checksum of a file is not that of its contents: no version of etendue wrote it so.
///
/// # Errors
/// A file that cannot be read, which may be whole.
pub fn is_damaged(path: &Path) -> Result<bool> {
    let cannot_read = |error| Error::io("cannot read", path, error);
    let (mut file, length) = open(path)?;
    let Some(content) = length.checked_sub(CHECKSUM as u64) else {
        return Ok(true);
    };
    let mut hasher = blake3::Hasher::new();
    hasher
        .update_reader((&mut file).take(content))
        .map_err(cannot_read)?;
    let mut checksum = [0; CHECKSUM];
    file.read_exact(&mut checksum).map_err(cannot_read)?;
    Ok(hasher.finalize() != checksum)
}

/// Reads the header of a file. The checksum is not compared.
///
/// # Errors
/// A file that cannot be read or is not a state file.
pub fn read_header(path: &Path) -> Result<StateHeader> {
    let cannot_read = |error| Error::io("cannot read", path, error);
    let (mut file, size) = open(path)?;
    let mut bytes = vec![];
    let mut read_to = |bytes: &mut Vec<u8>, end: u64| {
        let more = end.saturating_sub(bytes.len() as u64);
        (&mut file)
            .take(more)
            .read_to_end(bytes)
            .map_err(cannot_read)
    };
    read_to(&mut bytes, BEFORE_HEADER as u64)?;
    let length = header_length(&bytes).map_err(|error| error.in_file(path))?;
    read_to(&mut bytes, (BEFORE_HEADER + length) as u64)?;
    let header = header(&bytes, length, size);
    header.map_err(|error| error.in_file(path))
}

/// The header and the body of a whole file, once its checksum is found to be right.
///
/// # Errors
/// A damaged file, or one of another format.
pub fn checked(bytes: &[u8]) -> Result<(StateHeader, &[u8])> {
    let length = header_length(bytes)?;
    let Some((content, checksum)) = bytes.split_last_chunk::<CHECKSUM>() else {
        return Err(too_short(bytes.len()));
    };
    if blake3::hash(content) != *checksum {
        return Err(wrong_checksum());
    }
    let header = header(bytes, length, bytes.len() as u64)?;
    Ok((header, &content[BEFORE_HEADER + length..]))
}

/// The length of the header of a file that begins with these bytes.
pub(super) fn header_length(bytes: &[u8]) -> Result<usize> {
    if bytes.is_empty() {
        return Err(damaged("it is empty".to_owned()));
    }
    if !bytes.starts_with(&MAGIC[..bytes.len().min(MAGIC.len())]) {
        return Err(Error::new(
            ErrorKind::Io,
            "is not a state file: expected one that `etendue render -o FILE.etd` or --checkpoint wrote",
        ));
    }
    let number = |at: usize| -> Option<u32> {
        let bytes = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(format), Some(length)) = (number(8), number(12)) else {
        return Err(too_short(bytes.len()));
    };
    if format != FORMAT {
        return Err(Error::new(
            ErrorKind::Io,
            format!(
                "is a state file of format {format}: this version of etendue reads format {FORMAT}"
            ),
        ));
    }
    if length > MAX_HEADER {
        return Err(damaged(format!(
            "at byte 12, its header is said to have {length} bytes"
        )));
    }
    Ok(length as usize)
}

/// The header of a file of this size, whose first bytes are given.
pub(super) fn header(bytes: &[u8], length: usize, size: u64) -> Result<StateHeader> {
    let body_length = size.checked_sub((BEFORE_HEADER + length + CHECKSUM) as u64);
    let text = bytes.get(BEFORE_HEADER..BEFORE_HEADER + length);
    let (Some(text), Some(body_length)) = (text, body_length) else {
        return Err(too_short(size as usize));
    };
    let header: StateHeader = serde_json::from_slice(text)
        .map_err(|error| damaged(format!("its header cannot be read: {error}")).because(error))?;
    header.check(body_length)?;
    Ok(header)
}

/// The error for a file that is not as it was written.
pub(super) fn wrong_checksum() -> Error {
    damaged("its checksum is not that of its contents, so it was cut or changed".to_owned())
}

fn too_short(length: usize) -> Error {
    damaged(format!("it was cut: it ends after {length} bytes"))
}
