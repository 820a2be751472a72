//! Images at infinity: pbrt's equal-area octahedral maps, resampled to one panorama.
//!
//! Measure: radiance. A texel of the map covers the same solid angle as any other; rows of the panorama go down from +y.
//! Range: square maps; panoramas of at most 8192 x 4096 pixels. Each pixel of the panorama is the mean of sixteen
//! lookups, bilinear in the map, so that its radiance is that of the map up to the resolution.
//! Source: Clarberg 2008, "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD". Tested below and in
//! `tests/loading/pbrt/`.

use crate::image::Image;
use crate::math::rgb::Rgb;
use crate::math::transform::is_invertible;
use crate::math::vec::{DMat3, DVec2, DVec3};
use crate::planted::planted;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::sync::Arc;

/// Greatest height of a panorama, in pixels; it is twice as wide.
const MOST_ROWS: u32 = 4096;

/// Lookups along each axis of a pixel.
const LOOKUPS: u32 = 4;

/// An octahedral map, and where it is in the world.
#[derive(Debug)]
pub struct Panorama {
    map: Arc<Image>,
    scale: f64,
    from_world: DMat3,
}

impl Panorama {
    /// A map whose axes `to_world` turns into those of the world, times a scale. If `illuminance` is given, the map is
    /// scaled so that a surface that faces its +z has that irradiance before `scale`. `None` if a value is not finite.
    pub fn new(
        map: Arc<Image>,
        scale: f64,
        to_world: DMat3,
        illuminance: Option<f64>,
    ) -> Option<Self> {
        let factor = illuminance.map_or(1.0, |wanted| wanted / upward_illuminance(&map));
        let scale = scale * factor;
        let brightest = map
            .pixels()
            .iter()
            .fold(0.0, |most: f32, pixel| most.max(pixel.max_channel()));
        let is_fine =
            ((f64::from(brightest) * scale) as f32).is_finite() && is_invertible(&to_world);
        is_fine.then(|| Self {
            map,
            scale,
            from_world: to_world.inverse(),
        })
    }

    /// The height of a panorama that resolves the map.
    fn rows(&self) -> u32 {
        self.map.height().clamp(2, MOST_ROWS)
    }

    /// The radiance from a direction of the world.
    fn radiance(&self, direction: DVec3) -> Rgb {
        let towards = (self.from_world * direction).normalize_or(DVec3::Z);
        let colour = bilinear(&self.map, square(towards));
        colour.map(|x| (self.scale * f64::from(x)) as f32)
    }
}

/// The sum of the maps as a panorama of the world; `None` without any.
pub fn panorama(maps: &[Panorama]) -> Option<Image> {
    let height = maps.iter().map(Panorama::rows).max()?;
    let width = 2 * height;
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let mut sum = Rgb::BLACK;
            for sub in 0..LOOKUPS * LOOKUPS {
                let offset = |index: u32| (f64::from(index) + 0.5) / f64::from(LOOKUPS);
                let u = (f64::from(x) + offset(sub % LOOKUPS)) / f64::from(width);
                let v = (f64::from(y) + offset(sub / LOOKUPS)) / f64::from(height);
                let (azimuth, theta) = (TAU * (u - 0.5), PI * v);
                let towards = DVec3::new(
                    theta.sin() * azimuth.sin(),
                    theta.cos(),
                    -theta.sin() * azimuth.cos(),
                );
                for map in maps {
                    sum += map.radiance(towards);
                }
            }
            pixels.push(sum / (LOOKUPS * LOOKUPS) as f32);
        }
    }
    Some(Image::new(width, height, pixels))
}

/// The illuminance of a surface that faces +z, by the map's luminance.
fn upward_illuminance(map: &Image) -> f64 {
    let (width, height) = (map.width(), map.height());
    let mut sum = 0.0;
    for y in 0..height {
        for x in 0..width {
            let point = DVec2::new(
                (f64::from(x) + 0.5) / f64::from(width),
                (f64::from(y) + 0.5) / f64::from(height),
            );
            let cos = sphere(point).z.max(0.0);
            sum += f64::from(map.get(x, y).luminance()) * cos;
        }
    }
    4.0 * PI * sum / (f64::from(width) * f64::from(height))
}

/// The direction of a point of the unit square.
fn sphere(point: DVec2) -> DVec3 {
    let p = 2.0 * point - DVec2::ONE;
    let (u, v) = (p.x.abs(), p.y.abs());
    // Signed distance from the diagonal, which is the equator.
    let distance = 1.0 - (u + v);
    let r = 1.0 - distance.abs();
    let phi = if r == 0.0 {
        FRAC_PI_4
    } else {
        FRAC_PI_4 * ((v - u) / r + 1.0)
    };
    let across = r * (2.0 - r * r).max(0.0).sqrt();
    DVec3::new(
        (across * phi.cos()).copysign(p.x),
        (across * phi.sin()).copysign(p.y),
        (1.0 - r * r).copysign(distance),
    )
}

