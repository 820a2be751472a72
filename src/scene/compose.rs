//! Building a scene description in code; each part is checked as it is added.
//!
//! Measure: as in the description.
//! Range: a part that `load` would reject is an error, and is not added.
//! Source: none needed. Tested in `tests/loading/built_scenes.rs`.

use super::check;
use super::description::{
    InstanceDescription, LightDescription, MaterialDescription, SceneDescription, ShapeDescription,
};
use crate::error::Result;

impl SceneDescription {
    /// Adds a material and returns its index.
    ///
    /// # Errors
    /// If the material is invalid.
    pub fn add_material(&mut self, material: MaterialDescription) -> Result<usize> {
        check::material(&material)?;
        self.materials.push(material);
        Ok(self.materials.len() - 1)
    }

    /// Adds a shape, whose material and group must exist, and returns its index.
    ///
    /// # Errors
    /// If the shape is invalid.
    pub fn add_shape(&mut self, shape: ShapeDescription) -> Result<usize> {
        check::shape(&shape, self)?;
        self.shapes.push(shape);
        Ok(self.shapes.len() - 1)
    }

    /// Adds an empty group and returns its index.
    pub fn add_group(&mut self, name: impl Into<String>) -> usize {
        self.groups.push(name.into());
        self.groups.len() - 1
    }

    /// Adds an instance of an existing group and returns its index. A group that is placed within itself is only
    /// detected when the scene is prepared.
    ///
    /// # Errors
    /// If the instance is invalid.
    pub fn add_instance(&mut self, instance: InstanceDescription) -> Result<usize> {
        check::instance(&instance, self)?;
        self.instances.push(instance);
        Ok(self.instances.len() - 1)
    }

    /// Adds a light that is not a shape and returns its index.
    ///
    /// # Errors
    /// If the light is invalid, or a second image as environment.
    pub fn add_light(&mut self, light: LightDescription) -> Result<usize> {
        check::light(&light)?;
        self.lights.push(light);
        if let Err(error) = check::panoramas(&self.lights) {
            self.lights.pop();
            return Err(error);
        }
        Ok(self.lights.len() - 1)
    }
}
