//! A rectangle light, sampled as by `src/light/rectangle.rs` at a medium distance.

use etendue::internals::math::measure::PdfArea;
use etendue::internals::math::vec::{LaneVec3 as Vec3, Vec2};
use etendue::internals::sampling::linear::LinearSquare;

/// A rectangle light that emits to one side.
pub struct Light {
    pub corner: Vec3,
    pub edges: [Vec3; 2],
    pub normal: Vec3,
    pub radiance: Vec3,
    /// One over the area.
    pub pdf_area: f32,
    pub over_radius2: f32,
    pub half_edges2: Vec2,
    pub over_edges2: Vec2,
}

impl Light {
    /// Creates the light of a rectangle's two triangles.
    pub fn new([a, b, c]: [Vec3; 3], radiance: Vec3) -> Self {
        let edges = [b - a, c - b];
        let lengths2 = edges.map(|edge| edge.length_squared());
        let radius2 = 0.25 * (lengths2[0] + lengths2[1]);
        Self {
            corner: a,
            edges,
            normal: edges[0].cross(edges[1]).normalize(),
            radiance,
            pdf_area: 1.0 / (lengths2[0] * lengths2[1]).sqrt(),
            over_radius2: 1.0 / radius2,
            half_edges2: Vec2::from(lengths2) * (0.25 / radius2),
            over_edges2: 1.0 / Vec2::from(lengths2),
        }
    }

    /// The density for a receiver, given the corner relative to it: 1 / r^3 at the midpoint of each edge, as in
    /// `src/light/rectangle.rs`.
    #[inline(always)]
    pub fn density(&self, corner: Vec3) -> LinearSquare {
        let center = corner + 0.5 * (self.edges[0] + self.edges[1]);
        let distance2 = self.over_radius2 * center.length_squared();
        let along = self.edges.map(|edge| self.over_radius2 * center.dot(edge));
        let far = self.half_edges2 + Vec2::splat(distance2);
        let weight = |r2: f32| (1.0 / r2) * (1.0 / r2).sqrt();
        let weights = |r2: Vec2| Vec2::new(weight(r2.x), weight(r2.y));
        let along = Vec2::from(along);
        LinearSquare::new(weights(far - along), weights(far + along))
    }

    #[inline(always)]
    pub fn per_steradian(&self, of_shares: f32, distance2: f32, cos: f32) -> f32 {
        let pdf = PdfArea(of_shares * self.pdf_area).to_solid_angle(distance2, cos);
        pdf.map_or(f32::INFINITY, |pdf| pdf.0)
    }

    /// The density of sampling the point at `towards` from a receiver, where the light's cosine is `cos`.
    #[inline(always)]
    pub fn pdf(&self, receiver: Vec3, towards: Vec3, cos: f32) -> f32 {
        let corner = self.corner - receiver;
        let from_corner = towards - corner;
        let along = Vec2::from(self.edges.map(|edge| from_corner.dot(edge)));
        let of_shares = self.density(corner).pdf(self.over_edges2 * along);
        self.per_steradian(of_shares, towards.length_squared(), cos)
    }
}
