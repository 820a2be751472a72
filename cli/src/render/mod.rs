//! `etendue render`: from a scene file to image files.
//!
//! Measure: seconds, samples, pixels.
//! Range: any scene that loads; every output is checked to be writable before the first sample.
//! Source: none needed. Tested in `cli/tests/command/render.rs` and `cli/tests/command/bad_input.rs`.

mod checkpoint;
mod job;
mod options;
mod replay;
pub mod states;
pub mod stats;
pub mod summary;

use crate::args::{ProgressMode, RenderArguments};
use crate::denoise::Denoised;
use crate::output::ConsoleObserver;
use crate::recommendation::sentence;
use crate::{Outcome, command_line, named_after};
use checkpoint::Checkpointer;
use etendue::internals::film::ErrorEstimate;
use etendue::internals::film::filter::{Filter, FilterSampling};
use etendue::internals::film::splats::Strategy;
use etendue::internals::image::atomic::{check_creatable, make_folder};
use etendue::internals::image::{self, LayeredImage, MetadataValue, WriteOptions};
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::path_strategies::{PathStrategy, path_strategies};
use etendue::internals::render::{RenderInput, RenderObserver, Rendered, Threads, strategies};
use etendue::internals::session::{Rendering, Session};
use etendue::{Error, Result};
use job::RenderJob;
use options::options;
use states::is_state;
use stats::Times;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Renders according to the arguments.
pub fn run(arguments: &RenderArguments) -> Result<Outcome> {
    let start = Instant::now();
    let mode = if arguments.quiet {
        ProgressMode::None
    } else {
        arguments.progress
    };
    let console = ConsoleObserver::new(mode)?;
    let outputs = outputs(arguments);
    if arguments.pixel.is_none() {
        check(arguments, &outputs)?;
    }
    let mut description = arguments.scene.load()?;
    arguments.settings.apply_to(&mut description);
    let options = options(arguments);
    // Invalid combinations of options are reported before anything slow starts.
    options.settings(&description)?;
    let session = Session::new(description, arguments.tracing.options())?;
    let build_time = session.work().structures;
    let loaded = start.elapsed().saturating_sub(build_time);
    let started = states::start(arguments, &session, &options, &console);
    // Pilots that were cut choose otherwise, so that a state may seem to be that of another render.
    if console.is_cancelled() {
        return Ok(Outcome::Interrupted);
    }
    let mut rendering = started?;
    let settings = rendering.settings().clone();
    let recommendation = rendering.recommendation().cloned();
    let job = RenderJob {
        arguments,
        description: session.description(),
        scene: session.scene(),
        settings: &settings,
        auto: recommendation.as_ref(),
        choices: rendering.choices(),
    };
    announce(&job, &session);
    if arguments.bdpt_strategies.is_some() {
        strategies::check(&settings)?;
    }
    if let (Some(pixel), Some(sample)) = (arguments.pixel, arguments.sample) {
        if settings.integrator == IntegratorKind::Metropolis {
            return Err(Error::usage(
                "the mutations of mlt belong to no pixel and cannot be replayed: --integrator bdpt replays paths of the same kind",
            ));
        }
        return replay::run(&job, session.filter(), pixel, sample);
    }

    if let Some(cache) = &arguments.state.cache {
        rendering.share_cache(&session, cache, &console)?;
    }
    let checkpointer = Checkpointer::new(&console, arguments, &session, &rendering)?;
    let ended = rendering.continue_until(&session, rendering.budget(), &checkpointer);
    console.finish();
    ended?;
    let times = Times {
        load: loaded.as_secs_f64(),
        build: build_time.as_secs_f64(),
        ..Times::default()
    };
    finish(&job, &session, &rendering, &outputs, times, start)
}

/// Prints the notes that precede the first sample.
fn announce(job: &RenderJob<'_>, session: &Session) {
    let arguments = job.arguments;
    if !arguments.quiet {
        if let Some(recommendation) = job.auto {
            say!("{}", sentence(recommendation));
        }
        let bias = job.settings.bias_of_integrator(job.scene.effects);
        for note in session.notes().chain(bias) {
            say!("note: {note}");
        }
        if arguments.denoise.is_some() && arguments.error.is_some() {
            say!("note: the requested error is that of the image before filtering");
        }
    }
    if arguments.verbose {
        say!("{}", job.summary().trim_end());
    }
}

