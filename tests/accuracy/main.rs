//! The coverage of error bars, the errors that renders state, and the true errors of renders to a requested error, over enough
//! seeds to be significant: `make accuracy`. It prints the tables of docs/accuracy.md.
//!
//! Measure: shares of intervals in percent; true errors as multiples of the requested ones.
//! Range: ACCURACY_SEEDS images of each case of error bars, an eighth as many of the others, of the scenes whose name contains
//! ACCURACY_SCENES (default: all), and of the part ACCURACY_PART (`bars`, `stated` or `targets`, default: all); ends with a
//! panic that names the cases out of tolerance.
//! Source: accuracy protocol of docs/accuracy.md. It is a program, not a test, since it takes hours.

#[path = "../common/mod.rs"]
mod common;
mod stated;

use common::closed_forms::parallel_rectangle;
use common::error_bars::{Coverage, TargetsReached, settings};
use common::room::floor_below;
use common::scene::{film, ready, rectangle};
use etendue::internals::accel::Backend;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::NullRenderObserver;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::settings::{RenderSettings, SamplerKind};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use etendue::internals::scene::load::load;
use etendue::internals::session::{Session, tracing};
use stated::{CONFIDENCE, Stated, StatedErrors};
use std::path::Path;

/// Bundled scenes, samples per pixel, and the least share of pixels that have to be unflagged.
const SCENES: [(&str, u64, f64); 6] = [
    ("cornell-box/cornell-box", 256, 0.9),
    ("environment/environment", 256, 0.8),
    ("depth-of-field/depth-of-field", 256, 0.6),
    ("caustics/caustics", 256, 0.6),
    ("suzanne-room/suzanne-room", 1024, 0.6),
    ("materials/materials", 1024, 0.6),
];

/// The image size of these scenes.
const SIZE: (u32, u32) = (96, 64);

/// Scenes whose renders state their error, with the integrator: those that it converges in.
const STATED_SCENES: [(&str, IntegratorKind); 14] = [
    ("suzanne-room/suzanne-room", IntegratorKind::Path),
    ("caustics/caustics", IntegratorKind::Path),
    ("cornell-box/cornell-box", IntegratorKind::Path),
    ("environment/environment", IntegratorKind::Path),
    ("materials/materials", IntegratorKind::Path),
    ("depth-of-field/depth-of-field", IntegratorKind::Path),
    ("four-lights/four-lights", IntegratorKind::Path),
    ("frosted-block/frosted-block", IntegratorKind::Path),
    ("phong-lobes/phong-lobes", IntegratorKind::Path),
    ("rough-glass/rough-glass", IntegratorKind::Path),
    ("motion-blur/motion-blur", IntegratorKind::Path),
    (
        "ten-thousand-lamps/ten-thousand-lamps",
        IntegratorKind::Path,
    ),
    (
        "ten-thousand-instances/ten-thousand-instances",
        IntegratorKind::Path,
    ),
    ("shaded-lamps/shaded-lamps", IntegratorKind::Bidirectional),
];

/// Their sample counts per pixel.
const STATED_SPP: [u64; 3] = [64, 256, 1024];

/// Scenes that are rendered until an error is reached, and their image sizes.
const TARGET_SCENES: [(&str, (u32, u32)); 10] = [
    ("suzanne-room/suzanne-room", (32, 24)),
    ("depth-of-field/depth-of-field", (32, 24)),
    ("caustics/caustics", (64, 48)),
    ("frosted-block/frosted-block", (64, 48)),
    ("ten-thousand-instances/ten-thousand-instances", (64, 48)),
    ("cornell-box/cornell-box", (64, 48)),
    ("environment/environment", (64, 48)),
    ("rough-glass/rough-glass", (64, 48)),
    ("materials/materials", (64, 48)),
    ("motion-blur/motion-blur", (64, 48)),
];

/// The samples per pixel of their references.
const TARGET_TRUTH_SPP: u64 = 1 << 15;

/// The mean sample count below which the bound lies far above the error, and samples come in steps that are large beside it.
const FEW_SAMPLES: f64 = 32.0;

/// The least means of the true error over the requested one: with few samples, and with more.
const LEAST_SHARES: [f64; 2] = [0.6, 0.8];

/// Requested errors.
const TARGETS: [f64; 3] = [0.10, 0.05, 0.02];

/// The seed of reference images: no image compared with one has it.
const SEED_OF_TRUTH: u64 = 1 << 32;

/// Whether a scene is selected by ACCURACY_SCENES.
fn is_wanted(name: &str) -> bool {
    let part = std::env::var("ACCURACY_SCENES").unwrap_or_default();
    name.contains(&part)
}

/// Whether this part is run: the one that ACCURACY_PART names, or each if it is not set.
fn is_part(name: &str) -> bool {
    std::env::var("ACCURACY_PART").map_or(true, |part| part == name)
}

fn main() {
    let seeds = std::env::var("ACCURACY_SEEDS");
    let seeds: u64 = seeds.map_or(400, |text| {
        text.parse().expect("ACCURACY_SEEDS is a number")
    });
    let mut off = Vec::new();
    let renders = (seeds / 8).max(3);
    if is_part("bars") {
        println!(
            "| shares of unflagged intervals that hold the truth | 50 % | 80 % | 90 % | 95 % | 99 % | flagged | of these \
             at 95 % |\n|---|---|---|---|---|---|---|---|"
        );
        closed_forms(seeds, &mut off);
        pictures(seeds, &mut off);
    }
    if is_part("stated") {
        println!(
            "\n| stated errors | true error, mean | stated over true error | bounds that hold | `at least` |\n\
             |---|---|---|---|---|"
        );
        stated_errors(renders, &mut off);
    }
    if is_part("targets") {
        println!(
            "\n| error asked for | samples per pixel, mean | kept by | true error, as a share of it | foreseen within |\n\
             |---|---|---|---|---|"
        );
        targets(renders, &mut off);
    }
    assert!(off.is_empty(), "out of tolerance: {off:#?}");
}

