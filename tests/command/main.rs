//! The command, as its users call it.
#![cfg(feature = "cli")]

#[path = "../common/mod.rs"]
mod common;

mod adaptive;
mod auto;
mod bad_flags;
mod battery;
mod bench;
#[cfg(feature = "embree")]
mod c_library;
mod compare;
mod denoise;
mod denoise_oidn;
mod layers;
mod lesson;
mod non_finite;
mod plan;
mod render;
mod study;
