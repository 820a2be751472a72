//! The selection of lights by what each would contribute: its probabilities, and that no light that shines is left out.

use crate::common::TestRng;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::{disk::Disk, sphere::Sphere};
use etendue::internals::light::disk::DiskLight;
use etendue::internals::light::distant::DistantLight;
use etendue::internals::light::lanes::LightContextLanes;
use etendue::internals::light::moving::MovingTriangle;
use etendue::internals::light::point::PointLight;
use etendue::internals::light::rectangle::RectangleLight;
use etendue::internals::light::select::Lights;
use etendue::internals::light::sphere::SphereLight;
use etendue::internals::light::spot::SpotLight;
use etendue::internals::light::triangle::TriangleLight;
use etendue::internals::light::types::{Emission, LightChoice, LightSampling, Receiver};
use etendue::internals::light::{Light, tree::LightTree};
use etendue::internals::math::lanes::{ActiveLanes, LANES, Lanes3, store};
use etendue::internals::math::measure::Pmf;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec3;

const BY: LightChoice = LightChoice::Contribution;

fn selection(lights: Vec<Light>) -> Lights {
    let powers: Vec<f64> = lights.iter().map(|light| light.power(1.0)).collect();
    Lights::new(lights, &powers)
}

fn direction(rng: &mut TestRng) -> Vec3 {
    rng.direction_log_uniform(1e-3)
}

/// A point of a box, near some places more often than elsewhere.
fn place(rng: &mut TestRng) -> Vec3 {
    let [a, b] = [rng.uniform_2d(), rng.uniform_2d()];
    let spread = 10.0_f32.powf(-3.0 * b.y);
    let center = Vec3::new(b.x, (7.0 * b.x).fract(), (13.0 * b.x).fract());
    center + spread * (Vec3::new(a.x, a.y, b.x) - 0.5)
}

/// A light of any kind and of any size from 1e-4 on.
fn light(rng: &mut TestRng) -> Light {
    let (p, size) = (place(rng), 10.0_f32.powf(-4.0 * rng.uniform()));
    let [u, v] = [direction(rng), direction(rng)];
    let radiance = Rgb::grey(10.0_f32.powf(2.0 - 4.0 * rng.uniform()));
    let emission = Emission {
        radiance,
        two_sided: rng.uniform() < 0.2,
    };
    match (8.0 * rng.uniform()) as u32 {
        0 => Light::Sphere(SphereLight::new(Sphere::new(p, size), emission)),
        1 => Light::Disk(DiskLight::new(Disk::new(p, u, size), emission)),
        2 => Light::Point(PointLight::new(p, size * radiance)),
        3 => {
            let (cone, penumbra) = (3.0 * f64::from(rng.uniform()) + 0.02, 0.01);
            Light::Spot(SpotLight::new(p, u, size * radiance, cone, penumbra))
        }
        4 => {
            let edge = u.cross(v).normalize() * 0.3;
            let edges = [size * u, size * edge];
            Light::Rectangle(RectangleLight::new(p, edges, emission))
        }
        5 => {
            let moved = |t: f32| [p, p + size * u, p + size * v].map(|p| p + t * 0.1 * v);
            Light::MovingTriangle(MovingTriangle::new(vec![moved(0.0), moved(1.0)], emission))
        }
        _ => Light::Triangle(TriangleLight::new(
            [p, p + size * u, p + size * v],
            emission,
        )),
    }
}

/// Lights of all kinds, with one at infinity.
fn lights(count: usize, rng: &mut TestRng) -> Vec<Light> {
    let mut lights: Vec<Light> = (1..count).map(|_| light(rng)).collect();
    let distant = DistantLight::new(direction(rng), Rgb::grey(0.1));
    lights.push(Light::Distant(distant));
    lights
}

/// A receiver among the lights or far from them, with a normal or without.
fn receiver(rng: &mut TestRng) -> Receiver {
    let far = if rng.uniform() < 0.2 { 100.0 } else { 1.0 };
    let normal = direction(rng);
    let has_sides = rng.uniform() < 0.8;
    Receiver {
        p: far * place(rng),
        normal: if has_sides { normal } else { Vec3::ZERO },
    }
}

