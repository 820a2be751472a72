//! Placement of every shape: in the world itself, or in groups that are placed there, static or moving.
//!
//! Nested instances are flattened. A moving shape becomes a group of its own, as does a sphere or disk that its
//! keyframes scale non-uniformly. The result is a single level: groups of static shapes, and their placements in the
//! world.
//!
//! Measure: world units; times of the shutter.
//! Range: groups without cycles, which `load` guarantees, nested at most 64 deep; at most 2^22 placements. Groups that
//! are not placed are left out.
//! Source: none needed. Tested below and in `tests/rendering/motion.rs`.

use super::description::{
    GeometryDescription, Keyframe, Place, SceneDescription, ShapeDescription,
};
use super::keyframes;
use super::placed::{EVEN, even_scale};
use crate::error::Result;
use crate::math::vec::DAffine3;
use std::collections::{BTreeSet, HashMap};

/// All shapes of a scene by placement; shapes are indices into the description.
#[derive(Debug, Default)]
pub struct SceneLayout {
    /// Static shapes of the world itself.
    pub shapes: Vec<usize>,
    /// The shapes of each placed group.
    pub groups: Vec<Vec<usize>>,
    /// All placements of groups.
    pub placements: Vec<Placement>,
    /// The instances that place at least one shape, in order.
    pub instances: BTreeSet<usize>,
}

impl SceneLayout {
    /// Returns the shapes that are placed at least once, in order; `count` is the number of shapes in the description.
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
    /// The group, an index into [`SceneLayout::groups`].
    pub group: usize,
    /// Group to world, at equally spaced times from the opening of the shutter to its closing.
    pub steps: Vec<DAffine3>,
    /// The innermost object that places it, for messages: its name and its place in the file.
    pub object: (String, Place),
}

/// Transforms and keyframes between a group and the world, innermost last.
type TransformChain<'a> = Vec<(DAffine3, &'a [Keyframe])>;

/// The content of a placed group.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Member {
    /// The static shapes of a named group.
    Group(usize),
    /// A shape that forms its own group.
    Shape(usize),
}

/// Maximum nesting depth of groups.
const MAX_DEPTH: usize = 64;

/// Maximum number of placements in the world: it grows exponentially if groups contain others twice.
const MAX_PLACEMENTS: u64 = 1 << 22;

/// Members of a group, or of the world itself; indices into the description.
#[derive(Debug, Clone, Default)]
struct GroupMembers {
    still: Vec<usize>,
    alone: Vec<usize>,
    instances: Vec<usize>,
}

/// Totals over the members of a group, or of the world itself, and everything nested in it.
#[derive(Debug, Clone, Copy)]
struct Count {
    placements: u64,
    /// Depth of the groups nested in it.
    levels: usize,
}

struct Flattening<'a> {
    description: &'a SceneDescription,
    world: GroupMembers,
    groups: Vec<GroupMembers>,
    layout: SceneLayout,
    /// Index in the layout of each member that is placed already.
    known: HashMap<Member, usize>,
}

/// Computes the layout of a scene.
///
/// # Errors
/// If groups are nested deeper than 64 levels, or there are more than 2^22 placements.
pub fn layout(description: &SceneDescription) -> Result<SceneLayout> {
    let mut flattening = Flattening::new(description);
    flattening.count(None, 0, &mut vec![None; flattening.groups.len()])?;
    flattening.layout.shapes.clone_from(&flattening.world.still);
    flattening.place_contents(None, &mut Vec::new());
    Ok(flattening.layout)
}

/// Whether a shape forms its own group: if it moves, or if it is a sphere or disk that its keyframes scale
/// non-uniformly, even if it is static. It is then round in its own frame.
pub fn forms_own_group(shape: &ShapeDescription, shutter: [f64; 2]) -> bool {
    let is_round = matches!(
        shape.geometry,
        GeometryDescription::Sphere { .. } | GeometryDescription::Disk { .. }
    );
    let is_uneven = || even_scale(&keyframes::at(&shape.motion, shutter[0]), EVEN).is_none();
    keyframes::moves(&shape.motion, shutter) || (is_round && is_uneven())
}

impl<'a> Flattening<'a> {
    fn new(description: &'a SceneDescription) -> Self {
        let mut flattening = Self {
            description,
            world: GroupMembers::default(),
            groups: vec![GroupMembers::default(); description.groups.len()],
            layout: SceneLayout::default(),
            known: HashMap::new(),
        };
        let shutter = description.camera.shutter;
        for (index, shape) in description.shapes.iter().enumerate() {
            let contents = flattening.contents_mut(shape.group);
            if forms_own_group(shape, shutter) {
                contents.alone.push(index);
            } else {
                contents.still.push(index);
            }
        }
        for (index, instance) in description.instances.iter().enumerate() {
            flattening
                .contents_mut(instance.group)
                .instances
                .push(index);
        }
        flattening
    }

