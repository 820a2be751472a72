//! Irradiance around a point, to second order, from one sampling of its hemisphere.
//!
//! The hemisphere is divided into M rings of N cells of equal weight, uniform in sin^2 theta and phi. With the radiance
//! L of each cell, the irradiance for a normal n' near n is n' . V, where
//!
//!   V = sum L (integral of w dw over the cell).
//!
//! A cell shows light emitted by a surface at distance r: seen from another point, the walls between cells are
//! displaced. A wall between cells a and b belongs to the nearer of their surfaces, so that the derivatives include
//! what it hides and uncovers. With u the directions along the wall, counter-clockwise about a, the boundary of a cell
//! moves by -d/r across u where the point of view moves by d, so that
//!
//!   grad E = sum (L_a - L_b) / r  integral cos (u x du),
//!   hess E = sum (L_a - L_b) / r^2  4 integral cos sym[u (u x du)^T],
//!
//! in the plane of the surface. In the second formula, steps of r from wall to wall have been integrated by parts, and
//! the antisymmetric part is left out, which is zero for a closed boundary. No other property of the surfaces counts.
//!
//! Measure: radiance and irradiance; lengths in the unit of the given distances; local axes with z along the normal.
//! Range: distances above 0; a wall at an infinite distance does not move, nor does the horizon.
//! Source: the walls are those of Ward and Heckbert 1992 and Krivanek et al. 2005; the radius of a record from their
//! second order is that of Schwarzhaupt, Jensen and Jarosz 2012. Derived by Reynolds' transport theorem. Tested below
//! against closed forms.

use crate::math::functions::{asin, cos, hypot, sin, sin_cos};
use crate::math::rgb::Rgb;
use crate::math::vec::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::PI;

/// The division of the hemisphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cells {
    /// Rings from the zenith to the horizon, at least 1.
    pub rings: usize,
    /// Cells of each ring, at least 3.
    pub sectors: usize,
}

impl Cells {
    /// Divides the hemisphere into about `count` cells, about as wide as high.
    pub fn about(count: f64) -> Self {
        let rings = (count / PI).sqrt().round().max(1.0);
        Self {
            rings: rings as usize,
            sectors: (PI * rings).round().max(3.0) as usize,
        }
    }

    /// The number of cells.
    pub fn count(self) -> usize {
        self.rings * self.sectors
    }

    /// The direction of a point of a cell, with both coordinates in [0, 1); cells are numbered ring by ring.
    pub fn direction(self, cell: usize, u: Vec2) -> Vec3 {
        let ring = (cell / self.sectors) as f64 + f64::from(u.x);
        let sector = (cell % self.sectors) as f64 + f64::from(u.y);
        self.at(ring, sector).as_vec3a()
    }

    /// The direction where these two boundaries meet, or a direction between boundaries.
    fn at(self, ring: f64, sector: f64) -> DVec3 {
        let sin2 = (ring / self.rings as f64).min(1.0);
        let (sin_phi, cos_phi) = sin_cos(2.0 * PI * sector / self.sectors as f64);
        let sin = sin2.sqrt();
        DVec3::new(sin * cos_phi, sin * sin_phi, (1.0 - sin2).sqrt())
    }

    /// The integral of the direction over a cell.
    fn moment(self, ring: usize, sector: usize) -> DVec3 {
        // The antiderivative of sin^2 theta.
        let slope = |ring: usize| {
            let theta = asin((ring as f64 / self.rings as f64).min(1.0).sqrt());
            0.5 * (theta - sin(theta) * cos(theta))
        };
        let width = slope(ring + 1) - slope(ring);
        let phi = |sector: usize| 2.0 * PI * sector as f64 / self.sectors as f64;
        let (sin_0, cos_0) = sin_cos(phi(sector));
        let (sin_1, cos_1) = sin_cos(phi(sector + 1));
        let z = PI / self.count() as f64;
        DVec3::new(width * (sin_1 - sin_0), width * (cos_0 - cos_1), z)
    }
}

/// The expansion of the irradiance around a point, in its local axes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Expansion {
    /// The vector V for each of R, G and B.
    pub vectors: [DVec3; 3],
    /// The gradient of the irradiance along x and y, for each of R, G and B.
    pub gradients: [DVec2; 3],
    /// The Hessian of the luminance: xx, xy, yy.
    pub hessian: [f64; 3],
    /// The variance of the luminance of the irradiance, from the differences of neighbouring cells; an overestimate, as
    /// they differ without noise, too.
    pub variance: f64,
}

