//! Loads glTF 2.0 scenes, `.gltf` and `.glb`.
//!
//! Each primitive becomes a shape. The meshes of a node whose mesh no other node has are shapes of the world; other
//! meshes become groups with an instance for each of their nodes. What is not lit gets a sky, and what has no camera is
//! framed, as bare models are.
//!
//! Measure: meters; v of texture coordinates points up, where glTF's points down.
//! Range: triangles; points and lines, skins, morph targets and animations are left out with notes, and so is every
//! extension that is not read. An error names the place in the JSON. Memory is bounded by the size of the file and of those
//! that it refers to.
//! Source: glTF 2.0; the JSON through the crate gltf. docs/scene-formats.md lists what is read. Tested in
//! `tests/loading/gltf.rs`, `tests/loading/gltf_odd.rs` and `tests/loading/gltf_bad.rs`.

mod accessor;
mod animations;
mod buffers;
mod camera;
mod container;
mod light;
mod material;
mod material_textures;
mod mesh;
mod nodes;
mod primitives;
mod texture;
mod thin;

use super::bounds;
use super::contents::SceneContents;
use super::model::{framed, sky_unless};
use super::read_bytes;
use super::wording::{shown, unknown_name};
use crate::error::{Error, Result};
use crate::math::bounds::Bounds;
use crate::math::transform::is_invertible;
use crate::math::vec::DAffine3;
use crate::scene::description::{
    CameraDescription, ColourDescription, FilmDescription, InstanceDescription, LightDescription,
    Note, NoteKind, Place, SceneDescription, ShapeDescription,
};
use buffers::Asset;
use container::Container;
use nodes::{PlacedNode, nodes};
use primitives::Primitives;
use std::collections::HashMap;
use std::path::Path;

/// Loads a scene with its first camera, or with the one of this name.
///
/// # Errors
/// If the file, or one that it refers to, is invalid or not supported, or if there is no camera of this name.
pub fn load(path: &Path, camera: Option<&str>) -> Result<SceneDescription> {
    let bytes = read_bytes(path)?;
    let mut container = Container::parse(&bytes).map_err(|error| error.in_file(path))?;
    let mut contents = SceneContents::default();
    for extension in std::mem::take(&mut container.not_read) {
        let text = format!("the extension {} is not read", shown(&extension));
        contents.note(of_file(path, NoteKind::Omission, text));
    }
    if container.has_odd_animations {
        let text = "animations that could not be read were left out";
        contents.note(of_file(path, NoteKind::Omission, text));
    }
    let asset = Asset::read(path, container)?;
    let placed = nodes(&asset)?;
    note_left_out(&asset, &placed, &mut contents);
    meshes(&asset, &placed, &mut contents)?;
    if contents.shapes.is_empty() {
        return Err(Error::scene("expected a scene, found no triangles").in_file(path));
    }
    let mut lights = lights(&asset, &placed)?;
    let camera = camera_of(&asset, &placed, camera, &mut contents)?;
    let emissions = contents.shapes.iter().filter_map(|it| it.emission.as_ref());
    // Without a camera, glowing parts of a model, such as its screens, do not count as its lamps.
    let is_lamp = |it: &ColourDescription| camera.is_some() || it.brightest().max_channel() > 1.0;
    let is_lit = !lights.is_empty() || emissions.into_iter().any(is_lamp);
    lights.extend(sky_unless(is_lit, path, &mut contents));
    let (view, film) = match camera {
        Some(found) => found,
        None => {
            let bounds = bounds::of_all(&contents, bounds_of_box);
            (framed(path, &bounds, &mut contents)?, None)
        }
    };
    Ok(SceneDescription {
        film: film.unwrap_or_default(),
        materials: contents.materials,
        shapes: contents.shapes,
        groups: contents.groups,
        instances: contents.instances,
        lights,
        notes: contents.notes,
        ..SceneDescription::new(path, view)
    })
}

/// A note on a file: JSON is not read with its lines.
fn of_file(path: &Path, kind: NoteKind, text: impl Into<String>) -> Note {
    Note::at(Place::of_file(path), kind, text)
}

/// Notes what moves and is shown at rest.
fn note_left_out(asset: &Asset<'_>, placed: &[PlacedNode<'_>], contents: &mut SceneContents) {
    let mut note = |text| contents.note(of_file(asset.path, NoteKind::Omission, text));
    let animations = asset.document.animations().len();
    if animations > 0 {
        note(format!("{animations} animations were left out"));
    }
    let skinned = placed.iter().filter(|it| it.node.skin().is_some()).count();
    if skinned > 0 {
        note(format!(
            "the skins of {skinned} nodes were left out: their meshes are not deformed"
        ));
    }
    let is_morphed = |it: &&PlacedNode<'_>| {
        let weights = it.node.weights().or_else(|| it.node.mesh()?.weights());
        weights.is_some_and(|weights| weights.iter().any(|&weight| weight != 0.0))
    };
    let morphed = placed.iter().filter(is_morphed).count();
    if morphed > 0 {
        note(format!(
            "the morph targets of {morphed} nodes were left out"
        ));
    }
}

