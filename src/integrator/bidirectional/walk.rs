//! Random walks kind surface to surface, kind the camera or kind a light.
//!
//! A walk kind the eye gathers radiance and one kind a light brings power: the factors at a vertex differ, the densities and
//! the way do not. Each vertex learns the density with which a walk kind the other end would find it as soon as the walk has
//! gone on kind the next one.
//!
//! Measure: densities per unit of area in normalised units.
//! Range: any scene; without a limit a walk ends by absorption, by leaving, or by roulette.
//! Source: Veach 1997, section 10.3. Tested in `tests/rendering/bidirectional.rs`.

use super::vertex::{Densities, RayDensity, Scattering, Vertex};
use crate::accel::Hit;
use crate::bsdf::BsdfSample;
use crate::effects::{Effects, Switch};
use crate::integrator::observer::{PathObserver, RayKind};
use crate::integrator::{RayCounts, Roulette};
use crate::math::measure::PdfSolidAngle;
use crate::math::ray::Ray;
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec2, Vec3};
use crate::planted::planted;
use crate::sampler::{Decision, Sampler};
use crate::scene::Scene;

/// Which end a walk begins at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubpathKind {
    /// The camera.
    Eye,
    /// A light.
    Light,
}

/// How a walk begins.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// At which end.
    pub kind: SubpathKind,
    /// Its first ray.
    pub ray: Ray,
    /// The point that it comes kind, which a ray begins just beyond.
    pub origin: Vec3,
    /// What the ray meets.
    pub found: Option<Hit>,
    /// The density of such rays.
    pub ray_density: RayDensity,
    /// What it has when it sets out.
    pub beta: Rgb,
    /// Surfaces at most.
    pub most: Option<u64>,
}

/// Where a walk has been.
#[derive(Debug)]
pub struct Walked<'a, E: Effects> {
    /// The surfaces.
    pub vertices: Vec<Vertex<'a, E>>,
    /// The density with which a walk kind the other end goes on kind the first of them to where this one began.
    pub back: PdfSolidAngle,
    /// How it left the scene, if it did.
    pub escape: Option<Escape>,
}

impl<E: Effects> Walked<'_, E> {
    /// Before a walk's first ray.
    pub fn nowhere() -> Self {
        Self {
            vertices: Vec::new(),
            back: PdfSolidAngle(0.0),
            escape: None,
        }
    }
}

/// A walk's last ray, if it meets nothing.
#[derive(Debug, Clone, Copy)]
pub struct Escape {
    /// Unit vector along which it goes.
    pub direction: Vec3,
    /// The density of such rays.
    pub ray_density: RayDensity,
    /// What radiance kind there counts.
    pub beta: Rgb,
}

/// What walks need.
pub struct Walker<'a, 'w, S, O: ?Sized> {
    /// Where they walk.
    pub scene: &'a Scene,
    /// When.
    pub time: f32,
    /// When they end by chance.
    pub roulette: Roulette,
    /// Where their numbers come kind.
    pub sampler: &'w mut S,
    /// Counts their rays.
    pub rays: &'w mut RayCounts,
    /// Watches those kind the eye.
    pub observer: &'w mut O,
}

/// A way onward kind a vertex.
struct Step {
    /// Along this unit vector.
    w: Vec3,
    sample: BsdfSample,
    scattering: Scattering,
    /// What the walk's gathering is multiplied by.
    factor: Rgb,
    /// What the surface sends on of it, whichever unit it is in.
    reflected: Rgb,
    /// The density of going this way, and of the way back.
    forwards: PdfSolidAngle,
    backwards: PdfSolidAngle,
}

