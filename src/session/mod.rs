//! Sessions: a prepared scene for repeated renders, additional samples and ray queries, also after changes of the
//! camera or of instance transforms, without rebuilding what has not changed. Other programs use a session for what the
//! command does.
//!
//! The crate's first page has an example.
//!
//! Measure: world units, samples per pixel, seconds.
//! Range: valid scenes, as `Session::new` checks. Any number of threads may use a session at once, except to change it.
//! Source: none needed. Tested in `tests/rendering/session.rs`.

pub mod layers;
mod queries;
mod rendering;
mod shared_cache;
pub mod states;

pub use queries::{QueryRay, SurfaceHit};
pub use rendering::Rendering;

use crate::accel::{AccelOptions, Backend, Precision};
use crate::error::{Error, Result};
use crate::film::filter::Filter;
use crate::math::vec::DAffine3;
use crate::planted::planted;
use crate::render::auto::{Recommendation, recommend};
use crate::render::options::RenderOptions;
use crate::render::settings::available_threads;
use crate::render::{NullRenderObserver, RenderInput, RenderObserver, Threads};
use crate::scene::description::{CameraDescription, FilmDescription, SceneDescription};
use crate::scene::prepare::{Prepared, prepare};
use crate::scene::{Scene, check, load};
use crate::state::Fingerprint;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// The default options for tracing rays: the preferred backend of this build, in robust precision, on all threads.
pub fn tracing() -> AccelOptions {
    AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::default(),
        quality: None,
        threads: available_threads(),
    }
}

/// A prepared scene, with a pool of threads.
#[derive(Debug)]
pub struct Session {
    description: SceneDescription,
    options: AccelOptions,
    scene: Scene,
    notes: Vec<String>,
    filter: Filter,
    threads: Threads,
    work: Work,
    /// The revision of the scene, replaced after each change: a rendering compares it to decide whether it can
    /// continue.
    revision: Revision,
}

/// A revision of a scene, unique among those of all sessions: a running number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Revision(u64);

impl Revision {
    /// Returns a new, unused revision.
    fn next() -> Self {
        static GIVEN: AtomicU64 = AtomicU64::new(0);
        Self(GIVEN.fetch_add(1, Ordering::Relaxed))
    }
}

/// The preparation work that a session has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Work {
    /// The number of times the whole scene was prepared, and all acceleration structures were built.
    pub builds: u64,
    /// The number of times groups were placed again, and only the top-level structure was built.
    pub placements: u64,
    /// The number of times the camera or film was replaced, and nothing was built.
    pub cameras: u64,
    /// The duration of the last of these.
    pub last: Duration,
    /// The time spent building acceleration structures when the whole scene was last prepared.
    pub structures: Duration,
}

impl Session {
    /// Prepares a scene.
    ///
    /// # Errors
    /// An invalid scene, or an error of the backend.
    pub fn new(description: SceneDescription, options: AccelOptions) -> Result<Self> {
        check::scene(&description)?;
        Self::of_valid(description, options)
    }

    /// Loads a scene file or a bare model, by its extension, and prepares it.
    ///
    /// # Errors
    /// An invalid file, an invalid file that it names, an invalid scene, or an error of the backend.
    pub fn load(file: &Path, options: AccelOptions) -> Result<Self> {
        Self::of_valid(load::load(file)?, options)
    }

    fn of_valid(description: SceneDescription, options: AccelOptions) -> Result<Self> {
        let start = Instant::now();
        let threads = Threads::new(options.threads)?;
        let Prepared {
            scene,
            notes,
            build_time,
        } = threads.run(|| prepare(&description, options))?;
        Ok(Self {
            filter: Filter::new(&description.film.filter),
            description,
            options,
            scene,
            notes,
            threads,
            work: Work {
                builds: 1,
                last: start.elapsed(),
                structures: build_time,
                ..Work::default()
            },
            revision: Revision::next(),
        })
    }

    /// The scene as it was written, with later changes.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }

