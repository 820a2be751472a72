//! The version of the library.
//!
//! Measure: none.
//! Range: none.
//! Source: semantic versioning.

use std::ffi::{CStr, c_char};

const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => panic!("a version has no NUL byte"),
    };

/// Returns the version of the library at run time, such as "0.1.0": a static string, never to be freed. A program built
/// with the header of one version runs with every later one of the same major version; while that is 0, of the same
/// minor version.
#[unsafe(no_mangle)]
pub extern "C" fn etd_version() -> *const c_char {
    VERSION.as_ptr()
}
