//! The lab: measurements made with the renderer. Renderings compared with each other ([`study`]), ray tracing backends
//! compared on the rays of real renderings ([`mod@bench`]), difficult test cases with exact answers ([`battery`]), and the
//! course on Monte Carlo integration ([`lesson`]).
//!
//! The command `etendue` presents the results; the lab contains no code for pages or terminals. It uses the renderer's
//! internal modules, whose interface is not stable, and its own interface is not stable either.

pub mod battery;
pub mod bench;
pub mod course;
#[cfg(feature = "flip")]
pub mod flip;
pub mod lesson;
#[path = "../../src/planted.rs"]
mod planted;
pub mod plot;
pub mod price;
pub mod scene_builder;
pub mod study;
pub mod verdict;
