//! The cost of accuracy in a scene, measured within half a minute: the time to some errors, the sources of the error, and
//! what would make it cheaper.

pub mod answers;
pub mod cheaper;
pub mod report;
pub mod run;
mod watch;

pub use run::run;
