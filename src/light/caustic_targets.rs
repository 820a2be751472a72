//! Caustic targets of light paths: spheres around the shapes that cast caustics, towards which emitted rays are sampled.
//!
//! An emitted ray is sampled by its light's own density or, with probability `TARGET_PROBABILITY`, towards one of the spheres: a
//! direction uniform in the cone of the sphere as seen from the point on the light, or for a light at infinity a point
//! uniform on the disk of the sphere across the ray. Spheres are selected in proportion to the squared sines of their cones, or to
//! the areas of their disks. The density is that of the mixture, so that it covers every ray.
//!
//! Measure: normalised units; densities as in [`EmissionPdf`].
//! Range: at most [`MAX_TARGETS`] spheres; without one that the light can reach the density is the light's own.
//! Source: none needed: a mixture of densities. Tested below and in `tests/rendering/light_paths.rs`.

use super::types::{BoundingSphere, EmissionPdf, EmissionSample, ShadowRayEnd};
use crate::math::frame::Frame;
use crate::math::lanes::{LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::vec::{LaneVec3, Vec2, Vec3};
use crate::sampling::warp;
use std::f32::consts::{FRAC_1_PI, PI};

/// The probability of sampling a ray towards a target, where there is one: many rays stay as the light emits them, since much
/// light reaches metal and glass by way of other surfaces.
const TARGET_PROBABILITY: f32 = 0.5;

/// The largest number of targets: one for each lane.
pub const MAX_TARGETS: usize = LANES;

/// Spheres around the shapes that cast caustics. Lanes beyond the last have a radius of zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CausticTargets {
    count: usize,
    center: Lanes3,
    radius: Lanes<f32>,
}

/// The rays that targets are weighed for: those from a point, or parallel ones.
#[derive(Debug, Clone, Copy)]
enum EmittedRays {
    /// Rays from a point; the normal is zero where they leave in all directions.
    From {
        point: Vec3,
        normal: Vec3,
        two_sided: bool,
    },
    /// Parallel rays along a unit vector.
    Along(Vec3),
}

/// The targets as seen by the rays.
#[derive(Debug, Clone, Copy, Default)]
struct ProjectedTargets {
    /// The axes of their cones, or the centres of their disks.
    axis: Lanes3,
    /// The squared sines of their cones, or the areas of their disks: the weights of selecting each. 2 for a sphere around
    /// the point itself, and 0 where no ray reaches the target.
    weight: Lanes<f32>,
}

/// Rays of sixteen lanes that leave lights at points, with the densities of their directions.
#[repr(align(64))]
#[derive(Debug, Clone, Copy, Default)]
pub struct PointRayLanes {
    /// The points that they leave.
    pub point: Lanes3,
    /// The normals there; zero where rays leave in all directions.
    pub normal: Lanes3,
    /// 1 where both sides of the surface emit, else 0.
    pub two_sided: Lanes<u32>,
    /// Unit vectors along the rays.
    pub direction: Lanes3,
    /// The densities of the directions.
    pub pdf: Lanes<f32>,
}

