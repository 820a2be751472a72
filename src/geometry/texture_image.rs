//! The images of textures, stored for lookups at random positions, which are bound by memory latency rather than arithmetic.
//!
//! An 8-bit image has at most 256 distinct values over all channels. A texel is stored as codes of these values, four
//! bytes instead of twelve, in tiles of 4 x 4 texels that fill one cache line each, so that neighbouring texels mostly
//! share a line.
//!
//! Measure: those of [`super::texture`].
//! Range: any image; one with more values is stored as it is. Codes are lossless: lookups are identical to the last bit.
//! Source: tiles after Igehy, Eldridge and Proudfoot 1998, "Prefetching in a Texture Cache Architecture". Tested below.

use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// The number of texels along a side of a tile.
const SIDE: u32 = 4;

/// The number of codes of a byte.
const CODES: usize = 256;

/// The number of hash slots of a codebook, large enough that few values collide. A power of two.
const SLOTS: usize = 4 * CODES;

/// The image of a texture.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureImage(Storage);

#[derive(Debug, Clone, PartialEq)]
enum Storage {
    /// An image with few values.
    Codes(Codes),
    /// An image with many values.
    Values(Image),
}

/// An image as codes of its values.
#[derive(Debug, Clone, PartialEq)]
struct Codes {
    size: (u32, u32),
    tiles_per_row: u32,
    tiles: Vec<TexelBlock>,
    values: Box<[f32; CODES]>,
}

/// The codes of red, green and blue of each texel, padded to four bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(align(64))]
struct TexelBlock([[u8; 4]; (SIDE * SIDE) as usize]);

impl From<Image> for TextureImage {
    fn from(image: Image) -> Self {
        Self(match Codes::new(&image) {
            Some(codes) => Storage::Codes(codes),
            None => Storage::Values(image),
        })
    }
}

impl TextureImage {
    /// The width in texels.
    #[inline]
    pub fn width(&self) -> u32 {
        self.size().0
    }

    /// The height in texels.
    #[inline]
    pub fn height(&self) -> u32 {
        self.size().1
    }

    /// The width and the height.
    #[inline]
    pub fn size(&self) -> (u32, u32) {
        match &self.0 {
            Storage::Codes(codes) => codes.size,
            Storage::Values(image) => (image.width(), image.height()),
        }
    }

    /// The number of texels.
    pub fn texel_count(&self) -> usize {
        let (width, height) = self.size();
        width as usize * height as usize
    }

    /// The texel in column `x` of row `y`.
    ///
    /// # Panics
    ///
    /// If it lies beyond the image by more than a tile.
    #[inline]
    pub fn get(&self, x: u32, y: u32) -> Rgb {
        match &self.0 {
            Storage::Codes(codes) => codes.get(x, y),
            Storage::Values(image) => image.get(x, y),
        }
    }

    /// All texels, row by row from the top.
    pub fn texels(&self) -> impl ExactSizeIterator<Item = Rgb> {
        let width = self.width() as usize;
        (0..self.texel_count()).map(move |i| self.get((i % width) as u32, (i / width) as u32))
    }

    /// The colour at `uv` by bilinear interpolation, of an image that repeats over [0, 1].
    #[inline]
    pub fn lookup(&self, uv: Vec2) -> Rgb {
        self.lookup_with(uv, |texel| texel)
    }

    /// The colour at `uv`, with a function of the texels in their place.
    #[inline]
    pub fn lookup_with(&self, uv: Vec2, decode: impl Fn(Rgb) -> Rgb) -> Rgb {
        let size = self.size();
        match &self.0 {
            Storage::Codes(codes) => bilinear(size, uv, |x, y| decode(codes.get(x, y))),
            Storage::Values(image) => bilinear(size, uv, |x, y| decode(image.get(x, y))),
        }
    }

    /// The image with a function of each texel.
    pub fn map(&self, f: impl FnMut(Rgb) -> Rgb) -> Self {
        let (width, height) = self.size();
        Image::new(width, height, self.texels().map(f).collect()).into()
    }

    /// An image of these texels, of twelve bytes each.
    pub fn to_image(&self) -> Image {
        match &self.0 {
            Storage::Codes(codes) => {
                let (width, height) = codes.size;
                Image::new(width, height, self.texels().collect())
            }
            Storage::Values(image) => image.clone(),
        }
    }

