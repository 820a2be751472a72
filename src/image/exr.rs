//! Reading and writing OpenEXR: float pixels, with metadata and further layers.
//!
//! Measure: linear; the data window is the image.
//! Range: reads the first part with R, G and B, or with Y alone, of 16 or 32 bits. Deep data and subsampled chroma are
//! refused. Writes one part of 32-bit floats, losslessly compressed.
//! Source: the `exr` crate. Tested below and in `mod.rs`.

use super::exr_blocks::{self, Fitting};
use super::options::{MetadataValue, WriteOptions};
use super::{Image, checked_size};
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use ::exr::image::read::image::ReadLayers;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadSpecificChannel, Text, Vec2, WritableImage,
};
use std::io::{self, Cursor, Seek, Write};

/// The width of a row and the pixels while they are read. The pixels are arrays, because zeroed arrays take no memory
/// before they are written to, however large an image a damaged header declares.
type Rows = (usize, Vec<[f32; 3]>);

/// Whether bytes begin with the signature of OpenEXR.
pub(super) fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2F, 0x31, 0x01])
}

/// Decodes an image from the bytes of an OpenEXR file.
pub(super) fn decode(bytes: &[u8]) -> Result<Image> {
    match checked_meta_data(bytes)? {
        (_, Colours::Rgb) => decode_colour(bytes),
        (_, Colours::Grey) => decode_grey(bytes),
    }
}

/// The colour channels of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Colours {
    Rgb,
    Grey,
}

impl Colours {
    /// The names of the channels, in this order.
    pub(super) fn names(self) -> &'static [&'static str] {
        match self {
            Self::Rgb => &["R", "G", "B"],
            Self::Grey => &["Y"],
        }
    }

    /// Whether a part has all of these channels.
    pub(super) fn are_in(self, part: &Header) -> bool {
        let has = |name: &&str| part.channels.list.iter().any(|c| c.name.eq(name));
        self.names().iter().all(has)
    }
}

/// Reads the headers of a file and determines the colour channels of its image; an error if the image is too large or
/// has no colour channels.
pub(super) fn checked_meta_data(bytes: &[u8]) -> Result<(MetaData, Colours)> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(not_valid)?;
    for header in &meta.headers {
        checked_size(header.layer_size.0, header.layer_size.1, bytes.len())?;
        exr_blocks::check_sizes(header, bytes.len())?;
    }
    let some_part_has = |colours: Colours| meta.headers.iter().any(|part| colours.are_in(part));
    let channels = || {
        meta.headers
            .iter()
            .flat_map(|header| header.channels.list.iter())
    };
    if some_part_has(Colours::Rgb) {
        Ok((meta, Colours::Rgb))
    } else if some_part_has(Colours::Grey) && !channels().any(|channel| channel.name.eq("RY")) {
        Ok((meta, Colours::Grey))
    } else {
        let names: Vec<String> = channels().map(|channel| channel.name.to_string()).collect();
        Err(Error::scene(format!(
            "an OpenEXR file with the channels {}: expected R, G and B, or Y alone",
            names.join(", ")
        )))
    }
}

fn decode_colour(bytes: &[u8]) -> Result<Image> {
    let channels = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| new_rows(size),
            |rows, at, (r, g, b): (f32, f32, f32)| set_pixel(rows, at, [r, g, b]),
        );
    finish(
        Fitting(channels)
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes)),
        bytes.len(),
    )
}

fn decode_grey(bytes: &[u8]) -> Result<Image> {
    let channels = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("Y")
        .collect_pixels(
            |size, _| new_rows(size),
            |rows, at, (y,): (f32,)| set_pixel(rows, at, [y; 3]),
        );
    finish(
        Fitting(channels)
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes)),
        bytes.len(),
    )
}

fn new_rows(size: Vec2<usize>) -> Rows {
    (size.0, vec![[0.0; 3]; size.0 * size.1])
}

fn set_pixel((width, pixels): &mut Rows, Vec2(x, y): Vec2<usize>, pixel: [f32; 3]) {
    pixels[y * *width + x] = pixel;
}

fn finish<Channels>(
    read: ::exr::error::Result<
        ::exr::prelude::Image<Layer<::exr::image::SpecificChannels<Rows, Channels>>>,
    >,
    file_size: usize,
) -> Result<Image> {
    let layer = read.map_err(not_valid)?.layer_data;
    let (width, height) = checked_size(layer.size.0, layer.size.1, file_size)?;
    let (_, pixels) = layer.channel_data.pixels;
    let pixels = pixels.into_iter().map(Rgb::from).collect();
    Ok(Image::new(width, height, pixels))
}

pub(super) fn not_valid(cause: ::exr::error::Error) -> Error {
    Error::scene(format!("not a valid OpenEXR file: {cause}")).because(cause)
}

