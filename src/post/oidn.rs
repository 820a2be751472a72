//! Intel Open Image Denoise 2, loaded at run time where it is found.
//!
//! A trained network denoises the image, guided by albedo and normals, which it denoises first. Its errors have no
//! bound and do not vanish with more samples: they are estimated from the halves of the image only.
//!
//! Ownership: the library and all of its objects live within one call of [`filter`]; pixel buffers belong to this
//! program, and the library reads and writes them in place until a filter is executed.
//!
//! Measure: linear radiance; albedo in [0, 1]; unit normals in [-1, 1].
//! Range: library versions from 2.0 on; its CPU device alone, whose results do not depend on the machine's graphics card.
//! Source: the documentation of the C API, <https://www.openimagedenoise.org/documentation.html>. Tested in
//! `cli/tests/command/denoise_oidn.rs`.
#![allow(unsafe_code)]

use crate::error::{Error, Result};
use libloading::{Library, Symbol};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::PathBuf;

/// A device or a filter of the library.
type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`.
const DEVICE_CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FORMAT_FLOAT3: c_int = 3;

/// The file names of the library on this system.
const NAMES: &[&str] = if cfg!(target_os = "windows") {
    &["OpenImageDenoise.dll"]
} else if cfg!(target_os = "macos") {
    &["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"]
} else {
    &["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"]
};

/// The environment variable with a folder that contains the library, directly or in its `lib`.
const FOLDER_VARIABLE: &str = "OIDN_DIR";

/// The images to denoise, row by row, three channels a pixel.
#[derive(Debug)]
pub struct OidnImages<'a> {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Colour images, each replaced by its result.
    pub colours: &'a mut [Vec<[f32; 3]>],
    /// Albedo at first hits.
    pub albedo: Vec<[f32; 3]>,
    /// Normals at first hits.
    pub normal: Vec<[f32; 3]>,
}

/// Denoises several images of the same view.
///
/// # Errors
/// If the library is not found, is older than version 2, or fails.
pub fn filter(images: OidnImages<'_>) -> Result<()> {
    let library = load()?;
    let functions = Functions::of(&library)?;
    let device = OidnDevice::new(&functions)?;
    let OidnImages {
        size,
        colours,
        mut albedo,
        mut normal,
    } = images;
    // Guides of few samples are noisy themselves: denoised ones keep more detail.
    device.execute(size, &mut albedo, "albedo", &mut [])?;
    device.execute(size, &mut normal, "normal", &mut [])?;
    for colour in colours {
        let guides = &mut [("albedo", &mut albedo), ("normal", &mut normal)];
        device.execute(size, colour, "color", guides)?;
    }
    Ok(())
}

/// Checks that the library is available.
///
/// # Errors
/// If it is not found or is older than version 2.
pub fn check() -> Result<()> {
    Functions::of(&load()?).map(|_| ())
}

/// Loads the library from the folder of the environment variable, or from where the system looks.
fn load() -> Result<Library> {
    let folder = std::env::var_os(FOLDER_VARIABLE).map(PathBuf::from);
    let places: Vec<PathBuf> = match &folder {
        Some(folder) => ["lib", "lib64", "bin", ""]
            .iter()
            .flat_map(|part| NAMES.iter().map(move |name| folder.join(part).join(name)))
            .collect(),
        None => NAMES.iter().map(PathBuf::from).collect(),
    };
    let mut reasons = Vec::new();
    for place in &places {
        if folder.is_some() && !place.is_file() {
            continue;
        }
        // SAFETY: loading runs the library's initialisers, which do no more than register it with itself.
        match unsafe { Library::new(place) } {
            Ok(library) => return Ok(library),
            Err(error) => {
                let cause = std::error::Error::source(&error).map(ToString::to_string);
                let cause = cause.unwrap_or_else(|| error.to_string());
                reasons.push(format!("{}: {cause}", place.display()));
            }
        }
    }
    let looked = match &folder {
        Some(folder) => format!("in {FOLDER_VARIABLE}={}", folder.display()),
        None => format!(
            "for {} where the system looks for libraries; {FOLDER_VARIABLE} may name its folder",
            NAMES.join(" or ")
        ),
    };
    let reasons = match reasons.is_empty() {
        true => String::new(),
        false => format!(" ({})", reasons.join("; ")),
    };
    Err(Error::usage(format!(
        "Open Image Denoise 2 was not found: looked {looked}{reasons}"
    )))
}

/// The functions of the library in use.
struct Functions<'a> {
    new_device: Symbol<'a, unsafe extern "C" fn(c_int) -> Handle>,
    set_device_int: Symbol<'a, unsafe extern "C" fn(Handle, *const c_char, c_int)>,
    commit_device: Symbol<'a, unsafe extern "C" fn(Handle)>,
    device_error: Symbol<'a, unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int>,
    release_device: Symbol<'a, unsafe extern "C" fn(Handle)>,
    new_filter: Symbol<'a, unsafe extern "C" fn(Handle, *const c_char) -> Handle>,
    set_image: Symbol<'a, SetSharedFilterImage>,
    set_bool: Symbol<'a, unsafe extern "C" fn(Handle, *const c_char, bool)>,
    commit_filter: Symbol<'a, unsafe extern "C" fn(Handle)>,
    execute: Symbol<'a, unsafe extern "C" fn(Handle)>,
    release_filter: Symbol<'a, unsafe extern "C" fn(Handle)>,
}

/// The arguments are filter, name, pixels, format, width, height, offset in bytes, bytes from pixel to pixel, bytes
/// from row to row.
type SetSharedFilterImage = unsafe extern "C" fn(
    Handle,
    *const c_char,
    *mut c_void,
    c_int,
    usize,
    usize,
    usize,
    usize,
    usize,
);

impl<'a> Functions<'a> {
    fn of(library: &'a Library) -> Result<Self> {
        fn find<'a, T>(library: &'a Library, name: &str) -> Result<Symbol<'a, T>> {
            // SAFETY: the types are those that the documentation of version 2 gives these names, and a major version
            // keeps them.
            unsafe { library.get(name.as_bytes()) }.map_err(|error| {
                Error::usage(format!(
                    "Open Image Denoise is older than version 2: it has no {name}"
                ))
                .because(error)
            })
        }
        Ok(Self {
            new_device: find(library, "oidnNewDevice")?,
            set_device_int: find(library, "oidnSetDeviceInt")?,
            commit_device: find(library, "oidnCommitDevice")?,
            device_error: find(library, "oidnGetDeviceError")?,
            release_device: find(library, "oidnReleaseDevice")?,
            new_filter: find(library, "oidnNewFilter")?,
            set_image: find(library, "oidnSetSharedFilterImage")?,
            set_bool: find(library, "oidnSetFilterBool")?,
            commit_filter: find(library, "oidnCommitFilter")?,
            execute: find(library, "oidnExecuteFilter")?,
            release_filter: find(library, "oidnReleaseFilter")?,
        })
    }

    /// Returns the device's error since the last call; without a device, the reason why there is none.
    fn check(&self, device: Handle) -> Result<()> {
        let mut message = std::ptr::null();
        // SAFETY: the function takes any device or none, and a place for a pointer.
        let code = unsafe { (self.device_error)(device, &mut message) };
        if code == 0 {
            return Ok(());
        }
        let message = if message.is_null() {
            "no reason given".into()
        } else {
            // SAFETY: it is a C string that lives until the next call for this device.
            unsafe { CStr::from_ptr(message) }.to_string_lossy()
        };
        Err(Error::render(format!(
            "Open Image Denoise failed: {message} (error {code})"
        )))
    }
}

/// A device, released on drop.
struct OidnDevice<'a> {
    functions: &'a Functions<'a>,
    handle: Handle,
}

impl<'a> OidnDevice<'a> {
    fn new(functions: &'a Functions<'a>) -> Result<Self> {
        // SAFETY: any number is allowed for a device type; an unknown one yields null.
        let handle = unsafe { (functions.new_device)(DEVICE_CPU) };
        if handle.is_null() {
            functions.check(handle)?;
            return Err(Error::render(
                "Open Image Denoise has no device for this CPU",
            ));
        }
        let device = Self { functions, handle };
        let threads = c_int::try_from(rayon::current_num_threads()).unwrap_or(0);
        // SAFETY: the device is alive, the names are C strings.
        unsafe {
            (functions.set_device_int)(handle, c"numThreads".as_ptr(), threads);
            (functions.commit_device)(handle);
        }
        functions.check(handle)?;
        Ok(device)
    }

    /// Denoises an image in place.
    fn execute(
        &self,
        [width, height]: [usize; 2],
        picture: &mut [[f32; 3]],
        kind: &str,
        guides: &mut [(&str, &mut Vec<[f32; 3]>)],
    ) -> Result<()> {
        let name = |kind: &str| match kind {
            "albedo" => c"albedo",
            "normal" => c"normal",
            _ => c"color",
        };
        assert!(
            guides.iter().all(|(_, guide)| guide.len() == picture.len())
                && picture.len() == width * height,
            "images of one view have the same size"
        );
        let functions = self.functions;
        let place = picture.as_mut_ptr().cast::<c_void>();
        // SAFETY: the device is alive, and the filter is released below and nowhere else. The images have width *
        // height pixels of three floats without gaps, and are borrowed until the filter has been executed.
        unsafe {
            let filter = (functions.new_filter)(self.handle, c"RT".as_ptr());
            let image = |name: &CStr, place: *mut c_void| {
                (functions.set_image)(
                    filter,
                    name.as_ptr(),
                    place,
                    FORMAT_FLOAT3,
                    width,
                    height,
                    0,
                    0,
                    0,
                );
            };
            image(name(kind), place);
            for (kind, guide) in guides.iter_mut() {
                image(name(kind), guide.as_mut_ptr().cast());
            }
            image(c"output", place);
            if kind == "color" {
                (functions.set_bool)(filter, c"hdr".as_ptr(), true);
                (functions.set_bool)(filter, c"cleanAux".as_ptr(), true);
            }
            (functions.commit_filter)(filter);
            (functions.execute)(filter);
            (functions.release_filter)(filter);
        }
        functions.check(self.handle)
    }
}

impl Drop for OidnDevice<'_> {
    fn drop(&mut self) {
        // SAFETY: the device is alive, and nothing refers to it after this.
        unsafe { (self.functions.release_device)(self.handle) }
    }
}
