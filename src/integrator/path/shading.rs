//! The BSDFs at the surfaces of a block, and the buffers of the stages of a bounce.
//!
//! Measure: as each field says.
//! Range: any block.
//! Source: none needed.

use crate::accel::lanes::RayLanes;
use crate::bsdf::principled::lanes::{PrincipledLanes, SampledLanes};
use crate::bsdf::{Diffuse, Lobe};
use crate::effects::{EffectState, Effects, Slot};
use crate::light::lanes::{LightContextLanes, LightSampleLanes};
use crate::light::select::LightLanes;
use crate::light::types::Receiver;
use crate::math::lanes::ActiveLanes;
use crate::math::lanes::{LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::vec::{LaneVec3, Vec2};
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::{InteractionLanes, SurfaceScratch};

/// The scratch space of the stages of a bounce.
#[derive(Debug)]
pub struct StageScratch<E: Effects> {
    pub surfaces: SurfaceScratch<E>,
    /// The surface interactions.
    pub at: InteractionLanes<E>,
    pub bsdfs: BsdfLanes<E>,
    pub direct_light: DirectLightLanes,
    pub scattering: ScatteringLanes,
    pub light_paths: EffectState<E::LightPaths, LightPathLanes>,
}

impl<E: Effects> Default for StageScratch<E> {
    fn default() -> Self {
        Self {
            surfaces: SurfaceScratch::default(),
            at: InteractionLanes::default(),
            bsdfs: BsdfLanes::default(),
            direct_light: DirectLightLanes::default(),
            scattering: ScatteringLanes::default(),
            light_paths: Slot::new(LightPathLanes::default),
        }
    }
}

/// Light samples, their contributions and their shadow rays.
#[repr(align(64))]
#[derive(Debug)]
pub struct DirectLightLanes {
    /// The surfaces as receivers of light.
    pub receivers: Receiver<Lanes3>,
    /// The inputs of light sampling.
    pub context: LightContextLanes,
    pub samples: LightSampleLanes,
    /// The values of the BSDFs, and their densities.
    pub f: Lanes3,
    pub pdf_bsdf: Lanes<f32>,
    /// The contributions to the paths' radiance if the shadow rays are not occluded, with the MIS weights that they
    /// include.
    pub contribution: Lanes3,
    pub weight: Lanes<f32>,
    pub shadow: RayLanes<LANES>,
    /// The lanes with a shadow ray.
    pub shadow_ray_lanes: ActiveLanes<LANES>,
    /// The selected lights.
    pub lights: LightLanes,
}

impl Default for DirectLightLanes {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            receivers: Receiver::default(),
            context: LightContextLanes::default(),
            samples: LightSampleLanes::default(),
            f: [zero; 3],
            pdf_bsdf: zero,
            contribution: [zero; 3],
            weight: zero,
            shadow: RayLanes::default(),
            shadow_ray_lanes: ActiveLanes::NONE,
            lights: LightLanes::default(),
        }
    }
}

/// Sampled directions.
#[repr(align(64))]
#[derive(Debug)]
pub struct ScatteringLanes {
    /// The random numbers: two for the direction, one for the lobe.
    pub numbers: [Lanes<f32>; 3],
    /// The random numbers of Russian roulette.
    pub roulette: Lanes<f32>,
    /// The cosine-weighted directions of the random numbers.
    pub cosine_direction: Lanes3,
    /// The lanes with a sample.
    pub sampled: ActiveLanes<LANES>,
    /// The directions in the shading frames.
    pub wi: Lanes3,
    /// The factors of the throughputs, and the densities: infinite for delta lobes.
    pub weight: Lanes3,
    pub pdf: Lanes<f32>,
    /// Whether the direction is transmitted, and eta^2 if it is.
    pub is_transmitted: Lanes<u32>,
    pub eta2: Lanes<f32>,
    /// The lobes of samples; diffuse for diffuse surfaces.
    pub lobes: [Lobe; LANES],
    /// The lanes whose paths were scattered, with their throughputs, directions and survival probabilities.
    pub scattered: ActiveLanes<LANES>,
    pub beta: Lanes3,
    pub survival: Lanes<f32>,
}

impl Default for ScatteringLanes {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            numbers: [zero; 3],
            roulette: zero,
            cosine_direction: [zero; 3],
            sampled: ActiveLanes::NONE,
            wi: [zero; 3],
            weight: [zero; 3],
            pdf: zero,
            is_transmitted: [0; LANES],
            eta2: zero,
            lobes: [Lobe::Diffuse; LANES],
            scattered: ActiveLanes::NONE,
            beta: [zero; 3],
            survival: zero,
        }
    }
}

/// The densities of light paths at the surfaces of a block.
#[repr(align(64))]
#[derive(Debug, Clone, Copy)]
pub struct LightPathLanes {
    /// The densities with which light paths that arrive along the light samples continue towards the camera.
    pub reverse_pdf_of_light_sample: Lanes<f32>,
    /// The densities of light paths that arrive against the sampled directions.
    pub reverse_pdf_of_bsdf_sample: Lanes<f32>,
    /// The ratios of the densities of a light path and of light sampling, for the light samples.
    pub light_path_over_nee: Lanes<f32>,
}

