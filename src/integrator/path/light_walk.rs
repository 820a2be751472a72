//! The walk of light paths: sixteen at a time from surface to surface, each of which is connected to the lens.
//!
//! The stages are those of camera paths. Throughputs are of power, and relative to the flux of the first ray; the ratio of
//! a block is that of scattering and the light path, for a light that can be hit (`light_paths/weights.rs`).
//!
//! Measure: radiance times the number of light paths, divided by their number for each camera path.
//! Range: any scene; without a bounce limit a path ends by absorption, by leaving the scene, or by roulette.
//! Source: Veach 1997, section 10.3.4. Tested in `tests/rendering/light_paths.rs`.

use super::super::SampleLanes;
use super::super::bidirectional::vertex::{Densities, Vertex, adjoint};
use super::super::indirect::Indirect;
use super::super::light_paths::source::LightPathSource;
use super::super::light_paths::weights::{End, LightRatios, of_camera, passage};
use super::super::light_paths::{LightPathSplat, LightPathSplats};
use super::super::observer::Unobserved;
use super::super::technique::TechniqueSource;
use super::block::PathBlock;
use super::light_paths::facing;
use super::shading::{BsdfLanes, StageMemory};
use super::{PathIntegrator, PathMemory, Walk};
use crate::bsdf::BsdfSample;
use crate::camera::FilmPoint;
use crate::effects::{Effects, Slot, Switch};
use crate::film::splats::Splat;
use crate::light::types::{Receiver, ShadowRayEnd};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec2, Vec3};
use crate::planted::planted;
use crate::sampler::{Decision, LaneStates, Sampler};
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;
use crate::scene::{Scene, ShapeTraits};

/// The first ray of a light path, and what its weights need of the first surface.
#[derive(Debug, Clone, Copy)]
pub struct LightPathStart {
    source: LightPathSource,
    /// The density of light sampling over that of scattering, beyond the first surface.
    nee_over_scattering: f32,
}

/// Light at the surfaces of a block that scatters towards the camera.
struct TowardsCamera {
    /// The lanes with such light.
    lit: ActiveLanes<LANES>,
    /// The BSDFs with the factors of light paths: the cosine, and the adjoint of shading normals.
    factor: Lanes3,
    /// The densities with which camera paths continue towards the light.
    pdf_to_light: Lanes<f32>,
    /// The lanes where the light goes through the surface.
    goes_through: ActiveLanes<LANES>,
    /// The densities of light sampling for the surface as seen from the camera, where it is seen differently from there.
    receivers: Lanes<Option<Receiver>>,
}

