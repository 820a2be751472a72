//! The geometry of shapes of a pbrt file.
//!
//! Measure: the shape's own units.
//! Range: every class of shape of pbrt-v4. What is cut into triangles or left out is noted.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::files::unpacked;
use super::library::Library;
use super::mesh::{Finish, cut_patches, finish};
use super::params::Parameters;
use crate::error::Result;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::{GeometryDescription, MeshDescription};
use crate::scene::load::contents::SceneContents;
use crate::scene::load::mesh_files::FileMeshes;
use crate::scene::load::ply;
use crate::scene::load::revolution::{self, Round};
use crate::scene::load::wording::unknown_name;
use std::collections::HashMap;
use std::sync::Arc;

const CLASSES: &[&str] = &[
    "bilinearmesh",
    "curve",
    "cylinder",
    "disk",
    "loopsubdiv",
    "plymesh",
    "sphere",
    "trianglemesh",
];

/// A geometry, and what is applied before the shape's transform.
pub type Outline = (GeometryDescription, DAffine3);

/// Meshes of round shapes, so that equal ones share one.
pub type RoundMeshes = HashMap<String, Arc<MeshDescription>>;

/// Properties that a shape's geometry depends on besides its parameters.
#[derive(Debug, Clone, Copy)]
pub struct ShapeAppearance {
    pub finish: Finish,
    /// Whether the two sides of the shape differ: it emits to one side, or refracts.
    pub has_sides: bool,
}

impl Library {
    /// Reads the geometry of a shape; `None` if it was left out.
    ///
    /// # Errors
    /// If a parameter is not as the class requires.
    pub fn make_shape(
        &mut self,
        class: &str,
        params: &Parameters,
        appearance: ShapeAppearance,
        meshes: &mut RoundMeshes,
    ) -> Result<Option<Outline>> {
        match class {
            "sphere" => self.sphere(params, appearance, meshes).map(Some),
            "disk" => self.disk(params, appearance, meshes).map(Some),
            "cylinder" => self.cylinder(params, appearance, meshes).map(Some),
            "trianglemesh" => {
                let mesh = triangle_mesh(params)?;
                Ok(Some(finished(mesh, appearance.finish)))
            }
            "plymesh" => self.ply_mesh(params, appearance).map(Some),
            "bilinearmesh" => self.bilinear_mesh(params, appearance).map(Some),
            "loopsubdiv" => {
                params.has("levels");
                params.has("scheme");
                self.approximated(
                    &params.place,
                    "a subdivision surface became its control mesh",
                );
                let mesh = triangle_mesh(params)?;
                Ok(Some(finished(mesh, appearance.finish)))
            }
            "curve" => {
                self.omitted(&params.place, "a curve was left out");
                Ok(None)
            }
            _ => Err(params.error(unknown_name("shape", class, CLASSES))),
        }
    }

    fn sphere(
        &mut self,
        params: &Parameters,
        appearance: ShapeAppearance,
        meshes: &mut RoundMeshes,
    ) -> Result<Outline> {
        let radius = length(params, "radius", 1.0)?;
        let from = params.number("zmin", -radius)?.clamp(-radius, radius);
        let to = params.number("zmax", radius)?.clamp(-radius, radius);
        let angle = angle(params)?;
        if from >= to {
            return Err(params.error_of(
                "zmin",
                format!("expected zmin below zmax, found {from} and {to}"),
            ));
        }
        let is_whole = from <= -radius && to >= radius && angle >= 360.0;
        let keeps_mapping = appearance
            .finish
            .textured
            .is_none_or(|mapping| mapping == Default::default());
        let is_turned = appearance.finish.reverse && appearance.has_sides;
        if is_whole && keeps_mapping && !is_turned {
            // Texture coordinates go around our y axis, and around pbrt's z axis.
            let axes = match appearance.finish.textured {
                Some(_) => DAffine3::from_cols(DVec3::X, DVec3::Z, DVec3::Y, DVec3::ZERO),
                None => DAffine3::IDENTITY,
            };
            let center = DVec3::ZERO;
            return Ok((GeometryDescription::Sphere { center, radius }, axes));
        }
        let what = "a sphere that is a part, turned inside out or with its texture moved was cut into triangles";
        self.approximated(&params.place, what);
        let part = Round::Sphere {
            from: from / radius,
            to: to / radius,
        };
        Ok((
            cut(part, angle, appearance.finish, meshes),
            DAffine3::from_scale(DVec3::splat(radius)),
        ))
    }

    fn disk(
        &mut self,
        params: &Parameters,
        appearance: ShapeAppearance,
        meshes: &mut RoundMeshes,
    ) -> Result<Outline> {
        let radius = length(params, "radius", 1.0)?;
        let height = params.number("height", 0.0)?;
        let inner = params.number_where(
            "innerradius",
            0.0,
            "a number from 0 to below the radius",
            |x| (0.0..radius).contains(&x),
        )?;
        let angle = angle(params)?;
        let center = height * DVec3::Z;
        if inner == 0.0 && angle >= 360.0 && appearance.finish.textured.is_none() {
            let normal = if appearance.finish.reverse {
                -DVec3::Z
            } else {
                DVec3::Z
            };
            let disk = GeometryDescription::Disk {
                center,
                normal,
                radius,
            };
            return Ok((disk, DAffine3::IDENTITY));
        }
        self.approximated(
            &params.place,
            "a disk that is a part or textured was cut into triangles",
        );
        let part = Round::Disk {
            inner: inner / radius,
        };
        let placed =
            DAffine3::from_translation(center) * DAffine3::from_scale(DVec3::splat(radius));
        Ok((cut(part, angle, appearance.finish, meshes), placed))
    }

