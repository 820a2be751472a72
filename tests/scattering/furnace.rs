//! White furnace tests over the whole range of each scattering model: its albedo. Cases with exact answers are in the
//! battery.

use crate::common::closed_forms::GGX_NORMAL_ALBEDO;
use crate::common::quadrature::{Adaptive, Rectangle};
use crate::common::verdict::assert_mean;
use etendue::internals::bsdf::albedo::AlbedoRow;
use etendue::internals::bsdf::microfacet::Ggx;
use etendue::internals::bsdf::{
    Bsdf, ClearCoat, Coated, CoatedBase, Conductor, Dielectric, Diffuse, Lobe, Mirror, Phong,
    Principled, PrincipledParameters,
};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{Vec2, Vec3};
use etendue::internals::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, Place,
};
use etendue::internals::scene::material::Material;
use etendue_lab::battery::albedo::view;
use std::f64::consts::{FRAC_PI_2, PI};

/// A metal that reflects everything: in f32, |k| = 1e6 has no absorption.
fn white_metal(roughness: f32) -> Bsdf {
    Bsdf::Conductor(Conductor::new(Rgb::WHITE, Rgb::grey(1e6), roughness))
}

fn principled(metallic: f32, roughness: f32, transmission: f32) -> Bsdf {
    Bsdf::Principled(Principled::new(&PrincipledParameters {
        base_color: Rgb::WHITE,
        metallic,
        roughness,
        ior: 1.5,
        transmission,
    }))
}

/// The albedo of the green channel towards `wo`, as the means of `replicates` jittered grids.
fn albedo(bsdf: &Bsdf, ior: f32, wo: Vec3, replicates: u64, grid: u32) -> Moments {
    let numbers = etendue_lab::battery::albedo::albedo(bsdf, ior, wo, (replicates, grid), 1);
    Moments::of(numbers)
}

/// The [`albedo`] without a change of medium, to a standard error of 1e-3: narrow lobes with little multiple scattering
/// between facets need more samples.
fn precise_albedo(bsdf: &Bsdf, wo: Vec3) -> Moments {
    let moments = albedo(bsdf, 1.0, wo, 16, 48);
    if moments.standard_error() < Some(0.7e-3) {
        return moments;
    }
    albedo(bsdf, 1.0, wo, 16, 256)
}

#[test]
fn white_diffuse_and_mirror_have_unit_albedo() {
    for cos in [1.0, 0.3, 1e-3] {
        for bsdf in [
            Bsdf::Diffuse(Diffuse::new(Rgb::WHITE)),
            Bsdf::Mirror(Mirror::new(Rgb::WHITE)),
        ] {
            let moments = albedo(&bsdf, 1.0, view(cos), 16, 8);
            assert!((moments.mean() - 1.0).abs() < 2e-6);
            assert_eq!(moments.variance(), Some(0.0));
        }
    }
}

#[test]
fn smooth_glass_has_unit_albedo() {
    // Hard case 11: indices next to 1.
    for ior in [1.0, 1.000_001, 1.0001, 1.5, 1.0 / 1.5, 2.4] {
        let glass = Bsdf::Dielectric(Dielectric::new(ior, 0.0, Rgb::WHITE));
        for cos in [1.0, 0.5, 0.1, 1e-3] {
            for wo in [view(cos), -view(cos)] {
                let moments = albedo(&glass, ior, wo, 16, 8);
                assert!(
                    (moments.mean() - 1.0).abs() < 2e-6,
                    "{ior} {wo} {}",
                    moments.mean()
                );
            }
        }
    }
}