impl CausticTargets {
    /// Creates targets from these spheres, at most [`MAX_TARGETS`].
    pub fn new(spheres: &[BoundingSphere]) -> Self {
        assert!(spheres.len() <= MAX_TARGETS, "one target per lane");
        let mut this = Self {
            count: spheres.len(),
            ..Self::default()
        };
        for (lane, sphere) in spheres.iter().enumerate() {
            store(&mut this.center, lane, sphere.center);
            this.radius[lane] = sphere.radius;
        }
        this
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Redirects an emitted ray that its light has sampled towards a target or leaves it as it is, by a number for the
    /// choice and those of the light's own sample. Its radiance and its densities have to be computed again. `two_sided` is
    /// whether both sides of a surface emit.
    pub fn redirect(
        &self,
        sample: &mut EmissionSample,
        two_sided: bool,
        u_choice: f32,
        [u_position, u_direction]: [Vec2; 2],
        bounding_sphere: &BoundingSphere,
    ) {
        let rays = EmittedRays::of(&sample.end, sample.direction, two_sided);
        let targets = self.projected(rays);
        let total = sum(targets.weight);
        if total <= 0.0 || u_choice >= TARGET_PROBABILITY {
            return;
        }
        let mut rest = u_choice / TARGET_PROBABILITY * total;
        let mut chosen = None;
        for lane in (0..LANES).filter(|&lane| targets.weight[lane] > 0.0) {
            chosen = Some(lane);
            rest -= targets.weight[lane];
            if rest < 0.0 {
                break;
            }
        }
        let Some(lane) = chosen else {
            return;
        };
        let (axis, weight): (Vec3, f32) = (load(&targets.axis, lane), targets.weight[lane]);
        match rays {
            EmittedRays::From { .. } => {
                let one_minus_cos = if weight > 1.0 {
                    2.0
                } else {
                    weight / (1.0 + cos_of_cone(weight))
                };
                let local = warp::sample_cone_uniform(u_direction, one_minus_cos);
                sample.direction = Frame::from_normal(axis).to_world(local).normalize();
            }
            EmittedRays::Along(direction) => {
                let d = (weight / PI).sqrt() * warp::sample_disk_concentric(u_position);
                let across = Frame::from_normal(-direction).to_world(Vec3::new(d.x, d.y, 0.0));
                let p = axis + across;
                // The ray begins in front of the whole scene.
                let depth = (p - bounding_sphere.center).dot(direction) + bounding_sphere.radius;
                sample.origin = p - depth * direction;
            }
        }
    }

    /// Changes the densities of a light's own sampling to those of the mixture, for a ray through `through`.
    #[inline]
    pub fn mix(
        &self,
        pdf: &mut EmissionPdf,
        end: &ShadowRayEnd,
        direction: Vec3,
        through: Vec3,
        two_sided: bool,
    ) {
        if self.is_empty() {
            return;
        }
        let rays = EmittedRays::of(end, direction, two_sided);
        let [total, in_targets] = match rays {
            EmittedRays::From {
                point,
                normal,
                two_sided,
            } => density_from(
                self,
                point.into(),
                normal.into(),
                two_sided,
                direction.into(),
            ),
            EmittedRays::Along(along) => density_along(self, along.into(), through.into()),
        };
        if total <= 0.0 {
            return;
        }
        let mixed = |own: f32| mixture(own, in_targets / total);
        match rays {
            EmittedRays::From { .. } => {
                pdf.direction = pdf.direction.map(|own| PdfSolidAngle(mixed(own.0)));
            }
            EmittedRays::Along(_) => pdf.position = pdf.position.map(|own| PdfArea(mixed(own.0))),
        }
    }

    /// Changes the densities of the directions of rays from points to those of the mixture.
    #[inline]
    pub fn mix_lanes(&self, rays: &mut PointRayLanes) {
        if !self.is_empty() {
            mix_directions(self, rays);
        }
    }

    /// The targets as seen by the rays.
    fn projected(&self, rays: EmittedRays) -> ProjectedTargets {
        match rays {
            EmittedRays::Along(_) => ProjectedTargets {
                axis: self.center,
                weight: self.radius.map(disk),
            },
            EmittedRays::From {
                point,
                normal,
                two_sided,
            } => seen_from(self, point.into(), normal.into(), two_sided),
        }
    }
}

/// The density of the mixture, given that of a light's own sampling and that of sampling the targets.
#[inline(always)]
fn mixture(own: f32, of_targets: f32) -> f32 {
    (1.0 - TARGET_PROBABILITY) * own + TARGET_PROBABILITY * of_targets
}

/// The weight of a sphere's cone as seen by rays from a point, and the vector to its centre.
#[inline(always)]
fn cone(
    (center, radius): (LaneVec3, f32),
    point: LaneVec3,
    normal: LaneVec3,
    two_sided: bool,
) -> (f32, LaneVec3) {
    let offset = center - point;
    let is_behind = !two_sided & (offset.dot(normal) < -radius);
    let sin2 = radius * radius / offset.dot(offset);
    // A sphere around the point itself fills all directions, twice as many as the largest cone.
    let is_within = sin2 >= 1.0;
    let is_reached = (radius > 0.0) & (is_within | !is_behind);
    let weight = if is_within { 2.0 } else { sin2 };
    (if is_reached { weight } else { 0.0 }, offset)
}

/// The cosine of a cone with this weight; 0 for a sphere around the point.
#[inline(always)]
fn cos_of_cone(weight: f32) -> f32 {
    (1.0 - weight.min(1.0)).sqrt()
}

/// The density of a direction within a cone, times the cone's weight; 0 beyond it. With the sine s and the cosine c, the
/// weight s^2 over the solid angle 2 pi (1 - c) is (1 + c) / (2 pi).
#[inline(always)]
fn weighted_density((weight, offset): (f32, LaneVec3), radius: f32, direction: LaneVec3) -> f32 {
    // The distance across the ray has no cancellation, as the squared cosine of a narrow cone would.
    let along = offset.dot(direction);
    let across = offset - direction * along;
    let is_in_cone = (along > 0.0) & (across.dot(across) <= radius * radius);
    let is_hit = (weight > 0.0) & ((weight > 1.0) | is_in_cone);
    let density = (1.0 + cos_of_cone(weight)) * (0.5 * FRAC_1_PI);
    if is_hit { density } else { 0.0 }
}

vectorised! {
    /// The targets as seen by rays from a point.
    fn seen_from(
        spheres: &CausticTargets,
        point: [f32; 3],
        normal: [f32; 3],
        two_sided: bool,
    ) -> ProjectedTargets {
        let mut seen = ProjectedTargets::default();
        for lane in 0..LANES {
            let sphere = (load(&spheres.center, lane), spheres.radius[lane]);
            let (weight, offset) = cone(sphere, point.into(), normal.into(), two_sided);
            let axis = offset * (1.0 / offset.dot(offset).sqrt());
            let any = LaneVec3::from([0.0, 0.0, 1.0]);
            store(&mut seen.axis, lane, if weight > 1.0 { any } else { axis });
            seen.weight[lane] = weight;
        }
        seen
    }
}

vectorised! {
    /// The sum of the weights of the targets' cones, and the density of the unit vector `direction` in all of them, times
    /// that sum.
    fn density_from(
        spheres: &CausticTargets,
        point: [f32; 3],
        normal: [f32; 3],
        two_sided: bool,
        direction: [f32; 3],
    ) -> [f32; 2] {
        let (mut weights, mut densities) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let radius = spheres.radius[lane];
            let sphere = (load(&spheres.center, lane), radius);
            let cone = cone(sphere, point.into(), normal.into(), two_sided);
            weights[lane] = cone.0;
            densities[lane] = weighted_density(cone, radius, direction.into());
        }
        [sum(weights), sum(densities)]
    }
}

