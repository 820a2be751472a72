//! A record of the cache: indirect irradiance at a point, and how far from there it may be extrapolated.
//!
//! With the expansion's V, gradient g and largest curvature k at the record, the irradiance at a displacement d with
//! normal n is
//!
//!   E = n . V + g . d,
//!
//! with an error of 1/2 k d^2 from the displacement, and of a share 1 - cos of the tilt from the normal, as directions
//! below the record's horizon become visible. The curvature may pass through zero, but only briefly: E changes over a
//! length of E / |g|, and has no finer feature than the distance of the surroundings, of which h is the harmonic mean.
//! Of the allowed error, a share eps of E, the fraction used is e,
//!
//!   e^2 = |d|^2 / R^2 + (1 - n . n_0) / eps,   R^2 = 2 eps min[E / k, (E / |g|)^2, h^2].
//!
//! Measure: normalised scene units; irradiance.
//! Range: eps above 0. R is at most [`MAX_RADIUS`].
//! Source: Schwarzhaupt, Jensen and Jarosz 2012 for k; Krivanek et al. 2005 for the gradient; Ward, Rubinstein and
//! Clear 1988 for the harmonic mean. Tested in `tests/rendering/irradiance_cache.rs`.

use super::hemisphere::Expansion;
use crate::math::frame::Frame;
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec3, Vec3};
use crate::planted::planted;
use serde::{Deserialize, Serialize};

/// The largest distance at which a record counts: a scene is about one unit large.
const MAX_RADIUS: f64 = 1e4;

/// The indirect irradiance at one point, and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The point.
    pub p: Vec3,
    /// The shading normal there, on the lit side.
    pub n: Vec3,
    /// The radius within which the record counts.
    pub radius: f32,
    /// V for each channel.
    vectors: [Vec3; 3],
    /// g for each channel.
    gradients: [Vec3; 3],
}

impl Record {
    /// Makes the record at `p` of the expansion in the hemisphere about the frame's normal, with the distances seen
    /// there.
    pub fn new(p: Vec3, frame: &Frame, light: &Expansion, distance: &[f32], bound: f64) -> Self {
        let inverse: f64 = distance.iter().map(|&r| 1.0 / f64::from(r)).sum();
        let harmonic = distance.len() as f64 / inverse;
        let irradiance = light.irradiance();
        // Zero over zero: without irradiance, nothing changes.
        let length = |length: f64| {
            if length.is_nan() {
                f64::INFINITY
            } else {
                length
            }
        };
        let curvature = length((irradiance / light.curvature()).sqrt());
        let slope = length(irradiance / light.slope());
        let scale = curvature.min(slope).min(harmonic);
        let bounded = (2.0 * bound).sqrt() * scale;
        let radius = planted!("cache-without-bound", 4.0 * harmonic, bounded);
        let to_world = |v: DVec3| frame.to_world(v.as_vec3a());
        Self {
            p,
            n: frame.n,
            radius: radius.min(MAX_RADIUS) as f32,
            vectors: light.vectors.map(to_world),
            gradients: light.gradients.map(|g| to_world(g.extend(0.0))),
        }
    }

    /// Whether all numbers are finite, and the radius is at least 0 and at most the largest.
    pub fn is_possible(&self) -> bool {
        let vectors = [self.p, self.n].into_iter();
        let mut vectors = vectors.chain(self.vectors).chain(self.gradients);
        (0.0..=MAX_RADIUS as f32).contains(&self.radius) && vectors.all(|it| it.is_finite())
    }

    /// The error as a fraction e of the allowed error, if it is below 1 and the point is near enough to the record's
    /// plane.
    #[inline]
    pub fn error(&self, p: Vec3, n: Vec3, bound: f32) -> Option<f32> {
        let d = p - self.p;
        let distance2 = d.length_squared();
        let tilt = (1.0 - n.dot(self.n)).max(0.0) / bound;
        let squared = distance2 / (self.radius * self.radius) + tilt;
        // On a surface whose normal tilts no more than that, a chord leaves the plane at half the angle.
        let above = d.dot(self.n);
        let is_beside = above * above > 0.5 * bound * distance2;
        (squared < 1.0 && !is_beside).then(|| squared.sqrt())
    }

    /// The irradiance at a point with this normal, extrapolated from this record.
    #[inline]
    pub fn irradiance(&self, p: Vec3, n: Vec3) -> Rgb {
        let d = p - self.p;
        let [r, g, b] = std::array::from_fn(|channel| {
            self.vectors[channel].dot(n) + self.gradients[channel].dot(d)
        });
        Rgb::new(r, g, b)
    }
}
