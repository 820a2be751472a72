//! From a scene as written to a scene that can be rendered.
//!
//! Everything is placed in double precision, normalised, and only then rounded. A group is normalised by itself: its shapes
//! keep their digits wherever its instances stand.
//!
//! Measure: world units in, normalised units out.
//! Range: what `load` lets through; a transform that stretches a sphere or disk unevenly is an error, and so is what is
//! farther away than 2^48 times the scene's unit.
//! Source: docs/architecture.md. Tested below.

use super::description::{CameraDescription, ColourDescription, LightModel, SceneDescription};
use super::effects;
use super::emitters::{Emitters, Standing};
use super::keyframes;
use super::material::Material;
use super::normalisation::Normalisation;
use super::placed::{Placed, Traced};
use super::placement::{Layout, Placement, layout, stands_alone};
use super::{Scene, Shape};
use crate::accel::{Accel, AccelOptions};
use crate::camera::{Camera, CameraParameters};
use crate::effects::Effect;
use crate::error::Result;
use crate::geometry::packed::PackedImages;
use crate::geometry::texture::Texture;
use crate::geometry::world::{Instance, World};
use crate::light::select::Lights;
use crate::light::{
    Light, distant::DistantLight, environment::EnvironmentMap, point::PointLight, spot::SpotLight,
};
use crate::math::bounds::Bounds;
use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DVec3};
use crate::planted::planted;
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
    let layout = layout(description)?;
    let roots = place(&layout.shapes, description)?;
    let groups = layout.groups.iter();
    let groups = groups
        .map(|shapes| place(shapes, description))
        .collect::<Result<Vec<_>>>()?;
    let boxes = boxes(&roots, &groups, &layout);
    let normalisation = Normalisation::of(&boxes);
    let radius = scene_radius(&boxes, &normalisation);

    let mut packed = PackedImages::default();
    let materials = description.materials.iter();
    let materials: Vec<Material> = materials
        .map(|material| Material::new(material).packed(&mut packed))
        .collect();
    let mut build = Build::new(description, &materials);
    let roots = build.trace(&layout.shapes, &roots, &normalisation)?;
    let frames: Vec<Normalisation> = groups.iter().map(|group| frame_of(group)).collect();
    let members = layout.groups.iter().zip(groups.iter().zip(&frames));
    let members: Vec<Vec<Traced>> = members
        .map(|(shapes, (group, frame))| build.trace(shapes, group, frame))
        .collect::<Result<_>>()?;
    build.add_lights(&normalisation, radius);
    build.add_shapes(&layout.shapes, &roots, Standing::World);
    let mut instances = Vec::with_capacity(layout.placements.len());
    for placement in &layout.placements {
        let instance = instance(placement, &normalisation, &frames[placement.group])?;
        let boxes = members[placement.group].iter();
        let boxes = boxes.map(|traced| instance.bounds_of(&traced.geometry.bounds()));
        if !boxes
            .fold(Bounds::default(), Bounds::union)
            .is_within(REACH)
        {
            let (name, place) = &placement.object;
            return Err(place.error(too_far(name)));
        }
        let standing = match instance.steps.as_slice() {
            [still] => Standing::Still(still),
            steps => Standing::Moving(steps),
        };
        let shapes = &layout.groups[placement.group];
        build.add_shapes(shapes, &members[placement.group], standing);
        instances.push(instance);
    }

    let geometries = |traced: Vec<Traced>| traced.into_iter().map(|t| t.geometry).collect();
    let groups = members.into_iter().map(geometries).collect();
    let world = Arc::new(World::new(geometries(roots), groups, instances));
    let building = Instant::now();
    let accel = Accel::build(Arc::clone(&world), options)?;
    let build_time = building.elapsed();
    let notes = build.notes();
    let Emitters {
        emitters,
        lights,
        powers,
        primitives,
        ..
    } = build.emitters;
    let many_lights = lights.len() > 1;
    let all_in_place = primitives.iter().all(Option::is_none);
    let scene = Scene {
        camera: camera(&description.camera, description.film.size, &normalisation),
        lights: Lights::new(lights, &powers),
        environment: description.constant_environment(),
        normalisation,
        world,
        accel,
        effects: effects::of_scene(description, &layout).with_if(Effect::ManyLights, many_lights),
        shapes: build.shapes,
        materials,
        emitters,
        light_primitives: if all_in_place { vec![] } else { primitives },
    };
    Ok(Prepared {
        scene,
        notes,
        build_time,
    })
}

/// In normalised units. Farther away, areas times numbers of primitives leave single precision, and obvhs builds its trees by
/// these; beyond 2^60, Embree leaves shapes out without a word.
const REACH: f64 = (1_u64 << 48) as f64;

