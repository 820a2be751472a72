//! Flat lights sampled in proportion to the cosine at the receiver: the density, against Lambert's formula and by
//! chi-square, and the variance that is left.

use crate::common::TestRng;
use crate::common::chi_square::pearson;
use crate::common::closed_forms::lambert_polygon;
use crate::common::quadrature::gauss_legendre;
use crate::common::verdict::sidak;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::light::Light;
use etendue::internals::light::rectangle::RectangleLight;
use etendue::internals::light::select::Lights;
use etendue::internals::light::triangle::TriangleLight;
use etendue::internals::light::types::{
    Emission, LightChoice, LightSample, LightSampling, Receiver, ShadowRayEnd,
};
use etendue::internals::math::frame::Frame;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{DVec3, Vec2, Vec3};
use std::f64::consts::PI;

const EMISSION: Emission = Emission {
    radiance: Rgb::WHITE,
    two_sided: true,
};

/// A flat light, and its corners in order.
struct Flat {
    light: Light,
    corners: Vec<Vec3>,
}

impl Flat {
    /// The rectangle with these half edges about a point of the plane z = 0, or half of it.
    fn new(center: Vec3, [x, y]: [f32; 2], is_triangle: bool) -> Self {
        let edges = [2.0 * x * Vec3::X, 2.0 * y * Vec3::Y];
        let corner = center - 0.5 * (edges[0] + edges[1]);
        let [a, b, c] = [corner, corner + edges[0], corner + edges[1]];
        if is_triangle {
            Self {
                light: Light::Triangle(TriangleLight::new([a, b, c], EMISSION)),
                corners: vec![a, b, c],
            }
        } else {
            Self {
                light: Light::Rectangle(RectangleLight::new(corner, edges, EMISSION)),
                corners: vec![a, b, b + edges[1], c],
            }
        }
    }

    /// A light about the origin with half diagonal 1, of any shape.
    fn random(rng: &mut TestRng) -> Self {
        let (sin, cos) = (std::f32::consts::FRAC_PI_2 * rng.uniform()).sin_cos();
        let is_triangle = rng.uniform() < 0.5;
        Self::new(Vec3::ZERO, [cos, sin], is_triangle)
    }

    fn sample(&self, receiver: &Receiver, u: Vec2) -> Option<LightSample> {
        let rules = LightSampling::default();
        self.light.sample::<Everything>(rules, receiver, 0.0, u)
    }

    /// The density at the point at `towards` from a receiver.
    fn pdf(&self, receiver: &Receiver, towards: Vec3) -> f64 {
        let pdf = self
            .light
            .pdf::<Everything>(receiver, 0.0, towards, Vec3::Z);
        f64::from(pdf.expect("the light is a surface").0)
    }

    /// The integral of the cosine over the visible part of the light.
    fn projected_solid_angle(&self, receiver: &Receiver) -> f64 {
        let frame = Frame::from_normal(receiver.normal);
        let seen = self.corners.iter().map(|corner| {
            let [x, y, z] = [frame.s, frame.t, frame.n].map(|axis| {
                axis.as_dvec3()
                    .dot(corner.as_dvec3() - receiver.p.as_dvec3())
            });
            DVec3::new(x, y, z)
        });
        PI * lambert_polygon(&seen.collect::<Vec<_>>())
    }
}

fn density(sample: &LightSample) -> f64 {
    f64::from(sample.pdf.expect("no delta light").0)
}

fn end_of(sample: &LightSample) -> Vec3 {
    match sample.end {
        ShadowRayEnd::Surface(point, _) => point.p,
        ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => panic!("the light is a shape"),
    }
}

