//! Prepares a scene description for rendering. `update.rs` changes what is prepared.
//!
//! Everything is transformed in double precision, normalised, and only then rounded. A group is normalised by itself, so
//! that its shapes keep their precision wherever its instances are placed.
//!
//! Measure: world units in, normalised units out.
//! Range: descriptions that `load` accepts; a transform that scales a sphere or disk non-uniformly is an error, and so
//! is a shape farther away than 2^48 times the scene's unit.
//! Source: docs/architecture.md. Tested below.

use super::build_geometry::{build_geometry, instances};
use super::caustic_targets::caustic_targets;
use super::description::{CameraDescription, SceneDescription};
use super::effects;
use super::extent::{self, SceneBoxes, bounding_sphere, frame_of};
use super::footprint;
use super::keyframes;
use super::material::Material;
use super::normalisation::Normalisation;
use super::placed::TransformedShape;
use super::placement::{forms_own_group, layout};
use super::scene_lights::SceneLights;
use super::{PreparedCache, Scene};
use crate::accel::{Accel, AccelOptions};
use crate::camera::{Camera, CameraParameters};
use crate::error::Result;
use crate::geometry::world::World;
use crate::math::vec::DAffine3;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A scene prepared for rendering, and notes about what was left out of it.
#[derive(Debug)]
pub struct Prepared {
    /// The scene.
    pub scene: Scene,
    /// Notes for the user, such as how many triangles were dropped.
    pub notes: Vec<String>,
    /// Time spent building the acceleration structure.
    pub build_time: Duration,
}

/// Prepares a scene. Loops over the triangles of meshes run on rayon's current threads.
///
/// # Errors
/// A shape that cannot be transformed as described, insufficient memory, or an error of the acceleration structure's
/// backend.
pub fn prepare(description: &SceneDescription, options: AccelOptions) -> Result<Prepared> {
    let layout = layout(description)?;
    footprint::check(description, &layout, options.backend)?;
    let roots = place(&layout.shapes, description)?;
    let groups = layout.groups.iter();
    let groups = groups
        .map(|shapes| place(shapes, description))
        .collect::<Result<Vec<_>>>()?;
    let boxes = SceneBoxes::new(&roots, &groups, &layout);
    let (normalisation, whole) = Normalisation::of(&boxes);
    let radius = extent::radius(&whole, &normalisation);

    let materials = description.materials.iter();
    let unit = normalisation.length(1.0);
    let materials: Vec<Material> = materials
        .map(|material| Material::new(material, unit))
        .collect();
    let (roots, ungrouped) = build_geometry(&layout.shapes, &roots, description, &normalisation)?;
    let mut cache = PreparedCache {
        radius,
        objects: effects::of_objects(description, &layout),
        ungrouped,
        group_normalisations: groups.iter().map(|group| frame_of(group)).collect(),
        groups: vec![],
    };
    let mut members = Vec::with_capacity(groups.len());
    let placed = groups.iter().zip(&cache.group_normalisations);
    for (shapes, (group, frame)) in layout.groups.iter().zip(placed) {
        let (geometries, forms) = build_geometry(shapes, group, description, frame)?;
        members.push(geometries);
        cache.groups.push(forms);
    }
    let instances = instances(
        &layout,
        &normalisation,
        &cache.group_normalisations,
        &members,
    )?;
    let world = Arc::new(World::new(roots, members, instances));
    let building = Instant::now();
    let accel = Arc::new(Accel::build(Arc::clone(&world), options)?);
    let build_time = building.elapsed();
    let scene_lights = SceneLights::new(
        description,
        &layout,
        &materials,
        (&normalisation, &cache),
        &world,
    );
    let notes = scene_lights.notes(&cache);
    let scene = Scene {
        bounding_sphere: bounding_sphere(&world),
        caustic_targets: caustic_targets(description, &scene_lights.shapes, &world),
        camera: camera(&description.camera, description.film.size, &normalisation),
        environment: description.constant_environment(),
        normalisation,
        world,
        accel,
        effects: scene_lights.effects(&description.camera, &cache),
        shapes: scene_lights.shapes,
        materials,
        lights: scene_lights.lights,
        emitters: scene_lights.emitters,
        light_primitives: scene_lights.light_primitives,
        cache,
    };
    Ok(Prepared {
        scene,
        notes,
        build_time,
    })
}

