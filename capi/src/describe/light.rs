//! Lights that are not shapes.
//!
//! Measure: world units, degrees; W/sr, W/m^2 or W m^-2 sr^-1 as stated at each field.
//! Range: as in docs/scene-format.md for `[[light]]`.
//! Source: docs/scene-format.md.

use super::choice;
use super::image::{EtdImage, texture_or};
use super::placement::transform;
use crate::memory::Versioned;
use crate::status::Failure;
use renderer::Rgb;
use renderer::description::{LightDescription, LightModel, Place};
use renderer::vec::{DMat3, DVec3};
use std::mem::offset_of;

/// Kinds of lights that are not shapes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EtdLightKind {
    /// Environment light from infinity in all directions: `value` as radiance, or `panorama`; `transform`.
    Environment = 0,
    /// Point light: `value` as intensity, `position`.
    Point = 1,
    /// Spot light, which emits into a cone: as a point light, with `target`, `cone`, `penumbra`.
    Spot = 2,
    /// Distant light, parallel: `value` as irradiance, `direction`.
    Distant = 3,
}

/// A light that is not a shape. Fields that are not listed at its kind are ignored.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct EtdLight {
    /// sizeof(EtdLight)
    pub struct_size: usize,
    /// An `EtdLightKind`.
    pub kind: i32,
    /// Radiance, intensity or irradiance, at least 0.
    pub value: [f32; 3],
    /// Environment map, replaces `value`: its middle is seen along -z, its right half towards +x, its top along +y; null
    /// for none.
    pub panorama: *const EtdImage,
    /// Position of a point or spot light.
    pub position: [f64; 3],
    /// The point at which a spot light is aimed.
    pub target: [f64; 3],
    /// Direction in which the light of a distant light travels.
    pub direction: [f64; 3],
    /// Angle from the axis of a spot light to its edge in degrees, up to 180.
    pub cone: f64,
    /// The outer part of the cone angle over which the intensity falls off, in degrees.
    pub penumbra: f64,
    /// Rotation from the axes of the panorama to world axes: 12 numbers, row by row; null for the identity.
    pub transform: *const f64,
}

// SAFETY: numbers and pointers, of which zeros are values.
unsafe impl Versioned for EtdLight {
    const NAME: &'static str = "EtdLight";
    const FIRST_SIZE: usize = offset_of!(EtdLight, transform);
}

impl EtdLight {
    /// # Safety
    /// Its pointers are null, or valid.
    pub unsafe fn describe(&self) -> Result<LightDescription, Failure> {
        const KINDS: &[(i32, EtdLightKind)] = &[
            (EtdLightKind::Environment as i32, EtdLightKind::Environment),
            (EtdLightKind::Point as i32, EtdLightKind::Point),
            (EtdLightKind::Spot as i32, EtdLightKind::Spot),
            (EtdLightKind::Distant as i32, EtdLightKind::Distant),
        ];
        let value = Rgb::from(self.value);
        let position = DVec3::from_array(self.position);
        let model = match choice(self.kind, KINDS, "kind")? {
            EtdLightKind::Environment => LightModel::Environment {
                // SAFETY: the caller's promise.
                radiance: unsafe { texture_or(self.panorama, value) }?,
                // SAFETY: as above.
                to_world: unsafe { self.rotation() }?,
            },
            EtdLightKind::Point => LightModel::Point {
                position,
                intensity: value,
            },
            EtdLightKind::Spot => LightModel::Spot {
                position,
                target: DVec3::from_array(self.target),
                intensity: value,
                cone: self.cone.to_radians(),
                penumbra: self.penumbra.to_radians(),
            },
            EtdLightKind::Distant => LightModel::Distant {
                direction: DVec3::from_array(self.direction),
                irradiance: value,
            },
        };
        Ok(LightDescription {
            place: Place::default(),
            model,
        })
    }

    /// # Safety
    /// As [`EtdLight::describe`].
    unsafe fn rotation(&self) -> Result<DMat3, Failure> {
        // SAFETY: the caller's promise.
        let turned = unsafe { transform(self.transform) }?;
        if turned.translation == DVec3::ZERO {
            return Ok(turned.matrix3);
        }
        Err(Failure::argument(
            "transform: expected a rotation only: an environment has no position",
        ))
    }
}
