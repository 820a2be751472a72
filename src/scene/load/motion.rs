//! Reads motion: a list of keyframes.
//!
//! Measure: world units, degrees; time in the unit of the shutter's times.
//! Range: at least one key; times finite and increasing.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs` and `cli/tests/command/bad_input.rs`.

use super::reader::{Table, Value};
use super::transform::transform;
use crate::error::Result;
use crate::math::vec::DAffine3;
use crate::scene::description::Keyframe;

/// Reads the `motion` of an object, which is empty if it is static. `object` is its name in errors.
///
/// # Errors
/// If the value is not a list of keyframes in order of time.
pub fn motion(table: &Table<'_>, object: &str) -> Result<Vec<Keyframe>> {
    let Some(value) = table.optional("motion") else {
        return Ok(vec![]);
    };
    let keys = keys(&value, |key| {
        let placed = transform(&key.required("transform")?, object)?;
        Ok((placed, ()))
    })?;
    Ok(keys.into_iter().map(|(key, ())| key).collect())
}

/// Reads keyframes. `place` reads everything but the time: the transform and further values.
///
/// # Errors
/// As [`motion`], and those of `place`.
pub fn keys<'a, T>(
    value: &Value<'a>,
    place: impl Fn(&Table<'a>) -> Result<(DAffine3, T)>,
) -> Result<Vec<(Keyframe, T)>> {
    let mut keys: Vec<(Keyframe, T)> = vec![];
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
        keys.push((Keyframe { time, transform }, more));
    }
    if keys.is_empty() {
        return Err(value.error("expected at least one key: { time = ..., ... }"));
    }
    Ok(keys)
}

/// Reads the times at which the shutter opens and closes.
///
/// # Errors
/// If the value is not a pair of numbers in order.
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
