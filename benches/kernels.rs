//! Timings of the parts of a path, in nanoseconds: random numbers, warps, scattering, textures,
//! filters, light sampling.
//!
//! Run: `cargo bench --bench kernels`.

mod common;

use common::numbers;
use criterion::{Criterion, criterion_group, criterion_main};
use etendue::internals::bsdf::principled::PrincipledParameters;
use etendue::internals::bsdf::{
    Bsdf, Conductor, Dielectric, Diffuse, Phong, Principled, conductor,
};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::internals::geometry::texture_image::TextureImage;
use etendue::internals::image::Image;
use etendue::internals::light::Light;
use etendue::internals::light::rectangle::RectangleLight;
use etendue::internals::light::tree::LightTree;
use etendue::internals::light::triangle::TriangleLight;
use etendue::internals::light::types::{Emission, LightChoice, LightSampling, Receiver};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{Vec2, Vec3};
use etendue::internals::sampler::{Decision, Independent, Sampler, Sobol, Stratified};
use etendue::internals::sampling::warp;
use std::hint::black_box;

fn samplers(c: &mut Criterion) {
    sampler(c, "independent", Independent::new(0));
    sampler(c, "stratified", Stratified::new(0, Some(64)));
    sampler(c, "sobol", Sobol::new(0));
}

/// Times the start of a sample, draws of one, two and four numbers at once, and all draws of the camera and one bounce.
fn sampler(c: &mut Criterion, name: &str, mut sampler: impl Sampler) {
    let mut group = c.benchmark_group(format!("sampler/{name}"));
    let mut sample = 0;
    let mut next = || {
        sample = (sample + 1) % 64;
        black_box(sample)
    };
    group.bench_function("start", |b| b.iter(|| sampler.start([3, 5], next())));
    let decision = || black_box(Decision::Light(1));
    group.bench_function("one number", |b| {
        b.iter(|| sampler.draw::<1>(decision()));
    });
    group.bench_function("two numbers", |b| {
        b.iter(|| sampler.draw::<2>(decision()));
    });
    group.bench_function("four numbers", |b| {
        b.iter(|| sampler.draw::<4>(decision()));
    });
    group.bench_function("camera and one bounce", |b| {
        b.iter(|| one_bounce(&mut sampler, next()));
    });
}

fn one_bounce(sampler: &mut impl Sampler, sample: u64) -> f32 {
    sampler.start([3, 5], sample);
    let [a, ..] = sampler.draw::<4>(Decision::Camera);
    let [b, ..] = sampler.draw::<4>(Decision::Light(0));
    let [c, ..] = sampler.draw::<3>(Decision::Bsdf(0));
    let [d] = sampler.draw(Decision::Roulette(0));
    a + b + c + d
}

fn warps(c: &mut Criterion) {
    let u = numbers(1024);
    let mut group = c.benchmark_group("warp");
    let mut bench = |name: &str, warp: fn(Vec2) -> Vec3| {
        let mut i = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                i = (i + 1) % u.len();
                warp(black_box(Vec2::new(u[i][0], u[i][1])))
            });
        });
    };
    bench("hemisphere, cosine", warp::sample_hemisphere_cosine);
    bench("sphere, uniform", warp::sample_sphere_uniform);
}

fn scattering(c: &mut Criterion) {
    let u = numbers(1024);
    let (eta, k) = conductor::preset("gold").expect("gold is a preset");
    let plastic = PrincipledParameters {
        base_color: Rgb::grey(0.5),
        metallic: 0.0,
        roughness: 0.4,
        ior: 1.5,
        transmission: 0.0,
    };
    let models = [
        ("diffuse", Bsdf::Diffuse(Diffuse::new(Rgb::grey(0.5)))),
        ("conductor", Bsdf::Conductor(Conductor::new(eta, k, 0.3))),
        (
            "smooth dielectric",
            Bsdf::Dielectric(Dielectric::new(1.5, 0.0, Rgb::WHITE)),
        ),
        (
            "rough dielectric",
            Bsdf::Dielectric(Dielectric::new(1.5, 0.3, Rgb::WHITE)),
        ),
        ("principled", Bsdf::Principled(Principled::new(&plastic))),
        (
            "phong",
            Bsdf::Phong(Phong::new(Rgb::grey(0.5), Rgb::grey(0.3), 50.0)),
        ),
    ];
    let mut group = c.benchmark_group("bsdf");
    for (name, bsdf) in models {
        let directions: Vec<(Vec3, Vec3)> = u
            .iter()
            .map(|u| {
                let up = |a, b| warp::sample_hemisphere_cosine(Vec2::new(a, b));
                (up(u[0], u[1]), up(u[2], u[3]))
            })
            .collect();
        let mut i = 0;
        group.bench_function(format!("{name}, sample"), |b| {
            b.iter(|| {
                i = (i + 1) % u.len();
                bsdf.sample::<Everything>(
                    black_box(directions[i].0),
                    u[i][2],
                    Vec2::new(u[i][3], u[i][0]),
                )
            });
        });
        group.bench_function(format!("{name}, eval"), |b| {
            b.iter(|| {
                i = (i + 1) % u.len();
                bsdf.eval::<Everything>(black_box(directions[i].0), directions[i].1)
            });
        });
    }
}

/// Times lookups all over images too large for the inner caches, of few values and of many.
fn textures(c: &mut Criterion) {
    let (width, height) = (2048, 2048);
    let u = numbers(1 << 16);
    let mut group = c.benchmark_group("texture");
    for (name, values) in [("251 values", 251), ("1009 values", 1009)] {
        let pixels = (0..width * height)
            .map(|i| Rgb::grey((i * 37 % values) as f32 / 255.0))
            .collect();
        let image = TextureImage::from(Image::new(width, height, pixels));
        let mut i = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                i = (i + 1) % u.len();
                image.lookup(black_box(Vec2::new(u[i][0], u[i][1])))
            });
        });
    }
}

