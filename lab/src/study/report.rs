//! What a study measured, as it is written to `study.json`: all that its statistics follow from.
//!
//! Measure: seconds, samples per pixel, relMSE; said at each field.
//! Range: a study that was interrupted has what was done by then.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::bars::BarsReport;
use super::clock::Seconds;
use super::fit::TimeLaw;
use super::gram::Gram;
use super::lengths::BounceCost;
use super::pictures::Pictures;
use super::reference::ReferenceNoise;
use super::schedule::Schedule;
use super::variance::PathShares;
use super::variant::VariantReport;
use etendue::internals::math::stats::Spread;
use serde::Serialize;

/// All of a study.
#[derive(Debug, Clone, Default, Serialize)]
pub struct StudyReport {
    /// Of the program.
    pub version: &'static str,
    /// The scene's file.
    pub scene: String,
    /// Its picture, as the scene has it.
    pub full_size: (u32, u32),
    /// The picture that was rendered.
    pub size: (u32, u32),
    /// Threads that rendered.
    pub threads: usize,
    /// All seeds follow from it.
    pub seed: u64,
    /// Seconds that were asked for.
    pub budget: f64,
    /// Seconds that all of it took.
    pub seconds: f64,
    /// Whether everything was measured.
    pub complete: bool,
    /// What a reader has to know.
    pub warnings: Vec<String>,
    /// What was to be rendered.
    pub schedule: Option<Schedule>,
    /// What everything is held against.
    pub reference: Option<ReferenceReport>,
    /// What is compared.
    pub variants: Vec<VariantStudy>,
    /// What each effect of the scene costs.
    pub effects: Vec<EffectShare>,
    /// Pictures, which JSON does not have.
    #[serde(skip)]
    pub pictures: Pictures,
}

/// The references.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceReport {
    /// Their estimator.
    pub integrator: &'static str,
    /// Where their random numbers come from.
    pub sampler: &'static str,
    /// Samples per pixel of each.
    pub spp: u64,
    /// What each took.
    pub seconds: [Seconds; 2],
    /// Their seeds.
    pub seeds: [u64; 2],
    /// Mean luminance of each.
    pub luminances: [f64; 2],
    /// The standard error of the mean of both.
    pub luminance_error: f64,
    /// How far from the truth they are.
    pub noise: ReferenceNoise,
}

/// A variant, and all of its renders.
#[derive(Debug, Clone, Serialize)]
pub struct VariantStudy {
    /// How it renders.
    pub variant: VariantReport,
    /// Seconds by samples, as the warm-up told; [`super::summary`] has what all renders tell.
    pub warm_up: TimeLaw,
    /// Seconds that building its structure took.
    pub build: f64,
    /// From few samples to many.
    pub levels: Vec<LevelReport>,
    /// Renders that were repeated, since something else took a processor.
    pub repeated: usize,
    /// Renders that were disturbed, too, and for whose repetition there was no time.
    pub disturbed: usize,
    /// Whether its error bars hold what they say.
    pub bars: Option<BarsReport>,
    /// The probability of a tile's mean being as far from the references' by chance, for each tile.
    pub tile_p_values: Vec<f64>,
    /// Where the variance of a sample comes from.
    pub paths: Option<PathShares>,
    /// What each bounce costs.
    pub bounces: Vec<BounceCost>,
}

/// Renders of a variant with so many samples per pixel.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LevelReport {
    /// Samples per pixel.
    pub spp: u64,
    /// One for each seed.
    pub runs: Vec<RunReport>,
    /// Their products against the references.
    pub gram: Gram,
}

/// One render.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RunReport {
    /// Its seed.
    pub seed: u64,
    /// When it began, in the order of all.
    pub order: usize,
    /// What it took; of one that was repeated, the second time.
    pub seconds: Seconds,
    /// Whether it was repeated.
    pub repeated: bool,
    /// relMSE: what its product with itself is.
    pub rel_mse: f64,
    /// relMSE without the largest 0.1 % of all pixels.
    pub trimmed: f64,
    /// Mean luminance.
    pub luminance: f64,
    /// Samples that were not finite.
    pub rejected: u64,
}

/// What an effect costs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EffectShare {
    /// The effect.
    pub effect: &'static str,
    /// 1 - time without / time with.
    pub time: Spread,
    /// 1 - luminance without / luminance with, and its standard error.
    pub energy: [f64; 2],
}

impl StudyReport {
    /// A study of which nothing is measured yet.
    pub fn warn(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
}
