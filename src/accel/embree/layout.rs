//! A run-time check of the layout of Embree's hits, by tracing rays with known results before any others. A library
//! built with more instance levels than its headers declare writes past the end of every hit, and has no property
//! that reveals this.
//!
//! Measure: none.
//! Range: every device, with single rays and with the packets that it traces natively.
//! Source: embree4-sys and the assertions at the end of this file check the headers at compile time. Tested by every
//! test that builds a scene.

use super::device::Device;
use super::new_ray_hit;
use super::scene::{CommittedScene, EmbreeScene, PacketQuery};
use crate::accel::batch::{PacketWidth, RayBatch};
use crate::accel::lanes::{HitLanes, NO_ID, RayHitLanes, RayLanes};
use crate::accel::{AccelOptions, Backend, Precision};
use crate::error::{Error, Result};
use crate::math::lanes::ActiveLanes;
use crate::math::ray::Ray;
use crate::math::vec::Vec3;
use embree4_sys::{
    RTC_INVALID_GEOMETRY_ID, RTCHit, RTCHit8, RTCHit16, RTCRay8, RTCRay16, RTCRayHit, RTCRayHit8,
    RTCRayHit16,
};
use std::mem::offset_of;
use std::sync::Arc;

/// The geometry id of the test sphere.
const ID: u32 = 3;

/// Traces rays that hit and miss a sphere, and checks every field that is read later.
///
/// # Errors
/// If the library does not match its headers.
pub fn check(device: &Arc<Device>) -> Result<()> {
    let options = AccelOptions {
        backend: Backend::Embree,
        precision: Precision::Fast,
        quality: None,
        threads: 1,
    };
    let mut scene = EmbreeScene::new(Arc::clone(device), options)?;
    scene.attach_sphere(ID, [0.0, 0.0, 0.0, 1.0]);
    let scene = scene.commit()?;
    let fits = PacketWidth::ALL.iter().all(|&width| match width {
        PacketWidth::One => single_rays_fit(&scene),
        _ if !device.is_native(width.lanes()) => true,
        PacketWidth::Eight => packets_fit::<8>(&scene),
        PacketWidth::Sixteen => packets_fit::<16>(&scene),
    });
    if fits {
        return Ok(());
    }
    Err(Error::render(format!(
        "the Embree library does not fit the headers that this program was built with \
         (its hits are not the {} bytes of one instance level); rebuild against the installed Embree",
        size_of::<RTCHit>()
    )))
}

/// A ray that hits the sphere at t = 2, and one that misses it.
fn at_and_past() -> [Ray; 2] {
    [0.0, 3.0].map(|x| Ray::new(Vec3::new(x, 0.0, -3.0), Vec3::Z))
}

/// Whether t is 2, up to rounding: instruction sets differ in the last digits.
fn is_at_two(t: f32) -> bool {
    (t - 2.0).abs() < 1e-5
}

fn single_rays_fit(scene: &CommittedScene) -> bool {
    let [mut at, mut past] = at_and_past().map(|ray| Guarded::new(new_ray_hit(&ray, 0.0)));
    scene.intersect(&mut at.query);
    scene.intersect(&mut past.query);
    let RTCRayHit { ray, hit } = at.query;
    let found = is_at_two(ray.tfar)
        && (hit.geomID, hit.primID) == (ID, 0)
        && hit.instID == [RTC_INVALID_GEOMETRY_ID];
    let missed = past.query.hit.geomID == RTC_INVALID_GEOMETRY_ID;
    found && missed && at.is_intact() && past.is_intact()
}

