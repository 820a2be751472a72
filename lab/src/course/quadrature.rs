//! Quadrature rules: the trapezoidal and Simpson's, along one axis and as tensor products over the unit cube.
//!
//! Measure: that of the integrand times that of the domain.
//! Range: integrands that are finite, also at the ends; dimensions from 1, as many as the number of calls allows. With
//! N calls the error of smooth integrands falls as N^(-2/d) and N^(-4/d), where Monte Carlo has N^(-1/2) for any d.
//! Source: Davis and Rabinowitz, "Methods of Numerical Integration". Tested in `lab/tests/course/integration.rs`.

use super::grid::Grid;

/// The result of an integration over the cube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CubatureResult {
    /// The estimate of the integral.
    pub value: f64,
    /// Number of calls of the integrand: at most the requested number.
    pub calls: usize,
}

/// A rule with equally spaced nodes that include the ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuadratureRule {
    /// Linear interpolation between the nodes: an error of order h^2.
    Trapezoid,
    /// Parabolas through three nodes each: an error of order h^4.
    Simpson,
}

impl QuadratureRule {
    /// The integral of `f` from one end of `range` to the other with a number of nodes: two at least, or for Simpson's
    /// rule an odd number from three; `None` for other numbers.
    pub fn integrate(self, f: impl Fn(f64) -> f64, range: [f64; 2], nodes: usize) -> Option<f64> {
        if self.most_nodes(nodes) != Some(nodes) {
            return None;
        }
        let node = |i: usize| {
            let at = unit_node(i, nodes);
            (1.0 - at) * range[0] + at * range[1]
        };
        let sum: f64 = (0..nodes).map(|i| self.weight(i, nodes) * f(node(i))).sum();
        Some((range[1] - range[0]) * sum)
    }

    /// The integral of `f` over the unit cube by the rule's tensor product, with as many nodes as `calls` allows;
    /// `None` if the rule needs more, 2^d or 3^d.
    pub fn integrate_cube(
        self,
        f: impl Fn(&[f64]) -> f64,
        dimension: u32,
        calls: usize,
    ) -> Option<CubatureResult> {
        let grid = Grid::of_calls(calls, dimension, self.least_nodes())?;
        let nodes = self.most_nodes(grid.per_axis())?;
        let grid = grid.coarsened_to(nodes);
        let mut at = vec![0.0; dimension as usize];
        let value = grid.sum(|place| {
            let mut weight = 1.0;
            for (x, &i) in at.iter_mut().zip(place) {
                *x = unit_node(i, nodes);
                weight *= self.weight(i, nodes);
            }
            weight * f(&at)
        });
        Some(CubatureResult {
            value,
            calls: grid.count(),
        })
    }

    fn least_nodes(self) -> usize {
        match self {
            Self::Trapezoid => 2,
            Self::Simpson => 3,
        }
    }

    /// The greatest valid number of nodes up to a limit.
    fn most_nodes(self, limit: usize) -> Option<usize> {
        let most = match self {
            Self::Trapezoid => limit,
            // The greatest odd number up to the limit.
            Self::Simpson => limit.saturating_sub(1) | 1,
        };
        (most >= self.least_nodes()).then_some(most)
    }

    /// The weight of a node; all weights sum to 1.
    fn weight(self, i: usize, nodes: usize) -> f64 {
        let h = 1.0 / (nodes - 1) as f64;
        let is_end = i == 0 || i == nodes - 1;
        match self {
            Self::Trapezoid if is_end => 0.5 * h,
            Self::Trapezoid => h,
            Self::Simpson if is_end => h / 3.0,
            Self::Simpson if i % 2 == 1 => 4.0 * h / 3.0,
            Self::Simpson => 2.0 * h / 3.0,
        }
    }
}

/// The position of a node in [0, 1].
fn unit_node(i: usize, nodes: usize) -> f64 {
    i as f64 / (nodes - 1) as f64
}
