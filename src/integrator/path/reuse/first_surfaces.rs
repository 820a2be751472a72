//! The first surfaces of the pixels of a packet, and their connections to a second surface.
//!
//! Measure: densities per area of normalised scene units.
//! Range: any first surfaces; those that take part are opaque, with a BSDF that is not a delta.
//! Source: the formulas of [`super`].

use super::super::block::PathBlock;
use super::super::shading::BsdfLanes;
use crate::accel::lanes::RayLanes;
use crate::bsdf::principled::lanes::PrincipledLanes;
use crate::bsdf::{BsdfValue, Diffuse, has_lobes};
use crate::effects::{EffectState, Effects, Slot};
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec3, Vector};
use crate::planted::planted;
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;
use crate::scene::{Scene, ShapeTraits};

/// The least roughness parameter of a surface without a diffuse base that takes part: the reflections of smoother surfaces
/// come from few directions, so that the paths of other pixels contribute little.
const MIN_ALPHA: f32 = 0.1;

/// The surfaces that sixteen pixels see.
#[derive(Debug)]
pub(super) struct FirstSurfaces<E: Effects> {
    pub(super) at: InteractionLanes<E>,
    /// The reflectances of the diffuse surfaces.
    reflectance: Lanes3,
    principled: EffectState<E::Glossy, FirstPrincipled>,
    /// The pixels with other BSDFs that share.
    scalar: ActiveLanes<LANES>,
}

/// The principled BSDFs and the conductors of first surfaces, bound to the directions to the camera.
#[derive(Debug, Clone, Copy)]
struct FirstPrincipled {
    /// The pixels that have one.
    pixels: ActiveLanes<LANES>,
    bsdfs: PrincipledLanes,
    /// The values of the BSDFs for a second surface, and their densities.
    f: Lanes3,
    pdf: Lanes<f32>,
}

impl Default for FirstPrincipled {
    fn default() -> Self {
        Self {
            pixels: ActiveLanes::NONE,
            bsdfs: PrincipledLanes::default(),
            f: [[0.0; LANES]; 3],
            pdf: [0.0; LANES],
        }
    }
}

/// The connections of sixteen pixels to a second surface.
#[repr(align(64))]
#[derive(Debug, Default)]
pub(super) struct Connections {
    /// The directions from the pixels' surfaces, in the shading frames.
    wi: Lanes3,
    /// The ratios |cos| / r^2 of solid angle to the area of the surface; zero where a pixel cannot find it.
    solid_angle: Lanes<f32>,
    /// The densities g_k of the surface without visibility; zero where a pixel cannot find it.
    pub(super) density: Lanes<f32>,
    /// The factors f |cos| |cos| / r^2 of the radiance that the surface reflects.
    pub(super) factor: Lanes3,
    /// The rays from the pixels' surfaces.
    pub(super) rays: RayLanes<LANES>,
}

impl<E: Effects> Default for FirstSurfaces<E> {
    fn default() -> Self {
        Self {
            at: InteractionLanes::default(),
            reflectance: [[0.0; LANES]; 3],
            principled: Slot::new(FirstPrincipled::default),
            scalar: ActiveLanes::NONE,
        }
    }
}

impl<E: Effects> FirstSurfaces<E> {
    /// Sets the surfaces of a block of paths. Returns the pixels that share.
    pub(super) fn set(
        &mut self,
        block: &PathBlock<E>,
        at: &InteractionLanes<E>,
        bsdfs: &BsdfLanes<E>,
    ) -> ActiveLanes<LANES> {
        self.at.clone_from(at);
        let diffuse = bsdfs.diffuse_lanes(&block.active);
        let mut reflects = ActiveLanes::NONE;
        for lane in diffuse.each() {
            let reflectance = bsdfs.diffuse_bsdf(lane).reflectance();
            store(&mut self.reflectance, lane, reflectance);
            reflects.set(lane, reflectance.max_channel() > 0.0);
        }
        let mut pixels = planted!("reuse-counts-black-pixels", diffuse, reflects);
        let is_opaque = |lane: usize| at.traits[lane] & ShapeTraits::TRANSMISSIVE == 0;
        let scalar = bsdfs.scalar_lanes.without(&bsdfs.delta).and(is_opaque);
        self.scalar = if has_lobes::<E>() {
            scalar
        } else {
            ActiveLanes::NONE
        };
        for lane in self.scalar.each() {
            pixels.set(lane, true);
        }
        let Some(own) = self.principled.get_mut() else {
            return pixels;
        };
        own.pixels = rough_lanes(bsdfs);
        let Some(stage) = bsdfs.principled.get().filter(|_| own.pixels.any()) else {
            return pixels;
        };
        own.bsdfs = stage.bsdfs;
        let mut wo = [[0.0; LANES]; 3];
        for lane in own.pixels.each() {
            let at: Interaction<E> = at.get(lane);
            store(&mut wo, lane, at.frame.to_local(at.wo));
            pixels.set(lane, true);
        }
        own.bsdfs.bind(&wo);
        pixels
    }

