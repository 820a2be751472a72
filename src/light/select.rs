//! Which light to sample: by power.
//!
//! Measure: probabilities.
//! Range: any number of lights; one that emits nothing is never chosen.
//! Source: Shirley, Wang and Zimmerman 1996. Tested in `tests/light.rs`.

use super::Light;
use super::types::LightSample;
use crate::math::measure::PdfSolidAngle;
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
    /// A choice among these lights in proportion to their power.
    pub fn new(lights: Vec<Light>) -> Self {
        let powers: Vec<f64> = lights.iter().map(Light::power).collect();
        let choice = AliasTable::new(&powers);
        Self { lights, choice }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is nothing to sample.
    pub fn is_empty(&self) -> bool {
        self.choice.is_none()
    }

    /// A point on some light that lights `p`. The sample's density includes the choice of the light. The first two
    /// numbers, which low-discrepancy points place best, choose the point, the others the light.
    #[inline]
    pub fn sample(&self, p: Vec3, u: [f32; 4]) -> Option<LightSample> {
        let (chosen, pmf) = self.choice.as_ref()?.sample([u[2], u[3]]);
        let sample = self.lights[chosen].sample(p, Vec2::new(u[0], u[1]))?;
        Some(LightSample {
            pdf: pmf * sample.pdf,
            ..sample
        })
    }

    /// The density of [`sample`](Self::sample) at `p` for the point of light `light` at `towards`, with normal
    /// `normal`: 0 for a light that it never chooses.
    #[inline]
    pub fn pdf(&self, light: u32, p: Vec3, towards: Vec3, normal: Vec3) -> PdfSolidAngle {
        let chosen = self
            .choice
            .as_ref()
            .map(|choice| choice.pmf(light as usize));
        let pdf = self.lights[light as usize].pdf(p, towards, normal);
        match (chosen, pdf) {
            (Some(pmf), Some(pdf)) => pmf * pdf,
            _ => PdfSolidAngle(0.0),
        }
    }
}
