//! Traces ray batches and packets by Embree's packets of 8 and 16.
//!
//! All lanes of a packet are loaded at once. Its hits go through the same check as those of single rays, in lanes; where a
//! hit is rejected, its ray is continued as a single ray. Which of two primitives at the same distance is reported, and
//! the last bits of the hit, may differ from the results of single rays.
//!
//! For rays that are not flagged as coherent, Embree finds the closest hits of a packet one ray at a time; only the
//! call and its set-up are shared. It does the same for occlusion if few lanes are active. Otherwise it traverses the
//! upper levels of the BVH for all lanes together, and a ray through an edge may then hit it in one packet and miss
//! it in another.
//!
//! Measure: those of [`RayBatch`] and [`HitBatch`].
//! Range: any number of rays. Rays that are inactive or not finite are masked out, as are the lanes past the end of
//! the batch. If the library lacks packets of the requested width, the next narrower supported width is used.
//! Source: Embree's manual, "Ray packets" and "Fast Coherent Rays". Tested below and in `tests/tracing/batches.rs` and
//! `packets.rs`.

use super::EmbreeAccel;
use super::scene::PacketQuery;
use crate::accel::Hit;
use crate::accel::batch::{HitBatch, PacketWidth, Packets, RayBatch};
use crate::accel::lanes::{HitLanes, NO_ID, RayHitLanes, RayLanes};
use crate::math::lanes::ActiveLanes;
use crate::math::lanes::LANES;
use crate::planted::planted;

/// The largest number of active lanes, in a packet of `lanes`, for which Embree traces the rays one at a time: 14 of
/// 16 and 7 of 8 (Embree 4.3.3, `kernels/bvh/bvh_intersector_hybrid.h`, `switchThreshold`).
const fn most_apart(lanes: usize) -> usize {
    lanes - lanes.div_ceil(8)
}

impl EmbreeAccel {
    /// Finds the closest hit of every active ray.
    pub fn intersect_batch(&self, rays: &RayBatch, packets: Packets, hits: &mut HitBatch) {
        match self.native_width(packets.width) {
            PacketWidth::One => rays.intersect_each(hits, |ray, time| self.intersect(ray, time)),
            PacketWidth::Eight => self.intersect_packets::<8>(rays, packets.coherent, hits),
            PacketWidth::Sixteen => self.intersect_packets::<16>(rays, packets.coherent, hits),
        }
    }

    /// Tests each active ray for occlusion; `false` for the others.
    pub fn occluded_batch(&self, rays: &RayBatch, packets: Packets, occluded: &mut Vec<bool>) {
        match self.native_width(packets.width) {
            PacketWidth::One => rays.occluded_each(occluded, |ray, time| self.occluded(ray, time)),
            PacketWidth::Eight => self.occluded_packets::<8>(rays, packets.coherent, occluded),
            PacketWidth::Sixteen => self.occluded_packets::<16>(rays, packets.coherent, occluded),
        }
    }

    /// The widest packets that the library traces natively, up to the requested width.
    fn native_width(&self, asked: PacketWidth) -> PacketWidth {
        let native = self.native_widths.iter().copied();
        native
            .filter(|&width| width <= asked)
            .max()
            .unwrap_or_default()
    }

    fn intersect_packets<const N: usize>(
        &self,
        rays: &RayBatch,
        coherent: bool,
        hits: &mut HitBatch,
    ) {
        hits.resize(rays.len());
        let mut query = PacketQuery::new(coherent);
        let mut packet = RayHitLanes::<N>::default();
        for start in (0..rays.len()).step_by(N) {
            let active = packet.rays.load(rays, start);
            packet.hits.clear();
            if active.any() {
                self.scene
                    .intersect_packet(&active, &mut packet, &mut query);
            }
            let to_confirm = self.lanes_to_confirm(&active, &packet);
            for lane in 0..N.min(rays.len() - start) {
                let index = start + lane;
                let mut hit = self.hit_of_lane(&packet, lane);
                if to_confirm.has(lane) {
                    let (ray, time) = rays.get(index);
                    hit = hit.and_then(|hit| self.confirm(&ray, time, hit));
                }
                hits.set(index, hit);
            }
        }
    }

