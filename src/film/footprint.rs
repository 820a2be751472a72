//! The footprint of a sample: the weights with which it contributes to the pixels that its filter covers.
//!
//! A sample at the position x in its pixel q, uniformly distributed there, contributes f(x - c_p) L to every pixel p, with c_p
//! the centre of p. The mean over the samples of q has the expectation of the integral of f(x - c_p) L(x) over q, and the
//! sum over all q is the pixel p. The weights are the products of those along both axes, which are linear between tabulated
//! positions.
//!
//! Measure: positions in a pixel from its left or upper edge, in pixels; weights per sample, whose mean over all positions
//! and pixels is 1.
//! Range: positions in [0, 1); radii above half a pixel, up to 4.5 pixels, of filters that are continuous: others have no
//! footprint, and are importance sampled (`filter.rs`).
//! Source: Pharr, Jakob and Humphreys, "Physically Based Rendering", section 7.8; the shapes are those of `filter.rs`. Tested
//! below and in `tests/rendering/filters.rs`.

/// The largest border size of a footprint, in pixels: sums are kept for as many pixels around each tile.
pub const MAX_BORDER_SIZE: u32 = 4;

/// The number of weights along an axis of the largest footprint.
const MAX_WEIGHTS: usize = 2 * MAX_BORDER_SIZE as usize + 1;

/// The number of cells of the table over a pixel's width. Interpolation differs from a Gaussian by 2 * 10^-6 of its peak.
const CELLS: usize = 512;

/// The weights along one axis, from the pixel `border_size` before that of the sample to the one `border_size` behind it.
pub type AxisWeights = [f32; MAX_WEIGHTS];

/// A table of the weights along one axis.
#[derive(Debug, Clone)]
pub struct Footprint {
    border_size: u32,
    /// The weights at the ends of the cells.
    nodes: Vec<AxisWeights>,
}

impl Footprint {
    /// The footprint of a filter with this radius and this profile along an axis, as a function of the distance from the
    /// centre in pixels; `None` if the border size is too large, or if it does not reach beyond its own pixel.
    pub fn new(radius: f64, profile: impl Fn(f64) -> f64) -> Option<Self> {
        let border_size = (radius - 0.5).ceil();
        if !(1.0..=f64::from(MAX_BORDER_SIZE)).contains(&border_size) {
            return None;
        }
        let count = 2 * border_size as usize + 1;
        let weights = |node: usize| -> Vec<f64> {
            let offset = node as f64 / CELLS as f64 - 0.5;
            let pixels = (0..count).map(|k| k as f64 - border_size);
            pixels.map(|pixel| profile(offset - pixel)).collect()
        };
        let nodes: Vec<Vec<f64>> = (0..=CELLS).map(weights).collect();
        // Trapezoids are exact for a function that is linear in each cell.
        let of_node = |node: usize| nodes[node].iter().sum::<f64>();
        let all: f64 = (0..=CELLS).map(of_node).sum();
        let integral = (all - 0.5 * (of_node(0) + of_node(CELLS))) / CELLS as f64;
        let node = |weights: &Vec<f64>| {
            let mut node = [0.0; MAX_WEIGHTS];
            for (to, weight) in node.iter_mut().zip(weights) {
                *to = (weight / integral) as f32;
            }
            node
        };
        Some(Self {
            border_size: border_size as u32,
            nodes: nodes.iter().map(node).collect(),
        })
    }

    /// The number of pixels on either side of a sample's own that it contributes to.
    pub fn border_size(&self) -> u32 {
        self.border_size
    }

    /// The weights at a position along an axis; those further from the pixel than the border size are 0.
    #[inline(always)]
    pub fn along_axis(&self, position: f32) -> AxisWeights {
        let at = position * CELLS as f32;
        let cell = (at as usize).min(CELLS - 1);
        let within = at - cell as f32;
        let [from, to] = [&self.nodes[cell], &self.nodes[cell + 1]];
        std::array::from_fn(|k| from[k] + within * (to[k] - from[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tent(radius: f64) -> impl Fn(f64) -> f64 {
        move |x| (1.0 - x.abs() / radius).max(0.0)
    }

    #[test]
    fn unit_tent_footprint_has_linear_interpolation_weights() {
        let footprint = Footprint::new(1.0, tent(1.0)).expect("it reaches the next pixel");
        assert_eq!(footprint.border_size(), 1);
        for (position, expected) in [
            (0.5, [0.0, 1.0, 0.0]),
            (0.25, [0.25, 0.75, 0.0]),
            (0.875, [0.0, 0.625, 0.375]),
        ] {
            let weights = footprint.along_axis(position);
            for (weight, expected) in weights.iter().zip(expected) {
                assert!((weight - expected).abs() < 1e-6, "{position}: {weights:?}");
            }
            assert!(weights[3..].iter().all(|&weight| weight == 0.0));
        }
    }

    #[test]
    fn footprint_weights_sum_to_one_averaged_over_positions() {
        for radius in [0.6, 1.0, 1.3, 1.5, 2.0, 4.5] {
            let footprint = Footprint::new(radius, tent(radius)).expect("a footprint");
            const POSITIONS: u32 = 1 << 14;
            let all = (0..POSITIONS).map(|i| {
                let weights = footprint.along_axis((i as f32 + 0.5) / POSITIONS as f32);
                weights.iter().map(|&w| f64::from(w)).sum::<f64>()
            });
            let mean = all.sum::<f64>() / f64::from(POSITIONS);
            assert!((mean - 1.0).abs() < 1e-6, "{radius}: {mean}");
        }
    }

    #[test]
    fn filters_too_narrow_or_too_wide_have_no_footprint() {
        for radius in [0.1, 0.5, 4.6, 32.0] {
            assert!(Footprint::new(radius, tent(radius)).is_none(), "{radius}");
        }
    }
}