    /// The mean of each channel over all texels.
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for texel in self.texels() {
            for (sum, channel) in sum.iter_mut().zip(texel.to_array()) {
                *sum += f64::from(channel);
            }
        }
        sum.map(|sum| sum / self.texel_count() as f64)
    }
}

impl Serialize for TextureImage {
    /// By the texels, however they are stored.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct Texels<'a>(&'a TextureImage);

        impl Serialize for Texels<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_seq(self.0.texels())
            }
        }

        let mut image = serializer.serialize_struct("TextureImage", 3)?;
        image.serialize_field("width", &self.width())?;
        image.serialize_field("height", &self.height())?;
        image.serialize_field("texels", &Texels(self))?;
        image.end()
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

/// The colour at `uv` of an image of this width and height, by bilinear interpolation of the nearest texels.
#[inline]
fn bilinear((width, height): (u32, u32), uv: Vec2, texel: impl Fn(u32, u32) -> Rgb) -> Rgb {
    let (left, right, x) = neighbours(uv.x, width);
    // Rows go down, v goes up.
    let (above, below, y) = neighbours(-uv.y, height);
    let top = texel(left, above).lerp(texel(right, above), x);
    let bottom = texel(left, below).lerp(texel(right, below), x);
    top.lerp(bottom, y)
}

/// The two texels, of a repeating row of `count`, whose centres enclose `t`, and the interpolation weight of the
/// second.
#[inline]
fn neighbours(t: f32, count: u32) -> (u32, u32, f32) {
    // In [0, count], measured from the centre of the last texel of the previous period.
    let position = (t - t.floor()) * count as f32 + planted!("half-a-texel", 0.0, 0.5);
    let whole = position as u32;
    let second = if whole >= count { whole - count } else { whole };
    // Only a rounding error, or a `t` that is not finite, exceeds the range.
    let second = second.min(count - 1);
    let first = if second == 0 { count - 1 } else { second - 1 };
    (first, second, position - whole as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image with this many values, whose size is not a multiple of the tile size.
    fn image(values: u32) -> Image {
        let (width, height) = (37, 23);
        let value = |i: u32| (i * 7919 % values) as f32 / 255.0;
        let pixels = (0..width * height)
            .map(|i| Rgb::new(value(3 * i), value(3 * i + 1), value(3 * i + 2)))
            .collect();
        Image::new(width, height, pixels)
    }

    #[test]
    fn texels_and_lookups_are_those_of_the_image_bit_for_bit() {
        for (values, has_codes) in [(2, true), (256, true), (257, false)] {
            let image = image(values);
            let stored = TextureImage::from(image.clone());
            assert_eq!(matches!(stored.0, Storage::Codes(_)), has_codes, "{values}");
            assert_eq!(stored.to_image(), image);
            assert_eq!(stored.mean(), image.mean());
            let size = (image.width(), image.height());
            assert_eq!((stored.size(), stored.texels().len()), (size, 37 * 23));
            for i in 0..4000 {
                let uv = Vec2::new(i as f32 * 0.0137 - 20.0, i as f32 * 0.0071 - 3.0);
                let expected = bilinear(size, uv, |x, y| image.get(x, y));
                assert_eq!(stored.lookup(uv), expected, "{values} {uv}");
            }
        }
    }

    #[test]
    fn mapped_images_may_need_other_storage() {
        let stored = TextureImage::from(image(256));
        let twice = stored.map(|texel| 2.0 * texel);
        assert!(matches!(twice.0, Storage::Codes(_)));
        let mut count = 0.0;
        let numbered = stored.map(|_| {
            count += 1.0;
            Rgb::grey(count)
        });
        assert!(matches!(numbered.0, Storage::Values(_)));
        assert_eq!(numbered.get(1, 1), Rgb::grey(39.0));
    }

    #[test]
    fn storage_does_not_change_what_is_hashed() {
        let image = image(256);
        let hashed = |image: &TextureImage| postcard::to_allocvec(image).expect("plain data");
        let values = TextureImage(Storage::Values(image.clone()));
        assert_eq!(hashed(&image.into()), hashed(&values));
    }
}
