//! `etendue compare`: its numbers, its exit codes, its map, and its test for bias on real renders with and without bias.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, USAGE, fails, run, succeed};
use etendue::internals::image::{ColourSpace, Image, Layer, LayeredImage, WriteOptions, write};
use etendue::internals::math::rgb::Rgb;
use serde_json::Value;

const NO_FILES: [(&str, &str); 0] = [];

/// A matte floor and ceiling with a large lamp between them: noisy everywhere, but without rare events.
const MATTE: &str = r#"version = 1
[camera]
eye = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, -1]
fov = 30

[film]
size = [32, 24]
filter = "box"

[[material]]
name = "grey"
type = "diffuse"
reflectance = [0.5, 0.4, 0.3]

[[shape]]
type = "rectangle"
material = "grey"
corner = [-9, 0, 9]
edge_u = [18, 0, 0]
edge_v = [0, 0, -18]

[[shape]]
type = "rectangle"
emission = 3
corner = [-2, 6, -2]
edge_u = [4, 0, 0]
edge_v = [0, 0, 4]

[[shape]]
type = "rectangle"
material = "grey"
corner = [-9, 7, -9]
edge_u = [18, 0, 0]
edge_v = [0, 0, 18]
"#;

/// An image of 64 x 40 pixels of `factor` times (1, 0.5, 0.25); `at` replaces one pixel.
fn constant(factor: f32, at: Option<(u32, u32, Rgb)>) -> Image {
    let mut image = Image::filled(64, 40, factor * Rgb::new(1.0, 0.5, 0.25));
    if let Some((x, y, pixel)) = at {
        image.pixels_mut()[(y * 64 + x) as usize] = pixel;
    }
    image
}

fn save(folder: &SceneFolder, name: &str, image: &Image) {
    write(&folder.path(name), image, &WriteOptions::default()).expect("written");
}

fn json(folder: &SceneFolder, arguments: &str) -> Value {
    let stdout = succeed(folder, &format!("compare {arguments} --json")).stdout;
    serde_json::from_str(&stdout).expect("an object")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is a number"))
}

#[test]
fn compare_metrics_match_closed_forms() {
    let folder = SceneFolder::new(NO_FILES);
    save(&folder, "r.pfm", &constant(1.0, None));
    save(&folder, "brighter.exr", &constant(1.25, None));
    let it = json(&folder, "brighter.exr r.pfm");
    let close = |name: &str, exact: f64| {
        let found = number(&it[name]);
        assert!(
            (found / exact - 1.0).abs() < 1e-9,
            "{name}: {found} {exact}"
        );
    };
    // mean(r) = 1.75 / 3; each channel is off by a quarter of itself.
    let epsilon = 0.01 * (1.75_f64 / 3.0).powi(2);
    let squares = [1.0_f64, 0.5, 0.25].map(|r| r * r);
    let mse = squares.iter().sum::<f64>() / 3.0 / 16.0;
    let rel_mse = squares
        .map(|r2| r2 / 16.0 / (r2 + epsilon))
        .iter()
        .sum::<f64>()
        / 3.0;
    close("mse", mse);
    close("rmse", mse.sqrt());
    close("rel_mse", rel_mse);
    close("rel_rmse", rel_mse.sqrt());
    close("trimmed_rel_mse", rel_mse);
    for channel in 0..3 {
        assert!((number(&it["mean_differences"][channel]) - 0.25).abs() < 1e-12);
    }
    // The tiles at the bottom have 8 rows of 40.
    let tiles = it["tiles"].as_array().expect("a list");
    let shares: Vec<f64> = tiles.iter().map(|tile| number(&tile["share"])).collect();
    for (share, exact) in shares.iter().zip([0.4, 0.4, 0.1, 0.1]) {
        assert!((share - exact).abs() < 1e-9, "{shares:?}");
    }
    assert_eq!(it["bias"], Value::Null);
    assert_eq!((&it["width"], &it["height"]), (&64.into(), &40.into()));
    assert_eq!(it["verdict"]["metric"], "rel-rmse");
}

