//! State files: shards that merge to the bits of one render, renders that continue from a file, and damaged files.

use crate::common::scene_folder::SMALL;
use crate::common::session::{CancelAfter, folder, session};
use etendue::internals::film::filter::FilterSampling;
use etendue::internals::image::LayeredImage;
use etendue::internals::image::atomic::ExistingFile;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::settings::{Adaptive, BounceLimit, Budget, SamplerKind};
use etendue::internals::render::{NullRenderObserver, RenderObserver};
use etendue::internals::session::layers::with_film;
use etendue::internals::session::{Rendering, Session};
use etendue::internals::state::{FORMAT, Merge, Shard, State, with_checksum};
use etendue::{Error, ErrorKind};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The small scene with a sky alone and matte surfaces, whose error is not in doubt.
fn matte() -> String {
    let matte = "type = \"diffuse\"\nreflectance = 0.5";
    SMALL
        .replace("type = \"dielectric\"", matte)
        .replace(
            "type = \"conductor\"\npreset = \"gold\"\nroughness = 0.4",
            matte,
        )
        .replace("emission = [12, 11, 10]", "")
}

fn options(integrator: IntegratorKind, spp: u64) -> RenderOptions {
    let mut options = RenderOptions::samples(spp);
    options.integrator = Some(integrator);
    options
}

/// Renders a shard to a file.
fn shard(session: &Session, options: &RenderOptions, shard: Shard, file: &Path) {
    let mut rendering = session.start(options).expect("valid options");
    rendering.restrict(shard).expect("it can be divided");
    let until = rendering.budget();
    rendering
        .continue_until(session, until, &NullRenderObserver)
        .expect("it renders");
    rendering.save(session, file).expect("it is written");
}

/// Renders all shards to files.
fn shards(session: &Session, options: &RenderOptions, of: u64, folder: &TempDir) -> Vec<PathBuf> {
    let one = |index| {
        let file = folder.path().join(format!("part-{index}-of-{of}.etd"));
        shard(session, options, Shard::Part { index, of }, &file);
        file
    };
    (0..of).map(one).collect()
}

fn merged(files: &[PathBuf]) -> State {
    let merge = Merge::of(files).expect("they belong together");
    merge.sum().expect("they are whole")
}

/// Asserts that the sums of a state are those of a render, to the last bit.
#[track_caller]
fn assert_same(state: &State, whole: &Rendering, what: &str) {
    let film = whole.film();
    assert!(
        state.film.develop() == film.develop(),
        "{what}: the image differs"
    );
    for (a, b) in state.film.tiles().iter().zip(film.tiles()) {
        assert!(
            a.pixels == b.pixels,
            "{what}: sums of {:?} differ",
            a.window
        );
        assert!(
            a.splatted == b.splatted,
            "{what}: sums of {:?} and its halo differ",
            a.window
        );
        assert_eq!(a.samples, b.samples, "{what}");
    }
    let pixels = film.window().pixel_count() as usize;
    for pixel in 0..pixels {
        assert_eq!(
            state.film.batch_means(pixel),
            film.batch_means(pixel),
            "{what}"
        );
    }
    assert_eq!(state.header.rejected, whole.rendered().rejected, "{what}");
    assert_eq!(state.header.samples(), whole.spp(), "{what}");
}

#[test]
fn merged_shards_are_bit_identical_to_one_render() {
    let folder = folder();
    for (integrator, sampler, spp) in [
        (IntegratorKind::Path, SamplerKind::Sobol, 256),
        (IntegratorKind::Path, SamplerKind::Stratified, 258),
        (IntegratorKind::Naive, SamplerKind::Independent, 30),
        (IntegratorKind::Bidirectional, SamplerKind::Sobol, 256),
        (IntegratorKind::IrradianceCache, SamplerKind::Sobol, 30),
        (IntegratorKind::AmbientOcclusion, SamplerKind::Sobol, 30),
        (IntegratorKind::Metropolis, SamplerKind::Sobol, 256),
    ] {
        let mut options = options(integrator, spp);
        options.sampler = Some(sampler);
        options.max_bounces = Some(BounceLimit::AtMost(6));
        let whole = session(SMALL, 2).render(&options, &NullRenderObserver);
        let whole = whole.expect("valid options");
        for (of, threads) in [(2, 1), (7, 2), (64, 1)] {
            if of > spp / 4 {
                continue;
            }
            let mut files = shards(&session(SMALL, threads), &options, of, &folder);
            files.reverse();
            files.swap(0, of as usize / 2);
            let state = merged(&files);
            assert_same(&state, &whole, &format!("{integrator:?} {sampler:?} {of}"));
            if integrator != IntegratorKind::IrradianceCache {
                assert_eq!(state.header.rays, whole.rendered().rays);
            }
        }
    }
}

