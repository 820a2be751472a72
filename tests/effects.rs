//! A scene pays only for the effects that it calls for, and gets the same picture: every kernel that fits a scene gives
//! the image of the kernel with everything, bit for bit, and state of absent effects has no size.

mod common;

use common::TestRng;
use common::scene::{diffuse, looking, mirrored_octahedron, panorama, rectangle, shape, sky};
use common::scene_folder::in_repository;
use etendue::accel::{AccelOptions, Backend, Precision, Quality};
use etendue::bsdf::conductor;
use etendue::effects::kernel::types::{Everything, Matte};
use etendue::effects::switch::{Off, On};
use etendue::effects::{Effect, EffectSet, Effects, Kernel, State};
use etendue::film::filter::Filter;
use etendue::geometry::texture::Texture;
use etendue::image::Image;
use etendue::integrator::path::PathState;
use etendue::math::rgb::Rgb;
use etendue::math::vec::{DAffine3, DMat3, DVec3, Vec2};
use etendue::plan::Plan;
use etendue::render::settings::RenderSettings;
use etendue::render::{Unwatched, render};
use etendue::scene::Scene;
use etendue::scene::description::{
    ColourDescription, FilmDescription, GeometryDescription, InstanceDescription, Key,
    LightDescription, LightModel, MaterialDescription, MaterialModel, NormalMapDescription, Place,
    SceneDescription, ShapeDescription,
};
use etendue::scene::interaction::Interaction;
use etendue::scene::load::load;
use etendue::scene::prepare::prepare;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const SIZE: (u32, u32) = (16, 12);

fn ready(description: &SceneDescription, backend: Backend) -> Scene {
    let options = AccelOptions {
        backend,
        precision: Precision::Robust,
        quality: Quality::default(),
        threads: 1,
    };
    prepare(description, options).expect("a valid scene").scene
}

/// The picture that one kernel makes.
fn picture(description: &SceneDescription, scene: &Scene, kernel: Option<Kernel>) -> Image {
    let settings = RenderSettings {
        kernel,
        seed: 3,
        ..RenderSettings::new(SIZE, 2)
    };
    let filter = Filter::new(&description.film.filter);
    let rendered = render(scene, &filter, SIZE, &settings, &Unwatched).expect("the kernel fits");
    assert_eq!(rendered.rejected.count, 0, "not finite");
    rendered.film.develop()
}

/// Renders with every kernel that fits, and compares bit for bit.
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
            let path = entry.expect("as is its entry").path();
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
fn every_kernel_that_fits_a_scene_of_ours_gives_the_same_picture() {
    let scenes = scenes_of_ours();
    assert!(scenes.len() >= 6);
    for path in scenes {
        let description = load(&path).unwrap_or_else(|error| panic!("{error}"));
        every_fitting_kernel_agrees(&path.display().to_string(), &description, Backend::ALL[0]);
    }
}

/// Scenes with random effects.
struct Generator(TestRng);

impl Generator {
    fn chance(&mut self, p: f32) -> bool {
        self.0.uniform() < p
    }

