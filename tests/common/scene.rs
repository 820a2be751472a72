//! Scenes built in code, and what a tiny patch of one looks like.
//!
//! Measure: world units; radiance.
//! Range: a film of 32 pixels that all look at one point, so that each is an independent replicate.
//! Source: none needed.

use etendue::accel::{AccelOptions, Backend, Precision};
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
    CameraDescription, ColourDescription, FilmDescription, GeometryDescription, LightDescription,
    MaterialDescription, MaterialModel, MeshDescription, Place, SceneDescription, ShapeDescription,
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
        roulette,
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