fn place(shapes: &[usize], description: &SceneDescription) -> Result<Vec<TransformedShape>> {
    let shutter = description.camera.shutter;
    let shapes = shapes.iter().map(|&shape| &description.shapes[shape]);
    shapes
        .map(|shape| {
            // The keyframes of a shape that forms its own group are applied to the group; those of others are constant.
            let then = if forms_own_group(shape, shutter) {
                DAffine3::IDENTITY
            } else {
                keyframes::at(&shape.motion, shutter[0])
            };
            TransformedShape::new(shape, &then)
        })
        .collect()
}

/// Makes the camera of a description for a film of this size.
pub(super) fn camera(
    description: &CameraDescription,
    size: (u32, u32),
    normalisation: &Normalisation,
) -> Camera {
    let keys = &description.motion;
    let to_world = if keys.is_empty() {
        vec![description.to_world]
    } else {
        keyframes::steps(keys, description.shutter)
    };
    let pose = |to_world: &DAffine3| {
        let matrix = to_world.matrix3;
        let eye = normalisation.point(to_world.translation);
        (eye, [matrix.x_axis, matrix.y_axis, matrix.z_axis])
    };
    Camera::new(&CameraParameters {
        poses: to_world.iter().map(pose).collect(),
        is_mirrored: description.is_mirrored,
        fov: description.fov,
        size,
        lens_radius: normalisation.length(description.lens_radius),
        focus_distance: normalisation.length(description.focus_distance),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Backend, Precision};
    use crate::effects::kernel::types::Everything;
    use crate::effects::{Effect, Slot};
    use crate::light::types::LightSampling;
    use crate::math::measure::Pmf;
    use crate::math::ray::Ray;
    use crate::math::rgb::Rgb;
    use crate::math::vec::{DVec3, Vec2, Vec3};
    use crate::scene::EmitterLights;
    use crate::scene::description::{
        ColourDescription, GeometryDescription, Keyframe, LightDescription, LightModel,
        MaterialDescription, MaterialModel, MeshDescription, Place, ShapeDescription,
    };

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
        prepare(&scene(geometry, transform), options())
    }

    fn options() -> AccelOptions {
        AccelOptions {
            backend: Backend::ALL[0],
            precision: Precision::Robust,
            quality: None,
            threads: 1,
        }
    }

    fn unit_box() -> GeometryDescription {
        GeometryDescription::Box {
            min: -DVec3::ONE,
            max: DVec3::ONE,
        }
    }

    #[test]
    fn box_normals_point_outwards_also_when_mirrored() {
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
                    // The outside emits, and the inside does not.
                    assert_eq!(scene.emitted(&at), Some(Rgb::BLACK));
                }
            }
        }
    }

    #[test]
    fn emissive_rectangle_is_one_light_and_parallelogram_two() {
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
    fn rectangular_faces_of_an_emissive_mesh_are_one_light_each() {
        let (min, max) = (DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        let cuboid = || GeometryDescription::Box { min, max };
        let turned = DAffine3::from_rotation_x(0.4) * DAffine3::from_rotation_z(1.1);
        let scene = prepared(cuboid(), turned).expect("it has an area").scene;
        let EmitterLights::OfPrimitives(lights) = &scene.emitters[0].lights else {
            panic!("a mesh has lights of its primitives");
        };
        assert_eq!(**lights, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]);
        assert_eq!(scene.lights.len(), 6);

        let mut sheared = DAffine3::IDENTITY;
        sheared.matrix3.z_axis.x = 0.1;
        let scene = prepared(cuboid(), sheared).expect("it has an area").scene;
        // Two of the six faces are no rectangles any more.
        assert_eq!(scene.lights.len(), 4 + 2 * 2);
    }

    #[test]
    fn degenerate_triangles_are_dropped_and_counted() {
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
    fn sphere_and_disk_parameterisation_follows_the_transform() {
        let center = DVec3::new(0.25, -0.5, 0.125);
        let sphere = GeometryDescription::Sphere {
            center,
            radius: 1.0,
        };
        let disk = GeometryDescription::Disk {
            center,
            normal: DVec3::new(0.3, -0.2, 1.0),
            radius: 2.0,
        };
        let turned = DAffine3::from_rotation_z(2.0) * DAffine3::from_rotation_y(0.4);
        let mirrored = DAffine3::from_scale(DVec3::new(2.0, 2.0, -2.0));
        for (geometry, transform) in [
            (&sphere, turned),
            (&sphere, mirrored * turned),
            (&disk, turned),
            (&disk, mirrored * turned),
        ] {
            let seen = |transform: DAffine3| {
                let scene = prepared(geometry.clone(), transform)
                    .expect("it stays round")
                    .scene;
                let from = DVec3::new(0.3, 0.2, 5.0);
                let dir = (center + DVec3::new(0.2, 0.1, 0.0) - from).normalize();
                let origin = scene.normalisation.point(transform.transform_point3(from));
                let dir = transform.transform_vector3(dir).normalize().as_vec3a();
                let ray = Ray::new(origin, dir);
                let at = scene
                    .intersect::<Everything>(&ray, 0.0, None, 0.0)
                    .expect("the ray goes there");
                let uv = at.uv.or(Vec2::ZERO);
                let tangents = scene.world.tangents_at::<Everything>(at.id, 0.0, at.p);
                (uv, tangents.map(Vec3::normalize))
            };
            let (uv, tangents) = seen(DAffine3::IDENTITY);
            let (uv_turned, tangents_turned) = seen(transform);
            assert!((uv - uv_turned).length() < 1e-5, "{uv} {uv_turned}");
            for (tangent, turned) in tangents.into_iter().zip(tangents_turned) {
                let expected = transform.transform_vector3(tangent.as_dvec3()).normalize();
                assert!((expected.as_vec3a() - turned).length() < 1e-5, "{turned}");
            }
        }
    }

    #[test]
    fn keyframes_may_scale_a_sphere_non_uniformly() {
        let sphere = GeometryDescription::Sphere {
            center: DVec3::ZERO,
            radius: 1.0,
        };
        let key = |time, height| Keyframe {
            time,
            transform: DAffine3::from_scale(DVec3::new(1.0, height, 1.0)),
        };
        for shutter in [[0.0, 1.0], [1.0, 1.0], [1.0, 2.0]] {
            let mut scene = scene(sphere.clone(), DAffine3::IDENTITY);
            scene.shapes[0].motion = vec![key(0.0, 1.0), key(1.0, 0.5)];
            scene.camera.shutter = shutter;
            let scene = prepare(&scene, options())
                .expect("it is round in its frame")
                .scene;
            assert!(scene.effects.has(Effect::Instances), "{shutter:?}");
            // From above, when the shutter closes.
            let from = scene.normalisation.point(DVec3::new(0.0, 3.0, 0.0));
            let at = scene
                .intersect::<Everything>(&Ray::new(from, -Vec3::Y), 1.0, None, 0.0)
                .expect("it is below");
            let top = scene.normalisation.world_point(at.p);
            assert!((top - DVec3::new(0.0, 0.5, 0.0)).length() < 1e-5, "{top}");
        }
    }

    #[test]
    fn point_light_sample_is_invariant_to_scene_scale() {
        let scene_lights = |scale: f64| {
            let unit_box = GeometryDescription::Box {
                min: -DVec3::ONE,
                max: DVec3::ONE,
            };
            let mut scene = scene(unit_box, DAffine3::from_scale(DVec3::splat(scale)));
            scene.shapes[0].emission = None;
            scene.lights = vec![LightDescription {
                place: Place::default(),
                model: LightModel::Point {
                    position: DVec3::new(0.0, 3.0 * scale, 0.0),
                    intensity: Rgb::grey((4.0 * scale * scale) as f32),
                },
            }];
            let scene = prepare(&scene, options()).expect("it is a box").scene;
            let p = scene.normalisation.point(DVec3::new(0.0, scale, 0.0));
            let only = (0, Pmf(1.0));
            let u = Vec2::splat(0.5);
            let sample =
                scene.sample_light::<Everything>(only, LightSampling::default(), p, 0.0, u);
            sample.expect("it is lit").radiance
        };
        for exponent in [-70, -40, 0, 40, 60] {
            assert_eq!(
                scene_lights(2.0_f64.powi(exponent)),
                Rgb::WHITE,
                "{exponent}"
            );
        }
    }

    #[test]
    fn non_uniformly_scaled_sphere_is_rejected_with_line() {
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
