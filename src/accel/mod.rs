//! Ray queries against all shapes of a scene: the primitive that is hit, the ray parameter and the barycentric
//! coordinates. Lights and materials are not involved.
//!
//! The backends are a closed set and share one contract. A hit lies in (t_min, t_max] of the ray. On a triangle, (u, v)
//! are the barycentric coordinates of its second and third vertex. Which of two primitives at exactly the same distance
//! is reported is unspecified.
//!
//! Measure: normalised scene units; `t` in multiples of the direction's length.
//! Range: finite rays; a ray that is not finite hits nothing.
//! Source: the hit contract is Embree's. Tested in `tests/tracing/rays.rs` against the brute-force oracle.

pub mod batch;
pub mod brute;
#[cfg(feature = "embree")]
pub mod embree;
pub mod lanes;
pub mod library;
pub mod obvhs;
mod primitive;

use crate::error::{Error, Result};
pub use crate::geometry::world::PrimitiveId;
use crate::geometry::world::{Instance, World};
use crate::math::lanes::ActiveLanes;
use crate::math::lanes::LANES;
use crate::math::ray::Ray;
use crate::planted::planted;
use batch::{HitBatch, Packets, RayBatch};
use lanes::{ExcludedLanes, NO_ID, RayHitLanes, RayLanes};
use std::sync::Arc;

/// The intersection of a ray with a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The primitive.
    pub id: PrimitiveId,
    /// The parameter along the ray.
    pub t: f32,
    /// Barycentric coordinates on a triangle, unspecified elsewhere.
    pub uv: [f32; 2],
}

/// The primitive that a ray starts on, and the distance up to which a hit on it can only be a rounding error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExcludedPrimitive {
    /// The primitive.
    pub id: PrimitiveId,
    /// Hits on the primitive nearer than this are ignored.
    pub free_distance: f32,
}

impl ExcludedPrimitive {
    /// Whether a hit can only be a rounding error.
    #[inline]
    fn rules_out(&self, hit: &Hit) -> bool {
        let is_error = self.id == hit.id && hit.t < self.free_distance;
        planted!("excluded-primitive-ignored", false, is_error)
    }
}

/// The library that builds and traverses the acceleration structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Backend {
    /// Intel Embree, through the system's library.
    #[cfg(feature = "embree")]
    Embree,
    /// obvhs, in Rust, with a binary BVH.
    ObvhsBvh2,
    /// obvhs, in Rust, with a compressed BVH of eight children per node.
    ObvhsCwbvh,
}

impl Backend {
    /// All backends of this build, the preferred one first.
    pub const ALL: &'static [Self] = &[
        #[cfg(feature = "embree")]
        Self::Embree,
        Self::ObvhsBvh2,
        Self::ObvhsCwbvh,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree => "embree",
            Self::ObvhsBvh2 => "obvhs-bvh2",
            Self::ObvhsCwbvh => "obvhs-cwbvh",
        }
    }

    /// Whether the library is Embree.
    pub fn is_embree(self) -> bool {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree => true,
            Self::ObvhsBvh2 | Self::ObvhsCwbvh => false,
        }
    }

    /// The quality with which most scenes are traced fastest, see docs/architecture.md.
    pub fn default_quality(self) -> Quality {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree => Quality::Medium,
            Self::ObvhsBvh2 | Self::ObvhsCwbvh => Quality::High,
        }
    }
}

/// Returns facts about the Embree library of this build; `None` in a build without Embree.
///
/// # Errors
/// If Embree cannot create a device, or the library does not match its headers.
pub fn embree_info() -> Result<Option<library::EmbreeInfo>> {
    #[cfg(feature = "embree")]
    return embree::info().map(Some);
    #[cfg(not(feature = "embree"))]
    Ok(None)
}

/// The precision of ray intersections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Precision {
    /// Watertight along edges, and with obvhs also at vertices. With Embree, its robust mode and the check of every hit on a
    /// triangle add about a third to the traversal time; some segments aimed exactly at vertices still miss, one in 10^4 for a
    /// coarse mesh and one in 100 for a fine one. obvhs intersects triangles in double precision.
    #[default]
    Robust,
    /// The fastest mode of the backend, in single precision; rays that hit an edge exactly may pass through it.
    Fast,
}

impl Precision {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robust => "robust",
            Self::Fast => "fast",
        }
    }
}

