//! How much a rough mirror reflects after a single scattering, as tables: what energy compensation needs to know.
//!
//! For GGX with Fresnel's F = 1, E(mu, alpha) is the directional albedo, and B(mu, alpha) the same integral with Schlick's
//! (1 - wo.m)^5 inside, so that under Schlick's law the albedo is F0 (E - B) + B exactly. Kept are the loss 1 - E, which
//! small alphas keep exact, and B - (1 - mu)^5, which is smooth.
//!
//! Measure: shares, without unit; means are cosine-weighted over the hemisphere.
//! Range: mu in [0, 1], alpha in [`SMOOTH_ALPHA`, 1]; a smooth surface has [`AlbedoRow::smooth`]. Interpolated E is within
//! 1e-3 of the truth, B within 2.5e-3. Built on first use, in some 40 ms.
//! Source: Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks", for the idea of the tables. Tested
//! in `tests/bsdf.rs`.

use super::fresnel::schlick_weight;
use super::microfacet::{Ggx, SMOOTH_ALPHA};
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

/// What happens to light on its first meeting with the facets.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SingleScatter {
    /// 1 - E: the share that the facets shadow.
    pub loss: f32,
    /// B: the share reflected if each facet reflects (1 - cos)^5.
    pub schlick: f32,
}

impl SingleScatter {
    /// The share that is reflected under Schlick's law from `f0` at normal incidence to `f90` at grazing.
    #[inline]
    pub fn reflected(self, f0: f32, f90: f32) -> f32 {
        f0 * (1.0 - self.loss - self.schlick) + f90 * self.schlick
    }
}

/// The tables of one roughness: a function of mu, and its mean.
#[derive(Debug, Clone, Copy)]
pub struct AlbedoRow {
    /// Neighbouring rows of the table and the way from the first to the second; none for a smooth surface.
    rows: Option<(&'static [Row; 2], f32)>,
    alpha: f32,
    mean: SingleScatter,
}

type Row = [SingleScatter; NODES_MU];

impl AlbedoRow {
    /// A smooth surface: nothing is lost and Schlick's law is met at mu alone.
    #[inline]
    pub fn smooth() -> Self {
        Self {
            rows: None,
            alpha: 0.0,
            mean: SingleScatter {
                loss: 0.0,
                schlick: 1.0 / 21.0,
            },
        }
    }

    /// The row of a distribution; the first call builds the tables.
    #[inline]
    pub fn new(ggx: &Ggx) -> Self {
        static TABLES: LazyLock<Tables> = LazyLock::new(Tables::build);
        TABLES.row(ggx.alpha())
    }

    /// The row of a distribution, or of a smooth surface where there is none.
    #[inline]
    pub fn of(ggx: Option<Ggx>) -> Self {
        ggx.map_or_else(Self::smooth, |ggx| Self::new(&ggx))
    }

    /// Towards a direction of cosine `mu`.
    #[inline]
    pub fn at(&self, mu: f32) -> SingleScatter {
        let schlick = schlick_weight(mu);
        let Some((rows, t)) = self.rows else {
            return SingleScatter { loss: 0.0, schlick };
        };
        let (i, s) = split(coordinate_of_mu(mu, self.alpha), NODES_MU);
        let entry = lerp(
            lerp(rows[0][i], rows[0][i + 1], s),
            lerp(rows[1][i], rows[1][i + 1], s),
            t,
        );
        SingleScatter {
            loss: entry.loss,
            schlick: entry.schlick + schlick,
        }
    }

    /// The cosine-weighted mean of [`AlbedoRow::at`].
    #[inline]
    pub fn mean(&self) -> SingleScatter {
        self.mean
    }

