//! Parses the XML of a Mitsuba scene, and of the files that it includes, into objects.
//!
//! Measure: as written; angles of rotations in degrees.
//! Range: any text; an error has file and line. Elements are nested at most 64 deep, files include at most 16 deep and
//! 1000 in all, so that neither a cycle nor a bomb ends badly; elements `path` add at most 100 folders.
//! Source: Mitsuba 3 documentation, "Scene XML file format". Tested in `tests/loading/mitsuba.rs` and
//! `tests/loading/mitsuba_files.rs`.

use super::super::read_text;
use super::super::wording::{shown, unknown_name};
use super::folders::Folders;
use super::object::{Value, XmlObject};
use super::old::{snake_case, upgrade};
use super::parameters::Parameters;
use super::references::{MAX_NESTED, SceneObjects, WrittenProperty, WrittenValue, too_deep};
use crate::error::{Error, Result};
use crate::scene::description::Place;
use roxmltree::{Document, Node};
use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

const MAX_INCLUDES_NESTED: usize = 16;
const MAX_INCLUDES: usize = 1000;
const MAX_PATHS: usize = 100;

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

/// The other elements.
const OTHERS: &[&str] = &[
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
    "path",
];

/// Reads a scene and all files that it includes; returns its top-level objects as the properties of one object.
///
/// # Errors
/// If a file cannot be read, or something in it is not as the format requires.
pub fn read(path: &Path) -> Result<XmlObject> {
    let mut reader = DocumentReader::default();
    let folders = Folders::of_file(path, None);
    let written = reader.file(path, Rc::clone(&folders), None)?;
    Ok(XmlObject {
        tag: "scene".to_owned(),
        kind: String::new(),
        name: String::new(),
        place: Place::of_file(path),
        folders,
        properties: reader.objects.resolved(written)?,
    })
}

#[derive(Default)]
pub(super) struct DocumentReader {
    /// The values of `$names`.
    pub(super) parameters: Parameters,
    /// The number of bytes that these values inserted, or that were compared with names in vain.
    pub(super) inserted: Cell<usize>,
    /// The number of bytes of all files.
    pub(super) bytes: usize,
    objects: SceneObjects,
    includes: usize,
    paths: usize,
}

/// One file.
pub(super) struct SourceFile<'a> {
    path: &'a Path,
    /// The bytes at which its lines end.
    line_ends: Vec<usize>,
    pub(super) folders: Rc<Folders>,
    includes_nested: usize,
    /// Whether the file is of a version before 2, in which names are in camel case.
    is_old: bool,
}

impl SourceFile<'_> {
    pub(super) fn place(&self, node: Node<'_, '_>) -> Place {
        let start = node.range().start;
        Place::on_line(
            self.path,
            1 + self.line_ends.partition_point(|&end| end < start),
        )
    }
}

/// An element `include`.
struct Includer<'a> {
    source: &'a SourceFile<'a>,
    /// The name of what is included, if it is an object.
    name: String,
    nested: usize,
}

impl DocumentReader {
    /// Reads a file, which another one includes or not.
    fn file(
        &mut self,
        path: &Path,
        folders: Rc<Folders>,
        includer: Option<Includer<'_>>,
    ) -> Result<Vec<WrittenProperty>> {
        let text = read_text(path)?;
        self.bytes = self.bytes.saturating_add(text.len());
        let document = Document::parse(&text).map_err(|error| {
            let line = error.pos().row as usize;
            Error::scene(format!("expected XML: {}", shown(&error.to_string())))
                .in_file(path)
                .at_line(line)
        })?;
        let root = document.root_element();
        let by = includer.as_ref().map(|by| by.source);
        let source = SourceFile {
            path,
            line_ends: text.match_indices('\n').map(|(end, _)| end).collect(),
            folders,
            includes_nested: by.map_or(0, |by| by.includes_nested + 1),
            is_old: match root.attribute("version") {
                Some(version) => is_old(version),
                // An included file without a version is of that of the file that includes it.
                None => by.is_some_and(|by| by.is_old),
            },
        };
        let tag = root.tag_name().name();
        let (nested, expected) = match includer {
            Some(by) if OBJECTS.contains(&tag) => {
                let mut object = self.property(&source, root, by.nested)?;
                object.name = by.name;
                return Ok(vec![object]);
            }
            Some(by) => (by.nested, "an element `scene` or an object"),
            None => (0, "an element `scene`"),
        };
        if tag != "scene" {
            let why = format!("expected {expected}, found `{}`", shown(tag));
            return Err(source.place(root).error(why));
        }
        self.properties(&source, root, nested)
    }

    fn properties(
        &mut self,
        source: &SourceFile<'_>,
        parent: Node<'_, '_>,
        nested: usize,
    ) -> Result<Vec<WrittenProperty>> {
        if nested > MAX_NESTED {
            return Err(too_deep(&source.place(parent)));
        }
        let mut properties = Vec::new();
        for node in parent.children().filter(Node::is_element) {
            match node.tag_name().name() {
                "default" => {
                    let name = self.required(source, node, "name")?;
                    let value = self.required(source, node, "value")?;
                    self.parameters.add(name, value);
                }
                "include" => properties.append(&mut self.include(source, node, nested)?),
                "path" => self.path(source, node)?,
                "alias" => {
                    let [id, alias] = ["id", "as"].map(|name| self.required(source, node, name));
                    let (id, alias) = (id?, alias?);
                    let place = source.place(node);
                    let index = self.objects.index_of(&id, &place)?;
                    self.objects.declare(alias, index, &place)?;
                }
                _ => properties.push(self.property(source, node, nested)?),
            }
        }
        Ok(properties)
    }

