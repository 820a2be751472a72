//! Connections: every way of making one path of a camera subpath and a light subpath. `emission.rs` has the strategy s = 0,
//! which connects nothing.
//!
//! With s vertices of the light subpath and t of the camera subpath, ends included:
//!
//! - s = 0: the camera subpath hits a light, or leaves the scene for the environment.
//! - s = 1: next event estimation at the last surface of the camera subpath.
//! - s > 1, t > 1: the last surfaces of both are connected, beta_camera f_camera G V f_light beta_light.
//! - t = 1: the last surface of the light subpath is connected to a point of the lens, and splats anywhere on the film.
//!
//! Each strategy is weighted against all others that find the same path ([`WholePath`]).
//!
//! Measure: radiance; of splats, radiance times light subpaths.
//! Range: any subpaths through the same scene at the same time.
//! Source: Veach 1997, section 10.2 and 10.3.4. Tested in `tests/rendering/bidirectional.rs`.

use super::vertex::{LightVertex, RayDensity, SubpathVertex};
use super::walk::Subpath;
use super::weights::{ConnectionPdfs, WholePath};
use crate::camera::Viewpoint;
use crate::effects::Effects;
use crate::film::splats::Strategy;
use crate::integrator::RayCounts;
use crate::integrator::observer::{PathObserver, RayKind};
use crate::light::types::{LightChoice, LightSampling, ShadowRayEnd};
use crate::math::measure::PdfSolidAngle;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::Vec2;
use crate::planted::planted;
use crate::scene::Scene;

/// A light subpath, with its vertex on the light.
#[derive(Debug)]
pub struct LightSubpath<'a, 'w, E: Effects> {
    /// The vertex on the light.
    pub source: LightVertex,
    /// The density of the rays that leave the light there.
    #[cfg(test)]
    pub ray_density: RayDensity,
    /// The vertices on surfaces.
    pub subpath: &'w Subpath<'a, E>,
}

/// The contribution of one strategy, before and after it is weighted against the others that find its path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contribution {
    /// The strategy.
    pub strategy: Strategy,
    /// The film position of a splat; `None` for the pixel of the sample.
    pub film: Option<Vec2>,
    /// The radiance, of splats times light subpaths, as if there were no other strategy.
    pub unweighted: Rgb,
    /// The MIS weight of the strategy.
    pub weight: f32,
}

impl Contribution {
    /// The weighted contribution to the image.
    pub fn value(&self) -> Rgb {
        self.unweighted * self.weight
    }
}

/// Connects a camera subpath and a light subpath.
pub struct Connector<'a, 'w, E: Effects, O: ?Sized> {
    pub scene: &'a Scene,
    /// The time.
    pub time: f32,
    /// The largest number of scattering events.
    pub max_bounces: Option<u32>,
    /// The selection of lights by next event estimation.
    pub light_choice: LightChoice,
    /// The density of a sample's place on the film, per pixel of area, where each sample has one light subpath.
    pub per_pixel: f64,
    /// The light subpath, if there is one.
    pub light: Option<LightSubpath<'a, 'w, E>>,
    /// The camera subpath.
    pub camera_subpath: &'w Subpath<'a, E>,
    pub rays: &'w mut RayCounts,
    pub observer: &'w mut O,
    pub whole: &'w mut WholePath,
}

