//! The measurements of a study, as written to `study.json`: all data from which its statistics are computed.
//!
//! Measure: seconds, samples per pixel, relMSE; stated at each field.
//! Range: a study that was interrupted has the results so far.
//! Source: docs/accuracy.md, "The study". Tested in `lab/tests/reports/study.rs`.

use super::bars::BarsReport;
use super::clock::Seconds;
use super::fit::TimeLaw;
use super::gram::Gram;
use super::lengths::BounceCost;
use super::own_size::OwnSize;
use super::reference::ReferenceNoise;
use super::scaling::Scaling;
use super::schedule::Schedule;
use super::shown_images::ShownImages;
use super::variance::PathShares;
use super::variant::VariantReport;
use etendue::internals::math::stats::Spread;
use etendue::internals::render::convergence::ErrorRecord;
use serde::Serialize;

/// The report of a whole study.
#[derive(Debug, Clone, Default, Serialize)]
pub struct StudyReport {
    /// Version of the program.
    pub version: &'static str,
    /// The scene's file.
    pub scene: String,
    /// Size of the image in the scene file.
    pub full_size: (u32, u32),
    /// Size of the rendered images.
    pub size: (u32, u32),
    /// Number of threads that rendered.
    pub threads: usize,
    /// Seed from which all others are derived.
    pub seed: u64,
    /// Requested seconds.
    pub budget: f64,
    /// Elapsed seconds.
    pub seconds: f64,
    /// Whether everything was measured.
    pub complete: bool,
    /// Warnings to the reader.
    pub warnings: Vec<String>,
    /// The planned renders.
    pub schedule: Option<Schedule>,
    /// The references.
    pub reference: Option<ReferenceReport>,
    /// The variants.
    pub variants: Vec<VariantStudy>,
    /// The time on another number of processors.
    pub scaling: Option<Scaling>,
    /// The cost of each effect of the scene.
    pub effects: Vec<EffectShare>,
    /// Images, which are not part of the JSON.
    #[serde(skip)]
    pub images: ShownImages,
}

/// The references.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceReport {
    /// Their integrator.
    pub integrator: &'static str,
    /// Their sampler.
    pub sampler: &'static str,
    /// Samples per pixel of each.
    pub spp: u64,
    /// The duration of each.
    pub seconds: [Seconds; 2],
    /// Their seeds.
    pub seeds: [u64; 2],
    /// Mean luminance of each.
    pub luminances: [f64; 2],
    /// The standard error of the mean luminance of both.
    pub luminance_error: f64,
    /// The noise of the references.
    pub noise: ReferenceNoise,
}

/// A variant with all of its renders.
#[derive(Debug, Clone, Serialize)]
pub struct VariantStudy {
    /// Its settings.
    pub variant: VariantReport,
    /// Seconds by samples, from the warm-up; [`super::summary`] fits all renders.
    pub warm_up: TimeLaw,
    /// Seconds by samples at the scene's own size, if another size was studied and this was measured.
    pub own_size: Option<OwnSize>,
    /// Seconds of building its structure.
    pub build: f64,
    /// Levels from few samples to many.
    pub levels: Vec<LevelReport>,
    /// Number of renders that were repeated, since other processes disturbed them.
    pub repeated: usize,
    /// Number of renders whose repetition was disturbed, too, or that could not be repeated for lack of time.
    pub disturbed: usize,
    /// The error as a render estimates it, from which the certainty follows that `--error` asks for.
    #[serde(rename = "look")]
    pub error_record: Option<ErrorRecord>,
    /// The reliability of its error bars.
    pub bars: Option<BarsReport>,
    /// The p-value of each tile's mean against that of the references.
    pub tile_p_values: Vec<f64>,
    /// The sources of the variance of a sample.
    pub paths: Option<PathShares>,
    /// The cost of each bounce.
    pub bounces: Vec<BounceCost>,
}

/// Renders of a variant with equal samples per pixel.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LevelReport {
    /// Samples per pixel.
    pub spp: u64,
    /// One render for each seed.
    pub runs: Vec<RunReport>,
    /// Their products against the references.
    pub gram: Gram,
}

/// One render.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RunReport {
    /// Its seed.
    pub seed: u64,
    /// Its position in the order of all renders.
    pub order: usize,
    /// Its duration; for a repeated render, that of the second run.
    pub seconds: Seconds,
    /// Whether the render was repeated.
    pub repeated: bool,
    /// relMSE: its product with itself.
    pub rel_mse: f64,
    /// relMSE without the largest 0.1 % of all pixels.
    pub trimmed: f64,
    /// Mean luminance.
    pub luminance: f64,
    /// Number of samples that were not finite.
    pub rejected: u64,
}

/// The cost of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EffectShare {
    /// The effect.
    pub effect: &'static str,
    /// 1 - time without / time with.
    pub time: Spread,
    /// 1 - luminance without / luminance with, and its standard error.
    pub energy: [f64; 2],
    /// The half width of the interval of the latter share with a confidence of 95 %.
    pub energy_margin: f64,
}

impl StudyReport {
    /// Adds a warning, unless the report has it already.
    pub fn warn(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
}
