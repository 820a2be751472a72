//! State files (`.etd`): the samples of a render so far, to continue it, or to merge it with the samples that other
//! machines took.
//!
//! A file has these parts, in little-endian order:
//!
//! | bytes | contents |
//! |---|---|
//! | 8 | `ETDSTATE` |
//! | 4 | the number of the format, [`FORMAT`] |
//! | 4 | the length of the header |
//! | | the header, as JSON: [`StateHeader`] |
//! | 8 a tile | the sample count of each tile of the film |
//! | 16 a pixel | the counts of samples and of rays of each pixel, tile by tile, of an adaptive render |
//! | 4 to 196 a pixel | the sums of each pixel, tile by tile: 24 bits that tell which doubles are not 0, and these; 4 to 260 for each pixel of a tile and its halo where samples contribute to several pixels |
//! | 4 to 196 a pixel | the splat sums of each pixel, row by row, if the integrator splats |
//! | 4 a pixel and layer | layers of the first hits, row by row, in the file with the render's first sample |
//! | 16 a pixel | the allocation of an adaptive render that is no shard: each pixel's variance and its share of the samples |
//! | 32 | BLAKE3 of all bytes before |
//!
//! A file is written under a temporary name, brought to the disk, and renamed.
//!
//! Measure: as in [`StateHeader`]; sums as in `film/pixel.rs`.
//! Range: a file that was cut or changed is an error that names the byte or the checksum. Sums of different scenes,
//! settings or versions are never added. Of adaptive renders, there are states of the pilot, and of samples that it
//! distributed; of greedy ones there are none, as their counts depend on passes.
//! Source: our own format. Tested in `tests/rendering/state.rs`, `tests/fuzz_corpus.rs` and `cli/tests/command/shards.rs`.

mod body;
pub mod cache_file;
mod file;
mod fingerprint;
mod header;
mod merge;
mod pieces;
mod ranges;

use crate::error::{Error, Result};
use crate::film::batches::BATCHES;
use crate::film::{ErrorEstimate, Film};
use crate::image::Layer;
use crate::image::atomic::ExistingFile;
use crate::render::adaptive::allocation::Allocation;
use crate::render::convergence::{ErrorRecord, Forecast, without_bound_if_rising};
use crate::render::settings::SamplerKind;
use crate::render::{Rendered, check_found_light};
use body::Body;
pub use file::{FORMAT, is_damaged, read_header, with_checksum};
pub use fingerprint::{Fingerprint, fingerprint};
pub use header::{AdaptivePilot, StateHeader};
pub use merge::Merge;
pub use ranges::{Shard, describe, missing};
use std::path::Path;
use std::sync::Arc;

/// The samples of a render so far.
#[derive(Debug, Clone)]
pub struct State {
    /// The facts about the render.
    pub header: StateHeader,
    /// The sums of all pixels.
    pub film: Film,
    /// The layers of the first hits; only with the render's first sample.
    pub layers: Vec<Layer>,
    /// The allocation of samples to the pixels of an adaptive render that is no shard, once its pilot is complete.
    pub allocation: Option<Arc<Allocation>>,
}

impl State {
    /// Checks that the Markov chains of a whole render found light.
    ///
    /// # Errors
    /// A render by Markov chains that is black.
    pub fn check_is_lit(&self) -> Result<()> {
        check_found_light(self.header.identity.name("integrator"), &self.film)
    }

    /// The estimated error of the samples, with an upper bound of this confidence; `None` if it cannot be estimated.
    pub fn error(&self, confidence: f64) -> Option<ErrorEstimate> {
        let error = self.film.error(confidence)?;
        Some(without_bound_if_rising(
            error,
            self.even_spp(),
            &self.header.error_records,
        ))
    }

    /// The samples per pixel, distributed evenly, that have this error.
    fn even_spp(&self) -> f64 {
        let samples = self.header.samples() as f64;
        self.header.equivalent_spp.unwrap_or(samples)
    }