/// The effort spent on building an acceleration structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quality {
    /// A single build pass, without splitting triangles.
    Medium,
    /// obvhs: optimises the structure repeatedly until it hardly improves. Embree: splits triangles where that makes
    /// boxes smaller, which pays off for large triangles that are not aligned with the axes and otherwise makes tracing
    /// slower; in robust precision Embree does not split, and `High` is the same as `Medium`.
    High,
}

impl Quality {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// The options for building an acceleration structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AccelOptions {
    /// The library.
    pub backend: Backend,
    /// The precision of intersections.
    pub precision: Precision,
    /// The quality of the structure; `None` for the backend's default.
    pub quality: Option<Quality>,
    /// The number of threads to build with, at least 1.
    pub threads: usize,
}

impl AccelOptions {
    /// The quality of the structure, by default the backend's.
    pub fn quality(&self) -> Quality {
        let default = self.backend.default_quality();
        self.quality.unwrap_or(default)
    }
}

/// The acceleration structure over all shapes of a scene, for ray queries from any number of threads.
#[derive(Debug)]
pub enum Accel {
    /// Embree's structure.
    #[cfg(feature = "embree")]
    Embree(embree::EmbreeAccel),
    /// obvhs's structure, of either layout; boxed because it is held by value.
    Obvhs(Box<obvhs::ObvhsAccel>),
}

impl Accel {
    /// Builds the structure over all primitives.
    ///
    /// # Errors
    /// If the transform of an instance cannot be inverted at all times; errors of the backend, most likely that memory
    /// ran out.
    pub fn build(world: Arc<World>, options: AccelOptions) -> Result<Self> {
        check_world(&world)?;
        Ok(match options.backend {
            #[cfg(feature = "embree")]
            Backend::Embree => Self::Embree(embree::EmbreeAccel::build(world, options)?),
            Backend::ObvhsBvh2 | Backend::ObvhsCwbvh => {
                Self::Obvhs(Box::new(obvhs::ObvhsAccel::build(world, options)?))
            }
        })
    }

