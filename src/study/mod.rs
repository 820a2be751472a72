//! Experiments: renders side by side, and what they tell of time and accuracy.

pub mod effect_cost;
