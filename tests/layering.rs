//! The renderer has layers: a module imports only modules listed before it in `LAYERS`; and no modules of any package import each
//! other in a cycle, at any depth of folders.
//!
//! Reads every path that begins with `crate::` or `super::` in the sources of all packages, `mod.rs` files and groups in braces
//! included. Cargo itself rejects cycles of packages. The renderer calls no function whose bits the processor decides, and has at most
//! 60 kernel instances.

use etendue::internals::effects::Kernel;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Every module of the crate's root with its layer, from the lowest to the highest.
const LAYERS: &[(&str, u32)] = &[
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
    ("state", 6),
    ("session", 7),
];

/// The places where `unsafe` is allowed.
const UNSAFE_PLACES: &[&str] = &["src/accel/embree", "src/post/oidn.rs", "capi/src"];

/// A module as its path from the crate's root, such as `["render", "adaptive"]`; the root itself has none.
type Module = Vec<String>;

/// The code of each module of a package.
type Package = BTreeMap<Module, String>;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a source folder can be read");
    let paths = entries.map(|entry| entry.expect("its entries can be read").path());
    let files = paths.flat_map(|path| match path.is_dir() {
        true => files_below(&path),
        false => vec![path],
    });
    files
        .filter(|file| file.extension().is_some_and(|it| it == "rs"))
        .collect()
}

/// Reads the sources of a package, below its folder `src`.
fn package(sources: &str) -> Package {
    let root = repository().join(sources);
    let read = |file: PathBuf| {
        let text = fs::read_to_string(&file).expect("a source file is text");
        let below = file.strip_prefix(&root).expect("files come from there");
        (module_of(below), code(&text))
    };
    files_below(&root).into_iter().map(read).collect()
}

/// The module of a file below `src/`.
fn module_of(file: &Path) -> Module {
    let file = file.with_extension("");
    let mut module: Module = file
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    let names_folder = |name: &String| ["mod", "lib", "main"].contains(&name.as_str());
    module.pop_if(|name| names_folder(name));
    module
}

/// The code of a file: without comments and without its tests, which may import more.
fn code(text: &str) -> String {
    let before_tests = text.split("#[cfg(test)]\nmod tests").next();
    let lines = before_tests.expect("split yields one part").lines();
    let code = lines.map(|line| line.split("//").next().expect("as above"));
    code.collect::<Vec<_>>().join("\n")
}

/// Reads the path at the start of `text` and adds it to `paths`, with one path for each item in braces. Returns the rest.
fn read_path<'a>(text: &'a str, before: &[String], paths: &mut Vec<Vec<String>>) -> &'a str {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut path = before.to_vec();
    let mut rest = text;
    loop {
        let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
        if end > 0 {
            path.push(rest[..end].to_owned());
            rest = &rest[end..];
            match rest.strip_prefix("::") {
                Some(further) => rest = further,
                None => break,
            }
        } else if let Some(mut group) = rest.strip_prefix('{') {
            loop {
                group = group.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
                if let Some(after) = group.strip_prefix('}') {
                    return after;
                }
                let after = read_path(group, &path, paths);
                // Skips `*` and ` as name`, which are not paths.
                group = after.trim_start_matches(|c| !matches!(c, ',' | '}'));
                if group.is_empty() {
                    return group;
                }
            }
        } else {
            break;
        }
    }
    paths.push(path);
    rest
}

/// Every path that a module names, from the crate's root.
fn named_paths(module: &[String], code: &str) -> Vec<Vec<String>> {
    let begins_word = |at: usize| {
        let before = code[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':')
    };
    let mut paths = Vec::new();
    for (at, _) in code
        .match_indices("crate::")
        .filter(|&(at, _)| begins_word(at))
    {
        read_path(&code[at + "crate::".len()..], &[], &mut paths);
    }
    for (at, _) in code
        .match_indices("super::")
        .filter(|&(at, _)| begins_word(at))
    {
        let (mut rest, mut from) = (&code[at..], module);
        while let Some(further) = rest.strip_prefix("super::") {
            rest = further;
            from = from.split_last().map_or(from, |(_, parent)| parent);
        }
        read_path(rest, from, &mut paths);
    }
    paths
}

/// The items of its children that a module imports or exports, by name, each with its path.
fn re_exports(module: &Module, package: &Package) -> BTreeMap<String, Vec<String>> {
    let code = &package[module];
    let mut paths = Vec::new();
    for (at, word) in code.match_indices("use ") {
        let rest = &code[at + word.len()..];
        read_path(rest.strip_prefix("self::").unwrap_or(rest), &[], &mut paths);
    }
    let of_child = paths.into_iter().filter_map(|path| {
        let child = [module.as_slice(), path.get(..1)?].concat();
        let item = path.last().filter(|_| path.len() > 1)?.clone();
        let full = [module.as_slice(), path.as_slice()].concat();
        package.contains_key(&child).then_some((item, full))
    });
    of_child.collect()
}

