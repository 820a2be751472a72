//! Tests of the command: subcommands, flags, and what is printed to which stream.

use crate::common::scene_folder::{SMALL, SceneFolder, in_repository};
use crate::support::{Finished, command, interrupted, run, succeed};
use etendue::internals::image::{ColourSpace, Image};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::auto::LightPathChoice;
use exr::prelude::{AttributeValue, MetaData};
use serde_json::Value;

fn small() -> SceneFolder {
    SceneFolder::new([("small.toml", SMALL)])
}

/// Renders the small scene into an EXR file.
fn render(folder: &SceneFolder, flags: &str) -> Image {
    succeed(folder, &format!("render small.toml -q -o it.exr {flags}"));
    read(folder, "it.exr")
}

fn read(folder: &SceneFolder, name: &str) -> Image {
    Image::read(&folder.path(name), ColourSpace::Srgb).unwrap_or_else(|error| panic!("{error}"))
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("valid JSON")
}

/// The keys of a JSON object in order; those of nested objects follow their parent's key and a dot.
fn names(value: &Value) -> Vec<String> {
    let object = value.as_object().expect("a JSON object");
    let mut names: Vec<String> = object
        .iter()
        .flat_map(|(name, value)| match value {
            Value::Object(_) => names(value).iter().map(|n| format!("{name}.{n}")).collect(),
            _ => vec![name.clone()],
        })
        .collect();
    names.sort();
    names
}

fn last_line(finished: &Finished) -> &str {
    finished
        .stderr
        .lines()
        .last()
        .expect("something was printed")
}

/// The attributes of an EXR file, as text.
fn metadata(folder: &SceneFolder, name: &str) -> Vec<(String, String)> {
    let facts = MetaData::read_from_file(folder.path(name), false).expect("an EXR file");
    let header = &facts.headers[0];
    let all = header
        .shared_attributes
        .other
        .iter()
        .chain(&header.own_attributes.other);
    let mut facts: Vec<_> = all
        .map(|(name, value)| {
            let value = match value {
                AttributeValue::Text(text) => text.to_string(),
                AttributeValue::F64(number) => number.to_string(),
                other => panic!("{name} is {other:?}"),
            };
            (name.to_string(), value)
        })
        .collect();
    facts.sort();
    facts
}

#[test]
fn every_output_format_contains_the_same_image() {
    let folder = small();
    let outputs = ["a.exr", "a.pfm", "a.hdr", "a.png"];
    let finished = succeed(
        &folder,
        &format!("render small.toml -o {}", outputs.join(" -o ")),
    );
    assert_eq!(finished.stdout, "");
    assert_eq!(
        folder.listing(),
        ["a.exr", "a.hdr", "a.pfm", "a.png", "small.toml"]
    );
    let [exr, pfm, hdr, png] = outputs.map(|name| read(&folder, name));
    assert_eq!((exr.width(), exr.height()), (24, 16));
    assert_eq!(exr, pfm);
    for (other, tolerance) in [(&hdr, 0.01), (&png, 0.01)] {
        for (got, want) in other.pixels().iter().zip(exr.pixels()) {
            // PNG clips at 1; with a shared exponent, precision is relative to the largest channel.
            let want = if std::ptr::eq(other, &png) {
                want.map(|x| x.min(1.0))
            } else {
                *want
            };
            let distance = (*got - want).map(f32::abs).max_channel();
            assert!(
                distance <= tolerance * want.max_channel().max(1.0),
                "{got:?} {want:?}"
            );
        }
    }
}

#[test]
fn default_output_is_named_after_the_scene() {
    let folder = small();
    succeed(&folder, "render small.toml --spp 1 --size 5x4");
    assert_eq!(folder.listing(), ["small.png", "small.toml"]);
    let picture = read(&folder, "small.png");
    assert_eq!((picture.width(), picture.height()), (5, 4));
}

