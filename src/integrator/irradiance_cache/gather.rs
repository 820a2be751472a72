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
    /// The coordinates that select the random numbers, as a pixel's do.
    pub numbers: [u32; 2],
}

impl Gatherer<'_> {
    /// Gathers the record of a surface interaction. Rays are counted in `rays`.
    pub fn gather<E: Effects, S: Sampler>(
        &self,
        sampler: &mut S,
        at: &Interaction<E>,
        rays: &mut RayCounts,
        scratch: &mut PathScratch<E>,
    ) -> Option<Record> {
        let record = |HemisphereEstimate { light, distance }: &HemisphereEstimate| {
            Record::new(at.p, &at.frame, light, distance, self.bound)
        };
        let first =
            self.sample_hemisphere(Cells::about(MIN_RAYS), 0, sampler, at, rays, scratch)?;
        let noise = first.light.variance.sqrt() / first.light.irradiance();
        let too_much = (noise / (NOISE * self.bound)).powi(2);
        if too_much <= 1.0 {
            return Some(record(&first));
        }
        // `MAX_RAYS` if no light was found at all.
        let count = (first.distance.len() as f64 * too_much).min(MAX_RAYS);
        let spent = first.distance.len();
        let second =
            self.sample_hemisphere(Cells::about(count), spent, sampler, at, rays, scratch)?;
        Some(record(&second))
    }

    /// Samples the hemisphere once, with random numbers from the index `spent` on.
    fn sample_hemisphere<E: Effects, S: Sampler>(
        &self,
        cells: Cells,
        spent: usize,
        sampler: &mut S,
        at: &Interaction<E>,
        rays: &mut RayCounts,
        scratch: &mut PathScratch<E>,
    ) -> Option<HemisphereEstimate> {
        let mut radiance = vec![Rgb::BLACK; cells.count()];
        let mut distance = vec![f32::INFINITY; cells.count()];
        let (mut paths, mut samplers) = (Vec::new(), Vec::new());
        let mut samples = vec![SampleLanes::default(); WAVEFRONT_SIZE / LANES];
        let mut excluded_by_rays = Vec::new();
        // A scene with motion has no cache (`dispatch::check`).
        let time = 0.0;
        for first in (0..cells.count()).step_by(WAVEFRONT_SIZE) {
            paths.clear();
            samplers.clear();
            samples.fill(SampleLanes::default());
            excluded_by_rays.clear();
            for cell in first..cells.count().min(first + WAVEFRONT_SIZE) {
                sampler.start(self.numbers, (spent + cell) as u64);
                let u: [f32; 2] = sampler.draw(Decision::Bsdf(0));
                let local = cells.direction(cell, Vec2::from_array(u));
                let wi = at.frame.to_world(local);
                if !at.is_consistent_side(wi, false) {
                    continue;
                }
                let (ray, excluded) = self.scene.spawn(at, time, wi, false);
                let excluded = Some(excluded);
                let hit = self.scene.accel.intersect(&ray, time, excluded);
                let path = paths.len();
                samples[path / LANES].add(path % LANES, &CameraRay { ray, time }, hit);
                paths.push((cell, hit.map_or(f32::INFINITY, |hit| hit.t)));
                samplers.push(sampler.clone());
                excluded_by_rays.push(excluded);
            }
            scratch.paths.begin(&samples);
            let gathered_from = Some((at.receiver(false), PdfSolidAngle::MIN_ABOVE_ZERO));
            let blocks = scratch.paths.blocks_mut().iter_mut();
            for (block, excluded) in blocks.zip(excluded_by_rays.chunks(LANES)) {
                for (lane, &excluded) in excluded.iter().enumerate() {
                    block.excluded.set(lane, excluded);
                    let from = planted!("cache-counts-lights-twice", None, gathered_from);
                    block.set_prev_vertex(lane, from);
                }
            }
            let wavefront = PathWavefront {
                scene: self.scene,
                samples: &mut samples,
                samplers: &mut samplers,
                observer: &mut NullPathObserver,
                bounce: 1,
            };
            self.integrator.trace_wavefront(wavefront, scratch);
            for (path, (cell, clear)) in paths.drain(..).enumerate() {
                let estimate = samples[path / LANES].estimate(path % LANES);
                rays.closest += 1 + estimate.rays.closest;
                rays.shadow += estimate.rays.shadow;
                distance[cell] = clear;
                if !estimate.radiance.is_finite() {
                    return None;
                }
                radiance[cell] = estimate.radiance;
            }
        }
        let light = Expansion::of(cells, &radiance, &distance);
        Some(HemisphereEstimate { light, distance })
    }
}

/// The result of sampling the hemisphere once.
struct HemisphereEstimate {
    light: Expansion,
    distance: Vec<f32>,
}
