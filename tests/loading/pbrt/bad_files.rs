//! Files that are broken: each is an error with the file, the line and what was expected, never a panic.

use super::HEAD;
use crate::common::scene_folder::SceneFolder;
use etendue::ErrorKind;
use etendue::internals::scene::load::load;

/// A scene with one of everything, for truncation and mutation.
const EVERYTHING: &str = include_str!("everything.pbrt");

/// Loads a text and returns the error.
fn error_of(text: &str) -> (ErrorKind, Option<usize>, String) {
    let folder = SceneFolder::new([("a.pbrt", text)]);
    let error = load(&folder.path("a.pbrt")).expect_err(text);
    assert!(
        error.file().is_some_and(|file| file.ends_with("a.pbrt")),
        "{error}"
    );
    (error.kind(), error.line(), error.to_string())
}

/// Asserts that each text, which follows `HEAD`, is an error at this line after it, and that its message contains these words.
fn assert_errors_after_head(cases: &[(&str, usize, &str)]) {
    let first = HEAD.lines().count() + 1;
    for &(text, line, expected) in cases {
        let (_, found, message) = error_of(&format!("{HEAD}{text}"));
        assert_eq!(found, Some(first + line), "{text:?}: {message}");
        assert!(message.contains(expected), "{text:?}: {message}");
    }
}

#[test]
fn invalid_statements_and_transforms_are_rejected_with_line() {
    assert_errors_after_head(&[
        ("Shpae \"sphere\"", 0, "did you mean `Shape`?"),
        ("[", 0, "expected a statement, found `[`"),
        (
            "Translate 1 2",
            0,
            "expected a number, found the end of the file",
        ),
        ("Translate 1 x 3", 0, "expected a number, found `x`"),
        ("Scale nan 1 1", 0, "expected a number, found `nan`"),
        ("Rotate 30 0 0 0", 0, "expected an axis"),
        ("LookAt 0 0 0 0 0 0 0 1 0", 0, "the same point"),
        (
            "Transform [ 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1 ]",
            0,
            "expected an affine matrix",
        ),
        ("Transform 1 0", 0, "expected `[` around sixteen numbers"),
        (
            "ConcatTransform [ 1 2 3 ]",
            0,
            "expected a number, found `]`",
        ),
        (
            "ActiveTransform Some",
            0,
            "expected All, StartTime or EndTime",
        ),
        ("TransformTimes 0 1", 0, "before WorldBegin"),
        ("WorldBegin", 0, "before WorldBegin"),
        ("Film \"rgb\"", 0, "expected Film before WorldBegin"),
    ]);
}

#[test]
fn invalid_blocks_and_objects_are_rejected_with_line() {
    assert_errors_after_head(&[
        (
            "\nAttributeBegin\n\n",
            1,
            "expected an AttributeEnd for this block",
        ),
        ("AttributeEnd", 0, "AttributeEnd without AttributeBegin"),
        ("ObjectEnd", 0, "ObjectEnd without ObjectBegin"),
        (
            "ObjectBegin \"a\"\nAttributeEnd",
            1,
            "expected ObjectEnd before AttributeEnd",
        ),
        (
            "AttributeBegin\nObjectEnd",
            1,
            "expected AttributeEnd before ObjectEnd",
        ),
        (
            "ObjectBegin \"a\"\nObjectBegin \"b\"",
            1,
            "expected ObjectEnd before another",
        ),
        (
            "ObjectBegin \"a\"\nObjectEnd\nObjectBegin \"a\"",
            2,
            "already",
        ),
        ("ObjectInstance \"a\"", 0, "unknown object `a`"),
        (
            "ObjectBegin \"a\"\nObjectInstance \"a\"",
            1,
            "outside of ObjectBegin",
        ),
    ]);
}

