//! The state of sixteen paths as a structure of arrays.

use crate::random::RandomLanes;
use etendue::internals::accel::lanes::{RayHitLanes, RayLanes};
use etendue::internals::math::lanes::{ActiveLanes, LANES, Lanes};
use etendue::internals::math::vec::LaneVec3 as Vec3;

/// The sample index that marks a lane without a path.
pub const NO_SAMPLE: u32 = u32::MAX;

pub type Lanes3 = [Lanes<f32>; 3];

/// Sixteen paths.
#[derive(Clone)]
#[repr(C, align(64))]
pub struct Block {
    /// Extension rays, and their hits.
    pub extension: RayHitLanes<LANES>,
    /// The lanes whose extension rays are to be traced.
    pub to_trace: ActiveLanes<LANES>,
    pub shadow: RayLanes<LANES>,
    pub shadow_ray_lanes: ActiveLanes<LANES>,
    /// The lanes with a path that has not ended.
    pub active: ActiveLanes<LANES>,
    /// The index of each path's sample in the tile.
    pub sample: Lanes<u32>,
    pub bounce: Lanes<u32>,
    pub beta: Lanes3,
    pub radiance: Lanes3,
    /// The contribution of the light sample, if it is not occluded.
    pub contribution: Lanes3,
    /// The density of the last direction; infinite for camera rays, which light samples do not compete with.
    pub pdf: Lanes<f32>,
    pub random: RandomLanes,
    /// The random numbers of a bounce: for the point on the light, and for the direction.
    pub numbers: [Lanes<f32>; 4],
    pub surfaces: SurfaceLanes,
}

/// The triangles that were hit.
#[derive(Clone)]
pub struct SurfaceLanes {
    pub vertices: [Lanes3; 3],
    pub reflectance: Lanes3,
    /// 1 on the light, 0 elsewhere.
    pub is_light: Lanes<f32>,
}

impl Block {
    pub fn new() -> Self {
        let zero = [0.0; LANES];
        Self {
            extension: RayHitLanes::default(),
            to_trace: ActiveLanes::NONE,
            shadow: RayLanes::default(),
            shadow_ray_lanes: ActiveLanes::NONE,
            active: ActiveLanes::NONE,
            sample: [NO_SAMPLE; LANES],
            bounce: [0; LANES],
            beta: [zero; 3],
            radiance: [zero; 3],
            contribution: [zero; 3],
            pdf: zero,
            random: RandomLanes {
                state: [0; LANES],
                increment: [0; LANES],
            },
            numbers: [zero; 4],
            surfaces: SurfaceLanes {
                vertices: [[zero; 3]; 3],
                reflectance: [zero; 3],
                is_light: zero,
            },
        }
    }
}

#[inline(always)]
pub fn get(from: &Lanes3, lane: usize) -> Vec3 {
    Vec3::new(from[0][lane], from[1][lane], from[2][lane])
}

#[inline(always)]
pub fn set(to: &mut Lanes3, lane: usize, v: Vec3) {
    to[0][lane] = v.x;
    to[1][lane] = v.y;
    to[2][lane] = v.z;
}
