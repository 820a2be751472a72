//! The samplers of the course against their stated densities and inverses, also at extreme numbers. The wrong one has to fail.

use crate::common::TestRng;
use crate::common::chi_square::{ChiSquareTest, uniformity};
use crate::common::quadrature::integrate;
use crate::common::verdict::{assert_mean, sidak};
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{ONE_MINUS_EPSILON, Vec2, Vec3};
use etendue::internals::sampling::cosine_power::{
    invert_cosine_power, one_minus_cos, pdf_cosine_power, sample_cosine_power,
};
use etendue::internals::sampling::triangle::{
    invert_triangle_by_root, pdf_triangle_uniform, sample_triangle_by_root,
};
use etendue::internals::sampling::warp;
use etendue_lab::course::direction::{
    PDF_HEMISPHERE_UNIFORM, invert_hemisphere_cosine_by_inversion, invert_hemisphere_uniform,
    sample_hemisphere_cosine_by_inversion, sample_hemisphere_uniform,
};
use etendue_lab::course::disk::{
    invert_disk_crowded_at_the_centre, invert_disk_polar, pdf_disk_crowded_at_the_centre,
    pdf_disk_uniform, sample_disk_crowded_at_the_centre, sample_disk_polar,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const DRAWS: u32 = 1 << 17;
/// Uniform numbers where mappings fail first: no generator of this project returns more than the last.
const EXTREMES: [f32; 4] = [0.0, 1.0 / 16_777_216.0, 0.5, ONE_MINUS_EPSILON];
/// Exponents of the Phong lobe, from the uniform hemisphere to the narrowest.
const EXPONENTS: [f32; 6] = [0.0, 0.5, 1.0, 20.0, 1e3, 1e6];

fn extreme_pairs() -> impl Iterator<Item = Vec2> {
    EXTREMES
        .into_iter()
        .flat_map(|x| EXTREMES.map(|y| Vec2::new(x, y)))
}

/// Uniform pairs away from the poles and centres, where the inverse is ill-conditioned.
fn inner_pairs(seed: u64) -> impl Iterator<Item = Vec2> {
    let mut rng = TestRng::new(seed);
    (0..1 << 14).map(move |_| Vec2::splat(0.01) + 0.98 * rng.uniform_2d())
}

/// The p-value of uniform counts of points in [0, 1]^2, in 24 x 24 cells.
fn square_uniformity(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let cell = |x: f64| ((24.0 * x) as usize).min(23);
    let mut counts = vec![0; 24 * 24];
    points.for_each(|[x, y]| counts[24 * cell(x) + cell(y)] += 1);
    uniformity(&counts)
}

/// The radius, and the azimuth in units of a full turn.
fn polar(p: Vec2) -> (f64, f64) {
    let p = p.as_dvec2();
    (p.length(), p.y.atan2(p.x) / TAU + 0.5)
}

/// Asserts that two pairs are equal; the second number, an azimuth, is compared modulo one turn.
fn assert_close(what: &str, u: Vec2, back: Vec2, tolerance: f32) {
    let d = (back - u).abs();
    let d = d.x.max(d.y.min(1.0 - d.y));
    assert!(d < tolerance, "{what} {u} {back}");
}

#[test]
fn disk_sampling_is_uniform_and_crowded_variant_is_detected() {
    let p_of = |seed: u64, sample: fn(Vec2) -> Vec2, radius: fn(f64) -> f64| {
        let mut rng = TestRng::new(seed);
        square_uniformity((0..DRAWS).map(|_| {
            let (r, turn) = polar(sample(rng.uniform_2d()));
            [radius(r), turn]
        }))
    };
    // Rings of equal area hold equally many uniform points; rings of equal width hold equally many of the wrong points.
    let right = p_of(1, sample_disk_polar, |r| r * r);
    let wrong = p_of(1, sample_disk_crowded_at_the_centre, |r| r * r);
    let wrong_as_it_is = p_of(2, sample_disk_crowded_at_the_centre, |r| r);
    assert!(right > sidak(1e-3, 2), "{right:.1e}");
    assert!(wrong_as_it_is > sidak(1e-3, 2), "{wrong_as_it_is:.1e}");
    assert!(wrong < 1e-100, "the wrong disk passes: {wrong:.1e}");
    // The share of points within r is r for the wrong sampler and r^2 for the right one.
    let (p, r) = (Vec2::new(-0.12, 0.16), 0.2);
    assert!((f64::from(pdf_disk_uniform(p)) * PI - 1.0).abs() < 1e-6);
    assert!((f64::from(pdf_disk_crowded_at_the_centre(p)) * TAU * r - 1.0).abs() < 1e-6);
    // Both densities integrate to one: over rings, 2 pi r dr.
    for pdf in [pdf_disk_uniform, pdf_disk_crowded_at_the_centre] {
        let ring = |r: f64| TAU * r * f64::from(pdf(Vec2::new(0.6, 0.8) * r as f32));
        let integral = integrate(ring, 0.0, 1.0, 4);
        assert!((integral - 1.0).abs() < 1e-6, "{integral}");
        assert_eq!(pdf(Vec2::ONE), 0.0);
    }
}

#[test]
fn direction_samples_match_their_pdf() {
    let test = ChiSquareTest::default();
    let checks = 2 + EXPONENTS.len();
    let on_hemisphere = |w: Vec3| {
        if w.z > 0.0 {
            PDF_HEMISPHERE_UNIFORM
        } else {
            0.0
        }
    };
    let mut results = vec![
        (
            "uniform".to_owned(),
            test.run(
                |rng| Some(sample_hemisphere_uniform(rng.uniform_2d())),
                on_hemisphere,
            ),
        ),
        (
            "cosine".to_owned(),
            test.run(
                |rng| Some(sample_hemisphere_cosine_by_inversion(rng.uniform_2d())),
                |w| warp::pdf_hemisphere_cosine(w.z),
            ),
        ),
    ];
    for n in EXPONENTS {
        let result = test.run(
            |rng| Some(sample_cosine_power(rng.uniform_2d(), n)),
            |w| pdf_cosine_power(one_minus_cos(w, Vec3::Z), n),
        );
        results.push((format!("n = {n}"), result));
    }
    for (what, result) in results {
        assert!(result.p_value > sidak(1e-3, checks), "{what}: {result:?}");
        assert!((result.integral - 1.0).abs() < 1e-3, "{what}: {result:?}");
    }
}

#[test]
fn cosine_power_0_and_1_match_uniform_and_cosine_hemisphere() {
    for u in inner_pairs(7) {
        let distance = (sample_cosine_power(u, 0.0) - sample_hemisphere_uniform(u)).length();
        assert!(distance < 1e-6, "{u}");
        let cosine = sample_hemisphere_cosine_by_inversion(u);
        assert!(
            (sample_cosine_power(u, 1.0) - cosine).length() < 1e-6,
            "{u}"
        );
        let [lobe, pdf] = [
            pdf_cosine_power(1.0 - cosine.z, 1.0),
            warp::pdf_hemisphere_cosine(cosine.z),
        ];
        assert!((lobe / pdf - 1.0).abs() < 1e-5, "{u}: {lobe} {pdf}");
    }
}

#[test]
fn triangle_sampling_by_square_root_is_uniform() {
    const N: usize = 16;
    // Lines of constant coordinates divide the triangle into N^2 equal ones: upright ones and, beside them, reversed ones.
    let mut counts = vec![0; 2 * N * N];
    let mut rng = TestRng::new(11);
    for _ in 0..DRAWS {
        let b = sample_triangle_by_root(rng.uniform_2d());
        assert_eq!(pdf_triangle_uniform(b), 2.0);
        let [x, y] = [b.x, b.y].map(|b| f64::from(b) * N as f64);
        let is_reversed = x.fract() + y.fract() > 1.0;
        counts[2 * (N * x as usize + y as usize) + usize::from(is_reversed)] += 1;
    }
    let inside: Vec<u32> = (0..2 * N * N)
        .filter(|i| i / 2 / N + i / 2 % N + i % 2 < N)
        .map(|i| counts[i])
        .collect();
    assert_eq!((inside.len(), inside.iter().sum::<u32>()), (N * N, DRAWS));
    let p = uniformity(&inside);
    assert!(p > 1e-3, "{p:.1e}");
    assert_eq!(pdf_triangle_uniform(Vec2::new(0.6, 0.6)), 0.0);
}

#[test]
fn warp_inverses_round_trip() {
    for u in inner_pairs(3) {
        let back = invert_disk_polar(sample_disk_polar(u));
        assert_close("disk", u, back, 1e-6);
        let wrong = sample_disk_crowded_at_the_centre(u);
        let back = invert_disk_crowded_at_the_centre(wrong);
        assert_close("crowded disk", u, back, 1e-6);
        let back = invert_hemisphere_uniform(sample_hemisphere_uniform(u));
        assert_close("hemisphere", u, back, 1e-6);
        let cosine = sample_hemisphere_cosine_by_inversion(u);
        assert_close(
            "cosine",
            u,
            invert_hemisphere_cosine_by_inversion(cosine),
            1e-6,
        );
        let back = invert_triangle_by_root(sample_triangle_by_root(u));
        assert_close("triangle", u, back, 1e-5);
        for n in EXPONENTS {
            let back = invert_cosine_power(sample_cosine_power(u, n), n);
            assert_close("lobe", u, back, 3e-6);
        }
    }
}

#[test]
fn extreme_inputs_stay_in_the_sampling_domain() {
    let unit = |w: Vec3| (w.length() - 1.0).abs() < 1e-6;
    let up = |w: Vec3| unit(w) && w.z > 0.0;
    let in_square = |u: Vec2| u.min_element() >= 0.0 && u.max_element() <= 1.0;
    for u in extreme_pairs() {
        for d in [sample_disk_polar(u), sample_disk_crowded_at_the_centre(u)] {
            assert!(d.length() <= 1.0 + 1e-7, "{u} {d}");
        }
        let w = sample_hemisphere_uniform(u);
        assert!(up(w) && in_square(invert_hemisphere_uniform(w)), "{u} {w}");
        let w = sample_hemisphere_cosine_by_inversion(u);
        assert!(up(w) && warp::pdf_hemisphere_cosine(w.z) > 0.0, "{u} {w}");
        for n in EXPONENTS {
            let w = sample_cosine_power(u, n);
            let pdf = pdf_cosine_power(one_minus_cos(w, Vec3::Z), n);
            assert!(up(w) && pdf > 0.0 && pdf.is_finite(), "{u} {n} {w} {pdf}");
        }
        let b = sample_triangle_by_root(u);
        assert!(pdf_triangle_uniform(b) == 2.0, "{u} {b}");
        assert!(in_square(invert_triangle_by_root(b)), "{u} {b}");
    }
    assert!(in_square(invert_triangle_by_root(Vec2::X)));
}

/// Estimates of the irradiance under a sky of radiance cos^n about the zenith, from directions with their densities.
fn irradiance(n: i32, sample: impl Fn(Vec2) -> (Vec3, f32)) -> Moments {
    let mut rng = TestRng::new(70);
    Moments::of((0..3_000_000).map(|_| {
        let (w, pdf) = sample(rng.uniform_2d());
        f64::from(w.z).powi(n + 1) / f64::from(pdf)
    }))
}

#[test]
fn irradiance_estimates_match_exact_value_for_every_pdf() {
    let uniform = |u| (sample_hemisphere_uniform(u), PDF_HEMISPHERE_UNIFORM);
    let cosine = |u| {
        let w = sample_hemisphere_cosine_by_inversion(u);
        (w, warp::pdf_hemisphere_cosine(w.z))
    };
    let lobe = |u| {
        let w = sample_cosine_power(u, 3.0);
        (w, pdf_cosine_power(one_minus_cos(w, Vec3::Z), 3.0))
    };
    for n in [0, 2, 20] {
        let exact = TAU / f64::from(n + 2);
        assert_mean("uniform", &irradiance(n, uniform), exact, 2e-3);
        assert_mean("cosine", &irradiance(n, cosine), exact, 2e-3);
        // Under a uniform sky, cos / cos^3 has infinite variance.
        if n > 0 {
            assert_mean("lobe", &irradiance(n, lobe), exact, 2e-3);
        }
    }
}

#[test]
fn cosine_power_cdf_matches_closed_form() {
    // The share within the angle a is 1 - cos^(n + 1) a.
    for n in EXPONENTS.map(f64::from) {
        for share in [0.1, 0.5, 0.9] {
            let cos = (1.0_f64 - share).powf(1.0 / (n + 1.0));
            let density = |h: f64| TAU * f64::from(pdf_cosine_power(h as f32, n as f32));
            let integral = integrate(density, 0.0, 1.0 - cos, 4);
            assert!((integral - share).abs() < 1e-5, "{n} {share}: {integral}");
        }
    }
    assert_eq!(pdf_cosine_power((1.0 - FRAC_PI_2.cos()) as f32, 5.0), 0.0);
}
