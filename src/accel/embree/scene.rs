//! Owning handles of Embree's scenes: a scene under construction, and a committed scene, in which rays are traced.
//!
//! Each handle owns one reference and releases it when dropped. A scene holds a reference to its device, so the
//! device outlives its scenes. The owner of a scene keeps the buffers shared with Embree alive.
//!
//! Measure: normalised scene units, bytes.
//! Range: Embree 4 with the layout of hits given by its headers, which `layout.rs` checks.
//! Source: Embree's manual; embree4 headers. Tested in `tests/tracing/rays.rs`.

use super::device::Device;
use crate::accel::lanes::{RayHitLanes, RayLanes};
use crate::accel::{AccelOptions, Precision, Quality};
use crate::error::{Error, Result};
use crate::geometry::mesh::{Mesh, MeshVertex};
use crate::math::lanes::ActiveLanes;
use embree4_sys::*;
use std::ptr;
use std::sync::Arc;

/// A scene under construction, to which shapes are attached.
#[derive(Debug)]
pub struct EmbreeScene {
    handle: RTCScene,
    device: Arc<Device>,
    /// The scenes that instances refer to.
    groups: Vec<Arc<CommittedScene>>,
}

impl EmbreeScene {
    /// Creates an empty scene; robust precision makes it watertight along edges.
    pub fn new(device: Arc<Device>, options: AccelOptions) -> Result<Self> {
        // SAFETY: the device is valid, and kept alive by the scene.
        let handle = unsafe { rtcNewScene(device.handle) };
        device.take_error()?;
        let flags = match options.precision {
            Precision::Robust => RTC_SCENE_FLAG_ROBUST,
            Precision::Fast => RTC_SCENE_FLAG_NONE,
        };
        let quality = match options.quality() {
            Quality::Medium => RTC_BUILD_QUALITY_MEDIUM,
            Quality::High => RTC_BUILD_QUALITY_HIGH,
        };
        // SAFETY: the handle is valid, as no error was reported.
        unsafe {
            rtcSetSceneBuildQuality(handle, quality);
            rtcSetSceneFlags(handle, flags);
        }
        Ok(Self {
            handle,
            device,
            groups: Vec::new(),
        })
    }

    /// Attaches a mesh by reference under the given id.
    ///
    /// # Safety
    /// The mesh must stay where it is, unchanged, until the scene is dropped.
    pub unsafe fn attach_mesh(&mut self, id: u32, mesh: &Mesh) {
        // SAFETY: lengths and strides are those of the slices, which the caller keeps alive; Embree loads the first 16
        // bytes of a vertex, which has 32, as its position and a number that it ignores.
        unsafe {
            let geometry = rtcNewGeometry(self.device.handle, RTC_GEOMETRY_TYPE_TRIANGLE);
            rtcSetSharedGeometryBuffer(
                geometry,
                RTC_BUFFER_TYPE_VERTEX,
                0,
                RTC_FORMAT_FLOAT3,
                mesh.vertices().as_ptr().cast(),
                0,
                size_of::<MeshVertex>(),
                mesh.vertices().len(),
            );
            rtcSetSharedGeometryBuffer(
                geometry,
                RTC_BUFFER_TYPE_INDEX,
                0,
                RTC_FORMAT_UINT3,
                mesh.indices().as_ptr().cast(),
                0,
                size_of::<[u32; 3]>(),
                mesh.indices().len(),
            );
            self.attach(geometry, id);
        }
    }

