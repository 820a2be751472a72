//! A scene to ask things of, over and over: pictures, further samples of them, what rays meet; after a change of the camera
//! or of where things stand, too, without building anew what has not changed. What the command does, others do by it.
//!
//! ```
//! use etendue::math::rgb::Rgb;
//! use etendue::math::vec::DVec3;
//! use etendue::render::Unwatched;
//! use etendue::render::wishes::Wishes;
//! use etendue::scene::description::{
//!     CameraDescription, GeometryDescription, LightDescription, MaterialDescription,
//!     MaterialModel, Place, SceneDescription, ShapeDescription,
//! };
//! use etendue::session::{Session, tracing};
//!
//! # fn main() -> etendue::Result<()> {
//! let eye = DVec3::new(0.0, 1.0, 4.0);
//! let camera = CameraDescription::look_at(eye, DVec3::ZERO, DVec3::Y, 40.0_f64.to_radians())?;
//! let mut scene = SceneDescription::new("ball", camera);
//! scene.film.size = (32, 24);
//! let reflectance = Rgb::grey(0.7).into();
//! let white = MaterialModel::Diffuse { reflectance };
//! scene.add_material(MaterialDescription::new("white", Place::default(), white))?;
//! let ball = GeometryDescription::Sphere { center: DVec3::ZERO, radius: 1.0 };
//! scene.add_shape(ShapeDescription::new("ball", Place::default(), ball))?;
//! scene.add_light(LightDescription::sky(Place::default(), Rgb::WHITE))?;
//!
//! let session = Session::new(scene, tracing())?;
//! let mut rendering = session.render(&Wishes::samples(128), &Unwatched)?;
//! rendering.add_samples(&session, 128, &Unwatched)?;
//! assert_eq!(rendering.spp(), 256);
//! // A white sky lights the ball evenly, and is seen beside it.
//! let middle = rendering.image().get(16, 12).to_array()[1];
//! assert!((middle - 0.7).abs() < 0.1);
//! # Ok(())
//! # }
//! ```
//!
//! Measure: world units, samples per pixel, seconds.
//! Range: valid scenes, which `Session::new` makes sure of. A session may be used from any number of threads at once, except
//! to change it.
//! Source: none needed. Tested in `tests/rendering/session.rs`.

pub mod layers;
mod queries;
mod rendering;

pub use queries::{Met, QueryRay};
pub use rendering::Rendering;

use crate::accel::{AccelOptions, Backend, Precision};
use crate::error::{Error, Result};
use crate::film::filter::Filter;
use crate::math::vec::DAffine3;
use crate::planted::planted;
use crate::render::auto::{Recommendation, recommend};
use crate::render::options::RenderOptions;
use crate::render::settings::available_threads;
use crate::render::{RenderInput, RenderObserver, Threads, Unwatched};
use crate::scene::description::{CameraDescription, FilmDescription, SceneDescription};
use crate::scene::prepare::{Prepared, prepare};
use crate::scene::{Scene, check, load};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How rays are traced where nobody says: by the preferred backend of this build, robustly, on all threads.
pub fn tracing() -> AccelOptions {
    AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::default(),
        quality: None,
        threads: available_threads(),
    }
}

/// A scene that is ready, with threads that wait for work.
#[derive(Debug)]
pub struct Session {
    description: SceneDescription,
    options: AccelOptions,
    scene: Scene,
    notes: Vec<String>,
    filter: Filter,
    threads: Threads,
    work: Work,
    /// Another one after each change: a rendering knows by it whether it can go on.
    state: State,
}

/// What tells one state of a session from all others, of other sessions too: they are numbered through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct State(u64);

impl State {
    /// One that nobody has.
    fn next() -> Self {
        static GIVEN: AtomicU64 = AtomicU64::new(0);
        Self(GIVEN.fetch_add(1, Ordering::Relaxed))
    }
}

/// What a session has done to be ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Work {
    /// How often everything was made ready, and all acceleration structures were built.
    pub builds: u64,
    /// How often groups were placed anew, and nothing was built but the structure above them.
    pub placements: u64,
    /// How often the camera was replaced, and nothing was built.
    pub cameras: u64,
    /// What the last of them took.
    pub last: Duration,
    /// What building acceleration structures took of the time when everything was made ready last.
    pub structures: Duration,
}

impl Session {
    /// Makes a scene ready.
    ///
    /// # Errors
    /// What is wrong with the scene, and what the backend says.
    pub fn new(description: SceneDescription, options: AccelOptions) -> Result<Self> {
        check::scene(&description)?;
        Self::of_valid(description, options)
    }

