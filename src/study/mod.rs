//! What renders tell when they stand side by side: how far they are apart; the cost of an effect; plots of whatever was
//! measured.

pub mod comparison;
pub mod effect_cost;
pub mod plot;
