//! Tests of the test harness: correct code passes and planted bugs are caught.

use crate::common::TestRng;
use crate::common::chi_square::ChiSquareTest;
use crate::common::quadrature::{Adaptive, Rectangle, gauss_legendre, integrate};
use crate::common::verdict::sidak;
use etendue::internals::bsdf::microfacet::Ggx;
use etendue::internals::math::vec::{Vec3, reflect};
use etendue::internals::sampling::warp::{
    PDF_SPHERE_UNIFORM, pdf_hemisphere_cosine, sample_hemisphere_cosine, sample_sphere_uniform,
};

fn cosine(rng: &mut TestRng) -> Option<Vec3> {
    Some(sample_hemisphere_cosine(rng.uniform_2d()))
}

fn p_value(
    seed: u64,
    sample: impl FnMut(&mut TestRng) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> f64 {
    let test = ChiSquareTest {
        seed,
        ..Default::default()
    };
    test.run(sample, pdf).p_value
}

#[test]
fn chi_square_p_values_are_uniform_for_correct_pdfs() {
    // Cosine sampling that fails a tenth of the time, to include the cell of "no sample".
    let mut p_values: Vec<f64> = (0..200)
        .map(|seed| {
            let test = ChiSquareTest {
                samples: 1 << 13,
                levels: 5,
                seed,
                ..Default::default()
            };
            let sample = |rng: &mut TestRng| {
                if rng.uniform() < 0.1 {
                    None
                } else {
                    cosine(rng)
                }
            };
            test.run(sample, |w| 0.9 * pdf_hemisphere_cosine(w.z))
                .p_value
        })
        .collect();
    p_values.sort_by(f64::total_cmp);
    // Kolmogorov-Smirnov at 0.1 %: 1.95 / sqrt(n).
    let distance = p_values
        .iter()
        .enumerate()
        .map(|(i, p)| (p - (i as f64 + 0.5) / 200.0).abs())
        .fold(0.0, f64::max);
    assert!(distance < 1.95 / 200.0_f64.sqrt(), "{distance}");
}

#[test]
fn chi_square_test_accepts_correct_pdfs() {
    let threshold = sidak(0.01, 3);
    assert!(p_value(1, cosine, |w| pdf_hemisphere_cosine(w.z)) > threshold);
    let uniform = |rng: &mut TestRng| Some(sample_sphere_uniform(rng.uniform_2d()));
    assert!(p_value(2, uniform, |_| PDF_SPHERE_UNIFORM) > threshold);
    let ggx = Ggx::new(0.003);
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let facets = |rng: &mut TestRng| Some(ggx.sample_visible(wo, rng.uniform_2d()));
    let pdf = |m: Vec3| {
        if m.z > 0.0 {
            ggx.pdf_visible(wo, m)
        } else {
            0.0
        }
    };
    assert!(p_value(3, facets, pdf) > threshold);
}

#[test]
fn chi_square_test_rejects_wrong_pdfs() {
    let caught = |name: &str, p: f64| assert!(p < 1e-6, "{name}: p = {p}");
    caught(
        "twice",
        p_value(1, cosine, |w| 2.0 * pdf_hemisphere_cosine(w.z)),
    );
    caught(
        "half",
        p_value(1, cosine, |w| 0.5 * pdf_hemisphere_cosine(w.z)),
    );
    caught(
        "no cosine",
        p_value(1, cosine, |w| {
            if w.z > 0.0 {
                2.0 * PDF_SPHERE_UNIFORM
            } else {
                0.0
            }
        }),
    );
    caught(
        "lower side claimed",
        p_value(1, cosine, |w| pdf_hemisphere_cosine(w.z.abs())),
    );
    let ggx = Ggx::new(0.2);
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let mixture = |rng: &mut TestRng| {
        let wi = if rng.uniform() < 0.55 {
            reflect(wo, ggx.sample_visible(wo, rng.uniform_2d()))
        } else {
            sample_hemisphere_cosine(rng.uniform_2d())
        };
        (wi.z > 0.0).then_some(wi)
    };
    let mixture_pdf = |w: Vec3, share: f32| {
        if w.z <= 0.0 {
            return 0.0;
        }
        share * ggx.pdf_reflection(wo, (wo + w).normalize())
            + (1.0 - share) * pdf_hemisphere_cosine(w.z)
    };
    assert!(p_value(5, mixture, |w| mixture_pdf(w, 0.55)) > 1e-3);
    caught(
        "5 % wrong lobe weight",
        p_value(5, mixture, |w| mixture_pdf(w, 0.50)),
    );
    let facets = |rng: &mut TestRng| Some(ggx.sample_visible(wo, rng.uniform_2d()));
    let shifted = |m: Vec3| {
        // The peak, rotated by a degree about y.
        let (sin, cos) = 1.0_f32.to_radians().sin_cos();
        let m = Vec3::new(cos * m.x + sin * m.z, m.y, cos * m.z - sin * m.x);
        if m.z > 0.0 {
            ggx.pdf_visible(wo, m)
        } else {
            0.0
        }
    };
    caught("shifted peak", p_value(5, facets, shifted));
    let stated = ChiSquareTest {
        probability_of_none: Some(0.05),
        ..Default::default()
    };
    let result = stated.run(cosine, |w| 0.95 * pdf_hemisphere_cosine(w.z));
    caught("a delta that never comes", result.p_value);
}

#[test]
fn sidak_correction_gives_the_per_test_significance() {
    assert!((sidak(1e-4, 500) / 2e-7 - 1.0).abs() < 1e-3);
}

#[test]
fn quadrature_matches_known_integrals() {
    let total: f64 = gauss_legendre(16).iter().map(|&(_, w)| w).sum();
    assert!((total - 2.0).abs() < 1e-13);
    assert!((integrate(f64::exp, 0.0, 1.0, 1) - (1.0_f64.exp() - 1.0)).abs() < 1e-14);
    let unit = Rectangle {
        x: (0.0, 1.0),
        y: (0.0, 1.0),
    };
    // A narrow peak and an edge.
    let peak = |x: f64, y: f64| 1.0 / (1e-6 + (x - 0.3).powi(2) + (y - 0.7).powi(2));
    let edge = |x: f64, y: f64| f64::from(u8::from(x + 0.7 * y < 1.0));
    let rough = Adaptive::new(1e-5, 24).integrate(&peak, unit);
    let fine = Adaptive::new(1e-9, 40).integrate(&peak, unit);
    assert!((rough / fine - 1.0).abs() < 1e-6, "{rough} {fine}");
    assert!((Adaptive::new(1e-6, 30).integrate(&edge, unit) - 0.65).abs() < 1e-4);
}
