//! How calls end.
//!
//! Measure: none.
//! Range: every failure of the renderer has a status.
//! Source: none needed.

use renderer::{Error, ErrorKind};
use std::ffi::{CStr, c_char};

/// How a call ended. What is not `ETD_STATUS_OK` or `ETD_STATUS_CANCELLED` is a failure: the call has changed nothing, unless it says so, and
/// the text of the handle that it was given says what was wrong.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdStatus {
    /// Done.
    Ok = 0,
    /// Ended early because that was asked for; what is there so far is kept.
    Cancelled = 1,
    /// An argument is null, out of its range, or makes no sense with the others.
    InvalidArgument = 2,
    /// The handle is null, was released, or is none of this library's.
    InvalidHandle = 3,
    /// The scene, a part of it, or a file that it names, is not valid.
    InvalidScene = 4,
    /// A file could not be read or written.
    InputOutput = 5,
    /// The ray tracing library, or the rendering itself, failed.
    RenderFailed = 6,
    /// There is not enough memory for what was asked.
    OutOfMemory = 7,
    /// The handle is in use by another call that excludes this one: a render that is under way.
    Busy = 8,
    /// The scene has not been committed yet.
    NotCommitted = 9,
    /// A mistake in the library itself, which is to be reported. The handle should be released.
    Internal = 10,
}

/// What a call does that goes wrong.
#[derive(Debug)]
pub struct Failure {
    pub status: EtdStatus,
    pub text: String,
}

/// How a call ends, short of a failure.
pub type Outcome = Result<EtdStatus, Failure>;

impl Failure {
    pub fn new(status: EtdStatus, text: impl Into<String>) -> Self {
        Self {
            status,
            text: text.into(),
        }
    }

    pub fn argument(text: impl Into<String>) -> Self {
        Self::new(EtdStatus::InvalidArgument, text)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match error.kind() {
            ErrorKind::Usage => EtdStatus::InvalidArgument,
            ErrorKind::Scene => EtdStatus::InvalidScene,
            ErrorKind::Io => EtdStatus::InputOutput,
            ErrorKind::Memory => EtdStatus::OutOfMemory,
            _ => EtdStatus::RenderFailed,
        };
        Self::new(status, error.to_string())
    }
}

fn words(status: i32) -> &'static CStr {
    match status {
        0 => c"done",
        1 => c"cancelled",
        2 => c"invalid argument",
        3 => c"invalid handle",
        4 => c"invalid scene",
        5 => c"input or output failed",
        6 => c"rendering failed",
        7 => c"out of memory",
        8 => c"busy",
        9 => c"the scene is not committed",
        10 => c"internal error",
        _ => c"no status of this library",
    }
}

/// A status in words: a text that is always there and never to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn etd_status_text(status: i32) -> *const c_char {
    words(status).as_ptr()
}
