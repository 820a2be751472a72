//! Numbers derived from a benchmark: the fastest configuration of each backend, and its ratio to the reference. A
//! backend with packets is listed twice, with and without packets, so that programs that trace single rays can be
//! compared, too.
//!
//! Measure: ratios of times to those of a reference, Embree if it was measured; below 1 is faster.
//! Range: `None` if a time is missing or was below the clock resolution.
//! Source: Fleming and Wallace 1986 (ratios are averaged by the geometric mean). Tested below.

use etendue::internals::accel::Backend;
use etendue::internals::accel::batch::PacketWidth;
use etendue::internals::integrator::observer::RayKind;
use etendue_lab::bench::report::{BenchReport, SceneReport, TraceReport};
use etendue_lab::bench::target::TracingMode;
use serde::{Serialize, Serializer};

/// A backend that is compared, with or without packets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contender {
    /// The backend that traces.
    pub backend: Backend,
    /// Whether packets are allowed; true also for backends without packets.
    pub packets: bool,
}

impl Contender {
    /// Returns the name in tables.
    pub fn name(self) -> String {
        let without = if self.packets { "" } else { " without packets" };
        format!("{}{without}", self.backend.name())
    }

    fn admits(self, trace: &TraceReport) -> bool {
        let is_single = trace.variant.packets.width == PacketWidth::One;
        trace.variant.target.backend == self.backend && (self.packets || is_single)
    }
}

impl Serialize for Contender {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

/// A contender in its fastest configuration for a kind of rays.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Fastest<'a> {
    /// The contender that traced.
    pub contender: Contender,
    /// The configuration, and its time.
    #[serde(flatten)]
    pub trace: &'a TraceReport,
    /// The time over that of the reference in the latter's own fastest configuration.
    pub times_reference: Option<f64>,
}

/// The average result of a contender.
#[derive(Debug, Clone, Serialize)]
pub struct Mean {
    /// The contender that traced.
    pub contender: Contender,
    /// The geometric mean of its times over those of the reference.
    pub times_reference: Option<f64>,
}

/// Returns the backends that traced rays, the reference first.
pub fn backends<'a>(scenes: impl IntoIterator<Item = &'a SceneReport>) -> Vec<Backend> {
    let traces: Vec<_> = scenes.into_iter().flat_map(|scene| &scene.traces).collect();
    let traced = |backend: &Backend| {
        let mut traces = traces.iter();
        traces.any(|trace| trace.variant.target.backend == *backend)
    };
    Backend::ALL.iter().copied().filter(traced).collect()
}

/// Returns all contenders, the reference first.
pub fn contenders<'a>(scenes: impl IntoIterator<Item = &'a SceneReport> + Copy) -> Vec<Contender> {
    let traces: Vec<_> = scenes.into_iter().flat_map(|scene| &scene.traces).collect();
    let mut contenders = Vec::new();
    for backend in backends(scenes) {
        contenders.push(Contender {
            backend,
            packets: true,
        });
        let has_packets = |trace: &TraceReport| {
            let TracingMode { target, packets } = trace.variant;
            target.backend == backend && packets.width > PacketWidth::One
        };
        if traces.iter().any(|trace| has_packets(trace)) {
            contenders.push(Contender {
                backend,
                packets: false,
            });
        }
    }
    contenders
}

/// Returns the name of the reference backend.
pub fn reference(report: &BenchReport) -> &'static str {
    let backends = backends(&report.scenes);
    backends
        .first()
        .map_or("the first", |backend| backend.name())
}

/// Returns the fastest result of each contender for each kind of rays.
pub fn fastest(scene: &SceneReport) -> Vec<Fastest<'_>> {
    let contenders = contenders([scene]);
    let mut all = Vec::new();
    for &kind in RayKind::ALL {
        let reference = contenders.first().and_then(|&c| fastest_of(scene, kind, c));
        for &contender in &contenders {
            let Some(trace) = fastest_of(scene, kind, contender) else {
                continue;
            };
            all.push(Fastest {
                contender,
                trace,
                times_reference: reference.and_then(|reference| ratio(trace, reference)),
            });
        }
    }
    all
}

/// Returns the result with the smallest median among the configurations of a contender.
fn fastest_of(scene: &SceneReport, kind: RayKind, contender: Contender) -> Option<&TraceReport> {
    let traces = scene.traces.iter();
    traces
        .filter(|trace| trace.kind == kind && contender.admits(trace))
        .min_by(|a, b| a.nanoseconds.median.total_cmp(&b.nanoseconds.median))
}

