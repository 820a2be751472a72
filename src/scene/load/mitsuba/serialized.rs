//! Reads meshes in Mitsuba's compressed format, `.serialized`.
//!
//! Measure: the file's own units.
//! Range: versions 3 and 4; an error names the mesh and what was expected. Memory grows with what was decompressed, not
//! with what the file claims to contain.
//! Source: Mitsuba 3 documentation, "Serialized mesh loader". Tested in `tests/loading/mitsuba.rs`.

use crate::error::{Error, Result};
use crate::math::vec::{DVec2, DVec3};
use crate::memory;
use crate::scene::description::MeshDescription;
use flate2::read::ZlibDecoder;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

const MAGIC: u16 = 0x041c;
const NORMALS: u32 = 0x1;
const UVS: u32 = 0x2;
const COLOURS: u32 = 0x8;
const FACE_NORMALS: u32 = 0x10;
const DOUBLE: u32 = 0x2000;

/// The number of bytes that are decompressed at a time.
const PIECE: usize = 1 << 20;

/// Reads mesh number `index` of a file, and whether it is to have the normals of its faces.
///
/// # Errors
/// If the file cannot be read, has no such mesh, or the mesh is damaged.
pub fn read(path: &Path, index: usize) -> Result<(MeshDescription, bool)> {
    let (file, length) = super::super::open(path)?;
    let mesh = read_from(file, length, index);
    mesh.map_err(|why| Error::scene(format!("mesh {index}: {why}")).in_file(path))
}

/// Reads a mesh from a file of `length` bytes, of which no other mesh is read.
fn read_from(
    file: impl Read + Seek,
    length: u64,
    index: usize,
) -> std::result::Result<(MeshDescription, bool), String> {
    let (stream, version) = find(file, length, index as u64)?;
    inflate(stream, version)
}

/// Returns the compressed stream of a mesh, and the version of the format.
fn find(
    mut file: impl Read + Seek,
    length: u64,
    index: u64,
) -> std::result::Result<(impl Read, u16), String> {
    let mut number = |at: u64, size: usize| -> Option<u64> {
        let mut bytes = [0; 8];
        file.seek(SeekFrom::Start(at)).ok()?;
        file.read_exact(&mut bytes[..size]).ok()?;
        Some(u64::from_le_bytes(bytes))
    };
    let header = |both: Option<u64>| both.map(|both| (both as u16, (both >> 16) as u16));
    let version = match header(number(0, 4)) {
        Some((MAGIC, version @ (3 | 4))) => version,
        Some((MAGIC, version)) => return Err(format!("expected version 3 or 4, found {version}")),
        _ => return Err("expected a file in Mitsuba's format `serialized`".to_owned()),
    };
    let cut = || "the file is cut: expected its index at the end".to_owned();
    let end = length.saturating_sub(4);
    let count = number(end, 4).ok_or_else(cut)?;
    if index >= count {
        return Err(format!("there are {count} meshes, counted from 0"));
    }
    let size = if version == 4 { 8 } else { 4 };
    let table = end.checked_sub(count * size as u64).ok_or_else(cut)?;
    let start = number(table + index * size as u64, size);
    let start = start.filter(|&start| start < table).ok_or_else(cut)?;
    let wrong = || format!("expected a mesh at byte {start}");
    let size = table.checked_sub(start + 4).ok_or_else(wrong)?;
    // The stream begins after the header, where reading this leaves the file.
    match header(number(start, 4)) {
        Some((MAGIC, version @ (3 | 4))) => Ok((file.take(size), version)),
        _ => Err(wrong()),
    }
}

fn inflate(
    stream: impl Read,
    version: u16,
) -> std::result::Result<(MeshDescription, bool), String> {
    let mut reader = Inflated(ZlibDecoder::new(stream));
    let flags = reader.whole(4)? as u32;
    if version == 4 {
        // The name, which a zero ends.
        let mut length = 0;
        while reader.whole(1)? != 0 {
            length += 1;
            if length > 65_536 {
                return Err("expected a name of at most 65536 bytes".to_owned());
            }
        }
    }
    let (vertices, triangles) = (reader.whole(8)?, reader.whole(8)?);
    if vertices > u64::from(u32::MAX) || triangles > u64::from(u32::MAX) {
        return Err(format!(
            "expected fewer than 2^32 vertices and triangles, found {vertices} and {triangles}"
        ));
    }
    let size = if flags & DOUBLE == 0 { 4 } else { 8 };
    let mut vectors = |width: usize| reader.floats(width as u64 * vertices, size);
    let positions = triples(&vectors(3)?);
    let normals = if flags & NORMALS == 0 {
        Vec::new()
    } else {
        triples(&vectors(3)?)
    };
    let uvs = if flags & UVS == 0 {
        Vec::new()
    } else {
        vectors(2)?
    };
    if flags & COLOURS != 0 {
        vectors(3)?;
    }
    let mut indices = Vec::new();
    reader.words(3 * triangles, 4, |word| {
        let index = word.try_into().map(u32::from_le_bytes).unwrap_or(u32::MAX);
        indices.push(index);
        match u64::from(index) < vertices {
            true => Ok(()),
            false => Err(format!(
                "expected the index of one of {vertices} vertices, found {index}"
            )),
        }
    })?;
    if indices.is_empty() {
        return Err("expected triangles".to_owned());
    }
    let (indices, _) = indices.as_chunks();
    let (uvs, _) = uvs.as_chunks();
    let mesh = MeshDescription {
        positions,
        normals,
        uvs: uvs.iter().copied().map(DVec2::from_array).collect(),
        indices: indices.to_vec(),
    };
    Ok((mesh, flags & FACE_NORMALS != 0))
}

