//! Bidirectional path tracing: a camera subpath, a light subpath, and every way of making one path of both.
//!
//! A path with n edges can be found by n + 1 strategies, each of which is good at something: light subpaths at the
//! light that a lamp behind glass throws onto a wall, camera subpaths at what is seen in a mirror. The estimate of a
//! pixel is
//!
//!   sum_{t > 1, s} w_{s,t} C_{s,t} + 1/N sum_{light subpaths} sum_s h w_{s,1} C_{s,1},
//!
//! where the second sum is over the light subpaths, one for each sample of every pixel, N in all, that are connected to
//! the lens and fall where the pixel's filter h covers the film. The weights w, by the power heuristic, sum to one for
//! every path (`weights.rs`); light that the camera sees without scattering is found by s = 0 alone.
//!
//! Russian roulette changes the throughput of a subpath, not its densities.
//!
//! Measure: radiance; splats as in `film/splats.rs`.
//! Range: any scene. Subpaths are kept whole, some 300 bytes a vertex, until their sample is done.
//! Source: Lafortune and Willems 1993; Veach 1997, chapter 10. Tested in `tests/rendering/bidirectional.rs`.

mod connect;
#[cfg(test)]
mod consistency;
mod emission;
pub(super) mod vertex;
pub(super) mod walk;
mod weights;

use super::observer::{NullPathObserver, PathObserver};
use super::{CameraRay, Integrator, RayCounts, Roulette};
use crate::accel::Hit;
use crate::effects::Effects;
use crate::film::splats::{Splat, SplatList, Strategy};
use crate::light::types::{LightChoice, LightSampling};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;
pub use connect::Contribution;
use connect::{Connector, LightSubpath};
use vertex::{LightVertex, RayDensity};
use walk::{Subpath, SubpathKind, SubpathSampler, SubpathStart};
use weights::WholePath;

/// The bidirectional path integrator and its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bidirectional {
    /// The largest number of scattering events; `None` for no limit.
    pub max_bounces: Option<u32>,
    /// The rule of Russian roulette for both subpaths.
    pub roulette: Roulette,
    /// The area of film, in pixels, over which samples are spread evenly, with one light subpath for each: the whole
    /// image's area if its pixels have equal sample counts.
    pub film_area: f64,
    /// The selection of lights by next event estimation. Light subpaths begin at lights selected by power.
    pub light_choice: LightChoice,
}

/// The scratch of the bidirectional integrator: the subpaths of a sample, and the densities of a path that they make.
#[derive(Debug)]
pub struct SubpathScratch<'a, E: Effects> {
    light: Subpath<'a, E>,
    camera: Subpath<'a, E>,
    whole: WholePath,
}

impl<E: Effects> Default for SubpathScratch<'_, E> {
    fn default() -> Self {
        Self {
            light: Subpath::default(),
            camera: Subpath::default(),
            whole: WholePath::default(),
        }
    }
}

impl Integrator for Bidirectional {
    type Scratch<'a, E: Effects> = SubpathScratch<'a, E>;

    fn radiance<'a, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &'a Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        rays: &mut RayCounts,
        scratch: &mut SubpathScratch<'a, E>,
        observer: &mut O,
    ) -> Rgb {
        let splats = &mut SplatList::none();
        self.radiance_and_splats::<E, S, O>(
            scene, sampler, camera_ray, hit, rays, scratch, observer, splats,
        )
    }

    fn radiance_and_splats<'a, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &'a Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        rays: &mut RayCounts,
        scratch: &mut SubpathScratch<'a, E>,
        observer: &mut O,
        splats: &mut SplatList<'_>,
    ) -> Rgb {
        let mut radiance = Rgb::BLACK;
        let (reaches, list) = (splats.reaches, &mut splats.splats);
        let take = |it: Contribution| match it.film {
            Some(film) => list.push(Splat {
                film_position: film,
                value: it.value(),
            }),
            None => radiance += it.value(),
        };
        self.contributions::<E, S, O>(
            scene, sampler, camera_ray, hit, rays, scratch, observer, reaches, take,
        );
        radiance
    }
}

