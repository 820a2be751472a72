//! Etendue for C: opaque handles, plain structs, a status for each call and a text for each failure.
//!
//! Everything here goes through the renderer's public interface. The header, `include/etendue.h`, is made of this crate by
//! cbindgen, with the documentation in it (`make header`); `docs/c-api.md` is the guide to it.
//!
//! A handle is a number in the clothes of a pointer, looked up in a table and never followed (`handle.rs`), so that a handle
//! that was released, or never was one, is an error and not a crash. Unsafe are only the reading and writing of what callers
//! point to (`memory.rs`) and the calls of their functions (`watch.rs`). No panic leaves the library (`border.rs`).
//!
//! Measure: world units; degrees, as in scene files; radiance.
//! Range: what each function says; anything else is a status and a text.
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