vectorised! {
    /// Changes the densities of directions from points to those of the mixture.
    fn mix_directions(spheres: &CausticTargets, rays: &mut PointRayLanes) {
        let (mut weights, mut densities) = ([0.0; LANES], [0.0; LANES]);
        for target in 0..spheres.count {
            let radius = spheres.radius[target];
            let center: LaneVec3 = load(&spheres.center, target);
            for lane in 0..LANES {
                let (point, normal) = (load(&rays.point, lane), load(&rays.normal, lane));
                let cone = cone((center, radius), point, normal, rays.two_sided[lane] != 0);
                let direction = load(&rays.direction, lane);
                weights[lane] += cone.0;
                densities[lane] += weighted_density(cone, radius, direction);
            }
        }
        for lane in 0..LANES {
            let (own, total) = (rays.pdf[lane], weights[lane]);
            let mixed = mixture(own, densities[lane] / total);
            rays.pdf[lane] = if total > 0.0 { mixed } else { own };
        }
    }
}

vectorised! {
    /// The sum of the areas of the targets' disks across the unit vector `along`, and the density of a ray through
    /// `through` in all of them, times that sum: the number of disks that it meets.
    fn density_along(spheres: &CausticTargets, along: [f32; 3], through: [f32; 3]) -> [f32; 2] {
        let (mut areas, mut hits) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let (area, along) = (disk(spheres.radius[lane]), LaneVec3::from(along));
            let offset = load::<LaneVec3>(&spheres.center, lane) - LaneVec3::from(through);
            let across = offset - along * offset.dot(along);
            let is_hit = (area > 0.0) & (PI * across.dot(across) <= area);
            areas[lane] = area;
            hits[lane] = if is_hit { 1.0 } else { 0.0 };
        }
        [sum(areas), sum(hits)]
    }
}

/// The area of a sphere's disk across parallel rays.
#[inline(always)]
fn disk(radius: f32) -> f32 {
    PI * radius * radius
}

