//! Numeric integration in double precision.
//!
//! Measure: that of the integrand times the domain.
//! Range: bounded integrands; adaptive rules stop at a maximum depth, so that kinks and edges cost accuracy, not time.
//! Source: Gauss-Legendre nodes by Newton's method on P_n. Tested in `tests/sampling/harness.rs`.

use std::f64::consts::PI;

/// The nodes and weights of the n-point Gauss-Legendre rule on [-1, 1].
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..64 {
                // P_n by its recurrence, and P_n' from P_n and P_(n-1).
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / slope;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// The integral of `f` over [a, b] by `panels` panels of 16 points.
pub fn integrate(f: impl Fn(f64) -> f64, a: f64, b: f64, panels: usize) -> f64 {
    let rule = gauss_legendre(16);
    let width = (b - a) / panels as f64;
    let mut sum = 0.0;
    for panel in 0..panels {
        let centre = a + width * (panel as f64 + 0.5);
        for &(x, w) in &rule {
            sum += 0.5 * width * w * f(centre + 0.5 * width * x);
        }
    }
    sum
}

/// A rectangle [x0, x1] x [y0, y1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// The interval along the first axis.
    pub x: (f64, f64),
    /// The interval along the second axis.
    pub y: (f64, f64),
}

impl Rectangle {
    /// The halves across the first axis.
    fn halves_x(self) -> [Self; 2] {
        let middle = 0.5 * (self.x.0 + self.x.1);
        [(self.x.0, middle), (middle, self.x.1)].map(|x| Self { x, ..self })
    }

    /// The halves across the second axis.
    fn halves_y(self) -> [Self; 2] {
        let middle = 0.5 * (self.y.0 + self.y.1);
        [(self.y.0, middle), (middle, self.y.1)].map(|y| Self { y, ..self })
    }

    fn area(self) -> f64 {
        (self.x.1 - self.x.0) * (self.y.1 - self.y.0)
    }
}

/// Adaptive integration over rectangles.
pub struct Adaptive {
    rule: Vec<(f64, f64)>,
    /// The difference of two estimates below which a rectangle is not halved further. The same tolerance holds for
    /// the halves: errors at an edge have random signs.
    pub tolerance: f64,
    /// The maximum number of successive halvings.
    pub depth: u32,
}

impl Adaptive {
    /// Builds an integrator with rules of 5 x 5 points, which halves until `tolerance` or `depth` is reached.
    pub fn new(tolerance: f64, depth: u32) -> Self {
        Self {
            rule: gauss_legendre(5),
            tolerance,
            depth,
        }
    }

    /// The integral of `f` over `domain`.
    pub fn integrate(&self, f: &impl Fn(f64, f64) -> f64, domain: Rectangle) -> f64 {
        self.refine(f, domain, self.once(f, domain), self.depth)
    }

    fn once(&self, f: &impl Fn(f64, f64) -> f64, r: Rectangle) -> f64 {
        let (cx, hx) = (0.5 * (r.x.0 + r.x.1), 0.5 * (r.x.1 - r.x.0));
        let (cy, hy) = (0.5 * (r.y.0 + r.y.1), 0.5 * (r.y.1 - r.y.0));
        let mut sum = 0.0;
        for &(x, wx) in &self.rule {
            for &(y, wy) in &self.rule {
                sum += wx * wy * f(cx + hx * x, cy + hy * y);
            }
        }
        sum * hx * hy
    }

    /// Halves `domain` across the axis along which the integrand changes more, until the estimate changes within the tolerance.
    fn refine(
        &self,
        f: &impl Fn(f64, f64) -> f64,
        domain: Rectangle,
        coarse: f64,
        depth: u32,
    ) -> f64 {
        let halves = [domain.halves_x(), domain.halves_y()];
        let parts = halves.map(|pair| pair.map(|half| self.once(f, half)));
        let [error_x, error_y] = parts.map(|[low, high]| (low + high - coarse).abs());
        // A peak at a corner can be too narrow for the rules; values at the corners detect it.
        let [x, y] = [domain.x, domain.y];
        let [c00, c01, c10, c11] =
            [f(x.0, y.0), f(x.0, y.1), f(x.1, y.0), f(x.1, y.1)].map(f64::abs);
        let peak = c00.max(c01).max(c10).max(c11) * domain.area();
        let seen = peak <= self.tolerance + 8.0 * coarse.abs();
        if depth == 0 || (seen && error_x.max(error_y) <= self.tolerance) {
            return parts[0].iter().chain(&parts[1]).sum::<f64>() - coarse;
        }
        let across_x = if seen {
            error_x >= error_y
        } else {
            (c00 - c10).abs().max((c01 - c11).abs()) >= (c00 - c01).abs().max((c10 - c11).abs())
        };
        let axis = usize::from(!across_x);
        (0..2)
            .map(|i| self.refine(f, halves[axis][i], parts[axis][i], depth - 1))
            .sum()
    }
}
