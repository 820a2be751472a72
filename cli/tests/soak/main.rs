//! A soak test of half an hour: random scenes on every backend. Run it with `make soak`.
//!
//! Each round renders a generated scene with every backend and checks four properties: all samples are finite; all
//! backends give the same radiance; memory does not grow from round to round; and the image on disk is complete, however
//! the command that was replacing it was ended.
//!
//! Measure: seconds, set by the variable SOAK_SECONDS; bytes of resident memory, where /proc reports them.
//! Range: a failure ends the program with a panic that names the round; ROUND=n repeats round n.
//! Source: none needed. This is a program and not a `#[test]`, because of its long running time.

#[path = "../../../tests/common/mod.rs"]
mod common;
mod interruption;
#[path = "../support/command.rs"]
mod support;

use common::TestRng;
use common::generated::Generator;
use common::scene::ready;
use etendue::internals::accel::Backend;
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::math::stats::Moments;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::SceneDescription;
use std::time::{Duration, Instant};

/// Samples per pixel.
const SPP: u64 = 64;
/// Rounds between two attempts to kill the command.
const ROUNDS_BETWEEN_KILLS: u64 = 10;
/// Largest allowed growth of resident memory in bytes between the first third and the last: allocators keep some of
/// the freed memory.
const MAX_GAINED: u64 = 32 << 20;

fn main() {
    let variable = |name| std::env::var(name).ok().and_then(|text| text.parse().ok());
    if let Some(index) = variable("ROUND") {
        round(index);
        return;
    }
    let total = Duration::from_secs(variable("SOAK_SECONDS").unwrap_or(1800));
    let start = Instant::now();
    let mut memory = Memory::default();
    let mut rounds = 0;
    let mut last_word = start;
    let mut victim = interruption::InterruptedRender::new();
    while start.elapsed() < total {
        round(rounds);
        if rounds % ROUNDS_BETWEEN_KILLS == 0 {
            victim.kill_once(&mut TestRng::new(rounds));
        }
        rounds += 1;
        memory.look(start.elapsed().as_secs_f64() / total.as_secs_f64());
        if last_word.elapsed() > Duration::from_secs(30) {
            last_word = Instant::now();
            println!("{:?}: {rounds} rounds, {memory}", start.elapsed());
        }
    }
    println!("{rounds} rounds, {memory}; {victim}");
    memory.judge();
}

/// Renders one scene with every backend and compares the images.
fn round(index: u64) {
    let mut generator = Generator::new(index);
    let wanted = generator.wanted();
    let mut description = generator.scene(wanted);
    // Every second round has a tiny field of view, so that all pixels see the same point.
    if index % 2 == 1 {
        description.camera.fov = 1e-4;
    }
    let seen: Vec<Film> = Backend::ALL
        .iter()
        .map(|&it| picture(index, &description, it))
        .collect();
    for (film, backend) in seen.iter().zip(Backend::ALL).skip(1) {
        let what = format!(
            "round {index}: {} and {}",
            Backend::ALL[0].name(),
            backend.name()
        );
        compare(&what, &seen[0], film);
    }
}

fn picture(index: u64, description: &SceneDescription, backend: Backend) -> Film {
    let scene = ready(description, backend);
    let filter = Filter::new(&description.film.filter);
    let size = description.film.size;
    let settings = RenderSettings {
        seed: index,
        threads: 1 + index as usize % 3,
        ..RenderSettings::new(size, SPP)
    };
    let rendered =
        render(&scene, &filter, size, &settings, &NullRenderObserver).expect("valid settings");
    let rejected = rendered.rejected;
    assert_eq!(
        rejected.count,
        0,
        "round {index}, {}: {rejected:?}",
        backend.name()
    );
    rendered.film
}

/// Compares the means of two images rendered with the same seed. Where rounding makes a path diverge, the two differ
/// randomly, but by no more than images of independent samples would, at 5.2 sigma.
fn compare(what: &str, a: &Film, b: &Film) {
    let [a, b] = [a, b].map(|film| {
        let tiles = film.tiles().iter();
        let pixels =
            tiles.flat_map(|tile| tile.pixels.iter().map(move |sums| (sums, tile.samples)));
        let variances = pixels.clone().map(|(sums, n)| {
            let variance = sums.batch_means(n).variance();
            variance.map_or(0.0, |of_sample| of_sample[1] / n as f64)
        });
        let means = Moments::of(pixels.clone().map(|(sums, n)| sums.mean(n)[1]));
        let count = means.count() as f64;
        (means.mean(), variances.sum::<f64>() / (count * count))
    });
    let error = (a.1 + b.1).sqrt();
    let difference = (a.0 - b.0).abs();
    assert!(
        difference <= 5.2 * error + 4e-6 * a.0,
        "{what}: {} and {}, standard error {error}",
        a.0,
        b.0
    );
}

/// The peak resident memory in each third of the running time, in bytes.
#[derive(Debug, Default)]
struct Memory([u64; 3]);

impl Memory {
    /// Records the resident memory when this fraction of the time has passed.
    fn look(&mut self, share: f64) {
        let third = &mut self.0[((3.0 * share) as usize).min(2)];
        *third = (*third).max(resident());
    }

    fn judge(&self) {
        let [first, _, last] = self.0;
        assert!(
            first == 0 || last <= first + MAX_GAINED,
            "memory grows: {self}"
        );
    }
}

impl std::fmt::Display for Memory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [first, second, last] = self.0.map(|bytes| bytes >> 20);
        write!(f, "resident MiB by thirds {first}, {second}, {last}")
    }
}

/// Resident memory in bytes; 0 if unknown.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.unwrap_or(0) << 10
}
