//! The number of light paths beside camera paths: by the share of the squared error that they would remove, measured by
//! themselves in a small pilot.
//!
//! The error of camera paths alone cannot be measured in a pilot where light paths pay most: it is that of rare bright
//! samples, of which a pilot has none. So the pilot renders with light paths, and each of them tells by how much the
//! variance of its own contribution would be larger without ([`LightRatios::gain`]). With V the variance of a sample of the
//! pilot and D the sum of these gains for a sample, both over the squared truth, light paths pay if 1 + D / V is above the
//! ratio of the times of a sample, which docs/hard-light.md has for several scenes. Where the gains of light paths that are no
//! caustics are small, only caustics are connected to the lens, which takes less time.
//!
//! V is too small where a pilot lacks rare bright samples of paths that no light path finds, such as caustics seen through
//! glass. Light paths are then chosen although they remove a small part of the error (water in docs/hard-light.md).
//!
//! Measure: relative variance.
//! Range: any scene; without a shape that casts caustics there is no pilot, and there are no light paths.
//! Source: the second moment of a multi-sample estimator, Veach 1997, section 9.2. Tested in
//! `tests/rendering/light_paths.rs`.
//!
//! [`LightRatios::gain`]: crate::integrator::light_paths::weights::LightRatios::gain

use super::super::gain_sums::GainSums;
use super::super::settings::{LightPathRule, RenderSettings};
use super::super::{RenderInput, RenderObserver, Threads};
use super::pass::{pilot_settings, relative_weights, take_samples};
use super::{may_have, takes_other_paths};
use crate::effects::Effect;
use crate::error::Result;
use crate::film::batches::BATCHES;
use crate::film::filter::FilterSampling;
use crate::film::splats::Splats;
use crate::film::{Film, Window};
use crate::integrator::light_paths::LightPathShare;
use serde::Serialize;

/// The approximate number of pixels of the pilot's image.
const PIXELS: f64 = 1600.0;

/// The samples per pixel of the pilot's image.
const SPP: u64 = 32;

/// The seed of the pilot.
const SEED: u64 = 0x6c69_6768_7400;

/// The number of light paths for each camera path where only caustics pay, and in the pilot. In the scenes of
/// docs/hard-light.md it is nowhere worse than a half by more than 3 %.
const SHARE: LightPathShare = LightPathShare::Quarter;

/// The number of light paths for each camera path where others than caustics pay: 1.4 times as efficient as a quarter in
/// shaded-lamps.
const SHARE_OF_ALL: LightPathShare = LightPathShare::One;

/// The choice of a number of light paths, and its reason.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LightPathChoice {
    /// The number for each camera path, and which of them are connected to the lens.
    pub rule: LightPathRule,
    /// The squared error of as many samples without light paths, over that with them.
    pub ratio: f64,
}

impl LightPathChoice {
    /// The ratio of variances above which light paths pay: a pilot that has not sampled the rarest paths measures less than there
    /// is.
    pub const MIN_RATIO: f64 = 1.2;

    /// The ratio of variances above which light paths that are no caustics pay beside those that are.
    const MIN_RATIO_OF_OTHERS: f64 = 1.1;
}

/// Chooses the number of light paths for settings by which it follows from the scene; `None` where no pilot is needed.
///
/// # Errors
/// A kernel that lacks an effect of the scene.
pub fn choose(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<Option<LightPathChoice>> {
    let may_pay = settings.light_paths == LightPathRule::Auto
        && input.scene.casts_caustics()
        && takes_other_paths(settings)
        && may_have(settings, Effect::LightPaths)
        && !settings.reuse().is_on();
    if !may_pay {
        return Ok(None);
    }
    let (scene, size) = input.scene.reduced(input.size, PIXELS);
    let window = Window::whole(size);
    let pilot = RenderSettings {
        light_paths: LightPathRule::Share(SHARE),
        // A window that settings name must not lead to another choice than the same one, chosen by its own pilot.
        roulette: None,
        filter_sampling: FilterSampling::Importance,
        window,
        ..pilot_settings(settings, SEED, SPP)
    };
    let mut film = Film::new(window, pilot.tile_size).with_splats();
    let gains = GainSums::new(window);
    let (tiles, splats) = film.tiles_and_splats();
    let sums = (tiles.iter_mut().collect(), splats, Some(&gains));
    take_samples(&scene, threads, &pilot, sums, observer)?;
    let saved = [&gains.caustics, &gains.others].map(|gains| saved_over_rest(&film, gains));
    let [of_caustics, of_others] = saved;
    let ratio = 1.0 + of_caustics + of_others;
    let rule = if ratio <= LightPathChoice::MIN_RATIO {
        LightPathRule::OFF
    } else if 1.0 + of_others < LightPathChoice::MIN_RATIO_OF_OTHERS {
        LightPathRule::Caustics(SHARE)
    } else {
        LightPathRule::Share(SHARE_OF_ALL)
    };
    Ok(Some(LightPathChoice { rule, ratio }))
}

/// The variance that light paths save, over that which is left, both over the squared truth: a mean over 25 pixels. 0 where
/// nothing varies.
fn saved_over_rest(film: &Film, gains: &Splats) -> f64 {
    let window = film.window();
    let image = film.develop();
    let mean = image.mean().iter().sum::<f64>() / 3.0;
    // Splats are in units of radiance times pixels, and the variance of the mean of all samples is wanted.
    let samples = (window.pixel_count() * SPP) as f64;
    let (mut saved, mut with) = ([0.0; BATCHES as usize], 0.0);
    for (pixel, scales) in relative_weights(&image, mean).iter().enumerate() {
        let variances = film.batch_means(pixel).variance().unwrap_or_default();
        let of_gains = gains.pixel(pixel).values();
        for (c, scale) in scales.iter().enumerate() {
            with += scale * variances[c] / SPP as f64;
            for (saved, of_batch) in saved.iter_mut().zip(&of_gains) {
                *saved += scale * of_batch[c] / (samples * samples);
            }
        }
    }
    // A single path may have most of a batch's gain: the median is a cautious estimate.
    saved.sort_by(f64::total_cmp);
    let median = 0.5 * (saved[1] + saved[2]);
    if with > 0.0 {
        BATCHES as f64 * median / with
    } else {
        0.0
    }
}