#[test]
fn firefly_dominates_worst_tile_but_not_trimmed_error() {
    let folder = SceneFolder::new(NO_FILES);
    save(&folder, "r.exr", &constant(1.0, None));
    save(
        &folder,
        "a.exr",
        &constant(1.0, Some((40, 33, Rgb::grey(90.0)))),
    );
    let it = json(&folder, "a.exr r.exr --tile 8");
    assert_eq!(number(&it["trimmed_rel_mse"]), 0.0);
    assert!(number(&it["rel_mse"]) > 1.0);
    let worst = &it["tiles"][0];
    assert_eq!((&worst["x"], &worst["y"]), (&40.into(), &32.into()));
    assert_eq!(number(&worst["share"]), 1.0);

    let table = succeed(&folder, "compare a.exr r.exr").stdout;
    for words in ["a.exr against r.exr", "| rel-rmse", "Worst tiles", "100 %"] {
        assert!(table.contains(words), "no `{words}` in {table}");
    }
}

#[test]
fn exit_code_reflects_the_tolerance() {
    let folder = SceneFolder::new(NO_FILES);
    save(&folder, "r.exr", &constant(1.0, None));
    save(&folder, "a.exr", &constant(1.01, None));
    let code = |flags: &str| {
        let finished = run(&folder, &format!("compare a.exr r.exr -q {flags}"));
        assert_eq!((&*finished.stdout, &*finished.stderr), ("", ""), "{flags}");
        finished.code
    };
    assert_eq!(code(""), 0);
    assert_eq!((code("--tolerance 1%"), code("--tolerance 0.9%")), (0, 1));
    let rmse = "--metric rmse --tolerance";
    assert_eq!(
        (
            code(&format!("{rmse} 0.0067")),
            code(&format!("{rmse} 0.0066"))
        ),
        (0, 1)
    );
    let trimmed = "--metric trimmed-rel-rmse --tolerance";
    assert_eq!(
        (
            code(&format!("{trimmed} 1%")),
            code(&format!("{trimmed} 0"))
        ),
        (0, 1)
    );
    assert_eq!(run(&folder, "compare r.exr r.exr -q --tolerance 0").code, 0);

    let above = run(&folder, "compare a.exr r.exr --tolerance 0.5%");
    assert_eq!(above.code, 1);
    assert!(above.stderr.contains("rel-rmse 0.9"), "{}", above.stderr);
    assert!(
        above.stderr.contains("is above the tolerance 0.500 %"),
        "{}",
        above.stderr
    );
    let failed = run(&folder, "compare a.exr r.exr --tolerance 0.5% --json");
    let it: Value = serde_json::from_str(&failed.stdout).expect("an object");
    assert_eq!(
        (failed.code, &it["verdict"]["passed"]),
        (1, &Value::Bool(false))
    );

    // Against a black reference the error is infinite, above any tolerance.
    save(&folder, "black.exr", &Image::filled(64, 40, Rgb::BLACK));
    assert_eq!(
        run(&folder, "compare a.exr black.exr -q --tolerance 1e300").code,
        1
    );
    assert_eq!(
        run(&folder, "compare black.exr black.exr --tolerance 0").code,
        0
    );
}

#[cfg(feature = "flip")]
#[test]
fn flip_metric_depends_on_exposure() {
    let folder = SceneFolder::new(NO_FILES);
    save(&folder, "r.exr", &constant(8.0, None));
    save(&folder, "a.exr", &constant(16.0, None));
    let flip = |flags: &str| number(&json(&folder, &format!("a.exr r.exr {flags}"))["flip"]);
    assert_eq!(flip(""), 0.0);
    assert!(flip("--exposure -4") > 0.1);
    let code = |flags: &str| run(&folder, &format!("compare a.exr r.exr -q {flags}")).code;
    assert_eq!(code("--metric flip --tolerance 0"), 0);
    assert_eq!(code("--metric flip --tolerance 0.1 --exposure -4"), 1);
}

#[test]
fn every_image_format_compares_with_every_other() {
    let folder = SceneFolder::new(NO_FILES);
    let image = constant(1.0, Some((3, 4, Rgb::BLACK)));
    let names = ["a.exr", "a.png", "a.hdr", "a.pfm"];
    for name in names {
        save(&folder, name, &image);
    }
    for (a, b) in names.iter().flat_map(|a| names.map(|b| (*a, b))) {
        // A PNG rounds by half a code of 255, an HDR by one part in 256 of the largest channel.
        let it = json(&folder, &format!("{a} {b}"));
        assert!(number(&it["rel_rmse"]) < 0.01, "{a} {b}: {it}");
    }
}

