//! Hands on what embree4-sys's build script found out (its head comment lists the facts), to the library, the lab and the
//! command: each of them has this build script.
//!
//! Cargo passes a library's link arguments to no other package, so the run path to an Embree outside the system's folders is
//! set here, for programs, tests, benches and examples. They look first in the prefix that they are installed in, where
//! `make install` puts a private copy. For `etendue info`, two facts become variables that `env!` reads:
//! `EMBREE_HEADER_VERSION` and `EMBREE_FOUND_IN`. Without the feature `embree`, neither.
//!
//! The library also gets `ETENDUE_SOURCES`, a hash of its sources and of the versions of its dependencies: state files of two
//! programs that may compute other bits are not merged.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    if env::var("CARGO_PKG_NAME").is_ok_and(|name| name == "etendue") {
        println!("cargo::rerun-if-changed=src");
        println!("cargo::rerun-if-changed=Cargo.lock");
        println!(
            "cargo::rustc-env=ETENDUE_SOURCES={:016x}",
            hash_of_sources()
        );
    }
    // Nothing else is read; without any such line, every change in the package would run it again.
    println!("cargo::rerun-if-env-changed=CARGO_FEATURE_EMBREE");
    if env::var_os("CARGO_FEATURE_EMBREE").is_none() {
        return;
    }
    let fact = |name: &str| env::var(format!("DEP_EMBREE4_{name}"));
    let expected = "embree4-sys passes this on";
    println!(
        "cargo::rustc-env=EMBREE_HEADER_VERSION={}",
        fact("VERSION").expect(expected)
    );
    println!(
        "cargo::rustc-env=EMBREE_FOUND_IN={}",
        fact("ROOT").expect(expected)
    );
    if let Ok(folder) = fact("RPATH") {
        println!("cargo::rustc-link-arg=-Wl,-rpath,$ORIGIN/../lib/etendue:{folder}");
    }
}

/// A hash of all files below `src`, with their names, and of `Cargo.lock`.
fn hash_of_sources() -> u64 {
    let mut files = files_below(Path::new("src"));
    files.push(PathBuf::from("Cargo.lock"));
    files.sort_unstable();
    // FNV-1a: it has to tell two builds apart, not to withstand an attack.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in files {
        // A package that others depend on has no lock file.
        let content = fs::read(&file).unwrap_or_default();
        let name = file.to_string_lossy();
        for byte in name.bytes().chain(content) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    hash
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the package has its sources");
    let paths = entries.map(|entry| entry.expect("they can be listed").path());
    let files = paths.flat_map(|path| match path.is_dir() {
        true => files_below(&path),
        false => vec![path],
    });
    files.collect()
}
