//! Tables of the directional albedo of single scattering by GGX microfacets, for energy compensation.
//!
//! For a Fresnel reflectance F = 1, E(mu, alpha) is the directional albedo, and B(mu, alpha) the same integral with the
//! factor (1 - wo.m)^5 of Schlick's approximation, under which the albedo is exactly F0 (E - B) + B. The tables hold the
//! square root of the loss 1 - E, which falls like alpha / mu, and B - (1 - mu)^5, which is smooth.
//!
//! Measure: fractions, without unit; means are cosine-weighted over the hemisphere.
//! Range: mu in [0, 1], alpha in [`SMOOTH_ALPHA`, 1]; a smooth surface has [`AlbedoRow::smooth`]. Interpolated E is within
//! 1.3e-3 of the exact value, B within 2.5e-3. The tables are built on first use, in some 40 ms.
//! Source: Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks", for the idea of the tables. Tested
//! below and in `tests/scattering/furnace.rs`.

use super::fresnel::schlick_weight;
use super::microfacet::{Ggx, SMOOTH_ALPHA};
use crate::math::functions::{exp, ln, powf};
use crate::math::trig::sin_cos_turns;
use crate::math::vec::{Vec2, Vec3, reflect};
use std::f32::consts::FRAC_1_PI;
use std::sync::LazyLock;

/// Nodes along mu.
const NODES_MU: usize = 40;
/// Nodes along roughness.
const NODES_ROUGHNESS: usize = 56;
/// Nodes of the means along roughness.
const NODES_MEAN: usize = 256;
/// Roughness at the smooth end: the square root of `SMOOTH_ALPHA`.
const MIN_ROUGHNESS: f32 = 0.01;

/// Directional albedo terms of single scattering.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SingleScatter {
    /// 1 - E: the fraction of light that the microfacets shadow.
    pub loss: f32,
    /// B: the fraction reflected if each microfacet reflects (1 - cos)^5.
    pub schlick: f32,
}

impl SingleScatter {
    /// The albedo under Schlick's approximation, from `f0` at normal incidence to `f90` at grazing incidence.
    #[inline(always)]
    pub fn reflected(self, f0: f32, f90: f32) -> f32 {
        f0 * (1.0 - self.loss - self.schlick) + f90 * self.schlick
    }
}

/// The tabulated albedo of one roughness: a function of mu, and its mean.
#[derive(Debug, Clone, Copy)]
pub struct AlbedoRow {
    /// The table and the place in it; `None` for a smooth surface.
    table: Option<(&'static AlbedoTable, RowPlace)>,
    alpha: f32,
    mean: SingleScatter,
    /// 1 / (pi mean loss), or 0 where nothing is lost: normalises [`AlbedoRow::multiple_scattering`].
    multiple_scale: f32,
    /// ln(1 + 1 / alpha^2), which normalises [`AlbedoRow::pdf_multiple`].
    log: f32,
    /// 1 / (pi log).
    pdf_scale: f32,
}

/// A place between two rows of the table.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RowPlace {
    /// The index of the first entry of the first row.
    pub first: u32,
    /// The interpolation weight of the second row.
    pub t: f32,
    /// The roughness alpha.
    pub alpha: f32,
}

/// A table entry: the square root of the loss, and B - (1 - mu)^5.
#[derive(Debug, Clone, Copy, Default)]
struct AlbedoEntry {
    root_loss: f32,
    excess: f32,
}

type Row = [AlbedoEntry; NODES_MU];

/// The number of entries of the table, up to the next power of two: an index modulo this number needs no further check.
const ENTRIES: usize = (NODES_ROUGHNESS * NODES_MU).next_power_of_two();

/// The rows of all roughnesses, one after the other.
#[derive(Debug)]
pub struct AlbedoTable {
    root_loss: [f32; ENTRIES],
    excess: [f32; ENTRIES],
}

impl AlbedoTable {
    #[inline(always)]
    fn entry(&self, index: u32) -> AlbedoEntry {
        let index = index as usize % ENTRIES;
        AlbedoEntry {
            root_loss: self.root_loss[index],
            excess: self.excess[index],
        }
    }

