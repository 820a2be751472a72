//! Scene files of pbrt-v4: every statement, the handedness of their world, and files that are broken.

mod agreement;
mod bad_files;
mod materials;
mod statements;
mod worlds;

use crate::common::scene_folder::SceneFolder;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::scene::description::{
    ColourDescription, LightModel, MaterialModel, NoteKind, SceneDescription,
};

/// A camera of a right-handed world at (0, 0, 5), so that nothing is mirrored.
const HEAD: &str = "Scale -1 1 1\nLookAt 0 0 5  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\n";

/// Loads a world after [`HEAD`], beside these files.
fn world_with<const N: usize>(text: &str, files: [(&'static str, Vec<u8>); N]) -> SceneDescription {
    let text = format!("{HEAD}{text}").into_bytes();
    SceneFolder::new(files.into_iter().chain([("a.pbrt", text)])).load("a.pbrt")
}

fn world(text: &str) -> SceneDescription {
    world_with(text, [])
}

/// Loads a whole file.
fn file(text: &str) -> SceneDescription {
    SceneFolder::new([("a.pbrt", text)]).load("a.pbrt")
}

/// The model of the material of the last shape.
fn model(scene: &SceneDescription) -> &MaterialModel {
    let shape = scene.shapes.last().expect("a shape");
    &scene.materials[shape.material].model
}

fn constant(colour: &ColourDescription) -> Rgb {
    colour.constant().expect("one colour")
}

/// The emission of the last shape.
fn emission(scene: &SceneDescription) -> Rgb {
    let shape = scene.shapes.last().expect("a shape");
    constant(shape.emission.as_ref().expect("it emits"))
}

fn only_light(scene: &SceneDescription) -> &LightModel {
    let [light] = scene.lights.as_slice() else {
        panic!("{} lights", scene.lights.len());
    };
    &light.model
}

/// The kinds of the notes, each with its line.
fn notes(scene: &SceneDescription) -> Vec<(NoteKind, usize)> {
    let notes = scene.notes.iter();
    notes
        .map(|note| (note.kind, note.place.line.expect("a line")))
        .collect()
}

#[track_caller]
fn near(found: Rgb, expected: [f32; 3]) {
    let pairs = found.to_array().into_iter().zip(expected);
    let is_near = |(a, b): (f32, f32)| (a - b).abs() <= 1e-5 * b.abs().max(1.0);
    assert!(
        pairs.into_iter().all(is_near),
        "{found:?}, expected {expected:?}"
    );
}
