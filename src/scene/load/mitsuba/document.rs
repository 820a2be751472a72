//! Parses the XML of a Mitsuba scene into objects: defaults, `$names`, includes and references are resolved here.
//!
//! Measure: as written; angles of rotations in degrees.
//! Range: any text; an error has file and line. Elements are nested at most 64 deep, files include at most 16 deep and
//! 1000 in all, so that neither a cycle nor a bomb ends badly.
//! Source: Mitsuba 3 documentation, "Scene XML file format". Tested in `tests/loading/mitsuba.rs`.

use super::super::wording::{shown, unknown_name};
use super::super::{beside, read_text};
use super::object::{Object, Property, Value};
use crate::error::{Error, Result};
use crate::math::rgb::Rgb;
use crate::math::vec::DVec3;
use crate::scene::description::Place;
use roxmltree::{Document, Node};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

const MOST_NESTED: usize = 64;
const MOST_INCLUDES_NESTED: usize = 16;
const MOST_INCLUDES: usize = 1000;

/// The elements that declare objects.
const OBJECTS: &[&str] = &[
    "bsdf",
    "emitter",
    "film",
    "integrator",
    "medium",
    "phase",
    "rfilter",
    "sampler",
    "sensor",
    "shape",
    "texture",
    "volume",
    "spectrum",
];

/// Reads a scene and all files that it includes; returns its top-level objects as the properties of one object.
///
/// # Errors
/// If a file cannot be read, or something in it is not as the format requires.
pub fn read(path: &Path) -> Result<Object> {
    let mut reader = Reader::default();
    let properties = reader.file(path, 0)?;
    Ok(Object {
        tag: "scene".to_owned(),
        kind: String::new(),
        id: "the scene".to_owned(),
        place: Place {
            file: path.to_path_buf(),
            line: None,
        },
        properties,
    })
}

/// A name in camel case, as before version 2, in snake case: `toWorld` as `to_world`, `intIOR` as `int_ior`.
fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    let mut after_lower = false;
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && after_lower {
            snake.push('_');
        }
        after_lower = letter.is_ascii_lowercase() || letter.is_ascii_digit();
        snake.push(letter.to_ascii_lowercase());
    }
    snake
}

#[derive(Default)]
pub(super) struct Reader {
    /// The values of `$names`.
    defaults: BTreeMap<String, String>,
    /// Objects by their ids. A reference is to an object that precedes it.
    known: BTreeMap<String, Rc<Object>>,
    includes: usize,
    /// Whether the scene is of a version before 2, in which names are in camel case.
    is_old: bool,
}

/// One file, for places.
pub(super) struct Source<'a> {
    path: &'a Path,
    document: &'a Document<'a>,
    includes_nested: usize,
}

impl Source<'_> {
    pub(super) fn place(&self, node: Node<'_, '_>) -> Place {
        let line = self.document.text_pos_at(node.range().start).row as usize;
        Place {
            file: self.path.to_path_buf(),
            line: Some(line),
        }
    }
}

impl Reader {
    fn file(&mut self, path: &Path, includes_nested: usize) -> Result<Vec<Property>> {
        let text = read_text(path)?;
        let document = Document::parse(&text).map_err(|error| {
            let line = error.pos().row as usize;
            Error::scene(format!("expected XML: {}", shown(&error.to_string())))
                .in_file(path)
                .at_line(line)
        })?;
        let source = Source {
            path,
            document: &document,
            includes_nested,
        };
        let root = document.root_element();
        if root.tag_name().name() != "scene" {
            let found = shown(root.tag_name().name());
            return Err(source
                .place(root)
                .error(format!("expected an element `scene`, found `{found}`")));
        }
        // An included file without a version is of that of the scene.
        if let Some(version) = root.attribute("version") {
            let major = version
                .split('.')
                .next()
                .and_then(|it| it.trim().parse().ok());
            self.is_old = major.is_some_and(|major: u32| major < 2);
        }
        self.properties(&source, root, 0)
    }

