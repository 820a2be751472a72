//! Shapes and textures.
//!
//! Measure: normalised scene units; of the shapes of a group, the group's units.
//! Range: shapes that the checks of a scene accept (`src/scene/check/`).
//! Source: named in each file. Tested in `tests/tracing/` and in each file.

pub mod disk;
pub mod instance;
pub mod mesh;
pub mod placed;
pub mod sphere;
pub mod surface;
pub mod texture;
pub mod texture_image;
pub mod uv_map;
pub mod world;

use crate::math::bounds::Bounds;
use crate::math::ray::Ray;
use crate::math::vec::{Vec2, Vec3};
use disk::Disk;
use mesh::Mesh;
use sphere::Sphere;
use surface::SurfacePoint;

/// A shape prepared for tracing: single precision, in normalised scene units.
#[derive(Debug, Clone)]
pub enum Geometry {
    /// Triangles.
    Mesh(Mesh),
    /// An exact sphere.
    Sphere(Sphere),
    /// An exact flat disk.
    Disk(Disk),
}

impl Geometry {
    /// The number of primitives of the shape.
    pub fn primitive_count(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.indices().len(),
            Self::Sphere(_) | Self::Disk(_) => 1,
        }
    }

    /// The bounding box of one primitive.
    pub fn primitive_bounds(&self, primitive: u32) -> Bounds {
        match self {
            Self::Mesh(mesh) => {
                Bounds::around(mesh.triangle(primitive).map(|vertex| vertex.as_dvec3()))
            }
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Disk(disk) => disk.bounds(),
        }
    }

    /// The bounding box of the shape.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Disk(disk) => disk.bounds(),
        }
    }

    /// The surface point where `ray` hits `primitive` at parameter `t`, with barycentric coordinates (u, v).
    #[inline]
    pub fn surface_at(&self, primitive: u32, ray: &Ray, t: f32, uv: [f32; 2]) -> SurfacePoint {
        match self {
            Self::Mesh(mesh) => mesh.surface_at(primitive, uv),
            Self::Sphere(sphere) => sphere.surface_at(ray, t),
            Self::Disk(disk) => disk.surface_near(ray.at(t)),
        }
    }

    /// The texture coordinate of the point `p` of `primitive`, with barycentric coordinates `barycentric`.
    #[inline]
    pub fn uv_at(&self, primitive: u32, p: Vec3, barycentric: [f32; 2]) -> Vec2 {
        match self {
            Self::Mesh(mesh) => mesh.uv_at(primitive, barycentric),
            Self::Sphere(sphere) => sphere.uv_at(p),
            Self::Disk(disk) => disk.uv_at(p),
        }
    }

    /// The directions in which u and v increase at the point `p` of `primitive`, of any length; zero where there are
    /// none.
    pub fn tangents_at(&self, primitive: u32, p: Vec3) -> [Vec3; 2] {
        match self {
            Self::Mesh(mesh) => mesh.tangents_at(primitive),
            Self::Sphere(sphere) => sphere.tangents_at(p),
            Self::Disk(disk) => disk.tangents(),
        }
    }

    /// The parameter up to which a ray that leaves the shape's primitive at `from` along the unit vector `w`, on its
    /// outside if `to_outside`, cannot truly hit that primitive again.
    #[inline]
    pub fn free_distance(&self, from: Vec3, w: Vec3, to_outside: bool) -> f32 {
        match self {
            Self::Mesh(_) | Self::Disk(_) => f32::INFINITY,
            Self::Sphere(sphere) => sphere.free_distance(from, w, to_outside),
        }
    }
}
