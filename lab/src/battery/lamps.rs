//! Lights: the solid angles of sampled area lights, point lights, spots, distant lights, environment maps, and
//! occluders that almost touch a light.
//!
//! Measure: radiance of a floor of albedo 1/2; steradians.
//! Range: lights as small as a millionth of their distance, incident cosines down to a millionth.
//! Source: formulas at each. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort, Trial};
use super::claim::Claim;
use super::closed_forms::{bright_texel, parallel_rectangle};
use super::patch::{PatchSettings, bounces, direct, patch_scene, see};
use crate::bench::random::Random;
use crate::scene_builder::{ceiling, diffuse, light, mesh, rectangle, surface};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::sphere::Sphere;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::light::Light;
use etendue::internals::light::environment::EnvironmentMap;
use etendue::internals::light::sphere::SphereLight;
use etendue::internals::light::triangle::TriangleLight;
use etendue::internals::light::types::{Emission, EnvironmentSampling, LightSampling};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DMat3, DVec3, Vec2, Vec3};
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, LightModel, SceneDescription,
};
use std::f64::consts::PI;
use std::sync::Arc;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    [
        small_spheres(),
        small_triangles(),
        grazing(),
        occluders(),
        delta_lights(),
        panoramas(),
        useless_emitters(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const EMISSION: Emission = Emission {
    radiance: Rgb::WHITE,
    two_sided: false,
};

/// The mean of 1 / pdf over a grid of samples of a light, seen from the origin: its solid angle.
fn solid_angle(lamp: &Light) -> f64 {
    const GRID: u32 = 64;
    let middle = |i: u32| (i as f32 + 0.5) / GRID as f32;
    let points = (0..GRID * GRID).map(|i| Vec2::new(middle(i % GRID), middle(i / GRID)));
    let one = |u: Vec2| {
        let sample = lamp.sample::<Everything>(LightSampling::default(), Vec3::ZERO, 0.0, u);
        let pdf = sample.and_then(|sample| sample.pdf);
        pdf.map_or(f64::NAN, |pdf| 1.0 / f64::from(pdf.0))
    };
    points.map(one).sum::<f64>() / f64::from(GRID * GRID)
}

/// The solid angle of a sphere: 2 pi s^2 / (1 + sqrt(1 - s^2)), with s the ratio of radius and distance.
fn small_spheres() -> Vec<Case> {
    let case = |ratio: f32| {
        let sphere = Sphere::new(Vec3::Y, ratio);
        let s2 = f64::from(ratio).powi(2);
        let exact = 2.0 * PI * s2 / (1.0 + (1.0 - s2).sqrt());
        let name = format!("solid angle of a sphere of radius {ratio:e} at distance 1");
        let measure = move |_: &Trial<'_>| {
            let lamp = Light::Sphere(SphereLight::new(sphere, EMISSION));
            Ok(vec![solid_angle(&lamp)])
        };
        Case::new(22, name, Claim::without_noise(exact, 1e-6), measure)
    };
    [0.5, 1e-2, 1e-3, 2.4e-4, 1e-4, 1e-6].map(case).into()
}

/// The solid angle of a right triangle: the excess of its angles over pi, in double precision.
fn small_triangles() -> Vec<Case> {
    let case = |edge: f32| {
        let vertices = [
            Vec3::Z,
            Vec3::new(0.0, edge, 1.0),
            Vec3::new(edge, 0.0, 1.0),
        ];
        let exact = excess(vertices.map(|v| v.as_dvec3()));
        let name = format!("solid angle of a triangle of edge {edge:e} at distance 1");
        let measure = move |_: &Trial<'_>| {
            let lamp = Light::Triangle(TriangleLight::new(vertices, EMISSION));
            Ok(vec![solid_angle(&lamp)])
        };
        Case::new(23, name, Claim::without_noise(exact, 1e-6), measure)
    };
    [0.1, 1e-2, 1e-3, 1e-4].map(case).into()
}

