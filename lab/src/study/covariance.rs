//! The variance of samples that are sums over classes, X = sum_k X_k, by class: Var X = sum_k Cov(X_k, X) exactly.
//!
//! Measure: shares of the relative variance of one sample and of the light.
//! Range: at least two samples of each pixel; standard errors are those of the jackknife over parts of the image.
//! Source: the covariance is linear. Tested in `variance.rs` and `error_sources.rs`.

use super::prepared_scene::PreparedScene;
use super::reference::References;
use super::variant::Variant;
use etendue::internals::film::Film;
use etendue::internals::integrator::observer::PathObserver;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::render::observe_tile;
use rayon::prelude::*;

/// Number of parts of the image, for the standard errors of the shares.
const PARTS: usize = 16;

/// Edge of the tiles that form the parts, in pixels.
const TILE: u32 = 8;

/// The share of one class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorShare {
    /// The share of the variance.
    pub variance: f64,
    /// The standard error of `variance`; NaN for an image of a single part.
    pub variance_error: f64,
    /// The share of the light.
    pub energy: f64,
}

/// The shares of all classes.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassShares {
    /// The relative variance of one sample.
    pub variance: f64,
    /// The classes, those without light among them.
    pub classes: Vec<ErrorShare>,
}

/// Sums over pixels.
#[derive(Debug, Clone, Default)]
pub struct CovarianceSums {
    pixels: u64,
    variance: f64,
    covariance: Vec<f64>,
    energy: Vec<f64>,
}

impl CovarianceSums {
    fn new(classes: usize) -> Self {
        Self {
            covariance: vec![0.0; classes],
            energy: vec![0.0; classes],
            ..Self::default()
        }
    }

    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.variance += other.variance;
        let pairs = self.covariance.iter_mut().zip(&other.covariance);
        pairs.for_each(|(sum, x)| *sum += x);
        let pairs = self.energy.iter_mut().zip(&other.energy);
        pairs.for_each(|(sum, x)| *sum += x);
    }

    /// The part of the variance that these classes explain together.
    pub fn explained(&self, classes: std::ops::Range<usize>) -> f64 {
        self.covariance[classes].iter().sum::<f64>() / self.variance
    }
}

/// Sums over the samples of one pixel, by channel.
#[derive(Debug, Clone)]
struct PixelCovariance {
    count: f64,
    /// The sums of X and X^2.
    whole: [[f64; 2]; 3],
    /// The sums of X_k and X_k X.
    classes: Vec<[[f64; 2]; 3]>,
}

impl PixelCovariance {
    fn new(classes: usize) -> Self {
        Self {
            count: 0.0,
            whole: [[0.0; 2]; 3],
            classes: vec![[[0.0; 2]; 3]; classes],
        }
    }
}

/// Splits samples into classes. The pixels of a tile follow one another, each with all of its samples.
#[derive(Debug, Clone)]
pub struct Splits {
    spp: u64,
    weights: Vec<[f64; 3]>,
    pixel: usize,
    seen: u64,
    sample: Vec<Rgb>,
    of_pixel: PixelCovariance,
    /// The sums over the pixels so far.
    pub sums: CovarianceSums,
}

impl Splits {
    /// Starts sums for `spp` samples of pixels with these weights.
    pub fn new(classes: usize, spp: u64, weights: Vec<[f64; 3]>) -> Self {
        Self {
            spp,
            weights,
            pixel: 0,
            seen: 0,
            sample: vec![Rgb::BLACK; classes],
            of_pixel: PixelCovariance::new(classes),
            sums: CovarianceSums::new(classes),
        }
    }

    /// Adds a contribution to a class of the present sample.
    pub fn add(&mut self, class: usize, contribution: Rgb) {
        self.sample[class] += contribution;
    }

    /// Ends a sample, of which this is the value.
    pub fn sample_added(&mut self, value: Rgb) {
        if value.is_finite() {
            self.take(value);
        }
        self.sample.fill(Rgb::BLACK);
        self.seen += 1;
        if self.seen == self.spp {
            self.finish_pixel();
        }
    }

    fn take(&mut self, value: Rgb) {
        let sums = &mut self.of_pixel;
        sums.count += 1.0;
        let value = value.to_array().map(f64::from);
        for (whole, x) in sums.whole.iter_mut().zip(value) {
            whole[0] += x;
            whole[1] += x * x;
        }
        for (sums, part) in sums.classes.iter_mut().zip(&self.sample) {
            let parts = part.to_array().map(f64::from);
            for ((sum, part), x) in sums.iter_mut().zip(parts).zip(value) {
                sum[0] += part;
                sum[1] += part * x;
            }
        }
    }

