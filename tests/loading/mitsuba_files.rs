//! Scenes of Mitsuba 3 of several files and many lines: includes, folders, and references of any order.
//!
//! Measure: lines.
//! Range: scenes that are made here.
//! Source: docs/scene-formats.md.

use crate::common::scene_folder::{SceneFolder, TRIANGLE};
use crate::mitsuba::{complaint, mesh, scene, valid};
use etendue::Error;
use etendue::description::{GeometryDescription, MaterialModel, SceneDescription};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::scene::load::load;
use std::fs;

const NAMES_MESH: &str =
    r#"<shape type="obj"><string name="filename" value="meshes/a.obj"/></shape>"#;

/// Loads `a.xml` of a folder with these files in folders of their own.
fn load_files(files: &[(&str, &str)]) -> Result<SceneDescription, Error> {
    let folder = SceneFolder::new::<&str>([]);
    for (name, content) in files {
        let path = folder.path(name);
        let parent = path.parent().expect("a file has a folder");
        fs::create_dir_all(parent).expect("the folder is writable");
        fs::write(path, content).expect("the folder is writable");
    }
    load(&folder.path("a.xml"))
}

fn valid_files(files: &[(&str, &str)]) -> SceneDescription {
    load_files(files).unwrap_or_else(|error| panic!("{error}"))
}

