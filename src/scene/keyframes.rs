//! Interpolation between keyframes.
//!
//! Each keyframe's matrix is decomposed into a rotation and a stretch, M = R S. Between two keyframes R rotates about
//! one axis at constant speed, the shorter way, while S and the translation are interpolated linearly. The transform is
//! constant before the first keyframe and after the last one.
//!
//! Measure: world units; time in any unit.
//! Range: invertible matrices, finite times in order. A rotation between two keyframes is at most 180 degrees.
//! Source: Shoemake and Duff 1992, "Matrix Animation and Polar Decomposition"; Higham 1986 for the iteration. Tested
//! below.

use super::description::Keyframe;
use crate::math::functions::{atan2, cbrt};
use crate::math::transform::rotation;
use crate::math::vec::{DAffine3, DMat3, DQuat};
use crate::planted::planted;

/// Maximum number of intervals between shutter opening and closing.
const MAX_INTERVALS: u32 = 64;

/// Maximum distance of the middle of a chord from that of its arc, relative to the length of each axis: reached by a
/// rotation of 5.06 degrees, for 1 - cos(2.53 degrees) = 2^-10.
const CHORD: f64 = 1.0 / 1024.0;

/// Maximum distance of the middle of a chord from that of its arc, relative to the chord, for the path of an origin. A
/// rotation about a distant point by the angle of [`CHORD`] is well below it.
const ORIGIN_CHORD: f64 = 1.0 / 64.0;

/// Returns the transform at a time; the identity without keyframes. At a keyframe's time, and between two equal
/// keyframes, it is exactly theirs.
pub fn at(keys: &[Keyframe], time: f64) -> DAffine3 {
    let after = keys.partition_point(|key| key.time <= time);
    match (
        after.checked_sub(1).map(|before| keys[before]),
        keys.get(after),
    ) {
        (Some(a), Some(b)) if a.transform != b.transform && a.time != time => {
            between(&a.transform, &b.transform, share(a.time, b.time, time))
        }
        (Some(a), _) => a.transform,
        (None, Some(b)) => b.transform,
        (None, None) => DAffine3::IDENTITY,
    }
}

/// Whether the transform changes while the shutter is open.
pub fn moves(keys: &[Keyframe], shutter: [f64; 2]) -> bool {
    let [open, close] = shutter;
    let first = at(keys, open);
    open < close
        && (inside(keys, shutter).any(|key| key.transform != first) || at(keys, close) != first)
}

/// Returns the keyframes between the shutter's opening and closing.
fn inside(keys: &[Keyframe], [open, close]: [f64; 2]) -> impl Iterator<Item = &Keyframe> {
    let is_inside = move |key: &&Keyframe| open < key.time && key.time < close;
    keys.iter().filter(is_inside)
}

/// Returns the transforms at equally spaced times from the shutter's opening to its closing, between which matrices may
/// be interpolated linearly. A single one if nothing moves while the shutter is open.
///
/// The times of keyframes are among them if that takes no more than 64 intervals. There are never more than 64
/// intervals: a rotation of more than 324 degrees during the exposure is approximated more coarsely.
pub fn steps(keys: &[Keyframe], shutter: [f64; 2]) -> Vec<DAffine3> {
    let [open, close] = shutter;
    if !moves(keys, shutter) {
        return vec![at(keys, open)];
    }
    let shares: Vec<f64> = inside(keys, shutter)
        .map(|key| share(open, close, key.time))
        .collect();
    let intervals = (1..=MAX_INTERVALS)
        .find(|&intervals| shares.iter().all(|&share| falls_on_step(share, intervals)))
        .unwrap_or(MAX_INTERVALS);
    refined(intervals, MAX_INTERVALS, |share| {
        at(keys, mix(open, close, share))
    })
}

/// Samples a transform at equally spaced shares of the shutter's time, from 0 to 1. The number of intervals is doubled
/// until matrices may be interpolated linearly between them, or it would exceed `most`.
pub fn refined(
    mut intervals: u32,
    max_intervals: u32,
    transform: impl Fn(f64) -> DAffine3,
) -> Vec<DAffine3> {
    let sample = |intervals: u32| -> Vec<DAffine3> {
        let share = |step| f64::from(step) / f64::from(intervals);
        (0..=intervals).map(|step| transform(share(step))).collect()
    };
    let mut steps = sample(intervals);
    while 2 * intervals <= max_intervals {
        let finer = sample(2 * intervals);
        if finer.windows(3).step_by(2).all(chord_is_good) {
            break;
        }
        steps = finer;
        intervals *= 2;
    }
    steps
}

