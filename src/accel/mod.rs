//! Ray queries against all shapes of a scene: which primitive, how far, where on it. Nothing of lights or materials.
//!
//! The backends are a closed set and share one contract. A hit lies in (t_min, t_max] of the ray. On a triangle, (u, v)
//! are the barycentric coordinates of its second and third vertex. Which of two primitives at exactly the same distance
//! is reported is left open.
//!
//! Measure: normalised scene units; `t` in multiples of the direction's length.
//! Range: finite rays; a ray that is not finite hits nothing.
//! Source: the hit contract is Embree's. Tested in `tests/tracing/rays.rs` against the brute-force oracle.

pub mod batch;
pub mod brute;
#[cfg(feature = "embree")]
pub mod embree;
mod lanes;
pub mod library;
pub mod obvhs;
pub mod packet;
mod primitive;

use crate::error::{Error, Result};
pub use crate::geometry::world::PrimitiveId;
use crate::geometry::world::{Instance, World};
use crate::math::lanes::LANES;
use crate::math::ray::Ray;
use crate::planted::planted;
use batch::{HitBatch, Packets, RayBatch};
use packet::{Hits, RayPacket};
use std::sync::Arc;

/// Where a ray meets a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The primitive.
    pub id: PrimitiveId,
    /// How far along the ray.
    pub t: f32,
    /// Barycentric coordinates on a triangle, unspecified elsewhere.
    pub uv: [f32; 2],
}

/// The primitive that a ray has just left, and how far along the ray a hit on it must be an error of rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExcludedPrimitive {
    /// The primitive.
    pub id: PrimitiveId,
    /// Hits on it nearer than this do not count.
    pub free_distance: f32,
}

impl ExcludedPrimitive {
    /// Whether a hit must be an error of rounding.
    #[inline]
    fn rules_out(&self, hit: &Hit) -> bool {
        let is_error = self.id == hit.id && hit.t < self.free_distance;
        planted!("departure-ignored", false, is_error)
    }
}

/// The library that answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Backend {
    /// Intel Embree, through the system's library.
    #[cfg(feature = "embree")]
    Embree,
    /// obvhs, in Rust, with a binary BVH.
    ObvhsBvh2,
    /// obvhs, in Rust, with a compressed BVH of eight children a node.
    ObvhsCwbvh,
}

impl Backend {
    /// Every backend of this build, the preferred one first.
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

    /// The quality of structure with which most scenes are traced fastest, see docs/architecture.md.
    pub fn default_quality(self) -> Quality {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree => Quality::Medium,
            Self::ObvhsBvh2 | Self::ObvhsCwbvh => Quality::High,
        }
    }
}

/// The Embree of this build, `None` where it has none.
///
/// # Errors
/// If Embree finds no device, or one that does not fit its headers.
pub fn embree_info() -> Result<Option<library::EmbreeInfo>> {
    #[cfg(feature = "embree")]
    return embree::info().map(Some);
    #[cfg(not(feature = "embree"))]
    Ok(None)
}

/// How carefully rays are intersected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Precision {
    /// Watertight along edges, and in obvhs at vertices too. Embree checks every hit on a triangle, at about a third more time
    /// in traversal; of segments aimed exactly at vertices it still lets some pass, one in 10^4 of a coarse mesh, one in 100 of
    /// a fine one. obvhs meets triangles in double precision.
    #[default]
    Robust,
    /// As fast as the backend can, in single precision; rays that meet an edge exactly may slip through it.
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

/// How much work goes into an acceleration structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quality {
    /// One pass, without cutting triangles.
    Medium,
    /// obvhs: goes over the structure again until it hardly improves. Embree: cuts triangles where that makes boxes smaller,
    /// which pays if they are large and askew, and else makes rays slower; not in robust precision, where it is as `Medium`.
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

/// How an acceleration structure is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AccelOptions {
    /// The library.
    pub backend: Backend,
    /// How carefully it intersects.
    pub precision: Precision,
    /// How well it is built; `None` leaves it to the backend.
    pub quality: Option<Quality>,
    /// Threads to build with, at least 1.
    pub threads: usize,
}

impl AccelOptions {
    /// How well it is built.
    pub fn quality(&self) -> Quality {
        let default = self.backend.default_quality();
        self.quality.unwrap_or(default)
    }
}

/// The shapes of a scene, ready for ray queries from any number of threads.
#[derive(Debug)]
pub enum Accel {
    /// Embree's.
    #[cfg(feature = "embree")]
    Embree(embree::EmbreeAccel),
    /// obvhs's, of either layout; boxed because it is held by value.
    Obvhs(Box<obvhs::ObvhsAccel>),
}