    /// Builds the structure over a world that shares its shapes with the current one; the structures of groups are
    /// reused.
    ///
    /// # Errors
    /// The errors of [`Self::build`].
    pub fn with_instances_of(&self, world: Arc<World>) -> Result<Self> {
        check_world(&world)?;
        Ok(match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => Self::Embree(accel.with_instances_of(world)?),
            Self::Obvhs(accel) => Self::Obvhs(Box::new(accel.with_instances_of(world)?)),
        })
    }

    /// Finds the closest hit at a time of the shutter, from 0 to 1, ignoring false hits on the excluded primitive.
    #[inline]
    pub fn intersect(
        &self,
        ray: &Ray,
        time: f32,
        excluded: Option<ExcludedPrimitive>,
    ) -> Option<Hit> {
        let hit = self.closest(ray, time)?;
        match excluded {
            Some(excluded) if excluded.rules_out(&hit) => {
                self.next_accepted_hit(ray, time, excluded, hit)
            }
            _ => Some(hit),
        }
    }

    /// Finds the closest hit, without regard to an excluded primitive.
    #[inline]
    fn closest(&self, ray: &Ray, time: f32) -> Option<Hit> {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.intersect(ray, time),
            Self::Obvhs(accel) => accel.intersect(ray, time),
        }
    }

    /// Finds the closest hit beyond a false hit on the excluded primitive, skipping further false hits.
    #[cold]
    fn next_accepted_hit(
        &self,
        ray: &Ray,
        time: f32,
        excluded: ExcludedPrimitive,
        mut hit: Hit,
    ) -> Option<Hit> {
        let mut ray = *ray;
        while excluded.rules_out(&hit) {
            ray.begin_after(hit.t);
            hit = self.closest(&ray, time)?;
        }
        Some(hit)
    }

    /// Finds the closest hit of the infinitely long ray of every active lane, ignoring false hits on the excluded
    /// primitives. A ray that is not finite hits nothing.
    ///
    /// The hit of a ray does not depend on the other lanes, unless they are flagged as `coherent`, such as camera rays. This
    /// is faster; which of two primitives at the same distance is hit, and the last bits, may then depend on the others.
    #[cfg_attr(not(feature = "embree"), allow(unused_variables))] // obvhs has no packets
    pub fn intersect_lanes(
        &self,
        active: &ActiveLanes<LANES>,
        packet: &mut RayHitLanes<LANES>,
        excluded: &ExcludedLanes,
        coherent: bool,
    ) {
        let active = packet.rays.finite(active);
        packet.hits.geometry = [NO_ID; LANES];
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.intersect_lanes(&active, packet, coherent),
            Self::Obvhs(accel) => {
                for lane in active.each() {
                    let (ray, time) = packet.ray(lane);
                    packet.set_hit(lane, accel.intersect(&ray, time));
                }
            }
        }
        if !excluded.may_rule_out(packet) {
            return;
        }
        for lane in active.each() {
            if let (Some(excluded), Some(hit)) = (excluded.get(lane), packet.hit(lane))
                && excluded.rules_out(&hit)
            {
                let (ray, time) = packet.ray(lane);
                packet.set_hit(lane, self.next_accepted_hit(&ray, time, excluded, hit));
            }
        }
    }

    /// Tests the ray of every active lane for occlusion: sets the ends of occluded rays to minus infinity. A ray that is not
    /// finite is not occluded. If the rays are not flagged as coherent, the result of one does not depend on the others.
    #[cfg_attr(not(feature = "embree"), allow(unused_variables))] // obvhs has no packets
    pub fn occluded_lanes(
        &self,
        active: &ActiveLanes<LANES>,
        rays: &mut RayLanes<LANES>,
        coherent: bool,
    ) {
        let active = rays.finite(active);
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.occluded_lanes(active, rays, coherent),
            Self::Obvhs(accel) => {
                for lane in active.each() {
                    let (ray, time) = rays.get(lane);
                    if accel.occluded(&ray, time) {
                        rays.t_max[lane] = f32::NEG_INFINITY;
                    }
                }
            }
        }
    }

    /// Whether the ray is occluded at a time of the shutter.
    #[inline]
    pub fn occluded(&self, ray: &Ray, time: f32) -> bool {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.occluded(ray, time),
            Self::Obvhs(accel) => accel.occluded(ray, time),
        }
    }

    /// The number of bytes that the structure occupies in addition to the shapes.
    pub fn memory(&self) -> usize {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.memory(),
            Self::Obvhs(accel) => accel.memory(),
        }
    }

    /// Finds the closest hit of every active ray, like [`Self::intersect`] without an excluded primitive. With packets,
    /// another one of several primitives at the same distance may be reported, and hits may differ in the last bits.
    #[cfg_attr(not(feature = "embree"), allow(unused_variables))] // obvhs has no packets
    pub fn intersect_batch(&self, rays: &RayBatch, packets: Packets, hits: &mut HitBatch) {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.intersect_batch(rays, packets, hits),
            Self::Obvhs(accel) => {
                rays.intersect_each(hits, |ray, time| accel.intersect(ray, time));
            }
        }
    }

    /// Tests each active ray for occlusion; `false` for the others.
    #[cfg_attr(not(feature = "embree"), allow(unused_variables))] // obvhs has no packets
    pub fn occluded_batch(&self, rays: &RayBatch, packets: Packets, occluded: &mut Vec<bool>) {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.occluded_batch(rays, packets, occluded),
            Self::Obvhs(accel) => {
                rays.occluded_each(occluded, |ray, time| accel.occluded(ray, time));
            }
        }
    }

    /// The number of nodes of the structure; `None` if the library does not report it.
    pub fn nodes(&self) -> Option<usize> {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(_) => None,
            Self::Obvhs(accel) => Some(accel.nodes()),
        }
    }
}

/// Checks that a world can be traced: shape and primitive counts fit 32 bits, and every instance can be inverted.
fn check_world(world: &World) -> Result<()> {
    let fits = |count: usize| u32::try_from(count).is_ok();
    let instances = world.instances().len();
    let mut shapes = world
        .geometries()
        .iter()
        .chain(world.groups().iter().flatten());
    // Embree's ids of instances follow those of the top-level shapes.
    if !fits(world.shape_count() + instances) || !shapes.all(|g| fits(g.primitive_count())) {
        return Err(Error::render(
            "more than 2^32 shapes, or triangles in one shape",
        ));
    }
    if !world.instances().iter().all(Instance::is_invertible) {
        return Err(Error::render(
            "an instance cannot be inverted in single precision at all times of its motion; \
             more steps may help",
        ));
    }
    Ok(())
}
