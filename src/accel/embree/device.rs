//! The owning handle of an Embree device, its errors and its memory.
//!
//! The handle owns one reference and releases it when dropped. A callback collects errors; they are checked after building,
//! never per ray. Another counts the memory that Embree holds, and refuses what exceeds the limit.
//!
//! Measure: bytes.
//! Range: Embree 4.
//! Source: Embree's manual; embree4 headers. Tested below and in `tests/tracing/rays.rs`.

use crate::error::{Error, ErrorKind, Result};
use crate::memory;
use embree4_sys::*;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The environment variable with more of Embree's options, such as `isa=avx2`.
const OPTIONS: &str = "ETENDUE_EMBREE";

/// The state that Embree's callbacks write to, from any of its threads.
#[derive(Debug)]
struct Monitor {
    first_error: Mutex<Option<(RTCError, String)>>,
    bytes: AtomicI64,
    /// The largest number of bytes that Embree may hold.
    max_bytes: i64,
}

/// An Embree device.
#[derive(Debug)]
pub struct Device {
    pub(super) handle: RTCDevice,
    monitor: Box<Monitor>,
}

// SAFETY: Embree's devices may be used from any thread (manual, "Thread safety"); the monitor is synchronised.
unsafe impl Send for Device {}
// SAFETY: as above; we change a device only before it is shared.
unsafe impl Sync for Device {}

impl Device {
    /// Creates a device that builds with `threads` threads, or with one per core if there are fewer cores. The limit
    /// applies to the process: of several live devices, the largest counts. The device may use as much memory as the
    /// machine has available. The environment variable `ETENDUE_EMBREE` may have more of Embree's options: with `isa=avx2`
    /// it traces rays as on a processor without AVX-512.
    ///
    /// # Errors
    /// If Embree cannot create a device.
    pub fn new(threads: usize) -> Result<Arc<Self>> {
        Self::with_memory(threads, memory::available())
    }

    /// Creates a device that may use at most this many bytes of memory.
    fn with_memory(threads: usize, max_bytes: Option<u64>) -> Result<Arc<Self>> {
        let options = std::env::var(OPTIONS).unwrap_or_default();
        let config = CString::new(format!("threads={threads},{options}"))
            .expect("neither a number nor the environment has a NUL byte");
        // SAFETY: `config` is a NUL-terminated string that lives through the call.
        let handle = unsafe { rtcNewDevice(config.as_ptr()) };
        if handle.is_null() {
            // SAFETY: for a null device, the error of the last failed creation on this thread is returned.
            let code = unsafe { rtcGetDeviceError(ptr::null_mut()) };
            return Err(Error::render(format!(
                "Embree found no device: error {code}"
            )));
        }
        let device = Self {
            handle,
            monitor: Box::new(Monitor {
                first_error: Mutex::default(),
                bytes: AtomicI64::new(0),
                max_bytes: max_bytes.map_or(i64::MAX, |max_bytes| {
                    i64::try_from(max_bytes).unwrap_or(i64::MAX)
                }),
            }),
        };
        let user: *const Monitor = &*device.monitor;
        // SAFETY: the monitor is boxed and dropped after the device is released, so `user` is valid whenever Embree
        // calls back; both callbacks take it as a shared reference and never unwind.
        unsafe {
            rtcSetDeviceErrorFunction(handle, Some(on_error), user.cast_mut().cast());
            rtcSetDeviceMemoryMonitorFunction(handle, Some(on_memory), user.cast_mut().cast());
        }
        Ok(Arc::new(device))
    }

    /// Returns a property of the device, such as its version.
    pub fn property(&self, property: RTCDeviceProperty) -> isize {
        // SAFETY: the handle is valid while `self` is; an unknown property is reported as an error, not undefined.
        unsafe { rtcGetDeviceProperty(self.handle, property) as isize }
    }

    /// Whether the library natively traces packets of this many rays on this machine.
    pub fn is_native(&self, lanes: usize) -> bool {
        let property = match lanes {
            1 => return true,
            4 => RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED,
            8 => RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED,
            16 => RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED,
            _ => return false,
        };
        self.property(property) != 0
    }

    /// The number of bytes that Embree holds for this device.
    pub fn memory(&self) -> usize {
        usize::try_from(self.monitor.bytes.load(Ordering::Relaxed)).unwrap_or(0)
    }

    /// Returns the first error since the last call, with Embree's message.
    pub(super) fn take_error(&self) -> Result<()> {
        let mut first = self
            .monitor
            .first_error
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        first.take().map_or(Ok(()), |(code, words)| {
            let kind = match code {
                RTC_ERROR_OUT_OF_MEMORY => ErrorKind::Memory,
                _ => ErrorKind::Render,
            };
            Err(Error::new(kind, format!("Embree: {words}")))
        })
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: this is the only reference, obtained by `new`.
        unsafe { rtcReleaseDevice(self.handle) };
    }
}

/// Keeps the first error only: later ones are its consequences.
unsafe extern "C" fn on_error(user: *mut c_void, code: RTCError, text: *const c_char) {
    // SAFETY: `user` is the monitor of a living device, see `Device::new`.
    let monitor = unsafe { &*user.cast::<Monitor>() };
    let words = if text.is_null() {
        format!("error {code}")
    } else {
        // SAFETY: Embree passes a NUL-terminated text that lives through the callback.
        unsafe { CStr::from_ptr(text) }
            .to_string_lossy()
            .into_owned()
    };
    let mut first = monitor
        .first_error
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    first.get_or_insert((code, words));
}

/// Counts the bytes that Embree allocates and frees, and refuses an allocation beyond the limit. An allocation that
/// has already been made (`there`) cannot be refused.
unsafe extern "C" fn on_memory(user: *mut c_void, bytes: isize, there: bool) -> bool {
    // SAFETY: `user` is the monitor of a living device, see `Device::new`.
    let monitor = unsafe { &*user.cast::<Monitor>() };
    let bytes = bytes as i64;
    let held = monitor.bytes.fetch_add(bytes, Ordering::Relaxed) + bytes;
    let refused = bytes > 0 && !there && held > monitor.max_bytes;
    if refused {
        monitor.bytes.fetch_sub(bytes, Ordering::Relaxed);
    }
    !refused
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::embree::scene::EmbreeScene;
    use crate::accel::{AccelOptions, Backend, Precision};
    use crate::geometry::mesh::Mesh;
    use crate::math::vec::Vec3;

    /// Builds a BVH over a strip of triangles with at most this much memory, and returns the number of bytes held.
    fn build(max_bytes: Option<u64>) -> Result<usize> {
        let options = AccelOptions {
            backend: Backend::Embree,
            precision: Precision::Robust,
            quality: None,
            threads: 1,
        };
        let corner = |i: u32| Vec3::new((i / 2) as f32, (i % 2) as f32, 0.0);
        let positions = (0..60_000).map(corner).collect();
        let indices = (0..59_998).map(|i| [i, i + 1, i + 2]).collect();
        let mesh = Mesh::new(positions, vec![], vec![], indices);
        let mut scene = EmbreeScene::new(Device::with_memory(1, max_bytes)?, options)?;
        // SAFETY: the mesh is dropped after the scene.
        unsafe { scene.attach_mesh(0, &mesh) };
        scene.commit().map(|built| built.memory())
    }

    #[test]
    fn bvh_build_out_of_memory_is_a_memory_error() {
        assert!(build(None).expect("there is memory") > 1_000_000);
        let error = build(Some(1_000_000)).expect_err("it takes more");
        assert_eq!(error.kind(), ErrorKind::Memory, "{error}");
    }
}
