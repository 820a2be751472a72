//! What a reader of a bench would have to compute: the fastest way of each backend, and how it compares.
//!
//! Measure: ratios of times to those of a reference, Embree where it took part: below 1 is faster.
//! Range: `None` where a time is missing, or was too short for the clock.
//! Source: Fleming and Wallace 1986 (ratios are averaged by the geometric mean). Tested below.

use crate::accel::Backend;
use crate::bench::report::{BenchReport, SceneReport, TraceReport};
use crate::integrator::observer::RayKind;
use serde::Serialize;

/// A backend in its fastest way with the rays of a kind.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Fastest<'a> {
    /// The way, and its time.
    #[serde(flatten)]
    pub trace: &'a TraceReport,
    /// Its time over that of the reference in its own fastest way.
    pub times_reference: Option<f64>,
}

impl Fastest<'_> {
    /// Who traced.
    pub fn backend(&self) -> Backend {
        self.trace.variant.target.backend
    }
}

/// How a backend does on average.
#[derive(Debug, Clone, Serialize)]
pub struct Mean {
    /// Its name.
    pub backend: &'static str,
    /// The geometric mean of its times over those of the reference.
    pub times_reference: Option<f64>,
}

/// The backends that traced rays, the reference first.
pub fn backends<'a>(scenes: impl IntoIterator<Item = &'a SceneReport>) -> Vec<Backend> {
    let traces: Vec<_> = scenes.into_iter().flat_map(|scene| &scene.traces).collect();
    let traced = |backend: &Backend| {
        let mut traces = traces.iter();
        traces.any(|trace| trace.variant.target.backend == *backend)
    };
    Backend::ALL.iter().copied().filter(traced).collect()
}

/// What all others are compared to, by name.
pub fn reference(report: &BenchReport) -> &'static str {
    let backends = backends(&report.scenes);
    backends
        .first()
        .map_or("the first", |backend| backend.name())
}

/// The rays of each kind, traced by each backend in its fastest way.
pub fn fastest(scene: &SceneReport) -> Vec<Fastest<'_>> {
    let backends = backends([scene]);
    let mut all = Vec::new();
    for &kind in RayKind::ALL {
        let reference = backends.first().and_then(|&b| of_backend(scene, kind, b));
        for trace in backends.iter().filter_map(|&b| of_backend(scene, kind, b)) {
            all.push(Fastest {
                trace,
                times_reference: reference.and_then(|reference| ratio(trace, reference)),
            });
        }
    }
    all
}

/// The least median among the ways of a backend.
fn of_backend(scene: &SceneReport, kind: RayKind, backend: Backend) -> Option<&TraceReport> {
    scene
        .traces
        .iter()
        .filter(|trace| trace.kind == kind && trace.variant.target.backend == backend)
        .min_by(|a, b| a.nanoseconds.median.total_cmp(&b.nanoseconds.median))
}

fn ratio(one: &TraceReport, other: &TraceReport) -> Option<f64> {
    let (one, other) = (one.nanoseconds.median, other.nanoseconds.median);
    (one > 0.0 && other > 0.0).then(|| one / other)
}

/// Each backend over the kinds of rays of a scene.
pub fn means(scene: &SceneReport) -> Vec<Mean> {
    let fastest = fastest(scene);
    let mean = |&backend: &Backend| {
        let own = fastest
            .iter()
            .filter(|fastest| fastest.backend() == backend);
        Mean {
            backend: backend.name(),
            times_reference: geometric_mean(own.map(|fastest| fastest.times_reference)),
        }
    };
    backends([scene]).iter().map(mean).collect()
}

/// Each backend over all scenes, each of which counts the same.
pub fn overall(report: &BenchReport) -> Vec<Mean> {
    let scenes: Vec<Vec<Mean>> = report
        .scenes
        .iter()
        .filter(|scene| !scene.traces.is_empty())
        .map(means)
        .collect();
    let mean = |backend: &Backend| {
        let own = scenes.iter().map(|means| {
            let mut means = means.iter();
            means
                .find(|mean| mean.backend == backend.name())?
                .times_reference
        });
        Mean {
            backend: backend.name(),
            times_reference: geometric_mean(own),
        }
    };
    backends(&report.scenes).iter().map(mean).collect()
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
    fn the_fastest_way_of_each_backend_is_held_against_the_reference() {
        let report = report();
        let fastest = fastest(&report.scenes[0]);
        let found: Vec<_> = fastest
            .iter()
            .map(|f| (f.trace.kind.name(), f.backend().name(), f.times_reference))
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
    fn twice_as_slow_here_and_twice_as_fast_there_is_a_draw() {
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
    fn a_time_that_the_clock_did_not_see_compares_to_nothing() {
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
