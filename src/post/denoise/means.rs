//! Non-local means over the two halves of an image: each pixel becomes a weighted mean of similar pixels.
//!
//!   F_A(p) = sum_q w_B(p, q) A(q) / sum_q w_B(p, q),   w_B(p, q) = k(max(s d_B(p, q), d_guides(p, q))),
//!
//! and likewise with A and B exchanged, with the distances of `means/distances.rs`. The weights from one half are independent
//! of the noise in the other half, whose values they weigh: the mean over both is free of the bias of selecting noisy values
//! by their noise. k(d) = (1 - d / 4)^4 falls like exp(-d), and is exactly 0 from 4 on.
//!
//! Measure: radiance and its variance.
//! Range: finite numbers; variances may be 0. Pixels beyond the border have no weight.
//! Source: Buades, Coll and Morel 2005; Rousselle, Knaus and Zwicker 2012, "Adaptive Rendering with Non-Local Means
//! Filtering", section 4 for the halves. Tested below and in `tests/rendering/denoise.rs`.

mod distances;

use super::guides::Feature;
use super::part::PaddedPart;
use crate::math::plane::Plane;
use crate::planted::planted;
use rayon::prelude::*;

/// The edge in pixels of the tiles that threads work on.
const TILE: usize = 64;

/// The input of the filter.
#[derive(Debug, Clone)]
pub struct Halves {
    /// Both halves, channel by channel.
    pub values: [[Plane; 3]; 2],
    /// The variance of either half.
    pub variance: [Plane; 3],
}

/// The parameters of the comparison of pixels.
#[derive(Debug, Clone)]
pub struct ComparisonParameters {
    /// The radius of the search window, in pixels.
    pub reach: usize,
    /// The radius of patches, in pixels.
    pub patch: usize,
    /// The factor of colour distances, for each filter that is wanted: 0 ignores colours.
    pub strictness: Vec<f32>,
}

/// The filtered halves.
#[derive(Debug, Clone)]
pub struct Means {
    /// Both filtered halves, channel by channel.
    pub values: [[Plane; 3]; 2],
    /// The weight of each pixel's own value in its mean, in each half.
    pub own: [Plane; 2],
}

impl Means {
    /// The unfiltered halves.
    pub fn unfiltered(halves: &Halves) -> Self {
        let own = halves.variance[0].like(|_| 1.0);
        Self {
            values: halves.values.clone(),
            own: [own.clone(), own],
        }
    }
}

/// Filters both halves, once for each strictness.
pub fn means(halves: &Halves, guides: &[Feature], comparison: &ComparisonParameters) -> Vec<Means> {
    let [width, height] = [halves.variance[0].width, halves.variance[0].height];
    let corners: Vec<[usize; 2]> = (0..height)
        .step_by(TILE)
        .flat_map(|y| (0..width).step_by(TILE).map(move |x| [x, y]))
        .collect();
    let tiles: Vec<FilterTile> = corners
        .into_par_iter()
        .map(|[x, y]| {
            let size = [TILE.min(width - x), TILE.min(height - y)];
            FilterTile::filtered([x, y], size, halves, guides, comparison)
        })
        .collect();
    let empty = Plane::filled(width, height, 0.0);
    let place = |get: &dyn Fn(&FilterTile) -> &[f32]| {
        let mut plane = empty.clone();
        for tile in &tiles {
            let [columns, _] = tile.size;
            for (row, values) in get(tile).chunks_exact(columns).enumerate() {
                let start = (tile.corner[1] + row) * width + tile.corner[0];
                plane.values[start..start + columns].copy_from_slice(values);
            }
        }
        plane
    };
    (0..comparison.strictness.len())
        .map(|s| Means {
            values: [0, 1].map(|half| [0, 1, 2].map(|c| place(&|t| &t.sums[s].values[half][c]))),
            own: [0, 1].map(|half| place(&|t| &t.sums[s].weights[half])),
        })
        .collect()
}

/// A tile of the image while it is filtered.
struct FilterTile {
    corner: [usize; 2],
    size: [usize; 2],
    /// The sums for each strictness.
    sums: Vec<PatchSums>,
}

/// Weighted sums of differences to the own value and of weights; in the end means, and the weight of the own value.
#[derive(Clone)]
struct PatchSums {
    values: [[Vec<f32>; 3]; 2],
    weights: [Vec<f32>; 2],
}

/// The input of a tile, with a margin.
struct PaddedInput {
    margin: usize,
    size: [usize; 2],
    values: [[PaddedPart; 3]; 2],
    variance: [PaddedPart; 3],
    guides: Vec<GuideParts>,
}

struct GuideParts {
    channels: Vec<PaddedPart>,
    variance: PaddedPart,
    /// The reciprocal of the scale.
    per_scale: PaddedPart,
    slope: Option<[PaddedPart; 2]>,
}

