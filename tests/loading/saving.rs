//! Scenes that are written as scene files and read again: the same descriptions, and the same images to the last bit.

use crate::common::generated::{Generator, SIZE};
use crate::common::scene_folder::{HEAD, SceneFolder, in_repository, picture};
use crate::gltf_builder::{one_mesh, picture as image_uri, square};
use etendue::internals::effects::Effect;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::geometry::uv_map::{UvMap, Wrap};
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::description::{
    ColourDescription, LightDescription, LightModel, MaterialModel, Place, SceneDescription,
};
use etendue::internals::scene::load::load;
use etendue::internals::scene::save::save;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The scene without what a file cannot have: places, and names that occur twice.
fn bare(scene: &SceneDescription) -> SceneDescription {
    let mut scene = scene.clone();
    scene.file = PathBuf::new();
    scene.notes = vec![];
    scene.camera.place = Place::default();
    for (index, material) in scene.materials.iter_mut().enumerate() {
        material.place = Place::default();
        material.name = index.to_string();
    }
    for shape in &mut scene.shapes {
        shape.place = Place::default();
    }
    for instance in &mut scene.instances {
        instance.place = Place::default();
    }
    for light in &mut scene.lights {
        light.place = Place::default();
    }
    for name in [
        &mut scene.render.integrator,
        &mut scene.render.sampler,
        &mut scene.render.roulette,
        &mut scene.render.light_paths,
        &mut scene.render.reuse,
        &mut scene.render.adaptive,
    ] {
        name.iter_mut().for_each(|name| name.line = 0);
    }
    scene
}

fn assert_same(name: &str, scene: &SceneDescription, other: &SceneDescription) {
    let (a, b) = (bare(scene), bare(other));
    assert_eq!(a.camera, b.camera, "{name}");
    assert_eq!(a.film, b.film, "{name}");
    assert_eq!(a.render, b.render, "{name}");
    assert!(
        a.materials == b.materials,
        "{name}: {:?}\n{:?}",
        a.materials,
        b.materials
    );
    assert!(a.shapes == b.shapes, "{name}: shapes");
    assert_eq!(a.instances, b.instances, "{name}");
    assert!(a.lights == b.lights, "{name}: lights");
    assert_eq!(a.groups, b.groups, "{name}");
}

/// Writes a scene, reads it, and compares it and its image.
fn check(name: &str, scene: &SceneDescription) {
    let folder = SceneFolder::new([("unused", "")]);
    let path = folder.path("s.toml");
    save(scene, &path).unwrap_or_else(|error| panic!("{name}: {error}"));
    let again = load(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_same(name, scene, &again);
    let image = |scene: &SceneDescription| {
        let mut scene = scene.clone();
        scene.film.size = SIZE;
        let settings = RenderSettings {
            max_bounces: Some(3),
            threads: 1,
            ..RenderSettings::new(SIZE, 1)
        };
        let image = picture(&scene, &settings);
        let pixels = image.pixels().iter();
        pixels
            .map(|p| p.to_array().map(f32::to_bits))
            .collect::<Vec<_>>()
    };
    assert!(image(scene) == image(&again), "{name}: the images differ");
}

fn scenes_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("scenes/ is readable") {
        let path = entry.expect("it is readable").path();
        if path.is_dir() {
            scenes_below(&path, found);
        } else if path.extension().is_some_and(|it| it == "toml") {
            found.push(path);
        }
    }
}

#[test]
fn saved_bundled_scenes_reload_and_render_bit_identically() {
    let mut paths = vec![];
    scenes_below(&in_repository("scenes"), &mut paths);
    assert!(paths.len() > 10);
    for path in paths {
        let scene = load(&path).expect("valid");
        check(&path.display().to_string(), &scene);
    }
}

