//! The error of a filtered image, estimated from its halves, and the choice of the best of several filters for each
//! pixel.
//!
//! F_A weighs the values of half A by weights that are independent of them, so its covariance with A comes from the
//! pixel's own weight w_pp alone. With D = (A - B) / 2, whose square is half of the variance of A on average,
//!
//!   E(F_A - mu)^2 = E[(F_A - A)^2 - 2 D^2 + 4 w_pp D^2],
//!
//! and for the mean F of F_A and F_B
//!
//!   E(F - mu)^2 = (E(F_A - mu)^2 + E(F_B - mu)^2) / 2 - E(F_A - F_B)^2 / 4.
//!
//! Neither assumes a distribution, or needs another estimate of the variance: a firefly in one half cancels in the
//! sum of both. B could be used in place of A, but with more error: the weights of F_A prefer pixels that look like
//! B, noise included. For a single pixel the estimate is very noisy; filters are compared by its mean over a
//! neighbourhood. Unfiltered pixels, F_A = A, w_pp = 1, have D^2.
//!
//! Measure: squared radiance; relative to the squared image where filters are compared.
//! Range: at least one candidate; the first is preferred.
//! Source: Stein 1981 for fixed weights; Rousselle, Knaus and Zwicker 2012, section 5, for smoothed maps of the
//! choice. Tested below and in `tests/rendering/denoise.rs`.

use super::Filtered;
use super::means::Means;
use super::noisy::NoisyImage;
use crate::image::Image;
use crate::math::plane::Plane;
use crate::math::rgb::Rgb;
use rayon::prelude::*;

/// Radius of the squares over which estimated errors are averaged before filters are compared by them.
const NEIGHBOURHOOD: usize = 5;

/// The number of standard errors by which a filter has to be better than the preferred one.
const DOUBT: f32 = 2.0;

/// Radius of the squares over which choices are averaged, so that no border between two filters is visible.
const TRANSITION: usize = 2;

/// The estimated squared error of each pixel in each channel: unbiased, so it may be negative.
pub fn risks(filtered: &Means, noisy: &[[Plane; 3]; 2]) -> [Plane; 3] {
    [0, 1, 2].map(|c| {
        let [noisy_a, noisy_b] = [0, 1].map(|half| &noisy[half][c].values);
        let [filtered_a, filtered_b] = [0, 1].map(|half| &filtered.values[half][c].values);
        noisy[0][c].like(|i| {
            let [a, b, f_a, f_b] = [noisy_a[i], noisy_b[i], filtered_a[i], filtered_b[i]];
            let own = filtered.own[0].values[i] + filtered.own[1].values[i];
            let d = 0.5 * (a - b);
            let square = |x: f32| x * x;
            let of_halves = square(f_a - a) + square(f_b - b) + 4.0 * (own - 1.0) * d * d;
            0.5 * of_halves - 0.25 * (f_a - f_b) * (f_a - f_b)
        })
    })
}

/// The mean of both halves.
pub fn whole(filtered: &Means) -> [Plane; 3] {
    let [a, b] = &filtered.values;
    [0, 1, 2].map(|c| a[c].like(|i| 0.5 * (a[c].values[i] + b[c].values[i])))
}

/// The denominators of relMSE: the squared image plus a hundredth of its squared mean.
pub fn measure(picture: &[Plane; 3]) -> [Plane; 3] {
    let pixels = picture.iter().flat_map(|plane| &plane.values);
    let sum: f64 = pixels.map(|&x| f64::from(x)).sum();
    let mean = sum / (3 * picture[0].values.len()) as f64;
    let epsilon = (0.01 * mean * mean) as f32;
    picture
        .each_ref()
        .map(|plane| plane.like(|i| plane.values[i] * plane.values[i] + epsilon))
}

/// Squared errors over their measure, averaged over the channels; 0 where both are 0.
pub fn relative(risks: &[Plane; 3], measure: &[Plane; 3]) -> Plane {
    risks[0].like(|i| {
        let terms = risks.iter().zip(measure);
        let sum: f32 = terms
            .map(|(risk, measure)| risk.values[i] / (measure.values[i] + f32::MIN_POSITIVE))
            .sum();
        sum / 3.0
    })
}

