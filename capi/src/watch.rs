//! Callbacks that observe a render.
//!
//! Measure: samples, seconds.
//! Range: any functions, or none.
//! Source: none needed.

use crate::memory::Versioned;
use renderer::Film;
use renderer::{Progress, RenderObserver};
use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Progress of a render.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdProgress {
    /// Size of this structure in bytes.
    pub struct_size: usize,
    /// Samples so far, over all pixels.
    pub samples: u64,
    /// Completed samples per pixel; their mean if pixels differ.
    pub spp: u64,
    /// Seconds since the call began.
    pub seconds: f64,
    /// Completed fraction of the budget, from 0 to 1.
    pub fraction: f64,
    /// Estimated error so far, the square root of relMSE; NaN while it cannot be estimated.
    pub rel_rmse: f64,
}

/// An intermediate image of a render, valid only during the callback.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdPicture {
    /// Size of this structure in bytes.
    pub struct_size: usize,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue of each pixel, linear Rec. 709, row by row from the top without a gap.
    pub rgb: *const f32,
}

/// Callbacks that observe a render. Any of them may be null. They may not throw, longjmp, or wait for the render that
/// calls them. They may call this library; calls that the running render excludes return `ETD_STATUS_BUSY`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdWatch {
    /// sizeof(EtdWatch)
    pub struct_size: usize,
    /// Passed to each function.
    pub user: *mut c_void,
    /// Called often, from any of the render's threads and from several at once. A result other than 0 ends the render as
    /// soon as possible; the samples so far are kept. `progress` is valid only during the call. While "irradiance-cache"
    /// fills its cache, before the first sample, there are 0 samples.
    pub progress:
        Option<unsafe extern "C" fn(user: *mut c_void, progress: *const EtdProgress) -> i32>,
    /// Called after each pass over the image, from one of the render's threads while the others wait.
    pub picture: Option<unsafe extern "C" fn(user: *mut c_void, picture: *const EtdPicture)>,
}

// SAFETY: numbers, pointers and functions that may be null.
unsafe impl Versioned for EtdWatch {
    const NAME: &'static str = "EtdWatch";
}

/// Forwards progress and intermediate images to the callbacks, and their request to cancel to the render.
pub struct CallbackObserver<'a> {
    watch: EtdWatch,
    cancelled: &'a AtomicBool,
    start: Instant,
}

// SAFETY: callers are required to accept calls from any thread; the pointer is only passed on to them.
unsafe impl Sync for CallbackObserver<'_> {}

impl<'a> CallbackObserver<'a> {
    pub fn new(watch: EtdWatch, cancelled: &'a AtomicBool) -> Self {
        Self {
            watch,
            cancelled,
            start: Instant::now(),
        }
    }
}

impl RenderObserver for CallbackObserver<'_> {
    fn cache_prepass(&self, _share: f64, _records: usize) {
        self.progress(&Progress {
            samples: 0,
            spp: 0,
            elapsed: self.start.elapsed(),
            fraction: 0.0,
            rel_rmse: None,
            predicted: None,
        });
    }

    fn progress(&self, progress: &Progress) {
        let Some(function) = self.watch.progress else {
            return;
        };
        let progress = EtdProgress {
            struct_size: size_of::<EtdProgress>(),
            samples: progress.samples,
            spp: progress.spp,
            seconds: progress.elapsed.as_secs_f64(),
            fraction: progress.fraction,
            rel_rmse: progress.rel_rmse.unwrap_or(f64::NAN),
        };
        // SAFETY: a function of the caller with this signature; the progress outlives the call.
        if unsafe { function(self.watch.user, &raw const progress) } != 0 {
            self.cancelled.store(true, Ordering::Relaxed);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    fn pass(&self, film: &Film) {
        let Some(function) = self.watch.picture else {
            return;
        };
        let image = film.develop();
        let pixels = image.pixels().iter();
        let rgb: Vec<[f32; 3]> = pixels.map(|pixel| pixel.to_array()).collect();
        let picture = EtdPicture {
            struct_size: size_of::<EtdPicture>(),
            width: image.width(),
            height: image.height(),
            rgb: rgb.as_ptr().cast(),
        };
        // SAFETY: as above.
        unsafe { function(self.watch.user, &raw const picture) };
    }
}
