//! A moving triangle light: a [`TriangleLight`] at each time.
//!
//! Measure: densities per steradian; time from 0 to 1 while the shutter is open.
//! Range: at least two steps at equally spaced times, between which every vertex moves linearly.
//! Source: none needed. Tested in `tests/lights/light.rs` and `tests/rendering/motion.rs`.

use super::triangle::TriangleLight;
use super::types::{Emission, LightSample};
use crate::math::measure::PdfSolidAngle;
use crate::math::vec::{Vec2, Vec3};
use std::sync::Arc;

/// A moving triangle light.
#[derive(Debug, Clone)]
pub struct MovingTriangle {
    steps: Arc<[[Vec3; 3]]>,
    emission: Emission,
}

impl MovingTriangle {
    /// Creates a light from its vertices at equally spaced times.
    ///
    /// # Panics
    /// If there are fewer than two steps.
    pub fn new(steps: Vec<[Vec3; 3]>, emission: Emission) -> Self {
        assert!(steps.len() > 1, "what moves is at two places");
        Self {
            steps: steps.into(),
            emission,
        }
    }

    /// The vertices at all steps.
    pub fn vertices(&self) -> Vec<Vec3> {
        self.steps.iter().flatten().copied().collect()
    }

    /// The emission of the surface.
    pub fn emission(&self) -> Emission {
        self.emission
    }

    /// Mean radiant power in normalised units.
    pub fn power(&self) -> f64 {
        let powers = self.steps.iter();
        let powers = powers.map(|step| TriangleLight::new(*step, self.emission).power());
        powers.sum::<f64>() / self.steps.len() as f64
    }

    /// Samples a point on the light for the receiver `p` at a time.
    pub fn sample(&self, p: Vec3, time: f32, u: Vec2) -> Option<LightSample> {
        self.at(time).sample(p, u)
    }

    /// Samples a point uniformly by area, for the receiver `p` at a time.
    pub fn sample_by_area(&self, p: Vec3, time: f32, u: Vec2) -> Option<LightSample> {
        self.at(time).sample_by_area(p, u)
    }

    /// The density of [`sample`](Self::sample), as [`TriangleLight::pdf`].
    pub fn pdf(&self, p: Vec3, time: f32, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        self.at(time).pdf(p, distance2, cos)
    }

    /// The triangle light at a time.
    pub fn at(&self, time: f32) -> TriangleLight {
        let position = time * (self.steps.len() - 1) as f32;
        let before = (position as usize).min(self.steps.len() - 2);
        let share = position - before as f32;
        let [a, b] = [before, before + 1].map(|step| self.steps[step]);
        let corners = std::array::from_fn(|i| a[i] + share * (b[i] - a[i]));
        TriangleLight::new(corners, self.emission)
    }
}