/// Selects the first candidate for each pixel, or another one where that is significantly better, and mixes them.
pub fn choose(candidates: &[Means], noisy: &[[Plane; 3]; 2], measure: &[Plane; 3]) -> Means {
    let errors: Vec<Plane> = candidates
        .par_iter()
        .map(|it| relative(&risks(it, noisy), measure))
        .collect();
    // The least gain of each candidate over the first; 0 for the first.
    let gains: Vec<Plane> = errors
        .par_iter()
        .map(|it| sure_gain(it, &errors[0]))
        .collect();
    let best = |i: usize| {
        let gain = |k: &usize| gains[*k].values[i];
        // Ties go to the first.
        let order = |a: &usize, b: &usize| gain(a).total_cmp(&gain(b)).then(b.cmp(a));
        (0..gains.len()).max_by(order)
    };
    let shares: Vec<Plane> = (0..candidates.len())
        .into_par_iter()
        .map(|k| {
            let chosen = gains[0].like(|i| if best(i) == Some(k) { 1.0 } else { 0.0 });
            chosen.box_mean(TRANSITION)
        })
        .collect();
    let mix = |get: &dyn Fn(&Means) -> &Plane| {
        gains[0].like(|i| {
            let terms = candidates.iter().zip(&shares);
            terms
                .map(|(it, share)| share.values[i] * get(it).values[i])
                .sum()
        })
    };
    Means {
        values: [0, 1].map(|half| [0, 1, 2].map(|c| mix(&|it| &it.values[half][c]))),
        own: [0, 1].map(|half| mix(&|it| &it.own[half])),
    }
}

/// The mean gain of `error` over `other` in each neighbourhood, less its standard error times [`DOUBT`]: the minimum
/// of several noisy errors would otherwise be selected by chance.
fn sure_gain(error: &Plane, other: &Plane) -> Plane {
    let gain = error.like(|i| other.values[i] - error.values[i]);
    let mean = gain.box_mean(NEIGHBOURHOOD);
    let square = gain
        .like(|i| gain.values[i] * gain.values[i])
        .box_mean(NEIGHBOURHOOD);
    let side = (2 * NEIGHBOURHOOD + 1) as f32;
    mean.like(|i| {
        let mean = mean.values[i];
        let variance = (square.values[i] - mean * mean).max(0.0) / (side * side);
        mean - DOUBT * variance.sqrt()
    })
}

impl Filtered {
    /// Builds a filtered image, from unbiased estimates of its squared errors; `floor` is a lower bound of these.
    pub(super) fn assessed(
        picture: &[Plane; 3],
        risks: &[Plane; 3],
        floor: &[Plane; 3],
        noisy: &NoisyImage,
    ) -> Self {
        let measure = measure(picture);
        let [width, height] = noisy.size().map(|side| side as u32);
        let image = |get: &dyn Fn(usize, usize) -> f32| {
            let pixels =
                (0..picture[0].values.len()).map(|i| Rgb::from([0, 1, 2].map(|c| get(i, c))));
            Image::new(width, height, pixels.collect())
        };
        // Both are smoothed relative to the image, so that the error of a lamp does not spread to the wall beside it.
        let smooth = |errors: &[Plane; 3]| {
            [0, 1, 2].map(|c| {
                let measure = &measure[c].values;
                let share =
                    errors[c].like(|i| errors[c].values[i] / (measure[i] + f32::MIN_POSITIVE));
                share.box_mean(NEIGHBOURHOOD)
            })
        };
        let (risk, least) = (smooth(risks), smooth(floor));
        let error = |i: usize, c: usize| {
            let share = risk[c].values[i].max(least[c].values[i]).max(0.0);
            (share * measure[c].values[i]).sqrt()
        };
        let root = |errors: &[Plane; 3]| mean(&relative(errors, &measure));
        let is_black = picture.iter().flat_map(|it| &it.values).all(|&x| x == 0.0);
        Self {
            image: image(&|i, c| picture[c].values[i]),
            errors: image(&error),
            error: (!is_black).then(|| root(risks).max(root(floor)).sqrt()),
        }
    }
}

