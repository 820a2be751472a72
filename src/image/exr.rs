//! OpenEXR: 32-bit float channels, lossless, with layers and facts about the picture.
//!
//! Measure: linear values; channels `R`, `G`, `B`, or `Y` for grey.
//! Range: flat files; the first layer with colours is read.
//! Source: the OpenEXR file layout, through the exr crate. Tested in `image/mod.rs`.

use super::{Image, MetadataValue, WriteOptions, checked_size};
use crate::math::rgb::Rgb;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, LayerAttributes,
    LineOrder, ReadChannels, ReadLayers, Text, WritableImage, read,
};
use std::io::{self, Cursor, Seek, Write};

/// Writes the picture, its layers and its metadata.
pub fn encode(image: &Image, options: &WriteOptions, file: impl Write + Seek) -> io::Result<()> {
    let channel = |c: usize| {
        image
            .pixels
            .iter()
            .map(|pixel| pixel.to_array()[c])
            .collect()
    };
    let colours = [("R", 0), ("G", 1), ("B", 2)]
        .map(|(name, c)| AnyChannel::new(name, FlatSamples::F32(channel(c))));
    let layers = options
        .layers
        .iter()
        .map(|layer| AnyChannel::new(layer.name.as_str(), FlatSamples::F32(layer.samples.clone())));
    let channels = AnyChannels::sort(colours.into_iter().chain(layers).collect());
    let encoding = Encoding {
        compression: Compression::ZIP16,
        line_order: LineOrder::Increasing,
        ..Encoding::FAST_LOSSLESS
    };
    let size = (image.width as usize, image.height as usize);
    let layer = exr::prelude::Layer::new(size, LayerAttributes::default(), encoding, channels);
    let mut picture = exr::prelude::Image::from_layer(layer);
    for (name, value) in &options.metadata {
        let value = match value {
            MetadataValue::Text(text) => {
                AttributeValue::Text(Text::new_or_none(text).unwrap_or_default())
            }
            MetadataValue::Number(number) => AttributeValue::F64(*number),
        };
        picture
            .attributes
            .other
            .insert(Text::from(name.as_str()), value);
    }
    picture.write().to_buffered(file).map_err(io::Error::other)
}

/// Reads a picture, or says why not.
pub fn decode(bytes: &[u8]) -> Result<Image, String> {
    let picture = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("not an EXR picture that can be read: {error}"))?;
    let layer = picture.layer_data;
    let (width, height) = checked_size(layer.size.0, layer.size.1)?;
    let find = |name: &str| {
        layer
            .channel_data
            .list
            .iter()
            .find(|channel| channel.name.eq(name))
    };
    let grey = find("Y");
    let [red, green, blue] = ["R", "G", "B"].map(|name| find(name).or(grey));
    let (Some(red), Some(green), Some(blue)) = (red, green, blue) else {
        return Err("an EXR picture without channels R, G and B, or Y".to_owned());
    };
    let values = [red, green, blue].map(|channel| channel.sample_data.values_as_f32());
    let [red, green, blue] = values;
    let pixels = red
        .zip(green)
        .zip(blue)
        .map(|((r, g), b)| Rgb::new(r, g, b))
        .collect();
    Ok(Image::new(width, height, pixels))
}