    /// Evaluates the connections of the pixels to a second surface.
    pub(super) fn connect(
        &mut self,
        scene: &Scene,
        pixels: &ActiveLanes<LANES>,
        second: &Interaction<E, LaneVec3>,
        connections: &mut Connections,
    ) {
        connect_diffuse::<E>(pixels, &self.at, &self.reflectance, second, connections);
        if let Some(FirstPrincipled {
            pixels: own,
            bsdfs,
            f,
            pdf,
        }) = self.principled.get_mut()
            && own.any()
        {
            bsdfs.eval(&connections.wi, f, pdf);
            connect_principled(own, f, pdf, connections);
        }
        for pixel in self.scalar.and(|pixel| pixels.has(pixel)).each() {
            let at: Interaction<E> = self.at.get(pixel);
            let bsdf = scene.bsdf(&at);
            let bound = bsdf.bind::<E>(at.frame.to_local(at.wo));
            let wi: Vec3 = load(&connections.wi, pixel);
            let BsdfValue { f, pdf } = bound.eval::<E>(wi);
            connections.set(pixel, f * wi.z.abs(), pdf.0);
        }
    }
}

/// The lanes whose BSDF is evaluated in lanes, is not diffuse, and reflects light from so many directions that sharing it pays.
pub(super) fn rough_lanes<E: Effects>(bsdfs: &BsdfLanes<E>) -> ActiveLanes<LANES> {
    let Some(stage) = bsdfs.principled.get() else {
        return ActiveLanes::NONE;
    };
    stage.active.and(|lane| {
        let is_rough = stage.bsdfs.has_base(lane) || stage.bsdfs.alpha(lane) >= MIN_ALPHA;
        is_rough && stage.bsdfs.reflects(lane)
    })
}

impl Connections {
    /// Sets the connection of a pixel whose BSDF has this value, times the cosine, and this density.
    fn set(&mut self, pixel: usize, f_cos: Rgb, pdf: f32) {
        let density = pdf * self.solid_angle[pixel];
        let is_found = density > 0.0 && density < f32::INFINITY;
        self.density[pixel] = if is_found { density } else { 0.0 };
        let factor = f_cos * self.solid_angle[pixel];
        let factor = if is_found { factor } else { Rgb::BLACK };
        store(&mut self.factor, pixel, factor);
    }

    /// The reciprocal of the probability with which a path of this throughput has survived roulette: the throughput is
    /// f |cos| / p over that probability.
    pub(super) fn over_survival(&self, path: usize, beta: Rgb) -> f32 {
        let scattered = load::<Rgb>(&self.factor, path).max_channel() / self.density[path];
        beta.max_channel() / scattered
    }
}

vectorised! {
    /// Evaluates the connections of the pixels to a second surface, as those of diffuse first surfaces.
    fn connect_diffuse<E: Effects>(
        pixels: &ActiveLanes<LANES>,
        first: &InteractionLanes<E>,
        reflectance: &Lanes3,
        second: &Interaction<E, LaneVec3>,
        connections: &mut Connections,
    ) {
        let (point, normal) = (second.surface_point(), second.exit_normal(false));
        for lane in 0..LANES {
            let at: Interaction<E, LaneVec3> = first.get(lane);
            let to = point.p - at.p;
            let distance2 = to.dot(to);
            let wi = to * (1.0 / distance2.sqrt());
            let bsdf = Diffuse::<LaneVec3>::new(load(reflectance, lane));
            let [wo_local, wi_local] = [at.wo, wi].map(|w| at.frame.to_local(w));
            let BsdfValue { f, pdf } = bsdf.eval(wo_local, wi_local);
            let cos = -wi.dot(normal);
            let is_found = pixels.has(lane)
                & (cos > 0.0)
                & at.is_consistent_side(wi, false)
                & planted!("reuse-ignores-tilt", true, !second.is_tilted_for(-wi));
            let solid_angle = if is_found { cos / distance2 } else { 0.0 };
            let density = pdf.0 * planted!("reuse-without-cosine", 1.0 / distance2, solid_angle);
            let is_found = is_found & (density > 0.0) & (density < f32::INFINITY);
            store(&mut connections.wi, lane, wi_local);
            connections.solid_angle[lane] = solid_angle;
            connections.density[lane] = if is_found { density } else { 0.0 };
            let factor = f * (wi_local.z().abs() * solid_angle);
            let none = Rgb::<LaneVec3>::from([0.0; 3]);
            store(&mut connections.factor, lane, if is_found { factor } else { none });
            let ray = at.ray_to_surface(&point, wi, false);
            connections.rays.set(lane, &ray);
            connections.rays.time[lane] = 0.0;
        }
    }
}

vectorised! {
    /// Replaces the connections of these pixels by those of BSDFs with these values and densities.
    fn connect_principled(
        pixels: &ActiveLanes<LANES>,
        f: &Lanes3,
        pdf: &Lanes<f32>,
        connections: &mut Connections,
    ) {
        for (lane, &pdf) in pdf.iter().enumerate() {
            let solid_angle = connections.solid_angle[lane];
            let density = pdf * solid_angle;
            let is_found = (density > 0.0) & (density < f32::INFINITY);
            let density = if is_found { density } else { 0.0 };
            let value: Rgb<LaneVec3> = load(f, lane);
            let factor = value * (connections.wi[2][lane].abs() * solid_angle);
            let none = Rgb::<LaneVec3>::from([0.0; 3]);
            let factor = if is_found { factor } else { none };
            let is_own = pixels.has(lane);
            let kept: Rgb<LaneVec3> = load(&connections.factor, lane);
            store(&mut connections.factor, lane, if is_own { factor } else { kept });
            let kept = connections.density[lane];
            connections.density[lane] = if is_own { density } else { kept };
        }
    }
}
