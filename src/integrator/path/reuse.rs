//! Path reuse between the pixels of a group: each pixel is connected to the second surface of every path.
//!
//! Let x_k be the surface that pixel k of a group sees, and y_j the next surface of pixel j's path, both matte. If p_k is
//! the density with which the path of pixel k is scattered, in directions,
//!
//!   g_k(y) = p_k(x_k -> y) |cos at y| V(x_k, y) / |y - x_k|^2
//!
//! is the density per area of the second surfaces of pixel k. Multiple importance sampling with the balance heuristic
//! over the pixels of the group gives the indirect light of pixel i,
//!
//!   I_i = sum_j f_i(y_j) |cos at x_i| |cos at y_j| V(x_i, y_j) / |y_j - x_i|^2  L(y_j) / (q_j sum_k g_k(y_j)),
//!
//! where L is the radiance that y_j reflects and q_j the probability with which path j has survived roulette at x_j. The
//! weights g_j / sum_k g_k of the ways to find one y add up to one, and no term grows as y_j comes near to x_i, since
//! the same distance is in the denominator. The denominator holds the visibilities as well: without them, the pixels
//! that cannot find y would be counted. The path beyond y_j is traced once, with its throughput reset to the sum of
//! these factors over i, so that roulette sees the light that all pixels take. Emission of y_j and direct light at x_i,
//! which have their own weights, are not shared.
//!
//! A pixel k shares if x_k is matte and not black: paths end on black surfaces, so that their pixels find no y. This
//! depends on no sampled direction and is the same for every j. A second surface y is shared if it is matte with no
//! interpolated normal, which depends on y alone. A pixel on the other side of y's surface takes no part, neither in
//! the sum over i nor in that over k. Any other path is not shared: it counts for its own pixel alone, with weight one.
//!
//! Measure: radiance; densities per area of normalised scene units.
//! Range: kernels with `Reuse`, of scenes without motion and alpha. A path whose own density is zero or infinite by
//! rounding is not shared.
//! Source: Bekaert, Sbert and Halton 2002, "Accelerating Path Tracing by Re-Using Paths"; Veach 1997, section 9.2.
//! Tested in `tests/rendering/reuse.rs`.

use super::super::SampleLanes;
use super::super::reuse::PathReuse;
use super::block::PathBlock;
use super::shading::BsdfLanes;
use crate::accel::lanes::RayLanes;
use crate::bsdf::{BsdfValue, Diffuse};
use crate::effects::Effects;
use crate::geometry::surface::SurfacePoint;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vector};
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;

/// The surfaces that sixteen pixels see, and the paths that they share.
#[derive(Debug)]
struct SharedPaths<E: Effects> {
    first: InteractionLanes<E>,
    reflectance: Lanes3,
    /// The pixels that share.
    pixels: ActiveLanes<LANES>,
    /// The paths that are shared.
    paths: ActiveLanes<LANES>,
    /// The light that a shared path has found up to its second surface, for its own pixel alone.
    own: Lanes3,
    /// The weight in each pixel, for each path, of the light found beyond its second surface.
    factors: [Lanes3; LANES],
}

impl<E: Effects> Default for SharedPaths<E> {
    fn default() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self {
            first: InteractionLanes::default(),
            reflectance: zero,
            pixels: ActiveLanes::NONE,
            paths: ActiveLanes::NONE,
            own: zero,
            factors: [zero; LANES],
        }
    }
}

/// The paths that are shared in a wavefront. The memory is kept.
#[derive(Debug)]
pub struct ReuseScratch<E: Effects> {
    packets: Vec<SharedPaths<E>>,
    connections: Connections,
}

impl<E: Effects> Default for ReuseScratch<E> {
    fn default() -> Self {
        Self {
            packets: Vec::new(),
            connections: Connections::default(),
        }
    }
}

