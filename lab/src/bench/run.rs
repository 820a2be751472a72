//! Runs a whole bench: for each scene its builds, rays, traces, agreement and overhead, and the leak tests at the end.
//!
//! Measure: as in the report.
//! Range: settings that pass [`BenchSettings::validate`]. A cancelled bench reports its results so far.
//! Source: docs/bench.md. Tested in `lab/tests/bench/report.rs`.

use super::build::{build, builds, pool};
use super::closed::{Aim, ClosedMesh};
use super::comparison::compare_all;
use super::leaks::leaks;
use super::machine::machine;
use super::meter::Meter;
use super::obvhs_itself::ObvhsTree;
use super::overhead::{TracingFloor, render_times};
use super::parts::parts;
use super::record::{Recording, record};
use super::report::{BenchReport, ObvhsReport, OverheadReport, SceneReport, TraceReport};
use super::settings::{BenchObserver, BenchSettings, GivenScene};
use super::subject::BenchedRender;
use super::target::{BenchTarget, TracingMode};
use super::trace::{TraceMode, trace};
use super::work::{self, StageTimes};
use etendue::Result;
use etendue::internals::accel::Accel;
use etendue::internals::film::filter::{Filter, FilterSampling};
use etendue::internals::integrator::observer::RayKind;
use etendue::internals::integrator::reuse::PathReuse;
use etendue::internals::render::settings::{LightPathRule, PathReuseRule, RenderSettings};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::prepare::prepare;
use rayon::ThreadPool;
use std::time::Instant;

/// Squares along an edge of the cube that each closed mesh is made from: about 50 000 triangles a mesh.
const CLOSED_MESH_SQUARES: u32 = 64;

/// Measures all scenes and the leaks.
///
/// # Errors
/// Settings out of their range, a scene that cannot be prepared, or an error of a backend.
pub fn run(
    scenes: &[GivenScene],
    settings: &BenchSettings,
    observer: &dyn BenchObserver,
) -> Result<BenchReport> {
    settings.validate()?;
    let works: Vec<StageTimes> = scenes
        .iter()
        .map(|s| StageTimes::of(&s.scene, settings))
        .collect();
    let seconds = works.iter().map(StageTimes::total).sum::<f64>() + work::leaks(settings);
    let mut bench = BenchRun {
        settings,
        observer,
        pool: pool(settings.threads)?,
        meter: Meter::new(observer, seconds),
        report: BenchReport {
            version: env!("CARGO_PKG_VERSION"),
            machine: machine(),
            threads: settings.threads,
            rounds: settings.rounds,
            build_rounds: settings.build_rounds,
            ..BenchReport::default()
        },
    };
    bench.report.complete = bench.all(scenes, &works)?.is_some();
    bench.publish();
    Ok(bench.report)
}

struct BenchRun<'a> {
    settings: &'a BenchSettings,
    observer: &'a dyn BenchObserver,
    pool: ThreadPool,
    meter: Meter<'a>,
    report: BenchReport,
}

/// Edge of a tile in pixels. The rays of a recording are to come from the whole image, so that tiles are small, although an
/// observed tile takes memory for a wavefront of its own, which counts as camera rays.
const TILE_SIZE: u32 = 8;

/// The settings of a render all of whose rays an observer sees: each path is of one sample and begins at the camera, and no
/// pilot chooses what the recorded render does not have.
fn observed_settings(description: &SceneDescription) -> Result<RenderSettings> {
    Ok(RenderSettings {
        filter_sampling: FilterSampling::Importance,
        has_window_pilot: false,
        tile_size: TILE_SIZE,
        light_paths: LightPathRule::OFF,
        reuse: PathReuseRule::Pixels(PathReuse::Off),
        ..RenderSettings::of_scene(description)?.with_path_for_auto()
    })
}

/// A prepared scene with all acceleration structures that are compared.
struct BenchedScene {
    scene: Scene,
    filter: Filter,
    size: (u32, u32),
    settings: RenderSettings,
    /// The target with which the scene itself traces.
    target: BenchTarget,
    /// The structures of the other targets.
    accels: Vec<(BenchTarget, Accel)>,
    /// Seconds of reading and placing shapes, and of building.
    load: f64,
    build: f64,
}

