//! The output after a render: statistics, non-finite samples, the summary line.
//!
//! Measure: seconds, samples, shares of one.
//! Range: any render, also an interrupted one.
//! Source: none needed. Tested in `cli/tests/command/render.rs`.

use super::job::RenderJob;
use super::stats::{self, ErrorStats, ImageStats, Memory, PriceStats, Stats, TargetStats, Times};
use crate::denoise::Denoised;
use crate::durations::format_duration;
use crate::output::{format_confidence, format_percent};
use crate::{Outcome, print, quoted};
use etendue::Result;
use etendue::internals::accel::{Backend, Precision};
use etendue::internals::effects::Effect;
use etendue::internals::film::splats::Splats;
use etendue::internals::film::{ErrorEstimate, Film};
use etendue::internals::image::atomic::write_text;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::Adaptive;
use etendue::internals::render::{NonFiniteSample, Rejected, Rendered, kernel};
use std::path::PathBuf;
use std::time::Duration;

/// The factor by which the error is reduced in the printed price.
const TEN: f64 = 10.0;

/// The share of non-finite samples above which the render fails with exit code 6.
const NON_FINITE_LIMIT: f64 = 1e-6;

impl RenderJob<'_> {
    /// Whether anything is printed or written of a render beside its images and states.
    pub fn has_statistics(&self) -> bool {
        let arguments = self.arguments;
        !arguments.quiet || arguments.json || arguments.stats.is_some()
    }

    /// Writes and prints the statistics and the summary, and returns the outcome of the command.
    pub fn report(
        &self,
        outputs: &[PathBuf],
        rendered: &Rendered,
        error: Option<ErrorEstimate>,
        denoised: Option<&Denoised>,
        times: Times,
    ) -> Result<Outcome> {
        let stats = self.has_statistics().then(|| Stats {
            denoise: denoised.map(Denoised::stats),
            ..self.stats(rendered, error, times)
        });
        if let (Some(path), Some(stats)) = (&self.arguments.stats, &stats) {
            write_text(path, &stats.to_json())?;
        }
        if let Some(stats) = stats.as_ref().filter(|_| self.arguments.json) {
            print(stats.to_json().as_bytes())?;
        }
        let rejected = rendered.rejected;
        if rejected.count > 0 {
            say!("{}", self.describe_rejected(&rejected));
        }
        if let Some(stats) = stats.as_ref().filter(|_| !self.arguments.quiet) {
            if self.arguments.verbose {
                say!(
                    "time: load {:.3} s, build {:.3} s, render {:.3} s, write {:.3} s",
                    times.load,
                    times.build,
                    times.render,
                    times.write
                );
            }
            if self.settings.integrator == IntegratorKind::Metropolis {
                warn_of_disagreement(&rendered.film);
            }
            say!("{}", last_line(outputs, rendered, stats, denoised));
        }
        Ok(if rendered.cancelled {
            Outcome::Interrupted
        } else if are_too_many(rejected.count, rendered.film.sample_count()) {
            Outcome::TooManyNonFinite
        } else if self.settings.budget.error.is_some() && !rendered.reached {
            Outcome::ErrorNotReached
        } else {
            Outcome::Done
        })
    }

    fn stats(&self, rendered: &Rendered, error: Option<ErrorEstimate>, times: Times) -> Stats {
        let samples = rendered.film.sample_count();
        let counts = rendered.film.sample_counts();
        let (least, most) = (counts.iter().min(), counts.iter().max());
        let seconds = rendered.elapsed.as_secs_f64();
        Stats {
            version: env!("CARGO_PKG_VERSION"),
            scene: self.description.file.display().to_string(),
            width: self.settings.window.width,
            height: self.settings.window.height,
            spp: rendered.spp,
            integrator: self.settings.integrator.name(),
            auto: self.auto.map(|it| it.why.clone()),
            filter: self.filter(),
            roulette: self.settings.roulette().to_string(),
            light_paths: self.settings.light_path_rule().name(),
            reuse: self.settings.reuse().name(),
            sampler: self.settings.sampler.name(),
            adaptive: self.settings.adaptive.name(),
            backend: self.arguments.tracing.backend.name(),
            precision: self.arguments.tracing.precision.name(),
            quality: self.arguments.tracing.options().quality().name(),
            seed: self.settings.seed,
            threads: self.settings.threads,
            kernel: kernel(self.scene, self.settings).name(),
            effects: self
                .settings
                .effects(self.scene.effects)
                .iter()
                .map(Effect::name)
                .collect(),
            time: times,
            samples,
            spp_range: [least, most].map(|count| count.copied().unwrap_or(0)),
            rays: rendered.rays.into(),
            samples_per_second: samples as f64 / seconds,
            rays_per_second: rendered.rays.total() as f64 / seconds,
            memory: Memory {
                peak_rss: stats::peak_rss(),
                accel: self.scene.accel.memory() as u64,
                splats: rendered.film.splats().map_or(0, Splats::memory) as u64,
                cache: rendered.cache.as_ref().map(|cache| cache.memory() as u64),
            },
            price: error
                .and_then(|error| rendered.price(&error, TEN))
                .map(Into::into),
            error: error.map(|error| ErrorStats::new(error, &rendered.film)),
            target: self.settings.budget.error.map(|target| TargetStats {
                rel_rmse: target.rel_rmse,
                confidence: target.confidence,
                reached: rendered.reached,
                predicted: rendered.predicted.map(Into::into),
            }),
            denoise: None,
            rejected: rendered.rejected.into(),
            image: ImageStats::of(&rendered.film),
            bias: self.bias(),
            interrupted: rendered.cancelled,
        }
    }

    /// Returns the flags of this render that affect its samples.
    fn flags_of_samples(&self) -> String {
        let (flags, tracing) = (self.arguments, &self.arguments.tracing);
        let settings = &flags.settings;
        let size = settings
            .size
            .map(|(width, height)| format!("{width}x{height}"));
        let backend =
            (tracing.backend != Backend::ALL[0]).then(|| tracing.backend.name().to_owned());
        // `=` is needed, since the value of `--adaptive` is optional.
        let adaptive = flags.adaptive;
        let adaptive = adaptive.map(|how| format!(" --adaptive={}", how.name()));
        let layers = self.settings.layers.then(|| " --layers".to_owned());
        let camera = flags.scene.camera.as_deref().map(quoted);
        let precision = tracing.precision;
        let precision = (precision != Precision::Robust).then(|| precision.name().to_owned());
        [
            ("camera", camera),
            ("size", size),
            ("spp", flags.spp.map(|spp| spp.to_string())),
            ("sampler", settings.sampler.map(|it| it.name().to_owned())),
            (
                "integrator",
                settings
                    .integrator
                    .map(|_| self.settings.integrator.name().to_owned()),
            ),
            ("filter", settings.filter.map(|it| it.name())),
            (
                "filter-sampling",
                settings.filter_sampling.map(|it| it.name().to_owned()),
            ),
            ("roulette", settings.roulette.map(|it| it.to_string())),
            (
                "light-paths",
                settings.light_paths.map(|it| it.name().to_owned()),
            ),
            ("reuse", settings.reuse.map(|it| it.name().to_owned())),
            (
                "light-choice",
                settings.light_choice.map(|it| it.name().to_owned()),
            ),
            (
                "occlusion-distance",
                settings.occlusion_distance.map(|it| it.to_string()),
            ),
            ("cache-error", settings.cache_error.map(|it| it.to_string())),
            ("max-bounces", settings.max_bounces.map(|it| it.to_string())),
            ("backend", backend),
            ("precision", precision),
            ("quality", tracing.quality.map(|it| it.name().to_owned())),
            ("error", flags.error.map(|error| error.to_string())),
        ]
        .into_iter()
        .filter_map(|(flag, value)| value.map(|value| format!(" --{flag} {value}")))
        .chain(adaptive)
        .chain(layers)
        .collect()
    }

    /// Describes the number of non-finite samples, and the command that replays the first of them.
    fn describe_rejected(&self, rejected: &Rejected) -> String {
        // Samples beyond the image's edge contribute to it, but cannot be named.
        let (width, height) = self.description.film.size;
        let in_image = |first: &NonFiniteSample| first.x < width && first.y < height;
        let replay = rejected
            .first
            .filter(in_image)
            .map_or(String::new(), |first| {
                format!(
                    "; the first: etendue render {}{} --seed {} --pixel {},{} --sample {}",
                    quoted(&self.arguments.scene.file.display().to_string()),
                    self.flags_of_samples(),
                    self.settings.seed,
                    first.x,
                    first.y,
                    first.sample
                )
            });
        format!(
            "warning: {} samples were not finite and are left out{replay}",
            rejected.count
        )
    }
}

