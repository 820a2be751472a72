//! Denoising on the command line: at the end of a render, from a file, and the errors where it is impossible.

use crate::common::scene_folder::{SMALL, SceneFolder, in_repository};
use crate::support::{INPUT_OUTPUT, SCENE, USAGE, fails, run, succeed};
use etendue::internals::image::{ColourSpace, LayeredImage, MetadataValue, WriteOptions, write};
use serde_json::Value;

fn read(folder: &SceneFolder, name: &str) -> LayeredImage {
    LayeredImage::read(&folder.path(name), ColourSpace::Srgb).expect("an EXR with layers")
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("an object")
}

/// The mean of (x - r)^2 / (r^2 + eps) without the noise of the reference, whose two halves are independent.
fn rel_mse(picture: &LayeredImage, reference: &LayeredImage) -> f64 {
    let r = &reference.image;
    let mean = r.mean().iter().sum::<f64>() / 3.0;
    let halves = reference
        .required_layers(["half.R", "half.G", "half.B"])
        .expect("a reference has its half");
    let mut sum = 0.0;
    for (i, (x, r)) in picture.image.pixels().iter().zip(r.pixels()).enumerate() {
        for (c, half) in halves.iter().enumerate() {
            let [x, r, a] = [x.to_array()[c], r.to_array()[c], half[i]].map(f64::from);
            let b = 2.0 * r - a;
            sum += (x - a) * (x - b) / (r * r + 0.01 * mean * mean);
        }
    }
    sum / (3 * r.pixels().len()) as f64
}

#[test]
fn render_and_file_denoising_are_bit_identical() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    succeed(
        &folder,
        "render small.toml --spp 32 --layers -q -o plain.exr",
    );
    let flags = "--spp 32 --denoise --layers -o it.exr -o it.png --json";
    let rendered = succeed(&folder, &format!("render small.toml {flags}"));
    let denoised = succeed(&folder, "denoise plain.exr -o file.exr -t 1 --json");

    let [plain, it, file] = ["plain.exr", "it.exr", "file.exr"].map(|name| read(&folder, name));
    assert_eq!(it.image, file.image);
    assert_ne!(it.image, plain.image);
    for picture in [&it, &file] {
        for (c, name) in ["noisy.R", "noisy.G", "noisy.B"].into_iter().enumerate() {
            let before = plain.image.pixels().iter().map(|pixel| pixel.to_array()[c]);
            let layer = picture.layer(name).expect("the unfiltered picture is kept");
            assert!(before.eq(layer.iter().copied()), "{name}");
        }
        // The other layers are those of the render, except the error.
        for layer in &plain.layers {
            let is_kept = picture.layer(&layer.name) == Some(layer.samples.as_slice());
            let is_error = ["se.R", "se.G", "se.B"].contains(&layer.name.as_str());
            assert_eq!(is_kept, !is_error, "{}", layer.name);
        }
        let Some(MetadataValue::Text(bias)) = picture.fact("bias") else {
            panic!("no bias among {:?}", picture.metadata);
        };
        assert!(bias.contains("denoise nlm"), "{bias}");
    }
    assert_eq!(it.fact("relRmse"), file.fact("relRmse"));

    let (stats, report) = (json(&rendered.stdout), json(&denoised.stdout));
    assert!(
        stats["bias"][0]
            .as_str()
            .is_some_and(|bias| bias.contains("denoise nlm"))
    );
    for key in ["filter", "rel_rmse_before", "rel_rmse_after"] {
        assert_eq!(stats["denoise"][key], report[key], "{key}");
        assert!(!report[key].is_null(), "{key}");
    }
    for said in [&rendered.stderr, &denoised.stderr] {
        for word in [
            ": 24 x 16 pixels",
            "filtered by nlm, error then about",
            "biased by denoise nlm",
        ] {
            assert!(said.contains(word), "no `{word}` in {said}");
        }
    }
    // Without --layers the unfiltered image is kept all the same.
    succeed(
        &folder,
        "render small.toml --spp 32 --denoise=nlm -q -o short.exr",
    );
    let short = read(&folder, "short.exr");
    assert_eq!(short.image, it.image);
    assert_eq!(short.layers.len(), 3);
    assert_eq!(short.layer("noisy.R"), it.layer("noisy.R"));
}