    fn finish_pixel(&mut self) {
        let classes = self.sample.len();
        let pixel = std::mem::replace(&mut self.of_pixel, PixelCovariance::new(classes));
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
            for (k, class) in pixel.classes.iter().enumerate() {
                let [part, product] = class[c];
                self.sums.covariance[k] += scale * (product - part * x / n);
                self.sums.energy[k] += part / n;
            }
        }
    }
}

/// An observer that splits samples.
pub trait Splitter: PathObserver {
    /// The sums over all pixels.
    fn into_sums(self) -> CovarianceSums;
}

/// Observes `spp` samples of each pixel, by observers for `spp` samples of pixels with given weights; the sums of parts
/// of the image. `None` if there are no threads.
pub fn observed<O: Splitter>(
    prepared: &PreparedScene,
    variant: &Variant,
    references: &References,
    (spp, seed): (u64, u64),
    observer: impl Fn(Vec<[f64; 3]>) -> O + Sync,
) -> Option<Vec<CovarianceSums>> {
    let settings = prepared.settings(variant, spp, seed);
    let scene = prepared.scene(variant.options);
    let mut film = Film::new(settings.window, TILE);
    let width = prepared.size().0 as usize;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .ok()?;
    let observe = |(index, tile): (usize, &mut etendue::internals::film::Tile)| {
        let place = |[x, y]: [u32; 2]| y as usize * width + x as usize;
        let weights = references.weights();
        let weights = tile.window.pixels().map(|pixel| weights[place(pixel)]);
        let mut observer = observer(weights.collect());
        observe_tile(
            scene,
            prepared.filter(),
            &settings,
            None,
            tile,
            0..spp,
            &mut observer,
        );
        (index % PARTS, observer.into_sums())
    };
    let tiles: Vec<(usize, CovarianceSums)> = pool.install(|| {
        let tiles = film.tiles_mut().par_iter_mut().enumerate();
        tiles.map(observe).collect()
    });
    let classes = tiles.first()?.1.covariance.len();
    let mut parts = vec![CovarianceSums::new(classes); PARTS];
    for (part, sums) in &tiles {
        parts[*part].add(sums);
    }
    Some(parts)
}

/// The sum of all parts.
pub fn total(parts: &[CovarianceSums]) -> CovarianceSums {
    without(parts, None)
}

fn without(parts: &[CovarianceSums], left_out: Option<usize>) -> CovarianceSums {
    let mut all = CovarianceSums::new(parts.first().map_or(0, |part| part.covariance.len()));
    let kept = parts.iter().enumerate();
    for (_, part) in kept.filter(|(index, _)| Some(*index) != left_out) {
        all.add(part);
    }
    all
}

/// Computes the shares, with the jackknife over parts of the image. The classes from 0 up to `light` together have all
/// light. `None` without variance.
pub fn shares(parts: &[CovarianceSums], light: usize) -> Option<ClassShares> {
    let all = total(parts);
    if all.variance <= 0.0 || all.pixels == 0 {
        return None;
    }
    // A small image has fewer tiles than parts.
    let seen = (0..parts.len()).filter(|&part| parts[part].pixels > 0);
    let leaving: Vec<CovarianceSums> = seen.map(|part| without(parts, Some(part))).collect();
    let light: f64 = all.energy[..light].iter().sum();
    let class = |k: usize| {
        let share = |sums: &CovarianceSums| sums.covariance[k] / sums.variance;
        let value = share(&all);
        let count = leaving.len() as f64;
        let squares = leaving.iter().map(|sums| (share(sums) - value).powi(2));
        let squares: f64 = squares.filter(|square| square.is_finite()).sum();
        ErrorShare {
            variance: value,
            variance_error: match leaving.len() {
                // Of a single part nothing is known but its value.
                0 | 1 => f64::NAN,
                _ => (squares * (count - 1.0) / count).sqrt(),
            },
            energy: all.energy[k] / light,
        }
    };
    Some(ClassShares {
        variance: all.variance / (3 * all.pixels) as f64,
        classes: (0..all.covariance.len()).map(class).collect(),
    })
}