/// Buffers for one offset at a time.
struct Scratch {
    /// The colour distances of each half, with a margin of a patch's radius.
    distances: [Vec<f32>; 2],
    /// The colour distances summed along rows.
    across: [Vec<f32>; 2],
    /// The guide distances.
    guides: Vec<f32>,
    /// A buffer of one row.
    row: Vec<f32>,
}

impl FilterTile {
    fn filtered(
        corner: [usize; 2],
        size: [usize; 2],
        halves: &Halves,
        guides: &[Feature],
        comparison: &ComparisonParameters,
    ) -> Self {
        let margin = comparison.reach + comparison.patch;
        let part = |plane: &Plane| PaddedPart::of(plane, corner, size, margin);
        let source = PaddedInput {
            margin,
            size,
            values: halves
                .values
                .each_ref()
                .map(|half| half.each_ref().map(part)),
            variance: halves.variance.each_ref().map(part),
            guides: guides.iter().map(|it| GuideParts::of(it, &part)).collect(),
        };
        let count = size[0] * size[1];
        let zeros = || vec![0.0; count];
        let none = PatchSums {
            values: [0, 1].map(|_| [0, 1, 2].map(|_| zeros())),
            weights: [zeros(), zeros()],
        };
        let mut sums = vec![none; comparison.strictness.len()];
        let wide = size.map(|length| length + 2 * comparison.patch);
        let mut scratch = Scratch {
            distances: [0, 1].map(|_| vec![0.0; wide[0] * wide[1]]),
            across: [0, 1].map(|_| vec![0.0; size[0] * wide[1]]),
            guides: zeros(),
            row: vec![0.0; size[0]],
        };
        let picture = [halves.variance[0].width, halves.variance[0].height];
        let reach = comparison.reach as isize;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let offset = [dx, dy];
                // The pixels of the tile whose partners at the offset lie in the image.
                let [columns, rows] = [0, 1].map(|axis| {
                    let first = (-offset[axis] - corner[axis] as isize).max(0);
                    let last = picture[axis] as isize - offset[axis] - corner[axis] as isize;
                    first as usize..last.clamp(0, size[axis] as isize) as usize
                });
                if columns.is_empty() || rows.is_empty() {
                    continue;
                }
                source.guide_distances(offset, &mut scratch);
                source.colour_distances(offset, comparison.patch, &mut scratch);
                source.gather(offset, columns, rows, comparison, &mut scratch, &mut sums);
            }
        }
        for sums in &mut sums {
            source.normalise(sums);
        }
        Self { corner, size, sums }
    }
}

impl GuideParts {
    fn of(feature: &Feature, part: &impl Fn(&Plane) -> PaddedPart) -> Self {
        let per_scale = feature.scale.like(|i| 1.0 / feature.scale.values[i]);
        Self {
            channels: feature.channels.iter().map(part).collect(),
            variance: part(&feature.variance),
            per_scale: part(&per_scale),
            slope: feature
                .slope
                .as_ref()
                .map(|slope| slope.each_ref().map(part)),
        }
    }
}

impl PaddedInput {
    /// A row of a tile's own pixels, or of those at an offset.
    fn row<'a>(&self, part: &'a PaddedPart, y: usize, [dx, dy]: [isize; 2]) -> &'a [f32] {
        let x = (self.margin as isize + dx) as usize;
        let y = (self.margin + y) as isize + dy;
        part.row([x, y as usize], self.size[0])
    }

    /// Adds the pixels at an offset to the sums, with weights from the other half.
    fn gather(
        &self,
        offset: [isize; 2],
        columns: std::ops::Range<usize>,
        rows: std::ops::Range<usize>,
        comparison: &ComparisonParameters,
        scratch: &mut Scratch,
        sums: &mut [PatchSums],
    ) {
        let width = self.size[0];
        let side = 2 * comparison.patch + 1;
        let per_patch = 1.0 / (3 * side * side) as f32;
        for y in rows {
            let guides = &scratch.guides[y * width..][columns.clone()];
            for half in [0, 1] {
                let row = &mut scratch.row;
                row.fill(0.0);
                let other = planted!("denoise-own-weights", half, 1 - half);
                for line in y..y + side {
                    let across = &scratch.across[other][line * width..][..width];
                    for (sum, x) in row.iter_mut().zip(across) {
                        *sum += x;
                    }
                }
                let colours = &row[columns.clone()];
                let values = self.values[half].each_ref();
                let there = values.map(|part| &self.row(part, y, offset)[columns.clone()]);
                let here = values.map(|part| &self.row(part, y, [0, 0])[columns.clone()]);
                for (sums, &strictness) in sums.iter_mut().zip(&comparison.strictness) {
                    let scale = strictness * per_patch;
                    let at = y * width;
                    let weights = &mut sums.weights[half][at..][columns.clone()];
                    let differences = sums.values[half].each_mut();
                    let [r, g, b] = differences.map(|sum| &mut sum[at..][columns.clone()]);
                    for i in 0..columns.len() {
                        let w = weight((scale * colours[i]).max(guides[i]));
                        weights[i] += w;
                        r[i] += w * (there[0][i] - here[0][i]);
                        g[i] += w * (there[1][i] - here[1][i]);
                        b[i] += w * (there[2][i] - here[2][i]);
                    }
                }
            }
        }
    }

    /// Computes means from weighted sums of differences to the own value, a form that leaves constant regions
    /// unchanged. The own weight is 1.
    fn normalise(&self, sums: &mut PatchSums) {
        let width = self.size[0];
        for half in [0, 1] {
            for weight in &mut sums.weights[half] {
                *weight = 1.0 / *weight;
            }
            for (sum, own) in sums.values[half].iter_mut().zip(&self.values[half]) {
                for (y, sum) in sum.chunks_exact_mut(width).enumerate() {
                    let own = self.row(own, y, [0, 0]);
                    let weights = &sums.weights[half][y * width..];
                    for ((sum, own), weight) in sum.iter_mut().zip(own).zip(weights) {
                        *sum = own + *sum * weight;
                    }
                }
            }
        }
    }
}

