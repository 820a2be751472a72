//! Images at infinity: pbrt's equal-area octahedral maps, resampled to one panorama.
//!
//! Measure: radiance. A texel of the map covers the same solid angle as any other; rows of the panorama go down from +y.
//! Range: square maps; panoramas of at most 8192 x 4096 pixels, for which memory is checked. Each pixel of the panorama is
//! the mean of lookups, bilinear in the map, that are no further apart than its texels: of four, as a pixel has at most 0.8
//! times the solid angle of a texel, unless the map is larger than the largest panorama.
//! Source: Clarberg 2008, "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD". Tested below and in
//! `tests/loading/pbrt/`.

use crate::error::Result;
use crate::geometry::texture_image::TextureImage;
use crate::image::Image;
use crate::math::functions::{atan2, cos, sin, sin_cos};
use crate::math::rgb::Rgb;
use crate::math::transform::is_invertible;
use crate::math::vec::{DMat3, DVec2, DVec3};
use crate::memory;
use crate::planted::planted;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::sync::Arc;

/// Greatest height of a panorama, in pixels; it is twice as wide.
const MAX_ROWS: u32 = 4096;

/// Least number of lookups along each axis of a pixel.
const MIN_LOOKUPS: u32 = 2;

/// An octahedral map, and where it is in the world.
#[derive(Debug)]
pub struct Panorama {
    map: Arc<TextureImage>,
    scale: f64,
    from_world: DMat3,
}

impl Panorama {
    /// A map whose axes `to_world` turns into those of the world, times a scale. If `illuminance` is given, the map is
    /// scaled so that a surface that faces its +z has that irradiance before `scale`. `None` if a value is not finite.
    pub fn new(
        map: Arc<TextureImage>,
        scale: f64,
        to_world: DMat3,
        illuminance: Option<f64>,
    ) -> Option<Self> {
        let factor = illuminance.map_or(1.0, |wanted| wanted / upward_illuminance(&map));
        let scale = scale * factor;
        let brightest = map
            .texels()
            .fold(0.0, |most: f32, texel| most.max(texel.max_channel()));
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
        self.map.height().clamp(2, MAX_ROWS)
    }

    /// The radiance from a direction of the world.
    fn radiance(&self, direction: DVec3) -> Rgb {
        let towards = (self.from_world * direction).normalize_or(DVec3::Z);
        let colour = bilinear(&self.map, square(towards));
        colour.map(|x| (self.scale * f64::from(x)) as f32)
    }
}

/// The sum of the maps as a panorama of the world; `None` without any. It does not depend on the number of threads.
///
/// # Errors
/// If there is no memory for it.
pub fn panorama(maps: &[Panorama]) -> Result<Option<Image>> {
    let Some(height) = maps.iter().map(Panorama::rows).max() else {
        return Ok(None);
    };
    let side = maps.iter().map(|it| it.map.height()).max().unwrap_or(0);
    let lookups = side.div_ceil(height).max(MIN_LOOKUPS);
    let width = 2 * height;
    let count = width as usize * height as usize;
    memory::check((count * size_of::<Rgb>()) as u64, || {
        format!("a panorama of {width} x {height} pixels")
    })?;
    // The sine and the cosine at the centre of each part of an axis that has this many parts in all.
    let directions = |parts: u32, angle: fn(f64) -> f64| -> Vec<(f64, f64)> {
        let part = |index| sin_cos(angle((f64::from(index) + 0.5) / f64::from(parts)));
        (0..parts).map(part).collect()
    };
    let azimuths = directions(lookups * width, |u| TAU * (u - 0.5));
    let thetas = directions(lookups * height, |v| PI * v);
    let share = 1.0 / (lookups * lookups) as f32;
    let lookups = lookups as usize;
    let mut pixels = vec![Rgb::BLACK; count];
    pixels
        .par_chunks_exact_mut(width as usize)
        .zip(thetas.par_chunks_exact(lookups))
        .for_each(|(row, thetas)| {
            for (pixel, azimuths) in row.iter_mut().zip(azimuths.chunks_exact(lookups)) {
                let mut sum = Rgb::BLACK;
                for (sin_theta, cos_theta) in thetas {
                    for (sin, cos) in azimuths {
                        let towards = DVec3::new(sin_theta * sin, *cos_theta, -sin_theta * cos);
                        for map in maps {
                            sum += map.radiance(towards);
                        }
                    }
                }
                *pixel = share * sum;
            }
        });
    Ok(Some(Image::new(width, height, pixels)))
}

