//! Hands on what embree4-sys's build script found out (its head comment lists the facts).
//!
//! Cargo passes a library's link arguments to no other package, so the run path to an Embree
//! outside the system's folders is set here, for the program, the tests, the benches and the
//! examples; the installed program looks in its own prefix first, where `make install` puts a
//! private copy. For `etendue info`, two facts become variables that `env!`
//! reads: `EMBREE_HEADER_VERSION` and `EMBREE_FOUND_IN`. Without the feature `embree`, nothing.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
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
        println!("cargo::rustc-link-arg-bins=-Wl,-rpath,$ORIGIN/../lib/etendue");
        println!("cargo::rustc-link-arg=-Wl,-rpath,{folder}");
    }
}
