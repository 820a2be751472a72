//! From a scene as written to a scene that can be rendered.
//!
//! Everything is placed in double precision, normalised, and only then rounded. Triangles without an area are dropped
//! and counted.
//!
//! Measure: world units in, normalised units out.
//! Range: what `load` lets through; a transform that stretches a sphere or disk unevenly is an error.
//! Source: docs/architecture.md. Tested below.

use super::description::{
    CameraDescription, GeometryDescription, MeshDescription, SceneDescription, ShapeDescription,
};
use super::material::Material;
use super::normalisation::Normalisation;
use super::{Emitter, Scene, Shape};
use crate::accel::{Accel, AccelOptions};
use crate::camera::{Camera, CameraParameters};
use crate::effects::EffectSet;
use crate::error::{Error, Result};
use crate::geometry::world::World;
use crate::geometry::{Geometry, disk::Disk, mesh::Mesh, sphere::Sphere};
use crate::light::select::Lights;
use crate::light::types::Emission;
use crate::light::{
    Light, disk::DiskLight, rectangle::RectangleLight, sphere::SphereLight, triangle::TriangleLight,
};
use crate::math::bounds::Bounds;
use crate::math::vec::{DAffine3, DVec3, Vec3};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A scene ready to be rendered, and what had to be left out of it.
#[derive(Debug)]
pub struct Prepared {
    /// The scene.
    pub scene: Scene,
    /// Sentences for the user, such as how many triangles were dropped.
    pub notes: Vec<String>,
    /// What building the acceleration structure took of the time.
    pub build_time: Duration,
}

/// Makes a scene ready.
///
/// # Errors
/// A shape that cannot be transformed as written, or what the acceleration structure's backend says.
pub fn prepare(description: &SceneDescription, options: AccelOptions) -> Result<Prepared> {
    let placed = description
        .shapes
        .iter()
        .map(place)
        .collect::<Result<Vec<_>>>()?;
    let boxes: Vec<Bounds> = placed.iter().flat_map(Placed::boxes).collect();
    let normalisation = Normalisation::of(&boxes);

    let mut build = Build::new(normalisation);
    for (placed, shape) in placed.into_iter().zip(&description.shapes) {
        build.add(placed, shape);
    }
    let world = Arc::new(World::new(build.geometries, vec![], vec![]));
    let building = Instant::now();
    let accel = Accel::build(Arc::clone(&world), options)?;
    let build_time = building.elapsed();
    let scene = Scene {
        camera: camera(&description.camera, description.film.size, &normalisation),
        lights: {
            let powers: Vec<f64> = build.lights.iter().map(Light::power).collect();
            Lights::new(build.lights, &powers)
        },
        environment: description.constant_environment(),
        normalisation,
        world,
        accel,
        effects: EffectSet::ALL,
        emitters: build.emitters,
        textured_lights: vec![],
        shapes: build.shapes,
        materials: description.materials.iter().map(Material::new).collect(),
    };
    let dropped = (build.dropped > 0)
        .then(|| format!("{} triangles without an area were left out", build.dropped));
    Ok(Prepared {
        scene,
        notes: dropped.into_iter().collect(),
        build_time,
    })
}

/// A shape in world space, in double precision.
enum Placed {
    Mesh(PlacedMesh),
    Rectangle(PlacedMesh, [DVec3; 3]),
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
}

struct PlacedMesh {
    mesh: Arc<MeshDescription>,
    transform: DAffine3,
}

impl PlacedMesh {
    fn position(&self, index: u32) -> DVec3 {
        self.transform
            .transform_point3(self.mesh.positions[index as usize])
    }
}

impl Placed {
    /// The boxes of all primitives.
    fn boxes(&self) -> Vec<Bounds> {
        match self {
            Self::Mesh(placed) | Self::Rectangle(placed, _) => {
                let triangles = placed.mesh.indices.iter();
                triangles
                    .map(|t| Bounds::around(t.map(|i| placed.position(i))))
                    .collect()
            }
            Self::Sphere { center, radius } | Self::Disk { center, radius, .. } => {
                let radius = DVec3::splat(*radius);
                vec![Bounds {
                    min: *center - radius,
                    max: *center + radius,
                }]
            }
        }
    }
}

