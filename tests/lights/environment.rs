//! Environment maps: the direction of each texel, and the agreement of sampling with evaluation.

use crate::common::TestRng;
use crate::common::chi_square::ChiSquareTest;
use crate::common::closed_forms::bright_texel;
use crate::common::quadrature::integrate;
use crate::common::scene::{diffuse, patch_scene, ready, rectangle, see, see_by, surface};
use crate::common::verdict::assert_mean;
use etendue::internals::accel::Backend;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::light::Light;
use etendue::internals::light::environment::EnvironmentMap;
use etendue::internals::light::point::PointLight;
use etendue::internals::light::select::Lights;
use etendue::internals::light::types::{
    EnvironmentSampling, LightChoice, LightSampling, Receiver, ShadowRayEnd,
};
use etendue::internals::math::measure::Pmf;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{DMat3, DVec3, ONE_MINUS_EPSILON, Vec2, Vec3};
use etendue::internals::scene::description::{
    ColourDescription, LightDescription, LightModel, Place, SceneDescription,
};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

fn map_of(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Option<EnvironmentMap> {
    turned(width, height, texel, DMat3::IDENTITY)
}

fn turned(
    width: u32,
    height: u32,
    texel: impl Fn(u32, u32) -> f32,
    to_world: DMat3,
) -> Option<EnvironmentMap> {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = pixels.map(|(x, y)| Rgb::grey(texel(x, y))).collect();
    let image = Image::new(width, height, pixels);
    EnvironmentMap::new(Arc::new(image.into()), 1.0, to_world)
}

/// A map of random texels, a third of them black, and one very bright.
fn random(width: u32, height: u32, brightest: f32, to_world: DMat3) -> EnvironmentMap {
    let value = |x: u32, y: u32| {
        let mut rng = TestRng::new(u64::from(1000 * y + x));
        let value = rng.uniform();
        match (x, y) {
            (1, 1) => brightest,
            _ if rng.uniform() < 0.33 => 0.0,
            _ => value,
        }
    };
    turned(width, height, value, to_world).expect("not black")
}

/// The direction at (u, v) of the panorama, as defined in docs/scene-format.md.
fn direction(u: f64, v: f64) -> DVec3 {
    let (azimuth, theta) = (TAU * (u - 0.5), PI * v);
    DVec3::new(
        theta.sin() * azimuth.sin(),
        theta.cos(),
        -theta.sin() * azimuth.cos(),
    )
}

fn seen(map: &EnvironmentMap, w: DVec3) -> f32 {
    map.eval(w.as_vec3a(), EnvironmentSampling::Radiance)
        .0
        .to_array()[0]
}

fn turn() -> DMat3 {
    DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-1.1)
}

#[test]
fn environment_texels_have_correct_direction_and_interpolation() {
    for to_world in [DMat3::IDENTITY, turn()] {
        for (column, row) in [(0, 0), (3, 1), (7, 2), (5, 3), (4, 1)] {
            let texel = |x, y| f32::from((x, y) == (column, row));
            let map = turned(8, 4, texel, to_world).expect("not black");
            for y in 0..4 {
                for x in 0..8 {
                    let [u, v] = [(f64::from(x) + 0.5) / 8.0, (f64::from(y) + 0.5) / 4.0];
                    let value = seen(&map, to_world * direction(u, v));
                    let expected = texel(x, y);
                    assert!((value - expected).abs() < 3e-6, "({x}, {y}): {value}");
                    let between = seen(&map, to_world * direction(u + 1.0 / 16.0, v));
                    let expected = 0.5 * (expected + texel((x + 1) % 8, y));
                    assert!((between - expected).abs() < 3e-6, "({x}, {y}): {between}");
                }
            }
        }
    }
}

#[test]
fn environment_map_centre_is_minus_z_and_first_row_is_up() {
    let map = map_of(16, 8, |x, y| (100 * y + x) as f32).expect("not black");
    let near = |w: DVec3, expected: f32| {
        let value = seen(&map, w);
        assert!(
            (value - expected).abs() < 1e-3,
            "{w}: {value}, not {expected}"
        );
    };
    // The directions lie between columns 7 and 8, 11 and 12, 3 and 4; and rows 3 and 4.
    near(DVec3::NEG_Z, 357.5);
    near(DVec3::X, 361.5);
    near(DVec3::NEG_X, 353.5);
    // Across the seam, from column 15 to 0.
    near(DVec3::Z, 357.5);
    near(direction(1.0 / 64.0, 0.5), 350.0 + 0.75 * 0.0 + 0.25 * 15.0);
    // The first and the last row extend to the poles.
    let rows = map_of(16, 8, |_, y| y as f32 + 1.0).expect("not black");
    for w in [
        DVec3::Y,
        direction(0.3, 0.03),
        DVec3::new(1e-12, 1.0, 1e-20),
    ] {
        assert_eq!(seen(&rows, w), 1.0);
    }
    for w in [
        DVec3::NEG_Y,
        direction(0.3, 0.98),
        DVec3::new(-0.0, -1.0, 0.0),
    ] {
        assert_eq!(seen(&rows, w), 8.0);
    }
}