/// Denoises a hard scene: glass, gold, a small lamp. Each half of the reference has 16 times as many samples, and its noise
/// is not counted.
#[test]
fn denoising_halves_rel_mse_and_error_estimate_is_plausible() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let scene = in_repository("scenes/suzanne-room/suzanne-room.toml");
    let render = format!("render {} --size 144x96 -q", scene.display());
    succeed(
        &folder,
        &format!("{render} --spp 256 --seed 9 --layers -o reference.exr"),
    );
    succeed(&folder, &format!("{render} --spp 16 --layers -o noisy.exr"));
    let told = json(&succeed(&folder, "denoise noisy.exr -o it.exr --json").stdout);
    let [reference, noisy, it] =
        ["reference.exr", "noisy.exr", "it.exr"].map(|name| read(&folder, name));
    let (before, after) = (rel_mse(&noisy, &reference), rel_mse(&it, &reference));
    println!("relMSE {before} before, {after} after; told {told}");
    assert!(after < before / 2.0, "{before} before, {after} after");
    // Rare events are undersampled by 16 samples, so the stated error is conservative.
    let told = told["rel_rmse_after"].as_f64().expect("a number");
    assert!(
        (0.5..3.0).contains(&(told / after.sqrt())),
        "{told} stated, {} measured",
        after.sqrt()
    );
}

/// Denoises a grey box whose walls emit 1 and reflect half: every pixel is 2.
#[test]
fn denoised_furnace_matches_closed_form_within_stated_error() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let scene = in_repository("scenes/furnace/grey-box.toml");
    let flags = "--spp 64 --sampler independent --denoise --layers --json -o it.exr";
    let told = json(&succeed(&folder, &format!("render {} {flags}", scene.display())).stdout);
    let it = read(&folder, "it.exr");
    let squares = it.image.pixels().iter().flat_map(|x| x.to_array());
    let errors: Vec<f64> = squares
        .map(|x| (f64::from(x) / 2.0 - 1.0).powi(2))
        .collect();
    let actual = (errors.iter().sum::<f64>() / errors.len() as f64).sqrt();
    let [before, after] = ["rel_rmse_before", "rel_rmse_after"]
        .map(|key| told["denoise"][key].as_f64().expect("a number"));
    assert!(after < before / 3.0, "{before} before, {after} after");
    assert!(
        (0.6..1.6).contains(&(after / actual)),
        "{after} stated, {actual} measured"
    );
    let mean = it.image.mean()[0] / 2.0 - 1.0;
    assert!(mean.abs() < after, "{mean}");
}

#[test]
fn invalid_denoise_inputs_are_rejected_with_a_message() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    succeed(&folder, "render small.toml -q -o bare.exr -o bare.png");
    succeed(
        &folder,
        "render small.toml -q --denoise --layers -o done.exr",
    );
    succeed(&folder, "render small.toml -q --layers -o it.exr");
    let damaged = |name: &str, layer: &str, value: f32| {
        let mut picture = read(&folder, "it.exr");
        let found = picture.layers.iter_mut().find(|it| it.name == layer);
        found.expect("the layer is there").samples[24 * 2 + 5] = value;
        let options = WriteOptions {
            layers: picture.layers,
            ..WriteOptions::default()
        };
        write(&folder.path(name), &picture.image, &options).expect("written");
    };
    damaged("nan.exr", "half.G", f32::NAN);
    damaged("negative.exr", "se.B", -1.0);
    damaged("far.exr", "albedo.R", f32::INFINITY);
    damaged("behind.exr", "depth.Z", -3.0);
    for (arguments, code, words) in [
        (
            "bare.exr",
            SCENE,
            &["bare.exr", "half.R", "etendue render --layers"][..],
        ),
        ("bare.png", SCENE, &["bare.png", "etendue render --layers"]),
        ("done.exr", SCENE, &["done.exr", "filtered already"]),
        (
            "nan.exr",
            SCENE,
            &["nan.exr", "`half.G` is NaN in pixel (5, 2)", "finite"],
        ),
        (
            "negative.exr",
            SCENE,
            &["`se.B` is -1 in pixel (5, 2)", "at least 0"],
        ),
        ("far.exr", SCENE, &["`albedo.R` is inf in pixel (5, 2)"]),
        ("behind.exr", SCENE, &["`depth.Z` is -3 in pixel (5, 2)"]),
        ("missing.exr", INPUT_OUTPUT, &["missing.exr", "cannot read"]),
        ("it.exr -o it.tiff", USAGE, &["it.tiff", ".exr"]),
        ("it.exr -o no/it.exr", INPUT_OUTPUT, &["no/it.exr"]),
        ("it.exr --filter median", USAGE, &["--filter", "nlm"]),
        ("it.exr -t 0", USAGE, &["--threads"]),
    ] {
        fails(&folder, &format!("denoise {arguments}"), code, words);
    }
    for (flags, words) in [
        ("--denoise=median", &["--denoise", "nlm"][..]),
        ("--denoise nlm", &["nlm"]),
    ] {
        fails(&folder, &format!("render small.toml {flags}"), USAGE, words);
    }
}

#[test]
fn target_error_is_reported_as_before_filtering() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let said = run(&folder, "render small.toml --denoise --error 10% -o it.png");
    assert_eq!(said.code, 0, "{}", said.stderr);
    for word in ["before filtering", "filtered by nlm"] {
        assert!(said.stderr.contains(word), "{}", said.stderr);
    }
}
