//! The samples of tiles in one pass.
//!
//! Measure: samples; radiance.
//! Range: samples that are not finite are counted and located, and left out of the sums.
//! Source: none needed. Tested in `tests/rendering/determinism.rs`.

use super::dispatch::IntegratorJob;
use super::estimator::Estimator;
use super::gain_sums::GainSums;
use super::light_wavefront::{LightWavefront, SampleOrigin};
use super::pixel_block::PixelBlock;
use super::sample_range::SampleRange;
use super::sample_wavefront::{CameraRaySource, PacketIndex, SampleWavefront};
use super::tally::{NonFiniteSample, Rejected, Tally};
use crate::effects::{Effects, Switch};
use crate::film::splats::{Splat, SplatList, Splats};
use crate::film::splatted::SplattedSamples;
use crate::film::{Tile, Window};
use crate::integrator::Integrator;
use crate::integrator::light_paths::{LightPathSplat, LightPathSplats};
use crate::integrator::observer::{NullPathObserver, PathObserver};
use crate::math::lanes::{ActiveLanes, LANES, Lanes};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use rayon::prelude::*;
use std::ops::Range;

/// An upper bound of the filter weight of a sample in any pixel.
const MAX_WEIGHT: f32 = 16.0;

/// The number of splats from which on they are added to the film: enough for many to lie in the same row.
const PENDING_SPLATS: usize = 8192;

/// The sources of the samples of a pass.
#[derive(Clone, Copy)]
pub struct SampleSource<'a> {
    pub rays: CameraRaySource<'a>,
    /// The splats of the film, for light in other pixels.
    pub splats: Option<&'a Splats>,
    /// The sums of the variance that light paths save, if they are wanted.
    pub gains: Option<&'a GainSums>,
}

impl SampleSource<'_> {
    /// Whether a splat at a film position would count.
    fn reaches(&self, film: Vec2) -> bool {
        self.splats
            .is_some_and(|splats| splats.reaches(self.rays.filter, film))
    }
}

/// The job of sampling tiles on rayon's current threads.
pub struct PassJob<'a> {
    pub source: SampleSource<'a>,
    /// The tiles, in the order in which they are begun, with their samples.
    pub tiles: Vec<(&'a mut Tile, SampleRange<'a>)>,
    /// Whether to begin no further tile.
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Called after each tile, with the number of its samples.
    pub tile_done: &'a (dyn Fn(u64) + Sync),
}

impl IntegratorJob for PassJob<'_> {
    type Output = Tally;

    fn run<E: Effects, I: Integrator>(self, integrator: I) -> Tally {
        let source = self.source;
        let reaches = |film| source.reaches(film);
        let new = || TileSampler::<E, I>::new(source, integrator, &reaches);
        // Every thread takes the next tile when it is done with one, and keeps its memory.
        let tiles = self.tiles.into_iter().par_bridge();
        let tallies = tiles.map_init(new, |sampler, (tile, sample_range)| {
            if (self.is_cancelled)() {
                return Tally::default();
            }
            let samples = sample_range.sample_count(tile);
            let tally = sampler.tile(tile, sample_range, &mut NullPathObserver);
            (self.tile_done)(samples);
            tally
        });
        tallies.reduce(Tally::default, Tally::merged)
    }
}

/// The job of sampling the pixels of a tile with an observer.
pub struct ObservedTileJob<'a, O: ?Sized> {
    pub source: SampleSource<'a>,
    pub tile: &'a mut Tile,
    pub sample_range: SampleRange<'a>,
    pub observer: &'a mut O,
}

impl<O: PathObserver + ?Sized> IntegratorJob for ObservedTileJob<'_, O> {
    type Output = Tally;

    fn run<E: Effects, I: Integrator>(self, integrator: I) -> Tally {
        let reaches = |film| self.source.reaches(film);
        let mut sampler = TileSampler::<E, I>::new(self.source, integrator, &reaches);
        sampler.tile(self.tile, self.sample_range, self.observer)
    }
}

/// Takes the samples of tiles, a wavefront at a time.
struct TileSampler<'a, E: Effects, I: Integrator> {
    source: SampleSource<'a>,
    estimator: Estimator<'a, E, I>,
    wavefront: SampleWavefront,
    /// The splats of the current sample.
    sample_splats: SplatList<'a>,
    /// The light paths beside the camera paths that have been traced.
    light_wavefront: LightWavefront,
    light_path_splats: LightPathSplats<'a>,
    /// Splats that are to be added to the film, each with the index of its sample.
    pending_splats: Vec<(u64, Splat)>,
    /// Likewise the variance that light paths save: by caustics, and by others.
    pending_gains: [Vec<(u64, Splat)>; 2],
    tally: Tally,
}

