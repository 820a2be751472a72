//! Error estimates from independent renders with equal settings: mean squared error, variance, squared bias.
//!
//! All of them are computed from the products G_ij = mean of w (X_i - R1)(X_j - R2) of renders compared with two
//! references:
//!
//!   mean squared error  mean of G_ii,
//!   squared bias        mean of G_ij over i != j,
//!   variance            mean of (G_ii + G_jj - G_ij - G_ji) / 2 over i < j, which is that of w (X_i - X_j)^2 / 2.
//!
//! Measure: relMSE, without unit.
//! Range: at least two renders; estimates of small values may be negative by chance.
//! Source: docs/accuracy.md, "The study"; standard errors by the jackknife, except for the squared bias: without bias
//! its U-statistic is degenerate, and the jackknife would give twice the variance. It uses Hoeffding's decomposition
//! (Hoeffding 1948). Tested below.

use etendue::internals::math::stats::{Moments, student_p_value, student_quantile_of};
use serde::Serialize;

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// The degrees of freedom of the standard error.
    pub freedom: f64,
}

impl Estimate {
    /// The half width of the confidence interval with this confidence.
    pub fn margin(&self, confidence: f64) -> f64 {
        match self.freedom > 0.0 {
            true => student_quantile_of(self.freedom, 0.5 + 0.5 * confidence) * self.standard_error,
            // Without noise there are no degrees of freedom.
            false => self.standard_error,
        }
    }

    /// The one-sided p-value: the probability of a number as large if the expected value is 0.
    pub fn p_above_zero(&self) -> f64 {
        let t = self.value / self.standard_error;
        let two_sided = match t.is_finite() && self.freedom > 0.0 {
            true => student_p_value(t, self.freedom),
            false => 0.0,
        };
        match self.value > 0.0 {
            true => 0.5 * two_sided,
            false => 1.0 - 0.5 * two_sided,
        }
    }

    /// The sum of independent estimates, each multiplied by a factor.
    pub fn sum(parts: &[(f64, Self)]) -> Self {
        let variances = parts.iter().map(|(f, e)| (f * e.standard_error).powi(2));
        let variance: f64 = variances.clone().sum();
        // Degrees of freedom by Welch and Satterthwaite.
        let shares = variances.zip(parts).map(|(v, (_, e))| v * v / e.freedom);
        Self {
            value: parts.iter().map(|(f, e)| f * e.value).sum(),
            standard_error: variance.sqrt(),
            freedom: variance * variance / shares.sum::<f64>(),
        }
    }
}

/// The matrix of products of renders, to which renders are added one by one.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Gram {
    /// Row i has the products of (X_i - R1) with each (X_j - R2).
    rows: Vec<Vec<f64>>,
}

impl Gram {
    /// Adds a render by its products with the earlier ones, (X_new - R1) with each, each with (X_new - R2), and with
    /// itself.
    ///
    /// # Panics
    /// If their numbers differ from that of the earlier renders.
    pub fn push(&mut self, row: Vec<f64>, column: &[f64], own: f64) {
        assert_eq!([row.len(), column.len()], [self.rows.len(); 2]);
        for (row, &product) in self.rows.iter_mut().zip(column) {
            row.push(product);
        }
        let mut row = row;
        row.push(own);
        self.rows.push(row);
    }

    /// The number of renders.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// The squared error of each render.
    pub fn squared_errors(&self) -> Vec<f64> {
        (0..self.count()).map(|i| self.rows[i][i]).collect()
    }

    /// The mean squared error; `None` for less than two renders, as for all estimates.
    pub fn mse(&self) -> Option<Estimate> {
        let moments = Moments::of(self.squared_errors());
        Some(Estimate {
            value: moments.mean(),
            standard_error: moments.standard_error()?,
            freedom: moments.count() as f64 - 1.0,
        })
    }

    /// The variance of a render.
    pub fn variance(&self) -> Option<Estimate> {
        self.jackknife(|i, j| {
            let g = &self.rows;
            0.5 * (g[i][i] + g[j][j] - g[i][j] - g[j][i])
        })
    }