    fn include(
        &mut self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
        nested: usize,
    ) -> Result<Vec<WrittenProperty>> {
        let file = self.required(source, node, "filename")?;
        let name = self.name(source, node)?;
        self.includes += 1;
        if source.includes_nested >= MAX_INCLUDES_NESTED || self.includes > MAX_INCLUDES {
            let why = format!(
                "expected files that include at most {MAX_INCLUDES_NESTED} deep and {MAX_INCLUDES} in all: does {} include itself?",
                shown(&file)
            );
            return Err(source.place(node).error(why));
        }
        let path = source.folders.find(&file);
        let folders = Folders::of_file(&path, Some(&source.folders));
        let includer = Includer {
            source,
            name,
            nested,
        };
        self.file(&path, folders, Some(includer))
            .map_err(|error| match error.line() {
                // The place in the included file says more than that of the include.
                Some(_) => error,
                None => source
                    .place(node)
                    .error(error.to_string())
                    .of_kind(error.kind()),
            })
    }

    /// Adds a folder in which files are looked for.
    fn path(&mut self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<()> {
        let name = self.required(source, node, "value")?;
        let is_at_top = node.parent_element() == Some(node.document().root_element());
        let folder = source.folders.find(&name);
        self.paths += 1;
        let why = if !is_at_top {
            "expected `path` directly within the outermost element".to_owned()
        } else if self.paths > MAX_PATHS {
            format!("expected at most {MAX_PATHS} elements `path`")
        } else if !folder.is_dir() {
            format!("expected a folder, found {}", shown(&name))
        } else {
            source.folders.add(folder);
            return Ok(());
        };
        Err(source.place(node).error(why))
    }

    /// The attribute `name`, or nothing.
    fn name(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<String> {
        let name = self.attribute(source, node, "name")?.unwrap_or_default();
        Ok(match source.is_old {
            true => snake_case(&name),
            false => name,
        })
    }

    fn property(
        &mut self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
        nested: usize,
    ) -> Result<WrittenProperty> {
        let tag = node.tag_name().name();
        let name = self.name(source, node)?;
        let value = match tag {
            "ref" => WrittenValue::Reference(self.required(source, node, "id")?),
            "spectrum" if node.attribute("type").is_none() => {
                WrittenValue::Plain(Value::Spectrum(self.spectrum(source, node)?))
            }
            _ if OBJECTS.contains(&tag) => WrittenValue::Object(self.object(source, node, nested)?),
            _ => WrittenValue::Plain(self.plain(source, node)?),
        };
        Ok(WrittenProperty {
            name,
            place: source.place(node),
            value,
        })
    }

    /// A value that contains no objects.
    fn plain(&self, source: &SourceFile<'_>, node: Node<'_, '_>) -> Result<Value> {
        Ok(match node.tag_name().name() {
            "float" | "integer" => Value::Number(self.numbers::<1>(source, node)?[0]),
            "boolean" => {
                let text = self.required(source, node, "value")?;
                match text.to_ascii_lowercase().as_str() {
                    "true" => Value::Boolean(true),
                    "false" => Value::Boolean(false),
                    _ => {
                        let why = format!("expected true or false, found {}", shown(&text));
                        return Err(source.place(node).error(why));
                    }
                }
            }
            "string" => Value::Text(self.required(source, node, "value")?),
            "point" | "vector" => Value::Vector(self.vector(source, node, 0.0)?),
            "rgb" => Value::Colour(self.colour(source, node)?),
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
            tag => {
                let known = [OBJECTS, OTHERS].concat();
                let why = unknown_name("element", tag, &known);
                return Err(source.place(node).error(why));
            }
        })
    }

    /// Reads an object and returns its index.
    fn object(
        &mut self,
        source: &SourceFile<'_>,
        node: Node<'_, '_>,
        nested: usize,
    ) -> Result<usize> {
        let kind = self.required(source, node, "type")?;
        let id = self.attribute(source, node, "id")?;
        let tag = node.tag_name().name();
        let mut properties = self.properties(source, node, nested + 1)?;
        if source.is_old {
            upgrade(&kind, &mut properties);
        }
        let place = source.place(node);
        let object = XmlObject {
            tag: tag.to_owned(),
            name: shown(id.as_ref().unwrap_or(&kind)),
            kind,
            place: place.clone(),
            folders: Rc::clone(&source.folders),
            properties: Vec::new(),
        };
        let index = self.objects.add(object, properties);
        if let Some(id) = id {
            self.objects.declare(id, index, &place)?;
        }
        Ok(index)
    }
}

/// Whether a version is one before 2.
fn is_old(version: &str) -> bool {
    let major = version.split('.').next().unwrap_or_default();
    major.trim().parse().is_ok_and(|major: u32| major < 2)
}