impl Default for LightPathLanes {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            reverse_pdf_of_light_sample: zero,
            reverse_pdf_of_bsdf_sample: zero,
            light_path_over_nee: zero,
        }
    }
}

/// The BSDFs at the surfaces of a block.
#[repr(align(64))]
#[derive(Debug)]
pub struct BsdfLanes<E: Effects> {
    /// The lanes whose BSDF is not evaluated in lanes.
    pub scalar_lanes: ActiveLanes<LANES>,
    /// The lanes whose BSDF has delta lobes alone.
    pub delta: ActiveLanes<LANES>,
    /// The reflectances of the lanes whose BSDF is diffuse and evaluated in lanes.
    reflectance: Lanes3,
    pub principled: EffectState<E::Glossy, PrincipledStage>,
}

/// The principled BSDFs and the conductors at the surfaces of a block that are evaluated in lanes.
#[derive(Debug, Clone, Copy)]
pub struct PrincipledStage {
    /// The lanes that have one.
    pub active: ActiveLanes<LANES>,
    pub bsdfs: PrincipledLanes,
    /// The directions `wo`, and those to the light samples, in the shading frames.
    pub wo: Lanes3,
    pub to_light: Lanes3,
    pub sampled: SampledLanes,
    /// The values of the BSDFs, and their densities.
    pub f: Lanes3,
    pub pdf: Lanes<f32>,
    /// The densities of sampling `wo` from the light samples and from the sampled directions, in kernels with light paths.
    pub reverse_pdf_of_light_sample: Lanes<f32>,
    pub reverse_pdf_of_bsdf_sample: Lanes<f32>,
}

impl Default for PrincipledStage {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            active: ActiveLanes::NONE,
            bsdfs: PrincipledLanes::default(),
            wo: [zero; 3],
            to_light: [zero; 3],
            sampled: SampledLanes::default(),
            f: [zero; 3],
            pdf: zero,
            reverse_pdf_of_light_sample: zero,
            reverse_pdf_of_bsdf_sample: zero,
        }
    }
}

vectorised! {
    /// The directions `w` in the shading frames.
    pub(super) fn to_local<E: Effects>(at: &InteractionLanes<E>, w: &Lanes3, local: &mut Lanes3) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            store(local, lane, at.frame.to_local(load::<LaneVec3>(w, lane)));
        }
    }
}

vectorised! {
    /// The directions `wi` of the shading frames in the world.
    pub(super) fn to_world<E: Effects>(at: &InteractionLanes<E>, wi: &Lanes3, w: &mut Lanes3) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = at.get(lane);
            store(w, lane, at.frame.to_world(load::<LaneVec3>(wi, lane)));
        }
    }
}

impl<E: Effects> Default for BsdfLanes<E> {
    fn default() -> Self {
        Self {
            scalar_lanes: ActiveLanes::NONE,
            delta: ActiveLanes::NONE,
            reflectance: [[0.0; LANES]; 3],
            principled: Slot::new(PrincipledStage::default),
        }
    }
}

impl<E: Effects> BsdfLanes<E> {
    /// Looks up the BSDFs of the active lanes, and binds those that are principled to `wo`. If `all_scalar`, none is
    /// evaluated in lanes.
    #[inline(always)]
    pub fn look_up(
        &mut self,
        scene: &Scene,
        active: &ActiveLanes<LANES>,
        at: &InteractionLanes<E>,
        all_scalar: bool,
    ) {
        self.scalar_lanes = ActiveLanes::NONE;
        self.delta = ActiveLanes::NONE;
        if let Some(principled) = self.principled.get_mut() {
            principled.active = ActiveLanes::NONE;
            principled.bsdfs.clear();
        }
        for lane in active.each() {
            let at: Interaction<E> = at.get(lane);
            let material = scene.material(at.id);
            let uv = at.uv.or(Vec2::ZERO);
            if !all_scalar && let Some(reflectance) = material.diffuse_reflectance::<E>(uv) {
                store(&mut self.reflectance, lane, reflectance);
            } else if !all_scalar
                && let Some(stage) = self.principled.get_mut()
                && let Some((bsdf, place)) = material.rough_bsdf::<E>(uv)
            {
                stage.active.set(lane, true);
                stage.bsdfs.set(lane, &bsdf, place);
            } else {
                self.scalar_lanes.set(lane, true);
                self.delta.set(lane, material.is_delta::<E>());
            }
        }
        if let Some(stage) = self.principled.get_mut()
            && stage.active.any()
        {
            to_local::<E>(at, &at.wo, &mut stage.wo);
            stage.bsdfs.bind(&stage.wo);
        }
    }

    /// The lanes among the given ones whose BSDF is diffuse and evaluated in lanes.
    pub fn diffuse_lanes(&self, lanes: &ActiveLanes<LANES>) -> ActiveLanes<LANES> {
        let rest = lanes.without(&self.scalar_lanes);
        match self.principled.get() {
            Some(stage) => rest.without(&stage.active),
            None => rest,
        }
    }

    /// The diffuse BSDF of a lane.
    #[inline(always)]
    pub fn diffuse_bsdf(&self, lane: usize) -> Diffuse<LaneVec3> {
        let own = planted!("reflectance-of-the-next-lane", lane ^ 1, lane);
        Diffuse::new(load(&self.reflectance, own))
    }
}