#[test]
fn merged_layers_and_error_bars_equal_those_of_one_render() {
    let folder = folder();
    let mut options = options(IntegratorKind::Path, 62);
    options.layers = true;
    let session = session(SMALL, 2);
    let whole = session
        .render(&options, &NullRenderObserver)
        .expect("valid options");
    let files = shards(&session, &options, 5, &folder);
    let state = merged(&files);
    assert_same(&state, &whole, "with layers");
    let layers = with_film(state.layers.clone(), &state.film);
    let LayeredImage { layers: want, .. } = whole.layered(&session).expect("it has layers");
    let names = |layers: &[etendue::Layer]| -> Vec<String> {
        layers.iter().map(|layer| layer.name.clone()).collect()
    };
    assert_eq!(names(&layers), names(&want));
    for (a, b) in layers.iter().zip(&want) {
        assert!(a.samples == b.samples, "{} differs", a.name);
    }
}

#[test]
fn partial_merges_merge_to_the_full_render() {
    let folder = folder();
    let options = options(IntegratorKind::Bidirectional, 32);
    let session = session(SMALL, 2);
    let whole = session
        .render(&options, &NullRenderObserver)
        .expect("valid options");
    let files = shards(&session, &options, 8, &folder);
    let halves = [[0, 3, 5, 6], [1, 2, 4, 7]].map(|indices| {
        let files: Vec<PathBuf> = indices.iter().map(|&i| files[i].clone()).collect();
        let half = folder.path().join(format!("half-{}.etd", indices[0]));
        merged(&files).write(&half).expect("it is written");
        half
    });
    assert_same(&merged(&halves), &whole, "merged twice");
    let refused = State::read(&halves[0]).expect("whole");
    let refused = session.resume(&options, refused, &NullRenderObserver).err();
    assert!(
        refused
            .expect("it has gaps")
            .to_string()
            .contains("missing")
    );
}

#[test]
fn resuming_a_state_file_equals_an_uninterrupted_render() {
    let folder = folder();
    let file = folder.path().join("state.etd");
    for integrator in [IntegratorKind::Path, IntegratorKind::Bidirectional] {
        let options = options(integrator, 20);
        let whole = session(SMALL, 2).render(&options, &NullRenderObserver);
        let whole = whole.expect("valid options");
        for tiles in [1, 5, 9] {
            let begun = session(SMALL, 1);
            let mut rendering = begun.start(&options).expect("valid options");
            let until = rendering.budget();
            rendering
                .continue_until(&begun, until, &CancelAfter::tiles(tiles))
                .expect("it renders");
            assert!(rendering.rendered().cancelled);
            rendering.save(&begun, &file).expect("it is written");
            let other = session(SMALL, 2);
            let state = State::read(&file).expect("it is whole");
            let mut rendering = other
                .resume(&options, state, &NullRenderObserver)
                .expect("its state");
            rendering
                .continue_until(&other, until, &NullRenderObserver)
                .expect("it renders");
            assert!(rendering.image() == whole.image(), "{integrator:?} {tiles}");
            assert_eq!(rendering.rendered().rays, whole.rendered().rays);
        }
    }
}

