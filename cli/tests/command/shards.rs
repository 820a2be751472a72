//! Tests of `render --shard` and `merge`.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, USAGE, fails, run, succeed};
use etendue::internals::image::{ColourSpace, LayeredImage};
use serde_json::Value;

fn small() -> SceneFolder {
    SceneFolder::new([("small.toml", SMALL)])
}

fn read(folder: &SceneFolder, name: &str) -> LayeredImage {
    let read = LayeredImage::read(&folder.path(name), ColourSpace::Srgb);
    read.unwrap_or_else(|error| panic!("{error}"))
}

/// Renders shards with these flags, and returns the names of their files.
fn shards(folder: &SceneFolder, of: u64, flags: &str) -> String {
    let files = (0..of).map(|index| {
        let file = format!("part-{index}.etd");
        succeed(
            folder,
            &format!("render small.toml -q {flags} --shard {index}/{of} -o {file}"),
        );
        file
    });
    files.collect::<Vec<_>>().join(" ")
}

#[test]
fn merged_shards_are_bit_identical_to_a_single_render() {
    let folder = small();
    let flags = "--spp 32 --layers --integrator bdpt";
    succeed(
        &folder,
        &format!("render small.toml -q {flags} -o whole.exr"),
    );
    let files = shards(&folder, 3, flags);
    let merged = succeed(
        &folder,
        &format!("merge {files} -o merged.exr -o merged.png"),
    );
    assert!(
        merged.stderr.contains("3 files, 32 spp, error"),
        "{}",
        merged.stderr
    );
    let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| read(&folder, name));
    assert!(whole.image == merged.image);
    assert!(whole.layers == merged.layers);
    assert!(!whole.layers.is_empty());
    for fact in [
        "scene",
        "seed",
        "integrator",
        "sampler",
        "filter",
        "adaptive",
        "roulette",
        "lightPaths",
        "reuse",
        "spp",
        "bias",
        "relRmse",
    ] {
        assert_eq!(whole.fact(fact), merged.fact(fact), "{fact}");
    }
    succeed(
        &folder,
        &format!("merge -q {files} -o filtered.exr --denoise"),
    );
    succeed(
        &folder,
        &format!("render small.toml -q {flags} -o other.exr --denoise"),
    );
    let [a, b] = ["filtered.exr", "other.exr"].map(|name| read(&folder, name));
    assert!(a.image == b.image);
}

#[test]
fn folder_stands_for_its_state_files() {
    let folder = small();
    let files = shards(&folder, 3, "--spp 32");
    std::fs::create_dir(folder.path("parts")).expect("it is created");
    fails(
        &folder,
        "merge parts -o it.exr",
        USAGE,
        &["parts", "no state files"],
    );
    for file in files.split(' ') {
        std::fs::rename(folder.path(file), folder.path(&format!("parts/{file}"))).expect("moved");
    }
    std::fs::write(folder.path("parts/notes.txt"), "no state").expect("it is written");
    let command = "merge parts -o parts/all.etd -o it.exr";
    let merged = succeed(&folder, command);
    assert!(
        merged.stderr.contains("3 files, 32 spp"),
        "{}",
        merged.stderr
    );
    // Its samples might be in no other file any more.
    fails(&folder, command, USAGE, &["all.etd", "exists"]);
}

