//! Names the shared library for those that link it, and its run path to a private Embree: the copy
//! that `make install` puts beside it, or where it was built.
//!
//! The name has the major version, so that a library with another interface is not taken for this one.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let is_linux = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux");
    if is_linux {
        let major = env::var("CARGO_PKG_VERSION_MAJOR").expect("cargo tells the version");
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libetendue.so.{major}");
    }
    if let Ok(folder) = env::var("DEP_EMBREE4_RPATH") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-rpath,$ORIGIN/etendue:{folder}");
    }
}
