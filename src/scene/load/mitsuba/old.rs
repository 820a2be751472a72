//! Scenes of versions before 2: their names and properties as those of today.
//!
//! Measure: texture coordinates.
//! Range: names in camel case, the reflectance of `diffuse`, and scales and offsets of textures. Where a texture has
//! `to_uv` besides, its scales and offsets are left alone.
//! Source: Mitsuba 3, which upgrades scenes in this way. Tested in `tests/loading/mitsuba.rs`.

use super::object::Value;
use super::references::{WrittenProperty, WrittenValue};
use crate::math::vec::{DAffine3, DVec3};

/// A name in camel case in snake case: `toWorld` as `to_world`, `intIOR` as `int_ior`.
pub fn snake_case(name: &str) -> String {
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

/// Upgrades the properties of an object of this type.
pub fn upgrade(kind: &str, properties: &mut Vec<WrittenProperty>) {
    for property in properties.iter_mut() {
        if kind == "diffuse" && property.name == "diffuse_reflectance" {
            property.name = "reflectance".to_owned();
        }
    }
    let number = |name: &str| {
        let named = properties.iter().find(|property| property.name == name);
        match named?.value {
            WrittenValue::Plain(Value::Number(number)) => Some(number),
            _ => None,
        }
    };
    let names = ["uoffset", "voffset", "uscale", "vscale"];
    let numbers = names.map(number);
    let [u, v, u_scale, v_scale] = numbers;
    let is_one = |property: &WrittenProperty| {
        let index = names.iter().position(|name| *name == property.name);
        index.is_some_and(|index| numbers[index].is_some())
    };
    if properties.iter().any(|property| property.name == "to_uv") {
        return;
    }
    let Some(place) = properties.iter().find(|property| is_one(property)) else {
        return;
    };
    let place = place.place.clone();
    properties.retain(|property| !is_one(property));
    let offset = DVec3::new(u.unwrap_or(0.0), v.unwrap_or(0.0), 0.0);
    let scale = DVec3::new(u_scale.unwrap_or(1.0), v_scale.unwrap_or(1.0), 1.0);
    let to_uv = DAffine3::from_scale(scale) * DAffine3::from_translation(offset);
    properties.push(WrittenProperty {
        name: "to_uv".to_owned(),
        place,
        value: WrittenValue::Plain(Value::Transform(to_uv)),
    });
}
