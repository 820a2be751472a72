//! The effects that each object of a scene requires, ignoring settings without effect: a lens of radius 0, equal
//! keyframes, an image of one colour.
//!
//! Measure: none.
//! Range: any scene that `load` accepts.
//! Source: docs/architecture.md, "Effects". Tested in `tests/rendering/effects.rs`.

use super::caustic_targets::casts_caustics;
use super::description::{
    CameraDescription, GeometryDescription, InstanceDescription, LightDescription, LightModel,
    MaterialDescription, SceneDescription, ShapeDescription,
};
use super::keyframes::moves;
use super::material::Material;
use super::placed::has_shading_normals;
use super::placement::{SceneLayout, forms_own_group};
use crate::effects::{Effect, EffectSet};

/// Returns the effects of a camera.
pub fn of_camera(camera: &CameraDescription) -> EffectSet {
    EffectSet::NONE
        .with_if(Effect::Lens, camera.lens_radius > 0.0)
        .with_if(Effect::Motion, moves(&camera.motion, camera.shutter))
}

/// Returns the effects of a material.
pub fn of_material(material: &MaterialDescription) -> EffectSet {
    Material::new(material, 1.0).effects()
}

/// Returns the effects of a shape, excluding its material.
pub fn of_shape(shape: &ShapeDescription, shutter: [f64; 2]) -> EffectSet {
    let emission = shape.emission.as_ref().filter(|e| !e.is_black());
    let shading_normals = match &shape.geometry {
        GeometryDescription::Mesh(mesh) => has_shading_normals(mesh),
        _ => false,
    };
    let moving = moves(&shape.motion, shutter);
    EffectSet::NONE
        .with_if(Effect::ShadingNormals, shading_normals)
        .with_if(Effect::AreaLights, emission.is_some())
        .with_if(
            Effect::Textures,
            emission.is_some_and(|e| e.constant().is_none()),
        )
        .with_if(Effect::Motion, moving)
        .with_if(Effect::Instances, forms_own_group(shape, shutter))
}

/// Returns the effects of an instance, excluding its group.
pub fn of_instance(instance: &InstanceDescription, shutter: [f64; 2]) -> EffectSet {
    EffectSet::NONE
        .with(Effect::Instances)
        .with_if(Effect::Motion, moves(&instance.motion, shutter))
}

/// Returns the effects of a light that is not a shape.
pub fn of_light(light: &LightDescription) -> EffectSet {
    let none = EffectSet::NONE;
    match &light.model {
        LightModel::Environment { radiance, .. } => match radiance.constant() {
            Some(colour) => none.with_if(Effect::Environment, !colour.is_black()),
            None => none.with(Effect::Environment).with(Effect::EnvironmentMap),
        },
        LightModel::Point { intensity, .. } | LightModel::Spot { intensity, .. } => {
            none.with_if(Effect::DeltaLights, !intensity.is_black())
        }
        LightModel::Distant { irradiance, .. } => {
            none.with_if(Effect::DeltaLights, !irradiance.is_black())
        }
    }
}

/// Returns the effects of a scene's render settings.
pub fn of_render(description: &SceneDescription) -> EffectSet {
    of_light_paths(description) | of_reuse(description)
}

/// Returns the effects of a scene's number of pixels that share their paths; none where a pilot chooses it.
pub fn of_reuse(description: &SceneDescription) -> EffectSet {
    let rule = description.render.reuse.as_ref();
    let is_on = rule.is_some_and(|rule| !matches!(rule.value.as_str(), "off" | "auto"));
    EffectSet::NONE.with_if(Effect::Reuse, is_on)
}

/// Returns the effects of a scene's number of light paths.
pub fn of_light_paths(description: &SceneDescription) -> EffectSet {
    let has_light_paths = match &description.render.light_paths {
        Some(rule) if rule.value == "auto" => description.materials.iter().any(casts_caustics),
        Some(rule) => rule.value != "off",
        None => false,
    };
    EffectSet::NONE.with_if(Effect::LightPaths, has_light_paths)
}

/// Returns the effects of a scene's objects with this layout, except its camera and the choice among several lights.
/// Shapes of groups that are not placed, and unused materials, do not count.
pub fn of_objects(description: &SceneDescription, layout: &SceneLayout) -> EffectSet {
    let shutter = description.camera.shutter;
    let mut effects = EffectSet::NONE;
    let mut seen = vec![false; description.materials.len()];
    for shape in layout.placed_shapes(description.shapes.len()) {
        let shape = &description.shapes[shape];
        effects |= of_shape(shape, shutter);
        if !std::mem::replace(&mut seen[shape.material], true) {
            effects |= of_material(&description.materials[shape.material]);
        }
    }
    for light in &description.lights {
        effects |= of_light(light);
    }
    effects |= of_render(description);
    let moving = layout.placements.iter().any(|p| p.steps.len() > 1);
    effects
        .with_if(Effect::Instances, !layout.placements.is_empty())
        .with_if(Effect::Motion, moving)
}
