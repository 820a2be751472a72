//! Random walks from surface to surface, from the camera or from a light.
//!
//! A camera subpath gathers radiance and a light subpath carries power: their factors at a vertex differ, their
//! densities and procedure do not. The density with which a subpath from the other end finds a vertex is known as soon
//! as the subpath has continued from the next vertex.
//!
//! Measure: densities per unit of area in normalised units.
//! Range: any scene; without a limit a subpath ends by absorption, by leaving the scene, or by roulette.
//! Source: Veach 1997, section 10.3. Tested in `tests/rendering/bidirectional.rs`.

use super::vertex::{Densities, RayDensity, Scattering, SubpathVertex};
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

/// The end at which a subpath begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubpathKind {
    /// The camera.
    Camera,
    /// A light.
    Light,
}

/// The beginning of a subpath.
#[derive(Debug, Clone, Copy)]
pub struct SubpathStart {
    /// The end at which it begins.
    pub kind: SubpathKind,
    /// The first ray.
    pub ray: Ray,
    /// The point from which the ray comes; the ray begins just beyond.
    pub origin: Vec3,
    /// The closest hit on the ray.
    pub hit: Option<Hit>,
    /// The density of such rays.
    pub ray_density: RayDensity,
    /// The initial throughput.
    pub beta: Rgb,
    /// The largest number of surfaces.
    pub max_surfaces: Option<u64>,
}

/// The vertices of a subpath, and how it ended.
#[derive(Debug)]
pub struct Subpath<'a, E: Effects> {
    /// The vertices on surfaces.
    pub vertices: Vec<SubpathVertex<'a, E>>,
    /// The density with which a subpath from the other end continues from the first vertex to where this one began.
    pub pdf_to_start: PdfSolidAngle,
    /// The last ray, if it left the scene.
    pub escape: Option<Escape>,
}

impl<E: Effects> Default for Subpath<'_, E> {
    fn default() -> Self {
        Self {
            vertices: Vec::new(),
            pdf_to_start: PdfSolidAngle(0.0),
            escape: None,
        }
    }
}

impl<E: Effects> Subpath<'_, E> {
    /// Removes all vertices and keeps the memory.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.pdf_to_start = PdfSolidAngle(0.0);
        self.escape = None;
    }
}

/// The last ray of a subpath, if it hits nothing.
#[derive(Debug, Clone, Copy)]
pub struct Escape {
    /// The unit vector of its direction.
    pub direction: Vec3,
    /// The density of such rays.
    pub ray_density: RayDensity,
    /// The throughput: the factor of radiance from there.
    pub beta: Rgb,
}

/// The context in which subpaths are sampled.
pub struct SubpathSampler<'a, 'w, S, O: ?Sized> {
    /// The scene.
    pub scene: &'a Scene,
    /// The time.
    pub time: f32,
    /// The rule of Russian roulette.
    pub roulette: Roulette,
    /// The source of random numbers.
    pub sampler: &'w mut S,
    /// The counts of the rays.
    pub rays: &'w mut RayCounts,
    /// The observer of camera subpaths, and of all rays.
    pub observer: &'w mut O,
}

/// A sampled step from a vertex.
pub struct WalkStep {
    /// The unit vector of the direction.
    pub w: Vec3,
    /// The sample of the BSDF.
    pub sample: BsdfSample,
    /// The scattering in this direction.
    pub scattering: Scattering,
    /// The factor of the throughput.
    pub factor: Rgb,
    /// The share that the surface scatters, for Russian roulette: without the factor of eta^2 that radiance has.
    pub reflected: Rgb,
    /// The densities of this direction, and of the reverse direction.
    pub forwards: PdfSolidAngle,
    pub backwards: PdfSolidAngle,
}

