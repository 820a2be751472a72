//! Shards: the ranges of sample indices that a render is divided into.
//!
//! Batches are taken in turn by the samples of a pixel. So that any set of shards has equally many samples in each batch,
//! shards begin at multiples of the number of batches; the last one may end anywhere. Of an adaptive render the samples after
//! its pilot are divided.
//!
//! Measure: sample indices, samples per pixel.
//! Range: a render of a known number of samples; as many shards as it has rounds of batches, or fewer.
//! Source: none needed. Tested below and in `tests/rendering/state.rs`.

use crate::error::{Error, Result};
use crate::film::batches::BATCHES;
use std::ops::Range;

/// A part of a render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shard {
    /// One of several shards, counted from 0.
    Part {
        /// The shard.
        index: u64,
        /// The number of shards.
        of: u64,
    },
    /// The samples from one index up to but not including another.
    Samples {
        /// The first sample.
        first: u64,
        /// The sample after the last.
        end: u64,
    },
}

impl Shard {
    /// The sample indices of this shard of a render of `spp` samples per pixel.
    ///
    /// # Errors
    /// A shard that is not a part of that render.
    pub fn samples(self, spp: u64) -> Result<Range<u64>> {
        self.samples_after(0, spp)
    }

    /// The sample indices of this shard of the samples from `begin`, the end of a pilot, up to `spp`.
    ///
    /// # Errors
    /// A shard that is not a part of these samples.
    pub fn samples_after(self, begin: u64, spp: u64) -> Result<Range<u64>> {
        match self {
            Self::Part { index, of } => {
                let rounds = spp.saturating_sub(begin).div_ceil(BATCHES);
                if index >= of {
                    return Err(Error::usage(format!(
                        "there is no shard {index}/{of}: shards are counted from 0, so that the last of them is {}/{of}",
                        of.saturating_sub(1)
                    )));
                }
                if of > rounds {
                    let samples = spp.saturating_sub(begin);
                    return Err(Error::usage(format!(
                        "{samples} samples per pixel cannot be divided into {of} shards: each has at least {BATCHES} samples, so that there are at most {rounds}"
                    )));
                }
                let start = |index: u64| {
                    let round = u128::from(index) * u128::from(rounds) / u128::from(of);
                    (begin + BATCHES * round as u64).min(spp)
                };
                Ok(start(index)..start(index + 1))
            }
            Self::Samples { first, end } => {
                if first < begin || first >= end || end > spp {
                    return Err(Error::usage(format!(
                        "samples {first}..{end} are not a part of those from {begin} to {spp}, of which the last is not one: expected the first sample and the one after the last"
                    )));
                }
                if !first.is_multiple_of(BATCHES) || !(end.is_multiple_of(BATCHES) || end == spp) {
                    return Err(Error::usage(format!(
                        "samples {first}..{end} do not begin and end at multiples of {BATCHES}, so that error bars could not be estimated"
                    )));
                }
                Ok(first..end)
            }
        }
    }
}

/// The ranges from 0 to `end` that are in none of `done`, which are in order.
pub fn missing(done: &[[u64; 2]], end: u64) -> Vec<[u64; 2]> {
    let starts = std::iter::once(0).chain(done.iter().map(|range| range[1]));
    let ends = done.iter().map(|range| range[0]).chain([end]);
    let gaps = starts.zip(ends).filter(|(start, end)| start < end);
    gaps.map(|(start, end)| [start, end]).collect()
}

/// The union of ranges that are in order and do not overlap.
pub(super) fn joined(ranges: impl IntoIterator<Item = [u64; 2]>) -> Vec<[u64; 2]> {
    let mut all: Vec<[u64; 2]> = vec![];
    for range in ranges {
        match all.last_mut() {
            Some(last) if last[1] == range[0] => last[1] = range[1],
            _ => all.push(range),
        }
    }
    all
}

/// Ranges in words: `0..16, 32..48`; of many, the first few and their number.
pub fn describe(ranges: &[[u64; 2]]) -> String {
    const SHOWN: usize = 10;
    let shown = ranges.iter().take(SHOWN);
    let mut words: Vec<String> = shown.map(|[a, b]| format!("{a}..{b}")).collect();
    if ranges.len() > SHOWN {
        words.push(format!("and {} more", ranges.len() - SHOWN));
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_cover_every_sample_once() {
        for spp in [4_u64, 7, 64, 1000, 1 << 46] {
            for of in [1, 2, 7, 64, spp.div_ceil(4)] {
                if of > spp.div_ceil(4) || of > 1000 {
                    continue;
                }
                let mut next = 0;
                for index in 0..of {
                    let shard = Shard::Part { index, of }.samples(spp).expect("a part");
                    assert_eq!(shard.start, next);
                    assert!(shard.end > shard.start);
                    assert_eq!(
                        Shard::Samples {
                            first: shard.start,
                            end: shard.end
                        }
                        .samples(spp)
                        .ok(),
                        Some(shard.clone())
                    );
                    next = shard.end;
                }
                assert_eq!(next, spp);
            }
        }
    }

    #[test]
    fn shards_after_a_pilot_cover_every_other_sample_once() {
        for of in [1, 2, 7, 240] {
            let mut next = 64;
            for index in 0..of {
                let shard = Shard::Part { index, of }.samples_after(64, 1024);
                let shard = shard.expect("a part");
                assert_eq!(shard.start, next);
                next = shard.end;
            }
            assert_eq!(next, 1024);
        }
        let after = |shard: Shard| shard.samples_after(64, 1024);
        assert!(after(Shard::Part { index: 0, of: 241 }).is_err());
        assert!(after(Shard::Samples { first: 60, end: 80 }).is_err());
        assert!(after(Shard::Samples { first: 64, end: 80 }).is_ok());
        assert!(
            Shard::Part { index: 0, of: 1 }
                .samples_after(64, 64)
                .is_err()
        );
    }

    #[test]
    fn invalid_shards_are_rejected() {
        let part = |index, of| Shard::Part { index, of }.samples(16);
        let range = |first, end| Shard::Samples { first, end }.samples(16);
        for refused in [
            part(4, 4),
            part(0, 5),
            part(0, 0),
            range(0, 20),
            range(8, 8),
            range(2, 8),
            range(4, 7),
        ] {
            assert!(refused.is_err(), "{refused:?}");
        }
    }

    #[test]
    fn missing_ranges_are_the_uncovered_gaps() {
        assert_eq!(missing(&[], 8), [[0, 8]]);
        assert_eq!(missing(&[[0, 8]], 8), [[0_u64; 2]; 0]);
        assert_eq!(
            missing(&[[4, 8], [12, 16]], 20),
            [[0, 4], [8, 12], [16, 20]]
        );
        assert_eq!(joined([[0, 4], [4, 8], [12, 16]]), [[0, 8], [12, 16]]);
        assert_eq!(describe(&[[0, 4], [8, 12]]), "0..4, 8..12");
    }
}