    fn contents(&self, group: Option<usize>) -> &GroupMembers {
        group.map_or(&self.world, |group| &self.groups[group])
    }

    fn contents_mut(&mut self, group: Option<usize>) -> &mut GroupMembers {
        match group {
            Some(group) => &mut self.groups[group],
            None => &mut self.world,
        }
    }

    /// Counts the placements and levels below a group, or below the world itself. `counts` caches the results.
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
            let too_deep = || refuse(format!("groups are nested deeper than {MAX_DEPTH} times"));
            // Checked before the recursion, to limit the stack, and after it: the count of a group may come from the
            // cache.
            if depth >= MAX_DEPTH {
                return too_deep();
            }
            let below = self.count(Some(instance.of), depth + 1, counts)?;
            if depth + 1 + below.levels > MAX_DEPTH {
                return too_deep();
            }
            count.levels = count.levels.max(1 + below.levels);
            count.placements += 1 + below.placements;
            if count.placements > MAX_PLACEMENTS {
                return refuse(format!(
                    "groups are placed more than {MAX_PLACEMENTS} times in all"
                ));
            }
        }
        if let Some(group) = parent {
            counts[group] = Some(count);
        }
        Ok(count)
    }

    /// Adds the placements of a group's members, or of the world's, except the static shapes.
    fn place_contents(&mut self, parent: Option<usize>, chain: &mut TransformChain<'a>) {
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

    fn place(&mut self, member: Member, chain: &TransformChain<'a>, name: &str, place: &Place) {
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

/// Multiplies a chain, at as many times as its finest motion and the product of all need.
fn compose(chain: &TransformChain<'_>, shutter: [f64; 2]) -> Vec<DAffine3> {
    let intervals = chain
        .iter()
        .map(|(_, keys)| keyframes::steps(keys, shutter).len() - 1)
        .fold(0, common_multiple);
    let at = |share: f64| {
        let time = keyframes::mix(shutter[0], shutter[1], share);
        let links = chain.iter();
        links.fold(DAffine3::IDENTITY, |outer, (transform, keys)| {
            outer * keyframes::at(keys, time) * *transform
        })
    };
    match intervals {
        0 => vec![at(0.0)],
        _ => keyframes::refined(intervals as u32, MAX_INTERVALS, at),
    }
}

/// The largest number of intervals of a product of motions.
const MAX_INTERVALS: u32 = 128;

/// Returns the smallest common multiple of two numbers of intervals if it is small enough; otherwise the larger number.
fn common_multiple(a: usize, b: usize) -> usize {
    let larger = a.max(b);
    if a == 0 || b == 0 {
        return larger;
    }
    let multiples = (1..)
        .map(|k| k * larger)
        .take_while(|m| *m <= MAX_INTERVALS as usize);
    multiples
        .into_iter()
        .find(|m| m % a.min(b) == 0)
        .unwrap_or(larger)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::DVec3;

    fn keys(transforms: [DAffine3; 2]) -> Vec<Keyframe> {
        let key = |(time, transform)| Keyframe { time, transform };
        [0.0, 1.0].into_iter().zip(transforms).map(key).collect()
    }

    #[test]
    fn product_of_linear_motions_is_sampled_finely() {
        let grows = keys([1.0, 3.0].map(|x| DAffine3::from_scale(DVec3::splat(x))));
        let slides = keys([0.0, 10.0].map(|x| DAffine3::from_translation(x * DVec3::X)));
        let chain = vec![
            (DAffine3::IDENTITY, &*grows),
            (DAffine3::IDENTITY, &*slides),
        ];
        let steps = compose(&chain, [0.0, 1.0]);
        // At time t the origin is at 10 t (1 + 2 t): 10 in the middle, where the mean of the ends is 15.
        assert_eq!(steps.len() % 2, 1);
        assert_eq!(steps[steps.len() / 2].translation, 10.0 * DVec3::X);
        for (i, pair) in steps.windows(2).enumerate() {
            let t = (i as f64 + 0.5) / (steps.len() - 1) as f64;
            let middle = 0.5 * (pair[0].translation + pair[1].translation);
            let off = middle.x - 10.0 * t * (1.0 + 2.0 * t);
            assert!(off.abs() < 0.02, "{off} at {t}, of {} steps", steps.len());
        }
    }

    #[test]
    fn single_linear_motion_takes_one_interval() {
        let slides = keys([0.0, 10.0].map(|x| DAffine3::from_translation(x * DVec3::X)));
        let still = DAffine3::from_scale(DVec3::splat(2.0));
        let chain = vec![(still, &[][..]), (still, &*slides)];
        assert_eq!(compose(&chain, [0.0, 1.0]).len(), 2);
    }
}
