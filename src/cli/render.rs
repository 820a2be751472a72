//! `etendue render`: from a scene file to image files.
//!
//! Measure: seconds, samples, pixels.
//! Range: any scene that loads; every output is checked to be writable before the first sample.
//! Source: none needed. Tested in `tests/command.rs` and `tests/bad_input.rs`.

use super::args::{ProgressMode, RenderArguments};
use super::durations::format_duration;
use super::output::{Watcher, format_percent};
use super::stats::{self, Memory, Stats, Times};
use super::{Outcome, print, replay};
use crate::accel::AccelOptions;
use crate::error::{Error, Result};
use crate::film::filter::Filter;
use crate::film::{ErrorEstimate, Window};
use crate::image::{self, MetadataValue, WriteOptions};
use crate::integrator::Roulette;
use crate::render::settings::{
    Budget, IntegratorKind, RenderSettings, SamplerKind, available_threads,
};
use crate::render::{Rejected, Rendered};
use crate::scene::Scene;
use crate::scene::description::SceneDescription;
use crate::scene::load::{self, unknown_name};
use crate::scene::prepare::{Prepared, prepare};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Samples per pixel where neither scene nor command says.
const DEFAULT_SPP: u64 = 64;

/// More non-finite samples than this share make the render fail with exit code 6.
const NON_FINITE_LIMIT: f64 = 1e-6;

pub fn run(arguments: &RenderArguments) -> Result<Outcome> {
    let start = Instant::now();
    let outputs = outputs(arguments);
    if arguments.pixel.is_none() {
        for output in &outputs {
            image::check_writable(output)?;
        }
        if let Some(stats) = &arguments.stats {
            image::check_place(stats)?;
        }
    }
    let mut description = load::load(&arguments.scene)?;
    if let Some(size) = arguments.size {
        description.film.size = size;
    }
    let settings = settings(arguments, &description)?;
    settings.validate(description.film.size)?;
    let options = AccelOptions {
        backend: arguments.backend,
        precision: arguments.precision,
        threads: settings.threads,
    };
    let Prepared {
        scene,
        notes,
        build_time,
    } = prepare(&description, options)?;
    let loaded = start.elapsed().saturating_sub(build_time);
    let job = Job {
        arguments,
        description: &description,
        scene: &scene,
        settings: &settings,
    };
    if !arguments.quiet {
        for note in description.notes.iter().chain(&notes) {
            eprintln!("note: {note}");
        }
    }
    if arguments.verbose {
        eprint!("{}", job.summary());
    }
    let filter = Filter::new(&description.film.filter);
    if let (Some(pixel), Some(sample)) = (arguments.pixel, arguments.sample) {
        return replay::run(&job, &filter, pixel, sample);
    }

    let mode = if arguments.quiet {
        ProgressMode::None
    } else {
        arguments.progress
    };
    let watcher = Watcher::new(mode)?;
    let rendered =
        crate::render::render(&scene, &filter, description.film.size, &settings, &watcher);
    watcher.finish();
    let rendered = rendered?;

    let mut times = Times {
        load: loaded.as_secs_f64(),
        build: build_time.as_secs_f64(),
        render: rendered.elapsed.as_secs_f64(),
        ..Times::default()
    };
    let error = rendered.film.error();
    let writing = Instant::now();
    job.write(&outputs, &rendered, error.as_ref())?;
    times.write = writing.elapsed().as_secs_f64();
    times.total = start.elapsed().as_secs_f64();
    job.report(&outputs, &rendered, error, times)
}

/// The image files to write.
fn outputs(arguments: &RenderArguments) -> Vec<PathBuf> {
    if arguments.out.is_empty() {
        let name = arguments.scene.file_stem().unwrap_or("image".as_ref());
        vec![Path::new(name).with_extension("png")]
    } else {
        arguments.out.clone()
    }
}