    /// The reciprocal lobe that spreads what single scattering loses: its albedo towards `o` is the loss towards `o`.
    /// Kulla and Conty 2017, with the losses of both directions as [`AlbedoRow::at`] gives them.
    #[inline]
    pub fn multiple_scattering(&self, o: SingleScatter, i: SingleScatter) -> f32 {
        if o.loss * i.loss <= 0.0 {
            return 0.0;
        }
        FRAC_1_PI * o.loss * i.loss / self.mean.loss
    }
}

/// The single scattering of `ggx` towards a direction of cosine `mu`, by `points` quadrature points.
///
/// Over visible normals the integrand is 1 - G2/G1 or its rest; points are a Fibonacci lattice, whose size `points` and
/// predecessor `step` are. The lattice is denser (cubically) towards tangential normals, where reflections go below the
/// horizon; the plane of incidence is a symmetry.
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

struct Tables {
    rows: Box<[Row; NODES_ROUGHNESS]>,
    /// Means, their loss divided by alpha^2, which varies slowly.
    means: Box<[SingleScatter; NODES_MEAN]>,
}

impl Tables {
    fn build() -> Self {
        let mut tables = Self {
            rows: Box::new([[SingleScatter::default(); NODES_MU]; NODES_ROUGHNESS]),
            means: Box::new([SingleScatter::default(); NODES_MEAN]),
        };
        for (i, row) in tables.rows.iter_mut().enumerate() {
            let alpha = alpha_of_node(i, NODES_ROUGHNESS);
            let ggx = Ggx::new(alpha);
            for (j, entry) in row.iter_mut().enumerate() {
                let mu = mu_of_coordinate(j as f32 / (NODES_MU - 1) as f32, alpha);
                *entry = single_scatter(&ggx, mu, 377, 233);
                entry.schlick -= schlick_weight(mu);
            }
        }
        for i in 0..NODES_MEAN {
            let alpha = alpha_of_node(i, NODES_MEAN);
            let mut mean = mean_of(&tables.interpolated(alpha));
            mean.loss /= alpha * alpha;
            tables.means[i] = mean;
        }
        tables
    }

    /// The row of `alpha`, its mean included.
    #[inline]
    fn row(&'static self, alpha: f32) -> AlbedoRow {
        let (i, t) = split(coordinate_of_alpha(alpha), NODES_MEAN);
        let mut mean = lerp(self.means[i], self.means[i + 1], t);
        mean.loss *= alpha * alpha;
        let (i, t) = split(coordinate_of_alpha(alpha), NODES_ROUGHNESS);
        let rows = self.rows[i..].first_chunk().map(|rows| (rows, t));
        AlbedoRow { rows, alpha, mean }
    }

    /// The interpolated row, as a function of the coordinate of mu.
    fn interpolated(&self, alpha: f32) -> (f32, Row) {
        let (i, t) = split(coordinate_of_alpha(alpha), NODES_ROUGHNESS);
        let row = std::array::from_fn(|j| lerp(self.rows[i][j], self.rows[i + 1][j], t));
        (alpha, row)
    }
}

/// 2 integral of `row` mu dmu, over the same interpolation that lookups use, so that compensation conserves energy to
/// rounding and not to the table's error.
fn mean_of((alpha, row): &(f32, Row)) -> SingleScatter {
    const STEPS: usize = 8;
    let (mut loss, mut schlick) = (0.0_f64, 0.0_f64);
    let mut mu2_low = 0.0_f64;
    for k in 0..(NODES_MU - 1) * STEPS {
        let cells = ((NODES_MU - 1) * STEPS) as f32;
        let mu_high = f64::from(mu_of_coordinate((k + 1) as f32 / cells, *alpha));
        let weight = mu_high * mu_high - mu2_low;
        mu2_low = mu_high * mu_high;
        let (j, s) = split((k as f32 + 0.5) / cells, NODES_MU);
        let entry = lerp(row[j], row[j + 1], s);
        loss += weight * f64::from(entry.loss);
        schlick += weight * f64::from(entry.schlick);
    }
    SingleScatter {
        loss: loss as f32,
        schlick: schlick as f32 + 1.0 / 21.0,
    }
}

/// The table's coordinate of mu, in [0, 1]: what happens at grazing angles happens on the scale of mu = alpha.
#[inline]
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

/// The cell that `x` in [0, 1] lies in, and how far.
#[inline]
fn split(x: f32, nodes: usize) -> (usize, f32) {
    let scaled = x * (nodes - 1) as f32;
    let cell = (scaled as usize).min(nodes - 2);
    (cell, scaled - cell as f32)
}

#[inline]
fn lerp(a: SingleScatter, b: SingleScatter, t: f32) -> SingleScatter {
    SingleScatter {
        loss: a.loss + t * (b.loss - a.loss),
        schlick: a.schlick + t * (b.schlick - a.schlick),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_agree_with_the_integral() {
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

    #[test]
    fn tables_are_built_fast() {
        let start = std::time::Instant::now();
        std::hint::black_box(Tables::build());
        println!("tables built in {:?}", start.elapsed());
    }
}
