//! Light samples taken for many reference points at once are those of each point alone, bit for bit.

use crate::common::TestRng;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::light::Light;
use etendue::internals::light::point::PointLight;
use etendue::internals::light::rectangle::RectangleLight;
use etendue::internals::light::select::Lights;
use etendue::internals::light::triangle::TriangleLight;
use etendue::internals::light::types::{
    Emission, LightSample, LightSampleContext, PointRule, ShadowRayEnd,
};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec3;

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

/// All numbers of a light sample, as bits.
fn bits(sample: Option<LightSample>) -> Option<Vec<u32>> {
    let sample = sample?;
    let mut numbers = sample.wi.to_array().to_vec();
    numbers.extend(sample.radiance.to_array());
    numbers.extend(sample.pdf.map(|pdf| pdf.0));
    match sample.end {
        ShadowRayEnd::Surface(point, barycentric) => {
            for v in [point.p, point.error, point.ng, point.ns] {
                numbers.extend(v.to_array());
            }
            numbers.extend(barycentric);
        }
        ShadowRayEnd::Point(p) => numbers.extend(p.to_array()),
        ShadowRayEnd::Infinity => {}
    }
    Some(numbers.into_iter().map(f32::to_bits).collect())
}

/// Compares `count` light samples taken at once with those taken one by one; returns the number of valid samples.
fn agree(lights: &Lights, count: usize, points: PointRule, rng: &mut TestRng) -> usize {
    let questions: Vec<LightSampleContext> = (0..count)
        .map(|_| {
            let u_choice = rng.uniform_2d().to_array();
            let choice = lights.choose::<Everything>(u_choice);
            let (light, pmf) = choice.expect("the lights have power");
            // From a thousandth of the lamps' size to a thousand times it, on both sides and in their plane.
            let reach = 10.0_f32.powf(6.0 * rng.uniform() - 3.0);
            let mut p = Vec3::new(0.0, 0.0, 1.0) + reach * rng.direction_log_uniform(1e-6);
            if rng.uniform() < 0.05 {
                p.z = 1.0;
            }
            LightSampleContext {
                light,
                pmf,
                p,
                time: 0.0,
                u: rng.uniform_2d(),
            }
        })
        .collect();
    let mut samples = vec![];
    lights.sample_each::<Everything>(&questions, points, &mut samples);
    assert_eq!(samples.len(), count, "one result for each context");
    let mut answers = 0;
    for (question, together) in questions.iter().zip(samples) {
        let LightSampleContext {
            light,
            pmf,
            p,
            time,
            u,
        } = *question;
        let alone = lights.sample::<Everything>((light, pmf), points, p, time, u);
        answers += usize::from(alone.is_some());
        assert_eq!(
            bits(together),
            bits(alone),
            "{count} contexts, {question:?}"
        );
    }
    answers
}

#[test]
fn answers_do_not_depend_on_who_asks_as_well() {
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
    ];
    let mut rng = TestRng::new(71);
    for (i, lights) in all.iter().enumerate() {
        for points in [PointRule::SolidAngle, PointRule::Area] {
            let (mut asked, mut answered) = (0, 0);
            for count in 0..=40 {
                for _ in 0..50 {
                    asked += count;
                    answered += agree(lights, count, points, &mut rng);
                }
            }
            println!("lights {i}, {points:?}: {answered} of {asked} questions have answers");
            assert!(2 * answered > asked);
        }
    }
}
