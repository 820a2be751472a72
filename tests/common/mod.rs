//! Code shared by the integration tests: random numbers, statistical verdicts, numeric integration, closed
//! forms, scenes, the command.
//!
//! Measure: stated in each module.
//! Range: every check is deterministic: its seed is fixed.
//! Source: the acceptance rule of the project's catalogue of hard cases. The harness itself is tested in
//! `tests/sampling/harness.rs`.

// Each test binary compiles this library anew and uses a part of it.
#![allow(dead_code, unused_imports)]

pub mod chi_square;
pub mod closed_forms;
pub mod error_bars;
pub mod furnished;
pub mod generated;
pub mod nightly;
pub mod quadrature;
pub mod room;
pub mod scene;
pub mod scene_folder;
pub mod session;
pub mod tracing;
pub mod verdict;

use etendue::internals::math::vec::{Vec2, Vec3};
use rand_core::Rng;
use rand_pcg::Pcg32;

/// Uniform random numbers for tests.
pub struct TestRng(Pcg32);

impl TestRng {
    /// The random stream of one seed.
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(
            seed.wrapping_mul(0x9e37_79b9_7f4a_7c15),
            seed ^ 0xda3e_39cb_94b9_5bdb,
        ))
    }

    /// A uniform number in [0, 1 - 2^-24].
    pub fn uniform(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Two uniform numbers.
    pub fn uniform_2d(&mut self) -> Vec2 {
        Vec2::new(self.uniform(), self.uniform())
    }

    /// A uniform number in [0, 1 - 2^-48], for computations in double precision.
    pub fn uniform_f64(&mut self) -> f64 {
        f64::from(self.uniform()) + f64::from(self.uniform()) / 16_777_216.0
    }

    /// A unit vector whose |z| is log-uniform in [`low`, 1], of either sign.
    pub fn direction_log_uniform(&mut self, low: f32) -> Vec3 {
        let z = low.powf(self.uniform());
        let (sin, cos) = (std::f32::consts::TAU * self.uniform()).sin_cos();
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        let sign = if self.uniform() < 0.5 { -1.0 } else { 1.0 };
        Vec3::new(r * cos, r * sin, sign * z)
    }
}