fn ratio(one: &TraceReport, other: &TraceReport) -> Option<f64> {
    let (one, other) = (one.nanoseconds.median, other.nanoseconds.median);
    (one > 0.0 && other > 0.0).then(|| one / other)
}

/// Returns the mean of each contender over the kinds of rays of a scene.
pub fn means(scene: &SceneReport) -> Vec<Mean> {
    let fastest = fastest(scene);
    let mean = |&contender: &Contender| {
        let own = fastest.iter().filter(|one| one.contender == contender);
        Mean {
            contender,
            times_reference: geometric_mean(own.map(|one| one.times_reference)),
        }
    };
    contenders([scene]).iter().map(mean).collect()
}

/// Returns the mean of each contender over all scenes, which have equal weights.
pub fn overall(report: &BenchReport) -> Vec<Mean> {
    let scenes: Vec<Vec<Mean>> = report
        .scenes
        .iter()
        .filter(|scene| !scene.traces.is_empty())
        .map(means)
        .collect();
    let mean = |&contender: &Contender| {
        let own = scenes.iter().map(|means| {
            let mut means = means.iter();
            means
                .find(|mean| mean.contender == contender)?
                .times_reference
        });
        Mean {
            contender,
            times_reference: geometric_mean(own),
        }
    };
    contenders(&report.scenes).iter().map(mean).collect()
}

fn geometric_mean(ratios: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let logarithms: Vec<f64> = ratios
        .map(|ratio| ratio.map(f64::ln))
        .collect::<Option<_>>()?;
    let sum: f64 = logarithms.iter().sum();
    (!logarithms.is_empty()).then(|| (sum / logarithms.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::super::sample::{report, trace};
    use super::*;

    #[test]
    fn fastest_variant_per_backend_is_relative_to_reference() {
        let report = report();
        let fastest = fastest(&report.scenes[0]);
        let found: Vec<_> = fastest
            .iter()
            .map(|f| {
                (
                    f.trace.kind.name(),
                    f.contender.backend.name(),
                    f.times_reference,
                )
            })
            .collect();
        let [a, b] = [Backend::ALL[0].name(), Backend::ALL[1].name()];
        assert_eq!(
            found,
            [
                ("camera", a, Some(1.0)),
                ("camera", b, Some(2.0)),
                ("shadow", a, Some(1.0)),
                ("shadow", b, Some(0.5)),
            ]
        );
    }

    #[test]
    fn fastest_variants_are_compared_with_and_without_packets() {
        let mut report = report();
        let mut packets = trace(RayKind::Camera, Backend::ALL[0], 20.0);
        packets.variant.packets.width = PacketWidth::Eight;
        report.scenes[0].traces.push(packets);
        let fastest = fastest(&report.scenes[0]);
        let found = fastest
            .iter()
            .take(3)
            .map(|f| (f.contender.packets, f.times_reference));
        // 20 ns with packets, 50 ns without, and 100 ns for the other backend.
        let want = [(true, Some(1.0)), (false, Some(2.5)), (true, Some(5.0))];
        assert_eq!(found.collect::<Vec<_>>(), want);
    }

    #[test]
    fn overall_speed_is_the_geometric_mean_of_ratios() {
        let mut report = report();
        for mean in means(&report.scenes[0]).iter().chain(&overall(&report)) {
            assert!(
                mean.times_reference
                    .is_some_and(|m| (m - 1.0).abs() < 1e-12),
                "{mean:?}"
            );
        }
        report.scenes[0]
            .traces
            .retain(|trace| trace.kind == RayKind::Camera);
        let mean = overall(&report)[1].times_reference;
        assert!(
            mean.is_some_and(|mean| (mean - 2.0).abs() < 1e-12),
            "{mean:?}"
        );
    }

    #[test]
    fn zero_times_give_no_comparison() {
        let mut report = report();
        report.scenes[0].traces = vec![
            trace(RayKind::Camera, Backend::ALL[0], 0.0),
            trace(RayKind::Camera, Backend::ALL[1], 3.0),
        ];
        let means = overall(&report);
        assert_eq!(means.len(), 2);
        assert!(means.iter().all(|mean| mean.times_reference.is_none()));
    }
}
