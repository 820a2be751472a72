//! The distances between the pixels of a tile and those at one offset, by colours and by guides.
//!
//! The distance by the colours of half B is the mean over the channels and over the patch about p and q of
//!
//!   ((B_p - B_q)^2 - (v_p + min(v_p, v_q))) / (v_p + v_q),
//!
//! with v the variance of the noise. It is 0 on average between pixels that differ by their noise alone, and grows without
//! bound between all others as the noise vanishes, so that then only equal pixels are averaged. The distance by guides is
//! that of `guides.rs`.
//!
//! Distances of all pixels to those at one offset are computed together and averaged by a box filter, so that the
//! time does not depend on the size of patches (Darbon et al. 2008).
//!
//! Measure: squared differences in units of their noise or tolerance.
//! Range: finite numbers; variances may be 0.
//! Source: Rousselle, Knaus and Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", section 4. Tested in
//! `means.rs` and in `tests/rendering/denoise.rs`.

use super::{PaddedInput, Scratch};
use crate::planted::planted;

impl PaddedInput {
    /// Computes the guide distance of each pixel to the one at an offset: the largest over the features.
    pub(super) fn guide_distances(&self, offset: [isize; 2], scratch: &mut Scratch) {
        let [width, height] = self.size;
        scratch.guides.fill(0.0);
        for y in 0..height {
            let out = &mut scratch.guides[y * width..][..width];
            for guide in &self.guides {
                let squares = &mut scratch.row;
                squares.fill(0.0);
                for channel in &guide.channels {
                    let (p, q) = (self.row(channel, y, [0, 0]), self.row(channel, y, offset));
                    if let Some([across, down]) = &guide.slope {
                        let [dx, dy] = offset.map(|it| it as f32);
                        let across = self.row(across, y, [0, 0]);
                        let down = self.row(down, y, [0, 0]);
                        for i in 0..width {
                            let d = q[i] - p[i] - dx * across[i] - dy * down[i];
                            squares[i] += d * d;
                        }
                    } else {
                        for i in 0..width {
                            squares[i] += (q[i] - p[i]) * (q[i] - p[i]);
                        }
                    }
                }
                let v_p = self.row(&guide.variance, y, [0, 0]);
                let v_q = self.row(&guide.variance, y, offset);
                let per_scale = self.row(&guide.per_scale, y, [0, 0]);
                for i in 0..width {
                    let noise = v_p[i] + v_p[i].min(v_q[i]);
                    out[i] = out[i].max((squares[i] - noise) * per_scale[i]);
                }
            }
        }
    }

    /// Computes the colour distance of each pixel to the one at an offset, in each half, summed along rows over
    /// patches.
    pub(super) fn colour_distances(&self, offset: [isize; 2], patch: usize, scratch: &mut Scratch) {
        let [width, height] = self.size;
        let (wide, high) = (width + 2 * patch, height + 2 * patch);
        let start = self.margin - patch;
        for y in 0..high {
            let here = [start, start + y];
            let there = [0, 1].map(|axis| (here[axis] as isize + offset[axis]) as usize);
            let [first, second] = &mut scratch.distances;
            let out = [first, second].map(|it| &mut it[y * wide..][..wide]);
            out.into_iter().zip(&self.values).for_each(|(out, half)| {
                out.fill(0.0);
                for (part, variance) in half.iter().zip(&self.variance) {
                    let (p, q) = (part.row(here, wide), part.row(there, wide));
                    let (v_p, v_q) = (variance.row(here, wide), variance.row(there, wide));
                    for i in 0..wide {
                        let d = p[i] - q[i];
                        let noise = v_p[i] + v_p[i].min(v_q[i]);
                        // Without noise, equal pixels are at distance 0 and all others far apart.
                        let measure = planted!(
                            "denoise-ignores-variance",
                            0.1 * (p[i] + q[i]).powi(2) + f32::MIN_POSITIVE,
                            v_p[i] + v_q[i] + f32::MIN_POSITIVE
                        );
                        out[i] += (d * d - noise) / measure;
                    }
                }
            });
            for (across, distances) in scratch.across.iter_mut().zip(&scratch.distances) {
                let out = &mut across[y * width..][..width];
                let row = &distances[y * wide..][..wide];
                out.copy_from_slice(&row[..width]);
                for shift in 1..=2 * patch {
                    for (sum, x) in out.iter_mut().zip(&row[shift..]) {
                        *sum += x;
                    }
                }
            }
        }
    }
}
