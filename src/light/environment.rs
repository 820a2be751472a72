//! An environment map: an image light at infinity.
//!
//! The image is a panorama: u = 1/2 + atan2(x, -z) / 2 pi runs along its rows, and the angle theta from +y down its
//! columns, so that its centre is along -z, its right half towards +x and its first row at the top. Radiance is bilinear
//! in both angles between texel centres; it wraps around at the seam, and is constant in theta from the last row of
//! centres to a pole. Directions are sampled with a density that is constant on each patch between four centres (at the
//! ends, between two of them and the pole), in proportion to the integral of the patch's luminance.
//!
//! Beside BSDF sampling, which finds an even sky as well, the density is compensated: it is in proportion to the
//! luminance above the mean, and zero below it.
//!
//! Measure: radiance; densities per steradian.
//! Range: any image of finite texels of at least 0 that is not black; radiance does not depend on the receiver.
//! Source: Pharr, Jakob, Humphreys, "Infinite Area Lights"; the integral of a patch in closed form; Karlik, Sik, Vevoda,
//! Skrivan and Krivanek 2019, "MIS Compensation". Tested in `tests/lights/environment.rs`.

use super::types::{EnvironmentSampling, LightSample, ShadowRayEnd};
use crate::geometry::texture_image::TextureImage;
use crate::math::functions::{atan2, cos, hypot, sin, sin_cos};
use crate::math::measure::PdfSolidAngle;
use crate::math::rgb::Rgb;
use crate::math::vec::{DMat3, DVec3, Vec2, Vec3};
use crate::planted::planted;
use crate::sampling::piecewise::Piecewise2d;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A light at infinity that varies with direction.
#[derive(Debug, Clone)]
pub struct EnvironmentMap {
    image: Arc<TextureImage>,
    /// Multiplies every texel.
    scale: f32,
    to_world: DMat3,
    /// Distribution over patches, one more row of them than of texels; patch 0 of a row lies between texels 0 and 1.
    patches: Piecewise2d,
    /// The compensated distribution; `None` where no patch is above the mean.
    compensated: Option<Piecewise2d>,
    /// sin^2(theta / 2) at the borders of the rows of patches: solid angle is linear in it.
    borders: Vec<f64>,
}

/// The image position of a direction: a patch, and the offset in it in azimuth and in theta.
#[derive(Debug, Clone, Copy)]
struct Location {
    column: usize,
    row: usize,
    offset: [f64; 2],
}

impl EnvironmentMap {
    /// Creates the light of a panorama whose axes the rotation `to_world` turns into those of the world; `None` if the
    /// image is black.
    pub fn new(image: Arc<TextureImage>, scale: f32, to_world: DMat3) -> Option<Self> {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let luminance =
            |x: usize, y: usize| f64::from((scale * image.get(x as u32, y as u32)).luminance());
        let weights = (0..width * (height + 1)).map(|patch| {
            let (row, left) = (patch / width, patch % width);
            let right = (left + 1) % width;
            let [above, below] = texel_rows(row, height);
            let [share_above, share_below] = shares(row, height);
            let azimuth = TAU / width as f64;
            let mean = |y: usize| 0.5 * (luminance(left, y) + luminance(right, y));
            azimuth * (share_above * mean(above) + share_below * mean(below))
        });
        let patches = Piecewise2d::new(weights.clone(), width)?;
        let half_sin2 = |row| sin(0.5 * border(row, height)).powi(2);
        let borders: Vec<f64> = (0..height + 2).map(half_sin2).collect();
        let mean = patches.sum() / (4.0 * PI);
        let above_mean = weights.enumerate().map(|(patch, weight)| {
            let row = patch / width;
            let solid_angle = TAU / width as f64 * 2.0 * (borders[row + 1] - borders[row]);
            f64::max(weight - mean * solid_angle, 0.0)
        });
        let compensated = Piecewise2d::new(above_mean, width);
        Some(Self {
            image,
            scale,
            to_world,
            patches,
            compensated,
            borders,
        })
    }

    /// The integral of the luminance over all directions.
    pub fn integral(&self) -> f64 {
        self.patches.sum()
    }

    /// Radiant power in normalised units that enters the scene's bounding sphere: pi R^2 times the integral of radiance.
    pub fn power(&self, scene_radius: f64) -> f64 {
        PI * scene_radius * scene_radius * self.patches.sum()
    }

