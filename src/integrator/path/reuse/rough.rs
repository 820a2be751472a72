//! Rough second surfaces: the light samples and the BSDF samples that several pixels share there.
//!
//! Measure: densities per area of normalised scene units, and per steradian.
//! Range: principled BSDFs and conductors that are evaluated in lanes.
//! Source: the formulas of [`super`].

use crate::bsdf::principled::lanes::PrincipledLanes;
use crate::effects::Effects;
use crate::math::lanes::{ActiveLanes, LANES, Lanes, Lanes3, load, store, vectorised};
use crate::math::rgb::Rgb;
use crate::math::vec::{LaneVec3, Vec3};
use crate::scene::interaction::Interaction;
use crate::scene::interaction::lanes::InteractionLanes;

/// A rough second surface that is shared.
#[derive(Debug)]
pub(super) struct RoughSecondSurface {
    /// The sample of its path, and its lane in the block.
    pub(super) sample: usize,
    pub(super) lane: usize,
    /// The connections of the pixels, with visibility, and with the factors over the probability of survival.
    pub(super) density: Lanes<f32>,
    pub(super) factor: Lanes3,
    /// The directions to the pixels' surfaces, in the shading frame.
    pub(super) wo: Lanes3,
}

/// A BSDF as it is seen by sixteen pixels: its values for one direction, and their densities.
#[derive(Debug, Default)]
pub(super) struct SeenSurface {
    pub(super) bsdfs: PrincipledLanes,
    pub(super) f: Lanes3,
    pub(super) pdf: Lanes<f32>,
}

/// The light that light sampling finds at rough second surfaces: its weights are not those of the light found beyond.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightAtRough {
    /// The shared paths with such a surface.
    pub(super) paths: ActiveLanes<LANES>,
    pub(super) light: Lanes3,
    pub(super) factors: [Lanes3; LANES],
}

impl Default for LightAtRough {
    fn default() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self {
            paths: ActiveLanes::NONE,
            light: zero,
            factors: [zero; LANES],
        }
    }
}

/// The sums over the pixels that see a second surface.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct DensitySums {
    /// The sum of the densities of the surface.
    pub(super) density: f32,
    /// The sum of the products of the densities of the surface and of the direction.
    pub(super) density_with_pdf: f32,
}

impl DensitySums {
    /// The mean density of the direction.
    pub(super) fn pdf(self) -> f32 {
        self.density_with_pdf / self.density
    }
}

impl SeenSurface {
    /// Evaluates the BSDF for a direction.
    pub(super) fn evaluate(&mut self, wi: Vec3) {
        let wi = wi.to_array().map(|x| [x; LANES]);
        self.bsdfs.eval(&wi, &mut self.f, &mut self.pdf);
    }

    /// The sums of the densities for the direction.
    pub(super) fn sums(&self, second: &RoughSecondSurface) -> DensitySums {
        let mut sums = DensitySums::default();
        for (&density, &pdf) in second.density.iter().zip(&self.pdf) {
            if density > 0.0 {
                sums.density += density;
                sums.density_with_pdf += density * pdf;
            }
        }
        sums
    }

    /// Computes the factor of each pixel, with a common scale. Returns the throughput, by which they are divided.
    pub(super) fn factors(
        &self,
        second: &RoughSecondSurface,
        scale: f32,
        factors: &mut Lanes3,
    ) -> f32 {
        let mut total = Rgb::BLACK;
        for pixel in 0..LANES {
            let mut factor = Rgb::BLACK;
            if second.density[pixel] > 0.0 {
                let connected: Rgb = load(&second.factor, pixel);
                factor = scale * (connected * load::<Rgb>(&self.f, pixel));
            }
            store(factors, pixel, factor);
            total += factor;
        }
        normalise(factors, total)
    }
}

/// Divides the factors of all pixels by the throughput of a path, the largest channel of their sum, and returns it. Unless it
/// is finite and above 0, all are set to 0.
pub(super) fn normalise(factors: &mut Lanes3, total: Rgb) -> f32 {
    let throughput = total.max_channel();
    if !is_positive(throughput) {
        *factors = [[0.0; LANES]; 3];
        return 0.0;
    }
    *factors = factors.map(|channel| channel.map(|factor| factor / throughput));
    throughput
}

/// Whether a number is finite and above 0.
pub(super) fn is_positive(x: f32) -> bool {
    x.is_finite() && x > 0.0
}

vectorised! {
    /// The directions from a second surface to the first ones, in its shading frame.
    pub(super) fn directions_to_first_surfaces<E: Effects>(
        first: &InteractionLanes<E>,
        second: &Interaction<E, LaneVec3>,
        wo: &mut Lanes3,
    ) {
        for lane in 0..LANES {
            let to: LaneVec3 = load::<LaneVec3>(&first.p, lane) - second.p;
            let to = to * (1.0 / to.dot(to).sqrt());
            store(wo, lane, second.frame.to_local(to));
        }
    }
}