/// A surface that is connected to a point of the lens.
#[derive(Debug, Clone, Copy, Default)]
struct Connection {
    lens: Vec3,
    film: FilmPoint,
    distance2: f32,
    /// The ratio of the densities of a light path and of a camera path at the lens.
    of_camera: f32,
}

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Traces a light path for each active lane of the samples, at its time; the counts of their rays are stored in the
    /// samples. There is a sampler for each lane, in order.
    pub(super) fn walk_from_lights<E: Effects, S: Sampler>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut [SampleLanes],
        memory: &mut PathMemory<E>,
        splats: &mut LightPathSplats<'_>,
    ) {
        let PathMemory {
            paths,
            stage,
            starts,
        } = memory;
        starts.clear();
        for (samplers, samples) in samplers.chunks_mut(LANES).zip(&mut *samples) {
            starts.extend(self.emit::<E, S>(scene, samplers, samples));
        }
        paths.begin(samples);
        let mut walk = Walk {
            scene,
            samples,
            samplers,
            observer: &mut Unobserved,
            bounce: 0,
        };
        let most = self.max_bounces.unwrap_or(u32::MAX);
        while !paths.is_empty() && walk.bounce < most {
            for block in paths.blocks_mut() {
                walk.trace_extension_rays(block);
                self.advance_from_lights(&mut walk, block, stage, starts, splats);
            }
            paths.compact();
            walk.bounce += 1;
        }
    }

    /// Samples the first rays of light paths, and deactivates the lanes that have none. Returns the start of each lane.
    fn emit<E: Effects, S: Sampler>(
        &self,
        scene: &Scene,
        samplers: &mut [S],
        samples: &mut SampleLanes,
    ) -> Lanes<Option<LightPathStart>> {
        let mut starts = [None; LANES];
        let (active, places) = (samples.active, std::array::from_fn(|lane| lane as u32));
        if !active.any() {
            return starts;
        }
        let states = LaneStates::gather(samplers, &active, &places);
        let (mut source, mut direction) = ([[0.0; LANES]; 4], [[0.0; LANES]; 3]);
        let decision = Decision::Source;
        S::draw_lanes(samplers, &active, &places, &states, decision, &mut source);
        let decision = Decision::SourceDirection;
        S::draw_lanes(
            samplers,
            &active,
            &places,
            &states,
            decision,
            &mut direction,
        );
        for lane in active.each() {
            let time = samples.packet.rays.time[lane];
            let numbers = (source.map(|u| u[lane]), direction.map(|u| u[lane]));
            let source = LightPathSource::sample::<E>(scene, numbers, time);
            samples.active.set(lane, source.is_some());
            if let Some(source) = source {
                samples.packet.rays.set(lane, &source.sample.ray());
                starts[lane] = Some(LightPathStart {
                    source,
                    nee_over_scattering: 0.0,
                });
            }
        }
        starts
    }

    /// Takes the light paths of a block, whose rays have been traced, to their next vertices: connects these to the lens, and
    /// sets the extension rays of the paths that continue.
    fn advance_from_lights<E: Effects, S: Sampler>(
        &self,
        walk: &mut Walk<'_, S, Unobserved>,
        block: &mut PathBlock<E>,
        stage: &mut StageMemory<E>,
        starts: &mut [Option<LightPathStart>],
        splats: &mut LightPathSplats<'_>,
    ) {
        let (scene, bounce) = (walk.scene, walk.bounce);
        let arrived = block.active;
        if bounce == 0 {
            for lane in arrived.each() {
                block.count_rays(lane, true, false);
            }
        }
        arrive(walk, block, stage);
        if block.active.any() {
            self.look_up_bsdfs(scene, block, stage);
            let nee = if bounce == 0 {
                self.begin_from_lights(scene, block, stage, starts)
            } else {
                [0.0; LANES]
            };
            self.connect(walk, block, stage, starts, &nee, splats);
            if self.max_bounces == Some(bounce + 1) {
                block.active = ActiveLanes::NONE;
            } else {
                let states = LaneStates::gather(walk.samplers, &block.active, &block.path);
                let decision = Decision::LightPathBsdf(bounce);
                let lit = &ActiveLanes::NONE;
                self.sample_bsdfs(walk, block, stage, &states, lit, decision);
                self.carry_power(scene, block, stage, bounce, starts, &nee);
                let decision = Decision::LightPathRoulette(bounce);
                self.scatter(walk, block, stage, &states, decision);
                self.pass_ratios(block, stage);
            }
        }
        for lane in arrived.without(&block.active).each() {
            block.end(lane, walk.samples);
        }
    }

    /// Sets the ratios of the paths of a block at the first surface. Returns the densities of light sampling there.
    fn begin_from_lights<E: Effects>(
        &self,
        scene: &Scene,
        block: &mut PathBlock<E>,
        stage: &StageMemory<E>,
        starts: &[Option<LightPathStart>],
    ) -> Lanes<f32> {
        let mut nee = [0.0; LANES];
        for lane in block.active.each() {
            let Some(LightPathStart { source, .. }) = &starts[block.path[lane] as usize] else {
                continue;
            };
            let at: Interaction<E> = stage.at.get(lane);
            block.set_light_path_ratio(lane, 1.0 / source.density(scene, at.p));
            if !stage.bsdfs.delta.has(lane) {
                let transmits = stage.at.traits[lane] & ShapeTraits::TRANSMITS != 0;
                let receiver = at.receiver(transmits);
                nee[lane] = self.density_of_nee(scene, source, &receiver, block, lane);
            }
        }
        nee
    }

    /// The density with which light sampling at a receiver finds the source of a light path.
    fn density_of_nee<E: Effects>(
        &self,
        scene: &Scene,
        source: &LightPathSource,
        receiver: &Receiver,
        block: &PathBlock<E>,
        lane: usize,
    ) -> f32 {
        let time = block.packet.rays.time[lane];
        source.density_of_nee::<E>(scene, self.light_choice, self.map, receiver, time)
    }

    /// Connects the surfaces of a block to points of the lens, given the densities of light sampling at the first surface.
    fn connect<E: Effects, S: Sampler>(
        &self,
        walk: &mut Walk<'_, S, Unobserved>,
        block: &mut PathBlock<E>,
        stage: &mut StageMemory<E>,
        starts: &[Option<LightPathStart>],
        nee: &Lanes<f32>,
        splats: &mut LightPathSplats<'_>,
    ) {
        let (scene, is_first) = (walk.scene, walk.bounce == 0);
        let mut seen = block.active.without(&stage.bsdfs.delta);
        let mut to_lens = [[0.0; LANES]; 3];
        let mut connections = [Connection::default(); LANES];
        for lane in seen.each() {
            let p = load(&stage.at.p, lane);
            let connection = self.lens_seen_from(walk, block, lane, p);
            let connection = connection.filter(|it| (splats.reaches)(it.film.position));
            seen.set(lane, connection.is_some());
            if let Some(connection) = connection {
                connections[lane] = connection;
                store(&mut to_lens, lane, (connection.lens - p).normalize());
            }
        }
        if !seen.any() {
            return;
        }
        let StageMemory {
            at,
            bsdfs,
            direct_light,
            ..
        } = stage;
        let towards = towards_camera::<E>(scene, &seen, at, bsdfs, &to_lens);
        let lights = &mut *direct_light;
        lights.to_shadow = ActiveLanes::NONE;
        let mut gains = [Rgb::BLACK; LANES];
        for lane in towards.lit.each() {
            let Some(start) = &starts[block.path[lane] as usize] else {
                continue;
            };
            let Connection {
                lens,
                film,
                distance2,
                of_camera,
            } = connections[lane];
            let at: Interaction<E> = at.get(lane);
            let w: Vec3 = load(&to_lens, lane);
            let to_eye = End {
                pdf: 1.0,
                cos: w.dot(at.ng),
            };
            let to_light = End {
                pdf: towards.pdf_to_light[lane],
                cos: at.wo.dot(at.ng),
            };
            let ratio = block.light_path_ratio().map_or(0.0, |ratios| ratios[lane]);
            let by_scattering = ratio * passage(to_light, to_eye);
            let by_nee = if is_first {
                let l = match &towards.receivers[lane] {
                    Some(receiver) => {
                        self.density_of_nee(scene, &start.source, receiver, block, lane)
                    }
                    None => nee[lane],
                };
                ratio * passage(End { pdf: l, ..to_light }, to_eye)
            } else {
                by_scattering * start.nee_over_scattering
            };
            let can_be_met = start.source.can_be_met();
            let ratios = LightRatios {
                by_scattering: if can_be_met { by_scattering } else { 0.0 },
                by_nee,
            };
            let importance = planted!(
                "light-paths-without-importance",
                1.0,
                film.per_steradian as f32
            );
            let of_eye = importance / (distance2 * self.light_paths.share.number());
            let flux = start.source.flux * load::<Rgb>(&block.beta, lane);
            let value =
                flux * load::<Rgb>(&towards.factor, lane) * (of_eye * ratios.weight(of_camera));
            if value.is_black() {
                continue;
            }
            store(&mut lights.contribution, lane, value);
            if splats.with_gains {
                let unweighted = value * (1.0 / ratios.weight(of_camera));
                let gain = ratios.gain(of_camera);
                gains[lane] = unweighted * unweighted * gain;
            }
            let end = ShadowRayEnd::Point(lens);
            let ray = at.ray_to(&end, w, towards.goes_through.has(lane));
            lights.shadow.set(lane, &ray);
            lights.shadow.time[lane] = block.packet.rays.time[lane];
            lights.to_shadow.set(lane, true);
            block.count_rays(lane, false, true);
        }
        let visible = scene.visibilities::<E>(&lights.to_shadow, &mut lights.shadow);
        for lane in lights.to_shadow.each() {
            if visible[lane] > 0.0 {
                let value = load::<Rgb>(&lights.contribution, lane) * visible[lane];
                let film = connections[lane].film.position;
                splats.splats.push(LightPathSplat {
                    path: block.path[lane],
                    splat: Splat { film, value },
                    gain: gains[lane] * visible[lane],
                });
            }
        }
    }

    /// A point of the lens as seen from the point `p`, if it shows that on the film.
    fn lens_seen_from<E: Effects, S: Sampler>(
        &self,
        walk: &mut Walk<'_, S, Unobserved>,
        block: &PathBlock<E>,
        lane: usize,
        p: Vec3,
    ) -> Option<Connection> {
        let (camera, time) = (&walk.scene.camera, block.packet.rays.time[lane]);
        let mut u_lens = [0.0; 2];
        if E::Lens::ON {
            let sampler = &mut walk.samplers[block.path[lane] as usize];
            u_lens = sampler.draw(Decision::Lens(walk.bounce));
        }
        let lens = camera.viewpoint::<E>(Vec2::from(u_lens), time);
        let way = lens.p - p;
        let distance2 = way.length_squared();
        let to_film = -way / distance2.sqrt();
        let film = lens.film_point(to_film)?;
        let per_steradian = if E::Lens::ON {
            // Rays through the middle of the lens give the density of rays through any of its points.
            let middle = camera.viewpoint::<E>(Vec2::splat(0.5), time);
            middle.film_point(to_film)?.per_steradian
        } else {
            film.per_steradian
        };
        let over_film_density = self.light_paths.over_film_density();
        Some(Connection {
            lens: lens.p,
            film,
            distance2,
            of_camera: of_camera(over_film_density, distance2, per_steradian as f32),
        })
    }

    /// Changes the BSDF samples of a block from factors of radiance to factors of power, computes the densities with which
    /// camera paths continue in the reverse directions, and keeps the ratio of both densities of the first surface.
    fn carry_power<E: Effects>(
        &self,
        scene: &Scene,
        block: &PathBlock<E>,
        stage: &mut StageMemory<E>,
        bounce: u32,
        starts: &mut [Option<LightPathStart>],
        nee: &Lanes<f32>,
    ) {
        let StageMemory {
            at,
            bsdfs,
            scattering,
            light_paths,
            ..
        } = stage;
        let Some(lanes) = light_paths.get_mut() else {
            return;
        };
        let mut w = [[0.0; LANES]; 3];
        to_world::<E>(at, &scattering.wi, &mut w);
        let sampled = block.active.and(|lane| scattering.sampled.has(lane));
        let delta = sampled.and(|lane| scattering.pdf[lane] == f32::INFINITY);
        let rough = sampled.without(&delta);
        let towards = towards_camera::<E>(scene, &rough, at, bsdfs, &w);
        scattering.sampled = towards.lit.and(|lane| scattering.pdf[lane] > 0.0);
        lanes.of_scattered = towards.pdf_to_light;
        for lane in scattering.sampled.each() {
            let factor = load::<Rgb>(&towards.factor, lane) * (1.0 / scattering.pdf[lane]);
            store(&mut scattering.weight, lane, factor);
            scattering.eta2[lane] = 1.0;
            scattering.goes_through[lane] = u32::from(towards.goes_through.has(lane));
            if bounce == 0
                && let Some(start) = &mut starts[block.path[lane] as usize]
            {
                let l = match &towards.receivers[lane] {
                    Some(receiver) => {
                        self.density_of_nee(scene, &start.source, receiver, block, lane)
                    }
                    None => nee[lane],
                };
                start.nee_over_scattering = l / towards.pdf_to_light[lane];
            }
        }
        for lane in delta.each() {
            let sample = BsdfSample {
                wi: load(&scattering.wi, lane),
                weight: load(&scattering.weight, lane),
                pdf: None,
                lobe: scattering.lobes[lane],
            };
            let vertex = vertex(scene, at, lane);
            let wo = vertex.at.frame.to_local(vertex.at.wo);
            let (to_eye, to_light) = (load(&w, lane), vertex.at.wo);
            let scattered = vertex.delta_scattering(scene, &sample, to_eye, to_light);
            // A reflection about a tilted normal is not found in the reverse direction.
            let Some(scattered) = scattered.filter(|it| it.pdf_to_eye.0 > 0.0) else {
                continue;
            };
            // Radiance is divided by eta^2 on the way into glass, power is not.
            let eta = if wo.z > 0.0 {
                vertex.bsdf.ior()
            } else {
                1.0 / vertex.bsdf.ior()
            };
            let eta2 = if scattered.goes_through {
                eta * eta
            } else {
                1.0
            };
            let of_power = planted!("light-paths-thinned-as-radiance", 1.0, eta2);
            let factor = scattered.to_eye * (scattered.adjoint * of_power);
            store(&mut scattering.weight, lane, factor);
            scattering.eta2[lane] = 1.0;
            scattering.goes_through[lane] = u32::from(scattered.goes_through);
            scattering.sampled.set(lane, true);
        }
    }
}

