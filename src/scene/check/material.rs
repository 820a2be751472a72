//! Checks a material by the rules of `load`.
//!
//! Measure: reflectances without unit.
//! Range: any material.
//! Source: docs/scene-format.md. Tested in `tests/loading/built_scenes.rs`.

use super::values::{colour, not_negative, positive, require};
use crate::error::Result;
use crate::math::rgb::Rgb;
use crate::scene::description::{ColourDescription, MaterialDescription, MaterialModel};
use std::sync::Arc;

/// Checks a material.
///
/// # Errors
/// If the material is invalid.
pub fn material(material: &MaterialDescription) -> Result<()> {
    let field = |key: &str| format!("material `{}`: {key}", material.name);
    let share = |key: &str, x: f32| {
        let is_share = (0.0..=1.0).contains(&x);
        require(is_share, || field(key), "expected a number from 0 to 1")
    };
    let reflectance = |key: &str, c: &ColourDescription| colour(c, 1.0, || field(key));
    let index = |ior: f32| {
        let is_index = ior >= 1.0 && ior.is_finite();
        require(
            is_index,
            || field("ior"),
            "expected a finite number of at least 1",
        )
    };
    let positive_index = |ior: f32| {
        let is_index = ior > 0.0 && ior.is_finite();
        require(
            is_index,
            || field("ior"),
            "expected a finite number above 0",
        )
    };
    reflectance("alpha", &material.alpha)?;
    if let Some(cutoff) = material.alpha_cutoff {
        share("alpha_cutoff", cutoff)?;
    }
    if let Some(map) = &material.metallic_roughness_map {
        let map = ColourDescription::Texture(Arc::clone(map));
        reflectance("metallic_roughness_map", &map)?;
    }
    if let Some(map) = &material.normal_map {
        let is_fine = map.strength >= 0.0 && map.strength.is_finite();
        let expected = "expected a finite strength of at least 0";
        require(is_fine, || field("normal_map"), expected)?;
    }
    match &material.model {
        MaterialModel::Diffuse { reflectance: r } | MaterialModel::Mirror { reflectance: r } => {
            reflectance("reflectance", r)
        }
        MaterialModel::Conductor {
            eta,
            k,
            roughness,
            tint,
        } => {
            reflectance("tint", &ColourDescription::Constant(*tint))?;
            positive(*eta, || field("eta"))?;
            not_negative(*k, || field("k"))?;
            share("roughness", *roughness)
        }
        MaterialModel::Phong {
            diffuse,
            specular,
            exponent,
        } => {
            reflectance("diffuse", diffuse)?;
            reflectance("specular", specular)?;
            let sum = brightest(diffuse) + brightest(specular);
            require(
                sum.max_channel() <= 1.0,
                || field("specular"),
                "expected diffuse and specular of at most 1 together in every channel",
            )?;
            let fits = (0.0..=1e6).contains(exponent);
            require(
                fits,
                || field("exponent"),
                "expected a number from 0 to 1e6",
            )
        }
        MaterialModel::Plastic {
            reflectance: r,
            ior,
            roughness,
        } => {
            reflectance("reflectance", r)?;
            index(*ior)?;
            share("roughness", *roughness)
        }
        MaterialModel::Dielectric {
            ior,
            roughness,
            tint,
        } => {
            positive_index(*ior)?;
            share("roughness", *roughness)?;
            reflectance("tint", tint)
        }
        MaterialModel::ThinDielectric { ior, tint } => {
            positive_index(*ior)?;
            reflectance("tint", tint)
        }
        MaterialModel::Principled {
            base_color,
            metallic,
            roughness,
            ior,
            transmission,
        } => {
            reflectance("base_color", base_color)?;
            share("metallic", *metallic)?;
            share("roughness", *roughness)?;
            index(*ior)?;
            share("transmission", *transmission)
        }
    }?;
    require(
        material.two_sided || !material.transmits(),
        || field("two_sided"),
        "a transmissive material has two sides",
    )
}

/// Returns the largest value in each channel.
fn brightest(colour: &ColourDescription) -> Rgb {
    match colour {
        ColourDescription::Constant(colour) => *colour,
        ColourDescription::Texture(texture) => texture.brightest(),
    }
}
