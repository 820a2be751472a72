//! Construction of a tree of lights: from the root down, by splits in two.
//!
//! The lights of a node are split until there are sixteen clusters, always the cluster of the highest cost. A split cuts the
//! longest edge of the box of a cluster's centres at one of some planes, such that the sum of the costs of both halves is
//! least: the intensity times the squared diagonal times a measure of how much the normals differ. Lights at infinity are
//! clusters of their own.
//!
//! Measure: as in `light/bounds.rs`.
//! Range: any number of lights below 2^31. From [`BALANCED`] levels on, clusters are halved.
//! Source: Conty Estevez and Kulla 2018, section 4; Wald 2007, "On Fast Construction of SAH-based Bounding Volume
//! Hierarchies", for the planes. Tested in `tests/lights/choice.rs`.

use super::super::Light;
use super::super::bounds::LightBounds;
use super::{IS_NODE, LightTree, NONE, Node, Slots, TreePlace, WIDTH};
use crate::math::vec::Vec3;
use std::ops::Range;

/// The number of planes at which a cluster may be split, plus one.
const BINS: usize = 16;

/// The depth from which on clusters are halved, which bounds the depth of the tree.
const BALANCED: usize = 10;

/// A light to be placed.
#[derive(Debug, Clone, Copy)]
struct Item {
    bounds: LightBounds,
    light: u32,
}

/// Some lights, in the order of the items.
struct Cluster {
    range: Range<usize>,
    cost: f32,
}

/// The quantities that the cost of a cluster depends on.
#[derive(Debug, Clone, Copy)]
struct Extent {
    low: Vec3,
    high: Vec3,
    intensity: f32,
    /// The sum of the axes, times the intensities.
    axis: Vec3,
    count: usize,
}

impl LightTree {
    /// Builds the tree of lights with these powers; those of no power, or of a power that vanishes beside the greatest, are
    /// left out. `None` if all are.
    pub fn new(lights: &[Light], powers: &[f64]) -> Option<Self> {
        let bounds = || {
            lights
                .iter()
                .zip(powers)
                .map(|(light, &power)| light.bounds(power))
        };
        let greatest = bounds().map(|(_, intensity)| intensity).fold(0.0, f64::max);
        let mut items = Vec::with_capacity(lights.len());
        for (light, (bounds, intensity)) in (0..).zip(bounds()) {
            let relative = intensity / greatest;
            if relative >= f64::from(f32::MIN_POSITIVE) {
                let intensity = relative.max(1e-30) as f32;
                let bounds = LightBounds {
                    intensity,
                    ..bounds
                };
                items.push(Item { bounds, light });
            }
        }
        if items.is_empty() || lights.len() >= IS_NODE as usize {
            return None;
        }
        let nowhere = TreePlace {
            slot: NONE,
            node: NONE,
        };
        let mut tree = Self {
            nodes: Vec::with_capacity(items.len() / 4 + 1),
            slots: Slots::with_room(items.len() + items.len() / 4 + WIDTH),
            places: vec![nowhere; lights.len()],
        };
        items.sort_by_key(|item| item.bounds.nearness > 0.0);
        let beyond = items.partition_point(|item| item.bounds.nearness == 0.0);
        let clusters = clusters(&mut items, beyond);
        tree.add_node(&mut items, clusters, nowhere, 1);
        for _ in 1..WIDTH {
            tree.slots.push(&NOTHING, NONE);
        }
        tree.nodes.shrink_to_fit();
        tree.slots.shrink_to_fit();
        Some(tree)
    }

    /// Adds the node of some clusters of items, and the nodes below.
    fn add_node(
        &mut self,
        items: &mut [Item],
        clusters: Vec<Cluster>,
        place: TreePlace,
        depth: usize,
    ) {
        let node = self.nodes.len() as u32;
        let first = self.slots.child.len() as u32;
        self.nodes.push(Node {
            first,
            count: clusters.len() as u32,
            place,
        });
        for (slot, cluster) in (first..).zip(&clusters) {
            match &items[cluster.range.clone()] {
                [Item { bounds, light }] => {
                    self.slots.push(bounds, *light);
                    self.places[*light as usize] = TreePlace { slot, node };
                }
                several => {
                    let bounds = LightBounds::of_all(several.iter().map(|item| &item.bounds));
                    self.slots.push(&bounds, IS_NODE);
                }
            }
        }
        for (slot, cluster) in (first..).zip(clusters) {
            if cluster.range.len() > 1 {
                self.slots.child[slot as usize] = IS_NODE | self.nodes.len() as u32;
                let items = &mut items[cluster.range];
                let is_beyond = items[0].bounds.nearness == 0.0;
                let clusters = if is_beyond || depth >= BALANCED {
                    even_clusters(items.len())
                } else {
                    clusters_of(items, Vec::new(), 0)
                };
                self.add_node(items, clusters, TreePlace { slot, node }, depth + 1);
            }
        }
    }
}

/// Bounds that are read but not used.
const NOTHING: LightBounds = LightBounds {
    center: Vec3::ZERO,
    nearness: 0.0,
    radius: 0.0,
    axis: Vec3::Z,
    cos_normals: 1.0,
    cos_emission: 0.0,
    intensity: 0.0,
};

impl Slots {
    fn with_room(count: usize) -> Self {
        Self {
            numbers: std::array::from_fn(|_| Vec::with_capacity(count)),
            child: Vec::with_capacity(count),
        }
    }

