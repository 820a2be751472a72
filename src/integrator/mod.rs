//! Estimators of the radiance that arrives along a camera ray.
//!
//! An integrator is handed one sample at a time and knows nothing of pixels, passes or threads.

pub mod observer;
pub mod path;

use crate::math::rgb::Rgb;

/// How many rays were traced, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From a scattering event, for the closest hit.
    pub closest: u64,
    /// To a light, for visibility.
    pub shadow: u64,
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.camera + self.closest + self.shadow
    }
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.closest += other.closest;
        self.shadow += other.shadow;
    }
}

/// When a path ends by chance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Roulette {
    /// Never: only absorption and the bounce limit end it.
    None,
    /// With a probability that follows the path's throughput.
    #[default]
    Throughput,
}

impl Roulette {
    /// The probability with which a path goes on after its scattering event number `bounce`, given its throughput.
    ///
    /// Paths that lose nothing would never end in a closed scene: after many bounces they get an upper limit.
    #[inline]
    pub fn survival(self, bounce: u32, beta: Rgb) -> f32 {
        const PATIENCE: u32 = 32;
        const LONG_RUN: f32 = 0.99;
        match self {
            Self::None => 1.0,
            Self::Throughput => {
                let limit = if bounce < PATIENCE { 1.0 } else { LONG_RUN };
                beta.max_channel().min(limit)
            }
        }
    }
}
