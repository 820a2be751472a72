//! State files of a render: the outputs that end in `.etd`, and the state that it continues from.
//!
//! Measure: none.
//! Range: any render; what cannot be divided or continued is refused before the first sample.
//! Source: none needed. Tested in `cli/tests/command/shards.rs` and `cli/tests/command/checkpoints.rs`.

use super::checkpoint::save_over;
use crate::args::{RenderArguments, StateArguments};
use crate::damaged;
use crate::output::ConsoleObserver;
use etendue::internals::image::atomic::check_creatable;
use etendue::internals::render::RenderObserver;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::session::{Rendering, Session};
use etendue::internals::state::{Fingerprint, State, StateHeader, read_header};
use etendue::{Error, ErrorKind, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Whether this is the name of a state file.
pub fn is_state(path: &Path) -> bool {
    path.extension()
        .is_some_and(|it| it.eq_ignore_ascii_case("etd"))
}

/// Whether two paths are the same file, which need not exist.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| {
        let folder = path.parent().filter(|it| !it.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
        let whole = folder.join(path.file_name()?);
        // The last part may be a link.
        Some(whole.canonicalize().unwrap_or(whole))
    };
    a == b || resolved(a).is_some_and(|it| resolved(b) == Some(it))
}

/// Checks that the state files can be written, and that a shard has one.
pub fn check(arguments: &RenderArguments, outputs: &[PathBuf]) -> Result<()> {
    let state = &arguments.state;
    if state.shard.is_some() && !outputs.iter().all(|path| is_state(path)) {
        return Err(Error::usage(
            "a shard is written to a state file, such as -o part.etd: `etendue merge` makes the image",
        ));
    }
    let is_output = |path: &&PathBuf| outputs.iter().any(|output| is_same_file(output, path));
    if let Some(checkpoint) = state.checkpoint.as_ref().filter(is_output) {
        return Err(Error::usage(
            "is the output, too: a checkpoint there would look like the whole render",
        )
        .in_file(checkpoint));
    }
    if let (true, Some(file), Some(checkpoint)) =
        (state.set_damaged_aside, &state.resume, &state.checkpoint)
        && !is_same_file(file, checkpoint)
    {
        return Err(Error::usage(format!(
            "--set-damaged-aside is for the checkpoint, {}, and --resume names another file",
            checkpoint.display()
        ))
        .in_file(file));
    }
    for shared in [&state.cache, &state.choices].into_iter().flatten() {
        if !shared.exists() {
            check_creatable(shared)?;
        }
    }
    let states = outputs.iter().filter(|path| is_state(path));
    let mut all = states
        .map(PathBuf::as_path)
        .chain(state.checkpoint.as_deref());
    let pilot = state.pilot.as_deref();
    let is_pilot = |path: &Path| pilot.is_some_and(|pilot| is_same_file(pilot, path));
    all.try_for_each(|path| match is_pilot(path) {
        true => Err(Error::usage("is the pilot, which all shards need").in_file(path)),
        false => check_creatable(path),
    })
}

/// Checks that a render that begins may replace a checkpoint: one with samples may be of hours that nobody wants to lose,
/// and what is no checkpoint is not to be lost either.
fn check_replaceable(checkpoint: &Path) -> Result<()> {
    match read_header(checkpoint) {
        Ok(header) if header.samples() > 0 || header.is_uneven => Err(Error::usage(format!(
            "has samples already, {} of every pixel: --resume {} continues from them; delete the file to begin anew",
            header.samples(),
            checkpoint.display()
        ))
        .in_file(checkpoint)),
        Ok(_) => Ok(()),
        // An empty file, such as a temporary one, has nothing to lose.
        Err(error) if fs::metadata(checkpoint).is_ok_and(|it| it.is_file() && it.len() > 0) => {
            Err(error)
        }
        Err(_) => Ok(()),
    }
}

/// Begins a render, or continues from the state that the arguments name.
pub fn start(
    arguments: &RenderArguments,
    session: &Session,
    options: &RenderOptions,
    console: &ConsoleObserver,
) -> Result<Rendering> {
    let state = &arguments.state;
    let pilot = match &state.pilot {
        Some(file) => Some((file.as_path(), State::read(file)?)),
        None => None,
    };
    let continued = match &state.resume {
        Some(file) => read_to_continue(state, file, console)?.map(|old| (file.as_path(), old)),
        None => None,
    };
    match continued {
        Some((file, old)) => {
            let options = with_limit_of(options, &old.header);
            let known = Some(&old.header.identity);
            let mut rendering = begin(state, session, &options, known, console)?;
            distribute(&mut rendering, session, pilot.as_ref())?;
            let continued = rendering.continue_from(session, old);
            continued.map_err(|error| error.in_file(file))?;
            check_shard(arguments, &rendering, file)?;
            Ok(rendering)
        }
        None => start_anew(arguments, session, options, pilot, console),
    }
}

/// Begins a render that has no samples but those of its pilot.
fn start_anew(
    arguments: &RenderArguments,
    session: &Session,
    options: &RenderOptions,
    pilot: Option<(&Path, State)>,
    console: &ConsoleObserver,
) -> Result<Rendering> {
    let state = &arguments.state;
    if let Some(checkpoint) = &state.checkpoint {
        check_replaceable(checkpoint)?;
    }
    let known = pilot.as_ref().map(|(_, it)| &it.header.identity);
    let mut rendering = begin(state, session, options, known, console)?;
    match (pilot, state.shard) {
        (Some((file, pilot)), None) => {
            let continued = rendering.continue_after(session, pilot);
            continued.map_err(|error| error.in_file(file))?;
        }
        (pilot, Some(shard)) => {
            distribute(&mut rendering, session, pilot.as_ref())?;
            rendering.restrict(shard)?;
        }
        (None, None) => {
            if state.checkpoint.is_some() || arguments.out.iter().any(|path| is_state(path)) {
                rendering.check_can_be_kept()?;
            }
        }
    }
    Ok(rendering)
}

