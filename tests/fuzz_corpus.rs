//! The fuzzer's corpus as a test on every push: no panic, and memory bounded by the size of the input.
//!
//! It is a single test, because memory is counted for the whole process.

#[path = "../fuzz/src/lib.rs"]
mod fuzz;

use fuzz::{TARGETS, Target};
use peak_alloc::PeakAlloc;
use std::collections::BTreeSet;
use std::path::Path;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The size in bytes up to which a line of the corpus is repeated.
const REPEATED: usize = 1 << 17;

#[test]
fn fuzz_corpus_is_read_without_panic_and_in_bounded_memory() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    for target in TARGETS {
        let name = target.name;
        let inputs = inputs(&corpus.join(name));
        assert!(inputs.len() >= 10, "{} inputs of {name}", inputs.len());
        for (file, bytes) in &inputs {
            // Printed only if the test fails.
            println!("{name}/{file}");
            target.feed(bytes, &MEMORY);
        }
        if ["scene_toml", "obj", "mtl"].contains(&name) {
            repeat_lines(&target, &inputs);
        }
    }
}

/// Feeds, for each line of the corpus, a large input: a valid start, followed by the line many times.
fn repeat_lines(target: &Target, inputs: &[(String, Vec<u8>)]) {
    let texts = inputs
        .iter()
        .filter_map(|(_, bytes)| std::str::from_utf8(bytes).ok());
    let lines: BTreeSet<&str> = texts
        .flat_map(str::lines)
        .filter(|line| !line.is_empty())
        .collect();
    let start = match target.name {
        "scene_toml" => "version = 1\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n",
        "obj" => "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n",
        "pbrt" => "Scale -1 1 1\nWorldBegin\n",
        _ => "newmtl a\nnewmtl b\n",
    };
    for line in lines {
        println!("{}: {line}", target.name);
        let many = REPEATED / (line.len() + 1);
        let text = start.to_owned() + &format!("{line}\n").repeat(many);
        target.feed(text.as_bytes(), &MEMORY);
    }
}

/// The files of a folder, in order.
fn inputs(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).expect("the corpus is in the repository");
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("it is readable"))
        .map(|entry| {
            let bytes = std::fs::read(entry.path()).expect("it is readable");
            (entry.file_name().to_string_lossy().into_owned(), bytes)
        })
        .collect();
    files.sort();
    files
}
