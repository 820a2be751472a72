//! Shards of adaptive renders: the pilot and the ranges of levels after it merge to the bits of one render.

use crate::common::scene_folder::SMALL;
use crate::common::session::{CancelAfter, folder, session};
use etendue::internals::image::LayeredImage;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::settings::{Adaptive, LightPathRule, SamplerKind};
use etendue::internals::render::{NullRenderObserver, RenderObserver};
use etendue::internals::session::layers::with_film;
use etendue::internals::session::{Rendering, Session};
use etendue::internals::state::{Merge, Shard, State};
use std::path::{Path, PathBuf};
use std::time::Duration;

fn adaptive(sampler: SamplerKind, spp: u64) -> RenderOptions {
    let mut options = RenderOptions::samples(spp);
    options.sampler = Some(sampler);
    options.adaptive = Some(Adaptive::TwoPhase);
    options
}

/// Begins a shard of the pilot, or given the pilot of the samples after it.
fn begun(
    session: &Session,
    options: &RenderOptions,
    pilot: Option<&Path>,
    shard: Shard,
) -> Rendering {
    let mut rendering = session.start(options).expect("valid options");
    if let Some(pilot) = pilot {
        let pilot = State::read(pilot).expect("it is whole");
        let followed = rendering.distribute_by(session, &pilot);
        followed.expect("its pilot");
    }
    rendering.restrict(shard).expect("it can be divided");
    rendering
}

fn finish(rendering: &mut Rendering, session: &Session, observer: &dyn RenderObserver) {
    let until = rendering.budget();
    let rendered = rendering.continue_until(session, until, observer);
    rendered.expect("it renders");
}

/// Renders a shard to a file.
fn shard(
    session: &Session,
    options: &RenderOptions,
    pilot: Option<&Path>,
    shard: Shard,
    file: &Path,
) {
    let mut rendering = begun(session, options, pilot, shard);
    finish(&mut rendering, session, &NullRenderObserver);
    rendering.save(session, file).expect("it is written");
}

/// Renders the pilot in two parts, merges them and writes the state.
fn pilot(session: &Session, options: &RenderOptions, end: u64, folder: &Path) -> PathBuf {
    let parts = [[0, 12], [12, end]].map(|[first, end]| {
        let file = folder.join(format!("pilot-{first}.etd"));
        shard(session, options, None, Shard::Samples { first, end }, &file);
        file
    });
    let file = folder.join(format!("pilot-of-{end}.etd"));
    let pilot = Merge::of(&parts).and_then(Merge::sum);
    pilot
        .expect("they are whole")
        .write(&file)
        .expect("it is written");
    file
}

fn merged(files: &[PathBuf]) -> State {
    let merge = Merge::of(files).expect("they belong together");
    assert!(merge.missing().is_empty(), "{:?}", merge.missing());
    merge.sum().expect("they are whole")
}

/// Asserts that a state has the sums of a render, to the last bit.
#[track_caller]
fn assert_same(state: &State, whole: &Rendering, what: &str) {
    assert!(state.film.develop() == whole.image(), "{what}: the image");
    for (a, b) in state.film.tiles().iter().zip(whole.film().tiles()) {
        assert!(a.pixels == b.pixels, "{what}: sums of {:?}", a.window);
        assert_eq!(a.counts, b.counts, "{what}");
        assert_eq!(a.rays, b.rays, "{what}");
        assert_eq!(a.samples, b.samples, "{what}");
    }
    assert_eq!(state.header.rays, whole.rendered().rays, "{what}");
    assert_eq!(state.header.samples(), whole.spp(), "{what}");
    assert!(!state.header.is_uneven);
    assert!(state.header.equivalent_spp.is_some());
    assert_eq!(
        state.header.equivalent_spp,
        whole.rendered().equivalent_spp,
        "{what}"
    );
}

