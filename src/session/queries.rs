//! Questions about single rays: what they meet, whether they are free, what radiance comes along them.
//!
//! Measure: world units; times from 0, when the shutter opens, to 1; radiance.
//! Range: finite rays with a direction; others are errors. A surface that is only partly there counts where more than half of
//! it is, and a ray is free that more than half of the light passes along; radiance knows all shades.
//! Source: none needed. Tested in `tests/rendering/session.rs`.

use super::Session;
use crate::effects::Slot;
use crate::effects::kernel::types::Everything;
use crate::error::{Error, Result};
use crate::integrator::CameraRay;
use crate::math::ray::Ray;
use crate::math::vec::{DVec2, DVec3, Vec2, Vec3};
use crate::planted::planted;
use crate::render::along_ray::{AlongRay, along_rays};
use crate::render::check;
use crate::render::options::RenderOptions;

/// What a surface has to have left to count, and light to pass.
const HALF: f32 = 0.5;

/// A ray through the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QueryRay {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes, of any length but 0.
    pub direction: DVec3,
    /// What is at this distance or nearer does not count; at least 0.
    pub min_distance: f64,
    /// What is farther does not count; may be infinite.
    pub max_distance: f64,
    /// When it is traced, from 0 to 1 while the shutter is open.
    pub time: f64,
}

impl QueryRay {
    /// A ray without an end, as the shutter opens.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self {
            origin,
            direction,
            min_distance: 0.0,
            max_distance: f64::INFINITY,
            time: 0.0,
        }
    }
}

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Met {
    /// How far it is.
    pub distance: f64,
    /// Where it is.
    pub position: DVec3,
    /// The geometric normal, of unit length, on the side that the shape says is its front.
    pub geometric_normal: DVec3,
    /// The normal that is shaded with, of unit length: towards the ray, or outwards on what light passes through.
    pub shading_normal: DVec3,
    /// Texture coordinates; 0 where nothing on the shape asks for them.
    pub uv: DVec2,
    /// The shape's index in the description.
    pub shape: usize,
    /// The primitive's index in the shape, among those that have an area.
    pub primitive: u32,
}

impl Session {
    /// What a ray meets first.
    ///
    /// # Errors
    /// A ray out of its range.
    pub fn intersect(&self, ray: &QueryRay) -> Result<Option<Met>> {
        let CameraRay { ray: traced, time } = self.to_scene(ray)?;
        let scene = &self.scene;
        let met = scene.intersect::<Everything>(&traced, time, None, HALF);
        Ok(met.map(|at| {
            let position = scene.normalisation.world_point(at.p);
            Met {
                distance: (position - ray.origin).length(),
                position,
                geometric_normal: at.ng.as_dvec3(),
                shading_normal: at.frame.to_world(Vec3::Z).as_dvec3(),
                uv: at.uv.or(Vec2::ZERO).as_dvec2(),
                shape: scene.described(at.id.shape),
                primitive: at.id.primitive,
            }
        }))
    }

    /// Whether anything lies on a ray.
    ///
    /// # Errors
    /// A ray out of its range.
    pub fn occluded(&self, ray: &QueryRay) -> Result<bool> {
        let CameraRay { ray, time } = self.to_scene(ray)?;
        Ok(self.scene.visibility::<Everything>(&ray, time) <= HALF)
    }

    /// Estimates the radiance that comes along each ray to its origin, by `spp` samples each, with standard
    /// errors from four samples on; with layers wished for, `spp` is rounded up to a multiple of four. Each ray has random numbers of its own, by its index.
    ///
    /// # Errors
    /// A ray, wishes or samples out of their range.
    pub fn radiance(
        &self,
        options: &RenderOptions,
        rays: &[QueryRay],
        spp: u64,
    ) -> Result<Vec<AlongRay>> {
        let options = RenderOptions {
            spp: Some(spp),
            ..options.clone()
        };
        let settings = options.settings(&self.description)?;
        check(&self.scene, &settings)?;
        if settings.integrator.splats() {
            return Err(Error::usage(format!(
                "{} finds a part of the light by paths to the camera: along other rays it is missing",
                settings.integrator.name()
            )));
        }
        if u32::try_from(rays.len()).is_err() {
            return Err(Error::usage("more than 2^32 rays at once"));
        }
        let spp = spp.next_multiple_of(settings.least_samples());
        let rays: Vec<CameraRay> = rays
            .iter()
            .map(|ray| self.to_scene(ray))
            .collect::<Result<_>>()?;
        let estimate = || along_rays(&self.scene, &settings, &rays, spp);
        Ok(self.threads.run(estimate))
    }

    /// A ray in the scene's own units.
    fn to_scene(&self, ray: &QueryRay) -> Result<CameraRay> {
        let direction = ray.direction.try_normalize();
        let Some(direction) = direction.filter(|_| ray.origin.is_finite()) else {
            return Err(Error::usage(
                "expected a ray with a finite origin, and a finite direction that is not zero",
            ));
        };
        if !(ray.min_distance >= 0.0 && ray.min_distance < ray.max_distance) {
            return Err(Error::usage(
                "expected a ray with a least distance of at least 0, below its greatest",
            ));
        }
        if !(0.0..=1.0).contains(&ray.time) {
            return Err(Error::usage("expected the time of a ray from 0 to 1"));
        }
        let normalisation = &self.scene.normalisation;
        Ok(CameraRay {
            ray: Ray {
                origin: normalisation.point(ray.origin),
                dir: direction.as_vec3a(),
                t_min: planted!(
                    "min-distance-ignored",
                    0.0,
                    normalisation.length(ray.min_distance)
                ),
                t_max: normalisation.length(ray.max_distance),
            },
            time: ray.time as f32,
        })
    }
}
