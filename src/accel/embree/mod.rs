//! The Embree backend.
//!
//! Single rays are traced by `rtcIntersect1` and `rtcOccluded1`, batches by packets (`packets.rs`). In robust
//! precision every hit on a triangle is checked (`check.rs`).
//!
//! A group is a separate Embree scene, built once; its instances are attached to the main scene under the ids that
//! follow those of the top-level shapes.
//!
//! Measure: normalised scene units.
//! Range: coordinates up to 1e18 in magnitude, Embree's own limit; finite rays.
//! Source: Embree's manual; Woop, Benthin and Wald 2013 for its robust mode. Tested in `tests/tracing/rays.rs`.
#![allow(unsafe_code)]

mod check;
mod device;
mod info;
mod lanes;
mod layout;
mod packets;
mod scene;

pub use info::info;

use super::batch::PacketWidth;
use super::{AccelOptions, Hit, PrimitiveId};
use crate::error::Result;
use crate::geometry::Geometry;
use crate::geometry::world::World;
use crate::math::ray::Ray;
use crate::math::vec::DAffine3;
use device::Device;
use embree4_sys::{RTC_INVALID_GEOMETRY_ID, RTCHit, RTCRay, RTCRayHit};
use scene::{CommittedScene, EmbreeScene};
use std::sync::Arc;

/// A committed Embree scene and the shapes it refers to.
#[derive(Debug)]
pub struct EmbreeAccel {
    // Declared first, so that it is dropped before the world, whose buffers it shares.
    scene: CommittedScene,
    /// The committed scenes of the groups, by group index; `None` for groups without instances.
    groups: Vec<Option<Arc<CommittedScene>>>,
    world: Arc<World>,
    options: AccelOptions,
    /// Embree's id of the first instance.
    first_instance: u32,
    /// The packet widths that the library traces natively.
    native_widths: Vec<PacketWidth>,
}

impl EmbreeAccel {
    /// Builds BVHs of the requested quality over the world and its groups.
    ///
    /// # Errors
    /// Embree's error message.
    pub fn build(world: Arc<World>, options: AccelOptions) -> Result<Self> {
        let device = Device::new(options.threads)?;
        layout::check(&device)?;
        let groups = vec![None; world.groups().len()];
        Self::over(device, groups, world, options)
    }

    /// Builds the structure over a world that shares its shapes with the current one. The scenes of groups are
    /// reused.
    ///
    /// # Errors
    /// Embree's error message.
    ///
    /// # Panics
    /// If the worlds do not share their shapes, to which the scenes of groups point.
    pub fn with_instances_of(&self, world: Arc<World>) -> Result<Self> {
        assert!(self.world.shares_shapes_with(&world));
        let device = Arc::clone(self.scene.device());
        Self::over(device, self.groups.clone(), world, self.options)
    }

    /// Builds the groups that are missing in `groups`, and the top-level scene.
    fn over(
        device: Arc<Device>,
        mut groups: Vec<Option<Arc<CommittedScene>>>,
        world: Arc<World>,
        options: AccelOptions,
    ) -> Result<Self> {
        let mut scene = EmbreeScene::new(Arc::clone(&device), options)?;
        // SAFETY: the shapes are immutable behind their `Arc`, which outlives the scene in `Self`; so are those of the
        // groups' scenes, which `with_instances_of` checks.
        unsafe { attach_shapes(&mut scene, world.geometries()) };
        // SAFETY: as above.
        unsafe { attach_instances(&mut scene, &device, options, &world, &mut groups)? };
        let widths = PacketWidth::ALL.iter().copied();
        Ok(Self {
            native_widths: widths.filter(|&w| device.is_native(w.lanes())).collect(),
            scene: scene.commit()?,
            groups,
            first_instance: world.geometries().len() as u32,
            world,
            options,
        })
    }

    /// Finds the closest hit.
    #[inline]
    pub fn intersect(&self, ray: &Ray, time: f32) -> Option<Hit> {
        let hit = self.query(ray, time)?;
        self.confirm(ray, time, hit)
    }

    /// Whether the ray is occluded.
    #[inline]
    pub fn occluded(&self, ray: &Ray, time: f32) -> bool {
        if !ray.is_finite() {
            return false;
        }
        let mut query = new_ray(ray, time);
        self.scene.occluded(&mut query);
        query.tfar < 0.0
    }

