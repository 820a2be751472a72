//! The layers of an EXR hold the standard error and the first-hit features of each pixel; a requested error is reached, or
//! the command reports that it was not.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{fails, run, succeed};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A floor seen from above from a height of 5, half of it red, and nothing around it.
const FLOOR: &str = r#"version = 1
[camera]
eye = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov = 40

[film]
size = [24, 16]
filter = "box"

[[material]]
name = "red"
type = "diffuse"
reflectance = [0.5, 0.25, 0.125]

[[material]]
name = "glass"
type = "dielectric"

[[shape]]
type = "rectangle"
material = "red"
corner = [-2.5, 0, 1.5]
edge_u = [2.5, 0, 0]
edge_v = [0, 0, -3]

[[shape]]
type = "rectangle"
material = "glass"
corner = [0, 0, 1.5]
edge_u = [2.5, 0, 0]
edge_v = [0, 0, -3]

[[light]]
type = "environment"
radiance = 1
"#;

fn channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .expect("it is an EXR");
    let channels = image.layer_data.channel_data.list.into_iter();
    channels
        .map(|channel| {
            let FlatSamples::F32(samples) = channel.sample_data else {
                panic!("channels are floats");
            };
            (channel.name.to_string(), samples)
        })
        .collect()
}

#[test]
fn exr_layers_contain_the_named_quantities() {
    let folder = SceneFolder::new([("floor.toml", FLOOR)]);
    succeed(
        &folder,
        "render floor.toml --spp 1001 --sampler independent --roulette none --max-bounces 9 --layers -o it.exr",
    );
    let channels = channels(&folder.path("it.exr"));
    let names: Vec<&str> = channels.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "B",
            "G",
            "R",
            "albedo.B",
            "albedo.G",
            "albedo.R",
            "depth.Z",
            "flag.Y",
            "freedom.Y",
            "half.B",
            "half.G",
            "half.R",
            "normal.X",
            "normal.Y",
            "normal.Z",
            "se.B",
            "se.G",
            "se.R",
            "se.albedo",
            "se.depth",
            "se.normal",
            "spp.Y"
        ]
    );
    let at = |name: &str, x: usize, y: usize| channels[name][24 * y + x];
    // Red on the left, glass on the right, nothing in the corner.
    let [red, glass, nothing] = [(6, 8), (14, 8), (0, 0)];
    let albedo = |(x, y)| ["R", "G", "B"].map(|c| at(&format!("albedo.{c}"), x, y));
    assert_eq!(albedo(red), [0.5, 0.25, 0.125]);
    for share in albedo(glass) {
        assert!((share - 1.0).abs() < 1e-5, "{share}");
    }
    assert_eq!(albedo(nothing), [0.0; 3]);
    for (x, y) in [red, glass] {
        let normal = ["X", "Y", "Z"].map(|c| at(&format!("normal.{c}"), x, y));
        assert_eq!(normal, [0.0, 1.0, 0.0]);
        assert!((5.0..5.4).contains(&at("depth.Z", x, y)));
    }
    assert_eq!(at("depth.Z", nothing.0, nothing.1), f32::INFINITY);
    // All samples of the pixel have one albedo and one normal, at distances that differ a little.
    let (x, y) = red;
    assert_eq!([at("se.albedo", x, y), at("se.normal", x, y)], [0.0; 2]);
    assert!((1e-5..1e-2).contains(&at("se.depth", x, y)));
    // The half image has half of the samples: a noisy pixel differs a little.
    let (x, y) = glass;
    let (half, whole) = (at("half.R", x, y), at("R", x, y));
    assert!(half != whole && (half - whole).abs() < 6.0 * at("se.R", x, y));
    // 1001 samples are rounded up to 1004, four equal batches.
    assert!(channels["spp.Y"].iter().all(|&n| n == 1004.0));
    // An unoccluded diffuse surface has no noise under a white sky; glass chooses between reflection and transmission.
    let [still, noisy] = [red, glass].map(|(x, y)| at("se.R", x, y));
    assert!(still < 1e-6 && noisy > 1e-3, "{still} {noisy}");
    assert!(
        channels["flag.Y"]
            .iter()
            .all(|flag| [0.0, 1.0].contains(flag))
    );
    assert!((at("R", red.0, red.1) - 0.5).abs() < 1e-6);
}

