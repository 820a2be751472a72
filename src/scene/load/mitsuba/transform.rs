//! The steps of a Mitsuba transform.
//!
//! Measure: world units; angles in degrees.
//! Range: any step; one that is not affine is an error with its line.
//! Source: Mitsuba 3 documentation, "Transformations". Tested in `tests/loading/mitsuba.rs`.

use super::super::wording::unknown_name;
use super::document::{DocumentReader, SourceFile};
use crate::error::Result;
use crate::math::transform::{orientation, rotation};
use crate::math::vec::{DAffine3, DMat3, DVec3};
use roxmltree::Node;

impl DocumentReader {
    /// Returns one step of a transform.
    ///
    /// # Errors
    /// If it is not as the format requires.
    pub(super) fn step(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<DAffine3> {
        match node.tag_name().name() {
            "translate" => Ok(DAffine3::from_translation(self.vector(source, node, 0.0)?)),
            "scale" => Ok(DAffine3::from_scale(self.vector(source, node, 1.0)?)),
            "rotate" => {
                let axis = self.vector(source, node, 0.0)?;
                let angle = self.required(source, node, "angle")?;
                let angle = self.number(source, node, &angle)?.to_radians();
                let axis = axis.try_normalize().ok_or_else(|| {
                    source
                        .place(node)
                        .error("expected an axis that is not zero")
                })?;
                Ok(DAffine3::from_mat3(rotation(axis, angle)))
            }
            "lookat" | "look_at" | "lookAt" => self.look_at(source, node),
            "matrix" => self.matrix(source, node),
            tag => {
                let known = ["translate", "scale", "rotate", "lookat", "matrix"];
                Err(source
                    .place(node)
                    .error(unknown_name("step of a transform", tag, &known)))
            }
        }
    }

    /// The axes of Mitsuba's cameras: z ahead, y up, x to the left.
    fn look_at(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<DAffine3> {
        let point = |name| {
            let text = self.required(source, node, name)?;
            let numbers: Vec<f64> = text
                .split([' ', ',', '\t', '\n', '\r'])
                .filter(|word| !word.is_empty())
                .map(|word| self.number(source, node, word))
                .collect::<Result<_>>()?;
            numbers.try_into().map(DVec3::from_array).map_err(|_| {
                source
                    .place(node)
                    .error(format!("expected 3 numbers for `{name}`"))
            })
        };
        let (origin, target) = (point("origin")?, point("target")?);
        let ahead = target - origin;
        let up = match node.has_attribute("up") {
            true => point("up")?,
            // Mitsuba chooses any; the most upright axis serves.
            false if ahead.x.abs() + ahead.z.abs() > 1e-6 * ahead.length() => DVec3::Y,
            false => DVec3::Z,
        };
        let axes = orientation(ahead, up).ok_or_else(|| {
            let why = "origin and target are the same point, or up is along the line between them";
            source.place(node).error(why)
        })?;
        Ok(DAffine3 {
            matrix3: axes,
            translation: origin,
        })
    }

    fn matrix(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<DAffine3> {
        let numbers = self.list(source, node)?;
        let wrong = |why: &str| source.place(node).error(why);
        match numbers.as_slice() {
            [a, b, c, d, e, f, g, h, i] => Ok(DAffine3::from_mat3(DMat3::from_cols_array(&[
                *a, *d, *g, *b, *e, *h, *c, *f, *i,
            ]))),
            [rows @ .., p, q, r, s] if rows.len() == 12 => {
                if [*p, *q, *r, *s] != [0.0, 0.0, 0.0, 1.0] {
                    return Err(wrong("expected 0 0 0 1 as the last row of a matrix"));
                }
                let column = |i: usize| DVec3::new(rows[i], rows[4 + i], rows[8 + i]);
                Ok(DAffine3::from_cols(
                    column(0),
                    column(1),
                    column(2),
                    column(3),
                ))
            }
            _ => Err(wrong("expected a matrix of 16 or 9 numbers")),
        }
    }
}
