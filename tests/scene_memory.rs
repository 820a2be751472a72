//! Tests that the peak memory of preparing a scene is at most the memory predicted beforehand, and not far below it. This
//! is the only test of its process, because the allocations of others would be counted, too.
//!
//! Temporary memory of Embree's build is not measured.

mod common;

use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec2, DVec3, Vec2};
use etendue::internals::scene::description::{
    CameraDescription, ColourDescription, GeometryDescription, InstanceDescription, Keyframe,
    LightDescription, LightModel, MaterialDescription, MaterialModel, MeshDescription, Place,
    SceneDescription, ShapeDescription,
};
use etendue::internals::scene::footprint;
use etendue::internals::scene::placement::layout;
use etendue::internals::scene::prepare::prepare;
use peak_alloc::PeakAlloc;
use std::sync::Arc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// A hilly floor of 2 x `side`^2 triangles.
fn hills(side: u32) -> MeshDescription {
    let row = side + 1;
    let corner = |i: u32| {
        let [x, y] = [i % row, i / row];
        DVec3::new(f64::from(x), f64::from(x * y % 7), f64::from(y))
    };
    let triangles = (0..side * side).flat_map(|cell| {
        let here = cell / side * row + cell % side;
        let above = here + row;
        [[here, here + 1, above], [above, here + 1, above + 1]]
    });
    MeshDescription {
        positions: (0..row * row).map(corner).collect(),
        indices: triangles.collect(),
        ..MeshDescription::default()
    }
}

/// A hilly floor with separate vertices, normals and texture coordinates for each triangle.
fn soup(side: u32) -> MeshDescription {
    let shared = hills(side);
    let corners = shared.indices.iter().flatten();
    let positions: Vec<DVec3> = corners.map(|&i| shared.positions[i as usize]).collect();
    let count = positions.len() as u32;
    MeshDescription {
        normals: vec![DVec3::ONE; positions.len()],
        uvs: positions.iter().map(|p| DVec2::new(p.x, p.z)).collect(),
        positions,
        indices: (0..count / 3)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    }
}

fn empty() -> SceneDescription {
    let eye = DVec3::new(0.0, 50.0, 50.0);
    let camera = CameraDescription::look_at(eye, DVec3::ZERO, DVec3::Y, 0.8);
    let mut scene = SceneDescription::new("", camera.expect("a direction"));
    scene.camera.shutter = [0.0, 1.0];
    let reflectance = Rgb::grey(0.5).into();
    let model = MaterialModel::Diffuse { reflectance };
    let grey = MaterialDescription::new("grey", Place::default(), model);
    scene.add_material(grey).expect("valid");
    scene
}

fn shape(geometry: GeometryDescription) -> ShapeDescription {
    ShapeDescription::new("shape", Place::default(), geometry)
}

fn mesh(mesh: MeshDescription) -> ShapeDescription {
    shape(GeometryDescription::Mesh(Arc::new(mesh)))
}

fn ball(x: u32) -> ShapeDescription {
    shape(GeometryDescription::Sphere {
        center: DVec3::new(f64::from(x), 0.0, 0.0),
        radius: 0.4,
    })
}

fn one(shape: ShapeDescription) -> SceneDescription {
    let mut scene = empty();
    scene.add_shape(shape).expect("valid");
    scene
}

fn glowing(shape: ShapeDescription, emission: ColourDescription) -> ShapeDescription {
    ShapeDescription {
        emission: Some(emission),
        ..shape
    }
}

fn turning() -> Vec<Keyframe> {
    let key = |time: f64| Keyframe {
        time,
        transform: DAffine3::from_rotation_y(2.0 * time),
    };
    vec![key(0.0), key(1.0)]
}

fn placed_often(motion: &[Keyframe]) -> SceneDescription {
    let mut scene = empty();
    let group = scene.add_group("pair");
    for x in 0..2 {
        let group = Some(group);
        let member = ShapeDescription { group, ..ball(x) };
        let member = glowing(member, Rgb::WHITE.into());
        scene.add_shape(member).expect("valid");
    }
    for x in 0..2000 {
        scene
            .add_instance(InstanceDescription {
                name: format!("instance {x}"),
                place: Place::default(),
                of: group,
                group: None,
                transform: DAffine3::from_translation(DVec3::new(3.0 * f64::from(x), 0.0, 0.0)),
                motion: motion.to_vec(),
            })
            .expect("valid");
    }
    scene
}

fn panorama() -> SceneDescription {
    let colour = |i: u32| Rgb::new(i as f32, 1.0, 0.5);
    let image = Image::new(512, 512, (0..512 * 512).map(colour).collect());
    let radiance = ColourDescription::Texture(Arc::new(Texture::Image {
        image: Arc::new(image.into()),
        scale: 1.0,
    }));
    let mut scene = one(ball(0));
    let to_world = DMat3::IDENTITY;
    let sky = LightDescription {
        place: Place::default(),
        model: LightModel::Environment { radiance, to_world },
    };
    scene.add_light(sky).expect("valid");
    scene
}

/// Test scenes, small enough that the available memory is not checked, as the check itself allocates.
fn scenes() -> Vec<(&'static str, SceneDescription)> {
    let stripes = ColourDescription::Texture(Arc::new(Texture::Checker {
        colours: [Rgb::WHITE, Rgb::BLACK],
        repeat: Vec2::splat(0.1),
    }));
    let moving = ShapeDescription {
        motion: turning(),
        ..glowing(mesh(hills(100)), Rgb::WHITE.into())
    };
    let mut balls = empty();
    for x in 0..4000 {
        let lamp = glowing(ball(x), Rgb::WHITE.into());
        balls.add_shape(lamp).expect("valid");
    }
    vec![
        ("hills", one(mesh(hills(200)))),
        ("soup", one(mesh(soup(200)))),
        (
            "glowing hills",
            one(glowing(mesh(hills(100)), Rgb::WHITE.into())),
        ),
        ("striped soup", one(glowing(mesh(soup(100)), stripes))),
        ("moving hills", one(moving)),
        ("balls", balls),
        ("placed balls", placed_often(&[])),
        ("moving balls", placed_often(&turning())),
        ("panorama", panorama()),
    ]
}

#[test]
fn predicted_scene_memory_bounds_the_peak_within_a_factor_of_4() {
    let mut wrong = vec![];
    for &backend in Backend::ALL {
        for (precision, quality) in [
            (Precision::Robust, Quality::High),
            (Precision::Fast, Quality::High),
            (Precision::Fast, Quality::Medium),
        ] {
            let options = AccelOptions {
                backend,
                precision,
                quality: Some(quality),
                threads: 2,
            };
            for (name, scene) in scenes() {
                let layout = layout(&scene).expect("no cycle of groups");
                let told = footprint::of_scene(&scene, &layout, backend);
                let before = MEMORY.current_usage();
                MEMORY.reset_peak_usage();
                let prepared = prepare(&scene, options).expect("valid");
                let own = MEMORY.peak_usage() - before;
                // Embree's memory is not seen by this process's Rust allocator.
                let of_embree = match backend.name() {
                    "embree" => prepared.scene.accel.memory(),
                    _ => 0,
                };
                let taken = (own + of_embree) as u64;
                let what = format!(
                    "{name}, {}, {}, {}: {taken} bytes taken, {told} told",
                    backend.name(),
                    precision.name(),
                    quality.name()
                );
                println!("{what}");
                if !(taken..=4 * taken).contains(&told) {
                    wrong.push(what);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
