//! Correctness of the bench: the recorded rays are those of the render, and the numbers of a report add up. Speed itself is
//! not tested.

use crate::common::scene::ready;
use crate::common::scene_folder::{SMALL, load_text};
use etendue::ErrorKind;
use etendue::internals::accel::batch::{HitBatch, Packets};
use etendue::internals::accel::{Backend, PrimitiveId};
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::integrator::observer::{PathObserver, PathVertex, RayKind};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec3;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::render::{NullRenderObserver, observe_tile};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use etendue_lab::bench::overhead::TracingFloor;
use etendue_lab::bench::parts::{SamplePart, parts};
use etendue_lab::bench::record::record;
use etendue_lab::bench::report::BenchReport;
use etendue_lab::bench::run;
use etendue_lab::bench::settings::{BenchObserver, BenchSettings, GivenScene, NullBenchObserver};
use etendue_lab::bench::subject::BenchedRender;
use etendue_lab::bench::target::BenchTarget;
use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A scene with its filter and settings, in tiles of 8 x 8 pixels.
struct Small {
    scene: Scene,
    filter: Filter,
    settings: RenderSettings,
}

impl Small {
    fn new(spp: u64, sampler: SamplerKind) -> Self {
        let description = load_text(SMALL);
        let settings = RenderSettings {
            sampler,
            tile_size: 8,
            ..RenderSettings::new(description.film.size, spp)
        };
        Self {
            scene: ready(&description, Backend::ALL[0]),
            filter: Filter::new(&description.film.filter),
            settings,
        }
    }

    fn subject(&self) -> BenchedRender<'_> {
        BenchedRender {
            scene: &self.scene,
            filter: &self.filter,
            size: (24, 16),
            settings: &self.settings,
        }
    }
}

/// Checks that every tile with samples has the sums of `want`; returns the number of such tiles.
#[track_caller]
fn assert_part_of(film: &Film, want: &Film) -> usize {
    let pairs = film.tiles().iter().zip(want.tiles());
    let seen: Vec<_> = pairs.filter(|(tile, _)| tile.samples > 0).collect();
    for (tile, want) in &seen {
        assert_eq!(tile.samples, want.samples);
        assert_eq!(tile.pixels, want.pixels, "{:?}", tile.window);
    }
    seen.len()
}

#[test]
fn full_recording_reproduces_the_render_and_its_ray_counts() {
    for &sampler in SamplerKind::ALL {
        // More samples than are observed at once, and not a multiple of that number.
        let small = Small::new(6, sampler);
        let rendered = small
            .subject()
            .render(2, 6, &NullRenderObserver)
            .expect("valid settings");
        let recording = record(&small.subject(), usize::MAX);
        assert_eq!(assert_part_of(&recording.film, &rendered.film), 6);
        assert_eq!(recording.counts(), rendered.rays);
        let rays = RayKind::ALL.iter().map(|&kind| recording.rays(kind).len());
        assert_eq!(rays.sum::<usize>() as u64, rendered.rays.total());
        assert_eq!(recording.per_sample(RayKind::Camera), 1.0);
        // The scene has rays of all kinds.
        assert_eq!(recording.kinds().count(), RayKind::ALL.len());
    }
}

#[test]
fn limited_recording_is_deterministic_and_part_of_the_render() {
    let small = Small::new(4, SamplerKind::Sobol);
    let rendered = small
        .subject()
        .render(1, 4, &NullRenderObserver)
        .expect("valid settings");
    let limit = 500;
    let recording = record(&small.subject(), limit);
    let again = record(&small.subject(), limit);
    let tiles = assert_part_of(&recording.film, &rendered.film);
    assert!((1..6).contains(&tiles), "{tiles}");
    let mut longest = 0;
    for &kind in RayKind::ALL {
        let rays = recording.rays(kind);
        assert_eq!(rays, again.rays(kind), "{}", kind.name());
        longest = longest.max(rays.len());
    }
    assert_eq!(longest, limit);
    // Rays beyond the limit are still counted.
    let mut count = Count::default();
    for tile in recording.film.tiles().iter().filter(|t| t.samples > 0) {
        let (scene, filter, settings) = (&small.scene, &small.filter, &small.settings);
        let samples = 0..tile.samples;
        observe_tile(
            scene,
            filter,
            settings,
            None,
            &mut tile.clone(),
            samples,
            &mut count,
        );
    }
    assert_eq!(recording.counts().total(), count.rays.values().sum::<u64>());
    for rays in recording.report() {
        let want = count.rays[&rays.kind] as f64 / recording.film.sample_count() as f64;
        assert_eq!(rays.per_sample, want, "{}", rays.kind.name());
    }
}