/// The weight of a pixel at this distance: 1 at 0, close to exp(-d), and 0 from 4 on.
#[inline]
fn weight(distance: f32) -> f32 {
    let root = (1.0 - 0.25 * distance.max(0.0)).max(0.0);
    let square = root * root;
    square * square
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grey image, equal in both halves, with one variance everywhere.
    fn halves(width: usize, values: Vec<f32>, variance: f32) -> Halves {
        let plane = Plane::new(width, values.len() / width, values);
        let variance = plane.like(|_| variance);
        let grey = || [plane.clone(), plane.clone(), plane.clone()];
        Halves {
            values: [grey(), grey()],
            variance: [variance.clone(), variance.clone(), variance],
        }
    }

    fn comparison(reach: usize, patch: usize, strictness: f32) -> ComparisonParameters {
        ComparisonParameters {
            reach,
            patch,
            strictness: vec![strictness],
        }
    }

    #[test]
    fn weight_approximates_exponential_and_has_compact_support() {
        assert_eq!([weight(-3.0), weight(0.0)], [1.0; 2]);
        assert_eq!([weight(4.0), weight(f32::INFINITY)], [0.0; 2]);
        for i in 0..40 {
            let d = 0.1 * i as f32;
            assert!((weight(d) - (-d).exp()).abs() < 0.08 && weight(d) > weight(d + 0.1));
        }
    }

    #[test]
    fn noise_free_image_is_left_unchanged() {
        let values: Vec<f32> = (0..90).map(|i| 1.0 + 1e-4 * i as f32).collect();
        let still = halves(10, values.clone(), 0.0);
        let filtered = means(&still, &[], &comparison(3, 1, 1.0)).remove(0);
        assert_eq!(filtered.values[0][1].values, values);
        assert_eq!(filtered.own[1].values, [1.0; 90]);
    }

    #[test]
    fn filter_without_colour_comparison_is_a_box_mean() {
        // Larger than a tile, and not a multiple of one.
        let values: Vec<f32> = (0..70 * 67).map(|i| ((i * 7919) % 101) as f32).collect();
        let noisy = halves(70, values, 1.0);
        let filtered = means(&noisy, &[], &comparison(2, 0, 0.0)).remove(0);
        let expected = noisy.values[0][0].box_mean(2);
        for (x, y) in filtered.values[0][2].values.iter().zip(&expected.values) {
            assert!((x - y).abs() < 1e-3, "{x} {y}");
        }
        assert_eq!(filtered.own[0].values[0], 1.0 / 9.0);
        assert_eq!(filtered.own[0].values[35 * 70 + 35], 1.0 / 25.0);
    }

    /// Two levels, 10 standard errors apart: each pixel becomes the mean of its own level.
    #[test]
    fn levels_ten_standard_errors_apart_are_not_mixed() {
        let values: Vec<f32> = (0..20 * 20)
            .map(|i| if i % 20 < 10 { 0.0 } else { 10.0 })
            .collect();
        let noisy = halves(20, values.clone(), 1.0);
        let filtered = means(&noisy, &[], &comparison(4, 0, 1.0)).remove(0);
        assert_eq!(filtered.values[0][0].values, values);
        assert_eq!(filtered.own[0].values[10 * 20 + 9], 1.0 / 45.0);
    }
}
