//! The number of pixels that share their paths: the one with the least squared error for the same cost, measured in small
//! pilots. The cost is that of the rays, of which those that share paths are cheap.
//!
//! A first pilot of few samples without shared paths and with those of 16 pixels decides where the difference is clear;
//! otherwise longer pilots do, also of 4 pixels.
//!
//! The pilots are small windows of the image in its own resolution: how much pixels gain from each other depends on how near
//! to each other they see the scene.
//!
//! Measure: relMSE times cost, relative to a render without shared paths.
//! Range: renders by `path` without light paths, of scenes without motion and alpha.
//! Source: none: measured (docs/accuracy.md, "Paths shared by pixels"). Tested in `tests/rendering/reuse.rs`.

use super::super::settings::{Adaptive, PathReuseRule, RenderSettings};
use super::super::{RenderInput, RenderObserver, Threads, dispatch};
use super::pass::{pilot_settings, relative_weights, take_samples};
use super::{may_have, takes_other_paths};
use crate::effects::Effect;
use crate::error::Result;
use crate::film::batches::BATCHES;
use crate::film::{Film, Window};
use crate::image::Image;
use crate::integrator::light_paths::LightPathShare;
use crate::integrator::reuse::PathReuse;
use serde::Serialize;

/// The number of windows in a row and in a column, if the image is large enough.
const WINDOWS: [u32; 2] = [4, 3];

/// The width and the height of a window: a multiple of those of the squares within which pixels share paths.
const EDGE: u32 = 16;

/// The samples per pixel of the first pilots: one in each batch.
const FIRST_SPP: u64 = BATCHES;
/// The samples per pixel of the longer pilots.
const SPP: u64 = 8;

/// The seed of the pilots.
const SEED: u64 = 0x7265_7573_6500;

/// The least gain in a pilot for which paths are shared, since sharing correlates the noise of neighbours.
const MIN_GAIN: f64 = 1.25;

/// The gain in the first pilots from which 16 pixels share paths: groups of 4 gained at most 2 in docs/accuracy.md.
const CLEAR_GAIN: f64 = 2.5;

/// The ratio of squared errors in the first pilots below which no paths are shared, whatever the cost.
const CLEAR_LOSS: f64 = 1.1;

/// The cost of a shadow ray that shares a path, relative to that of a ray of a path. The first surfaces of sixteen pixels are
/// evaluated together, however many of them share, and only many rays are traced as a packet.
/// Measured: 1.1 to 2.1 in groups of 4 pixels, 0.3 to 0.6 in groups of 16 (cornell-box, also of principled surfaces, and
/// suzanne-room).
fn sharing_ray(reuse: PathReuse) -> f64 {
    match reuse {
        PathReuse::Off => 0.0,
        PathReuse::Four => 1.4,
        PathReuse::Sixteen => 0.4,
    }
}

/// The choice of a number of pixels that share their paths, and its reason.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathReuseChoice {
    /// The number of pixels.
    pub reuse: PathReuse,
    /// The squared error of as many samples without shared paths, over that with them, in the pilots that decided; 1 where
    /// nothing varies.
    pub ratio: f64,
    /// The squared error at equal cost without shared paths, over that with them.
    pub gain: f64,
}