/// Counts rays.
#[derive(Default)]
struct Count {
    rays: HashMap<RayKind, u64>,
}

impl PathObserver for Count {
    fn is_sequential(&self) -> bool {
        false
    }

    fn traced(&mut self, kind: RayKind, _ray: &Ray, _time: f32) {
        *self.rays.entry(kind).or_default() += 1;
    }
}

/// The hits of the render's own rays; within each kind, in the order of a recording.
#[derive(Default)]
struct ObservedHits {
    /// Rays in flight: their kinds, and the primitives that they leave. Hits of paths traced side by side are reported in the
    /// order in which their rays were traced.
    under_way: VecDeque<(RayKind, Option<PrimitiveId>)>,
    /// The primitive that the path's current vertex is on.
    current: Option<PrimitiveId>,
    closest: Vec<(RayKind, Option<PrimitiveId>, Option<PrimitiveId>)>,
    visible: Vec<f32>,
}

impl ObservedHits {
    fn record(&mut self, id: Option<PrimitiveId>) {
        let (kind, leaves) = self.under_way.pop_front().expect("a ray is in flight");
        self.closest.push((kind, leaves, id));
        self.current = id;
    }
}

impl PathObserver for ObservedHits {
    fn is_sequential(&self) -> bool {
        false
    }

    fn traced(&mut self, kind: RayKind, _ray: &Ray, _time: f32) {
        match kind {
            RayKind::Shadow => {}
            RayKind::Camera => self.under_way.push_back((kind, None)),
            _ => self.under_way.push_back((kind, self.current)),
        }
    }
    fn arrived(&mut self, at: &PathVertex, _beta: Rgb) {
        self.record(Some(at.id));
    }
    fn escaped(&mut self, _direction: Vec3) {
        self.record(None);
    }
    fn light(&mut self, _contribution: Rgb, _weight: f32, visible: f32) {
        self.visible.push(visible);
    }
}

#[test]
fn recorded_rays_reproduce_the_hits_of_the_render() {
    let small = Small::new(8, SamplerKind::Sobol);
    let recording = record(&small.subject(), usize::MAX);
    let mut observed = ObservedHits::default();
    small.subject().observe(0, &mut observed, |_| false);
    let accel = &small.scene.accel;

    let mut occluded = vec![];
    accel.occluded_batch(
        recording.rays(RayKind::Shadow),
        Packets::default(),
        &mut occluded,
    );
    let visible = observed.visible.iter().map(|&visible| visible == 0.0);
    assert!(visible.eq(occluded.iter().copied()));
    assert!(occluded.contains(&true) && occluded.contains(&false));

    let (mut compared, mut returned) = (0, 0);
    for kind in recording.kinds().filter(|&kind| kind != RayKind::Shadow) {
        let mut hits = HitBatch::default();
        accel.intersect_batch(recording.rays(kind), Packets::default(), &mut hits);
        let of_kind = observed.closest.iter().filter(|(k, ..)| *k == kind);
        assert_eq!(of_kind.clone().count(), hits.len(), "{}", kind.name());
        for (index, (_, left, met)) in of_kind.enumerate() {
            let hit = hits.get(index).map(|hit| hit.id);
            // The ray hits the primitive that it leaves, by rounding; the render excludes that primitive.
            let is_return = hit.is_some() && hit == *left && hit != *met;
            assert!(is_return || hit == *met, "{} ray {index}", kind.name());
            compared += 1;
            returned += usize::from(is_return);
        }
    }
    assert!(returned * 100 < compared, "{returned} of {compared}");
}

#[test]
fn every_trace_variant_occurs_once() {
    let targets = BenchTarget::all(Backend::ALL);
    assert_eq!(targets.len(), 4 * Backend::ALL.len());
    let variants: Vec<_> = targets.iter().flat_map(|t| t.variants()).collect();
    let different: HashSet<_> = variants.iter().collect();
    assert_eq!(different.len(), variants.len());
    for target in targets {
        let ways = if target.is_embree() { 5 } else { 1 };
        assert_eq!(target.variants().len(), ways, "{}", target.name());
    }
}

