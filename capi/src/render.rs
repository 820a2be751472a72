//! Renders: begun, run, gone on with. `read.rs` reads their pictures.
//!
//! Measure: radiance, samples per pixel, seconds.
//! Range: while a render runs, all other calls with its handle but `etd_render_cancel`, `etd_render_retain`,
//! `etd_render_release` and `etd_render_error` are answered with `ETD_STATUS_BUSY`.
//! Source: none needed.

use crate::handle::Table;
use crate::memory::{Versioned, not_null, read_struct_or_zeros, write_struct, write_text};
use crate::scene::{EtdScene, Ready, SCENES};
use crate::settings::EtdSettings;
use crate::status::{EtdStatus, Failure, Outcome};
use crate::watch::{EtdWatch, Watcher};
use renderer::Budget;
use renderer::LayeredImage;
use renderer::Rendering;
use std::ffi::c_char;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::Duration;

/// A render of a scene, as far as it has come.
pub struct EtdRender(());

/// What a render's handle stands for.
pub struct Render {
    /// The scene that is rendered.
    pub ready: Arc<Ready>,
    state: Mutex<State>,
    /// Whether a run is under way, or about to be.
    runs: AtomicBool,
    cancelled: AtomicBool,
}

/// Says that a run is under way, until it is dropped.
struct Running<'a>(&'a AtomicBool);

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// Between two looks whether another call is done: one that only reads takes about as long.
const PATIENCE: Duration = Duration::from_micros(20);

/// How far a render has come.
pub struct State {
    /// The render itself.
    pub rendering: Rendering,
    /// The picture with its layers, once somebody has asked for them.
    layered: Option<LayeredImage>,
}

/// All renders.
pub static RENDERS: Table<Render> = Table::new(2);

/// What is known of a render.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdRenderInfo {
    /// sizeof(EtdRenderInfo), to be set before the call.
    pub struct_size: usize,
    /// Pixels in a row of what is rendered.
    pub width: u32,
    /// Rows of it.
    pub height: u32,
    /// Complete samples per pixel; in the mean, where pixels differ.
    pub spp: u64,
    /// Samples in all pixels together.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
    /// Samples that were not finite, and were left out.
    pub rejected: u64,
    /// Seconds that rendering took so far.
    pub seconds: f64,
    /// 1 if the last call was cancelled.
    pub cancelled: u32,
    /// 1 if the last call ended because the error that was asked for was reached.
    pub reached: u32,
    /// Estimated error, the root of relMSE; not a number before it can be told, from four samples a pixel on.
    pub rel_rmse: f64,
    /// With `confidence`, the error is below this; not a number before that can be told, infinite where rare bright paths hold
    /// so much of the error that the samples do not tell a bound.
    pub rel_rmse_upper: f64,
    /// The confidence of that.
    pub confidence: f64,
    /// The share of pixels whose error bars are not to be trusted.
    pub uncalibrated_fraction: f64,
    /// The error is at least this where there is no bound; else 0.
    pub rel_rmse_at_least: f64,
}

// SAFETY: numbers.
unsafe impl Versioned for EtdRenderInfo {
    const NAME: &'static str = "EtdRenderInfo";
}

impl State {
    /// The picture with its layers.
    pub fn layered(&mut self, ready: &Ready) -> Result<&LayeredImage, Failure> {
        if self.layered.is_none() {
            let rendering = &self.rendering;
            self.layered = Some(ready.read(|session| Ok(rendering.layered(session)?))?);
        }
        Ok(self.layered.as_ref().expect("it was just made"))
    }
}

impl Render {
    /// Does something with the render, unless it runs.
    pub fn with<T>(
        &self,
        work: impl FnOnce(&mut State) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        loop {
            match self.state.try_lock() {
                Ok(mut state) => return work(&mut state),
                Err(TryLockError::Poisoned(poisoned)) => return work(&mut poisoned.into_inner()),
                Err(TryLockError::WouldBlock) if self.runs.load(Ordering::Acquire) => {
                    return Err(busy());
                }
                // Others that read are done soon.
                Err(TryLockError::WouldBlock) => std::thread::sleep(PATIENCE),
            }
        }
    }

    /// Goes on with the render.
    ///
    /// # Safety
    /// The watch is null, or as it says.
    unsafe fn run(
        &self,
        watch: *const EtdWatch,
        until: impl FnOnce(&Rendering) -> Budget,
    ) -> Outcome {
        // SAFETY: the caller's promise.
        let watch = unsafe { read_struct_or_zeros(watch) }?;
        if self.runs.swap(true, Ordering::AcqRel) {
            return Err(busy());
        }
        let _running = Running(&self.runs);
        self.cancelled.store(false, Ordering::Relaxed);
        // Whoever has it reads, and is done soon.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.layered = None;
        let watcher = Watcher::new(watch, &self.cancelled);
        let until = until(&state.rendering);
        let rendering = &mut state.rendering;
        self.ready
            .read(|session| Ok(rendering.go_on(session, until, &watcher)?))?;
        Ok(match rendering.rendered().cancelled {
            true => EtdStatus::Cancelled,
            false => EtdStatus::Ok,
        })
    }
}

fn busy() -> Failure {
    Failure::new(
        EtdStatus::Busy,
        "the render is under way: that call has to end first",
    )
}

/// Begins a render of a committed scene, without a sample yet, and writes its handle, to be released by `etd_render_release`. It
/// keeps the scene as long as it lives. `settings` may be null. A failure leaves its text with the scene.
///
/// # Safety
/// `settings` is null, or a structure as long as it says, whose pointers are null or texts; `render` is null, or a handle may be
/// written there.
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
            state: Mutex::new(State {
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

/// Holds a render once more.
#[unsafe(no_mangle)]
pub extern "C" fn etd_render_retain(render: *const EtdRender) -> EtdStatus {
    RENDERS.retain(render)
}

/// Holds a render once less. Nobody's render is freed, once it does not run. Null, and what was released already, are
/// `ETD_STATUS_INVALID_HANDLE`.
#[unsafe(no_mangle)]
pub extern "C" fn etd_render_release(render: *mut EtdRender) -> EtdStatus {
    RENDERS.release(render)
}

/// The text of the render's last failure, as `etd_scene_error`.
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

/// Renders until what the settings say is met: samples, a time or an error. Returns when it is, or `ETD_STATUS_CANCELLED`. A render that
/// was cancelled may be run again, and loses nothing. `watch` may be null.
///
/// # Safety
/// `watch` is null, or a structure as long as it says, with functions of these signatures.
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

/// Takes `spp` more samples in each pixel, as `etd_render_run`. Not for adaptive renders that have begun.
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

/// Ends the run of a render that is under way, from any thread, as soon as it can. Without one nothing happens.
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

/// Tells what is known of a render.
///
/// # Safety
/// `info` is null, or a structure as long as it says.
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
