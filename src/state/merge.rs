//! Merging: the sums of shards, added one file after the other.
//!
//! The headers of all files are compared before the first sum is added. Then the sums of each file are added while the file,
//! and the next one, is read: the memory is that of one film and a few pieces of files, for any number of files of any size.
//! The checksum of a file is known only when its sums are added; one that is wrong is an error of the whole merge.
//!
//! The files of an adaptive render have ranges of levels (`render/adaptive/allocation.rs`). Once its pilot is merged, the
//! allocation follows from the sums, and has to be that of the other files.
//!
//! Measure: sample indices.
//! Range: files of one render, no sample of which is in two of them; one of them may end within a round of batches. Gaps
//! are for the caller to judge.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `cli/tests/command/shards.rs`.

use super::State;
use super::body::{self, Body};
use super::file;
use super::header::{AdaptivePilot, StateHeader};
use super::pieces::FilesAhead;
use super::ranges::{describe, joined, missing};
use crate::error::{Error, Result};
use crate::film::batches::BATCHES;
use crate::render::CONFIDENCE;
use crate::render::adaptive::allocation::Allocation;
use crate::render::convergence::ErrorRecord;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, Scope};

/// The error is recorded when one part in this many of the samples is merged.
const RECORD_DIVISOR: u64 = 4;

/// The files of a render, which belong together.
#[derive(Debug)]
pub struct Merge {
    /// Each file with its header, in the order of their samples.
    parts: Vec<(PathBuf, StateHeader)>,
}

impl Merge {
    /// Reads the headers of the files, and checks that their sums may be added.
    ///
    /// # Errors
    /// A file that cannot be read or is not a state file; two files of different scenes, settings or versions, or with
    /// the same samples; two files that end within a round of batches; an interrupted render; no file, or none with
    /// samples.
    pub fn of(files: &[PathBuf]) -> Result<Self> {
        let mut parts = vec![];
        for file in files {
            let header = file::read_header(file)?;
            if header.is_uneven {
                return Err(Error::usage(
                    "was interrupted within a pass, so that some pixels have more samples than others: continue it by `etendue render --resume`",
                )
                .in_file(file));
            }
            // A shard that was interrupted before its first pass has nothing to add.
            if !header.done.is_empty() {
                parts.push((file.clone(), header));
            }
        }
        let Some((first, its_header)) = parts.first() else {
            return Err(Error::usage("there is no state file with samples to merge"));
        };
        for (other, header) in &parts[1..] {
            check_same(first, its_header, other, header)?;
        }
        check_apart(&parts)?;
        check_rounds(&parts)?;
        check_pilots(&parts)?;
        parts.sort_by_key(|(_, header)| header.done[0]);
        Ok(Self { parts })
    }

    /// The ranges of samples in the files.
    pub fn done(&self) -> Vec<[u64; 2]> {
        let mut all = ranges(&self.parts);
        all.sort_unstable();
        joined(all.into_iter().map(|(range, _)| range))
    }

    /// The samples per pixel of the whole render: as far as any of the files knows.
    pub fn spp(&self) -> u64 {
        let known = self.parts.iter().filter_map(|(_, header)| header.spp);
        let last = self.done().last().map_or(0, |range| range[1]);
        known.max().unwrap_or(0).max(last)
    }

    /// The ranges of samples of the whole render that are in none of the files.
    pub fn missing(&self) -> Vec<[u64; 2]> {
        missing(&self.done(), self.spp())
    }

    /// Adds the sums of all files.
    ///
    /// # Errors
    /// A damaged file, and too little memory.
    pub fn sum(self) -> Result<State> {
        thread::scope(|scope| self.sum_in(scope))
    }

