//! The MIS weights of the strategies that find the same path.
//!
//! A path x_0 x_1 ... x_n goes from the light, x_0, to the camera, x_n. The strategy with s vertices of a light subpath
//! finds it with the density
//!
//!   p_s = prod_{i < s} L_i prod_{s <= i < n} E_i,
//!
//! where L_i is the density of finding x_i on a light subpath and E_i on a camera subpath, given the vertices before.
//! With s = 1, x_0 is found by light sampling, and L_0 is the density of that. A strategy has the weight
//! p_s^2 / sum_k p_k^2, summed over those that can find the path: nothing is connected to a vertex that scatters by a
//! delta lobe. As p_{k+1} / p_k = L_k / E_k, only ratios are needed.
//!
//! Measure: any, the same for both densities of a vertex.
//! Range: any densities of at least 0; that of the strategy itself is above 0.
//! Source: Veach and Guibas 1995, the power heuristic with exponent 2; Veach 1997, section 10.2.1. Tested below.

use super::vertex::{Densities, LightVertex};
use crate::planted::planted;

/// The densities of all vertices of a path, from the light to the camera.
#[derive(Debug, Clone, Default)]
pub struct WholePath {
    /// The densities L_i and E_i; the camera has none.
    pub densities: Vec<Densities>,
    /// Whether the path continues by a delta lobe, for each vertex.
    pub is_delta: Vec<bool>,
    /// The density of finding x_0 by light sampling at x_1.
    pub nee_pdf: f64,
}

/// The densities around a connection, each of a vertex found from the other end.
#[derive(Debug, Clone, Copy)]
pub struct ConnectionPdfs {
    /// The densities of x_{s-1} and x_{s-2} on a camera subpath.
    pub by_camera: [f64; 2],
    /// The densities of x_s and x_{s+1} on a light subpath.
    pub by_light: [f64; 2],
}

impl ConnectionPdfs {
    /// The densities for s = 0: x_0 is the source, and the next vertex has the density `next` on a light subpath.
    pub fn of_emission(source: &LightVertex, next: f64) -> Self {
        Self {
            by_camera: [0.0; 2],
            by_light: [source.densities.by_light, next],
        }
    }
}

impl WholePath {
    /// Makes room for a path of `vertices` vertices, without densities.
    pub fn clear(&mut self, vertices: usize) {
        self.densities.clear();
        self.densities.resize(vertices, Densities::default());
        self.is_delta.clear();
        self.is_delta.resize(vertices, false);
        self.nee_pdf = 0.0;
    }

    /// Sets the densities of x_0.
    pub fn begin(&mut self, source: &LightVertex) {
        self.densities[0] = source.densities;
        self.nee_pdf = source.nee_pdf;
    }

    /// Sets the densities that the connection of x_{s-1}, of the light subpath, with x_s, of the camera subpath,
    /// determines for both and for those before them. Neither scatters by a delta lobe.
    pub fn set_connection(&mut self, s: usize, pdfs: &ConnectionPdfs) {
        let n = self.densities.len() - 1;
        if s > 0 {
            self.densities[s - 1].by_camera = pdfs.by_camera[0];
            self.is_delta[s - 1] = false;
        }
        if s > 1 {
            self.densities[s - 2].by_camera = pdfs.by_camera[1];
        }
        if s < n {
            self.densities[s].by_light = pdfs.by_light[0];
            self.is_delta[s] = false;
        }
        if s + 1 < n {
            self.densities[s + 1].by_light = pdfs.by_light[1];
        }
    }

    /// The weight of the strategy with `s` vertices of a light subpath.
    pub fn weight(&self, s: usize) -> f64 {
        let n = self.densities.len() - 1;
        // Light that the camera sees directly is found by s = 0 alone.
        if n == 1 {
            return 1.0;
        }
        let own = not_zero(self.density_of_light(s));
        let of_light = |k| f64::min(self.density_of_light(k) / own, f64::MAX);
        let mut sum = 1.0;
        // Strategies with more vertices of the light subpath: x_s and those after it are on it. x_0 is treated apart.
        let mut ratio = 1.0;
        for k in s + 1..=n {
            if k > 1 {
                let Densities {
                    by_light,
                    by_camera,
                } = self.densities[k - 1];
                ratio = f64::min(ratio * (by_light / not_zero(by_camera)), f64::MAX);
            }
            sum += self.square(k, ratio * of_light(k));
        }
        // Strategies with fewer vertices of the light subpath.
        let mut ratio = 1.0;
        for k in (0..s).rev() {
            if k > 0 {
                let Densities {
                    by_light,
                    by_camera,
                } = self.densities[k];
                ratio = f64::min(ratio * (by_camera / not_zero(by_light)), f64::MAX);
            }
            sum += self.square(k, ratio * of_light(k));
        }
        planted!("a-weight-is-missing", 1.0 / sum.min(2.0), 1.0 / sum)
    }

