//! The coverage of error bars, and the true errors of renders to a requested error.
//!
//! Measure: shares of intervals; true errors as multiples of the requested ones.
//! Range: films of at least four samples per pixel; references known much better than the images compared with them.
//! Source: docs/accuracy.md, "Error bars". A share of intervals is a binomial variable.

use super::scene::film;
use etendue::internals::film::Film;
use etendue::internals::film::error_bars::ErrorBars;
use etendue::internals::film::filter::Filter;
use etendue::internals::image::metrics::rel_mse;
use etendue::internals::integrator::reuse::PathReuse;
use etendue::internals::render::settings::{
    Budget, ErrorTarget, PathReuseRule, RenderSettings, SamplerKind,
};
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use std::fmt;

/// Confidence levels, and the tolerance of the coverage at each. Coverage is least accurate at the lowest level: rare bright
/// samples leave most pixels a little too dark.
const LEVELS: [(f64, f64); 5] = [
    (0.5, 0.08),
    (0.8, 0.045),
    (0.9, 0.025),
    (0.95, 0.015),
    (0.99, 0.012),
];

/// The tolerance of the coverage of few intervals, in standard deviations: each of the five levels exceeds it by chance once in
/// a thousand.
const SIGMAS: f64 = 3.3;

/// The settings of a render with `spp` samples per pixel.
pub fn settings(
    scene: &SceneDescription,
    sampler: SamplerKind,
    seed: u64,
    spp: u64,
) -> RenderSettings {
    RenderSettings {
        sampler,
        seed,
        ..RenderSettings::new(scene.film.size, spp)
    }
}

/// The settings of a reference about as accurate as `spp` samples per pixel of `path` alone in a room of rough surfaces: groups of
/// 16 pixels share their paths, which lowers the variance of a sample about eight times there (docs/accuracy.md).
pub fn reference_settings(scene: &SceneDescription, spp: u64) -> RenderSettings {
    RenderSettings {
        reuse: PathReuseRule::Pixels(PathReuse::Sixteen),
        ..settings(scene, SamplerKind::Sobol, 1000, spp / 8)
    }
}

/// Counts of intervals that contain the true value, of unflagged pixels and of flagged ones.
#[derive(Default)]
pub struct Coverage {
    held: [[u64; LEVELS.len()]; 2],
    counts: [u64; 2],
}

impl Coverage {
    /// Counts the green channel of every pixel of a film, given its expectation.
    pub fn add(&mut self, film: &Film, truth: impl Fn(usize) -> f64) {
        let picture = film.develop();
        let green = |index: usize| f64::from(picture.pixels()[index].to_array()[1]);
        self.add_bars(
            &film.error_bars(),
            |index| (green(index), truth(index)),
            1.0,
        );
    }

    /// Counts the green channel of every pixel, given its value and the reference's; the noise of the reference widens the
    /// distribution of their difference by the factor `widening`.
    fn add_bars(&mut self, bars: &ErrorBars, green: impl Fn(usize) -> (f64, f64), widening: f64) {
        for (index, error) in bars.standard_errors.pixels().iter().enumerate() {
            let (x, truth) = green(index);
            let se = f64::from(error.to_array()[1]);
            let off = (x - truth).abs() / widening;
            if se == 0.0 && off == 0.0 {
                // A pixel that is exactly right with a standard error of 0, such as black, says nothing of the intervals.
                continue;
            }
            let kind = usize::from(bars.flags[index]);
            self.counts[kind] += 1;
            for (held, (level, _)) in self.held[kind].iter_mut().zip(LEVELS) {
                // Plus rounding to single precision.
                let half_width = bars.quantile(index, level) * se + 2e-7 * x.abs();
                *held += u64::from(off <= half_width);
            }
        }
    }

    /// Renders images of several seeds, at least two, and compares each with the mean of the others.
    pub fn add_images_against_others(
        &mut self,
        (scene, description): (&Scene, &SceneDescription),
        settings: &RenderSettings,
        seeds: u64,
    ) {
        let renders: Vec<(ErrorBars, Vec<f64>)> = (0..seeds)
            .map(|seed| {
                let film = film(scene, description, &RenderSettings { seed, ..*settings });
                let picture = film.develop();
                let pixels = picture.pixels().iter();
                let green = pixels.map(|it| f64::from(it.to_array()[1])).collect();
                (film.error_bars(), green)
            })
            .collect();
        let sum = |index: usize| renders.iter().map(|(_, green)| green[index]).sum::<f64>();
        let sums: Vec<f64> = (0..renders[0].1.len()).map(sum).collect();
        let others = (seeds - 1) as f64;
        for (bars, green) in &renders {
            let pair = |index: usize| (green[index], (sums[index] - green[index]) / others);
            self.add_bars(bars, pair, (1.0 + others.recip()).sqrt());
        }
    }

    /// Renders images of several seeds and counts their pixels, given their expectation.
    pub fn add_images(
        &mut self,
        (scene, description): (&Scene, &SceneDescription),
        settings: &RenderSettings,
        seeds: u64,
        truth: impl Fn(usize) -> f64,
    ) {
        for seed in 0..seeds {
            let settings = RenderSettings { seed, ..*settings };
            self.add(&film(scene, description, &settings), &truth);
        }
    }

