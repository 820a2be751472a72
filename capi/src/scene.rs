//! Scenes: created, loaded, committed, changed. Their parts are added in `compose.rs`.
//!
//! Measure: as in `describe/`.
//! Range: a scene may be used from any number of threads at once. Changes of a committed scene return `ETD_STATUS_BUSY`
//! while a render or a query uses it.
//! Source: none needed.

use crate::build::{EtdTracing, EtdWork};
use crate::describe::{EtdCamera, EtdFilm, affine};
use crate::handle::HandleTable;
use crate::memory::{
    not_null, read_list, read_struct, read_struct_or_zeros, text, write_struct, write_text,
};
use crate::status::{CallResult, EtdStatus, Failure};
use renderer::Session;
use renderer::description::{CameraDescription, InstanceDescription, SceneDescription};
use renderer::vec::DAffine3;
use renderer::{check, load};
use std::ffi::c_char;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, TryLockError};

/// A scene.
pub struct EtdScene(());

/// The object of a scene's handle.
pub struct Scene {
    /// The description for the next commit.
    description: Mutex<SceneDescription>,
    /// The committed scene with the changes since. Shared with the renders that were created from it.
    pub ready: Arc<SceneSession>,
}

/// A committed scene, or `None` before the first commit.
#[derive(Default)]
pub struct SceneSession(RwLock<Option<Session>>);

/// All scenes.
pub static SCENES: HandleTable<Scene> = HandleTable::new(1);

impl SceneSession {
    /// Calls `work` with the committed scene, without changing it.
    pub fn read<T>(&self, work: impl FnOnce(&Session) -> Result<T, Failure>) -> Result<T, Failure> {
        let guard: RwLockReadGuard<'_, _> = self.0.read().unwrap_or_else(PoisonError::into_inner);
        match guard.as_ref() {
            Some(session) => work(session),
            None => Err(not_committed()),
        }
    }

    /// Changes the scene, unless it is in use.
    fn change<T>(
        &self,
        work: impl FnOnce(&mut Option<Session>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        match self.0.try_write() {
            Ok(mut session) => work(&mut session),
            Err(TryLockError::Poisoned(poisoned)) => work(&mut poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Failure::new(
                EtdStatus::Busy,
                "the scene is in use: a render of it has to end first",
            )),
        }
    }
}

fn not_committed() -> Failure {
    Failure::new(
        EtdStatus::NotCommitted,
        "the scene has not been committed: call etd_scene_commit first",
    )
}

impl Scene {
    /// Locks the description.
    pub fn describe(&self) -> MutexGuard<'_, SceneDescription> {
        self.description
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the committed scene, if any, and then the description.
    fn change(
        &self,
        ready: impl FnOnce(&mut Session) -> renderer::Result<()>,
        description: impl FnOnce(&mut SceneDescription),
    ) -> CallResult {
        self.ready.change(|session| {
            if let Some(session) = session {
                ready(session)?;
            }
            description(&mut self.describe());
            Ok(EtdStatus::Ok)
        })
    }
}

/// Returns an empty description with a pinhole camera at the origin that looks along -z.
fn empty() -> SceneDescription {
    let fov = 40.0_f64.to_radians();
    SceneDescription::new("", CameraDescription::pinhole(DAffine3::IDENTITY, fov))
}

/// Creates an empty scene, with a camera at the origin that looks along -z, and writes its handle. Its reference count
/// is 1, to be released by `etd_scene_release`.
///
/// # Safety
/// `scene` is null, or a handle may be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_create(scene: *mut *mut EtdScene) -> EtdStatus {
    if scene.is_null() {
        return EtdStatus::InvalidArgument;
    }
    let handle = SCENES.add(Scene {
        description: Mutex::new(empty()),
        ready: Arc::default(),
    });
    // SAFETY: the caller's promise.
    unsafe { scene.write_unaligned(handle) };
    EtdStatus::Ok
}

/// Increments the reference count of a scene.
#[unsafe(no_mangle)]
pub extern "C" fn etd_scene_retain(scene: *const EtdScene) -> EtdStatus {
    SCENES.retain(scene)
}

/// Decrements the reference count of a scene, which is freed at 0; renders created from it keep it alive. Null, and
/// handles that were freed already, are `ETD_STATUS_INVALID_HANDLE`.
#[unsafe(no_mangle)]
pub extern "C" fn etd_scene_release(scene: *mut EtdScene) -> EtdStatus {
    SCENES.release(scene)
}