#[test]
fn invalid_shapes_and_their_parameters_are_rejected_with_line() {
    assert_errors_after_head(&[
        ("Shape \"cube\"", 0, "unknown shape `cube`"),
        (
            "Shape sphere",
            0,
            "expected a string in quotes, found `sphere`",
        ),
        ("Shape \"sphere", 0, "expected a closing quote"),
        (
            "Shape \"sphere\"\n \"float radius\" \"1\"",
            1,
            "expected a number, found `\"1\"`",
        ),
        (
            "Shape \"sphere\"\n \"string radius\" \"1\"",
            1,
            "radius: expected a parameter of type float",
        ),
        (
            "Shape \"sphere\"\n \"float radius\" [ 1 2 ]",
            1,
            "expected one number, found 2",
        ),
        (
            "Shape \"sphere\"\n \"float radius\" -1",
            1,
            "expected a number above 0, found -1",
        ),
        (
            "Shape \"sphere\" \"flot radius\" 1",
            0,
            "did you mean `float`?",
        ),
        (
            "Shape \"sphere\" \"radius\" 1",
            0,
            "expected a parameter's type and name",
        ),
        (
            "Shape \"sphere\" \"float radius\"",
            0,
            "expected values of `float radius`",
        ),
        ("Shape \"sphere\" \"float radius\" [ 1", 0, "expected `]`"),
        ("Scale 0 1 1\nShape \"sphere\"", 1, "singular"),
        ("Shape \"trianglemesh\"", 0, "expected the points"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 ]",
            0,
            "expected a multiple of 3 numbers, found 4",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]\n\"integer indices\" [ 0 1 3 ]",
            1,
            "vertex 3, but there are 3 points",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]\n\"integer indices\" [ 0 1 1.5 ]",
            1,
            "expected an integer",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]\n\"integer indices\" [ 0 1 ]",
            1,
            "expected three vertices",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]\n\"normal N\" [ 0 0 1 ]",
            1,
            "one for each of the 3 points",
        ),
        (
            "Shape \"plymesh\"\n\"string filename\" \"missing.ply\"",
            1,
            "missing.ply",
        ),
    ]);
}

#[test]
fn invalid_materials_and_textures_are_rejected_with_line() {
    assert_errors_after_head(&[
        ("Material \"difuse\"", 0, "did you mean `diffuse`?"),
        (
            "Material \"diffuse\"\n\"rgb reflectance\" [ 2 0 0 ]",
            1,
            "at most 1",
        ),
        (
            "Material \"diffuse\"\n\"rgb reflectance\" [ 0 -1 0 ]",
            1,
            "of at least 0",
        ),
        (
            "Material \"diffuse\"\n\"texture reflectance\" \"none\"",
            1,
            "unknown texture `none`",
        ),
        (
            "Material \"conductor\"\n\"spectrum eta\" \"metal-Cu-eat\"",
            1,
            "did you mean `metal-Cu-eta`?",
        ),
        (
            "Material \"dielectric\" \"float eta\" 0",
            0,
            "expected a refractive index above 0",
        ),
        (
            "Material \"dielectric\" \"float roughness\" -1",
            0,
            "expected a roughness",
        ),
        ("Material \"mix\"", 0, "expected the names of two materials"),
        ("NamedMaterial \"a\"", 0, "unknown material `a`"),
        (
            "MakeNamedMaterial \"a\"",
            0,
            "expected a parameter `string type`",
        ),
        (
            "Texture \"a\" \"float\" \"imagmap\"",
            0,
            "did you mean `imagemap`?",
        ),
        (
            "Texture \"a\" \"colour\" \"constant\"",
            0,
            "unknown texture type",
        ),
        (
            "Texture \"a\" \"float\" \"imagemap\"",
            0,
            "expected a parameter `string filename`",
        ),
    ]);
}