/// The command line over the scene over the defaults.
fn settings(arguments: &RenderArguments, description: &SceneDescription) -> Result<RenderSettings> {
    let render = &description.render;
    let integrator = from_scene(
        description,
        "integrator",
        &render.integrator,
        IntegratorKind::ALL,
    )?;
    let sampler = from_scene(description, "sampler", &render.sampler, SamplerKind::ALL)?;
    let (width, height) = description.film.size;
    let window = match arguments.crop {
        None => Window {
            x: 0,
            y: 0,
            width,
            height,
        },
        Some([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 && x1 <= width && y1 <= height => Window {
            x: x0,
            y: y0,
            width: x1 - x0,
            height: y1 - y0,
        },
        Some([x0, y0, x1, y1]) => {
            return Err(Error::usage(format!(
                "--crop {x0},{y0},{x1},{y1} is not a part of the picture of {width}x{height} pixels"
            )));
        }
    };
    let wanted_spp = arguments.spp.or(render.spp);
    Ok(RenderSettings {
        integrator: arguments.integrator.or(integrator).unwrap_or_default(),
        sampler: arguments.sampler.or(sampler).unwrap_or_default(),
        seed: arguments.seed.or(render.seed).unwrap_or(0),
        budget: Budget {
            // A time that is asked for is not cut short by what the scene says by default.
            spp: match arguments.time {
                Some(_) => arguments.spp,
                None => Some(wanted_spp.unwrap_or(DEFAULT_SPP)),
            },
            time: arguments.time,
        },
        max_bounces: arguments.max_bounces.or(render.max_bounces),
        roulette: Roulette::default(),
        threads: arguments
            .threads
            .map_or_else(available_threads, usize::from),
        window,
        tile_size: 32,
    })
}

/// A choice that the scene names, among those that there are.
fn from_scene<T: Copy + Named>(
    description: &SceneDescription,
    key: &str,
    wanted: &Option<crate::scene::description::Written<String>>,
    all: &[T],
) -> Result<Option<T>> {
    let Some(wanted) = wanted else {
        return Ok(None);
    };
    if let Some(found) = all.iter().find(|choice| choice.name() == wanted.value) {
        return Ok(Some(*found));
    }
    let names: Vec<&str> = all.iter().map(|choice| choice.name()).collect();
    Err(Error::scene(unknown_name("name", &wanted.value, &names))
        .in_file(&description.file)
        .at_line(wanted.line)
        .in_field(format!("render.{key}")))
}

/// A choice with a name.
trait Named {
    fn name(&self) -> &'static str;
}

impl Named for IntegratorKind {
    fn name(&self) -> &'static str {
        Self::name(*self)
    }
}

impl Named for SamplerKind {
    fn name(&self) -> &'static str {
        Self::name(*self)
    }
}

/// A render with all that is known before it begins.
pub struct Job<'a> {
    pub arguments: &'a RenderArguments,
    pub description: &'a SceneDescription,
    pub scene: &'a Scene,
    pub settings: &'a RenderSettings,
}

