//! Path reuse between the pixels of a group: each pixel is connected to the second surface of every path.
//!
//! Let x_k be the surface that pixel k of a group sees, and y_j the next surface of pixel j's path, at first a matte one. If
//! p_k is the density with which the path of pixel k is scattered, in directions,
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
//! Where y_j is rough, not matte, it reflects other radiance to each pixel. The light samples at y_j, and the direction w in which
//! its BSDF scatters the path, are then shared, too. With p(w | x_k) the density of w for a path that comes from x_k, the light
//! that arrives at y_j along w is divided by
//!
//!   sum_k g_k(y_j) p(w | x_k)                    if the BSDF sampled w,
//!   p_light(w) sum_k g_k(y_j)                    if light sampling did,
//!
//! and weighted between these two by the power heuristic of p_light and the mean of p(w | x_k), with the weights g_k. So no
//! pixel takes much light from a direction that its own paths rarely take, and the others often.
//!
//! A pixel k shares if x_k is opaque, not black and not a mirror: paths end on black surfaces, so that their pixels find no y.
//! This depends on no sampled direction and is the same for every j. A second surface y is shared if it is matte or rough, which
//! depends on y alone. A pixel on the other side of y's surface, or one for which y's shading normal is tilted, takes no part,
//! neither in the sum over i nor in that over k: to it, y reflects other radiance than to the rest. Any other path is not
//! shared: it counts for its own pixel alone, with weight one.
//!
//! Measure: radiance; densities per area of normalised scene units.
//! Range: kernels with `Reuse`, of scenes without motion and alpha. A path whose own density is zero or infinite by
//! rounding is not shared.
//! Source: Bekaert, Sbert and Halton 2002, "Accelerating Path Tracing by Re-Using Paths"; Veach 1997, section 9.2.
//! Tested in `tests/rendering/reuse.rs`.

mod first_surfaces;
mod rough;

use super::super::SampleLanes;
use super::super::reuse::PathReuse;
use super::block::PathBlock;
use super::shading::{BsdfLanes, DirectLightLanes, ScatteringLanes};
use crate::effects::{EffectState, Effects, Slot};
use crate::math::lanes::{ActiveLanes, LANES, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec3};
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;
use first_surfaces::{Connections, FirstSurfaces, rough_lanes};
use rough::{
    LightAtRough, RoughSecondSurface, SeenSurface, directions_to_first_surfaces, is_positive,
    normalise,
};

/// The least number of shadow rays to one point that are traced as a coherent packet. Measured on whole renders of the
/// cornell-box: 15 rays in a packet take 0.73 times as long as one by one, three rays 1.05 times.
const MIN_COHERENT: usize = 8;

/// The surfaces that sixteen pixels see, and the paths that they share.
#[derive(Debug)]
struct SharedPaths<E: Effects> {
    first: FirstSurfaces<E>,
    /// The pixels that share.
    pixels: ActiveLanes<LANES>,
    /// The paths that are shared.
    paths: ActiveLanes<LANES>,
    /// The light that a shared path has found up to its second surface, for its own pixel alone.
    own: Lanes3,
    /// The weight in each pixel, for each path, of the light found beyond its second surface.
    factors: [Lanes3; LANES],
    /// The light that light sampling finds at rough second surfaces.
    at_rough: EffectState<E::Glossy, LightAtRough>,
}

impl<E: Effects> Default for SharedPaths<E> {
    fn default() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self {
            first: FirstSurfaces::default(),
            pixels: ActiveLanes::NONE,
            paths: ActiveLanes::NONE,
            own: zero,
            factors: [zero; LANES],
            at_rough: Slot::new(LightAtRough::default),
        }
    }
}

/// The paths that are shared in a wavefront. The memory is kept.
#[derive(Debug)]
pub struct ReuseScratch<E: Effects> {
    packets: Vec<SharedPaths<E>>,
    connections: Connections,
    /// The rough second surfaces of the current block of paths.
    rough: Vec<RoughSecondSurface>,
    seen: SeenSurface,
}

