//! Formatting of the numbers of a study, shared by its tables, its page and its conclusions.
//!
//! Measure: stated at each function.
//! Range: any number; infinity is written as ∞, NaN as a dash.
//! Source: the intervals justify two or three digits. Tested below.

use crate::report::lesson::wording::significant;
use etendue_lab::study::bootstrap::Ranged;
use etendue_lab::study::fit::Reached;

/// Formats a number with three digits.
pub fn number(x: f64) -> String {
    significant(x, 3)
}

/// Formats a number with two digits.
pub fn rough(x: f64) -> String {
    significant(x, 2)
}

/// Formats seconds in a unit that suits their size.
pub fn seconds(x: f64) -> String {
    match x {
        x if x.is_nan() => "-".to_owned(),
        x if x.is_infinite() => "∞".to_owned(),
        x if x < 1.0 => format!("{} ms", number(1e3 * x)),
        x if x < 120.0 => format!("{} s", number(x)),
        x if x < 7200.0 => format!("{} min", number(x / 60.0)),
        x if x < 172_800.0 => format!("{} h", number(x / 3600.0)),
        x => format!("{} days", number(x / 86_400.0)),
    }
}

/// Formats a sample count.
pub fn samples(count: u64) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} sample{plural}")
}

/// Formats a fraction as a percentage.
pub fn percent(x: f64) -> String {
    format!("{} %", rough(100.0 * x))
}

/// Formats a number with its interval, each by `write`.
pub fn ranged(range: &Ranged, write: impl Fn(f64) -> String) -> String {
    let [low, high] = [range.low, range.high].map(&write);
    match range.low == range.high {
        true => write(range.value),
        false => format!("{} ({low} to {high})", write(range.value)),
    }
}

/// Formats the time at which an error was reached; `never` if the bias is larger than that error.
pub fn reached(reached: &Reached, is_beyond_bias: bool) -> String {
    match reached {
        Reached::At(range) => ranged(range, seconds),
        Reached::Within(least) => format!("< {}", seconds(*least)),
        Reached::Beyond(_) if is_beyond_bias => "never".to_owned(),
        Reached::Beyond(most) => format!("> {}", seconds(*most)),
    }
}

/// Formats a probability.
pub fn probability(p: f64) -> String {
    match p {
        p if p < 1e-6 => "< 10⁻⁶".to_owned(),
        p if p < 1e-3 => significant(p, 1),
        p => format!("{p:.3}"),
    }
}

/// Formats a signed share with its margin, in percent.
pub fn signed_percent(x: f64, margin: f64) -> String {
    // A margin of 0 gives the maximum of two decimals.
    let decimals = (1.0 - (100.0 * margin).log10().floor()).clamp(0.0, 2.0) as usize;
    let text = format!(
        "{:+.decimals$} ± {:.decimals$} %",
        100.0 * x,
        100.0 * margin
    );
    text.replace('-', "−")
}

/// Returns the smallest of 1, 2 and 5 times a power of ten that is at least `x`.
pub fn round_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(x.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    steps.into_iter().find(|&step| step >= x).unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_suit_their_length() {
        for (time, text) in [
            (0.01234, "12.3 ms"),
            (3.456, "3.46 s"),
            (200.0, "3.33 min"),
            (9000.0, "2.5 h"),
            (f64::INFINITY, "∞"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(seconds(time), text);
        }
    }

    #[test]
    fn what_was_not_reached_is_not_extrapolated() {
        assert_eq!(reached(&Reached::Beyond(20.0), false), "> 20 s");
        assert_eq!(reached(&Reached::Beyond(20.0), true), "never");
        assert_eq!(reached(&Reached::Within(0.5), false), "< 500 ms");
        let range = Ranged {
            value: 3.0,
            low: 2.0,
            high: f64::INFINITY,
        };
        assert_eq!(reached(&Reached::At(range), true), "3 s (2 s to ∞)");
    }

    #[test]
    fn scales_end_at_round_numbers() {
        for (x, end) in [
            (0.013, 0.02),
            (0.3, 0.5),
            (7.0, 10.0),
            (1.0, 1.0),
            (0.0, 1.0),
        ] {
            assert!((round_up(x) - end).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn small_probabilities_and_signs() {
        assert_eq!(probability(1e-9), "< 10⁻⁶");
        assert_eq!(probability(0.04321), "0.043");
        assert_eq!(signed_percent(-0.1234, 0.0042), "−12.34 ± 0.42 %");
    }
}
