//! What renders tell when they stand side by side: the cost of an effect; plots of whatever was measured.

pub mod effect_cost;
pub mod plot;