fn mean(plane: &Plane) -> f64 {
    let sum: f64 = plane.values.iter().map(|&x| f64::from(x)).sum();
    sum / plane.values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    const SIDE: usize = 64;

    /// Uniform noise of this variance.
    fn noise(rng: &mut Pcg32, variance: f32) -> f32 {
        (12.0 * variance).sqrt() * (rng.next_u32() as f32 / 4_294_967_296.0 - 0.5)
    }

    /// A linear ramp and its halves, whose noise has variance 0.08.
    fn slope(seed: u64) -> (Plane, [[Plane; 3]; 2]) {
        let mut rng = Pcg32::new(seed, 1);
        let values = (0..SIDE * SIDE).map(|i| 1.0 + 0.3 * (i % SIDE) as f32);
        let truth = Plane::new(SIDE, SIDE, values.collect());
        let mut half = || {
            [0, 1, 2].map(|_| {
                let noisy = truth.values.iter().map(|mu| mu + noise(&mut rng, 0.08));
                Plane::new(SIDE, SIDE, noisy.collect())
            })
        };
        let halves = [half(), half()];
        (truth, halves)
    }

    /// Each pixel as the mean of itself and its right neighbour: a weight of a half, and a bias of 0.15.
    fn shifted(halves: &[[Plane; 3]; 2]) -> Means {
        let mean = |plane: &Plane| {
            plane.like(|i| {
                let right = plane.at((i % SIDE + 1) as isize, (i / SIDE) as isize);
                0.5 * (plane.values[i] + right)
            })
        };
        let own = halves[0][0].like(|i| if i % SIDE + 1 == SIDE { 1.0 } else { 0.5 });
        Means {
            values: halves.each_ref().map(|half| half.each_ref().map(mean)),
            own: [own.clone(), own],
        }
    }

    /// The risk, estimated without the truth, is the noise of the mean of two halves over two pixels, 0.08 / 4, plus
    /// the squared bias.
    #[test]
    fn estimated_risk_matches_the_expected_squared_error() {
        let mut ratios = Vec::new();
        for seed in 0..20 {
            let (truth, halves) = slope(seed);
            let filtered = shifted(&halves);
            let [estimated, ..] = risks(&filtered, &halves);
            let [picture, ..] = whole(&filtered);
            let error = truth.like(|i| (picture.values[i] - truth.values[i]).powi(2));
            let exact = (0.02 + 0.15 * 0.15) * (1.0 - 1.0 / SIDE as f64) + 0.04 / SIDE as f64;
            assert!((mean(&error) / exact - 1.0).abs() < 0.1);
            ratios.push(mean(&estimated) / exact);
        }
        // 80 000 pixels give it to 0.3 %.
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!((mean - 1.0).abs() < 0.015, "{mean}");
    }

    #[test]
    fn filter_choice_requires_a_significant_gain() {
        let (_, halves) = slope(77);
        let ones = halves[0][0].like(|_| 1.0);
        let unfiltered = Means {
            values: halves.clone(),
            own: [ones.clone(), ones.clone()],
        };
        let measure = [ones.clone(), ones.clone(), ones];
        // Unfiltered, the error is 0.04, and 0.0425 with the neighbour: too close to change.
        let kept = choose(&[unfiltered.clone(), shifted(&halves)], &halves, &measure);
        let differs = |i: &usize| kept.values[0][0].values[*i] != halves[0][0].values[*i];
        let changed = (0..SIDE * SIDE).filter(differs).count();
        assert!(changed < SIDE * SIDE / 8, "{changed}");
        // Against a candidate that is much worse, the unfiltered pixels are chosen.
        let mut worse = unfiltered.clone();
        for channel in worse.values.iter_mut().flatten() {
            *channel = channel.like(|i| channel.values[i] + 1.0);
        }
        let chosen = choose(&[worse, unfiltered], &halves, &measure);
        assert_eq!(chosen.values, halves);
    }
}