#[test]
fn merged_adaptive_shards_are_bit_identical_to_one_render() {
    let (none, half) = (LightPathShare::None, LightPathShare::Half);
    for (sampler, light_paths, spp, end, divisions) in [
        (
            SamplerKind::Sobol,
            none,
            320,
            64,
            &[(2, 1), (7, 2), (64, 2)][..],
        ),
        (SamplerKind::Sobol, half, 192, 48, &[(7, 2)][..]),
        (
            SamplerKind::Stratified,
            none,
            202,
            52,
            &[(2, 1), (7, 2)][..],
        ),
    ] {
        let mut options = adaptive(sampler, spp);
        options.light_paths = Some(LightPathRule::Share(light_paths));
        options.layers = true;
        let at_once = session(SMALL, 2);
        let whole = at_once.render(&options, &NullRenderObserver);
        let whole = whole.expect("valid options");
        let counts = whole.film().sample_counts();
        assert!(counts.iter().min() < counts.iter().max());
        for &(of, threads) in divisions {
            let what = format!(
                "{sampler:?}, {} light paths, {of} shards",
                light_paths.name()
            );
            let (folder, session) = (folder(), session(SMALL, threads));
            let pilot = pilot(&session, &options, end, folder.path());
            let mut files = vec![pilot.clone()];
            for index in 0..of {
                let file = folder.path().join(format!("part-{index}.etd"));
                let part = Shard::Part { index, of };
                shard(&session, &options, Some(&pilot), part, &file);
                files.push(file);
            }
            files.reverse();
            files.swap(0, of as usize / 2);
            let state = merged(&files);
            assert_same(&state, &whole, &what);
            let [a, b] = [state.error(0.9), whole.error(0.9)].map(|it| it.expect("it is known"));
            assert_eq!(a.rel_rmse, b.rel_rmse, "{what}");
            assert!(a.doubt.is_some() || state.needed_spp(0.01, 0.9) > Some(spp));

            let layers = with_film(state.layers.clone(), &state.film);
            let LayeredImage { layers: want, .. } = whole.layered(&at_once).expect("it has layers");
            assert!(layers == want, "{what}: layers");

            // Half of the files merged first, and the state of that read again.
            let half = folder.path().join("half.etd");
            merged_partly(&files[..3]).write(&half).expect("written");
            let rest: Vec<PathBuf> = files[3..].iter().cloned().chain([half]).collect();
            let state = merged(&rest);
            assert!(state.film.develop() == whole.image(), "{what}, twice");
            assert_eq!(state.film.sample_counts(), counts);
        }
    }
}

/// Merges files although samples are missing. Pixels without samples are flagged.
fn merged_partly(files: &[PathBuf]) -> State {
    let state = Merge::of(files).and_then(Merge::sum).expect("whole files");
    let bars = state.film.error_bars();
    for (count, flag) in state.film.sample_counts().iter().zip(bars.flags) {
        assert!(*count >= 4 || flag);
    }
    state
}

#[test]
fn killed_and_resumed_adaptive_shards_are_bit_identical_to_one_render() {
    let options = adaptive(SamplerKind::Sobol, 200);
    let whole = session(SMALL, 2).render(&options, &NullRenderObserver);
    let whole = whole.expect("valid options");
    let folder = folder();
    let file = |name: &str| folder.path().join(name);
    // Renders a shard that is interrupted twice, on one thread and on two.
    let interrupted = |pilot: Option<&Path>, part: Shard, name: &str| {
        let (first, then) = (session(SMALL, 1), session(SMALL, 2));
        let mut rendering = begun(&first, &options, pilot, part);
        finish(&mut rendering, &first, &CancelAfter::tiles(1));
        assert!(rendering.rendered().is_uneven);
        rendering.save(&first, &file(name)).expect("written");
        let refused = Merge::of(&[file(name)]).expect_err("it is uneven");
        assert!(refused.to_string().contains("--resume"), "{refused}");
        for observer in [CancelAfter::tiles(3), CancelAfter::tiles(u64::MAX)] {
            let state = State::read(&file(name)).expect("it is whole");
            let mut rendering = then.start(&options).expect("valid options");
            if let Some(pilot) = pilot {
                let pilot = State::read(pilot).expect("it is whole");
                rendering.distribute_by(&then, &pilot).expect("its pilot");
            }
            rendering.continue_from(&then, state).expect("its state");
            finish(&mut rendering, &then, &observer);
            rendering.save(&then, &file(name)).expect("written");
        }
        file(name)
    };
    let all = Shard::Samples { first: 0, end: 52 };
    let pilot = interrupted(None, all, "pilot.etd");
    let [a, b] = [0, 1].map(|index| {
        let part = Shard::Part { index, of: 2 };
        interrupted(Some(&pilot), part, &format!("part-{index}.etd"))
    });
    assert_same(&merged(&[b, pilot, a]), &whole, "resumed");
}

