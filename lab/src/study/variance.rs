//! The sources of the variance of a sample, by the length of paths and by the technique that found the light.
//!
//! A sample is a sum X = sum_k X_k over classes of paths, so that Var X = sum_k Cov(X_k, X) exactly: that is the share
//! of each class. It may be negative, for a class that compensates for others.
//!
//! Measure: shares of the variance of one sample, relative as relMSE is, and of the light.
//! Range: integrators that report their paths. Each sample is treated on its own: the variance that evenly distributed
//! points save is not included.
//! Source: the covariance is linear. Tested below and in `lab/tests/reports/study.rs`.

use super::prepared_scene::PreparedScene;
use super::reference::References;
use super::variant::Variant;
use etendue::internals::bsdf::types::Lobe;
use etendue::internals::film::Film;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::observer::PathObserver;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec3;
use etendue::internals::render::observe_tile;
use rayon::prelude::*;
use serde::Serialize;

/// Number of scattering events that are distinguished; paths with as many or more form one class.
const LONGEST: usize = 5;

/// Number of classes: seen directly; then by scattering events, each found by BSDF sampling and by light sampling.
const CLASSES: usize = 1 + 2 * LONGEST;

/// Number of parts of the image, for the standard errors of the shares.
const PARTS: usize = 16;

/// Edge of the tiles that form the parts, in pixels.
const TILE: u32 = 8;

/// The sources of the variance of a sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathShares {
    /// Samples per pixel that were observed.
    pub spp: u64,
    /// The relative variance of one sample.
    pub variance: f64,
    /// The part of the variance that the classes do not explain: 0 except for rounding.
    pub unexplained: f64,
    /// The classes that occur.
    pub classes: Vec<ClassShare>,
}

/// The contribution of one class of paths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ClassShare {
    /// Scattering events; the last class has longer ones, too.
    pub bounces: usize,
    /// The technique that found the light.
    pub found: LightFoundBy,
    /// Its share of the variance.
    pub variance: f64,
    /// The standard error of `variance`.
    pub variance_error: f64,
    /// Its share of the light.
    pub energy: f64,
}

/// The technique by which a path found its light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightFoundBy {
    /// A camera ray hit the light.
    Seen,
    /// An extension ray hit the light.
    Scattering,
    /// A shadow ray to a sampled light.
    LightSampling,
}

/// Whether this is the class that includes all longer paths.
pub fn is_longest(bounces: usize) -> bool {
    bounces == LONGEST
}

/// Observes `spp` samples of each pixel; `None` for an integrator that does not report its paths, takes parts of them
/// from a cache, or splats to other pixels than its sample's own.
pub fn path_shares(
    prepared: &PreparedScene,
    variant: &Variant,
    references: &References,
    spp: u64,
    seed: u64,
) -> Option<PathShares> {
    let settings = prepared.settings(variant, spp, seed);
    if settings.integrator == IntegratorKind::IrradianceCache || settings.splats() {
        return None;
    }
    let scene = prepared.scene(variant.options);
    let mut film = Film::new(settings.window, TILE);
    let width = prepared.size().0 as usize;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .ok()?;
    let watch = |(index, tile): (usize, &mut etendue::internals::film::Tile)| {
        let place = |[x, y]: [u32; 2]| y as usize * width + x as usize;
        let weights = references.weights();
        let weights = tile.window.pixels().map(|pixel| weights[place(pixel)]);
        let mut observer = Splitter::new(spp, weights.collect());
        observe_tile(
            scene,
            prepared.filter(),
            &settings,
            None,
            tile,
            0..spp,
            &mut observer,
        );
        (index % PARTS, observer.sums)
    };
    let tiles: Vec<(usize, Sums)> = pool.install(|| {
        let tiles = film.tiles_mut().par_iter_mut().enumerate();
        tiles.map(watch).collect()
    });
    let mut parts = vec![Sums::default(); PARTS];
    for (part, sums) in &tiles {
        parts[*part].add(sums);
    }
    shares(&parts, spp)
}

