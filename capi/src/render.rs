//! Renders: created, run, continued. `read.rs` reads their images.
//!
//! Measure: radiance, samples per pixel, seconds.
//! Range: while a render runs, all other calls with its handle but `etd_render_cancel`, `etd_render_retain`,
//! `etd_render_release` and `etd_render_error` return `ETD_STATUS_BUSY`.
//! Source: none needed.

use crate::handle::HandleTable;
use crate::memory::{Versioned, not_null, read_struct_or_zeros, write_struct, write_text};
use crate::scene::{EtdScene, SCENES, SceneSession};
use crate::settings::EtdSettings;
use crate::status::{CallResult, EtdStatus, Failure};
use crate::watch::{CallbackObserver, EtdWatch};
use renderer::Budget;
use renderer::LayeredImage;
use renderer::Rendering;
use std::ffi::c_char;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::Duration;

/// A render of a scene, with its samples so far.
pub struct EtdRender(());

/// The object of a render's handle.
pub struct Render {
    /// The scene.
    pub ready: Arc<SceneSession>,
    state: Mutex<RenderState>,
    /// Whether a run is active or about to start.
    runs: AtomicBool,
    cancelled: AtomicBool,
}

/// Marks a run as active until it is dropped.
struct Running<'a>(&'a AtomicBool);

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// Interval between attempts to lock the state: calls that only read take about as long.
const LOCK_INTERVAL: Duration = Duration::from_micros(20);

/// The state of a render.
pub struct RenderState {
    /// The render.
    pub rendering: Rendering,
    /// The image with its layers, once requested.
    layered: Option<LayeredImage>,
}

/// All renders.
pub static RENDERS: HandleTable<Render> = HandleTable::new(2);

/// Statistics and error estimates of a render.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdRenderInfo {
    /// sizeof(EtdRenderInfo), to be set before the call.
    pub struct_size: usize,
    /// Width in pixels of the rendered window.
    pub width: u32,
    /// Height in pixels of the rendered window.
    pub height: u32,
    /// Completed samples per pixel; their mean if pixels differ.
    pub spp: u64,
    /// Total number of samples over all pixels.
    pub samples: u64,
    /// Number of rays traced.
    pub rays: u64,
    /// Number of samples that were not finite, and were rejected.
    pub rejected: u64,
    /// Rendering time so far, in seconds.
    pub seconds: f64,
    /// 1 if the last call was cancelled.
    pub cancelled: u32,
    /// 1 if the last call ended because the target error was reached.
    pub reached: u32,
    /// Estimated error, the square root of relMSE; NaN with fewer than four samples per pixel.
    pub rel_rmse: f64,
    /// Upper bound of the error at this `confidence`; NaN while it cannot be estimated, infinite if rare bright paths
    /// cause so much of the error that the samples give no bound.
    pub rel_rmse_upper: f64,
    /// Confidence level of the upper bound.
    pub confidence: f64,
    /// Fraction of pixels whose error bars are not reliable.
    pub uncalibrated_fraction: f64,
    /// Lower bound of the error if there is no upper bound; otherwise 0.
    pub rel_rmse_at_least: f64,
}

// SAFETY: numbers.
unsafe impl Versioned for EtdRenderInfo {
    const NAME: &'static str = "EtdRenderInfo";
}

impl RenderState {
    /// Returns the image with its layers.
    pub fn layered(&mut self, ready: &SceneSession) -> Result<&LayeredImage, Failure> {
        if self.layered.is_none() {
            let rendering = &self.rendering;
            self.layered = Some(ready.read(|session| Ok(rendering.layered(session)?))?);
        }
        Ok(self.layered.as_ref().expect("it was just made"))
    }
}

impl Render {
    /// Calls `work` with the state of the render, unless the render runs.
    pub fn with<T>(
        &self,
        work: impl FnOnce(&mut RenderState) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        loop {
            match self.state.try_lock() {
                Ok(mut state) => return work(&mut state),
                Err(TryLockError::Poisoned(poisoned)) => return work(&mut poisoned.into_inner()),
                Err(TryLockError::WouldBlock) if self.runs.load(Ordering::Acquire) => {
                    return Err(busy());
                }
                // Other calls that read end soon.
                Err(TryLockError::WouldBlock) => std::thread::sleep(LOCK_INTERVAL),
            }
        }
    }

    /// Continues the render.
    ///
    /// # Safety
    /// The watch is null, or a structure of its `struct_size`.
    unsafe fn run(
        &self,
        watch: *const EtdWatch,
        until: impl FnOnce(&Rendering) -> Budget,
    ) -> CallResult {
        // SAFETY: the caller's promise.
        let watch = unsafe { read_struct_or_zeros(watch) }?;
        if self.runs.swap(true, Ordering::AcqRel) {
            return Err(busy());
        }
        let _running = Running(&self.runs);
        self.cancelled.store(false, Ordering::Relaxed);
        // Other calls that hold the lock only read, and end soon.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.layered = None;
        let observer = CallbackObserver::new(watch, &self.cancelled);
        let until = until(&state.rendering);
        let rendering = &mut state.rendering;
        self.ready
            .read(|session| Ok(rendering.continue_until(session, until, &observer)?))?;
        Ok(match rendering.rendered().cancelled {
            true => EtdStatus::Cancelled,
            false => EtdStatus::Ok,
        })
    }
}

fn busy() -> Failure {
    Failure::new(
        EtdStatus::Busy,
        "the render is in progress: that call has to end first",
    )
}

