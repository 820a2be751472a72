//! Lights: their samples, the densities of these, and the choice of one light among many.

use crate::common::TestRng;
use crate::common::chi_square::pearson;
use crate::common::closed_forms::{rectangle_solid_angle, triangle_solid_angle};
use crate::common::quadrature::gauss_legendre;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::disk::Disk;
use etendue::internals::geometry::sphere::Sphere;
use etendue::internals::geometry::surface::SurfacePoint;
use etendue::internals::light::Light;
use etendue::internals::light::disk::DiskLight;
use etendue::internals::light::rectangle::{self, RectangleLight};
use etendue::internals::light::select::Lights;
use etendue::internals::light::sphere::SphereLight;
use etendue::internals::light::triangle::{self, TriangleLight};
use etendue::internals::light::types::{
    Emission, LightChoice, LightSample, LightSampling, Receiver, ShadowRayEnd,
};
use etendue::internals::math::frame::Frame;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{ONE_MINUS_EPSILON, Vec2, Vec3};
use etendue::internals::sampling::distribution::AliasTable;
use etendue::internals::sampling::warp::sample_cone_uniform;

fn emission(two_sided: bool) -> Emission {
    Emission {
        radiance: Rgb::WHITE,
        two_sided,
    }
}

const CORNER: Vec3 = Vec3::new(-0.5, -0.4, 1.0);
const EDGES: [Vec3; 2] = [Vec3::new(0.0, 0.8, 0.0), Vec3::new(1.0, 0.0, 0.0)];
const RADIUS: f32 = 0.4;
const CENTER: Vec3 = Vec3::new(0.0, 0.0, 1.0);

/// The density of a sample of a light that is not a delta light.
fn density(sample: &LightSample) -> f32 {
    sample.pdf.expect("no delta").0
}

/// The point on the light of a sample of a shape.
fn end_of(sample: &LightSample) -> SurfacePoint {
    match sample.end {
        ShadowRayEnd::Surface(point, _) => point,
        ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => panic!("the light is a shape"),
    }
}

/// Lights that are chosen by power, in a scene of radius 1.
fn by_power(lights: Vec<Light>) -> Lights {
    let powers: Vec<f64> = lights.iter().map(|light| light.power(1.0)).collect();
    Lights::new(lights, &powers)
}

fn sampled(lights: &Lights, p: Vec3, [u, v, a, b]: [f32; 4]) -> Option<LightSample> {
    let choice = lights.choose_by_power::<Everything>([a, b])?;
    lights.sample::<Everything>(choice, LightSampling::default(), p, 0.0, Vec2::new(u, v))
}

/// Whether a ray from `p` along `w` hits a light.
type HitsLight = fn(Vec3, Vec3) -> bool;

