//! Reading all of an OpenEXR file: the image, its further channels and the metadata of this program.
//!
//! Measure: linear; the data window is the image.
//! Range: reads the part that `exr.rs` reads the image from, of 16 or 32 bits a channel; integers beyond 2^24 are
//! rounded. At most 2^30 samples in all. Deep data and subsampled channels are refused.
//! Source: the `exr` crate. Tested below and by the fuzz target `image`.

use super::exr::{Colours, checked_meta_data, not_valid};
use super::exr_blocks::Fitting;
use super::options::{Layer, MetadataValue};
use super::{Image, MAX_PIXELS, MAX_PIXELS_PER_BYTE, checked_size};
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use ::exr::image::read::any_channels::ReadAnyChannels;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::samples::ReadFlatSamples;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use ::exr::prelude::{AttributeValue, FlatSamples, ReadChannels, Text, Vec2};
use std::io::Cursor;

/// The most samples of all channels together that are read: 4 GiB in memory.
const MAX_SAMPLES: usize = 4 * MAX_PIXELS;

/// The prefix of the names of this program's metadata.
pub(super) const FACT_PREFIX: &str = "etendue.";

/// The contents of a file.
pub(super) struct ExrContents {
    /// The image; its pixels are not checked to be finite yet.
    pub(super) image: Image,
    pub(super) layers: Vec<Layer>,
    pub(super) metadata: Vec<(String, MetadataValue)>,
}

/// Decodes everything in the bytes of an OpenEXR file.
pub(super) fn decode(bytes: &[u8]) -> Result<ExrContents> {
    let (meta, colours) = checked_meta_data(bytes)?;
    check_samples(&meta, bytes.len())?;
    let all_channels = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels();
    let part = PartWith {
        colours,
        all_channels,
    };
    let file = Fitting(part)
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(not_valid)?;

    let part = file.layer_data;
    let (width, height) = checked_size(part.size.0, part.size.1, bytes.len())?;
    let channels = part.channel_data.list.into_iter();
    let (of_picture, layers): (Vec<Layer>, Vec<Layer>) = channels
        .map(|channel| Layer {
            name: string(&channel.name),
            samples: floats(channel.sample_data),
        })
        .partition(|layer| colours.names().contains(&layer.name.as_str()));
    let attributes = file.attributes.other.iter().chain(&part.attributes.other);
    Ok(ExrContents {
        image: Image::new(width, height, pixels(colours, &of_picture)),
        layers,
        metadata: attributes.filter_map(fact).collect(),
    })
}

/// Rejects files that declare more samples than they can hold, before memory is allocated.
fn check_samples(meta: &MetaData, bytes: usize) -> Result<()> {
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        let channels = header.channels.list.len();
        let samples = width.saturating_mul(height).saturating_mul(channels);
        if samples > MAX_SAMPLES || samples > MAX_PIXELS_PER_BYTE * bytes {
            return Err(Error::scene(format!(
                "an image of {width} x {height} pixels with {channels} channels is too large, \
                 or does not fit in {bytes} bytes"
            )));
        }
    }
    Ok(())
}

/// A channel reader for all channels of a part that has those of the image.
struct PartWith {
    colours: Colours,
    all_channels: ReadAnyChannels<ReadFlatSamples>,
}

impl<'s> ReadChannels<'s> for PartWith {
    type Reader = <ReadAnyChannels<ReadFlatSamples> as ReadChannels<'s>>::Reader;

    fn create_channels_reader(&'s self, part: &Header) -> ::exr::error::Result<Self::Reader> {
        let refuse = |why: &'static str| Err(::exr::error::Error::NotSupported(why.into()));
        if !self.colours.are_in(part) {
            return refuse("a part without an image");
        }
        if part.deep {
            return refuse("deep data");
        }
        let whole = Vec2(1, 1);
        if part.channels.list.iter().any(|c| c.sampling != whole) {
            return refuse("subsampled channels");
        }
        self.all_channels.create_channels_reader(part)
    }
}

/// Builds the pixels from the colour channels of the image.
fn pixels(colours: Colours, channels: &[Layer]) -> Vec<Rgb> {
    let find = |name| {
        let found = channels.iter().find(|channel| channel.name == name);
        &found
            .expect("the part has the channels of the image")
            .samples
    };
    match colours {
        Colours::Rgb => {
            let [r, g, b] = ["R", "G", "B"].map(find);
            let pixels = r.iter().zip(g).zip(b);
            pixels.map(|((&r, &g), &b)| Rgb::new(r, g, b)).collect()
        }
        Colours::Grey => find("Y").iter().map(|&y| Rgb::grey(y)).collect(),
    }
}

