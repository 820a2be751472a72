//! The Fresnel equations: the fraction of unpolarised light that a smooth surface reflects.
//!
//! Measure: a fraction, without unit; angles are given by their cosine to the (micro)normal.
//! Range: cosines in [0, 1]; refractive indices above 0, of magnitude below 1e9; equal ones reflect nothing; total internal
//! reflection is 1 exactly. The result is in [0, 1].
//! Source: Born and Wolf, "Principles of Optics", sections 1.5.2 and 14.2; Schlick 1994. Tested below and in
//! `lab/src/battery/`.

use crate::math::rgb::Rgb;
use crate::math::vec::Vector;

/// Reflection and refraction at the interface of two dielectrics: the reflectance, and the cosine of the refracted
/// direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// The reflectance R; the rest, 1 - R, is refracted.
    pub reflectance: f32,
    /// The cosine of the refracted direction, in [0, 1]; 0 under total internal reflection.
    pub cos_t: f32,
}

/// The Fresnel reflectance between two dielectrics, for light incident from the medium of index `n_i` on that of `n_t`.
///
/// Born and Wolf eq. 1.5.21. With g = n_t cos_t the numerators are written as (a^2 - b^2) / (a + b), where the square
/// roots drop out and n_t^2 - n_i^2 remains, so that nearly equal indices do not cancel.
#[inline]
pub fn dielectric(cos_i: f32, n_i: f32, n_t: f32) -> Interface {
    let contrast = (n_t - n_i) * (n_t + n_i);
    if contrast == 0.0 {
        // Equal indices reflect nothing, also where the square of a grazing cosine underflows.
        return Interface {
            reflectance: 0.0,
            cos_t: cos_i,
        };
    }
    let a = n_i * cos_i;
    let g2 = a * a + contrast;
    if g2 <= 0.0 {
        return Interface {
            reflectance: 1.0,
            cos_t: 0.0,
        };
    }
    let g = g2.sqrt();
    let (n_i2, n_t2) = (n_i * n_i, n_t * n_t);
    let s = a + g;
    let p = n_t2 * cos_i + n_i * g;
    let r_s = contrast / (s * s);
    let r_p = contrast * ((n_t2 + n_i2) * cos_i * cos_i - n_i2) / (p * p);
    Interface {
        reflectance: (0.5 * (r_s * r_s + r_p * r_p)).min(1.0),
        cos_t: (g / n_t).min(1.0),
    }
}

/// The reflectance at normal incidence between two dielectrics: ((n - 1) / (n + 1))^2.
#[inline]
pub fn normal_reflectance(n: f32) -> f32 {
    let r = (n - 1.0) / (n + 1.0);
    r * r
}

/// The Fresnel reflectance of a metal of index `eta` + i `k`, relative to the medium outside.
///
/// Born and Wolf section 14.2, in the form with a^2 + b^2 = |eta_t^2 - sin^2|.
#[inline(always)]
pub fn conductor(cos_i: f32, eta: f32, k: f32) -> f32 {
    let cos2 = cos_i * cos_i;
    let sin2 = 1.0 - cos2;
    let t = eta * eta - k * k - sin2;
    let modulus = (t * t + 4.0 * eta * eta * k * k).sqrt();
    let two_a_cos = (2.0 * (modulus + t)).max(0.0).sqrt() * cos_i;
    let r_s = (modulus + cos2 - two_a_cos) / (modulus + cos2 + two_a_cos);
    let u = cos2 * modulus + sin2 * sin2;
    let v = two_a_cos * sin2;
    let r_p = r_s * (u - v) / (u + v);
    // Grazing incidence at an index of exactly one gives 0/0 above; at every other index the grazing limit is 1.
    if r_p.is_finite() {
        (0.5 * (r_s + r_p)).clamp(0.0, 1.0)
    } else {
        1.0
    }
}

/// The reflectance [`conductor`] in each channel.
#[inline(always)]
pub fn conductor_rgb<V: Vector>(cos_i: f32, eta: Rgb<V>, k: Rgb<V>) -> Rgb<V> {
    let ([er, eg, eb], [kr, kg, kb]): ([f32; 3], [f32; 3]) = (eta.into(), k.into());
    Rgb::from([
        conductor(cos_i, er, kr),
        conductor(cos_i, eg, kg),
        conductor(cos_i, eb, kb),
    ])
}

