//! Tests of the C library as `make install` installs it: its symbols, its header, and clients in C and C++ that are
//! compiled against it and run.

use crate::common::nightly::is_nightly;
use crate::common::scene_folder::{SMALL, SceneFolder, in_repository};
use crate::scene_formats::MITSUBA;
use crate::support::succeed;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

/// Returns the prefix of an installation that all tests share, in a temporary folder.
fn prefix() -> &'static Path {
    static PREFIX: OnceLock<(TempDir, ())> = OnceLock::new();
    let (folder, ()) = PREFIX.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let install = Command::new("make")
            .current_dir(in_repository(""))
            // Built for the whole workspace and together with a test, every package has the same features as for
            // `cargo test --workspace`, and none is built again.
            .args(["install", "PROFILE=test"])
            .arg("CARGO_FLAGS=--workspace --lib --bins --test command")
            .arg(format!("CARGO={}", env!("CARGO")))
            .arg(format!("PREFIX={}", folder.path().display()))
            .env("CARGO_TARGET_DIR", target_folder())
            .output();
        expect_success("make install", install.expect("make is installed"));
        (folder, ())
    });
    folder.path()
}

/// The target folder of this test, whose dependencies are already built.
fn target_folder() -> PathBuf {
    let command = Path::new(env!("CARGO_BIN_EXE_etendue"));
    let folder = command.ancestors().nth(2);
    folder.expect("target/debug/etendue").to_path_buf()
}

fn expect_success(what: &str, output: Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{what}: {}\n{}{}",
        output.status,
        text(&output.stdout),
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// The output of `pkg-config` for the installed library, as words.
fn pkg_config(flags: &[&str]) -> Vec<String> {
    let output = Command::new("pkg-config")
        .env("PKG_CONFIG_PATH", prefix().join("lib/pkgconfig"))
        .args(flags)
        .arg("etendue")
        .output();
    let words = expect_success("pkg-config", output.expect("pkg-config is installed"));
    words.split_whitespace().map(str::to_owned).collect()
}

/// Compiles a client against the installed library.
fn compile(compiler: &str, flags: &[&str], source: &Path, folder: &SceneFolder) -> PathBuf {
    let program = folder.path("client");
    let output = Command::new(compiler)
        .args(["-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-g"])
        .args(flags)
        .arg(source)
        .arg("-o")
        .arg(&program)
        .args(pkg_config(&["--cflags", "--libs"]))
        .args(["-lpthread", "-lm"])
        .output();
    expect_success(compiler, output.expect("a compiler is installed"));
    program
}

/// A command that runs a client with the installed library in its search path.
fn client(program: impl AsRef<OsStr>, folder: &SceneFolder) -> Command {
    let mut client = Command::new(program);
    client
        .current_dir(folder.root())
        .env("LD_LIBRARY_PATH", prefix().join("lib"));
    client
}

fn run(client: &mut Command) -> String {
    expect_success("the client", client.output().expect("the client starts"))
}

fn source(name: &str) -> PathBuf {
    in_repository("tests/clients").join(name)
}

fn small() -> SceneFolder {
    SceneFolder::new([("small.toml", SMALL)])
}

#[test]
fn c_client_renders_bit_identically_to_the_command() {
    let folder = SceneFolder::new([("small.toml", SMALL), ("room.xml", MITSUBA)]);
    let mut flags = sanitized(&folder);
    flags.push("-D_POSIX_C_SOURCE=200809L");
    let program = compile("cc", &flags, &source("client.c"), &folder);
    let mut client = client(&program, &folder);
    let files = ["small.toml", "client-1.pfm", "room.xml", "client-2.pfm"];
    let says = run(guarded(&mut client, &folder).args(files));
    assert!(says.contains("all is well"));
    for pair in files.chunks(2) {
        let flags = "--spp 4 --seed 7 --sampler independent --light-paths off -q -o command.pfm";
        succeed(&folder, &format!("render {} {flags}", pair[0]));
        assert_same_files(&folder, pair[1], "command.pfm");
    }
}

fn assert_same_files(folder: &SceneFolder, a: &str, b: &str) {
    let read = |name| std::fs::read(folder.path(name)).expect("the file was written");
    assert!(read(a) == read(b), "{a} and {b} differ");
}

/// The scene has motion, alpha, normal maps and textured emission.
#[test]
fn scene_built_in_memory_matches_its_scene_file() {
    let scene = std::fs::read_to_string(source("everything.toml")).expect("the scene");
    let folder = SceneFolder::new([("everything.toml", scene.as_str())]);
    let program = compile("cc", &sanitized(&folder), &source("everything.c"), &folder);
    let says = run(guarded(&mut client(program, &folder), &folder).arg("client.pfm"));
    assert!(says.contains("all is well"), "{says}");
    succeed(&folder, "render everything.toml --spp 4 -q -o command.pfm");
    assert_same_files(&folder, "client.pfm", "command.pfm");
}

#[test]
fn out_of_memory_is_reported_and_the_client_continues() {
    let folder = small();
    let flags = ["-std=c11", "-D_POSIX_C_SOURCE=200809L"];
    let program = compile("cc", &flags, &source("limits.c"), &folder);
    let says = run(&mut client(program, &folder));
    assert!(says.contains("all is well"), "{says}");
}

#[test]
fn cpp_client_with_owning_handles_renders() {
    let folder = small();
    let program = compile("c++", &["-std=c++17"], &source("client.cpp"), &folder);
    assert!(run(&mut client(program, &folder)).contains("all is well"));
}

#[test]
fn guide_and_readme_examples_compile_and_run() {
    let guide = std::fs::read_to_string(in_repository("docs/c-api.md")).expect("the guide");
    let readme = std::fs::read_to_string(in_repository("README.md")).expect("the README");
    for page in [guide, readme] {
        let example = page
            .split("```c\n")
            .nth(1)
            .expect("the page has an example");
        let example = example.split("```").next().expect("the code block ends");
        let folder = SceneFolder::new([("example.c", example), ("scene.toml", SMALL)]);
        let program = compile("cc", &["-std=c11"], &folder.path("example.c"), &folder);
        run(&mut client(program, &folder));
        let written = folder.listing().iter().any(|name| name.ends_with(".png"));
        assert!(written, "{:?}", folder.listing());
    }
}

#[test]
fn python_example_runs() {
    let output = Command::new("python3")
        .arg(in_repository("examples/python/render.py"))
        .env("PREFIX", prefix())
        .output();
    match output {
        Ok(output) => {
            let says = expect_success("python3", output);
            assert!(says.contains(env!("CARGO_PKG_VERSION")), "{says}");
        }
        Err(_) => eprintln!("python3 is not there: the example was not run"),
    }
}

/// Whether `cc` supports AddressSanitizer on this system: some systems lack its library.
fn has_sanitizer(folder: &SceneFolder) -> bool {
    let empty = folder.path("empty.c");
    std::fs::write(&empty, "int main(void) { return 0; }\n").expect("written");
    let output = Command::new("cc")
        .args(["-fsanitize=address,undefined", "-o"])
        .arg(folder.path("empty"))
        .arg(&empty)
        .output();
    output.is_ok_and(|output| output.status.success())
}

/// The compiler flags of a C client that is checked for invalid addresses and leaks.
fn sanitized(folder: &SceneFolder) -> Vec<&'static str> {
    let mut flags = vec!["-std=c11"];
    if has_sanitizer(folder) {
        flags.push("-fsanitize=address,undefined");
    } else {
        eprintln!("without AddressSanitizer, which cc does not have here");
    }
    flags
}

