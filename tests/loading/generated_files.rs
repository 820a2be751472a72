//! Scenes and models composed at random of valid, nearly valid and invalid pieces: what loads is consistent and can be
//! prepared, and any error names the file and the line. `damaged_files.rs` damages whole files instead.

use crate::common::scene_folder::{HEAD, SceneFolder};
use etendue::ErrorKind;
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, prop_oneof, proptest};
use proptest::sample::select;

/// Valid and invalid numbers.
const NUMBERS: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-3",
    "3",
    "45",
    "1e30",
    "-1e-30",
    "1e38",
    "1e308",
    "1e-320",
    "1e999",
    "nan",
    "inf",
    "-0.0",
    "0x10",
    "1_0",
    "18446744073709551616",
];

/// Values of other types.
const VALUES: &[&str] = &[
    "true",
    "'a'",
    "'b'",
    "''",
    "'#ff8000'",
    "'#12'",
    "'gold'",
    "'path'",
    "'box'",
    "[]",
    "[1, 2]",
    "[0, 0, 1]",
    "[0, 1, 0]",
    "[1, 0, 0]",
    "[0, 0, 0]",
    "[4, 4]",
    "[[0, 0, 0], [1, 0, 0], [0, 1, 0]]",
    "[[0, 1, 2]]",
    "[[0, 0, 9]]",
    "{ texture = 'none.png' }",
    "{ checker = [0.2, 0.7], repeat = [2, 2] }",
    "{ checker = [1, 2] }",
    "{ scale = 2 }",
    "[{ scale = 2 }]",
    "[{ scale = 0 }]",
    "[{ rotate = { axis = [0, 1, 0], angle = 30 } }, { translate = [1, 2, 3] }]",
    "[{ matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }]",
    "[{ time = 0, transform = [{ scale = 1 }] }, { time = 1, transform = [{ scale = 2 }] }]",
    "1979-05-27",
    "\"\\u0000\"",
];

/// Tables with keys that belong to them.
const TABLES: &[(&str, &[&str])] = &[
    (
        "[[material]]",
        &[
            "name = 'a'",
            "name = 'b'",
            "type = 'diffuse'",
            "type = 'mirror'",
            "type = 'dielectric'",
            "type = 'conductor'",
            "type = 'phong'",
            "type = 'plastic'",
            "type = 'principled'",
            "preset = 'gold'",
            "reflectance",
            "roughness",
            "ior",
            "tint",
            "eta",
            "k",
            "diffuse",
            "specular",
            "exponent",
            "base_color",
            "metallic",
            "clear_coat",
            "transmission",
            "alpha",
            "normal_map",
            "bump_map",
            "two_sided",
        ],
    ),
    (
        "[[shape]]",
        &[
            "type = 'sphere'",
            "type = 'rectangle'",
            "type = 'disk'",
            "type = 'box'",
            "type = 'mesh'",
            "type = 'obj'",
            "center = [0, 0, 0]",
            "radius",
            "corner = [0, 0, 0]",
            "edge_u = [1, 0, 0]",
            "edge_v = [0, 1, 0]",
            "normal = [0, 0, 1]",
            "min = [0, 0, 0]",
            "max = [1, 1, 1]",
            "positions",
            "indices",
            "normals",
            "uvs",
            "file = 'm.obj'",
            "material = 'a'",
            "emission",
            "two_sided_emission",
            "transform",
            "motion",
            "group = 'a'",
            "group = 'b'",
            "name = 'it'",
        ],
    ),
    (
        "[[light]]",
        &[
            "type = 'environment'",
            "type = 'point'",
            "type = 'spot'",
            "type = 'distant'",
            "radiance",
            "position",
            "intensity",
            "target",
            "cone",
            "penumbra",
            "direction",
            "irradiance",
            "transform",
        ],
    ),
    (
        "[[instance]]",
        &[
            "of = 'a'",
            "of = 'b'",
            "group = 'a'",
            "group = 'b'",
            "transform",
            "motion",
        ],
    ),
    (
        "[film]",
        &[
            "size",
            "filter",
            "filter = 'tent'",
            "filter = { type = 'mitchell', radius = 2 }",
        ],
    ),
    (
        "[render]",
        &[
            "integrator",
            "sampler = 'sobol'",
            "spp",
            "max_bounces",
            "seed",
            "roulette",
            "occlusion_distance",
        ],
    ),
];

fn value() -> impl Strategy<Value = String> {
    let number = || select(NUMBERS).prop_map(str::to_owned);
    let triple = [number(), number(), number()].prop_map(|[x, y, z]| format!("[{x}, {y}, {z}]"));
    prop_oneof![number(), triple, select(VALUES).prop_map(str::to_owned)]
}

