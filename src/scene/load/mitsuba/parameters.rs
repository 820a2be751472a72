//! The parameters of a Mitsuba scene: the values that replace `$names`.
//!
//! Measure: bytes.
//! Range: any names; of two values of one name, the first one counts. Where one name begins with another, the longest that fits
//! is meant. Finding it takes as long as the text that agrees with a name, however many there are.
//! Source: Mitsuba 3 documentation, "Scene XML file format"; names as a trie, after Fredkin 1960, "Trie Memory". Tested below
//! and in `tests/loading/mitsuba_files.rs`.

use std::collections::HashMap;

/// A prefix of names, by its index. The empty one is 0.
type PrefixIndex = u32;

/// The values of `$names`.
#[derive(Debug, Default)]
pub struct Parameters {
    /// The prefixes that are one byte longer than others.
    longer: HashMap<(PrefixIndex, u8), PrefixIndex>,
    /// The names, with their values, by the prefix that is the whole name.
    whole: HashMap<PrefixIndex, (String, String)>,
}

/// A name at the start of a text, and its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FoundParameter<'a> {
    pub name: &'a str,
    pub value: &'a str,
    /// The number of bytes that were compared.
    pub compared: usize,
}

impl Parameters {
    /// Adds a parameter, unless there is one of this name.
    pub fn add(&mut self, name: String, value: String) {
        let mut prefix = 0;
        for byte in name.bytes() {
            let next = self.longer.len() as PrefixIndex + 1;
            prefix = *self.longer.entry((prefix, byte)).or_insert(next);
        }
        self.whole.entry(prefix).or_insert((name, value));
    }

    /// Returns the longest name that the text begins with.
    pub fn at_start_of(&self, text: &str) -> Option<FoundParameter<'_>> {
        let mut prefix = 0;
        let mut longest = self.whole.get(&0);
        let mut compared = 0;
        for byte in text.bytes() {
            let Some(longer) = self.longer.get(&(prefix, byte)) else {
                break;
            };
            prefix = *longer;
            compared += 1;
            longest = self.whole.get(&prefix).or(longest);
        }
        longest.map(|(name, value)| FoundParameter {
            name,
            value,
            compared,
        })
    }

    /// All names, in alphabetical order.
    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.whole.values().map(|(name, _)| name.as_str()).collect();
        names.sort_unstable();
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str]) -> Parameters {
        let mut parameters = Parameters::default();
        for name in names {
            parameters.add((*name).to_owned(), format!("value of {name}"));
        }
        parameters
    }

    #[test]
    fn longest_parameter_at_the_start_of_a_text_is_found() {
        let parameters = of(&["sp", "spp", "sppx", "größe", "größer", "b"]);
        for (text, expected) in [
            ("spp * 2", Some("spp")),
            ("sppy", Some("spp")),
            ("sppx", Some("sppx")),
            ("sp", Some("sp")),
            ("s", None),
            ("", None),
            ("xsp", None),
            ("größe", Some("größe")),
            ("größerer", Some("größer")),
            ("gröb", None),
            ("bsp", Some("b")),
        ] {
            let found = parameters.at_start_of(text);
            assert_eq!(found.map(|it| it.name), expected, "{text}");
            let value = expected.map(|name| format!("value of {name}"));
            assert_eq!(found.map(|it| it.value), value.as_deref(), "{text}");
        }
        assert_eq!(of(&["a", ""]).at_start_of("b").expect("empty").name, "");
        assert_eq!(of(&["b", "a", "b"]).names(), ["a", "b"]);
    }

    #[test]
    fn first_value_of_a_parameter_counts() {
        let mut parameters = of(&["a"]);
        parameters.add("a".to_owned(), "another".to_owned());
        let found = parameters.at_start_of("a").expect("there is one");
        assert_eq!(found.value, "value of a");
    }

    #[test]
    fn search_of_a_parameter_compares_no_more_than_the_longest_name() {
        let names: Vec<String> = (0..1000).map(|i| format!("parameter{i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let parameters = of(&names);
        let text = "parameter42 of a long text".repeat(100);
        let found = parameters.at_start_of(&text).expect("there is one");
        assert_eq!((found.name, found.compared), ("parameter42", 11));
    }
}
