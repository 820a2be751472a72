//! The arguments of `price`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/price.rs`.

use super::MeasurementArguments;
use super::values::{named, parse_size};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::integrator::kind::IntegratorKind;
use std::time::Duration;

/// Arguments of `price`.
#[derive(Debug, Args)]
pub struct PriceArguments {
    /// The scene, the seed and the output.
    #[command(flatten)]
    pub measurement: MeasurementArguments,
    /// Total time of the measurement.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, default_value = "30s")]
    pub budget: Duration,
    /// Integrator to measure; auto for the one that suits the scene.
    #[arg(long, value_parser = named(IntegratorKind::ALL, IntegratorKind::name), default_value = IntegratorKind::Auto.name())]
    pub integrator: IntegratorKind,
    /// Image size in pixels for which the price is. Default: the scene's own.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
}
