//! Materials of a pbrt file.
//!
//! Measure: pbrt's roughness is remapped to the microfacet alpha as its square root; ours is the square root of alpha.
//! Range: every class of material of pbrt-v4. What differs here is noted.
//! Source: pbrt-v4's file format; Jensen et al. 2001, eq. 15, for the albedo of subsurface scattering. Tested in
//! `tests/loading/pbrt.rs`.

use super::library::Library;
use super::params::Parameters;
use super::textured::{Mapping, Textured};
use crate::error::Result;
use crate::image::ColourSpace;
use crate::math::rgb::Rgb;
use crate::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, NormalMapDescription,
};
use crate::scene::load::wording::unknown_name;
use std::collections::HashMap;
use std::sync::Arc;

/// A material as shapes refer to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Made {
    /// No surface: the border between two media.
    Interface,
    /// A material, by its index, and what its textures change of texture coordinates.
    Surface { index: usize, mapping: Mapping },
}

/// Materials with opacity, by the material without it and the opacity.
pub type Worn = HashMap<(usize, String), usize>;

/// The alpha below which pbrt takes a surface as smooth.
const SMOOTH: f64 = 1e-3;

const CLASSES: &[&str] = &[
    "coatedconductor",
    "coateddiffuse",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "hair",
    "interface",
    "measured",
    "mix",
    "subsurface",
    "thindielectric",
];

impl Library {
    /// Reads the parameters of a material of this class, and adds it under a name for messages.
    ///
    /// # Errors
    /// If a parameter is not as the class requires.
    pub fn make_material(
        &mut self,
        class: &str,
        name: &str,
        params: &Parameters,
        named: &HashMap<String, Made>,
    ) -> Result<Made> {
        let mut mapping = None;
        let model = match class {
            "interface" | "none" | "" => {
                self.note_unused(params);
                return Ok(Made::Interface);
            }
            "mix" => return self.mix_materials(params, named),
            "diffuse" => MaterialModel::Diffuse {
                reflectance: self.textured(params, "reflectance", 0.5, &mut mapping)?,
            },
            "coateddiffuse" => self.coated_diffuse(params, &mut mapping)?,
            "conductor" => self.conductor(params, "", &mut mapping)?,
            "coatedconductor" => self.coated_conductor(params, &mut mapping)?,
            "dielectric" => MaterialModel::Dielectric {
                ior: self.ior(params, "eta")?,
                roughness: self.roughness(params, "")?,
                tint: Rgb::WHITE.into(),
            },
            "thindielectric" => self.thin_dielectric(params)?,
            "diffusetransmission" => self.diffuse_transmission(params, &mut mapping)?,
            "subsurface" => self.subsurface(params, &mut mapping)?,
            "hair" | "measured" => {
                let what =
                    format!("material class `{class}` became diffuse with a reflectance of 0.5");
                self.approximated(&params.place, what);
                return Ok(self.add(name, params, grey(0.5), None));
            }
            _ => return Err(params.error(unknown_name("material class", class, CLASSES))),
        };
        if params.has("displacement") {
            self.omitted(
                &params.place_of("displacement"),
                "displacement was left out",
            );
        }
        let made = self.add(name, params, model, mapping);
        if let (Some(file), Made::Surface { index, .. }) = (params.text("normalmap")?, made) {
            let path = self.path(file);
            let texture = self.contents.textures.read(&path, ColourSpace::Linear, 1.0);
            let texture = texture.map_err(|error| self.about(params, "normalmap", &error))?;
            self.contents.materials[index].normal_map = Some(NormalMapDescription {
                texture: Arc::new(texture),
                strength: 1.0,
            });
        }
        self.note_unused(params);
        Ok(made)
    }

    fn add(
        &mut self,
        name: &str,
        params: &Parameters,
        model: MaterialModel,
        mapping: Option<Mapping>,
    ) -> Made {
        let description = MaterialDescription::new(name, params.place.clone(), model);
        Made::Surface {
            index: self.contents.add_material(description),
            mapping: mapping.unwrap_or_default(),
        }
    }

    /// A reflectance; sets the material's mapping to that of its texture.
    fn textured(
        &mut self,
        params: &Parameters,
        name: &str,
        default: f32,
        mapping: &mut Option<Mapping>,
    ) -> Result<ColourDescription> {
        let textured = self.reflectance(params, name, default)?;
        if textured.colour.constant().is_none() {
            *mapping = Some(textured.mapping);
        }
        Ok(textured.colour)
    }