#[test]
fn interrupted_render_without_known_samples_saves_no_layers() {
    let folder = folder();
    let file = folder.path().join("state.etd");
    let session = session(&matte(), 1);
    let mut options = RenderOptions::default();
    options.error = Some(0.05);
    options.layers = true;
    let mut rendering = session.start(&options).expect("valid options");
    let until = rendering.budget();
    rendering
        .continue_until(&session, until, &CancelAfter::tiles(5))
        .expect("it renders");
    assert!(rendering.rendered().cancelled);
    rendering.save(&session, &file).expect("it is written");
    let state = State::read(&file).expect("it is whole");
    assert!(state.header.wants_layers && state.layers.is_empty());
    rendering
        .continue_until(&session, until, &NullRenderObserver)
        .expect("it renders");
    rendering.save(&session, &file).expect("it is written");
    let state = State::read(&file).expect("it is whole");
    assert!(!state.layers.is_empty());
}

#[test]
fn shard_is_not_resumed_to_an_error() {
    let folder = folder();
    let file = folder.path().join("part.etd");
    let session = session(SMALL, 1);
    let mut options = options(IntegratorKind::Path, 16);
    let first = Shard::Part { index: 0, of: 2 };
    shard(&session, &options, first, &file);
    options.error = Some(0.1);
    let state = State::read(&file).expect("it is whole");
    let refused = session.resume(&options, state, &NullRenderObserver);
    let refused = refused.expect_err("a shard has a known number of samples");
    assert_eq!(refused.kind(), ErrorKind::Usage);
    assert!(refused.to_string().contains("--error"), "{refused}");
}

#[test]
fn state_resumes_to_more_samples_and_to_an_error_target() {
    let folder = folder();
    let file = folder.path().join("state.etd");
    let session = session(&matte(), 2);
    let resumed = |options: &RenderOptions| {
        let state = State::read(&file).expect("it is whole");
        let mut rendering = session
            .resume(options, state, &NullRenderObserver)
            .expect("its state");
        let until = rendering.budget();
        rendering
            .continue_until(&session, until, &NullRenderObserver)
            .expect("it renders");
        rendering
    };
    for integrator in [IntegratorKind::Path, IntegratorKind::Metropolis] {
        let few = session.render(&options(integrator, 32), &NullRenderObserver);
        few.expect("valid")
            .save(&session, &file)
            .expect("it is written");
        let more = options(integrator, 80);
        let whole = session
            .render(&more, &NullRenderObserver)
            .expect("valid options");
        assert!(resumed(&more).image() == whole.image(), "{integrator:?}");
    }

    // A render to an error, saved between two of its estimates, ends after as many samples.
    let mut to_error = RenderOptions::default();
    to_error.error = Some(0.02);
    let whole = session
        .render(&to_error, &NullRenderObserver)
        .expect("valid options");
    let checkpoints = Checkpoints(std::sync::Mutex::default());
    let mut again = session.start(&to_error).expect("valid options");
    let until = again.budget();
    again
        .continue_until(&session, until, &checkpoints)
        .expect("it renders");
    assert!(
        again.image() == whole.image(),
        "checkpoints changed the image"
    );
    let states = checkpoints.0.into_inner().expect("no thread panicked");
    assert!(states.len() > 3, "{}", states.len());
    let header = again.header(&session).expect("a header");
    for rendered in states {
        State::write_parts(
            &header.clone().of(&rendered, &[]),
            &rendered.film,
            &[],
            None,
            &file,
            ExistingFile::Replace,
        )
        .expect("it is written");
        let ended = resumed(&to_error);
        assert_eq!(ended.spp(), whole.spp(), "from {}", rendered.spp);
        assert!(ended.image() == whole.image());
        assert!(ended.rendered().reached);
    }
}

/// Keeps a copy of the render after every pass.
struct Checkpoints(std::sync::Mutex<Vec<etendue::Rendered>>);

impl RenderObserver for Checkpoints {
    fn checkpoint_interval(&self) -> Option<std::time::Duration> {
        Some(std::time::Duration::ZERO)
    }

    fn checkpoint(&self, rendered: &etendue::Rendered) {
        self.0
            .lock()
            .expect("no thread panicked")
            .push(rendered.clone());
    }
}

