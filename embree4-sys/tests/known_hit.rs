//! Traces a triangle whose hits are known, with single rays and packets of 4, 8 and 16.
//!
//! What it proves about the Embree that is linked: every field of a ray and of a hit lies where
//! the bindings say; lanes that are switched off or miss stay as they were; nothing is written
//! past a packet's end. Each packet is laid out here by hand, as fields of `N` lanes, and the
//! bindings are held against that.

use embree4_sys::*;
use std::mem::offset_of;
use std::ptr::null_mut;

const GEOMETRY: u32 = 7;
const PRIMITIVE: u32 = 1;

/// The value that surrounds a packet, and fills the fields of a hit before it is traced.
const CANARY: u32 = 0xC0FF_EE00;

/// The 32-bit fields of `RTCRayHit`, in order; `RTCRay` is the first twelve. The last is new in
/// Embree 4.3.
#[derive(Clone, Copy, PartialEq, Debug)]
#[repr(usize)]
enum Field {
    OrgX,
    OrgY,
    OrgZ,
    TNear,
    DirX,
    DirY,
    DirZ,
    Time,
    TFar,
    Mask,
    Id,
    Flags,
    NgX,
    NgY,
    NgZ,
    U,
    V,
    PrimId,
    GeomId,
    InstId,
    InstPrimId,
}
const FIELDS: usize = Field::InstPrimId as usize + 1;

/// A packet of `N` rays between two runs of canaries.
#[derive(Clone, PartialEq, Debug)]
#[repr(C, align(64))]
struct Guarded<const N: usize> {
    before: [u32; 64],
    fields: [[u32; N]; FIELDS],
    after: [u32; 64],
}

/// Which lanes take part: -1 yes, 0 no.
#[repr(C, align(64))]
struct Valid<const N: usize>([i32; N]);

/// The outcome for which a lane is set up.
#[derive(Clone, Copy, PartialEq)]
enum Fate {
    Hit,
    Miss,
    Off,
}

fn fate(lane: usize) -> Fate {
    [Fate::Hit, Fate::Miss, Fate::Off][lane % 3]
}

/// Barycentrics of the hit that lane `lane` is aimed at; exact in binary.
fn target(lane: usize) -> (f32, f32) {
    (0.125 + lane as f32 / 64.0, 0.5 - lane as f32 / 128.0)
}

impl<const N: usize> Guarded<N> {
    /// Rays from z = 5 down towards the triangle of `Scene::new`; all that miss pass it by.
    fn new() -> Self {
        let mut packet = Guarded {
            before: [CANARY; 64],
            fields: [[CANARY; N]; FIELDS],
            after: [CANARY; 64],
        };
        for lane in 0..N {
            let (u, v) = target(lane);
            let aside = if fate(lane) == Fate::Miss { 100.0 } else { 0.0 };
            let ray = [
                4.0 * u + aside,
                4.0 * v,
                5.0,
                0.0,
                0.0,
                0.0,
                -2.0,
                0.0,
                f32::INFINITY,
            ];
            for (field, value) in packet.fields.iter_mut().zip(ray) {
                field[lane] = value.to_bits();
            }
            packet.fields[Field::Mask as usize][lane] = u32::MAX;
            packet.fields[Field::Id as usize][lane] = 1000 + lane as u32;
            packet.fields[Field::Flags as usize][lane] = 0;
            packet.fields[Field::GeomId as usize][lane] = RTC_INVALID_GEOMETRY_ID;
            packet.fields[Field::InstId as usize][lane] = RTC_INVALID_GEOMETRY_ID;
        }
        packet
    }

    fn valid() -> Valid<N> {
        Valid(std::array::from_fn(|lane| {
            if fate(lane) == Fate::Off { 0 } else { -1 }
        }))
    }

    fn set(&mut self, field: Field, lane: usize, value: u32) {
        self.fields[field as usize][lane] = value;
    }

    fn float(&self, field: Field, lane: usize) -> f32 {
        f32::from_bits(self.fields[field as usize][lane])
    }
}

/// A committed scene of two triangles, the second of which is the target: its corners are
/// (0,0,0), (4,0,0) and (0,4,0).
struct Scene {
    device: RTCDevice,
    scene: RTCScene,
}

impl Scene {
    fn new() -> Self {
        let vertices: [[f32; 3]; 6] = [
            [50.0, 50.0, 0.0],
            [51.0, 50.0, 0.0],
            [50.0, 51.0, 0.0],
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [0.0, 4.0, 0.0],
        ];
        let triangles: [[u32; 3]; 2] = [[0, 1, 2], [3, 4, 5]];
        // SAFETY: every handle is one that Embree has just returned; both buffers are written
        // within the size that they were asked for with, before the commit that reads them.
        unsafe {
            let device = rtcNewDevice(c"threads=1".as_ptr());
            assert!(
                !device.is_null(),
                "no device: error {}",
                rtcGetDeviceError(null_mut())
            );
            let geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
            let (float3, uint3) = (RTC_FORMAT_FLOAT3, RTC_FORMAT_UINT3);
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, float3, 12, 6)
                .cast::<[[f32; 3]; 6]>()
                .write(vertices);
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, uint3, 12, 2)
                .cast::<[[u32; 3]; 2]>()
                .write(triangles);
            rtcCommitGeometry(geometry);
            let scene = rtcNewScene(device);
            rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
            rtcAttachGeometryByID(scene, geometry, GEOMETRY);
            rtcReleaseGeometry(geometry);
            rtcCommitScene(scene);
            assert_eq!(rtcGetDeviceError(device), RTC_ERROR_NONE);
            Scene { device, scene }
        }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: the two handles are ours, are released once, and nothing uses them after.
        unsafe {
            rtcReleaseScene(self.scene);
            rtcReleaseDevice(self.device);
        }
    }
}

