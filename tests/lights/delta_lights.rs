//! Tests of point, spot and distant lights: their samples, and that they are invisible to the camera. Row 31 of the
//! battery compares images with their closed forms.

use crate::common::quadrature::integrate;
use crate::common::scene::{diffuse, patch_scene, rectangle, see, surface};
use etendue::internals::accel::Backend;
use etendue::internals::integrator::Roulette;
use etendue::internals::light::distant::DistantLight;
use etendue::internals::light::point::PointLight;
use etendue::internals::light::spot::SpotLight;
use etendue::internals::light::types::ShadowRayEnd;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DVec3, Vec3};
use etendue::internals::scene::description::{
    LightDescription, LightModel, Place, SceneDescription,
};
use std::f64::consts::PI;

#[test]
fn point_light_sample_follows_the_inverse_square_law() {
    let position = Vec3::new(1.0, 2.0, -3.0);
    let light = PointLight::new(position, Rgb::new(8.0, 4.0, 0.0));
    let s = light
        .sample(position - 2.0 * Vec3::Y)
        .expect("a distance above 0");
    assert_eq!(
        (s.wi, s.radiance, s.pdf),
        (Vec3::Y, Rgb::new(2.0, 1.0, 0.0), None)
    );
    assert!(matches!(s.end, ShadowRayEnd::Point(p) if p == position));
    // The squares of these distances overflow or underflow single precision; direction and radiance are still right.
    let far = light
        .sample(position + 1e25 * Vec3::X)
        .expect("a distance above 0");
    assert_eq!((far.wi, far.radiance), (Vec3::NEG_X, Rgb::BLACK));
    assert!(light.sample(position).is_none());
    let origin = PointLight::new(Vec3::ZERO, Rgb::WHITE);
    assert!(origin.sample(1e-30 * Vec3::X).is_none());
    let luminance = f64::from(Rgb::new(8.0, 4.0, 0.0).luminance());
    assert!((light.power() - 4.0 * PI * luminance).abs() < 1e-6);
}

#[test]
fn spot_light_falls_off_monotonically_over_its_penumbra() {
    for (cone, penumbra) in [(0.5, 0.2), (PI, PI), (2.5, 0.3), (1e-4, 5e-5), (0.3, 0.3)] {
        let light = SpotLight::new(Vec3::ZERO, Vec3::Z, Rgb::grey(3.0), cone, penumbra);
        // At distance 1 the irradiance equals the intensity.
        let at = |angle: f64| {
            let p = DVec3::new(angle.sin(), 0.0, angle.cos()).as_vec3a();
            light
                .sample(p)
                .map_or(0.0, |s| f64::from(s.radiance.to_array()[0]))
        };
        let close = |value: f64, expected: f64| {
            assert!(
                (value - expected).abs() < 6e-3,
                "{cone} {penumbra}: {value}, not {expected}"
            );
        };
        let full = cone - penumbra;
        close(at(0.0), 3.0);
        close(at(0.999 * full), 3.0);
        assert_eq!(at((1.001 * cone).min(PI)), 0.0);
        // In the middle of the penumbra, measured by the cosine, the intensity is half.
        let half_way = 0.5 * ((0.5 * cone).sin().powi(2) + (0.5 * full).sin().powi(2));
        close(at(2.0 * half_way.sqrt().asin()), 1.5);
        let mut before = f64::INFINITY;
        for i in 0..=100 {
            let value = at(full + penumbra * f64::from(i) / 100.0);
            assert!(
                value <= before * (1.0 + 1e-6),
                "the intensity never increases"
            );
            before = value;
        }
        // The power is the integral of the intensity.
        let ring = |angle: f64| 2.0 * PI * angle.sin() * at(angle);
        let exact = integrate(ring, 0.0, full, 1) + integrate(ring, full, cone, 4);
        assert!(
            (light.power() / exact - 1.0).abs() < 2e-3,
            "{} {exact}",
            light.power()
        );
    }
}

