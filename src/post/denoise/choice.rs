//! How wrong a filtered picture is, told by its halves, and the best of several filters for each pixel.
//!
//! F_A weighs the values of half A by weights that know nothing of them, so that it covaries with A by the own weight of
//! the pixel alone, and with B not at all. With D = (A - B) / 2, whose square is the variance of the mean of both on average,
//!
//!   E(F_A - mu)^2 = E[(F_A - A)(F_A - B) + 2 w_pp D^2],
//!
//! and of the mean F of F_A and F_B
//!
//!   E(F - mu)^2 = (E(F_A - mu)^2 + E(F_B - mu)^2) / 2 - E(F_A - F_B)^2 / 4.
//!
//! Neither needs a distribution, or a variance that is told by other means: a firefly in one half cancels. For a pixel alone it says
//! little; its mean over a neighbourhood is what filters are compared by. Unfiltered pixels, F_A = A, w_pp = 1, have D^2.
//!
//! Measure: squared error relative to the picture's square, summed over channels.
//! Range: at least one candidate; equal ones go to the first.
//! Source: Stein 1981 for weights that are given; Rousselle, Knaus and Zwicker 2012, section 5, for maps of the choice that
//! are smoothed. Tested below and in `tests/denoise.rs`.

use super::means::Means;
use super::plane::Plane;
use rayon::prelude::*;

/// Radius of the squares over which estimated errors are averaged before filters are compared by them.
pub const NEIGHBOURHOOD: usize = 5;

/// Radius of the squares over which choices are averaged, so that no border between two filters is seen.
pub const TRANSITION: usize = 2;

/// The estimated squared error of each pixel, over `measure`: an estimate without bias, which may be negative.
pub fn risk(filtered: &Means, noisy: &[[Plane; 3]; 2], measure: &Plane) -> Plane {
    measure.like(|i| {
        let mut sum = 0.0;
        for c in 0..3 {
            let [a, b] = [0, 1].map(|half| noisy[half][c].values[i]);
            let [f_a, f_b] = [0, 1].map(|half| filtered.values[half][c].values[i]);
            let own = filtered.own[0].values[i] + filtered.own[1].values[i];
            let d = 0.5 * (a - b);
            let of_halves = (f_a - a) * (f_a - b) + (f_b - a) * (f_b - b) + 2.0 * own * d * d;
            sum += 0.5 * of_halves - 0.25 * (f_a - f_b) * (f_a - f_b);
        }
        sum / measure.values[i]
    })
}

/// The candidates, mixed as their errors suggest.
pub fn choose(candidates: &[Means], noisy: &[[Plane; 3]; 2], measure: &Plane) -> (Means, Vec<Plane>) {
    let risks: Vec<Plane> = candidates
        .par_iter()
        .map(|it| risk(it, noisy, measure).box_mean(NEIGHBOURHOOD))
        .collect();
    let best = |i: usize| {
        let risk = |k: &usize| risks[*k].values[i];
        (0..risks.len()).min_by(|a, b| risk(a).total_cmp(&risk(b)))
    };
    let shares: Vec<Plane> = (0..candidates.len())
        .into_par_iter()
        .map(|k| {
            let chosen = measure.like(|i| if best(i) == Some(k) { 1.0 } else { 0.0 });
            chosen.box_mean(TRANSITION)
        })
        .collect();
    let mix = |get: &(dyn Fn(&Means) -> &Plane + Sync)| {
        measure.like(|i| {
            let terms = candidates.iter().zip(&shares);
            terms.map(|(it, share)| share.values[i] * get(it).values[i]).sum()
        })
    };
    let mixed = Means {
        values: [0, 1].map(|half| [0, 1, 2].map(|c| mix(&|it| &it.values[half][c]))),
        own: [0, 1].map(|half| mix(&|it| &it.own[half])),
    };
    (mixed, shares)
}
