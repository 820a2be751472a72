//! Tests of adaptive sampling of whole images: two-phase sampling has no bias and greedy sampling has, error bars are
//! calibrated, and every image, adaptive or not, is the mean of the samples that its settings determine.

use crate::common::error_bars::{Coverage, reference_settings};
use crate::common::nightly::{is_nightly, samplers, samples_and_limit};
use crate::common::room::with_metal_ball;
use crate::common::scene::{film, ready};
use crate::common::verdict::sidak;
use etendue::internals::accel::Backend;
use etendue::internals::film::filter::Filter;
use etendue::internals::film::{Film, Window};
use etendue::internals::image::Image;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::{Moments, normal_quantile};
use etendue::internals::render::replay::replay;
use etendue::internals::render::settings::Adaptive;
use etendue::internals::render::settings::{
    Budget, ErrorTarget, LightPathRule, RenderSettings, SamplerKind,
};
use etendue::internals::render::{NullRenderObserver, Progress, RenderObserver, Rendered, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// A room with a small ball of rough metal, which casts caustics.
fn room_with_metal(size: (u32, u32), roughness: f64) -> SceneDescription {
    let mut description = with_metal_ball(roughness, [0.5, 0.25, 0.4], 0.25);
    description.film.size = size;
    description
}

fn settings(scene: &SceneDescription, seed: u64, spp: u64) -> RenderSettings {
    RenderSettings {
        adaptive: Adaptive::TwoPhase,
        seed,
        ..RenderSettings::new(scene.film.size, spp)
    }
}

fn to_error(rel_rmse: f64, spp: Option<u64>) -> Budget {
    let error = Some(ErrorTarget {
        rel_rmse,
        confidence: 0.95,
    });
    Budget {
        error,
        spp,
        time: None,
    }
}

fn rendered(
    scene: &Scene,
    description: &SceneDescription,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Rendered {
    let filter = Filter::new(&description.film.filter);
    let size = description.film.size;
    render(scene, &filter, size, settings, observer).expect("the settings are valid")
}

/// The mean green of each quadrant of an image and of the whole image.
fn parts(image: &Image) -> [f64; 5] {
    let (width, height) = (image.width(), image.height());
    let mut sums = [0.0; 5];
    for (i, pixel) in image.pixels().iter().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let quadrant = usize::from(2 * x >= width) + 2 * usize::from(2 * y >= height);
        let green = f64::from(pixel.to_array()[1]);
        sums[quadrant] += green;
        sums[4] += 0.25 * green;
    }
    sums.map(|sum| 4.0 * sum / f64::from(width * height))
}

/// The moments of these means over images with different seeds.
fn parts_of(
    scene: &Scene,
    description: &SceneDescription,
    first_seed: u64,
    seeds: u64,
    with: impl Fn(RenderSettings) -> RenderSettings,
) -> [Moments; 5] {
    let mut moments = [Moments::default(); 5];
    for seed in first_seed..first_seed + seeds {
        let settings = with(settings(description, seed, 64));
        let image = film(scene, description, &settings).develop();
        for (moments, part) in moments.iter_mut().zip(parts(&image)) {
            moments.push(part);
        }
    }
    moments
}

/// The difference of two means in standard errors, and the standard error relative to the second mean.
fn welch(a: &Moments, b: &Moments) -> (f64, f64) {
    let [va, vb] = [a, b].map(|it| it.standard_error().expect("many images").powi(2));
    let error = (va + vb).sqrt();
    ((a.mean() - b.mean()) / error, error / b.mean())
}

#[test]
fn two_phase_sampling_is_unbiased_and_greedy_is_biased() {
    let description = room_with_metal((16, 16), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    let uniform = |settings| RenderSettings {
        adaptive: Adaptive::Off,
        ..settings
    };
    let (seeds, limit_of_error) = samples_and_limit(300, 0.00075);
    let even = parts_of(&scene, &description, 100_000, seeds / 5, |settings| {
        RenderSettings {
            budget: Budget::samples(512),
            ..uniform(settings)
        }
    });
    let limit = normal_quantile(1.0 - 0.5 * sidak(1e-4, 10));
    for &sampler in samplers(SamplerKind::ALL) {
        let ours = parts_of(&scene, &description, 0, seeds, |settings| RenderSettings {
            sampler,
            ..settings
        });
        for (part, (ours, even)) in ours.iter().zip(&even).enumerate() {
            let (z, error) = welch(ours, even);
            println!(
                "{}, part {part}: {z:.2} standard errors of {error:.5}",
                sampler.name()
            );
            assert!(z.abs() < limit, "part {part} is {z} standard errors off");
        }
        let (_, error) = welch(&ours[4], &even[4]);
        // A bias of 0.3 % is at least 4 standard errors, or 2.8 of half as many renders.
        assert!(error < limit_of_error, "inconclusive: {error}");
    }
    if !is_nightly() {
        return;
    }
    let greedy = parts_of(&scene, &description, 0, 400, |settings| RenderSettings {
        adaptive: Adaptive::Greedy,
        budget: to_error(0.2, Some(1024)),
        ..settings
    });
    let (z, _) = welch(&greedy[4], &even[4]);
    let off = greedy[4].mean() / even[4].mean() - 1.0;
    println!("greedy: {:.2} %, {z:.1} standard errors", 100.0 * off);
    // The bias may have either sign: pixels stop early where rare bright samples are missing, or rare dark ones.
    assert!(z.abs() > 5.2, "no bias of greedy sampling found: {z}");
}

#[test]
fn unflagged_adaptive_error_bars_have_nominal_coverage() {
    let description = room_with_metal((32, 32), 1.0);
    let scene = ready(&description, Backend::ALL[0]);
    let truth = reference_settings(&description, 1 << 13);
    let truth = film(&scene, &description, &truth).develop();
    for &sampler in samplers(&[SamplerKind::Sobol, SamplerKind::Independent]) {
        let settings = RenderSettings {
            sampler,
            ..settings(&description, 0, 256)
        };
        let mut coverage = Coverage::default();
        let images = if is_nightly() { 20 } else { 8 };
        coverage.add_images((&scene, &description), &settings, images, |index| {
            f64::from(truth.pixels()[index].to_array()[1])
        });
        println!("| adaptive, {} |{coverage}", sampler.name());
        assert_eq!(coverage.miscalibrated(), None, "{}", sampler.name());
        assert!(coverage.flagged() < 0.1, "{}", coverage.flagged());
    }
}

/// The output of a film: the bits of the image and the sample counts.
fn bits(film: &Film) -> (Vec<[u32; 3]>, Vec<u64>) {
    let image = film.develop();
    let pixels = image.pixels().iter();
    let bits = pixels.map(|p| p.to_array().map(f32::to_bits)).collect();
    (bits, film.sample_counts())
}

#[test]
fn adaptive_images_are_bit_identical_across_threads_and_tiles() {
    let description = room_with_metal((24, 16), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    let (none, half) = (LightPathShare::None, LightPathShare::Half);
    for (adaptive, budget, light_paths) in [
        (Adaptive::TwoPhase, Budget::samples(160), none),
        (Adaptive::TwoPhase, Budget::samples(160), half),
        (Adaptive::TwoPhase, to_error(0.1, None), none),
        (Adaptive::Greedy, to_error(0.2, Some(256)), none),
    ] {
        let with = |threads, tile_size| {
            let settings = RenderSettings {
                adaptive,
                budget,
                light_paths: LightPathRule::Share(light_paths),
                threads,
                tile_size,
                ..settings(&description, 3, 1)
            };
            let rendered = rendered(&scene, &description, &settings, &NullRenderObserver);
            assert_eq!(rendered.film.tiles()[0].window.width, tile_size.min(24));
            (bits(&rendered.film), rendered.spp, rendered.reached)
        };
        let one = with(1, 32);
        let counts = &one.0.1;
        assert!(
            counts.iter().min() < counts.iter().max(),
            "{adaptive:?}: all sample counts are equal"
        );
        for (threads, tile_size) in [(3, 32), (2, 5), (4, 1)] {
            assert!(
                with(threads, tile_size) == one,
                "{adaptive:?}, {threads} threads"
            );
        }
    }
}

/// Asserts that every pixel is the mean of its first samples, however many it has.
fn assert_means_of_first_samples(
    film: &Film,
    scene: &Scene,
    description: &SceneDescription,
    settings: &RenderSettings,
) {
    let filter = Filter::new(&description.film.filter);
    let (picture, counts) = (film.develop(), film.sample_counts());
    let pixels = film.window().pixels();
    for (i, (pixel, count)) in pixels.zip(counts).enumerate().step_by(7) {
        let mut sum = [0.0; 3];
        for sample in 0..count {
            let replayed = replay(scene, &filter, settings, pixel, sample);
            let value = replayed.expect("the settings are valid").radiance;
            for (sum, x) in sum.iter_mut().zip(value.to_array()) {
                *sum += f64::from(x);
            }
        }
        let mean = Rgb::from(sum.map(|sum| (sum / count as f64) as f32));
        assert_eq!(
            picture.pixels()[i],
            mean,
            "pixel {pixel:?} of {count} samples"
        );
    }
}

#[test]
fn pixels_equal_the_mean_of_their_replayed_samples() {
    let description = room_with_metal((16, 12), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    for adaptive in [Adaptive::Off, Adaptive::TwoPhase] {
        for sampler in [
            SamplerKind::Independent,
            SamplerKind::Sobol,
            SamplerKind::Stratified,
        ] {
            let settings = RenderSettings {
                adaptive,
                sampler,
                ..settings(&description, 5, 128)
            };
            let film = film(&scene, &description, &settings);
            assert_means_of_first_samples(&film, &scene, &description, &settings);
        }
    }
}

/// Cancels a render once it has this number of samples.
struct EndsAfter {
    samples: u64,
    so_far: AtomicU64,
}

impl RenderObserver for EndsAfter {
    fn progress(&self, progress: &Progress) {
        self.so_far.fetch_max(progress.samples, Ordering::Relaxed);
    }
    fn is_cancelled(&self) -> bool {
        self.so_far.load(Ordering::Relaxed) >= self.samples
    }
}

#[test]
fn cancelled_render_pixels_are_means_of_their_first_samples() {
    let description = room_with_metal((16, 12), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    let settings = RenderSettings {
        tile_size: 4,
        threads: 1,
        ..settings(&description, 5, 256)
    };
    let whole = film(&scene, &description, &settings).sample_counts();
    let observer = EndsAfter {
        samples: 16 * 12 * 160,
        so_far: AtomicU64::new(0),
    };
    let cut = rendered(&scene, &description, &settings, &observer);
    assert!(cut.cancelled);
    let counts = cut.film.sample_counts();
    assert!(
        counts
            .iter()
            .zip(&whole)
            .all(|(cut, whole)| (64..=*whole).contains(cut))
    );
    assert!(counts != whole && counts.iter().any(|&count| count > 64));
    assert_eq!(cut.film.sample_count(), counts.iter().sum::<u64>());
    assert_means_of_first_samples(&cut.film, &scene, &description, &settings);
}

#[test]
fn crop_pixels_with_equal_counts_match_the_full_render() {
    let description = room_with_metal((24, 16), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    let whole = settings(&description, 2, 128);
    let window = Window {
        x: 12,
        y: 5,
        width: 12,
        height: 11,
    };
    let crop = RenderSettings {
        window,
        ..whole.clone()
    };
    let [whole, crop] = [whole, crop].map(|settings| film(&scene, &description, &settings));
    let ((whole, all_counts), (crop, counts)) = (bits(&whole), bits(&crop));
    let mut alike = 0;
    for (i, [x, y]) in window.pixels().enumerate() {
        let index = (y * 24 + x) as usize;
        if counts[i] == all_counts[index] {
            alike += 1;
            assert_eq!(crop[i], whole[index], "pixel {x}, {y}");
        }
    }
    assert!(
        alike > 0 && alike < counts.len(),
        "{alike} of {}",
        counts.len()
    );
}

#[test]
fn pilot_only_adaptive_render_equals_the_uniform_render() {
    let description = room_with_metal((24, 16), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    for sampler in [
        SamplerKind::Independent,
        SamplerKind::Sobol,
        SamplerKind::Stratified,
    ] {
        let adaptive = RenderSettings {
            sampler,
            ..settings(&description, 2, 4)
        };
        let uniform = RenderSettings {
            adaptive: Adaptive::Off,
            ..adaptive.clone()
        };
        let [adaptive, uniform] =
            [adaptive, uniform].map(|settings| bits(&film(&scene, &description, &settings)));
        assert!(adaptive == uniform, "{}", sampler.name());
    }
}

/// The square root of an image's relMSE.
fn error_of(picture: &Image, truth: &Image) -> f64 {
    let channels = |image: &Image| -> Vec<f64> {
        let pixels = image.pixels().iter();
        pixels.flat_map(|p| p.to_array().map(f64::from)).collect()
    };
    let (picture, truth) = (channels(picture), channels(truth));
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let squares = picture.iter().zip(&truth);
    let squares = squares.map(|(x, r)| (x - r).powi(2) / (r * r + 0.01 * mean * mean));
    (squares.sum::<f64>() / truth.len() as f64).sqrt()
}

#[test]
fn adaptive_sampling_meets_error_target_with_fewer_samples() {
    let description = room_with_metal((32, 32), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    let truth = reference_settings(&description, 1 << 13);
    let truth = film(&scene, &description, &truth).develop();
    let target = 0.05;
    // If each render reaches the target with probability 95 %, fewer than 12 of 16 do so with probability 1e-3, and fewer than 5
    // of 8 with 4e-4.
    let (renders, least) = if is_nightly() { (16, 12) } else { (8, 5) };
    for &sampler in samplers(&[SamplerKind::Sobol, SamplerKind::Independent]) {
        let (mut kept, mut sum, mut off) = (0, 0.0, 0.0_f64);
        let mut spp = [0, 0];
        for seed in 0..renders {
            let adaptive = RenderSettings {
                sampler,
                budget: to_error(target, None),
                ..settings(&description, seed, 1)
            };
            let uniform = RenderSettings {
                adaptive: Adaptive::Off,
                ..adaptive.clone()
            };
            let [adaptive, uniform] = [adaptive, uniform]
                .map(|it| rendered(&scene, &description, &it, &NullRenderObserver));
            assert!(adaptive.reached && uniform.reached);
            spp[0] += adaptive.spp;
            spp[1] += uniform.spp;
            let error = error_of(&adaptive.film.develop(), &truth);
            kept += u32::from(error <= target);
            sum += error / target;
            if let Some(predicted) = adaptive.predicted {
                off = off.max((predicted.spp as f64 / adaptive.spp as f64).ln().abs());
            }
        }
        let (mean, spp) = (sum / renders as f64, spp.map(|sum| sum / renders));
        println!(
            "{}: {kept} of {renders} kept, {mean:.3} of it in the mean, foreseen to within a factor {:.2}; {} samples \
             per pixel, uniform {}",
            sampler.name(),
            off.exp(),
            spp[0],
            spp[1]
        );
        assert!(
            kept >= least,
            "{kept} of {renders} renders reach the target"
        );
        assert!(mean > 0.7, "{mean}");
        assert!(off < 1.7_f64.ln(), "{}", off.exp());
        assert!(spp[0] < spp[1], "{spp:?}");
    }
}

#[test]
fn short_time_budget_still_yields_an_error_estimate() {
    let description = room_with_metal((64, 64), 0.3);
    let scene = ready(&description, Backend::ALL[0]);
    let settings = RenderSettings {
        budget: Budget::time(Duration::from_millis(1)),
        ..settings(&description, 0, 1)
    };
    let film = rendered(&scene, &description, &settings, &NullRenderObserver).film;
    assert!(film.sample_counts().iter().all(|&count| count >= 4));
    assert!(film.error(0.95).is_some());
}

#[test]
fn greedy_sampling_requires_an_error_target_and_reports_bias() {
    let description = room_with_metal((8, 8), 0.3);
    let mut settings = RenderSettings {
        adaptive: Adaptive::Greedy,
        ..settings(&description, 0, 16)
    };
    let error = settings
        .validate((8, 8))
        .expect_err("there is no error target");
    assert!(error.to_string().contains("--error"), "{error}");
    settings.budget = to_error(0.5, None);
    assert!(settings.validate((8, 8)).is_ok());
    let scene = ready(&description, Backend::ALL[0]);
    let bias = |settings: &RenderSettings| settings.bias(scene.effects);
    assert!(bias(&settings)[0].contains("greedy"));
    settings.adaptive = Adaptive::TwoPhase;
    assert!(bias(&settings).is_empty());
}
