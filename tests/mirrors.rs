//! Hard case 14: what many reflections in a row leave of light and of its direction.

mod common;

use common::closed_forms::parallel_rectangle;
use common::scene::{diffuse, looking, ready, rectangle, see, shape, sky};
use etendue::accel::Backend;
use etendue::effects::kernel::types::Everything;
use etendue::integrator::Roulette;
use etendue::math::ray::Ray;
use etendue::math::rgb::Rgb;
use etendue::math::vec::{DAffine3, DVec3, Vec2, Vec3};
use etendue::scene::Scene;
use etendue::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, Place, SceneDescription,
};

use common::verdict::assert_mean;

const REFLECTANCE: f32 = 0.99;

fn mirror(reflectance: f32) -> MaterialModel {
    MaterialModel::Mirror {
        reflectance: ColourDescription::Constant(Rgb::grey(reflectance)),
    }
}

/// Two mirrors that face each other at z = 0 and z = 1, from x = -1 to `end`, seen into along x at 45 degrees.
fn corridor(end: f64) -> SceneDescription {
    let eye = DVec3::new(0.0, 0.0, 0.5);
    let mut scene = looking(eye, DVec3::new(0.5, 0.0, 0.0), mirror(REFLECTANCE));
    let wall = |z: f64| rectangle([-1.0, -1.0, z], [end + 1.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    scene.shapes = vec![shape(wall(0.0), 0.0), shape(wall(1.0), 0.0)];
    scene.lights = vec![sky(Rgb::WHITE)];
    scene
}

#[test]
fn facing_mirrors_keep_what_their_reflectances_multiply_to() {
    // The k-th reflection is at x = k - 1/2.
    for &backend in Backend::ALL {
        for bounces in [1, 10, 100] {
            let scene = corridor(f64::from(bounces));
            let exact = f64::from(REFLECTANCE).powi(bounces);
            for limit in [None, Some(bounces as u32)] {
                let seen = see(&scene, backend, 16, limit, Roulette::None);
                let error = (seen.mean() / exact - 1.0).abs();
                assert!(error < 1e-5, "{bounces} {}: {error:e}", backend.name());
            }
            // One bounce less never gets out.
            let short = see(
                &scene,
                backend,
                16,
                Some(bounces as u32 - 1),
                Roulette::None,
            );
            assert_eq!(short.mean(), 0.0);
        }
        // The row's own number, from 0.99 in double precision.
        let seen = see(&corridor(100.0), backend, 16, None, Roulette::None);
        assert!((seen.mean() / 0.366_032_341 - 1.0).abs() < 1e-5);
    }
}

/// Where a ray goes in the end, and after how many reflections.
fn follow(scene: &Scene, mut ray: Ray) -> (Vec3, u32) {
    let mut departure = None;
    for bounces in 0.. {
        let Some(at) = scene.intersect::<Everything>(&ray, 0.0, departure, 0.5) else {
            return (ray.dir, bounces);
        };
        let bsdf = scene.bsdf(&at).expect("a mirror has two sides");
        let wo = at.frame.to_local(at.wo);
        let sample = bsdf.sample::<Everything>(wo, 0.5, Vec2::splat(0.5));
        let wi = at.frame.to_world(sample.expect("a mirror reflects").wi);
        let (next, leaves) = scene.spawn(&at, 0.0, wi, false);
        (ray, departure) = (next, Some(leaves));
    }
    unreachable!("the loop ends where the ray does");
}

#[test]
fn a_corner_cube_sends_light_back() {
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    // Along the axes the frames are exact; turned, vertices and normals are rounded.
    for (place, tolerance) in [
        (DAffine3::IDENTITY, 4.0 * f32::EPSILON / 2.0),
        (turn, 16.0 * f32::EPSILON / 2.0),
    ] {
        for &backend in Backend::ALL {
            let mut scene = looking(DVec3::splat(3.0), DVec3::ZERO, mirror(1.0));
            let (x, y, z) = ([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
            for (u, v) in [(x, y), (y, z), (z, x)] {
                let mut wall = shape(rectangle([0.0; 3], u, v), 0.0);
                wall.transform = place;
                scene.shapes.push(wall);
            }
            let scene = ready(&scene, backend);
            let mut rng = common::TestRng::new(3);
            let mut thrice = 0;
            for _ in 0..1000 {
                let from = DVec3::from_array([0; 3].map(|_| 0.1 + 0.5 * f64::from(rng.uniform())));
                let to = DVec3::from_array([0; 3].map(|_| 0.1 + 0.8 * f64::from(rng.uniform())));
                let point = |p: DVec3| scene.normalisation.point(place.transform_point3(p));
                let dir = place.transform_vector3(-to.normalize()).as_vec3a();
                let (out, bounces) = follow(&scene, Ray::new(point(from), dir));
                if bounces == 3 {
                    thrice += 1;
                    let apart = (out + dir).abs().max_element();
                    assert!(apart <= tolerance, "{dir} {out} {apart:e}");
                }
            }
            assert!(thrice > 500, "{thrice}");
        }
    }
}

/// A lamp that shines up at a mirror lights the floor as its image behind the mirror would: what the floor's scattering finds
/// there, no light sampling does.
#[test]
fn a_lamp_in_a_mirror_lights_as_its_image_does() {
    let albedo = 0.5;
    let mut scene = looking(DVec3::new(-0.3, 0.2, 0.4), DVec3::ZERO, diffuse(albedo));
    let model = mirror(REFLECTANCE);
    scene
        .materials
        .push(MaterialDescription::new("mirror", Place::default(), model));
    let floor = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let lamp = rectangle([0.6, -0.5, 0.3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let above = rectangle([-2.0, -2.0, 1.0], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0]);
    scene.shapes = vec![shape(floor, 0.0), shape(lamp, 1.0), shape(above, 0.0)];
    scene.shapes[2].material = 1;
    // From x = 0.6 to 1.6, as far above the mirror as the lamp is below it.
    let up_to = |x: f64| 2.0 * parallel_rectangle(x, 0.5, 1.7);
    let exact = f64::from(albedo * REFLECTANCE) * (up_to(1.6) - up_to(0.6));
    for &backend in Backend::ALL {
        let seen = see(&scene, backend, 1 << 12, Some(2), Roulette::None);
        assert_mean(backend.name(), &seen, exact, 1e-2);
    }
}
