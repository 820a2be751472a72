//! Parsers of flag values: from text to a type, or to a message that states the expected format.
//!
//! Measure: stated at each parser.
//! Range: stated at each parser; a value outside it is a usage error that names the flag.
//! Source: none needed. Tested below and in `cli/tests/command/bad_flags.rs`.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use etendue::internals::accel::{Backend, Precision, Quality};
use etendue::internals::film::filter::{FilterDescription, FilterKind, MAX_RADIUS};
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::roulette::ParseRouletteError;
use etendue::internals::render::settings::BounceLimit;
use etendue::internals::scene::load::unknown_name;
use etendue::internals::state::Shard;

/// Parses the name of a backend of this build. For `embree` in a build without it, the error names the missing feature.
pub fn backend() -> impl TypedValueParser<Value = Backend> {
    let known = Backend::ALL
        .iter()
        .map(|backend| PossibleValue::new(backend.name()));
    let missing = (!cfg!(feature = "embree")).then(|| PossibleValue::new("embree").hide(true));
    PossibleValuesParser::new(known.chain(missing)).try_map(|chosen| {
        let mut all = Backend::ALL.iter().copied();
        all.find(|backend| backend.name() == chosen)
            .ok_or("this build is without Embree; it has to be built with the feature `embree`")
    })
}

/// Parses the precision of ray intersections.
pub fn precision() -> impl TypedValueParser<Value = Precision> {
    named(&[Precision::Robust, Precision::Fast], Precision::name)
}

/// Parses the build quality of acceleration structures.
pub fn quality() -> impl TypedValueParser<Value = Quality> {
    named(&[Quality::Medium, Quality::High], Quality::name)
}

/// Parses one of `values` by its name; clap lists the names and suggests the nearest.
pub fn named<T: Copy + Send + Sync + 'static>(
    values: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(values.iter().map(|&value| name(value))).map(move |chosen| {
        let found = values.iter().find(|&&value| name(value) == chosen);
        *found.expect("clap lets only these names through")
    })
}

/// Parses a rule of Russian roulette.
pub fn parse_roulette(text: &str) -> Result<Roulette, ParseRouletteError> {
    text.parse()
}

/// Parses a reconstruction filter: its name, and its radius in pixels if it is not the default one.
pub fn parse_filter(text: &str) -> Result<FilterDescription, String> {
    let (name, radius) = match text.split_once(':') {
        Some((name, radius)) => (name, Some(radius)),
        None => (text, None),
    };
    let Some(&(_, kind)) = FilterKind::ALL.iter().find(|(known, _)| *known == name) else {
        let names: Vec<&str> = FilterKind::ALL.iter().map(|(name, _)| *name).collect();
        return Err(unknown_name("filter", name, &names));
    };
    let radius = match radius {
        None => kind.default_radius(),
        Some(radius) => radius
            .parse()
            .ok()
            .filter(|&radius: &f64| radius > 0.0 && radius <= MAX_RADIUS)
            .ok_or_else(|| {
                format!("expected a radius above 0, up to {MAX_RADIUS} pixels, such as {name}:2")
            })?,
    };
    Ok(FilterDescription { kind, radius })
}

/// Parses a limit of scattering events.
pub fn parse_bounces(text: &str) -> Result<BounceLimit, String> {
    if text == "none" {
        return Ok(BounceLimit::Unlimited);
    }
    let limit = text.parse().map(BounceLimit::AtMost);
    limit.map_err(|_| format!("`{text}`: expected a whole number, or none"))
}

/// Parses a width and a height in pixels.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let expected =
        || "expected WIDTHxHEIGHT in pixels, each from 1 to 65536, such as 768x512".to_owned();
    let (width, height) = text.split_once('x').ok_or_else(expected)?;
    let side = |text: &str| {
        text.parse()
            .ok()
            .filter(|side| (1..=65536).contains(side))
            .ok_or_else(expected)
    };
    Ok((side(width)?, side(height)?))
}

/// Parses `N` whole numbers separated by commas.
pub fn parse_numbers<const N: usize>(text: &str) -> Result<[u32; N], String> {
    let numbers: Result<Vec<u32>, _> = text
        .split(',')
        .map(|number| number.trim().parse())
        .collect();
    numbers
        .ok()
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| format!("expected {N} whole numbers of pixels, separated by commas"))
}

/// Parses a shard: `3/64`, counted from 0, or a range of samples, `128..256`.
pub fn parse_shard(text: &str) -> Result<Shard, String> {
    let two = |separator: &str| -> Option<[u64; 2]> {
        let (a, b) = text.split_once(separator)?;
        Some([a.trim().parse().ok()?, b.trim().parse().ok()?])
    };
    if let Some([index, of]) = two("/") {
        return match index < of {
            true => Ok(Shard::Part { index, of }),
            false => Err(format!(
                "shards are counted from 0: the last of {of} is {}/{of}",
                of.saturating_sub(1)
            )),
        };
    }
    let [first, end] = two("..").ok_or(
        "expected a shard such as 0/64, the first of 64, or a range of samples such as 128..256",
    )?;
    Ok(Shard::Samples { first, end })
}

/// Parses a number or a percentage.
fn parse_ratio(text: &str) -> Option<f64> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text.trim(), 1.0),
    };
    number.trim().parse().ok().map(|number: f64| unit * number)
}

/// Parses a share above 0 and below 1, or a percentage.
pub fn parse_share(text: &str) -> Result<f64, String> {
    parse_ratio(text)
        .filter(|share| *share > 0.0 && *share < 1.0)
        .ok_or_else(|| "expected a share above 0 and below 1, such as 1% or 0.01".to_owned())
}

/// Parses a share from 0 to below 1, or a percentage.
pub fn parse_small(text: &str) -> Result<f64, String> {
    parse_ratio(text)
        .filter(|share| (0.0..1.0).contains(share))
        .ok_or_else(|| "expected a share from 0 to below 1, such as 5% or 0.05".to_owned())
}

/// Parses a finite number from 0 up, or a percentage.
pub fn parse_limit(text: &str) -> Result<f64, String> {
    parse_ratio(text)
        .filter(|limit| limit.is_finite() && *limit >= 0.0)
        .ok_or_else(|| "expected a number of at least 0, such as 1% or 0.01".to_owned())
}

/// Parses a finite number above 0.
pub fn parse_distance(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|distance: &f64| distance.is_finite() && *distance > 0.0)
        .ok_or_else(|| "expected a number above 0".to_owned())
}

/// Parses a number of stops, from -100 to 100.
pub fn parse_exposure(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|stops: &f32| stops.abs() <= 100.0)
        .ok_or_else(|| "expected a number of stops from -100 to 100".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_parsed_as_numbers_or_percentages() {
        for (text, limit) in [("0", 0.0), ("2.5 %", 0.025), ("150%", 1.5), ("7", 7.0)] {
            assert_eq!(parse_limit(text), Ok(limit));
        }
        for wrong in ["-1%", "nan", "inf", "%", "", "1%%"] {
            assert!(parse_limit(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_and_crops_are_parsed_strictly() {
        assert_eq!(parse_size("768x512"), Ok((768, 512)));
        for wrong in ["0x5", "768", "x", "70000x1", "-1x2", "1x2x3"] {
            assert!(parse_size(wrong).is_err(), "{wrong}");
        }
        assert_eq!(parse_numbers::<2>("3, 4"), Ok([3, 4]));
        assert!(parse_numbers::<2>("3,4,5").is_err());
        assert!(parse_numbers::<2>("3,-4").is_err());
    }
}