/// A table with keys in any order, sometimes one twice, or one of another table.
fn table() -> impl Strategy<Value = String> {
    let line = |keys: &'static [&'static str]| {
        (select(keys), value()).prop_map(|(key, value)| {
            if key.contains('=') {
                format!("{key}\n")
            } else {
                format!("{key} = {value}\n")
            }
        })
    };
    let (index, stray) = (0..TABLES.len(), 0..4 * TABLES.len());
    (index, stray).prop_flat_map(move |(index, stray)| {
        let (head, keys) = TABLES[index];
        let (_, others) = TABLES.get(stray).copied().unwrap_or(TABLES[index]);
        let lines = vec(prop_oneof![8 => line(keys), 1 => line(others)], 0..8);
        lines.prop_map(move |lines| format!("{head}\n{}", lines.concat()))
    })
}

/// A line of a model: vertex data, a face, or another statement, not always valid.
fn model_line() -> impl Strategy<Value = String> {
    let number = || select(&NUMBERS[..13]);
    let corner = || {
        let index = || {
            select(
                &[
                    "1",
                    "2",
                    "3",
                    "4",
                    "-1",
                    "-2",
                    "0",
                    "9",
                    "",
                    "x",
                    "4294967297",
                ][..],
            )
        };
        prop_oneof![
            4 => (1..4_usize).prop_map(|index| index.to_string()),
            1 => [index(), index(), index()].prop_map(|[v, vt, vn]| format!("{v}/{vt}/{vn}")),
            1 => [index(), index()].prop_map(|[v, vt]| format!("{v}/{vt}")),
        ]
    };
    let numbers = (select(&["v", "vt", "vn"][..]), vec(number(), 1..5))
        .prop_map(|(key, numbers)| format!("{key} {}", numbers.join(" ")));
    let face = vec(corner(), 1..6).prop_map(|corners| format!("f {}", corners.join(" ")));
    let other = select(
        &[
            "",
            "o",
            "g a b",
            "usemtl a",
            "usemtl c",
            "mtllib m.mtl",
            "mtllib none.mtl",
            "l 1 2",
            "s off",
            "\\",
            "f 1 2 \\",
            "#\\",
            "f",
        ][..],
    );
    prop_oneof![4 => numbers, 4 => face, 2 => other.prop_map(str::to_owned)]
}

/// Checks that the scene is consistent and can be prepared, or that the error is one line that begins with the place.
fn check(folder: &SceneFolder, scene: &str) {
    let path = folder.path(scene);
    let error = match load(&path) {
        Ok(description) => return check_description(&description),
        Err(error) => error,
    };
    let message = error.to_string();
    assert!(
        matches!(error.kind(), ErrorKind::Scene | ErrorKind::Io),
        "{message}"
    );
    assert!(!message.contains('\n') && message.len() < 2000, "{message}");
    let rest = message.strip_prefix(&path.display().to_string());
    let rest = rest.unwrap_or_else(|| panic!("no file named: {message}"));
    // Only these errors have no line.
    if rest.contains("found no faces") || rest.contains("too large to be framed") {
        return;
    }
    let line = rest
        .strip_prefix(':')
        .and_then(|rest| rest.split(':').next());
    let line: Option<usize> = line.and_then(|line| line.parse().ok());
    let text = std::fs::read_to_string(&path).expect("it was written");
    let lines = 1..=text.lines().count().max(1);
    assert!(
        line.is_some_and(|line| lines.contains(&line)),
        "no valid line named: {message}"
    );
}

fn check_description(description: &SceneDescription) {
    for shape in &description.shapes {
        assert!(shape.material < description.materials.len());
        if let GeometryDescription::Mesh(mesh) = &shape.geometry {
            let count = mesh.positions.len() as u32;
            assert!(mesh.positions.iter().all(|p| p.is_finite()));
            assert!(mesh.indices.iter().flatten().all(|index| *index < count));
            assert!([0, count as usize].contains(&mesh.normals.len()));
            assert!([0, count as usize].contains(&mesh.uvs.len()));
        }
    }
    let options = AccelOptions {
        backend: Backend::ALL[0],
        precision: Precision::Robust,
        quality: None,
        threads: 1,
    };
    if let Err(error) = prepare(description, options) {
        assert_eq!(error.kind(), ErrorKind::Scene, "{error}");
    }
}

const MODEL: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
const LIBRARY: &str = "newmtl a\nKd 1 0 0\nnewmtl b\n";

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    #[test]
    fn generated_scene_files_load_or_fail_with_file_and_line(
        head in prop_oneof![9 => Just(HEAD), 1 => Just("version = 1\n[camera]\n")],
        tables in vec(table(), 1..5),
    ) {
        let text = head.to_owned() + &tables.concat();
        check(&SceneFolder::new([("a.toml", text.as_str()), ("m.obj", MODEL), ("m.mtl", LIBRARY)]), "a.toml");
    }

    #[test]
    fn generated_obj_models_load_or_fail_with_file_name(lines in vec(model_line(), 0..12)) {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", lines.join("\n"));
        check(&SceneFolder::new([("a.obj", text.as_str()), ("m.mtl", LIBRARY)]), "a.obj");
    }
}
