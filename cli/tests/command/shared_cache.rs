//! Tests of `render --cache`: the file of an irradiance cache, which shards share.

use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{INPUT_OUTPUT, USAGE, fails, succeed};

const RENDER: &str = "render small.toml -q --integrator irradiance-cache --spp 8";

#[test]
fn shared_cache_changes_no_bit_and_is_filled_once() {
    let folder = SceneFolder::new([("small.toml", SMALL)]);
    let read = |name: &str| std::fs::read(folder.path(name)).expect(name);
    succeed(&folder, &format!("{RENDER} -o whole.pfm"));
    let shard = |index: u64, stats: &str| {
        succeed(
            &folder,
            &format!("{RENDER} --cache it.cache --shard {index}/2 -o {index}.etd --stats {stats}"),
        );
    };
    shard(0, "first.json");
    let cache = read("it.cache");
    shard(1, "second.json");
    assert_eq!(read("it.cache"), cache);
    succeed(&folder, "merge -q 0.etd 1.etd -o merged.pfm");
    assert_eq!(read("whole.pfm"), read("merged.pfm"));
    // The second shard traces no rays for the cache.
    let rays = |name: &str| {
        let stats: serde_json::Value = serde_json::from_slice(&read(name)).expect("it is JSON");
        let rays = stats["rays"].as_object().expect("counts by kind").clone();
        rays.values()
            .filter_map(serde_json::Value::as_u64)
            .max()
            .expect("some")
    };
    assert!(
        rays("first.json") > rays("second.json"),
        "{}",
        rays("second.json")
    );
}

#[test]
fn caches_of_other_renders_and_damaged_ones_are_refused() {
    let folder = SceneFolder::new([("small.toml", SMALL), ("text", "no cache")]);
    succeed(&folder, &format!("{RENDER} --cache it.cache -o it.pfm"));
    let bytes = std::fs::read(folder.path("it.cache")).expect("written");
    std::fs::write(folder.path("cut"), &bytes[..bytes.len() / 2]).expect("written");
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 1;
    std::fs::write(folder.path("flipped"), &flipped).expect("written");
    for (flags, code, words) in [
        (
            "--cache it.cache --seed 3",
            USAGE,
            ["another render", "seed"],
        ),
        (
            "--cache it.cache --cache-error 20%",
            USAGE,
            ["another render", "cache_error"],
        ),
        ("--cache text", INPUT_OUTPUT, ["text", "--cache wrote"]),
        ("--cache cut", INPUT_OUTPUT, ["cut", "cut or changed"]),
        (
            "--cache flipped",
            INPUT_OUTPUT,
            ["flipped", "cut or changed"],
        ),
        (
            "--cache none/it.cache",
            INPUT_OUTPUT,
            ["it.cache", "no such folder"],
        ),
    ] {
        fails(
            &folder,
            &format!("{RENDER} {flags} -o it.pfm"),
            code,
            &words,
        );
    }
    let by_path = "render small.toml -q --integrator path --cache it.cache -o it.pfm";
    fails(&folder, by_path, USAGE, &["irradiance-cache", "by path"]);
}
