//! Finds Embree >= 4.0, links it, and writes its bindings from its own headers.
//!
//! Searched in this order, as `scripts/setup.sh` does: `EMBREE_DIR`, or else pkg-config, the
//! usual prefixes, and the private copy `.embree/` that the script makes in the workspace.
//!
//! Passed on to the packages that depend on this one, as `DEP_EMBREE4_<NAME>`: `ROOT` (the
//! prefix), `INCLUDE`, `LIB`, `VERSION` (of the headers), and `RPATH`: the folder that an
//! executable has to name to find the library when it runs, absent where the loader looks
//! there anyway.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The prefixes under which systems and package managers put libraries.
const USUAL_PREFIXES: [&str; 4] = ["/usr", "/usr/local", "/opt/homebrew", "/opt/local"];

/// The functions that Etendue calls. All exist since Embree 4.0; bindgen adds the types and constants that they
/// need.
const FUNCTIONS: &[&str] = &[
    "rtcNewDevice",
    "rtcRetainDevice",
    "rtcReleaseDevice",
    "rtcGetDeviceError",
    "rtcGetDeviceProperty",
    "rtcSetDeviceErrorFunction",
    "rtcSetDeviceMemoryMonitorFunction",
    "rtcNewScene",
    "rtcRetainScene",
    "rtcReleaseScene",
    "rtcSetSceneBuildQuality",
    "rtcSetSceneFlags",
    "rtcSetSceneProgressMonitorFunction",
    "rtcAttachGeometry",
    "rtcAttachGeometryByID",
    "rtcDetachGeometry",
    "rtcCommitScene",
    "rtcJoinCommitScene",
    "rtcGetSceneBounds",
    "rtcNewGeometry",
    "rtcRetainGeometry",
    "rtcReleaseGeometry",
    "rtcCommitGeometry",
    "rtcEnableGeometry",
    "rtcDisableGeometry",
    "rtcSetGeometryBuildQuality",
    "rtcSetGeometryMask",
    "rtcSetGeometryTimeStepCount",
    "rtcSetGeometryTimeRange",
    "rtcSetGeometryUserData",
    "rtcSetNewGeometryBuffer",
    "rtcSetSharedGeometryBuffer",
    "rtcUpdateGeometryBuffer",
    "rtcSetGeometryIntersectFilterFunction",
    "rtcSetGeometryOccludedFilterFunction",
    "rtcSetGeometryEnableFilterFunctionFromArguments",
    "rtcSetGeometryInstancedScene",
    "rtcSetGeometryTransform",
    "rtcIntersect1",
    "rtcIntersect4",
    "rtcIntersect8",
    "rtcIntersect16",
    "rtcOccluded1",
    "rtcOccluded4",
    "rtcOccluded8",
    "rtcOccluded16",
];

/// An Embree: its headers and its library.
struct Embree {
    root: PathBuf,
    include: PathBuf,
    lib: PathBuf,
    version: String,
}