/// Moves a shape into world space.
fn place(shape: &ShapeDescription) -> Result<Placed> {
    let transform = shape.transform;
    let mesh = |mesh| PlacedMesh { mesh, transform };
    Ok(match &shape.geometry {
        GeometryDescription::Mesh(description) => Placed::Mesh(mesh(Arc::clone(description))),
        GeometryDescription::Box { min, max } => Placed::Mesh(mesh(Arc::new(box_mesh(*min, *max)))),
        GeometryDescription::Rectangle {
            corner,
            edge_u,
            edge_v,
        } => {
            let description = rectangle_mesh(*corner, *edge_u, *edge_v);
            let edges = [*edge_u, *edge_v].map(|edge| transform.transform_vector3(edge));
            let frame = [transform.transform_point3(*corner), edges[0], edges[1]];
            let right_angle = edges[0].normalize().dot(edges[1].normalize()).abs() < 1e-9;
            let placed = mesh(Arc::new(description));
            if right_angle {
                Placed::Rectangle(placed, frame)
            } else {
                Placed::Mesh(placed)
            }
        }
        GeometryDescription::Sphere { center, radius } => Placed::Sphere {
            center: transform.transform_point3(*center),
            radius: radius * even_scale(shape)?,
        },
        GeometryDescription::Disk {
            center,
            normal,
            radius,
        } => Placed::Disk {
            center: transform.transform_point3(*center),
            normal: normal_matrix(&transform) * normal.normalize(),
            radius: radius * even_scale(shape)?,
        },
    })
}

/// The factor by which a transform scales, if it is the same in all directions.
fn even_scale(shape: &ShapeDescription) -> Result<f64> {
    let matrix = shape.transform.matrix3;
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let scale = axes[0].length();
    let even = axes
        .iter()
        .all(|axis| (axis.length() / scale - 1.0).abs() < 1e-9)
        && (0..3).all(|i| axes[i].dot(axes[(i + 1) % 3]).abs() < 1e-9 * scale * scale);
    if even {
        return Ok(scale);
    }
    let message = format!(
        "the transform of {} stretches it unevenly, but a sphere or disk has to stay one; use a mesh instead",
        shape.name
    );
    Err(at_place(Error::scene(message), shape))
}

fn at_place(error: Error, shape: &ShapeDescription) -> Error {
    let error = error.in_file(&shape.place.file);
    match shape.place.line {
        Some(line) => error.at_line(line),
        None => error,
    }
}

/// What normals are multiplied by: the inverse transpose, up to a positive factor.
fn normal_matrix(transform: &DAffine3) -> glam::DMat3 {
    let matrix = transform.matrix3;
    // The cofactor matrix does not divide by the determinant; its sign keeps normals outside when mirroring.
    let cofactor = glam::DMat3::from_cols(
        matrix.y_axis.cross(matrix.z_axis),
        matrix.z_axis.cross(matrix.x_axis),
        matrix.x_axis.cross(matrix.y_axis),
    );
    cofactor * matrix.determinant().signum()
}