/// Computes the surface interactions of a block of light paths, and deactivates the lanes that have none, or that absorb all
/// light.
fn arrive<E: Effects, S: Sampler>(
    walk: &mut Walk<'_, S, Unobserved>,
    block: &mut PathBlock<E>,
    stage: &mut StageMemory<E>,
) {
    let (samplers, path, bounce) = (&mut *walk.samplers, &block.path, walk.bounce);
    let u_alpha = |lane: usize| {
        let sampler = &mut samplers[path[lane] as usize];
        let [u] = sampler.draw(Decision::LightPathAlpha(bounce));
        u
    };
    let StageMemory { surfaces, at, .. } = stage;
    let found = walk.scene.surface_interactions::<E>(
        &block.active,
        &block.packet,
        &block.excluded,
        u_alpha,
        surfaces,
        at,
    );
    block.active = found.and(|lane| {
        let traits = at.traits[lane];
        let is_opaque = traits & ShapeTraits::TRANSMITS == 0;
        let is_one_sided = E::OneSided::ON & (traits & ShapeTraits::IS_ONE_SIDED != 0);
        !(is_one_sided & is_opaque & at.is_behind(lane))
    });
}

/// The vertex of a lane, for what is not computed in lanes.
fn vertex<'a, E: Effects>(
    scene: &'a Scene,
    at: &InteractionLanes<E>,
    lane: usize,
) -> Vertex<'a, E> {
    let at: Interaction<E> = at.get(lane);
    Vertex::new(scene, at, Rgb::WHITE, Densities::default(), [0.0; 4])
}