#[test]
fn sample_time_parts_sum_to_the_total() {
    let small = Small::new(2, SamplerKind::Independent);
    let parts = parts(&small.subject(), 500, 1234.5);
    let names: Vec<&str> = parts.iter().map(|part| part.part).collect();
    let all: Vec<&str> = SamplePart::ALL.iter().map(|part| part.name()).collect();
    assert_eq!(names, all);
    let sum: f64 = parts.iter().map(|part| part.nanoseconds).sum();
    assert!((sum / 1234.5 - 1.0).abs() < 1e-9, "{sum}");
    assert!(parts.iter().all(|part| part.nanoseconds >= 0.0));
}

/// The scenes and settings of a bench that takes seconds.
fn short() -> (Vec<GivenScene>, BenchSettings) {
    let scene = |name: &str, scene: SceneDescription| GivenScene {
        name: name.into(),
        description: String::new(),
        scene,
        load: 0.25,
    };
    let scenes = vec![
        scene("one", load_text(SMALL)),
        scene("two", load_text(SMALL)),
    ];
    // Four configurations of the preferred backend, and one of another backend.
    let mut targets = BenchTarget::all(&Backend::ALL[..1]);
    targets.extend(BenchTarget::all(&[Backend::ObvhsCwbvh]).first());
    let settings = BenchSettings {
        threads: 2,
        targets,
        rounds: 2,
        build_rounds: 1,
        rays: 2000,
        render_seconds: 0.01,
        compared_rays: 500,
        segments: 100,
        ..BenchSettings::default()
    };
    (scenes, settings)
}

/// Records progress and reports, and cancels after `patience` reports of progress.
struct Onlooker {
    patience: usize,
    told: AtomicUsize,
    fractions: Mutex<Vec<f64>>,
    reports: AtomicUsize,
}

impl Onlooker {
    fn new(patience: usize) -> Self {
        Self {
            patience,
            told: AtomicUsize::new(0),
            fractions: Mutex::default(),
            reports: AtomicUsize::new(0),
        }
    }
}