/// A query of Embree's: lanes that are on, what to trace through, the packet, its arguments.
type Query<Packet, Arguments> =
    unsafe extern "C" fn(*const i32, RTCScene, *mut Packet, *mut Arguments);

/// Runs a query that takes `N` lanes; yields what was handed to it and what it made of that.
fn trace<const N: usize, P, A>(query: Query<P, A>) -> (Guarded<N>, Guarded<N>) {
    let scene = Scene::new();
    let before = Guarded::<N>::new();
    let mut after = before.clone();
    let packet = (&raw mut after.fields).cast();
    // SAFETY: the scene is committed; both pointers lead to `N` lanes, aligned to 64 bytes, and
    // the packet is followed by more than the padding of any structure of Embree's.
    unsafe {
        query(
            Guarded::<N>::valid().0.as_ptr(),
            scene.scene,
            packet,
            null_mut(),
        )
    };
    (before, after)
}

/// Checks a query for closest hits.
fn closest_hits<const N: usize, P, A>(query: Query<P, A>) {
    let (mut expected, after) = trace::<N, _, _>(query);
    for lane in (0..N).filter(|&lane| fate(lane) == Fate::Hit) {
        // Computed with a reciprocal, these may be off in their last bits; all else is exact.
        let (u, v) = target(lane);
        let hit = [
            (Field::TFar, 2.5),
            (Field::U, u),
            (Field::V, v),
            (Field::NgX, 0.0),
            (Field::NgY, 0.0),
            (Field::NgZ, 16.0),
        ];
        for (field, value) in hit {
            let traced = after.float(field, lane);
            assert!(
                (traced - value).abs() < 1e-6,
                "{field:?} of lane {lane}: {traced}, not {value}"
            );
            expected.set(field, lane, traced.to_bits());
        }
        expected.set(Field::PrimId, lane, PRIMITIVE);
        expected.set(Field::GeomId, lane, GEOMETRY);
        expected.set(Field::InstId, lane, RTC_INVALID_GEOMETRY_ID);
        if RTC_VERSION >= 40300 {
            expected.set(Field::InstPrimId, lane, RTC_INVALID_GEOMETRY_ID);
        }
    }
    assert_eq!(after, expected);
}

/// Checks a query for occlusion, to which the fields of a hit are out of bounds.
fn occlusion<const N: usize, P, A>(query: Query<P, A>) {
    let (mut expected, after) = trace::<N, _, _>(query);
    for lane in (0..N).filter(|&lane| fate(lane) == Fate::Hit) {
        expected.set(Field::TFar, lane, f32::NEG_INFINITY.to_bits());
    }
    assert_eq!(after, expected);
}

/// `rtcIntersect1` as a packet query of one lane.
unsafe extern "C" fn intersect1(
    _: *const i32,
    scene: RTCScene,
    ray: *mut RTCRayHit,
    arguments: *mut RTCIntersectArguments,
) {
    // SAFETY: what the caller promises for a packet holds for its only lane.
    unsafe { rtcIntersect1(scene, ray, arguments) }
}

/// `rtcOccluded1` as a packet query of one lane.
unsafe extern "C" fn occluded1(
    _: *const i32,
    scene: RTCScene,
    ray: *mut RTCRay,
    arguments: *mut RTCOccludedArguments,
) {
    // SAFETY: as in `intersect1`.
    unsafe { rtcOccluded1(scene, ray, arguments) }
}

#[test]
fn single_rays_return_known_hits() {
    closest_hits::<1, _, _>(intersect1);
    occlusion::<1, _, _>(occluded1);
}

#[test]
fn packets_of_4_return_known_hits() {
    closest_hits::<4, _, _>(rtcIntersect4);
    occlusion::<4, _, _>(rtcOccluded4);
}

#[test]
fn packets_of_8_return_known_hits() {
    closest_hits::<8, _, _>(rtcIntersect8);
    occlusion::<8, _, _>(rtcOccluded8);
}

#[test]
fn packets_of_16_return_known_hits() {
    closest_hits::<16, _, _>(rtcIntersect16);
    occlusion::<16, _, _>(rtcOccluded16);
}

#[test]
fn ray_hit_layout_matches_the_bindings() {
    macro_rules! check {
        ($packet:ident, $n:literal, $($field:ident: $part:ident.$name:ident),*) => {
            $(assert_eq!(
                offset_of!($packet, $part.$name),
                Field::$field as usize * $n * size_of::<u32>(),
                concat!(stringify!($packet), ".", stringify!($name)),
            );)*
        };
    }
    macro_rules! check_all {
        ($($packet:ident: $n:literal),*) => {
            $(check!(
                $packet, $n,
                OrgX: ray.org_x, OrgY: ray.org_y, OrgZ: ray.org_z, TNear: ray.tnear,
                DirX: ray.dir_x, DirY: ray.dir_y, DirZ: ray.dir_z, Time: ray.time,
                TFar: ray.tfar, Mask: ray.mask, Id: ray.id, Flags: ray.flags,
                NgX: hit.Ng_x, NgY: hit.Ng_y, NgZ: hit.Ng_z, U: hit.u, V: hit.v,
                PrimId: hit.primID, GeomId: hit.geomID, InstId: hit.instID
            );)*
        };
    }
    check_all!(RTCRayHit: 1, RTCRayHit4: 4, RTCRayHit8: 8, RTCRayHit16: 16);
}
