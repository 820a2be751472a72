//! Hands on what embree4-sys's build script found out (its head comment lists the facts), to the library, the lab and the
//! command: each of them has this build script.
//!
//! Cargo passes a library's link arguments to no other package, so the run path to an Embree outside the system's folders is
//! set here, for programs, tests, benches and examples. They look first in the prefix that they are installed in, where
//! `make install` puts a private copy. For `etendue info`, two facts become variables that `env!` reads:
//! `EMBREE_HEADER_VERSION` and `EMBREE_FOUND_IN`. Without the feature `embree`, nothing.

use std::env;

fn main() {
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
