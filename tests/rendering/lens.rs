//! Images of the thin lens: a lens of radius 0 is a pinhole bit for bit, and objects out of focus are blurred by the circle of
//! confusion. Its closed form is row 45 of the battery.

use crate::common::nightly::backends;
use crate::common::scene::{diffuse, gallery, keys, patch_scene, picture, rectangle, see, surface};
use crate::common::verdict::assert_mean;
use etendue::internals::accel::Backend;
use etendue::internals::integrator::Roulette;
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::scene::description::SceneDescription;
use etendue_lab::battery::closed_forms::disc_segment;

#[test]
fn zero_radius_lens_is_bit_identical_to_a_pinhole() {
    for &backend in Backend::ALL {
        let pinhole = picture(&gallery(), backend, 4);
        for focus_distance in [1e-3, 1.0, 3.7, 1e9, 1e30] {
            let mut scene = gallery();
            scene.camera.focus_distance = focus_distance;
            assert_eq!(picture(&scene, backend, 4), pinhole, "{focus_distance}");
        }
        let mut scene = gallery();
        scene.camera.lens_radius = 0.1;
        scene.camera.focus_distance = 2.0;
        assert_ne!(
            picture(&scene, backend, 4),
            pinhole,
            "a lens changes the image"
        );
    }
}

/// Far from all edges, a lens of radius 1e-8 gives the radiance of a pinhole.
#[test]
fn tiny_lens_radiance_agrees_with_a_pinhole() {
    for &backend in backends("tiny lens") {
        for target in [DVec3::new(0.7, -1.0, 0.0), DVec3::new(0.5, 0.3, 0.65)] {
            let mut scene = gallery();
            let view = patch_scene(DVec3::new(1.0, -4.0, 2.0), target, diffuse(0.6));
            (scene.camera, scene.film) = (view.camera, view.film);
            let pinhole = see(&scene, backend, 1 << 12, Some(1), Roulette::None);
            scene.camera.lens_radius = 1e-8;
            for focus_distance in [1.0, 4.0, 1e9] {
                scene.camera.focus_distance = focus_distance;
                let lens = see(&scene, backend, 1 << 12, Some(1), Roulette::None);
                let [a, b] = [pinhole, lens].map(|m| m.standard_error().expect("32 pixels"));
                let (apart, joint) = ((lens.mean() - pinhole.mean()).abs(), a.hypot(b));
                println!("{target} {focus_distance}: {pinhole:?} {lens:?}");
                let tolerance = 5.2 * joint + 4e-6 * pinhole.mean();
                assert!(
                    apart <= tolerance,
                    "{focus_distance}: {apart} > {tolerance}"
                );
                assert!(
                    joint <= 2e-3 * pinhole.mean(),
                    "too noisy for a conclusion: {joint}"
                );
            }
        }
    }
}

/// A half-plane x >= `edge` at z = 0 with radiance 1, seen around the origin from a height.
fn half_plane(edge: f64, height: f64, lens_radius: f64, focus_distance: f64) -> SceneDescription {
    let mut scene = patch_scene(height * DVec3::Z, DVec3::ZERO, diffuse(0.0));
    // As large as rays can reach, and no larger: the absolute precision depends on the size of the scene.
    let far = 1.0 + 4.0 * lens_radius * f64::abs(height / focus_distance - 1.0);
    let half = rectangle([edge, -far, 0.0], [far, 0.0, 0.0], [0.0, 2.0 * far, 0.0]);
    scene.shapes = vec![surface(half, 1.0)];
    scene.camera.lens_radius = lens_radius;
    scene.camera.focus_distance = focus_distance;
    scene
}

#[test]
fn an_edge_in_focus_is_sharp() {
    // Edges outside a patch of 1e-4 about the origin, with a margin for the rounding of a lens a thousand times as wide.
    for (edge, radiance) in [(-2.5e-4, 1.0), (2.5e-4, 0.0)] {
        let scene = half_plane(edge, 2.0, 0.3, 2.0);
        for &backend in Backend::ALL {
            let seen = see(&scene, backend, 1 << 10, Some(0), Roulette::None);
            assert_eq!(seen.mean(), radiance, "{edge} {}", backend.name());
        }
    }
}

/// The lens moves with its camera: moving the camera along an edge does not change the blur of the edge, nor does turning the
/// lens about its axis.
#[test]
fn edge_defocus_is_unchanged_by_motion_along_the_edge() {
    for x in [-0.5, 0.2, 0.8] {
        let mut scene = half_plane(0.1 * x, 2.0, 0.1, 1.0);
        let start = scene.camera.to_world;
        let along = DAffine3::from_translation(0.7 * DVec3::Y);
        let turned = DAffine3::from_rotation_z(1.0);
        scene.camera.shutter = [0.0, 1.0];
        let ends = [along * start, turned * start, along * turned * start];
        for (index, end) in ends.into_iter().enumerate() {
            scene.camera.motion = keys([(0.0, start), (1.0, end)]);
            for &backend in backends(&format!("{x} {index}")) {
                let seen = see(&scene, backend, 1 << 12, Some(0), Roulette::None);
                assert_mean(
                    &format!("{x}"),
                    &seen,
                    disc_segment(x),
                    2e-3 / disc_segment(x),
                );
            }
        }
    }
}