#[test]
fn error_map_colours_too_dark_and_too_bright_pixels() {
    let folder = SceneFolder::new(NO_FILES);
    save(&folder, "r.exr", &constant(1.0, None));
    let mut image = constant(1.0, Some((10, 20, Rgb::grey(2.0))));
    image.pixels_mut()[64 * 5 + 30] = Rgb::grey(0.1);
    save(&folder, "a.exr", &image);
    let shown = |flags: &str| {
        let finished = succeed(
            &folder,
            &format!("compare a.exr r.exr --map it.png {flags}"),
        );
        let map = Image::read(&folder.path("it.png"), ColourSpace::Srgb).expect("an image");
        assert_eq!((map.width(), map.height()), (64, 40));
        (map, finished.stderr)
    };
    let (map, said) = shown("--scale 0.5");
    let [bright, dark, right] = [(10, 20), (30, 5), (0, 0)].map(|(x, y)| map.get(x, y).to_array());
    assert!(bright[0] > 3.0 * bright[2], "{bright:?}");
    assert!(dark[2] > 3.0 * dark[0], "{dark:?}");
    assert!(right.iter().all(|channel| *channel > 0.8), "{right:?}");
    assert!(
        said.contains("it.png") && said.contains("0.5 (red"),
        "{said}"
    );
    // The file contains the description of the map.
    let bytes = std::fs::read(folder.path("it.png")).expect("read");
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("a.exr against r.exr") && text.contains("0.5 (red"));

    // Two pixels in 2560 are less than 1 %: the default scale is that of the greater of them.
    let it = json(&folder, "a.exr r.exr --map it.png");
    let greatest = number(&it["map"]["scale"]);
    let (paler, _) = shown("--scale 1000");
    assert!(greatest > 3.0 && greatest < 6.0, "{greatest}");
    assert!(
        paler
            .get(10, 20)
            .to_array()
            .iter()
            .all(|channel| *channel > 0.8)
    );
}

#[test]
fn invalid_comparisons_are_rejected_with_a_message() {
    let folder = SceneFolder::new([("text.exr", "no image")]);
    save(&folder, "r.exr", &constant(1.0, None));
    save(&folder, "small.png", &Image::filled(8, 8, Rgb::WHITE));
    save(
        &folder,
        "nan.pfm",
        &constant(1.0, Some((7, 3, Rgb::grey(f32::NAN)))),
    );
    for (arguments, code, words) in [
        ("small.png r.exr", USAGE, &["8 x 8 and 64 x 40", "crop"][..]),
        (
            "missing.exr r.exr",
            INPUT_OUTPUT,
            &["missing.exr: cannot read"],
        ),
        (
            "r.exr missing.exr",
            INPUT_OUTPUT,
            &["missing.exr: cannot read"],
        ),
        ("r.exr .", INPUT_OUTPUT, &["not a regular file"]),
        ("text.exr r.exr", INPUT_OUTPUT, &["text.exr: not an image"]),
        (
            "r.exr nan.pfm",
            INPUT_OUTPUT,
            &["nan.pfm", "pixel (7, 3)", "finite"],
        ),
        (
            "r.exr r.exr --map no/map.png",
            INPUT_OUTPUT,
            &["no/map.png", "no such folder"],
        ),
        ("r.exr r.exr --map .", USAGE, &["--map", ".png"]),
        (
            "r.exr r.exr --map map.jpg",
            USAGE,
            &["--map", "map.jpg", ".png"],
        ),
        ("r.exr r.exr --scale 2", USAGE, &["--map"]),
        (
            "r.exr r.exr --map map.png --scale 0",
            USAGE,
            &["--scale", "above 0"],
        ),
        (
            "r.exr r.exr --tolerance -1",
            USAGE,
            &["--tolerance", "of at least 0"],
        ),
        (
            "r.exr r.exr --tolerance nan",
            USAGE,
            &["--tolerance", "of at least 0"],
        ),
        (
            "r.exr r.exr --metric psnr",
            USAGE,
            &["--metric", "rel-rmse"],
        ),
        (
            "r.exr r.exr --exposure 1e9",
            USAGE,
            &["--exposure", "stops"],
        ),
        ("r.exr r.exr --tile 0", USAGE, &["--tile"]),
        ("r.exr r.exr -q --json", USAGE, &["--json"]),
        ("r.exr", USAGE, &["REFERENCE"]),
    ] {
        fails(&folder, &format!("compare {arguments}"), code, words);
    }
}

