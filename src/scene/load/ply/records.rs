//! Reads binary records of the same size on all threads: vertices without lists, and triangles.
//!
//! Measure: as in the file; indices count from 0.
//! Range: any bytes; `None` where they are not as expected. The records are then read in order, which finds the first error.
//! Source: Turk, "The PLY Polygon File Format" (1994). Tested in `tests/loading/ply_records.rs`.

use super::body::{NumberReader, Records};
use super::header::{Element, Scalar};
use crate::geometry::mesh::MIN_PER_THREAD;
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

/// Returns some numbers of each vertex; `None` if one is not finite in single precision.
pub fn numbers<const N: usize>(records: &Records, fields: [Field; N]) -> Option<Vec<[f64; N]>> {
    let of_vertex = |record| fields.map(|(offset, scalar)| records.number(record, offset, scalar));
    let all: Vec<[f64; N]> = each(records).map(of_vertex).collect();
    let values = all.par_iter().with_min_len(MIN_PER_THREAD);
    let is_finite = values.all(|numbers| numbers.iter().all(|x| (*x as f32).is_finite()));
    is_finite.then_some(all)
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