/// The module that has the item at the end of a path, through the re-exports of its ancestors.
fn module_of_item(mut path: Vec<String>, package: &Package) -> Module {
    // Re-exports of re-exports are few.
    for _ in 0..8 {
        let known = (0..=path.len())
            .rev()
            .find(|&n| package.contains_key(&path[..n]));
        let known = known.unwrap_or(0);
        let module = path[..known].to_vec();
        let item = path.get(known).filter(|_| package.contains_key(&module));
        match item.and_then(|item| re_exports(&module, package).remove(item)) {
            Some(target) => path = [target, path[known + 1..].to_vec()].concat(),
            None => return module,
        }
    }
    path
}

/// The imports between modules of the same folder: an import counts for the two modules at which the paths of importer and
/// imported diverge. Imports of a module's own children or of its parents' own items do not count.
fn imports(package: &Package) -> BTreeMap<Module, BTreeSet<Module>> {
    let mut imports: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for (module, code) in package {
        for path in named_paths(module, code) {
            let named = module_of_item(path, package);
            let alike = module
                .iter()
                .zip(&named)
                .take_while(|(a, b)| a == b)
                .count();
            if alike < module.len() && alike < named.len() {
                let importer = module[..=alike].to_vec();
                imports
                    .entry(importer)
                    .or_default()
                    .insert(named[..=alike].to_vec());
            }
        }
    }
    imports
}

/// Modules of the crate's root that import one listed after them.
fn upward_imports(package: &Package) -> Vec<String> {
    let place = |module: &Module| LAYERS.iter().position(|(name, _)| *name == module[0]);
    let imports = imports(package);
    let at_root = imports.iter().filter(|(module, _)| module.len() == 1);
    let pairs = at_root.flat_map(|(module, named)| named.iter().map(move |it| (module, it)));
    pairs
        .filter(|(module, named)| place(named) > place(module))
        .map(|(module, named)| {
            format!(
                "{} imports {}, which is listed after it",
                module[0], named[0]
            )
        })
        .collect()
}

/// Modules that are part of an import cycle.
fn circles(package: &Package) -> Vec<String> {
    let imports = imports(package);
    let is_in_circle = |start: &&Module| {
        let mut seen = BTreeSet::new();
        let mut open: Vec<&Module> = imports[*start].iter().collect();
        while let Some(next) = open.pop() {
            if next == *start {
                return true;
            }
            if seen.insert(next) {
                open.extend(imports.get(next).into_iter().flatten());
            }
        }
        false
    };
    imports
        .keys()
        .filter(is_in_circle)
        .map(|module| module.join("/"))
        .collect()
}

#[test]
fn every_root_module_is_assigned_to_a_layer() {
    let known: BTreeSet<&str> = LAYERS.iter().map(|(name, _)| *name).collect();
    let package = package("src");
    let unknown: Vec<_> = package
        .keys()
        .filter_map(|module| module.first())
        .filter(|name| !known.contains(name.as_str()))
        .collect();
    assert!(
        unknown.is_empty(),
        "no layer for {unknown:?}: add it to LAYERS in tests/layering.rs"
    );
    assert!(
        LAYERS.windows(2).all(|pair| pair[0].1 <= pair[1].1),
        "layers of LAYERS are in ascending order"
    );
}

