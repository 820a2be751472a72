//! The JSON of a glTF file without its animations, which are left out anyway: those that cannot be read need not stop a file.
//!
//! Measure: bytes.
//! Range: any JSON. An empty list and spaces take the place of the animations, so that errors in the rest keep their lines.
//! Source: KHR_animation_pointer, whose channels have no node, as the crate gltf requires. Tested in
//! `tests/loading/gltf_odd.rs`.

use crate::error::Result;
use crate::memory;
use serde::Deserialize;
use serde_json::value::RawValue;

/// The text of the animations.
#[derive(Debug, Deserialize)]
struct Animations<'a> {
    #[serde(borrow, default)]
    animations: Option<&'a RawValue>,
}

/// Returns the JSON with an empty list of animations; `None` if it has none, or is no JSON.
///
/// # Errors
/// If there is no memory for a second copy of the text.
pub fn without_animations(json: &[u8]) -> Result<Option<Vec<u8>>> {
    let found: Option<Animations<'_>> = serde_json::from_slice(json).ok();
    let Some(text) = found.and_then(|it| it.animations).map(RawValue::get) else {
        return Ok(None);
    };
    memory::check(json.len() as u64, || "the JSON of a glTF file".to_owned())?;
    let mut rest = json.to_vec();
    // The text that was found is a part of the one that it was found in.
    let start = text.as_ptr().addr() - json.as_ptr().addr();
    let [first, between @ .., last] = &mut rest[start..start + text.len()] else {
        return Ok(None);
    };
    for byte in between.iter_mut().filter(|byte| **byte != b'\n') {
        *byte = b' ';
    }
    (*first, *last) = (b'[', b']');
    Ok(Some(rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn animations_become_an_empty_list_of_as_many_lines() {
        let blank = |json: &str| {
            let found = without_animations(json.as_bytes()).expect("there is memory");
            found.map(|rest| String::from_utf8(rest).expect("only ASCII was written"))
        };
        let json =
            "{\"a\": 1, \"animations\": [\n{\"b\": \"\u{e9}\"}\n] , \"c\": {\"animations\": 2}}";
        let rest = "{\"a\": 1, \"animations\": [\n           \n] , \"c\": {\"animations\": 2}}";
        assert_eq!(blank(json).as_deref(), Some(rest));
        for json in [
            "{}",
            "{\"animations\": null}",
            "{\"animations\": 5}",
            "{\"animations\": [",
            "[]",
        ] {
            assert_eq!(blank(json), None, "{json}");
        }
    }
}
