//! Scattering models: their albedos and their limits.
//!
//! Measure: albedos; fractions.
//! Range: views from the normal down to a cosine of 1e-4, roughness from 0 to 1.
//! Source: Heitz 2014 for the microfacet models; closed forms at each. Tested in `lab/tests/reports/battery.rs`.

use super::albedo::{albedo, view};
use super::case::{Case, Effort, Trial};
use super::claim::Claim;
use super::closed_forms::GGX_NORMAL_ALBEDO;
use crate::bench::random::Random;
use crate::scene_builder::grey;
use etendue::internals::bsdf::microfacet::Ggx;
use etendue::internals::bsdf::{Bsdf, Conductor, Dielectric, Phong};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{Vec2, Vec3, reflect};
use etendue::internals::scene::description::{
    ClearCoatDescription, MaterialDescription, MaterialModel, Place,
};
use etendue::internals::scene::material::Material;
use std::f64::consts::PI;

/// The maximum error of the tables for energy compensation.
const TABLES: f64 = 2.5e-3;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    [
        single_scattering(),
        white_metal_is_white(),
        rough_glass(),
        layered_models(),
        phong(),
        smooth_glass(),
        ever_smoother(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A metal with reflectance 1: in f32, |k| = 1e6 leaves no absorption.
fn white_metal(alpha: f32) -> Bsdf {
    Bsdf::Conductor(Conductor::new(Rgb::WHITE, Rgb::grey(1e6), alpha.sqrt()))
}

/// A case about the albedo of a model, on grids of `grid` samples along each side.
fn albedo_case(
    row: u32,
    name: String,
    claim: Claim,
    (bsdf, ior): (Bsdf, f32),
    wo: Vec3,
    grid: u32,
) -> Case {
    Case::new(row, name, claim, move |trial| {
        let replicates = trial.either(16, 64);
        Ok(albedo(&bsdf, ior, wo, (replicates, grid), trial.seed))
    })
}

fn single_scattering() -> Vec<Case> {
    let case = |(alpha, exact): (f32, f64)| {
        let name = format!("GGX mirror of alpha {alpha}, single scattering, seen along the normal");
        Case::new(4, name, Claim::mean(exact, 1e-3), move |trial| {
            Ok(single_scatter(trial, alpha))
        })
    };
    GGX_NORMAL_ALBEDO.map(case).into()
}

/// The albedo of a microfacet mirror for single scattering.
fn single_scatter(trial: &Trial<'_>, alpha: f32) -> Vec<f64> {
    const GRID: u32 = 64;
    let ggx = Ggx::new(alpha);
    let replicate = |replicate: u64| {
        let mut random = Random::new(trial.seed, replicate);
        let one = |cell: u32| {
            let jitter = Vec2::new(random.uniform(), random.uniform());
            let corner = Vec2::new((cell % GRID) as f32, (cell / GRID) as f32);
            let u = (corner + jitter) / GRID as f32;
            let wi = reflect(Vec3::Z, ggx.sample_visible(Vec3::Z, u));
            if wi.z > 0.0 {
                f64::from(1.0 - ggx.shadowed(Vec3::Z, wi))
            } else {
                0.0
            }
        };
        (0..GRID * GRID).map(one).sum::<f64>() / f64::from(GRID * GRID)
    };
    (0..trial.either(64, 256)).map(replicate).collect()
}

fn white_metal_is_white() -> Vec<Case> {
    let alphas = [1.1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0];
    let all = alphas
        .into_iter()
        .flat_map(|alpha| [1.0, 0.4, 0.1, 1e-2, 1e-4].map(|cos: f32| (alpha, cos)));
    let case = |(alpha, cos): (f32, f32)| {
        let name = format!("white metal of alpha {alpha:e}, compensated, at cos {cos:e}");
        // Narrow lobes and grazing views need more samples.
        let grid = if alpha < 0.02 || cos < 0.02 { 160 } else { 64 };
        let claim = Claim::mean(1.0, 1e-3).within(2e-3);
        albedo_case(5, name, claim, (white_metal(alpha), 1.0), view(cos), grid)
    };
    all.map(case).collect()
}

/// Rough glass: single scattering loses what microfacets shadow; no energy is gained.
fn rough_glass() -> Vec<Case> {
    let all = [0.1, 0.3, 0.5, 1.0]
        .into_iter()
        .flat_map(|alpha| [1.0, 0.1, -1.0, -0.1].map(|cos: f32| (alpha, cos)));
    let case = |(alpha, cos): (f32, f32)| {
        let glass = Bsdf::Dielectric(Dielectric::new(1.5, alpha.sqrt(), Rgb::WHITE));
        let name = format!("rough glass of alpha {alpha} at cos {cos}");
        let wo = view(cos.abs()) * cos.signum();
        albedo_case(7, name, Claim::at_most(1.0, 1e-3), (glass, 1.5), wo, 64)
    };
    all.map(case).collect()
}

/// Layered models: opaque white ones reflect everything, and none returns more than it receives.
fn layered_models() -> Vec<Case> {
    let white = || grey(1.0);
    let mut cases = Vec::new();
    let mut add = |description: MaterialDescription, transmits: bool, cos: f32| {
        let material = Material::new(&description, 1.0);
        let bsdf = material.bsdf::<Everything>(Vec2::ZERO).into_owned();
        let name = format!("{} at cos {cos:e}", description.name);
        let claim = if transmits {
            Claim::at_most(1.0, 1e-3)
        } else {
            Claim::mean(1.0, 1e-3)
        };
        let claim = claim.within(TABLES);
        cases.push(albedo_case(8, name, claim, (bsdf, 1.5), view(cos), 96));
    };
    let named = |name, model| MaterialDescription::new(name, Place::default(), model);
    for cos in [1.0, 0.1, 1e-3] {
        for (roughness, metallic) in [(0.05, 0.0), (0.45, 0.4), (1.0, 0.0), (1.0, 1.0)] {
            let name =
                format!("white principled surface, roughness {roughness}, metallic {metallic}");
            let model = MaterialModel::Principled {
                base_color: white(),
                metallic,
                roughness,
                ior: 1.5,
                transmission: 0.0,
            };
            add(named(name, model), false, cos);
        }
        for (roughness, ior) in [(0.0, 1.3), (0.5, 1.5), (1.0, 2.4)] {
            let name = format!("white plastic of index {ior}, roughness {roughness}");
            let model = MaterialModel::Plastic {
                reflectance: white(),
                ior,
                roughness,
            };
            add(named(name, model), false, cos);
        }
        for (roughness, transmission) in [(0.0, 1.0), (0.45, 0.3), (1.0, 1.0)] {
            let name = format!(
                "white principled glass, roughness {roughness}, transmission {transmission}"
            );
            let model = MaterialModel::Principled {
                base_color: white(),
                metallic: 0.0,
                roughness,
                ior: 1.5,
                transmission,
            };
            add(named(name, model), true, cos);
        }
        for ior in [1.0, 1.5, 2.4] {
            let mirror = MaterialModel::Conductor {
                eta: Rgb::WHITE,
                // In single precision, without absorption.
                k: Rgb::grey(1e6),
                roughness: 0.0,
                tint: Rgb::WHITE,
            };
            let name = format!("white mirror under a smooth clear coat of index {ior}");
            let coated = MaterialDescription {
                clear_coat: Some(ClearCoatDescription {
                    weight: 1.0,
                    roughness: 0.0,
                    ior,
                }),
                ..named(name, mirror)
            };
            add(coated, false, cos);
        }
    }
    cases
}

/// Phong lobes. Along the normal the albedo is `specular` for any exponent. Elsewhere there are closed forms: the
/// integral of cos over two half spaces at an angle t is pi (1 + cos t) / 2, and that of both cosines is 2 / 3 (sin t +
/// (pi - t) cos t). A narrow lobe keeps cos t of the light.
fn phong() -> Vec<Case> {
    let specular = 0.75;
    let oblique = |exponent: f32, cos: f64| {
        let t = cos.acos();
        match exponent {
            0.0 => 0.5 * (1.0 + cos),
            1.0 => (t.sin() + (PI - t) * cos) / PI,
            // The mean cosine about the mirror direction is (n + 1) / (n + 2), which the normalisation cancels.
            _ => cos,
        }
    };
    let exponents = [0.0, 1.0, 1e2, 1e4, 1e6];
    let normal = exponents.map(|exponent| (exponent, 1.0, 1.0));
    let slanted = [0.0, 1.0, 1e4, 1e6].map(|exponent| (exponent, 0.5, oblique(exponent, 0.5)));
    let case = |(exponent, cos, share): (f32, f32, f64)| {
        let lobe = Bsdf::Phong(Phong::new(Rgb::BLACK, Rgb::grey(specular), exponent));
        let name = format!("Phong lobe of exponent {exponent:e} at cos {cos}");
        let claim = Claim::mean(f64::from(specular) * share, 1e-3);
        albedo_case(10, name, claim, (lobe, 1.0), view(cos), 128)
    };
    normal.into_iter().chain(slanted).map(case).collect()
}

fn smooth_glass() -> Vec<Case> {
    let indices = [1.0, 1.000_001, 1.0001, 1.5];
    let all = indices
        .into_iter()
        .flat_map(|ior| [1.0, 1e-3, -0.5].map(|cos: f32| (ior, cos)));
    let case = |(ior, cos): (f32, f32)| {
        let glass = Bsdf::Dielectric(Dielectric::new(ior, 0.0, Rgb::WHITE));
        let name = format!("smooth glass of index {ior} at cos {cos:e}");
        let wo = view(cos.abs()) * cos.signum();
        let claim = Claim::without_noise(1.0, 2e-6);
        albedo_case(11, name, claim, (glass, ior), wo, 8)
    };
    all.map(case).collect()
}

/// The fraction of light that white metal, seen along its normal, reflects within half a degree of the mirror
/// direction: by microfacets tilted by up to half of that, tan^2 / (alpha^2 + tan^2) of them; all of the light where
/// the metal is a delta lobe.
fn ever_smoother() -> Vec<Case> {
    let case = |alpha: f32| {
        let facet2 = (0.5 * LIGHT_RADIUS).sin().powi(2);
        let tan2 = facet2 / (1.0 - facet2);
        let exact = match white_metal(alpha).is_delta::<Everything>() {
            true => 1.0,
            false => tan2 / (f64::from(alpha).powi(2) + tan2),
        };
        let name = format!("metal of alpha {alpha:e} mirrors a light of 1 degree");
        let claim = Claim::mean(exact, 2e-3).within(TABLES * exact);
        Case::new(15, name, claim, move |trial| Ok(near_mirror(trial, alpha)))
    };
    // At 1e-4 metal becomes a delta lobe; two values are just above and below it.
    [1e-2, 1e-3, 3e-4, 1.01e-4, 0.99e-4, 1e-6, 1e-8]
        .map(case)
        .into()
}

/// The radius of the light: half a degree.
const LIGHT_RADIUS: f64 = PI / 360.0;

fn near_mirror(trial: &Trial<'_>, alpha: f32) -> Vec<f64> {
    let metal = white_metal(alpha);
    let chord = (2.0 * (0.5 * LIGHT_RADIUS).sin()) as f32;
    let samples = trial.samples(1 << 16);
    let replicate = |replicate: u64| {
        let mut random = Random::new(trial.seed, replicate);
        let one = |_| {
            let mut u = || random.uniform();
            let (u_lobe, u) = (u(), Vec2::new(u(), u()));
            let sample = metal.sample::<Everything>(Vec3::Z, u_lobe, u);
            let near = sample.filter(|s| (s.wi - Vec3::Z).length() < chord);
            near.map_or(0.0, |s| f64::from(s.weight.to_array()[1]))
        };
        (0..samples).map(one).sum::<f64>() / samples as f64
    };
    (0..32).map(replicate).collect()
}
