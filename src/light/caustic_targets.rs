//! Caustic targets of light paths: spheres around the shapes that cast caustics, towards which emitted rays are sampled.
//!
//! An emitted ray is sampled by its light's own density or, with probability `TARGET_PROBABILITY`, towards one of the spheres: a
//! direction uniform in the cone of the sphere as seen from the point on the light, or for a light at infinity a point
//! uniform on the disk of the sphere across the ray. The density is that of the mixture, so that it covers every ray.
//!
//! Measure: normalised units; densities as in [`EmissionPdf`].
//! Range: any number of spheres; without one that the light can reach the density is the light's own.
//! Source: none needed: a mixture of densities. Tested below and in `tests/rendering/light_paths.rs`.

use super::types::{BoundingSphere, EmissionPdf, EmissionSample, ShadowRayEnd};
use crate::math::frame::Frame;
use crate::math::measure::{PdfArea, PdfSolidAngle};
use crate::math::vec::{Vec2, Vec3};
use crate::sampling::warp;
use std::f32::consts::PI;

/// The probability of sampling a ray towards a target, where there is one: most rays stay as the light emits them, since much
/// light reaches metal and glass by way of other surfaces.
const TARGET_PROBABILITY: f32 = 0.25;

/// The largest number of targets: a scene with more shapes that cast caustics has one target around all of them.
pub const MAX_TARGETS: usize = 12;

/// Spheres around the shapes that cast caustics.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CausticTargets {
    spheres: Vec<BoundingSphere>,
}

/// The ray that targets are weighed for: a point and the directions of rays from there, or a direction of parallel rays.
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

/// A target as seen by the rays.
#[derive(Debug, Clone, Copy)]
struct ProjectedTarget {
    /// The axis of its cone, or the centre of its disk.
    axis: Vec3,
    /// The solid angle of its cone, or the area of its disk: in proportion to the probability of selecting it. Zero where
    /// no ray reaches it.
    size: f32,
}

impl CausticTargets {
    /// Creates targets from these spheres.
    pub fn new(spheres: Vec<BoundingSphere>) -> Self {
        Self { spheres }
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
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
        let total: f32 = self.projected(rays).map(|target| target.size).sum();
        if total <= 0.0 || u_choice >= TARGET_PROBABILITY {
            return;
        }
        let mut rest = u_choice / TARGET_PROBABILITY * total;
        let reached = self.projected(rays).filter(|target| target.size > 0.0);
        let mut chosen = None;
        for target in reached {
            chosen = Some(target);
            rest -= target.size;
            if rest < 0.0 {
                break;
            }
        }
        let Some(target) = chosen else {
            return;
        };
        match rays {
            EmittedRays::From { .. } => {
                let one_minus_cos = target.size / (2.0 * PI);
                let local = warp::sample_cone_uniform(u_direction, one_minus_cos);
                sample.direction = Frame::from_normal(target.axis).to_world(local).normalize();
            }
            EmittedRays::Along(direction) => {
                let d = (target.size / PI).sqrt() * warp::sample_disk_concentric(u_position);
                let across = Frame::from_normal(-direction).to_world(Vec3::new(d.x, d.y, 0.0));
                let p = target.axis + across;
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
        let (mut total, mut hit) = (0.0, 0.0);
        for target in self.projected(rays).filter(|target| target.size > 0.0) {
            total += target.size;
            let is_hit = match rays {
                EmittedRays::From { .. } => {
                    // 1 - cos, without cancellation.
                    let chord2 = target.axis.distance_squared(direction);
                    PI * chord2 <= target.size
                }
                EmittedRays::Along(along) => {
                    let offset = target.axis - through;
                    let across = offset - offset.dot(along) * along;
                    PI * across.length_squared() <= target.size
                }
            };
            // Each target is selected in proportion to its size, over which its rays are spread.
            hit += if is_hit { 1.0 } else { 0.0 };
        }
        if total <= 0.0 {
            return;
        }
        let of_targets = TARGET_PROBABILITY * hit / total;
        let mixed = |own: f32| (1.0 - TARGET_PROBABILITY) * own + of_targets;
        match rays {
            EmittedRays::From { .. } => {
                pdf.direction = pdf.direction.map(|own| PdfSolidAngle(mixed(own.0)));
            }
            EmittedRays::Along(_) => pdf.position = pdf.position.map(|own| PdfArea(mixed(own.0))),
        }
    }

    /// The targets as seen by the rays.
    fn projected(&self, rays: EmittedRays) -> impl Iterator<Item = ProjectedTarget> {
        self.spheres.iter().map(move |sphere| match rays {
            EmittedRays::Along(_) => ProjectedTarget {
                axis: sphere.center,
                size: PI * sphere.radius * sphere.radius,
            },
            EmittedRays::From {
                point,
                normal,
                two_sided,
            } => {
                let offset = sphere.center - point;
                let is_behind = !two_sided && offset.dot(normal) < -sphere.radius;
                let distance2 = offset.length_squared();
                let sin2 = sphere.radius * sphere.radius / distance2;
                // A sphere around the point itself fills all directions.
                if sin2 >= 1.0 {
                    return ProjectedTarget {
                        axis: Vec3::Z,
                        size: 4.0 * PI,
                    };
                }
                let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
                ProjectedTarget {
                    axis: offset / distance2.sqrt(),
                    size: if is_behind {
                        0.0
                    } else {
                        2.0 * PI * one_minus_cos
                    },
                }
            }
        })
    }
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
        CausticTargets::new(vec![sphere(0.0, 0.5), sphere(-3.0, 1.0), sphere(0.8, 0.6)])
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
