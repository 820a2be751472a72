//! Writes the tables of a scene file.
//!
//! Measure: as in docs/scene-format.md.
//! Range: any valid description; see `mod.rs`.
//! Source: docs/scene-format.md. Tested in `tests/loading/saving.rs`.

use super::assets::Assets;
use super::colour::{colour, constant_colour, keys};
use super::text::{Text, angle, list, motion, number, rgb, single, string, transform, vec3};
use crate::error::Result;
use crate::film::filter::FilterKind;
use crate::math::vec::DAffine3;
use crate::scene::description::{
    GeometryDescription, InstanceDescription, Keyframe, LightModel, MaterialDescription,
    MaterialModel, SceneDescription, ShapeDescription,
};
use std::collections::HashSet;

/// A scene file in progress.
pub struct Sections<'a> {
    scene: &'a SceneDescription,
    assets: &'a mut Assets,
    text: Text,
    materials: Vec<String>,
    groups: Vec<String>,
}

impl<'a> Sections<'a> {
    pub fn new(scene: &'a SceneDescription, assets: &'a mut Assets) -> Self {
        let materials = scene.materials.iter().map(|material| &material.name);
        Self {
            scene,
            assets,
            text: Text::default(),
            materials: unique(materials),
            groups: unique(&scene.groups),
        }
    }

    /// Returns the whole file.
    ///
    /// # Errors
    /// If a mesh or an image cannot be written.
    pub fn text(mut self) -> Result<String> {
        self.text.entry("version", 1);
        for note in &self.scene.notes {
            self.text.comment(&format!("note: {note}"));
        }
        self.camera();
        self.film();
        self.render();
        let scene = self.scene;
        for (index, material) in scene.materials.iter().enumerate() {
            self.material(material, index)?;
        }
        for shape in &scene.shapes {
            self.shape(shape)?;
        }
        // A group without members has no name in a file.
        let members = scene.shapes.iter().map(|it| it.group);
        let members = members.chain(scene.instances.iter().map(|it| it.group));
        let filled: HashSet<usize> = members.flatten().collect();
        for instance in scene.instances.iter().filter(|it| filled.contains(&it.of)) {
            self.instance(instance);
        }
        for light in &scene.lights {
            self.light(&light.model)?;
        }
        Ok(self.text.finish())
    }

    fn camera(&mut self) {
        let camera = &self.scene.camera;
        self.text.table("[camera]");
        if camera.motion.is_empty() {
            self.text.entry("transform", transform(&camera.to_world));
        } else {
            self.text.entry("motion", motion(&camera.motion));
        }
        if camera.is_mirrored {
            self.text.entry("mirrored", true);
        }
        self.text.entry("fov", angle(camera.fov));
        if camera.lens_radius != 0.0 {
            self.text.entry("lens_radius", number(camera.lens_radius));
        }
        let focus = number(camera.focus_distance);
        self.text.entry("focus_distance", focus);
        if camera.shutter != [0.0; 2] {
            self.text.entry("shutter", list(camera.shutter.map(number)));
        }
    }

    fn film(&mut self) {
        let film = &self.scene.film;
        let (width, height) = film.size;
        self.text.table("[film]");
        self.text.entry("size", format!("[{width}, {height}]"));
        let kind = FilterKind::ALL
            .iter()
            .find(|(_, kind)| *kind == film.filter.kind);
        let kind = string(kind.map_or("gaussian", |(name, _)| name));
        let radius = number(film.filter.radius);
        let filter = format!("{{ type = {kind}, radius = {radius} }}");
        self.text.entry("filter", filter);
    }

    fn render(&mut self) {
        let render = &self.scene.render;
        self.text.table("[render]");
        let names = [
            ("integrator", &render.integrator),
            ("sampler", &render.sampler),
            ("roulette", &render.roulette),
            ("light_paths", &render.light_paths),
            ("reuse", &render.reuse),
            ("adaptive", &render.adaptive),
        ];
        for (key, name) in names {
            if let Some(name) = name {
                self.text.entry(key, string(&name.value));
            }
        }
        let wholes = [
            ("spp", render.spp),
            ("max_bounces", render.max_bounces.map(u64::from)),
            ("seed", render.seed),
        ];
        for (key, whole) in wholes {
            if let Some(whole) = whole {
                self.text.entry(key, whole);
            }
        }
        let numbers = [
            ("occlusion_distance", render.occlusion_distance),
            ("cache_error", render.cache_error),
        ];
        for (key, value) in numbers {
            if let Some(value) = value {
                self.text.entry(key, number(value));
            }
        }
    }

