//! A record of the cache: indirect irradiance at a point, and how far from there it may be told from that.
//!
//! With the expansion's V, gradient g and largest curvature k at the record, the irradiance at a distance d with normal n is
//!
//!   E = n . V + g . d,
//!
//! short of 1/2 k d^2 in place, and of a share 1 - cos of the tilt in direction, as the horizon shows what was hidden. Where
//! the curvature passes through zero, it is not for long: E changes on a length of E / |g|, and none of its features is
//! finer than its surroundings are far, of which h is the harmonic mean. Of the error that is allowed, a share eps of E,
//! this is the part
//!
//!   e^2 = |d|^2 / R^2 + (1 - n . n_0) / eps,   R^2 = 2 eps min[E / k, (E / |g|)^2, h^2].
//!
//! Measure: normalised scene units; irradiance.
//! Range: eps above 0. R is at most [`FARTHEST`].
//! Source: Schwarzhaupt, Jensen and Jarosz 2012 for k; Krivanek et al. 2005 for the gradient; Ward, Rubinstein and Clear 1988
//! for the harmonic mean. Tested in
//! `tests/rendering/irradiance_cache.rs`.

use super::hemisphere::Expansion;
use crate::math::frame::Frame;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec3, Vec3};
use crate::planted::planted;

/// No record counts farther away: a scene is about one unit large.
const FARTHEST: f64 = 1e4;

/// What is known at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Where.
    pub p: Vec3,
    /// The shading normal there, on the side that is lit.
    pub n: Vec3,
    /// How far it counts.
    pub radius: f32,
    /// V for each channel.
    vectors: [Vec3; 3],
    /// g for each channel.
    gradients: [Vec3; 3],
}

impl Record {
    /// The record at `p` of what was seen in the hemisphere about the frame's normal, at these distances.
    pub fn new(p: Vec3, frame: &Frame, seen: &Expansion, distance: &[f32], bound: f64) -> Self {
        let inverse: f64 = distance.iter().map(|&r| 1.0 / f64::from(r)).sum();
        let harmonic = distance.len() as f64 / inverse;
        let irradiance = seen.irradiance();
        // Nothing changes where nothing is.
        let length = |length: f64| {
            if length.is_nan() {
                f64::INFINITY
            } else {
                length
            }
        };
        let curvature = length((irradiance / seen.curvature()).sqrt());
        let slope = length(irradiance / seen.slope());
        let scale = curvature.min(slope).min(harmonic);
        let told = (2.0 * bound).sqrt() * scale;
        let radius = planted!("cache-without-bound", 4.0 * harmonic, told);
        let to_world = |v: DVec3| frame.to_world(v.as_vec3a());
        Self {
            p,
            n: frame.n,
            radius: radius.min(FARTHEST) as f32,
            vectors: seen.vectors.map(to_world),
            gradients: seen.gradients.map(|g| to_world(g.extend(0.0))),
        }
    }

    /// The part e of the allowed error, if it is below 1 and the point is not off to one side.
    #[inline]
    pub fn error(&self, p: Vec3, n: Vec3, bound: f32) -> Option<f32> {
        let d = p - self.p;
        let distance2 = d.length_squared();
        let tilt = (1.0 - n.dot(self.n)).max(0.0) / bound;
        let squared = distance2 / (self.radius * self.radius) + tilt;
        // On a surface that turns no more than that, a chord leaves it at half the angle.
        let above = d.dot(self.n);
        let is_beside = above * above > 0.5 * bound * distance2;
        (squared < 1.0 && !is_beside).then(|| squared.sqrt())
    }

    /// The irradiance at a point with this normal, as this record tells it.
    #[inline]
    pub fn irradiance(&self, p: Vec3, n: Vec3) -> Rgb {
        let d = p - self.p;
        let [r, g, b] = std::array::from_fn(|channel| {
            self.vectors[channel].dot(n) + self.gradients[channel].dot(d)
        });
        Rgb::new(r, g, b)
    }
}
