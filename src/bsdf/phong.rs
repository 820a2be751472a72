//! The modified Phong model, as courses teach it: a diffuse part and a lobe about the mirror direction, of bounded albedo.
//!
//! Measure: f per steradian, f = diffuse / pi + specular (n + 2) / (2 pi) cos^n(a), where a is the angle between `wi` and
//! the mirror direction of `wo`.
//! Range: exponents from 0 to 1e6; `diffuse` plus `specular` at most 1 in each channel, then the albedo is, too. Both
//! sides scatter alike. At normal incidence the lobe's albedo is exactly `specular`. At other angles it loses the part
//! below the surface and, in addition, about a factor of cos(theta), so that even a narrow lobe darkens towards the
//! horizon: its limit is not a mirror. `tests/scattering/furnace.rs` prints the losses.
//! Source: Phong 1975, "Illumination for Computer Generated Pictures"; Lafortune and Willems 1994, "Using the Modified
//! Phong Reflectance Model for Physically Based Rendering", eq. 4 and 8. Tested in `tests/scattering/bsdf.rs`.

use super::types::{BsdfSample, BsdfSampleInput, BsdfValue, Lobe, facing_up};
use crate::math::frame::Frame;
use crate::math::{measure::PdfSolidAngle, rgb::Rgb, vec::Vec3};
use crate::sampling::cosine_power::{cosine_power, one_minus_cos, sample_cosine_power};
use crate::sampling::warp::pdf_hemisphere_cosine;
use std::f32::consts::{FRAC_1_PI, PI};

/// A diffuse surface with a Phong lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phong {
    diffuse: Rgb,
    specular: Rgb,
    exponent: f32,
    /// The probability of sampling the lobe: its share of the albedo.
    lobe_share: f32,
}

impl Phong {
    /// Creates a surface that reflects `diffuse` evenly, and `specular` about the mirror direction.
    #[inline]
    pub fn new(diffuse: Rgb, specular: Rgb, exponent: f32) -> Self {
        let (matte, shiny) = (diffuse.luminance(), specular.luminance());
        let lobe_share = if shiny > 0.0 {
            shiny / (matte + shiny)
        } else {
            0.0
        };
        Self {
            diffuse,
            specular,
            exponent,
            lobe_share,
        }
    }

    /// Evaluates both parts on the side of `wo`.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        facing_up(wo, wi).map_or_else(BsdfValue::default, |(wo, wi)| self.eval_above(wo, wi))
    }

    /// Samples a direction of the lobe or a cosine-weighted one. `None` for one below the surface: that part is lost.
    #[inline]
    pub fn sample(&self, wo: Vec3, input: &BsdfSampleInput) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let (mut wi, lobe) = if input.lobe < self.lobe_share {
            let about_mirror = Frame::from_normal(mirrored(up));
            let wi = about_mirror.to_world(sample_cosine_power(input.u, self.exponent));
            (wi, Lobe::GlossyReflection)
        } else {
            (input.cosine_direction, Lobe::Diffuse)
        };
        if wi.z <= 0.0 {
            return None;
        }
        let value = self.eval_above(up, wi);
        // Rounding may move a direction at the edge of the lobe to where its density is zero.
        if value.pdf.0 <= 0.0 {
            return None;
        }
        let weight = (wi.z / value.pdf.0) * value.f;
        wi.z = wi.z.copysign(wo.z);
        Some(BsdfSample {
            wi,
            weight,
            pdf: Some(value.pdf),
            lobe,
        })
    }

    /// Evaluates both parts, both directions above the surface.
    #[inline]
    fn eval_above(&self, wo: Vec3, wi: Vec3) -> BsdfValue {
        let n = self.exponent;
        let power = cosine_power(one_minus_cos(wi, mirrored(wo)), n) / (2.0 * PI);
        let cosine = pdf_hemisphere_cosine(wi.z);
        BsdfValue {
            f: FRAC_1_PI * self.diffuse + ((n + 2.0) * power) * self.specular,
            pdf: PdfSolidAngle(
                (1.0 - self.lobe_share) * cosine + self.lobe_share * ((n + 1.0) * power),
            ),
        }
    }
}

/// The mirror direction of `w`.
#[inline]
fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(-w.x, -w.y, w.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::Vec2;

    /// Hard case 10.
    #[test]
    fn narrow_phong_lobe_pdf_matches_double_precision() {
        let n = 1e6_f32;
        let lobe = Phong::new(Rgb::BLACK, Rgb::WHITE, n);
        let mut worst = 0.0_f64;
        for wo in [
            Vec3::Z,
            Vec3::new(0.6, 0.0, 0.8),
            Vec3::new(0.3, -0.9, 0.1).normalize(),
        ] {
            for i in 0..1000 {
                let u = Vec2::new(i as f32 / 1000.0, (i as f32 * 0.618).fract());
                let Some(s) = lobe.sample(wo, &BsdfSampleInput::new(0.0, u)) else {
                    continue;
                };
                let mirror = mirrored(wo).as_dvec3().normalize();
                let wi = s.wi.as_dvec3().normalize();
                let h = 0.5 * (wi - mirror).length_squared();
                let n = f64::from(n);
                let exact = (n + 1.0) / std::f64::consts::TAU * (n * (-h).ln_1p()).exp();
                let pdf = s.pdf.expect("the lobe has a density").0;
                worst = worst.max((f64::from(pdf) / exact - 1.0).abs());
            }
        }
        println!("within {worst:.1e}");
        assert!(worst < 3e-6, "{worst:e}");
    }
}