/// The point of the unit square of a unit direction: the inverse of [`sphere`].
fn square(direction: DVec3) -> DVec2 {
    let [x, y, z] = direction.abs().to_array();
    let r = (1.0 - z).max(0.0).sqrt();
    let phi = y.atan2(x) / FRAC_PI_2;
    let (u, v) = (r - phi * r, phi * r);
    let below = planted!(
        "octahedron-not-folded",
        (1.0 - u, 1.0 - v),
        (1.0 - v, 1.0 - u)
    );
    let (u, v) = if direction.z < 0.0 { below } else { (u, v) };
    let signed = DVec2::new(u.copysign(direction.x), v.copysign(direction.y));
    0.5 * (signed + DVec2::ONE)
}

/// The colour at a point of the unit square, between the centres of texels. Beyond an edge the map goes on mirrored at
/// the edge's middle.
fn bilinear(map: &Image, point: DVec2) -> Rgb {
    let side = i64::from(map.width());
    let position = point * side as f64 - DVec2::splat(0.5);
    let corner = position.floor();
    let share = (position - corner).as_vec2();
    let (x, y) = (corner.x as i64, corner.y as i64);
    let texel = |x: i64, y: i64| {
        let (x, y) = if x < 0 || x >= side {
            (x.clamp(0, side - 1), side - 1 - y)
        } else {
            (x, y)
        };
        let (x, y) = if y < 0 || y >= side {
            (side - 1 - x, y.clamp(0, side - 1))
        } else {
            (x, y)
        };
        map.get(x as u32, y as u32)
    };
    let top = texel(x, y).lerp(texel(x + 1, y), share.x);
    let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), share.x);
    top.lerp(bottom, share.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_to_sphere_mapping_inverts_and_has_uniform_moments() {
        let side = 64;
        let mut mean = DVec3::ZERO;
        let mut second = DVec3::ZERO;
        for index in 0..side * side {
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(side);
            let point = DVec2::new(at(index % side), at(index / side));
            let direction = sphere(point);
            assert!((direction.length() - 1.0).abs() < 1e-12);
            assert!((square(direction) - point).length() < 1e-7, "{point}");
            mean += direction;
            second += direction * direction;
        }
        let count = f64::from(side * side);
        assert!(mean.length() / count < 1e-12);
        // The mean of x^2 over the sphere is 1/3.
        assert!((second / count - DVec3::splat(1.0 / 3.0)).length() < 2e-3);
    }

    #[test]
    fn square_corners_and_centre_map_to_the_poles() {
        for corner in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
            assert!((sphere(corner) + DVec3::Z).length() < 1e-12);
        }
        assert!((sphere(DVec2::splat(0.5)) - DVec3::Z).length() < 1e-12);
        assert!((sphere(DVec2::new(1.0, 0.5)) - DVec3::X).length() < 1e-12);
        assert!((sphere(DVec2::new(0.5, 1.0)) - DVec3::Y).length() < 1e-12);
    }

    /// A map of radiance 1 + x/2 + y/4 + z/8.
    fn tilted(side: u32) -> Image {
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        let pixel = |index: u32| {
            let d = sphere(DVec2::new(at(index % side), at(index / side)));
            Rgb::grey((1.0 + 0.5 * d.x + 0.25 * d.y + 0.125 * d.z) as f32)
        };
        Image::new(side, side, (0..side * side).map(pixel).collect())
    }

    #[test]
    fn panorama_applies_the_transform_and_scale_of_its_map() {
        let map = Arc::new(tilted(64));
        // pbrt's z becomes our y, and handedness stays.
        let to_world = DMat3::from_rotation_x(-FRAC_PI_2);
        let placed = Panorama::new(map, 2.0, to_world, None).expect("finite");
        let image = panorama(&[placed]).expect("one");
        let (width, height) = (image.width(), image.height());
        assert_eq!((width, height), (128, 64));
        for (x, y) in [(10, 10), (64, 32), (100, 50), (3, 60), (127, 1)] {
            let azimuth = TAU * ((f64::from(x) + 0.5) / f64::from(width) - 0.5);
            let theta = PI * (f64::from(y) + 0.5) / f64::from(height);
            let world = DVec3::new(
                theta.sin() * azimuth.sin(),
                theta.cos(),
                -theta.sin() * azimuth.cos(),
            );
            let d = to_world.transpose() * world;
            let expected = 2.0 * (1.0 + 0.5 * d.x + 0.25 * d.y + 0.125 * d.z);
            let found = f64::from(image.get(x, y).to_array()[0]);
            assert!(
                (found - expected).abs() < 0.01,
                "({x}, {y}): {found} {expected}"
            );
        }
    }

    #[test]
    fn upward_illuminance_matches_the_analytic_integral() {
        // The integral of (1 + z/8) z over the upper hemisphere: pi + 2 pi / 24.
        let expected = PI + PI / 12.0;
        assert!((upward_illuminance(&tilted(64)) - expected).abs() < 0.01);
        let black = Arc::new(Image::filled(2, 2, Rgb::BLACK));
        assert!(Panorama::new(black, 1.0, DMat3::IDENTITY, Some(1.0)).is_none());
    }
}
