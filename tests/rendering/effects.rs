//! Tests that a scene pays only for the effects that it uses, and gets the same image: every kernel that supports a scene
//! gives the image of the kernel with all effects, bit for bit, and the state of absent effects has no size.

use crate::common::generated::{Generator, SIZE};
use crate::common::scene::{diffuse, patch_scene, rectangle, sky, surface};
use crate::common::scene_folder::in_repository;
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::effects::kernel::types::{Everything, Matte};
use etendue::internals::effects::switch::{Off, On};
use etendue::internals::effects::{Effect, EffectSet, EffectState, Effects, Kernel};
use etendue::internals::film::filter::Filter;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::integrator::path::block::PathBlock;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3, Vec2};
use etendue::internals::plan::Plan;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{
    ColourDescription, Keyframe, LightDescription, LightModel, MaterialModel, Place,
    SceneDescription, ShapeDescription,
};
use etendue::internals::scene::interaction::Interaction;
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn ready(description: &SceneDescription, backend: Backend) -> Scene {
    let options = AccelOptions {
        backend,
        precision: Precision::Robust,
        quality: None,
        threads: 1,
    };
    prepare(description, options).expect("a valid scene").scene
}

/// Renders a scene with one kernel.
fn picture(description: &SceneDescription, scene: &Scene, kernel: Option<Kernel>) -> Image {
    let of_scene = RenderSettings::of_scene(description).expect("valid settings");
    // Pilots add no effect here.
    let of_scene = of_scene.with_light_paths(None).with_reuse(None);
    let settings = RenderSettings {
        kernel,
        seed: 3,
        light_paths: of_scene.light_paths,
        reuse: of_scene.reuse,
        ..RenderSettings::new(SIZE, 2)
    };
    let filter = Filter::new(&description.film.filter);
    let rendered =
        render(scene, &filter, SIZE, &settings, &NullRenderObserver).expect("the kernel fits");
    assert_eq!(rendered.rejected.count, 0, "samples that are not finite");
    rendered.film.develop()
}

/// Renders with every kernel that supports the scene, and compares bit for bit.
fn every_fitting_kernel_agrees(
    name: &str,
    description: &SceneDescription,
    backend: Backend,
) -> Scene {
    let mut description = description.clone();
    description.film.size = SIZE;
    let scene = ready(&description, backend);
    let chosen = picture(&description, &scene, None);
    for &kernel in Kernel::ALL {
        if kernel.effects().contains(scene.effects) {
            let other = picture(&description, &scene, Some(kernel));
            let bits = |image: &Image| -> Vec<[u32; 3]> {
                let pixels = image.pixels().iter();
                pixels.map(|p| p.to_array().map(f32::to_bits)).collect()
            };
            assert_eq!(bits(&chosen), bits(&other), "{name}: {}", kernel.name());
        }
    }
    scene
}

fn scenes_of_ours() -> Vec<PathBuf> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("scenes/ is readable") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "toml") {
                found.push(path);
            }
        }
    }
    let mut found = vec![];
    walk(&in_repository("scenes"), &mut found);
    found.sort();
    found
}

#[test]
fn fitting_kernels_are_bit_identical_on_repository_scenes() {
    let scenes = scenes_of_ours();
    assert!(scenes.len() >= 6);
    for path in scenes {
        let description = load(&path).unwrap_or_else(|error| panic!("{error}"));
        every_fitting_kernel_agrees(&path.display().to_string(), &description, Backend::ALL[0]);
    }
}

#[test]
fn fitting_kernels_are_bit_identical_on_200_generated_scenes() {
    let mut generator = Generator::new(1);
    let mut effects: BTreeMap<Effect, usize> = BTreeMap::new();
    let mut kernels: BTreeMap<&str, usize> = BTreeMap::new();
    for index in 0..200 {
        let wanted = generator.wanted();
        let description = generator.scene(wanted);
        let backend = Backend::ALL[index % Backend::ALL.len()];
        let scene = every_fitting_kernel_agrees(&format!("scene {index}"), &description, backend);
        for effect in scene.effects.iter() {
            *effects.entry(effect).or_default() += 1;
        }
        *kernels
            .entry(Kernel::smallest_for(scene.effects).name())
            .or_default() += 1;
        let plan = Plan::new(&description, &scene);
        let on: EffectSet = plan.on().collect();
        assert_eq!(on, scene.effects, "scene {index}");
        for finding in plan.findings.iter().filter(|finding| finding.on) {
            let has_object = finding.place.is_some() || finding.effect == Effect::ManyLights;
            assert!(has_object, "scene {index}: {finding:?} names no object");
        }
    }
    for effect in Effect::ALL {
        let count = effects.get(&effect).copied().unwrap_or(0);
        assert!(count >= 20, "{} is on in {count} scenes", effect.name());
    }
    for kernel in Kernel::ALL {
        assert!(
            kernels.contains_key(kernel.name()),
            "{} never ran: {kernels:?}",
            kernel.name()
        );
    }
}