    fn material(&mut self, material: &MaterialDescription, index: usize) -> Result<()> {
        self.text.table("[[material]]");
        self.text.entry("name", string(&self.materials[index]));
        self.model(&material.model)?;
        if let Some(map) = &material.metallic_roughness_map
            && matches!(material.model, MaterialModel::Principled { .. })
        {
            let map = format!("{{ {} }}", keys(map, self.assets)?);
            self.text.entry("metallic_roughness_map", map);
        }
        if let Some(coat) = &material.clear_coat {
            let numbers = [coat.weight, coat.roughness, coat.ior].map(single);
            let [weight, roughness, ior] = numbers;
            let coat = format!("{{ weight = {weight}, roughness = {roughness}, ior = {ior} }}");
            self.text.entry("clear_coat", coat);
        }
        if material.alpha.constant() != Some(crate::math::rgb::Rgb::WHITE) {
            let alpha = colour(&material.alpha, self.assets)?;
            self.text.entry("alpha", alpha);
        }
        if let Some(cutoff) = material.alpha_cutoff {
            self.text.entry("alpha_cutoff", single(cutoff));
        }
        if let Some(map) = &material.normal_map {
            let texture = keys(&map.texture, self.assets)?;
            let hand = if map.is_right_handed {
                ", right_handed = true"
            } else {
                ""
            };
            let strength = single(map.strength);
            let map = format!("{{ {texture}, strength = {strength}{hand} }}");
            self.text.entry("normal_map", map);
        }
        if let Some(map) = &material.bump_map {
            let texture = keys(&map.texture, self.assets)?;
            let map = format!("{{ {texture}, height = {} }}", single(map.height));
            self.text.entry("bump_map", map);
        }
        if !material.two_sided {
            self.text.entry("two_sided", false);
        }
        Ok(())
    }

    fn model(&mut self, model: &MaterialModel) -> Result<()> {
        let (text, assets) = (&mut self.text, &mut *self.assets);
        match model {
            MaterialModel::Diffuse { reflectance } => {
                text.entry("type", string("diffuse"));
                text.entry("reflectance", colour(reflectance, assets)?);
            }
            MaterialModel::Mirror { reflectance } => {
                text.entry("type", string("mirror"));
                text.entry("reflectance", colour(reflectance, assets)?);
            }
            MaterialModel::Conductor {
                eta,
                k,
                roughness,
                tint,
            } => {
                text.entry("type", string("conductor"));
                text.entry("eta", rgb(*eta));
                text.entry("k", rgb(*k));
                text.entry("roughness", single(*roughness));
                text.entry("tint", rgb(*tint));
            }
            MaterialModel::Phong {
                diffuse,
                specular,
                exponent,
            } => {
                text.entry("type", string("phong"));
                text.entry("diffuse", colour(diffuse, assets)?);
                text.entry("specular", colour(specular, assets)?);
                text.entry("exponent", single(*exponent));
            }
            MaterialModel::Plastic {
                reflectance,
                ior,
                roughness,
            } => {
                text.entry("type", string("plastic"));
                text.entry("reflectance", colour(reflectance, assets)?);
                text.entry("ior", single(*ior));
                text.entry("roughness", single(*roughness));
            }
            MaterialModel::Dielectric {
                ior,
                roughness,
                tint,
            } => {
                text.entry("type", string("dielectric"));
                text.entry("ior", single(*ior));
                text.entry("roughness", single(*roughness));
                text.entry("tint", colour(tint, assets)?);
            }
            MaterialModel::ThinDielectric { ior, tint } => {
                text.entry("type", string("thin_dielectric"));
                text.entry("ior", single(*ior));
                text.entry("tint", colour(tint, assets)?);
            }
            MaterialModel::Principled {
                base_color,
                metallic,
                roughness,
                ior,
                transmission,
            } => {
                text.entry("type", string("principled"));
                text.entry("base_color", colour(base_color, assets)?);
                text.entry("metallic", single(*metallic));
                text.entry("roughness", single(*roughness));
                text.entry("ior", single(*ior));
                text.entry("transmission", single(*transmission));
            }
        }
        Ok(())
    }