    /// The single scattering towards a direction of cosine `mu`. Free of branches.
    #[inline(always)]
    pub fn at(&self, place: RowPlace, mu: f32) -> SingleScatter {
        let (node, s) = split(coordinate_of_mu(mu, place.alpha), NODES_MU);
        let node = place.first + node;
        let across = |node: u32| {
            let next = self.entry(node + NODES_MU as u32);
            self.entry(node).lerp(next, place.t)
        };
        let entry = across(node).lerp(across(node + 1), s);
        SingleScatter {
            loss: entry.root_loss * entry.root_loss,
            schlick: entry.excess + schlick_weight(mu),
        }
    }
}

impl AlbedoRow {
    /// The row of a smooth surface: there is no loss, and Schlick's approximation applies at mu alone.
    #[inline]
    pub fn smooth() -> Self {
        Self {
            table: None,
            alpha: 0.0,
            mean: SingleScatter {
                loss: 0.0,
                schlick: 1.0 / 21.0,
            },
            multiple_scale: 0.0,
            log: 1.0,
            pdf_scale: FRAC_1_PI,
        }
    }

    /// The row of a distribution; the first call builds the tables.
    #[inline]
    pub fn new(ggx: &Ggx) -> Self {
        TABLES.row(ggx.alpha())
    }

    /// The row of a distribution, or of a smooth surface for `None`.
    #[inline]
    pub fn of(ggx: Option<Ggx>) -> Self {
        ggx.map_or_else(Self::smooth, |ggx| Self::new(&ggx))
    }

    /// The single scattering towards a direction of cosine `mu`.
    #[inline]
    pub fn at(&self, mu: f32) -> SingleScatter {
        match self.table {
            Some((table, place)) => table.at(place, mu),
            None => SingleScatter {
                loss: 0.0,
                schlick: schlick_weight(mu),
            },
        }
    }

    /// The place in the table; `None` for a smooth surface.
    #[inline]
    pub fn place(&self) -> Option<RowPlace> {
        self.table.map(|(_, place)| place)
    }

    /// The factor of [`AlbedoRow::multiple_scattering`], and that of [`AlbedoRow::pdf_multiple`].
    #[inline]
    pub fn scales(&self) -> (f32, f32) {
        (self.multiple_scale, self.pdf_scale)
    }

    /// The cosine-weighted mean of [`AlbedoRow::at`].
    #[inline]
    pub fn mean(&self) -> SingleScatter {
        self.mean
    }

    /// The reciprocal lobe of multiple scattering, which restores the loss: its albedo towards `o` equals the loss towards
    /// `o`. Kulla and Conty 2017, with the losses of both directions from [`AlbedoRow::at`].
    #[inline]
    pub fn multiple_scattering(&self, o: SingleScatter, i: SingleScatter) -> f32 {
        multiple_scattering(o, i, self.multiple_scale)
    }

    /// Samples a direction for [`AlbedoRow::multiple_scattering`] with a density of the shape mu / (mu^2 + alpha^2) of the
    /// loss. Cosine-weighted sampling would undersample the grazing angles where smooth metals lose light.
    #[inline]
    pub fn sample_multiple(&self, u: Vec2) -> Vec3 {
        let mu = (self.alpha * (exp(u.x * self.log) - 1.0).sqrt()).min(1.0);
        let (sin, cos) = sin_cos_turns(u.y);
        let r = ((1.0 - mu) * (1.0 + mu)).sqrt();
        Vec3::new(r * cos, r * sin, mu)
    }

    /// The density of [`AlbedoRow::sample_multiple`] per steradian; not defined for a smooth surface.
    #[inline]
    pub fn pdf_multiple(&self, mu: f32) -> f32 {
        pdf_multiple(mu, self.alpha * self.alpha, self.pdf_scale)
    }
}

/// [`AlbedoRow::multiple_scattering`], given its factor.
#[inline(always)]
pub fn multiple_scattering(o: SingleScatter, i: SingleScatter, scale: f32) -> f32 {
    o.loss * i.loss * scale
}

/// [`AlbedoRow::pdf_multiple`], given its factor.
#[inline(always)]
pub fn pdf_multiple(mu: f32, alpha2: f32, scale: f32) -> f32 {
    scale * mu / (mu * mu + alpha2)
}

