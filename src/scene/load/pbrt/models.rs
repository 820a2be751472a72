//! The scattering models of a pbrt file's materials.
//!
//! Measure: pbrt's roughness is remapped to the microfacet alpha as its square root; ours is the square root of alpha.
//! Range: any parameters. What differs here is noted.
//! Source: pbrt-v4's file format; Jensen et al. 2001, eq. 15, for the albedo of subsurface scattering. Tested in
//! `tests/loading/pbrt/materials.rs`.

use super::library::Library;
use super::params::Parameters;
use super::textured::Mapping;
use crate::error::Result;
use crate::math::functions::exp;
use crate::math::rgb::Rgb;
use crate::scene::description::{ClearCoatDescription, MaterialModel};
use crate::scene::load::spectrum::{NamedSpectrum, named};

/// The alpha below which pbrt takes a surface as smooth.
const SMOOTH: f64 = 1e-3;

/// The least real part of a metal's index: pbrt allows 0, which ours divides by. At normal incidence, a metal of this one
/// reflects all light but at most 0.04 %, one of 0 all.
const MIN_INDEX: f32 = 1e-4;

impl Library {
    pub fn coated_diffuse(
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
    pub fn note_medium_of_coat(&mut self, params: &Parameters) -> Result<()> {
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
    pub fn ior_of_coat(&mut self, params: &Parameters, name: &str) -> Result<f32> {
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
    pub fn conductor(
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
        let copper = |name| match named(name) {
            Some(NamedSpectrum::Index(index)) => index,
            _ => Rgb::WHITE,
        };
        let eta = self
            .index(params, &eta_name)?
            .unwrap_or_else(|| copper("metal-Cu-eta"));
        let k = self
            .index(params, &k_name)?
            .unwrap_or_else(|| copper("metal-Cu-k"));
        if eta.to_array().iter().any(|x| *x < 0.0) {
            return Err(params.error_of(&eta_name, "expected a refractive index of at least 0"));
        }
        Ok(MaterialModel::Conductor {
            eta: eta.map(|x| x.max(MIN_INDEX)),
            k,
            roughness,
            tint: Rgb::WHITE,
        })
    }

    /// pbrt gives a metal of this reflectance at normal incidence an index of 1 and the absorption that follows.
    pub fn metal_of_reflectance(
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
                tint: Rgb::WHITE,
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

    /// A metal, whose index is relative to that of its coat, and the coat.
    pub fn coated_conductor(
        &mut self,
        params: &Parameters,
        mapping: &mut Option<Mapping>,
    ) -> Result<(MaterialModel, ClearCoatDescription)> {
        self.note_medium_of_coat(params)?;
        let coat = ClearCoatDescription {
            weight: 1.0,
            roughness: self.roughness(params, "interface.")?,
            ior: self.ior_of_coat(params, "interface.eta")?,
        };
        let what =
            "the random walk between the coat and the metal became the closed form of a clear coat";
        self.approximated(&params.place, what);
        let mut metal = self.conductor(params, "conductor.", mapping)?;
        if let MaterialModel::Conductor { eta, k, .. } = &mut metal {
            *eta *= 1.0 / coat.ior;
            *k *= 1.0 / coat.ior;
        }
        Ok((metal, coat))
    }

    pub fn thin_dielectric(&mut self, params: &Parameters) -> Result<MaterialModel> {
        Ok(MaterialModel::ThinDielectric {
            ior: self.ior(params, "eta")?,
            tint: Rgb::WHITE.into(),
        })
    }

    pub fn diffuse_transmission(
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
    pub fn subsurface(
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
    pub fn coefficient(&mut self, params: &Parameters, name: &str, default: Rgb) -> Result<Rgb> {
        match params.texture(name)? {
            Some(_) => Ok(self.reflectance(params, name, 0.0)?.mean()),
            None => Ok(self.index(params, name)?.unwrap_or(default)),
        }
    }

    /// The perceptual roughness of the parameters with this prefix.
    pub fn roughness(&mut self, params: &Parameters, prefix: &str) -> Result<f32> {
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
        let reflectance = 0.5 * albedo * (1.0 + exp(-4.0 / 3.0 * boundary * root)) * exp(-root);
        reflectance.clamp(0.0, 1.0) as f32
    }))
}