/// Returns the fraction of the time from `a` to `b` that has passed, from 0 to 1.
fn share(a: f64, b: f64, time: f64) -> f64 {
    // Halved, so that no difference of finite numbers overflows.
    let share = (0.5 * time - 0.5 * a) / (0.5 * b - 0.5 * a);
    // Times close to 0 may become equal when halved.
    if share.is_nan() { 0.0 } else { share }
}

/// Interpolates linearly; exactly `a` at 0 and `b` at 1.
pub fn mix(a: f64, b: f64, share: f64) -> f64 {
    (1.0 - share) * a + share * b
}

/// Whether a time is one of the steps, up to rounding: a few units in the last place of 1.
fn falls_on_step(share: f64, intervals: u32) -> bool {
    let step = share * f64::from(intervals);
    (step - step.round()).abs() <= 4.0 * f64::EPSILON * f64::from(intervals)
}

/// Whether the middle of three successive transforms is close to the mean of the others: its axes, and the path of its
/// origin.
fn chord_is_good(arc: &[DAffine3]) -> bool {
    let [a, middle, b] = [arc[0], arc[1], arc[2]];
    let axes_are_good = (0..3).all(|axis| {
        let [a, middle, b] = [a, middle, b].map(|it| it.matrix3.col(axis));
        (0.5 * (a + b) - middle).length() <= CHORD * middle.length()
    });
    let [a, middle, b] = [a, middle, b].map(|it| it.translation);
    let rounding = 8.0 * f64::EPSILON * middle.length();
    let limit = ORIGIN_CHORD * (b - a).length() + rounding;
    axes_are_good && (0.5 * (a + b) - middle).length() <= limit
}

/// Interpolates between two transforms.
fn between(a: &DAffine3, b: &DAffine3, share: f64) -> DAffine3 {
    let even = |a, b| (1.0 - share) * a + share * b;
    let matrix3 = if a.matrix3 == b.matrix3 {
        a.matrix3
    } else {
        match (polar(&a.matrix3), polar(&b.matrix3)) {
            (Some((rotation_a, stretch_a)), Some((rotation_b, stretch_b))) => {
                let stretch = stretch_a * (1.0 - share) + stretch_b * share;
                turned(&rotation_a, &rotation_b, share) * stretch
            }
            _ => a.matrix3 * (1.0 - share) + b.matrix3 * share,
        }
    };
    DAffine3 {
        matrix3,
        translation: even(a.translation, b.translation),
    }
}

/// Interpolates between two rotations about the axis of their quotient.
fn turned(a: &DMat3, b: &DMat3, share: f64) -> DMat3 {
    let turn = DQuat::from_mat3(&(*b * a.transpose()));
    // A quaternion and its negative are the same rotation: one of them takes the shorter way.
    let is_longer = planted!("the-longer-way-round", turn.w > 0.0, turn.w < 0.0);
    let turn = if is_longer { -turn } else { turn };
    let Some(axis) = turn.xyz().try_normalize() else {
        return *a;
    };
    let angle = 2.0 * atan2(turn.xyz().length(), turn.w);
    rotation(axis, share * angle) * *a
}

/// Decomposes M = R S into the rotation R and the symmetric stretch S; if M mirrors, S does. `None` if M's axes are so
/// uneven that its volume overflows or underflows.
fn polar(matrix: &DMat3) -> Option<(DMat3, DMat3)> {
    // Scaled to volume 1, where the iteration converges fast.
    let unit = *matrix * (1.0 / largest(matrix));
    let mut rotation = unit * (1.0 / cbrt(unit.determinant()));
    let mut change = f64::INFINITY;
    while rotation.is_finite() {
        let next = (rotation + rotation.inverse().transpose()) * 0.5;
        // The norm of these differences decreases until only rounding is left.
        let difference = norm(&(next - rotation));
        if difference >= change {
            let stretch = rotation.transpose() * *matrix;
            return Some((rotation, (stretch + stretch.transpose()) * 0.5));
        }
        (rotation, change) = (next, difference);
    }
    None
}

/// Returns the largest absolute entry.
fn largest(matrix: &DMat3) -> f64 {
    let entries = matrix.to_cols_array().into_iter();
    entries.fold(0.0, |max: f64, entry| max.max(entry.abs()))
}

