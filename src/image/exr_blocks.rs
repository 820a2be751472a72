//! Validation of the blocks of an OpenEXR file against its header: a damaged file may declare tiles of any size, and
//! name blocks of other parts as its own.
//!
//! Measure: pixels, bytes.
//! Range: any file whose header could be read; blocks that do not fit are errors.
//! Source: the `exr` crate, which leaves this to its users. Tested below and by the fuzz target `image`.

use super::MAX_PIXELS_PER_BYTE;
use crate::error::{Error, Result};
use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::TileCoordinates;
use ::exr::error::UnitResult;
use ::exr::image::read::layers::ChannelsReader;
use ::exr::meta::BlockDescription;
use ::exr::meta::header::Header;
use ::exr::prelude::{ReadChannels, Vec2};

/// Rejects blocks that a file of `bytes` bytes cannot hold, before memory is allocated: tiles may be larger than the
/// image.
pub(super) fn check_sizes(header: &Header, bytes: usize) -> Result<()> {
    let Vec2(width, height) = header.max_block_pixel_size();
    // The last lines of an image are a block, too, which may have fewer lines.
    let height = match header.blocks {
        BlockDescription::ScanLines => height.min(header.layer_size.1),
        BlockDescription::Tiles(_) => height,
    };
    let channels = header.channels.list.len();
    let samples = width.saturating_mul(height).saturating_mul(channels);
    if samples > MAX_PIXELS_PER_BYTE * bytes {
        return Err(Error::scene(format!(
            "blocks of {width} x {height} pixels with {channels} channels do not fit in {bytes} bytes"
        )));
    }
    Ok(())
}

/// A channel reader that accepts a block only if it fits in its part.
pub(super) struct Fitting<C>(pub(super) C);

impl<'s, C: ReadChannels<'s>> ReadChannels<'s> for Fitting<C> {
    type Reader = FittingReader<C::Reader>;

    fn create_channels_reader(&'s self, part: &Header) -> ::exr::error::Result<Self::Reader> {
        self.0.create_channels_reader(part).map(FittingReader)
    }
}

/// The reader of the blocks.
pub(super) struct FittingReader<R>(R);

impl<R: ChannelsReader> ChannelsReader for FittingReader<R> {
    type Channels = R::Channels;

    fn filter_block(&self, tile: TileCoordinates) -> bool {
        self.0.filter_block(tile)
    }

    fn read_block(&mut self, part: &Header, block: UncompressedBlock) -> UnitResult {
        let Vec2(left, top) = block.index.pixel_position;
        let Vec2(width, height) = block.index.pixel_size;
        let is_within = left + width <= part.layer_size.0 && top + height <= part.layer_size.1;
        if !is_within || block.data.len() != width * height * part.channels.bytes_per_pixel {
            return Err(::exr::error::Error::Invalid(
                "a block of another part".into(),
            ));
        }
        self.0.read_block(part, block)
    }

    fn into_channels(self) -> Self::Channels {
        self.0.into_channels()
    }
}

#[cfg(test)]
mod tests {
    use super::super::ColourSpace;
    use super::super::Image;
    use crate::math::rgb::Rgb;
    use ::exr::prelude::{
        AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image as ExrImage, ImageAttributes,
        IntegerBounds, Layer, LayerAttributes, Text, Vec2, WritableImage,
    };
    use std::io::Cursor;

    fn grey(name: &str, size: (usize, usize), blocks: Blocks) -> Layer<AnyChannels<FlatSamples>> {
        let samples = FlatSamples::F32(vec![0.25; size.0 * size.1]);
        let channels = [AnyChannel::new("Y", samples)].into_iter().collect();
        let encoding = Encoding {
            blocks,
            ..Encoding::UNCOMPRESSED
        };
        let attributes = LayerAttributes::named(Text::from(name));
        Layer::new(size, attributes, encoding, AnyChannels::sort(channels))
    }

    fn decoded(bytes: &[u8]) -> Result<Image, String> {
        Image::decode(bytes, ColourSpace::Linear).map_err(|error| error.to_string())
    }

    #[test]
    fn exr_tiles_may_exceed_the_image_but_not_the_file_capacity() {
        let tiled = |size: usize| {
            let mut bytes = Cursor::new(Vec::new());
            ExrImage::from_layer(grey("tiles", (2, 1), Blocks::Tiles(Vec2(size, size))))
                .write()
                .to_buffered(&mut bytes)
                .expect("encoded");
            decoded(bytes.get_ref())
        };
        assert_eq!(
            tiled(1024).expect("an image").pixels(),
            [Rgb::grey(0.25); 2]
        );
        let vast = tiled(1 << 14).expect_err("268 million pixels");
        assert!(vast.contains("blocks of 16384 x 16384 pixels"), "{vast}");
    }

    /// A file of two parts, whose first part has an offset that points to a block of the second.
    #[test]
    fn blocks_of_another_part_are_rejected() {
        let (small, large) = ((2, 2), (16, 16));
        let parts = [
            grey("a", small, Blocks::ScanLines),
            grey("b", large, Blocks::ScanLines),
        ];
        let window = IntegerBounds::from_dimensions(large);
        let mut bytes = Cursor::new(Vec::new());
        ExrImage::from_layers(ImageAttributes::new(window), Vec::from(parts))
            .write()
            .to_buffered(&mut bytes)
            .expect("encoded");
        let mut bytes = bytes.into_inner();
        assert_eq!(decoded(&bytes).expect("an image").pixels().len(), 4);

        // Each part has a table of line offsets: the first entry is changed to point at the last line of the second
        // part.
        let last_line = bytes.len() - (4 + 4 + 4 + 16 * 4);
        let first_line = last_line - 15 * (4 + 4 + 4 + 16 * 4) - 2 * (4 + 4 + 4 + 2 * 4);
        let table = first_line - 8 * (2 + 16);
        let entry = |bytes: &[u8]| bytes[table..table + 8].to_vec();
        assert_eq!(entry(&bytes), (first_line as u64).to_le_bytes());
        bytes[table..table + 8].copy_from_slice(&(last_line as u64).to_le_bytes());
        let error = decoded(&bytes).expect_err("its line is of another part");
        assert!(error.contains("block of another part"), "{error}");
    }
}
