//! The weights of camera paths against light paths: the densities with which a light path finds the same path.
//!
//! Each path carries the ratio of the density of a light path to its own, over the density e of the ray with which the
//! light path would begin (`light_paths/weights.rs`).
//!
//! Measure: ratios of densities of whole paths; densities per steradian.
//! Range: any block. Without light paths the ratios are zero, which changes no weight.
//! Source: as in `light_paths/weights.rs`. Tested in `tests/rendering/light_paths.rs`.

use super::super::indirect::Indirect;
use super::super::light_paths::source::{densities_of_light_samples, density_of_ray};
use super::super::light_paths::weights::{DirectionPdf, camera_vertex_ratio, vertex_ratio};
use super::super::observer::PathObserver;
use super::super::technique::TechniqueSource;
use super::block::PathBlock;
use super::scattering::replace;
use super::shading::{DirectLightLanes, LightPathLanes, PrincipledStage, StageScratch, to_world};
use super::{PathIntegrator, PathWavefront};
use crate::effects::{Effects, Slot, Switch};
use crate::light::types::ShadowRayEnd;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, vectorised};
use crate::math::vec::{LaneVec3, Vec2, Vec3};
use crate::planted::planted;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;
use crate::scene::{Scene, ShapeTraits};
use std::f32::consts::FRAC_1_PI;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Whether the kernel has light paths and the settings ask for them.
    #[inline(always)]
    pub(super) fn has_light_paths<E: Effects>(&self) -> bool {
        E::LightPaths::ON && self.light_paths.is_on()
    }

    /// Computes the densities of light paths at the surfaces of a block, whose BSDFs are sampled, and at the light samples
    /// of the lanes `nee_lanes`.
    pub(super) fn compute_light_path_ratios<E: Effects, S, O: PathObserver + ?Sized>(
        &self,
        wavefront: &PathWavefront<'_, S, O>,
        block: &mut PathBlock<E>,
        stage: &mut StageScratch<E>,
        nee_lanes: &ActiveLanes<LANES>,
    ) {
        if !self.has_light_paths::<E>() {
            return;
        }
        let scene = wavefront.scene;
        if wavefront.bounce == 0 {
            // The surface that the camera sees is connected to the lens, with certainty.
            self.begin_ratios(scene, block, &stage.at);
            if let Some(lanes) = stage.light_paths.get_mut() {
                lanes.reverse_pdf_of_light_sample = [1.0; LANES];
                lanes.reverse_pdf_of_bsdf_sample = [1.0; LANES];
            }
        }
        if planted!("first-surface-makes-a-caustic", true, wavefront.bounce > 0) {
            block.meet_surfaces(&stage.at.traits);
        }
        let nee_lanes = &self.light_path_lanes(block, nee_lanes);
        if wavefront.bounce > 0 {
            reverse_densities(scene, &block.active, stage, nee_lanes);
        }
        let StageScratch {
            at,
            direct_light,
            light_paths,
            ..
        } = stage;
        let (Some(lanes), Some(ratios)) = (light_paths.get_mut(), block.light_path_ratio()) else {
            return;
        };
        let lit = nee_lanes.and(|lane| {
            let ratio = ratios[lane] * lanes.reverse_pdf_of_light_sample[lane];
            ratio > 0.0 && direct_light.samples.is_sampled(lane)
        });
        let (context, samples) = (&direct_light.context, &direct_light.samples);
        let e = densities_of_light_samples(scene, &lit, context, samples, &at.p);
        compare_with_nee::<E>(at, ratios, &e, &lit, direct_light, lanes);
    }

    /// The lanes, among the given ones, whose path light paths find, if it ends at its current surface.
    #[inline(always)]
    pub(super) fn light_path_lanes<E: Effects>(
        &self,
        block: &PathBlock<E>,
        lanes: &ActiveLanes<LANES>,
    ) -> ActiveLanes<LANES> {
        if self.light_paths.caustics_only {
            lanes.and(|lane| block.is_caustic(lane))
        } else {
            *lanes
        }
    }

    /// Sets the ratios of the paths of a block at the surfaces that the camera sees.
    fn begin_ratios<E: Effects>(
        &self,
        scene: &Scene,
        block: &mut PathBlock<E>,
        at: &InteractionLanes<E>,
    ) {
        let over_film_density = planted!(
            "light-paths-counted-per-pixel",
            self.light_paths.share.number(),
            self.light_paths.expected_count()
        );
        let active = block.active;
        for lane in active.each() {
            let (ray, time) = block.packet.ray(lane);
            // Rays through the middle of the lens give the density of rays through any of its points.
            let middle = scene.camera.viewpoint::<E>(Vec2::splat(0.5), time);
            let film = middle.film_point(ray.dir);
            let distance2 = load::<Vec3>(&at.p, lane).distance_squared(ray.origin);
            let ratio = film.map_or(0.0, |film| {
                camera_vertex_ratio(over_film_density, distance2, film.per_steradian as f32)
            });
            block.set_light_path_ratio(lane, ratio);
        }
    }

    /// Multiplies the ratios of the paths of a block by the factors of the surfaces that they leave.
    pub(super) fn multiply_by_vertex_ratios<E: Effects>(
        &self,
        block: &mut PathBlock<E>,
        stage: &StageScratch<E>,
    ) {
        let (at, scattering) = (&stage.at, &stage.scattering);
        if let (Some(lanes), Some(ratios)) = (stage.light_paths.get(), block.light_path_ratio_mut())
        {
            let (wi, pdf) = (&scattering.wi, &scattering.pdf);
            multiply_ratios::<E>(at, wi, pdf, &lanes.reverse_pdf_of_bsdf_sample, ratios);
        }
    }

    /// Multiplies the ratios of camera paths by the factors of the surfaces that they leave, and sets them to zero
    /// where no light path finds the path.
    pub(super) fn update_camera_path_ratios<E: Effects>(
        &self,
        bounce: u32,
        block: &mut PathBlock<E>,
        stage: &StageScratch<E>,
    ) {
        if !self.has_light_paths::<E>() {
            return;
        }
        self.multiply_by_vertex_ratios(block, stage);
        let (at, scattering) = (&stage.at, &stage.scattering);
        let delta = block
            .active
            .and(|lane| scattering.pdf[lane] == f32::INFINITY);
        for lane in delta.each() {
            // The lens cannot be connected to a delta lobe, and a reflection about a tilted normal is not found in the
            // reverse direction.
            let is_lost = bounce == 0 || is_tilted(at, lane, &scattering.wi);
            if is_lost {
                block.set_light_path_ratio(lane, 0.0);
            }
        }
    }

    /// The ratio of the densities of a light path and of the path of a lane, without that of the light path's first ray; zero
    /// where no light path finds it.
    fn ratio_of_lane<E: Effects>(&self, block: &PathBlock<E>, lane: usize) -> f32 {
        let is_found = !self.light_paths.caustics_only || block.is_caustic(lane);
        match block.light_path_ratio() {
            Some(ratios) if is_found => ratios[lane],
            _ => 0.0,
        }
    }

    /// The ratio of the densities of a light path and of the path that has hit an emitting surface.
    pub(super) fn light_path_ratio_at_emitter<E: Effects>(
        &self,
        scene: &Scene,
        block: &PathBlock<E>,
        lane: usize,
        at: &Interaction<E>,
    ) -> f32 {
        let ratio = self.ratio_of_lane(block, lane);
        if ratio == 0.0 {
            return 0.0;
        }
        let (end, time) = (
            ShadowRayEnd::Surface(at.surface_point(), [0.0; 2]),
            block.packet.rays.time[lane],
        );
        let light = scene.light_of(at);
        let e = light.map(|light| density_of_ray(scene, light, time, &end, at.wo, at.p));
        e.map_or(0.0, |e| e * ratio)
    }

    /// The ratio of the densities of a light path and of the path that has left the scene along `dir` to the environment
    /// map, which is this light.
    pub(super) fn light_path_ratio_at_environment<E: Effects>(
        &self,
        scene: &Scene,
        block: &PathBlock<E>,
        lane: usize,
        dir: Vec3,
        light: u32,
    ) -> f32 {
        let ratio = self.ratio_of_lane(block, lane);
        if ratio == 0.0 {
            return 0.0;
        }
        let (ray, time) = block.packet.ray(lane);
        ratio
            * density_of_ray(
                scene,
                light,
                time,
                &ShadowRayEnd::Infinity,
                -dir,
                ray.origin,
            )
    }
}

