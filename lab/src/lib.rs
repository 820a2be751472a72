//! The lab: what is measured with the renderer. Renders side by side ([`study`]), backends side by side on the rays of real
//! renders ([`bench`]), hard cases with exact answers ([`battery`]) and the course on Monte Carlo integration ([`lesson`]).
//!
//! The command `etendue` shows what it finds; it knows nothing of pages and terminals. It is made of the renderer's own parts,
//! of which no promise is kept, and makes none itself.

pub mod battery;
pub mod bench;
pub mod course;
#[cfg(feature = "flip")]
pub mod flip;
pub mod lesson;
#[path = "../../src/planted.rs"]
mod planted;
pub mod plot;
pub mod scene_builder;
pub mod study;
pub mod verdict;
