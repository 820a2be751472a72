//! The objects of a Mitsuba scene while it is read: references stand for objects of any place in any file, and become
//! these when all files are read.
//!
//! Measure: none.
//! Range: objects contain others at most 64 deep and four million of them, counted once for each reference, so that no
//! later step takes too long or too much of the stack; a cycle is an error.
//! Source: Mitsuba 3 documentation, "Scene XML file format". Tested in `tests/loading/mitsuba_files.rs`.

use super::super::wording::{shown, unknown_name};
use super::object::{Property, Value, XmlObject};
use crate::error::Result;
use crate::scene::description::Place;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::mem;
use std::rc::Rc;

/// Maximum depth of objects within one another.
pub const MAX_NESTED: usize = 64;

/// Maximum number of objects within one, and in a scene; a reference counts all that its object consists of.
const MAX_WITHIN: u64 = 1 << 20;

/// A property as written.
#[derive(Debug)]
pub struct WrittenProperty {
    pub name: String,
    pub place: Place,
    pub value: WrittenValue,
}

/// A value as written.
#[derive(Debug)]
pub enum WrittenValue {
    Plain(Value),
    /// An object, by its index.
    Object(usize),
    /// An object, by its id.
    Reference(String),
}

/// A finished object with its depth, and the number of objects that it consists of.
#[derive(Debug, Clone)]
struct Finished {
    object: Rc<XmlObject>,
    depth: usize,
    size: u64,
}

#[derive(Debug)]
enum ObjectSlot {
    /// An object without its properties, and these as written.
    Written(XmlObject, Vec<WrittenProperty>),
    /// An object whose properties are being resolved.
    Open,
    Finished(Finished),
}

/// All objects of a scene, and the ids of those that have one.
#[derive(Debug, Default)]
pub struct SceneObjects {
    slots: Vec<ObjectSlot>,
    ids: BTreeMap<String, usize>,
}

impl SceneObjects {
    /// Adds an object with its properties, which replace those that it has, and returns its index.
    pub fn add(&mut self, object: XmlObject, properties: Vec<WrittenProperty>) -> usize {
        self.slots.push(ObjectSlot::Written(object, properties));
        self.slots.len() - 1
    }

    /// Declares an id.
    ///
    /// # Errors
    /// If another object has it.
    pub fn declare(&mut self, id: String, index: usize, place: &Place) -> Result<()> {
        let why = format!("there is an object of the id `{}` already", shown(&id));
        match self.ids.insert(id, index) {
            Some(_) => Err(place.error(why)),
            None => Ok(()),
        }
    }

    /// Returns the index of the object of an id that is declared already.
    ///
    /// # Errors
    /// If there is none.
    pub fn index_of(&self, id: &str, place: &Place) -> Result<usize> {
        self.ids.get(id).copied().ok_or_else(|| {
            let ids: Vec<&str> = self.ids.keys().map(String::as_str).collect();
            place.error(unknown_name("id", id, &ids))
        })
    }

    /// Returns the properties of the scene, in which references have become objects.
    ///
    /// # Errors
    /// If there is no object of an id, or objects contain themselves or too many others.
    pub fn resolved(mut self, properties: Vec<WrittenProperty>) -> Result<Vec<Property>> {
        let mut size = 0;
        let resolved = properties.into_iter().map(|property| {
            let (property, finished) = self.property(property, 0)?;
            size += finished.map_or(0, |it| it.size);
            if size > MAX_WITHIN {
                let why = format!("expected at most {MAX_WITHIN} objects in a scene");
                return Err(property.place.error(why));
            }
            Ok(property)
        });
        resolved.collect()
    }

    fn property(
        &mut self,
        written: WrittenProperty,
        outside: usize,
    ) -> Result<(Property, Option<Finished>)> {
        let WrittenProperty { name, place, value } = written;
        let (value, finished) = match value {
            WrittenValue::Plain(value) => (value, None),
            WrittenValue::Object(index) => self.value(index, &place, outside)?,
            WrittenValue::Reference(id) => {
                let index = self.index_of(&id, &place)?;
                self.value(index, &place, outside)?
            }
        };
        let used = Cell::new(false);
        let property = Property {
            name,
            place,
            value,
            used,
        };
        Ok((property, finished))
    }

    fn value(
        &mut self,
        index: usize,
        place: &Place,
        outside: usize,
    ) -> Result<(Value, Option<Finished>)> {
        let finished = self.object(index, place, outside)?;
        Ok((Value::Object(Rc::clone(&finished.object)), Some(finished)))
    }

    /// Returns an object that so many others contain.
    fn object(&mut self, index: usize, place: &Place, outside: usize) -> Result<Finished> {
        let (mut object, properties) = match mem::replace(&mut self.slots[index], ObjectSlot::Open)
        {
            ObjectSlot::Open => {
                return Err(place.error("expected an object that does not contain itself"));
            }
            ObjectSlot::Finished(finished) => {
                self.slots[index] = ObjectSlot::Finished(finished.clone());
                return Ok(finished);
            }
            ObjectSlot::Written(object, properties) => (object, properties),
        };
        let mut depth = 0;
        let mut size = 1_u64;
        for property in properties {
            if outside >= MAX_NESTED {
                return Err(too_deep(place));
            }
            let (property, within) = self.property(property, outside + 1)?;
            if let Some(within) = within {
                depth = depth.max(within.depth);
                size = size.saturating_add(within.size);
            }
            object.properties.push(property);
        }
        if depth >= MAX_NESTED {
            return Err(too_deep(place));
        }
        if size > MAX_WITHIN {
            let why = format!("expected at most {MAX_WITHIN} objects within one");
            return Err(object.place.error(why));
        }
        let finished = Finished {
            object: Rc::new(object),
            depth: depth + 1,
            size,
        };
        self.slots[index] = ObjectSlot::Finished(finished.clone());
        Ok(finished)
    }
}

/// The error about an object that contains others, or is contained, too deep.
pub fn too_deep(place: &Place) -> crate::Error {
    place.error(format!(
        "expected elements nested at most {MAX_NESTED} deep"
    ))
}