/// Returns the Frobenius norm.
fn norm(matrix: &DMat3) -> f64 {
    let entries = matrix.to_cols_array().into_iter();
    entries.map(|entry| entry * entry).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec::DVec3;
    use crate::scene::description::Keyframe;

    const AXIS: DVec3 = DVec3::new(0.6, 0.0, 0.8);

    fn turn(degrees: f64) -> DAffine3 {
        DAffine3::from_axis_angle(AXIS, degrees.to_radians())
    }

    fn keys<const N: usize>(keys: [(f64, DAffine3); N]) -> Vec<Keyframe> {
        let key = |(time, transform)| Keyframe { time, transform };
        keys.map(key).to_vec()
    }

    /// Asserts that entries agree to `2^-44` of the largest.
    #[track_caller]
    fn assert_near(got: DAffine3, want: DAffine3) {
        let off = largest(&(got.matrix3 - want.matrix3));
        assert!(
            off <= largest(&want.matrix3) * f64::exp2(-44.0),
            "{got} instead of {want}"
        );
        let off = got.translation.distance(want.translation);
        assert!(
            off <= want.translation.length() * f64::exp2(-44.0),
            "{got} instead of {want}"
        );
    }

    #[test]
    fn rotation_is_interpolated_at_constant_angular_velocity() {
        for angle in [1e-9, 1.0, 90.0, -120.0, 179.9] {
            let turntable = keys([(1.0, turn(20.0)), (3.0, turn(20.0 + angle))]);
            for share in [0.0, 1e-3, 0.25, 0.5, 0.9, 1.0] {
                let want = turn(20.0 + share * angle);
                assert_near(at(&turntable, 1.0 + 2.0 * share), want);
            }
        }
        // A full turn in three parts.
        let whole = [0.0, 1.0, 2.0, 3.0].map(|time| (time, turn(120.0 * time)));
        for time in [0.1, 1.0, 1.7, 2.5, 3.0] {
            assert_near(at(&keys(whole), time), turn(120.0 * time));
        }
        // The shorter way: 270 degrees are 90 backwards.
        let back = keys([(0.0, turn(0.0)), (1.0, turn(270.0))]);
        assert_near(at(&back, 0.5), turn(-45.0));
    }

    #[test]
    fn translation_and_scale_are_interpolated_linearly() {
        let (from, to) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-5.0, 2.5, 1e3));
        for share in [0.25, 0.5, 0.7] {
            let moved = keys([
                (0.0, DAffine3::from_translation(from)),
                (1.0, DAffine3::from_translation(to)),
            ]);
            let want = DAffine3::from_translation(from.lerp(to, share));
            assert_near(at(&moved, share), want);
            assert_eq!(at(&moved, share).matrix3, DMat3::IDENTITY);

            let [from, to] = [from.abs(), to.abs()];
            let stretched = keys([
                (0.0, turn(30.0) * DAffine3::from_scale(from)),
                (1.0, turn(80.0) * DAffine3::from_scale(to)),
            ]);
            let want = turn(30.0 + share * 50.0) * DAffine3::from_scale(from.lerp(to, share));
            assert_near(at(&stretched, share), want);
        }
    }

    #[test]
    fn mirroring_is_preserved_between_keyframes() {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 2.0, 3.0));
        let turning = keys([(0.0, mirror), (1.0, turn(100.0) * mirror)]);
        for share in [0.1, 0.5, 0.8] {
            assert_near(at(&turning, share), turn(100.0 * share) * mirror);
            assert!(at(&turning, share).matrix3.determinant() < 0.0);
        }
    }

    #[test]
    fn keyframes_are_exact_and_equal_keyframes_are_constant() {
        let odd = turn(33.3) * DAffine3::from_scale(DVec3::new(0.1, 0.7, -1.3));
        let path = keys([(0.1, odd), (0.3, turn(77.7)), (0.7, turn(77.7))]);
        for (time, want) in [
            (f64::MIN, odd),
            (0.1, odd),
            (0.3, turn(77.7)),
            (0.4, turn(77.7)),
            (0.6999, turn(77.7)),
            (0.7, turn(77.7)),
            (f64::MAX, turn(77.7)),
        ] {
            assert_eq!(at(&path, time), want, "{time}");
        }
        assert_eq!(at(&[], 1.0), DAffine3::IDENTITY);
        assert_eq!(at(&path[..1], 5.0), odd);
        // The largest possible difference of times.
        let far = keys([(f64::MIN, turn(0.0)), (f64::MAX, turn(90.0))]);
        assert_near(at(&far, 0.0), turn(45.0));
    }

    #[test]
    fn polar_decomposition_yields_rotation_and_symmetric_stretch() {
        for (numbers, sign) in [
            ([1.0, 2.0, 3.0, 0.0, 1.0, 4.0, 5.0, 6.0, 0.0], 1.0),
            ([1e-9, 0.0, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, 1e-3], 1.0),
            ([-2e100, 0.0, 0.0, 0.0, 2e100, 1e100, 0.0, 0.0, 3e100], -1.0),
        ] {
            let matrix = DMat3::from_cols_array(&numbers);
            let (rotation, stretch) = polar(&matrix).expect("it is invertible");
            let unit = rotation.transpose() * rotation - DMat3::IDENTITY;
            assert!(
                largest(&unit) < 1e-14 && rotation.determinant() > 0.0,
                "{matrix}"
            );
            assert!(
                largest(&(rotation * stretch - matrix)) < 1e-14 * largest(&matrix),
                "{matrix}"
            );
            assert_eq!(stretch, stretch.transpose());
            // S stretches all axes, or mirrors all of them.
            let trace = stretch.x_axis.x + stretch.y_axis.y + stretch.z_axis.z;
            assert!(trace * sign > 0.0, "{stretch}");
        }
        // No rotation can be determined: the entries are interpolated linearly.
        let flat = DAffine3::from_scale(DVec3::new(1.0, 1e-200, 1e-200));
        let squeezed = keys([(0.0, flat), (1.0, DAffine3::IDENTITY)]);
        assert_eq!(at(&squeezed, 0.5).matrix3.y_axis.y, 0.5);
    }

    #[test]
    fn transform_constant_over_the_shutter_is_a_single_step() {
        let path = keys([(0.0, turn(0.0)), (1.0, turn(50.0)), (2.0, turn(50.0))]);
        for (keys, shutter, want) in [
            (&path[..], [0.5, 0.5], turn(25.0)),
            (&path[..], [1.0, 1.7], turn(50.0)),
            (&path[..], [1.0, 9.0], turn(50.0)),
            (&path[..], [-2.0, 0.0], turn(0.0)),
            (&path[..1], [0.0, 1.0], turn(0.0)),
            (&[], [0.0, 1.0], DAffine3::IDENTITY),
        ] {
            let steps = steps(keys, shutter);
            assert_eq!(steps.len(), 1, "{shutter:?}");
            assert_near(steps[0], want);
        }
        assert_eq!(steps(&path, [1.0, 2.0]), [turn(50.0)]);
    }

    #[test]
    fn step_count_is_set_by_keyframe_times_and_chord_error() {
        let away = |x| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        let moved = keys([(0.0, away(0.0)), (1.0, away(8.0))]);
        assert_eq!(steps(&moved, [0.0, 1.0]), [away(0.0), away(8.0)]);
        assert_eq!(steps(&moved, [0.25, 0.5]), [away(2.0), away(4.0)]);
        // The motion ends in the middle, or after a third.
        assert_eq!(steps(&moved, [0.0, 2.0]), [0.0, 8.0, 8.0].map(away));
        assert_eq!(steps(&moved, [0.0, 3.0]), [0.0, 8.0, 8.0, 8.0].map(away));
        let third = keys([(0.1, away(0.0)), (0.2, away(1.0)), (0.4, away(0.0))]);
        assert_eq!(steps(&third, [0.1, 0.4]).len(), 4);
        let odd = keys([(0.0, away(0.0)), (1.0 / 129.0, away(1.0)), (1.0, away(0.0))]);
        assert_eq!(steps(&odd, [0.0, 1.0]).len(), 65);
        // At most 5.06 degrees per step.
        for (degrees, intervals) in [
            (5.0, 1),
            (10.0, 2),
            (10.2, 4),
            (90.0, 32),
            (160.0, 32),
            (170.0, 64),
        ] {
            let turntable = keys([(0.0, turn(0.0)), (1.0, turn(degrees))]);
            assert_eq!(
                steps(&turntable, [0.0, 1.0]).len(),
                intervals + 1,
                "{degrees}"
            );
        }
    }

    #[test]
    fn chord_error_between_steps_is_bounded() {
        let stretched = |degrees, x| turn(degrees) * DAffine3::from_scale(DVec3::new(x, 1.0, 0.01));
        let path = keys([
            (0.0, stretched(0.0, 1.0)),
            (0.5, stretched(60.0, 3.0)),
            (1.0, stretched(-40.0, 0.5)),
        ]);
        let steps = steps(&path, [0.1, 0.9]);
        let intervals = steps.len() - 1;
        assert!((2..=64).contains(&intervals), "{intervals}");
        for i in 0..=1000 {
            let share = f64::from(i) / 1000.0;
            let position = share * intervals as f64;
            let before = (position as usize).min(intervals - 1);
            let part = position - before as f64;
            let chord = steps[before].matrix3 * (1.0 - part) + steps[before + 1].matrix3 * part;
            let arc = at(&path, mix(0.1, 0.9, share)).matrix3;
            for axis in 0..3 {
                let off = (chord.col(axis) - arc.col(axis)).length() / arc.col(axis).length();
                assert!(off < 1.05 * CHORD, "{share}, axis {axis}: {off}");
            }
        }
    }
}