    /// Adds the sums of all files, which a thread of the scope reads.
    fn sum_in<'scope>(&'scope self, scope: &'scope Scope<'scope, '_>) -> Result<State> {
        let (done, spp) = (self.done(), self.spp());
        let (_, first) = &self.parts[0];
        let is_alone = self.parts.len() == 1;
        let mut sum = State {
            film: first.empty_film()?,
            header: StateHeader {
                spp: Some(spp),
                shard: None,
                done,
                seconds: 0.0,
                rays: Default::default(),
                rejected: Default::default(),
                wants_layers: self.parts.iter().any(|(_, header)| header.wants_layers),
                // Records of the first samples are records of the whole.
                error_records: match first.done[0][0] {
                    0 => first.error_records.clone(),
                    _ => vec![],
                },
                planner: None,
                splat_samples: first.splat_samples.map(|_| Default::default()),
                layers: vec![],
                pilot: self.parts.iter().find_map(|(_, it)| it.pilot.clone()),
                equivalent_spp: first.equivalent_spp.filter(|_| is_alone),
                ..first.clone()
            },
            layers: vec![],
            allocation: None,
        };
        let total = sum.header.samples();
        let mut merged = 0;
        let mut files = FilesAhead::new(scope, self.parts.iter().map(|(path, _)| path.as_path()));
        for (place, (path, header)) in self.parts.iter().enumerate() {
            let then = merged + header.samples();
            // A record on the way tells how the error falls.
            if merged > 0 && RECORD_DIVISOR * merged <= total && RECORD_DIVISOR * then > total {
                let error = sum.film.error(CONFIDENCE);
                let equivalent_spp = sum.equivalent_spp_of(merged);
                sum.header
                    .error_records
                    .retain(|record| record.samples < equivalent_spp);
                let error_record = error.map(|error| ErrorRecord::new(equivalent_spp, &error));
                sum.header.error_records.extend(error_record);
            }
            if let Some(pilot) = &header.pilot
                && self.is_pilot_alone(place, pilot)
            {
                sum.allocate(pilot).map_err(|error| error.in_file(path))?;
            }
            sum.add(header, &mut files)
                .map_err(|error| error.in_file(path))?;
            merged = then;
        }
        sum.header.has_allocation = sum.allocation.is_some();
        if sum.allocation.is_some() {
            sum.header.equivalent_spp = Some(sum.equivalent_spp_of(total));
        }
        Ok(sum)
    }

    /// Whether the files before a place are the whole pilot of an adaptive render, and nothing else.
    fn is_pilot_alone(&self, place: usize, pilot: &AdaptivePilot) -> bool {
        let before = &self.parts[..place];
        let all = || {
            let mut all = ranges(before);
            all.sort_unstable();
            joined(all.into_iter().map(|(range, _)| range))
        };
        before.iter().all(|(_, it)| it.pilot.is_none()) && all() == [[0, pilot.samples]]
    }
}

impl State {
    /// The samples per pixel, distributed evenly, that those up to a level are equivalent to.
    fn equivalent_spp_of(&self, level: u64) -> f64 {
        let allocation = self.allocation.as_ref();
        allocation.map_or(level as f64, |it| it.equivalent_spp(level))
    }

    /// Computes the allocation of an adaptive render from the sums of its pilot.
    fn allocate(&mut self, pilot: &AdaptivePilot) -> Result<()> {
        let allocation = Allocation::by_pilot(&self.film, pilot.samples);
        if AdaptivePilot::of(&allocation) != *pilot {
            return Err(Error::usage(
                "has samples that were distributed by another pilot than the one that is merged with them",
            ));
        }
        self.allocation = Some(Arc::new(allocation));
        Ok(())
    }

    /// Adds the sums of a file with this header.
    fn add(&mut self, expected: &StateHeader, files: &mut FilesAhead) -> Result<()> {
        let (header, length) = files.header()?;
        if header != *expected {
            return Err(Error::usage(
                "was replaced by another file while it was merged",
            ));
        }
        let mut next_piece = || files.piece();
        let body = Body::in_pieces(&mut next_piece, length);
        let added = body::add_to(&header, body, &mut self.film);
        // Where a body cannot be right because the file was damaged, its checksum says so.
        while files.piece()?.is_some() {}
        let body::BesideSums { layers, allocation } = added?;
        self.allocation = allocation.map(Arc::new).or(self.allocation.take());
        let total = &mut self.header;
        total.seconds += header.seconds;
        total.rays = total.rays.saturating_add(header.rays);
        total.rejected.merge(header.rejected);
        for (sum, samples) in total
            .splat_samples
            .iter_mut()
            .flatten()
            .zip(header.splat_samples.into_iter().flatten())
        {
            *sum = sum.saturating_add(samples);
        }
        if !layers.is_empty() {
            total.layers.clone_from(&header.layers);
            self.layers = layers;
        }
        Ok(())
    }
}