impl BenchedScene {
    fn subject(&self) -> BenchedRender<'_> {
        BenchedRender {
            scene: &self.scene,
            filter: &self.filter,
            size: self.size,
            settings: &self.settings,
        }
    }

    fn accel(&self, target: BenchTarget) -> &Accel {
        let other = self.accels.iter().find(|(other, _)| *other == target);
        other.map_or(&*self.scene.accel, |(_, accel)| accel)
    }
}

/// Each step returns `None` if the bench was cancelled.
impl BenchRun<'_> {
    fn all(&mut self, scenes: &[GivenScene], works: &[StageTimes]) -> Result<Option<()>> {
        for (scene, work) in scenes.iter().zip(works) {
            if self.scene(scene, work)?.is_none() {
                return Ok(None);
            }
        }
        self.leaks()
    }

    fn scene(&mut self, given: &GivenScene, work: &StageTimes) -> Result<Option<()>> {
        let name = &given.name;
        let stage = self.meter.stage(format!("{name}: preparing"), work.prepare);
        let mut ready = self.ready(given)?;
        self.report.scenes.push(SceneReport {
            name: name.clone(),
            description: given.description.clone(),
            primitives: primitives(&ready.scene),
            builds: vec![],
            rays: vec![],
            traces: vec![],
            obvhs_itself: vec![],
            agreement: vec![],
            overhead: None,
        });
        if !stage.advance(1.0) {
            return Ok(None);
        }

        let stage = self.meter.stage(format!("{name}: building"), work.build);
        let settings = self.settings;
        let (targets, threads) = (&settings.targets, settings.threads);
        let world = &ready.scene.world;
        let Some(builds) = builds(world, targets, threads, settings.build_rounds, &stage)? else {
            return Ok(None);
        };
        self.last().builds = builds;
        self.publish();

        let recording = record(&ready.subject(), settings.rays);
        self.last().rays = recording.report();
        for &target in targets.iter().filter(|&&target| target != ready.target) {
            let accel = build(&ready.scene.world, target, &self.pool)?;
            ready.accels.push((target, accel));
        }
        let traced = self.traces(&ready, &recording, name, work);
        let compared = traced.and_then(|()| self.agreement(&ready, &recording, name, work));
        if compared.is_none() {
            return Ok(None);
        }
        self.overhead(&ready, &recording, name, work)
    }

    fn ready(&self, given: &GivenScene) -> Result<BenchedScene> {
        let description: &SceneDescription = &given.scene;
        let target = self.settings.render_target();
        let options = target.options(self.settings.threads);
        let start = Instant::now();
        let prepared = self.pool.install(|| prepare(description, options))?;
        let (seconds, build) = (start.elapsed(), prepared.build_time);
        Ok(BenchedScene {
            scene: prepared.scene,
            filter: Filter::new(&description.film.filter),
            size: description.film.size,
            settings: observed_settings(description)?,
            target,
            accels: vec![],
            load: given.load + (seconds - build).as_secs_f64(),
            build: build.as_secs_f64(),
        })
    }

    fn traces(
        &mut self,
        ready: &BenchedScene,
        recording: &Recording,
        name: &str,
        work: &StageTimes,
    ) -> Option<()> {
        let variants = self.settings.targets.iter().flat_map(|t| t.variants());
        let variants: Vec<TracingMode> = variants.collect();
        let compares_obvhs = variants.iter().any(|it| !it.target.is_embree());
        let trees = match compares_obvhs {
            true => self.pool.install(|| ObvhsTree::all(&ready.scene.world)),
            false => Vec::new(),
        };
        let ours = variants
            .iter()
            .map(|variant| TraceMode::Accel(ready.accel(variant.target), variant.packets));
        let theirs = trees.iter().map(TraceMode::ObvhsItself);
        let modes: Vec<TraceMode<'_>> = ours.chain(theirs).collect();
        for &kind in RayKind::ALL {
            let what = format!("{name}: {} rays", kind.name());
            let stage = self.meter.stage(what, work.trace_of_kind);
            let rays = recording.rays(kind);
            if rays.is_empty() {
                continue;
            }
            let mut times = trace(&modes, kind, rays, self.settings.rounds, &self.pool, &stage)?;
            let theirs = times.split_off(variants.len()).into_iter().zip(&trees);
            let theirs = theirs.map(|(nanoseconds, tree)| ObvhsReport {
                kind,
                layout: tree.layout,
                is_split: tree.is_split,
                nanoseconds,
            });
            self.last().obvhs_itself.extend(theirs);
            let ours = times.into_iter().zip(&variants);
            let ours = ours.map(|(nanoseconds, &variant)| TraceReport {
                kind,
                variant,
                nanoseconds,
            });
            self.last().traces.extend(ours);
            self.publish();
        }
        Some(())
    }

    fn agreement(
        &mut self,
        ready: &BenchedScene,
        recording: &Recording,
        name: &str,
        work: &StageTimes,
    ) -> Option<()> {
        let stage = self
            .meter
            .stage(format!("{name}: comparing hits"), work.compare);
        let targets = self.settings.targets.iter();
        let targets: Vec<(BenchTarget, &Accel)> = targets.map(|&t| (t, ready.accel(t))).collect();
        let count = self.settings.compared_rays;
        let world = &ready.scene.world;
        self.last().agreement = compare_all(world, &targets, recording, count, &self.pool, &stage)?;
        self.publish();
        Some(())
    }

    fn overhead(
        &mut self,
        ready: &BenchedScene,
        recording: &Recording,
        name: &str,
        work: &StageTimes,
    ) -> Result<Option<()>> {
        let stage = self
            .meter
            .stage(format!("{name}: Etendue render"), work.render);
        let Some(floor) = TracingFloor::of(ready.target, recording, &self.last().traces) else {
            return Ok(Some(()));
        };
        let (subject, settings) = (ready.subject(), self.settings);
        let times = render_times(
            &subject,
            settings.threads,
            settings.rounds,
            settings.render_seconds,
            &stage,
        )?;
        let Some(times) = times else {
            return Ok(None);
        };
        let samples = recording.film.sample_count();
        self.last().overhead = Some(OverheadReport {
            target: ready.target,
            spp: times.spp,
            sample: times.sample,
            sample_alone: times.sample_alone,
            floor: floor.nanoseconds,
            factor: floor.factor(times.sample),
            best: floor.best,
            parts: parts(&subject, samples, times.sample.median),
            load: ready.load,
            build: ready.build,
        });
        self.publish();
        Ok(Some(()))
    }

    fn leaks(&mut self) -> Result<Option<()>> {
        let settings = self.settings;
        let stage = self.meter.stage("leaks".into(), work::leaks(settings));
        if settings.segments == 0 {
            return Ok(Some(()));
        }
        let is_cancelled = || self.observer.is_cancelled();
        let meshes = ClosedMesh::all(CLOSED_MESH_SQUARES);
        let all = (meshes.len() * settings.targets.len()) as f64;
        let mut done = 0.0;
        for mesh in &meshes {
            for &target in &settings.targets {
                let accel = build(mesh.world(), target, &self.pool)?;
                for &aim in Aim::ALL {
                    let traced = (target, &accel);
                    let count = || leaks(mesh, aim, traced, settings.segments, 0, &is_cancelled);
                    let report = self.pool.install(count);
                    self.report.leaks.push(report);
                }
                done += 1.0;
                self.publish();
                if !stage.advance(done / all) {
                    return Ok(None);
                }
            }
        }
        Ok(Some(()))
    }

    /// The report of the current scene.
    fn last(&mut self) -> &mut SceneReport {
        let scenes = &mut self.report.scenes;
        scenes.last_mut().expect("a scene begins with its report")
    }

    fn publish(&self) {
        self.observer.report(&self.report);
    }
}

/// The number of primitives, those of each group counted once.
fn primitives(scene: &Scene) -> usize {
    let (roots, groups) = (scene.world.geometries(), scene.world.groups());
    let all = roots.iter().chain(groups.iter().flatten());
    all.map(|geometry| geometry.primitive_count()).sum()
}

#[cfg(test)]
mod tests {
    use super::super::subject::SAMPLES_AT_ONCE;
    use super::*;

    /// Of few tiles, the rays would be those of one part of the image, such as the sky.
    #[test]
    fn rays_of_a_short_recording_come_from_many_tiles() {
        let of_tile = SAMPLES_AT_ONCE * u64::from(TILE_SIZE).pow(2);
        let tiles = 65_536 / of_tile;
        assert!(tiles >= 50, "{tiles}");
    }
}