#[test]
fn thin_dielectric_reflectance_matches_closed_form() {
    // One side reflects R = ((1 - n) / (1 + n))^2 along the normal; with all reflections in between, a pane reflects
    // 2R / (1 + R) = (n - 1)^2 / (n^2 + 1).
    let tint = Rgb::new(0.9, 0.5, 0.1);
    for ior in [1.0_f32, 1.3, 1.5, 2.4] {
        let exact = (ior - 1.0).powi(2) / (ior * ior + 1.0);
        let pane = Dielectric::thin(ior, tint);
        for wo in [view(1.0), -view(1.0)] {
            let sample = |u_lobe| pane.sample(wo, u_lobe, Vec2::splat(0.3)).expect("a delta");
            if exact > 0.0 {
                let s = sample(0.999 * exact);
                assert_eq!((s.lobe, s.weight), (Lobe::SpecularReflection, Rgb::WHITE));
                assert!((s.wi - wo).length() < 1e-6);
            }
            let s = sample(1.001 * exact + 1e-6);
            assert_eq!((s.lobe, s.weight), (Lobe::SpecularTransmission, tint));
            assert_eq!(s.wi, -wo);
        }
        for cos in [1.0, 0.5, 0.1, 1e-3] {
            let glass = Bsdf::Dielectric(Dielectric::thin(ior, Rgb::WHITE));
            let moments = albedo(&glass, 1.0, view(cos), 16, 8);
            assert!((moments.mean() - 1.0).abs() < 2e-6, "{ior} {cos}");
        }
    }
}

#[test]
fn dielectric_with_ior_one_transmits_unscattered() {
    let tint = Rgb::new(0.9, 0.5, 0.1);
    for roughness in [0.0, 0.1, 0.5, 1.0] {
        let glass = Dielectric::new(1.0, roughness, tint);
        for wo in [view(1.0), view(0.3), -view(0.3), view(1e-6)] {
            for u_lobe in [0.0, 0.5, 1.0 - 6e-8] {
                let s = glass
                    .sample(wo, u_lobe, Vec2::splat(0.3))
                    .expect("light passes");
                assert_eq!(s.lobe, Lobe::SpecularTransmission);
                assert!((s.wi + wo).length() < 1e-6, "{wo} {}", s.wi);
                assert_eq!(s.weight, tint);
            }
        }
    }
}

#[test]
fn single_scattering_ggx_albedo_matches_closed_form() {
    for (alpha, exact) in GGX_NORMAL_ALBEDO {
        let tabulated = 1.0 - AlbedoRow::new(&Ggx::new(alpha)).at(1.0).loss;
        assert!(
            (f64::from(tabulated) - exact).abs() < 1e-3 * exact,
            "{alpha} {tabulated}"
        );
    }
}

#[test]
fn energy_compensated_white_metal_has_unit_albedo() {
    let mut worst = 0.0_f64;
    for roughness in [
        0.0101, 0.015, 0.03, 0.06, 0.1, 0.2, 0.3, 0.42, 0.55, 0.7, 0.85, 1.0,
    ] {
        let metal = white_metal(roughness);
        for cos in [1.0, 0.9, 0.7, 0.4, 0.2, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4] {
            let moments = precise_albedo(&metal, view(cos));
            let error = moments.mean() - 1.0;
            let standard_error = moments.standard_error().expect("16 replicates");
            worst = worst.max(error.abs());
            assert!(standard_error <= 1e-3, "{roughness} {cos} {standard_error}");
            assert!(
                error.abs() <= 2e-3 + 5.2 * standard_error,
                "{roughness} {cos} {error}"
            );
        }
    }
    println!("white metal: worst furnace error {worst:.1e}");
}