/// Writes `image` with its metadata and layers as an OpenEXR file.
pub(super) fn encode(
    writer: impl Write + Seek,
    image: &Image,
    options: &WriteOptions,
) -> io::Result<()> {
    let colours = ["R", "G", "B"].into_iter().enumerate().map(|(i, name)| {
        let samples = image.pixels().iter().map(|pixel| pixel.to_array()[i]);
        channel(name, samples.collect())
    });
    let layers = options
        .layers
        .iter()
        .map(|layer| channel(&layer.name, layer.samples.clone()));
    let part = Layer::new(
        (image.width() as usize, image.height() as usize),
        LayerAttributes::default(),
        Encoding {
            compression: Compression::ZIP16,
            line_order: LineOrder::Increasing,
            ..Encoding::UNCOMPRESSED
        },
        AnyChannels::sort(colours.chain(layers).collect()),
    );
    let mut file = ::exr::prelude::Image::from_layer(part);
    for (name, value) in &options.metadata {
        file.attributes.other.insert(text(name), attribute(value));
    }
    file.write()
        .to_buffered(writer)
        .map_err(|error| match error {
            ::exr::error::Error::Io(error) => error,
            other => io::Error::other(other),
        })
}

fn channel(name: &str, samples: Vec<f32>) -> AnyChannel<FlatSamples> {
    AnyChannel::new(text(name), FlatSamples::F32(samples))
}

fn attribute(value: &MetadataValue) -> AttributeValue {
    match value {
        MetadataValue::Text(value) => AttributeValue::Text(text(value)),
        MetadataValue::Real(value) => AttributeValue::F64(*value),
        // OpenEXR has no integers of 64 bits.
        MetadataValue::Integer(value) => match i32::try_from(*value) {
            Ok(value) => AttributeValue::I32(value),
            Err(_) => AttributeValue::Text(text(&value.to_string())),
        },
    }
}

/// Converts a string to OpenEXR's UTF-8 text; the crate's own conversion panics beyond Latin-1.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::super::options::Layer as ExtraLayer;
    use super::super::tests::sample_image;
    use super::*;

    fn encoded(image: &Image, options: &WriteOptions) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        encode(&mut bytes, image, options).expect("encoded");
        bytes.into_inner()
    }

    #[test]
    fn exr_round_trip_is_lossless_with_an_extra_layer() {
        let image = sample_image();
        let albedo = ExtraLayer {
            name: "albedo.R".into(),
            samples: (0..13 * 7).map(|i| i as f32).collect(),
        };
        let options = WriteOptions {
            layers: vec![albedo.clone()],
            ..WriteOptions::default()
        };
        let bytes = encoded(&image, &options);
        assert_eq!(decode(&bytes).expect("an image"), image);

        let file = ::exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .expect("an OpenEXR file");
        let channels = &file.layer_data.channel_data.list;
        let layer = channels.iter().find(|channel| channel.name.eq("albedo.R"));
        assert_eq!(
            layer.expect("the layer").sample_data,
            FlatSamples::F32(albedo.samples)
        );
    }

    #[test]
    fn exr_encoding_is_deterministic() {
        let image = Image::filled(300, 200, Rgb::new(0.1, 0.2, 0.3));
        let options = WriteOptions::default();
        assert_eq!(encoded(&image, &options), encoded(&image, &options));
    }

    #[test]
    fn metadata_is_written_as_typed_exr_attributes() {
        let scene = "/schemes/sch\u{f6}n/\u{65e5}\u{672c}.toml";
        let options = WriteOptions {
            metadata: vec![
                ("etendue.scene".into(), MetadataValue::Text(scene.into())),
                ("etendue.seconds".into(), MetadataValue::Real(0.1)),
                ("etendue.spp".into(), MetadataValue::Integer(64)),
                ("etendue.samples".into(), MetadataValue::Integer(1 << 40)),
            ],
            ..WriteOptions::default()
        };
        let bytes = encoded(&sample_image(), &options);
        let meta = MetaData::read_from_buffered(Cursor::new(&bytes), true).expect("meta data");
        let header = &meta.headers[0];
        let find = |name: &str| {
            let attributes = &header.own_attributes.other;
            attributes
                .get(&text(name))
                .or(header.shared_attributes.other.get(&text(name)))
        };
        assert_eq!(
            find("etendue.scene"),
            Some(&AttributeValue::Text(text(scene)))
        );
        assert_eq!(find("etendue.seconds"), Some(&AttributeValue::F64(0.1)));
        assert_eq!(find("etendue.spp"), Some(&AttributeValue::I32(64)));
        let samples = AttributeValue::Text(text("1099511627776"));
        assert_eq!(find("etendue.samples"), Some(&samples));
    }

    #[test]
    fn luminance_only_exr_is_grey_and_others_are_rejected_by_name() {
        let single = |name: &str| {
            let channels =
                AnyChannels::sort([channel(name, vec![0.25, 4.0])].into_iter().collect());
            let mut bytes = Cursor::new(Vec::new());
            ::exr::prelude::Image::from_channels((2, 1), channels)
                .write()
                .to_buffered(&mut bytes)
                .expect("encoded");
            decode(bytes.get_ref())
        };
        let grey = single("Y").expect("an image");
        assert_eq!(grey.pixels(), [Rgb::grey(0.25), Rgb::grey(4.0)]);
        let depth = single("Z").expect_err("no colour");
        assert!(depth.to_string().contains("channels Z"), "{depth}");
    }
}
