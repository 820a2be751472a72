//! Samples per second of whole renders: the gain of `--precision fast` over `robust`, and of Embree over obvhs.
//!
//! Each iteration renders one image on all threads; its scene is loaded and built before. Criterion's "thrpt" is samples
//! per second over all threads. Run: `cargo bench --bench render`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::film::filter::Filter;
use etendue::internals::render::settings::{RenderSettings, SamplerKind, available_threads};
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use std::path::Path;

/// A scene, its image size, and its bounce limit.
type Case = (&'static str, (u32, u32), Option<u32>);

const CASES: &[Case] = &[
    ("cornell-box", (512, 512), Some(8)),
    ("suzanne-room", (384, 256), None),
];

/// Samples per pixel.
const SPP: u64 = 2;

fn renders(c: &mut Criterion) {
    for &(name, size, max_bounces) in CASES {
        let file = format!("{}/scenes/{name}/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let mut description = load(Path::new(&file)).expect("a bundled scene loads");
        description.film.size = size;
        let filter = Filter::new(&description.film.filter);
        let mut group = c.benchmark_group(name);
        group.sample_size(10);
        group.throughput(Throughput::Elements(
            u64::from(size.0) * u64::from(size.1) * SPP,
        ));
        for &backend in Backend::ALL {
            for precision in [Precision::Fast, Precision::Robust] {
                for &sampler in SamplerKind::ALL {
                    let threads = available_threads();
                    let options = AccelOptions {
                        backend,
                        precision,
                        quality: None,
                        threads,
                    };
                    let scene = prepare(&description, options)
                        .expect("it was built before")
                        .scene;
                    let settings = RenderSettings {
                        sampler,
                        max_bounces,
                        ..RenderSettings::new(size, SPP)
                    };
                    let id = [backend.name(), precision.name(), sampler.name()].join("/");
                    group.bench_function(id, |b| {
                        b.iter(|| render(&scene, &filter, size, &settings, &NullRenderObserver));
                    });
                }
            }
        }
        group.finish();
    }
}

criterion_group!(benches, renders);
criterion_main!(benches);
