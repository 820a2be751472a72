//! Measures the build time and the size of acceleration structures.
//!
//! Measure: seconds, bytes, nodes.
//! Range: at least one round. Targets are interleaved, so that disturbances of the machine affect all of them.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::meter::ProgressStage;
use super::report::BuildReport;
use super::target::BenchTarget;
use etendue::internals::accel::Accel;
use etendue::internals::geometry::world::World;
use etendue::internals::math::stats::Spread;
use etendue::{Error, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;
use std::time::Instant;

/// Starts a separate thread pool.
///
/// # Errors
/// If the system cannot start the threads.
pub fn pool(threads: usize) -> Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Error::render("cannot start the threads").because(error))
}

/// Builds one target on the threads of a pool.
///
/// # Errors
/// As [`Accel::build`].
pub fn build(world: &Arc<World>, target: BenchTarget, pool: &ThreadPool) -> Result<Accel> {
    let options = target.options(pool.current_num_threads());
    pool.install(|| Accel::build(Arc::clone(world), options))
}

/// Measures the builds of all targets on one thread and on all threads, identical builds only once; `None` if
/// cancelled.
///
/// # Errors
/// As [`Accel::build`].
pub fn builds(
    world: &Arc<World>,
    targets: &[BenchTarget],
    threads: usize,
    rounds: usize,
    stage: &ProgressStage<'_>,
) -> Result<Option<Vec<BuildReport>>> {
    let mut pools = vec![pool(1)?];
    if threads > 1 {
        pools.push(pool(threads)?);
    }
    let mut distinct: Vec<&BenchTarget> = vec![];
    for target in targets {
        if !distinct.iter().any(|known| known.builds_like(*target)) {
            distinct.push(target);
        }
    }
    let pairs = distinct
        .into_iter()
        .flat_map(|t| pools.iter().map(move |p| (t, p)));
    let pairs: Vec<(&BenchTarget, &ThreadPool)> = pairs.collect();
    let mut outcomes: Vec<Vec<BuildCost>> = vec![vec![]; pairs.len()];
    let all = (rounds * pairs.len()) as f64;
    for round in 0..rounds {
        for (index, (target, pool)) in pairs.iter().enumerate() {
            let start = Instant::now();
            let accel = build(world, **target, pool)?;
            outcomes[index].push(BuildCost {
                seconds: start.elapsed().as_secs_f64(),
                bytes: accel.memory(),
                nodes: accel.nodes(),
            });
            drop(accel);
            if !stage.advance((round * pairs.len() + index + 1) as f64 / all) {
                return Ok(None);
            }
        }
    }
    let reports = pairs.iter().zip(outcomes);
    let reports = reports.map(|((target, pool), outcomes)| report(**target, pool, &outcomes));
    Ok(Some(reports.collect()))
}

#[derive(Debug, Clone, Copy)]
struct BuildCost {
    seconds: f64,
    bytes: usize,
    nodes: Option<usize>,
}

fn report(target: BenchTarget, pool: &ThreadPool, outcomes: &[BuildCost]) -> BuildReport {
    let last = outcomes.last().expect("there is at least one round");
    BuildReport {
        target,
        threads: pool.current_num_threads(),
        seconds: Spread::of(outcomes.iter().map(|o| o.seconds).collect()),
        bytes: last.bytes,
        nodes: last.nodes,
    }
}