/// Computes the densities with which light paths continue towards the camera, for the light samples of the lanes
/// `nee_lanes` and for the sampled directions of the active lanes.
fn reverse_densities<E: Effects>(
    scene: &Scene,
    active: &ActiveLanes<LANES>,
    stage: &mut StageScratch<E>,
    nee_lanes: &ActiveLanes<LANES>,
) {
    let StageScratch {
        at,
        bsdfs,
        direct_light,
        scattering,
        light_paths,
        ..
    } = stage;
    let Some(lanes) = light_paths.get_mut() else {
        return;
    };
    let to_light = &direct_light.samples.wi;
    diffuse::<E>(at, to_light, &scattering.wi, lanes);
    if let Some(stage) = bsdfs.principled.get_mut()
        && stage.active.any()
    {
        let PrincipledStage {
            active,
            reverse_pdf_of_light_sample,
            reverse_pdf_of_bsdf_sample,
            ..
        } = stage;
        for (to, of) in [
            (
                &mut lanes.reverse_pdf_of_light_sample,
                reverse_pdf_of_light_sample,
            ),
            (
                &mut lanes.reverse_pdf_of_bsdf_sample,
                reverse_pdf_of_bsdf_sample,
            ),
        ] {
            replace(active, to, of);
        }
    }
    let mut scattered = [[0.0; LANES]; 3];
    to_world::<E>(at, &scattering.wi, &mut scattered);
    for (w, lanes_with_w, pdf) in [
        (
            &scattered,
            scattering
                .sampled
                .and(|lane| scattering.pdf[lane] != f32::INFINITY),
            &mut lanes.reverse_pdf_of_bsdf_sample,
        ),
        (to_light, *nee_lanes, &mut lanes.reverse_pdf_of_light_sample),
    ] {
        let lanes_with_w = active.and(|lane| lanes_with_w.has(lane));
        let tilted = tilted_lanes::<E>(at, w, &lanes_with_w);
        let one_by_one = lanes_with_w.and(|lane| bsdfs.scalar_lanes.has(lane) || tilted.has(lane));
        for lane in one_by_one.each() {
            pdf[lane] = reverse_density(scene, at, lane, load(w, lane));
        }
    }
}

