//! Bounds of lights and of groups of lights, and the estimate by which one of them is selected.
//!
//! A sphere holds all points that emit, and a cone all normals. The light travels in directions up to an angle away from
//! some normal: a right angle for a surface, zero for a spot light, whose cone of light stands for the normals. The
//! estimate for a receiver is
//!
//!   I c_x c_l / (d^2 + r^2 / 2),
//!
//! with the intensity I along a normal, the distance d of the sphere's centre, its radius r, and upper bounds c_x and c_l
//! of the cosines at the receiver and at the light over all points of the sphere. It is the irradiance of a point light, and
//! close to that of a disk above the receiver at any distance. It is zero only where no point of the sphere can light the
//! receiver.
//!
//! Measure: lengths in normalised units; intensities relative to the largest.
//! Range: any light and any receiver. The estimate is from `MIN_ESTIMATE` to `MAX_ESTIMATE`, or zero.
//! Source: Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", sections 4 and
//! 5. Tested in `tests/lights/choice.rs`.

use super::Light;
use super::types::Receiver;
use crate::math::vec::{Vec3, Vector};
use crate::planted::planted;
use std::f64::consts::PI;

/// The least estimate above zero.
const MIN_ESTIMATE: f32 = 1e-37;

/// The largest estimate: the sum of some is finite.
const MAX_ESTIMATE: f32 = 1e35;

/// A bound of the rounding errors of the cosines.
const MARGIN: f32 = 1e-5;

/// The bounds of one light or of several.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightBounds<V = Vec3> {
    /// The centre of the sphere; for lights at infinity the unit vector towards one, or any for several.
    pub center: V,
    /// 1, or 0 for lights at infinity, whose estimate does not depend on distance.
    pub nearness: f32,
    /// The radius of the sphere.
    pub radius: f32,
    /// The axis of the cone of normals.
    pub axis: V,
    /// The cosine of the angle from the axis to the normals; -1 where they point everywhere.
    pub cos_normals: f32,
    /// The cosine of the angle from a normal to the light's directions.
    pub cos_emission: f32,
    /// The intensity, or the irradiance of a light at infinity.
    pub intensity: f32,
}

impl LightBounds {
    /// The bounds of points on a surface with this normal.
    fn surface(points: &[Vec3], normal: Option<Vec3>) -> Self {
        let low = points.iter().fold(points[0], |low, p| low.min(*p));
        let high = points.iter().fold(points[0], |high, p| high.max(*p));
        let center = low + 0.5 * (high - low);
        let distances = points.iter().map(|p| p.distance(center));
        let radius = distances.fold(0.0, f32::max);
        Self {
            axis: normal.unwrap_or(Vec3::Z),
            cos_normals: if normal.is_some() { 1.0 } else { -1.0 },
            ..Self::point(center, radius)
        }
    }

    /// The bounds of a sphere that emits everywhere.
    fn point(center: Vec3, radius: f32) -> Self {
        Self {
            center,
            nearness: 1.0,
            radius: enlarged(radius, center),
            axis: Vec3::Z,
            cos_normals: -1.0,
            cos_emission: 0.0,
            intensity: 0.0,
        }
    }

    /// The bounds of several lights at infinity, or of one of all directions.
    fn at_infinity() -> Self {
        Self {
            nearness: 0.0,
            ..Self::point(Vec3::X, 1.0)
        }
    }

    /// The bounds of lights, with the sum of their intensities.
    ///
    /// # Panics
    /// If there are none.
    pub fn of_all<'a>(lights: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let first = *lights.clone().next().expect("a group has lights");
        let (mut low, mut high) = (first.center, first.center);
        let (mut axis, mut intensity, mut cos_emission) = (Vec3::ZERO, 0.0, 1.0);
        for it in lights.clone() {
            (low, high) = (low.min(it.center), high.max(it.center));
            axis += it.intensity * it.axis;
            intensity += f64::from(it.intensity);
            cos_emission = f32::min(cos_emission, it.cos_emission);
        }
        let intensity = intensity as f32;
        if first.nearness == 0.0 {
            return Self {
                intensity,
                ..Self::at_infinity()
            };
        }
        let center = low + 0.5 * (high - low);
        let axis = axis.normalize_or(Vec3::Z);
        let (mut radius, mut cos_normals) = (0.0, 1.0);
        for it in lights {
            radius = f32::max(radius, it.center.distance(center) + it.radius);
            cos_normals = f32::min(cos_normals, widened(it.axis.dot(axis), it.cos_normals));
        }
        Self {
            center,
            nearness: 1.0,
            radius: enlarged(radius, center),
            axis,
            cos_normals: f32::max(cos_normals - MARGIN, -1.0),
            cos_emission,
            intensity,
        }
    }
}

/// A radius with the rounding errors of distances from `center`.
fn enlarged(radius: f32, center: Vec3) -> f32 {
    let error = 4.0 * f32::EPSILON * (center.abs().max_element() + radius);
    radius + error
}