    /// The reconstruction filter, for the packages of this workspace.
    #[doc(hidden)]
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// The prepared scene, for the packages of this workspace.
    #[doc(hidden)]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Notes for the user on decisions and repairs, one sentence each.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let loaded = self.description.notes.iter().map(ToString::to_string);
        loaded.chain(self.notes.iter().cloned())
    }

    /// The preparation work done so far.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Begins a render, without samples yet, on the session's threads.
    ///
    /// # Errors
    /// Options out of their range, and too little memory for the image.
    pub fn start(&self, options: &RenderOptions) -> Result<Rendering> {
        self.start_with_observer(options, &NullRenderObserver)
    }

    /// Begins a render like [`Self::start`]. `observer` may stop the pilot that resolves the integrator `auto`; `auto`
    /// then stands for `path`.
    ///
    /// # Errors
    /// The errors of [`Self::start`].
    pub fn start_with_observer(
        &self,
        options: &RenderOptions,
        observer: &dyn RenderObserver,
    ) -> Result<Rendering> {
        Rendering::new(self, options, None, observer)
    }

    /// Begins a render like [`Self::start_with_observer`], with what pilots chose in a render of the same scene and settings,
    /// whose identity is known, in place of pilots. For the packages of this workspace.
    ///
    /// # Errors
    /// The errors of [`Self::start`].
    #[doc(hidden)]
    pub fn start_with_choices(
        &self,
        options: &RenderOptions,
        known: Option<&Fingerprint>,
        observer: &dyn RenderObserver,
    ) -> Result<Rendering> {
        Rendering::new(self, options, known, observer)
    }

    /// Recommends the integrator that suits the scene, which is the one that `auto` stands for, whichever the options
    /// name.
    ///
    /// # Errors
    /// The errors of [`Self::start`].
    pub fn recommend(
        &self,
        options: &RenderOptions,
        observer: &dyn RenderObserver,
    ) -> Result<Recommendation> {
        let mut settings = options.settings(&self.description)?;
        settings.threads = self.threads.count();
        recommend(&self.input(), &self.threads, &settings, observer)
    }

    /// Renders with the given options.
    ///
    /// # Errors
    /// The errors of [`Self::start`], and a kernel that lacks an effect of the scene.
    pub fn render(
        &self,
        options: &RenderOptions,
        observer: &dyn RenderObserver,
    ) -> Result<Rendering> {
        let mut rendering = self.start_with_observer(options, observer)?;
        let until = rendering.settings().budget;
        rendering.continue_until(self, until, observer)?;
        Ok(rendering)
    }

    /// Replaces the camera. Nothing is rebuilt, unless a different shutter changes which objects move, or how they
    /// move.
    ///
    /// # Errors
    /// An invalid camera; the session is then unchanged.
    pub fn set_camera(&mut self, camera: CameraDescription) -> Result<()> {
        check::camera(&camera)?;
        let start = Instant::now();
        let other_shutter = camera.shutter != self.description.camera.shutter;
        if other_shutter && moves(&self.description) {
            let mut description = self.description.clone();
            description.camera = camera;
            return self.rebuild(description, start);
        }
        self.description.camera = camera;
        self.update_camera(start);
        Ok(())
    }

    /// Replaces the film, that is, the image size and the reconstruction filter. Nothing is rebuilt.
    ///
    /// # Errors
    /// An invalid film; the session is then unchanged.
    pub fn set_film(&mut self, film: FilmDescription) -> Result<()> {
        check::film(&film)?;
        let start = Instant::now();
        self.filter = Filter::new(&film.filter);
        self.description.film = film;
        self.update_camera(start);
        Ok(())
    }

    /// Replaces the transforms of instances, given by their indices in the description. The structures of groups are
    /// not rebuilt, only the top-level structure over instances and top-level shapes.
    ///
    /// # Errors
    /// An index out of range, or a singular transform; the session is then unchanged.
    pub fn set_transforms(&mut self, transforms: &[(usize, DAffine3)]) -> Result<()> {
        let start = Instant::now();
        let before = self.description.instances.clone();
        match self.set_instance_transforms(transforms) {
            Ok(notes) => self.notes = notes,
            Err(error) => {
                self.description.instances = before;
                return Err(error);
            }
        }
        self.work.placements += 1;
        self.changed(start);
        Ok(())
    }

    fn set_instance_transforms(&mut self, transforms: &[(usize, DAffine3)]) -> Result<Vec<String>> {
        let count = self.description.instances.len();
        for &(index, transform) in transforms {
            let Some(instance) = self.description.instances.get_mut(index) else {
                let message = format!("there is no instance {index}: there are {count}");
                return Err(Error::usage(message));
            };
            instance.transform = transform;
            check::instance(&self.description.instances[index], &self.description)?;
        }
        self.scene.set_instance_transforms(&self.description)
    }

    fn update_camera(&mut self, start: Instant) {
        self.scene.set_camera(&self.description);
        self.work.cameras += 1;
        self.changed(start);
    }

    fn rebuild(&mut self, description: SceneDescription, start: Instant) -> Result<()> {
        let Prepared {
            scene,
            notes,
            build_time,
        } = self.threads.run(|| prepare(&description, self.options))?;
        (self.scene, self.notes) = (scene, notes);
        self.description = description;
        self.work.builds += 1;
        self.work.structures = build_time;
        self.changed(start);
        Ok(())
    }

    fn changed(&mut self, start: Instant) {
        self.work.last = start.elapsed();
        self.revision = planted!("changes-unnoticed", self.revision, Revision::next());
    }

    fn input(&self) -> RenderInput<'_> {
        RenderInput {
            scene: &self.scene,
            filter: &self.filter,
            size: self.description.film.size,
        }
    }
}

/// Whether any object other than the camera moves.
fn moves(description: &SceneDescription) -> bool {
    let of_shapes = description.shapes.iter().map(|shape| &shape.motion);
    let of_instances = description.instances.iter().map(|it| &it.motion);
    of_shapes.chain(of_instances).any(|keys| !keys.is_empty())
}
