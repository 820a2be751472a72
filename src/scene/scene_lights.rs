//! Collects the lights and emitters of a scene, with the shape numbers that rays return.
//!
//! Measure: normalised units.
//! Range: the shapes of a world, in order.
//! Source: docs/architecture.md. Tested through `prepare.rs` and in `tests/loading/lights.rs`.

use super::caustic_targets::is_glossy;
use super::description::{CameraDescription, ColourDescription, LightModel, SceneDescription};
use super::effects;
use super::emitters::{AddedShape, Emitters, InstanceTransform};
use super::material::Material;
use super::normalisation::Normalisation;
use super::placed::TransformedAttributes;
use super::placement::SceneLayout;
use super::{Emitter, PreparedCache, ShapeAttributes, ShapeTraits};
use crate::accel::PrimitiveId;
use crate::effects::{Effect, EffectSet};
use crate::geometry::Geometry;
use crate::geometry::texture::Texture;
use crate::geometry::world::World;
use crate::light::select::Lights;
use crate::light::{
    Light, distant::DistantLight, environment::EnvironmentMap, point::PointLight, spot::SpotLight,
};
use crate::math::rgb::Rgb;
use crate::planted::planted;
use std::sync::Arc;

/// The lights, emitters and shape attributes of a scene.
pub struct SceneLights {
    /// See [`Scene::shapes`](super::Scene).
    pub(super) shapes: Vec<ShapeAttributes>,
    /// Emission of the shapes that emit.
    pub(super) emitters: Vec<Emitter>,
    /// All lights that can be sampled.
    pub(super) lights: Lights,
    /// See [`Scene::light_primitives`](super::Scene).
    pub(super) light_primitives: Vec<Option<PrimitiveId>>,
    unsampled: usize,
}

impl SceneLights {
    /// Collects the shapes and lights of a description in a world with this layout.
    pub(super) fn new(
        description: &SceneDescription,
        layout: &SceneLayout,
        materials: &[Material],
        (normalisation, cache): (&Normalisation, &PreparedCache),
        world: &World,
    ) -> Self {
        let mut gathered = Gathered {
            description,
            materials,
            shapes: vec![],
            emitters: Emitters::default(),
        };
        gathered.add_lights(normalisation, cache.radius);
        let (roots, forms) = (world.geometries(), &cache.ungrouped);
        gathered.add_shapes(&layout.shapes, roots, forms, InstanceTransform::World);
        for (instance, placement) in world.instances().iter().zip(&layout.placements) {
            let transform = match instance.steps.as_slice() {
                [still] => InstanceTransform::Still(still),
                steps => InstanceTransform::Moving(steps),
            };
            let group = placement.group;
            let (shapes, forms) = (&layout.groups[group], &cache.groups[group]);
            gathered.add_shapes(shapes, &world.groups()[group], forms, transform);
        }
        let emitters = gathered.emitters;
        let all_in_place = emitters.primitives.iter().all(Option::is_none);
        Self {
            shapes: gathered.shapes,
            emitters: emitters.emitters,
            lights: Lights::new(emitters.lights, &emitters.powers),
            light_primitives: if all_in_place {
                vec![]
            } else {
                emitters.primitives
            },
            unsampled: emitters.unsampled,
        }
    }

    /// Returns the effects that the scene requires of a kernel.
    pub(super) fn effects(&self, camera: &CameraDescription, cache: &PreparedCache) -> EffectSet {
        (effects::of_camera(camera) | cache.objects)
            .with_if(Effect::ManyLights, self.lights.len() > 1)
    }

    /// Returns notes for the user: one sentence each.
    pub(super) fn notes(&self, cache: &PreparedCache) -> Vec<String> {
        let forms = cache.ungrouped.iter().chain(cache.groups.iter().flatten());
        let dropped: usize = forms.map(|form| form.dropped).sum();
        let dropped =
            (dropped > 0).then(|| format!("{dropped} triangles without an area were left out"));
        let unsampled = self.unsampled;
        let unsampled = (unsampled > 0).then(|| {
            format!(
                "{unsampled} emitting spheres, disks or textured meshes move, or are stretched or mirrored by an instance: only scattered rays find their light, with more noise"
            )
        });
        dropped.into_iter().chain(unsampled).collect()
    }
}