    fn number(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.uniform())
    }

    fn index(&mut self, count: usize) -> usize {
        (self.0.uniform() * count as f32) as usize
    }

    fn colour(&mut self, textured: bool) -> ColourDescription {
        let mut rgb = || Rgb::new(self.0.uniform(), self.0.uniform(), self.0.uniform());
        let colours = [rgb(), rgb()];
        if !textured {
            return ColourDescription::Constant(colours[0]);
        }
        let repeat = Vec2::new(3.0, 2.0);
        ColourDescription::Texture(Arc::new(Texture::Checker { colours, repeat }))
    }

    fn model(&mut self, wanted: EffectSet) -> MaterialModel {
        let textured = wanted.has(Effect::Textures) && self.chance(0.7);
        let colour = self.colour(textured);
        let (eta, k) = conductor::preset("gold").expect("a preset");
        let roughness = 0.2 + 0.5 * self.0.uniform();
        let mut models = vec![];
        if wanted.has(Effect::Glossy) {
            models.push(MaterialModel::Conductor { eta, k, roughness });
            models.push(MaterialModel::Plastic {
                reflectance: colour.clone(),
                ior: 1.5,
                roughness,
            });
            models.push(MaterialModel::Phong {
                diffuse: ColourDescription::Constant(Rgb::grey(0.4)),
                specular: ColourDescription::Constant(Rgb::grey(0.5)),
                exponent: 40.0,
            });
        }
        if wanted.has(Effect::Specular) {
            models.push(MaterialModel::Mirror {
                reflectance: colour.clone(),
            });
            models.push(MaterialModel::Conductor {
                eta,
                k,
                roughness: 0.0,
            });
        }
        if wanted.has(Effect::Transmission) {
            models.push(MaterialModel::Dielectric {
                ior: 1.5,
                roughness: if wanted.has(Effect::Glossy) {
                    roughness
                } else {
                    0.0
                },
                tint: colour.clone(),
            });
            if wanted.has(Effect::Glossy) {
                models.push(MaterialModel::Principled {
                    base_color: colour.clone(),
                    metallic: 0.2,
                    roughness,
                    ior: 1.4,
                    transmission: 0.5,
                });
            }
        }
        if models.is_empty() || self.chance(0.4) {
            return MaterialModel::Diffuse {
                reflectance: colour,
            };
        }
        models.swap_remove(self.index(models.len()))
    }

    fn material(&mut self, index: usize, wanted: EffectSet) -> MaterialDescription {
        let model = self.model(wanted);
        let mut material = MaterialDescription::new(format!("m{index}"), Place::default(), model);
        if wanted.has(Effect::Alpha) && self.chance(0.6) {
            material.alpha = self.colour(wanted.has(Effect::Textures));
        }
        let opaque = !wanted.has(Effect::Transmission);
        material.two_sided = !(wanted.has(Effect::OneSided) && opaque && self.chance(0.6));
        if wanted.has(Effect::NormalMaps) {
            let repeat = Vec2::splat(4.0);
            let colours = [Rgb::new(0.7, 0.5, 0.9), Rgb::new(0.4, 0.6, 0.9)];
            material.normal_map = Some(NormalMapDescription {
                texture: Arc::new(Texture::Checker { colours, repeat }),
                strength: 1.0,
            });
        }
        material
    }

    fn keys(&mut self) -> Vec<Key> {
        let shift = DVec3::new(self.number(-0.4, 0.4), self.number(0.0, 0.3), 0.0);
        let turn = DAffine3::from_rotation_y(self.number(-0.5, 0.5));
        [
            (0.0, DAffine3::IDENTITY),
            (1.0, DAffine3::from_translation(shift) * turn),
        ]
        .map(|(time, transform)| Key { time, transform })
        .to_vec()
    }

    fn geometry(&mut self, wanted: EffectSet) -> GeometryDescription {
        let at = DVec3::new(
            self.number(-1.2, 1.2),
            self.number(0.3, 1.2),
            self.number(-1.0, 1.0),
        );
        match self.index(if wanted.has(Effect::ShadingNormals) {
            4
        } else {
            3
        }) {
            0 => GeometryDescription::Sphere {
                center: at,
                radius: 0.4,
            },
            1 => GeometryDescription::Disk {
                center: at,
                normal: DVec3::new(0.3, 1.0, 0.5),
                radius: 0.5,
            },
            2 => GeometryDescription::Box {
                min: at - DVec3::splat(0.3),
                max: at + DVec3::splat(0.3),
            },
            _ => mirrored_octahedron(at, 0.5),
        }
    }

    fn light(&mut self, index: usize) -> LightDescription {
        let position = DVec3::new(self.number(-1.0, 1.0), 3.0, self.number(-1.0, 2.0));
        let model = match index % 3 {
            0 => LightModel::Point {
                position,
                intensity: Rgb::grey(3.0),
            },
            1 => LightModel::Spot {
                position,
                target: DVec3::ZERO,
                intensity: Rgb::grey(9.0),
                cone: 0.5,
                penumbra: 0.2,
            },
            _ => LightModel::Distant {
                direction: DVec3::new(0.3, -1.0, -0.2),
                irradiance: Rgb::grey(2.0),
            },
        };
        LightDescription {
            place: Place::default(),
            model,
        }
    }

    /// A scene that may call for any of the wanted effects, and for nothing else.
    fn scene(&mut self, wanted: EffectSet) -> SceneDescription {
        let mut scene = looking(
            DVec3::new(0.0, 1.5, 5.0),
            DVec3::new(0.0, 0.5, 0.0),
            diffuse(0.7),
        );
        scene.film = FilmDescription {
            size: SIZE,
            ..scene.film
        };
        scene.camera.fov = 0.7;
        scene.camera.shutter = [0.0, 1.0];
        if wanted.has(Effect::Lens) {
            scene.camera.lens_radius = 0.1;
            scene.camera.focus_distance = 5.0;
        }
        for index in 0..4 {
            scene.materials.push(self.material(index, wanted));
        }
        scene.shapes = vec![shape(
            rectangle([-3.0, 0.0, 3.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0]),
            0.0,
        )];
        for _ in 0..4 {
            let geometry = self.geometry(wanted);
            let mut added = shape(geometry, 0.0);
            added.material = 1 + self.index(4);
            if wanted.has(Effect::Motion) && self.chance(0.4) {
                added.motion = self.keys();
            }
            scene.shapes.push(added);
        }
        if wanted.has(Effect::Instances) {
            self.instances(&mut scene, wanted);
        }
        self.lamps(&mut scene, wanted);
        scene
    }

    fn instances(&mut self, scene: &mut SceneDescription, wanted: EffectSet) {
        scene.groups = vec!["pair".to_owned()];
        for _ in 0..2 {
            let mut member = shape(self.geometry(wanted), 0.0);
            member.group = Some(0);
            member.material = 1 + self.index(4);
            scene.shapes.push(member);
        }
        for index in 0..3 {
            let scale = DVec3::new(self.number(0.3, 0.8), self.number(0.3, 0.8), -0.5);
            let shift = DVec3::new(self.number(-2.0, 2.0), 0.2, self.number(-1.0, 1.0));
            scene.instances.push(InstanceDescription {
                name: format!("instance {index}"),
                place: Place::default(),
                of: 0,
                group: None,
                transform: DAffine3::from_scale_rotation_translation(
                    scale,
                    glam::DQuat::from_rotation_y(self.number(0.0, 6.0)),
                    shift,
                ),
                motion: if wanted.has(Effect::Motion) && index == 0 {
                    self.keys()
                } else {
                    vec![]
                },
            });
        }
    }

    fn lamps(&mut self, scene: &mut SceneDescription, wanted: EffectSet) {
        if wanted.has(Effect::AreaLights) {
            let lamp = rectangle([-0.5, 3.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
            let mut lamp = shape(lamp, 6.0);
            if wanted.has(Effect::Textures) && wanted.has(Effect::ManyLights) && self.chance(0.5) {
                lamp.emission = Some(self.colour(true));
            }
            scene.shapes.push(lamp);
            if wanted.has(Effect::ManyLights) {
                let ball = GeometryDescription::Sphere {
                    center: DVec3::new(1.5, 2.0, 1.0),
                    radius: 0.2,
                };
                scene.shapes.push(shape(ball, 4.0));
            }
        }
        if wanted.has(Effect::Environment) {
            scene.lights.push(sky(Rgb::new(0.2, 0.3, 0.4)));
        }
        if wanted.has(Effect::EnvironmentMap) {
            scene.lights.push(LightDescription {
                place: Place::default(),
                model: LightModel::Environment {
                    radiance: ColourDescription::Texture(Arc::new(panorama())),
                    to_world: DMat3::from_rotation_y(0.4),
                },
            });
        }
        if wanted.has(Effect::DeltaLights) {
            let first = self.index(3);
            let count = if wanted.has(Effect::ManyLights) { 2 } else { 1 };
            for index in 0..count {
                let light = self.light(first + index);
                scene.lights.push(light);
            }
        }
    }

    /// Sets of effects of all sizes.
    fn wanted(&mut self) -> EffectSet {
        let p = self.0.uniform();
        Effect::ALL.into_iter().filter(|_| self.chance(p)).collect()
    }
}

#[test]
fn every_kernel_that_fits_gives_the_same_picture_of_200_generated_scenes() {
    let mut generator = Generator(TestRng::new(1));
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
fn a_scene_is_not_rendered_by_a_kernel_that_lacks_one_of_its_effects() {
    let mut scene = looking(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    scene.lights = vec![sky(Rgb::WHITE)];
    let ready = ready(&scene, Backend::ALL[0]);
    let settings = RenderSettings {
        kernel: Some(Kernel::Matte),
        ..RenderSettings::new(SIZE, 1)
    };
    let filter = Filter::new(&scene.film.filter);
    let error = render(&ready, &filter, SIZE, &settings, &Unwatched).expect_err("no sky");
    assert!(error.to_string().contains("environment"), "{error}");
}

#[test]
fn state_of_absent_effects_has_no_size() {
    assert!(Matte::SET.len() == 1 && Everything::SET == EffectSet::ALL);
    assert_eq!(size_of::<State<Off, [f32; 3]>>(), 0);
    assert_eq!(size_of::<State<On, [f32; 3]>>(), 12);
    // A time and the scale of roulette, in a structure whose size goes in steps of a vector's 16 bytes.
    assert_eq!(
        size_of::<PathState<Everything>>() - size_of::<PathState<Matte>>(),
        16
    );
    // A texture coordinate, and whether the shading normal is the geometric one, likewise.
    assert_eq!(
        size_of::<Interaction<Everything>>() - size_of::<Interaction<Matte>>(),
        16
    );
}

#[test]
fn what_says_nothing_is_folded_away() {
    let mut scene = looking(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    let grey = Rgb::grey(0.3);
    let one_colour = ColourDescription::Texture(Arc::new(Texture::Checker {
        colours: [grey; 2],
        repeat: Vec2::ONE,
    }));
    let white = ColourDescription::Texture(Arc::new(Texture::Image {
        image: Arc::new(Image::filled(2, 2, Rgb::WHITE)),
        scale: 1.0,
    }));
    scene.materials[0].model = MaterialModel::Diffuse {
        reflectance: one_colour.clone(),
    };
    scene.materials[0].alpha = white;
    let key = |time| Key {
        time,
        transform: DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.3)),
    };
    scene.camera.shutter = [0.0, 1.0];
    scene.camera.motion = vec![key(0.0), key(1.0)];
    let mut still = ShapeDescription {
        motion: vec![key(0.0), key(0.5), key(1.0)],
        ..shape(
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
        finding.expect("every effect has one").why.clone()
    };
    for (effect, words) in [
        (Effect::Textures, "one colour"),
        (Effect::Alpha, "alpha of 1"),
        (Effect::Motion, "stands still"),
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
    // An environment of one colour is a constant one.
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
