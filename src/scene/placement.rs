//! Where every shape stands: in the world itself, or in groups that are placed there, still or moving.
//!
//! Instances within groups are multiplied out, and a shape that moves becomes a group of its own, as does a sphere or disk
//! that its keys leave stretched unevenly, so that what is left is one level: groups of shapes that stand still, and their placements in the world.
//!
//! Measure: world units; times of the shutter.
//! Range: groups without a circle, which `load` makes sure of, nested at most 64 deep; at most 2^22 placements. Groups that
//! nothing places are left out.
//! Source: none needed. Tested below and in `tests/rendering/motion.rs`.

use super::description::{GeometryDescription, Key, Place, SceneDescription, ShapeDescription};
use super::keyframes;
use super::placed::{EVEN, even_scale};
use crate::error::Result;
use crate::math::vec::DAffine3;
use std::collections::{BTreeSet, HashMap};

/// All shapes of a scene by where they stand; shapes are indices into the description.
#[derive(Debug, Default)]
pub struct Layout {
    /// Shapes that stand in the world themselves.
    pub shapes: Vec<usize>,
    /// The shapes of each group that is placed.
    pub groups: Vec<Vec<usize>>,
    /// All placements of groups.
    pub placements: Vec<Placement>,
    /// The instances that place something to be seen, in order.
    pub instances: BTreeSet<usize>,
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
    /// A shape that stands alone.
    Shape(usize),
}

/// Groups within groups within groups, at most.
const DEEPEST: usize = 64;

/// Placements of groups in the world, at most: groups that hold others twice grow fast.
const MOST_PLACEMENTS: u64 = 1 << 22;

/// What a group, or the world itself, holds; indices into the description.
#[derive(Debug, Clone, Default)]
struct Contents {
    still: Vec<usize>,
    alone: Vec<usize>,
    instances: Vec<usize>,
}

/// What a group, or the world itself, leads to.
#[derive(Debug, Clone, Copy)]
struct Count {
    placements: u64,
    /// How deep groups are nested in it.
    levels: usize,
}

struct Walk<'a> {
    description: &'a SceneDescription,
    world: Contents,
    groups: Vec<Contents>,
    layout: Layout,
    /// The index in the layout of what is placed already.
    known: HashMap<Member, usize>,
}

/// Finds out where everything stands.
///
/// # Errors
/// Groups that are nested deeper than 64 times, or more than 2^22 placements.
pub fn layout(description: &SceneDescription) -> Result<Layout> {
    let mut walk = Walk::new(description);
    walk.count(None, 0, &mut vec![None; walk.groups.len()])?;
    walk.layout.shapes.clone_from(&walk.world.still);
    walk.place_contents(None, &mut Vec::new());
    Ok(walk.layout)
}

/// Whether a shape is a group of its own: if it moves, or if it is a sphere or disk that its keys stretch unevenly, even
/// where it stands still. It is round in its own frame then, as it is while it moves.
pub fn stands_alone(shape: &ShapeDescription, shutter: [f64; 2]) -> bool {
    let is_round = matches!(
        shape.geometry,
        GeometryDescription::Sphere { .. } | GeometryDescription::Disk { .. }
    );
    match keyframes::steps(&shape.motion, shutter).as_slice() {
        [still] => is_round && even_scale(still, EVEN).is_none(),
        _ => true,
    }
}

impl<'a> Walk<'a> {
    fn new(description: &'a SceneDescription) -> Self {
        let mut walk = Self {
            description,
            world: Contents::default(),
            groups: vec![Contents::default(); description.groups.len()],
            layout: Layout::default(),
            known: HashMap::new(),
        };
        let shutter = description.camera.shutter;
        for (index, shape) in description.shapes.iter().enumerate() {
            let contents = walk.contents_mut(shape.group);
            if stands_alone(shape, shutter) {
                contents.alone.push(index);
            } else {
                contents.still.push(index);
            }
        }
        for (index, instance) in description.instances.iter().enumerate() {
            walk.contents_mut(instance.group).instances.push(index);
        }
        walk
    }

    fn contents(&self, group: Option<usize>) -> &Contents {
        group.map_or(&self.world, |group| &self.groups[group])
    }

    fn contents_mut(&mut self, group: Option<usize>) -> &mut Contents {
        match group {
            Some(group) => &mut self.groups[group],
            None => &mut self.world,
        }
    }

    /// What a group, or the world itself, leads to. `counts` holds what is known.
    fn count(
        &self,
        parent: Option<usize>,
        depth: usize,
        counts: &mut [Option<Count>],
    ) -> Result<Count> {
        if let Some(count) = parent.and_then(|group| counts[group]) {
            return Ok(count);
        }
        let contents = self.contents(parent);
        let mut count = Count {
            placements: contents.alone.len() as u64,
            levels: 0,
        };
        for &index in &contents.instances {
            let instance = &self.description.instances[index];
            let refuse =
                |why: String| Err(instance.place.error(format!("{}: {why}", instance.name)));
            let too_deep = || refuse(format!("groups are nested deeper than {DEEPEST} times"));
            // Asked before going down, for the sake of the stack, and after: a group may be known from higher up.
            if depth >= DEEPEST {
                return too_deep();
            }
            let below = self.count(Some(instance.of), depth + 1, counts)?;
            if depth + 1 + below.levels > DEEPEST {
                return too_deep();
            }
            count.levels = count.levels.max(1 + below.levels);
            count.placements += 1 + below.placements;
            if count.placements > MOST_PLACEMENTS {
                return refuse(format!(
                    "groups are placed more than {MOST_PLACEMENTS} times in all"
                ));
            }
        }
        if let Some(group) = parent {
            counts[group] = Some(count);
        }
        Ok(count)
    }

    /// Places what a group, or the world itself, holds beyond its still shapes.
    fn place_contents(&mut self, parent: Option<usize>, chain: &mut Chain<'a>) {
        let description = self.description;
        let contents = self.contents(parent).clone();
        for index in contents.alone {
            let shape = &description.shapes[index];
            chain.push((DAffine3::IDENTITY, &shape.motion));
            self.place(Member::Shape(index), chain, &shape.name, &shape.place);
            chain.pop();
        }
        for index in contents.instances {
            let instance = &description.instances[index];
            let before = self.layout.placements.len();
            chain.push((instance.transform, &instance.motion));
            self.place(
                Member::Group(instance.of),
                chain,
                &instance.name,
                &instance.place,
            );
            self.place_contents(Some(instance.of), chain);
            chain.pop();
            if self.layout.placements.len() > before {
                self.layout.instances.insert(index);
            }
        }
    }

    fn place(&mut self, member: Member, chain: &Chain<'a>, name: &str, place: &Place) {
        let group = match self.known.get(&member) {
            Some(&group) => group,
            None => {
                let shapes = match member {
                    Member::Group(group) => self.groups[group].still.clone(),
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
            at((1.0 - share) * shutter[0] + share * shutter[1])
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