fn too_far(name: &str) -> String {
    format!(
        "{name} reaches farther than 2^48 times the size of what the scene mostly consists of, or leaves double precision"
    )
}

fn place(shapes: &[usize], description: &SceneDescription) -> Result<Vec<Placed>> {
    let shutter = description.camera.shutter;
    let shapes = shapes.iter().map(|&shape| &description.shapes[shape]);
    shapes
        .map(|shape| {
            // What stands alone is placed with its group; keys that are all equal still say where.
            let then = if stands_alone(shape, shutter) {
                DAffine3::IDENTITY
            } else {
                keyframes::at(&shape.motion, shutter[0])
            };
            Placed::new(shape, &then)
        })
        .collect()
}

/// The boxes of all primitives; of an instance one for each shape.
fn boxes(roots: &[Placed], groups: &[Vec<Placed>], layout: &Layout) -> Vec<Bounds> {
    let whole = |placed: &Placed| {
        let boxes = placed.boxes().into_iter();
        boxes.fold(Bounds::default(), Bounds::union)
    };
    let of_groups: Vec<Vec<Bounds>> = groups
        .iter()
        .map(|group| group.iter().map(whole).filter(|b| !b.is_empty()).collect())
        .collect();
    let of_instances = layout.placements.iter().flat_map(|placement| {
        let shapes = &of_groups[placement.group];
        shapes.iter().map(|bounds| {
            let moved = placement.steps.iter().map(|step| moved(bounds, step));
            moved.fold(Bounds::default(), Bounds::union)
        })
    });
    roots
        .iter()
        .flat_map(Placed::boxes)
        .chain(of_instances)
        .collect()
}

/// The box around a transformed box.
fn moved(bounds: &Bounds, transform: &DAffine3) -> Bounds {
    Bounds::around((0..8).map(|corner| {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        transform.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    }))
}

/// Half the diagonal of the box around everything, in normalised units.
fn scene_radius(boxes: &[Bounds], normalisation: &Normalisation) -> f64 {
    let whole = boxes.iter().fold(Bounds::default(), |all, b| all.union(*b));
    if whole.is_empty() {
        return 1.0;
    }
    f64::from(normalisation.length(0.5 * whole.extent().length()))
}

/// A group's own frame.
fn frame_of(group: &[Placed]) -> Normalisation {
    let boxes: Vec<Bounds> = group.iter().flat_map(Placed::boxes).collect();
    Normalisation::of(&boxes)
}

/// A placement in normalised units on both sides, rounded last.
fn instance(
    placement: &Placement,
    world: &Normalisation,
    group: &Normalisation,
) -> Result<Instance> {
    let from_group = group.to_affine().inverse();
    let to_world = world.to_affine();
    let round =
        |m: DAffine3| DAffine3::from_cols_array(&m.to_cols_array().map(|x| f64::from(x as f32)));
    let steps = placement.steps.iter();
    let instance = Instance {
        group: placement.group,
        steps: steps.map(|&m| round(to_world * m * from_group)).collect(),
    };
    if instance.is_invertible() {
        return Ok(instance);
    }
    let (name, place) = &placement.object;
    let message = format!(
        "the transform of {name} cannot be inverted in single precision at all times: it flattens space, is too large or too small for the scene, or turns by half a circle or more from one key to the next"
    );
    Err(place.error(message))
}

fn camera(
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
        fov: description.fov,
        size,
        lens_radius: normalisation.length(description.lens_radius),
        focus_distance: normalisation.length(description.focus_distance),
    })
}

/// What is gathered shape by shape.
struct Build<'a> {
    description: &'a SceneDescription,
    materials: &'a [Material],
    shapes: Vec<Shape>,
    emitters: Emitters,
    dropped: usize,
}

impl<'a> Build<'a> {
    fn new(description: &'a SceneDescription, materials: &'a [Material]) -> Self {
        Self {
            description,
            materials,
            shapes: vec![],
            emitters: Emitters::default(),
            dropped: 0,
        }
    }

    /// # Errors
    /// The first of the shapes that is out of reach.
    fn trace(
        &mut self,
        shapes: &[usize],
        placed: &[Placed],
        normalisation: &Normalisation,
    ) -> Result<Vec<Traced>> {
        let trace = |(&shape, placed): (&usize, &Placed)| {
            let traced = placed.traced(normalisation);
            self.dropped += traced.dropped;
            let geometry = &traced.geometry;
            if geometry.primitive_count() > 0 && !geometry.bounds().is_within(REACH) {
                let shape = &self.description.shapes[shape];
                return Err(shape.place.error(too_far(&shape.name)));
            }
            Ok(traced)
        };
        shapes.iter().zip(placed).map(trace).collect()
    }

