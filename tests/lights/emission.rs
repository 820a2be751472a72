//! Emission sampling of each kind of light: directions and points have the density that is claimed, and the rays carry the
//! light's power.

use crate::common::TestRng;
use crate::common::chi_square::{ChiSquareTest, uniformity};
use crate::common::scene::panorama;
use crate::common::verdict::{assert_mean, sidak};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::disk::Disk;
use etendue::internals::geometry::sphere::Sphere;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::light::Light;
use etendue::internals::light::disk::DiskLight;
use etendue::internals::light::distant::DistantLight;
use etendue::internals::light::environment::EnvironmentMap;
use etendue::internals::light::moving::MovingTriangle;
use etendue::internals::light::point::PointLight;
use etendue::internals::light::rectangle::RectangleLight;
use etendue::internals::light::sphere::SphereLight;
use etendue::internals::light::spot::SpotLight;
use etendue::internals::light::triangle::TriangleLight;
use etendue::internals::light::types::{BoundingSphere, Emission, EmissionSample, ShadowRayEnd};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{DMat3, Vec2, Vec3};
use std::sync::Arc;

const AROUND: BoundingSphere = BoundingSphere {
    center: Vec3::new(0.3, -0.2, 0.1),
    radius: 2.5,
};

const TIME: f32 = 0.25;

/// One light of each kind.
fn lights() -> Vec<(&'static str, Light)> {
    let mut all = Vec::new();
    let corner = Vec3::new(-0.5, -0.4, 1.0);
    let edges = [Vec3::new(0.0, 0.8, 0.1), Vec3::new(1.0, 0.0, 0.0)];
    let triangle = [corner, corner + edges[0], corner + edges[1]];
    for two_sided in [false, true] {
        let e = Emission {
            radiance: Rgb::new(1.0, 2.0, 0.5),
            two_sided,
        };
        let moved = triangle.map(|p| 1.5 * p);
        all.extend([
            ("triangle", Light::Triangle(TriangleLight::new(triangle, e))),
            (
                "moving triangle",
                Light::MovingTriangle(MovingTriangle::new(vec![triangle, moved], e)),
            ),
            (
                "rectangle",
                Light::Rectangle(RectangleLight::new(corner, edges, e)),
            ),
            (
                "disk",
                Light::Disk(DiskLight::new(Disk::new(corner, Vec3::Y, 0.4), e)),
            ),
            (
                "sphere",
                Light::Sphere(SphereLight::new(Sphere::new(corner, 0.4), e)),
            ),
        ]);
    }
    let Texture::Image { image, scale } = panorama() else {
        unreachable!("a panorama is an image texture")
    };
    let map = EnvironmentMap::new(image, scale, DMat3::from_rotation_x(0.7)).expect("not black");
    let intensity = Rgb::new(2.0, 1.0, 3.0);
    let axis = Vec3::new(0.48, 0.6, 0.64);
    let spot =
        |cone, penumbra| Light::Spot(SpotLight::new(corner, axis, intensity, cone, penumbra));
    all.extend([
        ("point", Light::Point(PointLight::new(corner, intensity))),
        ("narrow spot", spot(0.05, 0.02)),
        ("wide spot", spot(2.5, 2.5)),
        (
            "distant",
            Light::Distant(DistantLight::new(axis, intensity)),
        ),
        ("environment", Light::Environment(Arc::new(map))),
    ]);
    all
}

fn sampled(light: &Light, rng: &mut TestRng) -> Option<EmissionSample> {
    let (position, direction) = (rng.uniform_2d(), rng.uniform_2d());
    light.sample_emission::<Everything>(TIME, position, direction, &AROUND)
}

/// The geometric normal at the sampled point; zero for a light without a surface.
fn normal_of(sample: &EmissionSample) -> Vec3 {
    match &sample.end {
        ShadowRayEnd::Surface(point, _) => point.ng,
        ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => Vec3::ZERO,
    }
}

/// The power of a ray: the luminance of its radiance times the cosine over the densities.
fn power_of(sample: &EmissionSample) -> f64 {
    let cos = match &sample.end {
        ShadowRayEnd::Surface(point, _) => point.ng.dot(sample.direction).abs(),
        ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => 1.0,
    };
    let position = sample.pdf.position.map_or(1.0, |pdf| pdf.0);
    let direction = sample.pdf.direction.map_or(1.0, |pdf| pdf.0);
    f64::from(sample.radiance.luminance() * cos / (position * direction))
}

#[test]
fn mean_power_of_emission_samples_equals_light_power() {
    for (name, light) in lights() {
        let mut rng = TestRng::new(3);
        let means = (0..64).map(|_| {
            let n = 1 << 10;
            let powers = (0..n).map(|_| sampled(&light, &mut rng).map_or(0.0, |s| power_of(&s)));
            powers.sum::<f64>() / f64::from(n)
        });
        let expected = match &light {
            // `power` of a moving light is the mean over all times.
            Light::MovingTriangle(light) => light.at(TIME).power(),
            _ => light.power(f64::from(AROUND.radius)),
        };
        assert_mean(name, &Moments::of(means), expected, 0.005);
    }
}