    fn shape(&mut self, shape: &ShapeDescription) -> Result<()> {
        self.text.table("[[shape]]");
        self.text.entry("name", string(&shape.name));
        self.geometry(&shape.geometry)?;
        let material = string(&self.materials[shape.material]);
        self.text.entry("material", material);
        if let Some(emission) = &shape.emission {
            let emission = colour(emission, self.assets)?;
            self.text.entry("emission", emission);
        }
        if shape.two_sided_emission {
            self.text.entry("two_sided_emission", true);
        }
        self.place(shape.group, &shape.transform, &shape.motion);
        Ok(())
    }

    fn geometry(&mut self, geometry: &GeometryDescription) -> Result<()> {
        let text = &mut self.text;
        match geometry {
            // A PLY file has at least one face.
            GeometryDescription::Mesh(mesh) if mesh.indices.is_empty() => {
                text.entry("type", string("mesh"));
                text.entry("positions", "[]");
                text.entry("indices", "[]");
            }
            GeometryDescription::Mesh(mesh) => {
                text.entry("type", string("ply"));
                text.entry("file", string(&self.assets.mesh(mesh)?));
            }
            GeometryDescription::Sphere { center, radius } => {
                text.entry("type", string("sphere"));
                text.entry("center", vec3(*center));
                text.entry("radius", number(*radius));
            }
            GeometryDescription::Rectangle {
                corner,
                edge_u,
                edge_v,
            } => {
                text.entry("type", string("rectangle"));
                text.entry("corner", vec3(*corner));
                text.entry("edge_u", vec3(*edge_u));
                text.entry("edge_v", vec3(*edge_v));
            }
            GeometryDescription::Disk {
                center,
                normal,
                radius,
            } => {
                text.entry("type", string("disk"));
                text.entry("center", vec3(*center));
                text.entry("normal", vec3(*normal));
                text.entry("radius", number(*radius));
            }
            GeometryDescription::Box { min, max } => {
                text.entry("type", string("box"));
                text.entry("min", vec3(*min));
                text.entry("max", vec3(*max));
            }
        }
        Ok(())
    }

    fn instance(&mut self, instance: &InstanceDescription) {
        self.text.table("[[instance]]");
        self.text.entry("name", string(&instance.name));
        self.text.entry("of", string(&self.groups[instance.of]));
        self.place(instance.group, &instance.transform, &instance.motion);
    }

    fn place(&mut self, group: Option<usize>, to_group: &DAffine3, keys: &[Keyframe]) {
        if let Some(group) = group {
            self.text.entry("group", string(&self.groups[group]));
        }
        if *to_group != DAffine3::IDENTITY {
            self.text.entry("transform", transform(to_group));
        }
        if !keys.is_empty() {
            self.text.entry("motion", motion(keys));
        }
    }

    fn light(&mut self, model: &LightModel) -> Result<()> {
        let (text, assets) = (&mut self.text, &mut *self.assets);
        text.table("[[light]]");
        match model {
            LightModel::Environment { radiance, to_world } => {
                text.entry("type", string("environment"));
                text.entry("radiance", colour(radiance, assets)?);
                let to_world = DAffine3::from_mat3(*to_world);
                if to_world != DAffine3::IDENTITY {
                    text.entry("transform", transform(&to_world));
                }
            }
            LightModel::Point {
                position,
                intensity,
            } => {
                text.entry("type", string("point"));
                text.entry("position", vec3(*position));
                text.entry("intensity", constant_colour(*intensity));
            }
            LightModel::Spot {
                position,
                target,
                intensity,
                cone,
                penumbra,
            } => {
                text.entry("type", string("spot"));
                text.entry("position", vec3(*position));
                text.entry("target", vec3(*target));
                text.entry("intensity", constant_colour(*intensity));
                text.entry("cone", angle(*cone));
                text.entry("penumbra", angle(*penumbra));
            }
            LightModel::Distant {
                direction,
                irradiance,
            } => {
                text.entry("type", string("distant"));
                text.entry("direction", vec3(*direction));
                text.entry("irradiance", constant_colour(*irradiance));
            }
        }
        Ok(())
    }
}

/// Numbers the names that occur again.
fn unique<'a>(names: impl IntoIterator<Item = &'a String>) -> Vec<String> {
    let mut taken = HashSet::new();
    let unique = |name: &String| {
        let mut next = name.clone();
        let mut number = 2;
        while !taken.insert(next.clone()) {
            next = format!("{name} ({number})");
            number += 1;
        }
        next
    };
    names.into_iter().map(unique).collect()
}