    /// Adds shapes in the order in which rays number them.
    fn add_shapes(&mut self, shapes: &[usize], traced: &[Traced], standing: Standing<'_>) {
        for (&shape, traced) in shapes.iter().zip(traced) {
            let description = &self.description.shapes[shape];
            let number = self.shapes.len() as u32;
            let material = &self.materials[description.material];
            let masked = material.is_masked();
            let emitter = self
                .emitters
                .add_shape(number, description, masked, traced, standing);
            let emission = emitter.map(|index| &self.emitters.emitters[index as usize]);
            let shines_by_texture = emission.is_some_and(|emitter| emitter.texture.is_some());
            self.shapes.push(Shape {
                described: shape as u32,
                material: description.material as u32,
                emitter,
                textured: material.is_textured() || shines_by_texture,
            });
        }
    }

    /// Adds the lights that are no shapes and are sampled, for a scene of this radius in normalised units.
    fn add_lights(&mut self, normalisation: &Normalisation, radius: f64) {
        for light in &self.description.lights {
            if let Some(light) = light_of(&light.model, normalisation) {
                let power = light.power(radius);
                self.emitters.add_light(light, power);
            }
        }
    }

    fn notes(&self) -> Vec<String> {
        let dropped = (self.dropped > 0)
            .then(|| format!("{} triangles without an area were left out", self.dropped));
        let unsampled = self.emitters.unsampled;
        let unsampled = (unsampled > 0).then(|| {
            format!(
                "{unsampled} emitting spheres, disks or textured meshes move, or are stretched or mirrored by an instance: only scattered rays find their light, with more noise"
            )
        });
        dropped.into_iter().chain(unsampled).collect()
    }
}

/// A light that is no shape, in normalised units; `None` if it is black, or the same in all directions.
fn light_of(model: &LightModel, normalisation: &Normalisation) -> Option<Light> {
    // Irradiance, I / d^2, is not to change with the unit of length. The square of a unit may leave single precision
    // where its product with an intensity does not.
    let intensity = |intensity: Rgb| {
        let normalised = |x: f32| normalisation.area(f64::from(x)) as f32;
        let normalised = |x| planted!("intensity-in-world-units", x, normalised(x));
        (!intensity.is_black()).then(|| intensity.map(normalised))
    };
    Some(match model {
        LightModel::Environment { radiance, to_world } => {
            let (None, ColourDescription::Texture(texture)) = (radiance.constant(), radiance)
            else {
                return None;
            };
            let Texture::Image { image, scale } = texture.as_ref() else {
                return None;
            };
            let map = EnvironmentMap::new(Arc::clone(image), *scale, *to_world)?;
            Light::Environment(Arc::new(map))
        }
        LightModel::Point {
            position,
            intensity: i,
        } => {
            let position = normalisation.point(*position);
            Light::Point(PointLight::new(position, intensity(*i)?))
        }
        LightModel::Spot {
            position,
            target,
            intensity: i,
            cone,
            penumbra,
        } => {
            let axis = (*target - *position).normalize().as_vec3a();
            let position = normalisation.point(*position);
            Light::Spot(SpotLight::new(
                position,
                axis,
                intensity(*i)?,
                *cone,
                *penumbra,
            ))
        }
        LightModel::Distant {
            direction,
            irradiance,
        } => {
            let direction = direction.normalize().as_vec3a();
            let light = DistantLight::new(direction, *irradiance);
            Light::Distant((!irradiance.is_black()).then_some(light)?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Backend, Precision, Quality};
    use crate::effects::Slot;
    use crate::effects::kernel::types::Everything;
    use crate::light::types::PointRule;
    use crate::math::measure::Pmf;
    use crate::math::ray::Ray;
    use crate::math::rgb::Rgb;
    use crate::math::vec::{Vec2, Vec3};
    use crate::scene::description::{
        GeometryDescription, Key, LightDescription, MaterialDescription, MaterialModel,
        MeshDescription, Place, ShapeDescription,
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
            quality: Quality::default(),
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
    fn textures_of_spheres_and_disks_turn_with_them() {
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
    fn keys_may_stretch_a_sphere_whether_it_moves_or_not() {
        let sphere = GeometryDescription::Sphere {
            center: DVec3::ZERO,
            radius: 1.0,
        };
        let key = |time, height| Key {
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
    fn points_light_scenes_of_any_size_alike() {
        let lit = |scale: f64| {
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
            let sample = scene.sample_light::<Everything>(only, PointRule::SolidAngle, p, 0.0, u);
            sample.expect("it is lit").radiance
        };
        for exponent in [-70, -40, 0, 40, 60] {
            assert_eq!(lit(2.0_f64.powi(exponent)), Rgb::WHITE, "{exponent}");
        }
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