#[test]
fn emission_directions_match_their_pdf() {
    for (index, (name, light)) in lights().into_iter().enumerate() {
        if name == "distant" {
            continue;
        }
        let normal = sampled(&light, &mut TestRng::new(1)).map_or(Vec3::ZERO, |s| normal_of(&s));
        // The directions from a sphere depend on the sampled point; their cosines are tested below.
        if name == "sphere" {
            continue;
        }
        let test = ChiSquareTest {
            seed: 10 + index as u64,
            ..ChiSquareTest::default()
        };
        let result = test.run(
            |rng| sampled(&light, rng).map(|s| s.direction),
            |w| {
                let pdf = light.pdf_emission(TIME, normal, w, &AROUND);
                pdf.direction.map_or(0.0, |pdf| pdf.0)
            },
        );
        assert!((result.integral - 1.0).abs() < 2e-3, "{name}: {result:?}");
        assert!(result.p_value > sidak(1e-4, 30), "{name}: {result:?}");
    }
}

/// One or two numbers that are uniform if the sampled point is: the shares of the light's area that lie before it.
fn shares(name: &str, sample: &EmissionSample) -> [f32; 2] {
    let corner = Vec3::new(-0.5, -0.4, 1.0);
    match &sample.end {
        ShadowRayEnd::Surface(point, b) => match name {
            "triangle" | "moving triangle" => {
                // Barycentric coordinates: the square of 1 - b[0] is uniform.
                let rest = 1.0 - b[0];
                [1.0 - rest * rest, b[1] / rest.max(f32::MIN_POSITIVE)]
            }
            "rectangle" => {
                let d = point.p - corner;
                [d.y / 0.8, d.x]
            }
            "disk" => {
                let d = (point.p - corner) / 0.4;
                [
                    d.length_squared(),
                    0.5 + d.z.atan2(d.x) / std::f32::consts::TAU,
                ]
            }
            _ => {
                let d = (point.p - corner) / 0.4;
                [
                    0.5 + 0.5 * d.z,
                    0.5 + d.y.atan2(d.x) / std::f32::consts::TAU,
                ]
            }
        },
        ShadowRayEnd::Point(_) => [0.5; 2],
        ShadowRayEnd::Infinity => {
            let from_center = sample.origin - AROUND.center;
            let along = from_center.dot(sample.direction);
            assert!(along < 0.0, "the ray starts outside the scene");
            let across = (from_center - along * sample.direction) / AROUND.radius;
            [across.length_squared(), 0.5]
        }
    }
}

#[test]
fn emission_points_are_uniform_over_light_or_scene_disk() {
    for (name, light) in lights() {
        let is_point = matches!(light, Light::Point(_) | Light::Spot(_));
        let is_beyond = matches!(light, Light::Distant(_) | Light::Environment(_));
        let columns = if is_beyond { 1 } else { 16 };
        let mut cells = vec![0_u32; 16 * columns];
        let mut rng = TestRng::new(7);
        for _ in 0..1 << 14 {
            let Some(sample) = sampled(&light, &mut rng) else {
                continue;
            };
            let [a, b] = shares(name, &sample).map(|share| share.clamp(0.0, 0.999_999));
            let column = (b * columns as f32) as usize;
            cells[(a * 16.0) as usize * columns + column] += 1;
            let pdf = light.pdf_emission(TIME, normal_of(&sample), sample.direction, &AROUND);
            assert_eq!(pdf.position, sample.pdf.position, "{name}");
            let [claimed, known] =
                [pdf.direction, sample.pdf.direction].map(|pdf| pdf.map_or(1.0, |pdf| pdf.0));
            assert!(
                (claimed / known - 1.0).abs() < 1e-4,
                "{name}: {claimed} {known}"
            );
        }
        if !is_point {
            let p = uniformity(&cells);
            assert!(p > sidak(1e-4, 30), "{name}: {p} {cells:?}");
        }
    }
}

/// The square of the cosine with the normal is uniform where the density is in proportion to the cosine.
#[test]
fn sphere_emission_directions_are_cosine_distributed() {
    for (name, light) in lights() {
        if name != "sphere" {
            continue;
        }
        let mut cells = [0_u32; 32];
        let mut rng = TestRng::new(9);
        for _ in 0..1 << 14 {
            let sample = sampled(&light, &mut rng).expect("a sphere emits everywhere");
            let cos = sample.direction.dot(normal_of(&sample));
            cells[((32.0 * cos * cos) as usize).min(31)] += 1;
        }
        let p = uniformity(&cells);
        assert!(p > 1e-5, "{p} {cells:?}");
    }
}

#[test]
fn extreme_random_numbers_give_finite_emission_rays() {
    let extremes = [0.0, 0.5, 1.0 - f32::EPSILON / 2.0];
    let corners = || {
        extremes
            .into_iter()
            .flat_map(|x| extremes.map(|y| Vec2::new(x, y)))
    };
    for (name, light) in lights() {
        for position in corners() {
            for direction in corners() {
                let sample =
                    light.sample_emission::<Everything>(TIME, position, direction, &AROUND);
                let Some(sample) = sample else { continue };
                let finite = sample.origin.is_finite() && power_of(&sample).is_finite();
                assert!(finite, "{name} {position} {direction}: {sample:?}");
                assert!((sample.direction.length() - 1.0).abs() < 1e-5, "{name}");
            }
        }
    }
}
