//! A tree of lights, by which one is selected in proportion to estimates of what each would contribute at a receiver.
//!
//! A node has up to sixteen children, each a light or another node, with bounds of all lights below. From the root on, a
//! child is selected in proportion to its estimate, with one random number for all levels from the root to the light. Up to
//! sixteen lights are the children of the root, so that each is selected in proportion to its own estimate.
//!
//! Where all children of a node have the estimate zero, although the bounds of the node had not, no light is selected, as
//! none can light the receiver.
//!
//! Measure: probabilities. A light takes some 70 bytes, and a selection or its probability the estimates of a node's
//! children for each level.
//! Range: any number of lights; those of intensity zero are never selected.
//! Source: Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"; Pharr, Jakob,
//! Humphreys, "Light Sampling". Tested in `tests/lights/choice.rs`.

mod build;

use super::bounds::LightBounds;
use super::types::Receiver;
use crate::math::lanes::{LANES, Lanes, Lanes3, load, vectorised};
use crate::math::measure::Pmf;
use crate::math::vec::LaneVec3;
use crate::sampling::distribution::joined;

/// The largest number of children.
pub const WIDTH: usize = LANES;

/// The slot of the root and of lights that are not in the tree, which are nobody's children.
const NONE: u32 = u32::MAX;

/// The bit that marks a child as a node.
const IS_NODE: u32 = 1 << 31;

/// A tree of lights.
#[derive(Debug, Clone)]
pub struct LightTree {
    nodes: Vec<Node>,
    slots: Slots,
    /// The slot and the node of each light.
    places: Vec<TreePlace>,
}

/// A node: consecutive slots.
#[derive(Debug, Clone, Copy)]
struct Node {
    first: u32,
    count: u32,
    /// The node as a child; [`NONE`] of the root.
    place: TreePlace,
}

/// The place of a child.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct TreePlace {
    slot: u32,
    node: u32,
}

/// The children of all nodes, padded for reads of sixteen.
#[derive(Debug, Clone, Default)]
struct Slots {
    /// The numbers of the bounds.
    numbers: [Vec<f32>; 11],
    /// The lights, or nodes if [`IS_NODE`] is set.
    child: Vec<u32>,
}

/// A selected child.
struct Selected {
    index: usize,
    probability: f64,
    /// The random number, rescaled to [0, 1).
    rescaled_u: f64,
}

impl LightTree {
    /// Selects a light for a receiver; returns it with the probability of selecting it.
    #[inline]
    pub fn choose(&self, receiver: &Receiver, u: [f32; 2]) -> Option<(u32, Pmf)> {
        let mut x = joined(u);
        let mut pmf = 1.0;
        let mut node = self.nodes.first()?;
        loop {
            let estimates = self.estimates(node, receiver);
            let selected = select(&estimates, x)?;
            (x, pmf) = (selected.rescaled_u, pmf * selected.probability);
            let child = self.slots.child[node.first as usize + selected.index];
            if child & IS_NODE == 0 {
                return Some((child, Pmf(pmf as f32))).filter(|(_, pmf)| is_normal(*pmf));
            }
            node = &self.nodes[(child & !IS_NODE) as usize];
        }
    }

    /// The probability of selecting a light for a receiver.
    #[inline]
    pub fn pmf(&self, light: u32, receiver: &Receiver) -> Pmf {
        let mut place = self.places[light as usize];
        let mut pmf = 1.0;
        while place.slot != NONE {
            let node = &self.nodes[place.node as usize];
            let estimates = self.estimates(node, receiver);
            pmf *= probability(&estimates, (place.slot - node.first) as usize);
            place = node.place;
        }
        let pmf = Pmf(pmf as f32);
        let is_in_tree = self.places[light as usize].slot != NONE;
        if is_in_tree && is_normal(pmf) {
            pmf
        } else {
            Pmf(0.0)
        }
    }

