//! Random scenes that use chosen effects: shapes of all kinds on a floor, lamps above them, and an environment.
//!
//! Measure: world units; radiance. Everything lies within 4 units of the origin.
//! Range: any set of effects; a scene may use fewer of them, never others.
//! Source: none needed.

use super::TestRng;
use super::scene::{diffuse, mirrored_octahedron, panorama, patch_scene, rectangle, sky, surface};
use etendue::internals::bsdf::conductor;
use etendue::internals::effects::{Effect, EffectSet};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3, Vec2};
use etendue::internals::scene::description::{
    BumpMapDescription, ClearCoatDescription, ColourDescription, FilmDescription,
    GeometryDescription, InstanceDescription, Keyframe, LightDescription, LightModel,
    MaterialDescription, MaterialModel, NormalMapDescription, Place, SceneDescription, WithLine,
};
use std::sync::Arc;

/// The image's size, in pixels.
pub const SIZE: (u32, u32) = (16, 12);

/// The effects with which pixels share no paths.
pub const NEVER_SHARED: [Effect; 3] = [Effect::Motion, Effect::Alpha, Effect::LightPaths];

/// A generator of scenes with random effects.
pub struct Generator(TestRng);

impl Generator {
    /// Creates a generator from a seed.
    pub fn new(seed: u64) -> Self {
        Self(TestRng::new(seed))
    }

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
            models.push(MaterialModel::Conductor {
                eta,
                k,
                roughness,
                tint: Rgb::new(1.0, 0.9, 0.8),
            });
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
                tint: Rgb::WHITE,
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
            if wanted.has(Effect::Specular) {
                models.push(MaterialModel::ThinDielectric {
                    ior: 1.5,
                    tint: colour.clone(),
                });
            }
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
                is_right_handed: false,
            });
        }
        let takes_coat = match material.model {
            MaterialModel::Conductor { roughness, .. } => roughness > 0.0,
            MaterialModel::Principled { transmission, .. } => transmission == 0.0,
            _ => false,
        };
        if takes_coat && wanted.has(Effect::Glossy) && index % 2 == 1 {
            material.clear_coat = Some(ClearCoatDescription {
                weight: 0.75,
                roughness: 0.3,
                ior: 1.5,
            });
        }
        if index % 3 == 2 && material.normal_map.take().is_some() {
            let heights = [0.2, 0.7, 0.4, 0.9].map(Rgb::grey);
            let image = Arc::new(Image::new(2, 2, heights.to_vec()).into());
            material.bump_map = Some(BumpMapDescription {
                texture: Arc::new(Texture::Image { image, scale: 1.0 }),
                height: 0.05,
            });
        }
        material
    }

    fn keys(&mut self) -> Vec<Keyframe> {
        let shift = DVec3::new(self.number(-0.4, 0.4), self.number(0.0, 0.3), 0.0);
        let turn = DAffine3::from_rotation_y(self.number(-0.5, 0.5));
        [
            (0.0, DAffine3::IDENTITY),
            (1.0, DAffine3::from_translation(shift) * turn),
        ]
        .map(|(time, transform)| Keyframe { time, transform })
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

    /// Generates a scene that may use any of the wanted effects, and no others.
    pub fn scene(&mut self, wanted: EffectSet) -> SceneDescription {
        let mut scene = patch_scene(
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
            scene.camera.is_mirrored = true;
            scene.camera.focus_distance = 5.0;
        }
        for index in 0..4 {
            scene.materials.push(self.material(index, wanted));
        }
        scene.shapes = vec![surface(
            rectangle([-3.0, 0.0, 3.0], [6.0, 0.0, 0.0], [0.0, 0.0, -6.0]),
            0.0,
        )];
        for _ in 0..4 {
            let geometry = self.geometry(wanted);
            let mut added = surface(geometry, 0.0);
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
        scene.render.light_paths = wanted.has(Effect::LightPaths).then(|| WithLine {
            value: "1".to_owned(),
            line: 1,
        });
        let shares = wanted.has(Effect::Reuse) && !NEVER_SHARED.iter().any(|&it| wanted.has(it));
        scene.render.reuse = shares.then(|| WithLine {
            value: "16".to_owned(),
            line: 1,
        });
        scene
    }

    fn instances(&mut self, scene: &mut SceneDescription, wanted: EffectSet) {
        scene.groups = vec!["pair".to_owned()];
        for _ in 0..2 {
            let mut member = surface(self.geometry(wanted), 0.0);
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
            let mut lamp = surface(lamp, 6.0);
            if wanted.has(Effect::Textures) && wanted.has(Effect::ManyLights) && self.chance(0.5) {
                lamp.emission = Some(self.colour(true));
            }
            scene.shapes.push(lamp);
            if wanted.has(Effect::ManyLights) {
                let ball = GeometryDescription::Sphere {
                    center: DVec3::new(1.5, 2.0, 1.0),
                    radius: 0.2,
                };
                scene.shapes.push(surface(ball, 4.0));
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

    /// Generates a random set of effects, of any size.
    pub fn wanted(&mut self) -> EffectSet {
        let p = self.0.uniform();
        let others = Effect::ALL.into_iter().filter(|&it| it != Effect::Reuse);
        let wanted: EffectSet = others.filter(|_| self.chance(p)).collect();
        let shares = self.chance(0.5);
        let excludes = NEVER_SHARED.into_iter().any(|it| wanted.has(it));
        match shares && (!excludes || self.chance(0.5)) {
            true => NEVER_SHARED
                .into_iter()
                .fold(wanted, EffectSet::without)
                .with(Effect::Reuse),
            false => wanted,
        }
    }
}
