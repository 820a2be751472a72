//! The weight window of Russian roulette: the smaller of two, if it hardly makes paths longer.
//!
//! A smaller window ends fewer paths, which has less variance and costs more rays. The rays are counted in a small pilot;
//! the variance is not measured, as its estimate scatters more than windows differ. In open scenes, whose paths end by
//! leaving, the smaller window adds few rays and removes up to a third of the squared error; in closed rooms it adds more
//! than it saves (docs/accuracy.md). It may add more rays where all light paths are connected to the lens: long paths find
//! what is left there (docs/hard-light.md).
//!
//! Measure: rays.
//! Range: renders by `path` for which no rule is named.
//! Source: none: measured. Tested in `tests/rendering/roulette.rs`.

use super::super::settings::{LightPathRule, PathReuseRule, RenderSettings};
use super::super::{RenderInput, RenderObserver, Threads};
use super::pass::pilot_settings;
use super::render_pilot;
use crate::error::Result;
use crate::film::Window;
use crate::film::filter::FilterSampling;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::integrator::roulette::WeightWindow;

/// The approximate number of pixels of the pilots' images.
const PIXELS: f64 = 1000.0;

/// The samples per pixel of the pilots' images. With this many, the counts of rays of both windows, for the same random
/// numbers, have a ratio within about 1 % of that of a whole render.
const SPP: u64 = 4;

/// The seed of the pilots.
const SEED: u64 = 0x7769_6e64_6f77;

/// The reciprocal of the smaller window.
const SMALLER: u8 = 4;

/// The ratio of the numbers of rays up to which the smaller window is chosen.
const MAX_RAYS: f64 = 1.15;

/// The ratio of the numbers of rays up to which the smaller window is chosen where every light path, not caustics alone, is
/// connected to the lens.
const MAX_RAYS_BESIDE_LIGHT_PATHS: f64 = 1.5;

/// A rule of roulette that a pilot has chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightWindowChoice {
    /// The rule.
    pub roulette: Roulette,
    /// The number of rays with the smaller window over that with the larger one.
    pub rays_of_smaller: f64,
    /// The ratio of the numbers of rays up to which the smaller window is chosen.
    pub max_rays: f64,
}

/// Chooses a rule of roulette for settings that name none.
///
/// # Errors
/// A kernel that lacks an effect of the scene.
pub fn choose(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<Option<WeightWindowChoice>> {
    let is_open = settings.has_window_pilot
        && settings.roulette.is_none()
        && settings.integrator == IntegratorKind::Path
        && settings.bounce_limit().is_none_or(|limit| limit > 1);
    let smaller = WeightWindow::reciprocal_of(SMALLER).filter(|_| is_open);
    let Some(smaller) = smaller.map(Roulette::Window) else {
        return Ok(None);
    };
    let (scene, size) = input.scene.reduced(input.size, PIXELS);
    let input = RenderInput {
        scene: &scene,
        size,
        ..*input
    };
    let rays = |roulette: Roulette| -> Result<f64> {
        let pilot = RenderSettings {
            light_paths: LightPathRule::OFF,
            // Without light paths the settings could share paths that the render does not share.
            reuse: PathReuseRule::Pixels(settings.reuse()),
            filter_sampling: FilterSampling::Importance,
            roulette: Some(roulette),
            window: Window::whole(size),
            ..pilot_settings(settings, SEED, SPP)
        };
        let rendered = render_pilot(&input, threads, &pilot, observer)?;
        Ok(rendered.rays.total() as f64)
    };
    let usual = settings.roulette();
    let rays_of_smaller = rays(smaller)? / rays(usual)?;
    let max_rays = match settings.light_path_rule() {
        LightPathRule::OFF | LightPathRule::Caustics(_) | LightPathRule::Auto => MAX_RAYS,
        LightPathRule::Share(_) => MAX_RAYS_BESIDE_LIGHT_PATHS,
    };
    let is_cheap = rays_of_smaller <= max_rays;
    Ok(Some(WeightWindowChoice {
        roulette: if is_cheap { smaller } else { usual },
        rays_of_smaller,
        max_rays,
    }))
}