impl Bidirectional {
    /// Computes all contributions of a sample's two subpaths, strategy by strategy; splats only at the places on the
    /// film for which `reaches` returns true.
    #[expect(
        clippy::too_many_arguments,
        reason = "a sample, and all that it may tell of"
    )]
    pub fn contributions<'a, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        scene: &'a Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        rays: &mut RayCounts,
        scratch: &mut SubpathScratch<'a, E>,
        observer: &mut O,
        reaches: &dyn Fn(Vec2) -> bool,
        mut take: impl FnMut(Contribution),
    ) {
        let SubpathScratch {
            light,
            camera,
            whole,
        } = scratch;
        let mut subpath_sampler = self.subpath_sampler(scene, camera_ray, sampler, rays, observer);
        let of_light = self.max_bounces.map(u64::from);
        let light = self.sample_light_subpath(&mut subpath_sampler, of_light, light);
        let of_camera = self.max_bounces.map(|limit| u64::from(limit) + 1);
        self.sample_camera_subpath(&mut subpath_sampler, camera_ray, hit, of_camera, camera);
        let subpaths = (light, &*camera);
        let mut connector = self.connector(scene, camera_ray.time, subpaths, whole, rays, observer);
        let viewpoint = |u| scene.camera.viewpoint::<E>(u, camera_ray.time);
        connector.film_contributions(viewpoint, reaches, &mut take);
        connector.pixel_contributions(take);
    }

    /// Computes the contributions of one strategy for the numbers of `sampler`, equal to those of
    /// [`Self::contributions`], with subpaths no longer than the strategy uses.
    #[expect(
        clippy::too_many_arguments,
        reason = "a sample, and all that it may tell of"
    )]
    pub fn by_strategy<'a, E: Effects, S: Sampler>(
        &self,
        strategy: Strategy,
        scene: &'a Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        rays: &mut RayCounts,
        scratch: &mut SubpathScratch<'a, E>,
        reaches: &dyn Fn(Vec2) -> bool,
    ) -> [Option<Contribution>; 2] {
        let &CameraRay { ray, time } = camera_ray;
        let Strategy { s, t } = strategy;
        let SubpathScratch {
            light,
            camera,
            whole,
        } = scratch;
        let observer = &mut NullPathObserver;
        let mut subpath_sampler = self.subpath_sampler(scene, camera_ray, sampler, rays, observer);
        let mut of_light = None;
        if s > 1 {
            let max_surfaces = Some(s as u64 - 1);
            of_light = self.sample_light_subpath(&mut subpath_sampler, max_surfaces, light);
            if of_light
                .as_ref()
                .is_none_or(|it| it.subpath.vertices.len() + 1 < s)
            {
                return [None; 2];
            }
        }
        camera.clear();
        if t > 1 {
            let hit = scene.accel.intersect(&ray, time, None);
            let max_surfaces = Some(t as u64 - 1);
            self.sample_camera_subpath(&mut subpath_sampler, camera_ray, hit, max_surfaces, camera);
        }
        let subpaths = (of_light, &*camera);
        let mut connector = self.connector(scene, time, subpaths, whole, rays, observer);
        let viewpoint = |u| scene.camera.viewpoint::<E>(u, time);
        connector.by_strategy(strategy, viewpoint, reaches)
    }

    fn subpath_sampler<'a, 'w, S, O: ?Sized>(
        &self,
        scene: &'a Scene,
        camera_ray: &CameraRay,
        sampler: &'w mut S,
        rays: &'w mut RayCounts,
        observer: &'w mut O,
    ) -> SubpathSampler<'a, 'w, S, O> {
        SubpathSampler {
            scene,
            time: camera_ray.time,
            roulette: self.roulette,
            sampler,
            rays,
            observer,
        }
    }

    fn connector<'a, 'w, E: Effects, O: ?Sized>(
        &self,
        scene: &'a Scene,
        time: f32,
        (light, camera_subpath): (Option<LightSubpath<'a, 'w, E>>, &'w Subpath<'a, E>),
        whole: &'w mut WholePath,
        rays: &'w mut RayCounts,
        observer: &'w mut O,
    ) -> Connector<'a, 'w, E, O> {
        Connector {
            scene,
            time,
            max_bounces: self.max_bounces,
            light_choice: self.light_choice,
            per_pixel: 1.0 / self.film_area,
            light,
            camera_subpath,
            rays,
            observer,
            whole,
        }
    }

    /// Samples a camera subpath of at most `max_surfaces` surfaces, along a camera ray with the closest hit `hit`.
    fn sample_camera_subpath<'a, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        subpath_sampler: &mut SubpathSampler<'a, '_, S, O>,
        &CameraRay { ray, time }: &CameraRay,
        hit: Option<Hit>,
        max_surfaces: Option<u64>,
        subpath: &mut Subpath<'a, E>,
    ) {
        // Rays through the middle of the lens give the density of rays through any of its points.
        let middle = subpath_sampler
            .scene
            .camera
            .viewpoint::<E>(Vec2::splat(0.5), time);
        let film = middle.film_point(ray.dir);
        let per_steradian = film.map_or(0.0, |film| film.per_steradian);
        subpath_sampler.rays.camera += 1;
        let start = SubpathStart {
            kind: SubpathKind::Camera,
            ray,
            origin: ray.origin,
            hit,
            ray_density: RayDensity::Point(per_steradian / self.film_area),
            beta: Rgb::WHITE,
            max_surfaces,
        };
        subpath_sampler.sample::<E>(start, subpath);
    }

    /// Samples a light subpath of at most `max_surfaces` surfaces; `None` where no light emits, or no surface is hit.
    fn sample_light_subpath<'a, 'w, E: Effects, S: Sampler, O: PathObserver + ?Sized>(
        &self,
        subpath_sampler: &mut SubpathSampler<'a, '_, S, O>,
        max_surfaces: Option<u64>,
        subpath: &'w mut Subpath<'a, E>,
    ) -> Option<LightSubpath<'a, 'w, E>> {
        if max_surfaces == Some(0) {
            return None;
        }
        let (scene, time) = (subpath_sampler.scene, subpath_sampler.time);
        let [u, v, u_choice, v_choice] = subpath_sampler.sampler.draw(Decision::Source);
        let u_direction = subpath_sampler.sampler.draw(Decision::SourceDirection);
        let choice = scene.lights.choose_by_power::<E>([u_choice, v_choice]);
        let (light, pmf) = choice?;
        let u_direction = Vec2::from_array(u_direction);
        let sample = scene.sample_emission::<E>(light, time, Vec2::new(u, v), u_direction)?;
        let (mut source, ray_density) = LightVertex::new(sample.end, pmf, &sample.pdf);
        let ray = sample.ray();
        subpath_sampler.rays.closest += 1;
        let start = SubpathStart {
            kind: SubpathKind::Light,
            ray,
            origin: sample.origin,
            hit: scene.accel.intersect(&ray, time, None),
            ray_density,
            beta: sample.flux(pmf),
            max_surfaces,
        };
        subpath_sampler.sample::<E>(start, subpath);
        let first = subpath.vertices.first()?;
        source.densities.by_camera = source.density_from(first.at.p, subpath.pdf_to_start);
        let rules = LightSampling {
            choice: self.light_choice,
            ..LightSampling::default()
        };
        let (lights, receiver) = (&scene.lights, first.receiver());
        let pdf = lights.pdf_nee::<E>(light, &sample, rules, &receiver, time);
        source.nee_pdf = match source.can_be_hit {
            true => source.density_from(receiver.p, PdfSolidAngle(pdf)),
            false => f64::from(pdf),
        };
        Some(LightSubpath {
            source,
            #[cfg(test)]
            ray_density,
            subpath,
        })
    }
}