/// The connections of sixteen pixels to a second surface.
#[repr(align(64))]
#[derive(Debug, Default)]
struct Connections {
    /// The densities g_k of the surface without visibility; zero where a pixel cannot find it.
    density: Lanes<f32>,
    /// The factors f |cos| |cos| / r^2 of the radiance that the surface reflects.
    factor: Lanes3,
    /// The rays from the pixels' surfaces.
    rays: RayLanes<LANES>,
}

/// A second surface.
#[derive(Debug, Clone, Copy)]
struct SecondSurface {
    point: SurfacePoint<LaneVec3>,
    /// The geometric normal on the side from which the path has come.
    normal: LaneVec3,
}

impl<E: Effects> ReuseScratch<E> {
    /// Begins a wavefront of this many packets of samples.
    pub(super) fn begin(&mut self, packets: usize) {
        if self.packets.len() < packets {
            self.packets.resize_with(packets, SharedPaths::default);
        }
        for shared in &mut self.packets {
            shared.pixels = ActiveLanes::NONE;
            shared.paths = ActiveLanes::NONE;
        }
    }

    /// Keeps the first surfaces of a block of paths, if these are those of a whole packet of pixels.
    pub(super) fn store_first_hits(
        &mut self,
        block: &PathBlock<E>,
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
    ) {
        let (first, last) = (
            block.sample_index[0] as usize,
            block.sample_index[LANES - 1] as usize,
        );
        if first % LANES != 0 || last != first + LANES - 1 {
            return;
        }
        let shared = &mut self.packets[first / LANES];
        shared.first.clone_from(at);
        let matte = bsdfs.diffuse_lanes(&block.active);
        let mut reflects = ActiveLanes::NONE;
        for lane in matte.each() {
            let reflectance = bsdfs.diffuse_bsdf(lane).reflectance();
            store(&mut shared.reflectance, lane, reflectance);
            reflects.set(lane, reflectance.max_channel() > 0.0);
        }
        let matte = planted!("reuse-counts-black-pixels", matte, reflects);
        shared.pixels = planted!(
            "reuse-judged-at-one-pixel",
            if matte.has(0) {
                block.active
            } else {
                ActiveLanes::NONE
            },
            matte
        );
    }

    /// Shares the second surfaces of a block of paths with the other pixels of their groups.
    pub(super) fn share(
        &mut self,
        scene: &Scene,
        reuse: PathReuse,
        block: &mut PathBlock<E>,
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
    ) {
        for lane in bsdfs.diffuse_lanes(&block.active).each() {
            let path = block.sample_index[lane] as usize;
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let shared = &mut self.packets[path / LANES];
            if !shared.pixels.has(path % LANES) || !at.is_flat() {
                continue;
            }
            let pixels = reuse.group_of(path % LANES);
            let pixels = pixels.and(|pixel| shared.pixels.has(pixel));
            shared.take(
                scene,
                (path % LANES, pixels),
                &at,
                (lane, &mut *block),
                &mut self.connections,
            );
        }
    }

    /// Distributes the light of the shared paths, all of which have ended, over the samples.
    pub(super) fn distribute(&self, samples: &mut [SampleLanes]) {
        for (shared, samples) in self.packets.iter().zip(samples) {
            if !shared.paths.any() {
                continue;
            }
            let shared_light = samples.radiance;
            for path in shared.paths.each() {
                store(&mut samples.radiance, path, load::<Rgb>(&shared.own, path));
            }
            for path in shared.paths.each() {
                let light: Rgb = load(&shared_light, path);
                add(&shared.factors[path], light.into(), &mut samples.radiance);
            }
        }
    }
}

