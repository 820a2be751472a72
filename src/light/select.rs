//! The selection of a light to sample, in proportion to power.
//!
//! Measure: probabilities.
//! Range: any number of lights; one that emits nothing is never selected.
//! Source: Shirley, Wang and Zimmerman 1996. Tested in `tests/lights/light.rs`.

use super::Light;
use super::environment::EnvironmentMap;
use super::rectangle::RectangleLight;
use super::triangle::TriangleLight;
use super::types::{LightSample, LightSampleContext, PointRule};
use crate::effects::{Effects, Switch};
use crate::math::lanes::{FEW, LANES};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampling::distribution::AliasTable;
use std::sync::Arc;

/// All lights of a scene, and the distribution for selecting one of them.
#[derive(Debug, Clone, Default)]
pub struct Lights {
    lights: Vec<Light>,
    /// The distribution; `None` when nothing emits.
    choice: Option<AliasTable>,
    /// The environment map and its index, if there is one.
    map: Option<(u32, Arc<EnvironmentMap>)>,
}

/// Lights of one kind that are sampled in SIMD lanes.
enum Alike<'a> {
    /// One light for all lanes.
    Rectangle(&'a RectangleLight),
    /// One light for each lane.
    Triangles([&'a TriangleLight; LANES]),
}

/// The light of the environment map along a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvironmentSample {
    /// The index of the light.
    pub light: u32,
    /// Its radiance.
    pub radiance: Rgb,
    /// The density of [`Lights::sample`] at the direction, including the selection of the light.
    pub pdf: PdfSolidAngle,
}

impl Lights {
    /// Creates the selection among lights, of which at most one is an environment map, in proportion to their powers.
    ///
    /// # Panics
    /// If there are not as many powers as lights.
    pub fn new(lights: Vec<Light>, powers: &[f64]) -> Self {
        assert_eq!(lights.len(), powers.len());
        let choice = AliasTable::new(powers);
        let map = (0..).zip(&lights).find_map(|(i, light)| match light {
            Light::Environment(map) => Some((i, Arc::clone(map))),
            _ => None,
        });
        Self {
            lights,
            choice,
            map,
        }
    }

    /// The number of lights.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is no light to sample.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.choice.is_none()
    }

    /// Selects a light; returns it with the probability of selecting it, `None` where nothing emits.
    #[inline]
    pub fn choose<E: Effects>(&self, u: [f32; 2]) -> Option<(u32, Pmf)> {
        let choice = self.choice.as_ref()?;
        if !E::ManyLights::ON {
            return Some((0, Pmf(1.0)));
        }
        let (light, pmf) = choice.sample(u);
        Some((light as u32, pmf))
    }

    /// Samples a direction to a light for the receiver `p`, at a time of the shutter. The sample's density, or the
    /// irradiance of a delta light, includes the probability `pmf` of selecting the light.
    #[inline]
    pub fn sample<E: Effects>(
        &self,
        (light, pmf): (u32, Pmf),
        points: PointRule,
        p: Vec3,
        time: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let mut sample = self.sample_one::<E>(light, points, p, time, u)?;
        sample.is_chosen_with(pmf);
        Some(sample)
    }

    /// Samples a given light, without the probability of selecting it.
    #[inline]
    fn sample_one<E: Effects>(
        &self,
        light: u32,
        points: PointRule,
        p: Vec3,
        time: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let light = &self.lights[light as usize];
        match points {
            PointRule::SolidAngle => light.sample::<E>(p, time, u),
            PointRule::Area => light.sample_by_area::<E>(p, time, u),
        }
    }

    /// Samples the light of each context, and appends the samples in order.
    #[inline]
    pub fn sample_each<E: Effects>(
        &self,
        questions: &[LightSampleContext],
        points: PointRule,
        samples: &mut Vec<Option<LightSample>>,
    ) {
        let by_solid_angle = E::AreaLights::ON && points == PointRule::SolidAngle;
        for questions in questions.chunks(LANES) {
            let first = samples.len();
            let alike = (by_solid_angle && questions.len() > FEW).then(|| self.alike(questions));
            match alike.flatten() {
                Some(Alike::Rectangle(light)) => light.sample_each(questions, samples),
                Some(Alike::Triangles(lights)) => {
                    TriangleLight::sample_each(&lights, questions, samples);
                }
                None => samples.extend(questions.iter().map(|question| {
                    let LightSampleContext { p, time, u, .. } = *question;
                    self.sample_one::<E>(question.light, points, p, time, u)
                })),
            }
            for (question, sample) in questions.iter().zip(&mut samples[first..]) {
                if let Some(sample) = sample {
                    sample.is_chosen_with(question.pmf);
                }
            }
        }
    }

    /// The lights of the contexts, if all are of one kind that is sampled in SIMD lanes.
    #[inline]
    fn alike(&self, questions: &[LightSampleContext]) -> Option<Alike<'_>> {
        let asked = |question: &LightSampleContext| &self.lights[question.light as usize];
        let (first, rest) = questions.split_first()?;
        match asked(first) {
            Light::Rectangle(light) => {
                let is_same = rest.iter().all(|question| question.light == first.light);
                is_same.then_some(Alike::Rectangle(light))
            }
            Light::Triangle(light) => {
                let mut lights = [light; LANES];
                for (light, question) in lights.iter_mut().zip(questions) {
                    let Light::Triangle(found) = asked(question) else {
                        return None;
                    };
                    *light = found;
                }
                Some(Alike::Triangles(lights))
            }
            _ => None,
        }
    }

    /// The density of [`sample`](Self::sample) for the receiver `p` at the point of light `light` at `towards` from it,
    /// with normal `normal`; 0 for a light that is never selected.
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
        let pmf = planted!("choice-left-out-of-pdf", Pmf(1.0), self.pmf(light));
        pdf.map_or(PdfSolidAngle(0.0), |pdf| pmf * pdf)
    }

    /// Returns a light by its index.
    #[inline]
    pub fn get(&self, light: u32) -> &Light {
        &self.lights[light as usize]
    }

    /// Evaluates the environment map along a direction; `None` if there is no map.
    #[inline]
    pub fn environment(&self, direction: Vec3) -> Option<EnvironmentSample> {
        let (light, map) = self.map.as_ref()?;
        let (radiance, pdf) = map.eval(direction);
        Some(EnvironmentSample {
            light: *light,
            radiance,
            pdf: self.pmf(*light) * pdf,
        })
    }

    /// The probability of selecting a light.
    #[inline]
    pub fn pmf(&self, light: u32) -> Pmf {
        self.choice
            .as_ref()
            .map_or(Pmf(0.0), |choice| choice.pmf(light as usize))
    }
}
