//! Queries for single rays: closest hits, occlusion, and the radiance along them.
//!
//! Measure: world units; times from 0, when the shutter opens, to 1; radiance.
//! Range: finite rays with a direction; others are errors. A surface with partial alpha is hit where its alpha exceeds
//! one half, and a ray is unoccluded if more than half of the light passes along it; radiance takes partial alpha into
//! account.
//! Source: none needed. Tested in `tests/rendering/session.rs`.

use super::Session;
use crate::effects::Slot;
use crate::effects::kernel::types::Everything;
use crate::error::{Error, Result};
use crate::integrator::CameraRay;
use crate::integrator::reuse::PathReuse;
use crate::math::ray::Ray;
use crate::math::vec::{DVec2, DVec3, Vec2, Vec3};
use crate::planted::planted;
use crate::render::check;
use crate::render::options::RenderOptions;
use crate::render::ray_radiance::{RayRadiance, along_rays};
use crate::render::settings::{Adaptive, LightPathRule, PathReuseRule};

/// The alpha above which a surface is hit, and the visibility above which a ray is unoccluded.
const HALF: f32 = 0.5;

/// A ray in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QueryRay {
    /// The point where the ray starts.
    pub origin: DVec3,
    /// The direction, of any length but 0.
    pub direction: DVec3,
    /// Hits at this distance or nearer are ignored; at least 0.
    pub min_distance: f64,
    /// Hits beyond this distance are ignored; may be infinite.
    pub max_distance: f64,
    /// The time within the shutter interval, from 0 to 1.
    pub time: f64,
}

impl QueryRay {
    /// Creates an infinite ray at the time when the shutter opens.
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

/// The surface interaction where a ray hits the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SurfaceHit {
    /// The distance from the origin of the ray.
    pub distance: f64,
    /// The position of the hit.
    pub position: DVec3,
    /// The geometric normal, of unit length, on the front side of the shape.
    pub geometric_normal: DVec3,
    /// The shading normal, of unit length: towards the ray, or outwards on transmissive surfaces.
    pub shading_normal: DVec3,
    /// The texture coordinates; 0 if nothing on the shape needs them.
    pub uv: DVec2,
    /// The index of the shape in the description.
    pub shape: usize,
    /// The index of the primitive in the shape, among those with nonzero area.
    pub primitive: u32,
}

impl Session {
    /// Finds the closest hit of a ray.
    ///
    /// # Errors
    /// A ray out of its range.
    pub fn intersect(&self, ray: &QueryRay) -> Result<Option<SurfaceHit>> {
        let CameraRay { ray: traced, time } = self.to_scene(ray)?;
        let scene = &self.scene;
        let at = scene.intersect::<Everything>(&traced, time, None, HALF);
        Ok(at.map(|at| {
            let position = scene.normalisation.world_point(at.p);
            SurfaceHit {
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

    /// Whether a ray is occluded.
    ///
    /// # Errors
    /// A ray out of its range.
    pub fn occluded(&self, ray: &QueryRay) -> Result<bool> {
        let CameraRay { ray, time } = self.to_scene(ray)?;
        Ok(self.scene.visibility::<Everything>(&ray, time) <= HALF)
    }

    /// Estimates the radiance that arrives along each ray at its origin, with `spp` samples each, and with standard
    /// errors if there are at least four samples. If layers are requested, `spp` is rounded up to a multiple of four.
    /// Each ray has its own random numbers, by its index. Adaptive sampling, light paths and shared paths are for images, and
    /// are left out.
    ///
    /// # Errors
    /// Rays, options or sample counts out of their range.
    pub fn radiance(
        &self,
        options: &RenderOptions,
        rays: &[QueryRay],
        spp: u64,
    ) -> Result<Vec<RayRadiance>> {
        let options = RenderOptions {
            spp: Some(spp),
            // Every ray has as many samples.
            adaptive: Some(Adaptive::Off),
            // The camera does not see where other rays begin.
            light_paths: Some(LightPathRule::OFF),
            reuse: Some(PathReuseRule::Pixels(PathReuse::Off)),
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
        let spp = spp.next_multiple_of(settings.spp_step());
        let rays: Vec<CameraRay> = rays
            .iter()
            .map(|ray| self.to_scene(ray))
            .collect::<Result<_>>()?;
        let estimate = || along_rays(&self.scene, &settings, &rays, spp);
        Ok(self.threads.run(estimate))
    }

    /// Converts a ray to the scene's normalised units.
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
