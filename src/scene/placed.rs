//! A shape transformed to the world or its group in double precision, and its conversion to normalised geometry.
//!
//! Measure: units of the world or of a group in, normalised units out.
//! Range: shapes that `load` accepts; a transform that scales a sphere or disk non-uniformly is an error. Triangles
//! without area are dropped and counted.
//! Source: docs/architecture.md. Tested in `scene/prepare.rs`.

use super::description::{GeometryDescription, MeshDescription, ShapeDescription};
use super::normalisation::Normalisation;
use crate::error::Result;
use crate::geometry::mesh::{MIN_PER_THREAD, Mesh, MeshVertex};
use crate::geometry::{Geometry, disk::Disk, sphere::Sphere};
use crate::math::bounds::Bounds;
use crate::math::frame::Frame;
use crate::math::vec::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// A transformed shape.
pub enum TransformedShape {
    /// A mesh.
    Mesh(PlacedMesh),
    /// A rectangle with right angles: its mesh; its corner and edges.
    Rectangle(PlacedMesh, [DVec3; 3]),
    /// A sphere.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
        /// Rotation from its own axes to those of the world, or of its group.
        turn: DMat3,
    },
    /// A disk.
    Disk {
        /// Centre.
        center: DVec3,
        /// Normal, of any length.
        normal: DVec3,
        /// Radius.
        radius: f64,
        /// The directions in which its texture coordinates grow, of any length.
        axes: [DVec3; 2],
    },
}

/// A mesh and its transform.
pub struct PlacedMesh {
    mesh: Arc<MeshDescription>,
    transform: DAffine3,
}

impl PlacedMesh {
    fn position(&self, index: u32) -> DVec3 {
        self.transform
            .transform_point3(self.mesh.positions[index as usize])
    }

    /// Returns the mesh in normalised units, without the triangles that have no area there, and the number of those.
    fn normalised(&self, normalisation: &Normalisation) -> (Mesh, usize) {
        let description = &self.mesh;
        let has_normals = has_shading_normals(description);
        let has_uvs = !description.uvs.is_empty();
        let normal_matrix = normal_matrix(&self.transform);
        let vertex = |i: usize| {
            let position = normalisation.point(self.position(i as u32));
            let normal = match has_normals {
                true => (normal_matrix * description.normals[i]).normalize_or_zero(),
                false => DVec3::ZERO,
            };
            let uv = match has_uvs {
                true => description.uvs[i].as_vec2(),
                false => Vec2::ZERO,
            };
            MeshVertex::new(position, normal.as_vec3a(), uv)
        };
        let numbers = (0..description.positions.len()).into_par_iter();
        let vertices = numbers.with_min_len(MIN_PER_THREAD).map(vertex);
        let vertices: Vec<MeshVertex> = vertices.collect();
        let has_area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| vertices[i as usize].position());
            (b - a).cross(c - a).length_squared() >= f32::MIN_POSITIVE
        };
        let triangles = || description.indices.par_iter().with_min_len(MIN_PER_THREAD);
        let mut indices: Vec<[u32; 3]> = if triangles().all(has_area) {
            // Copied by all threads.
            triangles().copied().collect()
        } else {
            triangles().copied().filter(has_area).collect()
        };
        if self.transform.matrix3.determinant() < 0.0 {
            // A mirroring transform reverses the winding: the outside stays outside.
            indices
                .iter_mut()
                .for_each(|[_, b, c]| std::mem::swap(b, c));
        }
        let dropped = description.indices.len() - indices.len();
        let mesh = Mesh::from_vertices(vertices, [has_normals, has_uvs], indices);
        (mesh, dropped)
    }
}

