//! Reads transforms: a list of steps, applied in the order in which they are written.
//!
//! Measure: world units, degrees.
//! Range: the composed transform is invertible; a matrix is affine.
//! Source: docs/scene-format.md; Rodrigues' rotation. Tested in `tests/loading/scene_files.rs`.

use super::reader::Value;
use crate::error::Result;
use crate::math::transform::{is_invertible, rotation};
use crate::math::vec::{DAffine3, DMat3, DVec3};

/// Reads a transform. `object` is its owner's name in errors.
///
/// # Errors
/// If a step is invalid, or the composed transform is singular.
pub fn transform(value: &Value<'_>, object: &str) -> Result<DAffine3> {
    let mut whole = DAffine3::IDENTITY;
    for entry in value.list()? {
        whole = step(&entry)? * whole;
    }
    if is_invertible(&whole.matrix3) && whole.is_finite() {
        Ok(whole)
    } else {
        Err(value.error(format!(
            "the transform of {object} is singular: it flattens space"
        )))
    }
}

fn step(entry: &Value<'_>) -> Result<DAffine3> {
    let table = entry.table()?;
    let mut steps = Vec::new();
    if let Some(scale) = table.optional("scale") {
        let factors = if scale.is_list() {
            scale.vec3()?
        } else {
            DVec3::splat(scale.number()?)
        };
        steps.push(DAffine3::from_scale(factors));
    }
    if let Some(rotate) = table.optional("rotate") {
        let turn = rotate.table()?;
        let axis = turn.required("axis")?;
        let direction = axis
            .vec3()?
            .try_normalize()
            .ok_or_else(|| axis.expected("an axis"))?;
        let angle = turn.required("angle")?.number()?.to_radians();
        turn.finish()?;
        steps.push(DAffine3::from_mat3(rotation(direction, angle)));
    }
    if let Some(translate) = table.optional("translate") {
        steps.push(DAffine3::from_translation(translate.vec3()?));
    }
    if let Some(matrix) = table.optional("matrix") {
        steps.push(affine(&matrix)?);
    }
    table.finish()?;
    match steps.as_slice() {
        [only] => Ok(*only),
        _ => Err(entry.error("expected one of scale, rotate, translate or matrix in each step")),
    }
}

/// Reads an affine matrix: sixteen numbers in row-major order, the last row being 0 0 0 1.
fn affine(value: &Value<'_>) -> Result<DAffine3> {
    let m = value.numbers::<16>()?;
    if m[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(value.error("expected a last row of 0, 0, 0, 1: the matrix is read row by row"));
    }
    let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    })
}
