//! Compares the hits of all targets on the rays of a scene.
//!
//! One half of the rays are recorded ones, with equal numbers of each kind as far as enough were recorded; the rest are
//! random rays through the scene's bounding box.
//!
//! Measure: rays.
//! Range: any number of rays. The same settings give the same counts on any number of threads.
//! Source: docs/bench.md. Tested in `lab/tests/bench/report.rs`.

use super::agreement::compare;
use super::meter::ProgressStage;
use super::rays::random_rays;
use super::record::Recording;
use super::report::AgreementReport;
use super::target::BenchTarget;
use etendue::internals::accel::Accel;
use etendue::internals::accel::batch::RayBatch;
use etendue::internals::geometry::world::World;
use etendue::internals::integrator::observer::RayKind;
use rayon::ThreadPool;

/// Number of random rays compared between two checks for cancellation.
const BATCH: usize = 1 << 16;

/// Compares `count` rays of each target with those of the first one; `None` if cancelled.
pub fn compare_all(
    world: &World,
    targets: &[(BenchTarget, &Accel)],
    recording: &Recording,
    count: usize,
    pool: &ThreadPool,
    stage: &ProgressStage<'_>,
) -> Option<Vec<AgreementReport>> {
    let Some((&reference, others)) = targets.split_first().filter(|_| count > 0) else {
        return Some(vec![]);
    };
    let new = |target: &(BenchTarget, &Accel)| AgreementReport::new(target.0, reference.0);
    let mut reports: Vec<AgreementReport> = others.iter().map(new).collect();
    let mut compared = 0;
    let mut compare_batch = |rays: &RayBatch, kind: RayKind| {
        let is_shadow = kind == RayKind::Shadow;
        for (&target, report) in others.iter().zip(&mut reports) {
            pool.install(|| compare(world, target, reference, rays, is_shadow, report));
        }
        compared += rays.len();
        stage
            .advance(compared as f64 / count as f64)
            .then_some(compared)
    };
    let of_each = count / 2 / RayKind::ALL.len();
    let mut done = 0;
    for kind in recording.kinds() {
        let recorded = recording.rays(kind);
        let mut rays = RayBatch::default();
        rays.append(recorded, 0..recorded.len().min(of_each));
        done = compare_batch(&rays, kind)?;
    }
    for seed in 0.. {
        if done >= count {
            break;
        }
        let rays = random_rays(world, BATCH.min(count - done), seed);
        done = compare_batch(&rays, RayKind::Camera)?;
    }
    Some(reports)
}