#[test]
fn environment_map_samples_match_their_pdf() {
    for (name, map) in [
        ("small", random(5, 3, 2.0, turn())),
        ("bright", random(16, 8, 100.0, DMat3::IDENTITY)),
        ("narrow", random(1, 4, 1.0, turn())),
        ("low", random(6, 1, 1.0, DMat3::IDENTITY)),
    ] {
        let test = ChiSquareTest {
            levels: 6,
            ..ChiSquareTest::default()
        };
        let result = test.run(
            |rng| {
                map.sample(rng.uniform_2d(), EnvironmentSampling::Radiance)
                    .map(|s| s.wi)
            },
            |w| map.eval(w, EnvironmentSampling::Radiance).1.0,
        );
        assert!(result.p_value > 1e-4, "{name}: {result:?}");
        assert!((result.integral - 1.0).abs() < 2e-3, "{name}: {result:?}");
    }
}

/// The upper border of a row of patches, as angle from +y.
fn border(row: u32, height: u32) -> f64 {
    (PI * (f64::from(row) - 0.5) / f64::from(height)).clamp(0.0, PI)
}

#[test]
fn environment_pdf_integrates_to_one_and_is_positive_where_lit() {
    for (width, height) in [(1, 1), (2, 1), (1, 2), (7, 5), (64, 32)] {
        let map = random(width, height, 1e6, turn());
        let mut integral = 0.0;
        for row in 0..=height {
            let [a, b] = [border(row, height), border(row + 1, height)];
            for column in 0..width {
                let u = (f64::from(column) + 1.0) / f64::from(width);
                let w = turn() * direction(u, 0.5 * (a + b) / PI);
                let (radiance, pdf) = map.eval(w.as_vec3a(), EnvironmentSampling::Radiance);
                assert!(pdf.0 > 0.0 || radiance.is_black(), "({column}, {row})");
                integral += f64::from(pdf.0) * (a.cos() - b.cos()) * TAU / f64::from(width);
            }
        }
        assert!(
            (integral - 1.0).abs() < 2e-6,
            "{width} x {height}: {integral}"
        );
        let mut rng = TestRng::new(3);
        for _ in 0..10_000 {
            let w = rng.direction_log_uniform(1e-6);
            let (radiance, pdf) = map.eval(w, EnvironmentSampling::Radiance);
            assert!(pdf.0 > 0.0 || radiance.is_black(), "{w}");
        }
    }
}

#[test]
fn environment_sample_radiance_and_pdf_equal_evaluation() {
    for map in [random(7, 5, 3.0, turn()), random(64, 32, 1e6, turn())] {
        let mut rng = TestRng::new(4);
        let ends = [0.0, 0.5, ONE_MINUS_EPSILON];
        let corners = ends.into_iter().flat_map(|x| ends.map(|y| Vec2::new(x, y)));
        let us: Vec<Vec2> = corners.chain((0..5000).map(|_| rng.uniform_2d())).collect();
        let mut nothing = 0;
        for u in us {
            // At the border to a black patch, rounding can place a sample in that patch, where radiance is zero.
            let Some(s) = map.sample(u, EnvironmentSampling::Radiance) else {
                nothing += 1;
                continue;
            };
            assert!((s.wi.length() - 1.0).abs() < 1e-6, "{u} {s:?}");
            assert!(matches!(s.end, ShadowRayEnd::Infinity));
            let (radiance, pdf) = map.eval(s.wi, EnvironmentSampling::Radiance);
            assert_eq!((s.radiance, s.pdf), (radiance, Some(pdf)));
        }
        assert!(
            nothing <= 9,
            "{nothing} samples failed, not only at the ends of the interval"
        );
    }
}

/// Estimates by light sampling of the integral of the radiance over the sphere, one for each replicate.
fn estimated(map: &EnvironmentMap, samples: u32) -> Moments {
    Moments::of((0..32).map(|replicate| {
        let mut rng = TestRng::new(replicate);
        let one = |rng: &mut TestRng| {
            map.sample(rng.uniform_2d(), EnvironmentSampling::Radiance)
                .map_or(0.0, |s| {
                    f64::from(s.radiance.luminance()) / f64::from(s.pdf.expect("no delta").0)
                })
        };
        (0..samples).map(|_| one(&mut rng)).sum::<f64>() / f64::from(samples)
    }))
}