/// Hard case 10. Along the normal the lobe's albedo is `specular` for any exponent. Elsewhere there are closed forms: the
/// integral of cos over the intersection of two half spaces at an angle t is pi (1 + cos t) / 2, and that of both cosines is
/// 2 / 3 (sin t + (pi - t) cos t). A narrow lobe reflects cos t of the light.
#[test]
fn phong_albedo_matches_closed_forms() {
    let specular = 0.75;
    for exponent in [0.0, 1.0, 1e2, 1e4, 1e6] {
        let lobe = Bsdf::Phong(Phong::new(Rgb::BLACK, Rgb::grey(specular), exponent));
        print!("phong of exponent {exponent} keeps");
        for cos in [1.0, 0.8, 0.5, 0.1] {
            let moments = albedo(&lobe, 1.0, view(cos), 64, 64);
            let standard_error = moments.standard_error().expect("64 replicates");
            let kept = moments.mean() / f64::from(specular);
            print!(" {kept:.4} at cos {cos},");
            assert!(
                kept <= 1.0 + 5.2 * standard_error,
                "{exponent} {cos} {kept}"
            );
            let (t, cos) = (f64::from(cos).acos(), f64::from(cos));
            let exact = if cos == 1.0 {
                1.0
            } else if exponent == 0.0 {
                0.5 * (1.0 + cos)
            } else if exponent == 1.0 {
                (t.sin() + (PI - t) * cos) / PI
            } else if exponent >= 1e4 && cos > 0.2 {
                // The mean cosine about the mirror direction is (n + 1) / (n + 2), which the normalisation cancels.
                cos
            } else {
                continue;
            };
            let what = format!("exponent {exponent}, cos {cos}");
            assert_mean(&what, &moments, f64::from(specular) * exact, 1e-3);
        }
        println!();
    }
    // With a diffuse lobe, the albedo is at most the sum of both.
    for exponent in [0.0, 1.0, 1e2, 1e4, 1e6] {
        let phong = Bsdf::Phong(Phong::new(Rgb::grey(0.6), Rgb::grey(0.4), exponent));
        let normal = albedo(&phong, 1.0, view(1.0), 64, 64);
        assert_mean(&format!("white phong {exponent}"), &normal, 1.0, 1e-3);
        for cos in [0.9, 0.5, 0.2, 0.01] {
            for wo in [view(cos), -view(cos)] {
                let moments = albedo(&phong, 1.0, wo, 16, 64);
                let standard_error = moments.standard_error().expect("16 replicates");
                assert!(
                    moments.mean() <= 1.0 + 5.2 * standard_error,
                    "{exponent} {wo}"
                );
                assert!(
                    moments.mean() >= 0.6 - 5.2 * standard_error,
                    "{exponent} {wo}"
                );
            }
        }
    }
}