/// The illuminance of a surface that faces +z, by the map's luminance.
fn upward_illuminance(map: &TextureImage) -> f64 {
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
        (across * cos(phi)).copysign(p.x),
        (across * sin(phi)).copysign(p.y),
        (1.0 - r * r).copysign(distance),
    )
}

/// The point of the unit square of a unit direction: the inverse of [`sphere`].
fn square(direction: DVec3) -> DVec2 {
    let [x, y, z] = direction.abs().to_array();
    let r = (1.0 - z).max(0.0).sqrt();
    let phi = atan2(y, x) / FRAC_PI_2;
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

/// The colour at a point of the unit square, between the centres of texels. Beyond an edge the map continues mirrored at
/// the edge's middle.
fn bilinear(map: &TextureImage, point: DVec2) -> Rgb {
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
    fn tilted(side: u32) -> TextureImage {
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        let pixel = |index: u32| {
            let d = sphere(DVec2::new(at(index % side), at(index / side)));
            Rgb::grey((1.0 + 0.5 * d.x + 0.25 * d.y + 0.125 * d.z) as f32)
        };
        Image::new(side, side, (0..side * side).map(pixel).collect()).into()
    }

    #[test]
    fn panorama_applies_the_transform_and_scale_of_its_map() {
        let map = Arc::new(tilted(64));
        // pbrt's z becomes our y, and handedness stays.
        let to_world = DMat3::from_rotation_x(-FRAC_PI_2);
        let placed = Panorama::new(map, 2.0, to_world, None).expect("finite");
        let image = panorama(&[placed]).expect("there is memory").expect("one");
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
    fn panorama_of_noise_keeps_its_irradiance_on_any_number_of_threads() {
        let side = 64;
        // Texels without any likeness to their neighbours, in [0, 2).
        let pixel = |index: u32| {
            let index = u64::from(index);
            Rgb::grey(((index * 7919 + 13) * index % 1009) as f32 / 504.5)
        };
        let map = Image::new(side, side, (0..side * side).map(pixel).collect());
        let map = Arc::new(TextureImage::from(map));
        let expected = map.mean()[0];
        let place = || {
            let placed = Panorama::new(Arc::clone(&map), 1.0, DMat3::IDENTITY, None);
            [placed.expect("finite")]
        };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let work = || panorama(&place()).expect("there is memory").expect("one");
            pool.expect("a few threads").install(work)
        };
        let image = on(1);
        assert_eq!(on(3), image);
        let (mut sum, mut weights) = (0.0, 0.0);
        for y in 0..image.height() {
            let weight = (PI * (f64::from(y) + 0.5) / f64::from(image.height())).sin();
            for x in 0..image.width() {
                sum += weight * f64::from(image.get(x, y).to_array()[0]);
                weights += weight;
            }
        }
        let found = sum / weights;
        assert!(
            (found - expected).abs() < 0.01 * expected,
            "{found} {expected}"
        );
    }

    #[test]
    fn upward_illuminance_matches_the_analytic_integral() {
        // The integral of (1 + z/8) z over the upper hemisphere: pi + 2 pi / 24.
        let expected = PI + PI / 12.0;
        assert!((upward_illuminance(&tilted(64)) - expected).abs() < 0.01);
        let black = Arc::new(Image::filled(2, 2, Rgb::BLACK).into());
        assert!(Panorama::new(black, 1.0, DMat3::IDENTITY, Some(1.0)).is_none());
    }
}
