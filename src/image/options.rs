//! Options for writing an image: exposure, metadata and further channels.
//!
//! Measure: stated at each field.
//! Range: a layer has one number a pixel; formats that cannot store an option omit it.
//! Source: the OpenEXR file layout for metadata and layers. Tested in `image/exr.rs`.

/// The exposure, metadata and further channels of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WriteOptions {
    /// Exposure in stops that brightens a PNG; the other formats keep the values unchanged.
    pub exposure: f32,
    /// Named metadata, for OpenEXR; the names must not be ones that OpenEXR defines.
    pub metadata: Vec<(String, MetadataValue)>,
    /// Further channels, for OpenEXR.
    pub layers: Vec<Layer>,
}

/// A metadata value.
#[derive(Debug, Clone, PartialEq)]
pub enum MetadataValue {
    /// A text.
    Text(String),
    /// A number.
    Real(f64),
    /// A whole number; beyond 32 bits OpenEXR keeps it as text.
    Integer(i64),
}

/// A further channel of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Names of layer and channel, such as `albedo.R`; not `R`, `G` or `B` alone.
    pub name: String,
    /// One number a pixel, row by row from the top.
    pub samples: Vec<f32>,
}
