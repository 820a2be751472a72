//! Consistency of every BSDF: densities, weights, reciprocity.

use crate::common::TestRng;
use crate::common::chi_square::ChiSquareTest;
use crate::common::verdict::sidak;
use etendue::internals::bsdf::conductor::{PRESETS, preset};
use etendue::internals::bsdf::{
    Bsdf, BsdfSampleInput, ClearCoat, Coated, CoatedBase, Conductor, Dielectric, Diffuse, Mirror,
    Phong, Principled, PrincipledParameters,
};
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::math::lanes::{LANES, load};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{ONE_MINUS_EPSILON, Vec2, Vec3};
use etendue::internals::sampling::warp::sample_hemisphere_cosine_lanes;

const ROUGHNESSES: [f32; 4] = [0.05, 0.2, 0.5, 1.0];
/// Phong exponents: hard case 10.
const EXPONENTS: [f32; 5] = [0.0, 1.0, 1e2, 1e4, 1e6];
const INDICES: [f32; 5] = [1.0, 1.0001, 1.5, 1.0 / 1.5, 2.4];

fn principled(base_color: Rgb, metallic: f32, roughness: f32, transmission: f32) -> Bsdf {
    Bsdf::Principled(Principled::new(&PrincipledParameters {
        base_color,
        metallic,
        roughness,
        ior: 1.5,
        transmission,
    }))
}

/// Every BSDF with many parameters: its name, the BSDF, and the index of refraction inside.
fn models() -> Vec<(String, Bsdf, f32)> {
    let colour = Rgb::new(0.8, 0.5, 0.2);
    let (eta, k) = preset("gold").expect("gold is a preset");
    let mut models = vec![
        (
            "diffuse".to_owned(),
            Bsdf::Diffuse(Diffuse::new(colour)),
            1.0,
        ),
        ("mirror".to_owned(), Bsdf::Mirror(Mirror::new(colour)), 1.0),
    ];
    for exponent in EXPONENTS {
        for (name, diffuse) in [
            ("phong", Rgb::new(0.2, 0.5, 0.1)),
            ("highlight", Rgb::BLACK),
        ] {
            let phong = Phong::new(diffuse, Rgb::new(0.5, 0.25, 0.1), exponent);
            models.push((format!("{name} {exponent}"), Bsdf::Phong(phong), 1.0));
        }
    }
    for roughness in [0.0].into_iter().chain(ROUGHNESSES) {
        let gold = Conductor::new(eta, k, roughness);
        models.push((format!("gold {roughness}"), Bsdf::Conductor(gold), 1.0));
        let tinted = Bsdf::Conductor(gold.tinted(colour));
        models.push((format!("tinted gold {roughness}"), tinted, 1.0));
        for ior in INDICES {
            let glass = Dielectric::new(ior, roughness, colour);
            models.push((
                format!("glass {ior} {roughness}"),
                Bsdf::Dielectric(glass),
                ior,
            ));
        }
        if roughness == 0.0 {
            let pane = Bsdf::Dielectric(Dielectric::thin(1.5, colour));
            models.push(("pane".into(), pane, 1.0));
        }
        for (metallic, transmission) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.0), (0.0, 1.0), (0.3, 0.4)]
        {
            let name = format!("principled {metallic} {roughness} {transmission}");
            models.push((
                name,
                principled(colour, metallic, roughness, transmission),
                1.5,
            ));
        }
    }
    for of_coat in [0.0, 0.2, 0.7] {
        let coat = ClearCoat::new(0.8, of_coat, 1.5);
        for roughness in [0.0, 0.05, 0.6] {
            let gold = CoatedBase::Conductor(Conductor::new(eta, k, roughness));
            let paint = CoatedBase::Principled(Principled::new(&PrincipledParameters {
                base_color: colour,
                metallic: 0.5,
                roughness,
                ior: 1.5,
                transmission: 0.0,
            }));
            for (name, base) in [("gold", gold), ("paint", paint)] {
                let bsdf = Bsdf::Coated(Coated::new(base, coat));
                models.push((format!("coated {name} {roughness} {of_coat}"), bsdf, 1.0));
            }
        }
    }
    models
}