    /// Selects a light for each of the receivers of `active` lanes, by the third and the fourth of their random numbers.
    /// The probability is zero where none is selected.
    #[inline]
    pub fn choose_lanes(
        &self,
        active: impl Iterator<Item = usize>,
        receivers: &Receiver<Lanes3>,
        u: &[Lanes<f32>; 2],
        light: &mut Lanes<u32>,
        pmf: &mut Lanes<f32>,
    ) {
        if let [root] = self.nodes.as_slice() {
            return choose_among(&self.slots, root.count as usize, receivers, u, light, pmf);
        }
        for lane in active {
            let receiver = Receiver {
                p: load(&receivers.p, lane),
                normal: load(&receivers.normal, lane),
            };
            let selected = self.choose(&receiver, [u[0][lane], u[1][lane]]);
            let (chosen, probability) = selected.unwrap_or((0, Pmf(0.0)));
            (light[lane], pmf[lane]) = (chosen, probability.0);
        }
    }

    /// The number of lights in the tree, of its nodes, and its memory in bytes.
    pub fn size(&self) -> [usize; 3] {
        let lights = self.slots.child.len() - (WIDTH - 1) - (self.nodes.len() - 1);
        let numbers = self.slots.numbers.len() * size_of::<f32>();
        let bytes = self.slots.child.capacity() * (numbers + size_of::<u32>())
            + self.nodes.capacity() * size_of::<Node>()
            + self.places.capacity() * size_of::<TreePlace>();
        [lights, self.nodes.len(), bytes]
    }

    /// The estimates of a node's children.
    #[inline]
    fn estimates(&self, node: &Node, receiver: &Receiver) -> Lanes<f32> {
        let receiver = Receiver {
            p: receiver.p.into(),
            normal: receiver.normal.into(),
        };
        estimates(
            &self.slots,
            node.first as usize,
            node.count as usize,
            &receiver,
        )
    }
}

/// Whether one over a probability is finite.
#[inline(always)]
fn is_normal(pmf: Pmf) -> bool {
    pmf.0 >= f32::MIN_POSITIVE
}

/// Selects in proportion to estimates, by a number in [0, 1).
#[inline(always)]
fn select(estimates: &Lanes<f32>, x: f64) -> Option<Selected> {
    let mut before = [0.0; WIDTH];
    let mut sum = 0.0;
    for (before, &estimate) in before.iter_mut().zip(estimates) {
        *before = sum;
        sum += f64::from(estimate);
    }
    let target = x * sum;
    let is_chosen = |&index: &usize| estimates[index] > 0.0 && before[index] <= target;
    let index = (0..WIDTH).rev().find(is_chosen)?;
    let estimate = f64::from(estimates[index]);
    let rescaled_u = (target - before[index]) / estimate;
    Some(Selected {
        index,
        probability: estimate / sum,
        rescaled_u: rescaled_u.clamp(0.0, 1.0_f64.next_down()),
    })
}

/// The probability of an index.
#[inline(always)]
fn probability(estimates: &Lanes<f32>, index: usize) -> f64 {
    let estimate = f64::from(estimates[index]);
    if estimate > 0.0 {
        estimate / sum(estimates)
    } else {
        0.0
    }
}

#[inline(always)]
fn sum(estimates: &Lanes<f32>) -> f64 {
    estimates
        .iter()
        .fold(0.0, |sum, &estimate| sum + f64::from(estimate))
}

impl Slots {
    /// Adds a child.
    fn push(&mut self, bounds: &LightBounds, child: u32) {
        let LightBounds { center, axis, .. } = bounds;
        let numbers = [
            center.x,
            center.y,
            center.z,
            bounds.nearness,
            bounds.radius,
            axis.x,
            axis.y,
            axis.z,
            bounds.cos_normals,
            bounds.cos_emission,
            bounds.intensity,
        ];
        for (to, number) in self.numbers.iter_mut().zip(numbers) {
            to.push(number);
        }
        self.child.push(child);
    }

