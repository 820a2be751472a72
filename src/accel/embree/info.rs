//! Facts about the Embree that runs, for `etendue info`.
//!
//! Measure: none.
//! Range: Linux tells where the library was loaded from; elsewhere the place stays unknown.
//! Source: Embree's device properties; proc(5). Tested in `cli/tests/command/render.rs`.

use super::handles::Device;
use crate::accel::library::EmbreeInfo;
use crate::error::Result;
use embree4_sys::{
    RTC_DEVICE_PROPERTY_VERSION_MAJOR, RTC_DEVICE_PROPERTY_VERSION_MINOR,
    RTC_DEVICE_PROPERTY_VERSION_PATCH,
};
use std::path::PathBuf;

/// Asks the library.
///
/// # Errors
/// If Embree finds no device, or one that does not fit its headers.
pub fn info() -> Result<EmbreeInfo> {
    let device = Device::new(1)?;
    super::layout::check(&device)?;
    let version = [
        RTC_DEVICE_PROPERTY_VERSION_MAJOR,
        RTC_DEVICE_PROPERTY_VERSION_MINOR,
        RTC_DEVICE_PROPERTY_VERSION_PATCH,
    ]
    .map(|property| device.property(property).to_string());
    let widths = [1, 4, 8, 16].into_iter();
    Ok(EmbreeInfo {
        header_version: env!("EMBREE_HEADER_VERSION").to_owned(),
        library_version: version.join("."),
        library: loaded_library(),
        native_widths: widths.filter(|&lanes| device.is_native(lanes)).collect(),
    })
}

/// The mapped file whose name starts with `libembree4`.
fn loaded_library() -> Option<PathBuf> {
    let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
    let mut paths = maps
        .lines()
        .filter_map(|line| line.find('/').map(|at| PathBuf::from(&line[at..])));
    paths.find(|path| {
        path.file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with("libembree4"))
    })
}
