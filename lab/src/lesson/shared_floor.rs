//! A floor in two dimensions whose pixels share their paths, with exact moments of their estimates.
//!
//! Measure: the irradiance on a floor at height 0, under a ceiling at height 1 that emits 1 where t > 0, with a low wall at
//! x = 0 that stands on the floor.
//! Range: pixels side by side on the floor, each with one path, whose direction is cosine-weighted.
//! Source: Bekaert, Sbert and Halton 2002, "Accelerating Path Tracing by Re-Using Paths". Exact values by quadrature of
//! E = int L g, and of the moments. Tested through the lesson, in `lab/tests/reports/lesson.rs`.

use super::uniform::Uniform;

/// The pixels of a group.
pub(super) const PIXELS: usize = 16;

/// The height of the wall.
pub(super) const WALL: f64 = 0.3;

/// Points of the quadrature.
pub(super) const POINTS: usize = 1 << 13;

/// The pixels that the denominator of the weights counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counted {
    /// The pixels of the group that see the point.
    Seeing,
    /// All pixels of the group, which is wrong.
    All,
}

/// Pixels side by side, in groups that share their paths.
#[derive(Debug, Clone)]
pub(super) struct PixelRow {
    pub(super) positions: Vec<f64>,
    /// The number of pixels in a group.
    group: usize,
    wall: f64,
}

impl PixelRow {
    /// Sixteen pixels about a centre.
    pub(super) fn new(centre: f64, spacing: f64, group: usize, wall: f64) -> Self {
        let middle = (PIXELS - 1) as f64 / 2.0;
        let positions = (0..PIXELS).map(|i| centre + spacing * (i as f64 - middle));
        Self {
            positions: positions.collect(),
            group,
            wall,
        }
    }

    /// The density by which the path of a pixel arrives at the point t of the ceiling: 0 if the wall is between.
    pub(super) fn density(&self, pixel: usize, t: f64) -> f64 {
        let x = self.positions[pixel];
        // The height at which the ray crosses x = 0, if it does.
        let crossing = -x / (t - x);
        if (0.0..=1.0).contains(&crossing) && crossing < self.wall {
            return 0.0;
        }
        unoccluded(x, t)
    }

    /// The pixels that share paths with a pixel.
    pub(super) fn group_of(&self, pixel: usize) -> std::ops::Range<usize> {
        let first = pixel - pixel % self.group;
        first..first + self.group
    }

    /// The denominator of the weights of the point t, in the group of a pixel.
    pub(super) fn denominator(&self, pixel: usize, t: f64, counted: Counted) -> f64 {
        let densities = self.group_of(pixel).map(|k| match counted {
            Counted::Seeing => self.density(k, t),
            Counted::All => unoccluded(self.positions[k], t),
        });
        densities.sum()
    }

    /// One estimate of each pixel, from one path of each.
    pub(super) fn estimates(&self, counted: Counted, uniform: &mut Uniform) -> [f64; PIXELS] {
        let mut estimates = [0.0; PIXELS];
        for path in 0..PIXELS {
            let sine = 2.0 * uniform.double() - 1.0;
            let t = self.positions[path] + sine / (1.0 - sine * sine).sqrt();
            // Else the path arrives at the wall, or at the dark part of the ceiling.
            if t > 0.0 && self.density(path, t) > 0.0 {
                let denominator = self.denominator(path, t, counted);
                for pixel in self.group_of(path) {
                    estimates[pixel] += self.density(pixel, t) / denominator;
                }
            }
        }
        estimates
    }

    /// The integral of a function of the point over the bright part of the ceiling.
    pub(super) fn integral(&self, f: impl Fn(f64) -> f64) -> f64 {
        let centre = self.positions[PIXELS / 2];
        let values = (0..POINTS).map(|i| {
            let sine = (2 * i + 1) as f64 / POINTS as f64 - 1.0;
            let cosine2 = 1.0 - sine * sine;
            let t = centre + sine / cosine2.sqrt();
            let per_sine = 1.0 / (cosine2 * cosine2.sqrt());
            if t > 0.0 { f(t) * per_sine } else { 0.0 }
        });
        values.sum::<f64>() * 2.0 / POINTS as f64
    }

    /// The exact mean of a pixel's estimates.
    pub(super) fn mean(&self, pixel: usize, counted: Counted) -> f64 {
        self.integral(|t| {
            let found: f64 = self.group_of(pixel).map(|k| self.density(k, t)).sum();
            match found {
                0.0 => 0.0,
                _ => self.density(pixel, t) * found / self.denominator(pixel, t, counted),
            }
        })
    }

    /// The parts m of a pixel's mean that come by the paths of each pixel of its group.
    pub(super) fn parts(&self, pixel: usize) -> Vec<f64> {
        let part = |by: usize| {
            self.integral(|t| match self.denominator(pixel, t, Counted::Seeing) {
                0.0 => 0.0,
                sum => self.density(pixel, t) * self.density(by, t) / sum,
            })
        };
        self.group_of(pixel).map(part).collect()
    }

    /// The exact variance of the estimates of a pixel.
    pub(super) fn variance(&self, pixel: usize) -> f64 {
        let parts = self.parts(pixel);
        covariance([&parts, &parts], pixel - self.group_of(pixel).start)
    }

    /// The exact variance of the mean over the first pixels, which are not more than a group.
    pub(super) fn variance_of_mean(&self, count: usize) -> f64 {
        let parts: Vec<Vec<f64>> = (0..count).map(|pixel| self.parts(pixel)).collect();
        let all = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
        let same_group = all.filter(|&(a, b)| self.group_of(a) == self.group_of(b));
        let first = |pixel| self.group_of(pixel).start;
        let terms = same_group.map(|(a, b)| covariance([&parts[a], &parts[b]], b - first(b)));
        terms.sum::<f64>() / (count * count) as f64
    }
}

/// The covariance of the estimates of two pixels of a group, from their parts, given the place of the second.
pub(super) fn covariance([a, b]: [&[f64]; 2], place: usize) -> f64 {
    let products = a.iter().zip(b).map(|(a, b)| a * b);
    a[place] - products.sum::<f64>()
}

/// The density by which a path from x arrives at the point t of the ceiling, if nothing is between: cosine at both ends, over
/// the distance.
pub(super) fn unoccluded(x: f64, t: f64) -> f64 {
    let distance2 = 1.0 + (t - x) * (t - x);
    0.5 / (distance2 * distance2.sqrt())
}

/// The closed form of the irradiance at x.
pub(super) fn irradiance(x: f64) -> f64 {
    let sine = |tangent: f64| tangent / tangent.hypot(1.0);
    if x >= 0.0 {
        0.5 * (1.0 + sine(x))
    } else {
        0.5 * (sine(-x / WALL) - sine(-x))
    }
}
