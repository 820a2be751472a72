//! The header of a state file: all that is known of the samples but their sums.
//!
//! Measure: stated at each field.
//! Range: [`StateHeader::check`] refuses a header that no render writes. Of adaptive renders, numbers of samples are levels,
//! means over the pixels.
//! Source: none needed. Tested in `tests/rendering/state.rs`.

use super::fingerprint::Fingerprint;
use super::ranges::describe;
use crate::error::{Error, ErrorKind, Result};
use crate::film::batches::BATCHES;
use crate::film::footprint::MAX_BORDER_SIZE;
use crate::film::splats::Splats;
use crate::film::{Film, FilmLayout, Window};
use crate::image::{Layer, MAX_SIDE};
use crate::integrator::RayCounts;
use crate::memory;
use crate::render::adaptive::allocation::Allocation;
use crate::render::budget::PlannerState;
use crate::render::convergence::ErrorRecord;
use crate::render::settings::MAX_SPP;
use crate::render::{Rejected, Rendered};
use serde::{Deserialize, Serialize};

/// The largest count of rays, light paths or rejected samples, so that those of a few files can be added.
pub(super) const MAX_COUNTED: u64 = 1 << 61;

/// The longest time of rendering, in seconds.
const MAX_SECONDS: f64 = 1e15;

/// The pilot of an adaptive render, which decides the counts of its other samples.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AdaptivePilot {
    /// The samples of every pixel in the pilot.
    pub samples: u64,
    /// The identity of its allocation.
    pub identity: String,
}

impl AdaptivePilot {
    /// The pilot of this allocation.
    pub fn of(allocation: &Allocation) -> Self {
        Self {
            samples: allocation.pilot(),
            identity: allocation.identity(),
        }
    }
}

/// The description of a render's samples, without their sums.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StateHeader {
    /// The identity of scene, settings and program.
    pub identity: Fingerprint,
    /// The scene file, for messages.
    pub scene_file: String,
    /// The part of the image.
    pub window: Window,
    /// The edge of a tile, in pixels.
    pub tile_size: u32,
    /// The number of pixels on either side of its own that a sample contributes to.
    #[serde(default, rename = "reach")]
    pub border_size: u32,
    /// The samples per pixel of the whole render, if they are known.
    pub spp: Option<u64>,
    /// The most samples per pixel of a render to an error.
    #[serde(default)]
    pub limit: Option<u64>,
    /// The first sample of the shard and the one after its last; `None` for a whole render.
    pub shard: Option<[u64; 2]>,
    /// The ranges of samples that every pixel has, in order and apart: the first, and the one after the last.
    pub done: Vec<[u64; 2]>,
    /// Whether some tiles have more samples, since the render was interrupted within a pass.
    pub is_uneven: bool,
    /// The time of rendering, in seconds; of merged states the sum.
    pub seconds: f64,
    /// The rays that were traced.
    pub rays: RayCounts,
    /// Samples that were not finite.
    pub rejected: Rejected,
    /// The estimates of the error during the render.
    #[serde(rename = "looks")]
    pub error_records: Vec<ErrorRecord>,
    /// The plan of the next estimate.
    pub planner: Option<PlannerState>,
    /// The samples of each batch that splats are divided by, if the integrator splats.
    #[serde(rename = "paths")]
    pub splat_samples: Option<[u64; BATCHES as usize]>,
    /// The names of the layers.
    pub layers: Vec<String>,
    /// Whether layers are to be written beside the image.
    pub wants_layers: bool,
    /// The biases of the image, in words.
    pub bias: Vec<String>,
    /// Whether each pixel has a count of samples and of rays, as in adaptive renders.
    #[serde(default)]
    pub has_counts: bool,
    /// The pilot that decided the counts of samples; `None` for an even distribution, such as that of a pilot.
    #[serde(default)]
    pub pilot: Option<AdaptivePilot>,
    /// Whether the file has the allocation of the pilot, so that the render continues without the pilot's file.
    #[serde(default)]
    pub has_allocation: bool,
    /// The samples per pixel, distributed evenly, that those of an adaptive render are equivalent to, if it is known.
    #[serde(default, rename = "worth")]
    pub equivalent_spp: Option<f64>,
}

impl StateHeader {
    /// The header of a render without samples.
    pub fn new(identity: Fingerprint, scene_file: String, window: Window) -> Self {
        Self {
            identity,
            scene_file,
            window,
            tile_size: 1,
            border_size: 0,
            spp: None,
            limit: None,
            shard: None,
            done: vec![],
            is_uneven: false,
            seconds: 0.0,
            rays: RayCounts::default(),
            rejected: Rejected::default(),
            error_records: vec![],
            planner: None,
            splat_samples: None,
            layers: vec![],
            wants_layers: false,
            bias: vec![],
            has_counts: false,
            pilot: None,
            has_allocation: false,
            equivalent_spp: None,
        }
    }

    /// The header of the state of a render.
    pub fn of(self, rendered: &Rendered, layers: &[Layer]) -> Self {
        let film = &rendered.film;
        let samples = film.tiles().iter().map(|tile| tile.samples);
        let (min, max) = (samples.clone().min(), samples.max());
        // Where counts differ between pixels, their level is known.
        let (spp, is_uneven) = match film.has_counts() {
            true => (rendered.spp, rendered.is_uneven),
            false => (min.unwrap_or(0), min != max),
        };
        let done = [rendered.first, rendered.first + spp];
        Self {
            done: Some(done).filter(|[a, b]| a < b).into_iter().collect(),
            is_uneven,
            has_counts: film.has_counts(),
            pilot: rendered.allocation.as_deref().map(AdaptivePilot::of),
            has_allocation: rendered.allocation.is_some() && !rendered.is_shard,
            equivalent_spp: rendered.equivalent_spp,
            tile_size: film.tile_size(),
            border_size: film.border_size(),
            seconds: rendered.elapsed.as_secs_f64(),
            rays: rendered.rays,
            rejected: rendered.rejected,
            error_records: rendered.error_records.clone(),
            planner: rendered.planner,
            splat_samples: film.splats().map(Splats::samples),
            layers: layers.iter().map(|layer| layer.name.clone()).collect(),
            ..self
        }
    }

