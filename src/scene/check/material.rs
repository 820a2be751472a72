//! Checks a material by the rules of `load`.
//!
//! Measure: reflectances without unit.
//! Range: any material.
//! Source: docs/scene-format.md. Tested in `tests/loading/built_scenes.rs`.

use super::values::{colour, not_negative, positive, require};
use crate::error::Result;
use crate::scene::description::{ColourDescription, MaterialDescription, MaterialModel};
use std::sync::Arc;

/// Checks a material.
///
/// # Errors
/// If the material is invalid.
pub fn material(material: &MaterialDescription) -> Result<()> {
    let fields = Fields {
        material: &material.name,
    };
    maps(fields, material)?;
    model(fields, &material.model)?;
    clear_coat(fields, material)?;
    require(
        material.two_sided || !material.transmits(),
        || fields.named("two_sided"),
        "a transmissive material has two sides",
    )
}

/// Checks the maps that any material may have.
fn maps(fields: Fields<'_>, material: &MaterialDescription) -> Result<()> {
    fields.reflectance("alpha", &material.alpha)?;
    if let Some(cutoff) = material.alpha_cutoff {
        fields.share("alpha_cutoff", cutoff)?;
    }
    if let Some(map) = &material.metallic_roughness_map {
        let map = ColourDescription::Texture(Arc::clone(map));
        fields.reflectance("metallic_roughness_map", &map)?;
    }
    if let Some(map) = &material.normal_map {
        let expected = "expected a finite strength";
        require(
            map.strength.is_finite(),
            || fields.named("normal_map"),
            expected,
        )?;
    }
    if let Some(map) = &material.bump_map {
        let named = || fields.named("bump_map");
        require(map.height.is_finite(), named, "expected a finite height")?;
        let is_alone = material.normal_map.is_none();
        require(is_alone, named, "expected either normal_map or bump_map")?;
    }
    Ok(())
}

/// Checks a clear coat, of which light has to come back.
fn clear_coat(fields: Fields<'_>, material: &MaterialDescription) -> Result<()> {
    let Some(coat) = &material.clear_coat else {
        return Ok(());
    };
    let has_base = material.model.takes_clear_coat();
    let named = |key: &str| fields.named(&format!("clear_coat{key}"));
    let expected = "expected a conductor, or a principled material without transmission";
    require(has_base, || named(""), expected)?;
    fields.share("clear_coat.weight", coat.weight)?;
    fields.share("clear_coat.roughness", coat.roughness)?;
    let is_index = coat.ior >= 1.0 && coat.ior.is_finite();
    let expected = "expected a finite number of at least 1";
    require(is_index, || named(".ior"), expected)
}

/// Checks the parameters of a model.
fn model(fields: Fields<'_>, model: &MaterialModel) -> Result<()> {
    match model {
        MaterialModel::Diffuse { reflectance } | MaterialModel::Mirror { reflectance } => {
            fields.reflectance("reflectance", reflectance)
        }
        MaterialModel::Conductor {
            eta,
            k,
            roughness,
            tint,
        } => {
            fields.reflectance("tint", &ColourDescription::Constant(*tint))?;
            positive(*eta, || fields.named("eta"))?;
            not_negative(*k, || fields.named("k"))?;
            fields.share("roughness", *roughness)
        }
        MaterialModel::Phong {
            diffuse,
            specular,
            exponent,
        } => phong(fields, diffuse, specular, *exponent),
        MaterialModel::Plastic {
            reflectance,
            ior,
            roughness,
        } => {
            fields.reflectance("reflectance", reflectance)?;
            fields.dense_index(*ior)?;
            fields.share("roughness", *roughness)
        }
        MaterialModel::Dielectric {
            ior,
            roughness,
            tint,
        } => {
            fields.index(*ior)?;
            fields.share("roughness", *roughness)?;
            fields.reflectance("tint", tint)
        }
        MaterialModel::ThinDielectric { ior, tint } => {
            fields.index(*ior)?;
            fields.reflectance("tint", tint)
        }
        MaterialModel::Principled {
            base_color,
            metallic,
            roughness,
            ior,
            transmission,
        } => {
            fields.reflectance("base_color", base_color)?;
            fields.share("metallic", *metallic)?;
            fields.share("roughness", *roughness)?;
            fields.dense_index(*ior)?;
            fields.share("transmission", *transmission)
        }
    }
}

/// Checks the parameters of the Phong model, which conserves energy if its two parts together do.
fn phong(
    fields: Fields<'_>,
    diffuse: &ColourDescription,
    specular: &ColourDescription,
    exponent: f32,
) -> Result<()> {
    fields.reflectance("diffuse", diffuse)?;
    fields.reflectance("specular", specular)?;
    let sum = diffuse.brightest() + specular.brightest();
    require(
        sum.max_channel() <= 1.0,
        || fields.named("specular"),
        "expected diffuse and specular of at most 1 together in every channel",
    )?;
    require(
        (0.0..=1e6).contains(&exponent),
        || fields.named("exponent"),
        "expected a number from 0 to 1e6",
    )
}

/// The fields of a material, for checks of one value each.
#[derive(Clone, Copy)]
struct Fields<'a> {
    /// The material's name.
    material: &'a str,
}

impl Fields<'_> {
    /// The name of a field in an error.
    fn named(self, key: &str) -> String {
        format!("material `{}`: {key}", self.material)
    }

    /// Checks a number from 0 to 1.
    fn share(self, key: &str, x: f32) -> Result<()> {
        let is_share = (0.0..=1.0).contains(&x);
        require(
            is_share,
            || self.named(key),
            "expected a number from 0 to 1",
        )
    }

    /// Checks a reflectance, which is from 0 to 1 in every channel.
    fn reflectance(self, key: &str, c: &ColourDescription) -> Result<()> {
        colour(c, 1.0, || self.named(key))
    }

    /// Checks an index of refraction that is at least that of the outside.
    fn dense_index(self, ior: f32) -> Result<()> {
        let is_index = ior >= 1.0 && ior.is_finite();
        let expected = "expected a finite number of at least 1";
        require(is_index, || self.named("ior"), expected)
    }

    /// Checks an index of refraction relative to the outside, which may be the denser of the two.
    fn index(self, ior: f32) -> Result<()> {
        let is_index = ior > 0.0 && ior.is_finite();
        let expected = "expected a finite number above 0";
        require(is_index, || self.named("ior"), expected)
    }
}
