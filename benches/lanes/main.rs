//! The least that a path tracer on Embree costs beyond its rays: diffuse triangles under one rectangle light, in lanes from
//! the camera ray to the film. The rays of the same paths, traced alone, are the floor.
//!
//! Sixteen paths make a block, and a block's state is a structure of arrays. Each stage is a loop over the lanes of a block
//! without branches or calls, written for one lane in scalar code, which the compiler vectorises. Only vertices are copied
//! one lane at a time. Lanes whose paths end are refilled with samples whose camera rays have been traced as coherent
//! packets of 4 x 4 pixels. docs/architecture.md has the results.
//!
//! Run: `cargo bench --bench lanes [-- SCENE]`, with a scene file of the kind described, by default the Cornell box. It prints
//! nanoseconds on one thread.

// A loop over lanes indexes several arrays alike.
#![allow(clippy::needless_range_loop)]

mod block;
#[path = "../common/mod.rs"]
mod common;
mod light;
mod random;
mod recording;
mod stages;
mod tables;
mod worker;

use common::ready;
use etendue::internals::scene::load::load;
use recording::Recording;
use std::path::Path;
use std::time::Instant;
use tables::Tables;
use worker::Worker;

/// The edge of the square image, in pixels.
const SIZE: usize = 256;
/// The edge of a tile, in pixels.
const TILE: usize = 16;
/// Samples per pixel.
const SPP: usize = 64;
/// Scattering events of a path; there is no roulette.
const MAX_BOUNCES: u32 = 7;
/// Blocks that a thread works on at a time.
const BLOCKS: usize = 16;
/// Measurements, of which the median is printed.
const ROUNDS: usize = 7;
/// Tiles whose rays are recorded for the floor: one of so many.
const RECORDED: usize = 11;

/// The tiles of the image, by their upper left pixels.
fn tiles() -> impl Iterator<Item = [usize; 2]> {
    let starts = || (0..SIZE).step_by(TILE);
    starts().flat_map(move |y| starts().map(move |x| [x, y]))
}

fn median(mut values: [f64; ROUNDS]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[ROUNDS / 2]
}

fn main() {
    let default = format!(
        "{}/scenes/cornell-box/cornell-box.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    let file = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let mut description = load(Path::new(&file.unwrap_or(default))).expect("a scene that loads");
    description.film.size = (SIZE as u32, SIZE as u32);
    let scene = ready(&description);
    let tables = Tables::new(&description, &scene);

    let mut worker = Worker::new(&tables);
    worker.recording = Some(Recording::default());
    let mut recorded = 0;
    for tile in tiles().step_by(RECORDED) {
        worker.render(tile);
        recorded += TILE * TILE * SPP;
    }
    let mut recording = worker.recording.take().expect("it was set");
    let rays = recording.rays().map(|rays| rays as f64 / recorded as f64);
    println!(
        "rays per sample: camera {:.3}, extension {:.3}, shadow {:.3}",
        rays[0], rays[1], rays[2]
    );

    let samples = SIZE * SIZE * SPP;
    let (mut floors, mut wholes) = ([[0.0; 3]; ROUNDS], [0.0; ROUNDS]);
    let mut sum = [0.0; 3];
    for (floor, whole) in floors.iter_mut().zip(&mut wholes) {
        *floor = recording.trace(&tables).map(|s| s * 1e9 / recorded as f64);
        let start = Instant::now();
        sum = [0.0; 3];
        for tile in tiles() {
            for (sum, of_tile) in sum.iter_mut().zip(worker.render(tile)) {
                *sum += of_tile;
            }
        }
        *whole = start.elapsed().as_secs_f64() * 1e9 / samples as f64;
    }
    let kinds = [0, 1, 2].map(|kind| median(floors.map(|floor| floor[kind])));
    let factors = std::array::from_fn(|i| wholes[i] / floors[i].iter().sum::<f64>());
    println!(
        "ns per sample, medians of {ROUNDS}: rays alone {:.1} (camera {:.1}, extension {:.1}, shadow {:.1}), whole {:.1}; ratio {:.3}",
        kinds.iter().sum::<f64>(),
        kinds[0],
        kinds[1],
        kinds[2],
        median(wholes),
        median(factors),
    );
    let mean = sum.map(|channel| channel / samples as f64);
    let [r, g, b] = mean;
    println!("mean radiance {r:.5} {g:.5} {b:.5}");
}
