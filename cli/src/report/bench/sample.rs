//! A hand-written report for tests.
//!
//! Measure: as in a report.
//! Range: two backends, two kinds of rays, every part.
//! Source: invented numbers.

use etendue::internals::accel::batch::Packets;
use etendue::internals::accel::{Backend, Precision, Quality};
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::math::stats::Spread;
use etendue_lab::bench::parts::SamplePart;
use etendue_lab::bench::report::{
    AgreementReport, BenchReport, BuildReport, LeakReport, Machine, ObvhsReport, OverheadReport,
    PartReport, RayCount, SceneReport, TraceReport,
};
use etendue_lab::bench::target::{BenchTarget, TracingMode};

/// Returns a structure of a backend.
pub fn target(backend: Backend) -> BenchTarget {
    BenchTarget {
        backend,
        precision: Precision::Fast,
        quality: Quality::High,
    }
}

/// Returns a time with a spread of a tenth to either side.
fn about(time: f64) -> Spread {
    Spread {
        median: time,
        min: 0.9 * time,
        max: 1.1 * time,
    }
}

/// Returns the result of rays that took `nanoseconds` each.
pub fn trace(kind: RayKind, backend: Backend, nanoseconds: f64) -> TraceReport {
    TraceReport {
        kind,
        variant: TracingMode {
            target: target(backend),
            packets: Packets::default(),
        },
        nanoseconds: about(nanoseconds),
    }
}

/// Returns a complete report: the second backend takes twice as long for camera rays, and half as long for shadow rays.
pub fn report() -> BenchReport {
    BenchReport {
        version: "1.2.3",
        machine: Machine {
            processor: "Abacus 9".to_owned(),
            processors: 2,
            system: "linux x86_64".to_owned(),
            embree: String::new(),
        },
        threads: 2,
        rounds: 9,
        build_rounds: 3,
        complete: true,
        scenes: vec![scene()],
        leaks: vec![LeakReport {
            mesh: "bumpy sphere".to_owned(),
            aim: "edges".to_owned(),
            target: target(Backend::ALL[1]),
            segments: 2_000_000,
            leaks: 3,
        }],
    }
}

fn scene() -> SceneReport {
    let [first, second] = [Backend::ALL[0], Backend::ALL[1]];
    let camera = trace(RayKind::Camera, first, 50.0);
    let slow = TraceReport {
        variant: TracingMode {
            target: BenchTarget {
                precision: Precision::Robust,
                ..target(first)
            },
            ..camera.variant
        },
        ..trace(RayKind::Camera, first, 80.0)
    };
    SceneReport {
        name: "a <box>".to_owned(),
        description: "a box with a lamp.".to_owned(),
        primitives: 1234,
        builds: vec![BuildReport {
            target: target(first),
            threads: 2,
            seconds: about(0.0123),
            bytes: 4_560_000,
            nodes: None,
        }],
        rays: [(RayKind::Camera, 1.0), (RayKind::Shadow, 2.5)]
            .map(|(kind, per_sample)| RayCount {
                kind,
                per_sample,
                recorded: 4096,
            })
            .to_vec(),
        traces: vec![
            slow,
            camera,
            trace(RayKind::Camera, second, 100.0),
            trace(RayKind::Shadow, first, 40.0),
            trace(RayKind::Shadow, second, 20.0),
        ],
        obvhs_itself: vec![ObvhsReport {
            kind: RayKind::Camera,
            layout: second,
            is_split: true,
            nanoseconds: about(80.0),
        }],
        agreement: vec![AgreementReport {
            target: target(second),
            reference: target(first),
            rays: 1000,
            identical: 990,
            ties: 6,
            edges: 3,
            real: 1,
            first_real: Some("origin 0 0 0, direction 0 0 1".to_owned()),
        }],
        overhead: Some(overhead(camera)),
    }
}

fn overhead(best: TraceReport) -> OverheadReport {
    let part = |part, nanoseconds| PartReport { part, nanoseconds };
    OverheadReport {
        target: best.variant.target,
        spp: 8,
        sample: about(600.0),
        sample_alone: about(500.0),
        floor: 150.0,
        best: vec![best],
        factor: about(4.0),
        parts: vec![
            part(SamplePart::ClosestHits.name(), 140.0),
            part("scattering", 250.0),
            part(SamplePart::ShadowRays.name(), 110.0),
        ],
        load: 0.5,
        build: 0.25,
    }
}
