//! Irradiance caching: indirect irradiance at matte surfaces is computed at few points and interpolated in between.
//!
//! A matte surface of albedo rho reflects the radiance rho / pi E. Direct light, which light sampling finds, is sampled
//! at every point; the rest of E changes slowly, and is a mean over the [`Record`]s nearby,
//!
//!   E(x, n) = sum_i w_i E_i(x, n) / sum_i w_i,   w_i = 1 - e_i,
//!
//! each weighted by the part of the allowed error that its error e_i leaves, if these weights sum to [`MIN_WEIGHT_SUM`].
//! Elsewhere the path continues, and nothing is extrapolated. The estimate is biased by the interpolation, within about
//! the bound, and by the noise of the records, which is less; both vanish with the bound, and a bound of 0 gives the
//! path tracer's image.
//!
//! Measure: irradiance; normalised scene units.
//! Range: scenes without motion; with a bounce limit the cache is used at the first surface only, as it is invalid at
//! others.
//! Source: Ward, Rubinstein and Clear 1988, "A Ray Tracing Solution for Diffuse Interreflection"; Krivanek and Gautron 2009.
//! Tested in `tests/rendering/irradiance_cache.rs`.

mod gather;
pub mod hemisphere;
mod record;

use super::indirect::Indirect;
use super::path::PathIntegrator;
use super::{CameraRay, RayCounts};
use crate::accel::Hit;
use crate::bsdf::Bsdf;
use crate::effects::Effects;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
pub use gather::GatherScratch;
use gather::Gatherer;
pub use record::Record;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use std::f32::consts::FRAC_1_PI;

/// The sum of weights from which irradiance is interpolated: one record suffices at its own point alone, two in the
/// middle between them. The mean over several has less noise than each, and the worst of 100,000 points stays within
/// the bound.
pub const MIN_WEIGHT_SUM: f32 = 1.0;

/// The box within which a record counts, and its index.
type ValidityBox = GeomWithData<Rectangle<[f32; 3]>, u32>;

/// The known indirect irradiance of a scene.
#[derive(Debug, Clone, Default)]
pub struct IrradianceCache {
    bound: f32,
    records: Vec<Record>,
    validity_boxes: RTree<ValidityBox>,
}

impl IrradianceCache {
    /// Creates an empty cache for relative errors up to `bound`, from 0 to 1.
    pub fn new(bound: f64) -> Self {
        Self {
            bound: bound as f32,
            ..Self::default()
        }
    }

    /// Inserts a record, unless others give the irradiance at its point already. Returns whether it was inserted.
    pub fn insert(&mut self, record: Record) -> bool {
        if self.count(record.p, record.n) > 0 {
            return false;
        }
        self.push(record);
        true
    }

    /// The cache of records that were inserted in this order; `None` for numbers that no record has.
    pub fn with_records(bound: f64, records: Vec<Record>) -> Option<Self> {
        if !records.iter().all(Record::is_possible) {
            return None;
        }
        let mut cache = Self::new(bound);
        records.into_iter().for_each(|record| cache.push(record));
        Some(cache)
    }

    fn push(&mut self, record: Record) {
        let index = self.records.len() as u32;
        let radius = Vec3::splat(record.radius);
        let corners = [record.p - radius, record.p + radius].map(|corner| corner.to_array());
        let validity_box = Rectangle::from_corners(corners[0], corners[1]);
        self.validity_boxes
            .insert(GeomWithData::new(validity_box, index));
        self.records.push(record);
    }

    /// The records.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// The memory of the cache in bytes, except for the tree's inner nodes, of which there is about one for six
    /// records.
    pub fn memory(&self) -> usize {
        self.records.len() * (size_of::<Record>() + size_of::<ValidityBox>())
    }

    /// The records that count at a point, with their errors as fractions of the allowed error.
    fn near(&self, p: Vec3, n: Vec3) -> impl Iterator<Item = (&Record, f32)> {
        let boxes = self.validity_boxes.locate_all_at_point(p.to_array());
        boxes.filter_map(move |validity_box| {
            let record = &self.records[validity_box.data as usize];
            record.error(p, n, self.bound).map(|error| (record, error))
        })
    }

