//! Scenes built in code, and what a tiny patch of one looks like.
//!
//! Measure: world units; radiance.
//! Range: a film of 32 pixels that all look at one point, so that each is an independent replicate.
//! Source: none needed.

use etendue::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::geometry::texture::Texture;
use etendue::image::Image;
use etendue::integrator::Roulette;
use etendue::math::rgb::Rgb;
use etendue::math::stats::Moments;
use etendue::math::vec::{DAffine3, DMat3, DVec3};
use etendue::render::settings::RenderSettings;
use etendue::render::{Unwatched, render};
use etendue::scene::Scene;
use etendue::scene::description::{
    CameraDescription, ColourDescription, FilmDescription, GeometryDescription,
    InstanceDescription, Key, LightDescription, MaterialDescription, MaterialModel,
    MeshDescription, Place, SceneDescription, ShapeDescription,
};
use etendue::scene::prepare::prepare;
use std::sync::Arc;

const SIZE: (u32, u32) = (8, 4);

/// An empty scene of one material, seen from `eye` within 1e-4 radians around `target`.
pub fn looking(eye: DVec3, target: DVec3, model: MaterialModel) -> SceneDescription {
    let back = (eye - target).normalize();
    let (right, up) = back.any_orthonormal_pair();
    // (right, up, back) is right-handed as (x, y, z) is.
    let to_world = DAffine3::from_mat3_translation(DMat3::from_cols(right, up, back), eye);
    SceneDescription {
        film: FilmDescription {
            size: SIZE,
            filter: FilterDescription {
                kind: FilterKind::Box,
                radius: 0.5,
            },
        },
        materials: vec![MaterialDescription::new(
            "material",
            Place::default(),
            model,
        )],
        ..SceneDescription::new("test", CameraDescription::pinhole(to_world, 1e-4))
    }
}

/// Lambert's model.
pub fn diffuse(albedo: f32) -> MaterialModel {
    MaterialModel::Diffuse {
        reflectance: ColourDescription::Constant(Rgb::grey(albedo)),
    }
}

/// The same radiance from everywhere beyond the scene.
pub fn sky(radiance: Rgb) -> LightDescription {
    LightDescription::sky(Place::default(), radiance)
}

/// A shape of the scene's material that emits `radiance`, if any, on the side of its normal.
pub fn shape(geometry: GeometryDescription, radiance: f32) -> ShapeDescription {
    let emission = ColourDescription::Constant(Rgb::grey(radiance));
    ShapeDescription {
        emission: (radiance > 0.0).then_some(emission),
        ..ShapeDescription::new("shape", Place::default(), geometry)
    }
}