fn filters(c: &mut Criterion) {
    let u = numbers(1024);
    let mut group = c.benchmark_group("filter");
    for &(name, kind) in FilterKind::ALL {
        let radius = kind.default_radius();
        let filter = Filter::new(&FilterDescription { kind, radius });
        let mut i = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                i = (i + 1) % u.len();
                filter.sample(black_box(Vec2::new(u[i][0], u[i][1])))
            });
        });
    }
}

/// Times sampling and pdf of a rectangle and its half at three distances: far, where points are sampled; middle, where
/// directions are sampled; near, where sampling directions takes double precision. The receivers are below the light, in all
/// directions within 60 degrees of its normal.
fn flat_lights(c: &mut Criterion) {
    let u = numbers(1024);
    let (corner, edges) = (Vec3::new(-0.6, -0.8, 0.0), [1.2 * Vec3::X, 1.6 * Vec3::Y]);
    let vertices = [corner, corner + edges[0], corner + edges[1]];
    let emission = Emission {
        radiance: Rgb::WHITE,
        two_sided: true,
    };
    let lights = [
        (
            "rectangle",
            Light::Rectangle(RectangleLight::new(corner, edges, emission)),
        ),
        (
            "triangle",
            Light::Triangle(TriangleLight::new(vertices, emission)),
        ),
    ];
    for (name, light) in lights {
        for (place, distance) in [("far", 20.0), ("middle", 3.0), ("near", 0.3)] {
            let seen: Vec<(Vec3, Vec2)> = u
                .iter()
                .map(|u| {
                    let cone: Vec3 = warp::sample_cone_uniform(Vec2::new(u[0], u[1]), 0.5);
                    (distance * cone, Vec2::new(u[2], u[3]))
                })
                .collect();
            let mut group = c.benchmark_group(format!("light/{name}/{place}"));
            let mut i = 0;
            group.bench_function("sample", |b| {
                b.iter(|| {
                    i = (i + 1) % seen.len();
                    let (p, u) = black_box(seen[i]);
                    light.sample::<Everything>(LightSampling::default(), p, 0.0, u)
                });
            });
            group.bench_function("pdf", |b| {
                b.iter(|| {
                    i = (i + 1) % seen.len();
                    let (p, u) = black_box(seen[i]);
                    let to = Vec3::new(0.5 * u.x - 0.5, 0.5 * u.y - 0.5, 0.0);
                    light.pdf::<Everything>(p, 0.0, to - p, Vec3::Z)
                });
            });
        }
    }
}

/// Times the choice of a light and of a point on it, for the camera's hits in the suzanne-room.
fn lights_of_a_room(c: &mut Criterion) {
    let description = common::written("suzanne-room");
    let scene = common::ready(&description);
    let (width, height) = description.film.size;
    let u = numbers(4096);
    let hits = u.iter().filter_map(|u| {
        let film = Vec2::new(width as f32 * u[0], height as f32 * u[1]);
        let ray = scene.camera.ray::<Everything>(film, Vec2::ZERO, 0.0);
        scene.intersect::<Everything>(&ray, 0.0, None, 0.5)
    });
    let hits: Vec<_> = hits.collect();
    let mut i = 0;
    c.bench_function("light/choice and sample", |b| {
        b.iter(|| {
            i = (i + 1) % hits.len();
            let [u, v, u_choice, v_choice] = u[i];
            let (rule, receiver) = (LightChoice::default(), hits[i].receiver(false));
            let u_choice = [u_choice, v_choice];
            let choice = scene
                .lights
                .choose::<Everything>(rule, &receiver, u_choice)?;
            let (rules, u) = (LightSampling::default(), Vec2::new(u, v));
            scene
                .lights
                .sample::<Everything>(choice, rules, hits[i].p, 0.0, u)
        });
    });
}

/// Times the construction of a tree of a hundred thousand lights, and a selection from it.
fn light_trees(c: &mut Criterion) {
    let u = numbers(100_000);
    let emission = Emission {
        radiance: Rgb::WHITE,
        two_sided: false,
    };
    let lights: Vec<Light> = u
        .iter()
        .map(|&[x, y, z, w]| {
            let corner = Vec3::new(x, y, z);
            let edges = [
                Vec3::new(0.003, 0.0, 0.002 * w),
                Vec3::new(0.0, 0.002, 0.001),
            ];
            let vertices = [corner, corner + edges[0], corner + edges[1]];
            Light::Triangle(TriangleLight::new(vertices, emission))
        })
        .collect();
    let powers: Vec<f64> = lights.iter().map(|light| light.power(1.0)).collect();
    c.bench_function("light/tree of 100 000", |b| {
        b.iter(|| LightTree::new(&lights, &powers));
    });
    let tree = LightTree::new(&lights, &powers).expect("they shine");
    let mut i = 0;
    c.bench_function("light/choice from 100 000", |b| {
        b.iter(|| {
            i = (i + 1) % u.len();
            let [x, y, z, w] = u[i];
            let receiver = Receiver {
                p: Vec3::new(z, x, y),
                normal: Vec3::Z,
            };
            tree.choose(&receiver, [w, x])
        });
    });
}

criterion_group!(
    benches,
    samplers,
    warps,
    scattering,
    textures,
    filters,
    flat_lights,
    light_trees,
    lights_of_a_room
);
criterion_main!(benches);