    /// The number of samples that every pixel has.
    pub fn samples(&self) -> u64 {
        self.done.iter().map(|[first, end]| end - first).sum()
    }

    /// The film of these samples, without them.
    ///
    /// # Errors
    /// Too little memory.
    pub fn empty_film(&self) -> Result<Film> {
        let Window { width, height, .. } = self.window;
        let layout = self.film_layout();
        let of_layers = (self.layers.len() * size_of::<f32>()) as u64;
        let of_allocation = u64::from(self.has_allocation) * Allocation::MEMORY;
        let pixels = self.window.pixel_count();
        let more = pixels.saturating_mul(of_layers + of_allocation);
        let bytes = layout.memory().saturating_add(more);
        memory::check(bytes, || format!("an image of {width} x {height} pixels"))?;
        Ok(Film::of_layout(&layout))
    }

    /// The layout of the film of these samples.
    pub(super) fn film_layout(&self) -> FilmLayout {
        FilmLayout {
            window: self.window,
            tile_size: self.tile_size,
            border_size: self.border_size,
            has_splats: self.splat_samples.is_some(),
            has_counts: self.has_counts,
        }
    }

    /// Refuses a header that no render writes, and one for which the file's body is too short.
    pub(super) fn check(&self, body_length: u64) -> Result<()> {
        let Window {
            x,
            y,
            width,
            height,
        } = self.window;
        let fits = |start: u32, length: u32| {
            (1..=MAX_SIDE).contains(&(length as usize)) && start.checked_add(length).is_some()
        };
        let is_tiled = self.tile_size > 0 && self.border_size <= MAX_BORDER_SIZE;
        if !fits(x, width) || !fits(y, height) || !is_tiled {
            return Err(damaged(format!(
                "its header has an impossible window: {width} x {height} pixels from ({x}, {y}) in tiles of {} and {} around",
                self.tile_size, self.border_size
            )));
        }
        self.check_samples()?;
        let pixels = self.window.pixel_count();
        let tiles = |length: u32| u64::from(length.div_ceil(self.tile_size));
        let sums = self.film_layout().sum_count();
        let words = u64::from(self.splat_samples.is_some())
            + self.layers.len() as u64
            + 4 * u64::from(self.has_counts)
            + 4 * u64::from(self.has_allocation);
        let words = sums.saturating_add(words.saturating_mul(pixels));
        let least = (8 * tiles(width) * tiles(height)).saturating_add(words.saturating_mul(4));
        if least > body_length {
            return Err(damaged(format!(
                "its header says {width} x {height} pixels, which take at least {least} bytes, but {body_length} follow"
            )));
        }
        Ok(())
    }

    /// Refuses ranges of samples and counts that no render has.
    fn check_samples(&self) -> Result<()> {
        let is_wrong = |[first, end]: &[u64; 2]| {
            first >= end || *end > MAX_SPP || !first.is_multiple_of(BATCHES)
        };
        let are_apart = self.done.windows(2).all(|pair| pair[0][1] < pair[1][0]);
        let mut ranges = self.done.iter().chain(&self.shard);
        let begins_elsewhere = match (self.shard, self.done.first()) {
            (Some([shard, _]), Some([first, _])) => shard != *first,
            _ => false,
        };
        if ranges.any(is_wrong) || !are_apart || begins_elsewhere {
            return Err(damaged(format!(
                "its header has impossible ranges of samples: {}",
                describe(&self.done)
            )));
        }
        let RayCounts {
            camera,
            closest,
            shadow,
        } = self.rays;
        let mut counts = [camera, closest, shadow, self.rejected.count]
            .into_iter()
            .chain(self.splat_samples.into_iter().flatten());
        if counts.any(|count| count > MAX_COUNTED)
            || self.spp.is_some_and(|spp| spp > MAX_SPP)
            || self
                .equivalent_spp
                .is_some_and(|equivalent_spp| !(1.0..=1e18).contains(&equivalent_spp))
            || !(0.0..=MAX_SECONDS).contains(&self.seconds)
        {
            return Err(damaged(
                "its header has an impossible count of samples or rays, or an impossible time"
                    .to_owned(),
            ));
        }
        let may_have_counts = self.border_size == 0;
        let is_pilot = |pilot: &AdaptivePilot| {
            (1..=MAX_SPP).contains(&pilot.samples) && pilot.samples.is_multiple_of(BATCHES)
        };
        let is_adaptive = self.has_counts && may_have_counts;
        if (self.has_counts && !may_have_counts)
            || !self.pilot.iter().all(|it| is_adaptive && is_pilot(it))
            || (self.has_allocation && (self.pilot.is_none() || self.shard.is_some()))
        {
            return Err(damaged(
                "its header has an impossible distribution of samples over the pixels".to_owned(),
            ));
        }
        Ok(())
    }
}

/// The error for a file that is not as a render writes it.
pub fn damaged(what: String) -> Error {
    Error::new(ErrorKind::Io, format!("is a damaged state file: {what}"))
}
