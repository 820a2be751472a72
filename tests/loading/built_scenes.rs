//! Scenes that are built in code are checked by the rules for scenes that are loaded.

use crate::common::scene_folder::{SMALL, in_repository, load_text};
use etendue::ErrorKind;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec2, DVec3};
use etendue::internals::scene::check;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, InstanceDescription, Keyframe, LightDescription,
    LightModel, MaterialDescription, MaterialModel, MeshDescription, Place, SceneDescription,
    ShapeDescription,
};
use etendue::internals::scene::load::load;
use std::sync::Arc;

#[test]
fn loaded_scenes_pass_the_scene_check() {
    for file in [
        "scenes/cornell-box/cornell-box.toml",
        "scenes/suzanne-room/suzanne-room.toml",
    ] {
        let scene = load(&in_repository(file)).expect("a bundled scene");
        check::scene(&scene).unwrap_or_else(|error| panic!("{file}: {error}"));
    }
    check::scene(&load_text(SMALL)).expect("it was loaded");
}

/// A valid scene with parts of every kind, for tests to make invalid.
fn scene() -> SceneDescription {
    let mut scene = load_text(SMALL);
    scene.add_group("group");
    let mesh = MeshDescription {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: vec![DVec3::Z; 3],
        uvs: vec![DVec2::ZERO; 3],
        indices: vec![[0, 1, 2]],
    };
    let mesh = GeometryDescription::Mesh(Arc::new(mesh));
    scene
        .add_shape(ShapeDescription::new("mesh", Place::default(), mesh))
        .expect("valid");
    scene
        .add_instance(InstanceDescription {
            name: "instance".into(),
            place: Place::default(),
            of: 0,
            group: None,
            transform: DAffine3::IDENTITY,
            motion: vec![],
        })
        .expect("valid");
    scene
}

#[track_caller]
fn is_refused(words: &str, spoil: impl Fn(&mut SceneDescription)) {
    let mut scene = scene();
    spoil(&mut scene);
    let error = check::scene(&scene).expect_err(words);
    assert_eq!(error.kind(), ErrorKind::Scene);
    assert!(error.to_string().contains(words), "{words}: {error}");
}

fn mesh_of(scene: &mut SceneDescription) -> &mut MeshDescription {
    match &mut scene.shapes.last_mut().expect("the mesh").geometry {
        GeometryDescription::Mesh(mesh) => Arc::make_mut(mesh),
        other => panic!("{other:?}"),
    }
}

#[test]
fn invalid_cameras_and_films_are_rejected_naming_the_field() {
    is_refused("camera.fov", |scene| scene.camera.fov = f64::NAN);
    is_refused("camera.fov", |scene| scene.camera.fov = 3.2);
    is_refused("camera.to_world", |scene| {
        scene.camera.to_world.matrix3 *= 2.0;
    });
    is_refused("camera.to_world", |scene| {
        scene.camera.to_world.translation.x = f64::INFINITY;
    });
    is_refused("camera.lens_radius", |scene| {
        scene.camera.lens_radius = -1.0
    });
    is_refused("camera.focus_distance", |scene| {
        scene.camera.focus_distance = 0.0;
    });
    is_refused("camera.shutter", |scene| scene.camera.shutter = [1.0, 0.0]);
    is_refused("film.size", |scene| scene.film.size = (1, 65537));
    is_refused("film.filter", |scene| scene.film.filter.radius = 0.0);
}

#[test]
fn invalid_shapes_are_rejected_naming_the_field() {
    is_refused("mesh`: indices: vertex 3", |scene| {
        mesh_of(scene).indices.push([0, 1, 3]);
    });
    is_refused("positions", |scene| {
        mesh_of(scene).positions[0].x = f64::NAN
    });
    is_refused("normals", |scene| mesh_of(scene).normals.truncate(1));
    is_refused("normals", |scene| mesh_of(scene).normals[2].y = f64::NAN);
    is_refused("uvs", |scene| mesh_of(scene).uvs.truncate(1));
    is_refused("uvs", |scene| mesh_of(scene).uvs[1].x = 1e39);
    is_refused("floor`: material", |scene| scene.shapes[0].material = 99);
    is_refused("floor`: group", |scene| scene.shapes[0].group = Some(1));
    is_refused("floor`: transform", |scene| {
        scene.shapes[0].transform = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    });
    is_refused("floor`: emission", |scene| {
        scene.shapes[0].emission = Some(Rgb::grey(-1.0).into());
    });
    is_refused("floor: motion", |scene| {
        let key = |time| Keyframe {
            time,
            transform: DAffine3::IDENTITY,
        };
        scene.shapes[0].motion = vec![key(1.0), key(1.0)];
    });
    let geometries = [
        (
            "radius",
            GeometryDescription::Sphere {
                center: DVec3::ZERO,
                radius: 0.0,
            },
        ),
        (
            "normal",
            GeometryDescription::Disk {
                center: DVec3::ZERO,
                normal: DVec3::ZERO,
                radius: 1.0,
            },
        ),
        (
            "edge_v",
            GeometryDescription::Rectangle {
                corner: DVec3::ZERO,
                edge_u: DVec3::X,
                edge_v: DVec3::X,
            },
        ),
        (
            "max",
            GeometryDescription::Box {
                min: DVec3::ONE,
                max: DVec3::X,
            },
        ),
    ];
    for (words, geometry) in geometries {
        is_refused(words, |scene| scene.shapes[0].geometry = geometry.clone());
    }
    is_refused("instance`: of", |scene| scene.instances[0].of = 1);
}

