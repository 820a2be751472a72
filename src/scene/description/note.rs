//! Notes of the loader: what it decided, approximated or left out, and where.
//!
//! Measure: none.
//! Range: any text; a place without a file is not printed.
//! Source: docs/scene-formats.md. Tested in `tests/loading/notes.rs`.

use super::{Place, SceneDescription};
use crate::error::Result;
use std::fmt;

/// One sentence of the loader to the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// The kind of decision.
    pub kind: NoteKind,
    /// The place of the object concerned; the default if the note is about the whole scene.
    pub place: Place,
    /// The object that was found, and its replacement.
    pub text: String,
}

/// Decisions of a loader, from the least to the greatest effect on the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum NoteKind {
    /// The file leaves something open or has a harmless mistake; the image is what the file describes.
    Decision,
    /// Something was replaced by the most similar that there is: the image differs.
    Approximation,
    /// Something was left out: the image differs.
    Omission,
}

impl Note {
    /// Returns a note about the whole scene.
    pub fn of_scene(kind: NoteKind, text: impl Into<String>) -> Self {
        Self::at(Place::default(), kind, text)
    }

    /// Returns a note about an object at this place.
    pub fn at(place: Place, kind: NoteKind, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { kind, place, text }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.place.file.as_os_str().is_empty() {
            write!(f, "{}:", self.place.file.display())?;
            if let Some(line) = self.place.line {
                write!(f, "{line}:")?;
            }
            f.write_str(" ")?;
        }
        f.write_str(&self.text)
    }
}

impl SceneDescription {
    /// Checks that the loader neither approximated nor left out anything.
    ///
    /// # Errors
    /// The first note about something that it did.
    pub fn check_faithful(&self) -> Result<()> {
        let changes = |note: &&Note| note.kind > NoteKind::Decision;
        let Some(first) = self.notes.iter().find(changes) else {
            return Ok(());
        };
        let others = self.notes.iter().filter(changes).count() - 1;
        let others = match others {
            0 => String::new(),
            1 => ", and 1 more".to_owned(),
            more => format!(", and {more} more"),
        };
        let text = &first.text;
        Err(first
            .place
            .error(format!("{text} (not allowed in strict mode{others})")))
    }
}
