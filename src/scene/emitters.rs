//! The emitters of a scene, and the lights by which they are sampled.
//!
//! Spheres and disks that move, or that an instance scales non-uniformly, are not covered by light sampling: only BSDF
//! sampling hits them, and their emission is added without MIS. The same holds for mirrored meshes of an instance whose
//! emission varies.
//!
//! Measure: normalised units.
//! Range: any shape; a shape with black emission is not an emitter.
//! Source: none needed. Tested in `scene/prepare.rs` and `tests/lights/light.rs`.

use super::description::{ColourDescription, ShapeDescription};
use super::mesh_rectangles::rectangle_of;
use super::placed::even_scale;
use super::{Emitter, EmitterLights};
use crate::geometry::texture::Texture;
use crate::geometry::world::PrimitiveId;
use crate::geometry::{Geometry, disk::Disk, mesh::Mesh, sphere::Sphere};
use crate::light::types::Emission;
use crate::light::{
    Light, disk::DiskLight, moving::MovingTriangle, rectangle::RectangleLight, sphere::SphereLight,
    triangle::TriangleLight,
};
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DVec3, Vec2, Vec3};
use std::sync::Arc;

/// Transform of a shape that may emit.
#[derive(Debug, Clone, Copy)]
pub enum InstanceTransform<'a> {
    /// None: the shape belongs to the world itself.
    World,
    /// The transform of a static group: group to world, both in normalised units.
    Still(&'a DAffine3),
    /// The transform of a moving group: group to world at equally spaced times.
    Moving(&'a [DAffine3]),
}

/// A shape that may emit.
#[derive(Debug, Clone, Copy)]
pub struct AddedShape<'a> {
    /// The shape number that rays return.
    pub number: u32,
    /// The description.
    pub description: &'a ShapeDescription,
    /// Whether the alpha of its material is below 1 somewhere.
    pub masked: bool,
    /// The geometry, in normalised units.
    pub geometry: &'a Geometry,
    /// Corner and edges of a rectangle with right angles.
    pub rectangle: Option<[Vec3; 3]>,
}

/// The emitters and lights collected so far.
#[derive(Debug, Default)]
pub struct Emitters {
    /// Emission of the shapes that emit.
    pub emitters: Vec<Emitter>,
    /// All lights.
    pub lights: Vec<Light>,
    /// Weight of each light in light selection: its radiant power in normalised units.
    pub powers: Vec<f64>,
    /// The primitive that each light lies on, where more than its position is needed: for lights with an emission
    /// texture or alpha, and lights of instances.
    pub primitives: Vec<Option<PrimitiveId>>,
    /// Number of emitting shapes that light sampling does not cover.
    pub unsampled: usize,
}

impl Emitters {
    /// Adds a light that is not a shape.
    pub fn add_light(&mut self, light: Light, power: f64) {
        self.lights.push(light);
        self.powers.push(power);
        self.primitives.push(None);
    }

    /// Adds the emission of a shape and returns its index among the emitters.
    pub fn add_shape(
        &mut self,
        added: &AddedShape<'_>,
        transform: InstanceTransform<'_>,
    ) -> Option<u32> {
        let AddedShape {
            number,
            description,
            masked,
            geometry,
            rectangle,
        } = *added;
        let colour = description.emission.as_ref().filter(|e| !e.is_black())?;
        let (radiance, texture) = match (colour, colour.constant()) {
            (_, Some(radiance)) => (radiance, None),
            (ColourDescription::Constant(radiance), None) => (*radiance, None),
            (ColourDescription::Texture(texture), None) => (Rgb::WHITE, Some(Arc::clone(texture))),
        };
        let emission = Emission {
            radiance,
            two_sided: description.two_sided_emission,
        };
        // The light of a rectangle has no texture coordinates; those of its triangles do.
        let varies = texture.is_some() || masked;
        let rectangle = rectangle.filter(|_| !varies);
        let whole = whole_light(geometry, rectangle, emission, transform);
        let first = self.lights.len() as u32;
        let lights = match (whole, geometry) {
            (Some(light), _) => {
                let power = light.power(1.0) * mean_luminance(texture.as_deref());
                self.add_light(light, power);
                EmitterLights::Whole(first)
            }
            (None, Geometry::Mesh(mesh)) => {
                let texture = texture.as_deref();
                self.add_mesh(mesh, emission, texture, varies, transform)
            }
            (None, _) => EmitterLights::None,
        };
        if varies || !matches!(transform, InstanceTransform::World) {
            // Each of these lights is that of one primitive.
            for (primitive, id) in (0..).zip(&mut self.primitives[first as usize..]) {
                *id = Some(PrimitiveId {
                    shape: number,
                    primitive,
                });
            }
        }
        self.unsampled += usize::from(matches!(lights, EmitterLights::None));
        self.emitters.push(Emitter {
            emission,
            texture,
            lights,
        });
        Some(self.emitters.len() as u32 - 1)
    }

