//! Merging: the sums of shards, added one file after the other.
//!
//! The headers of all files are compared before the first sum is added. Then each file is read whole, its checksum
//! compared, and its sums added: the memory is that of one film and one file, for any number of files.
//!
//! Measure: sample indices.
//! Range: files of one render, no sample of which is in two of them. Gaps are for the caller to judge.
//! Source: none needed. Tested in `tests/rendering/state.rs` and `cli/tests/command/shards.rs`.

use super::header::Header;
use super::ranges::{describe, joined, missing};
use super::{State, body, file};
use crate::error::{Error, Result};
use crate::render::CONFIDENCE;
use crate::render::convergence::Look;
use std::path::{Path, PathBuf};

/// The error is looked at when one part in this many of the samples is merged.
const APART: u64 = 4;

/// The files of a render, which belong together.
#[derive(Debug)]
pub struct Merge {
    /// Each file with its header, in the order of their samples.
    parts: Vec<(PathBuf, Header)>,
}

impl Merge {
    /// Reads the headers of the files, and checks that their sums may be added.
    ///
    /// # Errors
    /// A file that cannot be read or is not a state file; two files of different scenes, settings or versions, or with
    /// the same samples; an interrupted render; no file, or none with samples.
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
        let (done, spp) = (self.done(), self.spp());
        let (_, first) = &self.parts[0];
        let mut sum = State {
            film: first.empty_film()?,
            header: Header {
                spp: Some(spp),
                shard: None,
                done,
                seconds: 0.0,
                rays: Default::default(),
                rejected: Default::default(),
                looks: vec![],
                planner: None,
                paths: first.paths.map(|_| Default::default()),
                layers: vec![],
                ..first.clone()
            },
            layers: vec![],
        };
        let total = sum.header.samples();
        let mut merged = 0;
        for (path, header) in &self.parts {
            let next = merged + header.samples();
            // A look at the error on the way tells how it falls.
            if merged > 0 && APART * merged <= total && APART * next > total {
                let error = sum.film.error(CONFIDENCE);
                let look = error.map(|error| Look::new(merged as f64, &error));
                sum.header.looks.extend(look);
            }
            sum.add(path, header)?;
            merged = next;
        }
        Ok(sum)
    }
}

impl State {
    /// Adds the sums of a file with this header.
    fn add(&mut self, path: &Path, expected: &Header) -> Result<()> {
        let bytes = file::read_bytes(path)?;
        let in_file = |error: Error| error.in_file(path);
        let (header, body) = file::checked(&bytes).map_err(in_file)?;
        if header != *expected {
            return Err(in_file(Error::usage(
                "was replaced by another file while it was merged",
            )));
        }
        let layers = body::add_to(&header, body, &mut self.film).map_err(in_file)?;
        let total = &mut self.header;
        total.seconds += header.seconds;
        total.rays += header.rays;
        total.rejected.merge(header.rejected);
        for (sum, paths) in total
            .paths
            .iter_mut()
            .flatten()
            .zip(header.paths.into_iter().flatten())
        {
            *sum += paths;
        }
        if !layers.is_empty() {
            total.layers = header.layers;
            self.layers = layers;
        }
        Ok(())
    }
}

/// The ranges of samples of all files, with the place of each file in the list.
fn ranges(parts: &[(PathBuf, Header)]) -> Vec<([u64; 2], usize)> {
    let of_part = |(place, (_, header)): (usize, &(PathBuf, Header))| {
        let done = header.done.clone();
        done.into_iter().map(move |range| (range, place))
    };
    parts.iter().enumerate().flat_map(of_part).collect()
}

/// Refuses two files of different renders.
fn check_same(first: &Path, a: &Header, other: &Path, b: &Header) -> Result<()> {
    let [ours, theirs] = [first, other].map(|path| path.display().to_string());
    let mut differences = a.identity.differences(&b.identity, &ours, &theirs);
    let sums = |header: &Header| (header.tile_size, header.reach, header.paths.is_some());
    if sums(a) != sums(b) {
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
fn check_apart(parts: &[(PathBuf, Header)]) -> Result<()> {
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