/// The power and the peak radiance of a map with one bright texel. Its light sampling is row 32 of the battery.
#[test]
fn single_bright_texel_has_correct_power_and_peak_radiance() {
    let (width, height) = (4096, 2048);
    for row in [1023, 0, 1, 2047] {
        let texel = |x, y| if (x, y) == (1000, row) { 1e6 } else { 0.0 };
        let map = map_of(width, height, texel).expect("not black");
        let exact = 1e6 * bright_texel(row, width, height);
        let by_power = map.power(1.0) / PI;
        assert!(
            (by_power / exact - 1.0).abs() < 1e-6,
            "row {row}: {by_power:e} {exact:e}"
        );
        // The radiance at the centre of the texel.
        let theta = (f64::from(row) + 0.5) / f64::from(height);
        let centre = direction(1000.5 / 4096.0, theta);
        assert!((seen(&map, centre) / 1e6 - 1.0).abs() < 3e-3, "row {row}");
    }
}

#[test]
fn random_environment_power_and_estimate_match_its_integral() {
    let (width, height) = (7, 5);
    let map = random(width, height, 30.0, turn());
    // By quadrature over each patch, where radiance is smooth.
    let mut exact = 0.0;
    for row in 0..=height {
        for column in 0..width {
            let u = |x: f64| (f64::from(column) + 0.5 + x) / f64::from(width);
            let over_u = |theta: f64| {
                let radiance = |x| f64::from(seen(&map, turn() * direction(u(x), theta / PI)));
                theta.sin() * integrate(radiance, 0.0, 1.0, 1)
            };
            let [a, b] = [border(row, height), border(row + 1, height)];
            exact += TAU / f64::from(width) * integrate(over_u, a, b, 1);
        }
    }
    let by_power = map.power(2.0) / (4.0 * PI);
    assert!((by_power / exact - 1.0).abs() < 1e-6, "{by_power} {exact}");
    assert_mean("random map", &estimated(&map, 1 << 12), exact, 1e-2);
}

#[test]
fn constant_map_has_uniform_pdf_and_black_map_is_no_light() {
    for (width, height) in [(1, 1), (3, 2), (64, 32)] {
        let map = map_of(width, height, |_, _| 0.5).expect("not black");
        let mut rng = TestRng::new(6);
        for _ in 0..1000 {
            let s = map
                .sample(rng.uniform_2d(), EnvironmentSampling::Radiance)
                .expect("no direction is black");
            let pdf = f64::from(s.pdf.expect("no delta").0);
            assert!((pdf * 4.0 * PI - 1.0).abs() < 3e-7, "{width}: {pdf}");
            assert!((s.radiance.to_array()[0] - 0.5).abs() < 1e-6);
        }
        assert!(map_of(width, height, |_, _| 0.0).is_none());
    }
}

#[test]
fn environment_pdf_includes_the_light_selection_probability() {
    let map = Arc::new(random(7, 5, 3.0, turn()));
    let point = PointLight::new(Vec3::Y, Rgb::WHITE);
    let both = vec![Light::Point(point), Light::Environment(Arc::clone(&map))];
    let lights = Lights::new(both, &[1.0, 3.0]);
    let mut rng = TestRng::new(7);
    let mut found = 0;
    for _ in 0..1000 {
        let (a, b) = (rng.uniform_2d(), rng.uniform_2d());
        let choice = lights.choose_by_power::<Everything>([b.x, b.y]);
        let choice = choice.expect("both lights have power");
        let light = choice.0;
        let s = lights
            .sample::<Everything>(choice, LightSampling::default(), Vec3::ZERO, 0.0, a)
            .expect("both lights reach every point");
        let Some(pdf) = s.pdf else {
            // The irradiance of the point light is divided by its selection probability, 1 / 4.
            assert_eq!((light, s.radiance), (0, Rgb::grey(4.0)));
            continue;
        };
        found += 1;
        let beyond = lights.environment(s.wi, EnvironmentSampling::Radiance);
        let beyond = beyond.expect("there is a map");
        assert_eq!((light, beyond.light), (1, 1));
        assert_eq!((s.radiance, pdf), (beyond.radiance, choice.1 * beyond.pdf));
        assert!((pdf.0 / map.eval(s.wi, EnvironmentSampling::Radiance).1.0 - 0.75).abs() < 1e-6);
    }
    // 750 +- 14.
    assert!((680..820).contains(&found), "{found}");
    // A map that is never chosen is still evaluated.
    let lights = Lights::new(vec![Light::Environment(map)], &[0.0]);
    assert!(
        lights
            .environment(Vec3::X, EnvironmentSampling::Radiance)
            .is_some()
    );
    let nowhere = Receiver::isotropic(Vec3::ZERO);
    for choice in LightChoice::ALL {
        assert_eq!(lights.pmf::<Everything>(0, *choice, &nowhere), Pmf(0.0));
    }
    assert!(
        Lights::new(vec![Light::Point(point)], &[1.0])
            .environment(Vec3::X, EnvironmentSampling::Radiance)
            .is_none()
    );
}