    /// Attaches one sphere, `[x, y, z, radius]`, under the given id. Embree keeps a copy.
    pub fn attach_sphere(&mut self, id: u32, sphere: [f32; 4]) {
        // SAFETY: the new geometry is valid; `attach` takes it over.
        unsafe {
            let geometry = rtcNewGeometry(self.device.handle, RTC_GEOMETRY_TYPE_SPHERE_POINT);
            copy_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, sphere);
            self.attach(geometry, id);
        }
    }

    /// Attaches one flat disk, `[x, y, z, radius]` and its normal, under the given id. Embree keeps a copy.
    pub fn attach_disk(&mut self, id: u32, disk: [f32; 4], normal: [f32; 3]) {
        // SAFETY: the new geometry is valid; `attach` takes it over.
        unsafe {
            let kind = RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT;
            let geometry = rtcNewGeometry(self.device.handle, kind);
            copy_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, disk);
            copy_buffer(geometry, RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, normal);
            self.attach(geometry, id);
        }
    }

    /// Attaches an instance of another scene of the same device under the given id. Each of the steps, at equally
    /// spaced times from 0 to 1, holds the columns of the group-to-world matrix, the translation last.
    ///
    /// # Errors
    /// If there are more steps than Embree supports.
    pub fn attach_instance(
        &mut self,
        id: u32,
        group: &Arc<CommittedScene>,
        steps: &[[f32; 12]],
    ) -> Result<()> {
        if steps.len() > RTC_MAX_TIME_STEP_COUNT as usize {
            return Err(Error::render(format!(
                "Embree: more than {RTC_MAX_TIME_STEP_COUNT} steps of motion"
            )));
        }
        // SAFETY: the new geometry is valid unless null; the group is committed
        // and kept alive by this scene; Embree copies each matrix, whose length is that of its format.
        unsafe {
            let geometry = rtcNewGeometry(self.device.handle, RTC_GEOMETRY_TYPE_INSTANCE);
            if !geometry.is_null() {
                rtcSetGeometryInstancedScene(geometry, group.0.handle);
                rtcSetGeometryTimeStepCount(geometry, steps.len() as u32);
                for (number, step) in (0..).zip(steps) {
                    let format = RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR;
                    rtcSetGeometryTransform(geometry, number, format, step.as_ptr().cast());
                }
            }
            self.attach(geometry, id);
        }
        self.groups.push(Arc::clone(group));
        Ok(())
    }

    /// Commits a geometry and attaches it to the scene.
    ///
    /// # Safety
    /// `geometry` must be a new geometry of this device, or null after an error.
    unsafe fn attach(&mut self, geometry: RTCGeometry, id: u32) {
        if geometry.is_null() {
            return; // The error is collected and reported by `commit`.
        }
        // SAFETY: the geometry is valid; the scene takes its own reference, so ours is released.
        unsafe {
            rtcCommitGeometry(geometry);
            rtcAttachGeometryByID(self.handle, geometry, id);
            rtcReleaseGeometry(geometry);
        }
    }

    /// Builds the BVH.
    ///
    /// # Errors
    /// The first error that Embree reported since the scene was created.
    pub fn commit(self) -> Result<CommittedScene> {
        // SAFETY: the handle is valid and not shared.
        unsafe { rtcCommitScene(self.handle) };
        self.device.take_error()?;
        Ok(CommittedScene(self))
    }
}

impl Drop for EmbreeScene {
    fn drop(&mut self) {
        // SAFETY: this is the only reference, obtained by `new`; tracing borrows the scene, so no ray is being
        // traced.
        unsafe { rtcReleaseScene(self.handle) };
    }
}

/// Creates a buffer of one item, owned by the geometry, and fills it.
///
/// # Safety
/// `geometry` must be valid or null; `T` must be the plain floats that `format` names.
unsafe fn copy_buffer<T>(geometry: RTCGeometry, kind: RTCBufferType, format: RTCFormat, item: T) {
    if geometry.is_null() {
        return;
    }
    // SAFETY: Embree returns memory for one aligned item, or null after reporting an error.
    unsafe {
        let buffer = rtcSetNewGeometryBuffer(geometry, kind, 0, format, size_of::<T>(), 1);
        if !buffer.is_null() {
            buffer.cast::<T>().write(item);
        }
    }
}

