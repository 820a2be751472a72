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
use crate::light::types::{EnvironmentSampling, ShadowRayEnd};
use crate::math::rgb::Rgb;

impl<E: Effects, O: PathObserver + ?Sized> Connector<'_, '_, E, O> {
    /// The contribution of s = 0: the surface `j` of the camera subpath emits.
    pub(super) fn emission_s0(&mut self, j: usize) -> Option<Contribution> {
        let (scene, camera_path) = (self.scene, self.camera_path);
        let vertex = &camera_path.vertices[j];
        let emitted = scene.emitted(&vertex.at)?;
        let strategy = Strategy { s: 0, t: j + 2 };
        let mut weight = 1.0;
        if j > 0
            && let Some(light) = scene.light_of(&vertex.at)
        {
            let before = &camera_path.vertices[j - 1];
            let receiver = before.receiver();
            let by_nee = scene.light_pdf(self.light_choice, &receiver, self.time, &vertex.at);
            let end = ShadowRayEnd::Surface(vertex.at.surface_point(), [0.0; 2]);
            let pdf = scene.pdf_emission(light, self.time, &end, vertex.at.wo);
            let (mut source, rays) = LightVertex::new(end, scene.lights.pmf_by_power(light), &pdf);
            source.direct = source.density_from(before.at.p, by_nee);
            source.densities.by_camera = vertex.densities.by_camera;
            let at_before = rays.density_at(before.at.p - vertex.at.p, before.at.ng);
            let pdfs = ConnectionPdfs::of_emission(&source, at_before);
            weight = self.weight(strategy, &source, &pdfs);
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
        let Some(escape) = self.camera_path.escape.filter(|_| E::Environment::ON) else {
            return [None; 2];
        };
        let strategy = Strategy {
            s: 0,
            t: self.camera_path.vertices.len() + 2,
        };
        let contribution = |radiance: Rgb, weight| Contribution {
            strategy,
            film: None,
            unweighted: escape.beta * radiance,
            weight,
        };
        let constant = contribution(self.scene.environment, 1.0);
        let mut sampled = None;
        if E::EnvironmentMap::ON
            && let Some(environment) = self
                .scene
                .lights
                .environment(escape.direction, EnvironmentSampling::Radiance)
        {
            let mut weight = 1.0;
            if let Some(last) = self.camera_path.vertices.last() {
                let (end, direction) = (ShadowRayEnd::Infinity, -escape.direction);
                let (scene, light) = (self.scene, environment.light);
                let pdf = scene.pdf_emission(light, self.time, &end, direction);
                let lights = &scene.lights;
                let (mut source, rays) = LightVertex::new(end, lights.pmf_by_power(light), &pdf);
                let pmf = lights.pmf::<E>(light, self.light_choice, &last.receiver());
                source.direct = (pmf * environment.pdf).0.into();
                source.densities.by_camera = match escape.ray_density {
                    RayDensity::Point(density) | RayDensity::Parallel(density) => density,
                };
                let at_last = rays.density_at(direction, last.at.ng);
                let pdfs = ConnectionPdfs::of_emission(&source, at_last);
                weight = self.weight(strategy, &source, &pdfs);
            }
            sampled = Some(contribution(environment.radiance, weight));
        }
        let sum = sampled.map_or(constant.value(), |it| constant.value() + it.value());
        self.observer.environment(sum);
        [Some(constant), sampled]
    }
}