impl<'a, S: Sampler, O: PathObserver + ?Sized> SubpathSampler<'a, '_, S, O> {
    /// Samples a subpath until it ends, in the memory of another.
    pub fn sample<E: Effects>(&mut self, start: SubpathStart, subpath: &mut Subpath<'a, E>) {
        let SubpathStart {
            kind,
            mut ray,
            mut origin,
            mut hit,
            mut ray_density,
            mut beta,
            max_surfaces,
        } = start;
        subpath.clear();
        let mut excluded = None;
        // The throughput for Russian roulette.
        let mut rr_beta = Rgb::WHITE;
        let rule = self.roulette.survival();
        for bounce in 0.. {
            let is_last = max_surfaces.is_some_and(|limit| u64::from(bounce) + 1 >= limit);
            let u_alpha = self.u_alpha::<E>(kind, bounce);
            let interaction = self
                .scene
                .surface_interaction::<E>(&ray, self.time, excluded, u_alpha, hit);
            let Some(at) = interaction else {
                self.observe(kind, |observer| observer.escaped(ray.dir));
                subpath.escape = Some(Escape {
                    direction: ray.dir,
                    ray_density,
                    beta,
                });
                break;
            };
            self.observe(kind, |observer| observer.arrived(&(&at).into(), beta));
            let density = ray_density.density_at(at.p - origin, at.ng);
            let densities = kind.densities(density, 0.0);
            let u = self.u_connection::<E>(kind, bounce);
            let mut vertex = SubpathVertex::new(self.scene, at, beta, densities, u);
            let step = if is_last {
                None
            } else {
                self.step(&mut vertex, kind, bounce)
            };
            let Some(step) = step else {
                self.observe(kind, |observer| observer.absorbed());
                subpath.vertices.push(vertex);
                break;
            };
            match subpath.vertices.last_mut() {
                None => subpath.pdf_to_start = step.backwards,
                Some(before) => {
                    let density = before.density_from(at.p, step.backwards);
                    *kind.backwards(&mut before.densities) = density;
                }
            }
            subpath.vertices.push(vertex);

            beta *= step.factor;
            rr_beta *= step.reflected;
            self.observe(kind, |observer| {
                observer.scattered(step.w, step.sample.lobe, beta)
            });
            let survival = rule.probability(bounce, step.reflected, rr_beta);
            if survival < 1.0 {
                let [u] = self.sampler.draw(match kind {
                    SubpathKind::Camera => Decision::Roulette(bounce),
                    SubpathKind::Light => Decision::LightPathRoulette(bounce),
                });
                if u >= survival {
                    self.observe(kind, |observer| observer.terminated(survival));
                    break;
                }
                let correction = rule.correction(survival);
                beta *= correction;
                rr_beta *= correction;
            }
            let through = step.scattering.is_transmitted;
            let (next, next_excluded) = self.scene.spawn(&at, self.time, step.w, through);
            (ray, excluded, origin) = (next, Some(next_excluded), at.p);
            ray_density = RayDensity::Point(step.forwards.0.into());
            self.rays.closest += 1;
            let ray_kind = RayKind::extension(bounce, step.sample.pdf.is_none());
            self.observer.traced(ray_kind, &ray, self.time);
            hit = self.scene.accel.intersect(&ray, self.time, excluded);
        }
    }

    /// Calls the observer of a camera subpath.
    #[inline]
    fn observe(&mut self, kind: SubpathKind, tell: impl FnOnce(&mut O)) {
        if kind == SubpathKind::Camera {
            tell(self.observer);
        }
    }

    /// The number for the alpha test of a hit.
    pub fn u_alpha<E: Effects>(&mut self, kind: SubpathKind, bounce: u32) -> f32 {
        if !E::Alpha::ON {
            return 0.0;
        }
        let [u] = self.sampler.draw(match kind {
            SubpathKind::Camera => Decision::Alpha(bounce),
            SubpathKind::Light => Decision::LightPathAlpha(bounce),
        });
        u
    }

    /// The numbers for the point that a vertex is connected to.
    pub fn u_connection<E: Effects>(&mut self, kind: SubpathKind, bounce: u32) -> [f32; 4] {
        match kind {
            SubpathKind::Camera => self.sampler.draw(Decision::Light(bounce)),
            SubpathKind::Light if E::Lens::ON => {
                let [u, v] = self.sampler.draw(Decision::Lens(bounce));
                [u, v, 0.0, 0.0]
            }
            SubpathKind::Light => [0.0; 4],
        }
    }

    /// Samples the step from a vertex; `None` where everything is absorbed.
    pub fn step<E: Effects>(
        &mut self,
        vertex: &mut SubpathVertex<'a, E>,
        kind: SubpathKind,
        bounce: u32,
    ) -> Option<WalkStep> {
        let at = &vertex.at;
        let wo = at.frame.to_local(at.wo);
        let [u, v, u_lobe] = self.sampler.draw(match kind {
            SubpathKind::Camera => Decision::Bsdf(bounce),
            SubpathKind::Light => Decision::LightPathBsdf(bounce),
        });
        let sample = vertex.bsdf.sample::<E>(wo, u_lobe, Vec2::new(u, v))?;
        let w = at.frame.to_world(sample.wi);
        let (to_camera, to_light) = match kind {
            SubpathKind::Camera => (at.wo, w),
            SubpathKind::Light => (w, at.wo),
        };
        let is_delta = sample.pdf.is_none();
        let scattering = if is_delta {
            vertex.delta_scattering(self.scene, &sample, to_camera, to_light)
        } else {
            vertex.scattering(self.scene, to_camera, to_light)
        };
        let scattering = scattering?;
        let (forwards, backwards) = match kind {
            SubpathKind::Camera => (scattering.pdf_to_light, scattering.pdf_to_camera),
            SubpathKind::Light => (scattering.pdf_to_camera, scattering.pdf_to_light),
        };
        if forwards.0 <= 0.0 {
            return None;
        }
        // Radiance is divided by eta^2 on the way into glass, power is not.
        let eta2 = if !scattering.is_transmitted {
            1.0
        } else if wo.z > 0.0 {
            vertex.bsdf.ior() * vertex.bsdf.ior()
        } else {
            1.0 / (vertex.bsdf.ior() * vertex.bsdf.ior())
        };
        let (factor, reflected) = match kind {
            SubpathKind::Camera => (sample.weight, sample.weight * eta2),
            SubpathKind::Light => {
                let delta_scale = planted!("light-thinned-as-radiance", 1.0, eta2);
                let scale = if is_delta {
                    delta_scale
                } else {
                    1.0 / forwards.0
                };
                let factor = scattering.to_camera * (scattering.adjoint * scale);
                (factor, factor)
            }
        };
        vertex.is_delta = is_delta;
        Some(WalkStep {
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
    /// The densities of a vertex: of this subpath, and of one from the other end.
    fn densities(self, own: f64, other: f64) -> Densities {
        let (by_camera, by_light) = match self {
            Self::Camera => (own, other),
            Self::Light => (other, own),
        };
        Densities {
            by_light,
            by_camera,
        }
    }

    /// The density of a subpath from the other end.
    fn backwards(self, densities: &mut Densities) -> &mut f64 {
        match self {
            Self::Camera => &mut densities.by_light,
            Self::Light => &mut densities.by_camera,
        }
    }
}
