//! Sampling of emitted rays, with which light subpaths start.
//!
//! On an area light, the point is sampled uniformly by area and the direction in proportion to the cosine with the normal.
//! For a point or spot light, the direction is uniform over the sphere or the cone. For a light at infinity, the direction
//! is sampled first, then a point uniformly on a disk perpendicular to it, of the radius of the scene's bounding sphere.
//!
//! Measure: densities per unit of area in normalised units, and per steradian.
//! Range: any light; for a two-sided one each side has probability 1/2. A ray without radiance is `None`.
//! Source: Pharr, Jakob, Humphreys, "Light Interface", `SampleLe`; Veach 1997, section 10.3.1. Tested in
//! `tests/lights/emission.rs`.

use super::Light;
use super::types::{
    BoundingSphere, Emission, EmissionPdf, EmissionSample, EnvironmentSampling, ShadowRayEnd,
};
use crate::effects::{Effects, Switch, beyond_kernel};
use crate::geometry::surface::SurfacePoint;
use crate::math::frame::Frame;
use crate::math::measure::{PdfArea, PdfSolidAngle, Pmf};
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::robust::{offset_point, reach_of_point};
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampling::warp;
use std::f32::consts::PI;

impl Light {
    /// Samples an emitted ray at a time of the shutter, from random numbers for its position and for its direction.
    pub fn sample_emission<E: Effects>(
        &self,
        time: f32,
        u_position: Vec2,
        u_direction: Vec2,
        bounding_sphere: &BoundingSphere,
    ) -> Option<EmissionSample> {
        let flat = [0.0; 2];
        let lamp = |(point, b), emission, pdf| from_surface(point, b, emission, pdf, u_direction);
        match self {
            Self::Triangle(light) if E::AreaLights::ON => {
                lamp(light.point(u_position), light.emission(), light.pdf_area())
            }
            Self::MovingTriangle(light) if E::Motion::ON => {
                let light = light.at(time);
                lamp(light.point(u_position), light.emission(), light.pdf_area())
            }
            Self::Rectangle(light) if E::AreaLights::ON => {
                let point = light.point(u_position);
                lamp((point, flat), light.emission(), light.pdf_area())
            }
            Self::Disk(light) if E::AreaLights::ON => {
                let point = light.point(u_position);
                lamp((point, flat), light.emission(), light.pdf_area())
            }
            Self::Sphere(light) if E::AreaLights::ON => {
                let point = light.point(u_position);
                lamp((point, flat), light.emission(), light.pdf_area())
            }
            Self::Point(light) if E::DeltaLights::ON => {
                let direction = warp::sample_sphere_uniform(u_direction);
                let pdf = PdfSolidAngle(warp::PDF_SPHERE_UNIFORM);
                from_point(light.position(), direction, light.intensity(), pdf)
            }
            Self::Spot(light) if E::DeltaLights::ON => {
                let direction = light.direction(u_direction);
                let pdf = light.pdf_direction(direction);
                from_point(light.position(), direction, light.intensity(direction), pdf)
            }
            Self::Distant(light) if E::DeltaLights::ON => {
                let ray = (light.direction(), light.irradiance(), None);
                from_beyond(ray, u_position, bounding_sphere)
            }
            Self::Environment(map) if E::EnvironmentMap::ON => {
                let sample = map.sample(u_direction, EnvironmentSampling::Radiance)?;
                from_beyond(
                    (-sample.wi, sample.radiance, sample.pdf),
                    u_position,
                    bounding_sphere,
                )
            }
            _ => beyond_kernel(),
        }
    }

    /// Whether the light is a surface that emits on both sides.
    pub fn is_two_sided(&self) -> bool {
        match self {
            Self::Triangle(light) => light.emission().two_sided,
            Self::MovingTriangle(light) => light.at(0.0).emission().two_sided,
            Self::Rectangle(light) => light.emission().two_sided,
            Self::Disk(light) => light.emission().two_sided,
            Self::Sphere(light) => light.emission().two_sided,
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) | Self::Environment(_) => false,
        }
    }

    /// The densities of [`sample_emission`](Self::sample_emission) for a ray along the unit vector `direction` that leaves
    /// the light where its normal is `normal`, which lights without a surface ignore.
    pub fn pdf_emission(
        &self,
        time: f32,
        normal: Vec3,
        direction: Vec3,
        bounding_sphere: &BoundingSphere,
    ) -> EmissionPdf {
        let cos = direction.dot(normal);
        let lamp = |pdf, emission: Emission| EmissionPdf {
            position: Some(pdf),
            direction: Some(pdf_cosine(&emission, cos)),
        };
        let point = |direction| EmissionPdf {
            position: None,
            direction: Some(direction),
        };
        match self {
            Self::Triangle(light) => lamp(light.pdf_area(), light.emission()),
            Self::MovingTriangle(light) => {
                let light = light.at(time);
                lamp(light.pdf_area(), light.emission())
            }
            Self::Rectangle(light) => lamp(light.pdf_area(), light.emission()),
            Self::Disk(light) => lamp(light.pdf_area(), light.emission()),
            Self::Sphere(light) => lamp(light.pdf_area(), light.emission()),
            Self::Point(_) => point(PdfSolidAngle(warp::PDF_SPHERE_UNIFORM)),
            Self::Spot(light) => point(light.pdf_direction(direction)),
            Self::Distant(_) => EmissionPdf {
                position: Some(pdf_disk(bounding_sphere)),
                direction: None,
            },
            Self::Environment(map) => EmissionPdf {
                position: Some(pdf_disk(bounding_sphere)),
                direction: Some(map.eval(-direction, EnvironmentSampling::Radiance).1),
            },
        }
    }
}

