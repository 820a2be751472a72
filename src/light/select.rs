//! The selection of a light to sample: by what each would contribute at the receiver, or by power.
//!
//! Measure: probabilities.
//! Range: any number of lights; one that emits nothing is never selected.
//! Source: Shirley, Wang and Zimmerman 1996 for power; `light/tree.rs`. Tested in `tests/lights/light.rs` and
//! `tests/lights/choice.rs`.

use super::Light;
use super::environment::EnvironmentMap;
use super::lanes::{LightContextLanes, LightSampleLanes};
use super::rectangle::{self, RectangleLanes};
use super::sphere::{self, SphereLanes};
use super::tree::LightTree;
use super::triangle::{self, TriangleLightLanes};
use super::types::{
    EmissionSample, EnvironmentSampling, LightChoice, LightSample, LightSampling, Receiver,
    ShadowRayEnd,
};
use crate::effects::{Effects, Switch};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampling::distribution::AliasTable;
use std::sync::Arc;

/// All lights of a scene, and the distributions for selecting one of them.
#[derive(Debug, Clone, Default)]
pub struct Lights {
    lights: Vec<Light>,
    /// The distribution by power; `None` when nothing emits.
    by_power: Option<AliasTable>,
    /// The selection by contribution, if there are several lights.
    tree: Option<LightTree>,
    /// The environment map and its index, if there is one.
    map: Option<(u32, Arc<EnvironmentMap>)>,
}

/// The selected light of each lane, if it is of a kind that is sampled in lanes; kept from one bounce to the next until
/// the lane selects another one.
#[derive(Debug)]
pub struct LightLanes {
    /// The indices of the lights that are set.
    light: Lanes<u32>,
    is_rectangle: ActiveLanes<LANES>,
    is_triangle: ActiveLanes<LANES>,
    is_sphere: ActiveLanes<LANES>,
    rectangles: RectangleLanes,
    triangles: TriangleLightLanes,
    spheres: SphereLanes,
}

impl Default for LightLanes {
    fn default() -> Self {
        Self {
            light: [u32::MAX; LANES],
            is_rectangle: ActiveLanes::NONE,
            is_triangle: ActiveLanes::NONE,
            is_sphere: ActiveLanes::NONE,
            rectangles: RectangleLanes::default(),
            triangles: TriangleLightLanes::default(),
            spheres: SphereLanes::default(),
        }
    }
}

impl LightLanes {
    /// Removes all lights, before those of another scene are set.
    pub fn clear(&mut self) {
        self.light = [u32::MAX; LANES];
    }

    /// Sets the light of a lane, which has this index.
    fn set(&mut self, lane: usize, index: u32, light: &Light) {
        self.light[lane] = index;
        self.is_rectangle
            .set(lane, matches!(light, Light::Rectangle(_)));
        self.is_triangle
            .set(lane, matches!(light, Light::Triangle(_)));
        self.is_sphere.set(lane, matches!(light, Light::Sphere(_)));
        match light {
            Light::Rectangle(light) => self.rectangles.set(lane, light),
            Light::Triangle(light) => self.triangles.set(lane, light),
            Light::Sphere(light) => self.spheres.set(lane, light),
            _ => {}
        }
    }
}

/// The radiance of the environment map along a direction, and its pdf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvironmentEval {
    /// The index of the light.
    pub light: u32,
    /// Its radiance.
    pub radiance: Rgb,
    /// The density of sampling the direction, without the selection of the light.
    pub pdf: PdfSolidAngle,
}

