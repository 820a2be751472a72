//! Fresnel's law where its formulas cancel: indices close to 1, the critical angle, means over the hemisphere.
//!
//! Measure: reflectances.
//! Range: indices from 1 to 1.5 from either side.
//! Source: closed forms of the means by Egan and Hilgeman 1973. Tested in `lab/tests/reports/battery.rs`.

use super::case::{Case, Effort};
use super::claim::Claim;
use super::closed_forms::{FRESNEL_MEAN_INSIDE, FRESNEL_MEAN_OUTSIDE, normal_reflectance};
use etendue::internals::bsdf::fresnel;

/// Every case.
pub fn cases(_: Effort) -> Vec<Case> {
    let normal = [1.5, 1.0001, 1.000_001].map(|n: f32| {
        let exact = normal_reflectance(f64::from(n));
        let name = format!("normal reflectance of index {n}");
        let claim = Claim::without_noise(exact, 1e-5);
        Case::new(11, name, claim, move |_| {
            let both = [(1.0, n), (n, 1.0)];
            let at_normal = |(a, b)| f64::from(fresnel::dielectric(1.0, a, b).reflectance);
            let formula = f64::from(fresnel::normal_reflectance(n));
            Ok([both.map(at_normal).to_vec(), vec![formula]].concat())
        })
    });
    let mean = |row, name: &str, exact, tolerance, n_i, n_t| {
        let claim = Claim::without_noise(exact, tolerance);
        Case::new(row, name, claim, move |_| Ok(vec![mean(n_i, n_t)]))
    };
    let outside = "mean reflectance, index 1.5 from outside";
    let inside = "mean reflectance, index 1.5 from inside";
    let means = [
        mean(
            11,
            "mean reflectance, index 1.0001 from outside",
            3.329_173e-5,
            1e-3,
            1.0,
            1.0001,
        ),
        mean(
            11,
            "mean reflectance, index 1.0001 from inside",
            2.332_551e-4,
            1e-3,
            1.0001,
            1.0,
        ),
        mean(12, outside, FRESNEL_MEAN_OUTSIDE, 1e-5, 1.0, 1.5),
        mean(12, inside, FRESNEL_MEAN_INSIDE, 1e-5, 1.5, 1.0),
    ];
    let critical = Case::new(
        13,
        "reflectances next to the critical angle that are no shares, or fall",
        Claim::exactly(0.0),
        |_| Ok(vec![wrong_at_the_critical_angle()]),
    );
    normal.into_iter().chain(means).chain([critical]).collect()
}

/// The cosine-weighted mean: 2 times the integral of R mu over mu. The integral is split at the kink at the critical
/// angle, and mu = critical + t^2 removes the square root there.
fn mean(n_i: f32, n_t: f32) -> f64 {
    let critical = (1.0 - f64::from(n_t / n_i).powi(2)).max(0.0).sqrt();
    let f = |mu: f64| 2.0 * mu * f64::from(fresnel::dielectric(mu as f32, n_i, n_t).reflectance);
    midpoints(critical, f) + midpoints((1.0 - critical).sqrt(), |t| 2.0 * t * f(critical + t * t))
}

/// The integral over [0, end] by the midpoint rule.
fn midpoints(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let panels = 1 << 16;
    let width = end / f64::from(panels);
    let at = |i: i32| f(width * (f64::from(i) + 0.5));
    (0..panels).map(at).sum::<f64>() * width
}

/// Counts the cosines within 1000 ulp of the critical one with a reflectance outside of [0, 1], or with a smaller one
/// than the next larger cosine.
fn wrong_at_the_critical_angle() -> f64 {
    let mut wrong = 0;
    for n in [1.01_f32, 1.33, 1.5, 2.4] {
        let critical = (1.0 - 1.0 / f64::from(n).powi(2)).sqrt() as f32;
        let cosines =
            (-1000..=1000).map(|step| f32::from_bits((critical.to_bits() as i32 + step) as u32));
        let mut before = 1.0;
        for cos in cosines {
            let reflectance = fresnel::dielectric(cos, n, 1.0).reflectance;
            let fine = (0.0..=1.0).contains(&reflectance) && reflectance <= before;
            wrong += i32::from(!fine);
            before = reflectance;
        }
        // Half of the cosines are beyond the critical angle, and so is this one.
        let beyond = fresnel::dielectric(0.999 * critical, n, 1.0).reflectance;
        wrong += i32::from(beyond != 1.0);
    }
    f64::from(wrong)
}
