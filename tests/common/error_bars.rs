//! How often error bars hold the truth, and whether renders keep the error that they were asked for.
//!
//! Measure: shares of intervals; true errors as multiples of those asked for.
//! Range: films of four samples a pixel at least; truths known much better than the pictures that are held against them.
//! Source: docs/accuracy.md, "Error bars". A share of intervals is a binomial number.

use super::scene::film;
use etendue::internals::film::Film;
use etendue::internals::film::bars::ErrorBars;
use etendue::internals::film::filter::Filter;
use etendue::internals::image::metrics::rel_mse;
use etendue::internals::render::settings::{Budget, ErrorTarget, RenderSettings, SamplerKind};
use etendue::internals::render::{Unwatched, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use std::fmt;

/// Confidences, and how far the share of intervals that hold the truth may be from each. The middle of an interval is told
/// worst: rare bright samples leave most pixels a little too dark.
const LEVELS: [(f64, f64); 5] = [
    (0.5, 0.08),
    (0.8, 0.045),
    (0.9, 0.025),
    (0.95, 0.015),
    (0.99, 0.012),
];

/// Standard deviations that the share of a few intervals may be off by: each of the five levels by chance once in a thousand.
const SIGMAS: f64 = 3.3;

/// Settings for so many samples.
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

/// Counts of intervals that hold the truth, of unflagged pixels and of flagged ones.
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

    /// Counts the green channel of every pixel, given its value and the truth's, whose own noise makes their difference so many
    /// times as wide.
    fn add_bars(&mut self, bars: &ErrorBars, green: impl Fn(usize) -> (f64, f64), widening: f64) {
        for (index, error) in bars.standard_errors.pixels().iter().enumerate() {
            let (x, truth) = green(index);
            let se = f64::from(error.to_array()[1]);
            let off = (x - truth).abs() / widening;
            if se == 0.0 && off == 0.0 {
                // Of black that is known to be black, any interval holds it.
                continue;
            }
            let kind = usize::from(bars.flags[index]);
            self.counts[kind] += 1;
            for (held, (level, _)) in self.held[kind].iter_mut().zip(LEVELS) {
                // Rounding to single precision comes on top.
                let reach = bars.quantile(index, level) * se + 2e-7 * x.abs();
                *held += u64::from(off <= reach);
            }
        }
    }

    /// Renders pictures of several seeds, at least two, and holds each against the mean of the others.
    pub fn add_pictures_against_others(
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

    /// Takes pictures of several seeds in, given their expectation.
    pub fn add_pictures(
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

    /// The share of pixels whose bars are not to be trusted.
    pub fn flagged(&self) -> f64 {
        self.counts[1] as f64 / (self.counts[0] + self.counts[1]) as f64
    }

    /// Whether the intervals of unflagged pixels hold the truth as often as they say, or within what chance does to so few of
    /// them: which one does not.
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

/// How renders kept the error that they were asked for.
#[derive(Default)]
pub struct Kept {
    /// Renders.
    pub renders: u64,
    /// Those whose true error was at most that.
    pub kept: u64,
    sum: f64,
    /// Renders whose samples were foreseen within a factor of [`FORESEEN`].
    foreseen: u64,
    /// Renders of which anything was foreseen.
    predicted: u64,
}

/// The factor within which samples count as foreseen.
const FORESEEN: f64 = 1.25;

impl Kept {
    /// Renders with several seeds until the error is reached, and compares with the truth, whose own error is no part of theirs.
    pub fn of(
        (scene, description): (&Scene, &SceneDescription),
        (sampler, rel_rmse): (SamplerKind, f64),
        renders: u64,
        truth: &Film,
    ) -> Self {
        let of_truth = truth.error(0.95).expect("it has samples").rel_rmse;
        let truth = truth.develop();
        let filter = Filter::new(&description.film.filter);
        let mut this = Self::default();
        for seed in 0..renders {
            let target = ErrorTarget {
                rel_rmse,
                confidence: 0.95,
            };
            let settings = RenderSettings {
                budget: Budget {
                    error: Some(target),
                    ..Budget::default()
                },
                ..settings(description, sampler, seed, 1)
            };
            let size = description.film.size;
            let rendered = render(scene, &filter, size, &settings, &Unwatched);
            let rendered = rendered.expect("the settings are valid");
            assert!(rendered.reached);
            let apart = rel_mse(&rendered.film.develop(), &truth).expect("the same size");
            let share = (apart - of_truth * of_truth).max(0.0).sqrt() / rel_rmse;
            this.renders += 1;
            this.kept += u64::from(share <= 1.0);
            this.sum += share;
            if let Some(predicted) = rendered.predicted {
                let off = (predicted.spp as f64 / rendered.spp as f64).ln().abs();
                this.predicted += 1;
                this.foreseen += u64::from(off <= FORESEEN.ln());
            }
        }
        this
    }

    /// The mean of the true errors, as a share of what was asked for.
    pub fn mean(&self) -> f64 {
        self.sum / self.renders as f64
    }

    /// The share of renders whose samples were foreseen within a factor of 1.25; 1 if all took the pilot alone.
    pub fn foreseen(&self) -> f64 {
        match self.predicted {
            0 => 1.0,
            count => self.foreseen as f64 / count as f64,
        }
    }
}

/// A row of a table.
impl fmt::Display for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kept, renders, .. } = self;
        let (mean, foreseen) = (self.mean(), 100.0 * self.foreseen());
        write!(f, " {kept} of {renders} | {mean:.2} | {foreseen:.0} % |")
    }
}