impl Expansion {
    /// Computes the expansion from the radiances and distances of the cells.
    pub fn of(cells: Cells, radiance: &[Rgb], distance: &[f32]) -> Self {
        let mut all = Self::default();
        let weight = PI / cells.count() as f64;
        let place = |ring: usize, sector: usize| ring * cells.sectors + sector % cells.sectors;
        for ring in 0..cells.rings {
            for sector in 0..cells.sectors {
                let here = place(ring, sector);
                let moment = cells.moment(ring, sector);
                for (vector, light) in all.vectors.iter_mut().zip(radiance[here].to_array()) {
                    *vector += f64::from(light) * moment;
                }
                // Walls run counter-clockwise about this cell.
                let (r, s) = (ring as f64, sector as f64);
                let mut wall = |from: DVec3, to: DVec3, there: usize| {
                    let nearer = f64::from(distance[here].min(distance[there]));
                    let step = radiance[here] - radiance[there];
                    all.add(&Wall::between(from, to), step, 1.0 / nearer);
                    // Half of the squared difference is one cell's share, and each cell has about two walls.
                    all.variance += (f64::from(step.luminance()) * weight).powi(2) / 4.0;
                };
                let next = place(ring, sector + 1);
                wall(cells.at(r + 1.0, s + 1.0), cells.at(r, s + 1.0), next);
                if ring + 1 < cells.rings {
                    let beyond = place(ring + 1, sector);
                    wall(cells.at(r + 1.0, s), cells.at(r + 1.0, s + 1.0), beyond);
                }
            }
        }
        all
    }

    fn add(&mut self, wall: &Wall, step: Rgb, inverse: f64) {
        for (gradient, step) in self.gradients.iter_mut().zip(step.to_array()) {
            *gradient += f64::from(step) * inverse * wall.first;
        }
        let step = f64::from(step.luminance()) * inverse * inverse;
        for (sum, second) in self.hessian.iter_mut().zip(wall.second) {
            *sum += step * second;
        }
    }

    /// The luminance of the irradiance.
    pub fn irradiance(&self) -> f64 {
        let [r, g, b] = self.vectors.map(|vector| vector.z as f32);
        Rgb::new(r, g, b).luminance().into()
    }

    /// The slope of the luminance: the length of its gradient.
    pub fn slope(&self) -> f64 {
        let channel = |c: [f64; 3]| Rgb::new(c[0] as f32, c[1] as f32, c[2] as f32).luminance();
        let [x, y] = [self.gradients.map(|g| g.x), self.gradients.map(|g| g.y)].map(channel);
        hypot(f64::from(x), y.into())
    }

    /// The larger absolute value of the two curvatures of the luminance.
    pub fn curvature(&self) -> f64 {
        let [xx, xy, yy] = self.hessian;
        0.5 * ((xx + yy).abs() + hypot(xx - yy, 2.0 * xy))
    }
}

/// The integrals over a wall at distance 1.
struct Wall {
    /// The integral of cos (u x du): x, y.
    first: DVec2,
    /// The integral of 4 cos sym[u (u x du)^T]: xx, xy, yy.
    second: [f64; 3],
}