fn rectangle_mesh(corner: DVec3, u: DVec3, v: DVec3) -> MeshDescription {
    let uv = |u, v| glam::DVec2::new(u, v);
    MeshDescription {
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        normals: vec![],
        uvs: vec![uv(0.0, 0.0), uv(1.0, 0.0), uv(1.0, 1.0), uv(0.0, 1.0)],
        indices: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Six faces with normals outwards and texture coordinates of their own.
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

fn camera(
    description: &CameraDescription,
    size: (u32, u32),
    normalisation: &Normalisation,
) -> Camera {
    let matrix = description.to_world.matrix3;
    Camera::new(&CameraParameters {
        eye: normalisation.point(description.to_world.translation),
        axes: [matrix.x_axis, matrix.y_axis, matrix.z_axis],
        fov: description.fov,
        size,
        lens_radius: normalisation.length(description.lens_radius),
        focus_distance: normalisation.length(description.focus_distance),
    })
}

/// What is gathered shape by shape.
struct Build {
    normalisation: Normalisation,
    geometries: Vec<Geometry>,
    shapes: Vec<Shape>,
    lights: Vec<Light>,
    emitters: Vec<Emitter>,
    dropped: usize,
}

impl Build {
    fn new(normalisation: Normalisation) -> Self {
        Self {
            normalisation,
            geometries: vec![],
            shapes: vec![],
            lights: vec![],
            emitters: vec![],
            dropped: 0,
        }
    }

    fn add(&mut self, placed: Placed, description: &ShapeDescription) {
        let emission = description
            .emission
            .as_ref()
            .and_then(|radiance| radiance.constant())
            .filter(|radiance| !radiance.is_black())
            .map(|radiance| Emission {
                radiance,
                two_sided: description.two_sided_emission,
            });
        let first_light = self.lights.len() as u32;
        let mut per_primitive = false;
        let geometry = match placed {
            Placed::Mesh(placed) => {
                let mesh = self.mesh(&placed);
                if let Some(emission) = emission {
                    per_primitive = true;
                    let triangles = (0..mesh.indices().len() as u32).map(|i| mesh.triangle(i));
                    let lights =
                        triangles.map(|t| Light::Triangle(TriangleLight::new(t, emission)));
                    self.lights.extend(lights);
                }
                Geometry::Mesh(mesh)
            }
            Placed::Rectangle(placed, [corner, u, v]) => {
                if let Some(emission) = emission {
                    let to = |p: DVec3| self.normalisation.point(p);
                    let edges = [to(corner + u) - to(corner), to(corner + v) - to(corner)];
                    let light = RectangleLight::new(to(corner), edges, emission);
                    self.lights.push(Light::Rectangle(light));
                }
                Geometry::Mesh(self.mesh(&placed))
            }
            Placed::Sphere { center, radius } => {
                let (center, radius) = (
                    self.normalisation.point(center),
                    self.normalisation.length(radius),
                );
                let sphere = Sphere { center, radius };
                let light = |emission| Light::Sphere(SphereLight::new(sphere, emission));
                self.lights.extend(emission.map(light));
                Geometry::Sphere(sphere)
            }
            Placed::Disk {
                center,
                normal,
                radius,
            } => {
                let disk = Disk {
                    center: self.normalisation.point(center),
                    normal: normal.normalize().as_vec3(),
                    radius: self.normalisation.length(radius),
                };
                let light = |emission| Light::Disk(DiskLight::new(disk, emission));
                self.lights.extend(emission.map(light));
                Geometry::Disk(disk)
            }
        };
        self.geometries.push(geometry);
        let emitter = emission.map(|emission| {
            self.emitters.push(Emitter {
                emission,
                texture: None,
                first_light: Some(first_light),
                per_primitive,
            });
            self.emitters.len() as u32 - 1
        });
        self.shapes.push(Shape {
            material: description.material as u32,
            emitter,
        });
    }

    /// A mesh in normalised units, without the triangles that have no area there.
    fn mesh(&mut self, placed: &PlacedMesh) -> Mesh {
        let description = &placed.mesh;
        let to_normalised = |p: &DVec3| {
            self.normalisation
                .point(placed.transform.transform_point3(*p))
        };
        let positions: Vec<Vec3> = description.positions.iter().map(to_normalised).collect();
        let normal_matrix = normal_matrix(&placed.transform);
        let normals = description.normals.iter();
        let normals = normals.map(|n| (normal_matrix * *n).normalize_or_zero().as_vec3());
        let has_area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a).length_squared() >= f32::MIN_POSITIVE
        };
        let mirrored = placed.transform.matrix3.determinant() < 0.0;
        let indices: Vec<[u32; 3]> = description
            .indices
            .iter()
            .filter(|t| has_area(t))
            // A mirroring transform turns triangles over: the outside stays outside.
            .map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] })
            .collect();
        self.dropped += description.indices.len() - indices.len();
        let normals = normals.collect();
        let uvs = description.uvs.iter().map(|uv| uv.as_vec2()).collect();
        Mesh::new(positions, normals, uvs, indices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Backend, Precision};
    use crate::effects::kernel::types::Everything;
    use crate::math::ray::Ray;
    use crate::math::rgb::Rgb;
    use crate::scene::description::{ColourDescription, MaterialDescription, MaterialModel, Place};

    fn scene(geometry: GeometryDescription, transform: DAffine3) -> SceneDescription {
        let reflectance = ColourDescription::Constant(Rgb::grey(0.5));
        let model = MaterialModel::Diffuse { reflectance };
        let place = Place {
            file: "test".into(),
            line: Some(7),
        };
        let to_world = DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0));
        let shape = ShapeDescription {
            transform,
            emission: Some(ColourDescription::Constant(Rgb::WHITE)),
            ..ShapeDescription::new("shape", place, geometry)
        };
        SceneDescription {
            materials: vec![MaterialDescription::new("grey", Place::default(), model)],
            shapes: vec![shape],
            ..SceneDescription::new("test", CameraDescription::pinhole(to_world, 1.0))
        }
    }

    fn prepared(geometry: GeometryDescription, transform: DAffine3) -> Result<Prepared> {
        let options = AccelOptions {
            backend: Backend::ALL[0],
            precision: Precision::Robust,
            threads: 1,
        };
        prepare(&scene(geometry, transform), options)
    }

    fn unit_box() -> GeometryDescription {
        GeometryDescription::Box {
            min: -DVec3::ONE,
            max: DVec3::ONE,
        }
    }

    #[test]
    fn normals_of_a_box_point_outwards_also_when_it_is_mirrored() {
        let mirror = DAffine3::from_scale(DVec3::new(1.0, -2.0, 0.5));
        for transform in [
            DAffine3::IDENTITY,
            mirror,
            DAffine3::from_rotation_x(0.3) * mirror,
        ] {
            let scene = prepared(unit_box(), transform)
                .expect("a box can be stretched")
                .scene;
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    let mut w = Vec3::ZERO;
                    w[axis] = sign;
                    let inside = scene.normalisation.point(DVec3::new(0.1, 0.05, -0.02));
                    let at = scene
                        .intersect::<Everything>(&Ray::new(inside, w), 0.0, None, 0.0)
                        .expect("a closed box");
                    assert!(at.ng.dot(w) > 0.0, "{transform:?} {w}");
                    // So the outside emits, and what is seen from within does not.
                    assert_eq!(scene.emitted(&at), Some(Rgb::BLACK));
                }
            }
        }
    }

    #[test]
    fn a_rectangle_is_one_light_and_a_parallelogram_two() {
        let rectangle = |edge_v| GeometryDescription::Rectangle {
            corner: DVec3::ZERO,
            edge_u: DVec3::X,
            edge_v,
        };
        let lights = |edge_v, transform| {
            prepared(rectangle(edge_v), transform)
                .expect("it has an area")
                .scene
                .lights
                .len()
        };
        assert_eq!(lights(DVec3::Y, DAffine3::IDENTITY), 1);
        assert_eq!(
            lights(DVec3::Y, DAffine3::from_scale(DVec3::new(3.0, 0.1, 1.0))),
            1
        );
        assert_eq!(lights(DVec3::new(0.5, 1.0, 0.0), DAffine3::IDENTITY), 2);
    }

    #[test]
    fn triangles_without_an_area_are_dropped_and_counted() {
        let mesh = MeshDescription {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, 2.0 * DVec3::X],
            indices: vec![[0, 1, 2], [0, 1, 1], [0, 1, 3]],
            ..MeshDescription::default()
        };
        let geometry = GeometryDescription::Mesh(Arc::new(mesh));
        let prepared = prepared(geometry, DAffine3::IDENTITY).expect("one triangle is left");
        assert_eq!(
            prepared.notes,
            ["2 triangles without an area were left out"]
        );
        assert_eq!(prepared.scene.lights.len(), 1);
    }

    #[test]
    fn a_sphere_cannot_be_stretched_unevenly() {
        let sphere = GeometryDescription::Sphere {
            center: DVec3::ZERO,
            radius: 1.0,
        };
        let even = DAffine3::from_scale(DVec3::splat(3.0)) * DAffine3::from_rotation_x(1.0);
        assert!(prepared(sphere.clone(), even).is_ok());
        let uneven = DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0));
        let error = prepared(sphere, uneven).expect_err("it is no sphere any more");
        assert_eq!(
            (error.kind(), error.line()),
            (crate::ErrorKind::Scene, Some(7))
        );
    }
}