fn grey(value: f32) -> ColourDescription {
    ColourDescription::from(Rgb::grey(value))
}

#[test]
fn invalid_material_models_are_rejected_naming_the_field() {
    let bright = Texture::Image {
        image: Arc::new(Image::filled(2, 2, Rgb::WHITE).into()),
        scale: 1.5,
    };
    let models = [
        (
            "reflectance",
            MaterialModel::Diffuse {
                reflectance: grey(1.1),
            },
        ),
        (
            "reflectance",
            MaterialModel::Mirror {
                reflectance: ColourDescription::Texture(Arc::new(bright)),
            },
        ),
        (
            "eta",
            MaterialModel::Conductor {
                eta: Rgb::new(1.0, 0.0, 1.0),
                k: Rgb::WHITE,
                roughness: 0.0,
                tint: Rgb::WHITE,
            },
        ),
        (
            "specular",
            MaterialModel::Phong {
                diffuse: grey(0.6),
                specular: grey(0.6),
                exponent: 1.0,
            },
        ),
        (
            "ior",
            MaterialModel::Plastic {
                reflectance: grey(0.5),
                ior: 0.9,
                roughness: 0.0,
            },
        ),
        (
            "roughness",
            MaterialModel::Dielectric {
                ior: 0.9,
                roughness: 1.1,
                tint: grey(1.0),
            },
        ),
        (
            "metallic",
            MaterialModel::Principled {
                base_color: grey(0.5),
                metallic: f32::NAN,
                roughness: 0.0,
                ior: 1.5,
                transmission: 0.0,
            },
        ),
    ];
    for (words, model) in models {
        is_refused(words, |scene| scene.materials[0].model = model.clone());
    }
}

#[test]
fn one_sided_glass_and_an_alpha_above_one_are_rejected() {
    is_refused("two_sided", |scene| {
        let ior = 1.5;
        let (roughness, tint) = (0.0, grey(1.0));
        let glass = MaterialModel::Dielectric {
            ior,
            roughness,
            tint,
        };
        scene.materials[0] = MaterialDescription {
            two_sided: false,
            ..MaterialDescription::new("glass", Place::default(), glass)
        };
    });
    is_refused("alpha", |scene| scene.materials[0].alpha = grey(2.0));
}

#[test]
fn invalid_lights_are_rejected_naming_the_field() {
    let checker = Texture::Checker {
        colours: [Rgb::BLACK, Rgb::WHITE],
        repeat: etendue::internals::math::vec::Vec2::ONE,
    };
    let spot = |cone: f64, penumbra: f64| LightModel::Spot {
        position: DVec3::ZERO,
        target: DVec3::X,
        intensity: Rgb::WHITE,
        cone,
        penumbra,
    };
    let lights = [
        (
            "radiance",
            LightModel::Environment {
                radiance: ColourDescription::Texture(Arc::new(checker)),
                to_world: DMat3::IDENTITY,
            },
        ),
        (
            "to_world",
            LightModel::Environment {
                radiance: Rgb::WHITE.into(),
                to_world: DMat3::ZERO,
            },
        ),
        (
            "intensity",
            LightModel::Point {
                position: DVec3::ZERO,
                intensity: Rgb::grey(f32::INFINITY),
            },
        ),
        (
            "position",
            LightModel::Point {
                position: DVec3::NAN,
                intensity: Rgb::WHITE,
            },
        ),
        ("cone", spot(0.0, 0.0)),
        ("penumbra", spot(0.5, 0.6)),
        (
            "direction",
            LightModel::Distant {
                direction: DVec3::ZERO,
                irradiance: Rgb::WHITE,
            },
        ),
    ];
    for (words, model) in lights {
        is_refused(words, |scene| {
            scene.lights[0] = LightDescription {
                place: Place::default(),
                model: model.clone(),
            };
        });
    }
}

#[test]
fn rejected_shapes_and_lights_are_not_added_to_the_scene() {
    let mut scene = scene();
    let sphere = |radius| GeometryDescription::Sphere {
        center: DVec3::ZERO,
        radius,
    };
    let shapes = scene.shapes.len();
    let ball = |radius| ShapeDescription::new("ball", Place::default(), sphere(radius));
    assert!(scene.add_shape(ball(-1.0)).is_err());
    assert_eq!(scene.shapes.len(), shapes);
    assert_eq!(scene.add_shape(ball(1.0)).expect("valid"), shapes);
    let panorama = || {
        let image = Arc::new(Image::filled(2, 1, Rgb::WHITE).into());
        let texture = Texture::Image { image, scale: 1.0 };
        LightDescription {
            place: Place::default(),
            model: LightModel::Environment {
                radiance: ColourDescription::Texture(Arc::new(texture)),
                to_world: DMat3::IDENTITY,
            },
        }
    };
    let lights = scene.lights.len();
    assert_eq!(scene.add_light(panorama()).expect("the first"), lights);
    assert!(scene.add_light(panorama()).is_err());
    assert_eq!(scene.lights.len(), lights + 1);
}