impl Job<'_> {
    /// What the scene consists of.
    fn summary(&self) -> String {
        let primitives: usize = self
            .scene
            .geometries
            .iter()
            .map(|g| g.primitive_count())
            .sum();
        let (width, height) = self.description.film.size;
        format!(
            "scene: {} shapes, {primitives} primitives, {} materials, {} lights; {width} x {height} pixels\n\
             tracing: {}, {}; {:.1} MB\n",
            self.description.shapes.len(),
            self.description.materials.len(),
            self.scene.lights.len(),
            self.arguments.backend.name(),
            self.arguments.precision.name(),
            self.scene.accel.memory() as f64 / 1e6,
        )
    }

    fn write(
        &self,
        outputs: &[PathBuf],
        rendered: &Rendered,
        error: Option<&ErrorEstimate>,
    ) -> Result<()> {
        let options = WriteOptions {
            exposure: self.arguments.exposure,
            metadata: self.metadata(rendered, error),
            layers: Vec::new(),
        };
        let picture = rendered.film.develop();
        outputs
            .iter()
            .try_for_each(|output| image::write(output, &picture, &options))
    }

    /// What an EXR says of itself.
    fn metadata(
        &self,
        rendered: &Rendered,
        error: Option<&ErrorEstimate>,
    ) -> Vec<(String, MetadataValue)> {
        let text = |text: &str| MetadataValue::Text(text.to_owned());
        let command: Vec<String> = std::env::args().collect();
        let bias = self.settings.bias();
        let mut entries = vec![
            (
                "version",
                text(concat!("etendue ", env!("CARGO_PKG_VERSION"))),
            ),
            ("scene", text(&self.description.file.display().to_string())),
            ("seed", text(&self.settings.seed.to_string())),
            ("integrator", text(self.settings.integrator.name())),
            ("sampler", text(self.settings.sampler.name())),
            ("spp", MetadataValue::Number(rendered.spp as f64)),
            (
                "seconds",
                MetadataValue::Number(rendered.elapsed.as_secs_f64()),
            ),
            ("bias", text(if bias.is_empty() { "none" } else { "yes: " })),
            ("command", text(&command.join(" "))),
        ];
        if let Some(error) = error {
            entries.push(("relRmse", MetadataValue::Number(error.rel_rmse)));
        }
        let named = entries
            .into_iter()
            .map(|(name, value)| (format!("etendue.{name}"), value));
        let mut metadata: Vec<_> = named.collect();
        if !bias.is_empty() {
            let all = MetadataValue::Text(bias.join("; "));
            metadata.retain(|(name, _)| name != "etendue.bias");
            metadata.push(("etendue.bias".to_owned(), all));
        }
        metadata
    }

    fn report(
        &self,
        outputs: &[PathBuf],
        rendered: &Rendered,
        error: Option<ErrorEstimate>,
        times: Times,
    ) -> Result<Outcome> {
        let stats = self.stats(rendered, error, times);
        if let Some(path) = &self.arguments.stats {
            image::write_atomically(path, |file| {
                std::io::Write::write_all(file, stats.to_json().as_bytes())
            })?;
        }
        if self.arguments.json {
            print(stats.to_json().as_bytes())?;
        }
        let rejected = rendered.rejected;
        if rejected.count > 0 {
            eprintln!("{}", self.describe_rejected(&rejected));
        }
        if !self.arguments.quiet {
            if self.arguments.verbose {
                eprintln!(
                    "time: load {:.3} s, build {:.3} s, render {:.3} s, write {:.3} s",
                    times.load, times.build, times.render, times.write
                );
            }
            eprintln!("{}", last_line(outputs, rendered, &stats));
        }
        Ok(if rendered.cancelled {
            Outcome::Interrupted
        } else if rejected.count as f64 > NON_FINITE_LIMIT * stats.samples as f64 {
            Outcome::TooManyNonFinite
        } else {
            Outcome::Done
        })
    }

    fn stats(&self, rendered: &Rendered, error: Option<ErrorEstimate>, times: Times) -> Stats {
        let samples = rendered.film.sample_count();
        let seconds = rendered.elapsed.as_secs_f64();
        Stats {
            version: env!("CARGO_PKG_VERSION"),
            scene: self.description.file.display().to_string(),
            width: self.settings.window.width,
            height: self.settings.window.height,
            spp: rendered.spp,
            integrator: self.settings.integrator.name(),
            sampler: self.settings.sampler.name(),
            backend: self.arguments.backend.name(),
            precision: self.arguments.precision.name(),
            seed: self.settings.seed,
            threads: self.settings.threads,
            time: times,
            samples,
            rays: rendered.rays.into(),
            samples_per_second: samples as f64 / seconds,
            rays_per_second: rendered.rays.total() as f64 / seconds,
            memory: Memory {
                peak_rss: stats::peak_rss(),
                accel: self.scene.accel.memory() as u64,
            },
            error: error.map(Into::into),
            rejected: rendered.rejected.into(),
            image: stats::ImageStats::of(&rendered.film),
            bias: self.settings.bias(),
            interrupted: rendered.cancelled,
        }
    }

    /// How many samples were not finite, and the command that replays the first.
    fn describe_rejected(&self, rejected: &Rejected) -> String {
        let replay = rejected.first.map_or(String::new(), |first| {
            format!(
                "; the first: etendue render {} --seed {} --pixel {},{} --sample {}",
                self.arguments.scene.display(),
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

/// Where the image is, how long it took, how many samples, how wrong it is.
fn last_line(outputs: &[PathBuf], rendered: &Rendered, stats: &Stats) -> String {
    let files: Vec<String> = outputs
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let interrupted = if rendered.cancelled {
        "interrupted; "
    } else {
        ""
    };
    let error = match &stats.error {
        Some(error) => format!(
            "error {} (below {} at {:.0} % confidence)",
            format_percent(error.rel_rmse),
            format_percent(error.rel_rmse_upper),
            100.0 * error.confidence
        ),
        None => "error unknown".to_owned(),
    };
    let bias = if stats.bias.is_empty() {
        String::new()
    } else {
        format!(", biased by {}", stats.bias.join("; "))
    };
    format!(
        "{}: {interrupted}{} x {} pixels, {} spp in {}, {:.2} million samples/s, {error}{bias}",
        files.join(", "),
        stats.width,
        stats.height,
        stats.spp,
        format_duration(Duration::from_secs_f64(stats.time.total)),
        stats.samples_per_second / 1e6,
    )
}
