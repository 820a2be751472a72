//! Accessors of glTF: the numbers in a buffer, in any packing.
//!
//! Measure: as the accessor says; normalised integers are fractions of their maximum.
//! Range: elements within their buffer view; sparse indices within the accessor. Nothing is allocated here.
//! Source: glTF 2.0, chapter 3.6.2. Tested in `tests/loading/gltf.rs`.

use super::buffers::Asset;
use crate::error::Result;
use gltf::accessor::{Accessor, DataType};

/// The elements of an accessor, each of `N` numbers.
#[derive(Debug, Clone, Copy)]
pub struct Elements<'a, const N: usize> {
    /// `None` if all elements are zero, but for the sparse ones.
    packed: Option<Packed<'a>>,
    count: usize,
    sparse: Option<Sparse<'a>>,
    data_type: DataType,
    normalised: bool,
}

/// Elements at equal distances.
#[derive(Debug, Clone, Copy)]
struct Packed<'a> {
    /// The span from the first byte of the first element to the last byte of the last.
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that replace others.
#[derive(Debug, Clone, Copy)]
struct Sparse<'a> {
    indices: Packed<'a>,
    index_type: DataType,
    count: usize,
    values: Packed<'a>,
}

impl<'a, const N: usize> Elements<'a, N> {
    /// Returns the elements of an accessor.
    ///
    /// # Errors
    /// If the accessor has elements of other dimensions, or they are not within their buffer view.
    pub fn new(asset: &'a Asset<'_>, accessor: &Accessor<'_>) -> Result<Self> {
        let index = accessor.index();
        let wrong = |message: String| asset.error(format!("accessors[{index}]"), message);
        let found = accessor.dimensions().multiplicity();
        if found != N {
            return Err(wrong(format!(
                "expected elements of {N} numbers, found {found}"
            )));
        }
        let (count, data_type) = (accessor.count(), accessor.data_type());
        let size = N * data_type.size();
        let packed = |view: &gltf::buffer::View<'_>, offset, stride, size, count| {
            let bytes = asset.view(view)?;
            Packed::new(bytes, offset, stride, size, count).map_err(&wrong)
        };
        let elements = accessor.view().map(|view| {
            let stride = view.stride().unwrap_or(size);
            packed(&view, accessor.offset(), stride, size, count)
        });
        let sparse = accessor.sparse().map(|sparse| -> Result<_> {
            let (indices, values) = (sparse.indices(), sparse.values());
            let index_type = match indices.index_type() {
                gltf::accessor::sparse::IndexType::U8 => DataType::U8,
                gltf::accessor::sparse::IndexType::U16 => DataType::U16,
                gltf::accessor::sparse::IndexType::U32 => DataType::U32,
            };
            let (n, width) = (sparse.count(), index_type.size());
            let sparse = Sparse {
                indices: packed(&indices.view(), indices.offset(), width, width, n)?,
                index_type,
                count: n,
                values: packed(&values.view(), values.offset(), size, size, n)?,
            };
            sparse.check(count).map_err(&wrong)?;
            Ok(sparse)
        });
        let elements = Self {
            packed: elements.transpose()?,
            count,
            sparse: sparse.transpose()?,
            data_type,
            normalised: accessor.normalized(),
        };
        // Zeros cost no bytes, so that their number is limited by those that the file has.
        if elements.packed.is_none() && count > asset.size() {
            return Err(wrong(format!(
                "expected a buffer view: {count} elements without one are more than the buffers have bytes"
            )));
        }
        Ok(elements)
    }

    /// The number of elements.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Element `index`, which is less than the count.
    #[inline]
    pub fn get(&self, index: usize) -> [f64; N] {
        let bytes = self.sparse.and_then(|sparse| sparse.find(index));
        let bytes = bytes.or_else(|| self.packed.map(|packed| packed.from(index)));
        let Some(bytes) = bytes else {
            return [0.0; N];
        };
        std::array::from_fn(|i| {
            let number = number(bytes, i, self.data_type);
            if self.normalised {
                normalised(number, self.data_type)
            } else {
                number
            }
        })
    }
}

