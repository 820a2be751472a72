//! Etendue for C: opaque handles, plain structs, a status for each call and a message for each failure.
//!
//! Everything here uses the renderer's public interface. The header, `include/etendue.h`, is generated from this crate
//! by cbindgen, including its documentation (`make header`); `docs/c-api.md` is the guide to it.
//!
//! A handle is an integer in a pointer type, looked up in a table and never dereferenced (`handle.rs`), so that a
//! released or invalid handle is an error and not a crash. Only the access to the caller's memory (`memory.rs`) and the
//! calls of the caller's functions (`watch.rs`) are unsafe. No panic leaves the library (`border.rs`).
//!
//! Measure: world units; degrees, as in scene files; radiance.
//! Range: stated at each function; anything else is a status and a message.
//! Source: none needed. Tested by clients in C, C++ and Rust: `cli/tests/command/c_library.rs`.

mod border;
mod build;
mod compose;
mod describe;
mod handle;
mod memory;
mod query;
mod read;
mod render;
mod scene;
mod settings;
mod status;
mod version;
mod watch;
