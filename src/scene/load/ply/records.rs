//! Reads binary records of the same size on all threads: vertices without lists, and triangles.
//!
//! Measure: as in the file; indices count from 0.
//! Range: any bytes; `None` where they are not as expected. The records are then read in order, which finds the first error.
//! Source: Turk, "The PLY Polygon File Format" (1994). Tested in `tests/loading/ply.rs`.

use super::body::{NumberReader, Records};
use super::header::{Element, Scalar};
use crate::geometry::mesh::MIN_PER_THREAD;
use crate::math::vec::{DVec2, DVec3};
use rayon::prelude::*;

/// A number of each vertex: its offset in the record, and its type.
pub type Field = (usize, Scalar);

/// Returns the field of each property of an element, and the size of a record; `None` if a property is a list.
pub fn fields(element: &Element) -> Option<(Vec<Field>, usize)> {
    let mut size = 0;
    let mut fields = Vec::with_capacity(element.properties.len());
    for property in &element.properties {
        if property.length.is_some() {
            return None;
        }
        fields.push((size, property.scalar));
        size += property.scalar.size();
    }
    Some((fields, size))
}

/// Returns three numbers of each vertex.
pub fn triples(records: &Records, fields: [Field; 3]) -> Option<Vec<DVec3>> {
    let triple = |record| {
        let [x, y, z] = fields.map(|(offset, scalar)| records.number(record, offset, scalar));
        DVec3::new(x, y, z)
    };
    let triples: Vec<DVec3> = each(records).map(triple).collect();
    let values = triples.par_iter().with_min_len(MIN_PER_THREAD);
    let is_finite = values.all(|triple| triple.as_vec3().is_finite());
    is_finite.then_some(triples)
}

/// Returns two numbers of each vertex.
pub fn pairs(records: &Records, fields: [Field; 2]) -> Option<Vec<DVec2>> {
    let pair = |record| {
        let [x, y] = fields.map(|(offset, scalar)| records.number(record, offset, scalar));
        DVec2::new(x, y)
    };
    let pairs: Vec<DVec2> = each(records).map(pair).collect();
    let values = pairs.par_iter().with_min_len(MIN_PER_THREAD);
    let is_finite = values.all(|pair| pair.as_vec2().is_finite());
    is_finite.then_some(pairs)
}

/// Reads the faces, of which property `list` holds the indices of their corners, if all are triangles.
pub fn triangles(
    element: &Element,
    list: usize,
    vertices: usize,
    numbers: &mut impl NumberReader,
) -> Option<Vec<[u32; 3]>> {
    let mut size = 0;
    let mut start = 0;
    for (index, property) in element.properties.iter().enumerate() {
        match property.length {
            Some(length) if index == list => {
                start = size;
                size += length.size() + 3 * property.scalar.size();
            }
            Some(_) => return None,
            None => size += property.scalar.size(),
        }
    }
    let property = &element.properties[list];
    let length = property.length?;
    let records = numbers.records(size, element.count)?;
    // No vertex has this number, since their number has 32 bits.
    const NONE: u32 = u32::MAX;
    let triangle = |record| {
        if records.number(record, start, length) != 3.0 {
            return [NONE; 3];
        }
        std::array::from_fn(|corner| {
            let offset = start + length.size() + corner * property.scalar.size();
            let number = records.number(record, offset, property.scalar);
            let index = number as u32;
            let is_index = f64::from(index) == number && (index as usize) < vertices;
            if is_index { index } else { NONE }
        })
    };
    let triangles: Vec<[u32; 3]> = each(&records).map(triangle).collect();
    let values = triangles.par_iter().with_min_len(MIN_PER_THREAD);
    if values.any(|triangle| triangle.contains(&NONE)) {
        return None;
    }
    numbers.advance(size * element.count);
    Some(triangles)
}

fn each(records: &Records) -> impl IndexedParallelIterator<Item = usize> {
    let each = (0..records.count).into_par_iter();
    each.with_min_len(MIN_PER_THREAD)
}
