//! Scenes built in code, as those of the battery are, and renders of them or of a tiny patch.
//!
//! Measure: world units; radiance.
//! Range: a film of 32 pixels that all look at one point, so that each is an independent replicate.
//! Source: none needed.

use etendue::internals::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{
    GeometryDescription, InstanceDescription, Keyframe, MeshDescription, Place, SceneDescription,
};
use etendue::internals::scene::prepare::prepare;
use etendue_lab::battery::case::{Effort, Trial};
pub use etendue_lab::battery::patch::patch_scene;
use etendue_lab::battery::patch::{self, PatchSettings};
pub use etendue_lab::scene_builder::{diffuse, polygon, rectangle, sky, surface};
use std::sync::Arc;

/// Prepares a scene with robust precision.
pub fn ready(description: &SceneDescription, backend: Backend) -> Scene {
    prepare(description, robust(backend))
        .expect("a valid scene")
        .scene
}

/// The options of robust ray tracing, built on one thread.
pub fn robust(backend: Backend) -> AccelOptions {
    AccelOptions {
        backend,
        precision: Precision::Robust,
        quality: None,
        threads: 1,
    }
}

/// The film of a render.
pub fn film(scene: &Scene, description: &SceneDescription, settings: &RenderSettings) -> Film {
    let filter = Filter::new(&description.film.filter);
    let rendered = render(
        scene,
        &filter,
        description.film.size,
        settings,
        &NullRenderObserver,
    );
    rendered.expect("the settings are valid").film
}

/// The moments of the pixels of the patch, with `spp` samples per pixel.
pub fn see(
    description: &SceneDescription,
    backend: Backend,
    spp: u64,
    max_bounces: Option<u32>,
    roulette: Roulette,
) -> Moments {
    let integrator = IntegratorKind::default();
    see_by(integrator, description, backend, spp, max_bounces, roulette)
}

/// The moments of the pixels of the patch by an integrator.
pub fn see_by(
    integrator: IntegratorKind,
    description: &SceneDescription,
    backend: Backend,
    spp: u64,
    max_bounces: Option<u32>,
    roulette: Roulette,
) -> Moments {
    let trial = Trial {
        options: robust(backend),
        seed: 0,
        effort: Effort::Quick,
        is_cancelled: &|| false,
    };
    let patch = PatchSettings {
        spp,
        max_bounces,
        roulette,
    };
    let pixels = patch::see_by(&trial, integrator, description, patch);
    Moments::of(pixels.expect("a valid scene"))
}

/// An octahedron with shading normals; half of its triangles have reversed winding.
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

/// A small environment texture with a bright spot.
pub fn panorama() -> Texture {
    let pixel = |i: u8| match i {
        10 => Rgb::new(20.0, 18.0, 15.0),
        i => Rgb::new(0.1, 0.2, 0.01 * f32::from(i)),
    };
    Texture::Image {
        image: Arc::new(Image::new(8, 4, (0..32).map(pixel).collect()).into()),
        scale: 0.5,
    }
}

/// The bits of a whole image, rendered with the film of the scene.
pub fn picture(description: &SceneDescription, backend: Backend, spp: u64) -> Vec<[u32; 3]> {
    let size = description.film.size;
    let scene = ready(description, backend);
    let filter = Filter::new(&description.film.filter);
    let settings = RenderSettings::new(size, spp);
    let rendered =
        render(&scene, &filter, size, &settings, &NullRenderObserver).expect("valid settings");
    let image = rendered.film.develop();
    let pixels = image.pixels().iter();
    pixels.map(|p| p.to_array().map(f32::to_bits)).collect()
}

/// A scene for whole images: a lit floor, an emissive sphere, and an octahedron with shading normals.
pub fn gallery() -> SceneDescription {
    let mut scene = patch_scene(DVec3::new(1.0, -4.0, 2.0), DVec3::ZERO, diffuse(0.6));
    scene.film.size = (16, 12);
    scene.camera.fov = 0.7;
    let ball = GeometryDescription::Sphere {
        center: DVec3::new(0.5, 0.5, 0.5),
        radius: 0.25,
    };
    let stone = mirrored_octahedron(DVec3::new(-0.5, -0.25, 0.5), 0.5);
    let floor = rectangle([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
    scene.shapes = vec![surface(stone, 0.0), surface(ball, 4.0), surface(floor, 0.0)];
    scene.lights = vec![sky(Rgb::new(0.1, 0.2, 0.3))];
    scene
}

/// Motion keys from times and transforms.
pub fn keys<const N: usize>(keys: [(f64, DAffine3); N]) -> Vec<Keyframe> {
    keys.map(|(time, transform)| Keyframe { time, transform })
        .to_vec()
}

/// The motion keys of a translation at constant speed, from time 0 to 1.
pub fn slide(from: DVec3, to: DVec3) -> Vec<Keyframe> {
    keys([
        (0.0, DAffine3::from_translation(from)),
        (1.0, DAffine3::from_translation(to)),
    ])
}

/// Puts all shapes of the scene into one group, placed once.
pub fn as_instance(scene: &mut SceneDescription, transform: DAffine3, motion: Vec<Keyframe>) {
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

/// The mean of the green channel of a whole image, without bounces.
pub fn seen_whole(description: &SceneDescription, backend: Backend, spp: u64, seed: u64) -> f64 {
    let size = description.film.size;
    let scene = ready(description, backend);
    let filter = Filter::new(&description.film.filter);
    let settings = RenderSettings {
        seed,
        max_bounces: Some(0),
        ..RenderSettings::new(size, spp)
    };
    let rendered =
        render(&scene, &filter, size, &settings, &NullRenderObserver).expect("valid settings");
    rendered.film.mean()[1]
}
