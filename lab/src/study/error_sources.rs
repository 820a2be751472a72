//! The objects that the error of an image comes from: shares of the variance of a sample by the light that was found, and
//! by the material that scattered it last.
//!
//! Measure: shares of the variance of one sample, relative as relMSE is, and of the light.
//! Range: integrators that report their paths. Objects beyond the hundredth of each kind are counted together.
//! Source: `covariance.rs`. Tested in `cli/tests/command/price.rs` and below.

use super::covariance::{CovarianceSums, ErrorShare, Splits, Splitter, observed, shares};
use super::prepared_scene::PreparedScene;
use super::reference::References;
use super::variance::{PathShares, path_shares};
use super::variant::Variant;
use etendue::internals::accel::PrimitiveId;
use etendue::internals::bsdf::types::Lobe;
use etendue::internals::integrator::observer::{PathObserver, PathVertex, RayKind};
use etendue::internals::math::ray::Ray;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec3;
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use serde::Serialize;

/// The largest number of materials and of lights that are told apart.
const MAX_NAMED: usize = 100;

/// A shadow ray is extended by this share of its length, to hit the light at its end.
const BEYOND: f32 = 1e-3;

/// The sources of an error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorSources {
    /// The shares by length and technique of the paths.
    pub paths: PathShares,
    /// The shares by the material that scattered the light last, the largest first.
    pub materials: Vec<ObjectShare>,
    /// The shares by the light, the largest first.
    pub lights: Vec<ObjectShare>,
}

/// The share of one object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectShare {
    /// Its name in the scene.
    pub name: String,
    /// Its share of the variance.
    pub variance: f64,
    /// The standard error of `variance`.
    pub variance_error: f64,
    /// Its share of the light.
    pub energy: f64,
}

/// The names of the classes: materials, then lights.
struct Names {
    materials: Vec<String>,
    /// The name of each emitting shape of the description, as an index of `lights`.
    of_shape: Vec<usize>,
    lights: Vec<String>,
}

/// The lights that are not shapes.
const OTHER_LIGHT: &str = "lights without a surface";
const ENVIRONMENT: &str = "environment and distant lights";
const SEEN: &str = "seen directly";

impl Names {
    fn new(description: &SceneDescription) -> Self {
        let all = description.materials.iter().take(MAX_NAMED);
        let mut materials = vec![SEEN.to_owned(), "other materials".to_owned()];
        materials.extend(all.map(|material| material.name.clone()));
        let mut lights: Vec<String> = [ENVIRONMENT, OTHER_LIGHT].map(str::to_owned).to_vec();
        let of_shape = description.shapes.iter().map(|shape| {
            let material = &description.materials[shape.material].name;
            let name = match shape.name.is_empty() {
                true => material,
                false => &shape.name,
            };
            let known = lights.iter().position(|light| light == name);
            match known {
                _ if shape.emission.is_none() => 1,
                Some(index) => index,
                None if lights.len() < MAX_NAMED => {
                    lights.push(name.clone());
                    lights.len() - 1
                }
                None => 1,
            }
        });
        let of_shape = of_shape.collect();
        Self {
            materials,
            of_shape,
            lights,
        }
    }

    fn count(&self) -> usize {
        self.materials.len() + self.lights.len()
    }

    fn named(&self, shares: &[ErrorShare]) -> [Vec<ObjectShare>; 2] {
        let (materials, lights) = shares.split_at(self.materials.len());
        let named = |names: &[String], shares: &[ErrorShare]| {
            let pairs = names
                .iter()
                .zip(shares)
                .filter(|(_, share)| share.energy != 0.0);
            let mut all: Vec<ObjectShare> = pairs
                .map(|(name, share)| ObjectShare {
                    name: name.clone(),
                    variance: share.variance,
                    variance_error: share.variance_error,
                    energy: share.energy,
                })
                .collect();
            all.sort_by(|a, b| b.variance.total_cmp(&a.variance));
            all
        };
        [
            named(&self.materials, materials),
            named(&self.lights, lights),
        ]
    }
}

