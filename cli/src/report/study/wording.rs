//! Formatting of the numbers of a study, shared by its tables, its page and its conclusions.
//!
//! Measure: stated at each function.
//! Range: any number; infinity is written as ∞, NaN as a dash.
//! Source: the intervals justify two or three digits. Tested below.

use crate::report::lesson::wording::significant;
use etendue_lab::study::answer::Answer;
use etendue_lab::study::bootstrap::Ranged;

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
        x => {
            let (one, unit) = unit_of(x);
            format!("{} {unit}", number(x / one))
        }
    }
}

/// Returns the unit of a time, in seconds and in words.
fn unit_of(x: f64) -> (f64, &'static str) {
    match x {
        x if x < 1.0 => (1e-3, "ms"),
        x if x < 120.0 => (1.0, "s"),
        x if x < 7200.0 => (60.0, "min"),
        x if x < 172_800.0 => (3600.0, "h"),
        x if x < 3.2e7 => (86_400.0, "days"),
        _ => (31_557_600.0, "years"),
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

/// Formats a time and its interval in one unit, such as `12.3 s (11.9 to 12.8)`.
pub fn seconds_ranged(range: &Ranged) -> String {
    let value = seconds(range.value);
    let Some((_, unit)) = value.split_once(' ').filter(|_| range.low < range.high) else {
        return value;
    };
    let one = unit_of(range.value).0;
    let [low, high] = [range.low, range.high].map(|end| match end.is_finite() {
        true => number(end / one),
        false => "∞".to_owned(),
    });
    match (low == high, value.strip_suffix(unit)) {
        (false, Some(digits)) => format!("{digits}{unit} ({low} to {high})"),
        _ => value,
    }
}

/// Formats the interval of a time in the unit of the time, such as `115 to 129 s`.
pub fn seconds_interval(range: &Ranged) -> String {
    let (one, unit) = unit_of(range.value);
    let [low, high] = [range.low, range.high].map(|end| match end {
        end if end.is_nan() => "-".to_owned(),
        end if end.is_infinite() => "∞".to_owned(),
        end => number(end / one),
    });
    format!("{low} to {high} {unit}")
}

/// Formats an answer: `≈` marks times by the law.
pub fn answer(answer: &Answer) -> String {
    match answer {
        Answer::Measured(range) => seconds_ranged(range),
        Answer::Law(range) => format!("≈ {}", seconds_ranged(range)),
        Answer::AtOnce(least) => format!("< {}", seconds(*least)),
        Answer::Never(_) => "never".to_owned(),
        Answer::Exact(least) => format!("exact, {}", seconds(*least)),
        Answer::Unknown(_) => "unknown".to_owned(),
    }
}

/// Formats an answer without its interval; `None` if there is no time.
pub fn short_answer(answer: &Answer) -> Option<String> {
    let time = seconds(answer.seconds()?);
    Some(match answer {
        Answer::Law(_) => format!("≈ {time}"),
        Answer::AtOnce(_) => format!("< {time}"),
        _ => time,
    })
}

/// Formats a probability.
pub fn probability(p: f64) -> String {
    match p {
        p if p < 1e-6 => "< 10⁻⁶".to_owned(),
        p if p < 1e-3 => significant(p, 1),
        p => format!("{p:.3}"),
    }
}

/// Formats a signed share with its margin, in percent; without a margin if that is NaN.
pub fn signed_percent(x: f64, margin: f64) -> String {
    if margin.is_nan() {
        return format!("{:+.0} %", 100.0 * x).replace('-', "−");
    }
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
    fn times_are_formatted_in_suitable_units() {
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
    fn both_ends_of_an_interval_have_the_unit_of_the_time() {
        for ([value, low, high], text) in [
            ([122.0, 115.0, 129.0], "1.92 to 2.15 min"),
            ([119.0, 115.0, 129.0], "115 to 129 s"),
            ([0.9, 0.8, f64::INFINITY], "800 to ∞ ms"),
        ] {
            assert_eq!(seconds_interval(&Ranged { value, low, high }), text);
        }
    }

    #[test]
    fn each_kind_of_answer_is_formatted_distinctly() {
        let range = |value: f64, low: f64, high: f64| Ranged { value, low, high };
        for (given, text) in [
            (Answer::Measured(range(3.0, 2.9, 3.2)), "3 s (2.9 to 3.2)"),
            (Answer::Law(range(300.0, 240.0, 360.0)), "≈ 5 min (4 to 6)"),
            (
                Answer::Measured(range(3.0, 2.0, f64::INFINITY)),
                "3 s (2 to ∞)",
            ),
            (Answer::Measured(range(3.0, 3.0, 3.0)), "3 s"),
            (Answer::AtOnce(0.5), "< 500 ms"),
            (Answer::Never(0.02), "never"),
            (Answer::Exact(0.5), "exact, 500 ms"),
            (Answer::Unknown("why".to_owned()), "unknown"),
        ] {
            assert_eq!(answer(&given), text);
        }
        assert_eq!(short_answer(&Answer::Never(0.02)), None);
    }

    #[test]
    fn scale_limits_are_rounded_up() {
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
    fn probabilities_and_signed_percentages_are_formatted() {
        assert_eq!(probability(1e-9), "< 10⁻⁶");
        assert_eq!(probability(0.04321), "0.043");
        assert_eq!(signed_percent(-0.1234, 0.0042), "−12.34 ± 0.42 %");
        assert_eq!(signed_percent(-0.1234, f64::NAN), "−12 %");
    }
}
