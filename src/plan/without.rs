//! Removal of one effect from a scene. The difference between the two renders gives the cost of the effect and the
//! light that it transports.
//!
//! | effect | is removed by |
//! |---|---|
//! | shading-normals, normal-maps | flat shading |
//! | textures | the mean colour of each; flat normal maps |
//! | alpha, one-sided | an alpha of 1; two-sided surfaces |
//! | glossy, specular, transmission | absorbing the light that such lobes would scatter |
//! | lens, motion | a pinhole; the state when the shutter opens |
//! | environment, delta-lights, area-lights, many-lights | removing these lights; for many-lights, all but the first |
//! | environment-map | its mean over all directions |
//! | instances | removing them, and moving shapes |
//! | light-paths | light paths off: the light is found by camera paths alone, or not at all |
//!
//! Measure: none.
//! Range: any scene.
//! Source: none needed. Tested in `cli/tests/command/plan.rs`.

use crate::bsdf::microfacet::Ggx;
use crate::effects::Effect;
use crate::geometry::texture::Texture;
use crate::geometry::texture_image::TextureImage;
use crate::math::functions::sin;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ColourDescription, GeometryDescription, LightModel, MaterialDescription, MaterialModel,
    MeshDescription, SceneDescription, WithLine,
};
use crate::scene::placement::{self, forms_own_group};
use std::f64::consts::PI;
use std::sync::Arc;

/// Removes the maps of normals and heights.
fn without_detail(material: &mut MaterialDescription) {
    material.normal_map = None;
    material.bump_map = None;
}

/// Returns the scene without an effect.
pub fn without(description: &SceneDescription, effect: Effect) -> SceneDescription {
    let mut scene = description.clone();
    match effect {
        Effect::ShadingNormals => {
            each_mesh(&mut scene, |mesh| mesh.normals.clear());
            each_material(&mut scene, without_detail);
        }
        Effect::NormalMaps => each_material(&mut scene, without_detail),
        Effect::Textures => {
            each_material(&mut scene, |material| {
                flatten_colours(material);
                without_detail(material);
            });
            for emission in scene.shapes.iter_mut().filter_map(|s| s.emission.as_mut()) {
                flatten(emission);
            }
        }
        Effect::Alpha => {
            let all = ColourDescription::Constant(Rgb::WHITE);
            each_material(&mut scene, |material| {
                material.alpha = all.clone();
                material.alpha_cutoff = None;
            });
        }
        Effect::OneSided => each_material(&mut scene, |material| material.two_sided = true),
        Effect::Glossy | Effect::Specular | Effect::Transmission => {
            each_material(&mut scene, |material| absorb(material, effect));
        }
        Effect::Lens => scene.camera.lens_radius = 0.0,
        Effect::Motion => stand_still(&mut scene),
        Effect::Environment => scene
            .lights
            .retain(|light| !matches!(light.model, LightModel::Environment { .. })),
        Effect::EnvironmentMap => {
            for light in &mut scene.lights {
                if let LightModel::Environment { radiance, .. } = &mut light.model {
                    flatten_panorama(radiance);
                }
            }
        }
        Effect::DeltaLights => scene
            .lights
            .retain(|light| matches!(light.model, LightModel::Environment { .. })),
        Effect::AreaLights => {
            for shape in &mut scene.shapes {
                shape.emission = None;
            }
        }
        Effect::ManyLights => keep_one_light(&mut scene),
        Effect::Instances => {
            let shutter = scene.camera.shutter;
            scene.instances.clear();
            scene
                .shapes
                .retain(|shape| !forms_own_group(shape, shutter));
        }
        Effect::LightPaths => scene.render.light_paths = Some(off()),
        Effect::Reuse => scene.render.reuse = Some(off()),
    }
    scene
}

fn off() -> WithLine<String> {
    WithLine {
        value: "off".to_owned(),
        line: 0,
    }
}

fn each_material(scene: &mut SceneDescription, change: impl FnMut(&mut MaterialDescription)) {
    scene.materials.iter_mut().for_each(change);
}

fn each_mesh(scene: &mut SceneDescription, mut change: impl FnMut(&mut MeshDescription)) {
    for shape in &mut scene.shapes {
        if let GeometryDescription::Mesh(mesh) = &mut shape.geometry {
            change(Arc::make_mut(mesh));
        }
    }
}

/// Replaces a texture by its mean colour.
fn flatten(colour: &mut ColourDescription) {
    if let ColourDescription::Texture(texture) = colour {
        *colour = ColourDescription::Constant(texture.mean());
    }
}

/// Replaces an environment map by its mean over all directions, with rows weighted by their solid angle.
fn flatten_panorama(radiance: &mut ColourDescription) {
    if let ColourDescription::Texture(texture) = radiance
        && let Texture::Image { image, scale } = texture.as_ref()
    {
        let height = f64::from(image.height());
        let sin = |row: u32| sin(PI * (f64::from(row) + 0.5) / height);
        *radiance = ColourDescription::Constant(*scale * weighted_mean(image, sin));
    }
}

