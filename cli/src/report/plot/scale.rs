//! A drawn axis: the positions of values and its ticks.
//!
//! Measure: values in the axis's unit; positions as fractions of its length, from 0 to 1.
//! Range: any points; an axis without a drawable point runs from 0 to 1, or from 1 to 10 if logarithmic.
//! Source: steps of 1, 2 and 5 times a power of ten. Tested below.

use etendue_lab::plot::{Axis, Scale};

/// The approximate maximum number of labels on an axis; more would overlap on a phone.
const MAX_LABELS: f64 = 6.0;

/// The maximum number of marked values on an axis.
const MAX_MARKED: usize = 8;

/// A drawn axis.
#[derive(Debug, Clone)]
pub struct Ruler {
    scale: Scale,
    /// The marked values; none for round numbers.
    marked: Vec<(f64, String)>,
    /// The ends; exponents of ten on a logarithmic axis.
    start: f64,
    end: f64,
}

/// A tick: a marked value.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// The position as a fraction of the axis.
    pub place: f64,
    /// The label.
    pub label: String,
}

impl Ruler {
    /// Creates the axis over its own range, or else over all values with a margin; no margin below if it is `grounded`.
    pub fn new(axis: &Axis, grounded: bool, values: impl Iterator<Item = f64>) -> Self {
        let inner = |x: f64| match axis.scale {
            Scale::Linear => x,
            Scale::Log => x.log10(),
        };
        let around = |[start, end]: [f64; 2], x: f64| [start.min(x), end.max(x)];
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        let all = values
            .map(inner)
            .filter(|x| x.is_finite())
            .fold(nothing, around);
        let [start, end] = match axis.range {
            Some(range) => range.map(inner),
            None if all[0] > all[1] => [0.0, 1.0],
            None if all[0] == all[1] => [all[0] - 0.5, all[1] + 0.5],
            None => {
                let margin = 0.04 * (all[1] - all[0]);
                let below = if grounded { 0.0 } else { margin };
                [all[0] - below, all[1] + margin]
            }
        };
        let scale = axis.scale;
        let marks = axis.ticks.iter().map(|(value, _)| inner(*value));
        let [start, end] = with_a_mark([start, end], marks.filter(|x| x.is_finite()));
        Self {
            scale,
            marked: axis.ticks.clone(),
            start,
            end,
        }
    }

    /// Returns the position of a value; `None` if it has none, such as 0 on a logarithmic axis.
    pub fn place(&self, value: f64) -> Option<f64> {
        let inner = match self.scale {
            Scale::Linear => value,
            Scale::Log => value.log10(),
        };
        let place = (inner - self.start) / (self.end - self.start);
        // Clamped: the line still leaves the frame in approximately the right direction.
        place.is_finite().then_some(place.clamp(-20.0, 20.0))
    }

    /// Returns the ticks.
    pub fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            _ if !self.marked.is_empty() => self.marked_ticks(),
            Scale::Linear => self.even_ticks(),
            Scale::Log => self.log_ticks(),
        }
    }

    /// Returns the marked values within the axis, or every second, third ... if there are too many.
    fn marked_ticks(&self) -> Vec<Tick> {
        let marked = self.marked.iter();
        let within = marked.filter_map(|(value, label)| self.tick(*value, label.clone()));
        let ticks: Vec<Tick> = within.collect();
        let stride = ticks.len().div_ceil(MAX_MARKED).max(1);
        ticks.into_iter().rev().step_by(stride).collect()
    }

    fn even_ticks(&self) -> Vec<Tick> {
        let even = even_values([self.start, self.end]).into_iter();
        even.filter_map(|(value, label)| self.tick(value, label))
            .collect()
    }

    fn log_ticks(&self) -> Vec<Tick> {
        let [first, last] = [self.start.ceil() as i32, self.end.floor() as i32];
        let span = self.end - self.start;
        if span < 2.0 {
            // Less than two decades: 2 and 5 times the powers of ten are marked, too.
            let parts = [1.0, 2.0, 5.0];
            let ticks: Vec<Tick> = (first - 1..=last)
                .flat_map(|power| parts.map(|part| (part, power)))
                .filter_map(|(part, power)| {
                    let value = part * 10.0_f64.powi(power);
                    self.tick(value, short(value))
                })
                .collect();
            if ticks.len() > 1 {
                return ticks;
            }
            // Less than a third of a decade may have one of them, or none.
            let ends = [self.start, self.end].map(|end| 10.0_f64.powf(end));
            let even = even_values(ends).into_iter();
            let label = |value: f64, plain: String| match (1e-3..1e5).contains(&value) {
                true => plain,
                false => {
                    let power = value.log10().floor() as i32;
                    format!(
                        "{:.2}·10{}",
                        value / 10.0_f64.powi(power),
                        superscript(power)
                    )
                }
            };
            return even
                .filter_map(|(value, plain)| self.tick(value, label(value, plain)))
                .collect();
        }
        let stride = (span / MAX_LABELS).ceil() as i32;
        let powers = (first..=last).filter(|power| power.rem_euclid(stride) == 0);
        let label = |power: i32| match (first >= -2, last <= 4) {
            (true, true) => short(10.0_f64.powi(power)),
            _ => format!("10{}", superscript(power)),
        };
        powers
            .filter_map(|power| self.tick(10.0_f64.powi(power), label(power)))
            .collect()
    }

    fn tick(&self, value: f64, label: String) -> Option<Tick> {
        let place = self.place(value)?;
        let within = (-1e-9..=1.0 + 1e-9).contains(&place);
        within.then_some(Tick { place, label })
    }
}