#[test]
fn statistics_json_has_the_stable_field_names() {
    let folder = small();
    let arguments = "render small.toml --spp 8 --seed 3 -t 1 --json --stats it.json -o it.exr";
    let finished = succeed(&folder, arguments);
    let printed = json(&finished.stdout);
    let written = std::fs::read_to_string(folder.path("it.json")).expect("the file was written");
    assert_eq!(printed, json(&written));
    for name in "version scene width height spp integrator sampler backend precision quality seed threads time.load \
                 time.build time.render time.write time.total samples rays.camera rays.closest rays.shadow \
                 samples_per_second rays_per_second memory.peak_rss memory.accel error.rel_rmse error.confidence \
                 error.uncalibrated_fraction rejected.count rejected.first image.mean bias"
        .split_whitespace()
    {
        assert!(names(&printed).iter().any(|known| known == name), "no {name} in {printed}");
    }
    let counts = ["width", "height", "spp", "seed", "threads", "samples"];
    let counts = counts.map(|name| printed[name].as_u64().expect(name));
    assert_eq!(counts, [24, 16, 8, 3, 1, 24 * 16 * 8]);
    // The filter lets samples of one more pixel on each side contribute.
    assert_eq!(printed["rays"]["camera"], 26 * 18 * 8);
    assert_eq!(printed["rejected"]["count"], 0);
    assert_eq!(printed["bias"], json("[]"));
    assert_eq!(printed["interrupted"], false);
    assert_eq!(printed["image"]["mean"].as_array().map(Vec::len), Some(3));
    let picture = read(&folder, "it.exr");
    let red: f64 = picture
        .pixels()
        .iter()
        .map(|p| f64::from(p.to_array()[0]))
        .sum();
    let mean = printed["image"]["mean"][0].as_f64().expect("a number");
    assert!((red / (24.0 * 16.0) - mean).abs() < 1e-6 * mean);
}

#[test]
fn last_line_reports_the_result() {
    let folder = small();
    let finished = succeed(&folder, "render small.toml --spp 8 -o it.exr");
    for words in [
        "it.exr: ",
        "24 x 16 pixels",
        "8 spp in ",
        "samples/s",
        "error ",
    ] {
        assert!(
            last_line(&finished).contains(words),
            "{words}: {}",
            finished.stderr
        );
    }
    assert!(!finished.stderr.contains("biased"));
    // With more samples the line has an error bound and the cost of a smaller error; with this seed, as rare paths through
    // the glass leave no bound in most renders.
    let finished = succeed(&folder, "render small.toml --spp 16384 --seed 7 -o it.exr");
    for words in ["(below ", "at 95 % confidence)", "would take "] {
        assert!(
            last_line(&finished).contains(words),
            "{words}: {}",
            finished.stderr
        );
    }
    let verbose = succeed(&folder, "render small.toml --spp 8 -v -o it.exr").stderr;
    for words in ["4 shapes", "4 materials", "time: load"] {
        assert!(verbose.contains(words), "{words}: {verbose}");
    }
    let quiet = succeed(&folder, "render small.toml --spp 8 -q -o it.exr");
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}

#[test]
fn exr_metadata_records_render_settings() {
    let folder = small();
    render(
        &folder,
        "--spp 8 --seed 5 --sampler independent --max-bounces 2",
    );
    let facts = metadata(&folder, "it.exr");
    let fact = |name: &str| {
        let name = format!("etendue.{name}");
        let found = facts.iter().find(|(known, _)| *known == name);
        &found.unwrap_or_else(|| panic!("no {name} in {facts:?}")).1
    };
    assert_eq!(
        fact("version"),
        concat!("etendue ", env!("CARGO_PKG_VERSION"))
    );
    assert!(fact("command").ends_with("--sampler independent --max-bounces 2"));
    let short = ["scene", "seed", "integrator", "sampler", "spp"].map(fact);
    assert_eq!(short, ["small.toml", "5", "path", "independent", "8"]);
    assert!(fact("bias").contains("max_bounces 2"), "{}", fact("bias"));
    for number in ["seconds", "relRmse"] {
        assert!(
            fact(number).parse::<f64>().is_ok_and(|x| x > 0.0),
            "{number}"
        );
    }
    render(&folder, "--spp 8");
    assert!(metadata(&folder, "it.exr").contains(&("etendue.bias".to_owned(), "none".to_owned())));
}