/// Observes `spp` samples of each pixel; `None` where [`path_shares`] has none.
pub fn error_sources(
    prepared: &PreparedScene,
    description: &SceneDescription,
    variant: &Variant,
    references: &References,
    (spp, seed): (u64, u64),
) -> Option<ErrorSources> {
    let paths = path_shares(prepared, variant, references, spp, seed)?;
    let names = Names::new(description);
    let scene = prepared.scene(variant.options);
    let objects = |weights| Objects {
        splits: Splits::new(names.count(), spp, weights),
        scene,
        description,
        names: &names,
        at: None,
        before: None,
        shadow: None,
    };
    let parts = observed(prepared, variant, references, (spp, seed), objects)?;
    let shares = shares(&parts, names.materials.len())?;
    let [materials, lights] = names.named(&shares.classes);
    Some(ErrorSources {
        paths,
        materials,
        lights,
    })
}

/// An observer that splits samples by objects.
struct Objects<'a> {
    splits: Splits,
    scene: &'a Scene,
    description: &'a SceneDescription,
    names: &'a Names,
    /// The last surface, and the surface before it that scattered.
    at: Option<PrimitiveId>,
    before: Option<PrimitiveId>,
    /// The last shadow ray, with its time.
    shadow: Option<(Ray, f32)>,
}

impl Objects<'_> {
    fn add(&mut self, scatterer: Option<PrimitiveId>, light: usize, contribution: Rgb) {
        let material = scatterer.map_or(0, |id| {
            let shape = self.scene.described(id.shape);
            let index = self.description.shapes[shape].material + 2;
            if index < self.names.materials.len() {
                index
            } else {
                1
            }
        });
        self.splits.add(material, contribution);
        self.splits
            .add(self.names.materials.len() + light, contribution);
    }

    fn light_of(&self, id: PrimitiveId) -> usize {
        self.names.of_shape[self.scene.described(id.shape)]
    }

    /// The light at the end of the last shadow ray.
    fn sampled_light(&self) -> usize {
        let Some((ray, time)) = self.shadow else {
            return 1;
        };
        if ray.t_max.is_infinite() {
            return 0;
        }
        let through = Ray {
            t_min: ray.t_max * (1.0 - BEYOND),
            t_max: ray.t_max * (1.0 + BEYOND),
            ..ray
        };
        let hit = self.scene.accel.intersect(&through, time, None);
        hit.map_or(1, |hit| self.light_of(hit.id))
    }
}

impl Splitter for Objects<'_> {
    fn into_sums(self) -> CovarianceSums {
        self.splits.sums
    }
}

impl PathObserver for Objects<'_> {
    fn traced(&mut self, kind: RayKind, ray: &Ray, time: f32) {
        if kind == RayKind::Shadow {
            self.shadow = Some((*ray, time));
        }
    }

    fn arrived(&mut self, at: &PathVertex, _beta: Rgb) {
        self.at = Some(at.id);
    }

    fn environment(&mut self, contribution: Rgb) {
        self.add(self.before, 0, contribution);
    }

    fn emission(&mut self, contribution: Rgb, _weight: f32) {
        let light = self.at.map_or(1, |id| self.light_of(id));
        self.add(self.before, light, contribution);
    }

    fn light(&mut self, contribution: Rgb, _weight: f32, visible: f32) {
        if visible > 0.0 {
            let light = self.sampled_light();
            self.add(self.at, light, contribution * visible);
        }
    }

    fn scattered(&mut self, _wi: Vec3, _lobe: Lobe, _beta: Rgb) {
        self.before = self.at;
    }

    fn sample_added(&mut self, value: Rgb) {
        self.splits.sample_added(value);
        (self.at, self.before, self.shadow) = (None, None, None);
    }
}