    fn shrink_to_fit(&mut self) {
        self.numbers.iter_mut().for_each(Vec::shrink_to_fit);
        self.child.shrink_to_fit();
    }
}

/// The clusters of the root, whose first items are lights at infinity: each of them, or all together if there are many.
fn clusters(items: &mut [Item], beyond: usize) -> Vec<Cluster> {
    let whole = |range| Cluster { range, cost: 0.0 };
    let first = if beyond < WIDTH / 2 || items.len() <= WIDTH {
        (0..beyond).map(|i| whole(i..i + 1)).collect()
    } else {
        vec![whole(0..beyond)]
    };
    clusters_of(items, first, beyond)
}

/// Groups of about equal numbers.
fn even_clusters(count: usize) -> Vec<Cluster> {
    let parts = count.min(WIDTH);
    let start = |part: usize| part * count / parts;
    let cluster = |part| Cluster {
        range: start(part)..start(part + 1),
        cost: 0.0,
    };
    (0..parts).map(cluster).collect()
}

/// Splits the items from `first` on into clusters, up to sixteen with those that there are already.
fn clusters_of(items: &mut [Item], mut clusters: Vec<Cluster>, first: usize) -> Vec<Cluster> {
    if first < items.len() {
        let range = first..items.len();
        let cost = Extent::of(&items[range.clone()]).cost();
        clusters.push(Cluster { range, cost });
    }
    while clusters.len() < WIDTH {
        let can_split =
            |cluster: &&mut Cluster| cluster.range.len() > 1 && cluster.range.start >= first;
        let costliest = clusters.iter_mut().filter(can_split);
        let order = |a: &&mut Cluster, b: &&mut Cluster| {
            let by_cost = a.cost.total_cmp(&b.cost);
            by_cost.then(a.range.len().cmp(&b.range.len()))
        };
        let Some(cluster) = costliest.max_by(order) else {
            break;
        };
        let range = cluster.range.clone();
        let [(middle, left), (_, right)] = split(&mut items[range.clone()]);
        let middle = range.start + middle;
        *cluster = Cluster {
            range: range.start..middle,
            cost: left.cost(),
        };
        clusters.push(Cluster {
            range: middle..range.end,
            cost: right.cost(),
        });
    }
    clusters
}

/// Splits at least two items in two; returns the numbers and the extents of both halves.
fn split(items: &mut [Item]) -> [(usize, Extent); 2] {
    let whole = Extent::of(items);
    let size = whole.high - whole.low;
    let axis = (0..3).fold(0, |a, b| if size[b] > size[a] { b } else { a });
    let scale = BINS as f32 / size[axis];
    let bin = |item: &Item| {
        let share = (item.bounds.center[axis] - whole.low[axis]) * scale;
        (share as usize).min(BINS - 1)
    };
    if let Some(cut) = best_cut(items, bin) {
        let middle = partition(items, |item| bin(item) < cut);
        let (left, right) = items.split_at(middle);
        return [
            (left.len(), Extent::of(left)),
            (right.len(), Extent::of(right)),
        ];
    }
    let (left, right) = items.split_at(items.len() / 2);
    [
        (left.len(), Extent::of(left)),
        (right.len(), Extent::of(right)),
    ]
}

/// The bin before which a cut costs least; `None` if all items are in one bin.
fn best_cut(items: &[Item], bin: impl Fn(&Item) -> usize) -> Option<usize> {
    let mut bins = [Extent::NONE; BINS];
    for item in items {
        bins[bin(item)].add(item);
    }
    let mut right = [Extent::NONE; BINS + 1];
    for i in (0..BINS).rev() {
        right[i] = right[i + 1].with(&bins[i]);
    }
    let (mut left, mut best) = (Extent::NONE, None);
    for cut in 1..BINS {
        left = left.with(&bins[cut - 1]);
        if left.count == 0 || right[cut].count == 0 {
            continue;
        }
        let cost = left.cost() + right[cut].cost();
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, cut));
        }
    }
    best.map(|(_, cut)| cut)
}

/// Moves the items that are `first` before the others; returns their number.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let mut middle = 0;
    for i in 0..items.len() {
        if first(&items[i]) {
            items.swap(middle, i);
            middle += 1;
        }
    }
    middle
}

impl Extent {
    const NONE: Self = Self {
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
        intensity: 0.0,
        axis: Vec3::ZERO,
        count: 0,
    };

    fn of(items: &[Item]) -> Self {
        let mut extent = Self::NONE;
        items.iter().for_each(|item| extent.add(item));
        extent
    }

    #[inline]
    fn add(&mut self, item: &Item) {
        let bounds = &item.bounds;
        self.low = self.low.min(bounds.center);
        self.high = self.high.max(bounds.center);
        self.intensity += bounds.intensity;
        if bounds.cos_normals > 0.0 {
            self.axis += bounds.intensity * bounds.axis;
        }
        self.count += 1;
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            intensity: self.intensity + other.intensity,
            axis: self.axis + other.axis,
            count: self.count + other.count,
        }
    }

    /// The intensity, the squared diagonal, and a factor from 1, for equal normals, to 4.
    fn cost(&self) -> f32 {
        if self.count < 2 {
            return 0.0;
        }
        let alike = self.axis.length() / self.intensity;
        self.intensity * (self.high - self.low).length_squared() * (4.0 - 3.0 * alike.min(1.0))
    }
}
