//! Parsing and formatting of durations.
//!
//! Measure: hours, minutes and seconds.
//! Range: above 0, up to 1000 hours.
//! Source: the convention of `sleep` and systemd. Tested below.

use std::time::Duration;

/// Parses `90s`, `5m`, `1h30m` or `1.5h`; a number without a unit is in seconds.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let expected = || "expected a duration such as 30s, 5m or 1h30m".to_owned();
    let mut seconds = 0.0;
    let mut rest = text.trim();
    let mut unit_above = f64::INFINITY;
    while !rest.is_empty() {
        let digits = rest
            .find(|c: char| !c.is_ascii_digit() && c != '.')
            .unwrap_or(rest.len());
        let (number, tail) = rest.split_at(digits);
        let number: f64 = number.parse().map_err(|_| expected())?;
        let unit = match tail.chars().next() {
            Some('h') => 3600.0,
            Some('m') => 60.0,
            Some('s') => 1.0,
            None if unit_above.is_infinite() => 1.0,
            _ => return Err(expected()),
        };
        // Units must go from large to small, each at most once: 30m1h is probably a mistake.
        if unit >= unit_above {
            return Err(expected());
        }
        unit_above = unit;
        seconds += number * unit;
        rest = tail.get(1..).unwrap_or("");
    }
    if seconds > 0.0 && seconds <= 3.6e6 {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(expected())
    }
}

/// Durations from this many seconds up, four days, are formatted in days.
const DAYS: f64 = 4.0 * 86_400.0;

/// Formats a duration in a unit that suits its size.
pub fn format_duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    if seconds < 1.0 {
        format!("{:.0} ms", seconds * 1e3)
    } else if seconds < 100.0 {
        format!("{seconds:.1} s")
    } else if seconds < 6000.0 {
        format!(
            "{}m{:02}s",
            duration.as_secs() / 60,
            duration.as_secs() % 60
        )
    } else if seconds >= DAYS {
        format!("{:.0} days", seconds / 86_400.0)
    } else {
        format!(
            "{}h{:02}m",
            duration.as_secs() / 3600,
            duration.as_secs() / 60 % 60
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_parsed_and_invalid_ones_rejected() {
        for (text, seconds) in [
            ("90s", 90.0),
            ("5m", 300.0),
            ("1h30m", 5400.0),
            ("0.5s", 0.5),
            ("7", 7.0),
        ] {
            assert_eq!(
                parse_duration(text),
                Ok(Duration::from_secs_f64(seconds)),
                "{text}"
            );
        }
        for wrong in [
            "", "0s", "-3s", "s", "5x", "30m1h", "1h1h", "nan", "inf", "1e3s", "9999h",
        ] {
            assert!(parse_duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn durations_are_formatted_compactly() {
        for (seconds, text) in [
            (0.25, "250 ms"),
            (12.34, "12.3 s"),
            (125.0, "2m05s"),
            (7260.0, "2h01m"),
            (1e6, "12 days"),
        ] {
            assert_eq!(format_duration(Duration::from_secs_f64(seconds)), text);
        }
    }
}