/// Sets the environment of a client that was compiled with these flags.
fn guarded<'a>(client: &'a mut Command, folder: &SceneFolder) -> &'a mut Command {
    // Memory that Embree keeps until the process ends is not our leak.
    std::fs::write(folder.path("leaks"), "leak:libembree4\nleak:libtbb\n").expect("written");
    client
        .env("LSAN_OPTIONS", "suppressions=leaks")
        .env("ASAN_OPTIONS", "allocator_may_return_null=1")
}

#[test]
fn call_overhead_benchmark_runs() {
    let folder = small();
    let flags = ["-std=c11", "-D_POSIX_C_SOURCE=200809L"];
    let program = compile("cc", &flags, &source("overhead.c"), &folder);
    println!("{}", run(&mut client(program, &folder)));
}

#[test]
fn arbitrary_arguments_return_a_status_without_leaks() {
    let folder = small();
    let program = compile("cc", &sanitized(&folder), &source("arbitrary.c"), &folder);
    let calls = if is_nightly() { "20000" } else { "8000" };
    let says = run(guarded(&mut client(program, &folder), &folder).args(["1", calls]));
    assert!(says.contains("all is well"), "{says}");
}

/// Names of the functions that the header declares.
fn declared() -> BTreeSet<String> {
    let header = std::fs::read_to_string(in_repository("capi/include/etendue.h"));
    let header = header.expect("the header");
    let code = header.lines().filter(|line| !line.starts_with("//"));
    let code: Vec<&str> = code.collect();
    names_before_parenthesis(&code.join("\n"))
}

/// The names that begin with `etd_` and stand before a parenthesis.
fn names_before_parenthesis(code: &str) -> BTreeSet<String> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let before = code.split('(').map(|part| {
        let start = part.rfind(|c| !is_name(c)).map_or(0, |at| at + 1);
        part[start..].to_owned()
    });
    before.filter(|name| name.starts_with("etd_")).collect()
}

