//! Compares the hits of two targets ray by ray; where they differ, double precision decides whether rounding explains
//! the difference.
//!
//! Of two different hits, the nearer one is judged. If every query has to find it, the target that missed it is wrong.
//! If not, the ray of the target that found it is continued behind the hit and both are compared again, until both
//! targets report the same place or a miss: thus no hit that is certain is overlooked. For shadow rays, all hits of
//! both targets along the ray are judged in the same way; if there are none, every primitive is tested.
//!
//! Measure: rays.
//! Range: inactive rays are left out. Errors that two backends have in common are not detected.
//! Source: docs/bench.md; `hit_interval` for the bounds. Tested in `lab/tests/bench/agreement.rs`.

use super::hit_interval::{HitInterval, hit_intervals};
use super::report::AgreementReport;
use super::target::BenchTarget;
use etendue::internals::accel::batch::RayBatch;
use etendue::internals::accel::{Accel, Hit, PrimitiveId};
use etendue::internals::geometry::world::World;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::robust::gamma;
use rayon::prelude::*;

/// Number of rays compared by a thread at a time.
const BLOCK: usize = 1024;

/// The result of comparing one ray.
enum RayVerdict {
    Identical,
    Tie,
    Edge,
    /// A real error, described in words.
    Real(String),
}

impl AgreementReport {
    /// An empty report.
    pub fn new(target: BenchTarget, reference: BenchTarget) -> Self {
        Self {
            target,
            reference,
            rays: 0,
            identical: 0,
            ties: 0,
            edges: 0,
            real: 0,
            first_real: None,
        }
    }

    /// Adds the counts of a later report.
    pub fn merge(&mut self, later: Self) {
        self.rays += later.rays;
        self.identical += later.identical;
        self.ties += later.ties;
        self.edges += later.edges;
        self.real += later.real;
        self.first_real = self.first_real.take().or(later.first_real);
    }

    fn count(&mut self, verdict: RayVerdict) {
        self.rays += 1;
        match verdict {
            RayVerdict::Identical => self.identical += 1,
            RayVerdict::Tie => self.ties += 1,
            RayVerdict::Edge => self.edges += 1,
            RayVerdict::Real(words) => {
                self.real += 1;
                self.first_real.get_or_insert(words);
            }
        }
    }
}

/// Compares closest hits, or occlusion if `occlusion` is set, and adds the results to the report, on rayon's current
/// threads.
pub fn compare(
    world: &World,
    target: (BenchTarget, &Accel),
    reference: (BenchTarget, &Accel),
    rays: &RayBatch,
    occlusion: bool,
    report: &mut AgreementReport,
) {
    let pair = Pair {
        world,
        sides: [target, reference],
    };
    let block = |first: usize| {
        let mut counts = AgreementReport::new(target.0, reference.0);
        let last = (first + BLOCK).min(rays.len());
        for index in (first..last).filter(|&index| rays.is_active(index)) {
            let (ray, time) = rays.get(index);
            counts.count(if occlusion {
                pair.occlusion(&ray, time)
            } else {
                pair.closest(&ray, time)
            });
        }
        counts
    };
    let firsts: Vec<usize> = (0..rays.len()).step_by(BLOCK).collect();
    let blocks: Vec<AgreementReport> = firsts.into_par_iter().map(block).collect();
    for counts in blocks {
        report.merge(counts);
    }
}

