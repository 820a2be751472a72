//! The shapes of a Mitsuba scene, with their groups and instances.
//!
//! Measure: world units.
//! Range: an unknown type is an error; notes name what is approximated.
//! Source: Mitsuba 3 documentation, "Shapes". Tested in `tests/loading/mitsuba.rs`.

use super::super::contents::SceneContents;
use super::super::mesh_files::{FileMeshes, MeshFacts, MeshFiles};
use super::super::wording::unknown_name;
use super::super::{obj, ply};
use super::material::{MitsubaMaterial, material};
use super::mesh::{self, MeshOptions};
use super::object::XmlObject;
use super::round::Cylinders;
use super::{emitter, round, serialized};
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{
    GeometryDescription, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription,
    NoteKind, ShapeDescription,
};
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

/// The types that are read.
const KNOWN: &[&str] = &[
    "obj",
    "ply",
    "serialized",
    "rectangle",
    "cube",
    "sphere",
    "disk",
    "cylinder",
    "shapegroup",
    "instance",
    "merge",
];

/// Reads shapes, and remembers what several of them share.
#[derive(Default)]
pub struct Shapes {
    /// Materials by the addresses of their objects, which live as long as the scene is read.
    materials: HashMap<*const XmlObject, MitsubaMaterial>,
    groups: HashMap<*const XmlObject, usize>,
    grey: Option<MitsubaMaterial>,
    black: Option<MitsubaMaterial>,
    meshes: ShapeMeshes,
}

/// Meshes that several shapes have.
#[derive(Default)]
struct ShapeMeshes {
    cylinders: Cylinders,
    files: MeshFiles,
}

impl Shapes {
    /// Adds a shape to a group or to the world.
    ///
    /// # Errors
    /// If the shape, its bsdf or its emitter is invalid.
    pub fn add(
        &mut self,
        shape: &Rc<XmlObject>,
        group: Option<usize>,
        contents: &mut SceneContents,
    ) -> Result<()> {
        match shape.kind.as_str() {
            "shapegroup" => return self.group(shape, group, contents),
            "instance" => return self.instance(shape, group, contents),
            "merge" => {
                for child in shape.children("shape") {
                    self.add(child, group, contents)?;
                }
                shape.note_unused(&[], contents);
                return Ok(());
            }
            _ => {}
        }
        let lamp = shape.children("emitter").next();
        let mut surface = self.surface(shape, lamp.is_some(), contents)?;
        let mut emission = None;
        if let Some(lamp) = lamp {
            let (radiance, to_uv) = emitter::area(lamp, contents)?;
            emission = Some(radiance);
            if surface.to_uv.is_some() && to_uv.is_some() && surface.to_uv != to_uv {
                let text = "the texture of its radiance gets the `to_uv` of its bsdf";
                contents.note(shape.note(NoteKind::Approximation, text));
            }
            surface.to_uv = surface.to_uv.or(to_uv);
        }
        let first = contents.shapes.len();
        let to_world = shape.transform("to_world")?;
        let meshes = &mut self.meshes;
        for (geometry, transform) in geometries(shape, to_world, &surface, meshes, contents)? {
            contents.shapes.push(ShapeDescription {
                transform,
                group,
                material: surface.material,
                emission: emission.clone(),
                ..ShapeDescription::new(shape.name.clone(), shape.place.clone(), geometry)
            });
        }
        if surface.is_null && emission.is_none() {
            contents.shapes.truncate(first);
        }
        shape.note_unused(&["face_normals", "flip_tex_coords"], contents);
        Ok(())
    }

    fn surface(
        &mut self,
        shape: &XmlObject,
        emits: bool,
        contents: &mut SceneContents,
    ) -> Result<MitsubaMaterial> {
        if let Some(bsdf) = shape.children("bsdf").next() {
            let key = Rc::as_ptr(bsdf);
            let made = match self.materials.get(&key) {
                Some(known) => known.clone(),
                None => material(bsdf, contents)?,
            };
            self.materials.insert(key, made.clone());
            if !(made.is_null && emits) {
                return Ok(made);
            }
            let text = "an emitter on a bsdf of type `null` is opaque and black";
            contents.note(shape.note(NoteKind::Approximation, text));
        }
        // Without a bsdf, emitters reflect nothing and other shapes half of the light.
        let (known, grey) = match emits {
            true => (&mut self.black, 0.0),
            false => (&mut self.grey, 0.5),
        };
        let made = known.get_or_insert_with(|| {
            let model = MaterialModel::Diffuse {
                reflectance: Rgb::grey(grey).into(),
            };
            let material = MaterialDescription {
                two_sided: false,
                ..MaterialDescription::new("default", shape.place.clone(), model)
            };
            MitsubaMaterial {
                material: contents.add_material(material),
                to_uv: None,
                is_null: false,
            }
        });
        Ok(made.clone())
    }