/// Computes the shares, with the jackknife over parts of the image.
fn shares(parts: &[Sums], spp: u64) -> Option<PathShares> {
    let total = |without: Option<usize>| {
        let mut all = Sums::default();
        let kept = parts.iter().enumerate();
        for (_, part) in kept.filter(|(index, _)| Some(*index) != without) {
            all.add(part);
        }
        all
    };
    let all = total(None);
    if all.variance <= 0.0 || all.pixels == 0 {
        return None;
    }
    let leaving: Vec<Sums> = (0..parts.len()).map(|part| total(Some(part))).collect();
    let light: f64 = all.energy.iter().sum();
    let class = |k: usize| {
        let share = |sums: &Sums| sums.covariance[k] / sums.variance;
        let value = share(&all);
        let count = leaving.len() as f64;
        let squares: f64 = leaving
            .iter()
            .map(|sums| (share(sums) - value).powi(2))
            .filter(|square| square.is_finite())
            .sum();
        ClassShare {
            bounces: k.div_ceil(2),
            found: match k {
                0 => LightFoundBy::Seen,
                _ if k % 2 == 1 => LightFoundBy::Scattering,
                _ => LightFoundBy::LightSampling,
            },
            variance: value,
            variance_error: (squares * (count - 1.0) / count).sqrt(),
            energy: all.energy[k] / light,
        }
    };
    let classes: Vec<ClassShare> = (0..CLASSES)
        .filter(|&k| all.energy[k] != 0.0)
        .map(class)
        .collect();
    let explained: f64 = classes.iter().map(|class| class.variance).sum();
    Some(PathShares {
        spp,
        variance: all.variance / (3 * all.pixels) as f64,
        unexplained: 1.0 - explained,
        classes,
    })
}

/// Sums over pixels.
#[derive(Debug, Clone, Default)]
struct Sums {
    pixels: u64,
    variance: f64,
    covariance: [f64; CLASSES],
    energy: [f64; CLASSES],
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.variance += other.variance;
        for k in 0..CLASSES {
            self.covariance[k] += other.covariance[k];
            self.energy[k] += other.energy[k];
        }
    }
}

/// Sums over the samples of one pixel, by channel.
#[derive(Debug, Clone, Default)]
struct PixelSums {
    count: f64,
    /// The sums of X and X^2.
    whole: [[f64; 2]; 3],
    /// The sums of X_k and X_k X.
    classes: [[[f64; 2]; CLASSES]; 3],
}

/// An observer that splits samples into classes. The pixels of a tile follow one another, each with all of its samples.
struct Splitter {
    spp: u64,
    weights: Vec<[f64; 3]>,
    pixel: usize,
    seen: u64,
    bounces: usize,
    sample: [Rgb; CLASSES],
    sums: Sums,
    of_pixel: PixelSums,
}

impl Splitter {
    fn new(spp: u64, weights: Vec<[f64; 3]>) -> Self {
        Self {
            spp,
            weights,
            pixel: 0,
            seen: 0,
            bounces: 0,
            sample: [Rgb::BLACK; CLASSES],
            sums: Sums::default(),
            of_pixel: PixelSums::default(),
        }
    }

    /// Adds light that a camera or extension ray hit.
    fn met(&mut self, contribution: Rgb) {
        let class = match self.bounces.min(LONGEST) {
            0 => 0,
            bounces => 2 * bounces - 1,
        };
        self.sample[class] += contribution;
    }

    fn take(&mut self, value: Rgb) {
        let sums = &mut self.of_pixel;
        sums.count += 1.0;
        let value = value.to_array().map(f64::from);
        for (c, x) in value.into_iter().enumerate() {
            sums.whole[c][0] += x;
            sums.whole[c][1] += x * x;
            for (k, part) in self.sample.iter().enumerate() {
                let part = f64::from(part.to_array()[c]);
                sums.classes[c][k][0] += part;
                sums.classes[c][k][1] += part * x;
            }
        }
    }