/// Chooses the number of pixels that share their paths for settings by which it follows from the scene; `None` where no
/// pilot is needed.
///
/// # Errors
/// A kernel that lacks an effect of the scene.
pub fn choose(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<Option<PathReuseChoice>> {
    let may_pay = settings.reuse == PathReuseRule::Auto
        && takes_other_paths(settings)
        && settings.adaptive == Adaptive::Off
        && may_have(settings, Effect::Reuse)
        && settings.light_path_share() == LightPathShare::None
        && !settings.layers
        && dispatch::prevents_reuse(input.scene).is_none();
    if !may_pay {
        return Ok(None);
    }
    let windows = windows(input.size);
    let pilot = |reuse: PathReuse, spp: u64| -> Result<PilotResult> {
        let pilot = RenderSettings {
            reuse: PathReuseRule::Pixels(reuse),
            ..pilot_settings(settings, SEED, spp)
        };
        let films = windows.iter().map(|&window| Film::new(window, EDGE));
        let mut films: Vec<Film> = films.collect();
        let tiles = films.iter_mut().flat_map(Film::tiles_mut).collect();
        let rays = take_samples(input.scene, threads, &pilot, (tiles, None, None), observer)?;
        Ok(PilotResult {
            reuse,
            errors: squared_errors(&films),
            rays: rays.total() as f64,
        })
    };
    let alone = pilot(PathReuse::Off, FIRST_SPP)?;
    let first = pilot(PathReuse::Sixteen, FIRST_SPP)?.compared_with(&alone);
    if first.gain >= CLEAR_GAIN || first.ratio < CLEAR_LOSS {
        return Ok(Some(first.or_off()));
    }
    let alone = pilot(PathReuse::Off, SPP)?;
    let four = pilot(PathReuse::Four, SPP)?.compared_with(&alone);
    let sixteen = pilot(PathReuse::Sixteen, SPP)?.compared_with(&alone);
    let best = if four.gain > sixteen.gain {
        four
    } else {
        sixteen
    };
    Ok(Some(best.or_off()))
}

/// The result of a pilot.
struct PilotResult {
    reuse: PathReuse,
    /// The squared errors of the windows.
    errors: Vec<f64>,
    rays: f64,
}

impl PilotResult {
    /// Compares a pilot that shares paths with one of as many samples that does not.
    fn compared_with(&self, alone: &Self) -> PathReuseChoice {
        let cost = alone.rays + sharing_ray(self.reuse) * (self.rays - alone.rays);
        let ratio = cautious_ratio(&alone.errors, &self.errors);
        PathReuseChoice {
            reuse: self.reuse,
            ratio,
            gain: ratio * alone.rays / cost,
        }
    }
}

impl PathReuseChoice {
    /// This choice, or that of no shared paths, with the same numbers, if the gain is small.
    fn or_off(self) -> Self {
        let reuse = if self.gain >= MIN_GAIN {
            self.reuse
        } else {
            PathReuse::Off
        };
        Self { reuse, ..self }
    }
}

/// Windows that are spread over an image of this size, at positions that are multiples of their edge.
fn windows((width, height): (u32, u32)) -> Vec<Window> {
    let starts = |length: u32, max_count: u32| {
        let edges = length.div_ceil(EDGE);
        let count = max_count.min(edges);
        (0..count).map(move |k| (2 * k + 1) * edges / (2 * count) * EDGE)
    };
    let [columns, rows] = [starts(width, WINDOWS[0]), starts(height, WINDOWS[1])];
    let window = |x: u32, y: u32| Window {
        x,
        y,
        width: EDGE.min(width - x),
        height: EDGE.min(height - y),
    };
    rows.flat_map(|y| columns.clone().map(move |x| window(x, y)))
        .collect()
}

/// The variance of a sample over the squared truth, summed over the pixels and channels of each film.
fn squared_errors(films: &[Film]) -> Vec<f64> {
    let images: Vec<Image> = films.iter().map(Film::develop).collect();
    let mean = images.iter().flat_map(Image::mean).sum::<f64>() / (3 * films.len()) as f64;
    let of_film = |(film, image): (&Film, &Image)| {
        let weights = relative_weights(image, mean);
        let of_pixel = |(index, weights): (usize, &[f64; 3])| -> f64 {
            let variances = film.batch_means(index).variance().unwrap_or_default();
            let terms = weights.iter().zip(variances);
            terms.map(|(weight, variance)| weight * variance).sum()
        };
        weights.iter().enumerate().map(of_pixel).sum::<f64>()
    };
    films.iter().zip(&images).map(of_film).collect()
}

/// The ratio of two sums over windows: the least of those that leave out one window, since a single bright sample may have
/// most of a sum. 1 where nothing varies, and for a single window.
fn cautious_ratio(above: &[f64], below: &[f64]) -> f64 {
    let [sum_above, sum_below] = [above, below].map(|terms| terms.iter().sum::<f64>());
    let rest = above.iter().zip(below);
    let rest = rest.map(|(above, below)| (sum_above - above, sum_below - below));
    let ratios = rest.filter(|&(above, below)| above > 0.0 && below > 0.0);
    let least = ratios.map(|(above, below)| above / below).reduce(f64::min);
    least.unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cautious_ratio_ignores_a_single_outlier_window() {
        let even = [1.0; 4];
        assert_eq!(cautious_ratio(&[2.0; 4], &even), 2.0);
        assert_eq!(cautious_ratio(&[2.0, 2.0, 100.0, 2.0], &even), 2.0);
        assert_eq!(cautious_ratio(&[0.0; 4], &[0.0; 4]), 1.0);
    }

    #[test]
    fn pilot_windows_are_distinct_and_within_the_image() {
        for (size, count) in [
            ((1920, 1080), 12),
            ((64, 48), 12),
            ((63, 47), 12),
            ((40, 8), 3),
            ((1, 1), 1),
        ] {
            let windows = windows(size);
            assert_eq!(windows.len(), count, "{size:?}");
            let mut corners = std::collections::BTreeSet::new();
            for window in windows {
                assert!(window.x % EDGE == 0 && window.y % EDGE == 0);
                assert!(window.pixel_count() > 0);
                assert!(window.x + window.width <= size.0 && window.y + window.height <= size.1);
                assert!(corners.insert((window.x, window.y)), "{size:?}");
            }
        }
    }
}