/// Adds the shapes of all nodes; of meshes with several nodes, groups and their instances.
fn meshes(
    asset: &Asset<'_>,
    placed: &[PlacedNode<'_>],
    contents: &mut SceneContents,
) -> Result<()> {
    let mut uses: HashMap<usize, usize> = HashMap::new();
    for mesh in placed.iter().filter_map(|it| it.node.mesh()) {
        *uses.entry(mesh.index()).or_default() += 1;
    }
    let mut groups: HashMap<usize, Option<usize>> = HashMap::new();
    let mut primitives = Primitives::new(asset);
    for it in placed {
        let Some(mesh) = it.node.mesh() else {
            continue;
        };
        if !it.to_world.is_finite() {
            let field = format!("nodes[{}]", it.node.index());
            return Err(asset.error(field, "expected transforms within double precision"));
        }
        if !is_invertible(&it.to_world.matrix3) {
            let text = format!("{} is flattened by its transform, and left out", it.name());
            contents.note(of_file(asset.path, NoteKind::Decision, text));
            continue;
        }
        if uses[&mesh.index()] == 1 {
            let first = contents.shapes.len();
            primitives.add(&mesh, contents)?;
            for shape in &mut contents.shapes[first..] {
                shape.transform = it.to_world;
            }
            continue;
        }
        let group = match groups.get(&mesh.index()) {
            Some(known) => *known,
            None => {
                let added = group(&mesh, &mut primitives, contents)?;
                groups.insert(mesh.index(), added);
                added
            }
        };
        let Some(of) = group else { continue };
        contents.instances.push(InstanceDescription {
            name: it.name(),
            place: Place::of_file(asset.path),
            of,
            group: None,
            transform: it.to_world,
            motion: vec![],
        });
    }
    Ok(())
}

/// Adds a group with the shapes of a mesh; `None` if it has none.
fn group(
    mesh: &gltf::Mesh<'_>,
    primitives: &mut Primitives<'_>,
    contents: &mut SceneContents,
) -> Result<Option<usize>> {
    let first = contents.shapes.len();
    primitives.add(mesh, contents)?;
    if contents.shapes.len() == first {
        return Ok(None);
    }
    let mut name = primitives::name(mesh);
    while contents.group_named(&name).is_some() {
        name = format!("{name} ({})", mesh.index());
    }
    let group = contents.add_to_group(&name);
    for shape in &mut contents.shapes[first..] {
        shape.group = Some(group);
    }
    Ok(Some(group))
}

fn lights(asset: &Asset<'_>, placed: &[PlacedNode<'_>]) -> Result<Vec<LightDescription>> {
    let root = asset.document.as_json();
    let all = root.extensions.as_ref();
    let all = all.and_then(|it| it.khr_lights_punctual.as_ref());
    let mut lights = vec![];
    for it in placed {
        let node = &root.nodes[it.node.index()];
        let extensions = node.extensions.as_ref();
        let Some(link) = extensions.and_then(|it| it.khr_lights_punctual.as_ref()) else {
            continue;
        };
        let index = link.light.value();
        let light = all.and_then(|all| all.lights.get(index)).ok_or_else(|| {
            let message = format!("expected the index of a light, found {index}");
            asset.error(format!("nodes[{}]", it.node.index()), message)
        })?;
        lights.push(light::light(asset, light, index, &it.to_world)?);
    }
    Ok(lights)
}

/// Returns the first camera, or the one of this name, which may be that of its node.
fn camera_of(
    asset: &Asset<'_>,
    placed: &[PlacedNode<'_>],
    name: Option<&str>,
    contents: &mut SceneContents,
) -> Result<Option<(CameraDescription, Option<FilmDescription>)>> {
    let cameras = placed
        .iter()
        .filter_map(|it| it.node.camera().map(|camera| (it, camera)));
    let all: Vec<_> = cameras.collect();
    let found = match name {
        None => all.first(),
        Some(name) => {
            let found = all
                .iter()
                .find(|(it, camera)| it.node.name() == Some(name) || camera.name() == Some(name));
            if found.is_none() {
                let names = all
                    .iter()
                    .flat_map(|(it, camera)| [it.node.name(), camera.name()]);
                let mut names: Vec<&str> = names.flatten().collect();
                names.dedup();
                let message = unknown_name("camera", name, &names);
                return Err(Error::usage(message).in_file(asset.path));
            }
            found
        }
    };
    let Some((it, camera)) = found else {
        return Ok(None);
    };
    let mut notes = vec![];
    let camera = camera::camera(asset, camera, &it.to_world, &mut notes)?;
    notes.into_iter().for_each(|note| contents.note(note));
    Ok(Some(camera))
}

/// The bounds of a shape: of the box around its mesh, as the mesh is placed.
fn bounds_of_box(shape: &ShapeDescription) -> Bounds {
    let of_mesh = bounds::of_geometry(&shape.geometry, &DAffine3::IDENTITY);
    of_mesh.transformed(&shape.transform)
}
