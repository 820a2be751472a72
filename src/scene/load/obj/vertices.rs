//! Numbers the different corners of a mesh in the order of their first use.
//!
//! Measure: vertices count from 0.
//! Range: any corners; the time is linear in their number, whatever they are.
//! Source: a table of lists by position, since corners that name the same position mostly name the same vertex; corners beyond
//! the first few of a list are in a hash map. Tested below.

use std::collections::HashMap;

/// Indices of a position, texture coordinate and normal, counted from 1; 0 is none.
pub type Corner = [u32; 3];

/// Ends a list.
const NONE: u32 = u32::MAX;

/// The largest length of a list.
const MAX_LENGTH: usize = 8;

/// The vertices found so far.
#[derive(Debug)]
pub struct Vertices {
    /// The corner of each vertex.
    corners: Vec<Corner>,
    /// For each vertex, the one before it in its list, or [`NONE`].
    previous: Vec<u32>,
    /// The last vertex of each list, or [`NONE`]. A position belongs to the list of its lowest bits.
    last: Vec<u32>,
    /// The vertices that are in no list.
    others: HashMap<Corner, u32>,
}

impl Vertices {
    /// Expects corners of about as many positions.
    pub fn of_corners(positions: usize) -> Self {
        Self {
            corners: Vec::with_capacity(positions),
            previous: Vec::with_capacity(positions),
            last: vec![NONE; positions.next_power_of_two()],
            others: HashMap::new(),
        }
    }

    /// Returns the vertex of a corner, a new one for a new corner. There are fewer than 2³² corners.
    pub fn number(&mut self, corner: Corner) -> u32 {
        let next = self.corners.len() as u32;
        let list = corner[0] as usize & (self.last.len() - 1);
        let last = self.last[list];
        let (mut vertex, mut length) = (last, 0);
        while vertex != NONE {
            if self.corners[vertex as usize] == corner {
                return vertex;
            }
            vertex = self.previous[vertex as usize];
            length += 1;
        }
        if length < MAX_LENGTH {
            self.last[list] = next;
            self.previous.push(last);
        } else {
            let found = *self.others.entry(corner).or_insert(next);
            if found != next {
                return found;
            }
            self.previous.push(NONE);
        }
        self.corners.push(corner);
        next
    }

    /// Returns the corner of each vertex.
    pub fn into_corners(self) -> Vec<Corner> {
        self.corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    #[test]
    fn vertices_are_those_of_a_map_in_the_order_of_first_use() {
        let mut random = Pcg32::new(7, 1);
        // Few positions with many normals, and many positions in few lists.
        for (positions, normals, lists) in [(3, 200, 3), (500, 2, 1), (500, 2, 500), (1, 1, 0)] {
            let mut vertices = Vertices::of_corners(lists);
            let mut expected: Vec<Corner> = Vec::new();
            for _ in 0..3000 {
                let mut below = |end: u32| 1 + random.next_u32() % end;
                let corner = [below(positions), 0, below(normals)];
                let known = expected.iter().position(|other| *other == corner);
                let index = known.unwrap_or(expected.len());
                if known.is_none() {
                    expected.push(corner);
                }
                assert_eq!(vertices.number(corner) as usize, index);
            }
            assert_eq!(vertices.into_corners(), expected);
        }
    }
}
