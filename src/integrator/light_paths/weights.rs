//! The MIS weights of the three strategies that find the same path, from ratios in constant memory.
//!
//! On a path x_0 ... x_n from a light to the camera, let e be the density of the ray from x_0 to x_1 on light paths, per
//! unit of étendue; p_i that of continuing from x_i towards the camera, per steradian, and q_i towards the light; and c
//! the density of the camera's rays per steradian, over the number of light paths for each. Squared distances cancel:
//!
//!   p_t / p_0 = e r_1 r_2 ... r_{n-1} d^2 / c,   r_i = (p_i / q_i) |cos_light| / |cos_camera|,   p_{n-1} = 1,
//!
//! with the cosines between the geometric normal and both directions, and d between x_{n-1} and x_n. Light sampling, with
//! the density l of the direction from x_1, has p_t / p_1 = (p_t / p_0) q_1 / l. A camera path carries the product from
//! the camera on, a light path the reciprocal one from the light on; each strategy then has its own weight where its path
//! is complete. At a delta lobe r_i is 1, or 0 if a light path cannot find it.
//!
//! A light that no ray can hit has p_0 = 0; e is then per unit of area across the ray at x_1 instead, and l the
//! probability of selecting the light.
//!
//! Measure: ratios of densities of the whole path.
//! Range: any densities of at least 0; those of the strategy itself are above 0.
//! Source: Georgiev et al. 2012, section 4.4, without connections of surfaces and without merging; Veach and Guibas 1995
//! for the power heuristic. Tested below and in `tests/rendering/light_paths.rs`.

use crate::sampling::mis::power_heuristic_with_third;

/// The upper limit of the second moment of camera paths alone, which is infinite where no camera path finds the light.
const MISSED: f64 = 1e12;

/// One direction at a scattering vertex: the density of continuing along it, and its cosine with the geometric normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionPdf {
    /// The density of continuing, per steradian.
    pub pdf: f32,
    /// The cosine; only its absolute value counts.
    pub cos: f32,
}

/// The factor of a vertex in the ratio of the density of a path traced from the other end to that of this path:
/// `reverse` is the direction back along this path, `forward` the direction in which it continues. Free of branches.
#[inline(always)]
pub fn vertex_ratio(reverse: DirectionPdf, forward: DirectionPdf) -> f32 {
    (reverse.pdf / forward.pdf) * (forward.cos / reverse.cos).abs()
}

/// The ratio d^2 / c for the surface that the camera sees: `over_film_density` is the number of light paths for each
/// camera path, over their density on the film, `per_steradian` the film area per steradian.
#[inline(always)]
pub fn camera_vertex_ratio(over_film_density: f32, distance2: f32, per_steradian: f32) -> f32 {
    over_film_density * distance2 / per_steradian
}

/// The densities of scattering and of light sampling over that of a light path, for a path from a light up to its last
/// surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightRatios {
    /// p_0 / p_t.
    pub by_scattering: f32,
    /// p_1 / p_t.
    pub by_nee: f32,
}

impl LightRatios {
    /// The ratios before the first surface: the density `e` of the ray, which can be hit from the other end or not. That of
    /// light sampling still lacks its density.
    #[inline]
    pub fn new(e: f32, can_be_hit: bool) -> Self {
        Self {
            by_scattering: if can_be_hit { 1.0 / e } else { 0.0 },
            by_nee: 1.0 / e,
        }
    }

    /// The ratios beyond a surface. At the first one, the density of light sampling is `l`.
    #[inline]
    pub fn after_vertex(
        self,
        to_light: DirectionPdf,
        to_camera: DirectionPdf,
        l: Option<f32>,
    ) -> Self {
        let by_light_sampling = DirectionPdf {
            pdf: l.unwrap_or(to_light.pdf),
            ..to_light
        };
        Self {
            by_scattering: self.by_scattering * vertex_ratio(to_light, to_camera),
            by_nee: self.by_nee * vertex_ratio(by_light_sampling, to_camera),
        }
    }

    /// The ratios beyond a surface that scatters by a delta lobe, which light sampling cannot do.
    #[inline]
    pub fn after_delta_vertex(self, is_first: bool) -> Self {
        Self {
            by_nee: if is_first { 0.0 } else { self.by_nee },
            ..self
        }
    }

    /// The weight of the light path, where the ratio of its last surface and the camera is [`camera_vertex_ratio`].
    #[inline]
    pub fn weight(self, camera_vertex_ratio: f32) -> f32 {
        let Self {
            by_scattering,
            by_nee,
        } = self;
        power_heuristic_with_third(
            power_heuristic_with_third(1.0, by_scattering / camera_vertex_ratio),
            by_nee / camera_vertex_ratio,
        )
    }