/// Whether so many samples are not finite that the command fails.
pub fn are_too_many(rejected: u64, samples: u64) -> bool {
    rejected as f64 > NON_FINITE_LIMIT * samples as f64
}

/// Describes the bias of an image at the end of the last line.
pub fn biased_by(bias: &[String]) -> String {
    match bias {
        [] => String::new(),
        _ => format!(", biased by {}", bias.join("; ")),
    }
}

/// Formats the summary line: output files, time, samples per pixel, error.
fn last_line(
    outputs: &[PathBuf],
    rendered: &Rendered,
    stats: &Stats,
    denoised: Option<&Denoised>,
) -> String {
    let files: Vec<String> = outputs
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let interrupted = if rendered.cancelled {
        "interrupted; "
    } else {
        ""
    };
    let error = stats
        .error
        .as_ref()
        .map_or("error unknown".to_owned(), describe_error);
    let price = stats.price.as_ref().map_or(String::new(), describe_price);
    let filtered = denoised.map_or(String::new(), |it| format!(", {}", it.description()));
    let bias = biased_by(&stats.bias);
    let missed = match &stats.target {
        Some(target) if !target.reached => format!(
            "the requested error {} was not reached; ",
            format_percent(target.rel_rmse)
        ),
        _ => String::new(),
    };
    let spread = match stats.spp_range {
        _ if stats.adaptive == Adaptive::Off.name() => String::new(),
        [least, most] => format!(" in the mean ({least} to {most})"),
    };
    let chosen = match &stats.auto {
        Some(_) => format!(" by {}, chosen by auto", stats.integrator),
        None => String::new(),
    };
    format!(
        "{}: {interrupted}{missed}{} x {} pixels, {} spp{spread}{chosen} in {}, {:.2} million samples/s, {error}{price}{filtered}{bias}",
        files.join(", "),
        stats.width,
        stats.height,
        stats.spp,
        format_duration(Duration::from_secs_f64(stats.time.total)),
        stats.samples_per_second / 1e6,
    )
}