    /// Loads a scene, a `.toml` file or a bare `.obj` model, and makes it ready.
    ///
    /// # Errors
    /// What is wrong with the file, with one that it names or with the scene, and what the backend says.
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
        } = prepare(&description, options)?;
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
            state: State::next(),
        })
    }

    /// The scene as it was written, with the changes since.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }

    /// The reconstruction filter.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// The scene as it is rendered.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What was decided or repaired, for the user to know: one sentence each.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        let all = self.description.notes.iter().chain(&self.notes);
        all.map(String::as_str)
    }

    /// What was done so far to be ready.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Begins a render, without a sample yet. Its threads are the session's.
    ///
    /// # Errors
    /// Wishes that are out of their range, and a picture that there is no memory for.
    pub fn start(&self, options: &RenderOptions) -> Result<Rendering> {
        self.start_watched(options, &Unwatched)
    }

    /// The same, where `observer` may end the pilot by which `auto` is settled; then it stands for `path`.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_watched(
        &self,
        options: &RenderOptions,
        observer: &dyn RenderObserver,
    ) -> Result<Rendering> {
        Rendering::new(self, options, observer)
    }

    /// The integrator that suits the scene, whichever is wished for: what `auto` stands for.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn recommend(
        &self,
        options: &RenderOptions,
        observer: &dyn RenderObserver,
    ) -> Result<Recommendation> {
        let mut settings = options.settings(&self.description)?;
        settings.threads = self.threads.count();
        recommend(&self.view(), &self.threads, &settings, observer)
    }

    /// Renders as wished.
    ///
    /// # Errors
    /// As [`Self::start`], and a kernel that lacks an effect of the scene.
    pub fn render(
        &self,
        options: &RenderOptions,
        observer: &dyn RenderObserver,
    ) -> Result<Rendering> {
        let mut rendering = self.start_watched(options, observer)?;
        let until = rendering.settings().budget;
        rendering.go_on(self, until, observer)?;
        Ok(rendering)
    }

    /// Looks from somewhere else. Nothing is built, unless another shutter makes something move, or move otherwise.
    ///
    /// # Errors
    /// A camera that is not valid: then nothing changes.
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
        self.look_again(start);
        Ok(())
    }

    /// Makes pictures of another size, or by another filter. Nothing is built.
    ///
    /// # Errors
    /// A film that is not valid: then nothing changes.
    pub fn set_film(&mut self, film: FilmDescription) -> Result<()> {
        check::film(&film)?;
        let start = Instant::now();
        self.filter = Filter::new(&film.filter);
        self.description.film = film;
        self.look_again(start);
        Ok(())
    }

    /// Places instances anew, given by their indices in the description. What groups consist of is not built again, only the
    /// structure above them: instances, and shapes that stand in the world itself.
    ///
    /// # Errors
    /// An index that there is not, or a transform that flattens space: then nothing changes.
    pub fn set_transforms(&mut self, transforms: &[(usize, DAffine3)]) -> Result<()> {
        let start = Instant::now();
        let before = self.description.instances.clone();
        match self.place_again(transforms) {
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

    fn place_again(&mut self, transforms: &[(usize, DAffine3)]) -> Result<Vec<String>> {
        let count = self.description.instances.len();
        for &(index, transform) in transforms {
            let Some(instance) = self.description.instances.get_mut(index) else {
                let message = format!("there is no instance {index}: there are {count}");
                return Err(Error::usage(message));
            };
            instance.transform = transform;
            check::instance(&self.description.instances[index], &self.description)?;
        }
        self.scene.place_again(&self.description)
    }

    fn look_again(&mut self, start: Instant) {
        self.scene.look_from(&self.description);
        self.work.cameras += 1;
        self.changed(start);
    }

    fn rebuild(&mut self, description: SceneDescription, start: Instant) -> Result<()> {
        let Prepared {
            scene,
            notes,
            build_time,
        } = prepare(&description, self.options)?;
        (self.scene, self.notes) = (scene, notes);
        self.description = description;
        self.work.builds += 1;
        self.work.structures = build_time;
        self.changed(start);
        Ok(())
    }

    fn changed(&mut self, start: Instant) {
        self.work.last = start.elapsed();
        self.state = planted!("changes-unnoticed", self.state, State::next());
    }

    fn view(&self) -> RenderInput<'_> {
        RenderInput {
            scene: &self.scene,
            filter: &self.filter,
            size: self.description.film.size,
        }
    }
}

/// Whether anything but the camera moves.
fn moves(description: &SceneDescription) -> bool {
    let of_shapes = description.shapes.iter().map(|shape| &shape.motion);
    let of_instances = description.instances.iter().map(|it| &it.motion);
    of_shapes.chain(of_instances).any(|keys| !keys.is_empty())
}
