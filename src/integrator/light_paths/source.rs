//! The rays with which light paths begin, and their densities.
//!
//! Measure: the density of a ray is per unit of étendue, area times projected solid angle; of a ray from a light that no
//! other ray can hit, per unit of area across it at the point that it lights.
//! Range: any light; a ray without radiance is `None`.
//! Source: as in `light/emission.rs`. Tested in `tests/rendering/light_paths.rs`.

use crate::effects::Effects;
use crate::light::Light;
use crate::light::caustic_targets::PointRayLanes;
use crate::light::lanes::{LightContextLanes, LightSampleLanes};
use crate::light::types::{EmissionPdf, EmissionSample, ShadowRayEnd};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::scene::Scene;

/// The first ray of a light path.
#[derive(Debug, Clone, Copy)]
pub struct LightPathFirstRay {
    /// The light.
    pub light: u32,
    /// The emitted ray.
    pub sample: EmissionSample,
    /// The flux along the ray.
    pub flux: Rgb,
}

impl LightPathFirstRay {
    /// Samples the first ray of a light path by the random numbers of [`Decision::Source`] and
    /// [`Decision::SourceDirection`].
    ///
    /// [`Decision::Source`]: crate::sampler::Decision::Source
    /// [`Decision::SourceDirection`]: crate::sampler::Decision::SourceDirection
    pub fn sample<E: Effects>(
        scene: &Scene,
        ([u, v, u_choice, v_choice], [u_direction, v_direction, u_target]): ([f32; 4], [f32; 3]),
        time: f32,
    ) -> Option<Self> {
        let (light, pmf) = scene.lights.choose_by_power::<E>([u_choice, v_choice])?;
        let numbers = [Vec2::new(u, v), Vec2::new(u_direction, v_direction)];
        let mut sample = scene.sample_emission::<E>(light, time, numbers[0], numbers[1])?;
        if !scene.caustic_targets.is_empty() {
            let of_light = scene.lights.get(light);
            let (targets, bounding_sphere) = (&scene.caustic_targets, &scene.bounding_sphere);
            let two_sided = of_light.is_two_sided();
            targets.redirect(&mut sample, two_sided, u_target, numbers, bounding_sphere);
            let EmissionSample { end, direction, .. } = sample;
            let is_emitted = match of_light {
                Light::Spot(spot) => {
                    sample.radiance = spot.intensity(direction);
                    !sample.radiance.is_black()
                }
                // Point lights are uniform, and rays from infinity keep their direction.
                Light::Point(_) | Light::Distant(_) | Light::Environment(_) => true,
                Light::Triangle(_)
                | Light::MovingTriangle(_)
                | Light::Rectangle(_)
                | Light::Disk(_)
                | Light::Sphere(_) => match &end {
                    ShadowRayEnd::Surface(point, _) => {
                        let cos = direction.dot(point.ng);
                        cos > 0.0 || two_sided && cos < 0.0
                    }
                    _ => true,
                },
            };
            if !is_emitted {
                return None;
            }
            sample.pdf = pdf_of_ray(scene, light, time, &end, direction, sample.origin);
        }
        Some(Self {
            light,
            flux: sample.flux(pmf),
            sample,
        })
    }

    /// Whether a camera path can hit the light.
    pub fn can_be_hit(&self) -> bool {
        self.sample.pdf.can_be_hit()
    }

    /// The density of the ray, which lights the point `p`.
    pub fn density(&self, scene: &Scene, p: Vec3) -> f32 {
        let EmissionSample { end, direction, .. } = &self.sample;
        density(scene, self.light, end, *direction, p, &self.sample.pdf)
    }
}

/// The density of a ray that leaves a light at `end` along the unit vector `direction`, and lights the point `p`.
pub fn density_of_ray(
    scene: &Scene,
    light: u32,
    time: f32,
    end: &ShadowRayEnd,
    direction: Vec3,
    p: Vec3,
) -> f32 {
    let pdf = if targets_are_in_weights() {
        pdf_of_ray(scene, light, time, end, direction, p)
    } else {
        scene.pdf_emission(light, time, end, direction)
    };
    density(scene, light, end, direction, p, &pdf)
}

/// The densities of rays along the light samples of some lanes towards the points `p`, as [`density_of_ray`].
pub fn densities_of_light_samples(
    scene: &Scene,
    lanes: &ActiveLanes<LANES>,
    context: &LightContextLanes,
    samples: &LightSampleLanes,
    p: &Lanes3,
) -> Lanes<f32> {
    let mut e = [0.0; LANES];
    let mut rays = PointRayLanes::default();
    let mut from_points = ActiveLanes::<LANES>::NONE;
    for lane in lanes.each() {
        let Some(sample) = samples.get(lane) else {
            continue;
        };
        let (light, time) = (context.light[lane], context.time[lane]);
        let (direction, p) = (-sample.wi, load(p, lane));
        let (point, normal) = match sample.end {
            ShadowRayEnd::Surface(point, _) => (point.p, point.ng),
            ShadowRayEnd::Point(point) => (point, Vec3::ZERO),
            ShadowRayEnd::Infinity => {
                e[lane] = density_of_ray(scene, light, time, &sample.end, direction, p);
                continue;
            }
        };
        let mut pdf = scene.pdf_emission(light, time, &sample.end, direction);
        rays.pdf[lane] = pdf.direction.take().map_or(1.0, |pdf| pdf.0);
        e[lane] = density(scene, light, &sample.end, direction, p, &pdf);
        store(&mut rays.point, lane, point);
        store(&mut rays.normal, lane, normal);
        let leaves_all_around = matches!(sample.end, ShadowRayEnd::Point(_));
        let two_sided = leaves_all_around || scene.lights.get(light).is_two_sided();
        rays.two_sided[lane] = u32::from(two_sided);
        store(&mut rays.direction, lane, direction);
        from_points.set(lane, true);
    }
    if targets_are_in_weights() {
        scene.caustic_targets.mix_lanes(&mut rays);
    }
    for lane in from_points.each() {
        e[lane] *= rays.pdf[lane];
    }
    e
}

/// Whether the weights of the strategies take the sampling of caustic targets into account.
#[inline(always)]
fn targets_are_in_weights() -> bool {
    planted!("caustic-targets-left-out-of-weight", false, true)
}

/// The densities of a ray, which lights the point `p`, in the measures of its light.
fn pdf_of_ray(
    scene: &Scene,
    light: u32,
    time: f32,
    end: &ShadowRayEnd,
    direction: Vec3,
    p: Vec3,
) -> EmissionPdf {
    let mut pdf = scene.pdf_emission(light, time, end, direction);
    let two_sided = scene.lights.get(light).is_two_sided();
    let targets = &scene.caustic_targets;
    targets.mix(&mut pdf, end, direction, p, two_sided);
    pdf
}

/// The density of a ray, given its densities in the measures of its light.
fn density(
    scene: &Scene,
    light: u32,
    end: &ShadowRayEnd,
    direction: Vec3,
    p: Vec3,
    pdf: &EmissionPdf,
) -> f32 {
    let across = match end {
        ShadowRayEnd::Surface(point, _) => direction.dot(point.ng).abs(),
        ShadowRayEnd::Point(from) => p.distance_squared(*from),
        ShadowRayEnd::Infinity => 1.0,
    };
    let position = pdf.position.map_or(1.0, |pdf| pdf.0);
    let direction = pdf.direction.map_or(1.0, |pdf| pdf.0);
    scene.lights.pmf_by_power(light).0 * position * (direction / across)
}
