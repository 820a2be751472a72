//! Formatting of the numbers of a lesson, with as many digits as are significant.
//!
//! Measure: none.
//! Range: any number.
//! Source: two digits of a standard error, and the number itself to the same decimal place. Tested below.

use crate::report::plot::superscript;
use crate::report::table::{Table, numbers, words};
use etendue_lab::lesson::number::{MeasuredTechnique, Number};

/// Formats a number with `digits` significant digits, without trailing zeros.
pub fn significant(number: f64, digits: usize) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    if !number.is_finite() {
        return match number {
            _ if number.is_nan() => "-".to_owned(),
            _ if number > 0.0 => "∞".to_owned(),
            _ => "−∞".to_owned(),
        };
    }
    let scientific = format!("{number:.*e}", digits - 1);
    let (factor, power) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let power: i32 = power.parse().unwrap_or(0);
    let whole = (digits as i32).max(4);
    let text = if (-3..whole).contains(&power) {
        let decimals = (digits as i32 - 1 - power).max(0) as usize;
        trimmed(&format!("{number:.decimals$}"))
    } else {
        format!("{}·10{}", trimmed(factor), superscript(power))
    };
    text.replace('-', "−")
}

fn trimmed(text: &str) -> String {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    }
}

/// Formats a number with its standard error; without it if the error is 0.
pub fn with_error(number: f64, error: f64) -> String {
    // An error of the size of rounding is not statistical.
    if error <= f64::EPSILON * number.abs() {
        return significant(number, 7);
    }
    if !error.is_finite() || !number.is_finite() {
        return significant(number, 4);
    }
    let power = error.abs().log10().floor() as i32;
    let size = number.abs().max(error).log10().floor() as i32;
    if size < -3 || power > 5 {
        let digits = (size - power + 2).clamp(2, 8) as usize;
        return format!(
            "{} ± {}",
            significant(number, digits),
            significant(error, 2)
        );
    }
    let decimals = (1 - power).max(0) as usize;
    format!("{number:.decimals$} ± {error:.decimals$}").replace('-', "−")
}

/// Returns a table of numbers beside their exact values.
pub fn number_table(reading: &str, all: &[Number]) -> Table {
    let row = |number: &Number| {
        vec![
            number.name.clone(),
            significant(number.exact, 7),
            with_error(number.ours, number.standard_error),
            number.verdict.name().to_owned(),
        ]
    };
    Table {
        title: "The numbers".to_owned(),
        caption: reading.to_owned(),
        head: vec![
            words("what"),
            numbers("exact"),
            numbers("ours"),
            words("verdict"),
        ],
        rows: all.iter().map(row).collect(),
    }
}

/// Returns a table of techniques with their efficiencies.
pub fn technique_table(reading: &str, all: &[MeasuredTechnique]) -> Table {
    let first = all
        .first()
        .map_or(f64::NAN, |technique| technique.efficiency);
    let exact = all
        .iter()
        .any(|technique| technique.exact_variance.is_some());
    let row = |technique: &MeasuredTechnique| {
        let mut cells = vec![technique.name.clone(), significant(technique.variance, 4)];
        if exact {
            cells.push(
                technique
                    .exact_variance
                    .map_or(String::new(), |v| significant(v, 5)),
            );
        }
        cells.extend([
            duration(technique.cost),
            efficiency(technique),
            format!("{}×", significant(technique.efficiency / first, 3)),
            with_error(technique.mean, technique.standard_error),
        ]);
        cells
    };
    let mut head = vec![words("technique"), numbers("variance V")];
    if exact {
        head.push(numbers("V, exact"));
    }
    head.extend(["cost T", "efficiency 1/(V·T)", "× first", "estimate"].map(numbers));
    Table {
        title: "The techniques".to_owned(),
        caption: reading.to_owned(),
        head,
        rows: all.iter().map(row).collect(),
    }
}

/// Formats an efficiency, with the smallest and the largest if there are several.
fn efficiency(technique: &MeasuredTechnique) -> String {
    let middle = significant(technique.efficiency, 3);
    match technique.efficiency_range {
        None => middle,
        Some(range) => {
            let [least, greatest] = range.map(|end| significant(end, 3));
            format!("{middle} ({least} to {greatest})")
        }
    }
}

/// Formats a short time.
fn duration(seconds: f64) -> String {
    let scales = [(1e-6, 1e9, "ns"), (1e-3, 1e6, "µs"), (1.0, 1e3, "ms")];
    let scale = scales.into_iter().find(|(end, ..)| seconds < *end);
    let (_, factor, unit) = scale.unwrap_or((0.0, 1.0, "s"));
    format!("{} {unit}", significant(seconds * factor, 3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::math::stats::Moments;

    #[test]
    fn technique_table_rows_match_the_header_length() {
        let technique = MeasuredTechnique::new("it", &Moments::of([1.0, 2.0]), 1e-9);
        for technique in [technique.clone(), technique.exactly(0.5)] {
            let table = technique_table("", &[technique]);
            assert_eq!(table.rows[0].len(), table.head.len());
            assert_eq!(table.rows[0][1], "0.5");
        }
    }

    #[test]
    fn numbers_are_formatted_to_significant_digits() {
        assert_eq!(significant(35.0 / 12.0, 7), "2.916667");
        assert_eq!(significant(3.5, 7), "3.5");
        assert_eq!(significant(-1.5e-7, 3), "−1.5·10⁻⁷");
        assert_eq!(significant(2e9, 3), "2·10⁹");
        assert_eq!(significant(103_306.0, 3), "1.03·10⁵");
        assert_eq!(significant(5372.0, 3), "5372");
        assert_eq!(significant(100.0, 3), "100");
        assert_eq!(significant(f64::INFINITY, 3), "∞");
        assert_eq!(with_error(3.500_123, 0.000_83), "3.50012 ± 0.00083");
        assert_eq!(with_error(1.234_56e-5, 2e-7), "1.235·10⁻⁵ ± 2·10⁻⁷");
        assert_eq!(with_error(0.5, 0.0), "0.5");
        assert_eq!(with_error(0.0, 0.001), "0.0000 ± 0.0010");
        assert_eq!(duration(1.5e-8), "15 ns");
        assert_eq!(duration(2.0), "2 s");
    }
}
