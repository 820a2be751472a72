//! The shapes of a Mitsuba scene, with their groups and instances.
//!
//! Measure: world units.
//! Range: an unknown type is an error; notes name what is approximated.
//! Source: Mitsuba 3 documentation, "Shapes". Tested in `tests/loading/mitsuba.rs`.

use super::super::beside;
use super::super::contents::Contents;
use super::super::wording::unknown_name;
use super::super::{obj, ply};
use super::material::{Surface, material};
use super::mesh::{self, MeshOptions};
use super::object::Object;
use super::{emitter, serialized};
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DMat3, DVec3};
use crate::scene::description::{
    GeometryDescription, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription,
    NoteKind, ShapeDescription,
};
use std::collections::HashMap;
use std::path::PathBuf;
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
    "shapegroup",
    "instance",
    "merge",
];

/// Reads shapes, and remembers what several of them share.
#[derive(Default)]
pub struct Shapes {
    /// Materials by the addresses of their objects, which live as long as the scene is read.
    materials: HashMap<*const Object, Surface>,
    groups: HashMap<*const Object, usize>,
    grey: Option<Surface>,
    black: Option<Surface>,
}

impl Shapes {
    /// Adds a shape to a group or to the world.
    ///
    /// # Errors
    /// If the shape, its bsdf or its emitter is invalid.
    pub fn add(
        &mut self,
        shape: &Rc<Object>,
        group: Option<usize>,
        contents: &mut Contents,
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
        for (geometry, transform) in geometries(shape, to_world, &surface, contents)? {
            contents.shapes.push(ShapeDescription {
                transform,
                group,
                material: surface.material,
                emission: emission.clone(),
                ..ShapeDescription::new(shape.id.clone(), shape.place.clone(), geometry)
            });
        }
        if surface.is_null && emission.is_none() {
            contents.shapes.truncate(first);
        }
        shape.note_unused(&["face_normals", "flip_tex_coords"], contents);
        Ok(())
    }

    fn surface(&mut self, shape: &Object, emits: bool, contents: &mut Contents) -> Result<Surface> {
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
            Surface {
                material: contents.add_material(material),
                to_uv: None,
                is_null: false,
            }
        });
        Ok(made.clone())
    }

    fn group(
        &mut self,
        shape: &Rc<Object>,
        outer: Option<usize>,
        contents: &mut Contents,
    ) -> Result<()> {
        if outer.is_some() {
            return Err(shape.error("expected no group within a group"));
        }
        let key = Rc::as_ptr(shape);
        if self.groups.contains_key(&key) {
            return Ok(());
        }
        let line = shape.place.line.unwrap_or(0);
        let name = format!("{} of line {line}, {}", shape.id, contents.groups.len());
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
        shape: &Rc<Object>,
        group: Option<usize>,
        contents: &mut Contents,
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
            name: shape.id.clone(),
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
    shape: &Object,
    to_world: DAffine3,
    surface: &Surface,
    contents: &mut Contents,
) -> Result<Vec<(GeometryDescription, DAffine3)>> {
    let flip = shape.truth("flip_normals", false)?;
    let mut options = MeshOptions {
        flip,
        to_uv: surface.to_uv,
        mirrored: to_world.matrix3.determinant() < 0.0,
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
        "obj" => {
            options.flip_v = shape.truth("flip_tex_coords", true)?;
            let path = file(shape)?;
            let named = |error: crate::Error| shape.error(&error.to_string()).of_kind(error.kind());
            let models = obj::load(&path, Some(surface.material), contents).map_err(named)?;
            let meshes = models.into_iter().filter_map(|model| match model.geometry {
                GeometryDescription::Mesh(mesh) => {
                    Some(as_mesh(Arc::unwrap_or_clone(mesh), &options))
                }
                _ => None,
            });
            return Ok(meshes.collect());
        }
        "ply" => {
            options.flip_v = shape.truth("flip_tex_coords", false)?;
            let named = |error: crate::Error| shape.error(&error.to_string()).of_kind(error.kind());
            let model = ply::read_mesh(&file(shape)?).map_err(named)?;
            for note in model.notes {
                contents.note(note);
            }
            as_mesh(model.mesh, &options)
        }
        "serialized" => {
            let is_index = |n: f64| n >= 0.0 && n.fract() == 0.0 && n < 1e9;
            let index =
                shape.number_where("shape_index", 0.0, "a whole number of at least 0", is_index)?;
            let named = |error: crate::Error| shape.error(&error.to_string()).of_kind(error.kind());
            as_mesh(
                serialized::read(&file(shape)?, index as usize).map_err(named)?,
                &options,
            )
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
        "disk" => disk(shape, to_world, flip, surface, contents)?,
        "sphere" => sphere(shape, to_world, flip, surface, contents)?,
        other => return Err(shape.error(&unknown_name("shape", other, KNOWN))),
    }])
}