/// The ranges of samples of all files, with the place of each file in the list.
fn ranges(parts: &[(PathBuf, StateHeader)]) -> Vec<([u64; 2], usize)> {
    let of_part = |(place, (_, header)): (usize, &(PathBuf, StateHeader))| {
        let done = header.done.clone();
        done.into_iter().map(move |range| (range, place))
    };
    parts.iter().enumerate().flat_map(of_part).collect()
}

/// Refuses two files of different renders.
fn check_same(first: &Path, a: &StateHeader, other: &Path, b: &StateHeader) -> Result<()> {
    let [ours, theirs] = [first, other].map(|path| path.display().to_string());
    let mut differences = a.identity.differences(&b.identity, &ours, &theirs);
    if a.film_layout() != b.film_layout() {
        differences.push(format!("{ours} and {theirs} keep different sums"));
    }
    match differences.is_empty() {
        true => Ok(()),
        false => Err(Error::usage(format!(
            "cannot be merged with {ours}: {}",
            differences.join("; ")
        ))
        .in_file(other)),
    }
}

/// Refuses two files with the same samples.
fn check_apart(parts: &[(PathBuf, StateHeader)]) -> Result<()> {
    let mut all = ranges(parts);
    all.sort_unstable();
    let doubled = all.windows(2).filter(|pair| pair[1].0[0] < pair[0].0[1]);
    let words: Vec<String> = doubled
        .map(|pair| {
            let [(a, of_a), (b, of_b)] = [pair[0], pair[1]];
            format!(
                "{} in {} and {}",
                describe(&[[b[0], a[1].min(b[1])]]),
                parts[of_a].0.display(),
                parts[of_b].0.display()
            )
        })
        .collect();
    match words.is_empty() {
        true => Ok(()),
        false => Err(Error::usage(format!(
            "these samples are doubled: {}",
            words.join("; ")
        ))),
    }
}

/// Refuses two ranges that end within a round of batches. The batches of their samples together would not have the
/// counts that follow from the number of samples.
fn check_rounds(parts: &[(PathBuf, StateHeader)]) -> Result<()> {
    let mut ragged = ranges(parts)
        .into_iter()
        .filter(|([first, end], _)| !(end - first).is_multiple_of(BATCHES));
    match (ragged.next(), ragged.next()) {
        (Some((_, a)), Some((_, b))) => Err(Error::usage(format!(
            "ends within a round of {BATCHES} samples, as does {}, so that error bars could not be estimated: continue one of them by `etendue render --resume`",
            parts[a].0.display()
        ))
        .in_file(&parts[b].0)),
        _ => Ok(()),
    }
}

/// Refuses files of adaptive renders whose samples were distributed by different pilots, or by none where there is one.
fn check_pilots(parts: &[(PathBuf, StateHeader)]) -> Result<()> {
    let with_pilot = |(path, header): &'_ (PathBuf, StateHeader)| {
        let pilot = header.pilot.clone()?;
        Some((path.clone(), pilot))
    };
    let Some((first, pilot)) = parts.iter().find_map(with_pilot) else {
        return Ok(());
    };
    for (path, header) in parts {
        let end = header.done.last().map_or(0, |range| range[1]);
        let wrong = match &header.pilot {
            Some(other) if *other != pilot => "were distributed by another pilot than its samples",
            None if end > pilot.samples => "go beyond its pilot",
            _ => continue,
        };
        return Err(Error::usage(format!(
            "cannot be merged with {}: its samples {wrong}",
            first.display()
        ))
        .in_file(path));
    }
    Ok(())
}
