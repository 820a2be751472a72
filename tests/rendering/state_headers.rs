//! State files with headers that no render writes: they are refused, without a panic and without memory for what is not
//! there.

use crate::common::scene_folder::SMALL;
use crate::common::session::{folder, session};
use etendue::ErrorKind;
use etendue::internals::film::filter::FilterSampling;
use etendue::internals::film::{Film, Window};
use etendue::internals::image::atomic::ExistingFile;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::NullRenderObserver;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::session::Session;
use etendue::internals::state::{AdaptivePilot, Merge, State, StateHeader};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

struct Stage {
    folder: TempDir,
    session: Session,
}

impl Stage {
    fn new() -> Self {
        Self {
            folder: folder(),
            session: session(&SMALL.replace("size = [24, 16]", "size = [5, 3]"), 1),
        }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The state of a render with these options.
    fn state(&self, options: &RenderOptions) -> State {
        let file = self.file("it.etd");
        let rendering = self.session.render(options, &NullRenderObserver);
        let rendering = rendering.expect("valid options");
        rendering.save(&self.session, &file).expect("it is written");
        State::read(&file).expect("it is whole")
    }
}

fn path() -> RenderOptions {
    let mut options = RenderOptions::samples(8);
    options.integrator = Some(IntegratorKind::Path);
    options
}

fn write(state: &State, header: &StateHeader, file: &Path) {
    State::write_parts(
        header,
        &state.film,
        &state.layers,
        None,
        file,
        ExistingFile::Replace,
    )
    .expect("it is written");
}

#[test]
fn impossible_headers_are_rejected() {
    let stage = Stage::new();
    let state = stage.state(&path());
    let file = stage.file("crafted.etd");
    type Change = fn(&mut StateHeader);
    let pilot = |samples| AdaptivePilot {
        samples,
        identity: String::new(),
    };
    let changes: [(&str, Change); 13] = [
        ("an end beyond 2^46", |it| {
            it.done = vec![[0, (1 << 46) + 4]]
        }),
        ("the largest end", |it| it.done = vec![[0, u64::MAX]]),
        ("a start within a round", |it| it.done = vec![[2, 10]]),
        ("samples before its shard", |it| it.shard = Some([4, 16])),
        ("an empty shard", |it| it.shard = Some([16, 16])),
        ("an endless shard", |it| it.shard = Some([0, u64::MAX])),
        ("too many rays", |it| it.rays.shadow = u64::MAX),
        ("too many rejected", |it| it.rejected.count = u64::MAX),
        ("an endless time", |it| it.seconds = 1e300),
        ("a negative time", |it| it.seconds = -1.0),
        ("too many samples", |it| it.spp = Some(u64::MAX)),
        ("counts with a border", |it| it.has_counts = true),
        ("a tile of nothing", |it| it.tile_size = 0),
    ];
    assert!(state.film.border_size() > 0);
    for (what, change) in changes {
        let mut header = state.header.clone();
        change(&mut header);
        write(&state, &header, &file);
        let error = State::read(&file).expect_err(what);
        assert_eq!(error.kind(), ErrorKind::Io, "{what}: {error}");
        let error = Merge::of(std::slice::from_ref(&file)).expect_err(what);
        assert_eq!(error.kind(), ErrorKind::Io, "{what}: {error}");
    }
    for samples in [8, 0, 6, 1 << 47] {
        let mut header = state.header.clone();
        header.pilot = Some(pilot(samples));
        write(&state, &header, &file);
        assert!(State::read(&file).is_err(), "a pilot of {samples}");
    }
}

#[test]
fn counts_of_paths_and_samples_beyond_reason_are_rejected() {
    let stage = Stage::new();
    let mut options = path();
    options.integrator = Some(IntegratorKind::Bidirectional);
    let mut state = stage.state(&options);
    let file = stage.file("crafted.etd");
    let mut header = state.header.clone();
    header.splat_samples = Some([u64::MAX; 4]);
    write(&state, &header, &file);
    assert!(State::read(&file).is_err());
    header = state.header.clone();
    header.is_uneven = true;
    state.film.tiles_mut()[0].samples = u64::MAX / 2;
    write(&state, &header, &file);
    let error = State::read(&file).expect_err("too many samples");
    assert!(error.to_string().contains("at byte"), "{error}");
}

#[test]
fn header_with_more_sums_than_its_body_is_rejected_before_allocation() {
    let stage = Stage::new();
    let state = stage.state(&path());
    let window = Window::whole((512, 512));
    let film = Film::new(window, 32);
    let file = stage.file("crafted.etd");
    // With a halo of four pixels, small tiles have many more sums than pixels.
    let mut header = state.header.clone();
    (header.window, header.tile_size, header.border_size) = (window, 32, 0);
    (header.done, header.splat_samples) = (vec![], None);
    State::write_parts(&header, &film, &[], None, &file, ExistingFile::Replace)
        .expect("it is written");
    State::read(&file).expect("a black film");
    header.border_size = 4;
    State::write_parts(&header, &film, &[], None, &file, ExistingFile::Replace)
        .expect("it is written");
    let error = State::read(&file).expect_err("the body is too short");
    assert!(error.to_string().contains("take at least"), "{error}");
}

#[test]
fn files_with_other_windows_are_not_merged() {
    let stage = Stage::new();
    let state = stage.state(&path());
    let files = [stage.file("a.etd"), stage.file("b.etd")];
    write(&state, &state.header, &files[0]);
    let film = Film::new(
        Window {
            height: 30,
            ..state.header.window
        },
        state.header.tile_size,
    );
    let film = film.with_border(state.film.border_size()).with_splats();
    assert!(state.film.splats().is_some());
    let mut header = state.header.clone();
    header.window = film.window();
    header.done = vec![[8, 16]];
    header.is_uneven = false;
    let mut other = State {
        film,
        ..state.clone()
    };
    for tile in other.film.tiles_mut() {
        tile.samples = 8;
    }
    write(&other, &header, &files[1]);
    State::read(&files[1]).expect("it is whole");
    let error = Merge::of(&files).expect_err("the windows differ");
    assert!(error.to_string().contains("different sums"), "{error}");
}

#[test]
fn state_with_other_sums_than_the_render_is_not_resumed() {
    let stage = Stage::new();
    let mut options = path();
    options.filter_sampling = Some(FilterSampling::Importance);
    let own = stage.state(&options);
    options.filter_sampling = Some(FilterSampling::Splatting);
    let mut state = stage.state(&options);
    assert_ne!(state.film.border_size(), own.film.border_size());
    state.header.identity = own.header.identity;
    options.filter_sampling = Some(FilterSampling::Importance);
    let resumed = stage.session.resume(&options, state, &NullRenderObserver);
    let error = resumed.expect_err("it has other sums");
    assert!(error.to_string().contains("other sums"), "{error}");
}