/// Describes the cost of a smaller error.
fn describe_price(price: &PriceStats) -> String {
    /// The ratio up to which two times are printed as one.
    const ALIKE: f64 = 1.3;
    let time = |seconds: f64| format_duration(Duration::from_secs_f64(seconds.min(1e15)));
    let [least, most] = price.seconds_range;
    let how_long = match most > ALIKE * least {
        true => format!("{} to {}", time(least), time(most)),
        false => format!("about {}", time(price.seconds)),
    };
    format!("; {} would take {how_long}", format_percent(price.rel_rmse))
}

/// Describes the error with its bound, or the reason for a missing bound.
fn describe_error(error: &ErrorStats) -> String {
    match (error.rel_rmse_upper, &error.doubt) {
        (Some(bound), _) => format!(
            "error {} (below {} at {} confidence)",
            format_percent(error.rel_rmse),
            format_percent(bound),
            format_confidence(error.confidence)
        ),
        (None, Some(doubt)) => format!(
            "error at least {} ({})",
            format_percent(doubt.rel_rmse_at_least),
            doubt.why
        ),
        (None, None) => "error unknown".to_owned(),
    }
}

/// Warns if the Markov chains disagree.
pub fn warn_of_disagreement(film: &Film) {
    /// The share of disagreeing tiles above which the warning is printed.
    const MAX_DISAGREEMENT: f64 = 0.05;
    let share = film.uncertain_tile_share();
    if share > MAX_DISAGREEMENT {
        say!(
            "warning: the Markov chains disagree: in {} of the image their means, and so the brightness, are uncertain by more than 20 %; render longer",
            format_percent(share)
        );
    }
}
