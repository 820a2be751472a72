//! The attributes of a Mitsuba scene's XML: parameters, numbers, vectors, colours and spectra.
//!
//! Measure: as written.
//! Range: numbers are finite; parameters insert at most 64 times the bytes of the files, and what is compared with their names in
//! vain counts as inserted.
//! Source: Mitsuba 3 documentation, "Scene XML file format". Tested in `tests/loading/mitsuba.rs`.

use super::super::read_text;
use super::super::spectrum::Spectrum;
use super::super::wording::{shown, unknown_name};
use super::document::{DocumentReader, SourceFile};
use super::spectra::Spectral;
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use crate::math::vec::DVec3;
use roxmltree::Node;

/// Maximum number of bytes that parameters insert for each byte of the files: each can hold others, and a few lines could
/// fill the memory.
const MAX_INSERTED: usize = 64;

impl DocumentReader {
    /// An attribute in which the values of parameters replace their `$names`, and `\$` became a dollar sign.
    pub(super) fn attribute(
        &self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
        name: &str,
    ) -> Result<Option<String>> {
        let Some(written) = node.attribute(name) else {
            return Ok(None);
        };
        let mut text = String::new();
        let mut rest = written;
        while let Some((before, after)) = rest.split_once('$') {
            if let Some(before) = before.strip_suffix('\\') {
                text.push_str(before);
                text.push('$');
                rest = after;
                continue;
            }
            text.push_str(before);
            let Some(found) = self.parameters.at_start_of(after) else {
                let word: String = after
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                let names = self.parameters.names();
                return Err(source
                    .place(node)
                    .error(unknown_name("parameter", &word, &names)));
            };
            // Names that contain dollar signs may agree with more text than that up to the next one.
            let in_vain = found.compared - found.name.len();
            self.inserted
                .set(self.inserted.get() + found.value.len() + in_vain);
            if self.inserted.get() > MAX_INSERTED * self.bytes {
                let why = format!(
                    "expected parameters that insert at most {MAX_INSERTED} times the bytes of the files"
                );
                return Err(source.place(node).error(why));
            }
            text.push_str(found.value);
            rest = &after[found.name.len()..];
        }
        text.push_str(rest);
        Ok(Some(text))
    }

    /// An attribute that has to be there.
    pub(super) fn required(
        &self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
        name: &str,
    ) -> Result<String> {
        self.attribute(source, node, name)?.ok_or_else(|| {
            let tag = shown(node.tag_name().name());
            source
                .place(node)
                .error(format!("expected an attribute `{name}` of `{tag}`"))
        })
    }

    /// The numbers of the attribute `value`.
    pub(super) fn list(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<Vec<f64>> {
        let text = self.required(source, node, "value")?;
        let words = text
            .split([' ', ',', '\t', '\n', '\r'])
            .filter(|word| !word.is_empty());
        let number = |word: &str| {
            word.parse()
                .ok()
                .filter(|x: &f64| x.is_finite())
                .ok_or_else(|| {
                    let why = format!("expected a finite number, found {}", shown(word));
                    source.place(node).error(why)
                })
        };
        words.map(number).collect()
    }

    /// Reads as many numbers from the attribute `value`.
    pub(super) fn numbers<const N: usize>(
        &self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
    ) -> Result<[f64; N]> {
        let list = self.list(source, node)?;
        let found = list.len();
        list.try_into().map_err(|_| {
            source
                .place(node)
                .error(format!("expected {N} numbers, found {found}"))
        })
    }

    /// A vector: `value`, or `x`, `y` and `z`.
    pub(super) fn vector(
        &self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
        missing: f64,
    ) -> Result<DVec3> {
        if node.has_attribute("value") {
            return match self.list(source, node)?.as_slice() {
                [all] => Ok(DVec3::splat(*all)),
                [x, y, z] => Ok(DVec3::new(*x, *y, *z)),
                other => {
                    let why = format!("expected 3 numbers, found {}", other.len());
                    Err(source.place(node).error(why))
                }
            };
        }
        let axis = |name| match self.attribute(source, node, name)? {
            None => Ok(missing),
            Some(text) => self.number(source, node, &text),
        };
        Ok(DVec3::new(axis("x")?, axis("y")?, axis("z")?))
    }

    /// A finite number.
    pub(super) fn number(
        &self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
        text: &str,
    ) -> Result<f64> {
        let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| {
            let why = format!("expected a finite number, found {}", shown(text));
            source.place(node).error(why)
        })
    }

    /// A colour of one or three numbers of at least 0.
    pub(super) fn colour(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<Rgb> {
        let channels = match self.list(source, node)?.as_slice() {
            [grey] => [*grey; 3],
            [r, g, b] => [*r, *g, *b],
            other => {
                let why = format!("expected 1 or 3 numbers, found {}", other.len());
                return Err(source.place(node).error(why));
            }
        };
        let colour = Rgb::from(channels.map(|x| x as f32));
        if colour.is_finite() && channels.iter().all(|x| *x >= 0.0) {
            Ok(colour)
        } else {
            let why = "expected a colour of at least 0 in every channel, within single precision";
            Err(source.place(node).error(why))
        }
    }

    /// A spectrum: one value, or samples in the element or in a file.
    pub(super) fn spectrum(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<Spectral> {
        if let Some(name) = self.attribute(source, node, "filename")? {
            let path = source.folders.find(&name);
            let about = |error: Error| {
                let text = format!("spectrum: {error}");
                source.place(node).error(text).of_kind(error.kind())
            };
            let text = read_text(&path).map_err(about)?;
            let samples = Spectrum::parse(&text)
                .map_err(|(line, why)| about(Error::scene(why).in_file(&path).at_line(line)))?;
            let spectral = Spectral::of_samples(samples);
            return spectral.map_err(|why| about(Error::scene(why).in_file(&path)));
        }
        let text = self.required(source, node, "value")?;
        Spectral::parse(&text).map_err(|why| source.place(node).error(why))
    }
}