impl<E: Effects> SharedPaths<E> {
    /// Shares the second surface `at` of a path with these pixels, and begins its throughput anew.
    fn take(
        &mut self,
        scene: &Scene,
        (path, pixels): (usize, ActiveLanes<LANES>),
        at: &Interaction<E, LaneVec3>,
        (lane, block): (usize, &mut PathBlock<E>),
        connections: &mut Connections,
    ) {
        let second = SecondSurface {
            point: at.surface_point(),
            normal: at.exit_normal(false),
        };
        evaluate_connections::<E>(&pixels, &self.first, &self.reflectance, second, connections);
        let Connections {
            density,
            factor,
            rays,
        } = connections;
        if density[path] == 0.0 {
            return;
        }
        let mut queried = pixels.and(|pixel| density[pixel] > 0.0);
        // The path's own segment is unoccluded, so that it needs no shadow ray.
        queried.set(path, false);
        let mut visible = [0.0; LANES];
        if queried.any() {
            visible = scene.visibilities::<E>(&queried, rays);
        }
        visible[path] = 1.0;
        let sum: f32 = (0..LANES)
            .map(|pixel| {
                planted!(
                    "reuse-without-visibility",
                    density[pixel],
                    density[pixel] * visible[pixel]
                )
            })
            .sum();
        // The throughput is the albedo over the probability of survival.
        let [beta, albedo] = [&block.beta, &self.reflectance];
        let beta = load::<Rgb>(beta, lane).max_channel();
        let albedo = load::<Rgb>(albedo, path).max_channel();
        let scale = beta / (albedo * sum);
        if !(scale.is_finite() && scale > 0.0) {
            return;
        }
        let mut total = Rgb::BLACK;
        for (pixel, visible) in visible.iter().enumerate() {
            let taken = load::<Rgb>(factor, pixel) * (scale * visible);
            store(factor, pixel, taken);
            total += taken;
        }
        let throughput = total.max_channel();
        for (to, of) in self.factors[path].iter_mut().zip(&*factor) {
            for (to, of) in to.iter_mut().zip(of) {
                *to = of / throughput;
            }
        }
        self.paths.set(path, true);
        store(&mut self.own, path, load::<Rgb>(&block.radiance, lane));
        store(&mut block.radiance, lane, Rgb::BLACK);
        store(&mut block.beta, lane, throughput * Rgb::WHITE);
        block.count_shadow_rays(lane, queried.count() as u32);
    }
}

vectorised! {
    /// Evaluates the connections of the pixels to a second surface.
    fn evaluate_connections<E: Effects>(
        pixels: &ActiveLanes<LANES>,
        first: &InteractionLanes<E>,
        reflectance: &Lanes3,
        second: SecondSurface,
        connections: &mut Connections,
    ) {
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = first.get(lane);
            let to = second.point.p - at.p;
            let distance2 = to.dot(to);
            let wi = to * (1.0 / distance2.sqrt());
            let bsdf = Diffuse::<LaneVec3>::new(load(reflectance, lane));
            let [wo_local, wi_local] = [at.wo, wi].map(|w| at.frame.to_local(w));
            let BsdfValue { f, pdf } = bsdf.eval(wo_local, wi_local);
            let cos = -wi.dot(second.normal);
            let area = cos / distance2;
            let density = pdf.0 * planted!("reuse-without-cosine", 1.0 / distance2, area);
            let reaches = pixels.has(lane)
                & (cos > 0.0)
                & at.is_consistent_side(wi, false)
                & (density > 0.0)
                & (density < f32::INFINITY);
            connections.density[lane] = if reaches { density } else { 0.0 };
            let factor = f * (wi_local.z().abs() * area);
            let none = Rgb::<LaneVec3>::from([0.0; 3]);
            store(&mut connections.factor, lane, if reaches { factor } else { none });
            let ray = at.ray_to_surface(&second.point, wi, false);
            connections.rays.set(lane, &ray);
            connections.rays.time[lane] = 0.0;
        }
    }
}

vectorised! {
    /// Adds a path's light, times the factor of each pixel, where that is not zero.
    fn add(factors: &Lanes3, light: [f32; 3], to: &mut Lanes3) {
        for (channel, to) in to.iter_mut().enumerate() {
            for lane in 0..LANES {
                let (factor, kept) = (factors[channel][lane], to[lane]);
                let sum = kept + factor * light[channel];
                to[lane] = if factor > 0.0 { sum } else { kept };
            }
        }
    }
}