impl<'a, E: Effects, O: PathObserver + ?Sized> Connector<'a, '_, E, O> {
    /// Computes all contributions of paths with at least one edge of the camera subpath, one strategy after the other.
    pub fn pixel_contributions(&mut self, mut take: impl FnMut(Contribution)) {
        for j in 0..self.camera_subpath.vertices.len() {
            self.emission_s0(j).into_iter().for_each(&mut take);
            if !self.camera_subpath.vertices[j].is_connectible() {
                continue;
            }
            if self.allows(j + 1) {
                self.nee_s1(j).into_iter().for_each(&mut take);
            }
            for i in 0..self.light_surfaces() {
                if self.allows(i + j + 2) {
                    self.connection(i, j).into_iter().for_each(&mut take);
                }
            }
        }
        self.environment_s0().into_iter().flatten().for_each(take);
    }

    /// Computes all contributions of connections to the lens, at the places on the film for which `reaches` returns
    /// true.
    pub fn film_contributions(
        &mut self,
        viewpoint: impl Fn(Vec2) -> Viewpoint,
        reaches: &dyn Fn(Vec2) -> bool,
        mut take: impl FnMut(Contribution),
    ) {
        for i in 0..self.light_surfaces() {
            if self.allows(i + 1) {
                let splat = self.splat_t1(i, &viewpoint, reaches);
                splat.into_iter().for_each(&mut take);
            }
        }
    }

    /// Computes the contributions of one strategy, for subpaths that have at most as many surfaces as it uses. The
    /// environment makes two.
    pub fn by_strategy(
        &mut self,
        Strategy { s, t }: Strategy,
        viewpoint: impl Fn(Vec2) -> Viewpoint,
        reaches: &dyn Fn(Vec2) -> bool,
    ) -> [Option<Contribution>; 2] {
        if t == 1 {
            return [self.splat_t1(s - 2, &viewpoint, reaches), None];
        }
        let last = self.camera_subpath.vertices.last();
        let is_there = self.camera_subpath.vertices.len() + 1 == t;
        let is_connectible = is_there && last.is_some_and(SubpathVertex::is_connectible);
        match s {
            0 if is_there => [self.emission_s0(t - 2), None],
            0 if self.camera_subpath.vertices.len() + 2 == t => self.environment_s0(),
            1 if is_connectible => [self.nee_s1(t - 2), None],
            2.. if is_connectible => [self.connection(s - 2, t - 2), None],
            _ => [None; 2],
        }
    }

    /// Whether a path may have this number of scattering events.
    fn allows(&self, bounces: usize) -> bool {
        self.max_bounces.is_none_or(|most| bounces <= most as usize)
    }

    /// The number of surfaces of the light subpath.
    fn light_surfaces(&self) -> usize {
        self.light
            .as_ref()
            .map_or(0, |light| light.subpath.vertices.len())
    }

    /// The contribution of s = 1: next event estimation at the surface `j` of the camera subpath.
    fn nee_s1(&mut self, j: usize) -> Option<Contribution> {
        let (scene, camera_subpath) = (self.scene, self.camera_subpath);
        let vertex = &camera_subpath.vertices[j];
        let [u, v, u_choice, v_choice] = vertex.u;
        let (lights, receiver) = (&scene.lights, vertex.receiver());
        let u_choice = [u_choice, v_choice];
        let Some(choice) = lights.choose::<E>(self.light_choice, &receiver, u_choice) else {
            self.observer.unlit();
            return None;
        };
        let (from, rules) = (vertex.at.p, LightSampling::default());
        let u = Vec2::new(u, v);
        let found = scene.sample_light::<E>(choice, rules, from, self.time, u);
        let found = found.filter(|light| !light.radiance.is_black());
        let Some((light, at)) = found.and_then(|light| {
            let at = vertex.scattering(scene, vertex.at.wo, light.wi)?;
            Some((light, at))
        }) else {
            self.observer.unlit();
            return None;
        };
        let pdf = scene.pdf_emission(choice.0, self.time, &light.end, -light.wi);
        let (mut source, rays) = LightVertex::new(light.end, lights.pmf_by_power(choice.0), &pdf);
        source.nee_pdf = match light.pdf {
            Some(pdf) => source.density_from(from, pdf),
            None => choice.1.0.into(),
        };
        let offset = source.offset_to(from, -light.wi);
        let pdfs = ConnectionPdfs {
            by_camera: [source.density_from(from, at.pdf_to_light), 0.0],
            by_light: [
                rays.density_at(offset, vertex.at.ng),
                self.density_before(j, at.pdf_to_camera),
            ],
        };
        let strategy = Strategy { s: 1, t: j + 2 };
        let over_pdf = light.pdf.map_or(1.0, |pdf| 1.0 / pdf.0);
        let contribution = Contribution {
            strategy,
            film: None,
            unweighted: vertex.beta * at.to_camera * light.radiance * over_pdf,
            weight: self.weight(strategy, &source, &pdfs),
        };
        let ray = vertex.at.ray_to(&light.end, light.wi, at.is_transmitted);
        self.visible(&ray, contribution)
    }

    /// The contribution of s > 1, t > 1: the surface `i` of the light subpath is connected to the surface `j` of the
    /// camera subpath.
    pub fn connection(&mut self, i: usize, j: usize) -> Option<Contribution> {
        let light = self.light.as_ref()?;
        let (near, far) = (&self.camera_subpath.vertices[j], &light.subpath.vertices[i]);
        if !far.is_connectible() {
            return None;
        }
        let offset = far.at.p - near.at.p;
        let distance2 = offset.length_squared();
        let w = offset / distance2.sqrt();
        let at_near = near.scattering(self.scene, near.at.wo, w)?;
        let at_far = far.scattering(self.scene, -w, far.at.wo)?;
        let pdfs = ConnectionPdfs {
            by_camera: [
                far.density_from(near.at.p, at_near.pdf_to_light),
                light.density_before(i, at_far.pdf_to_light),
            ],
            by_light: [
                near.density_from(far.at.p, at_far.pdf_to_camera),
                self.density_before(j, at_near.pdf_to_camera),
            ],
        };
        let of_light = far.beta * at_far.to_camera * (at_far.adjoint / distance2);
        let unweighted = near.beta * at_near.to_camera * of_light;
        let end = ShadowRayEnd::Surface(far.at.surface_point(), [0.0; 2]);
        let ray = near.at.ray_to(&end, w, at_near.is_transmitted);
        let (source, strategy) = (light.source, Strategy { s: i + 2, t: j + 2 });
        let contribution = Contribution {
            strategy,
            film: None,
            unweighted,
            weight: self.weight(strategy, &source, &pdfs),
        };
        self.visible(&ray, contribution)
    }

    /// The contribution of t = 1: the surface `i` of the light subpath is connected to a point of the lens.
    fn splat_t1(
        &mut self,
        i: usize,
        viewpoint: impl Fn(Vec2) -> Viewpoint,
        reaches: &dyn Fn(Vec2) -> bool,
    ) -> Option<Contribution> {
        let light = self.light.as_ref()?;
        let vertex = &light.subpath.vertices[i];
        if !vertex.is_connectible() {
            return None;
        }
        let lens = viewpoint(Vec2::new(vertex.u[0], vertex.u[1]));
        let offset = lens.p - vertex.at.p;
        let distance2 = offset.length_squared();
        let w = offset / distance2.sqrt();
        let film = lens.film_point(-w)?;
        if !reaches(film.position) {
            return None;
        }
        let at = vertex.scattering(self.scene, w, vertex.at.wo)?;
        // Rays through the middle of the lens give the density of rays through any of its points.
        let middle = viewpoint(Vec2::splat(0.5)).film_point(-w)?;
        let rays = RayDensity::Point(middle.per_steradian * self.per_pixel);
        let pdfs = ConnectionPdfs {
            by_camera: [
                rays.density_at(-offset, vertex.at.ng),
                light.density_before(i, at.pdf_to_light),
            ],
            by_light: [0.0; 2],
        };
        let flux = planted!("splats-without-film", 1.0, film.per_steradian as f32);
        let unweighted = vertex.beta * at.to_camera * (at.adjoint * flux / distance2);
        let end = ShadowRayEnd::Point(lens.p);
        let ray = vertex.at.ray_to(&end, w, at.is_transmitted);
        let (source, strategy) = (light.source, Strategy { s: i + 2, t: 1 });
        let contribution = Contribution {
            strategy,
            film: Some(film.position),
            unweighted,
            weight: self.weight(strategy, &source, &pdfs),
        };
        self.visible(&ray, contribution)
    }

    /// The MIS weight of a strategy against all others that find its path, from the densities of both subpaths as far
    /// as it uses them, of the vertex on the light and of the connection.
    pub(super) fn weight(
        &mut self,
        Strategy { s, t }: Strategy,
        source: &LightVertex,
        pdfs: &ConnectionPdfs,
    ) -> f32 {
        let whole = &mut *self.whole;
        let vertices = s + t;
        whole.clear(vertices);
        // Without a vertex of the light subpath, the last surface of the camera subpath is the source.
        let surfaces = if s == 0 { t - 2 } else { t - 1 };
        for (j, vertex) in self.camera_subpath.vertices[..surfaces].iter().enumerate() {
            let place = vertices - 2 - j;
            whole.densities[place] = vertex.densities;
            whole.is_delta[place] = vertex.is_delta;
        }
        whole.begin(source);
        if let Some(light) = self.light.as_ref().filter(|_| s > 1) {
            for (i, vertex) in light.subpath.vertices[..s - 1].iter().enumerate() {
                whole.densities[i + 1] = vertex.densities;
                whole.is_delta[i + 1] = vertex.is_delta;
            }
        }
        whole.set_connection(s, pdfs);
        whole.weight(s) as f32
    }

    /// Traces the shadow ray of a connection, and returns the visible part of its contribution. Splats are not observed:
    /// they are not light of the sample's pixel.
    fn visible(&mut self, ray: &Ray, contribution: Contribution) -> Option<Contribution> {
        self.rays.shadow += 1;
        self.observer.traced(RayKind::Shadow, ray, self.time);
        let visible = self.scene.visibility::<E>(ray, self.time);
        if contribution.film.is_none() {
            let (value, weight) = (contribution.value(), contribution.weight);
            self.observer.light(value, weight, visible);
        }
        (visible > 0.0).then(|| Contribution {
            unweighted: contribution.unweighted * visible,
            ..contribution
        })
    }

    /// The density with which a light subpath continues from surface `j` of the camera subpath to the surface before
    /// `j`.
    fn density_before(&self, j: usize, pdf_to_camera: PdfSolidAngle) -> f64 {
        if j == 0 {
            return 0.0;
        }
        let from = self.camera_subpath.vertices[j].at.p;
        self.camera_subpath.vertices[j - 1].density_from(from, pdf_to_camera)
    }
}

impl<E: Effects> LightSubpath<'_, '_, E> {
    /// The density with which a camera subpath continues from surface `i` to the vertex before `i`.
    fn density_before(&self, i: usize, pdf_to_light: PdfSolidAngle) -> f64 {
        let from = self.subpath.vertices[i].at.p;
        match i {
            0 => self.source.density_from(from, pdf_to_light),
            _ => self.subpath.vertices[i - 1].density_from(from, pdf_to_light),
        }
    }
}