impl Accel {
    /// Builds the structure over all primitives.
    ///
    /// # Errors
    /// An instance whose transform cannot be inverted at all times; what the backend says, most likely that memory ran
    /// out.
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

    /// The structure over a world that shares its shapes with this one's: those over groups are not built again.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn with_instances_of(&self, world: Arc<World>) -> Result<Self> {
        check_world(&world)?;
        Ok(match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => Self::Embree(accel.with_instances_of(world)?),
            Self::Obvhs(accel) => Self::Obvhs(Box::new(accel.with_instances_of(world)?)),
        })
    }

    /// The closest hit at a time of the shutter, from 0 to 1, other than a false one on the primitive just left.
    #[inline]
    pub fn intersect(
        &self,
        ray: &Ray,
        time: f32,
        departure: Option<ExcludedPrimitive>,
    ) -> Option<Hit> {
        let hit = self.closest(ray, time)?;
        match departure {
            Some(departure) if departure.rules_out(&hit) => self.beyond(ray, time, departure, hit),
            _ => Some(hit),
        }
    }

    /// The closest hit, whatever the ray has left.
    #[inline]
    fn closest(&self, ray: &Ray, time: f32) -> Option<Hit> {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.intersect(ray, time),
            Self::Obvhs(accel) => accel.intersect(ray, time),
        }
    }

    /// The closest hit behind one that lies on what the ray has left, other than another of that kind.
    #[cold]
    fn beyond(
        &self,
        ray: &Ray,
        time: f32,
        departure: ExcludedPrimitive,
        mut hit: Hit,
    ) -> Option<Hit> {
        let mut ray = *ray;
        while departure.rules_out(&hit) {
            ray.t_min = hit.t.max(ray.t_min).next_up();
            hit = self.closest(&ray, time)?;
        }
        Some(hit)
    }

    /// The closest hit of every ray of a packet, other than a false one on the primitive just left. If the rays are
    /// `coherent`, as those of a camera are, it is quicker, and what one of them meets may depend on the others: which of
    /// two primitives at the same distance, and its last bits.
    #[cfg_attr(not(feature = "embree"), allow(unused_variables))] // obvhs has no packets
    pub fn intersect_packet(&self, rays: &mut RayPacket, coherent: bool, hits: &mut Hits) {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.intersect_packet(rays, coherent, hits),
            Self::Obvhs(accel) => rays.each(hits, |ray, time| accel.intersect(ray, time)),
        }
        for (lane, hit) in hits.iter_mut().enumerate().take(rays.len()) {
            if let (Some(departure), Some(found)) = (rays.departure(lane), &hit)
                && departure.rules_out(found)
            {
                let (ray, time) = rays.get(lane);
                *hit = self.beyond(&ray, time, departure, *found);
            }
        }
    }

    /// Whether anything lies on each ray of a packet.
    pub fn occluded_packet(&self, rays: &mut RayPacket, occluded: &mut [bool; LANES]) {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.occluded_packet(rays, occluded),
            Self::Obvhs(accel) => rays.each(occluded, |ray, time| accel.occluded(ray, time)),
        }
    }

    /// Whether anything lies on the ray at a time of the shutter.
    #[inline]
    pub fn occluded(&self, ray: &Ray, time: f32) -> bool {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.occluded(ray, time),
            Self::Obvhs(accel) => accel.occluded(ray, time),
        }
    }

    /// Bytes that the structure occupies beside the shapes.
    pub fn memory(&self) -> usize {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(accel) => accel.memory(),
            Self::Obvhs(accel) => accel.memory(),
        }
    }

    /// The closest hit of every active ray, as [`Self::intersect`] without a departure finds it. Of primitives at the same
    /// distance packets may report another one, and their hits may differ in the last bits.
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

    /// Whether anything lies on each active ray; `false` for the others.
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

    /// Nodes of the structure; `None` where the library does not tell.
    pub fn nodes(&self) -> Option<usize> {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(_) => None,
            Self::Obvhs(accel) => Some(accel.nodes()),
        }
    }
}

/// Whether a world can be traced: its numbers fit, and every instance has a way back.
fn check_world(world: &World) -> Result<()> {
    let fits = |count: usize| u32::try_from(count).is_ok();
    let instances = world.instances().len();
    let mut shapes = world
        .geometries()
        .iter()
        .chain(world.groups().iter().flatten());
    // Instances have Embree's ids after those of the shapes in the world.
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
