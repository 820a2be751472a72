//! Tests of shadow rays that leave slivers or end on them: a triangle does not shadow itself, however thin it is.
//!
//! Rays in all directions, and rays at grazing angles with cosines down to 10^-4, from points all over the triangle. The
//! error bound of a point has a term that matters only for slivers (`geometry/mesh.rs`): without it, one ray in a hundred
//! hits the triangle.

use crate::common::TestRng;
use crate::common::tracing::{
    direction, every_accel, in_single, placed_once, rotation, static_world, triangle,
};
use etendue::internals::accel::Precision;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::world::{PrimitiveId, World};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::robust::{gamma, offset_point};
use etendue::internals::math::vec::{DAffine3, DVec3, Vec3};
use etendue::internals::sampling::warp::sample_triangle_uniform;
use std::collections::BTreeMap;
use std::sync::Arc;

const SLIVERS: u32 = 3000;
const RAYS: u32 = 100;

struct Sliver {
    corners: [Vec3; 3],
    size: f32,
}

/// A random triangle whose height is 1 to 10^-4 of its longest edge; the third vertex is above any point of that edge.
/// Position, size and the order of the vertices are random, too.
fn sliver(rng: &mut TestRng) -> Sliver {
    let height = 10.0_f64.powf(-4.0 * rng.uniform_f64());
    // The foot of the height is at either end of the edge or between them.
    let foot = (1.5 * rng.uniform_f64() - 0.25).clamp(0.0, 1.0);
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(foot, height, 0.0)];
    let size = 10.0_f64.powf(6.0 * rng.uniform_f64() - 3.0);
    let away = 3.0 * rng.uniform_f64() * direction(rng).as_dvec3();
    let turn = rotation(rng);
    let mut corners =
        corners.map(|corner| (size * (turn.transform_point3(corner) + away)).as_vec3a());
    corners.rotate_left((3.0 * rng.uniform()) as usize);
    let size = size as f32;
    Sliver { corners, size }
}

/// Generates a ray that leaves the only primitive of a world, and one that ends on it and starts at three times its size
/// from it.
fn rays(rng: &mut TestRng, world: &World, size: f32) -> [Ray; 2] {
    let id = PrimitiveId {
        shape: 0,
        primitive: 0,
    };
    let u = sample_triangle_uniform(rng.uniform_2d()).to_array();
    let nowhere = Ray::new(Vec3::ZERO, Vec3::X);
    let surface = world.surface_at::<Everything>(id, &nowhere, 0.0, 0.0, u);
    let mut dir = direction(rng);
    if rng.uniform() < 0.5 {
        let height = 10.0_f32.powf(-4.0 * rng.uniform());
        dir = (dir.reject_from_normalized(surface.ng) + height * surface.ng).normalize();
    }
    let above = if dir.dot(surface.ng) < 0.0 {
        -surface.ng
    } else {
        surface.ng
    };
    // The second ray ends as a shadow ray ends on a light sample.
    let start = surface.p + 3.0 * size * dir;
    let error = surface.error + gamma(8) * (start - surface.p).abs();
    let from = offset_point(surface.p, surface.error, above);
    [
        Ray::new(from, dir),
        Ray::between(start, offset_point(surface.p, error, above)),
    ]
}

/// Counts for each acceleration structure the rays that hit the sliver that they leave or end on, and asserts that there
/// are none in robust precision.
fn assert_none_meets(seed: u64, world: impl Fn(&mut TestRng, [Vec3; 3]) -> Arc<World>) {
    let mut rng = TestRng::new(seed);
    let mut counts = BTreeMap::<String, [u32; 2]>::new();
    for _ in 0..SLIVERS {
        let Sliver { corners, size } = sliver(&mut rng);
        let world = world(&mut rng, corners);
        let accels = every_accel(&world);
        for _ in 0..RAYS {
            let rays = rays(&mut rng, &world, size);
            for (name, accel) in &accels {
                let sum = counts.entry(name.clone()).or_default();
                for (sum, ray) in sum.iter_mut().zip(&rays) {
                    *sum += u32::from(accel.occluded(ray, 0.0));
                }
            }
        }
    }
    let all = SLIVERS * RAYS;
    println!("of {all} rays that leave and {all} that end, met: {counts:?}");
    let robust = Precision::Robust.name();
    for (name, met) in counts.iter().filter(|(name, _)| name.ends_with(robust)) {
        assert_eq!(*met, [0, 0], "{name}");
    }
}

#[test]
fn robust_shadow_rays_do_not_self_intersect_slivers() {
    assert_none_meets(11, |_, corners| static_world(vec![triangle(corners)]));
}

#[test]
fn robust_shadow_rays_do_not_self_intersect_instanced_slivers() {
    assert_none_meets(12, |rng, corners| {
        let place = rotation(rng) * DAffine3::from_scale(DVec3::new(1.5, 1.0, 0.7));
        placed_once(vec![triangle(corners)], vec![in_single(place)])
    });
}