    /// The samples per pixel of a render whose error is at most `target` with this confidence, by the error so far; `None`
    /// if the error is unknown or in doubt, or if the allocation of an adaptive render is not known.
    pub fn needed_spp(&self, target: f64, confidence: f64) -> Option<u64> {
        let error = self
            .error(confidence)
            .filter(|error| error.doubt.is_none())?;
        let allocation = self.allocation.as_ref();
        if self.header.pilot.is_some() && allocation.is_none() {
            return None;
        }
        let samples = self.even_spp();
        let mut error_records = self.header.error_records.clone();
        error_records.retain(|record| record.samples < samples);
        error_records.push(ErrorRecord::new(samples, &error));
        let pixels = self.header.window.pixel_count();
        let is_sobol = self.header.identity.name("sampler") == SamplerKind::Sobol.name();
        let in_steps = is_sobol && allocation.is_none();
        let forecast = Forecast::new(&error_records, pixels, confidence, in_steps)?;
        let needed = forecast.samples_for(target);
        let needed = allocation.map_or(needed, |it| it.level_of(needed));
        let needed = needed.ceil().min(1e18) as u64;
        Some(needed.next_multiple_of(BATCHES))
    }

    /// Lets a render that has no samples continue from this state.
    ///
    /// # Errors
    /// Samples with gaps, which are not those of one render.
    pub fn continue_in(self, rendered: &mut Rendered) -> Result<()> {
        let (header, allocation) = (self.header, self.allocation);
        let [first, end] = match header.done.as_slice() {
            [] => [header.shard.map_or(0, |[first, _]| first); 2],
            [done] => *done,
            several => {
                return Err(Error::usage(format!(
                    "samples are missing between {}: such sums can be merged, not continued",
                    describe(several)
                )));
            }
        };
        if header.shard.is_none() && first > 0 {
            return Err(Error::usage(format!(
                "samples 0..{first} are missing: such sums can be merged, not continued"
            )));
        }
        rendered.film = self.film;
        rendered.allocation = allocation.or(rendered.allocation.take());
        (rendered.first, rendered.spp) = (first, end - first);
        (rendered.equivalent_spp, rendered.is_uneven) = (header.equivalent_spp, header.is_uneven);
        let elapsed = std::time::Duration::try_from_secs_f64(header.seconds);
        rendered.elapsed = elapsed.unwrap_or_default();
        (rendered.rays, rendered.rejected) = (header.rays, header.rejected);
        (rendered.error_records, rendered.planner) = (header.error_records, header.planner);
        Ok(())
    }

    /// Writes the state to a file, whole or not at all.
    ///
    /// # Errors
    /// A file that cannot be written; one that was there before is then unchanged.
    pub fn write(&self, path: &Path) -> Result<()> {
        let allocation = self.allocation.as_deref();
        let Self {
            header,
            film,
            layers,
            ..
        } = self;
        Self::write_parts(
            header,
            film,
            layers,
            allocation,
            path,
            ExistingFile::Replace,
        )
    }

    /// Writes the parts of a state to a file, as [`Self::write`] does, or fails where `existing` keeps one that is there.
    ///
    /// # Errors
    /// The errors of [`Self::write`].
    pub fn write_parts(
        header: &StateHeader,
        film: &Film,
        layers: &[Layer],
        allocation: Option<&Allocation>,
        path: &Path,
        existing: ExistingFile,
    ) -> Result<()> {
        let allocation = allocation.filter(|_| header.has_allocation);
        file::write(header, film, layers, allocation, path, existing)
    }

    /// Reads a state file.
    ///
    /// # Errors
    /// A file that cannot be read, is not a state file, or is damaged; too little memory for its image.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = file::read_bytes(path)?;
        Self::decode(&bytes).map_err(|error| error.in_file(path))
    }

    /// Decodes the bytes of a state file.
    ///
    /// # Errors
    /// The errors of [`Self::read`].
    pub fn decode(bytes: &[u8]) -> Result<Self> {
        let (header, body) = file::checked(bytes)?;
        let mut film = header.empty_film()?;
        let body::BesideSums { layers, allocation } =
            body::add_to(&header, Body::of(body), &mut film)?;
        Ok(Self {
            header,
            film,
            layers,
            allocation: allocation.map(Arc::new),
        })
    }
}
