//! A floor in two dimensions beside a mirror, whose light is found in three ways, with exact moments of their estimates.
//!
//! Measure: the mean irradiance of a pixel, a segment of the floor at height 0, over that under a sky of radiance 1. A lamp
//! at height 1 faces down, of radiance 1 / width; a mirror at x = 1 stands on the floor and reaches up to `MIRROR_HEIGHT`.
//! Range: pixels to the left of the mirror; a lamp narrower than 1.
//! Source: Veach 1997, "Robust Monte Carlo Methods for Light Transport Simulation", section 9.2 (multi-sample estimator,
//! power heuristic); exact values by quadrature. Tested through the lesson, in `lab/tests/reports/lesson.rs`.

use super::shared_floor::unoccluded;
use super::uniform::Uniform;

/// The position of the mirror.
const MIRROR: f64 = 1.0;

/// The height of the mirror. Light that it reflects arrives at x > 0.
const MIRROR_HEIGHT: f64 = 0.5;

/// Points of the quadrature in each dimension.
const POINTS: usize = 256;

/// A way to find a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LampStrategy {
    /// A camera path scatters and hits the lamp: s = 0.
    Scattering,
    /// A camera path samples a point of the lamp: s = 1, next event estimation.
    LightSampling,
    /// A path leaves the lamp and hits the pixel: t = 1.
    LightPath,
}

impl LampStrategy {
    pub(super) const ALL: [Self; 3] = [Self::Scattering, Self::LightSampling, Self::LightPath];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Scattering => "scattering",
            Self::LightSampling => "light sampling",
            Self::LightPath => "light paths",
        }
    }
}

/// The way of the light from the lamp to the floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Route {
    Direct,
    /// A path by way of the mirror: a caustic.
    Mirrored,
}

/// A pixel with the strategies that find its light.
#[derive(Debug, Clone)]
pub(super) struct Pixel {
    /// The left end of the segment, and its width.
    pub(super) left: f64,
    pub(super) width: f64,
    /// The width of the lamp, whose centre is at x = 0.
    pub(super) lamp: f64,
    /// The strategies, each weighted against the others.
    pub(super) used: Vec<LampStrategy>,
    /// The number of light paths for the pixel's camera path.
    pub(super) light_paths: usize,
    /// The number of light paths that the weights assume: any other than the true one is a mistake.
    pub(super) weighted_as: usize,
}

impl Pixel {
    /// The density, per length of the floor, with which a path from the point `t` of the lamp arrives at `x`. That of a
    /// camera path from `x` at `t`, per length of the lamp, is the same.
    fn density(x: f64, t: f64, route: Route) -> f64 {
        match route {
            Route::Direct => unoccluded(x, t),
            Route::Mirrored => {
                let image = 2.0 * MIRROR - t;
                let height = (MIRROR - x) / (image - x);
                if height < MIRROR_HEIGHT {
                    unoccluded(x, image)
                } else {
                    0.0
                }
            }
        }
    }

    /// The density of a path by a strategy, times its number of samples.
    fn sampled(&self, strategy: LampStrategy, g: f64, route: Route, light_paths: usize) -> f64 {
        match strategy {
            LampStrategy::Scattering => g / self.width,
            LampStrategy::LightSampling if route == Route::Mirrored => 0.0,
            LampStrategy::LightSampling => 1.0 / (self.width * self.lamp),
            LampStrategy::LightPath => light_paths as f64 * g / self.lamp,
        }
    }

    /// The weight of a strategy for a path, by the power heuristic.
    fn weight(&self, strategy: LampStrategy, g: f64, route: Route) -> f64 {
        let square = |strategy| self.sampled(strategy, g, route, self.weighted_as).powi(2);
        let all: f64 = self.used.iter().map(|&other| square(other)).sum();
        square(strategy) / all
    }

    /// The contribution of a path that a strategy has found.
    fn contribution(&self, strategy: LampStrategy, x: f64, t: f64, route: Route) -> f64 {
        let g = Self::density(x, t, route);
        if g == 0.0 {
            return 0.0;
        }
        let light = g / (self.lamp * self.width);
        let sampled = self.sampled(strategy, g, route, self.light_paths);
        self.weight(strategy, g, route) * light / sampled
    }