#[test]
fn ggx_visible_normal_pdf_integrates_to_one() {
    // Row 6, the weak white furnace: reflection at every visible normal, without shadowing towards wi, loses no energy.
    let quadrature = Adaptive::new(1e-7, 60);
    for alpha in [1e-4, 3e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0] {
        let ggx = Ggx::new(alpha);
        for cos in [1e-3, 1e-2, 0.1, 0.5, 1.0] {
            let wo = view(cos);
            let density = |below_pole: f64, azimuth: f64| {
                let r = (below_pole * (2.0 - below_pole)).sqrt();
                let (x, y) = (r * azimuth.cos(), r * azimuth.sin());
                let m = Vec3::new(x as f32, y as f32, (1.0 - below_pole) as f32);
                f64::from(ggx.pdf_visible(wo, m))
            };
            // The peak is at the pole; quarters of the azimuth place it at a corner of the domain.
            let sum: f64 = (0..4)
                .map(|k| {
                    let from = f64::from(k) * FRAC_PI_2;
                    let domain = Rectangle {
                        x: (0.0, 1.0),
                        y: (from, from + FRAC_PI_2),
                    };
                    quadrature.integrate(&density, domain)
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-4, "{alpha} {cos} {sum}");
        }
    }
}

#[test]
fn rough_glass_albedo_is_between_known_minima_and_one() {
    println!(
        "rough glass of 1.5, single scattering: albedo at cos 1 and 0.1, from outside and inside"
    );
    for alpha in [0.1_f32, 0.3, 0.5, 1.0] {
        let glass = Bsdf::Dielectric(Dielectric::new(1.5, alpha.sqrt(), Rgb::WHITE));
        let [a, b, c, d] = [view(1.0), view(0.1), -view(1.0), -view(0.1)].map(|wo| {
            let moments = albedo(&glass, 1.5, wo, 16, 64);
            let standard_error = moments.standard_error().expect("16 replicates");
            assert!(standard_error < 1e-3 * moments.mean(), "{alpha} {wo}");
            assert!(moments.mean() <= 1.0 + 5.2 * standard_error, "{alpha} {wo}");
            moments.mean()
        });
        println!("  alpha {alpha}: {a:.4} {b:.4}   {c:.4} {d:.4}");
        // The loss is that of other single-scattering models, and not larger.
        let least = [(0.1, 0.98), (0.3, 0.85), (0.5, 0.66), (1.0, 0.3)]
            .iter()
            .find(|&&(known, _)| known == alpha)
            .map_or(0.0, |&(_, least)| least);
        assert!(a > least, "{alpha} {a}");
    }
}

#[test]
fn white_principled_is_lossless_if_opaque_and_gains_no_energy() {
    let mut worst = 0.0_f64;
    for roughness in [0.0, 0.0101, 0.05, 0.2, 0.45, 0.7, 1.0] {
        for metallic in [0.0, 0.4, 1.0] {
            let surface = principled(metallic, roughness, 0.0);
            for cos in [1.0, 0.7, 0.3, 0.1, 0.01, 1e-3] {
                for wo in [view(cos), -view(cos)] {
                    let moments = precise_albedo(&surface, wo);
                    let standard_error = moments.standard_error().expect("16 replicates");
                    let error = moments.mean() - 1.0;
                    worst = worst.max(error.abs());
                    let what = format!("{metallic} {roughness} {cos} {error} {standard_error}");
                    assert!(standard_error <= 1e-3, "{what}");
                    // The tables' error, 0.25 %, bounds both the loss and the gain.
                    assert!(error.abs() <= 2.5e-3 + 5.2 * standard_error, "{what}");
                }
            }
        }
        for transmission in [0.3, 1.0] {
            let surface = principled(0.0, roughness, transmission);
            for cos in [1.0, 0.3, 0.01] {
                for wo in [view(cos), -view(cos)] {
                    let moments = albedo(&surface, 1.5, wo, 16, 48);
                    let standard_error = moments.standard_error().expect("16 replicates");
                    assert!(
                        moments.mean() <= 1.0025 + 5.2 * standard_error,
                        "{roughness} {cos}"
                    );
                }
            }
        }
    }
    println!("principled white: worst furnace error {worst:.1e}");
}

/// A white mirror under a smooth coat reflects everything: the coat takes from its base what it reflects. No coated surface
/// reflects more, and of a rough one the loss is bounded by the albedo of the coat.
#[test]
fn white_metal_under_a_clear_coat_gains_no_energy() {
    for roughness in [0.0, 0.1, 0.5] {
        for ior in [1.0, 1.5, 2.4] {
            let coat = ClearCoat::new(1.0, roughness, ior);
            for base in [0.0, 0.1, 0.5] {
                let Bsdf::Conductor(metal) = white_metal(base) else {
                    unreachable!("it is metal");
                };
                let bsdf = Bsdf::Coated(Coated::new(CoatedBase::Conductor(metal), coat));
                for cos in [1.0, 0.5, 0.1, 1e-2] {
                    let moments = precise_albedo(&bsdf, view(cos));
                    let standard_error = moments.standard_error().expect("16 replicates");
                    let what = format!("{roughness} {ior} {base} {cos} {moments:?}");
                    let bound = 2.5e-3 + 5.2 * standard_error;
                    assert!(moments.mean() <= 1.0 + bound, "{what}");
                    if roughness == 0.0 && base == 0.0 {
                        assert!(moments.mean() >= 1.0 - bound, "{what}");
                    }
                    if cos == 1.0 {
                        assert!(moments.mean() >= 0.8, "{what}");
                    }
                }
            }
        }
    }
}

/// Hard case 8: the base receives all light that the coat transmits, at any index.
#[test]
fn white_plastic_has_unit_albedo() {
    let mut worst = 0.0_f64;
    for ior in [1.0, 1.0001, 1.3, 2.4] {
        for roughness in [0.0, 0.1, 0.5, 1.0] {
            let model = MaterialModel::Plastic {
                reflectance: ColourDescription::Constant(Rgb::WHITE),
                ior,
                roughness,
            };
            let description = MaterialDescription::new("plastic", Place::default(), model);
            let plastic = Material::new(&description, 1.0);
            let bsdf = plastic.bsdf::<Everything>(Vec2::ZERO);
            for cos in [1.0, 0.5, 0.1, 1e-3] {
                let moments = precise_albedo(&bsdf, view(cos));
                let standard_error = moments.standard_error().expect("16 replicates");
                let error = moments.mean() - 1.0;
                worst = worst.max(error.abs());
                let what = format!("{ior} {roughness} {cos} {error} {standard_error}");
                assert!(standard_error <= 1e-3, "{what}");
                assert!(error.abs() <= 2.5e-3 + 5.2 * standard_error, "{what}");
            }
        }
    }
    println!("white plastic: worst furnace error {worst:.1e}");
}