/// Copies the message of the scene's last failure to `text`, truncated to `capacity` bytes including the terminating
/// NUL, and returns its full length without the NUL. `text` may be null, to query the length.
///
/// # Safety
/// `capacity` bytes may be written to `text`, unless it is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_error(
    scene: *const EtdScene,
    text: *mut c_char,
    capacity: usize,
) -> usize {
    let words = match SCENES.get(scene) {
        Some(scene) => scene.errors.get(),
        None => "no scene has this handle".to_owned(),
    };
    // SAFETY: the caller's promise.
    unsafe { write_text(&words, text, capacity) }
}

/// Loads a scene file or a bare model, by its extension, which replaces the description. It takes effect at the next commit.
///
/// # Safety
/// `path` is null, or a NUL-terminated string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_load(scene: *mut EtdScene, path: *const c_char) -> EtdStatus {
    SCENES.call(scene, |scene| {
        not_null(path, "path")?;
        // SAFETY: the caller's promise.
        let path = unsafe { text(path, "path") }?.unwrap_or_default();
        *scene.describe() = load::load(Path::new(path))?;
        Ok(EtdStatus::Ok)
    })
}

/// Sets the camera. On a committed scene this takes effect at once, and builds nothing, unless a different shutter
/// changes the motion of objects.
///
/// # Safety
/// `camera` is null, or a structure of its `struct_size`, whose pointers are null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_set_camera(
    scene: *mut EtdScene,
    camera: *const EtdCamera,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        let shutter = scene.describe().camera.shutter;
        // SAFETY: the caller's promise.
        let camera = unsafe { read_struct(camera)?.describe(shutter) }?;
        check::camera(&camera)?;
        let same = camera.clone();
        scene.change(
            |session| session.set_camera(same),
            |description| description.camera = camera,
        )
    })
}

/// Sets the image size and the reconstruction filter. On a committed scene this takes effect at once, and builds
/// nothing.
///
/// # Safety
/// `film` is null, or a structure of its `struct_size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_set_film(
    scene: *mut EtdScene,
    film: *const EtdFilm,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let film = unsafe { read_struct(film) }?.describe()?;
        check::film(&film)?;
        let same = film.clone();
        scene.change(
            |session| session.set_film(same),
            |description| description.film = film,
        )
    })
}

/// Prepares the scene for rendering: checks it, and builds its acceleration structures. Parts that are added later take
/// effect at the next commit, after which renders that were created before cannot continue. `tracing` may be null.
///
/// # Safety
/// `tracing` is null, or a structure of its `struct_size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_commit(
    scene: *mut EtdScene,
    tracing: *const EtdTracing,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let options = unsafe { read_struct_or_zeros(tracing) }?.options()?;
        scene.ready.change(|session| {
            let description = scene.describe().clone();
            *session = Some(Session::new(description, options)?);
            Ok(EtdStatus::Ok)
        })
    })
}

/// Sets the transforms of `count` instances: `instances` are their numbers, `transforms` 12 numbers for each, row by row
/// without a gap. On a committed scene this takes effect at once; only the top-level structure is built again, not those
/// of groups; an instance that was added since the commit is `ETD_STATUS_INVALID_ARGUMENT`. Moving instances keep their
/// keyframes, which are applied after the new transform.
///
/// # Safety
/// The pointers are null, or `count` instances and transforms may be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_set_transforms(
    scene: *mut EtdScene,
    instances: *const u32,
    transforms: *const f64,
    count: usize,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        // SAFETY: the caller's promise.
        let numbers: Vec<u32> = unsafe { read_list(instances.cast(), count, 0, "instances") }?;
        let matrices: Vec<[f64; 12]> =
            unsafe { read_list(transforms.cast(), count, 0, "transforms") }?;
        let description = scene.describe();
        let mut placed = Vec::with_capacity(numbers.len());
        let mut changed = Vec::with_capacity(numbers.len());
        for (number, matrix) in numbers.into_iter().zip(&matrices) {
            let index = number as usize;
            let Some(instance) = description.instances.get(index) else {
                let there = description.instances.len();
                let text = format!("instances: {index}, but there are {there}");
                return Err(Failure::argument(text));
            };
            let instance = InstanceDescription {
                transform: affine(matrix),
                ..instance.clone()
            };
            check::instance(&instance, &description)?;
            placed.push((index, instance.transform));
            changed.push((index, instance));
        }
        drop(description);
        scene.change(
            |session| session.set_transforms(&placed),
            |description| {
                for (index, instance) in changed {
                    description.instances[index] = instance;
                }
            },
        )
    })
}

/// Writes statistics about preparing the scene.
///
/// # Safety
/// `work` is null, or a structure of its `struct_size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_scene_work(scene: *const EtdScene, work: *mut EtdWork) -> EtdStatus {
    SCENES.call(scene, |scene| {
        let done = scene.ready.read(|session| Ok(session.work()))?;
        // SAFETY: the caller's promise.
        unsafe { write_struct(work, done.into()) }?;
        Ok(EtdStatus::Ok)
    })
}
