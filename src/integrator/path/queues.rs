//! What waits while paths are followed side by side: their rays, to be traced in packets.
//!
//! All paths go one step, and then all of their rays are traced: packets are whole, however many paths have ended, and neither
//! the code nor the data of the one are driven out of the processor's caches by the other after every ray.
//!
//! Measure: normalised scene units; radiance.
//! Range: any number of paths.
//! Source: Wald et al. 2001, "Interactive Rendering with Coherent Ray Tracing", for rays in packets; Laine, Karras and Aila
//! 2013, "Megakernels Considered Harmful", for one step of all paths at a time. Tested in
//! `tests/rendering/determinism.rs`, where replays follow paths one by one, and in `lab/tests/bench/report.rs`.

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

/// How many paths are best followed side by side: enough to fill packets of rays and lanes while some of them end, and to come
/// to each stage's code seldom; few enough to stay in a processor's second cache, some 900 bytes each.
pub const WAVEFRONT_SIZE: usize = 256;

/// What waits while paths are followed side by side: memory to be used again.
#[derive(Debug, Default)]
pub struct PathQueues {
    /// Rays to lights.
    pub(super) shadow_rays: ShadowRays,
    /// Rays of paths that go on.
    pub(super) extension_rays: RayQueue,
    /// The paths that go on, by their numbers, in the order of their rays.
    pub(super) active: Vec<usize>,
    /// For each path, the light that the last surface looked for, where that matters.
    pub(super) chosen: Vec<Option<u32>>,
    /// The paths that look for a light.
    pub(super) nee_paths: Vec<usize>,
    /// The numbers that choose their lights and points on them.
    pub(super) light_u: Vec<[f32; 4]>,
    /// What some of them ask.
    pub(super) light_contexts: Vec<LightSampleContext>,
    /// What answers they get.
    pub(super) samples: Vec<Option<LightSample>>,
    /// The numbers that decide on directions, as they are drawn.
    pub(super) bsdf_u: Vec<[f32; 3]>,
    /// The same, as surfaces ask for them.
    pub(super) bsdf_inputs: Vec<BsdfSampleInput>,
    /// And on who goes on.
    pub(super) roulette: Vec<f32>,
}

impl PathQueues {
    /// Waits for so many paths, all of which go on.
    pub(super) fn begin(&mut self, count: usize) {
        self.chosen.clear();
        self.chosen.resize(count, None);
        self.active.clear();
        self.active.extend(0..count);
    }
}

/// Rays to lights that are yet to be traced, with what they add to their paths.
#[derive(Debug, Default)]
pub struct ShadowRays {
    rays: RayQueue,
    lights: Vec<ShadowItem>,
}

/// What a path gets if its light is visible.
#[derive(Debug, Clone, Copy)]
struct ShadowItem {
    path: usize,
    contribution: Rgb,
    weight: f32,
}

impl ShadowRays {
    /// A ray to a light that adds so much to the path with this number, if nothing is in the way. `weight` is part of it.
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

    /// Traces them all, and tells what each path gets.
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
