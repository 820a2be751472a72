//! Counts the rays that leave closed meshes without a hit.
//!
//! Measure: segments.
//! Range: any number of segments; if cancelled, the report covers those traced so far. The same seed gives the same
//! counts on any number of threads.
//! Source: docs/bench.md. Tested in `lab/tests/bench/scenes.rs`.

use super::closed::{Aim, ClosedMesh};
use super::random::Random;
use super::report::LeakReport;
use super::target::BenchTarget;
use etendue::internals::accel::Accel;
use rayon::prelude::*;

/// Number of segments traced by a thread between two checks for cancellation.
const BLOCK: u64 = 1 << 16;

/// Traces segments out of a mesh on rayon's current threads, and counts those without a hit.
pub fn leaks(
    mesh: &ClosedMesh,
    aim: Aim,
    (target, accel): (BenchTarget, &Accel),
    segments: u64,
    seed: u64,
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> LeakReport {
    let block = |block: u64| {
        if is_cancelled() {
            return (0, 0);
        }
        let count = BLOCK.min(segments - block * BLOCK);
        let mut random = Random::new(seed, block);
        let leaked = (0..count).filter(|_| {
            let segment = mesh.segment(aim, &mut random);
            !accel.occluded(&segment, 0.0)
        });
        (count, leaked.count() as u64)
    };
    let add = |a: (u64, u64), b: (u64, u64)| (a.0 + b.0, a.1 + b.1);
    let blocks = (0..segments.div_ceil(BLOCK)).into_par_iter();
    let (traced, leaks) = blocks.map(block).reduce(|| (0, 0), add);
    LeakReport {
        mesh: mesh.name(),
        aim: aim.name().to_owned(),
        target,
        segments: traced,
        leaks,
    }
}