    fn coated_diffuse(
        &mut self,
        params: &Parameters,
        mapping: &mut Option<Mapping>,
    ) -> Result<MaterialModel> {
        self.note_medium_of_coat(params)?;
        let reflectance = self.textured(params, "reflectance", 0.5, mapping)?;
        let ior = self.ior_of_coat(params, "eta")?;
        let roughness = self.roughness(params, "")?;
        let what = "the random walk between the coat and the diffuse base became the closed form of `plastic`";
        self.approximated(&params.place, what);
        Ok(MaterialModel::Plastic {
            reflectance,
            ior,
            roughness,
        })
    }

    /// Notes a medium between coat and base; its thickness has no effect without one.
    fn note_medium_of_coat(&mut self, params: &Parameters) -> Result<()> {
        let albedo = self.reflectance(params, "albedo", 0.0)?;
        for ignored in ["thickness", "g", "maxdepth", "nsamples"] {
            params.has(ignored);
        }
        if !albedo.colour.is_black() {
            self.omitted(
                &params.place_of("albedo"),
                "the medium between coat and base was left out",
            );
        }
        Ok(())
    }

    /// The refractive index of a coat, at least 1.
    fn ior_of_coat(&mut self, params: &Parameters, name: &str) -> Result<f32> {
        let ior = self.ior(params, name)?;
        if ior < 1.0 {
            self.approximated(
                &params.place_of(name),
                "the index of a coat below 1 became 1",
            );
        }
        Ok(ior.max(1.0))
    }

    /// A metal of an index, by default copper's, or of a reflectance.
    fn conductor(
        &mut self,
        params: &Parameters,
        prefix: &str,
        mapping: &mut Option<Mapping>,
    ) -> Result<MaterialModel> {
        let (eta_name, k_name) = (format!("{prefix}eta"), format!("{prefix}k"));
        let k_name = if params.has(&k_name) {
            k_name
        } else {
            "k".to_owned()
        };
        let roughness = self.roughness(params, prefix)?;
        let has_index = params.has(&eta_name) || params.has(&k_name);
        if params.has("reflectance") && has_index {
            return Err(params.error_of(
                "reflectance",
                "expected either a reflectance, or eta and k, not both",
            ));
        }
        if params.has("reflectance") {
            return self.metal_of_reflectance(params, roughness, mapping);
        }
        for name in [&eta_name, &k_name] {
            if params.texture(name)?.is_some() {
                return Err(params.error_of(
                    name,
                    "expected a spectrum: textured indices are not supported",
                ));
            }
        }
        let copper = |name| match crate::scene::load::spectrum::named(name) {
            Some(crate::scene::load::spectrum::Named::Index(index)) => index,
            _ => Rgb::WHITE,
        };
        let eta = self
            .index(params, &eta_name)?
            .unwrap_or_else(|| copper("metal-Cu-eta"));
        let k = self
            .index(params, &k_name)?
            .unwrap_or_else(|| copper("metal-Cu-k"));
        if eta.to_array().iter().any(|x| *x <= 0.0) {
            return Err(params.error_of(&eta_name, "expected a refractive index above 0"));
        }
        Ok(MaterialModel::Conductor { eta, k, roughness })
    }

    /// pbrt gives a metal of this reflectance at normal incidence an index of 1 and the absorption that follows.
    fn metal_of_reflectance(
        &mut self,
        params: &Parameters,
        roughness: f32,
        mapping: &mut Option<Mapping>,
    ) -> Result<MaterialModel> {
        let base_color = self.textured(params, "reflectance", 0.5, mapping)?;
        if let Some(colour) = base_color.constant() {
            let absorption = |r: f32| {
                let r = f64::from(r).min(0.9999);
                (2.0 * (r / (1.0 - r)).sqrt()) as f32
            };
            return Ok(MaterialModel::Conductor {
                eta: Rgb::WHITE,
                k: colour.map(absorption),
                roughness,
            });
        }
        let what =
            "the metal of a textured reflectance became principled: its Fresnel term is Schlick's";
        self.approximated(&params.place_of("reflectance"), what);
        Ok(MaterialModel::Principled {
            base_color,
            metallic: 1.0,
            roughness,
            ior: 1.5,
            transmission: 0.0,
        })
    }