fn triples(numbers: &[f64]) -> Vec<DVec3> {
    let (triples, _) = numbers.as_chunks();
    triples.iter().copied().map(DVec3::from_array).collect()
}

/// A decompressed stream.
struct Inflated<R>(ZlibDecoder<R>);

impl<R: Read> Inflated<R> {
    fn fill(&mut self, bytes: &mut [u8]) -> std::result::Result<(), String> {
        let read = self.0.read_exact(bytes);
        read.map_err(|error| format!("the mesh is cut or damaged: {error}"))
    }

    fn whole(&mut self, size: usize) -> std::result::Result<u64, String> {
        let mut bytes = [0; 8];
        self.fill(&mut bytes[..size])?;
        Ok(u64::from_le_bytes(bytes))
    }

    /// Reads `count` words of `size` bytes, piece by piece.
    fn words(
        &mut self,
        count: u64,
        size: usize,
        mut each: impl FnMut(&[u8]) -> std::result::Result<(), String>,
    ) -> std::result::Result<(), String> {
        let mut left = count;
        let mut piece = vec![0; PIECE];
        while left > 0 {
            let now = left.min((PIECE / size) as u64);
            memory::check(now * 64, || "the mesh".to_owned()).map_err(|error| error.to_string())?;
            let bytes = &mut piece[..now as usize * size];
            self.fill(bytes)?;
            bytes.chunks_exact(size).try_for_each(&mut each)?;
            left -= now;
        }
        Ok(())
    }

    fn floats(&mut self, count: u64, size: usize) -> std::result::Result<Vec<f64>, String> {
        let mut floats = Vec::new();
        self.words(count, size, |word| {
            let float = match (
                word.try_into().map(f32::from_le_bytes),
                word.try_into().map(f64::from_le_bytes),
            ) {
                (Ok(float), _) => f64::from(float),
                (_, Ok(float)) => float,
                _ => f64::NAN,
            };
            floats.push(float);
            match (float as f32).is_finite() {
                true => Ok(()),
                false => Err(format!(
                    "expected numbers within single precision, found {float}"
                )),
            }
        })?;
        Ok(floats)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::{Cursor, Write};

    /// A file whose reader counts the bytes that are read.
    struct Counted<'a>(Cursor<&'a [u8]>, &'a mut usize);

    impl Read for Counted<'_> {
        fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
            let read = self.0.read(bytes)?;
            *self.1 += read;
            Ok(read)
        }
    }

    impl Seek for Counted<'_> {
        fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
            self.0.seek(to)
        }
    }

    /// A triangle at this height in version 4.
    fn triangle(height: f32) -> Vec<u8> {
        let mut content = [0_u8; 5].to_vec();
        for count in [3_u64, 1] {
            content.extend(count.to_le_bytes());
        }
        for number in [0.0, 0.0, height, 1.0, 0.0, height, 0.0, 1.0, height] {
            content.extend(number.to_le_bytes());
        }
        for index in [0_u32, 1, 2] {
            content.extend(index.to_le_bytes());
        }
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&content).expect("a vector grows");
        let packed = packed.finish().expect("a vector grows");
        [&[0x1c, 0x04, 4, 0][..], &packed].concat()
    }

    #[test]
    fn one_of_many_serialized_meshes_is_read_without_the_others() {
        let count = 4000_u32;
        let (mut file, mut starts) = (vec![], vec![]);
        for mesh in 0..count {
            starts.extend((file.len() as u64).to_le_bytes());
            file.extend(triangle(mesh as f32));
        }
        file.extend(starts);
        file.extend(count.to_le_bytes());
        let length = file.len() as u64;
        for index in [0, 1234, count - 1] {
            let mut read = 0;
            let counted = Counted(Cursor::new(&file), &mut read);
            let (mesh, is_faceted) =
                read_from(counted, length, index as usize).expect("a whole file");
            assert_eq!(mesh.positions[2], DVec3::new(0.0, 1.0, f64::from(index)));
            assert!(!is_faceted);
            assert!(read < file.len() / 4, "{read} of {}", file.len());
        }
        let cut = Cursor::new(&file);
        assert!(read_from(cut, length, count as usize).is_err());
    }
}
