//! The named choices of a render's settings: the sampler, the limit of bounces, light paths beside `path`, shared paths, and
//! the distribution of samples.
//!
//! Measure: none.
//! Range: the listed choices; an unknown name is an error of the scene file or of the command line.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_flags.rs`.

use crate::integrator::light_paths::LightPathShare;
use crate::integrator::reuse::PathReuse;
use serde::Serialize;
use std::fmt;

/// The source of random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub enum SamplerKind {
    /// Independent numbers.
    Independent,
    /// Jittered strata, for the requested number of samples.
    Stratified,
    /// Owen-scrambled Sobol' points.
    #[default]
    Sobol,
}

impl SamplerKind {
    /// Every sampler.
    pub const ALL: &'static [Self] = &[Self::Sobol, Self::Stratified, Self::Independent];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::Sobol => "sobol",
        }
    }
}

/// The limit of the scattering events of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BounceLimit {
    /// At most this number.
    AtMost(u32),
    /// Any number, also where the scene has a limit.
    Unlimited,
}

impl BounceLimit {
    /// The largest number of scattering events; `None` without a limit.
    pub fn max_bounces(self) -> Option<u32> {
        match self {
            Self::AtMost(limit) => Some(limit),
            Self::Unlimited => None,
        }
    }
}

impl fmt::Display for BounceLimit {
    /// As on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(limit) => limit.fmt(f),
            Self::Unlimited => f.write_str("none"),
        }
    }
}

/// The number of light paths for each camera path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum LightPathRule {
    /// A number that a pilot chooses for the scene.
    #[default]
    Auto,
    /// A fixed number.
    Share(LightPathShare),
    /// A fixed number, which are connected to the lens only beyond a glossy or smooth surface.
    Caustics(LightPathShare),
}

impl LightPathRule {
    /// No light paths.
    pub const OFF: Self = Self::Share(LightPathShare::None);

    /// Every rule.
    pub const ALL: &'static [Self] = &[
        Self::Auto,
        Self::OFF,
        Self::Share(LightPathShare::Quarter),
        Self::Share(LightPathShare::Half),
        Self::Share(LightPathShare::One),
        Self::Share(LightPathShare::Two),
        Self::Caustics(LightPathShare::Quarter),
        Self::Caustics(LightPathShare::Half),
        Self::Caustics(LightPathShare::One),
        Self::Caustics(LightPathShare::Two),
    ];

    /// The number of light paths for each camera path; none by `auto`.
    pub fn share(self) -> LightPathShare {
        match self {
            Self::Auto => LightPathShare::None,
            Self::Share(share) | Self::Caustics(share) => share,
        }
    }

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Share(share) => share.name(),
            Self::Caustics(share) => match share {
                LightPathShare::None => share.name(),
                LightPathShare::Quarter => "caustics:1/4",
                LightPathShare::Half => "caustics:1/2",
                LightPathShare::One => "caustics:1",
                LightPathShare::Two => "caustics:2",
            },
        }
    }
}

/// The number of pixels that share their paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum PathReuseRule {
    /// A number that a pilot chooses for the scene.
    #[default]
    Auto,
    /// A fixed number.
    Pixels(PathReuse),
}

impl PathReuseRule {
    /// Every rule.
    pub const ALL: &'static [Self] = &[
        Self::Auto,
        Self::Pixels(PathReuse::Off),
        Self::Pixels(PathReuse::Four),
        Self::Pixels(PathReuse::Sixteen),
    ];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Pixels(reuse) => reuse.name(),
        }
    }

    /// Whether the rule names a number of pixels that share paths.
    pub fn is_requested(self) -> bool {
        matches!(self, Self::Pixels(reuse) if reuse.is_on())
    }
}

/// The distribution of samples over the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub enum Adaptive {
    /// Equal counts for all pixels.
    #[default]
    Off,
    /// Two-phase sampling: counts by the errors that a pilot estimates, without bias.
    TwoPhase,
    /// Greedy sampling: each pixel until its own samples seem good enough. Biased.
    Greedy,
}

impl Adaptive {
    /// Every distribution.
    pub const ALL: &'static [Self] = &[Self::TwoPhase, Self::Greedy, Self::Off];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::TwoPhase => "two-phase",
            Self::Greedy => "greedy",
        }
    }

    /// The bias of the image, in words.
    pub fn bias(self) -> Option<String> {
        (self == Self::Greedy).then(|| {
            "greedy adaptive sampling: a pixel stops when its own samples are similar, even if by chance"
                .to_owned()
        })
    }
}