/// The cosine of the sum of two angles, or -1 beyond pi.
fn widened(cos_a: f32, cos_b: f32) -> f32 {
    let (cos_a, cos_b) = (cos_a.clamp(-1.0, 1.0), cos_b.clamp(-1.0, 1.0));
    if cos_a + cos_b <= 0.0 {
        return -1.0;
    }
    let sin = |cos: f32| (1.0 - cos * cos).sqrt();
    cos_a * cos_b - sin(cos_a) * sin(cos_b)
}

/// The cosine of the angle `a`, less the angle `b` but not below zero. Free of branches.
#[inline(always)]
fn narrowed(cos_a: f32, sin_b: f32, cos_b: f32) -> f32 {
    let sin_a = (1.0 - cos_a * cos_a).max(0.0).sqrt();
    let between = cos_a * cos_b + sin_a * sin_b;
    if cos_a >= cos_b { 1.0 } else { between }
}

impl<V: Vector> LightBounds<V> {
    /// The estimate for a receiver. Free of branches.
    #[inline(always)]
    pub fn estimate(&self, receiver: &Receiver<V>) -> f32 {
        let towards = self.center - receiver.p * self.nearness;
        let distance2 = towards.length_squared();
        let radius2 = self.radius * self.radius;
        let is_inside = distance2 <= radius2;
        let over_distance = 1.0 / distance2.sqrt();
        // The angle between the directions to the sphere's centre and to its edge.
        let sin2 = (radius2 / distance2).min(1.0);
        let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).sqrt());
        let cosine = |normal: V| (normal.dot(towards) * over_distance).clamp(-1.0, 1.0);
        let at_center = cosine(receiver.normal);
        let at_receiver = planted!(
            "light-bound-without-size",
            at_center,
            narrowed(at_center, sin, cos)
        );
        let has_sides = receiver.normal.length_squared() > 0.0;
        let at_receiver = if has_sides & !is_inside {
            at_receiver
        } else {
            1.0
        };
        let sin_normals = (1.0 - self.cos_normals * self.cos_normals).max(0.0).sqrt();
        let off_normals = narrowed(cosine(-self.axis), sin_normals, self.cos_normals);
        let at_light = narrowed(off_normals, sin, cos);
        let at_light = if is_inside { 1.0 } else { at_light };
        let is_lit = (at_receiver > -MARGIN) & (at_light >= self.cos_emission - MARGIN);
        let cosines = at_receiver.max(MARGIN) * at_light.max(MARGIN);
        let estimate = self.intensity * cosines / (distance2 + 0.5 * radius2);
        if is_lit {
            estimate.clamp(MIN_ESTIMATE, MAX_ESTIMATE)
        } else {
            0.0
        }
    }
}

impl Light {
    /// The bounds of the light, whose power is given, and its intensity: in double precision, since that of the bounds is
    /// relative.
    pub fn bounds(&self, power: f64) -> (LightBounds, f64) {
        let flat = |points: &[Vec3], normal: Vec3, two_sided: bool| {
            let normal = (!two_sided).then_some(normal);
            let sides = if two_sided { 2.0 } else { 1.0 };
            (LightBounds::surface(points, normal), power / (PI * sides))
        };
        match self {
            Self::Triangle(light) => flat(
                &light.vertices(),
                light.normal(),
                light.emission().two_sided,
            ),
            Self::MovingTriangle(light) => {
                let sides = f64::from(light.emission().sides());
                let bounds = LightBounds::surface(&light.vertices(), None);
                (bounds, power / (PI * sides))
            }
            Self::Rectangle(light) => {
                flat(&light.corners(), light.normal(), light.emission().two_sided)
            }
            Self::Disk(light) => {
                let disk = light.disk();
                let center = LightBounds::point(disk.center, disk.radius);
                let (of_plane, intensity) =
                    flat(&[disk.center], disk.normal, light.emission().two_sided);
                let radius = center.radius;
                (LightBounds { radius, ..of_plane }, intensity)
            }
            Self::Sphere(light) => {
                let sphere = light.sphere();
                let bounds = LightBounds::point(sphere.center, sphere.radius);
                (bounds, power / (4.0 * PI))
            }
            Self::Point(light) => {
                let bounds = LightBounds::point(light.position(), 0.0);
                (bounds, power / (4.0 * PI))
            }
            Self::Spot(light) => {
                let bounds = LightBounds {
                    axis: light.axis(),
                    cos_normals: light.cos_edge() - MARGIN,
                    cos_emission: 1.0,
                    ..LightBounds::point(light.position(), 0.0)
                };
                (bounds, light.greatest_intensity())
            }
            Self::Distant(light) => {
                let bounds = LightBounds {
                    center: -light.direction(),
                    radius: 0.0,
                    ..LightBounds::at_infinity()
                };
                (bounds, f64::from(light.irradiance().luminance()))
            }
            // The mean irradiance over all normals, and the denominator of the estimate inside the sphere.
            Self::Environment(map) => (LightBounds::at_infinity(), 1.5 * 0.25 * map.integral()),
        }
    }
}