/// Two acceleration structures of one world, to be compared.
struct Pair<'a> {
    world: &'a World,
    sides: [(BenchTarget, &'a Accel); 2],
}

impl Pair<'_> {
    fn closest(&self, ray: &Ray, time: f32) -> RayVerdict {
        let first = self
            .sides
            .map(|(_, accel)| accel.intersect(ray, time, None));
        if is_same(first) {
            return RayVerdict::Identical;
        }
        let real = |what: &str| RayVerdict::Real(self.words(ray, time, first, what));
        let mut hits = first;
        let mut passed_edge = false;
        // The distance up to which each side's ray was continued: the side cannot report hits before it any more.
        let mut skipped = [f32::NEG_INFINITY; 2];
        loop {
            let mut intervals: [Option<HitInterval>; 2] = [None; 2];
            for (interval, hit) in intervals.iter_mut().zip(hits) {
                let Some(hit) = hit else { continue };
                *interval = self.hit_interval(hit, ray, time);
                if interval.is_none() {
                    return real(&format!("{} is not at {:?}", name(hit.id), hit.t));
                }
            }
            let same_primitive = match (intervals, hits) {
                ([None, None], _) => return RayVerdict::Edge,
                ([Some(a), Some(b)], [Some(hit), Some(other)])
                    if a.overlaps(&b) && !a.is_grazing() && !b.is_grazing() =>
                {
                    Some(hit.id == other.id)
                }
                _ => None,
            };
            if let Some(same_primitive) = same_primitive {
                return match (passed_edge, same_primitive) {
                    (true, _) => RayVerdict::Edge,
                    (false, true) => RayVerdict::Identical,
                    (false, false) => RayVerdict::Tie,
                };
            }
            let distance = |hit: Option<Hit>| hit.map_or(f32::INFINITY, |hit| hit.t);
            let near = usize::from(distance(hits[1]) < distance(hits[0]));
            let (Some(hit), Some(interval)) = (hits[near], intervals[near]) else {
                return RayVerdict::Edge;
            };
            // A hit of the other side at the same distance up to rounding may hide this one.
            let far = 1 - near;
            let passes = f64::from(distance(hits[far])) > interval.to
                && f64::from(skipped[far]) < interval.from;
            if interval.certain && passes {
                let passing = self.sides[far].0.name();
                return real(&format!("{passing} misses {}", name(hit.id)));
            }
            passed_edge = true;
            (hits[near], skipped[near]) = self.behind(near, ray, time, hit);
        }
    }

    fn occlusion(&self, ray: &Ray, time: f32) -> RayVerdict {
        let occluded = self.sides.map(|(_, accel)| accel.occluded(ray, time));
        if occluded[0] == occluded[1] {
            return RayVerdict::Identical;
        }
        let free = self.sides[usize::from(occluded[0])].0.name();
        let real = |what: String| {
            let closest = self
                .sides
                .map(|(_, accel)| accel.intersect(ray, time, None));
            RayVerdict::Real(self.words(ray, time, closest, &what))
        };
        let mut candidates = false;
        for side in 0..2 {
            let mut next = self.sides[side].1.intersect(ray, time, None);
            while let Some(hit) = next {
                match self.hit_interval(hit, ray, time) {
                    Some(interval) if interval.certain => {
                        return real(format!(
                            "{free} reports no occlusion, but the ray hits {}",
                            name(hit.id)
                        ));
                    }
                    uncertain => candidates |= uncertain.is_some(),
                }
                (next, _) = self.behind(side, ray, time, hit);
            }
        }
        if candidates {
            return RayVerdict::Edge;
        }
        match self.anything_on(ray, time) {
            (Some(id), _) => real(format!(
                "{free} reports no occlusion, but the ray hits {}",
                name(id)
            )),
            (None, true) => RayVerdict::Edge,
            (None, false) => real(format!(
                "the ray hits nothing, but only {free} reports no occlusion"
            )),
        }
    }

    /// Returns the interval of the ray that contains the hit and in which its primitive may be hit.
    fn hit_interval(&self, hit: Hit, ray: &Ray, time: f32) -> Option<HitInterval> {
        let all = hit_intervals(self.world, hit.id, ray, time);
        all.into_iter()
            .flatten()
            .find(|interval| interval.holds(hit.t))
    }

    /// Returns the next hit of a side behind a hit, and the distance from which it was searched.
    ///
    /// Backends in single precision may report a hit some roundings before the start of the ray, as Embree's AVX2 code does with
    /// [`Precision::Fast`](etendue::Precision::Fast): then the start moves on.
    fn behind(&self, side: usize, ray: &Ray, time: f32, hit: Hit) -> (Option<Hit>, f32) {
        let mut rest = *ray;
        rest.begin_after(hit.t);
        loop {
            match self.sides[side].1.intersect(&rest, time, None) {
                Some(again) if again.t <= hit.t => rest.begin_after(again.t),
                next => return (next, rest.t_min),
            }
        }
    }

    /// Tests all primitives: returns one that the ray certainly hits, and whether the ray may hit any.
    fn anything_on(&self, ray: &Ray, time: f32) -> (Option<PrimitiveId>, bool) {
        let in_shape = |shape: u32| {
            let count = self.world.geometry(shape).primitive_count() as u32;
            (0..count)
                .into_par_iter()
                .map(move |primitive| PrimitiveId { shape, primitive })
        };
        let shapes = (0..self.world.shape_count() as u32).into_par_iter();
        let possible = shapes.flat_map(in_shape).filter_map(|id| {
            let intervals = hit_intervals(self.world, id, ray, time);
            let certain = intervals.iter().flatten().any(|interval| interval.certain);
            intervals[0]
                .or(intervals[1])
                .map(|_| (certain.then_some(id), true))
        });
        possible.reduce(
            || (None, false),
            |(a, _), (b, _)| (a.into_iter().chain(b).min(), true),
        )
    }

    /// Describes the ray and its hits so that it can be traced again: `{:?}` prints enough digits to parse the same
    /// number.
    fn words(&self, ray: &Ray, time: f32, hits: [Option<Hit>; 2], what: &str) -> String {
        let hit_of = |side: usize| {
            let name = self.sides[side].0.name();
            match hits[side] {
                Some(hit) => format!("{name}: {} at {:?}", self::name(hit.id), hit.t),
                None => format!("{name}: no hit"),
            }
        };
        format!(
            "{what} (origin {:?}, direction {:?}, t from {:?} to {:?}, time {time:?}; {}; {})",
            ray.origin.to_array(),
            ray.dir.to_array(),
            ray.t_min,
            ray.t_max,
            hit_of(0),
            hit_of(1),
        )
    }
}

fn name(id: PrimitiveId) -> String {
    format!("primitive {} of shape {}", id.primitive, id.shape)
}

/// Whether the two hits are the same without further tests: same primitive, and distances no farther apart than the two
/// roundings of a quotient allow for each.
fn is_same(hits: [Option<Hit>; 2]) -> bool {
    match hits {
        [None, None] => true,
        [Some(a), Some(b)] => a.id == b.id && (a.t - b.t).abs() <= gamma(4) * a.t.max(b.t),
        _ => false,
    }
}
