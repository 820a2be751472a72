//! Tests of `render --choices`, and of the choices that a state hands on: no shard has to repeat the pilots of another.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, USAGE, fails, succeed};
use etendue::internals::state::Fingerprint;

/// An image that is large enough for the pilots of shared paths.
const RENDER: &str = "render small.toml -q --size 48x32 --spp 8";

/// A file of choices in which the weight window is another than pilots choose.
fn with_other_window(folder: &SceneFolder) -> Fingerprint {
    let mut choices = Fingerprint::read(&folder.path("choices.json")).expect("it is written");
    let window = choices.settings.get_mut("roulette").expect("a rule");
    assert_ne!(*window, "window=1/7");
    *window = "window=1/7".into();
    choices
}

fn read(folder: &SceneFolder, name: &str) -> Vec<u8> {
    std::fs::read(folder.path(name)).expect(name)
}

#[test]
fn shared_choices_change_no_bit_and_replace_pilots() {
    for integrator in ["path", "auto", "path --adaptive"] {
        let folder = SceneFolder::new([("small.toml", SMALL)]);
        let render = format!("{RENDER} --integrator {integrator}");
        succeed(&folder, &format!("{render} -o whole.pfm"));
        let shard = |index: u64| {
            let range = match integrator.contains("adaptive") {
                true => format!("--shard {}..{}", 4 * index, 4 * index + 4),
                false => format!("--shard {index}/2"),
            };
            let pilot = match (integrator.contains("adaptive"), index) {
                (true, 1) => "--pilot 0.etd",
                _ => "",
            };
            let flags = format!("{range} {pilot} --choices choices.json -o {index}.etd");
            succeed(&folder, &format!("{render} {flags}"));
        };
        shard(0);
        let choices = read(&folder, "choices.json");
        shard(1);
        assert_eq!(read(&folder, "choices.json"), choices);
        succeed(&folder, "merge -q 0.etd 1.etd -o merged.pfm");
        assert!(
            read(&folder, "merged.pfm") == read(&folder, "whole.pfm"),
            "{integrator}"
        );
        // No pilot would choose this window: it is taken from the file.
        let other = with_other_window(&folder);
        other
            .write(&folder.path("other.json"))
            .expect("it is written");
        if integrator == "path" {
            succeed(&folder, &format!("{render} --choices other.json -o it.etd"));
            succeed(
                &folder,
                &format!("{render} --roulette window=1/7 --resume it.etd -o it.pfm"),
            );
            // A state hands its choices on.
            succeed(&folder, &format!("{render} --resume it.etd -o it.pfm"));
        }
    }
}

#[test]
fn choices_of_other_renders_and_damaged_ones_are_rejected() {
    let folder = SceneFolder::new([("small.toml", SMALL), ("text", "no choices")]);
    succeed(
        &folder,
        &format!("{RENDER} --choices choices.json -o it.pfm"),
    );
    for (flags, code, words) in [
        (
            "--choices choices.json --seed 3",
            USAGE,
            ["choices.json", "seed is 3"],
        ),
        (
            "--choices choices.json --roulette albedo",
            USAGE,
            ["choices.json", "roulette is"],
        ),
        (
            "--choices choices.json --filter box",
            USAGE,
            ["choices.json", "the film"],
        ),
        (
            "--choices text",
            INPUT_OUTPUT,
            ["text", "not a file of choices"],
        ),
        (
            "--choices none/choices.json",
            INPUT_OUTPUT,
            ["none/choices.json", "no such folder"],
        ),
    ] {
        fails(
            &folder,
            &format!("{RENDER} {flags} -o other.pfm"),
            code,
            &words,
        );
    }
}