/// The cosine-weighted mean over the hemisphere of [`conductor`], per channel: 2 integral of F(mu) mu dmu.
///
/// Integrated by the midpoint rule in mu^2, where the weight is constant; accurate to 1e-5.
pub fn conductor_mean(eta: Rgb, k: Rgb) -> Rgb {
    const STEPS: u16 = 512;
    let mut sum = Rgb::BLACK;
    for i in 0..STEPS {
        let mu2 = (f32::from(i) + 0.5) / f32::from(STEPS);
        sum += conductor_rgb(mu2.sqrt(), eta, k);
    }
    sum / f32::from(STEPS)
}

/// (1 - cos)^5, the weight with which Schlick's approximation interpolates from F0 to 1.
#[inline(always)]
pub fn schlick_weight(cos_i: f32) -> f32 {
    let c = 1.0 - cos_i;
    let c2 = c * c;
    c2 * c2 * c
}

/// The cosine-weighted mean over the hemisphere of Schlick's approximation: F0 + (1 - F0) / 21.
#[inline]
pub fn schlick_mean(f0: Rgb) -> Rgb {
    (Rgb::WHITE + 20.0 * f0) / 21.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectance_is_accurate_for_nearly_matched_indices() {
        for (n, expected) in [(1.0001, 2.499_75e-9), (1.000_001, 2.499_997_5e-13)] {
            // The index itself is rounded: compare with the reflectance of the f32 that is passed.
            let rounded = f64::from(n as f32);
            let exact = ((rounded - 1.0) / (rounded + 1.0)).powi(2);
            assert!((exact / expected - 1.0_f64).abs() < 0.1);
            for r in [
                dielectric(1.0, 1.0, n as f32).reflectance,
                dielectric(1.0, n as f32, 1.0).reflectance,
                normal_reflectance(n as f32),
            ] {
                assert!((f64::from(r) / exact - 1.0).abs() < 1e-5, "{n} {r} {exact}");
            }
        }
        for i in 0..=100 {
            let interface = dielectric(i as f32 / 100.0, 1.0, 1.0);
            assert_eq!(interface.reflectance, 0.0);
        }
    }

    #[test]
    fn reflectance_is_monotonic_across_the_critical_angle() {
        let n = 1.5_f32;
        let critical = (1.0 - 1.0 / f64::from(n * n)).sqrt() as f32;
        let mut last = 1.0;
        let mut cos = critical - 8.0 * f32::EPSILON;
        for _ in 0..64 {
            let r = dielectric(cos, n, 1.0).reflectance;
            assert!((0.0..=1.0).contains(&r) && r <= last, "{cos} {r} {last}");
            last = r;
            cos = cos.next_up();
        }
        assert!(last < 1.0);
        assert_eq!(dielectric(critical - 1e-6, n, 1.0).reflectance, 1.0);
        assert_eq!(dielectric(0.0, n, 1.0).reflectance, 1.0);
    }

    #[test]
    fn dielectric_reflectance_is_equal_from_both_sides() {
        for i in 1..=1000 {
            let cos = i as f32 / 1000.0;
            let there = dielectric(cos, 1.0, 1.5);
            let back = dielectric(there.cos_t, 1.5, 1.0);
            // Rounding the refracted cosine moves a grazing one by eps / cos.
            let tolerance = 2e-6 / cos;
            assert!((there.reflectance - back.reflectance).abs() < tolerance);
            assert!((back.cos_t - cos).abs() < tolerance);
        }
    }

    #[test]
    fn conductor_with_zero_k_matches_a_dielectric() {
        for i in 1..=1000 {
            let cos = i as f32 / 1000.0;
            let metal = conductor(cos, 1.5, 0.0);
            assert!((metal - dielectric(cos, 1.0, 1.5).reflectance).abs() < 2e-6);
        }
        assert_eq!(conductor(0.0, 0.2, 3.9), 1.0);
    }

    #[test]
    fn gold_reflectance_matches_closed_form_at_normal_incidence() {
        // ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2)
        let r = conductor(1.0, 0.18, 3.42);
        assert!((r - 0.945_2).abs() < 1e-3, "{r}");
        let mean = conductor_mean(Rgb::grey(0.18), Rgb::grey(3.42)).luminance();
        assert!((0.94..1.0).contains(&mean), "{mean}");
    }

    #[test]
    fn schlick_mean_matches_numerical_integration() {
        let n = 10_000;
        let mean: f64 = (0..n)
            .map(|i| {
                let mu = ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
                0.04 + 0.96 * f64::from(schlick_weight(mu as f32))
            })
            .sum::<f64>()
            / f64::from(n);
        let closed = schlick_mean(Rgb::grey(0.04)).to_array()[0];
        assert!((mean - f64::from(closed)).abs() < 1e-6);
    }
}