    fn finish_pixel(&mut self) {
        let pixel = std::mem::take(&mut self.of_pixel);
        let n = pixel.count;
        let weights = self.weights.get(self.pixel).copied().unwrap_or_default();
        self.pixel += 1;
        self.seen = 0;
        if n < 2.0 {
            return;
        }
        self.sums.pixels += 1;
        for (c, weight) in weights.into_iter().enumerate() {
            let [x, xx] = pixel.whole[c];
            let scale = weight / (n - 1.0);
            self.sums.variance += scale * (xx - x * x / n);
            for k in 0..CLASSES {
                let [part, product] = pixel.classes[c][k];
                self.sums.covariance[k] += scale * (product - part * x / n);
                self.sums.energy[k] += part / n;
            }
        }
    }
}

impl PathObserver for Splitter {
    fn environment(&mut self, contribution: Rgb) {
        self.met(contribution);
    }

    fn emission(&mut self, contribution: Rgb, _weight: f32) {
        self.met(contribution);
    }

    fn light(&mut self, contribution: Rgb, _weight: f32, visible: f32) {
        if visible > 0.0 {
            let bounces = (self.bounces + 1).min(LONGEST);
            self.sample[2 * bounces] += contribution * visible;
        }
    }

    fn scattered(&mut self, _wi: Vec3, _lobe: Lobe, _beta: Rgb) {
        self.bounces += 1;
    }

    fn filmed(&mut self, value: Rgb) {
        if value.is_finite() {
            self.take(value);
        }
        self.bounces = 0;
        self.sample = [Rgb::BLACK; CLASSES];
        self.seen += 1;
        if self.seen == self.spp {
            self.finish_pixel();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample with light seen directly and light found by light sampling, both random.
    fn sample(splitter: &mut Splitter, seen: f32, found: f32) {
        splitter.emission(Rgb::grey(seen), 1.0);
        splitter.light(Rgb::grey(2.0 * found), 1.0, 0.5);
        splitter.filmed(Rgb::grey(seen + found));
    }

    #[test]
    fn shares_are_those_of_independent_parts() {
        // Variances 1 and 4, in every combination: shares 1/5 and 4/5. Means 3 and 1.
        let mut splitter = Splitter::new(4, vec![[1.0; 3]; 2]);
        for _ in 0..2 {
            for (seen, found) in [(2.0, -1.0), (2.0, 3.0), (4.0, -1.0), (4.0, 3.0)] {
                sample(&mut splitter, seen, found);
            }
        }
        let shares = shares(&[splitter.sums.clone(), splitter.sums], 4).expect("it has variance");
        let [seen, found] = shares.classes.as_slice() else {
            panic!("two classes: {shares:?}");
        };
        assert_eq!((seen.found, seen.bounces), (LightFoundBy::Seen, 0));
        assert_eq!(
            (found.found, found.bounces),
            (LightFoundBy::LightSampling, 1)
        );
        assert!((seen.variance - 0.2).abs() < 1e-12 && (found.variance - 0.8).abs() < 1e-12);
        assert!((seen.energy - 0.75).abs() < 1e-12 && shares.unexplained.abs() < 1e-12);
        // The variance of a sample is 5; the unbiased estimate from four samples is 4/3 of it.
        assert!(
            (shares.variance - 20.0 / 3.0).abs() < 1e-12,
            "{}",
            shares.variance
        );
    }

    #[test]
    fn a_picture_without_noise_has_no_shares() {
        let mut splitter = Splitter::new(2, vec![[1.0; 3]]);
        for _ in 0..2 {
            sample(&mut splitter, 1.0, 1.0);
        }
        assert_eq!(shares(&[splitter.sums], 2), None);
    }
}
