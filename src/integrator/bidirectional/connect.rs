//! Every way of making one path of a walk from the eye and a walk from a light.
//!
//! With s vertices of the one from the light and t of the one from the eye, ends included:
//!
//! - s = 0: the walk from the eye meets a light, or leaves the scene for one beyond.
//! - s = 1: a light is looked for from its last surface.
//! - s > 1, t > 1: the last surfaces of both are connected, beta_eye f_eye G V f_light beta_light.
//! - t = 1: the last surface of the walk from the light is connected to a point of the lens, and falls somewhere on the film.
//!
//! Each is weighted against all others that find the same path ([`WholePath`]).
//!
//! Measure: radiance; of what falls on the film elsewhere, radiance times light paths.
//! Range: any walks through the same scene at the same time.
//! Source: Veach 1997, section 10.2 and 10.3.4. Tested in `tests/rendering/bidirectional.rs`.

use super::vertex::{Source, Spread, Vertex};
use super::walk::Walked;
use super::weights::{Join, WholePath};
use crate::camera::Viewpoint;
use crate::effects::{Effects, Switch};
use crate::film::splats::{SplatSink, Strategy};
use crate::geometry::surface::SurfacePoint;
use crate::integrator::RayCounts;
use crate::integrator::observer::{PathObserver, RayKind};
use crate::light::types::{EmissionPdf, LightEnd, PointRule};
use crate::math::measure::PdfSolidAngle;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;

/// A walk from a light, and where it began.
#[derive(Debug)]
pub struct LightPath<'a, E: Effects> {
    /// The light's end.
    pub source: Source,
    /// The density of the rays that go on from there.
    #[cfg(test)]
    pub spread: Spread,
    /// The surfaces after it.
    pub walked: Walked<'a, E>,
}

/// Makes paths of two walks.
pub struct Connector<'a, 'w, E: Effects, O> {
    pub scene: &'a Scene,
    /// When.
    pub time: f32,
    /// Scattering events at most.
    pub max_bounces: Option<u32>,
    /// The density of light paths' ends on the film, per pixel, if each pixel has one for each of its samples.
    pub per_pixel: f64,
    /// From a light, if any shines.
    pub light: Option<LightPath<'a, E>>,
    /// From the eye.
    pub eye: &'w Walked<'a, E>,
    pub rays: &'w mut RayCounts,
    pub observer: &'w mut O,
    pub whole: WholePath,
}

