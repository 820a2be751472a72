//! Comparison of backends: rays of real renders are recorded and traced again by each backend, ray kind by ray kind.

pub mod agreement;
pub mod build;
pub mod closed;
pub mod comparison;
pub mod cornell_box;
pub mod hit_interval;
pub mod leaks;
pub mod machine;
pub mod meter;
pub mod obvhs_itself;
pub mod overhead;
pub mod parts;
pub mod random;
pub mod rays;
pub mod record;
pub mod report;
mod run;
pub mod scenes;
pub mod settings;
pub mod subject;
pub mod target;
pub mod trace;
mod work;

pub use run::run;