#[test]
fn incomplete_or_invalid_error_layers_are_rejected() {
    let folder = SceneFolder::new(NO_FILES);
    save(&folder, "r.exr", &constant(1.0, None));
    let layer = |name: &str, value: f32| Layer {
        name: name.to_owned(),
        samples: vec![value; 64 * 40],
    };
    for (name, layers) in [
        ("half.exr", vec![layer("se.R", 0.1)]),
        (
            "wrong.exr",
            ["se.R", "se.G", "se.B"]
                .map(|name| layer(name, -0.1))
                .into(),
        ),
    ] {
        let options = WriteOptions {
            layers,
            ..WriteOptions::default()
        };
        write(&folder.path(name), &constant(1.0, None), &options).expect("written");
    }
    fails(
        &folder,
        "compare half.exr r.exr",
        INPUT_OUTPUT,
        &["half.exr", "se.G", "etendue render --layers"],
    );
    fails(
        &folder,
        "compare r.exr wrong.exr",
        INPUT_OUTPUT,
        &["wrong.exr", "standard error of pixel (0, 0)"],
    );
}

#[test]
fn bias_test_accepts_other_seeds_and_detects_one_percent_bias() {
    let folder = SceneFolder::new([("matte.toml", MATTE)]);
    for seed in [1, 2] {
        let flags =
            format!("--spp 1024 --sampler independent --seed {seed} --layers -q -o {seed}.exr");
        succeed(&folder, &format!("render matte.toml {flags}"));
    }
    let it = json(&folder, "1.exr 2.exr");
    let bias = &it["bias"];
    assert!(number(&bias["tested"]) > 0.9, "{bias}");
    assert!(
        number(&bias["p"]) > 1e-4 && number(&bias["tiles_p"]) > 1e-4,
        "{bias}"
    );
    assert_eq!(it["notes"], Value::Array(Vec::new()));
    for channel in 0..3 {
        let detectable = number(&bias["channels"][channel]["detectable"]);
        assert!(detectable > 0.0 && detectable < 0.004, "{detectable}");
    }
    // Both are equally noisy: half of the squared error is the reference's.
    let share = number(&it["reference_noise"]) / number(&it["rel_mse"]);
    assert!((0.4..0.6).contains(&share), "{share}");

    // Brighter by 1 %, more than twice the bias that is detected with a probability of 90 %.
    let read = LayeredImage::read(&folder.path("1.exr"), ColourSpace::Srgb).expect("an image");
    let brighter = read.image.pixels().iter().map(|&pixel| 1.01 * pixel);
    let brighter = Image::new(32, 24, brighter.collect());
    let options = WriteOptions {
        layers: read.layers,
        ..WriteOptions::default()
    };
    write(&folder.path("brighter.exr"), &brighter, &options).expect("written");
    let bias = &json(&folder, "brighter.exr 2.exr")["bias"];
    assert!(number(&bias["p"]) < 1e-3, "{bias}");
    let said = succeed(&folder, "compare brighter.exr 2.exr").stdout;
    assert!(said.contains("converge to different limits"), "{said}");

    // A bounce limit leaves out the indirect light from the ceiling.
    succeed(
        &folder,
        "render matte.toml --spp 1024 --seed 3 --max-bounces 1 --layers -q -o direct.exr",
    );
    let bias = &json(&folder, "direct.exr 2.exr")["bias"];
    assert!(number(&bias["p"]) < 1e-6, "{bias}");
    let worst = &bias["worst_tile"];
    assert!(number(&worst["difference"]) < 0.0, "{worst}");
}

#[test]
fn bias_test_warns_about_equal_seeds_and_missing_layers() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    for (spp, name) in [(16, "a"), (32, "b")] {
        succeed(
            &folder,
            &format!("render small.toml --spp {spp} --layers -q -o {name}.exr"),
        );
    }
    let said = succeed(&folder, "compare a.exr b.exr").stderr;
    assert!(
        said.contains("seed 0") && said.contains("not independent"),
        "{said}"
    );
    let quiet = succeed(&folder, "compare a.exr b.exr -q");
    assert_eq!((quiet.stdout, quiet.stderr), (String::new(), String::new()));
    // An image without layers has no standard errors; the command says how to get them.
    succeed(&folder, "render small.toml -q -o plain.exr");
    let plain = succeed(&folder, "compare plain.exr plain.exr").stdout;
    assert!(plain.contains("etendue render --layers"), "{plain}");
}
