//! Light paths beside camera paths: paths from lights, each of whose surfaces is connected to the lens.
//!
//! A path from a light x_0 to the camera x_n is found by a camera path that scatters towards the light (s = 0), by light
//! sampling from a camera path (s = 1), and by a light path whose last surface is connected to the lens (t = 1). The
//! estimate of a pixel is
//!
//!   sum_{camera paths} (w_0 C_0 + w_1 C_1) + 1/N sum_{light paths} sum_i h w_t C_t(x_1 ... x_i),
//!
//! where the second sum is over all N light paths of the film, and h is the pixel's filter around the place where x_i is
//! seen. The weights w, by the power heuristic, sum to one for every path (`weights.rs`). Light paths find the light that
//! glass and metal throw onto matte surfaces; nothing is stored, and surfaces are not connected to each other.
//!
//! Among matte surfaces light sampling finds the light as well. Where light paths are for caustics only, they are connected to
//! the lens at those surfaces alone that lie beyond a glossy or smooth one, and all other paths have the weights of camera
//! paths alone: each path has either three strategies or two, by its own surfaces, whichever end it is traced from.
//!
//! Measure: radiance; splats as in `film/splats.rs`.
//! Range: any scene. No strategy finds a path from a light that no ray can hit, such as a point light, if the first surfaces
//! from both ends scatter by delta lobes.
//! Source: Veach 1997, chapter 10; Georgiev, Křivánek, Davidovič and Slusallek 2012, "Light Transport Simulation with
//! Vertex Connection and Merging", for weights in constant memory. Tested in `tests/rendering/light_paths.rs`.

pub mod source;
pub mod weights;

use crate::film::splats::Splat;
use crate::math::lanes::{ActiveLanes, LANES};
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::sampler::{Decision, LaneStates, Sampler};
use serde::Serialize;

/// The number of light paths for each camera path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum LightPathShare {
    /// None.
    #[default]
    None,
    /// One for every fourth camera path.
    Quarter,
    /// One for every other camera path.
    Half,
    /// One for each.
    One,
    /// Two for each.
    Two,
}

impl LightPathShare {
    /// Every number.
    pub const ALL: &'static [Self] = &[Self::None, Self::Quarter, Self::Half, Self::One, Self::Two];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "off",
            Self::Quarter => "1/4",
            Self::Half => "1/2",
            Self::One => "1",
            Self::Two => "2",
        }
    }

    /// The number.
    #[inline]
    pub fn number(self) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Quarter => 0.25,
            Self::Half => 0.5,
            Self::One => 1.0,
            Self::Two => 2.0,
        }
    }

    /// The samples, among those of the active lanes, that have a light path; there is a sampler for each lane. Where not every
    /// sample has one, a random number of the sample decides, so that no sample depends on others; the total number of light
    /// paths then varies.
    #[inline]
    pub fn lanes_with_path<S: Sampler>(
        self,
        samplers: &mut [S],
        active: &ActiveLanes<LANES>,
    ) -> ActiveLanes<LANES> {
        let number = self.number();
        if number >= 1.0 {
            return *active;
        }
        let lane_indices = std::array::from_fn(|lane| lane as u32);
        let states = LaneStates::gather(samplers, active, &lane_indices);
        let mut u = [0.0; LANES];
        let numbers = std::array::from_mut(&mut u);
        S::draw_lanes(
            samplers,
            active,
            &lane_indices,
            &states,
            Decision::LightPath,
            numbers,
        );
        active.and(|lane| u[lane] < number)
    }
}

/// The light paths of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LightPaths {
    /// The number for each camera path.
    pub share: LightPathShare,
    /// The number of pixels over which the camera paths are spread.
    pub pixels: u64,
    /// Whether only caustics are found: paths with a glossy or smooth surface between their first and their last one.
    pub caustics_only: bool,
}

impl LightPaths {
    /// No light paths.
    pub const NONE: Self = Self {
        share: LightPathShare::None,
        pixels: 0,
        caustics_only: false,
    };

    /// Whether there are any.
    #[inline]
    pub fn is_on(self) -> bool {
        self.share != LightPathShare::None
    }

    /// The expected number of light paths for one sample of every pixel.
    #[inline]
    pub fn expected_count(self) -> f32 {
        self.share.number() * self.pixels as f32
    }
}

/// The splats of the light paths of a wavefront, and a test of where splats count.
pub struct LightPathSplats<'a> {
    /// Whether a splat at a film position would count.
    pub reaches: &'a dyn Fn(Vec2) -> bool,
    /// Whether the gains of splats are wanted.
    pub with_gains: bool,
    /// The splats.
    pub splats: Vec<LightPathSplat>,
}

/// A splat of a light path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPathSplat {
    /// The index of the light path among the samples.
    pub sample_index: u32,
    /// The splat.
    pub splat: Splat,
    /// The variance that the light path saves, in squares of the splat's unit; zero unless gains are wanted.
    pub gain: Rgb,
    /// Whether the light path is a caustic.
    pub is_caustic: bool,
}