fn excess([a, b, c]: [DVec3; 3]) -> f64 {
    let angle = |a: DVec3, b: DVec3, c: DVec3| {
        let (n, m) = (a.cross(b), a.cross(c));
        n.cross(m).length().atan2(n.dot(m))
    };
    angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - PI
}

/// A floor in the plane y = 0 around the origin, seen from above, under the given lights.
pub fn floor(half: f64, lights: impl IntoIterator<Item = LightModel>) -> SceneDescription {
    let mut scene = patch_scene(DVec3::new(0.3, 2.0, 0.4), DVec3::ZERO, diffuse(0.5));
    let side = 2.0 * half;
    let ground = rectangle([-half, 0.0, half], [side, 0.0, 0.0], [0.0, 0.0, -side]);
    scene.shapes.push(surface(ground, 0.0));
    scene.lights.extend(lights.into_iter().map(light));
    scene
}

/// A small square that contains the light's `position`, as a ceiling contains a lamp: the side on which rounding places
/// the light must not matter.
pub fn square_through(position: DVec3, tilt: f64) -> GeometryDescription {
    let (u, v) = (
        DVec3::new(0.4, tilt, 0.02),
        DVec3::new(0.03, -0.7 * tilt, 0.4),
    );
    let corner = position - 0.37 * u - 0.61 * v;
    rectangle(corner.into(), u.into(), v.into())
}

/// The radiance of the floor for an irradiance.
pub fn reflected(irradiance: f64) -> f64 {
    0.5 / PI * irradiance
}

/// A point light with equal intensity in all directions.
pub fn point(position: DVec3, intensity: f32) -> LightModel {
    LightModel::Point {
        position,
        intensity: Rgb::grey(intensity),
    }
}

/// A distant light.
pub fn distant(direction: DVec3, irradiance: f32) -> LightModel {
    LightModel::Distant {
        direction,
        irradiance: Rgb::grey(irradiance),
    }
}

fn grazing() -> Vec<Case> {
    let case = |cos: f64| {
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let direction = DVec3::new(sin * f64::cos(0.3), -cos, sin * f64::sin(0.3));
        let claim = Claim::without_noise(reflected(5.0 * cos), 1e-4);
        let name = format!("parallel light that grazes the floor at cos {cos:e}");
        Case::seen(
            29,
            name,
            claim,
            floor(3.0, [distant(direction, 5.0)]),
            direct(4),
        )
    };
    [1e-2, 1e-3, 1e-4, 1e-5, 1e-6].map(case).into()
}

/// A roof between a floor and its light, at half the distance or closer to the light, or just behind the light.
fn occluders() -> Vec<Case> {
    let roof = |height: f64| {
        let roof = rectangle([-0.2, height, 0.2], [0.4, 0.0, 0.0], [0.0, 0.0, -0.4]);
        surface(roof, 0.0)
    };
    let under = |lamp: LightModel, height: f64| {
        let mut scene = floor(3.0, [lamp]);
        // The camera is below the roof.
        scene.camera = patch_scene(DVec3::new(1.0, 0.3, 0.0), DVec3::ZERO, diffuse(0.5)).camera;
        scene.shapes.push(roof(height));
        scene
    };
    let before = [0.5, 1e-2, 1e-4, 1e-6].map(|gap: f64| {
        let name = format!("roof {gap:e} before a point that shines");
        let scene = under(point(DVec3::Y, 1.0), 1.0 - gap);
        Case::seen(30, name, Claim::exactly(0.0), scene, direct(4))
    });
    let behind = [1e-2, 1e-4, 1e-6].map(|gap: f64| {
        let name = format!("roof {gap:e} behind a point that shines");
        let scene = under(point(DVec3::Y, 1.0), 1.0 + gap);
        // The tolerance accounts for the size of the patch that is seen.
        let claim = Claim::without_noise(reflected(1.0), 3e-4);
        Case::seen(30, name, claim, scene, direct(4))
    });
    let lamps = [1e-2, 1e-4, 1e-6].map(|gap: f64| {
        let mut scene = patch_scene(DVec3::new(0.3, 0.2, 0.4), DVec3::ZERO, diffuse(0.5));
        let ground = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let square = |half: f64, z: f64| ceiling([-half, half], [-half, half], z);
        scene.shapes = vec![
            surface(ground, 0.0),
            surface(square(0.5, 1.0), 1.0),
            surface(square(0.51, 1.0 - gap), 0.0),
        ];
        let name = format!("plate {gap:e} before a lamp");
        Case::seen(30, name, Claim::exactly(0.0), scene, direct(1 << 9))
    });
    let far = under(distant(DVec3::NEG_Y, 1.0), 100.0);
    let far = Case::seen(
        30,
        "roof 100 away before parallel light",
        Claim::exactly(0.0),
        far,
        direct(4),
    );
    before
        .into_iter()
        .chain(behind)
        .chain(lamps)
        .chain([far])
        .collect()
}