impl<'a, E: Effects, I: Integrator> TileSampler<'a, E, I> {
    /// Creates a sampler without samples, given whether a splat at a film position would count.
    fn new(source: SampleSource<'a>, integrator: I, reaches: &'a dyn Fn(Vec2) -> bool) -> Self {
        Self {
            source,
            estimator: Estimator::new(source.rays.scene, integrator),
            wavefront: SampleWavefront::default(),
            sample_splats: SplatList {
                reaches,
                splats: Vec::new(),
            },
            light_path_splats: LightPathSplats {
                reaches,
                with_gains: source.gains.is_some(),
                splats: Vec::new(),
            },
            light_wavefront: LightWavefront::default(),
            pending_splats: Vec::new(),
            pending_gains: Default::default(),
            tally: Tally::default(),
        }
    }

    /// Takes the samples of the pixels of a tile.
    fn tile<O: PathObserver + ?Sized>(
        &mut self,
        tile: &mut Tile,
        sample_range: SampleRange<'_>,
        observer: &mut O,
    ) -> Tally {
        let sources = tile.sources();
        let stride = self.estimator.integrator.reuse().stride();
        for block in PixelBlock::covering(sources, stride) {
            self.add_block(tile, sources, block, &sample_range, observer);
        }
        self.advance(tile, observer);
        self.trace_light_paths(tile);
        self.add_splats();
        if let Some(splats) = self.source.splats {
            for (batch, count) in (0..).zip(sample_range.batch_counts(tile)) {
                if planted!(
                    "adaptive-light-paths-uncounted",
                    matches!(sample_range, SampleRange::Same(_)),
                    true
                ) {
                    splats.add_samples(batch, count);
                }
            }
        }
        match sample_range {
            SampleRange::Same(range) => tile.samples += range.end - range.start,
            SampleRange::Each { counts, .. } => {
                tile.samples = counts.iter().copied().min().unwrap_or(tile.samples);
                counts.clone_into(tile.counts.get_or_insert_default());
            }
        }
        std::mem::take(&mut self.tally)
    }

    /// Takes the samples of the pixels of a block.
    fn add_block<O: PathObserver + ?Sized>(
        &mut self,
        tile: &mut Tile,
        sources: Window,
        block: PixelBlock,
        sample_range: &SampleRange<'_>,
        observer: &mut O,
    ) {
        let in_tile = block.lanes_in(sources);
        let mut ranges: Lanes<Range<u64>> = std::array::from_fn(|_| 0..0);
        for lane in in_tile.each() {
            ranges[lane] = sample_range.of_pixel(tile, block.pixel(lane));
        }
        let requested = || ranges.iter().filter(|range| !range.is_empty());
        let first = requested().map(|range| range.start).min();
        let end = requested().map(|range| range.end).max();
        let (mut sample, end) = (first.unwrap_or(0), end.unwrap_or(0));
        while sample < end {
            let mut lanes = ActiveLanes::NONE;
            for (lane, range) in ranges.iter().enumerate() {
                lanes.set(lane, range.contains(&sample));
            }
            if !lanes.any() {
                // Ranges of pixels may be far apart.
                let later = ranges.iter().map(|range| range.start);
                sample = later.filter(|&start| start > sample).min().unwrap_or(end);
                continue;
            }
            let index = PacketIndex { block, sample };
            sample += 1;
            self.wavefront
                .add::<E, O>(&self.source.rays, index, lanes, observer);
            if self.wavefront.is_full() {
                self.advance(tile, observer);
            }
        }
    }

    /// Estimates all samples, and adds them to the film.
    fn advance<O: PathObserver + ?Sized>(&mut self, tile: &mut Tile, observer: &mut O) {
        self.wavefront.trace(self.estimator.scene);
        let is_together = I::IS_WAVEFRONT && !observer.is_sequential();
        if is_together {
            self.wavefront.estimate(&mut self.estimator, observer);
            self.add_light_paths(tile);
        }
        for packet in 0..self.wavefront.indices().len() {
            let mut kept = ActiveLanes::NONE;
            for lane in self.wavefront.requested(packet).each() {
                if !is_together {
                    let (estimator, splats) = (&mut self.estimator, &mut self.sample_splats);
                    self.wavefront
                        .estimate_one(packet, lane, estimator, observer, splats);
                }
                if !tile.window.contains(self.pixel(packet, lane)) {
                    // Only the samples of the tile's own pixels are counted for splats, so that others must not add
                    // any.
                    self.sample_splats.splats.clear();
                }
                kept.set(lane, self.film(tile, packet, lane, observer));
            }
            self.splat(tile, packet, kept);
        }
        self.wavefront.clear();
        if self.pending_splats.len() >= PENDING_SPLATS {
            self.add_splats();
        }
    }

