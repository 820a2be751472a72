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
use std::io::Read;
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
    let bytes = super::super::read_bytes(path)?;
    let mesh = find(&bytes, index).and_then(|(stream, version)| inflate(stream, version));
    mesh.map_err(|why| Error::scene(format!("mesh {index}: {why}")).in_file(path))
}

/// Returns the compressed stream of a mesh, and the version of the format.
fn find(bytes: &[u8], index: usize) -> std::result::Result<(&[u8], u16), String> {
    let number = |at: usize, size: usize| {
        let bytes = bytes.get(at..at.checked_add(size)?)?;
        Some(
            bytes
                .iter()
                .rev()
                .fold(0_u64, |number, &byte| number << 8 | u64::from(byte)),
        )
    };
    let header = |at: usize| Some((number(at, 2)? as u16, number(at + 2, 2)? as u16));
    match header(0) {
        Some((MAGIC, 3 | 4)) => {}
        Some((MAGIC, version)) => return Err(format!("expected version 3 or 4, found {version}")),
        _ => return Err("expected a file in Mitsuba's format `serialized`".to_owned()),
    }
    let cut = || "the file is cut: expected its index at the end".to_owned();
    let end = bytes.len() - 4;
    let count = number(end, 4).ok_or_else(cut)? as usize;
    if index >= count {
        return Err(format!("there are {count} meshes, counted from 0"));
    }
    let size = if header(0).is_some_and(|(_, version)| version == 4) {
        8
    } else {
        4
    };
    let table = count
        .checked_mul(size)
        .and_then(|table| end.checked_sub(table))
        .ok_or_else(cut)?;
    let start = number(table + index * size, size).ok_or_else(cut)?;
    let start = usize::try_from(start)
        .ok()
        .filter(|&start| start < table)
        .ok_or_else(cut)?;
    match header(start) {
        Some((MAGIC, version @ (3 | 4))) if start + 4 <= table => {
            Ok((&bytes[start + 4..table], version))
        }
        _ => Err(format!("expected a mesh at byte {start}")),
    }
}

fn inflate(stream: &[u8], version: u16) -> std::result::Result<(MeshDescription, bool), String> {
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
struct Inflated<'a>(ZlibDecoder<&'a [u8]>);

impl Inflated<'_> {
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