#[test]
fn merging_mismatched_shards_is_rejected_naming_both_files() {
    let folder = folder();
    let file = |name: &str| folder.path().join(name);
    let first = Shard::Part { index: 0, of: 2 };
    let second = Shard::Part { index: 1, of: 2 };
    let base = options(IntegratorKind::Path, 8);
    shard(&session(SMALL, 2), &base, first, &file("a.etd"));
    let differs = |other: &RenderOptions, text: &str, words: &[&str]| {
        shard(&session(text, 2), other, second, &file("b.etd"));
        let refused = Merge::of(&[file("a.etd"), file("b.etd")]).expect_err("they differ");
        assert_eq!(refused.kind(), ErrorKind::Usage, "{refused}");
        let message = refused.to_string();
        for word in [&["a.etd", "b.etd"], words].concat() {
            assert!(message.contains(word), "no `{word}` in: {message}");
        }
    };
    let mut other = base.clone();
    other.seed = Some(u64::MAX);
    differs(&other, SMALL, &["seed is 0 in", "18446744073709551615 in"]);
    other = base.clone();
    other.max_bounces = Some(BounceLimit::AtMost(3));
    differs(&other, SMALL, &["max_bounces is null in", "3 in"]);
    other = base.clone();
    other.filter_sampling = Some(FilterSampling::Importance);
    differs(
        &other,
        SMALL,
        &["filter_sampling is \"splatting\" in", "\"importance\" in"],
    );
    let tent = SMALL.replace("size = [24, 16]", "size = [24, 16]\nfilter = \"tent\"");
    differs(
        &base,
        &tent,
        &["filter is \"gaussian:1.5\" in", "\"tent:1\" in"],
    );
    let darker = SMALL.replace("[0.7, 0.2]", "[0.7, 0.25]");
    differs(&base, &darker, &["the scenes differ"]);

    // Whether named as such or not, roulette by this window is what `path` plays here.
    other = base.clone();
    other.roulette = etendue::WeightWindow::reciprocal_of(4).map(etendue::Roulette::Window);
    shard(&session(SMALL, 1), &other, second, &file("b.etd"));
    assert_eq!(merged(&[file("a.etd"), file("b.etd")]).header.samples(), 8);
    let doubled = Merge::of(&[file("a.etd"), file("b.etd"), file("a.etd")]);
    let message = doubled.expect_err("one is there twice").to_string();
    assert!(message.contains("doubled: 0..4 in"), "{message}");
    let gap = Merge::of(&[file("b.etd")]).expect("gaps are for the caller to judge");
    assert_eq!(gap.missing(), [[0, 4]]);
}

#[test]
fn merging_two_ragged_ranges_is_rejected_and_one_is_exact() {
    let folder = folder();
    let session = session(SMALL, 2);
    let options = options(IntegratorKind::Path, 32);
    let part = |[first, end]: [u64; 2], spp: u64| {
        let file = folder.path().join(format!("{first}-{spp}.etd"));
        let mut rendering = session.start(&options).expect("valid options");
        let shard = Shard::Samples { first, end };
        rendering.restrict(shard).expect("it can be divided");
        rendering
            .continue_until(&session, Budget::samples(spp), &NullRenderObserver)
            .expect("it renders");
        rendering.save(&session, &file).expect("it is written");
        file
    };
    let files = [part([0, 16], 7), part([16, 32], 6)];
    let refused = Merge::of(&files).expect_err("both end within a round");
    let message = refused.to_string();
    for word in ["0-7.etd", "16-6.etd", "within a round", "--resume"] {
        assert!(message.contains(word), "no `{word}` in: {message}");
    }
    let whole = part([0, 16], 16);
    let state = merged(&[files[1].clone(), whole]);
    let same = session.render(
        &self::options(IntegratorKind::Path, 22),
        &NullRenderObserver,
    );
    assert_same(&state, &same.expect("valid options"), "ragged");
}

#[test]
fn chains_of_a_shard_may_find_no_light() {
    let folder = folder();
    let dark = SMALL
        .replace("emission = [12, 11, 10]", "")
        .replace("radiance = [0.1, 0.12, 0.15]", "radiance = [0, 0, 0]");
    let session = session(&dark, 1);
    let options = options(IntegratorKind::Metropolis, 8);
    let whole = session.render(&options, &NullRenderObserver);
    let message = whole.expect_err("there is no light").to_string();
    assert!(message.contains("found any light"), "{message}");
    let state = merged(&shards(&session, &options, 2, &folder));
    assert_eq!(state.film.mean(), [0.0; 3]);
    assert_eq!(state.header.samples(), 8);
}