    #[inline]
    fn hit_of_lane<const N: usize>(&self, packet: &RayHitLanes<N>, lane: usize) -> Option<Hit> {
        let RayHitLanes { rays, hits } = packet;
        let HitLanes { u, v, .. } = hits;
        self.hit(
            [
                hits.geometry[lane],
                hits.primitive[lane],
                hits.instance[lane],
            ],
            rays.t_max[lane],
            [u[lane], v[lane]],
        )
    }

    fn occluded_packets<const N: usize>(
        &self,
        rays: &RayBatch,
        coherent: bool,
        occluded: &mut Vec<bool>,
    ) {
        occluded.clear();
        occluded.resize(rays.len(), false);
        let mut query = PacketQuery::new(coherent);
        let mut packet = RayLanes::<N>::default();
        for (number, answers) in occluded.chunks_mut(N).enumerate() {
            let active = packet.load(rays, number * N);
            if !active.any() {
                continue;
            }
            self.scene.occluded_packet(&active, &mut packet, &mut query);
            for (lane, answer) in answers.iter_mut().enumerate() {
                *answer = (active.0[lane] != 0) & (packet.t_max[lane] < 0.0);
            }
        }
    }

    /// Finds the closest hit of every active lane, with the world's shapes in place of Embree's ids, without regard to
    /// excluded primitives. If the rays are not flagged as coherent, the hit of one does not depend on the others.
    pub fn intersect_lanes(
        &self,
        active: &ActiveLanes<LANES>,
        packet: &mut RayHitLanes<LANES>,
        coherent: bool,
    ) {
        let mut query = PacketQuery::new(coherent);
        packet.hits.instance = [NO_ID; LANES];
        match self.native_width(PacketWidth::Sixteen) {
            PacketWidth::One => {
                for lane in active.each() {
                    let (ray, time) = packet.ray(lane);
                    packet.set_hit(lane, self.intersect(&ray, time));
                }
                return;
            }
            PacketWidth::Eight => {
                for half in (0..LANES).step_by(8) {
                    let mut lanes: RayHitLanes<8> = packet.part(half);
                    let active = active.part(half);
                    self.scene.intersect_packet(&active, &mut lanes, &mut query);
                    packet.replace(half, &lanes);
                }
            }
            PacketWidth::Sixteen => self.scene.intersect_packet(active, packet, &mut query),
        }
        if !self.world.instances().is_empty() {
            for lane in active.each() {
                packet.set_hit(lane, self.hit_of_lane(packet, lane));
            }
        }
        for lane in self.lanes_to_confirm(active, packet).each() {
            let (ray, time) = packet.ray(lane);
            let hit = packet.hit(lane);
            packet.set_hit(lane, hit.and_then(|hit| self.confirm(&ray, time, hit)));
        }
    }

    /// Tests every active lane for occlusion. If the rays are not flagged as coherent, the result of one does not depend on the
    /// others.
    pub fn occluded_lanes(
        &self,
        active: ActiveLanes<LANES>,
        rays: &mut RayLanes<LANES>,
        coherent: bool,
    ) {
        match self.native_width(PacketWidth::Sixteen) {
            PacketWidth::One => {
                for lane in active.each() {
                    let (ray, time) = rays.get(lane);
                    if self.occluded(&ray, time) {
                        rays.t_max[lane] = f32::NEG_INFINITY;
                    }
                }
            }
            PacketWidth::Eight => {
                for half in (0..LANES).step_by(8) {
                    let mut lanes: RayLanes<8> = rays.part(half);
                    self.occluded_packet(active.part(half), &mut lanes, coherent);
                    rays.t_max[half..half + 8].copy_from_slice(&lanes.t_max);
                }
            }
            PacketWidth::Sixteen => self.occluded_packet(active, rays, coherent),
        }
    }