    /// The number of bytes that Embree holds.
    pub fn memory(&self) -> usize {
        self.scene.memory()
    }

    #[inline]
    fn query(&self, ray: &Ray, time: f32) -> Option<Hit> {
        if !ray.is_finite() {
            return None;
        }
        let mut query = new_ray_hit(ray, time);
        self.scene.intersect(&mut query);
        let RTCHit {
            geomID: geometry,
            primID: primitive,
            instID: [instance],
            ..
        } = query.hit;
        let ids = [geometry, primitive, instance];
        self.hit(ids, query.ray.tfar, [query.hit.u, query.hit.v])
    }

    /// Converts Embree's ids of geometry, primitive and instance to a hit; `None` for a miss.
    #[inline]
    fn hit(&self, ids: [u32; 3], t: f32, uv: [f32; 2]) -> Option<Hit> {
        let [geometry, primitive, instance] = ids;
        if geometry == RTC_INVALID_GEOMETRY_ID {
            return None;
        }
        let shape = if instance == RTC_INVALID_GEOMETRY_ID {
            geometry
        } else {
            let instance = instance - self.first_instance;
            self.world.first_shape(instance as usize) + geometry
        };
        let id = PrimitiveId { shape, primitive };
        Some(Hit { id, t, uv })
    }
}

/// Attaches shapes under their indices.
///
/// # Safety
/// The shapes must stay where they are, unchanged, until the scene is dropped.
unsafe fn attach_shapes(scene: &mut EmbreeScene, shapes: &[Geometry]) {
    for (id, geometry) in (0..).zip(shapes) {
        match geometry {
            Geometry::Mesh(mesh) if mesh.indices().is_empty() => {}
            // SAFETY: guaranteed by the caller for all shapes.
            Geometry::Mesh(mesh) => unsafe { scene.attach_mesh(id, mesh) },
            Geometry::Sphere(sphere) => {
                scene.attach_sphere(id, sphere.center.extend(sphere.radius).to_array());
            }
            Geometry::Disk(disk) => {
                let center_radius = disk.center.extend(disk.radius).to_array();
                scene.attach_disk(id, center_radius, disk.normal.to_array());
            }
        }
    }
}

/// Attaches all instances, under the ids that follow those of the top-level shapes. Builds groups that are instanced
/// and not built yet.
///
/// # Errors
/// Embree's error message.
///
/// # Safety
/// The world must stay where it is, unchanged, until the scene is dropped.
unsafe fn attach_instances(
    scene: &mut EmbreeScene,
    device: &Arc<Device>,
    options: AccelOptions,
    world: &World,
    groups: &mut [Option<Arc<CommittedScene>>],
) -> Result<()> {
    let first = world.geometries().len() as u32;
    for (id, instance) in (first..).zip(world.instances()) {
        let group = match &mut groups[instance.group] {
            Some(built) => built,
            unbuilt => {
                let mut group = EmbreeScene::new(Arc::clone(device), options)?;
                // SAFETY: guaranteed by the caller for the world.
                unsafe { attach_shapes(&mut group, &world.groups()[instance.group]) };
                unbuilt.insert(Arc::new(group.commit()?))
            }
        };
        let steps: Vec<_> = instance.steps.iter().map(to_single).collect();
        scene.attach_instance(id, group, &steps)?;
    }
    Ok(())
}

/// The entries of a matrix in single precision, which represents them exactly.
fn to_single(matrix: &DAffine3) -> [f32; 12] {
    matrix.to_cols_array().map(|entry| entry as f32)
}

#[inline]
fn new_ray(ray: &Ray, time: f32) -> RTCRay {
    RTCRay {
        org_x: ray.origin.x,
        org_y: ray.origin.y,
        org_z: ray.origin.z,
        tnear: ray.t_min,
        dir_x: ray.dir.x,
        dir_y: ray.dir.y,
        dir_z: ray.dir.z,
        time,
        tfar: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

#[inline]
fn new_ray_hit(ray: &Ray, time: f32) -> RTCRayHit {
    let mut query = RTCRayHit {
        ray: new_ray(ray, time),
        ..Default::default()
    };
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID = [RTC_INVALID_GEOMETRY_ID];
    query
}
