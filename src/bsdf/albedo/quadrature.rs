//! Computes the tables of directional albedo by quadrature, and compares them with those of the program.
//!
//! Measure: as in `src/bsdf/albedo.rs`.
//! Range: all nodes of the tables.
//! Source: importance sampling of visible normals, Heitz 2018, "Sampling the GGX Distribution of Visible Normals".
//! `make albedo-tables` writes the tables; the tests below fail where they are not those of the present GGX model.

use super::{
    AlbedoEntry, AlbedoRow, AlbedoTable, AlbedoTables, BYTES, ENTRIES, MIN_ROUGHNESS, NODES,
    NODES_MEAN, NODES_MU, NODES_ROUGHNESS, SingleScatter, TABLES, coordinate_of_alpha,
    coordinate_of_mu, split,
};
use crate::bsdf::fresnel::schlick_weight;
use crate::bsdf::microfacet::{Ggx, SMOOTH_ALPHA};
use crate::math::functions::powf;
use crate::math::vec::{Vec2, Vec3, reflect};

/// Entries of all mu, for one roughness.
type Row = [AlbedoEntry; NODES_MU];

impl AlbedoTables {
    fn compute() -> Self {
        let mut tables = Self {
            entries: AlbedoTable {
                root_loss: [0.0; ENTRIES],
                excess: [0.0; ENTRIES],
            },
            means: [SingleScatter::default(); NODES_MEAN],
        };
        for i in 0..NODES_ROUGHNESS {
            let alpha = alpha_of_node(i, NODES_ROUGHNESS);
            let ggx = Ggx::new(alpha);
            for j in 0..NODES_MU {
                let mu = mu_of_coordinate(j as f32 / (NODES_MU - 1) as f32, alpha);
                let single = single_scatter(&ggx, mu, 377, 233);
                let index = i * NODES_MU + j;
                tables.entries.root_loss[index] = single.loss.sqrt();
                tables.entries.excess[index] = single.schlick - schlick_weight(mu);
            }
        }
        for i in 0..NODES_MEAN {
            let alpha = alpha_of_node(i, NODES_MEAN);
            let mut mean = mean_of(alpha, &tables.interpolated(alpha));
            mean.loss /= alpha * alpha;
            tables.means[i] = mean;
        }
        tables
    }

    /// The bytes that [`AlbedoTables::decode`] reads.
    fn encode(&self) -> Vec<u8> {
        let entries = (0..NODES).map(|i| [self.entries.root_loss[i], self.entries.excess[i]]);
        let means = self.means.iter().map(|mean| [mean.loss, mean.schlick]);
        let numbers = entries.chain(means).flatten();
        numbers.flat_map(f32::to_le_bytes).collect()
    }

    /// The row between two rows of the table.
    fn interpolated(&self, alpha: f32) -> Row {
        let (i, t) = split(coordinate_of_alpha(alpha), NODES_ROUGHNESS);
        let entry = |i: u32, j: usize| self.entries.entry(i * NODES_MU as u32 + j as u32);
        std::array::from_fn(|j| entry(i, j).lerp(entry(i + 1, j), t))
    }
}

/// Computes 2 integral of `row` mu dmu with the same interpolation as lookups, so that compensation conserves energy up
/// to rounding, not up to the table's error. Steps are geometric: `row` varies on the scale of alpha as well as of 1.
fn mean_of(alpha: f32, row: &Row) -> SingleScatter {
    const STEPS: u16 = 256;
    let lowest = 0.01 * alpha;
    let mu_at = |k: f32| powf(lowest, 1.0 - k / f32::from(STEPS));
    let (mut loss, mut schlick) = (0.0_f64, 0.0_f64);
    let mut mu2_low = 0.0_f64;
    for k in 0..STEPS {
        let mu2_high = f64::from(mu_at(f32::from(k) + 1.0)).powi(2);
        let weight = mu2_high - mu2_low;
        mu2_low = mu2_high;
        let entry = look_up(row, coordinate_of_mu(mu_at(f32::from(k) + 0.5), alpha));
        loss += weight * f64::from(entry.root_loss).powi(2);
        schlick += weight * f64::from(entry.excess);
    }
    SingleScatter {
        loss: loss as f32,
        schlick: schlick as f32 + 1.0 / 21.0,
    }
}