/// The options of a render that continues: with the limit that it had, unless they have one.
fn with_limit_of(options: &RenderOptions, header: &StateHeader) -> RenderOptions {
    let mut options = options.clone();
    let has_limit = options.time.is_some() || options.error.is_some() || options.spp.is_some();
    if !has_limit {
        options.spp = header.spp.or(header.limit);
        if let Some(target) = header.planner.and_then(|planner| planner.target()) {
            options.error = Some(target.rel_rmse);
            options.confidence = options.confidence.or(Some(target.confidence));
        }
    }
    options
}

/// Checks that a render that continues from a file is the shard, or the whole render, that the arguments name.
fn check_shard(arguments: &RenderArguments, rendering: &Rendering, file: &Path) -> Result<()> {
    if let Some(samples) = rendering.shard()
        && (arguments.out.is_empty() || !arguments.out.iter().all(|path| is_state(path)))
    {
        return Err(Error::usage(format!(
            "is the state of the shard of samples {}..{}, which is written to a state file, such as -o part.etd: `etendue merge` makes the image",
            samples.start, samples.end
        ))
        .in_file(file));
    }
    let Some(shard) = arguments.state.shard else {
        return Ok(());
    };
    let all = rendering.divisible()?;
    let wanted = shard.samples_after(all.start, all.end)?;
    if rendering.shard().as_ref() == Some(&wanted) {
        return Ok(());
    }
    let has = match rendering.shard() {
        Some(samples) => format!("the shard of samples {}..{}", samples.start, samples.end),
        None => "a whole render".to_owned(),
    };
    Err(Error::usage(format!(
        "is the state of {has}, not of the shard of samples {}..{}",
        wanted.start, wanted.end
    ))
    .in_file(file))
}

/// Begins a render with the choices of a state of it, or of the file that the arguments name, or of pilots.
fn begin(
    arguments: &StateArguments,
    session: &Session,
    options: &RenderOptions,
    known: Option<&Fingerprint>,
    console: &ConsoleObserver,
) -> Result<Rendering> {
    let Some(file) = &arguments.choices else {
        return session.start_with_choices(options, known, console);
    };
    let shared = file.exists().then(|| Fingerprint::read(file)).transpose()?;
    let rendering = session.start_with_choices(options, known.or(shared.as_ref()), console)?;
    let own = rendering.identity(session)?;
    match shared {
        Some(shared) => {
            let differences = own.differences(&shared, "this render", "the file");
            match differences.is_empty() {
                true => Ok(rendering),
                false => Err(Error::usage(format!(
                    "has the choices of another render: {}",
                    differences.join("; ")
                ))
                .in_file(file)),
            }
        }
        // Pilots that were cut choose otherwise.
        None if console.is_cancelled() => Ok(rendering),
        None => own.write(file).map(|()| rendering),
    }
}

/// Reads the state that a render continues from; `None` if it was damaged and is set aside.
fn read_to_continue(
    arguments: &StateArguments,
    file: &Path,
    console: &ConsoleObserver,
) -> Result<Option<State>> {
    let is_another = |kept: &&PathBuf| !is_same_file(kept, file);
    if let Some(kept) = arguments.checkpoint.as_ref().filter(is_another) {
        check_replaceable(kept)?;
    }
    let unusable = match State::read(file) {
        Ok(old) => return Ok(Some(old)),
        Err(error) => error,
    };
    let aside = match arguments.set_damaged_aside {
        true => damaged::set_aside(file)?,
        false => None,
    };
    let Some(note) = aside else {
        return Err(unusable);
    };
    console.warn(&format!("warning: {note}, and the render begins anew"));
    Ok(None)
}

/// Lets the pilot of this file distribute the samples of a render, if there is one.
fn distribute(
    rendering: &mut Rendering,
    session: &Session,
    pilot: Option<&(&Path, State)>,
) -> Result<()> {
    match pilot {
        Some((file, pilot)) => rendering
            .distribute_by(session, pilot)
            .map_err(|error| error.in_file(file)),
        None => Ok(()),
    }
}

/// Writes the state files of a render that has ended.
pub fn write(
    arguments: &RenderArguments,
    session: &Session,
    rendering: &Rendering,
    outputs: &[PathBuf],
) -> Result<()> {
    let checkpoint = arguments.state.checkpoint.as_deref();
    let is_cancelled = rendering.rendered().cancelled;
    // Markov chains that were cut do not replace the last whole state.
    let noted = |saved: Result<()>| match saved {
        Err(error) if is_cancelled && error.kind() == ErrorKind::Usage => {
            if !arguments.quiet {
                say!("note: {error}");
            }
            Ok(())
        }
        other => other,
    };
    // A render that continues from a checkpoint traces the first hits of its layers anew: a checkpoint has none.
    let keep = |path: &Path| {
        let header = rendering.header(session)?;
        save_over(header, rendering.rendered(), path)
    };
    let kept = checkpoint.map_or(Ok(()), |path| noted(keep(path)));
    // An interrupted render continues from its checkpoint: its outputs would look like those of a whole one.
    if checkpoint.is_some() && is_cancelled {
        return kept;
    }
    let states = outputs.iter().filter(|path| is_state(path));
    let write = |path: &Path| noted(rendering.save(session, path));
    states.fold(kept, |so_far, path| so_far.and(write(path)))
}
