//! Sampling of the hemisphere over a matte surface, for the incident light that light sampling does not find there.
//!
//! One ray goes through a random point of each cell, and its path is traced as any other. A first pass with few cells
//! determines how many the record needs.
//!
//! Measure: radiance; normalised scene units.
//! Range: any surface that scatters to one side. A value that is not finite makes no record: the place is left to
//! paths, which report it.
//! Source: Ward, Rubinstein and Clear 1988. Tested in `tests/rendering/irradiance_cache.rs`.

use super::hemisphere::{Cells, Expansion};
use super::record::Record;
use crate::accel::ExcludedPrimitive;
use crate::effects::Effects;
use crate::integrator::observer::NullPathObserver;
use crate::integrator::path::{PathIntegrator, PathScratch, PathWavefront, WAVEFRONT_SIZE};
use crate::integrator::{CameraRay, RayCounts, SampleLanes};
use crate::math::lanes::LANES;
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// The largest standard error of a record as a share of the bound, unless that takes too many rays. An image shows
/// means over several records, whose error is less.
const NOISE: f64 = 0.5;

/// The least number of rays of a record: with fewer, its distances and derivatives are mostly noise.
const MIN_RAYS: f64 = 256.0;

/// The largest number of rays of a record.
const MAX_RAYS: f64 = 16_384.0;

/// Gathers records at points of a scene.
#[derive(Debug)]
pub struct Gatherer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The integrator that traces the paths.
    pub integrator: PathIntegrator,
    /// The allowed relative error.
    pub bound: f64,
    /// The pixel whose sequence of random numbers the records use.
    pub sequence_pixel: [u32; 2],
}

/// The memory of a hemisphere, which the next one uses, too.
#[derive(Debug)]
pub struct GatherScratch<E: Effects, S> {
    /// The scratch of the paths.
    pub paths: PathScratch<E>,
    /// The radiance from each cell.
    radiance: Vec<Rgb>,
    /// The distance of the surface in each cell.
    distance: Vec<f32>,
    /// The samples of a wavefront, one for each ray.
    samples: Vec<SampleLanes>,
    samplers: Vec<S>,
    rays: Vec<GatherRay>,
}

/// A ray through a cell.
#[derive(Debug, Clone, Copy)]
struct GatherRay {
    cell: usize,
    /// The distance of the first hit; infinite without one.
    distance: f32,
    /// The primitive that the ray leaves.
    excluded: ExcludedPrimitive,
}

impl<E: Effects, S> Default for GatherScratch<E, S> {
    fn default() -> Self {
        Self {
            paths: PathScratch::default(),
            radiance: Vec::new(),
            distance: Vec::new(),
            samples: Vec::new(),
            samplers: Vec::new(),
            rays: Vec::new(),
        }
    }
}

impl Gatherer<'_> {
    /// Gathers the record of a surface interaction. Rays are counted in `rays`.
    pub fn gather<E: Effects, S: Sampler>(
        &self,
        sampler: &mut S,
        at: &Interaction<E>,
        rays: &mut RayCounts,
        scratch: &mut GatherScratch<E, S>,
    ) -> Option<Record> {
        let record = |light: &Expansion, scratch: &GatherScratch<E, S>| {
            Record::new(at.p, &at.frame, light, &scratch.distance, self.bound)
        };
        let cells = Cells::about(MIN_RAYS);
        let first = self.sample_hemisphere(cells, 0, sampler, at, rays, scratch)?;
        let noise = first.variance.sqrt() / first.irradiance();
        let too_much = (noise / (NOISE * self.bound)).powi(2);
        if too_much <= 1.0 {
            return Some(record(&first, scratch));
        }
        // `MAX_RAYS` if no light was found at all.
        let spent = cells.count();
        let count = (spent as f64 * too_much).min(MAX_RAYS);
        let cells = Cells::about(count);
        let second = self.sample_hemisphere(cells, spent, sampler, at, rays, scratch)?;
        Some(record(&second, scratch))
    }

    /// Samples the hemisphere once, with random numbers from the index `spent` on. The distances are left in the scratch.
    fn sample_hemisphere<E: Effects, S: Sampler>(
        &self,
        cells: Cells,
        spent: usize,
        sampler: &mut S,
        at: &Interaction<E>,
        rays: &mut RayCounts,
        scratch: &mut GatherScratch<E, S>,
    ) -> Option<Expansion> {
        let GatherScratch {
            paths,
            radiance,
            distance,
            samples,
            samplers,
            rays: gathered,
        } = scratch;
        radiance.clear();
        radiance.resize(cells.count(), Rgb::BLACK);
        distance.clear();
        distance.resize(cells.count(), f32::INFINITY);
        // A scene with motion has no cache (`dispatch::check`).
        let time = 0.0;
        for first in (0..cells.count()).step_by(WAVEFRONT_SIZE) {
            gathered.clear();
            samplers.clear();
            samples.clear();
            samples.resize(WAVEFRONT_SIZE / LANES, SampleLanes::default());
            for cell in first..cells.count().min(first + WAVEFRONT_SIZE) {
                sampler.start(self.sequence_pixel, (spent + cell) as u64);
                let u: [f32; 2] = sampler.draw(Decision::Bsdf(0));
                let local = cells.direction(cell, Vec2::from_array(u));
                let wi = at.frame.to_world(local);
                if !at.is_consistent_side(wi, false) {
                    continue;
                }
                let (ray, excluded) = self.scene.spawn(at, time, wi, false);
                let hit = self.scene.accel.intersect(&ray, time, Some(excluded));
                let path = gathered.len();
                samples[path / LANES].add(path % LANES, &CameraRay { ray, time }, hit);
                gathered.push(GatherRay {
                    cell,
                    distance: hit.map_or(f32::INFINITY, |hit| hit.t),
                    excluded,
                });
                samplers.push(sampler.clone());
            }
            paths.paths.begin(samples);
            let gathered_from = Some((at.receiver(false), PdfSolidAngle::MIN_ABOVE_ZERO));
            let blocks = paths.paths.blocks_mut().iter_mut();
            for (block, rays) in blocks.zip(gathered.chunks(LANES)) {
                for (lane, ray) in rays.iter().enumerate() {
                    block.excluded.set(lane, Some(ray.excluded));
                    let from = planted!("cache-counts-lights-twice", None, gathered_from);
                    block.set_prev_vertex(lane, from);
                }
            }
            let wavefront = PathWavefront {
                scene: self.scene,
                samples,
                samplers,
                observer: &mut NullPathObserver,
                bounce: 1,
            };
            self.integrator.trace_wavefront(wavefront, paths);
            for (path, ray) in gathered.iter().enumerate() {
                let estimate = samples[path / LANES].estimate(path % LANES);
                rays.closest += 1 + estimate.rays.closest;
                rays.shadow += estimate.rays.shadow;
                distance[ray.cell] = ray.distance;
                if !estimate.radiance.is_finite() {
                    return None;
                }
                radiance[ray.cell] = estimate.radiance;
            }
        }
        Some(Expansion::of(cells, radiance, distance))
    }
}
