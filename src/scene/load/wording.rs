//! How messages repeat what a file says: on one line, not too long, with the nearest name that there is.
//!
//! Measure: characters.
//! Range: any text.
//! Source: the nearest name by Damerau and Levenshtein's distance, through strsim. Tested in `load/reader.rs` and
//! `cli/tests/command/bad_input.rs`.

/// What to say of a name that is not among `known`: the nearest of them, or all.
pub fn unknown_name(what: &str, name: &str, known: &[&str]) -> String {
    let name = shown(name);
    let nearest = known
        .iter()
        .filter(|candidate| candidate.len() <= LONGEST_SHOWN)
        .map(|candidate| (strsim::damerau_levenshtein(&name, candidate), candidate))
        .min()
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 3);
    let listed = known.iter().take(MOST_LISTED).map(|name| shown(name));
    let mut listed = listed.collect::<Vec<_>>().join(", ");
    if known.len() > MOST_LISTED {
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

/// Characters of a text from a file that a message repeats.
const LONGEST_SHOWN: usize = 80;

/// Names that a message lists.
const MOST_LISTED: usize = 24;

/// A text from a file as a message repeats it: on one line, and not too long.
pub fn shown(text: &str) -> String {
    let end = text.char_indices().nth(LONGEST_SHOWN);
    let end = end.map_or(text.len(), |(index, _)| index);
    let mut shown = text[..end].replace(|c: char| c.is_control(), " ");
    if end < text.len() {
        shown.push_str("...");
    }
    shown
}