    /// The squared bias of a render. Two renders are a single pair, of whose spread nothing is known but its value.
    pub fn squared_bias(&self) -> Option<Estimate> {
        let n = self.count();
        if n < 2 {
            return None;
        }
        let (mut sums, mut square) = (vec![0.0; n], 0.0);
        for (i, j) in pairs(n) {
            let h = 0.5 * (self.rows[i][j] + self.rows[j][i]);
            sums[i] += h;
            sums[j] += h;
            square += h * h;
        }
        let count = n as f64;
        let pairs = 0.5 * count * (count - 1.0);
        let sum = 0.5 * sums.iter().sum::<f64>();
        let value = sum / pairs;
        if n == 2 {
            return Some(Estimate {
                value,
                standard_error: value.abs(),
                freedom: 1.0,
            });
        }
        // Mean products of pairs that share one render, and of pairs that share none.
        let triples = sums.iter().map(|s| s * s).sum::<f64>() - 2.0 * square;
        let one = triples / (count * (count - 1.0) * (count - 2.0)).max(1.0);
        let apart = 4.0 * sum * sum - 4.0 * (triples + 2.0 * square) + 4.0 * square;
        let none = apart / (count * (count - 1.0) * (count - 2.0) * (count - 3.0)).max(1.0);
        let of_pair = (square / pairs - value * value).max(0.0) * pairs / (pairs - 1.0).max(1.0);
        let of_render = if n > 3 { (one - none).max(0.0) } else { 0.0 };
        let variance = (2.0 * (count - 2.0) * of_render + of_pair) / pairs;
        Some(Estimate {
            value,
            standard_error: variance.sqrt(),
            freedom: count - 1.0,
        })
    }

    /// The mean of a symmetric function of two renders, with its jackknife standard error.
    fn jackknife(&self, f: impl Fn(usize, usize) -> f64) -> Option<Estimate> {
        let n = self.count();
        if n < 2 {
            return None;
        }
        let mut sums = vec![0.0; n];
        for (i, j) in pairs(n) {
            let value = f(i, j);
            sums[i] += value;
            sums[j] += value;
        }
        let count = n as f64;
        let pairs = 0.5 * count * (count - 1.0);
        let sum = 0.5 * sums.iter().sum::<f64>();
        let value = sum / pairs;
        // With two renders, no pair is left without one of them.
        let standard_error = if n == 2 {
            value.abs()
        } else {
            let left = pairs - (count - 1.0);
            let without = Moments::of(sums.iter().map(|own| (sum - own) / left));
            let spread = without.variance()? * (count - 1.0);
            (spread * (count - 1.0) / count).sqrt()
        };
        Some(Estimate {
            value,
            standard_error,
            freedom: count - 1.0,
        })
    }
}

fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (1..n).flat_map(|j| (0..j).map(move |i| (i, j)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::bootstrap::Dealer;
    use crate::study::reference::References;
    use etendue::internals::image::Image;
    use etendue::internals::math::rgb::Rgb;
    use etendue::internals::math::stats::normal_quantile;

    /// Number of pixels of a synthetic image, of which the true value is 1 everywhere.
    const PIXELS: usize = 48;
    const RENDERS: usize = 8;
    /// Standard deviations of a pixel of a render and of a reference.
    const SIGMA: f64 = 0.2;
    const SIGMA_REFERENCE: f64 = 0.05;

    fn picture(dealer: &mut Dealer, mean: f64, sigma: f64) -> Image {
        let mut number = || {
            let uniform = (dealer.below(1 << 40) as f64 + 0.5) / (1_u64 << 40) as f64;
            (mean + sigma * normal_quantile(uniform)) as f32
        };
        let pixels = (0..PIXELS).map(|_| Rgb::new(number(), number(), number()));
        Image::new(PIXELS as u32, 1, pixels.collect())
    }

    fn gram(references: &References, renders: &[Image]) -> Gram {
        let mut gram = Gram::default();
        for (index, new) in renders.iter().enumerate() {
            let earlier = &renders[..index];
            let row = earlier.iter().map(|old| references.product(new, old));
            let column: Vec<f64> = earlier
                .iter()
                .map(|old| references.product(old, new))
                .collect();
            let own = references.product(new, new);
            gram.push(row.collect(), &column, own);
        }
        gram
    }

    /// The estimates of a small simulated study, and the deviation due to the references' noise.
    fn study(dealer: &mut Dealer, bias: f64) -> ([Estimate; 3], f64) {
        let [one, two] = [0; 2].map(|_| picture(dealer, 1.0, SIGMA_REFERENCE));
        let references = References::new(one, two).expect("it is not black");
        let renders: Vec<Image> = (0..RENDERS)
            .map(|_| picture(dealer, 1.0 + bias, SIGMA))
            .collect();
        let gram = gram(&references, &renders);
        let estimates = [gram.mse(), gram.variance(), gram.squared_bias()];
        let deviation = references.noise().product_deviation;
        (estimates.map(|e| e.expect("several renders")), deviation)
    }

    #[test]
    fn estimates_have_expected_means_with_noisy_references() {
        let mut dealer = Dealer::new(1);
        for bias in [0.0, 0.1] {
            let mut means = [Moments::default(); 3];
            for _ in 0..1500 {
                let (estimates, _) = study(&mut dealer, bias);
                for (mean, estimate) in means.iter_mut().zip(estimates) {
                    mean.push(estimate.value);
                }
            }
            // To second order in the noise of r, w = 1 / (r^2 + eps) has the mean 1 + 3 var(r) times that of r = 1, and
            // is correlated with the squared error where there is a bias.
            let noise = 0.5 * SIGMA_REFERENCE * SIGMA_REFERENCE;
            let variance = SIGMA * SIGMA * (1.0 + 3.0 * noise) / 1.01;
            let squared = (bias * bias * (1.0 + 3.0 * noise) + 4.0 * bias * noise) / 1.01;
            for (mean, square) in means.iter().zip([variance + squared, variance, squared]) {
                let error = mean.standard_error().expect("many");
                let off = (mean.mean() - square).abs();
                assert!(
                    off < 5.0 * error + 0.01 * square,
                    "{bias} {mean:?} {square}"
                );
                // Taking one reference as exact would add its variance, which this test would detect.
                assert!(5.0 * error < 0.5 * SIGMA_REFERENCE * SIGMA_REFERENCE);
            }
        }
    }

    #[test]
    fn standard_errors_match_the_spread_of_the_estimates() {
        let mut dealer = Dealer::new(2);
        for bias in [0.0, 0.1] {
            let mut values = [Moments::default(); 3];
            let mut variances = [Moments::default(); 3];
            for _ in 0..1500 {
                let (estimates, deviation) = study(&mut dealer, bias);
                // All renders share the references.
                let shared = [deviation * deviation, 0.0, deviation * deviation];
                for (i, estimate) in estimates.iter().enumerate() {
                    values[i].push(estimate.value);
                    variances[i].push(estimate.standard_error.powi(2) + shared[i]);
                }
            }
            for (i, (value, estimated)) in values.iter().zip(variances).enumerate() {
                let ratio = estimated.mean() / value.variance().expect("many");
                // The variance of 1500 numbers is known to 4 %. With a bias, the error against two references varies
                // with these, too, by 2 b (R - r): that is why the lower limit is lower.
                let least = if bias > 0.0 && i != 1 { 0.5 } else { 0.8 };
                assert!((least..1.25).contains(&ratio), "{bias} {i} {ratio}");
            }
        }
    }

    #[test]
    fn p_values_are_uniform_without_bias_and_small_with_bias() {
        let mut dealer = Dealer::new(3);
        let mut test = |bias: f64| {
            let all = (0..1000).map(|_| {
                let ([_, _, mut squared_bias], deviation) = study(&mut dealer, bias);
                squared_bias.standard_error = squared_bias.standard_error.hypot(deviation);
                squared_bias.p_above_zero()
            });
            all.collect::<Vec<f64>>()
        };
        let none = test(0.0);
        for (level, most) in [(0.5, 0.58), (0.1, 0.14), (0.01, 0.02)] {
            let share = none.iter().filter(|&&p| p < level).count() as f64 / 1000.0;
            assert!(share < most, "{level}: {share}");
        }
        let low = none.iter().filter(|&&p| p < 0.5).count();
        assert!(low > 400, "{low}");
        let found = test(0.15).iter().filter(|&&p| p < 0.001).count();
        assert!(found > 950, "{found}");
    }

    #[test]
    fn single_render_yields_no_estimates() {
        let mut gram = Gram::default();
        gram.push(vec![], &[], 0.5);
        assert_eq!(
            (gram.mse(), gram.variance(), gram.squared_bias()),
            (None, None, None)
        );
        assert_eq!(gram.squared_errors(), [0.5]);
    }

    #[test]
    fn single_pair_of_renders_shows_no_bias() {
        let mut gram = Gram::default();
        gram.push(vec![], &[], 0.5);
        gram.push(vec![0.02], &[0.02], 0.5);
        let bias = gram.squared_bias().expect("two renders");
        assert!(bias.value > 0.0 && bias.p_above_zero() > 0.1, "{bias:?}");
    }
}