    /// The density with which strategy `k` finds x_0.
    fn density_of_light(&self, k: usize) -> f64 {
        match k {
            0 => self.densities[0].by_camera,
            1 => self.nee_pdf,
            _ => self.densities[0].by_light,
        }
    }

    /// The term of strategy `k` in the sum, given its density relative to that of the strategy in question.
    fn square(&self, k: usize, ratio: f64) -> f64 {
        let can_connect = k == 0 || !(self.is_delta[k - 1] || self.is_delta[k]);
        if can_connect { ratio * ratio } else { 0.0 }
    }
}

/// The density, kept above zero: rounding may leave nothing of a density by which a vertex has been found.
fn not_zero(density: f64) -> f64 {
    density.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path of four surfaces between light and camera, with numbers that differ widely; the vertex `delta` scatters
    /// by a delta lobe.
    fn path(i: u32, delta: Option<usize>) -> WholePath {
        let number = |k: f64| 10.0_f64.powf(12.0 * (f64::from(i + 1) * k).fract() - 6.0);
        let mut path = WholePath::default();
        path.clear(6);
        for (x, densities) in (0..).map(f64::from).zip(&mut path.densities) {
            densities.by_light = number(0.618_034 + 0.11 * x);
            densities.by_camera = number(0.414_214 + 0.07 * x);
        }
        path.nee_pdf = number(0.732_051);
        if let Some(delta) = delta {
            path.is_delta[delta] = true;
        }
        path
    }

    /// The density p_s by its definition.
    fn density(path: &WholePath, s: usize) -> f64 {
        let of = |i: usize| match (i, s) {
            (0, 1) => path.nee_pdf,
            _ if i < s => path.densities[i].by_light,
            _ => path.densities[i].by_camera,
        };
        (0..path.densities.len() - 1).map(of).product()
    }

    #[test]
    fn mis_weights_match_the_power_heuristic_and_sum_to_one() {
        for i in 0..2000 {
            for delta in [None, Some(1), Some(2), Some(4)] {
                let path = path(i, delta);
                let can = |s: &usize| *s == 0 || !(path.is_delta[s - 1] || path.is_delta[*s]);
                let strategies: Vec<usize> = (0..=5).filter(can).collect();
                let squares = strategies.iter().map(|&s| density(&path, s).powi(2));
                let all: f64 = squares.sum();
                let mut sum = 0.0;
                for &s in &strategies {
                    let weight = path.weight(s);
                    let expected = density(&path, s).powi(2) / all;
                    assert!((weight - expected).abs() < 1e-9, "{s} {weight} {expected}");
                    sum += weight;
                }
                assert!((sum - 1.0).abs() < 1e-9, "{sum}");
            }
        }
    }

    #[test]
    fn mis_weights_exclude_impossible_light_strategies() {
        let mut point = path(3, None);
        point.densities[0].by_camera = 0.0;
        let sum: f64 = (1..=5).map(|s| point.weight(s)).sum();
        assert!((sum - 1.0).abs() < 1e-9);
        let mut unsampled = path(3, None);
        unsampled.densities[0].by_light = 0.0;
        unsampled.nee_pdf = 0.0;
        assert_eq!(unsampled.weight(0), 1.0);
    }

    #[test]
    fn mis_weights_stay_in_unit_range_for_extreme_pdfs() {
        let mut path = path(5, Some(2));
        for (i, densities) in path.densities.iter_mut().enumerate() {
            densities.by_light = if i % 2 == 0 { 1e300 } else { 0.0 };
            densities.by_camera = if i % 2 == 0 { 0.0 } else { 1e-300 };
        }
        for s in 0..=5 {
            let weight = path.weight(s);
            assert!((0.0..=1.0).contains(&weight), "{s}: {weight}");
        }
    }
}