/// Evaluates the scattering of the light that arrives along the rays of some lanes towards the camera along the unit vectors
/// `w`, without delta lobes.
fn towards_camera<E: Effects>(
    scene: &Scene,
    lanes: &ActiveLanes<LANES>,
    at: &InteractionLanes<E>,
    bsdfs: &mut BsdfLanes<E>,
    w: &Lanes3,
) -> TowardsCamera {
    let mut towards = TowardsCamera {
        lit: *lanes,
        factor: [[0.0; LANES]; 3],
        pdf_to_light: [0.0; LANES],
        goes_through: ActiveLanes::NONE,
        receivers: [None; LANES],
    };
    let (mut to_eye, mut to_light) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    diffuse::<E>(at, bsdfs, w, &mut to_eye, &mut to_light, &mut towards);
    if let Some(stage) = bsdfs.principled.get_mut()
        && stage.active.any()
    {
        stage.bsdfs.bind(&to_eye);
        stage.bsdfs.eval(&to_light, &mut stage.f, &mut stage.pdf);
        for (to, of) in towards.factor.iter_mut().zip(&stage.f) {
            super::scattering::replace(&stage.active, to, of);
        }
        super::scattering::replace(&stage.active, &mut towards.pdf_to_light, &stage.pdf);
    }
    carry_light::<E>(at, w, &to_light, &mut towards);
    for lane in lanes.each() {
        let of_lane: Interaction<E> = at.get(lane);
        let may_be_mended = || {
            let along: Vec3 = load(w, lane);
            !of_lane.is_flat() && (of_lane.is_mended() || facing(at, lane, along).is_mended())
        };
        if !bsdfs.singly.has(lane) && !may_be_mended() {
            continue;
        }
        let vertex = vertex(scene, at, lane);
        let w = load(w, lane);
        let scattering = vertex.scattering(scene, w, vertex.at.wo);
        towards.lit.set(lane, scattering.is_some());
        if let Some(scattering) = scattering {
            store(
                &mut towards.factor,
                lane,
                scattering.to_eye * scattering.adjoint,
            );
            towards.pdf_to_light[lane] = scattering.pdf_to_light.0;
            towards.goes_through.set(lane, scattering.goes_through);
            let seen = vertex.at.facing(w, vertex.transmits);
            towards.receivers[lane] = Some(seen.receiver(vertex.transmits));
        }
    }
    towards
}