    /// The second moment of the estimator of camera paths alone, minus that of the three strategies, in units of the squared
    /// unweighted contribution of the light path.
    ///
    /// A path of contribution f, which the strategies find with the densities p_i and the weights w_i, adds the sum of
    /// w_i^2 f^2 / p_i to the second moment. An estimate of its integral by light paths, which find the rare bright paths
    /// often, does not suffer from what makes an estimate by camera paths unreliable.
    #[inline]
    pub fn gain(self, camera_vertex_ratio: f32) -> f32 {
        let [a, b] =
            [self.by_scattering, self.by_nee].map(|ratio| f64::from(ratio / camera_vertex_ratio));
        let (squares, cubes) = (a * a + b * b, a * a * a + b * b * b);
        let without = if squares > 0.0 {
            cubes / (squares * squares)
        } else {
            MISSED
        };
        let with = (1.0 + cubes) / ((1.0 + squares) * (1.0 + squares));
        (without.min(MISSED) - with) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::hash;

    /// A uniform number in (0.01, 1).
    fn number(seed: &mut u64) -> f32 {
        *seed = hash::combine(*seed, 1);
        0.01 + 0.99 * (*seed >> 40) as f32 / 16_777_216.0
    }

    /// A path that all strategies find.
    struct Path {
        /// The density of the first ray of a light path.
        e: f32,
        /// The density of light sampling at the first surface.
        l: f32,
        camera_vertex_ratio: f32,
        can_be_hit: bool,
        /// The directions to the light and to the camera at each surface from the light on, and whether its lobe is a delta
        /// lobe. The last surface is connected to the lens, and has none.
        surfaces: Vec<(DirectionPdf, DirectionPdf, bool)>,
    }

    impl Path {
        /// A random path of this many surfaces.
        fn random(surfaces: usize, seed: &mut u64) -> Self {
            let (e, l, camera_vertex_ratio) =
                (number(seed), number(seed), number(seed) / number(seed));
            let can_be_hit = number(seed) > 0.3;
            let surface = |i: usize| {
                let is_last = i + 1 == surfaces;
                let mut end = || DirectionPdf {
                    pdf: number(seed),
                    cos: number(seed),
                };
                let (to_light, mut to_camera) = (end(), end());
                if is_last {
                    to_camera.pdf = 1.0;
                }
                (to_light, to_camera, !is_last && number(seed) < 0.3)
            };
            Self {
                e,
                l,
                camera_vertex_ratio,
                can_be_hit,
                surfaces: (0..surfaces).map(surface).collect(),
            }
        }

        /// The weight of the light path.
        fn weight_by_light_path(&self) -> f32 {
            let mut ratios = LightRatios::new(self.e, self.can_be_hit);
            for (i, &(to_light, to_camera, is_delta)) in self.surfaces.iter().enumerate() {
                ratios = if is_delta {
                    ratios.after_delta_vertex(i == 0)
                } else {
                    ratios.after_vertex(to_light, to_camera, (i == 0).then_some(self.l))
                };
            }
            ratios.weight(self.camera_vertex_ratio)
        }

        /// The weights of the camera path that is scattered to the light, and of that which samples it.
        fn weights_from_camera(&self) -> [f32; 2] {
            let mut ratio = self.camera_vertex_ratio;
            for &(to_light, to_camera, is_delta) in self.surfaces[1..].iter().rev() {
                ratio *= if is_delta {
                    1.0
                } else {
                    vertex_ratio(to_camera, to_light)
                };
            }
            let (e, l) = (self.e, self.l);
            let (to_light, to_camera, is_delta) = self.surfaces[0];
            let q = to_light.pdf;
            let last = if is_delta {
                1.0
            } else {
                vertex_ratio(to_camera, to_light)
            };
            let nee_over_scattering = if is_delta { 0.0 } else { l / q };
            let mut by_scattering = 0.0;
            if self.can_be_hit {
                let among_two = 1.0 / (1.0 + nee_over_scattering * nee_over_scattering);
                by_scattering = power_heuristic_with_third(among_two, e * ratio * last);
            }
            let mut by_nee = 0.0;
            if !is_delta {
                let scattering_over_nee = if self.can_be_hit { q / l } else { 0.0 };
                let among_two = 1.0 / (1.0 + scattering_over_nee * scattering_over_nee);
                let at_light = vertex_ratio(to_camera, DirectionPdf { pdf: l, ..to_light });
                by_nee = power_heuristic_with_third(among_two, e * ratio * at_light);
            }
            [by_scattering, by_nee]
        }
    }

    /// Random paths of up to eight surfaces, some with delta lobes and some from lights that cannot be hit.
    #[test]
    fn mis_weights_of_the_three_strategies_sum_to_one() {
        let seed = &mut 7;
        for index in 0..1_000_000 {
            let path = Path::random(1 + index % 8, seed);
            let [by_scattering, by_nee] = path.weights_from_camera();
            let sum = path.weight_by_light_path() + by_scattering + by_nee;
            assert!((sum - 1.0).abs() < 1e-4, "{index}: {sum}");
        }
    }

    /// The gain is the difference of the second moments by their definition, sum of w_i^2 / p_i, with p_t = 1.
    #[test]
    fn light_path_gain_is_the_second_moment_reduction() {
        let seed = &mut 11;
        for _ in 0..10_000 {
            let [a, b, camera_vertex_ratio] =
                [0; 3].map(|_| 1.0 / number(seed) - 1.0 + number(seed));
            let ratios = LightRatios {
                by_scattering: a,
                by_nee: b,
            };
            let p = [
                f64::from(a / camera_vertex_ratio),
                f64::from(b / camera_vertex_ratio),
                1.0,
            ];
            let moment = |p: &[f64]| {
                let squares: f64 = p.iter().map(|p| p * p).sum();
                p.iter().map(|p| (p * p / squares).powi(2) / p).sum::<f64>()
            };
            let expected = moment(&p[..2]) - moment(&p);
            let gain = f64::from(ratios.gain(camera_vertex_ratio));
            assert!((gain - expected).abs() < 1e-5 * moment(&p[..2]).max(1.0));
        }
        let missed = LightRatios {
            by_scattering: 0.0,
            by_nee: 0.0,
        };
        assert!(missed.gain(1.0) > 1e11);
    }
}