#[test]
fn invalid_lights_options_and_includes_are_rejected_with_line() {
    assert_errors_after_head(&[
        ("LightSource \"sun\"", 0, "unknown light `sun`"),
        (
            "LightSource \"point\"\n\"blackbody I\" [ 0 ]",
            1,
            "expected one temperature above 0",
        ),
        (
            "LightSource \"point\"\n\"spectrum I\" [ 400 1 400 1 ]",
            1,
            "increasing wavelengths",
        ),
        (
            "LightSource \"spot\" \"point3 to\" [ 0 0 0 ]",
            0,
            "different points",
        ),
        ("AreaLightSource \"glow\"", 0, "unknown area light"),
        (
            "AreaLightSource \"diffuse\" \"float power\" 1e300\nShape \"disk\"",
            1,
            "finite radiance",
        ),
        ("ColorSpace \"cmyk\"", 0, "unknown colour space"),
        (
            "Attribute \"shapes\" \"float radius\" 1",
            0,
            "did you mean `shape`?",
        ),
        (
            "Option \"bool wavfront\" true",
            0,
            "did you mean `wavefront`?",
        ),
        ("Option \"integer seed\" -1", 0, "expected a whole number"),
        ("Include \"missing.pbrt\"", 0, "missing.pbrt"),
        ("Include \"\"", 0, "expected the name of a file"),
        ("Include \"a.pbrt\"", 0, "includes itself"),
        ("Import \"a.pbrt\"", 0, "includes itself"),
    ]);
}

#[test]
fn invalid_options_before_world_begin_are_rejected_with_line() {
    for (text, line, expected) in [
        ("Shape \"sphere\"", 1, "expected WorldBegin before Shape"),
        (
            "Camera \"orthographic\"\nWorldBegin",
            1,
            "`orthographic` are not supported",
        ),
        (
            "Camera \"perspectiv\"\nWorldBegin",
            1,
            "did you mean `perspective`?",
        ),
        (
            "Camera \"perspective\"\n\"float fov\" 180\nWorldBegin",
            2,
            "below 180",
        ),
        (
            "Scale 1 2 1\nCamera \"perspective\"\nWorldBegin",
            2,
            "stretches",
        ),
        (
            "Scale 0 0 0\nCamera \"perspective\"\nWorldBegin",
            2,
            "flattens",
        ),
        (
            "Camera \"perspective\" \"float shutterclose\" -1\nWorldBegin",
            1,
            "closes after it opens",
        ),
        (
            "Film \"rgb\"\n\"integer xresolution\" 0\nWorldBegin",
            2,
            "from 1 to 65536",
        ),
        (
            "Film \"rgb\"\n\"integer xresolution\" 2000000000\nWorldBegin",
            2,
            "from 1 to 65536",
        ),
        ("Film \"paper\"\nWorldBegin", 1, "unknown film"),
        ("PixelFilter \"fox\"\nWorldBegin", 1, "did you mean `box`?"),
        (
            "PixelFilter \"box\" \"float xradius\" 0\nWorldBegin",
            1,
            "above 0",
        ),
        ("Sampler \"sobl\"\nWorldBegin", 1, "did you mean `sobol`?"),
        (
            "Sampler \"sobol\" \"integer pixelsamples\" 0\nWorldBegin",
            1,
            "from 1",
        ),
        ("Integrator \"pth\"\nWorldBegin", 1, "did you mean `path`?"),
        (
            "Integrator \"path\" \"integer maxdepth\" -1\nWorldBegin",
            1,
            "from 0",
        ),
    ] {
        let (kind, found, message) = error_of(text);
        assert_eq!(
            (kind, found),
            (ErrorKind::Scene, Some(line)),
            "{text:?}: {message}"
        );
        assert!(message.contains(expected), "{text:?}: {message}");
    }
    assert!(error_of("").2.contains("expected WorldBegin"));
    assert!(
        error_of(&"AttributeBegin\n".repeat(2000))
            .2
            .contains("at most 1024 blocks")
    );
}