fn delta_lights() -> Vec<Case> {
    let position = |scale: f64| scale * DVec3::new(0.8, 1.5, -0.2);
    let scaled = |scale: f64, lamp: LightModel| {
        let mut scene = floor(3.0 * scale, [lamp]);
        scene.camera.to_world.translation *= scale;
        scene
    };
    let spot = |scale: f64, target: DVec3| LightModel::Spot {
        position: position(scale),
        target,
        intensity: Rgb::grey((4.0 * scale * scale) as f32),
        cone: 0.4,
        penumbra: 0.1,
    };
    let cos = position(1.0).y / position(1.0).length();
    let d2 = position(1.0).length_squared();
    let seen = |name: String, claim, scene| Case::seen(31, name, claim, scene, direct(4));
    let mut cases = Vec::new();
    for scale in [1e-3, 1.0, 1e4] {
        let intensity = (4.0 * scale * scale) as f32;
        // The tolerance accounts for the size of the patch that is seen.
        let lit = f64::from(intensity) * cos / (d2 * scale * scale);
        let lit = Claim::without_noise(reflected(lit), 3e-4);
        let lamp = point(position(scale), intensity);
        cases.extend([
            seen(format!("point, scale {scale:e}"), lit, scaled(scale, lamp)),
            seen(
                format!("spot, scale {scale:e}"),
                lit,
                scaled(scale, spot(scale, DVec3::ZERO)),
            ),
            seen(
                format!("beside a spot's cone, scale {scale:e}"),
                Claim::exactly(0.0),
                scaled(scale, spot(scale, position(scale) + scale * DVec3::X)),
            ),
            seen(
                format!("parallel light, scale {scale:e}"),
                Claim::without_noise(reflected(7.0 * cos), 1e-4),
                scaled(scale, distant(-3.0 * position(scale), 7.0)),
            ),
        ]);
    }
    for tilt in [0.0, 0.05, -0.11] {
        let mut scene = floor(3.0, [point(position(1.0), 4.0)]);
        let square = square_through(position(1.0), tilt);
        scene.shapes.push(surface(square, 0.0));
        cases.push(seen(
            format!("point in a square's plane, tilt {tilt}"),
            Claim::without_noise(reflected(4.0 * cos / d2), 3e-4),
            scene,
        ));
    }
    let both = [point(position(1.0), 4.0), distant(DVec3::NEG_Y, 2.0)];
    cases.push(Case::seen(
        31,
        "a point and parallel light together",
        Claim::mean(reflected(4.0 * cos / d2 + 2.0), 2e-3),
        floor(3.0, both),
        direct(1 << 9),
    ));
    // A point light cannot be hit by rays.
    let mut towards = patch_scene(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, diffuse(0.5));
    towards.lights = vec![light(point(DVec3::ZERO, 4.0))];
    cases.push(Case::seen(
        31,
        "a point looked at",
        Claim::exactly(0.0),
        towards,
        bounces(4, 16),
    ));
    cases
}