/// The state while collecting.
struct Gathered<'a> {
    description: &'a SceneDescription,
    materials: &'a [Material],
    shapes: Vec<ShapeAttributes>,
    emitters: Emitters,
}

impl Gathered<'_> {
    /// Adds shapes in the order of the shape numbers.
    fn add_shapes(
        &mut self,
        shapes: &[usize],
        geometries: &[Geometry],
        forms: &[TransformedAttributes],
        transform: InstanceTransform<'_>,
    ) {
        for (&shape, (geometry, form)) in shapes.iter().zip(geometries.iter().zip(forms)) {
            let description = &self.description.shapes[shape];
            let number = self.shapes.len() as u32;
            let material = &self.materials[description.material];
            let described = &self.description.materials[description.material];
            let added = AddedShape {
                number,
                description,
                masked: material.is_masked(),
                geometry,
                rectangle: form.rectangle,
            };
            let emitter = self.emitters.add_shape(&added, transform);
            let emission = emitter.map(|index| &self.emitters.emitters[index as usize]);
            let shines_by_texture = emission.is_some_and(|emitter| emitter.texture.is_some());
            let is_top_level = matches!(transform, InstanceTransform::World);
            let is_flat = is_top_level && matches!(geometry, Geometry::Mesh(_) | Geometry::Disk(_));
            let traits = material
                .traits()
                .with_if(ShapeTraits::EMISSIVE, emitter.is_some())
                .with_if(ShapeTraits::TEXTURED, shines_by_texture)
                .with_if(ShapeTraits::FLAT, is_flat)
                .with_if(ShapeTraits::GLOSSY, is_glossy(described));
            self.shapes.push(ShapeAttributes {
                described: shape as u32,
                material: description.material as u32,
                emitter,
                traits,
            });
        }
    }

    /// Adds the lights that are not shapes and can be sampled, for a scene of this radius in normalised units.
    fn add_lights(&mut self, normalisation: &Normalisation, radius: f64) {
        for light in &self.description.lights {
            if let Some(light) = light_of(&light.model, normalisation) {
                let power = light.power(radius);
                self.emitters.add_light(light, power);
            }
        }
    }
}

/// Returns a light that is not a shape in normalised units; `None` if it is black or a constant environment.
fn light_of(model: &LightModel, normalisation: &Normalisation) -> Option<Light> {
    // Irradiance, I / d^2, must not depend on the unit of length. The square of the scale may overflow single precision
    // where its product with an intensity does not.
    let intensity = |intensity: Rgb| {
        let normalised = |x: f32| normalisation.area(f64::from(x)) as f32;
        let normalised = |x| planted!("intensity-in-world-units", x, normalised(x));
        (!intensity.is_black()).then(|| intensity.map(normalised))
    };
    Some(match model {
        LightModel::Environment { radiance, to_world } => {
            let (None, ColourDescription::Texture(texture)) = (radiance.constant(), radiance)
            else {
                return None;
            };
            let Texture::Image { image, scale } = texture.as_ref() else {
                return None;
            };
            let map = EnvironmentMap::new(Arc::clone(image), *scale, *to_world)?;
            Light::Environment(Arc::new(map))
        }
        LightModel::Point {
            position,
            intensity: i,
        } => {
            let position = normalisation.point(*position);
            Light::Point(PointLight::new(position, intensity(*i)?))
        }
        LightModel::Spot {
            position,
            target,
            intensity: i,
            cone,
            penumbra,
        } => {
            let axis = (*target - *position).normalize().as_vec3a();
            let position = normalisation.point(*position);
            Light::Spot(SpotLight::new(
                position,
                axis,
                intensity(*i)?,
                *cone,
                *penumbra,
            ))
        }
        LightModel::Distant {
            direction,
            irradiance,
        } => {
            let direction = direction.normalize().as_vec3a();
            let light = DistantLight::new(direction, *irradiance);
            Light::Distant((!irradiance.is_black()).then_some(light)?)
        }
    })
}
