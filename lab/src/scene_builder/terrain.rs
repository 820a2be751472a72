//! Height fields: grids of triangles and fractal noise.
//!
//! Measure: world units.
//! Range: any seed.
//! Source: value noise with quintic interpolation, Perlin 2002, "Improving Noise". Tested through
//! `lab/tests/bench/scenes.rs`.

use etendue::internals::math::vec::{DVec2, DVec3};
use etendue::internals::sampler::hash::combine;

/// A grid of `columns` x `rows` squares of two triangles each: positions in row-major order, and indices. `place` maps
/// column and row in [0, 1] to the position of a vertex.
pub fn grid(
    columns: u32,
    rows: u32,
    place: impl Fn(DVec2) -> DVec3,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let share = |step: u32, of: u32| f64::from(step) / f64::from(of);
    let at = |row: u32, column: u32| place(DVec2::new(share(column, columns), share(row, rows)));
    let positions = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column)));
    let squares = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let indices = squares.flat_map(|(row, column)| {
        let a = row * (columns + 1) + column;
        let (b, c, d) = (a + 1, a + columns + 1, a + columns + 2);
        [[a, c, b], [b, c, d]]
    });
    (
        positions.map(|(row, column)| at(row, column)).collect(),
        indices.collect(),
    )
}

/// Value noise in [-1, 1] with features of size 1.
pub fn noise(seed: u64, p: DVec2) -> f64 {
    let cell = p.floor();
    let within = p - cell;
    let step = within * within * within * (within * (6.0 * within - 15.0) + 10.0);
    let corner = |x: f64, y: f64| {
        let lattice = cell + DVec2::new(x, y);
        let hash = combine(
            combine(seed, lattice.x as i64 as u64),
            lattice.y as i64 as u64,
        );
        2.0 * (hash >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
    };
    let lerp = |a: f64, b: f64, share: f64| a + share * (b - a);
    lerp(
        lerp(corner(0.0, 0.0), corner(1.0, 0.0), step.x),
        lerp(corner(0.0, 1.0), corner(1.0, 1.0), step.x),
        step.y,
    )
}

/// A sum of noise over octaves, each with half the feature size and `gain` times the amplitude of the one before.
pub fn fractal(seed: u64, p: DVec2, octaves: u32, gain: f64) -> f64 {
    let octave = |k: u32| {
        let turned = DVec2::from_angle(f64::from(k)).rotate(p);
        let k = k as i32;
        gain.powi(k) * noise(seed + k as u64, 2.0_f64.powi(k) * turned)
    };
    (0..octaves).map(octave).sum()
}