    /// Tests a packet for occlusion; if it is not coherent, with so few active lanes per call that Embree traces them one at a
    /// time.
    fn occluded_packet<const N: usize>(
        &self,
        active: ActiveLanes<N>,
        rays: &mut RayLanes<N>,
        coherent: bool,
    ) {
        let mut query = PacketQuery::new(coherent);
        let most = planted!("shadow-rays-together", N, most_apart(N));
        if coherent || active.count() <= most {
            self.scene.occluded_packet(&active, rays, &mut query);
            return;
        }
        for half in active.halves() {
            self.scene.occluded_packet(&half, rays, &mut query);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{AccelOptions, Backend, Precision, Quality};
    use crate::geometry::Geometry;
    use crate::geometry::mesh::Mesh;
    use crate::geometry::world::World;
    use crate::math::ray::Ray;
    use crate::math::vec::Vec3;
    use std::sync::Arc;

    /// A hilly square of triangles.
    fn hills() -> Mesh {
        const SIDE: u32 = 13;
        let height = |i: u32, j: u32| ((i * 7 + j * 5) % 11) as f32 / 11.0;
        let corner = |k: u32| {
            let (i, j) = (k % SIDE, k / SIDE);
            Vec3::new(i as f32, j as f32, height(i, j)) / SIDE as f32 - Vec3::new(0.5, 0.5, 0.0)
        };
        let squares = (0..SIDE * (SIDE - 1)).filter(|k| (k + 1) % SIDE > 0);
        let halves = squares.flat_map(|k| [[k, k + 1, k + SIDE], [k + 1, k + SIDE + 1, k + SIDE]]);
        Mesh::new(
            (0..SIDE * SIDE).map(corner).collect(),
            vec![],
            vec![],
            halves.collect(),
        )
    }

    /// Rays from the whole of a cube to the vertices and edges of a mesh within it.
    fn packet(number: usize, mesh: &Mesh) -> (ActiveLanes<LANES>, RayHitLanes<LANES>) {
        let mut packet = RayHitLanes::default();
        let digit = |i: usize, base: usize| (i * i % base) as f32 / base as f32 - 0.5;
        let count = 1 + number % LANES;
        for lane in 0..count {
            let i = number + lane;
            let from = 3.0 * Vec3::new(digit(i, 61), digit(i, 59), digit(i, 53));
            let [a, b, _] = mesh.triangle((i % mesh.indices().len()) as u32);
            let to = a + (i % 3) as f32 / 2.0 * (b - a);
            packet.rays.set(lane, &Ray::new(from, to - from));
        }
        (ActiveLanes::first(count), packet)
    }

    /// Covers libraries without packets of sixteen, as on processors without AVX-512.
    #[test]
    fn narrower_packets_and_single_rays_match_the_widest_packets() {
        let mesh = hills();
        for (precision, quality) in [
            (Precision::Robust, Quality::Medium),
            (Precision::Fast, Quality::Medium),
            (Precision::Fast, Quality::High),
        ] {
            let options = AccelOptions {
                backend: Backend::Embree,
                precision,
                quality: Some(quality),
                threads: 1,
            };
            let shapes = vec![Geometry::Mesh(mesh.clone())];
            let world = Arc::new(World::new(shapes, vec![], vec![]));
            let accel = EmbreeAccel::build(world, options).expect("a small scene");
            let widest = accel.native_width(PacketWidth::Sixteen);
            let narrower = PacketWidth::ALL.iter().filter(|&&width| width < widest);
            let narrower: Vec<EmbreeAccel> = narrower
                .map(|&width| {
                    let shapes = Arc::clone(&accel.world);
                    let mut narrow = EmbreeAccel::build(shapes, options).expect("a small scene");
                    narrow.native_widths.retain(|&native| native <= width);
                    narrow
                })
                .collect();
            let traced = |accel: &EmbreeAccel, number: usize| {
                let (active, mut packet) = packet(number, &mesh);
                let mut shadow = packet.rays.clone();
                accel.intersect_lanes(&active, &mut packet, false);
                accel.occluded_lanes(active, &mut shadow, false);
                let hits: [Option<Hit>; LANES] = std::array::from_fn(|lane| packet.hit(lane));
                (hits, shadow.t_max.map(|end| end < 0.0))
            };
            let mut hit = 0;
            for number in 0..4000 {
                let want = traced(&accel, number);
                hit += want.1.iter().filter(|&&occluded| occluded).count();
                for narrow in &narrower {
                    assert_eq!(
                        traced(narrow, number),
                        want,
                        "{precision:?} {quality:?}, packet {number}"
                    );
                }
            }
            assert!(hit > 10_000, "{hit}");
        }
    }
}