#[test]
fn errors_in_included_files_name_both_locations() {
    let folder = SceneFolder::new([
        ("a.pbrt", format!("{HEAD}Include \"b.pbrt\"\n")),
        ("b.pbrt", "\n\nShape \"box\"\n".to_owned()),
    ]);
    let message = load(&folder.path("a.pbrt"))
        .expect_err("no box")
        .to_string();
    assert!(
        message.contains("a.pbrt:5: ") && message.contains("b.pbrt:3: unknown shape"),
        "{message}"
    );
    // Files that include each other.
    let folder = SceneFolder::new([
        ("a.pbrt", format!("{HEAD}Include \"b.pbrt\"\n")),
        ("b.pbrt", "Include \"a.pbrt\"\n".to_owned()),
    ]);
    let error = load(&folder.path("a.pbrt")).expect_err("a circle");
    assert!(error.to_string().contains("includes itself"), "{error}");
}

#[test]
fn excessive_includes_are_rejected_with_a_bounded_message() {
    let twice = |name: &str| format!("Include \"{name}\"\n").repeat(8);
    let folder = SceneFolder::new([
        ("a.pbrt", format!("{HEAD}{}", twice("b.pbrt"))),
        ("b.pbrt", twice("c.pbrt")),
        ("c.pbrt", twice("d.pbrt")),
        ("d.pbrt", twice("e.pbrt")),
        ("e.pbrt", twice("f.pbrt")),
        ("f.pbrt", String::new()),
    ]);
    let error = load(&folder.path("a.pbrt")).expect_err("too many");
    assert!(
        error.to_string().contains("10000 in all"),
        "{}",
        error.to_string().len()
    );
    assert!(error.to_string().len() < 8 << 10);
}

#[test]
fn corrupt_gzip_include_is_rejected() {
    let folder = SceneFolder::new([
        (
            "a.pbrt",
            format!("{HEAD}Include \"b.pbrt.gz\"\n").into_bytes(),
        ),
        (
            "b.pbrt.gz",
            b"\x1f\x8b\x08\0\0\0\0\0\0\xff\x01\x02".to_vec(),
        ),
    ]);
    let error = load(&folder.path("a.pbrt")).expect_err("damaged");
    assert!(error.to_string().contains("compressed by gzip"), "{error}");
}

#[test]
fn truncated_pbrt_scene_loads_or_fails_with_a_located_error() {
    let folder = SceneFolder::new([("a.pbrt", EVERYTHING), ("part.pbrt", ""), ("m.ply", PLY)]);
    let path = folder.path("a.pbrt");
    load(&path).unwrap_or_else(|error| panic!("{error}"));
    for length in (0..EVERYTHING.len()).filter(|&length| EVERYTHING.is_char_boundary(length)) {
        std::fs::write(&path, &EVERYTHING[..length]).expect("written");
        if let Err(error) = load(&path) {
            assert!(
                error.line().is_some() || error.to_string().contains("WorldBegin"),
                "{error}"
            );
            assert!(
                matches!(error.kind(), ErrorKind::Scene | ErrorKind::Io),
                "{error}"
            );
        }
    }
}

/// Replaces, removes and repeats words of a scene at random, with a fixed seed.
#[test]
fn mutated_pbrt_scene_loads_or_fails_with_a_bounded_message() {
    let folder = SceneFolder::new([("a.pbrt", EVERYTHING), ("part.pbrt", ""), ("m.ply", PLY)]);
    let path = folder.path("a.pbrt");
    let words: Vec<&str> = EVERYTHING.split_inclusive([' ', '\n']).collect();
    let mut state: u64 = 1;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize % below
    };
    let strange = [
        "-1 ",
        "0 ",
        "1e300 ",
        "[ ",
        "] ",
        "\"a\" ",
        "true ",
        "\n",
        "4294967296 ",
    ];
    for _ in 0..2000 {
        let mut mutated = words.clone();
        for _ in 0..1 + random(3) {
            let at = random(mutated.len());
            match random(4) {
                0 => mutated[at] = words[random(words.len())],
                1 => mutated[at] = strange[random(strange.len())],
                2 => drop(mutated.remove(at)),
                _ => mutated.insert(at, words[random(words.len())]),
            }
        }
        std::fs::write(&path, mutated.concat()).expect("written");
        if let Err(error) = load(&path) {
            assert!(error.to_string().len() < 8 << 10);
        }
    }
}

/// A mesh for scenes that name one.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
