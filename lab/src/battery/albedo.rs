//! The albedo of a scattering model under uniform illumination.
//!
//! Measure: a fraction; refraction is counted in basic radiance, L / n^2, which is the same in both media of a furnace.
//! Range: any direction of view that is not in the surface's plane.
//! Source: the mean of f cos / pdf over a model's own samples. Tested in `lab/tests/reports/battery.rs` and
//! `tests/scattering/furnace.rs`.

use crate::bench::random::Random;
use etendue::internals::bsdf::Bsdf;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::math::vec::{ONE_MINUS_EPSILON, Vec2, Vec3};

/// A direction of view with the given cosine to the normal.
pub fn view(cos: f32) -> Vec3 {
    Vec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos)
}

/// The green albedo towards `wo` of a surface with refractive index `ior`, as the means of `replicates` jittered grids
/// of `grid` x `grid` samples.
pub fn albedo(
    bsdf: &Bsdf,
    ior: f32,
    wo: Vec3,
    (replicates, grid): (u64, u32),
    seed: u64,
) -> Vec<f64> {
    let index = |w: Vec3| if w.z > 0.0 { 1.0 } else { ior };
    let replicate = |replicate: u64| {
        let mut random = Random::new(seed, replicate);
        let cells = grid * grid;
        let one = |cell: u32| {
            let jitter = Vec2::new(random.uniform(), random.uniform());
            let corner = Vec2::new((cell % grid) as f32, (cell / grid) as f32);
            let u = ((corner + jitter) / grid as f32).min(Vec2::splat(ONE_MINUS_EPSILON));
            // A golden-ratio sequence distributes the lobe samples over the grid.
            let u_lobe = f64::from(cell) * 0.618_033_988_749_895 + replicate as f64 / 17.3;
            let u_lobe = (u_lobe.fract() as f32).min(ONE_MINUS_EPSILON);
            bsdf.sample::<Everything>(wo, u_lobe, u).map_or(0.0, |s| {
                let ratio = f64::from(index(s.wi)) / f64::from(index(wo));
                f64::from(s.weight.to_array()[1]) * ratio * ratio
            })
        };
        (0..cells).map(one).sum::<f64>() / f64::from(cells)
    };
    (0..replicates).map(replicate).collect()
}