    fn properties(
        &mut self,
        source: &Source<'_>,
        parent: Node<'_, '_>,
        nested: usize,
    ) -> Result<Vec<Property>> {
        if nested > MOST_NESTED {
            let why = format!("expected elements nested at most {MOST_NESTED} deep");
            return Err(source.place(parent).error(why));
        }
        let mut properties = Vec::new();
        for node in parent.children().filter(Node::is_element) {
            match node.tag_name().name() {
                "default" => {
                    let name = self.required(source, node, "name")?;
                    let value = self.required(source, node, "value")?;
                    self.defaults.entry(name).or_insert(value);
                }
                "include" => properties.append(&mut self.include(source, node)?),
                "alias" => {
                    let [id, alias] = ["id", "as"].map(|name| self.required(source, node, name));
                    let (id, alias) = (id?, alias?);
                    let object = Rc::clone(self.object_of_id(source, node, &id)?);
                    self.insert(source, node, alias, object)?;
                }
                _ => properties.push(self.property(source, node, nested)?),
            }
        }
        Ok(properties)
    }

    fn include(&mut self, source: &Source<'_>, node: Node<'_, '_>) -> Result<Vec<Property>> {
        let name = self.required(source, node, "filename")?;
        self.includes += 1;
        let nested = source.includes_nested + 1;
        if nested > MOST_INCLUDES_NESTED || self.includes > MOST_INCLUDES {
            let why = format!(
                "expected files that include at most {MOST_INCLUDES_NESTED} deep and {MOST_INCLUDES} in all: does {} include itself?",
                shown(&name)
            );
            return Err(source.place(node).error(why));
        }
        let path = beside(source.path, &name);
        self.file(&path, nested)
            .map_err(|error| match error.line() {
                // The place in the included file says more than that of the include.
                Some(_) => error,
                None => source
                    .place(node)
                    .error(error.to_string())
                    .of_kind(error.kind()),
            })
    }

    fn property(
        &mut self,
        source: &Source<'_>,
        node: Node<'_, '_>,
        nested: usize,
    ) -> Result<Property> {
        let tag = node.tag_name().name();
        let place = source.place(node);
        let name = self.attribute(source, node, "name")?.unwrap_or_default();
        let name = if self.is_old { snake_case(&name) } else { name };
        let value = match tag {
            "float" | "integer" => Value::Number(self.numbers::<1>(source, node)?[0]),
            "boolean" => {
                let text = self.required(source, node, "value")?;
                match text.to_ascii_lowercase().as_str() {
                    "true" => Value::Boolean(true),
                    "false" => Value::Boolean(false),
                    _ => {
                        let why = format!("expected true or false, found {}", shown(&text));
                        return Err(place.error(why));
                    }
                }
            }
            "string" => Value::Text(self.required(source, node, "value")?),
            "point" | "vector" => Value::Vector(self.vector(source, node, 0.0)?),
            "rgb" => Value::Colour(self.colour(source, node)?),
            "spectrum" if node.attribute("type").is_none() => {
                Value::Colour(self.spectrum(source, node)?)
            }
            "transform" => {
                let mut steps = Vec::new();
                for step in node.children().filter(Node::is_element) {
                    steps.push(self.step(source, step)?);
                }
                Value::Transform(
                    steps
                        .into_iter()
                        .fold(Default::default(), |all, next| next * all),
                )
            }
            "ref" => {
                let id = self.required(source, node, "id")?;
                Value::Object(Rc::clone(self.object_of_id(source, node, &id)?))
            }
            _ if OBJECTS.contains(&tag) => Value::Object(self.object(source, node, nested)?),
            _ => {
                let known = [
                    OBJECTS,
                    &[
                        "float",
                        "integer",
                        "boolean",
                        "string",
                        "point",
                        "vector",
                        "rgb",
                        "transform",
                        "ref",
                        "default",
                        "include",
                        "alias",
                    ],
                ]
                .concat();
                return Err(place.error(unknown_name("element", tag, &known)));
            }
        };
        Ok(Property {
            name,
            place,
            value,
            used: Cell::new(false),
        })
    }

