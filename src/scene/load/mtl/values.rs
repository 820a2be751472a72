//! The values of the lines of material libraries (MTL).
//!
//! Measure: numbers as written.
//! Range: any text; an error says what was expected.
//! Source: the MTL format. Tested below and in `mod.rs`.

use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use crate::scene::load::wording::shown;

/// Splits a `map_` line into its options, each with its numbers or its one word, and the file.
pub fn split_options(text: &str) -> (&str, &str) {
    let mut file = text;
    while file.starts_with('-') {
        let vector = ["-o ", "-s ", "-t ", "-mm "]
            .iter()
            .any(|option| file.starts_with(option));
        file = after_word(file);
        if vector {
            for _ in 0..3 {
                let word = file.split_whitespace().next().unwrap_or_default();
                if word.parse::<f64>().is_ok() {
                    file = after_word(file);
                }
            }
        } else {
            file = after_word(file);
        }
    }
    let options = &text[..text.len() - file.len()];
    (options.trim_end(), file)
}

fn after_word(text: &str) -> &str {
    text.split_once(char::is_whitespace)
        .map_or("", |(_, rest)| rest.trim_start())
}

/// Parses one number of at least 0.
pub fn number(text: &str) -> Result<f32> {
    let first = text.split_whitespace().next().unwrap_or("nothing");
    let number = first.parse().ok().filter(is_valid);
    number.ok_or_else(|| {
        let found = shown(first);
        Error::scene(format!("expected a number of at least 0, found {found}"))
    })
}

/// Parses three numbers of at least 0, or one for all three.
pub fn colour(text: &str) -> Result<Rgb> {
    let words = text.split_whitespace().map(|word| word.parse().ok());
    let channels: Option<Vec<f32>> = words.take(4).collect();
    let colour = match channels.as_deref() {
        Some([grey]) => Some(Rgb::grey(*grey)),
        Some([r, g, b]) => Some(Rgb::new(*r, *g, *b)),
        _ => None,
    };
    let valid = colour.filter(|c| c.to_array().iter().all(is_valid));
    valid.ok_or_else(|| {
        let found = shown(text);
        Error::scene(format!(
            "expected three numbers of at least 0, found {found}"
        ))
    })
}

fn is_valid(number: &f32) -> bool {
    (0.0..=f32::MAX).contains(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_options_are_split_from_the_file_name() {
        for (text, options, file) in [
            ("a b.png", "", "a b.png"),
            (
                "-s 1 2 3 -clamp on a b.png",
                "-s 1 2 3 -clamp on",
                "a b.png",
            ),
            ("-o 1 2.png", "-o 1", "2.png"),
            ("-bm", "-bm", ""),
        ] {
            assert_eq!(split_options(text), (options, file), "{text}");
        }
    }
}
