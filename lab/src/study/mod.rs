//! Statistics of renders: the difference of two, the error against time of many, the cost of an effect.

pub mod answer;
pub mod bars;
pub mod bias;
pub mod bias_test;
pub mod bootstrap;
pub mod clock;
mod compared_renders;
pub mod comparison;
pub mod costs;
pub mod covariance;
mod difference;
pub mod effect_cost;
mod efficiency;
pub mod error_sources;
pub mod fit;
pub mod gram;
mod images;
pub mod law;
pub mod lengths;
pub mod own_size;
mod planning;
pub mod prepared_scene;
pub mod reference;
mod reference_renders;
pub mod report;
pub mod run;
pub mod runner;
pub mod scaling;
pub mod schedule;
pub mod settings;
pub mod shards;
pub mod shown_images;
mod standard_errors;
pub mod summary;
#[cfg(test)]
mod synthetic;
mod thread_gain;
pub mod tiles;
pub mod variance;
pub mod variant;

pub use run::run;