impl EmissionSample {
    /// The ray: it begins beyond the bound of the error of its point.
    pub fn ray(&self) -> Ray {
        let origin = match &self.end {
            ShadowRayEnd::Surface(point, _) => {
                let leaves_above = self.direction.dot(point.ng) > 0.0;
                let side = if leaves_above { point.ng } else { -point.ng };
                offset_point(point.p, point.error, side)
            }
            ShadowRayEnd::Point(point) => *point + reach_of_point(*point) * self.direction,
            ShadowRayEnd::Infinity => self.origin,
        };
        Ray::new(origin, self.direction)
    }

    /// The flux that a light path along the ray carries, with the probability `pmf` of selecting the light.
    pub fn flux(&self, pmf: Pmf) -> Rgb {
        let cos = match &self.end {
            ShadowRayEnd::Surface(point, _) => self.direction.dot(point.ng).abs(),
            ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => 1.0,
        };
        let position = self.pdf.position.map_or(1.0, |pdf| pdf.0);
        let direction = self.pdf.direction.map_or(1.0, |pdf| pdf.0);
        self.radiance * (cos / direction / position / pmf.0)
    }
}

/// Samples a ray from a point of an area light.
fn from_surface(
    point: SurfacePoint,
    barycentric: [f32; 2],
    emission: Emission,
    pdf: PdfArea,
    u: Vec2,
) -> Option<EmissionSample> {
    let (u, side) = if !emission.two_sided {
        (u, 1.0)
    } else if u.x < 0.5 {
        (Vec2::new(2.0 * u.x, u.y), 1.0)
    } else {
        (Vec2::new(2.0 * u.x - 1.0, u.y), -1.0)
    };
    let local = warp::sample_hemisphere_cosine(u);
    let direction = Frame::from_normal(side * point.ng).to_world(local);
    // Of the rounded direction, as for a ray that hits the light along it.
    let cos = direction.dot(point.ng);
    let density = pdf_cosine(&emission, cos);
    (density.0 > 0.0).then_some(EmissionSample {
        end: ShadowRayEnd::Surface(point, barycentric),
        origin: point.p,
        direction,
        radiance: emission.towards(cos),
        pdf: EmissionPdf {
            position: Some(pdf),
            direction: Some(density),
        },
    })
}

/// The density of directions about the normal of an area light.
fn pdf_cosine(emission: &Emission, cos: f32) -> PdfSolidAngle {
    let of_one_side = warp::pdf_hemisphere_cosine(if emission.two_sided { cos.abs() } else { cos });
    let sides = planted!("both-sides-at-once", 1.0, emission.sides());
    PdfSolidAngle(of_one_side / sides)
}

/// Builds a ray from a point or spot light.
fn from_point(
    position: Vec3,
    direction: Vec3,
    intensity: Rgb,
    pdf: PdfSolidAngle,
) -> Option<EmissionSample> {
    (!intensity.is_black() && pdf.0 > 0.0).then_some(EmissionSample {
        end: ShadowRayEnd::Point(position),
        origin: position,
        direction,
        radiance: intensity,
        pdf: EmissionPdf {
            position: None,
            direction: Some(pdf),
        },
    })
}

/// Samples a ray from a light at infinity, given its direction, its radiance and its density per steradian.
fn from_beyond(
    (direction, radiance, pdf): (Vec3, Rgb, Option<PdfSolidAngle>),
    u: Vec2,
    bounding_sphere: &BoundingSphere,
) -> Option<EmissionSample> {
    let d = bounding_sphere.radius * warp::sample_disk_concentric(u);
    let frame = Frame::from_normal(-direction);
    Some(EmissionSample {
        end: ShadowRayEnd::Infinity,
        origin: bounding_sphere.center
            + frame.to_world(Vec3::new(d.x, d.y, bounding_sphere.radius)),
        direction,
        radiance,
        pdf: EmissionPdf {
            position: Some(pdf_disk(bounding_sphere)),
            direction: pdf,
        },
    })
}

/// The density of points on a disk of the sphere's radius.
fn pdf_disk(bounding_sphere: &BoundingSphere) -> PdfArea {
    PdfArea(1.0 / (PI * bounding_sphere.radius * bounding_sphere.radius))
}
