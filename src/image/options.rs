//! What goes into a file beside the pixels.
//!
//! Measure: said at each.
//! Range: a layer has one number a pixel; formats without room for something leave it out.
//! Source: the OpenEXR file layout for metadata and layers. Tested in `image/exr.rs`.

/// What goes into a file besides the pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WriteOptions {
    /// Stops by which a PNG is made brighter; the other formats keep the values as they are.
    pub exposure: f32,
    /// Named facts about the picture, for OpenEXR; the names must not be ones that OpenEXR defines.
    pub metadata: Vec<(String, MetadataValue)>,
    /// Further channels, for OpenEXR.
    pub layers: Vec<Layer>,
}

/// One fact about a picture.
#[derive(Debug, Clone, PartialEq)]
pub enum MetadataValue {
    /// A text.
    Text(String),
    /// A number.
    Real(f64),
    /// A whole number; beyond 32 bits OpenEXR keeps it as text.
    Integer(i64),
}

/// One more channel of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Layer and channel, such as `albedo.R`; not `R`, `G` or `B` alone.
    pub name: String,
    /// One number a pixel, row by row from the top.
    pub samples: Vec<f32>,
}