#[test]
fn merged_pilot_and_adaptive_shards_are_bit_identical_to_a_single_render() {
    let folder = small();
    let flags = "small.toml -q --spp 128 --adaptive --layers";
    succeed(&folder, &format!("render {flags} -o whole.exr"));
    for part in ["0..16", "16..32"] {
        succeed(
            &folder,
            &format!("render {flags} --shard {part} -o {part}.etd"),
        );
    }
    succeed(
        &folder,
        "merge -q --partial 0..16.etd 16..32.etd -o pilot.etd",
    );
    let given = format!("render {flags} --pilot pilot.etd");
    let mut files = "pilot.etd".to_owned();
    for index in 0..3 {
        let checkpoint = format!("--checkpoint kept-{index}.etd");
        let shard = format!("{given} --shard {index}/3 -o part-{index}.etd");
        succeed(&folder, &format!("{shard} {checkpoint}"));
        succeed(
            &folder,
            &format!("{shard} {checkpoint} --resume kept-{index}.etd"),
        );
        files = format!("part-{index}.etd {files}");
    }
    let merged = succeed(&folder, &format!("merge {files} -o merged.exr"));
    assert!(
        merged.stderr.contains("4 files, 128 spp, error"),
        "{}",
        merged.stderr
    );
    succeed(&folder, &format!("{given} -o continued.exr"));
    let [whole, merged, continued] =
        ["whole.exr", "merged.exr", "continued.exr"].map(|name| read(&folder, name));
    for parts in [&merged, &continued] {
        assert!(whole.image == parts.image);
        assert!(whole.layers == parts.layers);
        for fact in ["adaptive", "spp", "bias", "relRmse"] {
            assert_eq!(whole.fact(fact), parts.fact(fact), "{fact}");
        }
    }
    for (wrong, word) in [
        ("--shard 0/3 -o part.etd", "--shard 0..32"),
        ("--shard 0/3 --pilot 0..16.etd -o part.etd", "0..16.etd"),
        (
            "--shard 0/3 --pilot part-0.etd -o part.etd",
            "not a whole pilot",
        ),
        (
            "--shard 0..40 --pilot pilot.etd -o part.etd",
            "from 32 to 128",
        ),
        ("--resume kept-0.etd -o part.etd", "--pilot"),
        ("--adaptive=off --pilot pilot.etd -o it.exr", "--adaptive"),
    ] {
        let flags = match wrong.starts_with("--adaptive") {
            true => "small.toml -q --spp 128",
            false => flags,
        };
        fails(&folder, &format!("render {flags} {wrong}"), USAGE, &[word]);
    }
    fails(
        &folder,
        "merge part-1.etd pilot.etd -o it.exr",
        USAGE,
        &["are missing"],
    );
}

#[test]
fn shards_that_time_ends_finish_their_round_and_can_be_merged() {
    let folder = small();
    // With next to no time, a render has one sample, and a shard a round of four.
    for range in ["0..32", "32..64"] {
        let shard = format!("--shard {range} --time 0.000001s -o {range}.etd");
        succeed(&folder, &format!("render small.toml -q --spp 64 {shard}"));
    }
    let merged = succeed(
        &folder,
        "merge --partial 0..32.etd 32..64.etd -o it.exr --json",
    );
    let report: Value = serde_json::from_str(&merged.stdout).expect("JSON");
    assert_eq!(report["spp"], 8);
    assert_eq!(report["missing"], serde_json::json!([[4, 32], [36, 64]]));
}

#[test]
fn black_chains_of_all_shards_are_an_error_of_the_merge() {
    let folder = small();
    let text = SMALL
        .replace("[12, 11, 10]", "0")
        .replace("[0.1, 0.12, 0.15]", "0");
    std::fs::write(folder.path("dark.toml"), text).expect("it is writable");
    for part in 0..2 {
        let shard = format!("--shard {part}/2 -o dark-{part}.etd");
        succeed(
            &folder,
            &format!("render dark.toml -q --integrator mlt --spp 8 {shard}"),
        );
    }
    succeed(&folder, "merge -q --partial dark-0.etd -o it.exr");
    fails(
        &folder,
        "merge dark-0.etd dark-1.etd -o it.exr",
        1,
        &["found any light"],
    );
}

#[test]
fn merge_reports_missing_and_duplicate_samples() {
    let folder = small();
    shards(&folder, 4, "--spp 64");
    let two = "merge part-0.etd part-2.etd -o it.exr";
    fails(
        &folder,
        two,
        USAGE,
        &["samples 16..32, 48..64 of 64 are missing", "--partial"],
    );
    let doubled = "merge part-0.etd part-1.etd part-0.etd -o it.exr";
    fails(
        &folder,
        doubled,
        USAGE,
        &["doubled: 0..16 in part-0.etd and part-0.etd"],
    );
    let partial = succeed(&folder, &format!("{two} --partial --json"));
    let report: Value = serde_json::from_str(&partial.stdout).expect("JSON");
    assert_eq!(report["spp"], 32);
    assert_eq!(report["missing"][1][0], 48);
    assert!(
        partial
            .stderr
            .contains("samples 16..32, 48..64 are missing"),
        "{}",
        partial.stderr
    );
}

