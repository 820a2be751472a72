//! The arguments of `study`.
//!
//! Measure: stated at each flag.
//! Range: stated at each flag; a value outside it is a usage error that names the flag.
//! Source: the conventions of `etendue help`. Tested in `cli/tests/command/study.rs` and below.

use super::MeasurementArguments;
use super::values::{parse_bounces, parse_shard, parse_size};
use crate::durations::parse_duration;
use clap::Args;
use etendue::internals::accel::{Backend, Precision};
use etendue::internals::effects::Kernel;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::{LightPathRule, PathReuseRule, SamplerKind};
use etendue::internals::scene::load::unknown_name;
use etendue::internals::state::Shard;
use etendue_lab::study::shards::MAX_SHARDS;
use etendue_lab::study::variant::SettingValue;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `study`.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// The scene, the seed and the output.
    #[command(flatten)]
    pub measurement: MeasurementArguments,
    /// Settings to compare, such as integrator=path,nee sampler=sobol,independent. Default: sampler=independent,sobol.
    ///
    /// Every combination of the values is rendered, but for those that no render can have. The settings are integrator, sampler, precision, backend,
    /// light-paths, reuse, kernel and max-bounces (a number, or none). Ratios are relative to the first combination
    /// in which no bias is found, or else to the first.
    #[arg(long, value_name = "SETTING=A,B", num_args = 1.., value_parser = parse_varied)]
    pub vary: Vec<Varied>,
    /// Total time of the study; with --shards, of each shard.
    #[arg(long, value_name = "DURATION", value_parser = parse_duration, default_value = "5m")]
    pub budget: Duration,
    /// Integrator of the reference renders: path, bdpt or mlt, whichever converges best for the scene.
    #[arg(long, value_name = "INTEGRATOR", value_parser = parse_reference, default_value = "path")]
    pub reference: IntegratorKind,
    /// Image size of the renders in pixels. Default: the scene's own, or a smaller one if the budget is too short for it.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// Render at the scene's own size, however short the budget.
    #[arg(long, conflicts_with = "size")]
    pub full_size: bool,
    /// Also predict times for this number of threads, by the measured gain from one thread to all of this machine.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub for_threads: Option<u32>,
    /// Plan a study of N shards for as many machines, and write the plan to the output folder, which they share.
    ///
    /// Each shard is then rendered by the command with --shard in place of --shards, and they are merged by the one
    /// with --merge.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=MAX_SHARDS as i64))]
    pub shards: Option<u32>,
    /// Render a shard of the study that is planned in the output folder: K/N, counted from 0.
    #[arg(long, value_name = "K/N", value_parser = parse_shard, conflicts_with = "shards")]
    pub shard: Option<Shard>,
    /// Merge the shards in the output folder to the report.
    #[arg(long, conflicts_with_all = ["shards", "shard"])]
    pub merge: bool,
    /// Merge the shards that are there, although others are missing.
    #[arg(long, requires = "merge")]
    pub partial: bool,
    /// Output folder for study.html, study.md, study.json and study.csv; created if missing.
    #[arg(short, long = "out", value_name = "DIR", default_value = "out/study")]
    pub out: PathBuf,
}

/// The values of one setting.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Varied(pub Vec<SettingValue>);

/// The settings that can be varied.
const SETTINGS: [&str; 8] = [
    "integrator",
    "sampler",
    "precision",
    "backend",
    "light-paths",
    "reuse",
    "kernel",
    "max-bounces",
];

/// The integrators that may render references: those of full light transport.
const REFERENCES: [IntegratorKind; 3] = [
    IntegratorKind::Path,
    IntegratorKind::Bidirectional,
    IntegratorKind::Metropolis,
];

fn parse_reference(text: &str) -> Result<IntegratorKind, String> {
    named(text, &REFERENCES, IntegratorKind::name)
}

fn parse_varied(text: &str) -> Result<Varied, String> {
    let (setting, values) = text
        .split_once('=')
        .ok_or_else(|| format!("expected SETTING=A,B with one of {}", SETTINGS.join(", ")))?;
    let choices = values.split(',').map(|value| choice(setting, value.trim()));
    choices.collect::<Result<_, _>>().map(Varied)
}

fn choice(setting: &str, value: &str) -> Result<SettingValue, String> {
    match setting {
        "integrator" => {
            named(value, IntegratorKind::ALL, IntegratorKind::name).map(SettingValue::Integrator)
        }
        "sampler" => named(value, SamplerKind::ALL, SamplerKind::name).map(SettingValue::Sampler),
        "precision" => {
            let all = [Precision::Robust, Precision::Fast];
            named(value, &all, Precision::name).map(SettingValue::Precision)
        }
        "backend" => named(value, Backend::ALL, Backend::name).map(SettingValue::Backend),
        "light-paths" => {
            named(value, LightPathRule::ALL, LightPathRule::name).map(SettingValue::LightPaths)
        }
        "reuse" => named(value, PathReuseRule::ALL, PathReuseRule::name).map(SettingValue::Reuse),
        "kernel" => named(value, Kernel::ALL, Kernel::name).map(SettingValue::Kernel),
        "max-bounces" => {
            let limit = parse_bounces(value)?;
            Ok(SettingValue::MaxBounces(limit.max_bounces()))
        }
        _ => Err(unknown_name("setting", setting, &SETTINGS)),
    }
}

fn named<T: Copy>(value: &str, all: &[T], name: impl Fn(T) -> &'static str) -> Result<T, String> {
    let found = all.iter().copied().find(|&one| name(one) == value);
    found.ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|&one| name(one)).collect();
        unknown_name("value", value, &names)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::integrator::reuse::PathReuse;

    #[test]
    fn varied_settings_are_parsed() {
        let read = parse_varied("integrator=path, nee").expect("two integrators");
        let expected = [IntegratorKind::Path, IntegratorKind::NextEvent];
        assert_eq!(read.0, expected.map(SettingValue::Integrator));
        let read = parse_varied("reuse=auto,off").expect("two rules");
        let off = PathReuseRule::Pixels(PathReuse::Off);
        assert_eq!(read.0, [PathReuseRule::Auto, off].map(SettingValue::Reuse));
        let read = parse_varied("max-bounces=1,none").expect("two limits");
        assert_eq!(
            read.0,
            [
                SettingValue::MaxBounces(Some(1)),
                SettingValue::MaxBounces(None)
            ]
        );
    }

    #[test]
    fn invalid_varied_settings_are_rejected_with_a_hint() {
        for (wrong, word) in [
            ("integrator", "SETTING=A,B"),
            ("integrater=path", "integrator"),
            ("sampler=sobel", "sobol"),
            ("max-bounces=-1", "whole number"),
            ("sampler=", "sobol"),
        ] {
            let message = parse_varied(wrong).expect_err("wrong");
            assert!(message.contains(word), "{wrong}: {message}");
        }
    }
}
