//! The first-hit features that guide the comparison of pixels: albedo, normal, distance.
//!
//! The distance of two pixels is the largest of three squared distances, from each of which its expectation by the
//! noise of the features is subtracted, and which is measured in squares of the step that still counts as equal:
//!
//! - albedo and normal: |f_p - f_q|^2 over the largest of the tolerance, the variance and the squared gradient at p;
//! - distance: the reciprocal of the distance is affine over the image of a plane, so the measure is the deviation of
//!   q from the tangent plane at p, relative to p's own distance.
//!
//! Measure: albedo in [0, 1], unit normals, distances in any unit.
//! Range: infinite distance where nothing is hit.
//! Source: Rousselle, Manzi and Zwicker 2013, "Robust Denoising using Feature and Color Information", section 4, with the
//! tangent plane of Moon et al. 2014 in place of a constant distance. Tested below and in `tests/rendering/denoise.rs`.

use crate::math::plane::Plane;

/// The layers of a file that describe first hits.
#[derive(Debug, Clone)]
pub struct FirstHitLayers {
    pub albedo: [Plane; 3],
    pub normal: [Plane; 3],
    pub distance: Plane,
    /// Standard errors of albedo, normal and distance.
    pub errors: [Plane; 3],
}

/// A feature of one or more channels, prepared for comparison.
#[derive(Debug, Clone)]
pub struct Feature {
    pub channels: Vec<Plane>,
    /// The variance of all channels together.
    pub variance: Plane,
    /// The divisor of squared differences.
    pub scale: Plane,
    /// Change per column and row, for a feature that is compared with its tangent plane.
    pub slope: Option<[Plane; 2]>,
}

/// Squared steps that count as equal.
const ALBEDO_TOLERANCE: f32 = 2e-3;
const NORMAL_TOLERANCE: f32 = 5e-3;
const DISTANCE_TOLERANCE: f32 = 1e-4;

/// Builds all features of an image.
pub fn features(layers: &FirstHitLayers) -> Vec<Feature> {
    let [albedo, normal, distance] = &layers.errors;
    let squared = |plane: &Plane| plane.like(|i| plane.values[i] * plane.values[i]);
    vec![
        constant(
            &layers.albedo,
            scaled(&squared(albedo), 3.0),
            ALBEDO_TOLERANCE,
        ),
        constant(&layers.normal, squared(normal), NORMAL_TOLERANCE),
        tangent(&layers.distance, distance),
    ]
}

fn scaled(plane: &Plane, factor: f32) -> Plane {
    plane.like(|i| factor * plane.values[i])
}

/// Builds a feature that is compared directly.
fn constant(channels: &[Plane; 3], variance: Plane, tolerance: f32) -> Feature {
    let mut gradient2 = vec![0.0_f32; variance.values.len()];
    for channel in channels {
        let [across, down] = slopes(channel);
        for (i, sum) in gradient2.iter_mut().enumerate() {
            *sum += across.values[i].powi(2) + down.values[i].powi(2);
        }
    }
    let scale = variance.like(|i| tolerance.max(variance.values[i]).max(gradient2[i]));
    Feature {
        channels: channels.to_vec(),
        variance,
        scale,
        slope: None,
    }
}

/// Builds the feature of the reciprocal of the distance, which is compared with the tangent plane.
fn tangent(distance: &Plane, error: &Plane) -> Feature {
    let near = distance.like(|i| 1.0 / distance.values[i]);
    let variance = near.like(|i| {
        // d(1 / z) = dz / z^2, and 0 where nothing is hit.
        let error = error.values[i] * near.values[i] * near.values[i];
        error * error
    });
    let scale = near.like(|i| {
        let tolerance = DISTANCE_TOLERANCE * near.values[i] * near.values[i];
        tolerance.max(variance.values[i]).max(f32::MIN_POSITIVE)
    });
    let slope = slopes(&near);
    Feature {
        channels: vec![near],
        variance,
        scale,
        slope: Some(slope),
    }
}

/// The slopes per column and row: the smaller of the differences to either side, so that the slope beside an edge is
/// that of the pixel's own side.
fn slopes(plane: &Plane) -> [Plane; 2] {
    let slope = |dx: isize, dy: isize| {
        plane.like(|i| {
            let (x, y) = ((i % plane.width) as isize, (i / plane.width) as isize);
            let (first, last) = (x - dx, y - dy);
            let is_first = first < 0 || last < 0;
            let (right, below) = (x + dx, y + dy);
            let is_last = right >= plane.width as isize || below >= plane.height as isize;
            let here = plane.values[i];
            let (before, after) = (here - plane.at(first, last), plane.at(right, below) - here);
            if is_last || (!is_first && before.abs() < after.abs()) {
                before
            } else {
                after
            }
        })
    };
    [slope(1, 0), slope(0, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(distance: Plane) -> FirstHitLayers {
        let one = || distance.like(|_| 1.0);
        let none = || distance.like(|_| 0.0);
        FirstHitLayers {
            albedo: [one(), one(), one()],
            normal: [none(), none(), one()],
            errors: [none(), none(), none()],
            distance,
        }
    }

    /// A receding plane: the reciprocal of its distance is affine, so any pixel lies on the tangent at any other.
    #[test]
    fn reciprocal_distance_of_a_plane_has_constant_slope() {
        let near = |i: usize| 1.0 + 0.3 * (i % 9) as f32 + 0.05 * (i / 9) as f32;
        let distance = Plane::new(9, 7, (0..63).map(|i| 1.0 / near(i)).collect());
        let features = features(&layers(distance));
        let feature = &features[2];
        let [across, down] = feature.slope.as_ref().expect("distances have a slope");
        for i in 0..63 {
            assert!((across.values[i] - 0.3).abs() < 1e-5, "{i}");
            assert!((down.values[i] - 0.05).abs() < 1e-5, "{i}");
        }
    }

    #[test]
    fn slope_beside_a_depth_discontinuity_is_one_sided() {
        let distance = Plane::new(6, 1, vec![2.0, 2.0, 2.0, 8.0, 8.0, f32::INFINITY]);
        let features = features(&layers(distance));
        let feature = &features[2];
        let [across, _] = feature.slope.as_ref().expect("distances have a slope");
        assert_eq!(across.values[..4], [0.0; 4]);
        // The step is far larger than one that counts as equal.
        let near = &feature.channels[0].values;
        let step = near[2] - near[3];
        assert!(step * step / feature.scale.values[2] > 100.0);
        assert!(
            feature
                .scale
                .values
                .iter()
                .all(|&x| x > 0.0 && x.is_finite())
        );
    }
}
