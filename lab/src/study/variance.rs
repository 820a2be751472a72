//! The sources of the variance of a sample, by the length of paths and by the technique that found the light.
//!
//! The share of a class of paths may be negative: it compensates for others.
//!
//! Measure: shares of the variance of one sample, relative as relMSE is, and of the light.
//! Range: integrators that report their paths. Each sample is treated on its own: the variance that evenly distributed
//! points save is not included, nor is that of light paths beside camera paths.
//! Source: `covariance.rs`. Tested below and in `lab/tests/reports/study.rs`.

use super::covariance::{CovarianceSums, ErrorShare, Splits, Splitter, observed, shares, total};
use super::prepared_scene::PreparedScene;
use super::reference::References;
use super::variant::Variant;
use etendue::internals::bsdf::types::Lobe;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::integrator::observer::PathObserver;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec3;
use etendue::internals::render::settings::RenderSettings;
use serde::Serialize;

/// Number of scattering events that are distinguished; paths with as many or more form one class.
const MAX_BOUNCES: usize = 5;

/// Number of classes: seen directly; then by scattering events, each found by BSDF sampling and by light sampling.
const CLASSES: usize = 1 + 2 * MAX_BOUNCES;

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
    bounces == MAX_BOUNCES
}

/// The remark on shares of renders that find light by more than the camera paths of its own pixel; `None` where there is
/// nothing to remark.
pub fn remark(settings: &RenderSettings) -> Option<&'static str> {
    if settings.light_path_share() != LightPathShare::None {
        Some(
            "sources of variance are those of camera paths: light paths beside them have variance of their own",
        )
    } else if settings.reuse().is_on() {
        Some(
            "sources of variance are those of paths that no other pixel shares: sharing them removes most of the variance of indirect light",
        )
    } else {
        None
    }
}

/// Observes `spp` samples of each pixel; `None` for an integrator that does not report its paths, takes parts of them
/// from a cache, or splats all its samples.
pub fn path_shares(
    prepared: &PreparedScene,
    variant: &Variant,
    references: &References,
    spp: u64,
    seed: u64,
) -> Option<PathShares> {
    let settings = &variant.settings;
    if settings.integrator == IntegratorKind::IrradianceCache || settings.integrator.splats() {
        return None;
    }
    let splitter = |weights| Lengths::new(spp, weights);
    let parts = observed(prepared, variant, references, (spp, seed), splitter)?;
    path_shares_of(&parts, spp)
}

fn path_shares_of(parts: &[CovarianceSums], spp: u64) -> Option<PathShares> {
    let shares = shares(parts, CLASSES)?;
    let class = |(k, share): (usize, &ErrorShare)| ClassShare {
        bounces: k.div_ceil(2),
        found: match k {
            0 => LightFoundBy::Seen,
            _ if k % 2 == 1 => LightFoundBy::Scattering,
            _ => LightFoundBy::LightSampling,
        },
        variance: share.variance,
        variance_error: share.variance_error,
        energy: share.energy,
    };
    let classes = shares.classes.iter().enumerate().map(class);
    Some(PathShares {
        spp,
        variance: shares.variance,
        unexplained: 1.0 - total(parts).explained(0..CLASSES),
        classes: classes.filter(|class| class.energy != 0.0).collect(),
    })
}

/// An observer that splits samples by the length of paths and by the technique that found the light.
struct Lengths {
    splits: Splits,
    bounces: usize,
}

impl Lengths {
    fn new(spp: u64, weights: Vec<[f64; 3]>) -> Self {
        Self {
            splits: Splits::new(CLASSES, spp, weights),
            bounces: 0,
        }
    }

    /// Adds light that a camera or extension ray hit.
    fn record(&mut self, contribution: Rgb) {
        let class = match self.bounces.min(MAX_BOUNCES) {
            0 => 0,
            bounces => 2 * bounces - 1,
        };
        self.splits.add(class, contribution);
    }
}

impl Splitter for Lengths {
    fn into_sums(self) -> CovarianceSums {
        self.splits.sums
    }
}

impl PathObserver for Lengths {
    fn environment(&mut self, contribution: Rgb) {
        self.record(contribution);
    }

    fn emission(&mut self, contribution: Rgb, _weight: f32) {
        self.record(contribution);
    }

    fn light(&mut self, contribution: Rgb, _weight: f32, visible: f32) {
        if visible > 0.0 {
            let bounces = (self.bounces + 1).min(MAX_BOUNCES);
            self.splits.add(2 * bounces, contribution * visible);
        }
    }

    fn scattered(&mut self, _wi: Vec3, _lobe: Lobe, _beta: Rgb) {
        self.bounces += 1;
    }

    fn sample_added(&mut self, value: Rgb) {
        self.splits.sample_added(value);
        self.bounces = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample with light seen directly and light found by light sampling, both random.
    fn sample(splitter: &mut Lengths, seen: f32, found: f32) {
        splitter.emission(Rgb::grey(seen), 1.0);
        splitter.light(Rgb::grey(2.0 * found), 1.0, 0.5);
        splitter.sample_added(Rgb::grey(seen + found));
    }

    #[test]
    fn variance_shares_match_independent_contributions() {
        // Variances 1 and 4, in every combination: shares 1/5 and 4/5. Means 3 and 1.
        let mut splitter = Lengths::new(4, vec![[1.0; 3]; 2]);
        for _ in 0..2 {
            for (seen, found) in [(2.0, -1.0), (2.0, 3.0), (4.0, -1.0), (4.0, 3.0)] {
                sample(&mut splitter, seen, found);
            }
        }
        let sums = splitter.into_sums();
        let shares = path_shares_of(&[sums.clone(), sums], 4).expect("it has variance");
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
    fn parts_without_pixels_do_not_reduce_the_standard_error() {
        let part = |scale: f32| {
            let mut splitter = Lengths::new(4, vec![[1.0; 3]]);
            for (seen, found) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                sample(&mut splitter, 4.0 + scale * seen, 4.0 + found);
            }
            splitter.into_sums()
        };
        let empty = || Lengths::new(4, vec![]).into_sums();
        let error = |parts: &[CovarianceSums]| {
            let shares = path_shares_of(parts, 4).expect("it has variance");
            shares.classes[0].variance_error
        };
        // Shares of 1/2 and 4/5: those without one of them lie 0.3 apart.
        let of_two = error(&[part(1.0), part(2.0)]);
        assert!(of_two > 0.1, "{of_two}");
        assert_eq!(of_two, error(&[part(1.0), empty(), part(2.0), empty()]));
        // Of a single part, the uncertainty is not known.
        assert!(error(&[part(1.0), empty()]).is_nan());
    }

    #[test]
    fn noise_free_image_has_no_variance_shares() {
        let mut splitter = Lengths::new(2, vec![[1.0; 3]]);
        for _ in 0..2 {
            sample(&mut splitter, 1.0, 1.0);
        }
        assert_eq!(path_shares_of(&[splitter.into_sums()], 2), None);
    }
}
