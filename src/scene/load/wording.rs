//! Helpers for error messages: quoting text from a file in one short line, and suggesting the most similar name.
//!
//! Measure: characters.
//! Range: any text.
//! Source: similarity by Damerau-Levenshtein distance, through strsim. Tested in `load/reader.rs` and
//! `cli/tests/command/bad_input.rs`.

/// A line, counted from 1, and what is wrong in it.
pub type LineError = (usize, String);

/// Returns the message for a name that is not among `known`: the most similar of them, if any, and the list of all.
pub fn unknown_name(what: &str, name: &str, known: &[&str]) -> String {
    let name = shown(name);
    let nearest = known
        .iter()
        .filter(|candidate| candidate.len() <= MAX_SHOWN)
        .map(|candidate| (strsim::damerau_levenshtein(&name, candidate), candidate))
        .min()
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 3);
    let listed = known.iter().take(MAX_LISTED).map(|name| shown(name));
    let mut listed = listed.collect::<Vec<_>>().join(", ");
    if known.len() > MAX_LISTED {
        listed.push_str(", ...");
    }
    match nearest {
        Some((_, nearest)) => {
            format!("unknown {what} `{name}`; did you mean `{nearest}`? Expected one of: {listed}")
        }
        None if known.is_empty() => format!("unknown {what} `{name}`; there are none"),
        None => format!("unknown {what} `{name}`; expected one of: {listed}"),
    }
}

/// Maximum number of characters that a message quotes from a file.
const MAX_SHOWN: usize = 80;

/// Maximum number of names that a message lists.
const MAX_LISTED: usize = 24;

/// Shortens a text from a file to one line for a message.
pub fn shown(text: &str) -> String {
    let end = text.char_indices().nth(MAX_SHOWN);
    let end = end.map_or(text.len(), |(index, _)| index);
    let mut shown = text[..end].replace(|c: char| c.is_control(), " ");
    if end < text.len() {
        shown.push_str("...");
    }
    shown
}