vectorised! {
    /// The directions `wi` of the shading frames in the world.
    fn to_world<E: Effects>(at: &InteractionLanes<E>, wi: &Lanes3, w: &mut Lanes3) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            store(w, lane, at.frame.to_world(load::<LaneVec3>(wi, lane)));
        }
    }
}

vectorised! {
    /// The values of diffuse surfaces and their densities, and the directions to both ends in the shading frames.
    fn diffuse<E: Effects>(
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
        w: &Lanes3,
        to_eye: &mut Lanes3,
        to_light: &mut Lanes3,
        towards: &mut TowardsCamera,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let eye = at.frame.to_local(load::<LaneVec3>(w, lane));
            let light = at.frame.to_local(at.wo);
            let value = bsdfs.diffuse(lane).eval(eye, light);
            store(to_eye, lane, eye);
            store(to_light, lane, light);
            store(&mut towards.factor, lane, value.f);
            towards.pdf_to_light[lane] = value.pdf.0;
        }
    }
}

vectorised! {
    /// Multiplies the values of opaque surfaces by the factors of light paths, and marks those that are lit.
    fn carry_light<E: Effects>(
        at: &InteractionLanes<E>,
        w: &Lanes3,
        to_light: &Lanes3,
        towards: &mut TowardsCamera,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let along: LaneVec3 = load(w, lane);
            let f: Rgb<LaneVec3> = load(&towards.factor, lane);
            let light: LaneVec3 = load(to_light, lane);
            let cos = light.z.abs();
            let factor = f * (cos * adjoint(&at, along, at.wo));
            let is_lit = towards.lit.has(lane) & at.agrees(along, false) & !factor.is_black();
            store(&mut towards.factor, lane, factor);
            towards.lit.set(lane, is_lit);
        }
    }
}