/// The interpolated entry of a row at the coordinate `x` of mu.
fn look_up(row: &Row, x: f32) -> AlbedoEntry {
    let (i, s) = split(x, NODES_MU);
    row[i as usize].lerp(row[i as usize + 1], s)
}

/// Integrates the single scattering of `ggx` towards a direction of cosine `mu`, with `points` quadrature points.
///
/// Over visible normals the integrand is 1 - G2/G1 or its complement. The points are a Fibonacci lattice: `points` is a
/// Fibonacci number and `step` its predecessor. The lattice is denser (cubically) towards tangential normals, where
/// reflections go below the horizon. The integrand is symmetric about the plane of incidence.
fn single_scatter(ggx: &Ggx, mu: f32, points: u32, step: u32) -> SingleScatter {
    let wo = Vec3::new(((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt(), 0.0, mu);
    let (mut loss, mut schlick, mut total) = (0.0_f32, 0.0_f32, 0.0_f32);
    for k in 0..points {
        let v = (k as f32 + 0.5) / points as f32;
        let azimuth = ((k * step % points) as f32 + 0.5) / points as f32;
        let weight = v * v;
        total += weight;
        let m = ggx.sample_visible(wo, Vec2::new(0.5 * azimuth, 1.0 - v * v * v));
        let wi = reflect(wo, m);
        let shadowed = if wi.z > 0.0 {
            ggx.shadowed(wo, wi)
        } else {
            1.0
        };
        loss += weight * shadowed;
        schlick += weight * (1.0 - shadowed) * schlick_weight(wo.dot(m).min(1.0));
    }
    SingleScatter {
        loss: loss / total,
        schlick: schlick / total,
    }
}

fn mu_of_coordinate(x: f32, alpha: f32) -> f32 {
    let x = x * x;
    (x * alpha / (1.0 + alpha - x)).min(1.0)
}

fn alpha_of_node(i: usize, nodes: usize) -> f32 {
    let roughness = MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * i as f32 / (nodes - 1) as f32;
    (roughness * roughness).max(SMOOTH_ALPHA)
}

#[test]
fn the_tables_of_the_program_are_those_of_the_quadrature() {
    let computed = AlbedoTables::compute().encode();
    assert_eq!(computed.len(), BYTES);
    if let Some(file) = std::env::var_os("ALBEDO_TABLES") {
        std::fs::write(file, &computed).expect("the file can be written");
    } else {
        let is_same = computed == TABLES.encode();
        assert!(
            is_same,
            "the GGX model has changed: run `make albedo-tables`"
        );
    }
}

#[test]
fn albedo_tables_match_numerical_integration() {
    let (mut worst_loss, mut worst_schlick) = (0.0_f32, 0.0_f32);
    for i in 0..40 {
        let roughness = 0.01 + 0.99 * (i as f32 + 0.37) / 40.0;
        let ggx = Ggx::new(roughness * roughness);
        let row = AlbedoRow::new(&ggx);
        for j in 0..=40 {
            let x = j as f32 / 40.0;
            for mu in [x, mu_of_coordinate(x, ggx.alpha())] {
                let exact = single_scatter(&ggx, mu, 4181, 2584);
                let looked_up = row.at(mu);
                worst_loss = worst_loss.max((looked_up.loss - exact.loss).abs());
                worst_schlick = worst_schlick.max((looked_up.schlick - exact.schlick).abs());
            }
        }
    }
    println!("table error: E {worst_loss:.1e}, B {worst_schlick:.1e}");
    assert!(worst_loss < 1.5e-3, "{worst_loss}");
    assert!(worst_schlick < 2.5e-3, "{worst_schlick}");
}