/// Of two shards that are damaged, one by a bit of its body and one by its end, the samples are missing.
#[test]
fn damaged_shards_are_set_aside_on_request() {
    let folder = small();
    let files = shards(&folder, 4, "--spp 32");
    let path = |name: &str| folder.path(name);
    let mut flipped = std::fs::read(path("part-1.etd")).expect("a shard");
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    std::fs::write(path("part-1.etd"), &flipped).expect("it is written");
    let cut = &flipped[..7];
    std::fs::write(path("part-3.etd"), cut).expect("it is written");
    let merge = format!("merge {files} -o it.pfm");
    fails(&folder, &merge, INPUT_OUTPUT, &["part-", "damaged"]);
    let aside = run(&folder, &format!("{merge} --set-damaged-aside"));
    assert_eq!(aside.code, USAGE, "{}", aside.stderr);
    let missing = "samples 8..16, 24..32 of 32 are missing";
    assert!(aside.stderr.contains(missing), "{}", aside.stderr);
    let names = ["part-1.etd.damaged", "part-3.etd.damaged"];
    for (name, bytes) in names.into_iter().zip([&flipped[..], cut]) {
        assert!(aside.stderr.contains(name), "{}", aside.stderr);
        assert!(std::fs::read(path(name)).expect(name) == bytes, "{name}");
    }
    // Other files are not renamed, nor are whole ones.
    let other = "merge small.toml part-0.etd -o it.pfm --set-damaged-aside";
    fails(
        &folder,
        other,
        INPUT_OUTPUT,
        &["small.toml", "not a state file"],
    );
    succeed(
        &folder,
        "merge -q part-0.etd part-2.etd -o it.pfm --partial --set-damaged-aside",
    );
}

#[test]
fn merge_reports_spp_needed_for_the_target_error() {
    let matte = "type = \"diffuse\"\nreflectance = 0.5";
    let scene = SMALL
        .replace("type = \"dielectric\"", matte)
        .replace("emission = [12, 11, 10]", "");
    let folder = SceneFolder::new([("small.toml", scene)]);
    let files = shards(&folder, 4, "--spp 64 --sampler independent");
    let fell_short = run(
        &folder,
        &format!("merge {files} -o it.etd --error 0.1% --json"),
    );
    assert_eq!(fell_short.code, 5, "{}", fell_short.stderr);
    let report: Value = serde_json::from_str(&fell_short.stdout).expect("JSON");
    assert_eq!(report["reached"], false);
    let needed = report["needed_spp"]
        .as_u64()
        .expect("an error without doubt");
    assert!(needed > 640, "{needed}");
    succeed(&folder, &format!("merge -q {files} -o it.etd --error 50%"));
    // The next round continues after the last sample of the one before.
    let more = "render small.toml -q --spp 96 --sampler independent --shard 64..96 -o more.etd";
    succeed(&folder, more);
    succeed(&folder, "merge -q it.etd more.etd -o all.exr");
    succeed(
        &folder,
        "render small.toml -q --spp 96 --sampler independent -o whole.exr",
    );
    assert!(read(&folder, "all.exr").image == read(&folder, "whole.exr").image);
}

#[test]
fn invalid_shards_and_files_are_rejected() {
    let folder = small();
    let shard = |flags: &str| format!("render small.toml -o part.etd {flags}");
    for (flags, word) in [
        ("--shard 4/4 --spp 64", "counted from 0"),
        ("--shard x", "0/64"),
        ("--shard 0/64 --spp 64", "at most 16"),
        ("--shard 2..8 --spp 64", "multiples of 4"),
        ("--shard 0..128 --spp 64", "not a part"),
        ("--shard 0/2 --error 10%", "--spp"),
        ("--shard 0/2 --spp 64 --adaptive", "--adaptive=off"),
        ("--shard 0/2 --spp 64 -o it.png", "etendue merge"),
        ("--every 5s", "--checkpoint"),
        (
            "--shard 0/2 --spp 64 --checkpoint ./part.etd",
            "is the output, too",
        ),
    ] {
        fails(&folder, &shard(flags), USAGE, &[word]);
    }
    let no_file = "merge none.etd -o it.exr";
    fails(&folder, no_file, INPUT_OUTPUT, &["none.etd"]);
    fails(
        &folder,
        "merge small.toml -o it.exr",
        INPUT_OUTPUT,
        &["not a state file"],
    );
    fails(&folder, "merge -o it.exr", USAGE, &["<FILE>"]);
    fails(&folder, "merge small.toml -o it.jpg", USAGE, &[".exr"]);
}
