//! Watching a path as it is built, at no cost when nobody does.
//!
//! Measure: normalised scene units; radiance.
//! Range: every vertex of every path.
//! Source: none needed. Tested through `etendue render --pixel`, in `tests/command.rs`.

use crate::bsdf::types::Lobe;
use crate::effects::Effects;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use crate::scene::interaction::Interaction;

/// What an integrator tells of a path. Every method does nothing unless it is implemented.
pub trait PathObserver {
    /// The path came to a surface with this throughput.
    fn arrived<E: Effects>(&mut self, _at: &Interaction<E>, _beta: Rgb) {}
    /// The path left the scene along this direction.
    fn escaped(&mut self, _direction: Vec3) {}
    /// Emission found by scattering was added, with this weight against light sampling.
    fn emission(&mut self, _contribution: Rgb, _weight: f32) {}
    /// Light sampling found this contribution, with this weight; `visible` tells what the shadow ray said.
    fn light(&mut self, _contribution: Rgb, _weight: f32, _visible: f32) {}
    /// The path was scattered.
    fn scattered(&mut self, _wi: Vec3, _lobe: Lobe, _beta: Rgb) {}
    /// The path ended by Russian roulette, which let it survive with this probability.
    fn terminated(&mut self, _survival: f32) {}
}

/// Nobody watches.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unobserved;

impl PathObserver for Unobserved {}