/// A floor of albedo 0.5 under an environment map, seen from above.
fn floor_under(texture: Texture, to_world: DMat3) -> SceneDescription {
    let mut scene = patch_scene(DVec3::new(0.3, 2.0, 0.4), DVec3::ZERO, diffuse(0.5));
    let ground = rectangle([-3.0, 0.0, 3.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0]);
    scene.shapes.push(surface(ground, 0.0));
    let radiance = ColourDescription::Texture(Arc::new(texture));
    scene.lights.push(LightDescription {
        place: Place::default(),
        model: LightModel::Environment { radiance, to_world },
    });
    scene
}

fn picture_of(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Texture {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = pixels.map(|(x, y)| Rgb::grey(texel(x, y))).collect();
    Texture::Image {
        image: Arc::new(Image::new(width, height, pixels).into()),
        scale: 2.0,
    }
}

#[test]
fn floor_under_environment_map_matches_its_irradiance() {
    // A dim sky with a sun in column 3 of row 4, which is above the horizon after the tilt below.
    let (width, height) = (32, 16);
    let texel = |x, y| if (x, y) == (3, 4) { 1000.0 } else { 0.25 };
    let to_world = DMat3::from_rotation_z(0.2) * DMat3::from_rotation_y(1.0);
    let map = turned(width, height, |x, y| 2.0 * texel(x, y), to_world).expect("not black");
    // The irradiance of the dim part is pi L; the sun is a tent above it, between the centres of its neighbours.
    let [u, v] = [|x: f64| x / 32.0, |y: f64| y / 16.0];
    let over_u = |theta: f64| {
        let one = |x: f64| {
            let w = to_world * direction(u(x), theta / PI);
            assert!(w.y > 0.0, "the sun is above the horizon");
            w.y * f64::from(seen(&map, w) - 0.5)
        };
        theta.sin() * TAU / 32.0 * (integrate(one, 2.5, 3.5, 1) + integrate(one, 3.5, 4.5, 1))
    };
    let sun = integrate(over_u, PI * v(3.5), PI * v(4.5), 1)
        + integrate(over_u, PI * v(4.5), PI * v(5.5), 1);
    let exact = 0.5 / PI * (PI * 0.5 + sun);
    let scene = floor_under(picture_of(width, height, texel), to_world);
    let pixels = see(
        &scene,
        Backend::ALL[0],
        1 << 14,
        Some(1),
        Roulette::default(),
    );
    assert_mean("sun and sky", &pixels, exact, 1e-3);
}

/// Half of this sky is 1, the other half 3: the mean is 2, and a density above the mean alone misses a quarter of the light.
#[test]
fn environment_lighting_includes_below_average_radiance() {
    let halves = picture_of(64, 32, |x, _| if x < 32 { 0.5 } else { 1.5 });
    let scene = floor_under(halves, DMat3::IDENTITY);
    for integrator in [IntegratorKind::Path, IntegratorKind::NextEvent] {
        let pixels = see_by(
            integrator,
            &scene,
            Backend::ALL[0],
            1 << 12,
            Some(1),
            Roulette::default(),
        );
        assert_mean(integrator.name(), &pixels, 0.5 * 2.0, 5e-3);
    }
}

#[test]
fn uniform_environment_image_becomes_a_constant_environment() {
    let plain = floor_under(picture_of(8, 4, |_, _| 0.75), turn());
    let scene = ready(&plain, Backend::ALL[0]);
    assert_eq!((scene.environment, scene.lights.len()), (Rgb::grey(1.5), 0));
    let pixels = see(&plain, Backend::ALL[0], 16, Some(1), Roulette::default());
    assert!((pixels.mean() - 0.75).abs() < 1e-6, "{}", pixels.mean());
    let black = floor_under(picture_of(8, 4, |_, _| 0.0), turn());
    let scene = ready(&black, Backend::ALL[0]);
    assert_eq!((scene.environment, scene.lights.len()), (Rgb::BLACK, 0));
    let pixels = see(&black, Backend::ALL[0], 4, None, Roulette::default());
    assert_eq!(pixels.mean(), 0.0);
}