#[test]
fn render_continued_after_its_pilot_is_bit_identical_to_one_render() {
    let folder = folder();
    let session = session(SMALL, 2);
    let options = adaptive(SamplerKind::Sobol, 200);
    let whole = session
        .render(&options, &NullRenderObserver)
        .expect("valid options");
    let file = pilot(&session, &options, 52, folder.path());
    let read = |file: &Path| State::read(file).expect("it is whole");
    let mut rendering = session.start(&options).expect("valid options");
    rendering
        .continue_after(&session, read(&file))
        .expect("its pilot");
    finish(&mut rendering, &session, &CancelAfter::tiles(3));
    let checkpoint = folder.path().join("checkpoint.etd");
    rendering.save(&session, &checkpoint).expect("written");
    let mut rendering = session.start(&options).expect("valid options");
    let state = read(&checkpoint);
    rendering
        .distribute_by(&session, &read(&file))
        .expect("its pilot");
    rendering.continue_from(&session, state).expect("its state");
    finish(&mut rendering, &session, &NullRenderObserver);
    let parts = folder.path().join("whole.etd");
    rendering.save(&session, &parts).expect("written");
    assert_same(&merged(std::slice::from_ref(&parts)), &whole, "continued");

    // The pilot's file as a checkpoint.
    let mut rendering = session.start(&options).expect("valid options");
    let resumed = rendering.continue_from(&session, read(&file));
    resumed.expect("its state");
    finish(&mut rendering, &session, &NullRenderObserver);
    assert!(rendering.image() == whole.image());

    // Another round, by the same pilot.
    let options = adaptive(SamplerKind::Sobol, 400);
    let more = folder.path().join("more.etd");
    let round = Shard::Samples {
        first: 200,
        end: 400,
    };
    shard(&session, &options, Some(&file), round, &more);
    let mut longer = session.start(&options).expect("valid options");
    longer
        .continue_after(&session, read(&file))
        .expect("its pilot");
    finish(&mut longer, &session, &NullRenderObserver);
    let both = merged(&[parts, more]);
    assert!(both.film.develop() == longer.image());
    assert_eq!(both.film.sample_counts(), longer.film().sample_counts());
    let error = both.error(0.95).expect("it is known");
    assert!(error.doubt.is_some() || both.needed_spp(0.01, 0.95) > Some(400));
}

/// The first checkpoints are of the pilot, the others have its allocation. No file of the pilot is needed.
#[test]
fn killed_and_resumed_adaptive_render_is_bit_identical_to_one_render() {
    let folder = folder();
    let checkpoint = folder.path().join("checkpoint.etd");
    let options = adaptive(SamplerKind::Sobol, 200);
    let whole = session(SMALL, 2).render(&options, &NullRenderObserver);
    let whole = whole.expect("valid options");
    let mut in_pilot = vec![];
    for kill in 0.. {
        let session = session(SMALL, 1 + kill % 2);
        let mut rendering = session.start(&options).expect("valid options");
        if kill > 0 {
            let state = State::read(&checkpoint).expect("it is whole");
            in_pilot.push(state.allocation.is_none());
            rendering.continue_from(&session, state).expect("its state");
        }
        finish(
            &mut rendering,
            &session,
            &CancelAfter::tiles(2 + 3 * kill as u64),
        );
        rendering.save(&session, &checkpoint).expect("written");
        if !rendering.rendered().cancelled {
            break;
        }
    }
    assert!(
        in_pilot.contains(&true) && in_pilot.contains(&false),
        "{in_pilot:?}"
    );
    let state = State::read(&checkpoint).expect("it is whole");
    assert_same(&state, &whole, "resumed");

    // Another pilot's allocation is noticed, although its numbers are finite.
    let mut damaged = state.clone();
    let pilot = damaged.header.pilot.as_mut().expect("it is adaptive");
    pilot.samples += 4;
    damaged.write(&checkpoint).expect("written");
    let error = State::read(&checkpoint).expect_err("the allocation is of another pilot");
    assert!(
        error.to_string().contains("the allocation of its pilot"),
        "{error}"
    );
}