    fn object(
        &mut self,
        source: &Source<'_>,
        node: Node<'_, '_>,
        nested: usize,
    ) -> Result<Rc<Object>> {
        let kind = self.required(source, node, "type")?;
        let id = self.attribute(source, node, "id")?;
        let tag = node.tag_name().name();
        let mut properties = self.properties(source, node, nested + 1)?;
        if self.is_old && tag == "bsdf" && kind == "diffuse" {
            for property in &mut properties {
                if property.name == "diffuse_reflectance" {
                    property.name = "reflectance".to_owned();
                }
            }
        }
        let object = Rc::new(Object {
            tag: tag.to_owned(),
            id: match &id {
                Some(id) => format!("{tag} `{}`", shown(id)),
                None => format!("{tag} `{}`", shown(&kind)),
            },
            kind,
            place: source.place(node),
            properties,
        });
        if let Some(id) = id {
            self.insert(source, node, id, Rc::clone(&object))?;
        }
        Ok(object)
    }

    /// The object of an id, which is declared before.
    fn object_of_id(
        &self,
        source: &Source<'_>,
        node: Node<'_, '_>,
        id: &str,
    ) -> Result<&Rc<Object>> {
        self.known.get(id).ok_or_else(|| {
            let ids: Vec<&str> = self.known.keys().map(String::as_str).collect();
            source.place(node).error(unknown_name("id", id, &ids))
        })
    }

    /// Declares an object's id.
    fn insert(
        &mut self,
        source: &Source<'_>,
        node: Node<'_, '_>,
        id: String,
        object: Rc<Object>,
    ) -> Result<()> {
        let why = format!("there is an object of the id `{}` already", shown(&id));
        match self.known.insert(id, object) {
            Some(_) => Err(source.place(node).error(why)),
            None => Ok(()),
        }
    }

    pub(super) fn attribute(
        &self,
        source: &Source<'_>,
        node: Node<'_, '_>,
        name: &str,
    ) -> Result<Option<String>> {
        let Some(written) = node.attribute(name) else {
            return Ok(None);
        };
        let mut text = String::new();
        let mut rest = written;
        while let Some((before, after)) = rest.split_once('$') {
            text.push_str(before);
            // The longest name, as one may begin with another.
            let known = self
                .defaults
                .keys()
                .filter(|name| after.starts_with(name.as_str()));
            let Some(name) = known.max_by_key(|name| name.len()) else {
                let word: String = after
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                let names: Vec<&str> = self.defaults.keys().map(String::as_str).collect();
                return Err(source
                    .place(node)
                    .error(unknown_name("parameter", &word, &names)));
            };
            text.push_str(&self.defaults[name]);
            rest = &after[name.len()..];
        }
        text.push_str(rest);
        Ok(Some(text))
    }

    pub(super) fn required(
        &self,
        source: &Source<'_>,
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

    pub(super) fn list(&self, source: &Source<'_>, node: Node<'_, '_>) -> Result<Vec<f64>> {
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

    pub(super) fn numbers<const N: usize>(
        &self,
        source: &Source<'_>,
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
        source: &Source<'_>,
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

    pub(super) fn number(
        &self,
        source: &Source<'_>,
        node: Node<'_, '_>,
        text: &str,
    ) -> Result<f64> {
        let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| {
            let why = format!("expected a finite number, found {}", shown(text));
            source.place(node).error(why)
        })
    }

    fn colour(&self, source: &Source<'_>, node: Node<'_, '_>) -> Result<Rgb> {
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

    fn spectrum(&self, source: &Source<'_>, node: Node<'_, '_>) -> Result<Rgb> {
        let is_sampled = |text: Option<&str>| text.is_some_and(|text| text.contains(':'));
        if node.has_attribute("filename") || is_sampled(node.attribute("value")) {
            let why = "spectra by wavelength are not supported: expected one value, or `rgb`";
            return Err(source.place(node).error(why));
        }
        self.colour(source, node)
    }
}