#[test]
fn saved_generated_scenes_reload_and_render_bit_identically() {
    let mut generator = Generator::new(5);
    for index in 0..40 {
        let mut wanted = generator.wanted();
        if index == 0 {
            wanted = Effect::ALL.into_iter().collect();
        }
        let mut scene = generator.scene(wanted);
        let image = Image::new(2, 1, vec![Rgb::new(0.1, 0.2, 0.3), Rgb::grey(1.0 / 3.0)]);
        let texture = Texture::Placed {
            image: Arc::new(image.into()),
            tint: Rgb::new(0.9, 0.1, 0.7),
            uv_map: UvMap {
                rows: [[0.1, 0.2, 0.3], [-0.4, 1.0 / 3.0, 7.0]],
                wrap: [Wrap::Mirror, Wrap::Clamp],
            },
        };
        let texture = Arc::new(texture);
        let material = &mut scene.materials[1];
        material.metallic_roughness_map = Some(Arc::clone(&texture));
        material.model = MaterialModel::Principled {
            base_color: ColourDescription::Texture(texture),
            metallic: 0.3,
            roughness: 0.7,
            ior: 1.45,
            transmission: 0.0,
        };
        material.alpha = Rgb::grey(0.6).into();
        material.alpha_cutoff = Some(0.1);
        scene.render.seed = Some(u64::MAX);
        // No number of degrees has these bits.
        scene.camera.fov = 0.7_f64.next_up();
        scene.camera.is_mirrored = true;
        check(&format!("scene {index}"), &scene);
    }
}

#[test]
fn saved_extreme_values_reload_bit_identically() {
    let mut scene = load(&in_repository("scenes/cornell-box/cornell-box.toml")).expect("valid");
    let place = scene.shapes[0].place.clone();
    // As a cone of 12 degrees in single precision, whose penumbra fills it.
    for degrees in [12.0_f64, 24.0, 48.0, 55.0] {
        let cone = f64::from(degrees.to_radians() as f32);
        let model = LightModel::Spot {
            position: DVec3::new(0.0, 1.0, 1e39),
            target: DVec3::ZERO,
            intensity: Rgb::grey(2e38),
            cone,
            penumbra: cone,
        };
        scene.lights.push(LightDescription {
            place: place.clone(),
            model,
        });
    }
    let folder = SceneFolder::new([("none", "")]);
    let path = folder.path("s.toml");
    save(&scene, &path).expect("saved");
    let again = load(&path).unwrap_or_else(|error| panic!("{error}"));
    let models = |scene: &SceneDescription| -> Vec<LightModel> {
        scene
            .lights
            .iter()
            .map(|light| light.model.clone())
            .collect()
    };
    assert_eq!(models(&again), models(&scene));
}

#[test]
fn saved_mesh_without_triangles_reloads() {
    let empty = format!(
        "{HEAD}[[shape]]\ntype = \"mesh\"\npositions = []\nindices = []\n[[light]]\ntype = \"point\"\n\
         position = [0, 1, 0]\nintensity = 1\n"
    );
    let folder = SceneFolder::new([("s.toml", empty)]);
    let scene = folder.load("s.toml");
    save(&scene, &folder.path("t.toml")).expect("saved");
    let again = load(&folder.path("t.toml")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(again.shapes.len(), 1);
}

#[test]
fn saved_textured_gltf_reloads_and_renders_bit_identically() {
    let (builder, [positions, uvs, indices]) = square();
    let keys = format!(
        "\"attributes\":{{\"POSITION\":{positions},\"TEXCOORD_0\":{uvs}}},\"indices\":{indices},\"material\":0"
    );
    let scene = builder.load(&format!(
        "{},\"images\":[{{\"uri\":\"{}\"}}],\"textures\":[{{\"source\":0}}],\"materials\":[{{\"alphaMode\":\"MASK\",\
         \"pbrMetallicRoughness\":{{\"baseColorTexture\":{{\"index\":0}},\"metallicRoughnessTexture\":{{\"index\":0}}}},\
         \"normalTexture\":{{\"index\":0}},\"emissiveTexture\":{{\"index\":0}},\"emissiveFactor\":[1,0.5,0.3]}}]",
        one_mesh(&keys),
        image_uri()
    ));
    check("a glTF scene", &scene);
}

#[test]
fn failed_save_keeps_existing_files_and_leaves_no_new_ones() {
    let folder = SceneFolder::new([("s.toml", "before")]);
    let scene = Generator::new(1).scene(Effect::ALL.into_iter().collect());
    assert!(save(&scene, &folder.path("s.txt")).is_err());
    assert!(save(&scene, &folder.path("none/s.toml")).is_err());
    // A file where the folder of the meshes has to be.
    std::fs::write(folder.path("s-assets"), "mine").expect("written");
    assert!(save(&scene, &folder.path("s.toml")).is_err());
    assert_eq!(folder.listing(), ["s-assets", "s.toml"]);
    let kept = std::fs::read_to_string(folder.path("s.toml")).expect("kept");
    assert_eq!(kept, "before");
}