/// The ends of an axis, moved to the nearest mark if there is none between them.
fn with_a_mark([start, end]: [f64; 2], marks: impl Iterator<Item = f64>) -> [f64; 2] {
    let outside = |mark: f64| (start - mark).max(mark - end).max(0.0);
    let nearest = marks.min_by(|a, b| outside(*a).total_cmp(&outside(*b)));
    nearest.map_or([start, end], |mark| [start.min(mark), end.max(mark)])
}

/// Round numbers between two ends, with their labels.
fn even_values([start, end]: [f64; 2]) -> Vec<(f64, String)> {
    let rough = (end - start) / MAX_LABELS;
    let power = rough.log10().floor();
    let unit = 10.0_f64.powf(power);
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * unit);
    let step = step.into_iter().find(|&step| step >= rough * (1.0 - 1e-9));
    let step = step.unwrap_or(unit);
    let decimals = (-(step * 1.001).log10().floor()).max(0.0) as usize;
    let [first, last] = [(start / step).ceil(), (end / step).floor()];
    (first as i64..=last as i64)
        .map(|index| index as f64 * step)
        .map(|value| (value, format!("{value:.decimals$}").replace('-', "−")))
        .collect()
}

/// Formats a number with few digits.
fn short(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        format!("{}", (value * 1e6).round() / 1e6)
    } else {
        let power = value.log10().floor() as i32;
        let factor = (value / 10.0_f64.powi(power)).round();
        format!("{factor}·10{}", superscript(power))
    }
}

/// Formats a whole number as a superscript.
pub fn superscript(power: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // The code points of the other digits are consecutive.
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    power.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, values: &[f64]) -> Vec<String> {
        let ruler = Ruler::new(axis, false, values.iter().copied());
        ruler.ticks().into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn axis_tick_labels_are_round_and_few() {
        let even = |start, end| labels(&Axis::linear("x").over(start, end), &[]);
        assert_eq!(even(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(even(-1.0, 1.0), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(even(0.5, 6.5), ["1", "2", "3", "4", "5", "6"]);
        let log = |start, end| labels(&Axis::log("x").over(start, end), &[]);
        assert_eq!(log(1.0, 1e3), ["1", "10", "100", "1000"]);
        assert_eq!(
            log(1e-6, 1.0),
            ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"]
        );
        assert_eq!(
            log(1e-12, 1e3),
            ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰", "10³"]
        );
        assert_eq!(log(2.0, 12.0), ["2", "5", "10"]);
        assert_eq!(log(2.1, 3.1), ["2.2", "2.4", "2.6", "2.8", "3.0"]);
    }

    #[test]
    fn marked_axis_has_a_mark() {
        let marked = |start, end| {
            let mut axis = Axis::log("x").over(start, end);
            axis.ticks = vec![(10.0, "ten".to_owned()), (60.0, "sixty".to_owned())];
            labels(&axis, &[])
        };
        assert_eq!(marked(20.0, 40.0), ["sixty"]);
        assert_eq!(marked(12.0, 30.0), ["ten"]);
        assert_eq!(marked(5.0, 100.0), ["sixty", "ten"]);
    }

    #[test]
    fn axis_range_ignores_undrawable_values() {
        let odd = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1.0, 100.0];
        let ruler = Ruler::new(&Axis::log("x"), false, odd.into_iter());
        assert_eq!(ruler.place(0.0), None);
        assert_eq!(ruler.place(f64::NAN), None);
        let middle = ruler.place(10.0).expect("it is positive");
        assert!((middle - 0.5).abs() < 1e-12);
        for nothing in [Axis::linear("x"), Axis::log("x")] {
            assert!(!labels(&nothing, &[]).is_empty());
            assert!(!labels(&nothing, &[f64::NAN]).is_empty());
            assert!(!labels(&nothing, &[3.0]).is_empty());
        }
    }
}