    fn share(&self, kind: usize, level: usize) -> f64 {
        self.held[kind][level] as f64 / self.counts[kind].max(1) as f64
    }

    /// The share of flagged pixels, whose bars are not reliable.
    pub fn flagged(&self) -> f64 {
        self.counts[1] as f64 / (self.counts[0] + self.counts[1]) as f64
    }

    /// The first confidence level at which the coverage of unflagged pixels is out of tolerance, or none; the tolerance includes
    /// the statistical fluctuation of so few intervals.
    pub fn miscalibrated(&self) -> Option<String> {
        let count = self.counts[0] as f64;
        let is_off = |(level, (confidence, tolerance)): &(usize, (f64, f64))| {
            let sigma = (confidence * (1.0 - confidence) / count).sqrt();
            let off = (self.share(0, *level) - confidence).abs();
            count > 0.0 && off > tolerance.max(SIGMAS * sigma)
        };
        let (level, (confidence, _)) = LEVELS.into_iter().enumerate().find(is_off)?;
        let share = self.share(0, level);
        Some(format!("{share} of {count} intervals at {confidence}"))
    }
}

/// A row of a table: the shares in percent of unflagged intervals at each level, the share flagged, and that of flagged
/// intervals at 95 %.
impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |kind, level| match self.counts[kind] {
            0 => String::new(),
            _ => format!("{:.1}", 100.0 * self.share(kind, level)),
        };
        for level in 0..LEVELS.len() {
            write!(f, " {} |", percent(0, level))?;
        }
        write!(f, " {:.1} | {} |", 100.0 * self.flagged(), percent(1, 3))
    }
}

/// Statistics of the true errors of renders to a requested error.
#[derive(Default)]
pub struct TargetsReached {
    /// The number of renders.
    pub renders: u64,
    /// Renders whose true error was at most the requested one.
    pub kept: u64,
    sum: f64,
    /// The sum of their samples per pixel.
    spp: u64,
    /// Renders whose sample count was predicted within a factor of [`FORESEEN`].
    foreseen: u64,
    /// Renders with a prediction that came early enough to count.
    predicted: u64,
}

/// The factor within which a predicted sample count is correct.
const FORESEEN: f64 = 1.25;

/// The share of a render's samples before which a prediction has to come to count.
const MAX_PILOT: f64 = 0.9;

impl TargetsReached {
    /// Renders with these settings and several seeds until the error is `rel_rmse`, and compares with the reference, whose own
    /// squared error is subtracted.
    pub fn of(
        (scene, description): (&Scene, &SceneDescription),
        (settings, rel_rmse): (&RenderSettings, f64),
        renders: u64,
        truth: &Film,
    ) -> Self {
        let of_truth = truth.error(0.95).expect("it has samples").rel_rmse;
        let truth = truth.develop();
        let filter = Filter::new(&description.film.filter);
        let error = ErrorTarget {
            rel_rmse,
            confidence: 0.95,
        };
        let mut this = Self::default();
        for seed in 0..renders {
            let settings = RenderSettings {
                seed,
                budget: Budget {
                    error: Some(error),
                    ..Budget::default()
                },
                ..*settings
            };
            let size = description.film.size;
            let rendered = render(scene, &filter, size, &settings, &NullRenderObserver);
            let rendered = rendered.expect("the settings are valid");
            assert!(rendered.reached);
            let apart = rel_mse(&rendered.film.develop(), &truth).expect("the same size");
            let share = (apart - of_truth * of_truth).max(0.0).sqrt() / rel_rmse;
            this.renders += 1;
            this.kept += u64::from(share <= 1.0);
            this.sum += share;
            this.spp += rendered.spp;
            let is_early = |pilot: u64| (pilot as f64) < MAX_PILOT * rendered.spp as f64;
            if let Some(predicted) = rendered.predicted.filter(|it| is_early(it.pilot)) {
                let off = (predicted.spp as f64 / rendered.spp as f64).ln().abs();
                this.predicted += 1;
                this.foreseen += u64::from(off <= FORESEEN.ln());
            }
        }
        this
    }

    /// The mean of the true errors, as a share of the requested one.
    pub fn mean(&self) -> f64 {
        self.sum / self.renders as f64
    }

    /// The mean of their samples per pixel.
    pub fn mean_spp(&self) -> f64 {
        self.spp as f64 / self.renders as f64
    }

    /// Whether the number of predictions within a factor of 1.25 is plausible if each of them is with the probability `rate`: a
    /// smaller number than accepted has a probability of 0.001 then (normal approximation).
    pub fn are_foreseen_at(&self, rate: f64) -> bool {
        let count = self.predicted as f64;
        self.foreseen as f64 >= rate * count - 3.1 * (rate * (1.0 - rate) * count).sqrt()
    }
}

/// A row of a table.
impl fmt::Display for TargetsReached {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kept, renders, .. } = self;
        let (mean, spp) = (self.mean(), self.mean_spp());
        let (foreseen, predicted) = (self.foreseen, self.predicted);
        write!(
            f,
            " {spp:.0} | {kept} of {renders} | {mean:.2} | {foreseen} of {predicted} |"
        )
    }
}