/// One light of each kind about (0, 0, 1), the flat ones looking down.
fn lights(two_sided: bool) -> [(&'static str, Light, HitsLight); 4] {
    let e = emission(two_sided);
    let triangle = [CORNER, CORNER + EDGES[0], CORNER + EDGES[1]];
    let disk = Disk::new(CENTER, -Vec3::Z, RADIUS);
    let sphere = Sphere::new(CENTER, RADIUS);
    [
        (
            "triangle",
            Light::Triangle(TriangleLight::new(triangle, e)),
            |p, w| at_height_one(p, w).is_some_and(|[u, v]| u >= 0.0 && v >= 0.0 && u + v <= 1.0),
        ),
        (
            "rectangle",
            Light::Rectangle(RectangleLight::new(CORNER, EDGES, e)),
            |p, w| at_height_one(p, w).is_some_and(|uv| uv.iter().all(|x| (0.0..=1.0).contains(x))),
        ),
        ("disk", Light::Disk(DiskLight::new(disk, e)), |p, w| {
            let t = (1.0 - p.z) / w.z;
            t > 0.0 && (p + t * w - CENTER).length() <= RADIUS
        }),
        (
            "sphere",
            Light::Sphere(SphereLight::new(sphere, e)),
            |p, w| {
                let c = CENTER - p;
                let inside = c.length() < RADIUS;
                inside || (c.dot(w) > 0.0 && c.cross(w).length() <= RADIUS)
            },
        ),
    ]
}

/// The point where a ray hits the plane z = 1, in units of the edges.
fn at_height_one(p: Vec3, w: Vec3) -> Option<[f32; 2]> {
    let t = (1.0 - p.z) / w.z;
    let q = p + t * w - CORNER;
    (t > 0.0).then_some([q.y / EDGES[0].y, q.x / EDGES[1].x])
}

/// Receivers near, beside, far, grazing, above (behind the flat lights), and inside the sphere.
const RECEIVERS: [Vec3; 7] = [
    Vec3::ZERO,
    Vec3::new(0.1, -0.2, 0.55),
    Vec3::new(2.0, 1.0, 0.0),
    Vec3::new(3.0, -5.0, 2.5),
    Vec3::new(1.5, 0.2, 0.9),
    Vec3::new(0.1, 0.1, 1.7),
    Vec3::new(0.1, -0.1, 0.8),
];

#[test]
fn mean_inverse_pdf_equals_the_solid_angle() {
    // The mean of 1 / pdf over light samples is the solid angle: measured as the share of directions that hit the light.
    for (name, light, meets) in lights(true) {
        for p in RECEIVERS {
            let replicates = |seed: u64, n: u32, f: &dyn Fn(&mut TestRng) -> f64| {
                Moments::of((0..32).map(|replicate| {
                    let mut rng = TestRng::new(seed + replicate);
                    (0..n).map(|_| f(&mut rng)).sum::<f64>() / f64::from(n)
                }))
            };
            let by_light = replicates(0, 1 << 10, &|rng| {
                let s =
                    light.sample::<Everything>(LightSampling::default(), p, 0.0, rng.uniform_2d());
                s.map_or(0.0, |s| 1.0 / f64::from(density(&s)))
            });
            // All lights are within 0.7 of the centre: random directions are restricted to that sphere.
            let to_center = (CENTER - p).length();
            let sin2 = (0.7 / to_center).powi(2).min(1.0);
            let cone = if sin2 < 1.0 {
                1.0 - (1.0 - sin2).sqrt()
            } else {
                2.0
            };
            let frame = Frame::from_normal((CENTER - p) / to_center);
            let by_chance = replicates(100, 1 << 16, &|rng| {
                let w = frame.to_world(sample_cone_uniform(rng.uniform_2d(), cone));
                let omega = 2.0 * std::f64::consts::PI * f64::from(cone);
                if meets(p, w) { omega } else { 0.0 }
            });
            let [a, b] = [by_light, by_chance].map(|m| m.standard_error().expect("32"));
            let (mean, error) = (by_light.mean(), a.hypot(b));
            let what = format!(
                "{name} from {p}: {mean} and {} +- {error}",
                by_chance.mean()
            );
            assert!(
                (mean - by_chance.mean()).abs() <= 5.2 * error + 4e-6 * mean,
                "{what}"
            );
            assert!(error <= 0.01 * mean, "{what}");
        }
    }
}

#[test]
fn light_samples_agree_with_pdf_and_lie_on_the_light() {
    for (name, light, meets) in lights(true) {
        let lights = Lights::new(vec![light], &[1.0]);
        for p in RECEIVERS {
            let mut rng = TestRng::new(5);
            let mut misses = 0;
            let extremes = [0.0, 0.5, ONE_MINUS_EPSILON];
            let corners = extremes
                .into_iter()
                .flat_map(|x| extremes.map(|y| Vec2::new(x, y)));
            let us: Vec<Vec2> = corners.chain((0..2000).map(|_| rng.uniform_2d())).collect();
            for u in us {
                let Some(s) = sampled(&lights, p, [u.x, u.y, 0.5, 0.5]) else {
                    continue;
                };
                let what = format!("{name} from {p} {u}: {s:?}");
                assert!((s.wi.length() - 1.0).abs() < 1e-6, "{what}");
                let s_pdf = density(&s);
                assert!(s_pdf.is_finite() && s_pdf > 0.0, "{what}");
                let point = end_of(&s);
                assert!((point.p - p).normalize().dot(s.wi) > 1.0 - 1e-6, "{what}");
                let pdf = lights.pdf::<Everything>(
                    0,
                    LightChoice::Power,
                    &Receiver::isotropic(p),
                    0.0,
                    point.p - p,
                    point.ng,
                );
                assert!((pdf.0 / s_pdf - 1.0).abs() < 1e-4, "{what} {pdf:?}");
                misses += u32::from(!meets(p, s.wi));
            }
            // Only samples at the rim miss, by rounding; in a grazing view many samples are at the rim.
            assert!(misses <= 20, "{name} from {p}: {misses}");
        }
    }
}

/// A rectangle about the origin, or half of it, with half diagonal 1, and its solid angle from any point.
fn flat_light(rng: &mut TestRng, is_triangle: bool) -> (Light, impl Fn(Vec3) -> f64 + use<>) {
    let (sin, cos) = (std::f32::consts::FRAC_PI_2 * rng.uniform()).sin_cos();
    let edges = [2.0 * cos * Vec3::X, 2.0 * sin * Vec3::Y];
    let corner = -0.5 * (edges[0] + edges[1]);
    let vertices = [corner, corner + edges[0], corner + edges[1]];
    let light = if is_triangle {
        Light::Triangle(TriangleLight::new(vertices, emission(true)))
    } else {
        Light::Rectangle(RectangleLight::new(corner, edges, emission(true)))
    };
    let solid_angle = move |p: Vec3| {
        if is_triangle {
            triangle_solid_angle(vertices.map(|v| v.as_dvec3() - p.as_dvec3()))
        } else {
            let corner = corner.as_dvec3() - p.as_dvec3();
            rectangle_solid_angle(corner, edges.map(|e| e.as_dvec3()))
        }
    };
    (light, solid_angle)
}

/// The mean and relative variance of 1 / pdf, integrated over the random numbers of samples; the density of each sample is
/// also compared with that of `Light::pdf`.
fn over_samples(light: &Light, p: Vec3) -> (f64, f64) {
    let (mut mean, mut mean_square) = (0.0, 0.0);
    let nodes = gauss_legendre(16);
    for (x, weight_x) in &nodes {
        for (y, weight_y) in &nodes {
            let u = Vec2::new((0.5 + 0.5 * x) as f32, (0.5 + 0.5 * y) as f32);
            let s = light
                .sample::<Everything>(LightSampling::default(), p, 0.0, u)
                .expect("off the plane");
            let point = end_of(&s);
            let pdf = light.pdf::<Everything>(p, 0.0, point.p - p, point.ng);
            let ratio = pdf.expect("the light is a surface").0 / density(&s);
            assert!((ratio - 1.0).abs() < 1e-4, "{p} {u} {s:?} {pdf:?}");
            let value = 1.0 / f64::from(density(&s));
            mean += 0.25 * weight_x * weight_y * value;
            mean_square += 0.25 * weight_x * weight_y * value * value;
        }
    }
    (mean, mean_square / (mean * mean) - 1.0)
}

#[test]
fn flat_light_inverse_pdf_integrates_to_the_solid_angle() {
    let mut rng = TestRng::new(20);
    for i in 0..2000 {
        let (light, solid_angle) = flat_light(&mut rng, i % 2 == 0);
        let distance = 10.0_f32.powf(4.0 * rng.uniform() - 1.0);
        let p = distance * rng.direction_log_uniform(0.05);
        let (mean, variance) = over_samples(&light, p);
        let exact = solid_angle(p);
        // The mapping to a triangle has a kink, where the error of the rule is a fraction of the spread.
        let tolerance = 4e-6 + 0.01 * variance.max(0.0).sqrt();
        assert!(
            (mean / exact - 1.0).abs() < tolerance,
            "{p}: {mean} {exact} {variance:e}"
        );
    }
}

#[test]
fn flat_light_inverse_pdf_variance_is_within_stated_bounds() {
    let mut rng = TestRng::new(21);
    let mut mean_variance = |is_triangle: bool, distance: f32| {
        let variances = Moments::of((0..1000).map(|_| {
            let (light, _) = flat_light(&mut rng, is_triangle);
            let (z, turn) = (1.0 - rng.uniform(), rng.uniform() * std::f32::consts::TAU);
            let r = (1.0 - z * z).sqrt();
            let p = distance * Vec3::new(r * turn.cos(), r * turn.sin(), z);
            over_samples(&light, p).1
        }));
        variances.mean()
    };
    // Just inside the limits the variance is zero. The triangles' radii, from their centroids, are up to twice 0.5.
    assert!(mean_variance(false, rectangle::CLEAR * 0.999) < 1e-12);
    assert!(mean_variance(true, triangle::FAR * 0.4) < 1e-11);
    for (is_triangle, distance, stated) in [
        (false, rectangle::CLEAR * 1.001, 0.013),
        (false, 4.0, 0.002),
        (false, 10.0, 0.000_05),
        (false, 1.001 * rectangle::FAR, 0.000_12),
        (true, 1.4 * triangle::FAR, 0.012),
    ] {
        let measured = mean_variance(is_triangle, distance);
        println!("at {distance}: {measured:.2e} of {stated:.2e}");
        assert!(
            measured < stated && measured > 0.1 * stated,
            "{distance}: {measured}"
        );
    }
}

#[test]
fn sphere_cone_solid_angle_is_accurate_for_small_spheres() {
    for ratio in [0.5, 1e-2, 1e-3, 2.4e-4, 1e-4, 1e-6] {
        let distance = 3.0_f32;
        let radius = ratio * distance;
        let light = SphereLight::new(Sphere::new(distance * Vec3::Y, radius), emission(false));
        let s2 = (f64::from(radius) / f64::from(distance)).powi(2);
        let exact = 2.0 * std::f64::consts::PI * s2 / (1.0 + (1.0 - s2).sqrt());
        let omega = 1.0 / f64::from(light.pdf(Vec3::ZERO, -1.0).0);
        assert!(
            (omega / exact - 1.0).abs() < 4e-7,
            "R / d = {ratio}: {omega:e} {exact:e}"
        );
        // Sampled points face the receiver.
        let mut rng = TestRng::new(8);
        for _ in 0..1000 {
            let s = light.sample(Vec3::ZERO, rng.uniform_2d()).expect("outside");
            assert!(s.wi.dot(end_of(&s).ng) <= 1e-3, "{ratio} {s:?}");
        }
    }
}

#[test]
fn one_sided_lights_are_dark_from_behind() {
    for (name, light, _) in lights(false) {
        let mut rng = TestRng::new(9);
        for (p, lit) in [
            (Vec3::ZERO, true),
            (Vec3::new(0.1, 0.2, 3.0), name == "sphere"),
        ] {
            for _ in 0..100 {
                let s = light
                    .sample::<Everything>(LightSampling::default(), p, 0.0, rng.uniform_2d())
                    .expect("off the plane");
                assert_eq!(!s.radiance.is_black(), lit, "{name} {p} {s:?}");
            }
        }
        // Only a two-sided sphere emits to its inside.
        if name == "sphere" {
            let s = light
                .sample::<Everything>(LightSampling::default(), CENTER, 0.0, Vec2::splat(0.3))
                .expect("inside");
            assert!(s.radiance.is_black());
        }
    }
    for (name, light, _) in lights(true) {
        for p in [
            Vec3::ZERO,
            Vec3::new(0.1, 0.2, 3.0),
            Vec3::new(0.1, 0.0, 0.9),
        ] {
            let s = light
                .sample::<Everything>(LightSampling::default(), p, 0.0, Vec2::splat(0.3))
                .expect("off the plane");
            assert!(!s.radiance.is_black(), "{name} {p}");
        }
    }
}

#[test]
fn light_power_equals_pi_times_area_times_radiance() {
    let area = f64::from(RADIUS * RADIUS) * std::f64::consts::PI;
    for ((name, one, _), (_, two, _)) in lights(false).iter().zip(&lights(true)) {
        let expected = match *name {
            "triangle" => 0.4,
            "rectangle" => 0.8,
            "disk" => area,
            _ => 4.0 * area,
        } * std::f64::consts::PI;
        assert!(
            (one.power(1.0) / expected - 1.0).abs() < 1e-6,
            "{name} {}",
            one.power(1.0)
        );
        assert_eq!(two.power(1.0), 2.0 * one.power(1.0), "{name}");
    }
}

#[test]
fn lights_are_chosen_by_power() {
    // The spheres are far apart, so that the direction identifies the chosen one; every third is black.
    let brightness = |i: usize| if i % 3 == 2 { 0.0 } else { (1 + i) as f32 };
    let sphere = |i: usize| {
        let angle = i as f32 * std::f32::consts::TAU / 30.0;
        let center = 10.0 * Vec3::new(angle.cos(), angle.sin(), 0.0);
        let radiance = Rgb::grey(brightness(i));
        let emission = Emission {
            radiance,
            two_sided: false,
        };
        Light::Sphere(SphereLight::new(Sphere::new(center, 0.1), emission))
    };
    let lights = by_power((0..30).map(sphere).collect());
    let total: f64 = (0..30).map(|i| f64::from(brightness(i))).sum();
    let n = 1 << 16;
    let mut cells: Vec<_> = (0..30)
        .map(|i| (f64::from(n) * f64::from(brightness(i)) / total, 0.0))
        .collect();
    let mut rng = TestRng::new(10);
    for _ in 0..n {
        let (a, b) = (rng.uniform_2d(), rng.uniform_2d());
        let s = sampled(&lights, Vec3::ZERO, [a.x, a.y, b.x, b.y]).expect("outside");
        let angle = s.wi.y.atan2(s.wi.x) * 30.0 / std::f32::consts::TAU;
        let chosen = (angle.round() as i32).rem_euclid(30) as usize;
        assert!(!s.radiance.is_black());
        cells[chosen].1 += 1.0;
    }
    assert!(pearson(&mut cells) > 1e-3);
    // The density of a light that is never chosen is 0.
    let towards = 10.0 * Vec3::X;
    assert_eq!(
        lights
            .pdf::<Everything>(
                2,
                LightChoice::Power,
                &Receiver::isotropic(Vec3::ZERO),
                0.0,
                towards,
                -Vec3::X
            )
            .0,
        0.0
    );
    // No lights, and black lights only.
    assert!(by_power(vec![]).is_empty() && by_power(vec![sphere(2)]).is_empty());
    assert!(sampled(&by_power(vec![sphere(2)]), Vec3::ZERO, [0.5; 4]).is_none());
}

/// A million emitters: one of them lights the origin, the others have zero weight, a denormal weight, or no area.
#[test]
fn sampling_ignores_a_million_lights_of_negligible_power() {
    let flat = TriangleLight::new([CORNER; 3], emission(false));
    let whole = TriangleLight::new(
        [CORNER, CORNER + EDGES[0], CORNER + EDGES[1]],
        emission(false),
    );
    let count = 1_000_000;
    let shining = 654_321;
    let mut all = vec![Light::Triangle(flat); count];
    all[shining] = Light::Triangle(whole);
    let mut powers: Vec<f64> = all.iter().map(|light| light.power(1.0)).collect();
    assert_eq!(powers[0], 0.0);
    for i in (0..count).filter(|i| i % 3 == 0 && *i != shining) {
        powers[i] = [5e-324, 1e-310, f64::from(f32::MIN_POSITIVE) * 1e-3][i % 9 / 3];
    }
    let lights = Lights::new(all, &powers);
    let single = by_power(vec![Light::Triangle(whole)]);
    let mut rng = TestRng::new(12);
    let ends = [0.0, ONE_MINUS_EPSILON];
    let choices = ends.into_iter().flat_map(|x| ends.map(|y| Vec2::new(x, y)));
    let choices: Vec<Vec2> = choices
        .chain((0..100_000).map(|_| rng.uniform_2d()))
        .collect();
    for choice in choices {
        let u = [0.3, 0.6, choice.x, choice.y];
        let s = sampled(&lights, Vec3::ZERO, u).expect("it shines");
        let alone = sampled(&single, Vec3::ZERO, u).expect("it shines");
        let light = lights.choose_by_power::<Everything>([choice.x, choice.y]);
        assert_eq!(light.map(|(light, _)| light as usize), Some(shining));
        assert_eq!(
            (s.wi, s.radiance, s.pdf),
            (alone.wi, alone.radiance, alone.pdf)
        );
    }
}

/// A million emitters of the same power, all but one facing away from the origin: the mean over all choices is exact.
#[test]
fn one_visible_light_among_a_million_has_the_exact_mean() {
    let towards = [CORNER, CORNER + EDGES[0], CORNER + EDGES[1]];
    let away = [CORNER, CORNER + EDGES[1], CORNER + EDGES[0]];
    let count = 1_000_000;
    let mut all = vec![Light::Triangle(TriangleLight::new(away, emission(false))); count];
    all[271_828] = Light::Triangle(TriangleLight::new(towards, emission(false)));
    let single = by_power(vec![all[271_828].clone()]);
    let lights = by_power(all);
    let estimate = |s: LightSample| f64::from(s.radiance.luminance() / density(&s));
    let mean = (0..count).map(|i| {
        let x = (i as f64 + 0.5) / count as f64 * 16_777_216.0;
        let digits = [x.floor(), (x.fract() * 16_777_216.0).floor()];
        let [a, b] = digits.map(|d| (d / 16_777_216.0) as f32);
        sampled(&lights, Vec3::ZERO, [0.3, 0.6, a, b]).map_or(0.0, estimate) / count as f64
    });
    let mean: f64 = mean.sum();
    let exact = sampled(&single, Vec3::ZERO, [0.3, 0.6, 0.5, 0.5]).map_or(0.0, estimate);
    assert!(
        exact > 0.0 && (mean / exact - 1.0).abs() < 1e-6,
        "{mean} {exact}"
    );
}

#[test]
fn alias_table_pmf_of_a_million_weights_sums_to_one() {
    let mut rng = TestRng::new(13);
    let weights: Vec<f64> = (0..1_000_000)
        .map(|i| match i % 4 {
            0 => 0.0,
            1 => 1e-320,
            _ => f64::from(rng.uniform()).powi(8),
        })
        .collect();
    let table = AliasTable::new(&weights).expect("valid weights");
    let sum: f64 = (0..weights.len()).map(|i| f64::from(table.pmf(i).0)).sum();
    assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    for _ in 0..1_000_000 {
        let (item, pmf) = table.sample(rng.uniform_2d().to_array());
        assert!(item % 4 > 1 && pmf.0 >= f32::MIN_POSITIVE, "{item} {pmf:?}");
    }
}
