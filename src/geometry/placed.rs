//! A shape of an instance at one time, and its surface in world space.
//!
//! Points and normals are computed in double precision in the group's frame, transformed to the world and rounded once.
//! The error bounds include the error of this and of a ray query that transforms the ray to the group's frame in single
//! precision, as Embree does. A ray whose origin is offset by the bound therefore never hits the same flat primitive
//! again.
//!
//! Measure: normalised scene units in the world, the group's units in the group.
//! Range: transforms that can be inverted; the determinant may be negative.
//! Source: Pharr, Jakob, Humphreys, sections 3.10 (normals) and 6.8.6 (error of transformed points); Higham 2002, section
//! 14.1, for the inverse. Tested in `tests/tracing/instance_surfaces.rs`.

use super::Geometry;
use super::instance::Instance;
use super::mesh::Mesh;
use super::surface::SurfacePoint;
use crate::math::ray::Ray;
use crate::math::robust::gamma;
use crate::math::vec::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use crate::planted::planted;

/// A shape of an instance at one time.
#[derive(Debug, Clone, Copy)]
pub struct PlacedShape<'a> {
    /// The shape, in the group's units.
    pub geometry: &'a Geometry,
    to_world: DAffine3,
    /// The magnitudes of the entries that `to_world` interpolates.
    magnitude: DAffine3,
}

impl<'a> PlacedShape<'a> {
    /// Creates the view of a shape of an instance's group at a time.
    #[inline]
    pub fn new(geometry: &'a Geometry, instance: &Instance, time: f32) -> Self {
        Self {
            geometry,
            to_world: instance.at(time),
            magnitude: instance.magnitude_at(time),
        }
    }

    /// The surface point where `ray` hits `primitive` at parameter `t`, with barycentric coordinates (u, v).
    pub fn surface_at(&self, primitive: u32, ray: &Ray, t: f32, uv: [f32; 2]) -> SurfacePoint {
        let local = match self.geometry {
            Geometry::Mesh(mesh) => mesh.surface_at(primitive, uv),
            Geometry::Sphere(sphere) => {
                let to_local = self.to_world.inverse();
                let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
                let near = to_local.transform_point3(origin + f64::from(t) * dir);
                let dir = to_local.transform_vector3(dir).normalize_or(DVec3::Z);
                sphere.surface_near(
                    near,
                    to_local.transform_point3(origin),
                    dir.as_vec3a(),
                    ray.t_min > 0.0,
                )
            }
            Geometry::Disk(disk) => {
                let at = ray.origin.as_dvec3() + f64::from(t) * ray.dir.as_dvec3();
                disk.surface_near(self.to_world.inverse().transform_point3(at).as_vec3a())
            }
        };
        // A spawned ray can falsely hit the primitive no farther away than its extent.
        let extent = self.geometry.primitive_bounds(primitive).extent();
        let (p, error) = self.point(local.p, local.error, self.to_world.matrix3.abs() * extent);
        let ng = match self.geometry {
            Geometry::Mesh(mesh) => self.normal(flat_normal(mesh, primitive)),
            _ => self.normal(local.ng.as_dvec3()),
        };
        let ns = if local.ns == local.ng {
            ng
        } else {
            // Normals on the same side in the group need not be so in the world.
            let ns = self.normal(local.ns.as_dvec3());
            if ns.dot(ng) < 0.0 { -ns } else { ns }
        };
        SurfacePoint {
            p: p.as_vec3a(),
            error: error.as_vec3a(),
            ng,
            ns,
        }
    }

    /// The error bound of a point `p` of `primitive` in the world, for rays that start there.
    pub fn error_at(&self, primitive: u32, p: Vec3) -> Vec3 {
        let bounds = self.geometry.primitive_bounds(primitive);
        let (size, extent) = (bounds.min.abs().max(bounds.max.abs()), bounds.extent());
        // At least the error of a point of a sphere, of a disk, or of a triangle that is not a sliver.
        let mut local = f64::from(gamma(8)) * (size + 2.0 * extent);
        if let Geometry::Mesh(mesh) = self.geometry {
            local = local.max(mesh.greatest_error(primitive).as_dvec3());
        }
        let reach = self.to_world.matrix3.abs() * extent;
        let (_, error) = self.point(self.local(p), local.as_vec3a(), reach);
        error.as_vec3a()
    }

    /// The texture coordinate of the point `p` of `primitive`, with barycentric coordinates `barycentric`.
    pub fn uv_at(&self, primitive: u32, p: Vec3, barycentric: [f32; 2]) -> Vec2 {
        let local = match self.geometry {
            Geometry::Mesh(_) => Vec3::ZERO,
            _ => self.local(p),
        };
        self.geometry.uv_at(primitive, local, barycentric)
    }

    /// The directions in which u and v increase at the point `p` of `primitive`, of any length; zero where there are
    /// none.
    pub fn tangents_at(&self, primitive: u32, p: Vec3) -> [Vec3; 2] {
        let local = self.geometry.tangents_at(primitive, self.local(p));
        local.map(|tangent| (self.to_world.matrix3 * tangent.as_dvec3()).as_vec3a())
    }

