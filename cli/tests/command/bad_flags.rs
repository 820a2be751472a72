//! Invalid flags and outputs of the command: the exit code, the flag and the expected value are reported; nothing is written.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, USAGE, fails};

/// Renders the small scene with these flags, and expects a usage error.
#[track_caller]
fn flags_fail(flags: &str, words: &[&str]) {
    let folder = SceneFolder::new([("a.toml", SMALL)]);
    fails(&folder, &format!("render a.toml {flags}"), USAGE, words);
}

#[test]
fn invalid_flags_are_usage_errors() {
    for crop in [
        "0,0,25,16",
        "3,3,3,4",
        "5,5,4,6",
        "0,0,1",
        "-1,0,2,2",
        "a,b,c,d",
    ] {
        flags_fail(&format!("--crop={crop}"), &["--crop"]);
    }
    for size in ["0x5", "5", "5x", "axb", "-3x4", "99999x1"] {
        flags_fail(&format!("--size={size}"), &["--size", "WIDTHxHEIGHT"]);
    }
    for time in ["soon", "-3s", "0s", "nan", "1e9h"] {
        flags_fail(
            &format!("--time={time}"),
            &["--time", "a duration such as 30s"],
        );
    }
    for spp in ["-4", "0", "many", "1.5"] {
        flags_fail(&format!("--spp={spp}"), &["--spp"]);
    }
    flags_fail("--threads=0", &["--threads"]);
    flags_fail("--exposure=nan", &["--exposure", "a number of stops"]);
    flags_fail("--pixel 1,1", &["--sample"]);
    flags_fail("--sample 1", &["--pixel"]);
    flags_fail("--pixel 24,0 --sample 0", &["--pixel 24,0", "24x16"]);
    flags_fail("--pixel 1 --sample 0", &["--pixel", "2 whole numbers"]);
    flags_fail("--integrator pth", &["--integrator", "pth", "path"]);
    flags_fail("--integrator brdf", &["--integrator", "bsdf"]);
    flags_fail(
        "--max-bounces few",
        &["--max-bounces", "whole number, or none"],
    );
    flags_fail("--roulette never", &["--roulette", "none"]);
    flags_fail("--roulette none", &["--max-bounces"]);
    flags_fail("--light-paths 3", &["--light-paths", "1/4"]);
    flags_fail(
        "--light-paths 1 --integrator bdpt",
        &["only the integrator path"],
    );
    flags_fail(
        "--light-paths 1 --adaptive=greedy --error 10%",
        &["--light-paths off"],
    );
    flags_fail("--reuse 8", &["--reuse", "16"]);
    flags_fail(
        "--reuse 16 --integrator bdpt",
        &["only the integrator path"],
    );
    flags_fail("--reuse 16 --adaptive=two-phase", &["--adaptive=off"]);
    flags_fail("--reuse 16 --light-paths 1", &["--light-paths off"]);
    flags_fail(
        "--occlusion-distance 0",
        &["--occlusion-distance", "above 0"],
    );
    flags_fail("--integrator nee --kernel room", &["nee", "room", "matte"]);
    flags_fail("--filter gauss", &["--filter", "gauss", "`gaussian`"]);
    flags_fail("--filter tent:0", &["--filter", "above 0, up to 32 pixels"]);
    flags_fail(
        "--filter tent:wide",
        &["--filter", "above 0, up to 32 pixels"],
    );
    flags_fail(
        "--filter-sampling splat",
        &["--filter-sampling", "splatting"],
    );
    flags_fail(
        "--denoise --filter-sampling splatting",
        &["--denoise", "--filter-sampling splatting"],
    );
    flags_fail("--sampler sobl", &["--sampler", "sobol"]);
    flags_fail("--backend embre", &["--backend"]);
    flags_fail("--sp 3", &["--sp", "--spp"]);
    flags_fail("--quiet --verbose", &["--quiet", "--verbose"]);
}

#[test]
fn unwritable_outputs_are_rejected() {
    flags_fail("-o a.bmp", &["a.bmp", ".exr, .png, .hdr or .pfm"]);
    flags_fail("-o a", &["\"a\"", ".exr"]);
    let folder = SceneFolder::new([("a.toml", SMALL)]);
    for flags in [
        "-o none/a.png",
        "-o a.png -o none/a.exr",
        "--stats none/a.json",
    ] {
        let arguments = format!("render a.toml {flags}");
        fails(
            &folder,
            &arguments,
            INPUT_OUTPUT,
            &["none/a.", "cannot write", "no such folder"],
        );
    }
    std::fs::create_dir(folder.path("folder.png")).expect("the folder is writable");
    let arguments = "render a.toml -o folder.png";
    fails(
        &folder,
        arguments,
        INPUT_OUTPUT,
        &["folder.png", "cannot write"],
    );
}

#[test]
fn unknown_or_incomplete_subcommands_are_usage_errors() {
    let folder = SceneFolder::new([("a.toml", SMALL)]);
    fails(&folder, "", USAGE, &["Usage"]);
    fails(&folder, "rendr a.toml", USAGE, &["rendr", "render"]);
    fails(&folder, "render", USAGE, &["SCENE"]);
    fails(&folder, "man rendr", USAGE, &["rendr"]);
    fails(&folder, "completions fsh", USAGE, &["fsh", "fish"]);
}