    /// The bounds of sixteen children.
    #[inline(always)]
    fn child_bounds(&self, first: usize) -> ChildBounds<'_> {
        let [
            x,
            y,
            z,
            nearness,
            radius,
            a,
            b,
            c,
            normals,
            emission,
            intensity,
        ] = &self.numbers;
        ChildBounds {
            center: [chunk(x, first), chunk(y, first), chunk(z, first)],
            nearness: chunk(nearness, first),
            radius: chunk(radius, first),
            axis: [chunk(a, first), chunk(b, first), chunk(c, first)],
            cos_normals: chunk(normals, first),
            cos_emission: chunk(emission, first),
            intensity: chunk(intensity, first),
        }
    }
}

/// Sixteen numbers from one on.
#[inline(always)]
fn chunk(numbers: &[f32], first: usize) -> &Lanes<f32> {
    let chunk = numbers[first..].first_chunk();
    chunk.expect("sixteen follow each first child")
}

/// The bounds of sixteen children.
#[derive(Clone, Copy)]
struct ChildBounds<'a> {
    center: [&'a Lanes<f32>; 3],
    nearness: &'a Lanes<f32>,
    radius: &'a Lanes<f32>,
    axis: [&'a Lanes<f32>; 3],
    cos_normals: &'a Lanes<f32>,
    cos_emission: &'a Lanes<f32>,
    intensity: &'a Lanes<f32>,
}

impl ChildBounds<'_> {
    /// The bounds in one lane.
    #[inline(always)]
    fn get(&self, lane: usize) -> LightBounds<LaneVec3> {
        let ([x, y, z], [a, b, c]) = (self.center, self.axis);
        LightBounds {
            center: LaneVec3::new(x[lane], y[lane], z[lane]),
            nearness: self.nearness[lane],
            radius: self.radius[lane],
            axis: LaneVec3::new(a[lane], b[lane], c[lane]),
            cos_normals: self.cos_normals[lane],
            cos_emission: self.cos_emission[lane],
            intensity: self.intensity[lane],
        }
    }
}

vectorised! {
    /// The estimates of `count` children from `first` on.
    fn estimates(
        slots: &Slots,
        first: usize,
        count: usize,
        receiver: &Receiver<LaneVec3>,
    ) -> Lanes<f32> {
        let children = slots.child_bounds(first);
        let mut estimates = [0.0; LANES];
        for (lane, to) in estimates.iter_mut().enumerate() {
            let estimate = children.get(lane).estimate(receiver);
            *to = if lane < count { estimate } else { 0.0 };
        }
        estimates
    }
}

vectorised! {
    /// Selects one of the first `count` children for each receiver, as [`select`] does.
    fn choose_among(
        slots: &Slots,
        count: usize,
        receivers: &Receiver<Lanes3>,
        u: &[Lanes<f32>; 2],
        light: &mut Lanes<u32>,
        pmf: &mut Lanes<f32>,
    ) {
        let children = slots.child_bounds(0);
        let mut estimates = [[0.0; LANES]; WIDTH];
        let mut sums = [0.0_f64; LANES];
        for child in 0..count {
            let estimates = &mut estimates[child];
            let bounds = children.get(child);
            for lane in 0..LANES {
                let receiver = Receiver {
                    p: load(&receivers.p, lane),
                    normal: load(&receivers.normal, lane),
                };
                estimates[lane] = bounds.estimate(&receiver);
                sums[lane] += f64::from(estimates[lane]);
            }
        }
        let (mut before, mut selected) = ([0.0_f64; LANES], [0.0_f64; LANES]);
        *light = [0; LANES];
        for child in 0..count {
            let estimates = &estimates[child];
            let index = slots.child[child];
            for lane in 0..LANES {
                let estimate = f64::from(estimates[lane]);
                let target = joined([u[0][lane], u[1][lane]]) * sums[lane];
                let is_chosen = (estimate > 0.0) & (before[lane] <= target);
                light[lane] = if is_chosen { index } else { light[lane] };
                selected[lane] = if is_chosen { estimate } else { selected[lane] };
                before[lane] += estimate;
            }
        }
        for lane in 0..LANES {
            let probability = (selected[lane] / before[lane]) as f32;
            pmf[lane] = if is_normal(Pmf(probability)) { probability } else { 0.0 };
        }
    }
}