impl Wall {
    /// Integrates over the wall along the great circle from `p` to `q`.
    fn between(p: DVec3, q: DVec3) -> Self {
        // Points of a Gauss-Legendre quadrature: walls are short.
        const POINTS: [(f64, f64); 3] = [
            (0.112_701_665_379_258_3, 5.0 / 18.0),
            (0.5, 8.0 / 18.0),
            (0.887_298_334_620_741_7, 5.0 / 18.0),
        ];
        let e = q - p;
        let normal = p.cross(e);
        let (mut first, mut second) = (DVec2::ZERO, [0.0; 3]);
        for (s, weight) in POINTS {
            let r = p + s * e;
            let inverse = 1.0 / r.length_squared();
            let u = r * inverse.sqrt();
            let turn = weight * inverse * u.z * normal.truncate();
            first += turn;
            second[0] += 4.0 * turn.x * u.x;
            second[1] += 2.0 * (turn.x * u.y + turn.y * u.x);
            second[2] += 4.0 * turn.y * u.y;
        }
        Self { first, second }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The irradiance at a point of the plane z = 0 from a rectangle of radiance 1 at this height, by Lambert's
    /// formula.
    fn exact(x: f64, y: f64, [x0, x1, y0, y1]: [f64; 4], height: f64) -> f64 {
        let corners =
            [(x0, y0), (x0, y1), (x1, y1), (x1, y0)].map(|(a, b)| DVec3::new(a - x, b - y, height));
        let edge = |i: usize| {
            let (p, q) = (corners[i], corners[(i + 1) % 4]);
            p.angle_between(q) * p.cross(q).normalize().z
        };
        -0.5 * (0..4).map(edge).sum::<f64>()
    }

    const RECTANGLE: [f64; 4] = [0.2, 1.4, -0.7, 0.5];
    const HEIGHT: f64 = 1.1;

    /// The expansion of the rectangle in front of a floor behind it, from the middles of fine cells.
    fn expansion_of_rectangle(cells: Cells, behind: f32) -> Expansion {
        let [x0, x1, y0, y1] = RECTANGLE;
        let (radiance, distance): (Vec<Rgb>, Vec<f32>) = (0..cells.count())
            .map(|cell| {
                let w = cells.direction(cell, Vec2::splat(0.5)).as_dvec3();
                let at = w * (HEIGHT / w.z);
                if (x0..x1).contains(&at.x) && (y0..y1).contains(&at.y) {
                    (Rgb::WHITE, at.length() as f32)
                } else {
                    (Rgb::BLACK, behind * at.length() as f32)
                }
            })
            .unzip();
        Expansion::of(cells, &radiance, &distance)
    }

    #[test]
    fn irradiance_gradient_and_hessian_match_a_rectangle() {
        let (cells, h) = (
            Cells {
                rings: 300,
                sectors: 900,
            },
            1e-3,
        );
        let e = |x: f64, y: f64| exact(x, y, RECTANGLE, HEIGHT);
        let gradient = DVec2::new(e(h, 0.0) - e(-h, 0.0), e(0.0, h) - e(0.0, -h)) / (2.0 * h);
        let xx = (e(h, 0.0) - 2.0 * e(0.0, 0.0) + e(-h, 0.0)) / (h * h);
        let yy = (e(0.0, h) - 2.0 * e(0.0, 0.0) + e(0.0, -h)) / (h * h);
        let xy = (e(h, h) - e(h, -h) - e(-h, h) + e(-h, -h)) / (4.0 * h * h);
        // A wall behind the rectangle, as near as it or far behind: the rectangle hides it alike.
        for behind in [1.0, 50.0, f32::INFINITY] {
            let found = expansion_of_rectangle(cells, behind);
            for channel in 0..3 {
                assert!(
                    (found.vectors[channel].z - e(0.0, 0.0)).abs() < 2e-3,
                    "{found:?}"
                );
                let off = found.gradients[channel] - gradient;
                assert!(
                    off.length() < 0.01 * gradient.length(),
                    "{found:?} {gradient}"
                );
            }
            for (found, right) in found.hessian.into_iter().zip([xx, xy, yy]) {
                assert!(
                    (found - right).abs() < 0.02 * xx.abs().max(yy.abs()),
                    "{found} {right}"
                );
            }
        }
    }

    #[test]
    fn irradiance_derivatives_match_a_near_occluder_edge() {
        // A bright sky above half a black ceiling, whose height determines how much sky a move by d uncovers or hides.
        let cells = Cells {
            rings: 400,
            sectors: 1200,
        };
        let height = 0.4;
        let (radiance, distance): (Vec<Rgb>, Vec<f32>) = (0..cells.count())
            .map(|cell| {
                let w = cells.direction(cell, Vec2::splat(0.5)).as_dvec3();
                if w.x * height > 0.1 * w.z {
                    (Rgb::BLACK, (height / w.z) as f32)
                } else {
                    (Rgb::WHITE, f32::INFINITY)
                }
            })
            .unzip();
        let found = Expansion::of(cells, &radiance, &distance);
        // The edge at x = 0.1: E = pi / 2 (1 + sin of its angle), tan = (0.1 - x) / height.
        let e = |x: f64| {
            let t: f64 = (0.1 - x) / height;
            0.5 * PI * (1.0 + t / t.hypot(1.0))
        };
        let h = 1e-4;
        let slope = (e(h) - e(-h)) / (2.0 * h);
        let curve = (e(h) - 2.0 * e(0.0) + e(-h)) / (h * h);
        assert!((found.vectors[0].z - e(0.0)).abs() < 5e-3, "{found:?}");
        assert!(
            (found.gradients[0].x - slope).abs() < 0.02 * slope.abs(),
            "{found:?} {slope}"
        );
        assert!(
            (found.hessian[0] - curve).abs() < 0.05 * curve.abs(),
            "{found:?} {curve}"
        );
    }

    #[test]
    fn constant_sky_irradiance_vector_is_pi_along_the_normal() {
        let cells = Cells::about(1000.0);
        let sky = vec![Rgb::WHITE; cells.count()];
        let found = Expansion::of(cells, &sky, &vec![f32::INFINITY; cells.count()]);
        for vector in found.vectors {
            assert!(
                (vector - DVec3::new(0.0, 0.0, PI)).length() < 1e-9,
                "{vector}"
            );
        }
        assert_eq!(found.curvature(), 0.0);
    }

    #[test]
    fn cell_count_is_near_target_and_moments_align_with_centres() {
        let cells = Cells::about(500.0);
        assert!((450..550).contains(&cells.count()));
        for cell in 0..cells.count() {
            let moment = cells.moment(cell / cells.sectors, cell % cells.sectors);
            let middle = cells.direction(cell, Vec2::splat(0.5)).as_dvec3();
            assert!(moment.normalize().dot(middle) > 0.98, "{cell}");
        }
    }
}
