//! State files that are read one after the other by a thread of its own, in pieces, while others add what was read: the memory
//! is that of a few pieces, for files of any size.
//!
//! Measure: bytes.
//! Range: any files; the checksum of one is compared after its last piece, so that what was added until then may be wrong.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `cli/tests/command/shards.rs`.

use super::file::{BEFORE_HEADER, CHECKSUM, header, header_length, wrong_checksum};
use super::header::StateHeader;
use crate::error::{Error, Result};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, SendError, SyncSender, sync_channel};
use std::thread::Scope;

/// The length of a piece.
const PIECE: usize = 1 << 23;

/// The pieces that are read ahead.
const AHEAD: usize = 2;

/// A part of a file that the reading thread hands over.
enum FileItem {
    /// The beginning of a file, and the length of its body.
    Header(Box<StateHeader>, u64),
    /// A part of its body.
    Piece(Vec<u8>),
    /// Its end, after a checksum that is right.
    End,
}

/// Files that are being read.
pub struct FilesAhead {
    items: Receiver<Result<FileItem>>,
    /// Whether an error was returned, after which there is nothing more.
    has_failed: bool,
}

impl FilesAhead {
    /// Begins to read these files, in this order.
    pub fn new<'scope>(
        scope: &'scope Scope<'scope, '_>,
        files: impl Iterator<Item = &'scope Path> + Send + 'scope,
    ) -> Self {
        let (sender, items) = sync_channel(AHEAD);
        scope.spawn(move || {
            for file in files {
                let failed = match read(file, &sender) {
                    Ok(()) => continue,
                    Err(Stop::Unwanted) => return,
                    Err(Stop::Failed(error)) => error.in_file(file),
                };
                // Nobody reads on after an error.
                sender.send(Err(failed)).ok();
                return;
            }
        });
        Self {
            items,
            has_failed: false,
        }
    }

    /// The header of the next file, and the length of its body.
    ///
    /// # Errors
    /// A file that cannot be read or is not a state file.
    pub fn header(&mut self) -> Result<(StateHeader, u64)> {
        match self.next()? {
            FileItem::Header(header, length) => Ok((*header, length)),
            FileItem::Piece(_) | FileItem::End => Err(out_of_order()),
        }
    }

    /// The next piece of the body of a file; `None` after the last one, whose checksum is right.
    ///
    /// # Errors
    /// A file that cannot be read or is damaged.
    pub fn piece(&mut self) -> Result<Option<Vec<u8>>> {
        match self.next()? {
            FileItem::Piece(piece) => Ok(Some(piece)),
            FileItem::End => Ok(None),
            FileItem::Header(..) => Err(out_of_order()),
        }
    }

    fn next(&mut self) -> Result<FileItem> {
        if self.has_failed {
            return Ok(FileItem::End);
        }
        let item = self.items.recv().unwrap_or_else(|_| Err(out_of_order()));
        self.has_failed = item.is_err();
        item
    }
}

fn out_of_order() -> Error {
    Error::render("the state files were not read in order")
}

/// Why reading ends before the last file.
enum Stop {
    /// Nobody wants what is read.
    Unwanted,
    /// A file cannot be read.
    Failed(Error),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

impl From<SendError<Result<FileItem>>> for Stop {
    fn from(_: SendError<Result<FileItem>>) -> Self {
        Self::Unwanted
    }
}

/// Reads a file from its beginning to its end.
fn read(path: &Path, sender: &SyncSender<Result<FileItem>>) -> std::result::Result<(), Stop> {
    let cannot_read = |error| Error::io("cannot read", path, error);
    let mut file = File::open(path).map_err(cannot_read)?;
    let size = file.metadata().map_err(cannot_read)?.len();
    let mut hasher = blake3::Hasher::new();
    let mut read = |length: usize| -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        bytes
            .try_reserve_exact(length)
            .map_err(|_| cannot_read(io::ErrorKind::OutOfMemory.into()))?;
        let mut part = (&mut file).take(length as u64);
        part.read_to_end(&mut bytes).map_err(cannot_read)?;
        Ok(bytes)
    };
    let mut bytes = read(BEFORE_HEADER)?;
    let length = header_length(&bytes)?;
    bytes.extend(read(length)?);
    let header = header(&bytes, length, size)?;
    hasher.update(&bytes);
    let mut left = size.saturating_sub((bytes.len() + CHECKSUM) as u64);
    sender.send(Ok(FileItem::Header(Box::new(header), left)))?;
    while left > 0 {
        let piece = read(left.min(PIECE as u64) as usize)?;
        if piece.is_empty() {
            // It became shorter meanwhile.
            return Err(Stop::Failed(wrong_checksum()));
        }
        left -= piece.len() as u64;
        hasher.update(&piece);
        sender.send(Ok(FileItem::Piece(piece)))?;
    }
    if hasher.finalize().as_bytes()[..] != read(CHECKSUM)?[..] {
        return Err(Stop::Failed(wrong_checksum()));
    }
    Ok(sender.send(Ok(FileItem::End))?)
}