/// Creates a render of a committed scene, without samples, and writes its handle, to be released by
/// `etd_render_release`. It keeps the scene alive. `settings` may be null. The message of a failure is stored with the
/// scene.
///
/// Small pilots, which take up to a few seconds on the scene's threads and cannot be cancelled, choose the integrator in
/// place of "auto", and for "path" what `light_paths`, `reuse` and `roulette` leave open. There are none for any other
/// integrator, nor for "path" with, say, "off", "off" and "window=1/3".
///
/// # Safety
/// `settings` is null, or a structure of its `struct_size`, whose pointers are null or NUL-terminated strings; `render`
/// is null, or a handle may be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_create(
    scene: *const EtdScene,
    settings: *const EtdSettings,
    render: *mut *mut EtdRender,
) -> EtdStatus {
    SCENES.call(scene, |scene| {
        not_null(render, "render")?;
        // SAFETY: the caller's promise.
        let options = unsafe { read_struct_or_zeros(settings)?.options() }?;
        let rendering = scene.ready.read(|session| Ok(session.start(&options)?))?;
        let handle = RENDERS.add(Render {
            ready: Arc::clone(&scene.ready),
            state: Mutex::new(RenderState {
                rendering,
                layered: None,
            }),
            runs: AtomicBool::new(false),
            cancelled: AtomicBool::new(false),
        });
        // SAFETY: the caller's promise.
        unsafe { render.write_unaligned(handle) };
        Ok(EtdStatus::Ok)
    })
}

/// Increments the reference count of a render.
#[unsafe(no_mangle)]
pub extern "C" fn etd_render_retain(render: *const EtdRender) -> EtdStatus {
    RENDERS.retain(render)
}

/// Decrements the reference count of a render, which is freed at 0, once it does not run. Null, and handles that were
/// freed already, are `ETD_STATUS_INVALID_HANDLE`.
#[unsafe(no_mangle)]
pub extern "C" fn etd_render_release(render: *mut EtdRender) -> EtdStatus {
    RENDERS.release(render)
}

/// Copies the message of the render's last failure, like `etd_scene_error`.
///
/// # Safety
/// As `etd_scene_error`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_error(
    render: *const EtdRender,
    text: *mut c_char,
    capacity: usize,
) -> usize {
    let words = match RENDERS.get(render) {
        Some(render) => render.errors.get(),
        None => "no render has this handle".to_owned(),
    };
    // SAFETY: the caller's promise.
    unsafe { write_text(&words, text, capacity) }
}

/// Renders until the limit in the settings is reached: samples, time or error. Returns `ETD_STATUS_CANCELLED` if it was
/// cancelled; it may then be run again, without loss of samples, unless `adaptive` is "greedy". A render by "mlt" that finds no
/// light fails, and keeps its samples. `watch` may be null.
///
/// # Safety
/// `watch` is null, or a structure of its `struct_size`, with functions of these signatures.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_run(
    render: *mut EtdRender,
    watch: *const EtdWatch,
) -> EtdStatus {
    RENDERS.call(render, |render| {
        // SAFETY: the caller's promise.
        unsafe { render.run(watch, |rendering| rendering.settings().budget) }
    })
}

/// Takes `spp` more samples per pixel, like `etd_render_run`. Not for greedy adaptive renders that have samples.
///
/// # Safety
/// As `etd_render_run`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_add_samples(
    render: *mut EtdRender,
    spp: u64,
    watch: *const EtdWatch,
) -> EtdStatus {
    RENDERS.call(render, |render| {
        if spp == 0 {
            return Err(Failure::argument("spp: expected at least 1 sample"));
        }
        let until = |rendering: &Rendering| Budget::samples(rendering.spp().saturating_add(spp));
        // SAFETY: the caller's promise.
        unsafe { render.run(watch, until) }
    })
}

/// Cancels the active run of a render as soon as possible, from any thread. Without an active run, it does nothing.
#[unsafe(no_mangle)]
pub extern "C" fn etd_render_cancel(render: *mut EtdRender) -> EtdStatus {
    match RENDERS.get(render) {
        Some(object) => {
            object.value.cancelled.store(true, Ordering::Relaxed);
            EtdStatus::Ok
        }
        None => EtdStatus::InvalidHandle,
    }
}

/// Writes statistics and error estimates of a render.
///
/// # Safety
/// `info` is null, or a structure of its `struct_size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn etd_render_info(
    render: *const EtdRender,
    info: *mut EtdRenderInfo,
) -> EtdStatus {
    RENDERS.call(render, |render| {
        let known = render.with(|state| Ok(known(&state.rendering)))?;
        // SAFETY: the caller's promise.
        unsafe { write_struct(info, known) }?;
        Ok(EtdStatus::Ok)
    })
}

fn known(rendering: &Rendering) -> EtdRenderInfo {
    let (rendered, settings) = (rendering.rendered(), rendering.settings());
    let target = settings.budget.error;
    let confidence = target.map_or(renderer::CONFIDENCE, |target| target.confidence);
    let error = rendering.error(confidence);
    EtdRenderInfo {
        struct_size: size_of::<EtdRenderInfo>(),
        width: settings.window.width,
        height: settings.window.height,
        spp: rendered.spp,
        samples: rendered.film.sample_count(),
        rays: rendered.rays.total(),
        rejected: rendered.rejected.count,
        seconds: rendered.elapsed.as_secs_f64(),
        cancelled: rendered.cancelled.into(),
        reached: rendered.reached.into(),
        rel_rmse: error.map_or(f64::NAN, |error| error.rel_rmse),
        rel_rmse_upper: error.map_or(f64::NAN, |error| error.upper_bound),
        confidence,
        uncalibrated_fraction: rendering
            .error_bars()
            .map_or(0.0, |bars| bars.flagged_share()),
        rel_rmse_at_least: error
            .and_then(|error| error.doubt)
            .map_or(0.0, |doubt| doubt.at_least()),
    }
}