/// A unit vector in a uniform direction.
fn direction(rng: &mut TestRng) -> Vec3 {
    let z = 2.0 * rng.uniform() - 1.0;
    let (sin, cos) = (std::f32::consts::TAU * rng.uniform()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

/// The mean and the relative variance of max(cos, 0) / pdf for a receiver with this normal, integrated over the random
/// numbers of samples taken `by` a receiver; the density of each sample is also compared with that of `Light::pdf`.
fn over_samples(flat: &Flat, normal: Vec3, by: &Receiver) -> (f64, f64) {
    let (mut mean, mut mean_square) = (0.0, 0.0);
    let nodes = gauss_legendre(24);
    for (x, weight_x) in &nodes {
        for (y, weight_y) in &nodes {
            let u = Vec2::new((0.5 + 0.5 * x) as f32, (0.5 + 0.5 * y) as f32);
            let sample = flat.sample(by, u).expect("off the plane");
            let pdf = flat.pdf(by, end_of(&sample) - by.p);
            let ratio = pdf / density(&sample);
            assert!((ratio - 1.0).abs() < 2e-3, "{by:?} {u} {sample:?} {pdf:?}");
            let value = f64::from(sample.wi.dot(normal)).max(0.0) / density(&sample);
            mean += 0.25 * weight_x * weight_y * value;
            mean_square += 0.25 * weight_x * weight_y * value * value;
        }
    }
    (mean, mean_square / (mean * mean) - 1.0)
}

#[test]
fn densities_with_a_normal_give_the_projected_solid_angle() {
    let mut rng = TestRng::new(30);
    let mut clear = 0;
    for _ in 0..3000 {
        let flat = Flat::random(&mut rng);
        let distance = 10.0_f32.powf(4.0 * rng.uniform() - 1.0);
        let p = distance * rng.direction_log_uniform(0.05);
        let at = Receiver {
            p,
            normal: direction(&mut rng),
        };
        let exact = flat.projected_solid_angle(&at);
        let above = |corner: &Vec3| (*corner - p).normalize().dot(at.normal) > 0.05;
        if !flat.corners.iter().all(above) {
            continue;
        }
        clear += 1;
        let (mean, variance) = over_samples(&flat, at.normal, &at);
        // The mapping to a triangle has a kink, where the error of the rule is a fraction of the spread.
        let tolerance = 2e-5 + 0.01 * variance.max(0.0).sqrt();
        assert!(
            (mean / exact - 1.0).abs() < tolerance,
            "{at:?}: {mean} {exact} {variance:e}"
        );
    }
    assert!(clear > 1000, "{clear}");
}

#[test]
fn hits_have_the_density_of_samples() {
    let mut rng = TestRng::new(34);
    for _ in 0..3000 {
        let flat = Flat::random(&mut rng);
        let distance = 10.0_f32.powf(3.0 * rng.uniform() - 1.0);
        let p = distance * rng.direction_log_uniform(0.05);
        let normal = direction(&mut rng);
        let at = Receiver { p, normal };
        let lights = Lights::new(vec![flat.light.clone()], &[1.0]);
        for _ in 0..8 {
            let sample = flat.sample(&at, rng.uniform_2d()).expect("off the plane");
            let (choice, towards) = (LightChoice::default(), end_of(&sample) - p);
            let pdf = lights.pdf::<Everything>(0, choice, &at, 0.0, towards, Vec3::Z);
            let ratio = f64::from(pdf.0) / density(&sample);
            assert!((ratio - 1.0).abs() < 2e-3, "{at:?} {sample:?} {pdf:?}");
        }
    }
}

#[test]
fn lights_that_cross_the_horizon_give_the_projected_solid_angle() {
    let mut rng = TestRng::new(31);
    let mut sums = Moments::default();
    for _ in 0..200 {
        let flat = Flat::random(&mut rng);
        let distance = 10.0_f32.powf(2.0 * rng.uniform() - 1.0);
        let p = distance * rng.direction_log_uniform(0.05);
        // The horizon goes through a point of the light.
        let on_light = flat.corners[0] + rng.uniform() * (flat.corners[2] - flat.corners[0]);
        let normal = (on_light - p).cross(direction(&mut rng)).normalize();
        let at = Receiver { p, normal };
        let exact = flat.projected_solid_angle(&at);
        let estimates = Moments::of((0..4096).map(|_| {
            let sample = flat.sample(&at, rng.uniform_2d()).expect("off the plane");
            f64::from(sample.wi.dot(normal)).max(0.0) / density(&sample)
        }));
        let error = estimates.standard_error().expect("many");
        let deviation = (estimates.mean() - exact) / error.max(1e-5 * exact);
        assert!(deviation.abs() < 5.5, "{at:?}: {deviation}");
        sums.push(deviation);
    }
    assert!(sums.mean().abs() < 0.3, "{}", sums.mean());
}

/// The p-value of samples counted in cells of the sphere about the receiver, whose densities are integrated there: for lights
/// that subtend a large angle.
fn by_direction(flat: &Flat, at: &Receiver, seed: u64) -> f64 {
    const CELLS: usize = 12;
    const POINTS: usize = 24;
    let down = -at.p.z.signum();
    let mut cells = vec![(0.0, 0.0); CELLS * CELLS];
    let count = 1 << 16;
    let area = 2.0 * PI / (CELLS * POINTS).pow(2) as f64;
    for i in 0..(CELLS * POINTS).pow(2) {
        let [a, b] = [i / (CELLS * POINTS), i % (CELLS * POINTS)];
        let [x, y] = [a, b].map(|k| (k as f64 + 0.5) / (CELLS * POINTS) as f64);
        let (sin, cos) = (2.0 * PI * y).sin_cos();
        let r = (1.0 - x * x).sqrt();
        // In the plane of the light; receivers are next to the origin.
        let t = f64::from(at.p.z.abs()) / x;
        let point = [
            f64::from(at.p.x) + t * r * cos,
            f64::from(at.p.y) + t * r * sin,
        ];
        let [edge_x, edge_y] = [flat.corners[1].x, flat.corners[2].y].map(|x| f64::from(x.abs()));
        if point[0].abs() < edge_x && point[1].abs() < edge_y {
            let towards = Vec3::new((t * r * cos) as f32, (t * r * sin) as f32, -at.p.z);
            let expected = f64::from(count) * area * flat.pdf(at, towards);
            cells[CELLS * (a / POINTS) + b / POINTS].0 += expected;
        }
    }
    let mut rng = TestRng::new(seed);
    for _ in 0..count {
        let Some(sample) = flat.sample(at, rng.uniform_2d()) else {
            continue;
        };
        let towards = end_of(&sample) - at.p;
        let x = (towards.normalize().z * down).clamp(0.0, 1.0);
        let y = (towards.y.atan2(towards.x) / std::f32::consts::TAU).rem_euclid(1.0);
        let [a, b] = [x, y].map(|x| ((CELLS as f32 * x) as usize).min(CELLS - 1));
        cells[CELLS * a + b].1 += 1.0;
    }
    pearson(&mut cells)
}

/// The p-value of samples counted in cells of a rectangle, whose densities per area are integrated there.
fn by_area(flat: &Flat, at: &Receiver, seed: u64) -> f64 {
    const CELLS: usize = 10;
    const POINTS: usize = 8;
    let mut cells = vec![(0.0, 0.0); CELLS * CELLS];
    let count = 1 << 16;
    let [a, b, _, c] = flat.corners[..] else {
        panic!("a rectangle has four corners");
    };
    let area = f64::from((b - a).length() * (c - a).length()) / (CELLS * POINTS).pow(2) as f64;
    for i in 0..(CELLS * POINTS).pow(2) {
        let [k, l] = [i / (CELLS * POINTS), i % (CELLS * POINTS)];
        let [x, y] = [k, l].map(|k| (k as f32 + 0.5) / (CELLS * POINTS) as f32);
        let towards = a + x * (b - a) + y * (c - a) - at.p;
        let distance2 = f64::from(towards.x).powi(2)
            + f64::from(towards.y).powi(2)
            + f64::from(towards.z).powi(2);
        let cos = f64::from(towards.z.abs()) / distance2.sqrt();
        let expected = f64::from(count) * area * flat.pdf(at, towards) * cos / distance2;
        cells[CELLS * (k / POINTS) + l / POINTS].0 += expected;
    }
    let mut rng = TestRng::new(seed);
    for _ in 0..count {
        let sample = flat.sample(at, rng.uniform_2d()).expect("off the plane");
        let from_corner = end_of(&sample) - a;
        let [x, y] = [b - a, c - a].map(|edge| from_corner.dot(edge) / edge.length_squared());
        let [k, l] = [x, y].map(|x| ((CELLS as f32 * x) as usize).min(CELLS - 1));
        cells[CELLS * k + l].1 += 1.0;
    }
    pearson(&mut cells)
}

#[test]
fn samples_follow_their_density_from_near_and_far() {
    let mut rng = TestRng::new(32);
    let mut checks = Vec::new();
    for seed in 0..12 {
        let at = |rng: &mut TestRng, p: Vec3| {
            let normal = match seed % 3 {
                0 => Vec3::ZERO,
                _ => direction(rng),
            };
            Receiver { p, normal }
        };
        let flat = Flat::new(Vec3::ZERO, [0.8, 0.6], false);
        for distance in [1e-5, 1e-3, 0.3] {
            let at = at(&mut rng, distance * Vec3::new(0.2, 0.5, 1.0));
            checks.push((at, by_direction(&flat, &at, seed)));
        }
        for distance in [1.5, 2.6, 5.0, 1e2, 1e4, 1e8] {
            let p = distance * rng.direction_log_uniform(0.2);
            let at = at(&mut rng, p);
            checks.push((at, by_area(&flat, &at, seed)));
        }
    }
    for (at, p) in &checks {
        assert!(*p > sidak(1e-3, checks.len()), "{at:?}: {p:.1e}");
    }
}

#[test]
fn a_normal_takes_most_of_the_variance_of_the_cosine() {
    let mut rng = TestRng::new(33);
    for (distance, is_triangle, uniform, weighted) in [
        (1.2, false, 0.12, 0.03),
        (3.0, false, 0.02, 0.006),
        (10.0, false, 0.0025, 0.0006),
        (1.2, true, 0.07, 0.02),
    ] {
        let [mut without, mut with] = [Moments::default(); 2];
        for _ in 0..1000 {
            let (sin, cos) = (std::f32::consts::FRAC_PI_2 * rng.uniform()).sin_cos();
            let flat = Flat::new(Vec3::ZERO, [cos, sin], is_triangle);
            let p = distance * direction(&mut rng);
            let normal = direction(&mut rng);
            let above = |corner: &Vec3| (*corner - p).normalize().dot(normal) > 0.2;
            if p.z.abs() < 0.1 || !flat.corners.iter().all(above) {
                continue;
            }
            without.push(over_samples(&flat, normal, &Receiver::anywhere(p)).1);
            with.push(over_samples(&flat, normal, &Receiver { p, normal }).1);
        }
        let (without, with) = (without.mean(), with.mean());
        println!("at {distance}, triangle {is_triangle}: {without:.1e} to {with:.1e}");
        assert!(
            without > uniform && with < weighted,
            "{distance} {is_triangle}: {without:.1e} {with:.1e}"
        );
    }
}
