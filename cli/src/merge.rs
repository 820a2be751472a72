//! `etendue merge`: the image, or the state, of all shards of a render together.
//!
//! Measure: samples per pixel; errors as roots of relMSE.
//! Range: any number of state files of one render.
//! Source: none needed. Tested in `cli/tests/command/shards.rs`.

use super::args::MergeArguments;
use super::damaged;
use super::denoise::{DenoiseStats, Denoised};
use super::output::{explain, format_confidence, format_percent};
use super::render::states::{is_same_file, is_state};
use super::render::summary::{are_too_many, biased_by, warn_of_disagreement};
use super::{Outcome, command_line, print};
use etendue::internals::film::ErrorEstimate;
use etendue::internals::image::atomic::check_creatable;
use etendue::internals::image::{self, LayeredImage, MetadataValue, WriteOptions};
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::auto::with_known_choices;
use etendue::internals::render::settings::{
    Adaptive, LightPathRule, PathReuseRule, RenderSettings, available_threads,
};
use etendue::internals::session::layers::with_film;
use etendue::internals::state::{Merge, State, describe, read_header};
use etendue::{Error, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The printed result.
#[derive(Debug, Serialize)]
struct MergeReport {
    version: String,
    files: usize,
    /// Samples per pixel that were merged.
    spp: u64,
    /// Ranges of samples per pixel that are in no file: the first, and the one after the last.
    missing: Vec<[u64; 2]>,
    rel_rmse: Option<f64>,
    rel_rmse_upper: Option<f64>,
    /// Whether the requested error is reached, if there is one.
    reached: Option<bool>,
    /// The samples per pixel of a render that reaches it, by the error so far.
    needed_spp: Option<u64>,
    /// The causes of bias in the image.
    bias: Vec<String>,
    /// The samples that were not finite and are left out.
    rejected: u64,
    /// The filter of the image, and its error then.
    #[serde(skip_serializing_if = "Option::is_none")]
    denoise: Option<DenoiseStats>,
    /// The time of rendering of all shards, in seconds.
    render_seconds: f64,
    seconds: f64,
}

/// Checks that the outputs can be written, and the filter's parameters.
fn check(arguments: &MergeArguments) -> Result<()> {
    for output in &arguments.out {
        match is_state(output) {
            true => check_creatable(output)?,
            false => image::check_writable(output)?,
        }
    }
    arguments.denoise.map_or(Ok(()), |filter| filter.check())
}

/// The files to merge: of folders, all state files, by name.
fn state_files(arguments: &MergeArguments) -> Result<Vec<PathBuf>> {
    let mut files = vec![];
    for path in &arguments.files {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let cannot_read = |error| Error::io("cannot read", path, error);
        let before = files.len();
        for entry in path.read_dir().map_err(cannot_read)? {
            let file = entry.map_err(cannot_read)?.path();
            if !is_state(&file) || !file.is_file() {
                continue;
            }
            // It may have samples that no other file has any more.
            if arguments.out.iter().any(|it| is_same_file(it, &file)) {
                return Err(Error::usage(
                    "is an output in a folder that is merged, and exists: name another one, or delete it",
                )
                .in_file(file));
            }
            files.push(file);
        }
        if files.len() == before {
            return Err(Error::usage("has no state files (.etd) to merge").in_file(path));
        }
        files[before..].sort_unstable();
    }
    Ok(files)
}

/// The files that are not damaged; the others are set aside. A file of another name is no shard, and stays where it is.
fn without_damaged(files: Vec<PathBuf>) -> Result<Vec<PathBuf>> {
    let mut whole = vec![];
    for file in files {
        let note = match is_state(&file) {
            true => damaged::set_aside(&file)?,
            false => None,
        };
        match note {
            Some(note) => say!("warning: {note}"),
            None => whole.push(file),
        }
    }
    Ok(whole)
}

/// Merges according to the arguments.
pub fn run(arguments: &MergeArguments) -> Result<Outcome> {
    let start = Instant::now();
    check(arguments)?;
    let mut files = state_files(arguments)?;
    if arguments.set_damaged_aside {
        files = without_damaged(files)?;
    }
    let merge = Merge::of(&files)?;
    let missing = merge.missing();
    if !missing.is_empty() && !arguments.partial {
        return Err(Error::usage(format!(
            "samples {} of {} are missing: render them by `etendue render --shard`, or merge what is there by --partial",
            describe(&missing),
            merge.spp()
        )));
    }
    let has_images = arguments.out.iter().any(|path| !is_state(path));
    if arguments.denoise.is_some() && !has_images {
        return Err(Error::usage(
            "--denoise filters an image: give one by -o, such as -o image.exr",
        ));
    }
    if arguments.denoise.is_some() && !files.iter().any(has_layers) {
        return Err(lacks_layers());
    }
    let state = merge.sum()?;
    if missing.is_empty() {
        state.check_is_lit()?;
    }
    let error = state.error(arguments.confidence);
    let denoised = write(arguments, &state, error.as_ref())?;
    let bound = error
        .map(|error| error.upper_bound)
        .filter(|it| it.is_finite());
    let reached = arguments
        .error
        .map(|target| bound.is_some_and(|bound| bound <= target));
    let needed = arguments.error.filter(|_| reached == Some(false));
    let report = MergeReport {
        version: state.header.identity.program.clone(),
        files: files.len(),
        spp: state.header.samples(),
        missing,
        rel_rmse: error.map(|error| error.rel_rmse),
        rel_rmse_upper: bound,
        reached,
        needed_spp: needed.and_then(|target| state.needed_spp(target, arguments.confidence)),
        bias: bias(&state, denoised.as_ref()),
        rejected: state.header.rejected.count,
        denoise: denoised.as_ref().map(Denoised::stats),
        render_seconds: state.header.seconds,
        seconds: start.elapsed().as_secs_f64(),
    };
    if arguments.json {
        let json = serde_json::to_string_pretty(&report).expect("plain data always serialises");
        print((json + "\n").as_bytes())?;
    }
    if report.rejected > 0 {
        let rejected = report.rejected;
        say!("warning: {rejected} samples were not finite and are left out");
    }
    if !arguments.quiet {
        if state.header.identity.name("integrator") == IntegratorKind::Metropolis.name() {
            warn_of_disagreement(&state.film);
        }
        let filtered = denoised.as_ref().map(Denoised::description);
        say!(
            "{}",
            last_line(arguments, &report, error.as_ref(), filtered)
        );
    }
    let samples = state.film.sample_count();
    Ok(match reached {
        _ if are_too_many(report.rejected, samples) => Outcome::TooManyNonFinite,
        Some(false) => Outcome::ErrorNotReached,
        _ => Outcome::Done,
    })
}

/// Writes the outputs. Returns the filtered image, if it is to be filtered.
fn write(
    arguments: &MergeArguments,
    state: &State,
    error: Option<&ErrorEstimate>,
) -> Result<Option<Denoised>> {
    let (states, images): (Vec<_>, Vec<_>) = arguments.out.iter().partition(|path| is_state(path));
    states.into_iter().try_for_each(|path| state.write(path))?;
    if images.is_empty() {
        return Ok(None);
    }
    let mut picture = LayeredImage::from(state.film.develop());
    let has_layers = !state.layers.is_empty();
    if has_layers {
        picture.layers = with_film(state.layers.clone(), &state.film);
    } else if arguments.denoise.is_some() {
        return Err(lacks_layers());
    } else if state.header.wants_layers && !arguments.quiet {
        say!(
            "note: without layers: they are in the output with the first sample, which is missing; checkpoints have none"
        );
    }
    let denoise = |filter| {
        let before = error.map(|error| error.rel_rmse);
        Denoised::new(filter, &picture, before, available_threads())
    };
    let denoised = arguments.denoise.map(denoise).transpose()?;
    let options = WriteOptions {
        exposure: arguments.exposure,
        metadata: metadata(state, error, denoised.as_ref()),
        layers: match &denoised {
            Some(denoised) => denoised.layers(&picture, true),
            None => picture.layers.clone(),
        },
    };
    let image = denoised
        .as_ref()
        .map_or(&picture.image, |it| &it.filtered.image);
    images
        .into_iter()
        .try_for_each(|path: &PathBuf| image::write(path, image, &options))?;
    Ok(denoised)
}

/// Whether a state file has layers, by its header.
fn has_layers(file: impl AsRef<Path>) -> bool {
    read_header(file.as_ref()).is_ok_and(|header| !header.layers.is_empty())
}

/// The error for files without the layers that a filter needs.
fn lacks_layers() -> Error {
    Error::usage(
        "--denoise needs the layers of the first hits, which are in the output with the first sample of a render with --layers",
    )
}

/// Descriptions of everything that biases the image.
fn bias(state: &State, denoised: Option<&Denoised>) -> Vec<String> {
    let mut bias = state.header.bias.clone();
    bias.extend(denoised.map(|it| it.denoiser.bias().to_owned()));
    bias
}

/// The settings of a state that the light paths and the shared paths of a render depend on.
fn settings_of_paths(state: &State) -> RenderSettings {
    let identity = &state.header.identity;
    let mut settings = RenderSettings::new((1, 1), 1);
    settings.integrator = IntegratorKind::Auto;
    settings.light_paths = LightPathRule::Auto;
    settings.reuse = PathReuseRule::Auto;
    let mut kinds = Adaptive::ALL.iter();
    if let Some(kind) = kinds.find(|it| identity.name("adaptive") == it.name()) {
        settings.adaptive = *kind;
    }
    with_known_choices(&settings, &identity.settings)
}

/// The metadata of an EXR file: as `etendue render` writes them, but for the reason of `auto`, which no state has.
fn metadata(
    state: &State,
    error: Option<&ErrorEstimate>,
    denoised: Option<&Denoised>,
) -> Vec<(String, MetadataValue)> {
    let header = &state.header;
    let text = |text: &str| MetadataValue::Text(text.to_owned());
    let bias = bias(state, denoised);
    let bias = match bias.is_empty() {
        true => "none".to_owned(),
        false => bias.join("; "),
    };
    let settings = settings_of_paths(state);
    let seed = header.identity.settings.get("seed");
    let sampling = state.film.filter_sampling().name();
    let filter = format!("{}, {sampling}", header.identity.name("filter"));
    let mut metadata = vec![
        ("version", text(&header.identity.program)),
        ("scene", text(&header.scene_file)),
        (
            "seed",
            text(&seed.map_or(String::new(), ToString::to_string)),
        ),
        ("integrator", text(header.identity.name("integrator"))),
        ("sampler", text(header.identity.name("sampler"))),
        ("filter", text(&filter)),
        ("adaptive", text(header.identity.name("adaptive"))),
        ("roulette", text(header.identity.name("roulette"))),
        ("lightPaths", text(settings.light_path_rule().name())),
        ("reuse", text(settings.reuse().name())),
        ("spp", MetadataValue::Real(header.samples() as f64)),
        ("seconds", MetadataValue::Real(header.seconds)),
        ("bias", text(&bias)),
        ("command", text(&command_line())),
    ];
    let real = |name, value| (name, MetadataValue::Real(value));
    match denoised {
        Some(denoised) => metadata.extend(denoised.filtered.error.map(|it| real("relRmse", it))),
        None => {
            metadata.extend(error.map(|it| real("relRmse", it.rel_rmse)));
            metadata.extend(error.map(|it| match it.doubt {
                Some(doubt) => real("relRmseAtLeast", doubt.at_least()),
                None => real("relRmseUpper", it.upper_bound),
            }));
        }
    }
    let named = metadata.into_iter();
    named
        .map(|(name, value)| (format!("etendue.{name}"), value))
        .collect()
}

/// The summary line: outputs, files, samples, error, and what is missing.
fn last_line(
    arguments: &MergeArguments,
    report: &MergeReport,
    error: Option<&ErrorEstimate>,
    filtered: Option<String>,
) -> String {
    let name = |path: &PathBuf| Path::display(path).to_string();
    let outputs: Vec<String> = arguments.out.iter().map(name).collect();
    let error = match error {
        None => "error unknown".to_owned(),
        Some(error) => match error.doubt {
            Some(doubt) => format!(
                "error at least {} ({})",
                format_percent(doubt.at_least()),
                explain(doubt)
            ),
            None => format!(
                "error {} (below {} at {} confidence)",
                format_percent(error.rel_rmse),
                format_percent(error.upper_bound),
                format_confidence(error.confidence)
            ),
        },
    };
    let missing = match report.missing.as_slice() {
        [] => String::new(),
        missing => format!("; samples {} are missing", describe(missing)),
    };
    let needed = match (report.reached, report.needed_spp) {
        (Some(false), Some(spp)) => {
            let more = spp.saturating_sub(report.spp);
            let shards = match report.files {
                0 | 1 => String::new(),
                files => {
                    let of_shard = (report.spp / files as u64).max(1);
                    format!(", {} more shards", more.div_ceil(of_shard))
                }
            };
            format!("; the requested error takes about {spp} spp, {more} more{shards}")
        }
        (Some(false), None) => "; the requested error is not reached".to_owned(),
        _ => String::new(),
    };
    let filtered = filtered.map_or(String::new(), |words| format!(", {words}"));
    let bias = biased_by(&report.bias);
    let files = if report.files == 1 { "file" } else { "files" };
    format!(
        "{}: {} {files}, {} spp, {error}{filtered}{bias}{missing}{needed}",
        outputs.join(", "),
        report.files,
        report.spp
    )
}
