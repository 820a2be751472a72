//! Images packed for lookups at random positions, which are bound by memory latency rather than arithmetic.
//!
//! An 8-bit image has at most 256 distinct values over all channels. A texel is stored as codes of these values, four
//! bytes instead of twelve, in tiles of 4 x 4 texels that fill one cache line each, so that neighbouring texels mostly
//! share a line.
//!
//! Measure: those of [`super::texture`].
//! Range: any image; one with more values is stored unpacked. Packing is lossless: lookups are identical to the last
//! bit.
//! Source: tiles after Igehy, Eldridge and Proudfoot 1998, "Prefetching in a Texture Cache Architecture". Tested below.

use super::texture::bilinear;
use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use std::sync::Arc;

/// The number of texels along a side of a tile.
const SIDE: u32 = 4;

/// The number of codes of a byte.
const CODES: usize = 256;

/// The number of hash slots of a codebook, large enough that few values collide. A power of two.
const SLOTS: usize = 4 * CODES;

/// A packed image.
#[derive(Debug, Clone)]
pub enum PackedImage {
    /// An image with few values.
    Codes(Codes),
    /// An image with many values.
    Values(Arc<Image>),
}

/// An image as codes of its values.
#[derive(Debug, Clone)]
pub struct Codes {
    size: (u32, u32),
    tiles_per_row: u32,
    tiles: Vec<TexelBlock>,
    values: Box<[f32; CODES]>,
}

/// The codes of red, green and blue of each texel, padded to four bytes.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
struct TexelBlock([[u8; 4]; (SIDE * SIDE) as usize]);

impl PackedImage {
    /// Packs an image.
    pub fn new(image: &Arc<Image>) -> Self {
        Codes::new(image).map_or_else(|| Self::Values(Arc::clone(image)), Self::Codes)
    }

    /// The width and the height.
    #[inline]
    pub fn size(&self) -> (u32, u32) {
        match self {
            Self::Codes(codes) => codes.size,
            Self::Values(image) => (image.width(), image.height()),
        }
    }

    /// The colour at `uv`, identical to [`Texture::lookup`](super::texture::Texture::lookup).
    #[inline]
    pub fn lookup(&self, uv: Vec2) -> Rgb {
        match self {
            Self::Codes(codes) => bilinear(codes.size, uv, |x, y| codes.get(x, y)),
            Self::Values(image) => {
                bilinear((image.width(), image.height()), uv, |x, y| image.get(x, y))
            }
        }
    }
}

impl Codes {
    /// Encodes an image; `None` if it has more values than a byte has codes.
    fn new(image: &Image) -> Option<Self> {
        let mut codebook = Codebook::default();
        // Most images with too many values show it in their first rows, before any memory is taken for codes.
        for texel in image.pixels() {
            for value in texel.to_array() {
                codebook.code(value)?;
            }
        }
        let size = (image.width(), image.height());
        let tiles_per_row = size.0.div_ceil(SIDE);
        let count = tiles_per_row as usize * size.1.div_ceil(SIDE) as usize;
        let mut codes = Self {
            size,
            tiles_per_row,
            tiles: vec![TexelBlock::default(); count],
            values: Box::new([0.0; CODES]),
        };
        for (i, row) in image.pixels().chunks(size.0 as usize).enumerate() {
            for (j, texel) in row.iter().enumerate() {
                let (tile, place) = codes.place(j as u32, i as u32);
                for (code, value) in codes.tiles[tile].0[place].iter_mut().zip(texel.to_array()) {
                    *code = codebook.code(value)?;
                }
            }
        }
        codes.values[..codebook.values.len()].copy_from_slice(&codebook.values);
        Some(codes)
    }

    /// The tile of a texel, and its index in the tile.
    #[inline]
    fn place(&self, x: u32, y: u32) -> (usize, usize) {
        let tile = (y / SIDE) as usize * self.tiles_per_row as usize + (x / SIDE) as usize;
        (tile, (SIDE * (y % SIDE) + x % SIDE) as usize)
    }

    #[inline]
    fn get(&self, x: u32, y: u32) -> Rgb {
        let (tile, place) = self.place(x, y);
        let [r, g, b, _] = self.tiles[tile].0[place];
        let value = |code: u8| self.values[usize::from(code)];
        Rgb::new(value(r), value(g), value(b))
    }
}

/// The values found so far; the code of a value is its order of appearance.
struct Codebook {
    values: Vec<f32>,
    /// The codes plus one, by a hash of the value; 0 marks an empty slot.
    slots: [u16; SLOTS],
}

impl Default for Codebook {
    fn default() -> Self {
        Self {
            values: Vec::with_capacity(CODES),
            slots: [0; SLOTS],
        }
    }
}

impl Codebook {
    /// Returns the code of a value, compared by its bits; `None` if no codes are left.
    fn code(&mut self, value: f32) -> Option<u8> {
        let bits = value.to_bits();
        // Fibonacci hashing: the high bits are well mixed. Linear probing finds the value or a free slot.
        let mut slot = (bits.wrapping_mul(0x9E37_79B1) >> (32 - SLOTS.ilog2())) as usize;
        loop {
            match usize::from(self.slots[slot]) {
                0 if self.values.len() == CODES => return None,
                0 => {
                    self.values.push(value);
                    self.slots[slot] = self.values.len() as u16;
                }
                found if self.values[found - 1].to_bits() == bits => {
                    return u8::try_from(found - 1).ok();
                }
                _ => slot = (slot + 1) % SLOTS,
            }
        }
    }
}

/// Packed images with the images they were made from: each image is packed once, for any number of materials.
#[derive(Debug, Default)]
pub struct PackedImages(Vec<(Arc<Image>, Arc<PackedImage>)>);

impl PackedImages {
    /// Returns the packed image, packing it on first use.
    pub fn pack(&mut self, image: &Arc<Image>) -> Arc<PackedImage> {
        if let Some((_, packed)) = self.0.iter().find(|(known, _)| Arc::ptr_eq(known, image)) {
            return Arc::clone(packed);
        }
        let packed = Arc::new(PackedImage::new(image));
        self.0.push((Arc::clone(image), Arc::clone(&packed)));
        packed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::texture::Texture;

    /// An image with this many values, whose size is not a multiple of the tile size.
    fn image(values: u32) -> Arc<Image> {
        let (width, height) = (37, 23);
        let value = |i: u32| (i * 7919 % values) as f32 / 255.0;
        let pixels = (0..width * height)
            .map(|i| Rgb::new(value(3 * i), value(3 * i + 1), value(3 * i + 2)))
            .collect();
        Arc::new(Image::new(width, height, pixels))
    }

    #[test]
    fn packed_and_unpacked_texture_lookups_are_identical() {
        for (values, packs) in [(2, true), (256, true), (257, false)] {
            let image = image(values);
            let packed = PackedImage::new(&image);
            assert_eq!(matches!(packed, PackedImage::Codes(_)), packs, "{values}");
            let texture = Texture::Image { image, scale: 1.0 };
            for i in 0..4000 {
                let uv = Vec2::new(i as f32 * 0.0137 - 20.0, i as f32 * 0.0071 - 3.0);
                assert_eq!(packed.lookup(uv), texture.lookup(uv), "{values} {uv}");
            }
        }
    }

    #[test]
    fn each_image_is_packed_only_once() {
        let (one, other) = (image(20), image(20));
        let mut packed = PackedImages::default();
        let first = packed.pack(&one);
        assert!(Arc::ptr_eq(&first, &packed.pack(&one)));
        assert!(!Arc::ptr_eq(&first, &packed.pack(&other)));
    }
}
