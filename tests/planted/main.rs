//! The planted bugs are all in the table, each once, and no build without debug assertions can contain them.

mod table;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use table::PLANTED;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every source file below a folder.
fn source_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a source folder can be read");
    let paths = entries.map(|entry| entry.expect("its entries can be read").path());
    let files = paths.flat_map(|path| {
        if path.is_dir() {
            source_files(&path)
        } else {
            vec![path]
        }
    });
    files
        .filter(|file| file.extension().is_some_and(|it| it == "rs"))
        .collect()
}

/// The names of the bugs planted in a source text.
fn planted_in(text: &str) -> impl Iterator<Item = &str> {
    text.split("planted!(").skip(1).map(|after| {
        let quoted = after.trim_start().strip_prefix('"');
        let name = quoted.and_then(|name| name.split('"').next());
        name.expect("the macro's first argument is a name")
    })
}

/// The file that holds a test, and the test's own name.
fn file_of(killer: &str) -> (PathBuf, &str) {
    let (modules, test) = killer.rsplit_once("::").expect("target::test");
    let Some(modules) = modules.strip_prefix("lib::") else {
        let modules = modules.replace("::", "/");
        let in_package = |package: &str| root().join(format!("{package}tests/{modules}.rs"));
        let files = ["", "lab/", "cli/"].map(in_package);
        let [renderer, ..] = &files;
        let found = files.iter().find(|file| file.is_file());
        return (found.unwrap_or(renderer).clone(), test);
    };
    let modules = modules.trim_end_matches("::tests").replace("::", "/");
    let file = root().join(format!("src/{modules}.rs"));
    if file.is_file() {
        return (file, test);
    }
    (root().join(format!("src/{modules}/mod.rs")), test)
}

/// The output of this test is read by `scripts/mutants.sh`.
#[test]
fn planted_bug_names_are_unique_and_their_tests_exist() {
    let mut names = BTreeSet::new();
    println!();
    for bug in PLANTED {
        println!("planted\t{}\t{}\t{}", bug.name, bug.killer, bug.wrong);
        assert!(names.insert(bug.name), "{} is in the table twice", bug.name);
        assert!(
            !bug.wrong.is_empty(),
            "{}: the description is empty",
            bug.name
        );
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(bug.name.chars().all(is_plain), "{}", bug.name);
        let (file, test) = file_of(bug.killer);
        let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{file:?}: {error}"));
        let defines = text.contains(&format!("#[test]\nfn {test}()"))
            || text.contains(&format!("#[test]\n    fn {test}()"));
        assert!(defines, "{}: no test {test} in {file:?}", bug.name);
    }
}

#[test]
fn planted_bug_table_matches_the_source_sites() {
    let mut sites = Vec::new();
    let sources = ["src", "lab/src", "cli/src"].map(|folder| source_files(&root().join(folder)));
    for file in sources.concat() {
        if file.ends_with("src/planted.rs") {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a source file is text");
        sites.extend(planted_in(&text).map(str::to_owned));
    }
    sites.sort_unstable();
    let mut table: Vec<_> = PLANTED.iter().map(|bug| bug.name).collect();
    table.sort_unstable();
    assert_eq!(sites, table);
}

/// The output of the compiler for the macro's file, with the planted bugs enabled.
fn compiled(debug_assertions: bool) -> Output {
    let compiler = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let flag = if debug_assertions { "on" } else { "off" };
    let into = tempfile::tempdir().expect("a temporary folder");
    let output = Command::new(compiler)
        .args(["--crate-type=lib", "--emit=metadata", "--edition=2024"])
        .args(["--cfg=etendue_mutants", "-C"])
        .arg(format!("debug-assertions={flag}"))
        .arg("--out-dir")
        .arg(into.path())
        .arg(root().join("src/planted.rs"))
        .output();
    output.expect("the compiler that built this runs")
}

#[test]
fn planted_bugs_do_not_compile_without_debug_assertions() {
    let refused = compiled(false);
    let reason = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success() && reason.contains("planted bugs are for tests"));
    let allowed = compiled(true);
    let reason = String::from_utf8_lossy(&allowed.stderr);
    assert!(allowed.status.success(), "{reason}");
}

#[test]
fn planted_site_scanner_extracts_bug_names() {
    let text = "planted!(\"a\", 1, 2) + planted!(\n    \"b-c\",\n    x,\n)";
    assert_eq!(planted_in(text).collect::<Vec<_>>(), ["a", "b-c"]);
}