fn main() {
    if let Err(error) = run() {
        // To standard error, as cargo shows it when a build script fails; no backtrace.
        eprintln!("\n{error}\n");
        std::process::exit(1);
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=EMBREE_DIR");
    let embree = find()?;
    write_bindings(&embree)?;

    let headers = embree.include.join("embree4");
    println!("cargo::rerun-if-changed={}", headers.display());
    println!("cargo::rustc-link-search=native={}", embree.lib.display());
    println!("cargo::rustc-link-lib=dylib=embree4");
    println!("cargo::metadata=ROOT={}", embree.root.display());
    println!("cargo::metadata=INCLUDE={}", embree.include.display());
    println!("cargo::metadata=LIB={}", embree.lib.display());
    println!("cargo::metadata=VERSION={}", embree.version);
    if embree.root != Path::new("/usr") {
        // For this package's own tests; the others take it from the metadata.
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", embree.lib.display());
        println!("cargo::metadata=RPATH={}", embree.lib.display());
    }
    Ok(())
}

/// The first Embree >= 4.0 of the places in the head comment.
fn find() -> Result<Embree, String> {
    if let Some(dir) = env::var_os("EMBREE_DIR") {
        return embree_under(Path::new(&dir))
            .map_err(|why| format!("EMBREE_DIR is set, but {why}."));
    }
    // Asked now: this program may have been built when the workspace was elsewhere.
    let package = env::var("CARGO_MANIFEST_DIR").map_err(|error| error.to_string())?;
    let private = Path::new(&package).with_file_name(".embree");
    let prefixes = USUAL_PREFIXES
        .map(PathBuf::from)
        .into_iter()
        .chain([private]);

    let mut reasons = String::new();
    for prefix in pkg_config_prefix().into_iter().chain(prefixes) {
        match embree_under(&prefix) {
            Ok(embree) => return Ok(embree),
            Err(why) => reasons += &format!("\n  {why}"),
        }
    }
    Err(format!(
        "Embree 4 was not found:{reasons}\n\
         Run `scripts/setup.sh`, which finds or fetches one, or set EMBREE_DIR to the folder that\n\
         holds its include/ and lib/. To build without Embree, on a slower ray tracer:\n\
         cargo build --release --no-default-features"
    ))
}

/// The prefix that pkg-config knows, if there is pkg-config and it knows one.
fn pkg_config_prefix() -> Option<PathBuf> {
    let output = Command::new("pkg-config")
        .args(["--variable=prefix", "embree4"])
        .output()
        .ok()?;
    let prefix = String::from_utf8(output.stdout).ok()?;
    let prefix = prefix.trim();
    (output.status.success() && !prefix.is_empty()).then(|| prefix.into())
}

/// The Embree with this prefix, or why there is none to use.
fn embree_under(root: &Path) -> Result<Embree, String> {
    let include = root.join("include");
    let version = header_version(&include)
        .ok_or_else(|| format!("{} has no include/embree4/rtcore_config.h", root.display()))?;
    let major = version
        .split('.')
        .next()
        .and_then(|major| major.parse().ok())
        .unwrap_or(0);
    if major < 4 {
        return Err(format!(
            "{} has Embree {version}, which is older than 4.0",
            root.display()
        ));
    }
    let architecture = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let lib = [
        "lib".to_string(),
        "lib64".to_string(),
        format!("lib/{architecture}-linux-gnu"),
    ]
    .iter()
    .map(|folder| root.join(folder))
    .find(|lib| {
        ["so", "dylib"]
            .iter()
            .any(|end| lib.join(format!("libembree4.{end}")).exists())
    })
    .ok_or_else(|| {
        format!(
            "{} has Embree's headers but no libembree4.so",
            root.display()
        )
    })?;
    Ok(Embree {
        root: root.to_path_buf(),
        include,
        lib,
        version,
    })
}

/// The version that the headers in `include` state.
fn header_version(include: &Path) -> Option<String> {
    let config = fs::read_to_string(include.join("embree4/rtcore_config.h")).ok()?;
    let after = config.split_once("#define RTC_VERSION_STRING \"")?.1;
    Some(after.split_once('"')?.0.to_string())
}

/// Writes the bindings to `OUT_DIR/bindings.rs`.
fn write_bindings(embree: &Embree) -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let mut builder = bindgen::Builder::default()
        .header(embree.include.join("embree4/rtcore.h").to_string_lossy())
        .clang_arg(format!("-I{}", embree.include.display()))
        .rust_target(bindgen::RustTarget::stable(89, 0).map_err(|error| error.to_string())?)
        .rust_edition(bindgen::RustEdition::Edition2024)
        .formatter(bindgen::Formatter::None)
        // Constants under their C names, and enums as the plain integers they are in C: an
        // enum of Rust would make a value that a newer library returns undefined behaviour.
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .derive_default(true)
        .allowlist_type("RTC(Error|SceneFlags|RayQueryFlags|RayQueryContext|DeviceProperty)")
        .allowlist_var("RTC_(VERSION.*|MAX_.*|INVALID_GEOMETRY_ID)")
        // Some of those are expressions that only clang can evaluate.
        .clang_macro_fallback()
        .clang_macro_fallback_build_dir(&out);
    for function in FUNCTIONS {
        builder = builder.allowlist_function(function);
    }
    builder.generate()?.write_to_file(out.join("bindings.rs"))?;
    Ok(())
}