impl<E: Effects> Default for ReuseScratch<E> {
    fn default() -> Self {
        Self {
            packets: Vec::new(),
            connections: Connections::default(),
            rough: Vec::new(),
            seen: SeenSurface::default(),
        }
    }
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
            if let Some(at_rough) = shared.at_rough.get_mut() {
                at_rough.paths = ActiveLanes::NONE;
            }
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
        let pixels = shared.first.set(block, at, bsdfs);
        shared.pixels = planted!(
            "reuse-judged-at-one-pixel",
            if pixels.has(0) {
                block.active
            } else {
                ActiveLanes::NONE
            },
            pixels
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
        self.rough.clear();
        let diffuse = bsdfs.diffuse_lanes(&block.active);
        let rough = rough_lanes(bsdfs);
        let active = block.active;
        for lane in active.each() {
            let is_diffuse = diffuse.has(lane);
            if !(is_diffuse || rough.has(lane)) {
                continue;
            }
            let sample = block.sample_index[lane] as usize;
            let path = sample % LANES;
            let shared = &mut self.packets[sample / LANES];
            // A delta lobe scatters paths of its own pixel alone.
            if !shared.pixels.has(path) || block.prev_vertex(lane).is_none() {
                continue;
            }
            let pixels = reuse.group_of(path);
            let pixels = pixels.and(|pixel| shared.pixels.has(pixel));
            let at: Interaction<E, LaneVec3> = at.get(lane);
            let connections = &mut self.connections;
            let Some(connected) = shared.connect(scene, (path, pixels), &at, connections) else {
                continue;
            };
            let is_shared = match is_diffuse {
                true => shared.take_diffuse((path, lane), block, connections),
                false => {
                    let second = shared.take_rough((sample, lane), block, &at, connections);
                    let is_shared = second.is_some();
                    self.rough.extend(second);
                    is_shared
                }
            };
            if is_shared {
                shared.paths.set(path, true);
                store(&mut shared.own, path, load::<Rgb>(&block.radiance, lane));
                store(&mut block.radiance, lane, Rgb::BLACK);
                block.count_shadow_rays(lane, connected);
            }
        }
    }

    /// Replaces the BSDF samples of the block at rough second surfaces, and the values of the BSDFs for the light samples of
    /// the lanes `nee_lanes`, by those for all pixels.
    pub(super) fn scatter_at_rough(
        &mut self,
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
        nee_lanes: &ActiveLanes<LANES>,
        direct_light: &mut DirectLightLanes,
        scattering: &mut ScatteringLanes,
    ) {
        let Some(stage) = bsdfs.principled.get() else {
            return;
        };
        let seen = &mut self.seen;
        for second in &self.rough {
            let (lane, path) = (second.lane, second.sample % LANES);
            let shared = &mut self.packets[second.sample / LANES];
            seen.bsdfs = stage.bsdfs.repeated(lane);
            seen.bsdfs.bind(&planted!(
                "reuse-rough-seen-alike",
                second.wo.map(|it| [it[path]; LANES]),
                second.wo
            ));
            if let Some(at_rough) = shared.at_rough.get_mut()
                && nee_lanes.has(lane)
            {
                let at: Interaction<E> = at.get(lane);
                seen.evaluate(at.frame.to_local(load(&direct_light.samples.wi, lane)));
                let sums = seen.sums(second);
                let factors = &mut at_rough.factors[path];
                let f = seen.factors(second, 1.0 / sums.density, factors);
                store(&mut direct_light.f, lane, f * Rgb::WHITE);
                direct_light.pdf_bsdf[lane] = sums.pdf();
            }
            let wi: Vec3 = load(&scattering.wi, lane);
            seen.evaluate(wi);
            let sums = seen.sums(second);
            let factors = &mut shared.factors[path];
            let scale = wi.z.abs() / sums.density_with_pdf;
            let throughput = seen.factors(second, scale, factors);
            let is_sampled = scattering.sampled.has(lane) && throughput > 0.0;
            scattering.sampled.set(lane, is_sampled);
            store(&mut scattering.weight, lane, throughput * Rgb::WHITE);
            scattering.pdf[lane] = sums.pdf();
        }
    }