    /// The distribution over patches.
    #[inline]
    fn distribution(&self, sampling: EnvironmentSampling) -> &Piecewise2d {
        match (sampling, &self.compensated) {
            (EnvironmentSampling::Compensated, Some(compensated)) => compensated,
            _ => &self.patches,
        }
    }

    /// Samples a direction to the environment, the same for every receiver.
    #[inline]
    pub fn sample(&self, u: Vec2, sampling: EnvironmentSampling) -> Option<LightSample> {
        let [column, row] = self
            .distribution(sampling)
            .sample(u.to_array().map(f64::from));
        let [low, high] = [self.borders[row.piece], self.borders[row.piece + 1]];
        let half_sin2 = low + row.offset * (high - low);
        let sin_theta = 2.0 * (half_sin2 * (1.0 - half_sin2)).sqrt();
        let centre = planted!("environment-half-a-texel", 0.0, 0.5);
        let x = column.piece as f64 + column.offset + centre;
        let (sin_azimuth, cos_azimuth) = sin_cos(TAU * (x / f64::from(self.image.width()) - 0.5));
        let local = DVec3::new(
            sin_theta * sin_azimuth,
            1.0 - 2.0 * half_sin2,
            -sin_theta * cos_azimuth,
        );
        let wi = (self.to_world * local).as_vec3a();
        // Evaluated at the rounded direction, so that a BSDF sample of the same direction gets the same values.
        let (radiance, pdf) = self.eval(wi, sampling);
        (pdf.0 > 0.0).then_some(LightSample {
            wi,
            radiance,
            pdf: Some(pdf),
            end: ShadowRayEnd::Infinity,
        })
    }

    /// The radiance from a direction, and the density of [`sample`](Self::sample) there.
    #[inline]
    pub fn eval(&self, direction: Vec3, sampling: EnvironmentSampling) -> (Rgb, PdfSolidAngle) {
        let at = self.locate(direction);
        let solid_angle = TAU / f64::from(self.image.width())
            * 2.0
            * (self.borders[at.row + 1] - self.borders[at.row]);
        let pdf = self.distribution(sampling).pmf(at.column, at.row) / solid_angle;
        (self.radiance(at), PdfSolidAngle(pdf as f32))
    }

    #[inline]
    fn locate(&self, direction: Vec3) -> Location {
        let (width, height) = (self.image.width() as usize, self.image.height() as usize);
        let w = self.to_world.transpose() * direction.as_dvec3();
        let u = 0.5 + atan2(w.x, -w.z) / TAU;
        let theta = atan2(hypot(w.x, w.z), w.y);
        // x counts from the centre of the last column; patch 0 starts at the centre of the first.
        let x = u * width as f64 + 0.5;
        let column = (x as usize + width - 1) % width;
        let y = theta / PI * height as f64 + 0.5;
        let row = (y as usize).min(height);
        Location {
            column,
            row,
            offset: [x - x.floor(), (y - row as f64).min(1.0)],
        }
    }

    #[inline]
    fn radiance(&self, at: Location) -> Rgb {
        let (width, height) = (self.image.width() as usize, self.image.height() as usize);
        let (left, right) = (at.column as u32, ((at.column + 1) % width) as u32);
        let [x, y] = at.offset.map(|offset| offset as f32);
        let [above, below] = texel_rows(at.row, height).map(|y| {
            let texel = |x| self.image.get(x, y as u32);
            texel(left).lerp(texel(right), x)
        });
        self.scale * above.lerp(below, y)
    }
}

/// The rows of texels above and below a row of patches.
#[inline]
fn texel_rows(row: usize, height: usize) -> [usize; 2] {
    [row.saturating_sub(1), row.min(height - 1)]
}

/// The angle from +y at which a row of patches begins.
fn border(row: usize, height: usize) -> f64 {
    if row == 0 {
        0.0
    } else if row > height {
        PI
    } else {
        PI * (row as f64 - 0.5) / height as f64
    }
}

/// The integrals over a row of patches, per radian of azimuth, of the tent functions of the texels above and below it:
/// int (b - theta) / (b - a) sin theta dtheta, and int (theta - a) / (b - a) sin theta dtheta, from a to b.
fn shares(row: usize, height: usize) -> [f64; 2] {
    let (a, b) = (border(row, height), border(row + 1, height));
    let whole = 2.0 * sin(0.5 * (a + b)) * sin(0.5 * (b - a));
    let below = (sin(b) - sin(a)) / (b - a) - cos(b);
    [whole - below, below]
}