fn reflectance(scene: &SceneDescription, shape: usize) -> Rgb {
    match &scene.materials[scene.shapes[shape].material].model {
        MaterialModel::Diffuse { reflectance } => reflectance.constant().expect("a constant"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn files_are_found_in_folders_of_included_file_then_of_includers() {
    let main = scene("<include filename=\"fragments/b.xml\"/>");
    let part = scene(NAMES_MESH).replace("<sensor", "<sensor id=\"of the part\"");
    let part = part.replace(
        "</scene>",
        "<include filename=\"fragments/c.xml\"/></scene>",
    );
    let inner = "<scene version=\"3.0.0\"><shape type=\"sphere\"/></scene>";
    let files = [
        ("a.xml", main.as_str()),
        ("fragments/b.xml", part.as_str()),
        ("fragments/c.xml", inner),
        ("meshes/a.obj", TRIANGLE),
    ];
    assert_eq!(valid_files(&files).shapes.len(), 2);
    // A file of the same name beside the part comes first.
    let near = TRIANGLE.replace("v 1 0 0", "v 7 0 0");
    let near = [&files[..], &[("fragments/meshes/a.obj", near.as_str())]].concat();
    assert_eq!(mesh(&valid_files(&near), 0).positions[1].x, 7.0);
    // Nowhere: the message names the folder of the file.
    let error = load_files(&files[..3])
        .expect_err("there is no mesh")
        .to_string();
    assert!(error.contains("fragments/b.xml:3"), "{error}");
    assert!(error.contains("fragments/meshes/a.obj"), "{error}");
}

#[test]
fn paths_add_folders_that_come_first() {
    let main = scene(&format!("<path value=\"library\"/>{NAMES_MESH}"));
    let far = TRIANGLE.replace("v 1 0 0", "v 7 0 0");
    let files = [
        ("a.xml", main.as_str()),
        ("library/meshes/a.obj", far.as_str()),
        ("meshes/a.obj", TRIANGLE),
    ];
    assert_eq!(mesh(&valid_files(&files), 0).positions[1].x, 7.0);
    let many = "<path value=\".\"/>".repeat(101);
    for (path, expected) in [
        (
            "<path value=\"none\"/>",
            "a.xml:3: expected a folder, found none",
        ),
        (
            "<shape type=\"cube\"><path value=\".\"/></shape>",
            "expected `path` directly within the outermost element",
        ),
        (many.as_str(), "at most 100 elements `path`"),
    ] {
        let words = complaint(path);
        assert!(words.contains(expected), "{words}");
    }
}

#[test]
fn included_file_may_hold_a_single_object() {
    let main = scene(
        "<include filename=\"red.xml\"/><shape type=\"cube\"><include filename=\"green.xml\"/></shape>\
        <shape type=\"sphere\"><ref id=\"red\"/></shape>\
        <shape type=\"sphere\"><bsdf type=\"diffuse\"><include filename=\"blue.xml\" name=\"reflectance\"/></bsdf></shape>",
    );
    let files = [
        ("a.xml", main.as_str()),
        (
            "red.xml",
            r#"<bsdf type="diffuse" id="red" version="3.0.0"><rgb name="reflectance" value="1 0 0"/></bsdf>"#,
        ),
        (
            "green.xml",
            r#"<bsdf type="diffuse" version="0.6.0"><rgb name="diffuseReflectance" value="0 1 0"/></bsdf>"#,
        ),
        (
            "blue.xml",
            r#"<texture type="srgb" version="3.0.0"><rgb name="color" value="0 0 1"/></texture>"#,
        ),
    ];
    let it = valid_files(&files);
    let colours = [0, 1, 2].map(|shape| reflectance(&it, shape).to_array());
    assert_eq!(colours, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(it.check_faithful().is_ok(), "{:?}", it.notes);
    let error = load_files(&[
        ("a.xml", &scene("<include filename=\"b.xml\"/>")),
        ("b.xml", "<float name=\"x\" value=\"1\"/>"),
    ]);
    let error = error.expect_err("a number is no object").to_string();
    assert!(
        error.contains("b.xml:1: expected an element `scene` or an object"),
        "{error}"
    );
}

#[test]
fn references_may_precede_their_objects() {
    let red = r#"<bsdf type="twosided" id="red"><ref id="base"/></bsdf>
        <bsdf type="diffuse" id="base"><rgb name="reflectance" value="$x 0 0"/></bsdf>"#;
    let it = valid(&format!(
        "<shape type=\"cube\"><ref id=\"red\"/></shape><shape type=\"sphere\"><ref id=\"red\"/></shape>\
        <default name=\"x\" value=\"0.5\"/>{red}"
    ));
    assert_eq!(reflectance(&it, 0), Rgb::new(0.5, 0.0, 0.0));
    assert_eq!(it.shapes[0].material, it.shapes[1].material);
    // In another file, too.
    let part = format!("<scene version=\"3.0.0\">{red}</scene>");
    let main = "<default name=\"x\" value=\"0.25\"/><shape type=\"cube\"><ref id=\"red\"/></shape>\
        <include filename=\"b.xml\"/>";
    let it = valid_files(&[("a.xml", &scene(main)), ("b.xml", &part)]);
    assert_eq!(reflectance(&it, 0), Rgb::new(0.25, 0.0, 0.0));
}

#[test]
fn cycles_and_long_chains_of_references_are_rejected() {
    let cycle = "<shape type=\"cube\"><ref id=\"a\"/></shape>\
        <bsdf id=\"a\" type=\"twosided\"><ref id=\"b\"/></bsdf><bsdf id=\"b\" type=\"twosided\"><ref id=\"a\"/></bsdf>";
    let words = complaint(cycle);
    assert!(
        words.contains("a.xml:3: expected an object that does not contain itself"),
        "{words}"
    );
    // One refers to the next one, or to the one before: neither may overflow the stack.
    let link = |of: usize, to: usize| {
        format!("<bsdf id=\"m{of}\" type=\"twosided\"><ref id=\"m{to}\"/></bsdf>\n")
    };
    let end = |of: usize| format!("<bsdf id=\"m{of}\" type=\"diffuse\"/>");
    let count = 50_000;
    let down: String = (0..count).map(|i| link(i, i + 1)).collect();
    let words = complaint(&(down + &end(count)));
    assert!(words.contains("nested at most 64 deep"), "{words}");
    let up: String = (1..count).map(|i| link(i, i - 1)).collect();
    let words = complaint(&(end(0) + &up));
    assert!(words.contains("nested at most 64 deep"), "{words}");
    let short: String = (1..63).map(|i| link(i, i - 1)).collect();
    valid(&(end(0) + &short + "<shape type=\"cube\"><ref id=\"m62\"/></shape>"));
    // Each contains the one before twice: two to the power of 40 in all.
    let pairs: String = (1..40)
        .map(|i| {
            let part = format!("<ref id=\"s{}\"/>", i - 1);
            format!("<shape id=\"s{i}\" type=\"merge\">{part}{part}</shape>")
        })
        .collect();
    let words = complaint(&format!("<shape id=\"s0\" type=\"sphere\"/>{pairs}"));
    assert!(words.contains("at most 1048576 objects"), "{words}");
}

/// If every `$name` were compared with every parameter, this would take minutes.
#[test]
fn many_parameters_are_replaced_quickly() {
    let count = 50_000;
    let name = |i: usize| format!("a_parameter_of_number_{i}_");
    let parameters = (0..count).map(|i| format!("<default name=\"{}\" value=\"{i}\"/>\n", name(i)));
    let spheres = (0..count).step_by(2).map(|i| {
        let name = name(i);
        format!("<shape type=\"sphere\"><float name=\"radius\" value=\"1${name}\"/></shape>\n")
    });
    let it = valid(&parameters.chain(spheres).collect::<String>());
    assert_eq!(it.shapes.len(), count / 2);
    let radius = it.shapes[7].transform.matrix3.x_axis.length();
    let GeometryDescription::Sphere { radius: own, .. } = it.shapes[7].geometry else {
        panic!("{:?}", it.shapes[7].geometry);
    };
    assert_eq!(radius * own, 114.0);
}

/// With a search from the beginning for the line of every element, this would take minutes.
#[test]
fn lines_of_large_files_are_found_quickly() {
    let count = 60_000;
    let many = "<bsdf type=\"diffuse\"/>\n".repeat(count);
    let it = valid(&format!(
        "{many}<shape type=\"sphere\"/>\n\n\n<shape\n type=\"cube\"/>"
    ));
    let lines: Vec<_> = it.shapes.iter().map(|shape| shape.place.line).collect();
    assert_eq!(lines, [Some(3 + count), Some(6 + count)]);
}
