//! Backends side by side: rays of real renders are recorded and traced again by each of them, ray kind by ray kind.

pub mod build;
pub mod machine;
pub mod meter;
pub mod overhead;
pub mod parts;
pub mod record;
pub mod report;
mod run;
pub mod settings;
pub mod subject;
pub mod target;
pub mod trace;
mod work;

pub use run::run;
