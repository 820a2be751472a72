//! The queues of a wavefront of paths, whose rays are traced in packets.
//!
//! All paths take one step, and then all of their rays are traced: packets are full, however many paths have ended, and
//! shading and traversal do not evict each other's code and data from the processor's caches after every ray.
//!
//! Measure: normalised scene units; radiance.
//! Range: any number of paths.
//! Source: Wald et al. 2001, "Interactive Rendering with Coherent Ray Tracing", for ray packets; Laine, Karras and Aila
//! 2013, "Megakernels Considered Harmful", for one step of all paths at a time. Tested in
//! `tests/rendering/determinism.rs`, where replays trace paths one by one, and in `lab/tests/bench/report.rs`.

use super::super::observer::PathObserver;
use crate::accel::packet::RayQueue;
use crate::bsdf::BsdfSampleInput;
use crate::effects::Effects;
use crate::light::types::{LightSample, LightSampleContext};
use crate::math::lanes::LANES;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::planted::planted;
use crate::scene::Scene;

/// The number of paths in a wavefront: enough to fill packets and lanes while some paths end, and to switch rarely
/// between the stages' code; few enough, at some 900 bytes each, to stay in a processor's second-level cache.
pub const WAVEFRONT_SIZE: usize = 256;

/// The queues of a wavefront of paths, whose memory is reused.
#[derive(Debug, Default)]
pub struct PathQueues {
    /// The shadow rays.
    pub(super) shadow_rays: ShadowRays,
    /// The extension rays of the paths that continue.
    pub(super) extension_rays: RayQueue,
    /// The indices of the active paths, which continue, in the order of their rays.
    pub(super) active: Vec<usize>,
    /// For each path, the light that was last chosen by light sampling, if any.
    pub(super) chosen: Vec<Option<u32>>,
    /// The indices of the paths that sample a light.
    pub(super) nee_paths: Vec<usize>,
    /// The random numbers that choose their lights and points on them.
    pub(super) light_u: Vec<[f32; 4]>,
    /// The inputs of light sampling for up to [`LANES`] of them.
    pub(super) light_contexts: Vec<LightSampleContext>,
    /// The light samples for these inputs.
    pub(super) samples: Vec<Option<LightSample>>,
    /// The random numbers that choose directions, as drawn.
    pub(super) bsdf_u: Vec<[f32; 3]>,
    /// The inputs of BSDF sampling, made of these numbers.
    pub(super) bsdf_inputs: Vec<BsdfSampleInput>,
    /// The random numbers of Russian roulette.
    pub(super) roulette: Vec<f32>,
}

impl PathQueues {
    /// Begins a wavefront of `count` paths, all of which are active.
    pub(super) fn begin(&mut self, count: usize) {
        self.chosen.clear();
        self.chosen.resize(count, None);
        self.active.clear();
        self.active.extend(0..count);
    }
}

/// The queued shadow rays, with their contributions to their paths.
#[derive(Debug, Default)]
pub struct ShadowRays {
    rays: RayQueue,
    lights: Vec<ShadowItem>,
}

/// The contribution of a shadow ray to its path if it is not occluded.
#[derive(Debug, Clone, Copy)]
struct ShadowItem {
    path: usize,
    contribution: Rgb,
    weight: f32,
}

impl ShadowRays {
    /// Queues a shadow ray, with its contribution to the path with this index if it is not occluded. `weight` is the
    /// MIS weight, which `contribution` includes.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        path: usize,
        contribution: Rgb,
        weight: f32,
        ray: &Ray,
        time: f32,
    ) {
        let then = planted!("shadows-as-the-shutter-opens", 0.0, time);
        self.lights.push(ShadowItem {
            path,
            contribution,
            weight,
        });
        self.rays.push(ray, then, None);
    }

    /// Traces all queued shadow rays, and calls `add` with each path's index and visible contribution.
    #[inline]
    pub(super) fn trace<E: Effects, O: PathObserver + ?Sized>(
        &mut self,
        scene: &Scene,
        observer: &mut O,
        mut add: impl FnMut(usize, Rgb),
    ) {
        let packets = self.rays.packets_mut().iter_mut();
        for (rays, lights) in packets.zip(self.lights.chunks(LANES)) {
            let visible = scene.visibilities::<E>(rays);
            for (light, visible) in lights.iter().zip(visible) {
                observer.light(light.contribution, light.weight, visible);
                if visible > 0.0 {
                    add(light.path, light.contribution * visible);
                }
            }
        }
        self.rays.clear();
        self.lights.clear();
    }
}