/// The rectangle at `corner`, with the normal u x v.
pub fn rectangle(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> GeometryDescription {
    GeometryDescription::Rectangle {
        corner: corner.into(),
        edge_u: u.into(),
        edge_v: v.into(),
    }
}

/// A convex polygon as a fan of triangles.
pub fn polygon(positions: Vec<DVec3>) -> GeometryDescription {
    let indices = (2..positions.len() as u32).map(|i| [0, i - 1, i]).collect();
    GeometryDescription::Mesh(Arc::new(MeshDescription {
        positions,
        indices,
        ..Default::default()
    }))
}

/// A scene made ready, robustly.
pub fn ready(description: &SceneDescription, backend: Backend) -> Scene {
    let options = AccelOptions {
        backend,
        precision: Precision::Robust,
        quality: Quality::default(),
        threads: 1,
    };
    prepare(description, options).expect("a valid scene").scene
}

/// What each pixel of the patch saw, with `spp` samples a pixel.
pub fn see(
    description: &SceneDescription,
    backend: Backend,
    spp: u64,
    max_bounces: Option<u32>,
    roulette: Roulette,
) -> Moments {
    let settings = RenderSettings {
        max_bounces,
        roulette: Some(roulette),
        tile_size: 1,
        ..RenderSettings::new(SIZE, spp)
    };
    let scene = ready(description, backend);
    let filter = Filter::new(&description.film.filter);
    let rendered = render(&scene, &filter, SIZE, &settings, &Unwatched).expect("valid settings");
    let tiles = rendered.film.tiles();
    Moments::of(tiles.iter().map(|t| t.pixels[0].mean(t.samples)[1]))
}

/// An octahedron with shading normals of its own, wound the wrong way round on one side.
pub fn mirrored_octahedron(center: DVec3, radius: f64) -> GeometryDescription {
    let axes = [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    let mut indices = vec![];
    for x in [0, 3] {
        for y in [1, 4] {
            for z in [2, 5] {
                indices.push([x, y, z]);
            }
        }
    }
    GeometryDescription::Mesh(Arc::new(MeshDescription {
        positions: axes.iter().map(|&axis| center + radius * axis).collect(),
        normals: axes.to_vec(),
        uvs: axes.iter().map(|axis| axis.truncate()).collect(),
        indices,
    }))
}

/// A small sky with a bright spot.
pub fn panorama() -> Texture {
    let pixel = |i: u8| match i {
        10 => Rgb::new(20.0, 18.0, 15.0),
        i => Rgb::new(0.1, 0.2, 0.01 * f32::from(i)),
    };
    Texture::Image {
        image: Arc::new(Image::new(8, 4, (0..32).map(pixel).collect())),
        scale: 0.5,
    }
}

/// The bits of a whole picture, with the film that the scene asks for.
pub fn picture(description: &SceneDescription, backend: Backend, spp: u64) -> Vec<[u32; 3]> {
    let size = description.film.size;
    let scene = ready(description, backend);
    let filter = Filter::new(&description.film.filter);
    let settings = RenderSettings::new(size, spp);
    let rendered = render(&scene, &filter, size, &settings, &Unwatched).expect("valid settings");
    let image = rendered.film.develop();
    let pixels = image.pixels().iter();
    pixels.map(|p| p.to_array().map(f32::to_bits)).collect()
}

/// A room without walls for whole pictures: a lit floor, a ball that shines, and a stone with shading normals.
pub fn gallery() -> SceneDescription {
    let mut scene = looking(DVec3::new(1.0, -4.0, 2.0), DVec3::ZERO, diffuse(0.6));
    scene.film.size = (16, 12);
    scene.camera.fov = 0.7;
    let ball = GeometryDescription::Sphere {
        center: DVec3::new(0.5, 0.5, 0.5),
        radius: 0.25,
    };
    let stone = mirrored_octahedron(DVec3::new(-0.5, -0.25, 0.5), 0.5);
    let floor = rectangle([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
    scene.shapes = vec![shape(stone, 0.0), shape(ball, 4.0), shape(floor, 0.0)];
    scene.lights = vec![sky(Rgb::new(0.1, 0.2, 0.3))];
    scene
}

/// Keys of motion.
pub fn keys<const N: usize>(keys: [(f64, DAffine3); N]) -> Vec<Key> {
    keys.map(|(time, transform)| Key { time, transform })
        .to_vec()
}

/// Evenly from one place to another, from time 0 to 1.
pub fn slide(from: DVec3, to: DVec3) -> Vec<Key> {
    keys([
        (0.0, DAffine3::from_translation(from)),
        (1.0, DAffine3::from_translation(to)),
    ])
}

/// Puts all shapes of the scene into one group, placed once.
pub fn as_instance(scene: &mut SceneDescription, transform: DAffine3, motion: Vec<Key>) {
    scene.groups = vec!["all".into()];
    scene.shapes.iter_mut().for_each(|s| s.group = Some(0));
    scene.instances = vec![InstanceDescription {
        name: "all".into(),
        place: Place::default(),
        of: 0,
        group: None,
        transform,
        motion,
    }];
}

/// The mean of a whole picture.
pub fn seen_whole(description: &SceneDescription, backend: Backend, spp: u64, seed: u64) -> f64 {
    let size = description.film.size;
    let scene = ready(description, backend);
    let filter = Filter::new(&description.film.filter);
    let settings = RenderSettings {
        seed,
        max_bounces: Some(0),
        ..RenderSettings::new(size, spp)
    };
    let rendered = render(&scene, &filter, size, &settings, &Unwatched).expect("valid settings");
    rendered.film.mean()[1]
}