fn file(shape: &Object) -> Result<PathBuf> {
    let name = shape.text("filename")?;
    let name = name.ok_or_else(|| shape.error("expected a `filename`"))?;
    Ok(beside(&shape.place.file, name))
}

/// Notes that the texture coordinates of a round shape differ.
fn note_uvs(shape: &Object, contents: &mut Contents) {
    let text = "textures lie differently on it";
    contents.note(shape.note(NoteKind::Approximation, text));
}

fn disk(
    shape: &Object,
    to_world: DAffine3,
    flip: bool,
    surface: &Surface,
    contents: &mut Contents,
) -> Result<(GeometryDescription, DAffine3)> {
    if surface.to_uv.is_some() {
        note_uvs(shape, contents);
    }
    let axes = to_world.matrix3;
    let (x, y) = (axes.x_axis, axes.y_axis);
    let radius = x.length();
    let is_round =
        (y.length() - radius).abs() < 1e-5 * radius && x.dot(y).abs() < 1e-5 * radius * radius;
    let upright = if (axes.determinant() < 0.0) == flip {
        x.cross(y)
    } else {
        -x.cross(y)
    };
    if !is_round || radius == 0.0 || upright == DVec3::ZERO {
        return Err(shape.error_at("to_world", "expected a transform that keeps the disk round"));
    }
    let geometry = GeometryDescription::Disk {
        center: to_world.translation,
        normal: upright,
        radius,
    };
    Ok((geometry, DAffine3::IDENTITY))
}

fn sphere(
    shape: &Object,
    to_world: DAffine3,
    flip: bool,
    surface: &Surface,
    contents: &mut Contents,
) -> Result<(GeometryDescription, DAffine3)> {
    let center = shape.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = shape.number_where("radius", 1.0, "a number above 0", |x| x > 0.0)?;
    let axes = to_world.matrix3;
    let lengths = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
    let scale = lengths[0];
    let turned = DMat3::from_cols(
        axes.x_axis / scale,
        axes.y_axis / scale,
        axes.z_axis / scale,
    );
    let error = turned * turned.transpose() - DMat3::IDENTITY;
    if !error.to_cols_array().into_iter().all(|x| x.abs() < 1e-4) {
        return Err(shape.error_at(
            "to_world",
            "expected a transform that scales the sphere uniformly",
        ));
    }
    if flip {
        let text = "`flip_normals` of a sphere is not supported: it has its outside outside";
        contents.note(shape.note(NoteKind::Approximation, text));
    }
    if surface
        .to_uv
        .is_some_and(|to_uv| to_uv != Default::default())
    {
        note_uvs(shape, contents);
    }
    // Mitsuba's sphere has its poles along z, ours along y.
    let poles = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
    let geometry = GeometryDescription::Sphere {
        center: DVec3::ZERO,
        radius: radius * scale,
    };
    let transform = DAffine3 {
        matrix3: turned * poles,
        translation: to_world.transform_point3(center),
    };
    Ok((geometry, transform))
}