    fn group(
        &mut self,
        shape: &Rc<XmlObject>,
        outer: Option<usize>,
        contents: &mut SceneContents,
    ) -> Result<()> {
        if outer.is_some() {
            return Err(shape.error("expected no group within a group"));
        }
        let key = Rc::as_ptr(shape);
        if self.groups.contains_key(&key) {
            return Ok(());
        }
        let line = shape.place.line.unwrap_or(0);
        let name = format!("{} of line {line}, {}", shape.name, contents.groups.len());
        let index = contents.add_to_group(&name);
        self.groups.insert(key, index);
        for child in shape.children("shape") {
            self.add(child, Some(index), contents)?;
        }
        shape.note_unused(&[], contents);
        Ok(())
    }

    fn instance(
        &mut self,
        shape: &Rc<XmlObject>,
        group: Option<usize>,
        contents: &mut SceneContents,
    ) -> Result<()> {
        if group.is_some() {
            return Err(shape.error("expected no instance within a group"));
        }
        let of = shape
            .children("shape")
            .find(|child| child.kind == "shapegroup");
        let of =
            of.ok_or_else(|| shape.error("expected a reference to a shape of type shapegroup"))?;
        self.group(of, None, contents)?;
        contents.instances.push(InstanceDescription {
            name: shape.name.clone(),
            place: shape.place.clone(),
            of: self.groups[&Rc::as_ptr(of)],
            group: None,
            transform: shape.transform("to_world")?,
            motion: Vec::new(),
        });
        shape.note_unused(&[], contents);
        Ok(())
    }
}

/// Returns the geometries of a shape with their transforms.
fn geometries(
    shape: &XmlObject,
    to_world: DAffine3,
    surface: &MitsubaMaterial,
    meshes: &mut ShapeMeshes,
    contents: &mut SceneContents,
) -> Result<Vec<(GeometryDescription, DAffine3)>> {
    let flip = shape.truth("flip_normals", false)?;
    let mut options = MeshOptions {
        flip,
        to_uv: surface.to_uv,
        to_world: to_world.matrix3,
        face_normals: shape.truth("face_normals", false)?,
        flip_v: false,
    };
    let as_mesh = |mesh: MeshDescription, options: &MeshOptions| {
        (
            GeometryDescription::Mesh(Arc::new(mesh::finished(mesh, options))),
            to_world,
        )
    };
    Ok(vec![match shape.kind.as_str() {
        "obj" | "ply" | "serialized" => {
            options.flip_v = shape.truth("flip_tex_coords", shape.kind == "obj")?;
            let parts = file_meshes(shape, options, &mut meshes.files, contents)?;
            let placed = |mesh| (GeometryDescription::Mesh(mesh), to_world);
            return Ok(parts.into_iter().map(placed).collect());
        }
        "cube" => as_mesh(mesh::cube(), &options),
        "rectangle" if surface.to_uv.is_none() && !flip => (
            GeometryDescription::Rectangle {
                corner: DVec3::new(-1.0, -1.0, 0.0),
                edge_u: DVec3::new(2.0, 0.0, 0.0),
                edge_v: DVec3::new(0.0, 2.0, 0.0),
            },
            to_world,
        ),
        "rectangle" => as_mesh(mesh::rectangle(), &options),
        "disk" => round::disk(shape, to_world, flip, surface, contents)?,
        "sphere" => round::sphere(shape, to_world, flip, surface, contents)?,
        "cylinder" => {
            let (geometry, placed) =
                round::cylinder(shape, &options, &mut meshes.cylinders, contents)?;
            (geometry, to_world * placed)
        }
        other => return Err(shape.error(&unknown_name("shape", other, KNOWN))),
    }])
}

/// Returns the meshes of a shape that a file describes.
fn file_meshes(
    shape: &XmlObject,
    options: MeshOptions,
    files: &mut MeshFiles,
    contents: &mut SceneContents,
) -> Result<Vec<Arc<MeshDescription>>> {
    let mut index = 0;
    if shape.kind == "serialized" {
        let is_index = |n: f64| n >= 0.0 && n.fract() == 0.0 && n < 1e9;
        let what = "a whole number of at least 0";
        index = shape.number_where("shape_index", 0.0, what, is_index)? as usize;
    }
    let path = shape.file()?;
    let read = |contents: &mut SceneContents| match shape.kind.as_str() {
        "obj" => Ok(FileMeshes {
            parts: obj::load_whole(&path, contents)?,
            is_faceted: false,
        }),
        "ply" => {
            let model = ply::read_mesh(&path)?;
            model.notes.into_iter().for_each(|note| contents.note(note));
            Ok(FileMeshes {
                parts: vec![model.mesh],
                is_faceted: false,
            })
        }
        _ => {
            let (mesh, is_faceted) = serialized::read(&path, index)?;
            Ok(FileMeshes {
                parts: vec![mesh],
                is_faceted,
            })
        }
    };
    let states_normals = shape.get("face_normals").is_some();
    let changes = |facts: MeshFacts| {
        let face_normals = match states_normals {
            true => options.face_normals,
            false => facts.is_faceted,
        };
        MeshOptions {
            face_normals,
            ..options
        }
        .reduced(facts.have_normals)
    };
    let named = |error: crate::Error| shape.error(&error.to_string()).of_kind(error.kind());
    files
        .meshes((&path, index), contents, read, changes, mesh::finish)
        .map_err(named)
}
