//! Which light to sample: by power.
//!
//! Measure: probabilities.
//! Range: any number of lights; one that emits nothing is never chosen.
//! Source: Shirley, Wang and Zimmerman 1996. Tested in `tests/light.rs`.

use super::Light;
use super::types::LightSample;
use crate::effects::{Effects, Switch};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::sampling::distribution::AliasTable;

/// All lights of a scene, and how one of them is chosen.
#[derive(Debug, Clone, Default)]
pub struct Lights {
    lights: Vec<Light>,
    /// `None` when nothing emits.
    choice: Option<AliasTable>,
}

impl Lights {
    /// A choice among these lights in proportion to their powers.
    ///
    /// # Panics
    /// If there are not as many powers as lights.
    pub fn new(lights: Vec<Light>, powers: &[f64]) -> Self {
        assert_eq!(lights.len(), powers.len());
        let choice = AliasTable::new(powers);
        Self { lights, choice }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is nothing to sample.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.choice.is_none()
    }

    /// Which light was chosen, and a direction from which it lights `p` at a time of the shutter. The sample's density, or
    /// the irradiance of a delta light, includes the choice of the light. The first two numbers, which low-discrepancy
    /// points place best, choose the direction, the others the light.
    #[inline]
    pub fn sample<E: Effects>(
        &self,
        p: Vec3,
        time: f32,
        u: [f32; 4],
    ) -> Option<(u32, LightSample)> {
        let choice = self.choice.as_ref()?;
        let (chosen, pmf) = if E::ManyLights::ON {
            choice.sample([u[2], u[3]])
        } else {
            (0, Pmf(1.0))
        };
        let mut sample = self.lights[chosen].sample::<E>(p, time, Vec2::new(u[0], u[1]))?;
        match &mut sample.pdf {
            Some(pdf) => *pdf = pmf * *pdf,
            None => sample.radiance *= 1.0 / pmf.0,
        }
        Some((chosen as u32, sample))
    }

    /// The density of [`sample`](Self::sample) at `p` for the point of light `light` at `towards`, with normal
    /// `normal`: 0 for a light that it never chooses.
    #[inline]
    pub fn pdf<E: Effects>(
        &self,
        light: u32,
        p: Vec3,
        time: f32,
        towards: Vec3,
        normal: Vec3,
    ) -> PdfSolidAngle {
        let chosen = self
            .choice
            .as_ref()
            .map(|choice| choice.pmf(light as usize));
        let pdf = self.lights[light as usize].pdf::<E>(p, time, towards, normal);
        match (chosen, pdf) {
            (Some(pmf), Some(pdf)) => pmf * pdf,
            _ => PdfSolidAngle(0.0),
        }
    }

    /// What is sampled of the light from beyond the scene: the radiance from a direction, and the density with which
    /// [`sample`](Self::sample) finds that direction.
    #[inline]
    pub fn beyond(&self, _direction: Vec3) -> Option<(Rgb, PdfSolidAngle)> {
        None
    }
}