/// The sum over all lanes, in pairs: in vectors, and in the same order on any processor.
#[inline(always)]
fn sum(mut terms: Lanes<f32>) -> f32 {
    let mut count = LANES / 2;
    while count > 0 {
        for lane in 0..count {
            terms[lane] += terms[lane + count];
        }
        count /= 2;
    }
    terms[0]
}

impl EmittedRays {
    fn of(end: &ShadowRayEnd, direction: Vec3, two_sided: bool) -> Self {
        match end {
            ShadowRayEnd::Surface(point, _) => Self::From {
                point: point.p,
                normal: point.ng,
                two_sided,
            },
            ShadowRayEnd::Point(point) => Self::From {
                point: *point,
                normal: Vec3::ZERO,
                two_sided: true,
            },
            ShadowRayEnd::Infinity => Self::Along(direction),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rgb::Rgb;
    use crate::sampler::hash;

    /// A number in [0, 1), by an index.
    fn number(index: u64, of: u64) -> f32 {
        (hash::combine(index, of) >> 40) as f32 / 16_777_216.0
    }

    fn caustic_targets() -> CausticTargets {
        let sphere = |x, radius| BoundingSphere {
            center: Vec3::new(x, 0.5, 2.0),
            radius,
        };
        // The last encloses a part of the first.
        CausticTargets::new(&[sphere(0.0, 0.5), sphere(-3.0, 1.0), sphere(0.8, 0.6)])
    }

    const AROUND: BoundingSphere = BoundingSphere {
        center: Vec3::ZERO,
        radius: 5.0,
    };

    /// The mean of one over the density is the measure of all rays, and its error that of samples with weights of at most
    /// 1 / (1 - TARGET_PROBABILITY).
    fn measure(end: ShadowRayEnd, own: EmissionPdf, two_sided: bool) -> [f64; 2] {
        let (targets, count) = (caustic_targets(), 100_000);
        let (mut sum, mut redirected) = (0.0, 0);
        for index in 0..count {
            let u = [1, 3].map(|of| Vec2::new(number(index, of), number(index, of + 1)));
            let d = AROUND.radius * warp::sample_disk_concentric(u[0]);
            let (direction, origin) = match &end {
                ShadowRayEnd::Infinity => (-Vec3::Z, Vec3::new(d.x, d.y, AROUND.radius)),
                _ => (warp::sample_sphere_uniform(u[1]), Vec3::ZERO),
            };
            let mut sample = EmissionSample {
                end,
                origin,
                direction,
                radiance: Rgb::WHITE,
                pdf: own,
            };
            targets.redirect(&mut sample, two_sided, number(index, 5), u, &AROUND);
            let is_redirected = sample.direction != direction || sample.origin != origin;
            redirected += u32::from(is_redirected);
            targets.mix(
                &mut sample.pdf,
                &end,
                sample.direction,
                sample.origin,
                two_sided,
            );
            let pdf = match &end {
                ShadowRayEnd::Infinity => sample.pdf.position.map(|pdf| pdf.0),
                _ => sample.pdf.direction.map(|pdf| pdf.0),
            };
            sum += 1.0 / f64::from(pdf.expect("it has a density"));
        }
        [sum / count as f64, f64::from(redirected) / count as f64]
    }

    #[test]
    fn mixed_pdf_matches_sampling_over_the_sphere_of_directions() {
        let own = EmissionPdf {
            position: None,
            direction: Some(PdfSolidAngle(warp::PDF_SPHERE_UNIFORM)),
        };
        let [all, redirected] = measure(ShadowRayEnd::Point(Vec3::ZERO), own, true);
        // Standard errors of at most 1 / sqrt(100 000), relative to all, with five of them as tolerance.
        assert!(
            (all / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.016,
            "{all}"
        );
        assert!(
            (redirected - f64::from(TARGET_PROBABILITY)).abs() < 0.007,
            "{redirected}"
        );
    }

    #[test]
    fn mixed_pdf_matches_sampling_of_parallel_rays() {
        let area = PI * AROUND.radius * AROUND.radius;
        let own = EmissionPdf {
            position: Some(PdfArea(1.0 / area)),
            direction: None,
        };
        let [all, redirected] = measure(ShadowRayEnd::Infinity, own, false);
        assert!((all / f64::from(area) - 1.0).abs() < 0.016, "{all}");
        assert!(
            (redirected - f64::from(TARGET_PROBABILITY)).abs() < 0.007,
            "{redirected}"
        );
    }
}
