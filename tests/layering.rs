//! The house has floors: a file imports what stands before it, never upwards and never in a circle.
//!
//! Reads every `crate::` path in `src/`. The order below is the order of the floors, and within a floor the order of
//! its rooms.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Every module of the crate's root, from the ground up, with its floor.
const HOUSE: &[(&str, u32)] = &[
    ("error", 0),
    ("planted", 0),
    ("memory", 0),
    ("effects", 0),
    ("math", 0),
    ("sampling", 1),
    ("image", 1),
    ("sampler", 1),
    ("geometry", 2),
    ("bsdf", 2),
    ("light", 2),
    ("camera", 2),
    ("accel", 3),
    ("film", 3),
    ("scene", 4),
    ("plan", 4),
    ("integrator", 5),
    ("render", 6),
    ("post", 6),
    ("session", 7),
    ("study", 7),
    ("bench", 7),
    ("lesson", 7),
    ("battery", 7),
    ("cli", 8),
];

/// Where `unsafe` may stand.
const UNSAFE_ROOMS: &[&str] = &["accel/embree", "post/oidn.rs"];

fn source_files() -> Vec<PathBuf> {
    files_below(&root())
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("src/ can be read") {
            let path = entry.expect("an entry of src/ can be read").path();
            if path.is_dir() {
                walk(&path, files);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    let mut files = Vec::new();
    walk(folder, &mut files);
    files
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The path below src/, with forward slashes.
fn below_root(file: &Path) -> String {
    let relative = file.strip_prefix(root()).expect("files come from src/");
    relative.to_string_lossy().replace('\\', "/")
}

/// The root module that a file belongs to.
fn room(file: &Path) -> String {
    let relative = below_root(file);
    let first = relative.split('/').next().expect("a path has a first part");
    first.trim_end_matches(".rs").to_owned()
}

/// The code of a file: without comments and without its tests, which may reach further.
fn code(text: &str) -> String {
    let before_tests = text
        .split("#[cfg(test)]\nmod tests")
        .next()
        .expect("split yields one part");
    let lines = before_tests
        .lines()
        .map(|line| line.split("//").next().expect("as above"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The root modules that a text names by `crate::name`, also in `crate::{a, b}`.
fn imports(code: &str) -> BTreeSet<String> {
    let mut names = names_after("crate::", code);
    names.retain(|name| HOUSE.iter().any(|(known, _)| known == name));
    names
}

/// The first names behind a prefix such as `crate::` or `super::`, also where a group in braces follows.
fn names_after(prefix: &str, code: &str) -> BTreeSet<String> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut names = BTreeSet::new();
    for part in code.split(prefix).skip(1) {
        let Some(group) = part.strip_prefix('{') else {
            names.insert(part.chars().take_while(|&c| is_name(c)).collect());
            continue;
        };
        // Of `{a::{b, c}, d}` the names a and d: those that begin right inside the braces.
        let (mut depth, mut begins) = (0, true);
        for (index, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => begins = true,
                _ if depth == 0 && begins && is_name(c) => {
                    names.insert(group[index..].chars().take_while(|&c| is_name(c)).collect());
                    begins = false;
                }
                _ => {}
            }
        }
    }
    names
}

/// Violations among `(room, code)` pairs.
fn upward_imports<'a>(files: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<String> {
    let place = |room: &str| HOUSE.iter().position(|(name, _)| *name == room);
    let mut wrong = Vec::new();
    for (room, code) in files {
        let Some(here) = place(room) else { continue };
        for import in imports(code) {
            let there = place(&import).expect("imports() yields known rooms");
            if there > here {
                wrong.push(format!("{room} imports {import}, which stands above it"));
            }
        }
    }
    wrong
}

#[test]
fn every_module_has_its_place_in_the_house() {
    let known: BTreeSet<&str> = HOUSE.iter().map(|(name, _)| *name).collect();
    let found: BTreeSet<String> = source_files().iter().map(|file| room(file)).collect();
    let unknown: Vec<_> = found
        .iter()
        .filter(|name| !known.contains(name.as_str()) && !["lib", "main"].contains(&name.as_str()))
        .collect();
    assert!(
        unknown.is_empty(),
        "no floor for {unknown:?}: add it to HOUSE in tests/layering.rs"
    );
    assert!(
        HOUSE.windows(2).all(|pair| pair[0].1 <= pair[1].1),
        "floors go up"
    );
}

#[test]
fn imports_point_down() {
    let texts: Vec<(String, String)> = source_files()
        .iter()
        .map(|file| {
            (
                room(file),
                code(&fs::read_to_string(file).expect("a source file is text")),
            )
        })
        .collect();
    let wrong = upward_imports(
        texts
            .iter()
            .map(|(room, code)| (room.as_str(), code.as_str())),
    );
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn files_of_one_module_do_not_import_in_a_circle() {
    // Within a room: `super::name` and `crate::room::name` edges between sibling files. A child may name its parent's
    // own items; siblings must not form a circle.
    let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in source_files() {
        let relative = below_root(&file);
        let Some((folder, name)) = relative.rsplit_once('/') else {
            continue;
        };
        if name == "mod.rs" {
            continue;
        }
        let here = format!("{folder}/{}", name.trim_end_matches(".rs"));
        let text = code(&fs::read_to_string(&file).expect("a source file is text"));
        let module_path = format!("crate::{}::", folder.replace('/', "::"));
        for prefix in ["super::", module_path.as_str()] {
            for name in names_after(prefix, &text) {
                if root().join(folder).join(format!("{name}.rs")).is_file() {
                    edges
                        .entry(here.clone())
                        .or_default()
                        .insert(format!("{folder}/{name}"));
                }
            }
        }
    }
    for start in edges.keys() {
        let mut seen = BTreeSet::new();
        let mut open: Vec<&String> = edges[start].iter().collect();
        while let Some(next) = open.pop() {
            assert_ne!(next, start, "{start} imports itself in a circle");
            if seen.insert(next) {
                open.extend(edges.get(next).into_iter().flatten());
            }
        }
    }
}

#[test]
fn unsafe_code_stays_in_its_rooms_and_gives_its_reason() {
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("capi/src");
    for file in source_files().into_iter().chain(files_below(&library)) {
        let is_library = file.starts_with(&library);
        let relative = if is_library {
            file.display().to_string()
        } else {
            below_root(&file)
        };
        let text = fs::read_to_string(&file).expect("a source file is text");
        let lines: Vec<&str> = text.lines().collect();
        for (index, line) in lines.iter().enumerate() {
            let statement = line.split("//").next().expect("split yields one part");
            if !statement.contains("unsafe ") || statement.contains("unsafe_") {
                continue;
            }
            let place = format!("{relative}:{}", index + 1);
            assert!(
                is_library || UNSAFE_ROOMS.iter().any(|room| relative.starts_with(room)),
                "{place}: unsafe code outside {UNSAFE_ROOMS:?}"
            );
            if statement.contains("unsafe {") || statement.contains("unsafe impl") {
                let reason = lines[index.saturating_sub(4)..index]
                    .iter()
                    .any(|above| above.trim_start().starts_with("// SAFETY:"));
                assert!(reason, "{place}: an unsafe block without `// SAFETY:`");
            }
        }
    }
}

#[test]
fn the_reader_of_imports_sees_what_it_should() {
    let names = |text: &str| imports(text).into_iter().collect::<Vec<_>>();
    assert_eq!(names("use crate::math::vec::Vec3;"), ["math"]);
    assert_eq!(
        names("use crate::{bsdf::{Bsdf, types}, math};"),
        ["bsdf", "math"]
    );
    assert_eq!(names("let x = crate::render::render();"), ["render"]);
    assert!(names("use std::fmt;").is_empty());
    let siblings: Vec<_> = names_after("super::", "use super::{a::B, c, d::{e, f}};")
        .into_iter()
        .collect();
    assert_eq!(siblings, ["a", "c", "d"]);
    // And an import upwards is reported.
    assert_eq!(
        upward_imports([("math", "use crate::scene::Scene;")]).len(),
        1
    );
    assert!(upward_imports([("scene", "use crate::math::vec::Vec3;")]).is_empty());
}