    fn cylinder(
        &mut self,
        params: &Parameters,
        appearance: ShapeAppearance,
        meshes: &mut RoundMeshes,
    ) -> Result<Outline> {
        let radius = length(params, "radius", 1.0)?;
        let (from, to) = (params.number("zmin", -1.0)?, params.number("zmax", 1.0)?);
        if from >= to {
            return Err(params.error_of(
                "zmin",
                format!("expected zmin below zmax, found {from} and {to}"),
            ));
        }
        self.approximated(&params.place, "a cylinder was cut into triangles");
        let size = DVec3::new(radius, radius, to - from);
        let placed = DAffine3::from_translation(from * DVec3::Z) * DAffine3::from_scale(size);
        Ok((
            cut(Round::Cylinder, angle(params)?, appearance.finish, meshes),
            placed,
        ))
    }

    fn bilinear_mesh(
        &mut self,
        params: &Parameters,
        appearance: ShapeAppearance,
    ) -> Result<Outline> {
        let corners = vertices(params)?;
        let count = corners.positions.len();
        let mut indices = params.indices("indices", count)?;
        if indices.is_empty() && !params.has("indices") && count == 4 {
            indices = vec![0, 1, 2, 3];
        }
        let (patches, rest) = indices.as_chunks();
        if patches.is_empty() || !rest.is_empty() {
            return Err(params.error_of("indices", "expected four vertices for each patch"));
        }
        let (mesh, is_approximate) = cut_patches(corners, patches);
        if is_approximate {
            self.approximated(
                &params.place,
                "bilinear patches that are not flat were cut into triangles",
            );
        }
        Ok(finished(mesh, appearance.finish))
    }

    fn ply_mesh(&mut self, params: &Parameters, appearance: ShapeAppearance) -> Result<Outline> {
        let Some(file) = params.text("filename")? else {
            return Err(params.error("expected a parameter `string filename`"));
        };
        if params.has("displacement") {
            self.omitted(
                &params.place_of("displacement"),
                "displacement was left out",
            );
            params.has("edgelength");
        }
        let path = self.path(file);
        let read = |contents: &mut SceneContents| {
            let model = match path.extension().is_some_and(|extension| extension == "gz") {
                true => ply::decode(&unpacked(&path)?, &path)?,
                false => ply::read_mesh(&path)?,
            };
            model.notes.into_iter().for_each(|note| contents.note(note));
            Ok(FileMeshes {
                parts: vec![model.mesh],
                is_faceted: false,
            })
        };
        let files = &mut self.mesh_files;
        let changes = |_| appearance.finish;
        let contents = &mut self.contents;
        let meshes = files.meshes((&path, 0), contents, read, changes, finish);
        let meshes = meshes.map_err(|error| self.about(params, "filename", &error))?;
        let mesh = meshes.into_iter().next();
        let mesh = mesh.ok_or_else(|| params.error("expected a mesh"))?;
        Ok((GeometryDescription::Mesh(mesh), DAffine3::IDENTITY))
    }
}

fn finished(mut mesh: MeshDescription, changes: Finish) -> Outline {
    finish(&mut mesh, &changes);
    (
        GeometryDescription::Mesh(Arc::new(mesh)),
        DAffine3::IDENTITY,
    )
}

/// A part of a round shape as a mesh, which shapes with equal parameters share.
fn cut(
    part: Round,
    degrees: f64,
    changes: Finish,
    meshes: &mut RoundMeshes,
) -> GeometryDescription {
    let key = format!("{part:?} {degrees} {changes:?}");
    let mesh = meshes.entry(key).or_insert_with(|| {
        let mut mesh = revolution::round(part, degrees.to_radians());
        finish(&mut mesh, &changes);
        Arc::new(mesh)
    });
    GeometryDescription::Mesh(Arc::clone(mesh))
}

fn length(params: &Parameters, name: &str, default: f64) -> Result<f64> {
    params.number_where(name, default, "a number above 0", |x| x > 0.0)
}

fn angle(params: &Parameters) -> Result<f64> {
    params.number_where("phimax", 360.0, "an angle above 0", |x| x > 0.0)
}

/// The points of a mesh with what belongs to each.
fn vertices(params: &Parameters) -> Result<MeshDescription> {
    let positions = params.points("P")?;
    if positions.is_empty() {
        return Err(params.error_of("P", "expected the points of a mesh"));
    }
    let normals = params.points("N")?;
    let uvs = params.points2("uv")?;
    // Tangents and numbers of faces have no use here.
    for unused in ["S", "faceIndices"] {
        params.has(unused);
    }
    for (name, count) in [("N", normals.len()), ("uv", uvs.len())] {
        if count != 0 && count != positions.len() {
            let message = format!(
                "expected one for each of the {} points, found {count}",
                positions.len()
            );
            return Err(params.error_of(name, message));
        }
    }
    if uvs.iter().any(|uv| !uv.as_vec2().is_finite()) {
        return Err(params.error_of("uv", "expected numbers within single precision"));
    }
    Ok(MeshDescription {
        positions,
        normals,
        uvs,
        indices: vec![],
    })
}

fn triangle_mesh(params: &Parameters) -> Result<MeshDescription> {
    let mut mesh = vertices(params)?;
    let count = mesh.positions.len();
    let indices = params.indices("indices", count)?;
    let (triangles, rest) = indices.as_chunks();
    mesh.indices = match (triangles, rest) {
        // pbrt takes three points without indices as a triangle.
        ([], []) if !params.has("indices") && count == 3 => vec![[0, 1, 2]],
        ([], _) | (_, [_, ..]) => {
            return Err(params.error_of("indices", "expected three vertices for each triangle"));
        }
        (triangles, []) => triangles.to_vec(),
    };
    Ok(mesh)
}