    /// Adds the light paths of the samples of the wavefront, which are estimated, and traces them when there are enough.
    fn add_light_paths(&mut self, tile: &mut Tile) {
        let light_paths = self.estimator.integrator.light_paths();
        if !E::LightPaths::ON || !light_paths.is_on() || self.source.splats.is_none() {
            return;
        }
        let light_wavefront = &mut self.light_wavefront;
        self.wavefront
            .add_light_paths(light_paths.share, tile.window, light_wavefront);
        if light_wavefront.is_full() {
            self.trace_light_paths(tile);
        }
    }

    /// Traces the light paths that have not been traced yet.
    fn trace_light_paths(&mut self, tile: &mut Tile) {
        if !E::LightPaths::ON {
            return;
        }
        let traced = &mut self.light_path_splats;
        self.light_wavefront.trace(&mut self.estimator, traced);
        for (origin, rays) in self.light_wavefront.ray_counts() {
            self.tally.rays += rays;
            if let Some(of_pixels) = &mut tile.rays {
                of_pixels[tile.window.index(origin.pixel)] += rays.total();
            }
        }
        for LightPathSplat {
            sample_index,
            splat,
            gain,
            is_caustic,
        } in traced.splats.drain(..)
        {
            let SampleOrigin { pixel, sample } = self.light_wavefront.origin(sample_index);
            if splat.value.is_finite() {
                self.pending_splats.push((sample, splat));
                if traced.with_gains && gain.is_finite() {
                    let value = gain;
                    let pending = &mut self.pending_gains[usize::from(!is_caustic)];
                    pending.push((sample, Splat { value, ..splat }));
                }
            } else {
                let [x, y] = pixel;
                let first = Some(NonFiniteSample { y, x, sample });
                self.tally.rejected.merge(Rejected { count: 1, first });
            }
        }
        self.light_wavefront.clear();
    }

    /// Adds the pending splats to the film.
    fn add_splats(&mut self) {
        let SampleSource {
            rays,
            splats,
            gains,
        } = self.source;
        let [caustics, others] = &mut self.pending_gains;
        for (sums, pending) in [
            (splats, &mut self.pending_splats),
            (gains.map(|gains| &gains.caustics), caustics),
            (gains.map(|gains| &gains.others), others),
        ] {
            if let Some(sums) = sums {
                sums.add(rays.filter, pending);
            }
            pending.clear();
        }
    }

    /// The pixel of a sample.
    fn pixel(&self, packet: usize, lane: usize) -> [u32; 2] {
        self.wavefront.indices()[packet].block.pixel(lane)
    }

    /// Adds the samples of a packet to all pixels that they contribute to, if these are several.
    fn splat(&self, tile: &mut Tile, packet: usize, samples: ActiveLanes<LANES>) {
        let footprint = self.source.rays.filter.footprint();
        if let (Some(splatted), Some(footprint)) = (&mut tile.splatted, footprint) {
            let PacketIndex { block, sample } = self.wavefront.indices()[packet];
            let radiance = |lane| match samples.has(lane) {
                true => self.wavefront.value(packet, lane),
                false => Rgb::BLACK,
            };
            let samples = SplattedSamples {
                active: samples,
                pixels: block.pixels(),
                positions: *self.wavefront.positions(packet),
                radiance: std::array::from_fn(radiance),
            };
            splatted.add(footprint, sample, &samples);
        }
    }

    /// Adds one sample to the film. Where samples contribute to several pixels, this adds only its splats and counts,
    /// and [`Self::splat`] the sample with its packet. Returns whether it is finite.
    #[inline]
    fn film<O: PathObserver + ?Sized>(
        &mut self,
        tile: &mut Tile,
        packet: usize,
        lane: usize,
        observer: &mut O,
    ) -> bool {
        let sample = self.wavefront.indices()[packet].sample;
        let [x, y] = self.pixel(packet, lane);
        let value = self.wavefront.value(packet, lane);
        let is_splatted = tile.splatted.is_some();
        let largest = if is_splatted {
            MAX_WEIGHT * value
        } else {
            value
        };
        let sample_splats = &mut self.sample_splats.splats;
        let is_finite =
            largest.is_finite() && sample_splats.iter().all(|splat| splat.value.is_finite());
        if is_finite {
            let of_sample = sample_splats.iter().map(|splat| (sample, *splat));
            self.pending_splats.extend(of_sample);
            if !is_splatted {
                tile.pixels[tile.window.index([x, y])].add(sample, value);
            }
        } else {
            let first = Some(NonFiniteSample { y, x, sample });
            self.tally.rejected.merge(Rejected { count: 1, first });
        }
        sample_splats.clear();
        let rays = self.wavefront.samples(packet).estimate(lane).rays;
        self.tally.rays += rays;
        if let Some(of_pixels) = &mut tile.rays {
            of_pixels[tile.window.index([x, y])] += rays.total();
        }
        observer.sample_added(value);
        is_finite
    }
}
