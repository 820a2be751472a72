//! Helpers for tests of ray queries: worlds, acceleration structures of every kind, random rays.
//!
//! Measure: normalised scene units.
//! Range: small scenes.
//! Source: none needed.

use super::TestRng;
use etendue::internals::accel::{Accel, AccelOptions, Backend, Hit, Precision, Quality};
use etendue::internals::geometry::world::{Instance, World};
use etendue::internals::geometry::{Geometry, disk::Disk, mesh::Mesh, sphere::Sphere};
use etendue::internals::math::vec::{DAffine3, DVec3, Vec3};
use etendue_lab::bench::closed::cube_surface;
use std::sync::Arc;

/// A world of static shapes without instances.
pub fn static_world(geometries: Vec<Geometry>) -> Arc<World> {
    Arc::new(World::new(geometries, vec![], vec![]))
}

/// Builds an acceleration structure for every backend and precision of this build, with names.
pub fn every_accel(world: &Arc<World>) -> Vec<(String, Accel)> {
    let precisions = [Precision::Robust, Precision::Fast];
    let both = |&backend| precisions.map(|precision| (backend, precision, None));
    let mut all: Vec<_> = Backend::ALL.iter().flat_map(both).collect();
    // One more structure with high quality: with split triangles, if Embree is available.
    all.push((Backend::ALL[0], Precision::Fast, Some(Quality::High)));
    let build = |(backend, precision, quality)| {
        let options = AccelOptions {
            backend,
            precision,
            quality,
            threads: 2,
        };
        let accel = Accel::build(Arc::clone(world), options).expect("a small scene");
        let quality = options.quality().name();
        (
            format!("{} {quality} {}", backend.name(), precision.name()),
            accel,
        )
    };
    all.into_iter().map(build).collect()
}

/// Samples a uniform direction.
pub fn direction(rng: &mut TestRng) -> Vec3 {
    etendue::internals::sampling::warp::sample_sphere_uniform(rng.uniform_2d())
}

/// Samples a uniform point in the cube from -1 to 1.
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

/// Random triangles, spheres and disks of all sizes.
pub fn soup(rng: &mut TestRng) -> Vec<Geometry> {
    let mut shapes = Vec::new();
    for i in 0..60 {
        let center = point(rng);
        let size = 10.0_f32.powf(-2.0 * rng.uniform());
        shapes.push(match i % 3 {
            0 => triangle([0, 1, 2].map(|_| center + size * point(rng))),
            1 => Geometry::Sphere(Sphere::new(center, 0.3 * size)),
            _ => Geometry::Disk(Disk::new(center, direction(rng), 0.5 * size)),
        });
    }
    shapes
}

/// Whether two hits are equal up to rounding: primitives may differ only at the same distance.
pub fn same(a: Option<Hit>, b: Option<Hit>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => (a.t - b.t).abs() <= 1e-4 * a.t.max(1e-3),
        _ => false,
    }
}

/// A closed mesh: the surface of a cube with `n` x `n` squares per face, projected onto a sphere if `round`.
pub fn closed_mesh(n: u32, round: bool) -> Mesh {
    let (positions, indices) = cube_surface(n, |p| if round { p.normalize() } else { p });
    Mesh::new(positions, vec![], vec![], indices)
}

/// Rounds the entries of a matrix to single precision, in which instances store them.
pub fn in_single(m: DAffine3) -> DAffine3 {
    DAffine3::from_cols_array(&m.to_cols_array().map(|entry| f64::from(entry as f32)))
}

/// A rotation about a random axis.
pub fn rotation(rng: &mut TestRng) -> DAffine3 {
    let angle = f64::from(rng.uniform()) * std::f64::consts::TAU;
    DAffine3::from_axis_angle(direction(rng).as_dvec3(), angle)
}

/// Transforms of every kind, with names; those that scale or shear also rotate.
pub fn transforms(rng: &mut TestRng) -> Vec<(&'static str, DAffine3)> {
    let scale = |x: f64, y: f64, z: f64| DAffine3::from_scale(DVec3::new(x, y, z));
    let mut shear = DAffine3::IDENTITY;
    shear.matrix3.y_axis.x = 2.0;
    shear.matrix3.z_axis.y = -1.5;
    let far = DAffine3::from_translation(1e3 * point(rng).as_dvec3());
    let mut turned = |m: DAffine3| rotation(rng) * m * rotation(rng);
    let all = vec![
        ("identity", DAffine3::IDENTITY),
        ("rotation", turned(DAffine3::IDENTITY)),
        ("uneven", turned(scale(0.1, 1.0, 5.0))),
        ("mirror", turned(scale(-1.0, 1.0, 1.0))),
        (
            "uneven mirror",
            turned(scale(-1.0, 0.3, -2.0) * scale(1.0, -1.0, 1.0)),
        ),
        ("shear", turned(shear)),
        ("tiny", turned(scale(1e-3, 1e-3, 1e-3))),
        ("large", turned(scale(1e3, 1e3, 1e3))),
        ("far", far * turned(DAffine3::IDENTITY)),
    ];
    let all = all.into_iter();
    all.map(|(name, m)| (name, in_single(m))).collect()
}

/// The steps of a motion that starts at a transform, rotates and translates.
pub fn moving(rng: &mut TestRng, start: DAffine3, steps: usize) -> Vec<DAffine3> {
    let size = start.matrix3.determinant().abs().cbrt();
    let (axis, towards) = (direction(rng).as_dvec3(), size * direction(rng).as_dvec3());
    let step = |i: usize| {
        let at = i as f64 / (steps - 1) as f64;
        let turn = DAffine3::from_axis_angle(axis, 1.2 * at);
        let mut step = start * turn;
        step.translation += at * towards;
        in_single(step)
    };
    (0..steps).map(step).collect()
}

/// A world of one group, placed once.
pub fn placed_once(group: Vec<Geometry>, steps: Vec<DAffine3>) -> Arc<World> {
    let instance = Instance { group: 0, steps };
    Arc::new(World::new(vec![], vec![group], vec![instance]))
}