    /// Keeps the light that light sampling has found at the rough second surfaces of the block.
    pub(super) fn keep_light_at_rough(&mut self, block: &mut PathBlock<E>) {
        for second in &self.rough {
            let shared = &mut self.packets[second.sample / LANES];
            if let Some(at_rough) = shared.at_rough.get_mut() {
                let light: Rgb = load(&block.radiance, second.lane);
                store(&mut at_rough.light, second.sample % LANES, light);
                at_rough.paths.set(second.sample % LANES, true);
                store(&mut block.radiance, second.lane, Rgb::BLACK);
            }
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
            if let Some(at_rough) = shared.at_rough.get() {
                for path in at_rough.paths.each() {
                    let light: Rgb = load(&at_rough.light, path);
                    let factors = &at_rough.factors[path];
                    add(factors, light.into(), &mut samples.radiance);
                }
            }
        }
    }
}

impl<E: Effects> SharedPaths<E> {
    /// Connects these pixels to the second surface `at` of a path. Returns the number of shadow rays; `None` if the path's
    /// own pixel cannot find it.
    fn connect(
        &mut self,
        scene: &Scene,
        (path, pixels): (usize, ActiveLanes<LANES>),
        at: &Interaction<E, LaneVec3>,
        connections: &mut Connections,
    ) -> Option<u32> {
        self.first.connect(scene, &pixels, at, connections);
        let Connections {
            density,
            factor,
            rays,
            ..
        } = connections;
        if density[path] == 0.0 {
            return None;
        }
        let mut queried = pixels.and(|pixel| density[pixel] > 0.0);
        // The path's own segment is unoccluded, so that it needs no shadow ray.
        queried.set(path, false);
        let mut visible = [0.0; LANES];
        if queried.any() {
            // A packet has the shadow rays of one group to one point, so that its results depend on nothing else.
            let coherent = queried.count() >= MIN_COHERENT;
            visible = scene.visibilities::<E>(&queried, rays, coherent);
        }
        visible[path] = 1.0;
        for (pixel, visible) in visible.into_iter().enumerate() {
            density[pixel] *= planted!("reuse-without-visibility", 1.0, visible);
            let visible = load::<Rgb>(factor, pixel) * visible;
            store(factor, pixel, visible);
        }
        Some(queried.count() as u32)
    }

    /// Shares the diffuse second surface of a path with the pixels that are connected to it, and begins its throughput anew.
    /// Returns whether that is possible.
    fn take_diffuse(
        &mut self,
        (path, lane): (usize, usize),
        block: &mut PathBlock<E>,
        connections: &Connections,
    ) -> bool {
        let sum: f32 = connections.density.iter().sum();
        let scale = connections.over_survival(path, load(&block.beta, lane)) / sum;
        if !is_positive(scale) {
            return false;
        }
        let mut factor = connections.factor;
        let mut total = Rgb::BLACK;
        for pixel in 0..LANES {
            let taken = load::<Rgb>(&factor, pixel) * scale;
            store(&mut factor, pixel, taken);
            total += taken;
        }
        let throughput = normalise(&mut factor, total);
        self.factors[path] = factor;
        store(&mut block.beta, lane, throughput * Rgb::WHITE);
        true
    }

    /// Shares a rough second surface of a path as [`Self::take_diffuse`] does, but for the weights of its light: they depend on
    /// the directions that are sampled there.
    fn take_rough(
        &self,
        (sample, lane): (usize, usize),
        block: &mut PathBlock<E>,
        at: &Interaction<E, LaneVec3>,
        connections: &Connections,
    ) -> Option<RoughSecondSurface> {
        let scale = connections.over_survival(sample % LANES, load(&block.beta, lane));
        if !is_positive(scale) {
            return None;
        }
        let mut second = RoughSecondSurface {
            sample,
            lane,
            density: connections.density,
            factor: connections.factor.map(|it| it.map(|factor| scale * factor)),
            wo: [[0.0; LANES]; 3],
        };
        directions_to_first_surfaces::<E>(&self.first.at, at, &mut second.wo);
        store(&mut block.beta, lane, Rgb::WHITE);
        Some(second)
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
