//! Tables of the directional albedo of single scattering by GGX microfacets, for energy compensation.
//!
//! For a Fresnel reflectance F = 1, E(mu, alpha) is the directional albedo, and B(mu, alpha) the same integral with the
//! factor (1 - wo.m)^5 of Schlick's approximation, under which the albedo is exactly F0 (E - B) + B. The tables hold the
//! square root of the loss 1 - E, which falls like alpha / mu, and B - (1 - mu)^5, which is smooth.
//!
//! Measure: fractions, without unit; means are cosine-weighted over the hemisphere.
//! Range: mu in [0, 1], alpha in [`SMOOTH_ALPHA`, 1]; a smooth surface has [`AlbedoRow::smooth`]. Interpolated E is within
//! 1.3e-3 of the exact value, B within 2.5e-3.
//! Source: Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks", for the idea of the tables. Computed and
//! tested in `src/bsdf/albedo/quadrature.rs`; tested in `tests/scattering/furnace.rs`, too.

use super::fresnel::schlick_weight;
use super::microfacet::Ggx;
use crate::math::functions::{exp, ln};
use crate::math::trig::sin_cos_turns;
use crate::math::vec::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

#[cfg(test)]
mod quadrature;

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

/// The number of entries of the table.
const NODES: usize = NODES_ROUGHNESS * NODES_MU;

/// [`NODES`] up to the next power of two: an index modulo this number needs no further check.
const ENTRIES: usize = NODES.next_power_of_two();

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

    /// The row of a distribution.
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

/// Tables of the bytes that `make albedo-tables` writes: to compute them takes 50 ms, as long as to load many a scene.
static TABLES: AlbedoTables = AlbedoTables::decode(include_bytes!("albedo/tables.bin"));

/// The bytes of all tables: pairs of numbers in single precision.
const BYTES: usize = 8 * (NODES + NODES_MEAN);

/// The table of all roughnesses.
pub fn table() -> &'static AlbedoTable {
    &TABLES.entries
}

struct AlbedoTables {
    entries: AlbedoTable,
    /// The means, with the loss divided by alpha^2: that ratio varies slowly.
    means: [SingleScatter; NODES_MEAN],
}

impl AlbedoTables {
    /// Decodes the pairs of the entries, row by row, and of the means: little-endian numbers.
    const fn decode(bytes: &[u8; BYTES]) -> Self {
        let mut tables = Self {
            entries: AlbedoTable {
                root_loss: [0.0; ENTRIES],
                excess: [0.0; ENTRIES],
            },
            means: [SingleScatter {
                loss: 0.0,
                schlick: 0.0,
            }; NODES_MEAN],
        };
        let (numbers, _) = bytes.as_chunks();
        let mut i = 0;
        while i < NODES {
            tables.entries.root_loss[i] = f32::from_le_bytes(numbers[2 * i]);
            tables.entries.excess[i] = f32::from_le_bytes(numbers[2 * i + 1]);
            i += 1;
        }
        let mut i = 0;
        while i < NODES_MEAN {
            tables.means[i].loss = f32::from_le_bytes(numbers[2 * (NODES + i)]);
            tables.means[i].schlick = f32::from_le_bytes(numbers[2 * (NODES + i) + 1]);
            i += 1;
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
}

/// The table's coordinate of mu, in [0, 1]. At grazing angles the tabulated functions vary on the scale of mu = alpha.
#[inline(always)]
fn coordinate_of_mu(mu: f32, alpha: f32) -> f32 {
    (mu * (1.0 + alpha) / (mu + alpha)).sqrt()
}

/// The table's coordinate of alpha, in [0, 1]: linear in roughness.
#[inline]
fn coordinate_of_alpha(alpha: f32) -> f32 {
    (alpha.sqrt() - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS)
}

/// The cell that contains `x` in [0, 1], and the offset in it.
#[inline(always)]
fn split(x: f32, nodes: usize) -> (u32, f32) {
    let scaled = x * (nodes - 1) as f32;
    // Conversions of signed numbers are single instructions.
    let cell = (scaled as i32).min(nodes as i32 - 2);
    (cell as u32, scaled - cell as f32)
}
