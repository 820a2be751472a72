//! The files of a pbrt scene: the main one and those that it includes, compressed or not.
//!
//! Measure: bytes.
//! Range: at most 64 files within one another and 10000 in all, none within itself.
//! Source: pbrt-v4's file format; RFC 1952. Tested in `tests/loading/pbrt/`.

use crate::error::{Error, Result};
use crate::memory;
use crate::scene::load::{read_bytes, read_text};
use flate2::read::MultiGzDecoder;
use std::io::Read;
use std::path::{Path, PathBuf};

const MAX_WITHIN: usize = 64;
const MAX_FILES: usize = 10_000;

/// The file that is being read, within those that include it.
#[derive(Debug, Default)]
pub struct IncludeStack {
    open: Vec<PathBuf>,
    count: usize,
}

impl IncludeStack {
    /// Reads a file and notes that it is open.
    ///
    /// # Errors
    /// If it cannot be read, is not UTF-8, is open already, or there are too many.
    pub fn open(&mut self, path: &Path) -> Result<String> {
        // The same file may have several names.
        let unique = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let refuse = |why: String| Err(Error::scene(why).in_file(path));
        if self.open.contains(&unique) {
            return refuse("the file includes itself".to_owned());
        }
        if self.open.len() >= MAX_WITHIN || self.count >= MAX_FILES {
            return refuse(format!(
                "expected at most {MAX_WITHIN} files within one another, and {MAX_FILES} in all"
            ));
        }
        let text = match path.extension().is_some_and(|extension| extension == "gz") {
            true => unpacked_text(path)?,
            false => read_text(path)?,
        };
        self.open.push(unique);
        self.count += 1;
        Ok(text)
    }

    /// Notes that the file is read.
    pub fn close(&mut self) {
        self.open.pop();
    }
}

fn unpacked_text(path: &Path) -> Result<String> {
    String::from_utf8(unpacked(path)?)
        .map_err(|_| Error::scene("expected UTF-8 text within the compressed file").in_file(path))
}

/// Reads a file that gzip compressed.
///
/// # Errors
/// If it cannot be read, is damaged, or there is no memory for its content.
pub fn unpacked(path: &Path) -> Result<Vec<u8>> {
    const STEP: u64 = 1 << 24;
    let packed = read_bytes(path)?;
    let mut decoder = MultiGzDecoder::new(packed.as_slice());
    let mut content = vec![];
    loop {
        // Growing may take twice what there is.
        memory::check(2 * content.len() as u64 + STEP, || {
            format!("{}", path.display())
        })?;
        let read = decoder.by_ref().take(STEP).read_to_end(&mut content);
        let read = read.map_err(|error| {
            Error::scene(format!("expected a file compressed by gzip: {error}")).in_file(path)
        })?;
        if read == 0 {
            return Ok(content);
        }
    }
}
