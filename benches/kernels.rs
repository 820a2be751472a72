//! Nanoseconds of the parts that a path is made of: random numbers, warps, scattering, textures,
//! filters, light sampling, single rays; and of batches of rays.
//!
//! Run: `cargo bench --bench kernels`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use etendue::accel::batch::{HitBatch, PacketWidth, Packets, RayBatch};
use etendue::accel::{Accel, AccelOptions, Backend, Precision, Quality};
use etendue::bsdf::principled::PrincipledParameters;
use etendue::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, Phong, Principled, conductor};
use etendue::effects::kernel::types::Everything;
use etendue::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::geometry::packed::PackedImage;
use etendue::geometry::texture::Texture;
use etendue::image::Image;
use etendue::math::ray::Ray;
use etendue::math::rgb::Rgb;
use etendue::math::vec::{Vec2, Vec3};
use etendue::sampler::{Decision, Independent, Sampler, Sobol};
use etendue::sampling::warp;
use etendue::scene::description::SceneDescription;
use etendue::scene::load::load;
use etendue::scene::prepare::prepare;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

/// Uniform numbers to draw inputs from, the same in every run.
fn numbers(count: usize) -> Vec<[f32; 4]> {
    let mut sampler = Independent::new(1);
    let draw = |i: usize| {
        sampler.start([0, 0], i as u64);
        sampler.draw(Decision::Light(0))
    };
    (0..count).map(draw).collect()
}

fn samplers(c: &mut Criterion) {
    let mut group = c.benchmark_group("sampler");
    let mut sample = 0;
    let mut next = || {
        sample += 1;
        sample
    };
    let mut independent = Independent::new(0);
    group.bench_function("independent, camera and one bounce", |b| {
        b.iter(|| one_bounce(&mut independent, next()));
    });
    let mut sobol = Sobol::new(0);
    group.bench_function("sobol, camera and one bounce", |b| {
        b.iter(|| one_bounce(&mut sobol, next()));
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

/// Lookups all over a picture of a size that no near cache holds, packed and not.
fn textures(c: &mut Criterion) {
    let (width, height) = (2048, 2048);
    let pixels = (0..width * height)
        .map(|i| Rgb::grey((i * 37 % 251) as f32 / 255.0))
        .collect();
    let image = Arc::new(Image::new(width, height, pixels));
    let packed = PackedImage::new(&image);
    let texture = Texture::Image { image, scale: 1.0 };
    let u = numbers(1 << 16);
    let mut group = c.benchmark_group("texture");
    let mut bench = |name: &str, lookup: &dyn Fn(Vec2) -> Rgb| {
        let mut i = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                i = (i + 1) % u.len();
                lookup(black_box(Vec2::new(u[i][0], u[i][1])))
            });
        });
    };
    bench("as read", &|uv| texture.lookup(uv));
    bench("packed", &|uv| packed.lookup(uv));
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

/// The suzanne-room as written.
fn suzanne_room() -> SceneDescription {
    let file = format!(
        "{}/scenes/suzanne-room/suzanne-room.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    load(Path::new(&file)).expect("a scene of our own loads")
}

/// Light sampling and single rays, in the suzanne-room.
fn room(c: &mut Criterion) {
    let description = suzanne_room();
    let u = numbers(4096);
    for &backend in Backend::ALL {
        for precision in [Precision::Fast, Precision::Robust] {
            let options = AccelOptions {
                backend,
                precision,
                quality: Quality::default(),
                threads: 1,
            };
            let scene = prepare(&description, options)
                .expect("it was built before")
                .scene;
            let rays: Vec<Ray> = u
                .iter()
                .map(|u| {
                    let film = Vec2::new(768.0 * u[0], 512.0 * u[1]);
                    scene.camera.ray::<Everything>(film, Vec2::ZERO, 0.0)
                })
                .collect();
            let mut group =
                c.benchmark_group(format!("ray/{}/{}", backend.name(), precision.name()));
            let mut i = 0;
            let mut next = || {
                i = (i + 1) % rays.len();
                &rays[i]
            };
            let accel: &Accel = &scene.accel;
            group.bench_function("camera, closest", |b| {
                b.iter(|| accel.intersect(next(), 0.0, None))
            });
            group.bench_function("camera, occluded", |b| {
                b.iter(|| accel.occluded(next(), 0.0))
            });
            group.finish();
            if (backend, precision) == (Backend::ALL[0], Precision::Fast) {
                let hits: Vec<_> = rays
                    .iter()
                    .filter_map(|ray| scene.intersect::<Everything>(ray, 0.0, None, 0.5))
                    .collect();
                let mut i = 0;
                c.bench_function("light/sample", |b| {
                    b.iter(|| {
                        i = (i + 1) % hits.len();
                        scene.lights.sample::<Everything>(hits[i].p, 0.0, u[i])
                    });
                });
            }
        }
    }
}

/// Batches of 4096 rays in the suzanne-room, in packets of every width: divide by that for a ray. The camera's go through
/// squares of 4 x 4 pixels; those that bounce start where these end, at random.
fn batches(c: &mut Criterion) {
    let description = suzanne_room();
    let u = numbers(4096);
    for precision in [Precision::Fast, Precision::Robust] {
        let options = AccelOptions {
            backend: Backend::ALL[0],
            precision,
            quality: Quality::default(),
            threads: 1,
        };
        let scene = prepare(&description, options)
            .expect("it was built before")
            .scene;
        let (mut camera, mut bounced) = (RayBatch::default(), RayBatch::default());
        for (i, u) in u.iter().enumerate() {
            let (square, pixel) = (96 * (i / 16), i % 16);
            let [x, y] = [
                4 * (square % 192) + pixel % 4,
                4 * (square / 192) + pixel / 4,
            ];
            let film = Vec2::new(x as f32 + u[0], y as f32 + u[1]);
            let ray = scene.camera.ray::<Everything>(film, Vec2::ZERO, 0.0);
            camera.push(&ray, 0.0);
            if let Some(hit) = scene.accel.intersect(&ray, 0.0, None) {
                // A little before the surface, so that the ray is not stopped there at once.
                let towards = warp::sample_sphere_uniform(Vec2::new(u[2], u[3]));
                bounced.push(&Ray::new(ray.at(0.999 * hit.t), towards), 0.0);
            }
        }
        let name = format!(
            "batch/{}/{}",
            options.backend.name(),
            options.precision.name()
        );
        let mut group = c.benchmark_group(name);
        let (mut hits, mut occluded) = (HitBatch::default(), Vec::new());
        for (kind, rays) in [("camera", &camera), ("bounced", &bounced)] {
            group.throughput(Throughput::Elements(rays.len() as u64));
            for (&width, coherent) in PacketWidth::ALL
                .iter()
                .flat_map(|width| [(width, false), (width, true)])
            {
                let packets = Packets { width, coherent };
                let way = if coherent { "coherent" } else { "incoherent" };
                let name = format!("{kind}, {} {way}", width.lanes());
                group.bench_function(format!("{name}, closest"), |b| {
                    b.iter(|| scene.accel.intersect_batch(rays, packets, &mut hits));
                });
                group.bench_function(format!("{name}, occluded"), |b| {
                    b.iter(|| scene.accel.occluded_batch(rays, packets, &mut occluded));
                });
            }
        }
    }
}

criterion_group!(
    benches, samplers, warps, scattering, textures, filters, room, batches
);
criterion_main!(benches);
