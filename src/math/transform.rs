//! Properties of linear transforms, and the placement of cameras.
//!
//! Measure: any units of length.
//! Range: any matrices; one with numbers that are not finite is neither a rotation nor invertible.
//! Source: none needed. Tested below and in `tests/loading/scene_files.rs`.

use super::functions::{atan2, sin_cos};
use super::vec::{DAffine3, DMat3, DVec3};

/// Whether a matrix is invertible, at any scale: compares its determinant with the product of its axes' lengths.
pub fn is_invertible(matrix: &DMat3) -> bool {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let lengths: f64 = axes.iter().map(|axis| axis.length()).product();
    lengths > 0.0 && matrix.determinant().abs() > 1e-12 * lengths
}

/// Whether a matrix is a pure rotation.
pub fn is_rotation(matrix: &DMat3) -> bool {
    let error = *matrix * matrix.transpose() - DMat3::IDENTITY;
    let largest = error
        .to_cols_array()
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max);
    largest < 1e-6 && matrix.determinant() > 0.0
}

/// The rotation about the unit vector `axis`, in radians: Rodrigues' formula, by functions that are the same everywhere.
pub fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    let (sin, cos) = sin_cos(angle);
    let turned = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DMat3::from_cols(turned(DVec3::X), turned(DVec3::Y), turned(DVec3::Z))
}

/// The angle between two vectors, from 0 to pi; accurate also where it is small.
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    atan2(a.cross(b).length(), a.dot(b))
}

/// The transform of a camera at `eye` that looks at `target`; `None` where its orientation is undetermined.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Option<DAffine3> {
    Some(DAffine3 {
        matrix3: orientation(eye - target, up)?,
        translation: eye,
    })
}

/// The axes of a camera that looks along `-back`; `None` where its orientation is undetermined.
pub fn orientation(back: DVec3, up: DVec3) -> Option<DMat3> {
    let back = back.try_normalize()?;
    let right = up.try_normalize()?.cross(back);
    // Nearly parallel vectors leave a direction that is mostly rounding error.
    let right = (right.length() > 1e-9).then(|| right.normalize())?;
    Some(DMat3::from_cols(right, back.cross(right), back))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_rotation_and_is_invertible_classify_matrices() {
        let turned = DMat3::from_rotation_y(0.3);
        assert!(is_rotation(&turned) && is_invertible(&turned));
        let tiny = 1e-9 * turned;
        assert!(!is_rotation(&tiny) && is_invertible(&tiny));
        let flat = DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0));
        assert!(!is_rotation(&flat) && !is_invertible(&flat));
        let unknown = DMat3::from_diagonal(DVec3::new(1.0, f64::NAN, 1.0));
        assert!(!is_rotation(&unknown) && !is_invertible(&unknown));
        let mirrored = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
        assert!(!is_rotation(&mirrored) && is_invertible(&mirrored));
    }

    #[test]
    fn rotations_and_angles_agree_with_glam() {
        for i in 0..50 {
            let t = f64::from(i) * 0.37;
            let axis = DVec3::new(t.sin(), 0.3, t.cos()).normalize();
            let theirs = DMat3::from_axis_angle(axis, t - 9.0);
            let error = rotation(axis, t - 9.0) - theirs;
            assert!(error.to_cols_array().iter().all(|x| x.abs() < 1e-15));
            let (a, b) = (theirs.x_axis * 3.0, DVec3::new(0.2, -t, 1.0));
            assert!((angle(a, b) - a.angle_between(b)).abs() < 1e-7);
        }
        // glam's arc cosine has no angle that is this small.
        assert_eq!(angle(DVec3::X, DVec3::new(1.0, 1e-12, 0.0)), 1e-12);
    }

    #[test]
    fn look_at_faces_negative_z_and_rejects_degenerate_input() {
        let placed = look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y);
        let expected = DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0));
        assert!(
            placed
                .expect("it has a direction")
                .abs_diff_eq(expected, 1e-12)
        );
        assert!(look_at(DVec3::ONE, DVec3::ONE, DVec3::Y).is_none());
        assert!(look_at(DVec3::Y, DVec3::ZERO, DVec3::Y).is_none());
    }
}