    /// One estimate by a strategy, which draws its own point of the pixel or, for light paths, of the lamp.
    pub(super) fn estimate_by(&self, strategy: LampStrategy, uniform: &mut Uniform) -> f64 {
        let mut on_floor = || self.left + self.width * uniform.double();
        match strategy {
            LampStrategy::LightSampling => {
                let x = on_floor();
                let t = self.lamp * (uniform.double() - 0.5);
                self.contribution(strategy, x, t, Route::Direct)
            }
            LampStrategy::Scattering => {
                let x = on_floor();
                let arrival = x + tangent(uniform);
                let is_lamp = |t: f64| t.abs() < 0.5 * self.lamp;
                let image = 2.0 * MIRROR - arrival;
                if is_lamp(arrival) {
                    self.contribution(strategy, x, arrival, Route::Direct)
                } else if is_lamp(image) {
                    self.contribution(strategy, x, image, Route::Mirrored)
                } else {
                    0.0
                }
            }
            LampStrategy::LightPath => {
                let mut sum = 0.0;
                for _ in 0..self.light_paths {
                    let t = self.lamp * (uniform.double() - 0.5);
                    let arrival = t + tangent(uniform);
                    let (x, route) = match arrival < MIRROR {
                        true => (arrival, Route::Direct),
                        false => (2.0 * MIRROR - arrival, Route::Mirrored),
                    };
                    if (self.left..self.left + self.width).contains(&x) {
                        sum += self.contribution(strategy, x, t, route);
                    }
                }
                sum
            }
        }
    }

    /// One estimate of the pixel: the sum over its strategies.
    pub(super) fn estimate(&self, uniform: &mut Uniform) -> f64 {
        let all = self.used.iter();
        all.map(|&strategy| self.estimate_by(strategy, uniform))
            .sum()
    }

    /// The integral of a function of the path over the pixel, the lamp and both routes; it is given g.
    fn integral(&self, f: impl Fn(f64, Route) -> f64) -> f64 {
        let midpoint = |i: usize| (i as f64 + 0.5) / POINTS as f64;
        let mut sum = 0.0;
        for i in 0..POINTS {
            let x = self.left + self.width * midpoint(i);
            for j in 0..POINTS {
                let t = self.lamp * (midpoint(j) - 0.5);
                for route in [Route::Direct, Route::Mirrored] {
                    let g = Self::density(x, t, route);
                    if g > 0.0 {
                        sum += f(g, route);
                    }
                }
            }
        }
        sum * self.width * self.lamp / (POINTS * POINTS) as f64
    }

    /// The exact light of the pixel.
    pub(super) fn light(&self) -> f64 {
        self.integral(|g, _| g / (self.lamp * self.width))
    }

    /// The exact mean of the estimates by a strategy: the light that it finds, by its weight.
    pub(super) fn mean_by(&self, strategy: LampStrategy) -> f64 {
        self.integral(|g, route| self.weight(strategy, g, route) * g / (self.lamp * self.width))
    }

    /// The exact variance of an estimate of the pixel.
    pub(super) fn variance(&self) -> f64 {
        let of_strategy = |&strategy: &LampStrategy| {
            let samples = match strategy {
                LampStrategy::LightPath => self.light_paths as f64,
                _ => 1.0,
            };
            let squares = self.integral(|g, route| {
                let sampled = self.sampled(strategy, g, route, self.light_paths);
                let weighted = self.weight(strategy, g, route) * g / (self.lamp * self.width);
                match sampled {
                    0.0 => 0.0,
                    _ => weighted * weighted / sampled,
                }
            });
            squares - self.mean_by(strategy).powi(2) / samples
        };
        self.used.iter().map(of_strategy).sum()
    }
}

/// The tangent of a cosine-weighted direction.
fn tangent(uniform: &mut Uniform) -> f64 {
    let sine = 2.0 * uniform.double() - 1.0;
    sine / (1.0 - sine * sine).sqrt()
}