#[test]
fn root_modules_import_only_modules_listed_before_them() {
    let wrong = upward_imports(&package("src"));
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn modules_have_no_import_cycles() {
    for sources in ["src", "lab/src", "cli/src", "capi/src"] {
        let wrong = circles(&package(sources));
        assert!(wrong.is_empty(), "{sources}: {wrong:#?}");
    }
}

/// The number of kernel instances: for each kernel and integrator one of each job (docs/architecture.md, "Effects").
#[test]
fn there_are_at_most_60_kernel_instances() {
    let code: String = package("src").into_values().collect();
    // Calls may be broken into lines anywhere.
    let code: String = code.split_whitespace().collect();
    let count = |pattern: &str| code.matches(pattern).count();
    let kernels = Kernel::ALL.len();
    let integrators = count("run_matte_or_everything(kernel,With(job,");
    let observed_jobs = count("dispatch::dispatch_to_matte_or_everything(");
    let unobserved_jobs = count("IntegratorJobfor") - observed_jobs;
    // All but the job that joins a job with its integrator.
    let other_jobs = count("KernelJobfor") - 1;
    assert!(integrators >= 5 && observed_jobs == 1 && unobserved_jobs == 2 && other_jobs >= 5);
    let instances = unobserved_jobs * (kernels + 2 * (integrators - 1))
        + observed_jobs * 2 * integrators
        + other_jobs * 2
        // First hits, whose kernel has every effect.
        + 1;
    println!("{instances} kernel instances");
    assert!(instances <= 60, "{instances}");
}

#[test]
fn unsafe_code_is_in_allowed_places_with_safety_comments() {
    let folders = ["src", "lab/src", "cli/src", "capi/src"].map(|folder| repository().join(folder));
    for file in folders.iter().flat_map(|folder| files_below(folder)) {
        let relative = file
            .strip_prefix(repository())
            .expect("files come from there");
        let relative = relative.to_string_lossy().replace('\\', "/");
        let text = fs::read_to_string(&file).expect("a source file is text");
        let lines: Vec<&str> = text.lines().collect();
        for (index, line) in lines.iter().enumerate() {
            let statement = line.split("//").next().expect("split yields one part");
            if !statement.contains("unsafe ") || statement.contains("unsafe_") {
                continue;
            }
            let place = format!("{relative}:{}", index + 1);
            assert!(
                UNSAFE_PLACES.iter().any(|room| relative.starts_with(room)),
                "{place}: unsafe code outside {UNSAFE_PLACES:?}"
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

/// Functions whose last bits depend on the processor or on the C library, by their calls.
const MACHINE_FUNCTIONS: &[&str] = &[
    ".sin(",
    ".cos(",
    ".tan(",
    ".sin_cos(",
    ".asin(",
    ".acos(",
    ".atan(",
    ".atan2(",
    ".sinh(",
    ".cosh(",
    ".tanh(",
    ".exp(",
    ".exp2(",
    ".exp_m1(",
    ".ln(",
    ".log(",
    ".log2(",
    ".log10(",
    ".ln_1p(",
    ".powf(",
    ".cbrt(",
    ".hypot(",
    "from_rotation_",
    "from_axis_angle",
    "angle_between",
    "slerp(",
];

/// The calls of these functions, each with its module.
fn calls_of_machine_functions(package: &Package) -> Vec<String> {
    let modules = package
        .iter()
        .filter(|(module, _)| module.join("::") != "math::functions");
    let calls = modules.flat_map(|(module, code)| {
        let found = MACHINE_FUNCTIONS
            .iter()
            .filter(|call| code.contains(**call));
        found.map(|call| format!("{}: {call}", module.join("::")))
    });
    calls.collect()
}

#[test]
fn transcendental_functions_are_the_same_on_every_processor() {
    let calls = calls_of_machine_functions(&package("src"));
    assert!(calls.is_empty(), "math/functions.rs has these: {calls:#?}");
    let wrong = small(&[("film/filter.rs", "fn f(x: f64) -> f64 { x.exp() }")]);
    assert_eq!(calls_of_machine_functions(&wrong), ["film::filter: .exp("]);
}

/// A package of a few files.
fn small(files: &[(&str, &str)]) -> Package {
    let module = |(file, text): &(&str, &str)| (module_of(Path::new(file)), code(text));
    files.iter().map(module).collect()
}

#[test]
fn upward_imports_are_detected_in_plain_and_mod_files() {
    for importer in ["math/vec.rs", "math/mod.rs", "math.rs"] {
        let wrong = |text| upward_imports(&small(&[(importer, text), ("scene/mod.rs", "")])).len();
        assert_eq!(wrong("use crate::scene::Scene;"), 1, "{importer}");
        assert_eq!(wrong("use crate::{film, scene::{Scene, check}};"), 1);
        assert_eq!(wrong("fn f() -> crate::scene::Scene { todo!() }"), 1);
        assert_eq!(wrong("// crate::scene is above\nuse std::fmt;"), 0);
    }
    let down = [
        ("scene/mod.rs", "use crate::math::vec::Vec3;"),
        ("math/vec.rs", ""),
    ];
    assert!(upward_imports(&small(&down)).is_empty());
}

#[test]
fn import_cycles_are_detected_across_folders_and_mod_files() {
    let settings = ("render/settings.rs", "use super::adaptive::Adaptive;");
    let one_way = [settings, ("render/adaptive/mod.rs", "")];
    assert!(circles(&small(&one_way)).is_empty());
    let files = [
        ("render/adaptive/mod.rs", "use super::settings::Budget;"),
        (
            "render/adaptive/mod.rs",
            "use crate::render::settings::Budget;",
        ),
        (
            "render/adaptive/greedy.rs",
            "use super::super::settings::Budget;",
        ),
        (
            "render/adaptive/greedy.rs",
            "use crate::{math, render::{film, settings::Budget}};",
        ),
    ];
    for file in files {
        let parent = ("render/adaptive/mod.rs", "");
        let package: Vec<_> = if file.0 == parent.0 {
            vec![settings, file]
        } else {
            vec![settings, parent, file]
        };
        let found = circles(&small(&package));
        assert_eq!(found, ["render/adaptive", "render/settings"], "{file:?}");
    }
    // A cycle of three modules.
    let three = [
        ("a.rs", "use super::b::B;"),
        ("b.rs", "use crate::c::C;"),
        ("c/mod.rs", "use crate::a::A;"),
    ];
    assert_eq!(circles(&small(&three)), ["a", "b", "c"]);
    // A cycle through what the parent exports.
    let parent = (
        "render/mod.rs",
        "mod progress; mod rendered; pub use rendered::{Price, Rendered};",
    );
    let exported = [
        parent,
        ("render/progress.rs", "use super::Rendered;"),
        ("render/rendered.rs", "use super::progress::Predicted;"),
    ];
    let found = circles(&small(&exported));
    assert_eq!(found, ["render/progress", "render/rendered"]);
    // A child may import items of its parent, and a parent items of its children.
    let family = [
        ("a/mod.rs", "use b::B; pub struct A;"),
        ("a/b.rs", "use super::A;"),
    ];
    assert!(circles(&small(&family)).is_empty());
}
