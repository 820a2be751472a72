//! Russian roulette, which ends paths at random without bias: a path continues with a survival probability, by which
//! its throughput is then divided.
//!
//! Measure: throughputs without unit. Probabilities follow the throughput times the squared ratios of the refractive
//! indices that transmission divided it by, as that factor is restored on the way out.
//! Range: any throughput; a weight window from 1/64 to 1.
//! Source: Veach 1997, section 10.4.1; the lower bound of the weight windows of Booth and Hendricks 1984. Tested in
//! `tests/rendering/roulette.rs` and `integrators.rs`.

use crate::math::rgb::Rgb;
use crate::math::vec::Vector;
use crate::planted::planted;
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// The rule of Russian roulette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(into = "String")]
#[non_exhaustive]
pub enum Roulette {
    /// No roulette: a path ends only by absorption, by the bounce limit or where the integrator's technique counts
    /// emission at random.
    None,
    /// The survival probability follows the weight of the last BSDF sample: what the surface reflected.
    Albedo,
    /// The survival probability follows the path throughput: a weight window of 1.
    #[default]
    Throughput,
    /// The survival probability is the path throughput over the window: a path that survives has at least its weight.
    Window(WeightWindow),
}

/// A weight window: the reciprocal of a whole number from 1 to 64.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WeightWindow {
    parts: u8,
}

/// 1/2: a smaller window gains more where light scatters often, and loses where it does not (docs/accuracy.md).
impl Default for WeightWindow {
    fn default() -> Self {
        Self { parts: 2 }
    }
}

impl WeightWindow {
    /// The weight window 1/`parts`; `None` unless `parts` is from 1 to 64.
    pub fn reciprocal_of(parts: u8) -> Option<Self> {
        (1..=64).contains(&parts).then_some(Self { parts })
    }
}

impl Roulette {
    /// The names in scenes and on the command line. A weight window may be given, as in `window=1/4`; without one, `window`
    /// is [`WeightWindow::default`].
    pub const NAMES: &'static [&'static str] = &["none", "albedo", "throughput", "window"];

    /// The rule as a function of throughputs.
    #[inline]
    pub fn survival(self) -> Survival {
        let parts = match self {
            Self::Window(window) => f32::from(window.parts),
            _ => 1.0,
        };
        Survival {
            is_certain: self == Self::None,
            by_albedo: self == Self::Albedo,
            parts,
        }
    }
}

impl fmt::Display for Roulette {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Albedo => f.write_str("albedo"),
            Self::Throughput => f.write_str("throughput"),
            Self::Window(window) => write!(f, "window=1/{}", window.parts),
        }
    }
}

impl From<Roulette> for String {
    fn from(roulette: Roulette) -> Self {
        roulette.to_string()
    }
}

/// A text that does not name a rule of roulette.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParseRouletteError {
    /// An unknown name.
    Name,
    /// A window that is not 1/N with N from 1 to 64.
    Window,
}

impl fmt::Display for ParseRouletteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name => write!(f, "expected one of: {}", Roulette::NAMES.join(", ")),
            Self::Window => {
                f.write_str("expected a weight window as window=1/N, with N from 1 to 64")
            }
        }
    }
}

impl std::error::Error for ParseRouletteError {}

impl FromStr for Roulette {
    type Err = ParseRouletteError;

    fn from_str(text: &str) -> Result<Self, ParseRouletteError> {
        match text {
            "none" => return Ok(Self::None),
            "albedo" => return Ok(Self::Albedo),
            "throughput" => return Ok(Self::Throughput),
            "window" => return Ok(Self::Window(WeightWindow::default())),
            _ => {}
        }
        let window = text
            .strip_prefix("window=")
            .ok_or(ParseRouletteError::Name)?;
        let parts = match window {
            "1" => Some(1),
            _ => window.strip_prefix("1/").and_then(|n| n.parse().ok()),
        };
        let window = parts.and_then(WeightWindow::reciprocal_of);
        window.map(Self::Window).ok_or(ParseRouletteError::Window)
    }
}

/// The survival probability of paths, by one rule.
#[derive(Debug, Clone, Copy)]
pub struct Survival {
    is_certain: bool,
    by_albedo: bool,
    /// The reciprocal of the weight window.
    parts: f32,
}

impl Survival {
    /// Returns the survival probability of a path after scattering event number `bounce`, which multiplied its
    /// throughput by `weight` and left it at `beta`.
    ///
    /// A path that loses no energy would never end in a closed scene: from event `LONG_PATH` on, the probability is at
    /// most `LONG_RUN`.
    #[inline(always)]
    pub fn probability<V: Vector>(self, bounce: u32, weight: Rgb<V>, beta: Rgb<V>) -> f32 {
        const LONG_PATH: u32 = 32;
        const LONG_RUN: f32 = 0.99;
        let [by_albedo, by_throughput] = [weight.max_channel(), beta.max_channel()];
        let share = if self.by_albedo {
            by_albedo
        } else {
            by_throughput * self.parts
        };
        let limit = if bounce < LONG_PATH { 1.0 } else { LONG_RUN };
        if self.is_certain {
            1.0
        } else {
            share.min(limit)
        }
    }

    /// The factor of the throughput of a path that has survived with a probability below 1.
    #[inline(always)]
    pub fn correction(self, probability: f32) -> f32 {
        planted!(
            "window-without-its-weight",
            self.parts / probability,
            1.0 / probability
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roulette_names_round_trip_and_bad_windows_are_rejected() {
        for text in ["none", "albedo", "throughput", "window=1/4"] {
            let roulette: Roulette = text.parse().expect("a rule");
            assert_eq!(roulette.to_string(), text);
        }
        assert_eq!("window".parse(), "window=1/2".parse::<Roulette>());
        assert_eq!("window=1".parse(), "window=1/1".parse::<Roulette>());
        assert_eq!("windows".parse::<Roulette>(), Err(ParseRouletteError::Name));
        for text in [
            "window=",
            "window=0.5",
            "window=1/0",
            "window=1/65",
            "window=1/-2",
        ] {
            assert_eq!(
                text.parse::<Roulette>(),
                Err(ParseRouletteError::Window),
                "{text}"
            );
        }
    }

    /// The mean throughput after roulette is that before, and survivors have the weight of the window.
    #[test]
    fn weight_window_preserves_expected_throughput() {
        for (parts, beta) in [(1, 0.3), (4, 0.3), (4, 0.1), (8, 0.01), (64, 1.0)] {
            let window = WeightWindow::reciprocal_of(parts).expect("it is from 1 to 64");
            let survival = Roulette::Window(window).survival();
            let beta = Rgb::<crate::math::vec::Vec3>::grey(beta);
            let probability = survival.probability(1, beta, beta);
            let after = if probability < 1.0 {
                beta.max_channel() * survival.correction(probability)
            } else {
                beta.max_channel()
            };
            assert!((probability * after / beta.max_channel() - 1.0).abs() < 1e-6);
            assert!(after >= 0.999 / f32::from(parts).max(1.0 / beta.max_channel()));
        }
    }
}
