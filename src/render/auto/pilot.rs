//! The inefficiency of integrators, measured on small images of a scene: two by each, with different random numbers.
//!
//! Half of the squared difference of two independent images a and b is, on average, the squared error of each; that
//! needs no error bars and holds for Markov chains, too. Relative to t, the median of all images around a pixel,
//!
//!   relMSE = mean of (a - b)^2 / 2 / (t^2 + eps),
//!
//! where eps is a hundredth of the square of the mean of all images.
//!
//! Light that is so rare that an integrator has hardly found it does not show in the variance. So where its images lack
//! light that those of bidirectional path tracing have, in whole tiles and significantly, that is counted as its error,
//! too.
//!
//! Work is counted in rays, each of which stands for what an integrator does between two of them, so that neither the
//! machine nor its load has an influence.
//!
//! Measure: relMSE of one image; rays of `path`; their product is the inefficiency.
//! Range: images of the same size.
//! Source: docs/accuracy.md, "Which integrator". Tested below and in `tests/rendering/auto.rs`.

use super::rule::Candidate;
use crate::image::Image;
use crate::image::tiles::ImageTile;
use crate::integrator::kind::IntegratorKind;
use crate::math::rgb::Rgb;
use crate::planted::planted;

/// The radius of the surroundings that give the reference of a pixel, in pixels.
const REACH: u32 = 2;

/// The cost of a ray of bidirectional path tracing, with all the work for it, relative to one of `path`. In the scenes
/// of docs/accuracy.md it took 1.3 to 1.8 times as long.
const BIDIRECTIONAL_RAY: f64 = 1.5;

/// The cost of a ray of Markov chains, likewise: it took 1.75 to 2.75 times as long.
const METROPOLIS_RAY: f64 = 2.2;

/// The side of the tiles in which light may be lacking, in pixels.
const SIDE: u32 = 8;

/// The number of standard errors by which a tile has to differ to count.
const SIGMAS: f64 = 4.0;

/// The pilot of one integrator.
#[derive(Debug, Clone, PartialEq)]
pub struct Pilot {
    /// The integrator.
    pub integrator: IntegratorKind,
    /// Two independent images.
    pub images: [Image; 2],
    /// The number of rays of one of them.
    pub rays: f64,
}

impl Pilot {
    /// The work of one of its images, in rays of `path`.
    fn work(&self) -> f64 {
        let of_ray = match self.integrator {
            IntegratorKind::Bidirectional => BIDIRECTIONAL_RAY,
            IntegratorKind::Metropolis => METROPOLIS_RAY,
            _ => 1.0,
        };
        of_ray * self.rays
    }
}

/// The inefficiency of each integrator.
pub fn inefficiencies(pilots: &[Pilot]) -> Vec<Candidate> {
    let truth = ReferenceImage::of(pilots);
    let by = |kind| pilots.iter().find(|it| it.integrator == kind);
    let bidirectional = by(IntegratorKind::Bidirectional);
    let of_one = |pilot: &Pilot| {
        let others = bidirectional.filter(|it| it.integrator != pilot.integrator);
        let of_other =
            |other| planted!("missed-light-is-no-error", 0.0, truth.lacking(pilot, other));
        let lacking = others.map_or(0.0, of_other);
        // Black images give no information.
        let is_black = pilot.images.iter().all(|it| it.mean() == [0.0; 3]);
        Candidate {
            integrator: pilot.integrator,
            inefficiency: if is_black {
                f64::INFINITY
            } else {
                (truth.spread(pilot) + lacking) * pilot.work()
            },
        }
    };
    pilots.iter().map(of_one).collect()
}

/// The reference image, from all pilots.
struct ReferenceImage {
    image: Image,
    epsilon: f64,
}