    fn coated_conductor(
        &mut self,
        params: &Parameters,
        mapping: &mut Option<Mapping>,
    ) -> Result<MaterialModel> {
        self.note_medium_of_coat(params)?;
        self.roughness(params, "interface.")?;
        self.ior(params, "interface.eta")?;
        self.omitted(&params.place, "the coat of a coated conductor was left out");
        self.conductor(params, "conductor.", mapping)
    }

    fn thin_dielectric(&mut self, params: &Parameters) -> Result<MaterialModel> {
        self.ior(params, "eta")?;
        self.approximated(
            &params.place,
            "a thin dielectric became one of index 1: it reflects nothing",
        );
        Ok(MaterialModel::Dielectric {
            ior: 1.0,
            roughness: 0.0,
            tint: Rgb::WHITE.into(),
        })
    }

    fn diffuse_transmission(
        &mut self,
        params: &Parameters,
        mapping: &mut Option<Mapping>,
    ) -> Result<MaterialModel> {
        self.reflectance(params, "transmittance", 0.25)?;
        let scale =
            params.number_where("scale", 1.0, "a number of at least 0", |x| x >= 0.0)? as f32;
        let reflectance = self.reflectance(params, "reflectance", 0.25)?;
        *mapping = Some(reflectance.mapping);
        self.omitted(
            &params.place,
            "diffuse transmission was left out: the material only reflects",
        );
        let reflectance = if scale == 1.0 {
            reflectance
        } else {
            reflectance.map(|colour| scale * colour).clamped()
        };
        Ok(MaterialModel::Diffuse {
            reflectance: reflectance.colour,
        })
    }

    /// A diffuse base of the albedo of subsurface scattering, under a dielectric coat.
    fn subsurface(
        &mut self,
        params: &Parameters,
        mapping: &mut Option<Mapping>,
    ) -> Result<MaterialModel> {
        let ior = params.number_where("eta", 1.33, "a number above 0", |x| {
            x > 0.0 && (x as f32).is_finite()
        })?;
        let ior = ior.max(1.0) as f32;
        let roughness = self.roughness(params, "")?;
        for ignored in ["scale", "g", "mfp"] {
            params.has(ignored);
        }
        let what = "subsurface scattering became diffuse reflection under a coat";
        self.approximated(&params.place, what);
        let reflectance = if params.has("reflectance") {
            self.textured(params, "reflectance", 0.5, mapping)?
        } else if params.text("name")?.is_some() {
            self.approximated(
                &params.place_of("name"),
                "the named medium became one of reflectance 0.5",
            );
            Rgb::grey(0.5).into()
        } else {
            let absorbed = self.coefficient(params, "sigma_a", Rgb::new(0.0011, 0.0024, 0.014))?;
            let scattered = self.coefficient(params, "sigma_s", Rgb::new(2.55, 3.21, 3.77))?;
            diffuse_albedo(absorbed, scattered, ior).into()
        };
        Ok(MaterialModel::Plastic {
            reflectance,
            ior,
            roughness,
        })
    }

    /// A coefficient of a medium; the mean of a texture.
    fn coefficient(&mut self, params: &Parameters, name: &str, default: Rgb) -> Result<Rgb> {
        match params.texture(name)? {
            Some(_) => Ok(self.reflectance(params, name, 0.0)?.mean()),
            None => Ok(self.index(params, name)?.unwrap_or(default)),
        }
    }

    /// One of two materials by the share of each, or their mean if both are diffuse.
    fn mix_materials(
        &mut self,
        params: &Parameters,
        named: &HashMap<String, Made>,
    ) -> Result<Made> {
        let names = params.texts("materials")?;
        let [first, second] = names else {
            return Err(params.error_of("materials", "expected the names of two materials"));
        };
        let find = |name: &String| match named.get(name) {
            Some(Made::Surface { index, mapping }) => Ok((*index, *mapping)),
            Some(Made::Interface) => {
                Err(params.error_of("materials", "an interface cannot be mixed"))
            }
            None => {
                let mut names: Vec<&str> = named.keys().map(String::as_str).collect();
                names.sort_unstable();
                Err(params.error_of("materials", unknown_name("material", name, &names)))
            }
        };
        let (first, second) = (find(first)?, find(second)?);
        let amount = self.float(params, "amount", 0.5)?;
        let share = amount.mean().to_array()[0].clamp(0.0, 1.0);
        self.note_unused(params);
        if let (Some(a), Some(b), Some(_)) = (
            self.diffuse(first.0),
            self.diffuse(second.0),
            amount.colour.constant(),
        ) {
            let model = MaterialModel::Diffuse {
                reflectance: a.lerp(b, share).into(),
            };
            return Ok(self.add("mix", params, model, None));
        }
        let (index, mapping) = if share < 0.5 { first } else { second };
        let name = &self.contents.materials[index].name;
        let what = format!("a mix of materials became the one with the greater share, `{name}`");
        self.approximated(&params.place, what);
        Ok(Made::Surface { index, mapping })
    }