impl<'a, E: Effects, O: PathObserver> Connector<'a, '_, E, O> {
    /// Everything that the walk from the eye finds: with at least one surface of it, or none if it leaves at once.
    pub fn radiance<P: SplatSink>(&mut self, splats: &mut P) -> Rgb {
        let mut radiance = Rgb::BLACK;
        for j in 0..self.eye.vertices.len() {
            radiance += self.met(j, splats);
            if !self.eye.vertices[j].is_connectible() {
                continue;
            }
            if self.allows(j + 1) {
                radiance += self.looked_for(j, splats);
            }
            let surfaces = self
                .light
                .as_ref()
                .map_or(0, |light| light.walked.vertices.len());
            for i in 0..surfaces {
                if self.allows(i + j + 2) {
                    radiance += self.connected(i, j, splats);
                }
            }
        }
        radiance + self.beyond(splats)
    }

    /// What one strategy finds, of walks that have as many surfaces as it takes at most.
    pub fn by_strategy<P: SplatSink>(
        &mut self,
        s: usize,
        t: usize,
        viewpoint: impl Fn(Vec2) -> Viewpoint,
        splats: &mut P,
    ) {
        if t == 1 {
            self.lens_connected(s - 2, &viewpoint, splats);
            return;
        }
        let last = self.eye.vertices.last();
        let is_there = self.eye.vertices.len() + 1 == t;
        let is_connectible = is_there && last.is_some_and(Vertex::is_connectible);
        match s {
            0 if is_there => self.met(t - 2, splats),
            0 if self.eye.vertices.len() + 2 == t => self.beyond(splats),
            1 if is_connectible => self.looked_for(t - 2, splats),
            2.. if is_connectible => self.connected(s - 2, t - 2, splats),
            _ => Rgb::BLACK,
        };
    }

    /// Whether a path may scatter so often.
    fn allows(&self, bounces: usize) -> bool {
        self.max_bounces.is_none_or(|most| bounces <= most as usize)
    }

    /// s = 0: the surface `j` of the walk from the eye emits.
    fn met<P: SplatSink>(&mut self, j: usize, splats: &mut P) -> Rgb {
        let (scene, vertex) = (self.scene, &self.eye.vertices[j]);
        let Some(emitted) = scene.emitted(&vertex.at) else {
            return Rgb::BLACK;
        };
        let mut weight = 1.0;
        if j > 0
            && let Some(light) = scene.light_of(&vertex.at)
        {
            let before = &self.eye.vertices[j - 1];
            let looked = scene.light_pdf(before.at.p, self.time, &vertex.at);
            let end = LightEnd::Surface(point_of(&vertex.at), [0.0; 2]);
            let pdf = self.emission_pdf(light, &end, vertex.at.wo);
            let (mut source, spread) = Source::new(end, scene.lights.pmf(light), &pdf);
            source.direct = source.density_from(before.at.p, looked);
            source.densities.by_eye = vertex.densities.by_eye;
            let at_before = spread.density_at(before.at.p - vertex.at.p, before.at.ng);
            write_eye(&mut self.whole, self.eye, j + 2, j);
            self.whole.begin(&source);
            self.whole.densities[1].by_light = at_before;
            weight = self.whole.weight(0) as f32;
        }
        let unweighted = vertex.beta * emitted;
        splats.made(Strategy { s: 0, t: j + 2 }, None, unweighted, weight);
        let contribution = unweighted * weight;
        self.observer.emission(contribution, weight);
        contribution
    }

    /// s = 0: light from beyond the scene.
    fn beyond<P: SplatSink>(&mut self, splats: &mut P) -> Rgb {
        let Some(escape) = self.eye.escape.filter(|_| E::Environment::ON) else {
            return Rgb::BLACK;
        };
        let by = Strategy {
            s: 0,
            t: self.eye.vertices.len() + 2,
        };
        let mut radiance = self.scene.environment;
        splats.made(by, None, escape.beta * radiance, 1.0);
        if E::EnvironmentMap::ON
            && let Some(beyond) = self.scene.lights.beyond(escape.direction)
        {
            let mut weight = 1.0;
            if let Some(last) = self.eye.vertices.last() {
                let end = LightEnd::Infinity;
                let pdf = self.emission_pdf(beyond.light, &end, -escape.direction);
                let pmf = self.scene.lights.pmf(beyond.light);
                let (mut source, spread) = Source::new(end, pmf, &pdf);
                source.direct = beyond.pdf.0.into();
                source.densities.by_eye = match escape.spread {
                    Spread::Rays(density) | Spread::Beam(density) => density,
                };
                let at_last = spread.density_at(-escape.direction, last.at.ng);
                let surfaces = self.eye.vertices.len();
                write_eye(&mut self.whole, self.eye, surfaces + 2, surfaces);
                self.whole.begin(&source);
                self.whole.densities[1].by_light = at_last;
                weight = self.whole.weight(0) as f32;
            }
            splats.made(by, None, escape.beta * beyond.radiance, weight);
            radiance += beyond.radiance * weight;
        }
        let contribution = escape.beta * radiance;
        self.observer.environment(contribution);
        contribution
    }

    /// s = 1: a light is looked for from the surface `j` of the walk from the eye.
    fn looked_for<P: SplatSink>(&mut self, j: usize, splats: &mut P) -> Rgb {
        let (scene, vertex) = (self.scene, &self.eye.vertices[j]);
        let [u, v, u_choice, v_choice] = vertex.u;
        let Some(choice) = scene.lights.choose::<E>([u_choice, v_choice]) else {
            return Rgb::BLACK;
        };
        let (from, points) = (vertex.at.p, PointRule::SolidAngle);
        let u = Vec2::new(u, v);
        let found = scene.sample_light::<E>(choice, points, from, self.time, u);
        let found = found.filter(|light| !light.radiance.is_black());
        let Some((light, at)) = found.and_then(|light| {
            let at = vertex.scattering(scene, vertex.at.wo, light.wi)?;
            Some((light, at))
        }) else {
            self.observer.unlit();
            return Rgb::BLACK;
        };
        let pdf = self.emission_pdf(choice.0, &light.end, -light.wi);
        let (mut source, spread) = Source::new(light.end, choice.1, &pdf);
        if let Some(pdf) = light.pdf {
            source.direct = source.density_from(from, pdf);
        }
        let way = match &light.end {
            LightEnd::Surface(point, _) => from - point.p,
            LightEnd::Point(point) => from - *point,
            LightEnd::Infinity => -light.wi,
        };
        write_eye(&mut self.whole, self.eye, j + 3, j + 1);
        self.whole.begin(&source);
        let join = Join {
            by_eye: [source.density_from(from, at.pdf_to_light), 0.0],
            by_light: [
                spread.density_at(way, vertex.at.ng),
                self.density_before(j, at.pdf_to_eye),
            ],
        };
        self.whole.join(1, &join);
        let weight = self.whole.weight(1) as f32;
        let over_pdf = light.pdf.map_or(1.0, |pdf| 1.0 / pdf.0);
        let unweighted = vertex.beta * at.to_eye * light.radiance * over_pdf;
        let contribution = unweighted * weight;
        let ray = vertex.at.ray_to(&light.end, light.wi, at.goes_through);
        let visible = self.seen(&ray, contribution, weight);
        splats.made(
            Strategy { s: 1, t: j + 2 },
            None,
            unweighted * visible,
            weight,
        );
        contribution * visible
    }

    /// s > 1, t > 1: the surface `i` of the walk from the light is connected to the surface `j` of that from the eye.
    pub fn connected<P: SplatSink>(&mut self, i: usize, j: usize, splats: &mut P) -> Rgb {
        let Some(light) = &self.light else {
            return Rgb::BLACK;
        };
        let (near, far) = (&self.eye.vertices[j], &light.walked.vertices[i]);
        if !far.is_connectible() {
            return Rgb::BLACK;
        }
        let way = far.at.p - near.at.p;
        let distance2 = way.length_squared();
        let w = way / distance2.sqrt();
        let Some((at_near, at_far)) = near
            .scattering(self.scene, near.at.wo, w)
            .and_then(|at_near| Some((at_near, far.scattering(self.scene, -w, far.at.wo)?)))
        else {
            return Rgb::BLACK;
        };
        let s = i + 2;
        write_eye(&mut self.whole, self.eye, s + j + 2, j + 1);
        light.write(&mut self.whole, i + 1);
        let join = Join {
            by_eye: [
                far.density_from(near.at.p, at_near.pdf_to_light),
                light.density_before(i, at_far.pdf_to_light),
            ],
            by_light: [
                near.density_from(far.at.p, at_far.pdf_to_eye),
                self.density_before(j, at_near.pdf_to_eye),
            ],
        };
        self.whole.join(s, &join);
        let weight = self.whole.weight(s) as f32;
        let of_light = far.beta * at_far.to_eye * (at_far.adjoint / distance2);
        let unweighted = near.beta * at_near.to_eye * of_light;
        let contribution = unweighted * weight;
        let end = LightEnd::Surface(point_of(&far.at), [0.0; 2]);
        let ray = near.at.ray_to(&end, w, at_near.goes_through);
        let visible = self.seen(&ray, contribution, weight);
        splats.made(Strategy { s, t: j + 2 }, None, unweighted * visible, weight);
        contribution * visible
    }

    /// t = 1: everything that the walk from the light brings to the lens.
    pub fn splat<P: SplatSink>(&mut self, viewpoint: impl Fn(Vec2) -> Viewpoint, splats: &mut P) {
        let surfaces = self
            .light
            .as_ref()
            .map_or(0, |light| light.walked.vertices.len());
        for i in 0..surfaces {
            if self.allows(i + 1) {
                self.lens_connected(i, &viewpoint, splats);
            }
        }
    }

    fn lens_connected<P: SplatSink>(
        &mut self,
        i: usize,
        viewpoint: impl Fn(Vec2) -> Viewpoint,
        splats: &mut P,
    ) -> Option<()> {
        let light = self.light.as_ref()?;
        let vertex = &light.walked.vertices[i];
        if !vertex.is_connectible() {
            return None;
        }
        let lens = viewpoint(Vec2::new(vertex.u[0], vertex.u[1]));
        let way = lens.p - vertex.at.p;
        let distance2 = way.length_squared();
        let w = way / distance2.sqrt();
        let film = lens.film_point(-w)?;
        if !splats.reaches(film.position) {
            return None;
        }
        let at = vertex.scattering(self.scene, w, vertex.at.wo)?;
        let s = i + 2;
        // Rays through the middle of the lens tell the density of rays through any of its points.
        let middle = viewpoint(Vec2::splat(0.5)).film_point(-w)?;
        let per_steradian = Spread::Rays(middle.per_steradian * self.per_pixel);
        self.whole.clear(s + 1);
        light.write(&mut self.whole, i + 1);
        let join = Join {
            by_eye: [
                per_steradian.density_at(-way, vertex.at.ng),
                light.density_before(i, at.pdf_to_light),
            ],
            by_light: [0.0; 2],
        };
        self.whole.join(s, &join);
        let weight = self.whole.weight(s) as f32;
        let flux = planted!("splats-without-film", 1.0, film.per_steradian as f32);
        let unweighted = vertex.beta * at.to_eye * (at.adjoint * flux / distance2);
        let ray = vertex
            .at
            .ray_to(&LightEnd::Point(lens.p), w, at.goes_through);
        self.rays.shadow += 1;
        self.observer.traced(RayKind::Shadow, &ray, self.time);
        let visible = self.scene.visibility::<E>(&ray, self.time);
        if visible > 0.0 {
            let contribution = unweighted * visible;
            let place = film.position;
            splats.made(Strategy { s, t: 1 }, Some(place), contribution, weight);
            splats.splat(place, contribution * weight);
        }
        Some(())
    }

    /// The share of light that comes along a ray, of a contribution that is told.
    fn seen(&mut self, ray: &Ray, contribution: Rgb, weight: f32) -> f32 {
        self.rays.shadow += 1;
        self.observer.traced(RayKind::Shadow, ray, self.time);
        let visible = self.scene.visibility::<E>(ray, self.time);
        self.observer.light(contribution, weight, visible);
        visible
    }

    fn emission_pdf(&self, light: u32, end: &LightEnd, direction: Vec3) -> EmissionPdf {
        let normal = match end {
            LightEnd::Surface(point, _) => point.ng,
            LightEnd::Point(_) | LightEnd::Infinity => Vec3::ZERO,
        };
        let around = &self.scene.around;
        let light = self.scene.lights.get(light);
        light.pdf_emission(self.time, normal, direction, around)
    }

    /// The density with which a path from the light goes on from surface `j` of the walk from the eye to the one before.
    fn density_before(&self, j: usize, pdf_to_eye: PdfSolidAngle) -> f64 {
        if j == 0 {
            return 0.0;
        }
        let from = self.eye.vertices[j].at.p;
        self.eye.vertices[j - 1].density_from(from, pdf_to_eye)
    }
}

