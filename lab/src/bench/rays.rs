//! Random rays through a scene, independent of any render: chords, rays along axes, and rays at vertices and edges of
//! triangles.
//!
//! Measure: normalised scene units.
//! Range: at most 2^24 triangles per shape can be aimed at; an empty scene gets rays as well.
//! Source: none needed. Tested in `lab/tests/bench/agreement.rs`.

use super::random::Random;
use etendue::internals::accel::batch::RayBatch;
use etendue::internals::geometry::Geometry;
use etendue::internals::geometry::mesh::Mesh;
use etendue::internals::geometry::world::World;
use etendue::internals::math::bounds::Bounds;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::vec::{DVec3, Vec3};

/// The bounding box of all shapes over the shutter interval.
pub fn bounds_of(world: &World) -> Bounds {
    let standing = world.geometries().iter().map(Geometry::bounds);
    let placed = (0..world.instances().len()).map(|i| world.instance_bounds(i));
    standing
        .chain(placed)
        .filter(|bounds| !bounds.is_empty())
        .fold(Bounds::default(), Bounds::union)
}

/// Random rays through the scene's box, of four kinds in turn: unbounded through two points within, segments between
/// points within, along an axis, and with one component of the direction 0.
pub fn random_rays(world: &World, count: usize, seed: u64) -> RayBatch {
    let bounds = box_of(world);
    let mut random = Random::new(seed, 0);
    let mut rays = RayBatch::default();
    for index in 0..count {
        let from = point_in(&bounds, &mut random);
        let to = point_in(&bounds, &mut random);
        let (from, to) = (from.as_vec3a(), to.as_vec3a());
        let axis = random.below(3);
        let ray = match index % 4 {
            0 => outwards(from, to - from),
            1 => Ray::between(from, to),
            2 => {
                let mut dir = Vec3::ZERO;
                dir[axis] = if random.uniform() < 0.5 { 1.0 } else { -1.0 };
                let length = bounds.extent()[axis] as f32;
                Ray::new(from - 1.5 * length * dir, dir)
            }
            _ => {
                let mut dir = to - from;
                dir[axis] = 0.0;
                Ray::new(from, dir)
            }
        };
        rays.push(&ray, random.uniform());
    }
    rays
}

/// Rays at triangles: at vertices, midpoints of edges and other points of edges in turn. A query may report or miss
/// such a triangle, and may find either of two neighbours.
pub fn aimed_rays(world: &World, count: usize, seed: u64) -> RayBatch {
    let bounds = box_of(world);
    let mut random = Random::new(seed, 1);
    let mut rays = RayBatch::default();
    let meshes: Vec<(u32, &Mesh)> = (0..world.shape_count() as u32)
        .filter_map(|shape| match world.geometry(shape) {
            Geometry::Mesh(mesh) if !mesh.indices().is_empty() => Some((shape, mesh)),
            _ => None,
        })
        .collect();
    for index in 0..count {
        let from = point_in(&bounds, &mut random).as_vec3a();
        let time = random.uniform();
        let mut target = point_in(&bounds, &mut random);
        if !meshes.is_empty() {
            let (shape, mesh) = meshes[random.below(meshes.len())];
            let local = seam(mesh, index % 3, &mut random);
            target = world
                .placed(shape, time)
                .map_or(local, |placed| placed.to_world(local));
        }
        let ray = outwards(from, target.as_vec3a() - from);
        rays.push(&ray, time);
    }
    rays
}

/// A point on the edges of a random triangle: a vertex (0), the midpoint of an edge (1), another point of an edge (2).
fn seam(mesh: &Mesh, kind: usize, random: &mut Random) -> DVec3 {
    let triangle = mesh.triangle(random.below(mesh.indices().len()) as u32);
    let corner = random.below(3);
    let share = [0.0, 0.5, f64::from(random.uniform())][kind];
    let [a, b] = [corner, (corner + 1) % 3].map(|k| triangle[k].as_dvec3());
    a + share * (b - a)
}

/// An unbounded ray in direction `dir` through `from` that begins at `from - dir`.
fn outwards(from: Vec3, dir: Vec3) -> Ray {
    Ray::new(from - dir, dir)
}

fn box_of(world: &World) -> Bounds {
    let bounds = bounds_of(world);
    if bounds.is_empty() {
        Bounds::around([-DVec3::ONE, DVec3::ONE])
    } else {
        bounds
    }
}

fn point_in(bounds: &Bounds, random: &mut Random) -> DVec3 {
    bounds.centre() + 0.5 * bounds.extent() * random.in_cube()
}
