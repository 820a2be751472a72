//! Cuts the text of an OBJ file into chunks of whole lines, and these into lines.
//!
//! Measure: chunks in bytes; lines count from 1.
//! Range: a chunk never ends within a line that is continued on the next one.
//! Source: the OBJ format, appendix B1 of Wavefront's Advanced Visualizer manual. Tested in `lines`.

use std::borrow::Cow;

/// Cuts the text after every `size` bytes, at the end of a line that is not continued.
pub fn chunks(text: &str, size: usize) -> Vec<&str> {
    let mut chunks = Vec::new();
    let mut rest = text;
    while let Some(end) = chunk_end(rest, size) {
        let (chunk, after) = rest.split_at(end);
        chunks.push(chunk);
        rest = after;
    }
    chunks.push(rest);
    chunks
}

fn chunk_end(text: &str, size: usize) -> Option<usize> {
    let after = text.as_bytes().get(size..)?;
    let mut end = size + after.iter().position(|byte| *byte == b'\n')? + 1;
    // The line up to here may have begun before, so that a whole line decides.
    for line in text[end..].split_inclusive('\n') {
        end += line.len();
        if continued(line).is_none() {
            return Some(end);
        }
    }
    None
}

/// Returns the lines without comments, with their numbers, which begin at `first`; a line that ends in a backslash is joined with the next.
pub fn logical_lines(text: &str, first: usize) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = (first..).zip(lines(text));
    std::iter::from_fn(move || {
        let (number, first) = lines
            .by_ref()
            .find(|(_, line)| !line.trim_ascii_start().starts_with('#'))?;
        let Some(part) = continued(first) else {
            return Some((number, Cow::Borrowed(first)));
        };
        // Appends in place: a file may be one line of a million parts.
        let mut whole = part.to_owned();
        for (_, next) in lines.by_ref() {
            whole.push(' ');
            let Some(part) = continued(next) else {
                whole.push_str(next);
                break;
            };
            whole.push_str(part);
        }
        Some((number, Cow::Owned(whole)))
    })
}

/// Returns the lines of a text, those of other systems with their carriage return; the last one may be empty.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut start = 0;
    let ends = memchr::memchr_iter(b'\n', text.as_bytes());
    ends.chain([text.len()]).map(move |end| {
        let line = &text[start..end];
        start = end + 1;
        line
    })
}

/// Returns the line without the backslash at its end; `None` if it has none.
fn continued(line: &str) -> Option<&str> {
    line.trim_ascii_end().strip_suffix('\\')
}
