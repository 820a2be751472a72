//! What tests of ray queries share: worlds, every way of tracing them, random rays.
//!
//! Measure: normalised scene units.
//! Range: small scenes.
//! Source: none needed.

use super::TestRng;
use etendue::accel::{Accel, AccelOptions, Backend, Hit, Precision};
use etendue::geometry::world::World;
use etendue::geometry::{Geometry, disk::Disk, mesh::Mesh, sphere::Sphere};
use etendue::math::vec::Vec3;
use std::sync::Arc;

/// A world of shapes that stand in it themselves.
pub fn standing(geometries: Vec<Geometry>) -> Arc<World> {
    Arc::new(World::new(geometries, vec![], vec![]))
}

/// Every way of tracing that this build has.
pub fn every_accel(world: &Arc<World>) -> Vec<(String, Accel)> {
    let mut all = Vec::new();
    for &backend in Backend::ALL {
        for precision in [Precision::Robust, Precision::Fast] {
            let options = AccelOptions {
                backend,
                precision,
                threads: 2,
            };
            let accel = Accel::build(Arc::clone(world), options).expect("a small scene");
            all.push((format!("{} {}", backend.name(), precision.name()), accel));
        }
    }
    all
}

/// A uniform direction.
pub fn direction(rng: &mut TestRng) -> Vec3 {
    etendue::sampling::warp::sample_sphere_uniform(rng.uniform_2d())
}

/// A uniform point of the cube from -1 to 1.
pub fn point(rng: &mut TestRng) -> Vec3 {
    2.0 * Vec3::new(rng.uniform(), rng.uniform(), rng.uniform()) - Vec3::ONE
}

/// A mesh of one triangle.
pub fn triangle(vertices: [Vec3; 3]) -> Geometry {
    Geometry::Mesh(Mesh::new(
        vertices.to_vec(),
        vec![],
        vec![],
        vec![[0, 1, 2]],
    ))
}

/// Triangles of all sizes, spheres and disks.
pub fn soup(rng: &mut TestRng) -> Vec<Geometry> {
    let mut shapes = Vec::new();
    for i in 0..60 {
        let center = point(rng);
        let size = 10.0_f32.powf(-2.0 * rng.uniform());
        shapes.push(match i % 3 {
            0 => triangle([0, 1, 2].map(|_| center + size * point(rng))),
            1 => Geometry::Sphere(Sphere {
                center,
                radius: 0.3 * size,
            }),
            _ => Geometry::Disk(Disk {
                center,
                normal: direction(rng),
                radius: 0.5 * size,
            }),
        });
    }
    shapes
}

/// The same hit up to rounding: another primitive only at the same distance.
pub fn same(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => (a.t - b.t).abs() <= 1e-4 * a.t.max(1e-3),
        _ => false,
    }
}