impl TransformedShape {
    /// Applies a shape's own transform to it, and then another.
    ///
    /// # Errors
    /// If the transform scales a sphere or disk non-uniformly.
    pub fn new(shape: &ShapeDescription, then: &DAffine3) -> Result<Self> {
        let transform = *then * shape.transform;
        let mesh = |mesh| PlacedMesh { mesh, transform };
        Ok(match &shape.geometry {
            GeometryDescription::Mesh(description) => Self::Mesh(mesh(Arc::clone(description))),
            GeometryDescription::Box { min, max } => {
                Self::Mesh(mesh(Arc::new(box_mesh(*min, *max))))
            }
            GeometryDescription::Rectangle {
                corner,
                edge_u,
                edge_v,
            } => {
                let description = rectangle_mesh(*corner, *edge_u, *edge_v);
                let [u, v] = [*edge_u, *edge_v].map(|edge| transform.transform_vector3(edge));
                let placed = mesh(Arc::new(description));
                if u.normalize().dot(v.normalize()).abs() < 1e-9 {
                    // As of a mesh, the outside stays outside where the transform mirrors.
                    let is_mirrored = transform.matrix3.determinant() < 0.0;
                    let (u, v) = if is_mirrored { (v, u) } else { (u, v) };
                    Self::Rectangle(placed, [transform.transform_point3(*corner), u, v])
                } else {
                    Self::Mesh(placed)
                }
            }
            GeometryDescription::Sphere { center, radius } => {
                let scale = scale_of(&transform, shape)?;
                Self::Sphere {
                    center: transform.transform_point3(*center),
                    radius: radius * scale,
                    turn: transform.matrix3 * (1.0 / scale),
                }
            }
            GeometryDescription::Disk {
                center,
                normal,
                radius,
            } => {
                let scale = scale_of(&transform, shape)?;
                let normal = normal.normalize();
                Self::Disk {
                    center: transform.transform_point3(*center),
                    normal: normal_matrix(&transform) * normal,
                    radius: radius * scale,
                    axes: disk_axes(normal).map(|axis| transform.matrix3 * axis),
                }
            }
        })
    }

    /// The number of primitives.
    pub fn primitive_count(&self) -> usize {
        match self {
            Self::Mesh(placed) | Self::Rectangle(placed, _) => placed.mesh.indices.len(),
            Self::Sphere { .. } | Self::Disk { .. } => 1,
        }
    }

    /// Returns the box of a primitive; that of a degenerate triangle is empty, as it does not indicate where the detail is.
    #[inline]
    pub fn primitive_bounds(&self, primitive: usize) -> Bounds {
        match self {
            Self::Mesh(placed) | Self::Rectangle(placed, _) => {
                let [a, b, c] = placed.mesh.indices[primitive].map(|i| placed.position(i));
                let is_degenerate = (b - a).cross(c - a) == DVec3::ZERO;
                match is_degenerate {
                    true => Bounds::default(),
                    false => Bounds::around([a, b, c]),
                }
            }
            Self::Sphere { center, radius, .. } | Self::Disk { center, radius, .. } => {
                let radius = DVec3::splat(*radius);
                Bounds {
                    min: *center - radius,
                    max: *center + radius,
                }
            }
        }
    }

    /// Returns the box of all primitives.
    pub fn bounds(&self) -> Bounds {
        let primitives = (0..self.primitive_count()).into_par_iter();
        let boxes = primitives.with_min_len(MIN_PER_THREAD);
        let boxes = boxes.map(|primitive| self.primitive_bounds(primitive));
        boxes.reduce(Bounds::default, Bounds::union)
    }

    /// Converts the shape to normalised units.
    pub fn build_geometry(&self, normalisation: &Normalisation) -> NormalisedShape {
        let (mut dropped, mut rectangle) = (0, None);
        let geometry = match self {
            Self::Mesh(placed) | Self::Rectangle(placed, _) => {
                let (mesh, without_area) = placed.normalised(normalisation);
                dropped = without_area;
                Geometry::Mesh(mesh)
            }
            Self::Sphere {
                center,
                radius,
                turn,
            } => Geometry::Sphere(Sphere {
                center: normalisation.point(*center),
                radius: normalisation.length(*radius),
                turn: turn.as_mat3(),
            }),
            Self::Disk {
                center,
                normal,
                radius,
                axes,
            } => Geometry::Disk(Disk {
                center: normalisation.point(*center),
                normal: normal.normalize().as_vec3a(),
                radius: normalisation.length(*radius),
                axes: axes.map(|axis| axis.normalize().as_vec3a()),
            }),
        };
        if let Self::Rectangle(_, [corner, u, v]) = self {
            let to = |p: DVec3| normalisation.point(p);
            let edges = [*u, *v].map(|edge| to(*corner + edge) - to(*corner));
            rectangle = Some([to(*corner), edges[0], edges[1]]);
        }
        NormalisedShape {
            geometry,
            form: TransformedAttributes { rectangle, dropped },
        }
    }
}