    /// Adds a light for each triangle, or for two that form a rectangle whose emission is constant; none if they cannot be
    /// sampled.
    fn add_mesh(
        &mut self,
        mesh: &Mesh,
        emission: Emission,
        texture: Option<&Texture>,
        varies: bool,
        transform: InstanceTransform<'_>,
    ) -> EmitterLights {
        let steps: &[DAffine3] = match &transform {
            InstanceTransform::World => &[DAffine3::IDENTITY],
            InstanceTransform::Still(still) => std::slice::from_ref(*still),
            InstanceTransform::Moving(steps) => steps,
        };
        // A mirrored triangle keeps its outside by swapping two corners, which would swap its texture coordinates, too.
        let mirrored = steps[0].matrix3.determinant() < 0.0;
        if mirrored && varies {
            return EmitterLights::None;
        }
        let may_pair = !varies && matches!(transform, InstanceTransform::World);
        let count = mesh.indices().len() as u32;
        let mut lights = Vec::with_capacity(count as usize);
        while (lights.len() as u32) < count {
            let primitive = lights.len() as u32;
            let index = self.lights.len() as u32;
            let rectangle = (may_pair && primitive + 1 < count)
                .then(|| [primitive, primitive + 1].map(|triangle| mesh.triangle(triangle)))
                .and_then(|[first, second]| rectangle_of(first, second));
            if let Some([corner, u, v]) = rectangle {
                let light = Light::Rectangle(RectangleLight::new(corner, [u, v], emission));
                let power = light.power(1.0);
                self.add_light(light, power);
                lights.extend([index; 2]);
                continue;
            }
            let places = steps.iter().map(|step| {
                let corners = mesh.triangle(primitive);
                let [a, b, c] = corners.map(|p| step.transform_point3(p.as_dvec3()).as_vec3a());
                if mirrored { [a, c, b] } else { [a, b, c] }
            });
            let light = match places.collect::<Vec<_>>().as_slice() {
                [still] => Light::Triangle(TriangleLight::new(*still, emission)),
                moving => Light::MovingTriangle(MovingTriangle::new(moving.to_vec(), emission)),
            };
            let mean = texture.map_or(1.0, |texture| triangle_luminance(texture, mesh, primitive));
            let power = light.power(1.0) * mean;
            self.add_light(light, power);
            lights.push(index);
        }
        EmitterLights::OfPrimitives(lights.into())
    }
}

/// Twice the maximum deviation of an instance's uniform scale from rounding to single precision.
const ROUNDED: f64 = 2.0 * f32::EPSILON as f64;

/// Returns a single light for the whole shape, if there is a type for it.
fn whole_light(
    geometry: &Geometry,
    rectangle: Option<[Vec3; 3]>,
    emission: Emission,
    transform: InstanceTransform<'_>,
) -> Option<Light> {
    let (to_world, scale) = match transform {
        InstanceTransform::World => (DAffine3::IDENTITY, 1.0),
        InstanceTransform::Still(still) => (*still, even_scale(still, ROUNDED)?),
        InstanceTransform::Moving(_) => return None,
    };
    let point = |p: Vec3| to_world.transform_point3(p.as_dvec3()).as_vec3a();
    let length = |x: f32| (f64::from(x) * scale) as f32;
    match geometry {
        Geometry::Mesh(_) => match (rectangle, transform) {
            (Some([corner, u, v]), InstanceTransform::World) => {
                let light = RectangleLight::new(corner, [u, v], emission);
                Some(Light::Rectangle(light))
            }
            _ => None,
        },
        Geometry::Sphere(sphere) => {
            let sphere = Sphere::new(point(sphere.center), length(sphere.radius));
            Some(Light::Sphere(SphereLight::new(sphere, emission)))
        }
        Geometry::Disk(disk) => {
            let normal = to_world.transform_vector3(disk.normal.as_dvec3());
            let normal = normal.normalize_or(DVec3::Z).as_vec3a();
            let disk = Disk::new(point(disk.center), normal, length(disk.radius));
            Some(Light::Disk(DiskLight::new(disk, emission)))
        }
    }
}

/// Lookups along an edge to estimate a texture's mean over a triangle. An estimate suffices: undersampled parts are
/// covered by BSDF sampling.
const POINTS: u32 = 6;

/// Estimates the mean luminance of a texture over a triangle.
fn triangle_luminance(texture: &Texture, mesh: &Mesh, primitive: u32) -> f64 {
    let mut sum = 0.0;
    let mut count = 0.0;
    for i in 0..POINTS {
        for j in 0..POINTS - i {
            let at = |k: u32| (k as f32 + 1.0 / 3.0) / POINTS as f32;
            let uv = mesh.uv_at(primitive, [at(i), at(j)]);
            sum += f64::from(texture.lookup(uv).luminance());
            count += 1.0;
        }
    }
    sum / count
}

/// Estimates the mean luminance of a texture over [0, 1]^2; 1 without a texture.
fn mean_luminance(texture: Option<&Texture>) -> f64 {
    let Some(texture) = texture else { return 1.0 };
    let n = 4 * POINTS;
    let at = |k: u32| (k as f32 + 0.5) / n as f32;
    let uvs = (0..n).flat_map(|i| (0..n).map(move |j| Vec2::new(at(i), at(j))));
    let luminances = uvs.map(|uv| f64::from(texture.lookup(uv).luminance()));
    luminances.sum::<f64>() / f64::from(n * n)
}
