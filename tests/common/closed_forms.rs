//! Exact answers that tests compare with.
//!
//! Measure: as said at each.
//! Range: as said at each.
//! Source: named at each.

/// The directional albedo of a GGX-Smith mirror (F = 1, height-correlated, single scattering) of `alpha` 1, .5, .3 and
/// .1 seen along the normal. At alpha 1 it is 1 - ln 2, since D is 1 / pi and G1 2 mu / (1 + mu); the others are
/// quadratures.
pub const GGX_NORMAL_ALBEDO: [(f32, f64); 4] = [
    (1.0, 1.0 - std::f64::consts::LN_2),
    (0.5, 0.687_848_5),
    (0.3, 0.877_358_4),
    (0.1, 0.988_304_1),
];

/// The cosine-weighted mean of Fresnel's reflectance at a dielectric of index 1.5, from outside.
pub const FRESNEL_MEAN_OUTSIDE: f64 = 0.091_777_959_34;

/// The same from inside; 1 - F_inside = (1 - F_outside) / n^2.
pub const FRESNEL_MEAN_INSIDE: f64 = 0.596_345_759_71;

/// The normal reflectance of a dielectric: ((n - 1) / (n + 1))^2.
pub fn normal_reflectance(n: f64) -> f64 {
    ((n - 1.0) / (n + 1.0)).powi(2)
}