#[test]
fn light_pmf_is_normalized_and_agrees_with_selection() {
    let mut rng = TestRng::new(81);
    for count in [2, 5, 16, 17, 300] {
        let lights = selection(lights(count, &mut rng));
        for _ in 0..100 {
            let at = receiver(&mut rng);
            let pmf = |light| lights.pmf::<Everything>(light, BY, &at).0;
            let sum: f64 = (0..count as u32).map(|light| f64::from(pmf(light))).sum();
            let tries = 4000;
            let mut none = 0;
            for i in 0..tries {
                let x = (f64::from(i) + 0.5) / f64::from(tries);
                match lights.choose::<Everything>(BY, &at, [x as f32, rng.uniform()]) {
                    Some((light, Pmf(chosen))) => {
                        let error = (chosen / pmf(light) - 1.0).abs();
                        assert!(error < 1e-6, "{count}: {chosen} {}", pmf(light));
                    }
                    None => none += 1,
                }
            }
            // Each of few intervals of the random number without a light is counted to one try.
            let nothing = f64::from(none) / f64::from(tries);
            assert!(
                (sum + nothing - 1.0).abs() < 0.01,
                "{count}: {sum} {nothing}"
            );
            if count <= 16 {
                assert!((sum - 1.0).abs() < 1e-5 || sum == 0.0, "{count}: {sum}");
            }
        }
    }
}

#[test]
fn light_selection_frequencies_match_their_pmf() {
    let mut rng = TestRng::new(82);
    let lights = selection(lights(200, &mut rng));
    for _ in 0..5 {
        let at = receiver(&mut rng);
        let tries = 1 << 18;
        let mut counts = [0_u32; 200];
        for _ in 0..tries {
            let u = rng.uniform_2d().to_array();
            if let Some((light, _)) = lights.choose::<Everything>(BY, &at, u) {
                counts[light as usize] += 1;
            }
        }
        for (light, count) in (0..).zip(counts) {
            let expected = f64::from(tries) * f64::from(lights.pmf::<Everything>(light, BY, &at).0);
            // Six standard deviations of a Poisson number, or six counts.
            let limit = 6.0 * expected.sqrt() + 6.0;
            assert!(
                (f64::from(count) - expected).abs() < limit,
                "{count} {expected}"
            );
        }
    }
}

#[test]
fn contributing_lights_have_positive_selection_probability() {
    let mut rng = TestRng::new(83);
    let mut shining = 0;
    for count in [16, 400] {
        let lights = selection(lights(count, &mut rng));
        for _ in 0..300 {
            let at = receiver(&mut rng);
            for light in 0..count as u32 {
                let certain = (light, Pmf(1.0));
                let shines = (0..4).any(|_| {
                    let (u, rules) = (rng.uniform_2d(), LightSampling::default());
                    let sample =
                        lights.sample::<Everything>(certain, rules, at.p, rng.uniform(), u);
                    sample.is_some_and(|it| {
                        let is_above = at.normal == Vec3::ZERO || it.wi.dot(at.normal) > 0.0;
                        is_above && !it.radiance.is_black()
                    })
                });
                shining += u32::from(shines);
                let pmf = lights.pmf::<Everything>(light, BY, &at);
                assert!(!shines || pmf.0 > 0.0, "{at:?} {:?}", lights.get(light));
            }
        }
    }
    assert!(shining > 30_000, "{shining}");
}

#[test]
fn point_lights_are_selected_in_proportion_to_their_irradiance() {
    let mut rng = TestRng::new(84);
    let points: Vec<(Vec3, f32)> = (0..16)
        .map(|_| (2.0 * place(&mut rng) - 1.0, 0.1 + rng.uniform()))
        .collect();
    let point = |&(p, intensity)| Light::Point(PointLight::new(p, Rgb::grey(intensity)));
    let lights = selection(points.iter().map(point).collect());
    for _ in 0..200 {
        let at = receiver(&mut rng);
        let irradiance = |&(p, intensity): &(Vec3, f32)| {
            let towards = p - at.p;
            let cos = towards.dot(at.normal) / towards.length();
            let cos = if at.normal == Vec3::ZERO { 1.0 } else { cos };
            f64::from(intensity * cos.max(0.0) / towards.length_squared())
        };
        let sum: f64 = points.iter().map(irradiance).sum();
        if sum == 0.0 {
            continue;
        }
        for (light, point) in (0..).zip(&points) {
            let pmf = f64::from(lights.pmf::<Everything>(light, BY, &at).0);
            let exact = irradiance(point) / sum;
            // Grazing light is selected a little more often than in proportion.
            assert!((pmf - exact).abs() < 1e-3, "{pmf} {exact}");
        }
    }
}