impl Lights {
    /// Creates the selection among lights, of which at most one is an environment map, of these powers.
    ///
    /// # Panics
    /// If there are not as many powers as lights.
    pub fn new(lights: Vec<Light>, powers: &[f64]) -> Self {
        assert_eq!(lights.len(), powers.len());
        let by_power = AliasTable::new(powers);
        let are_several = by_power.is_some() && lights.len() > 1;
        let tree = are_several
            .then(|| LightTree::new(&lights, powers))
            .flatten();
        let map = (0..).zip(&lights).find_map(|(i, light)| match light {
            Light::Environment(map) => Some((i, Arc::clone(map))),
            _ => None,
        });
        Self {
            lights,
            by_power,
            tree,
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
        self.by_power.is_none()
    }

    /// Whether one of several lights has to be selected. A kernel without `ManyLights` never selects.
    #[inline]
    pub fn are_several<E: Effects>(&self) -> bool {
        E::ManyLights::ON && self.lights.len() > 1
    }

    /// The tree of lights, if there are several.
    pub fn tree(&self) -> Option<&LightTree> {
        self.tree.as_ref()
    }

    /// Selects a light for a receiver; returns it with the probability of selecting it, `None` where no light shines.
    #[inline]
    pub fn choose<E: Effects>(
        &self,
        choice: LightChoice,
        receiver: &Receiver,
        u: [f32; 2],
    ) -> Option<(u32, Pmf)> {
        match &self.tree {
            Some(tree) if E::ManyLights::ON && choice == LightChoice::Contribution => {
                tree.choose(receiver, u)
            }
            _ => self.choose_by_power::<E>(u),
        }
    }

    /// Selects a light in proportion to power, as light subpaths do.
    #[inline]
    pub fn choose_by_power<E: Effects>(&self, u: [f32; 2]) -> Option<(u32, Pmf)> {
        let by_power = self.by_power.as_ref()?;
        if !E::ManyLights::ON {
            return Some((0, Pmf(1.0)));
        }
        let (light, pmf) = by_power.sample(u);
        Some((light as u32, pmf))
    }

    /// Selects a light for the receivers of some lanes, as [`choose`](Self::choose) does. The probability is zero where
    /// there is none.
    #[inline]
    pub fn choose_lanes<E: Effects>(
        &self,
        choice: LightChoice,
        active: &ActiveLanes<LANES>,
        receivers: &Receiver<Lanes3>,
        context: &mut LightContextLanes,
    ) {
        let [.., a, b] = &context.u;
        match &self.tree {
            _ if !self.are_several::<E>() => {
                (context.light, context.pmf) = ([0; LANES], [1.0; LANES]);
            }
            Some(tree) if choice == LightChoice::Contribution => {
                let (u, lanes) = ([*a, *b], active.each());
                let (light, pmf) = (&mut context.light, &mut context.pmf);
                tree.choose_lanes(lanes, receivers, &u, light, pmf);
            }
            _ => {
                for lane in active.each() {
                    let chosen = self.choose_by_power::<E>([a[lane], b[lane]]);
                    let (light, pmf) = chosen.unwrap_or((0, Pmf(0.0)));
                    (context.light[lane], context.pmf[lane]) = (light, pmf.0);
                }
            }
        }
    }

    /// Samples a direction to a light for the receiver `p`, at a time of the shutter. The sample's density, or the
    /// irradiance of a delta light, includes the probability `pmf` of selecting the light.
    #[inline]
    pub fn sample<E: Effects>(
        &self,
        (light, pmf): (u32, Pmf),
        rules: LightSampling,
        p: Vec3,
        time: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        if pmf.0 == 0.0 {
            return None;
        }
        let mut sample = self.lights[light as usize].sample::<E>(rules, p, time, u)?;
        sample.multiply_pdf_by(pmf);
        Some(sample)
    }

    /// Samples the selected light of each active lane for the receiver `p` uniformly by solid angle, if it is of a kind
    /// that is sampled in lanes. Returns the lanes that [`sample`](Self::sample) has to sample.
    #[inline]
    pub fn sample_lanes(
        &self,
        active: &ActiveLanes<LANES>,
        context: &LightContextLanes,
        p: &Lanes3,
        lights: &mut LightLanes,
        samples: &mut LightSampleLanes,
    ) -> ActiveLanes<LANES> {
        let changed = active.and(|lane| lights.light[lane] != context.light[lane]);
        for lane in changed.each() {
            let light = context.light[lane];
            lights.set(lane, light, &self.lights[light as usize]);
        }
        let rectangles = active.and(|lane| lights.is_rectangle.has(lane));
        let triangles = active.and(|lane| lights.is_triangle.has(lane));
        let spheres = active.and(|lane| lights.is_sphere.has(lane));
        let in_lanes = rectangles.with(&triangles).with(&spheres);
        let mut scalar_lanes = active.without(&in_lanes);
        if rectangles.any() {
            let near =
                rectangle::sample_lanes(&lights.rectangles, &rectangles, context, p, samples);
            scalar_lanes = scalar_lanes.with(&near);
        }
        if triangles.any() {
            let skew = triangle::sample_lanes(&lights.triangles, &triangles, context, p, samples);
            scalar_lanes = scalar_lanes.with(&skew);
        }
        if spheres.any() {
            let inside = sphere::sample_lanes(&lights.spheres, &spheres, context, p, samples);
            scalar_lanes = scalar_lanes.with(&inside);
        }
        scalar_lanes
    }

    /// The density of sampling, for a receiver, the point of light `light` at `towards` from it, with normal `normal`,
    /// including the selection of the light; 0 for a light that is never selected.
    #[inline]
    pub fn pdf<E: Effects>(
        &self,
        light: u32,
        choice: LightChoice,
        receiver: &Receiver,
        time: f32,
        towards: Vec3,
        normal: Vec3,
    ) -> PdfSolidAngle {
        let pdf = self.lights[light as usize].pdf::<E>(receiver.p, time, towards, normal);
        let pmf = planted!(
            "choice-left-out-of-pdf",
            Pmf(1.0),
            self.pmf::<E>(light, choice, receiver)
        );
        pdf.map_or(PdfSolidAngle(0.0), |pdf| pmf * pdf)
    }

    /// Returns a light by its index.
    #[inline]
    pub fn get(&self, light: u32) -> &Light {
        &self.lights[light as usize]
    }

    /// Evaluates the environment map along a direction; `None` if there is no map.
    #[inline]
    pub fn environment(
        &self,
        direction: Vec3,
        sampling: EnvironmentSampling,
    ) -> Option<EnvironmentEval> {
        let (light, map) = self.map.as_ref()?;
        let (radiance, pdf) = map.eval(direction, sampling);
        Some(EnvironmentEval {
            light: *light,
            radiance,
            pdf,
        })
    }

    /// The density with which light sampling at a receiver finds the origin of an emitted ray of a light, or the ray's
    /// direction from a light at infinity: per steradian, or the probability of selecting a light that has no other point
    /// or direction.
    pub fn pdf_nee<E: Effects>(
        &self,
        light: u32,
        sample: &EmissionSample,
        rules: LightSampling,
        receiver: &Receiver,
        time: f32,
    ) -> f32 {
        match &sample.end {
            ShadowRayEnd::Surface(point, _) => {
                let towards = point.p - receiver.p;
                let pdf = self.pdf::<E>(light, rules.choice, receiver, time, towards, point.ng);
                pdf.0
            }
            ShadowRayEnd::Infinity if E::EnvironmentMap::ON && sample.pdf.can_be_hit() => {
                let pmf = self.pmf::<E>(light, rules.choice, receiver);
                let environment = self.environment(-sample.direction, rules.environment);
                environment.map_or(0.0, |environment| (pmf * environment.pdf).0)
            }
            ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => {
                self.pmf::<E>(light, rules.choice, receiver).0
            }
        }
    }

    /// The probability of selecting a light for a receiver.
    #[inline]
    pub fn pmf<E: Effects>(&self, light: u32, choice: LightChoice, receiver: &Receiver) -> Pmf {
        match &self.tree {
            Some(tree) if E::ManyLights::ON && choice == LightChoice::Contribution => {
                tree.pmf(light, receiver)
            }
            _ => self.pmf_by_power(light),
        }
    }

    /// The probability of selecting a light by power.
    #[inline]
    pub fn pmf_by_power(&self, light: u32) -> Pmf {
        self.by_power
            .as_ref()
            .map_or(Pmf(0.0), |table| table.pmf(light as usize))
    }
}