    /// The reflectance of a material that is diffuse, of one colour, and has no normal map.
    fn diffuse(&self, index: usize) -> Option<Rgb> {
        let material = &self.contents.materials[index];
        match &material.model {
            MaterialModel::Diffuse { reflectance } if material.normal_map.is_none() => {
                reflectance.constant()
            }
            _ => None,
        }
    }

    /// The perceptual roughness of the parameters with this prefix.
    fn roughness(&mut self, params: &Parameters, prefix: &str) -> Result<f32> {
        let remap = params.truth("remaproughness", true)?;
        let both = format!("{prefix}roughness");
        let along = |name: String| {
            if params.has(&name) {
                name
            } else {
                both.clone()
            }
        };
        let [u, v] = [format!("{prefix}uroughness"), format!("{prefix}vroughness")].map(along);
        let mut alphas = [0.0; 2];
        for (alpha, name) in alphas.iter_mut().zip([&u, &v]) {
            let textured = self.float(params, name, 0.0)?;
            if textured.colour.constant().is_none() {
                self.approximated(
                    &params.place_of(name),
                    "a texture of roughness became its mean",
                );
            }
            let roughness = f64::from(textured.mean().to_array()[0]);
            if roughness < 0.0 || !roughness.is_finite() {
                return Err(params.error_of(
                    name,
                    format!("expected a roughness of at least 0, found {roughness}"),
                ));
            }
            *alpha = if remap { roughness.sqrt() } else { roughness };
        }
        let [u_alpha, v_alpha] = alphas;
        if u_alpha != v_alpha {
            let what = "anisotropic roughness became isotropic, of the geometric mean";
            self.approximated(&params.place_of(&u), what);
        }
        if u_alpha.max(v_alpha) < SMOOTH {
            return Ok(0.0);
        }
        let alpha = (u_alpha.max(SMOOTH) * v_alpha.max(SMOOTH)).sqrt();
        if alpha > 1.0 {
            self.approximated(&params.place_of(&u), "a microfacet alpha above 1 became 1");
        }
        Ok(alpha.min(1.0).sqrt() as f32)
    }

    /// The material with this opacity: a new one unless it is opaque or was asked for before.
    pub fn with_alpha(&mut self, index: usize, alpha: &Textured) -> usize {
        let mut material = self.contents.materials[index].clone();
        material.alpha = alpha.clone().clamped().colour;
        self.contents.add_material(material)
    }
}

/// A diffuse material.
fn grey(reflectance: f32) -> MaterialModel {
    MaterialModel::Diffuse {
        reflectance: Rgb::grey(reflectance).into(),
    }
}

/// The diffuse albedo of a half space of a medium, from the dipole approximation.
fn diffuse_albedo(absorbed: Rgb, scattered: Rgb, ior: f32) -> Rgb {
    let eta = f64::from(ior);
    // The internal diffuse reflectance, as fitted by Egan and Hilgeman 1973.
    let fresnel = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
    let boundary = (1.0 + fresnel) / (1.0 - fresnel);
    let (absorbed, scattered) = (absorbed.to_array(), scattered.to_array());
    Rgb::from([0, 1, 2].map(|i| {
        let (absorbed, scattered) = (f64::from(absorbed[i]), f64::from(scattered[i]));
        let albedo = scattered / (absorbed + scattered);
        if !albedo.is_finite() {
            return 0.0;
        }
        let root = (3.0 * (1.0 - albedo)).sqrt();
        let reflectance =
            0.5 * albedo * (1.0 + (-4.0 / 3.0 * boundary * root).exp()) * (-root).exp();
        reflectance.clamp(0.0, 1.0) as f32
    }))
}