#[test]
fn unshardable_renders_are_rejected() {
    let session = session(SMALL, 1);
    let refused = |options: &RenderOptions| -> Error {
        let mut rendering = session.start(options).expect("valid options");
        let shard = Shard::Part { index: 0, of: 2 };
        rendering.restrict(shard).expect_err("it cannot be divided")
    };
    let mut adaptive = RenderOptions::samples(64);
    adaptive.adaptive = Some(Adaptive::TwoPhase);
    assert!(refused(&adaptive).to_string().contains("--adaptive=off"));
    assert!(refused(&adaptive).to_string().contains("--shard 0..16"));
    adaptive.adaptive = Some(Adaptive::Greedy);
    adaptive.error = Some(0.1);
    assert!(refused(&adaptive).to_string().contains("greedy"));
    let mut to_error = RenderOptions::samples(64);
    to_error.error = Some(0.1);
    assert!(refused(&to_error).to_string().contains("--spp"));
    let mut begun = session
        .render(&RenderOptions::samples(4), &NullRenderObserver)
        .expect("valid");
    assert!(begun.restrict(Shard::Samples { first: 0, end: 4 }).is_err());
    assert_eq!(begun.budget(), Budget::samples(4));
}

/// The bytes of a small state file with every part that there is.
fn small_file() -> Vec<u8> {
    let folder = folder();
    let file = folder.path().join("small.etd");
    let session = session(&SMALL.replace("size = [24, 16]", "size = [5, 3]"), 1);
    let mut options = options(IntegratorKind::Bidirectional, 8);
    options.layers = true;
    let rendering = session
        .render(&options, &NullRenderObserver)
        .expect("valid options");
    rendering.save(&session, &file).expect("it is written");
    fs::read(&file).expect("it is there")
}

#[test]
fn truncated_or_corrupt_state_file_is_rejected() {
    let whole = small_file();
    State::decode(&whole).expect("it is whole");
    for length in 0..whole.len() {
        let error = State::decode(&whole[..length]).expect_err("it was cut");
        assert_eq!(error.kind(), ErrorKind::Io, "{error}");
    }
    for bit in (0..8 * whole.len()).step_by(37) {
        let mut changed = whole.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        let error = State::decode(&changed).expect_err("a bit was flipped");
        assert_eq!(error.kind(), ErrorKind::Io, "{error}");
    }
    let mut other = whole.clone();
    other[8..12].copy_from_slice(&(FORMAT + 1).to_le_bytes());
    let message = State::decode(&other)
        .expect_err("another format")
        .to_string();
    assert!(
        [FORMAT, FORMAT + 1]
            .iter()
            .all(|it| message.contains(&format!("format {it}"))),
        "{message}"
    );
    let message = State::decode(b"").expect_err("empty").to_string();
    assert!(message.contains("empty"), "{message}");
    let message = State::decode(b"\x89PNG\r\n")
        .expect_err("an image")
        .to_string();
    assert!(message.contains("not a state file"), "{message}");

    // Of a file that is too long or too short in spite of a right checksum, the byte is named.
    let content = &whole[..whole.len() - 32];
    for wrong in [
        content[..content.len() - 3].to_vec(),
        [content, b"more"].concat(),
    ] {
        let message = State::decode(&with_checksum(wrong))
            .expect_err("damaged")
            .to_string();
        assert!(message.contains("at byte"), "{message}");
    }
}

#[test]
fn merge_reports_the_path_of_a_truncated_shard() {
    let folder = folder();
    let session = session(SMALL, 1);
    let files = shards(&session, &options(IntegratorKind::Path, 16), 4, &folder);
    let whole = fs::read(&files[2]).expect("it is there");
    for length in [0, 7, 15, 40, whole.len() / 2, whole.len() - 1] {
        fs::write(&files[2], &whole[..length]).expect("it is written");
        let error = Merge::of(&files)
            .and_then(Merge::sum)
            .expect_err("it was cut");
        assert_eq!(error.file(), Some(files[2].as_path()), "{error}");
    }
    fs::write(&files[2], whole).expect("it is written");
    assert_eq!(merged(&files).header.samples(), 16);
    assert!(Merge::of(&[]).is_err());
}
