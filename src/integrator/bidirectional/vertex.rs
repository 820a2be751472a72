//! The vertices of camera and light subpaths, and the scattering at a vertex from a light towards the camera, whichever
//! end the subpath began at.
//!
//! A shading normal is tilted for a viewer who would see the surface from behind ([`Interaction`]). So scattering is
//! always evaluated on the surface as seen from the camera, and the density of the reverse direction on the surface as
//! seen from the light. With the shading normal n and the geometric normal g, light along l that leaves towards the
//! camera e is multiplied by
//!
//!   f(e, l) |l n| |e g| / |l g|,
//!
//! for each unit of projected solid angle about g: Veach's adjoint of a BSDF with shading normals.
//!
//! Measure: densities per unit of area in normalised units; at a light beyond the scene per steradian.
//! Range: any surface. Delta lobes have the density 1 per steradian both ways: their true densities have the same
//! ratio.
//! Source: Veach 1997, sections 5.3 and 8.3.2, eq. 5.17. Tested in `tests/rendering/bidirectional.rs`.

use crate::bsdf::{Bsdf, BsdfSample};
use crate::effects::Effects;
use crate::light::types::{EmissionPdf, Receiver, ShadowRayEnd};
use crate::math::measure::{PdfSolidAngle, Pmf};
use crate::math::rgb::Rgb;
use crate::math::vec::{Vec3, Vector};
use crate::planted::planted;
use crate::scene::Scene;
use crate::scene::interaction::Interaction;
use std::borrow::Cow;

/// The densities with which subpaths from both ends find a vertex, given the vertices before it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Densities {
    /// The density on a light subpath.
    pub by_light: f64,
    /// The density on a camera subpath.
    pub by_camera: f64,
}

/// A density of rays, before their hits are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RayDensity {
    /// Rays from a point, per steradian.
    Point(f64),
    /// Parallel rays, per unit of area across.
    Parallel(f64),
}

impl RayDensity {
    /// The density with which the rays hit a point of a surface with the normal `ng`, at the end of `offset`; for
    /// parallel rays the length of `offset` has no meaning.
    #[inline]
    pub fn density_at(self, offset: Vec3, ng: Vec3) -> f64 {
        let offset = offset.as_dvec3();
        let distance2 = offset.length_squared();
        let cos = offset.dot(ng.as_dvec3()).abs() / distance2.sqrt();
        let density = match self {
            Self::Point(density) => density * cos / distance2,
            Self::Parallel(density) => density * cos,
        };
        // At zero distance nothing is found.
        if density.is_finite() { density } else { 0.0 }
    }
}

/// The scattering of light at a surface towards the camera, and the densities of sampling that direction.
#[derive(Debug, Clone, Copy)]
pub struct Scattering {
    /// The factor f |cos|, with the cosine between the light's direction and the shading normal as seen from the
    /// camera.
    pub to_camera: Rgb,
    /// The factor by which `to_camera` is multiplied on a light subpath.
    pub adjoint: f32,
    /// The density of continuing towards the light, on a camera subpath.
    pub pdf_to_light: PdfSolidAngle,
    /// The density of continuing towards the camera, on a light subpath.
    pub pdf_to_camera: PdfSolidAngle,
    /// Whether the light passes through the surface.
    pub is_transmitted: bool,
}

/// A vertex of a subpath on a surface.
#[derive(Debug)]
pub struct SubpathVertex<'a, E: Effects> {
    /// The surface interaction, as seen from the vertex before.
    pub at: Interaction<E>,
    /// The BSDF of the surface.
    pub bsdf: Cow<'a, Bsdf>,
    /// Whether the surface is transmissive.
    pub transmits: bool,
    /// The throughput of the subpath up to here.
    pub beta: Rgb,
    /// The densities of finding the vertex.
    pub densities: Densities,
    /// Whether the subpath continues from here by a delta lobe.
    pub is_delta: bool,
    /// The random numbers for the point that the vertex is connected to: on a light, or on the lens.
    pub u: [f32; 4],
}

impl<'a, E: Effects> SubpathVertex<'a, E> {
    /// The vertex where a subpath has arrived.
    pub fn new(
        scene: &'a Scene,
        at: Interaction<E>,
        beta: Rgb,
        densities: Densities,
        u: [f32; 4],
    ) -> Self {
        Self {
            bsdf: scene.bsdf(&at),
            transmits: scene.material(at.id).transmits(),
            at,
            beta,
            densities,
            is_delta: false,
            u,
        }
    }

    /// The vertex as a receiver of light, for the selection of a light there. The side of the normal is left out: it
    /// depends on the end at which a subpath began.
    #[inline]
    pub fn receiver(&self) -> Receiver {
        Receiver::isotropic(self.at.p)
    }

    /// Whether the BSDF has any lobe but delta lobes, so that the vertex can be connected to.
    #[inline]
    pub fn is_connectible(&self) -> bool {
        !self.bsdf.is_delta::<E>()
    }

    /// The density of finding this vertex with the density `pdf` of directions at `from`.
    #[inline]
    pub fn density_from(&self, from: Vec3, pdf: PdfSolidAngle) -> f64 {
        RayDensity::Point(pdf.0.into()).density_at(self.at.p - from, self.at.ng)
    }

