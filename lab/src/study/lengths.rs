//! The cost and the contribution of each further bounce: renders with growing limits of bounces and the same random
//! numbers, in turn.
//!
//! Roulette ends the same paths under any limit, so that two limits differ in one bounce only.
//!
//! Measure: shares of the time and of the light of the whole image.
//! Range: at least one round; shares of time are as uncertain as timings of that length.
//! Source: none needed. Tested in `lab/tests/reports/study.rs`.

use super::prepared_scene::PreparedScene;
use super::variant::Variant;
use etendue::Result;
use etendue::internals::math::stats::{Moments, Spread};
use etendue::internals::render::RenderObserver;
use serde::Serialize;

/// Number of limits that are measured, besides no limit.
const LIMITS: u32 = 5;

/// The contribution of one more bounce.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BounceCost {
    /// Number of scattering events; `None` for all further ones.
    pub bounces: Option<u32>,
    /// Its share of the time.
    pub time: Spread,
    /// Its share of the light.
    pub energy: f64,
    /// The standard error of `energy`; 0 for one round.
    pub energy_error: f64,
}

/// The limits; the last one is no limit.
fn limits() -> impl Iterator<Item = Option<u32>> {
    (0..=LIMITS).map(|limit| (limit < LIMITS).then_some(limit))
}

/// Number of renders in a round.
pub const RENDERS: u64 = LIMITS as u64 + 1;

/// Renders all limits in rounds; `None` if cancelled.
///
/// # Errors
/// As a render.
pub fn bounce_costs(
    prepared: &PreparedScene,
    variant: &Variant,
    spp: u64,
    seeds: &[u64],
    observer: &dyn RenderObserver,
) -> Result<Option<Vec<BounceCost>>> {
    let mut rounds = Vec::new();
    for &seed in seeds {
        let mut round = Vec::new();
        for limit in limits() {
            let mut settings = prepared.settings(variant, spp, seed);
            settings.max_bounces = limit;
            let Some(shot) = prepared.render(variant, &settings, observer)? else {
                return Ok(None);
            };
            let light: f64 = shot.film.mean().iter().sum();
            round.push([shot.seconds.wall, light]);
        }
        rounds.push(round);
    }
    Ok(Some(costs(&rounds)))
}

/// Computes the costs from (seconds, light) of each limit, in rounds.
fn costs(rounds: &[Vec<[f64; 2]>]) -> Vec<BounceCost> {
    if rounds.is_empty() {
        return Vec::new();
    }
    let added = |index: usize, what: usize| {
        let share = move |round: &Vec<[f64; 2]>| {
            let before = index
                .checked_sub(1)
                .map_or(0.0, |before| round[before][what]);
            let whole = round.last().map_or(f64::NAN, |last| last[what]);
            (round[index][what] - before) / whole
        };
        rounds.iter().map(share).collect::<Vec<f64>>()
    };
    let cost = |(index, bounces): (usize, Option<u32>)| {
        let energy = Moments::of(added(index, 1));
        BounceCost {
            bounces,
            time: Spread::of(added(index, 0)),
            energy: energy.mean(),
            energy_error: energy.standard_error().unwrap_or(0.0),
        }
    };
    limits().enumerate().map(cost).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_shares_of_bounces_sum_to_one() {
        let round = |scale: f64| -> Vec<[f64; 2]> {
            let all = [
                [1.0, 0.0],
                [3.0, 4.0],
                [4.0, 6.0],
                [4.5, 7.0],
                [4.75, 7.5],
                [5.0, 8.0],
            ];
            all.map(|[t, l]| [scale * t, l]).to_vec()
        };
        let costs = costs(&[round(1.0), round(2.0)]);
        assert_eq!(costs.len() as u64, RENDERS);
        assert_eq!((costs[1].bounces, costs[1].time.median), (Some(1), 0.4));
        assert_eq!((costs[5].bounces, costs[5].energy), (None, 0.0625));
        let time: f64 = costs.iter().map(|cost| cost.time.median).sum();
        assert!((time - 1.0).abs() < 1e-12);
    }
}