#[test]
fn biased_settings_are_reported() {
    let folder = small();
    let finished = succeed(
        &folder,
        "render small.toml --integrator direct-area --roulette none",
    );
    let line = last_line(&finished);
    assert!(
        line.contains("biased by direct-area: light that scatters more"),
        "{line}"
    );
    let finished = succeed(&folder, "render small.toml --max-bounces 1 --json");
    assert!(
        last_line(&finished).contains("biased by max_bounces 1"),
        "{}",
        finished.stderr
    );
    let bias = &json(&finished.stdout)["bias"];
    assert!(
        bias[0]
            .as_str()
            .is_some_and(|bias| bias.contains("max_bounces 1")),
        "{bias}"
    );
    let finished = succeed(&folder, "render small.toml --max-bounces none --json");
    let bias = &json(&finished.stdout)["bias"];
    assert!(bias.as_array().is_some_and(Vec::is_empty), "{bias}");
}

#[test]
fn crop_pixels_are_bit_identical_to_the_full_image() {
    let folder = small();
    // The light paths of a crop are its own.
    let whole = render(&folder, "--light-paths off");
    for (crop, [x0, y0, x1, y1]) in [("0,0,24,16", [0, 0, 24, 16]), ("5,3,9,16", [5, 3, 9, 16])] {
        let part = render(&folder, &format!("--light-paths off --crop {crop}"));
        assert_eq!((part.width(), part.height()), (x1 - x0, y1 - y0));
        for y in y0..y1 {
            for x in x0..x1 {
                assert_eq!(part.get(x - x0, y - y0), whole.get(x, y), "{x},{y}");
            }
        }
    }
}

#[test]
fn image_depends_on_seed_but_not_on_thread_count() {
    let folder = small();
    let base = render(&folder, "--threads 1");
    assert_eq!(render(&folder, "--threads 2"), base);
    assert_ne!(render(&folder, "--seed 1"), base);
}

#[test]
fn images_of_all_backends_and_precisions_agree() {
    let folder = small();
    let base = render(&folder, "--spp 64");
    let info = json(&succeed(&folder, "info --json").stdout);
    let backends = info["backends"].as_array().expect("a list").clone();
    assert!(
        backends
            .iter()
            .any(|name| name.as_str().is_some_and(|n| n.starts_with("obvhs")))
    );
    for backend in backends.iter().filter_map(Value::as_str) {
        for precision in ["robust", "fast"] {
            let flags = format!("--spp 64 --backend {backend} --precision {precision}");
            let picture = render(&folder, &flags);
            let error =
                etendue::internals::image::metrics::rel_mse(&picture, &base).expect("same size");
            // Rounding differs between them, so a few paths diverge; wrong hits would give errors of the order of one.
            assert!(error.sqrt() < 0.05, "{flags}: {}", error.sqrt());
        }
    }
}

#[test]
fn time_limited_render_completes() {
    let finished = succeed(&small(), "render small.toml --time 0.3s --json");
    let spp = json(&finished.stdout)["spp"].as_u64().expect("a count");
    assert!(spp >= 1);
}

#[cfg(unix)]
#[test]
fn interrupted_render_writes_its_samples() {
    let folder = small();
    let arguments = "render small.toml --spp 100000000 -o it.exr --json";
    let child = command(&folder, arguments)
        .spawn()
        .expect("the command starts");
    // Much longer than loading takes, so that the render is running. The handler is installed before the first sample.
    std::thread::sleep(std::time::Duration::from_secs(2));
    let finished = interrupted(child);
    assert!(
        last_line(&finished).contains("interrupted"),
        "{}",
        finished.stderr
    );
    let stats = json(&finished.stdout);
    assert_eq!(stats["interrupted"], true);
    assert!(stats["spp"].as_u64().is_some_and(|spp| spp >= 1), "{stats}");
    assert!(
        read(&folder, "it.exr")
            .pixels()
            .iter()
            .any(|pixel| !pixel.is_black())
    );
}