    /// Evaluates scattering from the unit vector `to_light` to the unit vector `to_camera`, both away from the surface,
    /// without delta lobes; `None` if no light is scattered this way.
    pub fn scattering(&self, scene: &Scene, to_camera: Vec3, to_light: Vec3) -> Option<Scattering> {
        let (seen, is_transmitted) = self.seen(scene, to_camera, to_light)?;
        let wi = seen.frame.to_local(to_light);
        let value = self.bsdf.eval::<E>(seen.frame.to_local(to_camera), wi);
        if value.f.is_black() {
            return None;
        }
        let lit = self.at.with_wo(to_light, self.transmits);
        let back = (lit.frame.to_local(to_light), lit.frame.to_local(to_camera));
        Some(Scattering {
            to_camera: value.f * wi.z.abs(),
            adjoint: adjoint(&seen, to_camera, to_light),
            pdf_to_light: value.pdf,
            pdf_to_camera: self.bsdf.eval::<E>(back.0, back.1).pdf,
            is_transmitted,
        })
    }

    /// Evaluates scattering for a direction that a subpath from either end has sampled from a delta lobe.
    ///
    /// Reflection about a tilted normal, and refraction through it, are not found in the reverse direction.
    pub fn delta_scattering(
        &self,
        scene: &Scene,
        sample: &BsdfSample,
        to_camera: Vec3,
        to_light: Vec3,
    ) -> Option<Scattering> {
        let (seen, is_transmitted) = self.seen(scene, to_camera, to_light)?;
        let is_tilted = [to_camera, to_light].iter().any(|&w| seen.is_tilted_for(w));
        let both_ways = PdfSolidAngle(1.0);
        let one_way = PdfSolidAngle(if is_tilted { 0.0 } else { 1.0 });
        let [of_camera, of_light] = [to_camera, to_light].map(|w| seen.frame.to_local(w).z.abs());
        // Refraction changes the width of a beam: light is kept in projected solid angle about the shading normal.
        Some(Scattering {
            to_camera: sample.weight,
            adjoint: adjoint(&seen, to_camera, to_light) * (of_light / of_camera),
            pdf_to_light: both_ways,
            pdf_to_camera: one_way,
            is_transmitted,
        })
    }

    /// The surface as seen from the camera, and whether light passes through it; `None` where its two normals do not
    /// agree on that, or this side of it absorbs everything.
    fn seen(
        &self,
        scene: &Scene,
        to_camera: Vec3,
        to_light: Vec3,
    ) -> Option<(Interaction<E>, bool)> {
        let seen = self.at.with_wo(to_camera, self.transmits);
        let [wo, wi] = [to_camera, to_light].map(|w| seen.frame.to_local(w));
        let is_transmitted = wi.z * wo.z < 0.0;
        let is_lit =
            seen.is_consistent_side(to_light, is_transmitted) && !scene.is_absorbing_side(&seen);
        is_lit.then_some((seen, is_transmitted))
    }
}

/// The factor |e g| / |l g| of the light from `to_light` that scatters towards `to_camera`, where |l n| is a factor already.
/// Free of branches.
#[inline(always)]
pub fn adjoint<E: Effects, V: Vector>(seen: &Interaction<E, V>, to_camera: V, to_light: V) -> f32 {
    let cos = to_camera.dot(seen.ng).abs();
    // So that the cosines of a flat surface cancel exactly.
    let of_shading = seen.frame.to_local(to_light).z().abs();
    let of_geometry = to_light.dot(seen.ng).abs();
    let is_flat = planted!("shading-normals-both-ways-alike", true, seen.is_flat());
    cos / if is_flat { of_shading } else { of_geometry }
}

/// The vertex of a path on a light: a point, or a direction if the light is beyond the scene.
#[derive(Debug, Clone, Copy)]
pub struct LightVertex {
    /// The point, on a surface or in free space, or infinity.
    pub end: ShadowRayEnd,
    /// Whether a camera subpath can hit the source.
    pub can_be_hit: bool,
    /// The densities of finding the source.
    pub densities: Densities,
    /// The density with which light sampling at the vertex next to it finds the source.
    pub nee_pdf: f64,
}

impl LightVertex {
    /// Makes the source with which a light subpath begins with these densities, times the probability of selecting the
    /// light, and the density of the rays that leave it. The density of light sampling is left at zero.
    pub fn new(end: ShadowRayEnd, pmf: Pmf, pdf: &EmissionPdf) -> (Self, RayDensity) {
        let position = pdf.position.map_or(1.0, |pdf| f64::from(pdf.0));
        let direction = pdf.direction.map_or(1.0, |pdf| f64::from(pdf.0));
        // The vertex is what is sampled first: the direction of light from beyond the scene, otherwise the point.
        let (first, rays) = match end {
            ShadowRayEnd::Infinity => (direction, RayDensity::Parallel(position)),
            ShadowRayEnd::Surface(..) | ShadowRayEnd::Point(_) => {
                (position, RayDensity::Point(direction))
            }
        };
        let source = Self {
            end,
            can_be_hit: pdf.can_be_hit(),
            densities: Densities {
                by_light: f64::from(pmf.0) * first,
                by_camera: 0.0,
            },
            nee_pdf: 0.0,
        };
        (source, rays)
    }

    /// The offset from the source to a point: from beyond the scene the direction of the light, whose unit vector is
    /// `direction`.
    pub fn offset_to(&self, to: Vec3, direction: Vec3) -> Vec3 {
        match &self.end {
            ShadowRayEnd::Surface(point, _) => to - point.p,
            ShadowRayEnd::Point(point) => to - *point,
            ShadowRayEnd::Infinity => direction,
        }
    }

    /// The density of hitting the source with the density `pdf` of directions at `from`.
    pub fn density_from(&self, from: Vec3, pdf: PdfSolidAngle) -> f64 {
        match &self.end {
            _ if !self.can_be_hit => 0.0,
            ShadowRayEnd::Surface(point, _) => {
                RayDensity::Point(pdf.0.into()).density_at(point.p - from, point.ng)
            }
            ShadowRayEnd::Point(_) | ShadowRayEnd::Infinity => pdf.0.into(),
        }
    }
}
