//! Changes of a prepared scene: another camera and film, and other places of instances.
//!
//! Measure: world units in, normalised units out.
//! Range: descriptions that differ from the prepared one in nothing else.
//! Source: docs/architecture.md, "Sessions". Tested in `tests/rendering/session.rs`.

use super::Scene;
use super::build_geometry::instances;
use super::caustic_targets::caustic_targets;
use super::description::SceneDescription;
use super::effects;
use super::extent::bounding_sphere;
use super::placement::layout;
use super::prepare::camera;
use super::scene_lights::SceneLights;
use crate::effects::Effect;
use crate::error::Result;
use crate::planted::planted;
use std::sync::Arc;

impl Scene {
    /// Replaces the camera and film by those of the description. Everything else must be unchanged; so must the shutter,
    /// if anything moves.
    pub fn set_camera(&mut self, description: &SceneDescription) {
        let size = description.film.size;
        self.camera = camera(&description.camera, size, &self.normalisation);
        let many_lights = self.effects.has(Effect::ManyLights);
        let of_camera = planted!(
            "new-lens-left-out",
            Default::default(),
            effects::of_camera(&description.camera)
        );
        self.effects = (of_camera | self.cache.objects).with_if(Effect::ManyLights, many_lights);
    }

    /// Moves the instances to their transforms in the description, and returns notes like
    /// [`prepare`](super::prepare::prepare). Everything else must be unchanged. The shapes, the acceleration structures
    /// of groups and the normalisation are kept: images differ from those of a newly prepared scene only by rounding.
    ///
    /// # Errors
    /// A transform that cannot be traced, or an error of the backend; the scene is then unchanged.
    pub fn set_instance_transforms(
        &mut self,
        description: &SceneDescription,
    ) -> Result<Vec<String>> {
        let layout = layout(description)?;
        let cache = &self.cache;
        let groups = self.world.groups();
        let instances = instances(
            &layout,
            &self.normalisation,
            &cache.group_normalisations,
            groups,
        )?;
        let world = Arc::new(self.world.with_instances(instances));
        let accel = Arc::new(self.accel.with_instances_of(Arc::clone(&world))?);
        let frame = (&self.normalisation, cache);
        let lamps_in = planted!("lamps-stay-behind", &self.world, &world);
        let scene_lights = SceneLights::new(description, &layout, &self.materials, frame, lamps_in);
        let notes = scene_lights.notes(cache);
        self.effects = scene_lights.effects(&description.camera, cache);
        self.bounding_sphere = bounding_sphere(&world);
        self.caustic_targets = caustic_targets(description, &scene_lights.shapes, &world);
        (self.world, self.accel) = (world, accel);
        (self.shapes, self.emitters) = (scene_lights.shapes, scene_lights.emitters);
        (self.lights, self.light_primitives) = (scene_lights.lights, scene_lights.light_primitives);
        Ok(notes)
    }
}