#[test]
fn standard_errors_match_variance_between_seeds() {
    // A matte floor and a lamp beside it.
    let before_glass = FLOOR.split("[[shape]]").take(2).collect::<Vec<_>>();
    let lamp = "\nmaterial = \"red\"\ntype = \"rectangle\"\nemission = 3\ncorner = [-3, 2.1, -1]\n\
                edge_u = [0, 0, 2]\nedge_v = [0, -2, 0]\n";
    let lamp = format!("{}[[shape]]{lamp}", before_glass.join("[[shape]]"));
    let folder = SceneFolder::new([("small.toml", lamp)]);
    let mut sums = vec![[0.0_f64; 3]; 24 * 16];
    let mut flagged = vec![false; 24 * 16];
    let seeds = 24;
    for seed in 0..seeds {
        let flags = format!("--spp 512 --seed {seed} --layers -q -o it.exr");
        succeed(&folder, &format!("render small.toml {flags}"));
        let channels = channels(&folder.path("it.exr"));
        for (i, sums) in sums.iter_mut().enumerate() {
            let [x, se] = ["G", "se.G"].map(|name| f64::from(channels[name][i]));
            sums[0] += x;
            sums[1] += x * x;
            sums[2] += se * se;
            flagged[i] |= channels["flag.Y"][i] > 0.0;
        }
    }
    // The mean of the squared standard errors is the variance between seeds: over all unflagged pixels, within the noise
    // of both.
    let n = f64::from(seeds);
    let sums = sums
        .iter()
        .zip(flagged)
        .filter(|(s, flagged)| !flagged && s[0] > 0.0);
    let sums: Vec<[f64; 3]> = sums.map(|(sums, _)| *sums).collect();
    assert!(sums.len() > 20, "{}", sums.len());
    let between: f64 = sums
        .iter()
        .map(|s| (s[1] - s[0] * s[0] / n) / (n - 1.0))
        .sum();
    let told: f64 = sums.iter().map(|s| s[2] / n).sum();
    assert!(
        (told / between - 1.0).abs() < 0.3,
        "variance: {told} stated, {between} between seeds"
    );
}

#[test]
fn target_error_is_reached_or_reported_as_missed() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let stats = |flags: &str, code: i32| -> Value {
        let finished = run(
            &folder,
            &format!("render small.toml {flags} --json -o it.png"),
        );
        assert_eq!(finished.code, code, "{}", finished.stderr);
        serde_json::from_str(&finished.stdout).expect("an object")
    };
    let reached = stats("--error 1% --seed 4", 0);
    assert_eq!(reached["target"]["reached"], true);
    let error = reached["error"]["rel_rmse"].as_f64().expect("a number");
    assert!(error < 0.01 && error > 0.0025, "{error}");
    let predicted = &reached["target"]["predicted"]["spp"];
    let ratio = predicted.as_f64().expect("a number") / reached["spp"].as_f64().expect("a number");
    assert!((0.5..2.0).contains(&ratio), "{ratio}");

    let missed = stats("--error 0.1% --spp 64", 5);
    assert_eq!(
        (&missed["target"]["reached"], &missed["spp"]),
        (&Value::Bool(false), &Value::from(64))
    );
    let late = run(
        &folder,
        "render small.toml --error 0.01% --max-time 0.3s -o it.png",
    );
    assert_eq!(late.code, 5);
    assert!(late.stderr.contains("was not reached"), "{}", late.stderr);
}

#[test]
fn invalid_error_and_layer_flags_are_rejected() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    for (flags, words) in [
        ("--error 0", &["--error", "above 0 and below 1"]),
        ("--error 100%", &["--error", "above 0 and below 1"]),
        ("--error nan", &["--error", "above 0 and below 1"]),
        (
            "--error 1% --confidence 100%",
            &["--confidence", "above 0 and below 1"],
        ),
        ("--error 1% --time 3s", &["--error", "--time"]),
        ("--max-time 3s", &["--error", "--max-time"]),
        ("--layers", &["--layers", ".exr"]),
    ] {
        fails(&folder, &format!("render small.toml {flags}"), 2, words);
    }
}