/// Writes the states, filters, writes and reports the rendered image. `times` has the durations of the earlier phases; `start`
/// is the start of the command.
///
/// # Errors
/// The first error. Every output is tried before that: one that cannot be written costs no other, and states come first, as
/// a process that was asked to end may have little time.
fn finish(
    job: &RenderJob<'_>,
    session: &Session,
    rendering: &Rendering,
    outputs: &[PathBuf],
    mut times: Times,
    start: Instant,
) -> Result<Outcome> {
    let arguments = job.arguments;
    let rendered = rendering.rendered();
    times.render = rendered.elapsed.as_secs_f64();
    let has_images = images(outputs).next().is_some();
    // An estimate of the error takes as long as some samples, and a shard rendered by `--quiet` shows it to nobody.
    let error = match has_images || job.has_statistics() {
        true => rendering.error(arguments.confidence),
        false => None,
    };
    let writing = Instant::now();
    let mut failures = Failures::default();
    failures.note(states::write(arguments, session, rendering, outputs));
    times.write = writing.elapsed().as_secs_f64();
    let mut denoised = None;
    if has_images {
        let picture = match job.settings.layers {
            true => rendering.layered(session)?,
            false => LayeredImage::from(rendering.image()),
        };
        denoised = arguments.denoise.and_then(|filter| {
            let before = error.map(|error| error.rel_rmse);
            failures.note(Denoised::new(
                filter,
                &picture,
                before,
                job.settings.threads,
            ))
        });
        times.denoise = denoised.as_ref().map_or(0.0, |it| it.elapsed.as_secs_f64());
        let writing = Instant::now();
        let metadata = job.metadata(rendered, error.as_ref(), denoised.as_ref());
        job.write(outputs, picture, denoised.as_ref(), metadata, &mut failures);
        times.write += writing.elapsed().as_secs_f64();
    }
    if let Some(folder) = &arguments.bdpt_strategies
        && !rendered.cancelled
    {
        let writing = Instant::now();
        failures.note(job.write_strategies(folder, session.filter()));
        times.write += writing.elapsed().as_secs_f64();
    }
    times.total = start.elapsed().as_secs_f64();
    let reported = failures.note(job.report(outputs, rendered, error, denoised.as_ref(), times));
    match failures.first {
        Some(error) => Err(error),
        None => Ok(reported.expect("without an error there is an outcome")),
    }
}

/// The first of several errors; the others are printed at once.
#[derive(Default)]
struct Failures {
    first: Option<Error>,
}

impl Failures {
    /// Returns the value of a result; keeps the first error and prints later ones.
    fn note<T>(&mut self, result: Result<T>) -> Option<T> {
        match result {
            Ok(value) => return Some(value),
            Err(error) if self.first.is_some() => say!("etendue: {error}"),
            Err(error) => self.first = Some(error),
        }
        None
    }
}

/// Checks that every step after the last sample can be done.
fn check(arguments: &RenderArguments, outputs: &[PathBuf]) -> Result<()> {
    states::check(arguments, outputs)?;
    for output in images(outputs) {
        image::check_writable(output)?;
    }
    let is_exr = |path: &PathBuf| {
        path.extension()
            .is_some_and(|it| it.eq_ignore_ascii_case("exr"))
    };
    let has_layers = |path: &PathBuf| is_exr(path) || is_state(path);
    if arguments.layers && !outputs.iter().any(has_layers) {
        return Err(Error::usage(
            "--layers needs an output format that stores layers, such as -o image.exr",
        ));
    }
    if arguments.denoise.is_some() && images(outputs).next().is_none() {
        return Err(Error::usage(
            "--denoise filters an image: give one by -o, or the state files to `etendue merge --denoise`",
        ));
    }
    if arguments.bdpt_strategies.is_some() && arguments.state.shard.is_some() {
        return Err(Error::usage(
            "--bdpt-strategies renders all samples itself: leave out --shard",
        ));
    }
    if let Some(filter) = arguments.denoise {
        filter.check()?;
        if arguments.settings.filter_sampling == Some(FilterSampling::Splatting) {
            return Err(Error::usage(
                "--denoise takes the noise of pixels as independent, which that of --filter-sampling splatting is not: leave the latter out",
            ));
        }
    }
    arguments.stats.as_deref().map_or(Ok(()), check_creatable)
}

