//! The objects of a scene that can be the reason for an effect, in the order in which they are considered.
//!
//! Measure: none.
//! Range: any scene that `load` lets through; objects that are not placed in the scene are omitted.
//! Source: none needed. Tested in `cli/tests/command/plan.rs`.

use crate::effects::{Effect, EffectSet};
use crate::scene::description::{
    ColourDescription, GeometryDescription, LightModel, MaterialDescription, MaterialModel, Place,
    SceneDescription, ShapeDescription,
};
use crate::scene::{effects, placement};

/// An object of a scene with the effects that it requires.
#[derive(Debug)]
pub struct PlannedObject {
    /// The name of the object in a sentence.
    pub name: String,
    /// The location of the object in the scene file.
    pub place: Place,
    /// The effects that the object requires.
    pub calls_for: EffectSet,
    /// The effects in the description of the object, including those without any result.
    pub written: EffectSet,
}

impl PlannedObject {
    /// The property of the object that requires an effect.
    pub fn what(&self, effect: Effect) -> &'static str {
        match effect {
            Effect::ShadingNormals if self.calls_for.has(Effect::NormalMaps) => {
                "has a normal or bump map"
            }
            Effect::ShadingNormals => "has shading normals",
            Effect::Textures => "has a colour that varies over its surface",
            Effect::NormalMaps => "has a normal or bump map",
            Effect::Alpha => "has an alpha below 1",
            Effect::OneSided => "is not two_sided",
            Effect::Glossy => "is glossy",
            Effect::Specular => "is specular",
            Effect::Transmission => "transmits light",
            Effect::Lens => "has a lens",
            Effect::Motion => "moves while the shutter is open",
            Effect::Environment => "emits",
            Effect::EnvironmentMap => "varies with direction",
            Effect::DeltaLights => "has no size",
            Effect::AreaLights => "emits",
            Effect::ManyLights => "is one of several lights",
            Effect::Instances if self.calls_for.has(Effect::Motion) => "moves",
            Effect::Instances if self.written.has(Effect::Instances) => "places a group",
            Effect::Instances => "is stretched by its keyframes",
            Effect::LightPaths => "requests light paths",
            Effect::Reuse => "requests shared paths",
        }
    }
}

/// Lists all objects that are in the scene: the camera, materials in the order of their use by shapes, shapes,
/// instances, lights.
pub fn objects(description: &SceneDescription) -> Vec<PlannedObject> {
    let shutter = description.camera.shutter;
    let none = EffectSet::NONE;
    let mut objects = vec![PlannedObject {
        name: "the camera".to_owned(),
        place: description.camera.place.clone(),
        calls_for: effects::of_camera(&description.camera),
        written: none.with_if(Effect::Motion, !description.camera.motion.is_empty()),
    }];
    // A scene whose layout fails is not prepared, and has no plan.
    let layout = placement::layout(description).unwrap_or_default();
    let shapes: Vec<&ShapeDescription> = layout
        .placed_shapes(description.shapes.len())
        .map(|shape| &description.shapes[shape])
        .collect();
    let mut seen = vec![false; description.materials.len()];
    for shape in &shapes {
        if !std::mem::replace(&mut seen[shape.material], true) {
            let material = &description.materials[shape.material];
            objects.push(PlannedObject {
                name: format!("material `{}`", material.name),
                place: material.place.clone(),
                calls_for: effects::of_material(material),
                written: written_in_material(material),
            });
        }
    }
    objects.extend(shapes.iter().map(|shape| PlannedObject {
        name: format!("shape `{}`", shape.name),
        place: shape.place.clone(),
        calls_for: effects::of_shape(shape, shutter),
        written: written_in_shape(shape),
    }));
    objects.extend(layout.instances.iter().map(|&instance| {
        let instance = &description.instances[instance];
        PlannedObject {
            name: format!("instance `{}`", instance.name),
            place: instance.place.clone(),
            calls_for: effects::of_instance(instance, shutter),
            written: none
                .with(Effect::Instances)
                .with_if(Effect::Motion, !instance.motion.is_empty()),
        }
    }));
    objects.extend(description.lights.iter().map(|light| {
        let (name, written) = match &light.model {
            LightModel::Environment { radiance, .. } => (
                "the environment",
                none.with(Effect::Environment)
                    .with_if(Effect::EnvironmentMap, is_texture(radiance)),
            ),
            LightModel::Point { .. } => ("the point light", none.with(Effect::DeltaLights)),
            LightModel::Spot { .. } => ("the spot light", none.with(Effect::DeltaLights)),
            LightModel::Distant { .. } => ("the distant light", none.with(Effect::DeltaLights)),
        };
        PlannedObject {
            name: name.to_owned(),
            place: light.place.clone(),
            calls_for: effects::of_light(light),
            written,
        }
    }));
    objects.extend(settings(description));
    objects
}

/// The settings of the scene that need an effect, where it states them.
fn settings(description: &SceneDescription) -> impl Iterator<Item = PlannedObject> {
    let render = &description.render;
    let light_paths = effects::of_light_paths(description);
    let reuse = effects::of_reuse(description);
    [
        ("light_paths", &render.light_paths, light_paths),
        ("reuse", &render.reuse, reuse),
    ]
    .into_iter()
    .filter_map(|(key, rule, calls_for)| {
        let rule = rule.as_ref()?;
        Some(PlannedObject {
            name: format!("{key} = \"{}\"", rule.value),
            place: Place::on_line(&description.file, rule.line),
            calls_for,
            written: EffectSet::NONE,
        })
    })
}

fn is_texture(colour: &ColourDescription) -> bool {
    matches!(colour, ColourDescription::Texture(_))
}

fn written_in_material(material: &MaterialDescription) -> EffectSet {
    let colours: &[&ColourDescription] = match &material.model {
        MaterialModel::Diffuse { reflectance }
        | MaterialModel::Mirror { reflectance }
        | MaterialModel::Plastic { reflectance, .. } => &[reflectance],
        MaterialModel::Phong {
            diffuse, specular, ..
        } => &[diffuse, specular],
        MaterialModel::Dielectric { tint, .. } | MaterialModel::ThinDielectric { tint, .. } => {
            &[tint]
        }
        MaterialModel::Principled { base_color, .. } => &[base_color],
        MaterialModel::Conductor { .. } => &[],
    };
    EffectSet::NONE
        .with_if(Effect::Textures, colours.iter().any(|c| is_texture(c)))
        .with_if(Effect::Textures, material.metallic_roughness_map.is_some())
        .with_if(Effect::Alpha, is_texture(&material.alpha))
        .with_if(
            Effect::NormalMaps,
            material.normal_map.is_some() || material.bump_map.is_some(),
        )
}

fn written_in_shape(shape: &ShapeDescription) -> EffectSet {
    let has_normals = match &shape.geometry {
        GeometryDescription::Mesh(mesh) => !mesh.normals.is_empty(),
        _ => false,
    };
    EffectSet::NONE
        .with_if(Effect::ShadingNormals, has_normals)
        .with_if(Effect::Motion, !shape.motion.is_empty())
        .with_if(Effect::AreaLights, shape.emission.is_some())
        .with_if(
            Effect::Textures,
            shape.emission.as_ref().is_some_and(is_texture),
        )
}