fn picture_of(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Image {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = pixels.map(|(x, y)| Rgb::grey(texel(x, y))).collect();
    Image::new(width, height, pixels)
}

fn panoramas() -> Vec<Case> {
    let (width, height) = (4096, 2048);
    let texels = [1023, 0].map(|row| {
        let name = format!("one texel of 1e6 in row {row} of a panorama of 4096 x 2048");
        let claim = Claim::mean(1e6 * bright_texel(row, width, height), 1e-3);
        Case::new(32, name, claim, move |trial| {
            let texel = |x, y| if (x, y) == (1000, row) { 1e6 } else { 0.0 };
            let image = Arc::new(picture_of(width, height, texel).into());
            let map = EnvironmentMap::new(image, 1.0, DMat3::IDENTITY);
            Ok(map.map_or(vec![], |map| integrals(trial, &map)))
        })
    });
    let sky = |value: f32| {
        let image = Arc::new(picture_of(8, 4, |_, _| value).into());
        let radiance = ColourDescription::Texture(Arc::new(Texture::Image { image, scale: 2.0 }));
        let to_world = DMat3::from_rotation_z(0.2) * DMat3::from_rotation_y(1.0);
        floor(3.0, [LightModel::Environment { radiance, to_world }])
    };
    let plain = Case::seen(
        32,
        "panorama of one colour",
        Claim::without_noise(0.5 * 1.5, 2e-6),
        sky(0.75),
        direct(16),
    );
    let black = Case::seen(
        32,
        "black panorama",
        Claim::exactly(0.0),
        sky(0.0),
        bounces(4, 16),
    );
    texels.into_iter().chain([plain, black]).collect()
}

/// Estimates the integral of the radiance over the sphere by light sampling, one number per replicate.
fn integrals(trial: &Trial<'_>, map: &EnvironmentMap) -> Vec<f64> {
    let samples = trial.samples(1 << 16);
    let replicate = |replicate: u64| {
        let mut random = Random::new(trial.seed, replicate);
        let one = |_| {
            let u = Vec2::new(random.uniform(), random.uniform());
            map.sample(u, EnvironmentSampling::Radiance)
                .map_or(0.0, |s| {
                    let pdf = s.pdf.map_or(f64::NAN, |pdf| f64::from(pdf.0));
                    f64::from(s.radiance.luminance()) / pdf
                })
        };
        (0..samples).map(one).sum::<f64>() / samples as f64
    };
    (0..32).map(replicate).collect()
}

/// A floor under one lamp, with a hundred thousand emitters of zero area and one of almost no radiance.
fn useless_emitters() -> Vec<Case> {
    const COUNT: u32 = 100_000;
    let patch: PatchSettings = direct(1 << 9);
    let name = "one lamp among 1e5 emitters of no area and one of radiance 1e-40";
    let exact = 0.5 * 4.0 * parallel_rectangle(1.0, 1.0, 1.0);
    let case = Case::new(33, name, Claim::mean(exact, 1e-3), move |trial| {
        let mut scene = patch_scene(DVec3::new(0.3, 0.2, 0.4), DVec3::ZERO, diffuse(0.5));
        let ground = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let lamp = ceiling([-1.0, 1.0], [-1.0, 1.0], 1.0);
        let dim = ceiling([-1.0, 1.0], [-1.0, 1.0], 2.0);
        scene.shapes = vec![
            surface(needles(COUNT), 1.0),
            surface(ground, 0.0),
            surface(lamp, 1.0),
            surface(dim, 1e-40),
        ];
        see(trial, &scene, patch)
    });
    vec![case]
}

/// A mesh of degenerate triangles whose vertices lie on a line.
fn needles(count: u32) -> GeometryDescription {
    let place = |i: u32| {
        let share = f64::from(i) / f64::from(count);
        DVec3::new(0.2 + 0.1 * share, 0.3, 0.5)
    };
    let positions = (0..count + 2).map(place).collect();
    mesh(positions, (0..count).map(|i| [i, i + 1, i + 2]).collect())
}