    /// The parameter up to which a ray that leaves the primitive at `from` along the unit vector `w`, on its outside if
    /// `to_outside`, cannot truly hit that primitive again.
    pub fn free_distance(&self, from: Vec3, w: Vec3, to_outside: bool) -> f32 {
        match self.geometry {
            Geometry::Sphere(sphere) if !to_outside => {
                let to_local = self.to_world.inverse();
                let offset = to_local.transform_point3(from.as_dvec3()) - sphere.center.as_dvec3();
                // The local ray has the same parameters as the world ray, so its direction is not of unit length.
                let w = to_local.transform_vector3(w.as_dvec3());
                (-w.dot(offset) / w.length_squared()) as f32
            }
            _ => f32::INFINITY,
        }
    }

    /// Transforms a point of the group to the world.
    #[inline]
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        self.to_world.transform_point3(p)
    }

    /// The vertices of a triangle in the world.
    pub fn triangle(&self, mesh: &Mesh, primitive: u32) -> [DVec3; 3] {
        let vertices = mesh.triangle(primitive);
        vertices.map(|vertex| self.to_world(vertex.as_dvec3()))
    }

    /// Transforms a surface point to the world, and returns it with the error bound of each coordinate. The bound
    /// includes the error of a query whose ray starts, or continues, up to `reach` away along each axis.
    pub fn point(&self, p: Vec3, error: Vec3, reach: DVec3) -> (DVec3, DVec3) {
        let gamma = |n| f64::from(gamma(n));
        let x = p.as_dvec3();
        let offset = self.to_world.matrix3 * x;
        let translation = self.to_world.translation;
        let p = offset + translation;
        let Inversion {
            inverse,
            cofactors,
            determinant,
        } = self.inversion();
        let from_center = offset.abs() + reach;
        // A cofactor divided by the determinant has four roundings. The error of the determinant itself, of eight
        // roundings, scales the instance about its centre. Transforming origin and direction by the inverse has six.
        let query = gamma(4) * (cofactors * from_center)
            + gamma(6) * (inverse * (p.abs() + translation.abs() + reach));
        let scaling = gamma(8) * determinant * from_center;
        // The interpolation of two steps in single precision, and the rounding of the point.
        let mean =
            self.magnitude.matrix3 * (x.abs() + inverse * reach) + self.magnitude.translation;
        let rounding = gamma(4) * mean + gamma(1) * p.abs();
        let local = error.as_dvec3() + query;
        (p, self.to_world.matrix3.abs() * local + scaling + rounding)
    }

    /// The magnitudes to which the rounding error is proportional when the transform is inverted by cofactors.
    fn inversion(&self) -> Inversion {
        let DMat3 {
            x_axis,
            y_axis,
            z_axis,
        } = self.to_world.matrix3.abs();
        let (yz, zx, xy) = (
            unsigned_cross(y_axis, z_axis),
            unsigned_cross(z_axis, x_axis),
            unsigned_cross(x_axis, y_axis),
        );
        let per_determinant = 1.0 / self.to_world.matrix3.determinant().abs();
        Inversion {
            inverse: self.to_world.matrix3.inverse().abs(),
            cofactors: DMat3::from_cols(yz, zx, xy).transpose() * per_determinant,
            determinant: x_axis.dot(yz) * per_determinant,
        }
    }

    /// Transforms a normal to the world by the inverse transpose, so that it stays on its side of the surface even
    /// under a reflection.
    fn normal(&self, n: DVec3) -> Vec3 {
        let DMat3 {
            x_axis,
            y_axis,
            z_axis,
        } = self.to_world.matrix3;
        let cofactors = DMat3::from_cols(
            y_axis.cross(z_axis),
            z_axis.cross(x_axis),
            x_axis.cross(y_axis),
        );
        let side = self.to_world.matrix3.determinant().signum();
        let transform = planted!("normals-by-the-matrix", self.to_world.matrix3, cofactors);
        (side * (transform * n)).normalize_or(DVec3::Z).as_vec3a()
    }

    fn local(&self, p: Vec3) -> Vec3 {
        let to_local = self.to_world.inverse();
        to_local.transform_point3(p.as_dvec3()).as_vec3a()
    }
}

/// Magnitudes of the terms of an inverse.
struct Inversion {
    /// The magnitudes of its entries.
    inverse: DMat3,
    /// The magnitudes of the products in its cofactors, divided by the determinant.
    cofactors: DMat3,
    /// The magnitudes of the products in the determinant, divided by the determinant.
    determinant: f64,
}

/// The geometric normal of a triangle in double precision, not of unit length: a transform may magnify the rounding
/// error of a normal.
fn flat_normal(mesh: &Mesh, primitive: u32) -> DVec3 {
    let [a, b, c] = mesh.triangle(primitive).map(|vertex| vertex.as_dvec3());
    (b - a).cross(c - a)
}

/// The cross product of vectors without negative entries, with sums in place of differences.
fn unsigned_cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(
        a.y * b.z + a.z * b.y,
        a.z * b.x + a.x * b.z,
        a.x * b.y + a.y * b.x,
    )
}
