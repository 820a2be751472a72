//! Tests of area lights that BSDF sampling and light sampling both find (combined by MIS), or only one of them.

use crate::common::scene::{diffuse, patch_scene, rectangle, see, surface};
use crate::common::verdict::assert_mean;
use etendue::internals::accel::Backend;
use etendue::internals::integrator::Roulette;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, Place,
};
use etendue_lab::battery::closed_forms::parallel_rectangle;

const REFLECTANCE: f32 = 0.99;

/// A large, close lamp, which BSDF sampling and light sampling find about equally often.
#[test]
fn large_area_light_render_matches_its_form_factor() {
    let albedo = 0.5;
    let mut scene = patch_scene(DVec3::new(0.3, 0.2, 0.4), DVec3::ZERO, diffuse(albedo));
    let floor = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let lamp = rectangle([-1.0, -1.0, 1.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]);
    scene.shapes = vec![surface(floor, 0.0), surface(lamp, 1.0)];
    let exact = f64::from(albedo) * 4.0 * parallel_rectangle(1.0, 1.0, 1.0);
    for &backend in Backend::ALL {
        let seen = see(&scene, backend, 1 << 10, Some(1), Roulette::None);
        assert_mean(backend.name(), &seen, exact, 2e-3);
    }
}

/// A lamp that faces up to a mirror lights the floor like its mirror image. Only BSDF sampling at the floor finds this
/// light, not light sampling.
#[test]
fn light_reflected_by_mirror_matches_its_virtual_image() {
    let albedo = 0.5;
    let mut scene = patch_scene(DVec3::new(-0.3, 0.2, 0.4), DVec3::ZERO, diffuse(albedo));
    let model = MaterialModel::Mirror {
        reflectance: ColourDescription::Constant(Rgb::grey(REFLECTANCE)),
    };
    scene
        .materials
        .push(MaterialDescription::new("mirror", Place::default(), model));
    let floor = rectangle([-0.5, -0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let lamp = rectangle([0.6, -0.5, 0.3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let above = rectangle([-2.0, -2.0, 1.0], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0]);
    scene.shapes = vec![surface(floor, 0.0), surface(lamp, 1.0), surface(above, 0.0)];
    scene.shapes[2].material = 1;
    // The mirror image extends from x = 0.6 to 1.6, as far above the mirror as the lamp is below it.
    let up_to = |x: f64| 2.0 * parallel_rectangle(x, 0.5, 1.7);
    let exact = f64::from(albedo * REFLECTANCE) * (up_to(1.6) - up_to(0.6));
    for &backend in Backend::ALL {
        let seen = see(&scene, backend, 1 << 12, Some(2), Roulette::None);
        assert_mean(backend.name(), &seen, exact, 1e-2);
    }
}
