//! Tests of the bench: its scenes, its report, and the agreement of the backends.

#[path = "../../../tests/common/mod.rs"]
mod common;

mod agreement;
mod obvhs_itself;
mod report;
mod scenes;
