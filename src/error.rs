//! The error type of the library: a kind, a message, and the location.
//!
//! Measure: none; `line` counts from 1.
//! Range: every failure that input, files or Embree can cause is an `Error`; only broken internal invariants panic.
//! Source: one opaque error with a kind and a cause, so that callers match on the kind only and messages can change.
//! Tested below and, through the command, in `cli/tests/command/bad_input.rs`.

use std::fmt;
use std::path::{Path, PathBuf};

/// `Result` with our [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// The kind of a failure; the command maps it to its exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An invalid request: a wrong flag, or a setting out of its range.
    Usage,
    /// A scene, or a file that it names, is not valid.
    Scene,
    /// A file could not be read or written.
    Io,
    /// Embree, or the rendering itself, failed.
    Render,
    /// A request for more memory than there is.
    Memory,
}

/// A failure: its kind, a message, the location in a file if there is one, and the underlying cause.
pub struct Error(Box<Inner>);

struct Inner {
    kind: ErrorKind,
    message: String,
    file: Option<PathBuf>,
    line: Option<usize>,
    field: Option<String>,
    source: Option<Box<dyn std::error::Error + Send + Sync>>,
}

impl Error {
    /// Creates a failure of the given kind. `message` states what was found and what was expected.
    #[cold]
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self(Box::new(Inner {
            kind,
            message: message.into(),
            file: None,
            line: None,
            field: None,
            source: None,
        }))
    }

    /// An invalid setting or flag.
    #[cold]
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Usage, message)
    }

    /// An invalid scene or an invalid file that it names.
    #[cold]
    pub fn scene(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Scene, message)
    }

    /// A failure of Embree or of the rendering.
    #[cold]
    pub fn render(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Render, message)
    }

    /// A file that could not be read or written; `action` names the failed action, such as "cannot read".
    #[cold]
    pub fn io(action: &str, path: &Path, source: std::io::Error) -> Self {
        Self::new(ErrorKind::Io, format!("{action}: {source}"))
            .in_file(path)
            .because(source)
    }

    /// Sets the file, unless one is already set by an inner location.
    pub fn in_file(mut self, file: impl AsRef<Path>) -> Self {
        self.0
            .file
            .get_or_insert_with(|| file.as_ref().to_path_buf());
        self
    }

    /// Sets the line, counted from 1, unless one is already set.
    pub fn at_line(mut self, line: usize) -> Self {
        self.0.line.get_or_insert(line);
        self
    }

    /// Sets the field or flag, such as `shape[2].radius`, unless one is already set.
    pub fn in_field(mut self, field: impl Into<String>) -> Self {
        self.0.field.get_or_insert_with(|| field.into());
        self
    }

    /// Sets the cause, for callers that walk the chain of sources.
    pub fn because(mut self, source: impl std::error::Error + Send + Sync + 'static) -> Self {
        self.0.source = Some(Box::new(source));
        self
    }

    /// Changes the kind: to that of the cause, where a file is invalid because of another file that it names.
    pub fn of_kind(mut self, kind: ErrorKind) -> Self {
        self.0.kind = kind;
        self
    }

    /// The kind of failure.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// The file concerned, if the failure is about one.
    pub fn file(&self) -> Option<&Path> {
        self.0.file.as_deref()
    }

    /// The line concerned, counted from 1.
    pub fn line(&self) -> Option<usize> {
        self.0.line
    }
}

/// Prints `file:line: field: message` without the unknown parts, as `Display` does, because Rust prints the `Debug`
/// form of an error returned by `main`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let inner = &self.0;
        if let Some(file) = &inner.file {
            write!(f, "{}:", file.display())?;
            if let Some(line) = inner.line {
                write!(f, "{line}:")?;
            }
            f.write_str(" ")?;
        }
        if let Some(field) = &inner.field {
            write!(f, "{field}: ")?;
        }
        f.write_str(&inner.message)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source.as_deref().map(|source| source as _)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_location_precedes_message_and_innermost_is_kept() {
        let error = Error::scene("expected a number")
            .in_field("shape[2].radius")
            .at_line(7)
            .in_file("a.toml")
            .at_line(1)
            .in_file("b.toml");
        assert_eq!(
            error.to_string(),
            "a.toml:7: shape[2].radius: expected a number"
        );
        assert_eq!(format!("{error:?}"), error.to_string());
        assert_eq!(error.kind(), ErrorKind::Scene);
    }

    #[test]
    fn io_error_keeps_its_source() {
        let cause = std::io::Error::other("disk on fire");
        let error = Error::io("cannot write", Path::new("out.exr"), cause);
        assert!(std::error::Error::source(&error).is_some());
        assert_eq!(error.to_string(), "out.exr: cannot write: disk on fire");
    }
}