impl AlbedoEntry {
    #[inline(always)]
    fn lerp(self, other: Self, t: f32) -> Self {
        Self {
            root_loss: self.root_loss + t * (other.root_loss - self.root_loss),
            excess: self.excess + t * (other.excess - self.excess),
        }
    }
}

/// The interpolated entry of a row at the coordinate `x` of mu.
#[inline]
fn look_up(row: &Row, x: f32) -> AlbedoEntry {
    let (i, s) = split(x, NODES_MU);
    row[i as usize].lerp(row[i as usize + 1], s)
}

/// Integrates the single scattering of `ggx` towards a direction of cosine `mu`, with `points` quadrature points.
///
/// Over visible normals the integrand is 1 - G2/G1 or its complement. The points are a Fibonacci lattice: `points` is a
/// Fibonacci number and `step` its predecessor. The lattice is denser (cubically) towards tangential normals, where
/// reflections go below the horizon. The integrand is symmetric about the plane of incidence.
pub fn single_scatter(ggx: &Ggx, mu: f32, points: u32, step: u32) -> SingleScatter {
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

static TABLES: LazyLock<AlbedoTables> = LazyLock::new(AlbedoTables::build);

/// The table of all roughnesses; the first call builds it.
pub fn table() -> &'static AlbedoTable {
    &TABLES.entries
}

struct AlbedoTables {
    entries: Box<AlbedoTable>,
    /// The means, with the loss divided by alpha^2: that ratio varies slowly.
    means: Box<[SingleScatter; NODES_MEAN]>,
}

impl AlbedoTables {
    fn build() -> Self {
        let mut tables = Self {
            entries: Box::new(AlbedoTable {
                root_loss: [0.0; ENTRIES],
                excess: [0.0; ENTRIES],
            }),
            means: Box::new([SingleScatter::default(); NODES_MEAN]),
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

    /// The row of `alpha`, including its mean.
    #[inline]
    fn row(&'static self, alpha: f32) -> AlbedoRow {
        let (i, t) = split(coordinate_of_alpha(alpha), NODES_MEAN);
        let i = i as usize;
        let [low, high] = [self.means[i], self.means[i + 1]];
        let alpha2 = alpha * alpha;
        let mean = SingleScatter {
            loss: alpha2 * (low.loss + t * (high.loss - low.loss)),
            schlick: low.schlick + t * (high.schlick - low.schlick),
        };
        let (i, t) = split(coordinate_of_alpha(alpha), NODES_ROUGHNESS);
        let place = RowPlace {
            first: i * NODES_MU as u32,
            t,
            alpha,
        };
        let log = ln(1.0 + 1.0 / alpha2);
        AlbedoRow {
            table: Some((&self.entries, place)),
            alpha,
            mean,
            multiple_scale: FRAC_1_PI / mean.loss,
            log,
            pdf_scale: FRAC_1_PI / log,
        }
    }

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

/// The table's coordinate of mu, in [0, 1]. At grazing angles the tabulated functions vary on the scale of mu = alpha.
#[inline(always)]
fn coordinate_of_mu(mu: f32, alpha: f32) -> f32 {
    (mu * (1.0 + alpha) / (mu + alpha)).sqrt()
}

fn mu_of_coordinate(x: f32, alpha: f32) -> f32 {
    let x = x * x;
    (x * alpha / (1.0 + alpha - x)).min(1.0)
}

/// The table's coordinate of alpha, in [0, 1]: linear in roughness.
#[inline]
fn coordinate_of_alpha(alpha: f32) -> f32 {
    (alpha.sqrt() - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS)
}

fn alpha_of_node(i: usize, nodes: usize) -> f32 {
    let roughness = MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * i as f32 / (nodes - 1) as f32;
    (roughness * roughness).max(SMOOTH_ALPHA)
}

/// The cell that contains `x` in [0, 1], and the offset in it.
#[inline(always)]
fn split(x: f32, nodes: usize) -> (u32, f32) {
    let scaled = x * (nodes - 1) as f32;
    // Conversions of signed numbers are single instructions.
    let cell = (scaled as i32).min(nodes as i32 - 2);
    (cell as u32, scaled - cell as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