#[test]
fn replayed_sample_matches_the_rendered_pixel() {
    let folder = small();
    for (x, y, integrator) in [
        (4, 3, "path"),
        (8, 9, "path"),
        (15, 8, "naive"),
        (12, 15, "light-or-rest"),
        (12, 14, "ambient-occlusion"),
    ] {
        // A pixel of a box filter is its sample; others are sums over the samples of several pixels.
        let flags = format!("--spp 1 --filter box --integrator {integrator}");
        let crop = format!("{flags} --crop {x},{y},{},{}", x + 1, y + 1);
        let [r, g, b] = render(&folder, &crop).get(0, 0).to_array();
        let finished = succeed(
            &folder,
            &format!("render small.toml {flags} --pixel {x},{y} --sample 0"),
        );
        let text = &finished.stdout;
        assert!(
            text.starts_with(&format!("pixel {x},{y} sample 0\n")),
            "{text}"
        );
        assert!(
            text.contains("vertex 0: ") || text.contains("left the scene"),
            "{text}"
        );
        assert!(
            text.ends_with(&format!("radiance ({r:.6}, {g:.6}, {b:.6})\n")),
            "{text}"
        );
    }
    assert_eq!(folder.listing(), ["it.exr", "small.toml"]);
}

#[test]
fn exposure_affects_png_but_not_exr() {
    let folder = small();
    succeed(
        &folder,
        "render small.toml --exposure -100 -o it.png -o it.exr",
    );
    assert!(
        read(&folder, "it.png")
            .pixels()
            .iter()
            .all(|pixel| *pixel == Rgb::BLACK)
    );
    assert!(
        read(&folder, "it.exr")
            .pixels()
            .iter()
            .any(|pixel| !pixel.is_black())
    );
}

#[test]
fn info_help_man_and_completions_are_printed() {
    let folder = SceneFolder::new::<&str>([]);
    let caption = |arguments: &str, words: &[&str]| {
        let text = succeed(&folder, arguments).stdout;
        for word in words {
            assert!(text.contains(word), "{arguments}: no `{word}` in {text}");
        }
    };
    let version = env!("CARGO_PKG_VERSION");
    caption("info", &[version, "backends", "obvhs", "threads"]);
    let info = json(&succeed(&folder, "info --json").stdout);
    assert_eq!(info["version"], version);
    assert!(info["threads"].as_u64().is_some_and(|threads| threads >= 1));
    caption("--help", &["render", "info", "completions", "man"]);
    caption("--version", &[version]);
    caption(
        "render --help",
        &["--spp", "--crop", "--pixel", "--max-bounces"],
    );
    caption("completions bash", &["_etendue", "--max-bounces"]);
    caption("completions zsh", &["#compdef etendue", "--max-bounces"]);
    caption("completions fish", &["complete -c etendue", "max-bounces"]);
    caption("man", &[".TH", "etendue", "render"]);
    caption("man render", &[".TH", "max\\-bounces"]);
    assert_eq!(run(&folder, "").code, 2);
    assert!(folder.listing().is_empty());
}

#[test]
fn replay_names_instanced_and_moving_shapes() {
    let folder = SceneFolder::new([("placed.toml", PLACED)]);
    // The instances cover the left and the right third of the image, the moving disk the middle.
    for (x, name) in [(2, "placed"), (15, "moving"), (27, "placed")] {
        let replay = format!("render placed.toml --pixel {x},1 --sample 0");
        let printed = succeed(&folder, &replay).stdout;
        let vertex = format!("vertex 0: {name} primitive 0 ");
        assert!(printed.contains(&vertex), "no `{vertex}` in\n{printed}");
    }
}

/// A scene whose shapes are numbered differently in the acceleration structure; one of them is there twice.
const PLACED: &str = r#"version = 1
[camera]
eye = [0, 0, 1]
target = [0, 0, 0]
shutter = [0, 1]
[film]
size = [30, 3]
[[shape]]
name = "moving"
type = "disk"
center = [0, 0, 0]
normal = [0, 0, 1]
radius = 1
motion = [{ time = 0, transform = [] }, { time = 1, transform = [{ translate = [0, 0, 0.1] }] }]
[[shape]]
name = "placed"
type = "disk"
center = [0, 0, 0.01]
normal = [0, 0, 1]
radius = 1
group = "plate"
[[shape]]
name = "standing"
type = "disk"
center = [0, 0, -9]
normal = [0, 0, 1]
radius = 1
[[instance]]
of = "plate"
transform = [{ translate = [-2.5, 0, 0.2] }]
[[instance]]
of = "plate"
transform = [{ translate = [2.5, 0, 0.2] }]
"#;