/// The weighted mean of all pixels, with `weight` giving the weight of a row.
fn weighted_mean(image: &TextureImage, weight: impl Fn(u32) -> f64) -> Rgb {
    let mut sum = [0.0; 3];
    let mut weights = 0.0;
    for y in 0..image.height() {
        let weight = weight(y);
        for x in 0..image.width() {
            let pixel = image.get(x, y).to_array();
            for (sum, channel) in sum.iter_mut().zip(pixel) {
                *sum += weight * f64::from(channel);
            }
        }
        weights += weight * f64::from(image.width());
    }
    Rgb::from(sum.map(|x| (x / weights) as f32))
}

fn flatten_colours(material: &mut MaterialDescription) {
    flatten(&mut material.alpha);
    flatten_map(material);
    match &mut material.model {
        MaterialModel::Diffuse { reflectance }
        | MaterialModel::Mirror { reflectance }
        | MaterialModel::Plastic { reflectance, .. } => flatten(reflectance),
        MaterialModel::Phong {
            diffuse, specular, ..
        } => {
            flatten(diffuse);
            flatten(specular);
        }
        MaterialModel::Dielectric { tint, .. } | MaterialModel::ThinDielectric { tint, .. } => {
            flatten(tint);
        }
        MaterialModel::Principled { base_color, .. } => flatten(base_color),
        MaterialModel::Conductor { .. } => {}
    }
}

/// Replaces the map of roughness and metallic by its mean.
fn flatten_map(material: &mut MaterialDescription) {
    let Some(map) = material.metallic_roughness_map.take() else {
        return;
    };
    if let MaterialModel::Principled {
        metallic,
        roughness,
        ..
    } = &mut material.model
    {
        let [_, rough, metal] = map.mean().to_array();
        *roughness *= rough;
        *metallic *= metal;
    }
}

/// Makes the lobes of this kind scatter nothing; diffuse lobes remain.
fn absorb(material: &mut MaterialDescription, effect: Effect) {
    let map = material.metallic_roughness_map.as_deref();
    let metal = map.map_or(1.0, |map| map.mean().to_array()[2]);
    // The opaque lobes of mapped surfaces are rough everywhere; their glass may be smooth.
    let is_mapped = map.is_some();
    let black = ColourDescription::Constant(Rgb::BLACK);
    let shiny = |roughness: f32| {
        if Ggx::from_roughness(roughness).is_some() {
            Effect::Glossy
        } else {
            Effect::Specular
        }
    };
    if let Some(coat) = &material.clear_coat
        && effect == shiny(coat.roughness)
    {
        material.clear_coat = None;
    }
    let model = &mut material.model;
    let matte = match &mut *model {
        MaterialModel::Mirror { .. } if effect == Effect::Specular => black,
        MaterialModel::Conductor { roughness, .. } if effect == shiny(*roughness) => black,
        MaterialModel::Dielectric { roughness, .. }
            if effect == shiny(*roughness) || effect == Effect::Transmission =>
        {
            black
        }
        MaterialModel::ThinDielectric { .. }
            if matches!(effect, Effect::Specular | Effect::Transmission) =>
        {
            black
        }
        MaterialModel::Plastic {
            reflectance,
            roughness,
            ..
        } if effect == shiny(*roughness) => reflectance.clone(),
        MaterialModel::Phong { diffuse, .. } if effect == Effect::Glossy => diffuse.clone(),
        MaterialModel::Principled {
            base_color,
            metallic,
            roughness,
            transmission,
            ..
        } => {
            if effect == Effect::Transmission || (effect == Effect::Specular && is_mapped) {
                scale(base_color, 1.0 - (1.0 - metal * *metallic) * *transmission);
                *transmission = 0.0;
                return;
            }
            let lobes = if is_mapped {
                Effect::Glossy
            } else {
                shiny(*roughness)
            };
            if effect != lobes {
                return;
            }
            scale(
                base_color,
                (1.0 - metal * *metallic) * (1.0 - *transmission),
            );
            base_color.clone()
        }
        _ => return,
    };
    *model = MaterialModel::Diffuse { reflectance: matte };
    // A matte surface has no coat, of whatever kind.
    material.clear_coat = None;
}

fn scale(colour: &mut ColourDescription, factor: f32) {
    match colour {
        ColourDescription::Constant(colour) => *colour *= factor,
        ColourDescription::Texture(texture) => match Arc::make_mut(texture) {
            Texture::Image { scale, .. } => *scale *= factor,
            Texture::Placed { tint, .. } => *tint *= factor,
            Texture::Checker { colours, .. } => *colours = colours.map(|c| factor * c),
        },
    }
}

/// Freezes the scene at the time when the shutter opens.
fn stand_still(scene: &mut SceneDescription) {
    let open = scene.camera.shutter[0];
    scene.camera.shutter = [open; 2];
}

/// Removes every light in the scene but the first: emitting shapes come first, then other lights.
fn keep_one_light(scene: &mut SceneDescription) {
    // A scene whose layout fails is not prepared, and has no lights.
    let layout = placement::layout(scene).unwrap_or_default();
    let placed: Vec<usize> = layout.placed_shapes(scene.shapes.len()).collect();
    let mut found = false;
    for shape in placed {
        let shape = &mut scene.shapes[shape];
        let emits = shape.emission.as_ref().is_some_and(|e| !e.is_black());
        if found {
            shape.emission = None;
        }
        found |= emits;
    }
    scene.lights.retain(|light| {
        let constant = matches!(&light.model, LightModel::Environment { radiance, .. } if radiance.constant().is_some());
        constant || !std::mem::replace(&mut found, true)
    });
}