/// Runs the cases of a floor under a lamp, where every pixel has a closed form.
fn closed_forms(seeds: u64, off: &mut Vec<String>) {
    let square = rectangle([-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let strip = rectangle([-2.0, 0.1, -0.1], [4.0, 0.0, 0.0], [0.0, 0.0, 0.2]);
    let disk = GeometryDescription::Disk {
        center: DVec3::Y,
        normal: DVec3::NEG_Y,
        radius: 1.0,
    };
    let sphere = GeometryDescription::Sphere {
        center: 2.0 * DVec3::Y,
        radius: 1.0,
    };
    // The floor's albedo, 0.5, times each lamp's form factor.
    let cases = [
        (
            "square lamp",
            square,
            2.0 * parallel_rectangle(1.0, 1.0, 1.0),
        ),
        (
            "strip near the floor",
            strip,
            2.0 * parallel_rectangle(2.0, 0.1, 0.1),
        ),
        ("disk", disk, 0.25),
        ("sphere", sphere, 0.125),
    ];
    let wanted = cases.into_iter().filter(|(name, ..)| is_wanted(name));
    for (name, lamp, exact) in wanted {
        let description = floor_below(lamp);
        let scene = ready(&description, Backend::ALL[0]);
        for sampler in SamplerKind::ALL {
            for spp in [64, 512] {
                let settings = RenderSettings {
                    max_bounces: Some(1),
                    ..settings(&description, *sampler, 0, spp)
                };
                let mut coverage = Coverage::default();
                coverage.add_images((&scene, &description), &settings, seeds, |_| exact);
                judge(
                    &format!("{name}, {}, {spp} spp", sampler.name()),
                    &coverage,
                    off,
                );
            }
        }
    }
}

/// Runs the cases of whole images, each compared with the mean of the others.
fn pictures(seeds: u64, off: &mut Vec<String>) {
    for (name, spp, least) in SCENES.into_iter().filter(|(name, ..)| is_wanted(name)) {
        let description = ours(name, SIZE);
        let scene = ready(&description, Backend::ALL[0]);
        let settings = settings(&description, SamplerKind::Sobol, 0, spp);
        let mut coverage = Coverage::default();
        coverage.add_images_against_others((&scene, &description), &settings, seeds.max(2));
        let case = format!("{name}, sobol, {spp} spp");
        judge(&case, &coverage, off);
        let unflagged = 1.0 - coverage.flagged();
        if unflagged < least {
            off.push(format!("{case}: {unflagged} of the pixels are unflagged"));
        }
    }
}

fn judge(case: &str, coverage: &Coverage, off: &mut Vec<String>) {
    println!("| {case} |{coverage}");
    off.extend(
        coverage
            .miscalibrated()
            .map(|what| format!("{case}: {what}")),
    );
}

/// Runs the cases of renders with default options, which state their error.
fn stated_errors(renders: u64, off: &mut Vec<String>) {
    let wanted = STATED_SCENES.into_iter();
    for (name, integrator) in wanted.filter(|(name, _)| is_wanted(name)) {
        let session = Session::new(ours(name, SIZE), tracing()).expect("a bundled scene is valid");
        for spp in STATED_SPP {
            let render = |seed: u64| {
                let mut options = RenderOptions::samples(spp);
                (options.seed, options.integrator) = (Some(seed), Some(integrator));
                let rendering = session.render(&options, &NullRenderObserver);
                let rendering = rendering.expect("valid options");
                Stated {
                    image: rendering.image(),
                    error: rendering
                        .error(CONFIDENCE)
                        .expect("all pixels have samples"),
                }
            };
            let renders: Vec<Stated> = (0..renders).map(render).collect();
            let errors = StatedErrors::of(&renders);
            let case = format!("{name}, {}, {spp} spp", integrator.name());
            println!("| {case} |{errors}");
            off.extend(
                errors
                    .out_of_tolerance()
                    .map(|row| format!("{case}: {row}")),
            );
        }
    }
}

/// Runs the cases of images that are rendered until an error is reached.
fn targets(renders: u64, off: &mut Vec<String>) {
    for (name, size) in TARGET_SCENES
        .into_iter()
        .filter(|(name, _)| is_wanted(name))
    {
        let description = ours(name, size);
        let scene = ready(&description, Backend::ALL[0]);
        let mut options = RenderOptions::samples(TARGET_TRUTH_SPP);
        options.sampler = Some(SamplerKind::Sobol);
        // Pilots choose light paths, shared paths and the weight window, as in `etendue render`.
        let settings = options.settings(&description).expect("valid options");
        let truth = RenderSettings {
            seed: SEED_OF_TRUTH,
            ..settings
        };
        let truth = film(&scene, &description, &truth);
        for rel_rmse in TARGETS {
            let kept = TargetsReached::of(
                (&scene, &description),
                (&settings, rel_rmse),
                renders,
                &truth,
            );
            let case = format!("{name}, sobol, {} %", 100.0 * rel_rmse);
            println!("| {case} |{kept}");
            let [with_few, with_more] = LEAST_SHARES;
            let least = if kept.mean_spp() < FEW_SAMPLES {
                with_few
            } else {
                with_more
            };
            if 100 * kept.kept < 93 * kept.renders || kept.mean() < least {
                off.push(format!("{case}: {kept}"));
            }
        }
    }
}

/// A bundled scene with a small film.
fn ours(name: &str, size: (u32, u32)) -> SceneDescription {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
    let mut description = load(&file).expect("a bundled scene is valid");
    description.film.size = size;
    description
}