/// A shape in normalised units.
#[derive(Debug)]
pub struct NormalisedShape {
    /// The geometry that rays intersect.
    pub geometry: Geometry,
    /// Further attributes.
    pub form: TransformedAttributes,
}

/// Attributes of a normalised shape besides its geometry.
#[derive(Debug, Clone, Copy)]
pub struct TransformedAttributes {
    /// Corner and edges of a rectangle with right angles.
    pub rectangle: Option<[Vec3; 3]>,
    /// Number of triangles that were left out.
    pub dropped: usize,
}

/// Whether a mesh has shading normals that differ from its geometric ones: many exporters write normals for flat faces,
/// too.
pub fn has_shading_normals(mesh: &MeshDescription) -> bool {
    let triangles = mesh.indices.par_iter().with_min_len(MIN_PER_THREAD);
    !mesh.normals.is_empty()
        && triangles.any(|t| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let Some(ng) = (b - a).cross(c - a).try_normalize() else {
                return false;
            };
            // Files round normals to about four digits.
            t.iter().any(|&i| {
                let ns = mesh.normals[i as usize].normalize_or(ng);
                ns.cross(ng).length() > 2e-4
            })
        })
}

/// Returns the uniform scale of a transform, if it is uniform up to a relative `tolerance`: that of the precision to
/// which the transform was rounded.
pub fn even_scale(transform: &DAffine3, tolerance: f64) -> Option<f64> {
    let matrix = transform.matrix3;
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let scale = axes[0].length();
    let even = axes
        .iter()
        .all(|axis| (axis.length() / scale - 1.0).abs() < tolerance)
        && (0..3).all(|i| axes[i].dot(axes[(i + 1) % 3]).abs() < tolerance * scale * scale);
    even.then_some(scale)
}

/// Maximum deviation of a uniform scale from rounding to double precision.
pub const EVEN: f64 = 1e-9;

/// Returns the scale of a shape's transform, which must be uniform.
fn scale_of(transform: &DAffine3, shape: &ShapeDescription) -> Result<f64> {
    even_scale(transform, EVEN).ok_or_else(|| {
        let message = format!(
            "the transform of `{}` stretches it unevenly, but a sphere or disk has to stay one; use a mesh instead",
            shape.name
        );
        shape.place.error(message)
    })
}

/// Returns the texture axes of a disk without rotation.
fn disk_axes(normal: DVec3) -> [DVec3; 2] {
    let frame = Frame::from_normal(normal.as_vec3a());
    [frame.s.as_dvec3(), frame.t.as_dvec3()]
}

/// Returns the matrix for normals: the inverse transpose, up to a positive factor.
fn normal_matrix(transform: &DAffine3) -> DMat3 {
    let matrix = transform.matrix3;
    // The cofactor matrix avoids dividing by the determinant; its sign keeps normals outside when mirroring.
    let cofactor = DMat3::from_cols(
        matrix.y_axis.cross(matrix.z_axis),
        matrix.z_axis.cross(matrix.x_axis),
        matrix.x_axis.cross(matrix.y_axis),
    );
    cofactor * matrix.determinant().signum()
}

fn rectangle_mesh(corner: DVec3, u: DVec3, v: DVec3) -> MeshDescription {
    let uv = |u, v| DVec2::new(u, v);
    MeshDescription {
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        normals: vec![],
        uvs: vec![uv(0.0, 0.0), uv(1.0, 0.0), uv(1.0, 1.0), uv(0.0, 1.0)],
        indices: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Returns six faces with outward normals, each with its own vertices and texture coordinates.
fn box_mesh(min: DVec3, max: DVec3) -> MeshDescription {
    let mut mesh = MeshDescription::default();
    let size = max - min;
    for axis in 0..3 {
        let [u, v] = [1, 2].map(|step| {
            let mut edge = DVec3::ZERO;
            edge[(axis + step) % 3] = size[(axis + step) % 3];
            edge
        });
        let mut far = min;
        far[axis] = max[axis];
        for (corner, u, v) in [(min, v, u), (far, u, v)] {
            let face = rectangle_mesh(corner, u, v);
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(face.positions);
            mesh.uvs.extend(face.uvs);
            mesh.indices
                .extend(face.indices.iter().map(|t| t.map(|i| i + first)));
        }
    }
    mesh
}