#[test]
fn light_selection_in_lanes_is_identical_to_scalar_selection() {
    let mut rng = TestRng::new(85);
    for count in [2, 7, 16, 100] {
        let lights = selection(lights(count, &mut rng));
        for _ in 0..50 {
            let mut context = LightContextLanes::default();
            let mut lanes = Receiver::<Lanes3>::default();
            let mut single = Vec::new();
            for lane in 0..LANES {
                let at = receiver(&mut rng);
                store(&mut lanes.p, lane, at.p);
                store(&mut lanes.normal, lane, at.normal);
                let u = rng.uniform_2d();
                (context.u[2][lane], context.u[3][lane]) = (u.x, u.y);
                single.push(lights.choose::<Everything>(BY, &at, u.to_array()));
            }
            let active = ActiveLanes::first(LANES);
            lights.choose_lanes::<Everything>(BY, &active, &lanes, &mut context);
            for (lane, single) in single.into_iter().enumerate() {
                let pmf = context.pmf[lane];
                let chosen = (pmf > 0.0).then_some((context.light[lane], Pmf(pmf)));
                assert_eq!(chosen, single, "{count}");
            }
        }
    }
}

/// All but one of many emitters face away, or have no power beside it.
#[test]
fn only_the_contributing_light_of_10000_is_selected() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| 0.01 * p);
    let facing = |i: usize, towards: bool| {
        let corner = Vec3::new(0.1 * (i % 100) as f32, 0.1 * (i / 100) as f32, 1.0);
        let [a, b, c] = corners.map(|p| p + corner);
        let vertices = if towards { [a, c, b] } else { [a, b, c] };
        let emission = Emission {
            radiance: Rgb::WHITE,
            two_sided: false,
        };
        Light::Triangle(TriangleLight::new(vertices, emission))
    };
    let at = Receiver::isotropic(Vec3::new(5.0, 5.0, 0.0));
    let lights = selection((0..10_000).map(|i| facing(i, i == 4321)).collect());
    let dim = (0..10_000).map(|i| facing(i, true)).collect();
    let powers: Vec<f64> = (0..10_000)
        .map(|i| if i == 4321 { 1.0 } else { 5e-324 })
        .collect();
    for lights in [lights, Lights::new(dim, &powers)] {
        let mut rng = TestRng::new(86);
        let (tries, expected) = (10_000, lights.pmf::<Everything>(4321, BY, &at));
        let mut found = 0;
        for _ in 0..tries {
            let chosen = lights.choose::<Everything>(BY, &at, rng.uniform_2d().to_array());
            if let Some((light, pmf)) = chosen {
                assert_eq!((light, pmf), (4321, expected));
                found += 1;
            }
        }
        let share = f64::from(found) / f64::from(tries);
        assert!(
            share > 0.0 && (share - f64::from(expected.0)).abs() < 0.03,
            "{share}"
        );
    }
}

#[test]
fn light_tree_uses_less_than_100_bytes_per_light() {
    let mut rng = TestRng::new(87);
    for count in [100, 1000, 30_000] {
        let lights = lights(count, &mut rng);
        let powers: Vec<f64> = lights.iter().map(|light| light.power(1.0)).collect();
        let tree = LightTree::new(&lights, &powers).expect("they shine");
        let [in_tree, nodes, bytes] = tree.size();
        println!("{count}: {nodes} nodes, {} bytes a light", bytes / count);
        assert_eq!(in_tree, count);
        assert!(bytes < 100 * count, "{count}: {bytes}");
    }
}

/// Lights at the same place, and lights without an extent, can be told apart by nothing.
#[test]
fn coincident_lights_have_similar_selection_probabilities() {
    let point = Light::Point(PointLight::new(Vec3::ONE, Rgb::WHITE));
    let lights = selection(vec![point; 1000]);
    for p in [Vec3::ZERO, Vec3::ONE, Vec3::splat(1e20)] {
        let at = Receiver::isotropic(p);
        for light in [0, 17, 999] {
            let pmf = f64::from(lights.pmf::<Everything>(light, BY, &at).0);
            // Beyond the range of squared distances, groups count alike, of however many lights.
            assert!((pmf * 1000.0 - 1.0).abs() < 0.4, "{p}: {pmf}");
        }
    }
}
