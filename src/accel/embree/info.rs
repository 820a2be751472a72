//! Facts about the Embree library in use, for `etendue info`.
//!
//! Measure: none.
//! Range: the path of the library is known on Linux only.
//! Source: Embree's device properties; proc(5). Tested in `cli/tests/command/render.rs`.

use super::device::Device;
use crate::accel::library::EmbreeInfo;
use crate::error::Result;
use embree4_sys::{
    RTC_DEVICE_PROPERTY_VERSION_MAJOR, RTC_DEVICE_PROPERTY_VERSION_MINOR,
    RTC_DEVICE_PROPERTY_VERSION_PATCH,
};
use std::path::PathBuf;

/// Queries the Embree library for its version, path and native packet widths.
///
/// # Errors
/// If Embree cannot create a device, or the library does not match its headers.
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

/// The path of the mapped file whose name starts with `libembree4`.
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