impl ReferenceImage {
    /// The median of the surroundings of each pixel in all images, so that a rare bright sample is not its own
    /// reference.
    fn of(pilots: &[Pilot]) -> Self {
        let images: Vec<&Image> = pilots.iter().flat_map(|pilot| &pilot.images).collect();
        let (width, height) = (images[0].width(), images[0].height());
        let near = |x: u32, length: u32| x.saturating_sub(REACH)..(x + REACH + 1).min(length);
        let around = |(x, y)| {
            let (columns, rows) = (near(x, width), near(y, height));
            let places = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
            let values = places.flat_map(|(x, y)| images.iter().map(move |it| it.get(x, y)));
            let values: Vec<[f32; 3]> = values.map(Rgb::to_array).collect();
            Rgb::from([0, 1, 2].map(|c| median(values.iter().map(|value| value[c]).collect())))
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let image = Image::new(width, height, places.map(around).collect());
        let sum: f64 = images.iter().flat_map(|it| it.mean()).sum();
        let mean = sum / (3 * images.len()) as f64;
        Self {
            image,
            epsilon: 0.01 * mean * mean,
        }
    }

    /// The factors that make squares of the channels of a pixel or a tile relative, by its colour.
    fn scale(&self, colour: [f64; 3]) -> [f64; 3] {
        colour.map(|t| 1.0 / (t * t + self.epsilon))
    }

    /// The relMSE of one image of a pilot, by the difference of both.
    fn spread(&self, pilot: &Pilot) -> f64 {
        let sum: f64 = (0..self.image.pixels().len())
            .map(|index| {
                let scale = self.scale(self.image.pixels()[index].to_array().map(f64::from));
                let variance = variance(pilot, index);
                (0..3).map(|c| scale[c] * variance[c]).sum::<f64>()
            })
            .sum();
        sum / (3 * self.image.pixels().len()) as f64
    }

    /// The relMSE of the light that a pilot lacks in tiles where another has it.
    fn lacking(&self, pilot: &Pilot, other: &Pilot) -> f64 {
        let (width, height) = (self.image.width(), self.image.height());
        let mut sum = 0.0;
        for tile in ImageTile::all(width, height, SIDE) {
            let of_truth = mean(&self.image, tile);
            let scale = self.scale(of_truth);
            let [own, others] = [pilot, other].map(|it| {
                let [a, b] = [0, 1].map(|i| mean(&it.images[i], tile));
                std::array::from_fn::<f64, 3, _>(|c| 0.5 * (a[c] + b[c]))
            });
            let noise = [pilot, other].map(|it| variance_of_tile(it, tile));
            let pixels = f64::from(tile.width) * f64::from(tile.height);
            for c in 0..3 {
                let lacks = others[c] - own[c];
                let error = (noise[0][c] + noise[1][c]).sqrt();
                if lacks > SIGMAS * error {
                    sum += pixels * scale[c] * lacks * lacks;
                }
            }
        }
        sum / (3 * self.image.pixels().len()) as f64
    }
}

/// The median of some numbers, the upper one of two.
fn median(mut numbers: Vec<f32>) -> f32 {
    let middle = numbers.len() / 2;
    *numbers.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// The variance of an image's channels at a pixel.
fn variance(pilot: &Pilot, index: usize) -> [f64; 3] {
    let [a, b] = [0, 1].map(|i| pilot.images[i].pixels()[index].to_array().map(f64::from));
    std::array::from_fn(|c| 0.5 * (a[c] - b[c]).powi(2))
}

/// The variance of the mean of both images over a tile, whose pixels are taken as independent.
fn variance_of_tile(pilot: &Pilot, tile: ImageTile) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let mut count = 0.0;
    for index in tile.indices(pilot.images[0].width()) {
        for (sum, variance) in sum.iter_mut().zip(variance(pilot, index)) {
            *sum += 0.5 * variance;
        }
        count += 1.0;
    }
    sum.map(|sum| sum / (count * count))
}

/// The mean of an image's channels over a tile.
fn mean(image: &Image, tile: ImageTile) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let mut count = 0.0;
    for index in tile.indices(image.width()) {
        for (sum, x) in sum.iter_mut().zip(image.pixels()[index].to_array()) {
            *sum += f64::from(x);
        }
        count += 1.0;
    }
    sum.map(|sum| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (64, 48);

    /// Images of `light`, where a pixel is `light` over `p` with probability `p`, else black.
    fn pilot(integrator: IntegratorKind, light: f32, p: f32, rays: f64, seed: u64) -> Pilot {
        use crate::sampler::hash;
        let image = |index: u64| {
            let pixel = |place: u64| {
                let bits = hash::combine(hash::combine(seed, index), place) >> 40;
                let is_met = (bits as f32) < p * 16_777_216.0;
                Rgb::grey(if is_met { light / p } else { 0.0 })
            };
            let pixels = (0..u64::from(SIZE.0 * SIZE.1)).map(pixel).collect();
            Image::new(SIZE.0, SIZE.1, pixels)
        };
        Pilot {
            integrator,
            images: [image(0), image(1)],
            rays,
        }
    }

    #[test]
    fn inefficiency_ratio_matches_the_closed_form() {
        use IntegratorKind::{Bidirectional, Path};
        // The relative variance of a pixel that is lit with probability p is (1 - p) / p.
        let pilots = [
            pilot(Path, 2.0, 0.7, 10.0, 1),
            pilot(Bidirectional, 2.0, 0.9, 20.0, 2),
        ];
        let [path, other] = inefficiencies(&pilots)[..] else {
            panic!("one for each");
        };
        let ratio = path.inefficiency / other.inefficiency;
        // A standard error of 4 %.
        let exact = (0.3 / 0.7) / (0.1 / 0.9) * 10.0 / (20.0 * BIDIRECTIONAL_RAY);
        assert!((ratio / exact - 1.0).abs() < 0.2, "{ratio} {exact}");
    }

    #[test]
    fn light_missed_by_path_counts_towards_its_inefficiency() {
        use IntegratorKind::{Bidirectional, Path};
        let dark = pilot(Path, 1.0, 1.0, 10.0, 1);
        let other = |light| pilot(Bidirectional, light, 0.8, 20.0, 2);
        let of_path = |light| inefficiencies(&[dark.clone(), other(light)])[0].inefficiency;
        // Equal means: nothing is lacking.
        assert_eq!(of_path(1.0), 0.0);
        // Half of the light is lacking, 1 beside the other's 2 / 0.8 in most of its pixels: the median is in between,
        // or 1.
        let of_path = of_path(2.0);
        assert!((10.0 / (2.5 * 2.5)..=10.0).contains(&of_path), "{of_path}");
    }

    #[test]
    fn black_pilot_images_have_infinite_inefficiency() {
        let black = pilot(IntegratorKind::Path, 0.0, 0.5, 10.0, 1);
        assert_eq!(inefficiencies(&[black])[0].inefficiency, f64::INFINITY);
    }
}
