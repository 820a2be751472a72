//! Densities that carry their measure, and the only conversions between measures.
//!
//! Measure: [`PdfSolidAngle`] per steradian, [`PdfArea`] per square scene unit, [`Pmf`] a probability.
//! Range: at least 0 and finite; a conversion that would divide by zero returns `None`.
//! Source: Veach 1997, section 8.2.2.2, eq. 8.10. Tested below.

use crate::planted::planted;

/// A probability density per steradian.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct PdfSolidAngle(pub f32);

/// A probability density per unit of area, in normalised scene units.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct PdfArea(pub f32);

/// The probability of one choice among finitely many.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct Pmf(pub f32);

impl PdfArea {
    /// Converts the pdf to solid angle, seen from a point at squared distance `distance2`, where `cos` is between the
    /// light's normal and the connecting line: p_omega = p_A r^2 / |cos|. `None` edge-on.
    #[inline(always)]
    pub fn to_solid_angle(self, distance2: f32, cos: f32) -> Option<PdfSolidAngle> {
        let tilt = planted!("area-pdf-without-cosine", 1.0, cos.abs());
        let pdf = self.0 * distance2 / tilt;
        pdf.is_finite().then_some(PdfSolidAngle(pdf))
    }
}

impl PdfSolidAngle {
    /// The smallest density above 0: the MIS weight of any other technique is then 1, and without another technique
    /// that of this one.
    pub const MIN_ABOVE_ZERO: Self = Self(f32::from_bits(1));

    /// Converts the pdf to area measure at squared distance `distance2`: p_A = p_omega |cos| / r^2.
    #[inline]
    pub fn to_area(self, distance2: f32, cos: f32) -> Option<PdfArea> {
        let pdf = self.0 * cos.abs() / distance2;
        pdf.is_finite().then_some(PdfArea(pdf))
    }
}

/// The pdf of a choice followed by a direction.
impl std::ops::Mul<PdfSolidAngle> for Pmf {
    type Output = PdfSolidAngle;
    #[inline]
    fn mul(self, pdf: PdfSolidAngle) -> PdfSolidAngle {
        PdfSolidAngle(self.0 * pdf.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pdf_conversions_round_trip_and_reject_zero_cos_or_distance() {
        let there = PdfArea(0.25).to_solid_angle(9.0, -0.5);
        assert_eq!(there, Some(PdfSolidAngle(4.5)));
        let back = there.and_then(|pdf| pdf.to_area(9.0, -0.5));
        assert_eq!(back, Some(PdfArea(0.25)));
        assert_eq!(PdfArea(0.25).to_solid_angle(9.0, 0.0), None);
        assert_eq!(PdfSolidAngle(1.0).to_area(0.0, 1.0), None);
    }
}
