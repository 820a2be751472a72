//! Light samples taken for many reference points at once are those of each point alone, bit for bit.

use crate::common::TestRng;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::geometry::sphere::Sphere;
use etendue::internals::light::Light;
use etendue::internals::light::lanes::{LightContextLanes, LightSampleLanes};
use etendue::internals::light::point::PointLight;
use etendue::internals::light::rectangle::RectangleLight;
use etendue::internals::light::select::{LightLanes, Lights};
use etendue::internals::light::sphere::SphereLight;
use etendue::internals::light::triangle::TriangleLight;
use etendue::internals::light::types::{Emission, LightSample, LightSampling, ShadowRayEnd};
use etendue::internals::math::lanes::{ActiveLanes, LANES, load, store};
use etendue::internals::math::measure::Pmf;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{Vec2, Vec3};

const EDGES: [Vec3; 2] = [Vec3::new(0.0, 0.8, 0.0), Vec3::new(1.0, 0.0, 0.0)];

/// The selection of lights by their powers.
fn lights(lights: Vec<Light>) -> Lights {
    let powers: Vec<f64> = lights.iter().map(|light| light.power(1.0)).collect();
    Lights::new(lights, &powers)
}

fn rectangle(corner: Vec3, two_sided: bool) -> Light {
    let radiance = Rgb::new(1.0, 0.5, 0.25);
    let emission = Emission {
        radiance,
        two_sided,
    };
    Light::Rectangle(RectangleLight::new(corner, EDGES, emission))
}

fn triangle(corner: Vec3, two_sided: bool) -> Light {
    let radiance = Rgb::new(0.5, 1.0, 0.25);
    let emission = Emission {
        radiance,
        two_sided,
    };
    let vertices = [corner, corner + EDGES[0], corner + EDGES[1]];
    Light::Triangle(TriangleLight::new(vertices, emission))
}

fn sphere(center: Vec3, radius: f32, two_sided: bool) -> Light {
    let radiance = Rgb::new(0.25, 1.0, 0.5);
    let emission = Emission {
        radiance,
        two_sided,
    };
    Light::Sphere(SphereLight::new(Sphere::new(center, radius), emission))
}

/// All numbers of a light sample but the barycentric coordinates, which lanes do not keep, as bits.
fn bits(sample: Option<LightSample>) -> Option<Vec<u32>> {
    let sample = sample?;
    let mut numbers = sample.wi.to_array().to_vec();
    numbers.extend(sample.radiance.to_array());
    numbers.extend(sample.pdf.map(|pdf| pdf.0));
    match sample.end {
        ShadowRayEnd::Surface(point, _) => {
            for v in [point.p, point.error, point.ng, point.ns] {
                numbers.extend(v.to_array());
            }
        }
        ShadowRayEnd::Point(p) => numbers.extend(p.to_array()),
        ShadowRayEnd::Infinity => {}
    }
    Some(numbers.into_iter().map(f32::to_bits).collect())
}

/// Compares light samples of some lanes with those of single receivers; returns the number of lanes, of those that were
/// sampled in lanes, and of valid samples.
fn agree(lights: &Lights, memory: &mut Memory, rng: &mut TestRng) -> [usize; 3] {
    let Memory {
        context,
        of_lanes,
        samples,
    } = memory;
    let (mut active, mut p) = (ActiveLanes::<LANES>::NONE, [[0.0; LANES]; 3]);
    for lane in 0..LANES {
        active.set(lane, rng.uniform() < 0.8);
        let u_choice = rng.uniform_2d().to_array();
        let choice = lights.choose_by_power::<Everything>(u_choice);
        let (light, pmf) = choice.expect("the lights have power");
        // From a thousandth of the lamps' size to a thousand times it, on both sides and in their plane.
        let reach = 10.0_f32.powf(6.0 * rng.uniform() - 3.0);
        let mut receiver = Vec3::new(0.0, 0.0, 1.0) + reach * rng.direction_log_uniform(1e-6);
        if rng.uniform() < 0.05 {
            receiver.z = 1.0;
        }
        store(&mut p, lane, receiver);
        (context.light[lane], context.pmf[lane]) = (light, pmf.0);
        let u = rng.uniform_2d();
        (context.u[0][lane], context.u[1][lane]) = (u.x, u.y);
    }
    let singly = lights.sample_lanes(&active, context, &p, of_lanes, samples);
    let in_lanes = active.without(&singly);
    let mut valid = 0;
    for lane in in_lanes.each() {
        let u = Vec2::new(context.u[0][lane], context.u[1][lane]);
        let choice = (context.light[lane], Pmf(context.pmf[lane]));
        let (receiver, rules) = (load(&p, lane), LightSampling::default());
        let alone = lights.sample::<Everything>(choice, rules, receiver, 0.0, u);
        valid += usize::from(alone.is_some());
        let sample = samples.get(lane);
        assert_eq!(bits(sample), bits(alone), "{receiver} {choice:?}");
    }
    [active.count(), in_lanes.count(), valid]
}

/// The memory of light sampling in lanes.
#[derive(Default)]
struct Memory {
    context: LightContextLanes,
    of_lanes: LightLanes,
    samples: LightSampleLanes,
}

#[test]
fn light_samples_in_lanes_are_bit_identical_to_scalar_samples() {
    let corner = Vec3::new(-0.5, -0.4, 1.0);
    let elsewhere = |i: u32| corner + Vec3::new(0.3 * i as f32, 0.1, -0.2 * i as f32);
    let point = PointLight::new(Vec3::new(0.1, 0.2, 0.9), Rgb::WHITE);
    let all = [
        lights(vec![rectangle(corner, false)]),
        lights(vec![rectangle(corner, true)]),
        lights(vec![triangle(corner, false)]),
        lights((0..5).map(|i| triangle(elsewhere(i), i % 2 == 0)).collect()),
        lights(vec![
            rectangle(corner, false),
            rectangle(elsewhere(2), false),
            triangle(elsewhere(3), true),
            Light::Point(point),
        ]),
        // Receivers near their centres are inside.
        lights(vec![sphere(Vec3::new(0.0, 0.0, 1.0), 0.03, false)]),
        lights(vec![
            sphere(Vec3::new(0.2, 0.1, 1.3), 0.2, true),
            sphere(Vec3::new(-0.7, 2.0, 0.4), 1e-4, false),
            rectangle(corner, false),
        ]),
    ];
    let mut rng = TestRng::new(71);
    for (i, lights) in all.iter().enumerate() {
        let mut sums = [0; 3];
        // Blocks of lanes that keep their lights from call to call.
        for _ in 0..40 {
            let mut memory = Memory::default();
            for _ in 0..50 {
                let counts = agree(lights, &mut memory, &mut rng);
                for (sum, count) in sums.iter_mut().zip(counts) {
                    *sum += count;
                }
            }
        }
        let [active, in_lanes, valid] = sums;
        println!("lights {i}: {in_lanes} of {active} in lanes, {valid} of them valid");
        assert!(5 * in_lanes > active && 2 * valid > in_lanes);
    }
}