/// Returns those of the files that are images.
fn images(outputs: &[PathBuf]) -> impl Iterator<Item = &PathBuf> {
    outputs.iter().filter(|path| !is_state(path))
}

/// Returns the files to write.
fn outputs(arguments: &RenderArguments) -> Vec<PathBuf> {
    if arguments.out.is_empty() {
        vec![named_after(&arguments.scene.file, "png")]
    } else {
        arguments.out.clone()
    }
}

impl RenderJob<'_> {
    fn write(
        &self,
        outputs: &[PathBuf],
        picture: LayeredImage,
        denoised: Option<&Denoised>,
        metadata: Vec<(String, MetadataValue)>,
        failures: &mut Failures,
    ) {
        let layers = match denoised {
            Some(denoised) => denoised.layers(&picture, self.arguments.layers),
            None => picture.layers,
        };
        let options = WriteOptions {
            exposure: self.arguments.exposure,
            metadata,
            layers,
        };
        let image = denoised.map_or(&picture.image, |it| &it.filtered.image);
        for output in images(outputs) {
            failures.note(image::write(output, image, &options));
        }
    }

    /// Writes the contribution of each strategy: its weighted image, and for bidirectional path tracing the unweighted one.
    fn write_strategies(&self, folder: &Path, filter: &Filter) -> Result<()> {
        make_folder(folder)?;
        let input = RenderInput {
            scene: self.scene,
            filter,
            size: self.description.film.size,
        };
        let threads = Threads::new(self.settings.threads)?;
        let options = WriteOptions::default();
        if self.settings.integrator == IntegratorKind::Path {
            let images = path_strategies(&input, &threads, self.settings)?;
            for (strategy, image) in PathStrategy::ALL.iter().zip(&images) {
                let file = folder.join(format!("{}-weighted.exr", strategy.name()));
                image::write(&file, image, &options)?;
            }
            return Ok(());
        }
        for images in strategies::strategies(&input, &threads, self.settings)? {
            let Strategy { s, t } = images.strategy;
            let alone = folder.join(format!("s{s}-t{t}.exr"));
            image::write(&alone, &images.unweighted, &options)?;
            let weighted = folder.join(format!("s{s}-t{t}-weighted.exr"));
            image::write(&weighted, &images.weighted, &options)?;
        }
        Ok(())
    }

    /// Returns the metadata of an EXR file.
    fn metadata(
        &self,
        rendered: &Rendered,
        error: Option<&ErrorEstimate>,
        denoised: Option<&Denoised>,
    ) -> Vec<(String, MetadataValue)> {
        let text = |text: &str| MetadataValue::Text(text.to_owned());
        let bias = match self.bias() {
            none if none.is_empty() => "none".to_owned(),
            all => all.join("; "),
        };
        let mut metadata = vec![
            (
                "version",
                text(concat!("etendue ", env!("CARGO_PKG_VERSION"))),
            ),
            ("scene", text(&self.description.file.display().to_string())),
            ("seed", text(&self.settings.seed.to_string())),
            ("integrator", text(self.settings.integrator.name())),
            ("sampler", text(self.settings.sampler.name())),
            ("adaptive", text(self.settings.adaptive.name())),
            ("filter", text(&self.filter())),
            ("roulette", text(&self.settings.roulette().to_string())),
            ("lightPaths", text(self.settings.light_path_rule().name())),
            ("reuse", text(self.settings.reuse().name())),
            ("spp", MetadataValue::Real(rendered.spp as f64)),
            (
                "seconds",
                MetadataValue::Real(rendered.elapsed.as_secs_f64()),
            ),
            ("bias", text(&bias)),
            ("command", text(&command_line())),
        ];
        let real = |name, value| (name, MetadataValue::Real(value));
        metadata.extend(self.auto.map(|it| ("auto", text(&it.why))));
        match denoised {
            Some(denoised) => {
                metadata.extend(denoised.filtered.error.map(|it| real("relRmse", it)))
            }
            None => {
                metadata.extend(error.map(|it| real("relRmse", it.rel_rmse)));
                let bound = error.map(|it| match it.doubt {
                    Some(doubt) => real("relRmseAtLeast", doubt.at_least()),
                    None => real("relRmseUpper", it.upper_bound),
                });
                metadata.extend(bound);
            }
        }
        metadata
            .into_iter()
            .map(|(name, value)| (format!("etendue.{name}"), value))
            .collect()
    }
}
