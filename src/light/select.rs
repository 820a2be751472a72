//! Which light to sample: by power.
//!
//! Measure: probabilities.
//! Range: any number of lights; one that emits nothing is never chosen.
//! Source: Shirley, Wang and Zimmerman 1996. Tested in `tests/light.rs`.

use super::Light;
use super::environment::EnvironmentMap;
use super::types::LightSample;
use crate::effects::{Effects, Switch};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::sampling::distribution::AliasTable;
use std::sync::Arc;

/// All lights of a scene, and how one of them is chosen.
#[derive(Debug, Clone, Default)]
pub struct Lights {
    lights: Vec<Light>,
    /// `None` when nothing emits.
    choice: Option<AliasTable>,
    /// Which of them is the environment map, if there is one.
    map: Option<(usize, Arc<EnvironmentMap>)>,
}

impl Lights {
    /// A choice among these lights, of which at most one is an environment map, in proportion to their powers.
    ///
    /// # Panics
    /// If there are not as many powers as lights.
    pub fn new(lights: Vec<Light>, powers: &[f64]) -> Self {
        assert_eq!(lights.len(), powers.len());
        let choice = AliasTable::new(powers);
        let map = lights
            .iter()
            .enumerate()
            .find_map(|(i, light)| match light {
                Light::Environment(map) => Some((i, Arc::clone(map))),
                _ => None,
            });
        Self {
            lights,
            choice,
            map,
        }
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
        let pdf = self.lights[light as usize].pdf::<E>(p, time, towards, normal);
        pdf.map_or(PdfSolidAngle(0.0), |pdf| self.pmf(light as usize) * pdf)
    }

    /// What is sampled of the light from beyond the scene: the radiance from a direction, and the density with which
    /// [`sample`](Self::sample) finds that direction, the choice of the light included.
    #[inline]
    pub fn beyond(&self, direction: Vec3) -> Option<(Rgb, PdfSolidAngle)> {
        let (light, map) = self.map.as_ref()?;
        let (radiance, pdf) = map.eval(direction);
        Some((radiance, self.pmf(*light) * pdf))
    }

    /// The probability of choosing a light.
    #[inline]
    fn pmf(&self, light: usize) -> Pmf {
        self.choice
            .as_ref()
            .map_or(Pmf(0.0), |choice| choice.pmf(light))
    }
}
