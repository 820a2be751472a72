//! The notation of values in scene files.
//!
//! Measure: none.
//! Range: finite numbers; every number reads back as the same bits, but for the sign of a zero.
//! Source: TOML 1.0, through the toml crate. Tested below and in `tests/loading/saving.rs`.

use crate::math::rgb::Rgb;
use crate::math::vec::{DAffine3, DVec3};
use crate::scene::description::Keyframe;

/// A scene file in progress.
#[derive(Debug, Default)]
pub struct Text(String);

impl Text {
    /// Begins a table, such as `[[shape]]`.
    pub fn table(&mut self, header: &str) {
        self.0.push_str(&format!("\n{header}\n"));
    }

    /// Writes a key and its value.
    pub fn entry(&mut self, key: &str, value: impl std::fmt::Display) {
        self.0.push_str(&format!("{key} = {value}\n"));
    }

    /// Writes a comment.
    pub fn comment(&mut self, comment: &str) {
        for line in comment.lines() {
            let line = line.replace(|c: char| c.is_control(), " ");
            self.0.push_str(format!("# {line}").trim_end());
            self.0.push('\n');
        }
    }

    /// The whole text.
    pub fn finish(self) -> String {
        self.0
    }
}

/// A string in quotes.
pub fn string(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A number.
pub fn number(x: f64) -> String {
    let text = toml::Value::Float(x).to_string();
    // Digits without a point are read as an integer, of at most 128 bits.
    let whole = text.strip_suffix(".0").filter(|_| x.abs() < 1e15);
    whole.map_or(text.clone(), str::to_owned)
}

/// A number of single precision, with the fewest digits that read back as the same.
pub fn single(x: f32) -> String {
    let short = number_of(&x.to_string());
    if short as f32 == x {
        number(short)
    } else {
        number(f64::from(x))
    }
}

fn number_of(digits: &str) -> f64 {
    digits
        .parse()
        .expect("digits of a finite number are a number")
}

/// An angle in degrees, or in radians where degrees do not give the same bits.
pub fn angle(radians: f64) -> String {
    let near = radians.to_degrees();
    let candidates = [near, near.next_up(), near.next_down()];
    let exact = candidates.into_iter().find(|it| it.to_radians() == radians);
    exact.map_or_else(|| format!("{{ radians = {} }}", number(radians)), number)
}

/// A list of values.
pub fn list(values: impl IntoIterator<Item = String>) -> String {
    let values: Vec<String> = values.into_iter().collect();
    format!("[{}]", values.join(", "))
}

/// A point or a direction.
pub fn vec3(v: DVec3) -> String {
    list(v.to_array().map(number))
}

/// A constant colour.
pub fn rgb(colour: Rgb) -> String {
    list(colour.to_array().map(single))
}

/// A transform.
pub fn transform(it: &DAffine3) -> String {
    let (m, t) = (it.matrix3, it.translation);
    let row = |i: usize| [m.x_axis[i], m.y_axis[i], m.z_axis[i], t[i]];
    let rows = [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
    let numbers = rows.into_iter().flatten().map(number);
    format!("[{{ matrix = {} }}]", list(numbers))
}

/// The keyframes of a motion.
pub fn motion(keys: &[Keyframe]) -> String {
    let key = |key: &Keyframe| {
        let (time, place) = (number(key.time), transform(&key.transform));
        format!("    {{ time = {time}, transform = {place} }},\n")
    };
    let keys: String = keys.iter().map(key).collect();
    format!("[\n{keys}]")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_are_written_in_short_decimal_form() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.25), "-0.25");
        assert_eq!(single(0.1), "0.1");
        assert_eq!(single(16_777_216.0), "16777216");
        assert_eq!(angle(40_f64.to_radians()), "40");
        assert_eq!(vec3(DVec3::new(1.0, 0.5, -3.0)), "[1, 0.5, -3]");
        assert_eq!(
            string("a \"b\"\n"),
            toml::Value::from("a \"b\"\n").to_string()
        );
    }

    proptest! {
        #[test]
        fn finite_numbers_round_trip_exactly(x: f64, y: f32) {
            prop_assume!(x.is_finite() && y.is_finite());
            prop_assert_eq!(number(x).parse::<f64>().expect("a number"), x);
            prop_assert_eq!(single(y).parse::<f64>().expect("a number") as f32, y);
        }

        #[test]
        fn angles_round_trip_exactly(radians in 1e-9_f64..3.2) {
            let text = angle(radians);
            let read = match text.strip_prefix("{ radians = ") {
                Some(rest) => rest.trim_end_matches(" }").parse().expect("a number"),
                None => text.parse::<f64>().expect("a number").to_radians(),
            };
            prop_assert_eq!(read, radians);
        }
    }
}