#[test]
fn spot_light_without_penumbra_has_a_hard_edge() {
    let light = SpotLight::new(Vec3::ZERO, Vec3::NEG_Y, Rgb::WHITE, PI / 3.0, 0.0);
    let at = |degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        light
            .sample(Vec3::new(sin, -cos, 0.0))
            .map(|s| s.radiance.to_array()[0])
    };
    assert!(at(59.9).is_some_and(|x| (x - 1.0).abs() < 1e-6) && at(60.1).is_none());
    assert!((light.power() - PI).abs() < 1e-6);
}

#[test]
fn spot_light_with_180_degree_cone_emits_directly_backwards() {
    let mut rng = crate::common::TestRng::new(1);
    for _ in 0..1000 {
        let axis = rng.direction_log_uniform(1e-3);
        let light = SpotLight::new(Vec3::ZERO, axis, Rgb::WHITE, PI, 0.0);
        assert!(light.sample(-axis).is_some(), "{axis}");
    }
}

#[test]
fn distant_light_sample_has_given_direction_and_irradiance() {
    let light = DistantLight::new(Vec3::NEG_Y, Rgb::grey(3.0));
    let s = light.sample();
    assert_eq!((s.wi, s.radiance, s.pdf), (Vec3::Y, Rgb::grey(3.0), None));
    assert!(matches!(s.end, ShadowRayEnd::Infinity));
    assert!((light.power(2.0) - 12.0 * PI).abs() < 1e-5);
}

/// A scene with a floor of albedo 0.5 around the origin, seen from above, and lights.
fn floor(half: f64, lights: impl IntoIterator<Item = LightModel>) -> SceneDescription {
    let mut scene = patch_scene(DVec3::new(0.3, 2.0, 0.4), DVec3::ZERO, diffuse(0.5));
    let side = 2.0 * half;
    let ground = rectangle([-half, 0.0, half], [side, 0.0, 0.0], [0.0, 0.0, -side]);
    scene.shapes.push(surface(ground, 0.0));
    scene
        .lights
        .extend(lights.into_iter().map(|model| LightDescription {
            place: Place::default(),
            model,
        }));
    scene
}

/// Asserts that every pixel has the radiance albedo / pi times `irradiance`.
#[track_caller]
fn assert_irradiance(what: &str, scene: &SceneDescription, irradiance: f64, tolerance: f64) {
    for backend in Backend::ALL {
        let pixels = see(scene, *backend, 4, Some(1), Roulette::default());
        let exact = 0.5 / PI * irradiance;
        let spread = pixels.variance().expect("32 pixels").sqrt();
        assert!(
            (pixels.mean() / exact - 1.0).abs() < tolerance && spread < tolerance * exact,
            "{what}, {backend:?}: {} +- {spread}, not {exact}",
            pixels.mean()
        );
    }
}

fn point(position: DVec3, intensity: f32) -> LightModel {
    LightModel::Point {
        position,
        intensity: Rgb::grey(intensity),
    }
}

fn distant(direction: DVec3, irradiance: f32) -> LightModel {
    LightModel::Distant {
        direction,
        irradiance: Rgb::grey(irradiance),
    }
}

#[test]
fn delta_lights_are_invisible_to_camera_and_scattered_rays() {
    // The camera looks straight at the light, in front of a wall.
    let towards = patch_scene(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, diffuse(0.5));
    let mut scene = towards;
    scene.shapes.push(surface(
        rectangle([-1.0, -1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
        0.0,
    ));
    scene.lights = floor(1.0, [point(DVec3::ZERO, 4.0)]).lights;
    // The wall behind it, at distance 1, has irradiance 4; the light itself adds nothing.
    assert_irradiance("behind", &scene, 4.0, 3e-4);
    scene.lights = floor(1.0, [distant(DVec3::Z, 4.0)]).lights;
    let dark = see(&scene, Backend::ALL[0], 4, None, Roulette::default());
    assert_eq!(dark.mean(), 0.0, "lit from behind the wall");
}