#[test]
fn wrong_pilots_are_rejected() {
    let folder = folder();
    let file = |name: &str| folder.path().join(name);
    let session = session(SMALL, 2);
    let options = adaptive(SamplerKind::Sobol, 200);
    let read = |file: &Path| State::read(file).expect("it is whole");
    let good = pilot(&session, &options, 52, folder.path());
    let refused = |options: &RenderOptions, pilot: &Path, words: &str| {
        let mut rendering = session.start(options).expect("valid options");
        let error = rendering.distribute_by(&session, &read(pilot));
        let error = error.expect_err(words).to_string();
        assert!(error.contains(words), "no `{words}` in: {error}");
    };
    refused(&options, &file("pilot-0.etd"), "it has 0..12");
    let mut other = options.clone();
    other.seed = Some(1);
    refused(&other, &good, "seed is 1 in this render");
    other = options.clone();
    other.adaptive = Some(Adaptive::Off);
    refused(&other, &good, "--adaptive");
    let part = Shard::Samples {
        first: 52,
        end: 100,
    };
    shard(&session, &options, Some(&good), part, &file("part.etd"));
    refused(
        &options,
        &file("part.etd"),
        "samples that a pilot distributed",
    );

    // A shard of one pilot is not continued by another, and not merged with one.
    let short = adaptive(SamplerKind::Sobol, 100);
    let short = pilot(&session, &short, 28, folder.path());
    let resumed = |pilot: Option<&Path>, state: &Path| {
        let mut rendering = session.start(&options).expect("valid options");
        if let Some(pilot) = pilot {
            let followed = rendering.distribute_by(&session, &read(pilot));
            followed.expect("a pilot");
        }
        let continued = rendering.continue_from(&session, read(state));
        continued.expect_err("the wrong pilot").to_string()
    };
    let part = file("part.etd");
    assert!(resumed(Some(&short), &part).contains("another pilot"));
    assert!(resumed(None, &part).contains("--pilot"));
    assert!(resumed(Some(&short), &good).contains("it is of a pilot"));
    let merge = |files: [&PathBuf; 2]| -> String {
        let merge = Merge::of(&files.map(Clone::clone)).and_then(Merge::sum);
        merge.expect_err("different pilots").to_string()
    };
    let rest = file("rest.etd");
    let after = Shard::Samples {
        first: 100,
        end: 200,
    };
    shard(&session, &options, Some(&short), after, &rest);
    assert!(merge([&part, &rest]).contains("another pilot"));
    let long = adaptive(SamplerKind::Sobol, 2000);
    let beyond = file("beyond.etd");
    let even = Shard::Samples {
        first: 100,
        end: 124,
    };
    shard(&session, &long, None, even, &beyond);
    assert!(merge([&part, &beyond]).contains("beyond its pilot"));

    // Other sums than those that distributed the samples.
    let mut changed = read(&good);
    changed.film.tiles_mut()[0].pixels[0].add(0, Rgb::grey(1e3));
    changed.write(&file("changed.etd")).expect("written");
    assert!(merge([&file("changed.etd"), &part]).contains("another pilot"));
    let samples = merged_partly(&[good, part]).header.samples();
    assert_eq!(samples, 100);
}

#[test]
fn shards_beyond_the_pilot_need_it() {
    let session = session(SMALL, 1);
    let options = adaptive(SamplerKind::Sobol, 200);
    for part in [
        Shard::Part { index: 0, of: 2 },
        Shard::Samples { first: 0, end: 56 },
    ] {
        let mut rendering = session.start(&options).expect("valid options");
        let error = rendering.restrict(part).expect_err("there is no pilot");
        let error = error.to_string();
        assert!(error.contains("--shard 0..52"), "{error}");
        assert!(error.contains("--pilot"), "{error}");
    }
}

/// Asks for a checkpoint after every pass, which makes passes short.
struct EveryPass;

impl RenderObserver for EveryPass {
    fn checkpoint_interval(&self) -> Option<Duration> {
        Some(Duration::ZERO)
    }
}

#[test]
fn checkpoints_leave_adaptive_renders_to_an_error_as_they_are() {
    let session = session(SMALL, 2);
    let mut options = RenderOptions::default();
    options.adaptive = Some(Adaptive::TwoPhase);
    options.error = Some(0.02);
    let [whole, kept] = [&NullRenderObserver as &dyn RenderObserver, &EveryPass].map(|observer| {
        let rendering = session.render(&options, observer);
        rendering.expect("valid options")
    });
    let counts = whole.film().sample_counts();
    assert!(counts.iter().min() < counts.iter().max());
    assert_eq!(counts, kept.film().sample_counts());
    assert!(whole.image() == kept.image());
}
