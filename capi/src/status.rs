//! Status codes and failures.
//!
//! Measure: none.
//! Range: every failure of the renderer has a status.
//! Source: none needed.

use renderer::{Error, ErrorKind};
use std::ffi::{CStr, c_char};

/// The result of a call. All values but `ETD_STATUS_OK` and `ETD_STATUS_CANCELLED` are failures: the call has changed
/// nothing, unless stated otherwise, and the message is stored with the handle that was passed.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdStatus {
    /// Success.
    Ok = 0,
    /// Cancelled on request; the samples so far are kept.
    Cancelled = 1,
    /// An argument is null, out of range, or inconsistent with the others.
    InvalidArgument = 2,
    /// The handle is null, was released, or does not belong to this library.
    InvalidHandle = 3,
    /// The scene, a part of it, or a file that it refers to, is invalid.
    InvalidScene = 4,
    /// A file could not be read or written.
    InputOutput = 5,
    /// The ray tracing library, or the rendering itself, failed.
    RenderFailed = 6,
    /// A request for more memory than there is.
    OutOfMemory = 7,
    /// The handle is in use by another call that excludes this one, such as a running render.
    Busy = 8,
    /// The scene has not been committed.
    NotCommitted = 9,
    /// A bug in the library, which should be reported. The handle should be released.
    Internal = 10,
}

/// The status and the message of a failed call.
#[derive(Debug)]
pub struct Failure {
    pub status: EtdStatus,
    pub text: String,
}

/// The result of a call.
pub type CallResult = Result<EtdStatus, Failure>;

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
        _ => c"unknown status",
    }
}

/// Returns the description of a status: a static string, never to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn etd_status_text(status: i32) -> *const c_char {
    words(status).as_ptr()
}
