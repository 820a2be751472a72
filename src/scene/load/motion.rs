//! Motion: a list of places by time.
//!
//! Measure: world units, degrees; time in any unit that is also the shutter's.
//! Range: at least one key; times finite and increasing.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_input.rs`.

use super::reader::{Table, Value};
use super::transform::transform;
use crate::error::Result;
use crate::math::vec::DAffine3;
use crate::scene::description::Key;

/// The `motion` of an object, empty if it stands still. `object` names it in errors.
///
/// # Errors
/// Anything that is no list of keys in order of time.
pub fn motion(table: &Table<'_>, object: &str) -> Result<Vec<Key>> {
    let Some(value) = table.optional("motion") else {
        return Ok(vec![]);
    };
    let keys = keys(&value, |key| {
        let placed = transform(&key.required("transform")?, object)?;
        Ok((placed, ()))
    })?;
    Ok(keys.into_iter().map(|(key, ())| key).collect())
}

/// Keys of which `place` reads all but the time: the transform, and whatever else it finds.
///
/// # Errors
/// As [`motion`], and those of `place`.
pub fn keys<'a, T>(
    value: &Value<'a>,
    place: impl Fn(&Table<'a>) -> Result<(DAffine3, T)>,
) -> Result<Vec<(Key, T)>> {
    let mut keys: Vec<(Key, T)> = vec![];
    for entry in value.list()? {
        let table = entry.table()?;
        let when = table.required("time")?;
        let time = when.number()?;
        if let Some((last, _)) = keys.last()
            && last.time >= time
        {
            return Err(when.error(format!(
                "keys out of order in time: {time} follows {}",
                last.time
            )));
        }
        let (transform, more) = place(&table)?;
        table.finish()?;
        keys.push((Key { time, transform }, more));
    }
    if keys.is_empty() {
        return Err(value.error("expected at least one key: { time = ..., ... }"));
    }
    Ok(keys)
}

/// The times at which the shutter opens and closes.
///
/// # Errors
/// Anything that is no pair of numbers in order.
pub fn shutter(value: &Value<'_>) -> Result<[f64; 2]> {
    let [open, close] = value.numbers()?;
    if open <= close {
        Ok([open, close])
    } else {
        Err(value.error(format!(
            "expected [open, close] in order of time, but {close} is before {open}"
        )))
    }
}
