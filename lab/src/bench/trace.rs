//! Times the recorded rays, traced again in every way.
//!
//! All threads trace at the same time, each its own range of the rays, in blocks that are first copied into a buffer,
//! as if a kernel had just generated them there. The time of copying alone is measured in the same way and subtracted.
//!
//! Measure: nanoseconds of one core a ray: the time in which threads were busy, over the rays.
//! Range: at least one ray and one round. Ways are interleaved, so that disturbances of the machine affect all of them;
//! a first round fills the caches and is discarded. A way that is not slower than copying takes 0.
//! Source: none needed. Tested in `lab/tests/bench/report.rs`.

use super::meter::ProgressStage;
use super::obvhs_itself::ObvhsTree;
use etendue::internals::accel::Accel;
use etendue::internals::accel::batch::{HitBatch, Packets, RayBatch};
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::math::stats::Spread;
use rayon::ThreadPool;
use std::hint::black_box;
use std::ops::Range;
use std::sync::Barrier;
use std::time::Instant;

/// Number of rays in a block: with their hits, they fit into a core's L2 cache.
const BLOCK: usize = 1024;

/// A way of tracing.
#[derive(Clone, Copy)]
pub enum TraceMode<'a> {
    /// Through an acceleration structure of the renderer, in these packets.
    Accel(&'a Accel, Packets),
    /// Through a tree of obvhs, by its own loops.
    ObvhsItself(&'a ObvhsTree),
}

/// Times all ways of tracing the rays of one kind: nanoseconds a ray of each; `None` if cancelled.
pub fn trace(
    modes: &[TraceMode<'_>],
    kind: RayKind,
    rays: &RayBatch,
    rounds: usize,
    pool: &ThreadPool,
    stage: &ProgressStage<'_>,
) -> Option<Vec<Spread>> {
    let mut copying = vec![];
    let mut tracing: Vec<Vec<f64>> = vec![vec![]; modes.len()];
    for round in 0..=rounds {
        let copy = nanoseconds_per_ray(pool, rays, |block| {
            black_box(&block.rays);
        });
        let times = modes.iter().map(|mode| time(mode, kind, rays, pool));
        let times: Vec<f64> = times.collect();
        if round > 0 {
            copying.push(copy);
            for (all, time) in tracing.iter_mut().zip(times) {
                all.push(time);
            }
        }
        if !stage.advance((round + 1) as f64 / (rounds + 1) as f64) {
            return None;
        }
    }
    let copying = Spread::of(copying).median;
    let spread = |times: Vec<f64>| {
        let without_copying = times.iter().map(|time| (time - copying).max(0.0));
        Spread::of(without_copying.collect())
    };
    Some(tracing.into_iter().map(spread).collect())
}

fn time(mode: &TraceMode<'_>, kind: RayKind, rays: &RayBatch, pool: &ThreadPool) -> f64 {
    match (*mode, kind) {
        (TraceMode::Accel(accel, packets), RayKind::Shadow) => {
            nanoseconds_per_ray(pool, rays, |block| {
                accel.occluded_batch(&block.rays, packets, &mut block.occluded);
                black_box(&block.occluded);
            })
        }
        (TraceMode::Accel(accel, packets), _) => nanoseconds_per_ray(pool, rays, |block| {
            accel.intersect_batch(&block.rays, packets, &mut block.hits);
            black_box(&block.hits);
        }),
        (TraceMode::ObvhsItself(tree), RayKind::Shadow) => {
            nanoseconds_per_ray(pool, rays, |block| {
                for index in 0..block.rays.len() {
                    black_box(tree.is_occluded(&block.rays.get(index).0));
                }
            })
        }
        (TraceMode::ObvhsItself(tree), _) => nanoseconds_per_ray(pool, rays, |block| {
            for index in 0..block.rays.len() {
                black_box(tree.closest(&block.rays.get(index).0));
            }
        }),
    }
}

/// The buffers of a thread.
#[derive(Default)]
struct RayBuffers {
    rays: RayBatch,
    hits: HitBatch,
    occluded: Vec<bool>,
}

impl RayBuffers {
    fn load(&mut self, rays: &RayBatch, range: Range<usize>) {
        self.rays.clear();
        self.rays.append(rays, range);
    }
}

/// The time per ray of `work` on every block of the rays, by all threads of a pool at once.
fn nanoseconds_per_ray(
    pool: &ThreadPool,
    rays: &RayBatch,
    work: impl Fn(&mut RayBuffers) + Sync,
) -> f64 {
    let start = Barrier::new(pool.current_num_threads());
    let busy = pool.broadcast(|thread| {
        let stretch = stretch(rays.len(), thread.index(), thread.num_threads());
        let blocks = stretch.clone().step_by(BLOCK);
        let blocks = blocks.map(|first| first..stretch.end.min(first + BLOCK));
        let mut block = RayBuffers::default();
        // One block beforehand allocates the memory.
        if let Some(range) = blocks.clone().next() {
            block.load(rays, range);
            work(&mut block);
        }
        start.wait();
        let begin = Instant::now();
        for range in blocks {
            block.load(rays, range);
            work(&mut block);
        }
        begin.elapsed().as_secs_f64()
    });
    busy.iter().sum::<f64>() * 1e9 / rays.len() as f64
}

/// The range of `count` items assigned to one of several threads.
fn stretch(count: usize, thread: usize, threads: usize) -> Range<usize> {
    count * thread / threads..count * (thread + 1) / threads
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::math::ray::Ray;
    use etendue::internals::math::vec::Vec3;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn every_ray_is_traced_once_plus_one_warmup_block_per_thread() {
        let mut rays = RayBatch::default();
        for i in 0..5000_u16 {
            rays.push(&Ray::new(Vec3::splat(f32::from(i)), Vec3::X), 0.0);
        }
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().expect("threads");
            let sum = AtomicU64::new(0);
            nanoseconds_per_ray(&pool, &rays, |block| {
                let x = block.rays.origin[0].iter().map(|&x| x as u64);
                sum.fetch_add(x.sum(), Ordering::Relaxed);
            });
            let beforehand = (0..threads).map(|thread| {
                let stretch = stretch(5000, thread, threads);
                (stretch.start as u64..).take(BLOCK).sum::<u64>()
            });
            let want = 4999 * 5000 / 2 + beforehand.sum::<u64>();
            assert_eq!(sum.into_inner(), want, "{threads} threads");
        }
    }
}