/// Directions from the normal to cos 1e-3, on both sides.
fn views() -> Vec<Vec3> {
    let mut views = Vec::new();
    for (i, cos) in [1.0_f32, 0.8, 0.3, 0.05, 1e-3].into_iter().enumerate() {
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let (s, c) = (i as f32).sin_cos();
        for sign in [1.0, -1.0] {
            views.push(Vec3::new(sin * c, sin * s, sign * cos));
        }
    }
    views
}

#[test]
fn bsdf_samples_pass_chi_square_tests_against_the_pdf() {
    let mut checks = Vec::new();
    for (name, bsdf, _) in models() {
        if bsdf.is_delta::<Everything>() {
            continue;
        }
        for wo in views() {
            // Opaque models treat both sides by one code path; the chi-square test of one side is enough.
            if wo.z < 0.0 && !(name.starts_with("glass") || name.starts_with("principled 0.3")) {
                continue;
            }
            // An exponent of 0 cuts the lobe off at a right angle to the mirror direction. No quadrature of ours resolves such
            // a step; `tests/scattering/furnace.rs` has closed forms for it.
            if name.ends_with(" 0") && name.starts_with(['p', 'h']) && wo.z != 1.0 {
                continue;
            }
            let test = ChiSquareTest {
                seed: checks.len() as u64,
                ..Default::default()
            };
            let sample = |rng: &mut TestRng| {
                let s = bsdf.sample::<Everything>(wo, rng.uniform(), rng.uniform_2d())?;
                s.pdf.map(|_| s.wi)
            };
            let result = test.run(sample, |wi| bsdf.eval::<Everything>(wo, wi).pdf.0);
            checks.push((format!("{name} {wo}"), result));
        }
    }
    let threshold = sidak(0.001, checks.len());
    for (name, result) in &checks {
        assert!(result.p_value > threshold, "{name}: {result:?}");
        // The integral of the density and the probability of no sample add up to 1.
        let total = result.integral + result.none;
        assert!((total - 1.0).abs() < 0.02, "{name}: {result:?}");
    }
    println!("{} chi-square tests", checks.len());
}

#[test]
fn sample_weights_equal_f_cos_over_pdf() {
    let mut rng = TestRng::new(7);
    for (name, bsdf, _) in models() {
        for wo in views() {
            for _ in 0..500 {
                let Some(s) = bsdf.sample::<Everything>(wo, rng.uniform(), rng.uniform_2d()) else {
                    continue;
                };
                let value = bsdf.eval::<Everything>(wo, s.wi);
                let Some(pdf) = s.pdf else { continue };
                assert!(
                    (pdf.0 / value.pdf.0 - 1.0).abs() < 1e-5,
                    "{name} {wo} {s:?}"
                );
                let expected = (s.wi.z.abs() / value.pdf.0) * value.f;
                let difference = (s.weight - expected).map(f32::abs).max_channel();
                assert!(
                    difference <= 1e-5 * expected.max_channel(),
                    "{name} {wo} {s:?}"
                );
            }
        }
    }
}

#[test]
fn bsdfs_are_reciprocal() {
    let mut rng = TestRng::new(11);
    let mut worst = 0.0_f32;
    for (name, bsdf, ior) in models() {
        for k in 0..4000 {
            // Down to cos 1e-6, and near the mirror direction, where narrow lobes are.
            let wo = rng.direction_log_uniform(1e-6);
            let wi = if k % 2 == 0 {
                rng.direction_log_uniform(1e-6)
            } else {
                match bsdf.sample::<Everything>(wo, rng.uniform(), rng.uniform_2d()) {
                    Some(s) if s.pdf.is_some() => s.wi,
                    _ => continue,
                }
            };
            let index = |w: Vec3| if w.z > 0.0 { 1.0 } else { ior };
            // f / n_o^2 of refraction; reflection within one medium has no such factor.
            let scale = |o: Vec3, i: Vec3| {
                if o.z * i.z > 0.0 {
                    1.0
                } else {
                    1.0 / (index(o) * index(o))
                }
            };
            let there = (scale(wo, wi) * bsdf.eval::<Everything>(wo, wi).f).to_array();
            let back = (scale(wi, wo) * bsdf.eval::<Everything>(wi, wo).f).to_array();
            for (a, b) in there.into_iter().zip(back) {
                assert!(
                    a.is_finite() && a >= 0.0 && b.is_finite() && b >= 0.0,
                    "{name} {wo} {wi}"
                );
                let error = (a - b).abs() / a.max(b).max(f32::MIN_POSITIVE);
                // Below this f rounds as a denormal.
                if a.max(b) > 1e-30 {
                    worst = worst.max(error);
                    assert!(error < 1e-4, "{name} {wo} {wi}: {a} {b}");
                }
            }
        }
    }
    println!("reciprocity within {worst:.1e}");
}