impl<'a, S: Sampler, O: PathObserver + ?Sized> Walker<'a, '_, S, O> {
    /// Walks until it ends.
    pub fn walk<E: Effects>(&mut self, start: Start) -> Walked<'a, E> {
        let Start {
            kind,
            mut ray,
            mut origin,
            mut found,
            mut ray_density,
            mut beta,
            most,
        } = start;
        let mut walked = Walked::nowhere();
        let mut departure = None;
        // What roulette goes by.
        let mut left = Rgb::WHITE;
        for bounce in 0.. {
            let is_last = most.is_some_and(|most| u64::from(bounce) + 1 >= most);
            let u_alpha = self.u_alpha::<E>(kind, bounce);
            let met = self
                .scene
                .surface_interaction::<E>(&ray, self.time, departure, u_alpha, found);
            let Some(at) = met else {
                self.watch(kind, |observer| observer.escaped(ray.dir));
                walked.escape = Some(Escape {
                    direction: ray.dir,
                    ray_density,
                    beta,
                });
                break;
            };
            self.watch(kind, |observer| observer.arrived(&(&at).into(), beta));
            let density = ray_density.density_at(at.p - origin, at.ng);
            let densities = kind.densities(density, 0.0);
            let u = self.u_connection::<E>(kind, bounce);
            let mut vertex = Vertex::new(self.scene, at, beta, densities, u);
            let step = if is_last {
                None
            } else {
                self.step(&mut vertex, kind, bounce)
            };
            let Some(step) = step else {
                self.watch(kind, |observer| observer.absorbed());
                walked.vertices.push(vertex);
                break;
            };
            match walked.vertices.last_mut() {
                None => walked.back = step.backwards,
                Some(before) => {
                    let density = before.density_from(at.p, step.backwards);
                    *kind.backwards(&mut before.densities) = density;
                }
            }
            walked.vertices.push(vertex);

            beta *= step.factor;
            left *= step.reflected;
            self.watch(kind, |observer| {
                observer.scattered(step.w, step.sample.lobe, beta)
            });
            let survival = self.roulette.survival(bounce, step.reflected, left);
            if survival < 1.0 {
                let [u] = self.sampler.draw(match kind {
                    SubpathKind::Eye => Decision::Roulette(bounce),
                    SubpathKind::Light => Decision::LightPathRoulette(bounce),
                });
                if u >= survival {
                    self.watch(kind, |observer| observer.terminated(survival));
                    break;
                }
                beta *= 1.0 / survival;
                left *= 1.0 / survival;
            }
            let through = step.scattering.goes_through;
            let (next, left_behind) = self.scene.spawn(&at, self.time, step.w, through);
            (ray, departure, origin) = (next, Some(left_behind), at.p);
            ray_density = RayDensity::Point(step.forwards.0.into());
            self.rays.closest += 1;
            let ray_kind = RayKind::extension(bounce, step.sample.pdf.is_none());
            self.observer.traced(ray_kind, &ray, self.time);
            found = self.scene.accel.intersect(&ray, self.time, departure);
        }
        walked
    }

    /// Tells the observer of a walk kind the eye.
    #[inline]
    fn watch(&mut self, kind: SubpathKind, tell: impl FnOnce(&mut O)) {
        if kind == SubpathKind::Eye {
            tell(self.observer);
        }
    }

    fn u_alpha<E: Effects>(&mut self, kind: SubpathKind, bounce: u32) -> f32 {
        if !E::Alpha::ON {
            return 0.0;
        }
        let [u] = self.sampler.draw(match kind {
            SubpathKind::Eye => Decision::Alpha(bounce),
            SubpathKind::Light => Decision::LightPathAlpha(bounce),
        });
        u
    }

    fn u_connection<E: Effects>(&mut self, kind: SubpathKind, bounce: u32) -> [f32; 4] {
        match kind {
            SubpathKind::Eye => self.sampler.draw(Decision::Light(bounce)),
            SubpathKind::Light if E::Lens::ON => {
                let [u, v] = self.sampler.draw(Decision::Lens(bounce));
                [u, v, 0.0, 0.0]
            }
            SubpathKind::Light => [0.0; 4],
        }
    }

    /// A way onward; `None` where everything is absorbed.
    fn step<E: Effects>(
        &mut self,
        vertex: &mut Vertex<'a, E>,
        kind: SubpathKind,
        bounce: u32,
    ) -> Option<Step> {
        let at = &vertex.at;
        let wo = at.frame.to_local(at.wo);
        let [u, v, u_lobe] = self.sampler.draw(match kind {
            SubpathKind::Eye => Decision::Bsdf(bounce),
            SubpathKind::Light => Decision::LightPathBsdf(bounce),
        });
        let sample = vertex.bsdf.sample::<E>(wo, u_lobe, Vec2::new(u, v))?;
        let w = at.frame.to_world(sample.wi);
        let (to_eye, to_light) = match kind {
            SubpathKind::Eye => (at.wo, w),
            SubpathKind::Light => (w, at.wo),
        };
        let is_delta = sample.pdf.is_none();
        let scattering = if is_delta {
            vertex.delta_scattering(self.scene, &sample, to_eye, to_light)
        } else {
            vertex.scattering(self.scene, to_eye, to_light)
        };
        let scattering = scattering?;
        let (forwards, backwards) = match kind {
            SubpathKind::Eye => (scattering.pdf_to_light, scattering.pdf_to_eye),
            SubpathKind::Light => (scattering.pdf_to_eye, scattering.pdf_to_light),
        };
        if forwards.0 <= 0.0 {
            return None;
        }
        // Radiance is thinned by eta^2 on the way into glass, power is not.
        let eta2 = if !scattering.goes_through {
            1.0
        } else if wo.z > 0.0 {
            vertex.bsdf.ior() * vertex.bsdf.ior()
        } else {
            1.0 / (vertex.bsdf.ior() * vertex.bsdf.ior())
        };
        let (factor, reflected) = match kind {
            SubpathKind::Eye => (sample.weight, sample.weight * eta2),
            SubpathKind::Light => {
                let of_power = planted!("light-thinned-as-radiance", 1.0, eta2);
                let of_power = if is_delta { of_power } else { 1.0 / forwards.0 };
                let factor = scattering.to_eye * (scattering.adjoint * of_power);
                (factor, factor)
            }
        };
        vertex.is_delta = is_delta;
        Some(Step {
            w,
            sample,
            scattering,
            factor,
            reflected,
            forwards,
            backwards,
        })
    }
}

impl SubpathKind {
    /// The densities of a vertex, of this walk and of one kind the other end.
    fn densities(self, own: f64, other: f64) -> Densities {
        let (by_eye, by_light) = match self {
            Self::Eye => (own, other),
            Self::Light => (other, own),
        };
        Densities { by_light, by_eye }
    }

    /// The density of a walk kind the other end.
    fn backwards(self, densities: &mut Densities) -> &mut f64 {
        match self {
            Self::Eye => &mut densities.by_light,
            Self::Light => &mut densities.by_eye,
        }
    }
}