/// Whether packets of `N` rays fit. The lanes cyclically hit, miss, or would hit but are masked out.
fn packets_fit<const N: usize>(scene: &CommittedScene) -> bool {
    let [at, past] = at_and_past();
    let mut rays = RayBatch::default();
    for lane in 0..N {
        rays.push(if lane % 3 == 1 { &past } else { &at }, 0.0);
        rays.active[lane] = lane % 3 != 2;
    }
    let mut query = PacketQuery::new(false);
    let mut guarded = Guarded::new(RayHitLanes::<N>::default());
    let active = guarded.query.rays.load(&rays, 0);
    scene.intersect_packet(&active, &mut guarded.query, &mut query);
    let mut occlusion = Guarded::new(guarded.query.rays.clone());
    occlusion.query.t_max = [f32::INFINITY; N];
    scene.occluded_packet(&active, &mut occlusion.query, &mut query);

    let RayHitLanes { rays: ends, hits } = &guarded.query;
    let lane_fits = |lane: usize| {
        let ids = (hits.geometry[lane], hits.primitive[lane]);
        let occluded = occlusion.query.t_max[lane] < 0.0;
        if lane.is_multiple_of(3) {
            is_at_two(ends.t_max[lane]) && ids == (ID, 0) && occluded
        } else {
            let nothing = (RTC_INVALID_GEOMETRY_ID, RTC_INVALID_GEOMETRY_ID);
            ends.t_max[lane] == f32::INFINITY && ids == nothing && !occluded
        }
    };
    (0..N).all(|lane| lane_fits(lane) && hits.instance[lane] == RTC_INVALID_GEOMETRY_ID)
        && guarded.is_intact()
        && occlusion.is_intact()
}

/// A query followed by a guard area that a library with another layout would overwrite.
#[repr(C)]
struct Guarded<Q> {
    query: Q,
    guard: [u32; 256],
}

impl<Q> Guarded<Q> {
    const CANARY: u32 = 0xC0FF_EE00;

    fn new(query: Q) -> Box<Self> {
        let guard = [Self::CANARY; 256];
        Box::new(Self { query, guard })
    }

    fn is_intact(&self) -> bool {
        self.guard.iter().all(|&word| word == Self::CANARY)
    }
}

const _: () = assert!(NO_ID == RTC_INVALID_GEOMETRY_ID);

/// Asserts that the types for one packet width match those of the headers.
macro_rules! assert_layout {
    ($lanes:literal, $ray:ident, $hit:ident, $ray_hit:ident) => {
        const _: () = {
            const N: usize = $lanes;
            assert!(align_of::<ActiveLanes<N>>() >= align_of::<$ray_hit>());
            assert!(size_of::<RayLanes<N>>() == size_of::<$ray>());
            assert!(align_of::<RayLanes<N>>() >= align_of::<$ray>());
            assert!(offset_of!(RayLanes<N>, origin) == offset_of!($ray, org_x));
            assert!(offset_of!(RayLanes<N>, t_min) == offset_of!($ray, tnear));
            assert!(offset_of!(RayLanes<N>, dir) == offset_of!($ray, dir_x));
            assert!(offset_of!(RayLanes<N>, time) == offset_of!($ray, time));
            assert!(offset_of!(RayLanes<N>, t_max) == offset_of!($ray, tfar));
            assert!(offset_of!(RayLanes<N>, mask) == offset_of!($ray, mask));
            assert!(offset_of!(RayLanes<N>, id) == offset_of!($ray, id));
            assert!(offset_of!(RayLanes<N>, flags) == offset_of!($ray, flags));
            // Hits have one more field since Embree 4.3.
            assert!(size_of::<HitLanes<N>>() >= size_of::<$hit>());
            assert!(offset_of!(HitLanes<N>, normal) == offset_of!($hit, Ng_x));
            assert!(offset_of!(HitLanes<N>, u) == offset_of!($hit, u));
            assert!(offset_of!(HitLanes<N>, v) == offset_of!($hit, v));
            assert!(offset_of!(HitLanes<N>, primitive) == offset_of!($hit, primID));
            assert!(offset_of!(HitLanes<N>, geometry) == offset_of!($hit, geomID));
            assert!(offset_of!(HitLanes<N>, instance) == offset_of!($hit, instID));
            assert!(size_of::<RayHitLanes<N>>() >= size_of::<$ray_hit>());
            assert!(align_of::<RayHitLanes<N>>() >= align_of::<$ray_hit>());
            assert!(offset_of!(RayHitLanes<N>, hits) == offset_of!($ray_hit, hit));
        };
    };
}

assert_layout!(8, RTCRay8, RTCHit8, RTCRayHit8);
assert_layout!(16, RTCRay16, RTCHit16, RTCRayHit16);