#[test]
fn extreme_random_numbers_give_valid_samples_or_none() {
    let us = [0.0, 2.0_f32.powi(-32), 0.5, ONE_MINUS_EPSILON];
    let mut wos = views();
    wos.extend([
        Vec3::new(1.0, 0.0, 1e-6),
        Vec3::new(0.0, -1.0, -1e-6),
        Vec3::new(1.0, 0.0, 1e-30),
        Vec3::X,
    ]);
    for (name, bsdf, _) in models() {
        for &wo in &wos {
            for u_lobe in us {
                for u in us.iter().flat_map(|&x| us.map(|y| Vec2::new(x, y))) {
                    let Some(s) = bsdf.sample::<Everything>(wo, u_lobe, u) else {
                        continue;
                    };
                    let what = format!("{name} {wo} {u_lobe} {u} {s:?}");
                    assert!((s.wi.length() - 1.0).abs() < 1e-5, "{what}");
                    assert!(s.weight.is_finite(), "{what}");
                    assert!(s.weight.to_array().iter().all(|&w| w >= 0.0), "{what}");
                    assert!(s.pdf.is_none_or(|p| p.0 > 0.0 && p.0.is_finite()), "{what}");
                    let other_side = wo.z.is_sign_positive() != s.wi.z.is_sign_positive();
                    assert_eq!(s.lobe.is_transmission(), other_side, "{what}");
                }
            }
        }
    }
}

#[test]
fn is_delta_holds_exactly_if_no_sample_has_a_pdf() {
    for (name, bsdf, _) in models() {
        let mut rng = TestRng::new(3);
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let densities = (0..200)
            .filter_map(|_| bsdf.sample::<Everything>(wo, rng.uniform(), rng.uniform_2d()))
            .filter(|s| s.pdf.is_some())
            .count();
        assert_eq!(bsdf.is_delta::<Everything>(), densities == 0, "{name}");
    }
}

#[test]
fn conductor_presets_have_expected_reflectances() {
    assert!(PRESETS.iter().all(|(name, _, _)| preset(name).is_some()));
    assert_eq!(preset("adamant"), None);
    let reflectance = |name: &str| {
        let (eta, k) = preset(name).expect(name);
        let metal = Conductor::new(eta, k, 0.0);
        let s = metal
            .sample(Vec3::Z, 0.5, Vec2::splat(0.5))
            .expect("a mirror");
        s.weight.to_array()
    };
    let [r, g, b] = reflectance("gold");
    assert!(
        r > 0.9 && (0.6..0.85).contains(&g) && b < 0.5,
        "{r} {g} {b}"
    );
    let [r, g, b] = reflectance("copper");
    assert!(r > g && g > b, "{r} {g} {b}");
    assert!(reflectance("silver").into_iter().all(|x| x > 0.95));
    assert!(reflectance("aluminium").into_iter().all(|x| x > 0.88));
}

/// Both would be rounded differently if vector code used fused multiply-adds where scalar code does not.
#[test]
fn cosine_hemisphere_lanes_are_bit_identical_to_scalar_code() {
    let mut rng = TestRng::new(25);
    let rim = [0.0, 0.5, ONE_MINUS_EPSILON];
    for _ in 0..300 {
        let number = |i: usize, rng: &mut TestRng| match i % 5 {
            0 => rim[(3.0 * rng.uniform()) as usize],
            _ => rng.uniform(),
        };
        let mut u = [1, 5].map(|step| std::array::from_fn(|lane| number(lane / step, &mut rng)));
        u[0].rotate_left((LANES as f32 * rng.uniform()) as usize);
        let mut together = [[0.0; LANES]; 3];
        sample_hemisphere_cosine_lanes(&u, &mut together);
        for lane in 0..LANES {
            let of_lane = Vec2::from(u.map(|u: [f32; LANES]| u[lane]));
            let alone = BsdfSampleInput::new(0.0, of_lane).cosine_direction;
            assert_eq!(load::<Vec3>(&together, lane), alone, "lane {lane} of {u:?}");
        }
    }
}
