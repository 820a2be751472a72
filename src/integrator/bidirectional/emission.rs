//! The strategy s = 0: the camera subpath hits a light, or leaves the scene for the environment.
//!
//! Measure: radiance.
//! Range: any camera subpath; what emits nothing has no contribution.
//! Source: Veach 1997, section 10.2. Tested in `tests/rendering/bidirectional.rs`.

use super::connect::{Connector, Contribution};
use super::vertex::{LightVertex, RayDensity};
use super::weights::ConnectionPdfs;
use crate::effects::{Effects, Switch};
use crate::film::splats::Strategy;
use crate::integrator::observer::PathObserver;
use crate::light::types::{EnvironmentSampling, Receiver, ShadowRayEnd};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec3;

/// A light that the camera subpath hits, or leaves the scene for.
struct FoundLight {
    /// The number of the light.
    light: u32,
    /// The point of the light.
    end: ShadowRayEnd,
    /// The unit vector of the direction of its light, towards the camera subpath.
    direction: Vec3,
    /// The density of finding it on the camera subpath.
    by_camera: f64,
}

impl<E: Effects, O: PathObserver + ?Sized> Connector<'_, '_, E, O> {
    /// The contribution of s = 0: the surface `j` of the camera subpath emits.
    pub(super) fn emission_s0(&mut self, j: usize) -> Option<Contribution> {
        let (scene, camera_subpath) = (self.scene, self.camera_subpath);
        let vertex = &camera_subpath.vertices[j];
        let emitted = scene.emitted(&vertex.at)?;
        let strategy = Strategy { s: 0, t: j + 2 };
        let mut weight = 1.0;
        if let Some(light) = scene.light_of(&vertex.at) {
            let found = FoundLight {
                light,
                end: ShadowRayEnd::Surface(vertex.at.surface_point(), [0.0; 2]),
                direction: vertex.at.wo,
                by_camera: vertex.densities.by_camera,
            };
            let (choice, time) = (self.light_choice, self.time);
            weight = self.weight_s0(strategy, found, |receiver| {
                scene.light_pdf(choice, receiver, time, &vertex.at)
            });
        }
        let contribution = Contribution {
            strategy,
            film: None,
            unweighted: vertex.beta * emitted,
            weight,
        };
        self.observer.emission(contribution.value(), weight);
        Some(contribution)
    }

    /// The contributions of s = 0 from the environment: of the constant one and of the one that is sampled.
    pub(super) fn environment_s0(&mut self) -> [Option<Contribution>; 2] {
        let Some(escape) = self.camera_subpath.escape.filter(|_| E::Environment::ON) else {
            return [None; 2];
        };
        let strategy = Strategy {
            s: 0,
            t: self.camera_subpath.vertices.len() + 2,
        };
        let contribution = |radiance: Rgb, weight| Contribution {
            strategy,
            film: None,
            unweighted: escape.beta * radiance,
            weight,
        };
        let constant = contribution(self.scene.environment, 1.0);
        let lights = &self.scene.lights;
        let mut sampled = None;
        if E::EnvironmentMap::ON
            && let Some(environment) =
                lights.environment(escape.direction, EnvironmentSampling::Radiance)
        {
            let light = environment.light;
            let found = FoundLight {
                light,
                end: ShadowRayEnd::Infinity,
                direction: -escape.direction,
                by_camera: match escape.ray_density {
                    RayDensity::Point(density) | RayDensity::Parallel(density) => density,
                },
            };
            let choice = self.light_choice;
            let weight = self.weight_s0(strategy, found, |receiver| {
                lights.pmf::<E>(light, choice, receiver) * environment.pdf
            });
            sampled = Some(contribution(environment.radiance, weight));
        }
        let sum = sampled.map_or(constant.value(), |it| constant.value() + it.value());
        self.observer.environment(sum);
        [Some(constant), sampled]
    }

    /// The MIS weight of s = 0 for a light. `by_nee` returns the density with which light sampling at a receiver finds it.
    fn weight_s0(
        &mut self,
        strategy: Strategy,
        found: FoundLight,
        by_nee: impl FnOnce(&Receiver) -> PdfSolidAngle,
    ) -> f32 {
        let (scene, camera_subpath) = (self.scene, self.camera_subpath);
        // Light that the camera sees directly is found by s = 0 alone.
        let Some(before) = strategy.t.checked_sub(3) else {
            return 1.0;
        };
        let before = &camera_subpath.vertices[before];
        let FoundLight {
            light,
            end,
            direction,
            by_camera,
        } = found;
        let pdf = scene.pdf_emission(light, self.time, &end, direction);
        let (mut source, rays) = LightVertex::new(end, scene.lights.pmf_by_power(light), &pdf);
        source.nee_pdf = source.density_from(before.at.p, by_nee(&before.receiver()));
        source.densities.by_camera = by_camera;
        let offset = source.offset_to(before.at.p, direction);
        let at_before = rays.density_at(offset, before.at.ng);
        let pdfs = ConnectionPdfs::of_emission(&source, at_before);
        self.weight(strategy, &source, &pdfs)
    }
}
