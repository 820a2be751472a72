//! Where every shape stands: in the world itself, or in groups that are placed there, still or moving.
//!
//! Instances within groups are multiplied out, and a shape that moves becomes a group of its own, so that what is left is
//! one level: groups of shapes that stand still, and their placements in the world.
//!
//! Measure: world units; times of the shutter.
//! Range: groups without a circle, which `load` makes sure of; groups that nothing places are left out.
//! Source: none needed. Tested below and in `tests/motion.rs`.

use super::description::{Key, Place, SceneDescription};
use super::keyframes;
use crate::math::vec::DAffine3;
use std::collections::HashMap;

/// All shapes of a scene by where they stand; shapes are indices into the description.
#[derive(Debug, Default)]
pub struct Layout {
    /// Shapes that stand in the world themselves.
    pub shapes: Vec<usize>,
    /// The shapes of each group that is placed.
    pub groups: Vec<Vec<usize>>,
    /// All placements of groups.
    pub placements: Vec<Placement>,
}

impl Layout {
    /// The shapes that are to be seen somewhere, in order, of `count` in the description.
    pub fn placed_shapes(&self, count: usize) -> impl Iterator<Item = usize> {
        let mut placed = vec![false; count];
        for &shape in self.shapes.iter().chain(self.groups.iter().flatten()) {
            placed[shape] = true;
        }
        (0..count).filter(move |&shape| placed[shape])
    }
}

/// One placement of a group.
#[derive(Debug)]
pub struct Placement {
    /// The group, an index into [`Layout::groups`].
    pub group: usize,
    /// Group to world, at equally spaced times from the opening of the shutter to its closing.
    pub steps: Vec<DAffine3>,
    /// The innermost object that places it, for messages: its name and where it was written.
    pub object: (String, Place),
}

/// What is applied on the way from a group to the world, innermost last.
type Chain<'a> = Vec<(DAffine3, &'a [Key])>;

/// What a placed group is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Member {
    /// The shapes of a named group that stand still in it.
    Group(usize),
    /// A shape that moves.
    Shape(usize),
}

struct Walk<'a> {
    description: &'a SceneDescription,
    layout: Layout,
    /// The index in the layout of what is placed already.
    known: HashMap<Member, usize>,
}

/// Finds out where everything stands.
pub fn layout(description: &SceneDescription) -> Layout {
    let mut walk = Walk {
        description,
        layout: Layout::default(),
        known: HashMap::new(),
    };
    walk.layout.shapes = walk.still_shapes(None);
    walk.place_contents(None, &mut Vec::new());
    walk.layout
}

impl<'a> Walk<'a> {
    /// Whether keys move anything while the shutter is open.
    fn moves(&self, keys: &[Key]) -> bool {
        keyframes::steps(keys, self.description.camera.shutter).len() > 1
    }

    /// Shapes of a group, or of the world itself, that stand still there.
    fn still_shapes(&self, group: Option<usize>) -> Vec<usize> {
        let shapes = self.description.shapes.iter().enumerate();
        let still = shapes.filter(|(_, s)| s.group == group && !self.moves(&s.motion));
        still.map(|(index, _)| index).collect()
    }

    /// Places what a group, or the world itself, holds beyond its still shapes.
    fn place_contents(&mut self, parent: Option<usize>, chain: &mut Chain<'a>) {
        let description = self.description;
        for (index, shape) in description.shapes.iter().enumerate() {
            if shape.group == parent && self.moves(&shape.motion) {
                chain.push((DAffine3::IDENTITY, &shape.motion));
                self.place(Member::Shape(index), chain, &shape.name, &shape.place);
                chain.pop();
            }
        }
        for instance in &description.instances {
            if instance.group == parent {
                chain.push((instance.transform, &instance.motion));
                self.place(
                    Member::Group(instance.of),
                    chain,
                    &instance.name,
                    &instance.place,
                );
                self.place_contents(Some(instance.of), chain);
                chain.pop();
            }
        }
    }

    fn place(&mut self, member: Member, chain: &Chain<'a>, name: &str, place: &Place) {
        let group = match self.known.get(&member) {
            Some(&group) => group,
            None => {
                let shapes = match member {
                    Member::Group(group) => self.still_shapes(Some(group)),
                    Member::Shape(shape) => vec![shape],
                };
                self.layout.groups.push(shapes);
                self.known.insert(member, self.layout.groups.len() - 1);
                self.layout.groups.len() - 1
            }
        };
        if !self.layout.groups[group].is_empty() {
            let steps = compose(chain, self.description.camera.shutter);
            let object = (name.to_owned(), place.clone());
            self.layout.placements.push(Placement {
                group,
                steps,
                object,
            });
        }
    }
}

/// The product of a chain, at as many times as the finest of its motions needs.
fn compose(chain: &Chain<'_>, shutter: [f64; 2]) -> Vec<DAffine3> {
    let intervals = chain
        .iter()
        .map(|(_, keys)| keyframes::steps(keys, shutter).len() - 1)
        .fold(0, common_multiple);
    let at = |time: f64| {
        let links = chain.iter();
        links.fold(DAffine3::IDENTITY, |outer, (transform, keys)| {
            outer * keyframes::at(keys, time) * *transform
        })
    };
    (0..=intervals)
        .map(|i| {
            let share = i as f64 / intervals.max(1) as f64;
            at(shutter[0] + share * (shutter[1] - shutter[0]))
        })
        .collect()
}

/// Intervals that both numbers of intervals divide, if they are few enough; else the larger.
fn common_multiple(a: usize, b: usize) -> usize {
    const MOST: usize = 128;
    let larger = a.max(b);
    if a == 0 || b == 0 {
        return larger;
    }
    let multiples = (1..).map(|k| k * larger).take_while(|m| *m <= MOST);
    multiples
        .into_iter()
        .find(|m| m % a.min(b) == 0)
        .unwrap_or(larger)
}