/// The surface of a lane as seen along the unit vector `w`.
fn with_wo<E: Effects>(at: &InteractionLanes<E>, lane: usize, w: Vec3) -> Interaction<E> {
    let transmits = at.traits[lane] & ShapeTraits::TRANSMISSIVE != 0;
    at.get::<Vec3>(lane).with_wo(w, transmits)
}

/// Whether the shading normal of a lane is tilted for either direction of a sample, `wi` in the shading frame.
fn is_tilted<E: Effects>(at: &InteractionLanes<E>, lane: usize, wi: &Lanes3) -> bool {
    let seen: Interaction<E> = at.get(lane);
    let wi = seen.frame.to_world(load(wi, lane));
    [seen.wo, wi].iter().any(|&w| seen.is_tilted_for(w))
}

/// The density with which a light path that arrives from the unit vector `wi` continues towards the camera.
fn reverse_density<E: Effects>(
    scene: &Scene,
    at: &InteractionLanes<E>,
    lane: usize,
    wi: Vec3,
) -> f32 {
    let from_light = with_wo(at, lane, wi);
    let seen: Interaction<E> = at.get(lane);
    let [from, to] = [wi, seen.wo].map(|w| from_light.frame.to_local(w));
    scene.bsdf(&seen).eval::<E>(from, to).pdf.0
}