impl BenchObserver for Onlooker {
    fn progress(&self, fraction: f64, what: &str) {
        assert!(!what.is_empty());
        self.told.fetch_add(1, Ordering::Relaxed);
        self.fractions.lock().expect("no panic").push(fraction);
    }
    fn is_cancelled(&self) -> bool {
        self.told.load(Ordering::Relaxed) >= self.patience
    }
    fn report(&self, _report: &BenchReport) {
        self.reports.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn bench_report_counts_are_consistent() {
    let (scenes, settings) = short();
    let onlooker = Onlooker::new(usize::MAX);
    let report = run(&scenes, &settings, &onlooker).expect("it can be measured");
    assert!(report.complete);
    assert_eq!(report.scenes.len(), 2);
    let fractions = onlooker.fractions.into_inner().expect("no panic");
    assert!(fractions.is_sorted() && fractions[0] >= 0.0);
    assert!((fractions[fractions.len() - 1] - 1.0).abs() < 1e-9);
    assert!(onlooker.reports.into_inner() > 2 * RayKind::ALL.len());

    let variants = settings.targets.iter().map(|t| t.variants().len());
    let variants: usize = variants.sum();
    for scene in &report.scenes {
        assert_eq!(scene.primitives, 16);
        // On one thread and on two.
        assert_eq!(scene.builds.len(), 2 * settings.targets.len());
        assert!(
            scene
                .builds
                .iter()
                .all(|b| b.bytes > 0 && b.seconds.min > 0.0)
        );
        assert_eq!(scene.rays.len(), RayKind::ALL.len());
        assert_eq!(scene.traces.len(), variants * scene.rays.len());
        // Both scenes have shapes that obvhs does not know.
        assert!(scene.obvhs_itself.is_empty());
        assert_eq!(scene.agreement.len(), settings.targets.len() - 1);
        for agreement in &scene.agreement {
            assert_eq!(agreement.reference, settings.targets[0]);
            assert_eq!(agreement.rays, settings.compared_rays as u64);
            assert_eq!(agreement.real, 0, "{:?}", agreement.first_real);
        }
        for trace in &scene.traces {
            let spread = trace.nanoseconds;
            assert!(spread.min <= spread.median && spread.median <= spread.max);
        }
    }
    // Six meshes, three kinds of targets.
    assert_eq!(report.leaks.len(), 18 * settings.targets.len());
    assert!(
        report
            .leaks
            .iter()
            .all(|leak| leak.segments == settings.segments)
    );
    // The two scenes are identical, and so are their rays.
    let rays = |index: usize| report.scenes[index].rays.iter();
    assert!(
        rays(0)
            .zip(rays(1))
            .all(|(a, b)| a.per_sample == b.per_sample)
    );
}

#[cfg(feature = "embree")]
#[test]
fn overhead_factor_is_sample_time_over_its_floor() {
    let (scenes, settings) = short();
    let report = run(&scenes[..1], &settings, &NullBenchObserver).expect("it can be measured");
    let scene = &report.scenes[0];
    let overhead = scene.overhead.as_ref().expect("Embree was measured");
    assert_eq!(overhead.target, settings.render_target());
    let mut floor = 0.0;
    for (rays, best) in scene.rays.iter().zip(&overhead.best) {
        assert_eq!(rays.kind, best.kind);
        let target = best.variant.target;
        assert!(target.is_embree() && target.precision == settings.precision);
        let others = scene.traces.iter().filter(|trace| {
            let other = trace.variant.target;
            trace.kind == best.kind && other.is_embree() && other.precision == settings.precision
        });
        let others: Vec<f64> = others.map(|trace| trace.nanoseconds.median).collect();
        assert_eq!(others.len(), 10);
        assert!(others.iter().all(|&other| other >= best.nanoseconds.median));
        floor += rays.per_sample * best.nanoseconds.median;
    }
    assert_eq!(overhead.best.len(), scene.rays.len());
    assert!(overhead.floor > 0.0 && (overhead.floor / floor - 1.0).abs() < 1e-12);
    let factor = overhead.sample.median / overhead.floor;
    assert!((overhead.factor.median / factor - 1.0).abs() < 1e-12);
    let parts: f64 = overhead.parts.iter().map(|part| part.nanoseconds).sum();
    assert!((parts / overhead.sample.median - 1.0).abs() < 1e-9);
    assert!(overhead.load >= 0.25 && overhead.build > 0.0 && overhead.spp >= 64);
}

#[test]
fn floor_is_none_without_embree_timings() {
    let small = Small::new(1, SamplerKind::Sobol);
    let recording = record(&small.subject(), 100);
    let [_, target, ..] = BenchTarget::all(&[Backend::ObvhsBvh2])[..] else {
        panic!("a backend has four targets");
    };
    assert!(TracingFloor::of(target, &recording, &[]).is_none());
    // No floor either where a kind of rays was not timed.
    let target = BenchTarget::all(&[Backend::ALL[0]])[0];
    assert!(TracingFloor::of(target, &recording, &[]).is_none());
}

#[test]
fn cancelled_bench_reports_partial_results() {
    let (mut scenes, mut settings) = short();
    scenes.pop();
    settings.targets.truncate(2);
    settings.segments = 1;
    let whole = Onlooker::new(usize::MAX);
    run(&scenes, &settings, &whole).expect("it can be measured");
    let steps = whole.told.into_inner();
    let mut traces = vec![];
    for patience in (1..steps).step_by(steps / 7) {
        let onlooker = Onlooker::new(patience);
        let report = run(&scenes, &settings, &onlooker).expect("it was cancelled");
        assert!(!report.complete, "{patience} of {steps}");
        // It ends within one step, and reports the last state.
        assert!(onlooker.told.into_inner() <= patience + 1);
        assert!(onlooker.reports.into_inner() > 0);
        let scenes = report.scenes.iter().map(|scene| scene.traces.len());
        traces.push(scenes.sum::<usize>());
    }
    assert!(traces.is_sorted() && traces[0] == 0 && traces[traces.len() - 1] > 0);
}

#[test]
fn out_of_range_settings_are_usage_errors() {
    let (scenes, fine) = short();
    let change = |change: fn(&mut BenchSettings)| {
        let mut settings = fine.clone();
        change(&mut settings);
        settings
    };
    for wrong in [
        change(|s| s.threads = 0),
        change(|s| s.rounds = 0),
        change(|s| s.build_rounds = 0),
        change(|s| s.rays = 0),
        change(|s| s.targets.clear()),
    ] {
        let error = run(&scenes, &wrong, &NullBenchObserver).expect_err("nothing can be measured");
        assert_eq!(error.kind(), ErrorKind::Usage, "{wrong:?}");
    }
}