/// A committed scene, in which any thread may trace rays.
#[derive(Debug)]
pub struct CommittedScene(EmbreeScene);

// SAFETY: queries on a committed scene are safe from any thread (manual, "Thread safety"), and a committed scene can no
// longer be changed.
unsafe impl Send for CommittedScene {}
// SAFETY: as above.
unsafe impl Sync for CommittedScene {}

impl CommittedScene {
    /// The device of the scene.
    pub fn device(&self) -> &Arc<Device> {
        &self.0.device
    }

    /// The number of bytes that Embree holds for the scene's device.
    pub fn memory(&self) -> usize {
        self.0.device.memory()
    }

    /// Traces one ray and fills in its closest hit.
    #[inline]
    pub fn intersect(&self, ray_hit: &mut RTCRayHit) {
        // SAFETY: the scene is committed; `ray_hit` has Embree's alignment by its type; null arguments are the
        // defaults.
        unsafe { rtcIntersect1(self.0.handle, ray_hit, ptr::null_mut()) };
    }

    /// Sets `tfar` of a ray to minus infinity if the ray is occluded.
    #[inline]
    pub fn occluded(&self, ray: &mut RTCRay) {
        // SAFETY: as in `intersect`.
        unsafe { rtcOccluded1(self.0.handle, ray, ptr::null_mut()) };
    }

    /// Traces the active lanes of a packet, fills in their closest hits and leaves the other lanes unchanged.
    #[inline]
    pub fn intersect_packet<const N: usize>(
        &self,
        active: &ActiveLanes<N>,
        packet: &mut RayHitLanes<N>,
        query: &mut PacketQuery,
    ) {
        const { assert!(N == 8 || N == 16) };
        let (active, packet) = (active.0.as_ptr(), ptr::from_mut(packet));
        let arguments = &mut query.intersect;
        // SAFETY: the scene is committed; mask and packet have Embree's layout and alignment for `N` lanes, as `layout.rs`
        // asserts, and live through the call; the arguments name no callback.
        unsafe {
            if N == 8 {
                rtcIntersect8(active, self.0.handle, packet.cast(), arguments);
            } else {
                rtcIntersect16(active, self.0.handle, packet.cast(), arguments);
            }
        }
    }

    /// Sets `t_max` of the active lanes of a packet to minus infinity where the ray is occluded.
    #[inline]
    pub fn occluded_packet<const N: usize>(
        &self,
        active: &ActiveLanes<N>,
        packet: &mut RayLanes<N>,
        query: &mut PacketQuery,
    ) {
        const { assert!(N == 8 || N == 16) };
        let (active, packet) = (active.0.as_ptr(), ptr::from_mut(packet));
        let arguments = &mut query.occluded;
        // SAFETY: as in `intersect_packet`.
        unsafe {
            if N == 8 {
                rtcOccluded8(active, self.0.handle, packet.cast(), arguments);
            } else {
                rtcOccluded16(active, self.0.handle, packet.cast(), arguments);
            }
        }
    }
}

/// Embree's query arguments for tracing packets, built once for all packets of a batch.
#[derive(Debug)]
pub struct PacketQuery {
    intersect: RTCIntersectArguments,
    occluded: RTCOccludedArguments,
}

impl PacketQuery {
    /// Builds the arguments for coherent or incoherent rays, with Embree's defaults otherwise.
    pub fn new(coherent: bool) -> Self {
        let flags = if coherent {
            RTC_RAY_QUERY_FLAG_COHERENT
        } else {
            RTC_RAY_QUERY_FLAG_INCOHERENT
        };
        let feature_mask = RTC_FEATURE_FLAG_ALL;
        Self {
            intersect: RTCIntersectArguments {
                flags,
                feature_mask,
                ..Default::default()
            },
            occluded: RTCOccludedArguments {
                flags,
                feature_mask,
                ..Default::default()
            },
        }
    }
}