#[test]
fn non_finite_warning_prints_replay_command_with_render_flags() {
    let folder = SceneFolder::new([("bright.toml", TOO_BRIGHT)]);
    let flags =
        "--size 5x4 --spp 2 --sampler stratified --max-bounces 3 --precision fast --quality high";
    let finished = run(&folder, &format!("render bright.toml {flags} -o a.pfm"));
    assert_eq!(finished.code, 6, "{}", finished.stderr);
    let replay = format!("etendue render bright.toml {flags} --seed 0 --pixel 0,0 --sample 0");
    let said = &finished.stderr;
    assert!(said.contains(&replay), "no `{replay}` in\n{said}");
}

/// Two constant environments whose sum overflows single precision.
const TOO_BRIGHT: &str = r#"version = 1
[camera]
eye = [0, 0, 5]
target = [0, 0, 0]
[[light]]
type = "environment"
radiance = 3e38
[[light]]
type = "environment"
radiance = 3e38
"#;

#[test]
fn each_sampling_strategy_is_written_as_an_image() {
    let folder = small();
    for (flags, files) in [
        (
            "--integrator path --light-paths 1",
            vec!["s0-weighted.exr", "s1-weighted.exr", "t1-weighted.exr"],
        ),
        (
            "--integrator bdpt --max-bounces 1",
            vec!["s1-t2.exr", "s1-t2-weighted.exr"],
        ),
    ] {
        let flags = format!("render small.toml -q -o it.exr --spp 4 {flags}");
        succeed(&folder, &format!("{flags} --bdpt-strategies ways"));
        for file in files {
            let image = read(&folder, &format!("ways/{file}"));
            assert_eq!(image.width(), read(&folder, "it.exr").width(), "{file}");
        }
    }
}

#[test]
fn default_output_keeps_dots_of_the_scene_name() {
    let folder = SceneFolder::new([("room.v2.toml", SMALL)]);
    succeed(&folder, "render room.v2.toml -q --spp 1");
    assert_eq!(read(&folder, "room.v2.png").width(), 24);
    succeed(&folder, "convert room.v2.toml -q -o room.v3.toml");
    succeed(&folder, "render room.v3.toml -q --spp 1");
    assert_eq!(read(&folder, "room.v3.png").width(), 24);
}

/// `nohup` has its command ignore that the terminal has gone.
#[cfg(unix)]
#[test]
fn hangup_does_not_interrupt_under_nohup() {
    let folder = small();
    let render = command(&folder, "render small.toml -q --time 1s -o it.png");
    let mut shell = std::process::Command::new("sh");
    shell
        .args(["-c", "trap '' HUP; exec \"$0\" \"$@\""])
        .arg(render.get_program())
        .args(render.get_args())
        .current_dir(folder.root());
    let mut child = shell.spawn().expect("it starts");
    std::thread::sleep(std::time::Duration::from_millis(300));
    let pid = child.id().to_string();
    let asked = std::process::Command::new("kill")
        .args(["-HUP", &pid])
        .status();
    assert!(asked.expect("kill runs").success());
    assert!(child.wait().expect("it ends").success());
    assert_eq!(read(&folder, "it.png").width(), 24);
}

/// A pilot would choose shared paths, which this kernel lacks.
#[test]
fn named_kernel_limits_the_choices_of_pilots() {
    let folder = SceneFolder::new([("empty.txt", "")]);
    let scene = in_repository("scenes/cornell-box/cornell-box.toml");
    let flags = "--kernel matte --size 64x64 --spp 4 -q -o it.exr";
    succeed(&folder, &format!("render {} {flags}", scene.display()));
}

#[test]
fn help_states_the_ratio_from_which_light_paths_pay() {
    let folder = small();
    let help = succeed(&folder, "render --help").stdout;
    let help: Vec<&str> = help.split_whitespace().collect();
    let ratio = format!("more than {} times", LightPathChoice::MIN_RATIO);
    assert!(help.join(" ").contains(&ratio), "no `{ratio}`");
}
