//! Surface interactions in SIMD lanes: those of a packet of rays with their hits.
//!
//! Vertices are copied lane by lane; everything that follows from them on top-level triangle meshes is computed by the
//! functions for single interactions, in a loop over the lanes that the compiler vectorises. Other shapes, alpha, normal
//! maps and points next to the edge of a triangle are left to [`Scene::surface_interaction`].
//!
//! Measure: as in [`Interaction`].
//! Range: any packet.
//! Source: none needed. Both ways give the same bits: tested in `tests/tracing/packets.rs`.

use super::Interaction;
use crate::accel::lanes::{ExcludedLanes, NO_ID, RayHitLanes};
use crate::accel::{Hit, PrimitiveId};
use crate::effects::{EffectState, Effects, Slot, Switch};
use crate::geometry::Geometry;
use crate::geometry::mesh::{Mesh, may_be_outside, shading_normal, triangle_point};
use crate::geometry::surface::SurfacePoint;
use crate::light::types::Receiver;
use crate::math::frame::Frame;
use crate::math::lanes::ActiveLanes;
use crate::math::lanes::{LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::ray::Ray;
use crate::math::vec::{LaneVec3, Vec2, Vector};
use crate::scene::{Scene, ShapeTraits};

/// A surface interaction for each lane.
#[repr(align(64))]
#[derive(Debug, Clone)]
pub struct InteractionLanes<E: Effects> {
    /// The shapes.
    pub shape: Lanes<u32>,
    /// The primitives.
    pub primitive: Lanes<u32>,
    /// The [`ShapeTraits`] of the shapes.
    pub traits: Lanes<u32>,
    /// The positions.
    pub p: Lanes3,
    error: Lanes3,
    ng: Lanes3,
    side: Lanes<f32>,
    is_flat: EffectState<E::ShadingNormals, Lanes<u32>>,
    ns: EffectState<E::ShadingNormals, Lanes3>,
    frame: [Lanes3; 3],
    uv: EffectState<E::Textures, [Lanes<f32>; 2]>,
    /// Unit vectors back along the paths.
    pub wo: Lanes3,
}

const ZERO: Lanes<f32> = [0.0; LANES];

impl<E: Effects> Default for InteractionLanes<E> {
    fn default() -> Self {
        Self {
            shape: [NO_ID; LANES],
            primitive: [0; LANES],
            traits: [0; LANES],
            p: [ZERO; 3],
            error: [ZERO; 3],
            ng: [ZERO; 3],
            side: ZERO,
            is_flat: Slot::new(|| [0; LANES]),
            ns: Slot::new(|| [ZERO; 3]),
            frame: [[ZERO; 3]; 3],
            uv: Slot::new(|| [ZERO; 2]),
            wo: [ZERO; 3],
        }
    }
}

impl<E: Effects> InteractionLanes<E> {
    /// The primitive of a lane.
    #[inline(always)]
    pub fn id(&self, lane: usize) -> PrimitiveId {
        PrimitiveId {
            shape: self.shape[lane],
            primitive: self.primitive[lane],
        }
    }

    /// Whether `wo` of a lane is on the back of the surface.
    #[inline(always)]
    pub fn is_behind(&self, lane: usize) -> bool {
        self.side[lane] < 0.0
    }

    /// Copies the points as receivers of light.
    #[inline]
    pub fn receivers(&self, to: &mut Receiver<Lanes3>) {
        to.p = self.p;
        for lane in 0..LANES {
            store(&mut to.normal, lane, self.receiver_normal(lane));
        }
    }

    /// The normal of a lane's point as a receiver of light. Free of branches.
    #[inline(always)]
    pub fn receiver_normal(&self, lane: usize) -> LaneVec3 {
        let normal = load(&self.frame[2], lane);
        let transmits = self.traits[lane] & ShapeTraits::TRANSMISSIVE != 0;
        if transmits { LaneVec3::ZERO } else { normal }
    }

    /// The interaction of a lane.
    #[inline(always)]
    pub fn get<V: Vector>(&self, lane: usize) -> Interaction<E, V> {
        Interaction {
            id: self.id(lane),
            p: load(&self.p, lane),
            error: load(&self.error, lane),
            ng: load(&self.ng, lane),
            side: self.side[lane],
            is_flat: Slot::new(|| self.is_flat.get().is_some_and(|it| it[lane] != 0)),
            ns: Slot::new(|| self.ns.get().map_or(V::splat(0.0), |ns| load(ns, lane))),
            frame: Frame {
                s: load(&self.frame[0], lane),
                t: load(&self.frame[1], lane),
                n: load(&self.frame[2], lane),
            },
            uv: Slot::new(|| {
                let uv = self.uv.get();
                uv.map_or(Vec2::ZERO, |[u, v]| Vec2::new(u[lane], v[lane]))
            }),
            wo: load(&self.wo, lane),
        }
    }

    /// Sets the interaction of a lane.
    #[inline(always)]
    pub fn set<V: Vector>(&mut self, lane: usize, at: &Interaction<E, V>) {
        self.shape[lane] = at.id.shape;
        self.primitive[lane] = at.id.primitive;
        store(&mut self.p, lane, at.p);
        store(&mut self.error, lane, at.error);
        store(&mut self.ng, lane, at.ng);
        self.side[lane] = at.side;
        if let Some(is_flat) = self.is_flat.get_mut() {
            is_flat[lane] = u32::from(at.is_flat());
        }
        if let Some(ns) = self.ns.get_mut() {
            store(ns, lane, at.ns.or(V::splat(0.0)));
        }
        store(&mut self.frame[0], lane, at.frame.s);
        store(&mut self.frame[1], lane, at.frame.t);
        store(&mut self.frame[2], lane, at.frame.n);
        if let Some([u, v]) = self.uv.get_mut() {
            let uv = at.uv.or(Vec2::ZERO);
            (u[lane], v[lane]) = (uv.x, uv.y);
        }
        store(&mut self.wo, lane, at.wo);
    }
}

/// A triangle for each lane, with the attributes of its vertices.
#[repr(align(64))]
#[derive(Debug, Clone)]
struct HitTriangleLanes<E: Effects> {
    vertices: [Lanes3; 3],
    normals: EffectState<E::ShadingNormals, [Lanes3; 3]>,
    has_normals: EffectState<E::ShadingNormals, Lanes<u32>>,
    /// The texture coordinates of the vertices; zero where none are needed.
    uvs: EffectState<E::Textures, [[Lanes<f32>; 2]; 3]>,
    transmits: EffectState<E::Transmission, Lanes<u32>>,
}

impl<E: Effects> HitTriangleLanes<E> {
    fn new() -> Self {
        Self {
            vertices: [[ZERO; 3]; 3],
            normals: Slot::new(|| [[ZERO; 3]; 3]),
            has_normals: Slot::new(|| [0; LANES]),
            uvs: Slot::new(|| [[ZERO; 2]; 3]),
            transmits: Slot::new(|| [0; LANES]),
        }
    }

    /// Sets the triangle of a lane.
    #[inline(always)]
    fn set(&mut self, lane: usize, mesh: &Mesh, primitive: u32, traits: ShapeTraits) {
        let corners = mesh.corners(primitive);
        for (to, vertex) in self.vertices.iter_mut().zip(corners) {
            store(to, lane, vertex.position());
        }
        if let (Some(to), Some(has)) = (self.normals.get_mut(), self.has_normals.get_mut()) {
            has[lane] = u32::from(mesh.has_normals());
            for (to, vertex) in to.iter_mut().zip(corners) {
                store(to, lane, vertex.normal());
            }
        }
        if let Some(to) = self.uvs.get_mut() {
            let uvs = if traits.has(ShapeTraits::TEXTURED) {
                mesh.uvs_of(corners)
            } else {
                [Vec2::ZERO; 3]
            };
            for ([u, v], uv) in to.iter_mut().zip(uvs) {
                (u[lane], v[lane]) = (uv.x, uv.y);
            }
        }
        if let Some(to) = self.transmits.get_mut() {
            to[lane] = u32::from(traits.has(ShapeTraits::TRANSMISSIVE));
        }
    }

    /// The surface point of a lane at barycentric coordinates, its texture coordinate, and whether it may be beyond an
    /// edge. Free of branches.
    #[inline(always)]
    fn surface(&self, lane: usize, [u, v]: [f32; 2]) -> (SurfacePoint<LaneVec3>, Vec2, bool) {
        let [a, b, c] = &self.vertices;
        let triangle: [LaneVec3; 3] = [load(a, lane), load(b, lane), load(c, lane)];
        let point = triangle_point(triangle, [u, v]);
        let is_outside = may_be_outside(&point, triangle, [u, v]);
        let mut ns = point.ng;
        if let (Some(normals), Some(has)) = (self.normals.get(), self.has_normals.get()) {
            let [a, b, c] = normals;
            let normals = [load(a, lane), load(b, lane), load(c, lane)];
            let smooth = shading_normal(normals, point.ng, [u, v]);
            ns = if has[lane] != 0 { smooth } else { ns };
        }
        let mut uv = Vec2::ZERO;
        if let Some(uvs) = self.uvs.get() {
            let of_vertex = |i: usize| Vec2::new(uvs[i][0][lane], uvs[i][1][lane]);
            uv = (1.0 - u - v) * of_vertex(0) + u * of_vertex(1) + v * of_vertex(2);
        }
        (SurfacePoint { ns, ..point }, uv, is_outside)
    }
}

/// Memory for [`Scene::surface_interactions`].
#[derive(Debug, Clone)]
pub struct SurfaceScratch<E: Effects>(HitTriangleLanes<E>);

impl<E: Effects> Default for SurfaceScratch<E> {
    fn default() -> Self {
        Self(HitTriangleLanes::new())
    }
}

vectorised! {
    /// The interaction of every lane with its triangle. The result marks points that may be beyond an edge.
    fn interactions<E: Effects>(
        triangles: &HitTriangleLanes<E>,
        packet: &RayHitLanes<LANES>,
        interactions: &mut InteractionLanes<E>,
    ) -> Lanes<u32> {
        let mut outside = [0; LANES];
        for lane in 0..LANES {
            let uv = [packet.hits.u[lane], packet.hits.v[lane]];
            let (surface, texture_uv, is_outside) = triangles.surface(lane, uv);
            outside[lane] = u32::from(is_outside);
            let transmits = triangles.transmits.get().is_some_and(|it| it[lane] != 0);
            let ray = Ray::new(load(&packet.rays.origin, lane), load(&packet.rays.dir, lane));
            let id = PrimitiveId {
                shape: packet.hits.geometry[lane],
                primitive: packet.hits.primitive[lane],
            };
            let hit = Hit { id, t: 0.0, uv };
            let uv = Slot::new(|| texture_uv);
            interactions.set(lane, &Interaction::new(&ray, &hit, &surface, transmits, uv));
        }
        outside
    }
}

impl Scene {
    /// Computes the interactions of rays with their hits. Returns the lanes that have one: those active lanes whose rays
    /// have hit something that is not passed through. `alpha` returns, for a lane, the random number that decides whether
    /// a surface with alpha is passed through, and the distance at which the ray ends behind it.
    #[inline]
    pub fn surface_interactions<E: Effects>(
        &self,
        active: &ActiveLanes<LANES>,
        packet: &RayHitLanes<LANES>,
        excluded: &ExcludedLanes,
        mut alpha: impl FnMut(usize) -> (f32, f32),
        scratch: &mut SurfaceScratch<E>,
        interactions: &mut InteractionLanes<E>,
    ) -> ActiveLanes<LANES> {
        let SurfaceScratch(triangles) = scratch;
        let mut hit_lanes = active.and(|lane| packet.hits.geometry[lane] != NO_ID);
        let mut scalar_lanes = ActiveLanes::<LANES>::NONE;
        for lane in hit_lanes.each() {
            let shape = packet.hits.geometry[lane];
            let traits = self.shapes[shape as usize].traits;
            interactions.traits[lane] = traits.0;
            match self.world.geometries().get(shape as usize) {
                Some(Geometry::Mesh(mesh)) => {
                    triangles.set(lane, mesh, packet.hits.primitive[lane], traits);
                }
                _ => scalar_lanes.set(lane, true),
            }
        }
        let outside = self::interactions::<E>(triangles, packet, interactions);
        let scalar_lanes = hit_lanes.and(|lane| {
            let has_alpha = E::Alpha::ON & (interactions.traits[lane] & ShapeTraits::ALPHA != 0);
            let has_normal_map =
                E::NormalMaps::ON & (interactions.traits[lane] & ShapeTraits::NORMAL_MAPPED != 0);
            (outside[lane] != 0) | scalar_lanes.has(lane) | has_alpha | has_normal_map
        });
        for lane in scalar_lanes.each() {
            let (ray, time) = packet.ray(lane);
            let (excluded, hit) = (excluded.get(lane), packet.hit(lane));
            let (ray, u_alpha) = if E::Alpha::ON {
                let (u_alpha, t_max) = alpha(lane);
                (Ray { t_max, ..ray }, u_alpha)
            } else {
                (ray, 0.0)
            };
            match self.surface_interaction(&ray, time, excluded, u_alpha, hit) {
                Some(at) => {
                    // Behind a surface with alpha there may be another shape.
                    interactions.traits[lane] = self.shapes[at.id.shape as usize].traits.0;
                    interactions.set(lane, &at);
                }
                None => hit_lanes.set(lane, false),
            }
        }
        hit_lanes
    }
}
