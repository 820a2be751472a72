//! Formatting of the numbers of a benchmark, shared by its tables and its page.
//!
//! Measure: stated at each function.
//! Range: any number; non-finite numbers are written as such.
//! Source: the spread of such timings justifies three digits. Tested below.

use etendue::internals::math::stats::Spread;
use etendue_lab::bench::target::TracingMode;

/// Formats a number with three digits, or with all digits of its whole part if it has more.
pub fn digits(number: f64) -> String {
    let decimals = match number.abs() {
        // Rounding must not add a digit: 9.996 is 10.0.
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        size if size >= 0.9995 || size == 0.0 => 2,
        _ => 3,
    };
    format!("{number:.decimals$}")
}

/// Formats `median (least to greatest)`, with the numbers multiplied by `scale`.
pub fn spread(spread: &Spread, scale: f64) -> String {
    let [median, min, max] = [spread.median, spread.min, spread.max].map(|x| digits(x * scale));
    format!("{median} ({min} to {max})")
}

/// Formats bytes in megabytes.
pub fn megabytes(bytes: usize) -> String {
    digits(bytes as f64 / 1e6)
}

/// Formats a ratio; a dash if there is none.
pub fn ratio(ratio: Option<f64>) -> String {
    ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"))
}

/// Describes the configuration of tracing without the backend: `fast high, 8 wide, coherent`.
pub fn way(variant: &TracingMode) -> String {
    let target = variant.target;
    let built = format!("{} {}", target.precision.name(), target.quality.name());
    let coherent = if variant.packets.coherent {
        ", coherent"
    } else {
        ""
    };
    match variant.packets.width.lanes() {
        1 => format!("{built}, single"),
        lanes => format!("{built}, {lanes} wide{coherent}"),
    }
}

/// Formats a whole number with its thousands separated.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Formats a count with its noun in singular or plural.
pub fn of_things(number: usize, one: &str, many: &str) -> String {
    let name = if number == 1 { one } else { many };
    format!("{} {name}", count(number as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_formatted_to_three_digits() {
        for (number, text) in [
            (0.0, "0.00"),
            (0.1234, "0.123"),
            (0.99951, "1.00"),
            (1.0, "1.00"),
            (9.994, "9.99"),
            (9.996, "10.0"),
            (99.96, "100"),
            (123.4, "123"),
            (12345.6, "12346"),
        ] {
            assert_eq!(digits(number), text);
        }
    }

    #[test]
    fn thousands_are_separated() {
        for (number, text) in [
            (0, "0"),
            (999, "999"),
            (1000, "1 000"),
            (1234567, "1 234 567"),
        ] {
            assert_eq!(count(number), text);
        }
        assert_eq!(of_things(1, "run", "runs"), "1 run");
    }
}
