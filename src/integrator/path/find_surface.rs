//! The first surface of a path with a given property, without light sampling: the vertices of a path do not depend on its
//! light samples.
//!
//! Measure: none.
//! Range: one path at a time, by any technique; roulette may end it before.
//! Source: the stages of `trace_wavefront`. Tested in `tests/rendering/irradiance_cache.rs`.

use super::super::indirect::Indirect;
use super::super::observer::NullPathObserver;
use super::super::technique::TechniqueSource;
use super::super::{CameraRay, SampleLanes};
use super::{PathIntegrator, PathScratch, PathWavefront};
use crate::accel::Hit;
use crate::bsdf::Bsdf;
use crate::effects::Effects;
use crate::math::lanes::ActiveLanes;
use crate::sampler::{Decision, LaneStates, Sampler};
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use std::slice;

impl<C: TechniqueSource, K: Indirect> PathIntegrator<C, K> {
    /// Traces one path, without light sampling, to the first surface for which `find` returns a value, and returns that
    /// value.
    pub fn find_surface<E: Effects, S: Sampler, T>(
        &self,
        scene: &Scene,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        scratch: &mut PathScratch<E>,
        mut find: impl FnMut(&Interaction<E>, &Bsdf, u32) -> Option<T>,
    ) -> Option<T> {
        let PathScratch { paths, stage, .. } = scratch;
        let mut samples = SampleLanes::default();
        samples.add(0, camera_ray, hit);
        let mut wavefront = PathWavefront {
            scene,
            samples: slice::from_mut(&mut samples),
            samplers: slice::from_mut(sampler),
            observer: &mut NullPathObserver,
            bounce: 0,
        };
        paths.begin(wavefront.samples);
        let block = paths.blocks_mut().first_mut()?;
        let mut found = None;
        while block.active.any() {
            self.add_emission(&mut wavefront, block, stage);
            if block.active.any() {
                let at: Interaction<E> = stage.at.get(0);
                found = find(&at, &scene.bsdf(&at), wavefront.bounce);
                if found.is_some() {
                    break;
                }
                self.look_up_bsdfs(scene, block, stage);
                let states =
                    LaneStates::gather(wavefront.samplers, &block.active, &block.sample_index);
                let nee_lanes = &ActiveLanes::NONE;
                let decision = Decision::Bsdf(wavefront.bounce);
                self.sample_bsdfs(&mut wavefront, block, stage, &states, nee_lanes, decision);
                let decision = Decision::Roulette(wavefront.bounce);
                self.scatter(&mut wavefront, block, stage, &states, decision);
                wavefront.trace_extension_rays(block);
                wavefront.bounce += 1;
            }
        }
        found
    }
}
