//! The cost of accuracy in a scene, measured within half a minute: the time to some errors, the sources of the error, and
//! what would make it cheaper.

pub mod answers;
pub mod cheaper;
mod clock;
pub mod report;
pub mod run;

pub use run::run;