#[test]
fn kernel_lacking_a_required_effect_is_rejected() {
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    scene.lights = vec![sky(Rgb::WHITE)];
    let ready = ready(&scene, Backend::ALL[0]);
    let settings = RenderSettings {
        kernel: Some(Kernel::Matte),
        ..RenderSettings::new(SIZE, 1)
    };
    let filter = Filter::new(&scene.film.filter);
    let error = render(&ready, &filter, SIZE, &settings, &NullRenderObserver)
        .expect_err("the kernel has no environment");
    assert!(error.to_string().contains("environment"), "{error}");
}

#[test]
fn state_of_absent_effects_has_zero_size() {
    assert!(Matte::SET.len() == 2 && Everything::SET == EffectSet::ALL);
    assert_eq!(size_of::<EffectState<Off, [f32; 3]>>(), 0);
    assert_eq!(size_of::<EffectState<On, [f32; 3]>>(), 12);
    // The eta scales of sixteen paths, their last normals, the ratios of their densities to those of light paths, and whether
    // they are caustics. The time belongs to Embree's packet, which has it always.
    assert_eq!(
        size_of::<PathBlock<Everything>>() - size_of::<PathBlock<Matte>>(),
        64 + 192 + 64 + 64
    );
    // Texture coordinate, shading normal and whether it is the geometric one; also a multiple of 16 bytes.
    assert_eq!(
        size_of::<Interaction<Everything>>() - size_of::<Interaction<Matte>>(),
        32
    );
}

#[test]
fn no_op_scene_features_require_no_effects() {
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    let grey = Rgb::grey(0.3);
    let one_colour = ColourDescription::Texture(Arc::new(Texture::Checker {
        colours: [grey; 2],
        repeat: Vec2::ONE,
    }));
    let white = ColourDescription::Texture(Arc::new(Texture::Image {
        image: Arc::new(Image::filled(2, 2, Rgb::WHITE).into()),
        scale: 1.0,
    }));
    scene.materials[0].model = MaterialModel::Diffuse {
        reflectance: one_colour.clone(),
    };
    scene.materials[0].alpha = white;
    let key = |time| Keyframe {
        time,
        transform: DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.3)),
    };
    scene.camera.shutter = [0.0, 1.0];
    scene.camera.motion = vec![key(0.0), key(1.0)];
    let mut still = ShapeDescription {
        motion: vec![key(0.0), key(0.5), key(1.0)],
        ..surface(
            rectangle([-1.0, -1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
            0.0,
        )
    };
    still.emission = Some(ColourDescription::Constant(Rgb::BLACK));
    scene.shapes = vec![still];
    let position = DVec3::Z;
    let intensity = Rgb::BLACK;
    scene.lights = vec![
        sky(Rgb::BLACK),
        LightDescription {
            place: Place::default(),
            model: LightModel::Point {
                position,
                intensity,
            },
        },
    ];
    let plain = ready(&scene, Backend::ALL[0]);
    assert_eq!(plain.effects, EffectSet::NONE);
    let plan = Plan::new(&scene, &plain);
    let why = |effect| {
        let finding = plan
            .findings
            .iter()
            .find(|finding| finding.effect == effect);
        finding.expect("every effect has a finding").why.clone()
    };
    for (effect, words) in [
        (Effect::Textures, "one colour"),
        (Effect::Alpha, "alpha of 1"),
        (Effect::Motion, "does not move"),
        (Effect::Environment, "is black"),
        (Effect::DeltaLights, "is black"),
        (Effect::AreaLights, "is black"),
    ] {
        assert!(
            why(effect).contains(words),
            "{}: {}",
            effect.name(),
            why(effect)
        );
    }
    // An environment map of one colour becomes a constant environment.
    scene.lights = vec![LightDescription {
        place: Place::default(),
        model: LightModel::Environment {
            radiance: one_colour,
            to_world: DMat3::IDENTITY,
        },
    }];
    let sky = ready(&scene, Backend::ALL[0]);
    assert_eq!(sky.effects, EffectSet::NONE.with(Effect::Environment));
    assert_eq!((sky.environment, sky.lights.len()), (grey, 0));
}