vectorised! {
    /// The ratios of the densities of a light path and of light sampling in the given lanes, zero in the others: `e` are the
    /// densities of the light paths' first rays.
    fn compare_with_nee<E: Effects>(
        at: &InteractionLanes<E>,
        ratios: &Lanes<f32>,
        e: &Lanes<f32>,
        lit: &ActiveLanes<LANES>,
        direct_light: &DirectLightLanes,
        lanes: &mut LightPathLanes,
    ) {
        let (context, samples) = (&direct_light.context, &direct_light.samples);
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let wi: LaneVec3 = load(&samples.wi, lane);
            let of_delta_light = samples.pdf[lane] == f32::INFINITY;
            let nee = DirectionPdf {
                pdf: if of_delta_light { context.pmf[lane] } else { samples.pdf[lane] },
                cos: wi.dot(at.ng),
            };
            let to_camera = DirectionPdf {
                pdf: ratios[lane] * lanes.reverse_pdf_of_light_sample[lane],
                cos: at.wo.dot(at.ng),
            };
            let over_nee = e[lane] * vertex_ratio(to_camera, nee);
            lanes.light_path_over_nee[lane] = if lit.has(lane) { over_nee } else { 0.0 };
        }
    }
}

vectorised! {
    /// The lanes, among the given ones, whose shading normal is tilted for `wo` or for the unit vector `w`.
    pub(super) fn tilted_lanes<E: Effects>(
        at: &InteractionLanes<E>,
        w: &Lanes3,
        lanes: &ActiveLanes<LANES>,
    ) -> ActiveLanes<LANES> {
        let mut tilted = ActiveLanes::NONE;
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let is_tilted = at.is_tilted_for(at.wo) | at.is_tilted_for(load(w, lane));
            tilted.set(lane, lanes.has(lane) & is_tilted);
        }
        tilted
    }
}

vectorised! {
    /// The densities of diffuse surfaces.
    fn diffuse<E: Effects>(
        at: &InteractionLanes<E>,
        to_light: &Lanes3,
        scattered: &Lanes3,
        lanes: &mut LightPathLanes,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let wo = at.frame.to_local(at.wo);
            let to_light_local = at.frame.to_local(load::<LaneVec3>(to_light, lane));
            let wi: LaneVec3 = load(scattered, lane);
            let pdf = wo.z.abs() * FRAC_1_PI;
            lanes.reverse_pdf_of_light_sample[lane] = if to_light_local.z * wo.z > 0.0 { pdf } else { 0.0 };
            lanes.reverse_pdf_of_bsdf_sample[lane] = if wi.z * wo.z > 0.0 { pdf } else { 0.0 };
        }
    }
}

vectorised! {
    /// Multiplies ratios by the factors of surfaces that scatter along `wi`, in their shading frames, with the density
    /// `pdf`; by 1 at delta lobes.
    fn multiply_ratios<E: Effects>(
        at: &InteractionLanes<E>,
        wi: &Lanes3,
        pdf: &Lanes<f32>,
        reverse_pdf_of_bsdf_sample: &Lanes<f32>,
        ratios: &mut Lanes<f32>,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let wi = at.frame.to_world(load::<LaneVec3>(wi, lane));
            let to_camera = DirectionPdf { pdf: reverse_pdf_of_bsdf_sample[lane], cos: at.wo.dot(at.ng) };
            let to_light = DirectionPdf { pdf: pdf[lane], cos: wi.dot(at.ng) };
            let is_delta = pdf[lane] == f32::INFINITY;
            ratios[lane] *= if is_delta { 1.0 } else { vertex_ratio(to_camera, to_light) };
        }
    }
}