impl<'a> Elements<'a, 1> {
    /// Element `index` as an index of something, which is less than the count; the accessor has integers.
    #[inline]
    pub fn index(&self, index: usize) -> u32 {
        let sparse = self.sparse.and_then(|sparse| sparse.find(index));
        let bytes = sparse.or_else(|| self.packed.map(|packed| packed.from(index)));
        bytes.map_or(0, |bytes| whole(bytes, self.data_type))
    }

    /// Whether the accessor has unsigned integers.
    pub fn is_unsigned(&self) -> bool {
        matches!(self.data_type, DataType::U8 | DataType::U16 | DataType::U32)
    }
}

impl<'a> Packed<'a> {
    fn new(
        bytes: &'a [u8],
        offset: usize,
        stride: usize,
        size: usize,
        count: usize,
    ) -> std::result::Result<Self, String> {
        if stride < size {
            return Err(format!(
                "expected elements of {size} bytes, but they are {stride} bytes apart"
            ));
        }
        // Of no element, nothing is read.
        let end = (count.max(1) - 1)
            .checked_mul(stride)
            .and_then(|end| end.checked_add(size)?.checked_add(offset));
        let bytes = end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            format!(
                "expected {count} elements of {size} bytes, {stride} bytes apart, from byte {offset} on, but the buffer \
                 view has {} bytes",
                bytes.len()
            )
        })?;
        Ok(Self { bytes, stride })
    }

    #[inline]
    fn from(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}

impl<'a> Sparse<'a> {
    /// Checks that the indices increase and are less than `count`.
    fn check(&self, count: usize) -> std::result::Result<(), String> {
        let mut last = None;
        for i in 0..self.count {
            let index = self.index(i) as usize;
            if index >= count || last.is_some_and(|last| index <= last) {
                return Err(format!(
                    "expected increasing sparse indices below {count}, found {index} at place {i}"
                ));
            }
            last = Some(index);
        }
        Ok(())
    }

    #[inline]
    fn index(&self, i: usize) -> u32 {
        whole(self.indices.from(i), self.index_type)
    }

    /// The value that replaces an element.
    fn find(&self, index: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = (low + high) / 2;
            match (self.index(middle) as usize).cmp(&index) {
                std::cmp::Ordering::Equal => return Some(self.values.from(middle)),
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

/// The bytes of number `i`.
#[inline]
fn chunk<const SIZE: usize>(bytes: &[u8], i: usize) -> [u8; SIZE] {
    let bytes = &bytes[i * SIZE..(i + 1) * SIZE];
    std::array::from_fn(|k| bytes[k])
}

#[inline]
fn number(bytes: &[u8], i: usize, data_type: DataType) -> f64 {
    match data_type {
        DataType::I8 => f64::from(i8::from_le_bytes(chunk(bytes, i))),
        DataType::U8 => f64::from(bytes[i]),
        DataType::I16 => f64::from(i16::from_le_bytes(chunk(bytes, i))),
        DataType::U16 => f64::from(u16::from_le_bytes(chunk(bytes, i))),
        DataType::U32 => f64::from(u32::from_le_bytes(chunk(bytes, i))),
        DataType::F32 => f64::from(f32::from_le_bytes(chunk(bytes, i))),
    }
}

#[inline]
fn whole(bytes: &[u8], data_type: DataType) -> u32 {
    match data_type {
        DataType::U8 => u32::from(bytes[0]),
        DataType::U16 => u32::from(u16::from_le_bytes(chunk(bytes, 0))),
        _ => u32::from_le_bytes(chunk(bytes, 0)),
    }
}

/// Maps an integer to [0, 1], or [-1, 1] if it has a sign.
fn normalised(number: f64, data_type: DataType) -> f64 {
    match data_type {
        DataType::I8 => (number / 127.0).max(-1.0),
        DataType::U8 => number / 255.0,
        DataType::I16 => (number / 32767.0).max(-1.0),
        DataType::U16 => number / 65535.0,
        DataType::U32 | DataType::F32 => number,
    }
}

/// Whether every number is finite in single precision.
pub fn is_finite<const N: usize>(numbers: &[f64; N]) -> bool {
    numbers.iter().all(|&x| (x as f32).is_finite())
}
