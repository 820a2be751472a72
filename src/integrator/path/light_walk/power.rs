//! The scattering of light paths: factors of power in place of those of radiance, and the densities of camera paths in the
//! reverse directions.
//!
//! Measure: factors of throughputs; densities per steradian.
//! Range: sampled BSDFs of any kind.
//! Source: Veach 1997, section 5.3, for the adjoint of shading normals and of refraction. Tested in
//! `tests/rendering/light_paths.rs`.

use super::super::super::indirect::Indirect;
use super::super::super::technique::TechniqueSource;
use super::super::PathIntegrator;
use super::super::block::PathBlock;
use super::super::shading::{ScatteringLanes, StageScratch, to_world};
use super::LightPathStart;
use super::towards_camera::{towards_camera, vertex};
use crate::bsdf::BsdfSample;
use crate::effects::{Effects, Slot};
use crate::math::lanes::{LANES, load, store};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::interaction::lanes::InteractionLanes;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Changes the BSDF samples of a block from factors of radiance to factors of power, computes the densities with which
    /// camera paths continue in the reverse directions, and keeps the ratio of both densities of the first surface.
    pub(super) fn convert_to_power<E: Effects>(
        &self,
        scene: &Scene,
        block: &PathBlock<E>,
        stage: &mut StageScratch<E>,
        bounce: u32,
        starts: &mut [Option<LightPathStart>],
    ) {
        let StageScratch {
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
        let non_delta = sampled.without(&delta);
        let towards = towards_camera::<E>(scene, &non_delta, at, bsdfs, &w, true);
        scattering.sampled = towards.active.and(|lane| scattering.pdf[lane] > 0.0);
        lanes.reverse_pdf_of_bsdf_sample = towards.pdf_to_light;
        for lane in scattering.sampled.each() {
            let factor = load::<Rgb>(&towards.factor, lane) * (1.0 / scattering.pdf[lane]);
            store(&mut scattering.weight, lane, factor);
            scattering.eta2[lane] = 1.0;
            scattering.is_transmitted[lane] = u32::from(towards.is_transmitted.has(lane));
            if bounce == 0
                && let Some(start) = &mut starts[block.sample_index[lane] as usize]
            {
                let receiver = towards.receivers[lane].as_ref();
                let nee = self.density_of_nee(scene, start, receiver, block, lane);
                start.nee_over_scattering = nee / towards.pdf_to_light[lane];
            }
        }
        for lane in delta.each() {
            convert_delta_to_power::<E>(scene, at, load(&w, lane), scattering, lane);
        }
    }
}

/// Changes a sample of a delta lobe, along the unit vector `to_camera`, from a factor of radiance to one of power.
fn convert_delta_to_power<E: Effects>(
    scene: &Scene,
    at: &InteractionLanes<E>,
    to_camera: Vec3,
    scattering: &mut ScatteringLanes,
    lane: usize,
) {
    let sample = BsdfSample {
        wi: load(&scattering.wi, lane),
        weight: load(&scattering.weight, lane),
        pdf: None,
        lobe: scattering.lobes[lane],
    };
    let vertex = vertex(scene, at, lane);
    let wo = vertex.at.frame.to_local(vertex.at.wo);
    let to_light = vertex.at.wo;
    let scattered = vertex.delta_scattering(scene, &sample, to_camera, to_light);
    // A reflection about a tilted normal is not found in the reverse direction.
    let Some(scattered) = scattered.filter(|it| it.pdf_to_camera.0 > 0.0) else {
        return;
    };
    // Radiance is divided by eta^2 on the way into glass, power is not.
    let eta = if wo.z > 0.0 {
        vertex.bsdf.ior()
    } else {
        1.0 / vertex.bsdf.ior()
    };
    let eta2 = if scattered.is_transmitted {
        eta * eta
    } else {
        1.0
    };
    let of_power = planted!("light-paths-thinned-as-radiance", 1.0, eta2);
    let factor = scattered.to_camera * (scattered.adjoint * of_power);
    store(&mut scattering.weight, lane, factor);
    scattering.eta2[lane] = 1.0;
    scattering.is_transmitted[lane] = u32::from(scattered.is_transmitted);
    scattering.sampled.set(lane, true);
}