    /// The irradiance at a point with this normal, and the number of records that it is interpolated from; `None` if
    /// they are not enough.
    fn interpolate(&self, p: Vec3, n: Vec3) -> Option<(Rgb, usize)> {
        let (mut sum, mut weights, mut count) = (Rgb::BLACK, 0.0, 0);
        for (record, error) in self.near(p, n) {
            let weight = 1.0 - error;
            sum += weight * record.irradiance(p, n);
            weights += weight;
            count += 1;
        }
        // A gradient may extrapolate to less than zero.
        (weights >= MIN_WEIGHT_SUM).then(|| ((sum / weights).map(|e| e.max(0.0)), count))
    }

    /// The irradiance at a point with this normal, where it is known.
    pub fn irradiance(&self, p: Vec3, n: Vec3) -> Option<Rgb> {
        self.interpolate(p, n).map(|(irradiance, _)| irradiance)
    }

    /// The number of records that the irradiance there is interpolated from; 0 if it is not known.
    pub fn count(&self, p: Vec3, n: Vec3) -> usize {
        self.interpolate(p, n).map_or(0, |(_, count)| count)
    }

    /// The albedo of a surface at which the cache may be used; `None` at others.
    fn albedo(bsdf: &Bsdf, bounce: u32, is_limited: bool) -> Option<Rgb> {
        match bsdf {
            Bsdf::Diffuse(matte) if bounce == 0 || !is_limited => Some(matte.reflectance()),
            _ => None,
        }
    }
}

/// Indirect light from a cache.
#[derive(Debug, Clone, Copy)]
pub struct Cached<'a>(pub &'a IrradianceCache);

impl Indirect for Cached<'_> {
    fn reflected<E: Effects>(
        &self,
        at: &Interaction<E>,
        bsdf: &Bsdf,
        bounce: u32,
        is_limited: bool,
    ) -> Option<Rgb> {
        let albedo = IrradianceCache::albedo(bsdf, bounce, is_limited)?;
        let irradiance = self.0.irradiance(at.p, at.frame.n)?;
        Some(FRAC_1_PI * albedo * irradiance)
    }
}

/// The result of a lookup where a path would use the cache.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LookupResult {
    /// The number of records that the irradiance is interpolated from; 0 if it is not known.
    Known(usize),
    /// A new record, where the irradiance is not known, with the rays traced for it.
    New(Record, RayCounts),
}

/// A lookup in the cache where a path may use it, which may make a record.
#[derive(Debug, Clone, Copy)]
pub struct CacheLookup<'a> {
    /// The cache.
    pub cache: &'a IrradianceCache,
    /// The scene.
    pub scene: &'a Scene,
    /// The integrator that traces the paths of new records.
    pub integrator: PathIntegrator,
    /// Whether to make a record where none counts.
    pub makes_records: bool,
}

impl CacheLookup<'_> {
    /// Traces a path, given the hit on its camera ray, to the first surface where the cache may be used, and looks up
    /// the irradiance there; `None` if there is no such surface, or no record can be made. A new record draws its
    /// random numbers from `sampler`, as a sample of `sequence_pixel` does.
    pub fn on_path<E: Effects, S: Sampler>(
        &self,
        sampler: &mut S,
        camera_ray: &CameraRay,
        hit: Option<Hit>,
        sequence_pixel: [u32; 2],
        scratch: &mut GatherScratch<E, S>,
    ) -> Option<LookupResult> {
        let is_limited = self.integrator.max_bounces.is_some();
        let mut of_record = sampler.clone();
        let find = |at: &Interaction<E>, bsdf: &Bsdf, bounce| {
            IrradianceCache::albedo(bsdf, bounce, is_limited).map(|_| *at)
        };
        let paths = &mut scratch.paths;
        let at = self
            .integrator
            .find_surface(self.scene, sampler, camera_ray, hit, paths, find)?;
        self.at_surface(&at, &mut of_record, sequence_pixel, scratch)
    }

    fn at_surface<E: Effects, S: Sampler>(
        &self,
        at: &Interaction<E>,
        sampler: &mut S,
        sequence_pixel: [u32; 2],
        scratch: &mut GatherScratch<E, S>,
    ) -> Option<LookupResult> {
        let count = self.cache.count(at.p, at.frame.n);
        if count > 0 || !self.makes_records {
            return Some(LookupResult::Known(count));
        }
        let mut rays = RayCounts::default();
        let gatherer = Gatherer {
            scene: self.scene,
            integrator: self.integrator,
            bound: self.cache.bound.into(),
            sequence_pixel,
        };
        let record = gatherer.gather(sampler, at, &mut rays, scratch)?;
        Some(LookupResult::New(record, rays))
    }
}
