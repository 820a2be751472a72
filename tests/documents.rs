//! Documents, comments and committed reports contain no path of the machine that they were made on, and the files of the
//! repository that they name exist.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Prefixes of paths that belong to a user or a machine.
const FOREIGN: [&str; 5] = ["/home/", "/root/", "/tmp/", "/Users/", "/work/"];

/// Folders that are not part of the sources.
const NOT_OURS: [&str; 6] = [".git", ".embree", "target", "out", "found", "artifacts"];

/// Extensions of text files.
const TEXTS: [&str; 18] = [
    "rs", "md", "toml", "sh", "py", "c", "h", "cpp", "in", "mtl", "json", "lock", "svg", "xml",
    "pbrt", "dict", "obj", "txt",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The files below a folder that have an extension of [`TEXTS`] or none.
fn texts(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder of the sources can be read");
    let paths = entries.map(|entry| entry.expect("its entries can be read").path());
    let files = paths.flat_map(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let ending = path.extension().map(|it| it.to_string_lossy());
        match ending {
            _ if NOT_OURS.contains(&&*name) => vec![],
            _ if path.is_dir() => texts(&path),
            Some(ending) if !TEXTS.contains(&&*ending) => vec![],
            _ => vec![path],
        }
    });
    files.collect()
}

/// Words of a text that are paths of a machine; `root` is the path of these sources.
fn foreign_paths<'a>(text: &'a str, root: &str) -> Vec<&'a str> {
    let is_end = |c: char| c.is_whitespace() || "`'\"()[]|,;".contains(c);
    let words = text.split(is_end);
    words
        .filter(|word| {
            let begins = FOREIGN.iter().any(|folder| {
                let rest = word.strip_prefix(folder);
                rest.is_some_and(|rest| rest.starts_with(char::is_alphanumeric))
            });
            begins || (root.len() > 1 && word.starts_with(&format!("{root}/")))
        })
        .collect()
}

/// The Rust files that a text names by their paths from the root of the repository.
fn named_files(text: &str) -> impl Iterator<Item = &str> {
    const FOLDERS: [&str; 9] = [
        "src/",
        "tests/",
        "lab/",
        "cli/",
        "capi/",
        "benches/",
        "docs/",
        "examples/",
        "scripts/",
    ];
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.filter(|name| {
        let is_path = name
            .chars()
            .all(|c| c.is_alphanumeric() || "/_-.".contains(c));
        is_path && FOLDERS.iter().any(|folder| name.starts_with(folder))
    })
}

#[test]
fn text_files_contain_no_machine_specific_paths() {
    let here = root().to_string_lossy();
    let own = Path::new(file!()).file_name();
    for file in texts(root()).iter().filter(|it| it.file_name() != own) {
        let Ok(text) = fs::read_to_string(file) else {
            continue;
        };
        let found = foreign_paths(&text, &here);
        assert!(found.is_empty(), "{}: {found:?}", file.display());
    }
}

#[test]
fn paths_quoted_in_text_files_exist() {
    let mut missing = BTreeSet::new();
    let own = Path::new(file!()).file_name();
    for file in texts(root()).iter().filter(|it| it.file_name() != own) {
        let Ok(text) = fs::read_to_string(file) else {
            continue;
        };
        // From the root of the repository or of the file's package.
        let names_nothing = |name: &&str| !file.ancestors().any(|it| it.join(name).exists());
        // Line by line, as backticks are paired within a line.
        for name in text.lines().flat_map(named_files).filter(names_nothing) {
            missing.insert(format!("{}: {name}", file.display()));
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn path_scanners_find_machine_specific_and_quoted_paths() {
    let found = |text| foreign_paths(text, "/somewhere/else");
    assert_eq!(found("| 4.4.0 (/work/x/lib.so) |"), ["/work/x/lib.so"]);
    assert_eq!(found("`/home/me/a.toml`"), ["/home/me/a.toml"]);
    assert_eq!(found("in /somewhere/else/src"), ["/somewhere/else/src"]);
    assert!(found("/usr/lib/libembree4.so, $HOME/.local, /root/ and docs/work/").is_empty());
    let named: Vec<_> =
        named_files("see `tests/a.rs`, `x + y` and `src/b/`, not src/c.rs").collect();
    assert_eq!(named, ["tests/a.rs", "src/b/"]);
}