impl<E: Effects> LightPath<'_, E> {
    /// The density with which a path from the eye goes on from surface `i` to what is before it.
    fn density_before(&self, i: usize, pdf_to_light: PdfSolidAngle) -> f64 {
        let from = self.walked.vertices[i].at.p;
        match i {
            0 => self.source.density_from(from, pdf_to_light),
            _ => self.walked.vertices[i - 1].density_from(from, pdf_to_light),
        }
    }

    /// Writes the source and the first surfaces down.
    fn write(&self, whole: &mut WholePath, surfaces: usize) {
        whole.begin(&self.source);
        for (i, vertex) in self.walked.vertices[..surfaces].iter().enumerate() {
            whole.densities[i + 1] = vertex.densities;
            whole.is_delta[i + 1] = vertex.is_delta;
        }
    }
}

/// Begins a path of so many vertices, and writes the first surfaces from the eye down, which stand at its end.
fn write_eye<E: Effects>(
    whole: &mut WholePath,
    eye: &Walked<'_, E>,
    vertices: usize,
    surfaces: usize,
) {
    whole.clear(vertices);
    for (j, vertex) in eye.vertices[..surfaces].iter().enumerate() {
        let place = vertices - 2 - j;
        whole.densities[place] = vertex.densities;
        whole.is_delta[place] = vertex.is_delta;
    }
}

/// The interaction's point as one of its surface.
fn point_of<E: Effects>(at: &Interaction<E>) -> SurfacePoint {
    SurfacePoint {
        p: at.p,
        error: at.error,
        ng: at.ng,
        ns: at.ng,
    }
}