#[test]
fn library_exports_exactly_the_header_functions() {
    let output = Command::new("nm")
        .args(["-D", "--defined-only"])
        .arg(prefix().join("lib/libetendue.so"))
        .output();
    let symbols = expect_success("nm", output.expect("nm is installed"));
    let symbols: BTreeSet<String> = symbols
        .lines()
        .filter_map(|line| line.split_whitespace().last())
        .map(str::to_owned)
        .collect();
    let declared = declared();
    assert!(declared.len() > 30, "{declared:?}");
    assert_eq!(symbols, declared);
}

#[test]
fn header_matches_the_sources() {
    // The whole header is compared if cbindgen is installed; functions and structures always.
    let folders = ["capi/src", "capi/src/describe"].map(in_repository);
    let entries = folders.iter().flat_map(|folder| {
        let entries = std::fs::read_dir(folder).expect("the sources");
        entries.map(|entry| entry.expect("an entry").path())
    });
    let mut exported = BTreeSet::new();
    let mut structures = BTreeSet::new();
    for file in entries.filter(|path| path.is_file()) {
        let text = std::fs::read_to_string(file).expect("a source");
        for after in text.split("#[unsafe(no_mangle)]").skip(1) {
            let line = after.split_once("extern \"C\" fn ").expect("a function").1;
            let name = line.split('(').next().expect("its name");
            exported.insert(name.to_owned());
        }
        for after in text.split("pub struct Etd").skip(1) {
            let name: String = after.chars().take_while(|c| c.is_alphanumeric()).collect();
            structures.insert(format!("}} Etd{name};"));
        }
    }
    assert_eq!(exported, declared());
    let path = in_repository("capi/include/etendue.h");
    let header = std::fs::read_to_string(&path).expect("the header");
    for structure in structures {
        let opaque = structure.replace("} ", "typedef struct ");
        let is_there = header.contains(&structure) || header.contains(opaque.trim_end_matches(';'));
        assert!(is_there, "{structure}: run `make header`");
    }
    let cbindgen = Command::new("cbindgen")
        .current_dir(in_repository("capi"))
        .args(["--quiet", "--config", "cbindgen.toml", "."])
        .output();
    match cbindgen {
        Ok(output) => {
            let made =
                expect_success("cbindgen", output).replace("// # Safety\n", "// Pointers:\n");
            assert!(made == header, "run `make header`");
        }
        Err(_) => eprintln!("cbindgen is not there: only names were compared"),
    }
}

/// A cbindgen that fails leaves the header as it is.
#[cfg(unix)]
#[test]
fn header_is_kept_if_it_cannot_be_made() {
    use std::os::unix::fs::PermissionsExt;
    let folder = SceneFolder::new([("cbindgen", "#!/bin/sh\nexit 1\n")]);
    let permissions = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder.path("cbindgen"), permissions).expect("it is ours");
    std::fs::create_dir_all(folder.path("capi/include")).expect("a new folder");
    let header = folder.path("capi/include/etendue.h");
    std::fs::write(&header, "/* whole */").expect("it is written");
    let path = std::env::var("PATH").expect("there are programs");
    let make = Command::new("make")
        .current_dir(folder.root())
        .arg("-f")
        .arg(in_repository("Makefile"))
        .arg("header")
        .env("PATH", format!("{}:{path}", folder.root().display()))
        .output();
    assert!(!make.expect("make is installed").status.success());
    let kept = std::fs::read_to_string(&header).expect("it is there");
    assert_eq!(kept, "/* whole */");
}

#[test]
fn static_library_links() {
    let folder = small();
    let archive = prefix().join("lib/libetendue.a");
    let private: Vec<String> = pkg_config(&["--static", "--libs"])
        .into_iter()
        .filter(|flag| flag != "-letendue")
        .collect();
    let program = folder.path("static");
    let mut compiler = Command::new("cc");
    compiler
        .arg(source("version.c"))
        .arg("-o")
        .arg(&program)
        .args(pkg_config(&["--cflags"]))
        .arg(&archive)
        .args(&private);
    expect_success("cc", compiler.output().expect("a compiler is installed"));
    let says = run(&mut Command::new(&program));
    assert_eq!(says.trim(), env!("CARGO_PKG_VERSION"));
}

#[test]
fn installation_does_not_depend_on_the_build_directory() {
    for file in ["bin/etendue", "lib/libetendue.so"] {
        let output = Command::new("ldd").arg(prefix().join(file)).output();
        let libraries = expect_success("ldd", output.expect("ldd is installed"));
        assert!(libraries.contains("libembree4"), "{file}: {libraries}");
        assert!(!libraries.contains("not found"), "{file}: {libraries}");
        let source = in_repository("");
        let source = source.to_string_lossy();
        assert!(!libraries.contains(&*source), "{file}: {libraries}");
    }
    let says = Command::new(prefix().join("bin/etendue"))
        .arg("info")
        .output();
    expect_success("etendue info", says.expect("it is installed"));
}