fn floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(samples) => samples,
        FlatSamples::F16(samples) => samples.into_iter().map(|half| half.to_f32()).collect(),
        FlatSamples::U32(samples) => samples.into_iter().map(|whole| whole as f32).collect(),
    }
}

/// The metadata of an attribute, if its name has the prefix.
fn fact((name, value): (&Text, &AttributeValue)) -> Option<(String, MetadataValue)> {
    let name = string(name);
    let value = match value {
        AttributeValue::Text(text) => MetadataValue::Text(string(text)),
        AttributeValue::F64(real) => MetadataValue::Real(*real),
        AttributeValue::I32(whole) => MetadataValue::Integer((*whole).into()),
        _ => return None,
    };
    name.starts_with(FACT_PREFIX).then_some((name, value))
}

/// Converts OpenEXR's UTF-8 text to a string; invalid bytes are replaced.
fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::super::options::WriteOptions;
    use super::super::tests::sample_image;
    use super::super::{ColourSpace, LayeredImage, exr};
    use super::*;
    use ::exr::prelude::{AnyChannel, AnyChannels, WritableImage};

    fn encoded(options: &WriteOptions) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        exr::encode(&mut bytes, &sample_image(), options).expect("encoded");
        bytes.into_inner()
    }

    #[test]
    fn exr_layers_and_metadata_round_trip() {
        let layer = |name: &str, scale: f32| Layer {
            name: name.into(),
            samples: (0..13 * 7).map(|i| scale * i as f32).collect(),
        };
        let mut depth = layer("depth.Z", 0.5);
        depth.samples[3] = f32::INFINITY;
        let options = WriteOptions {
            // Sorted by name, as in files.
            layers: vec![layer("albedo.G", 0.01), depth, layer("se.R", 1e-3)],
            metadata: vec![
                (
                    "etendue.scene".into(),
                    MetadataValue::Text("sch\u{f6}n.toml".into()),
                ),
                ("etendue.seconds".into(), MetadataValue::Real(0.1)),
                ("etendue.spp".into(), MetadataValue::Integer(64)),
                ("other.fact".into(), MetadataValue::Integer(1)),
            ],
            ..WriteOptions::default()
        };
        let read = LayeredImage::decode(&encoded(&options), ColourSpace::Srgb).expect("an image");
        assert_eq!(read.image, sample_image());
        assert_eq!(read.layers, options.layers);
        let depth = read.layer("depth.Z").expect("the layer");
        assert_eq!(depth[3], f32::INFINITY);
        assert_eq!(read.metadata.len(), 3);
        for (name, value) in &options.metadata[..3] {
            let name = name.strip_prefix("etendue.").expect("it is ours");
            assert_eq!(read.fact(name), Some(value));
        }
    }

    #[test]
    fn half_and_integer_samples_and_grey_images_are_read() {
        let half = |value: f32| ::exr::prelude::f16::from_f32(value);
        let channels = [
            AnyChannel::new("Y", FlatSamples::F16(vec![half(0.25), half(4.0)])),
            AnyChannel::new("id.Y", FlatSamples::U32(vec![7, 1 << 20])),
        ];
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let mut bytes = Cursor::new(Vec::new());
        ::exr::prelude::Image::from_channels((2, 1), channels)
            .write()
            .to_buffered(&mut bytes)
            .expect("encoded");
        let read = LayeredImage::decode(bytes.get_ref(), ColourSpace::Linear).expect("an image");
        assert_eq!(read.image.pixels(), [Rgb::grey(0.25), Rgb::grey(4.0)]);
        assert_eq!(read.layer("id.Y"), Some(&[7.0, 1_048_576.0][..]));
    }

    #[test]
    fn channel_count_beyond_the_file_capacity_is_rejected() {
        // Flat channels compress well, but none to less than a byte in 8256 samples.
        let names = (0..40).map(|i| format!("flat.{i:02}"));
        let flat = |name| Layer {
            name,
            samples: vec![0.0; 13 * 7],
        };
        let options = WriteOptions {
            layers: names.map(flat).collect(),
            ..WriteOptions::default()
        };
        let bytes = encoded(&options);
        let (meta, _) = checked_meta_data(&bytes).expect("an image");
        check_samples(&meta, bytes.len()).expect("it fits");
        let error = check_samples(&meta, 43 * 13 * 7 / MAX_PIXELS_PER_BYTE);
        assert!(
            error
                .expect_err("too many")
                .to_string()
                .contains("43 channels")
        );
    }
}
