//! Russian roulette ends paths at random and does not change the mean: tested on a surface whose lobes see a lamp and
//! darkness, with an albedo below 1.

use crate::common::scene::{patch_scene, see, surface};
use crate::common::scene_folder::in_repository;
use etendue::internals::accel::Backend;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::roulette::{Roulette, WeightWindow};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::render::options::RenderOptions;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, MaterialModel, SceneDescription,
};
use etendue::internals::scene::load::load;
use etendue::internals::session::{Session, tracing};

/// A floor with a highlight, and a lamp in its mirror direction.
fn highlight() -> SceneDescription {
    let grey = |value: f32| ColourDescription::Constant(Rgb::grey(value));
    let model = MaterialModel::Phong {
        diffuse: grey(0.3),
        specular: grey(0.3),
        exponent: 100.0,
    };
    let mut scene = patch_scene(DVec3::new(0.0, -1.0, 1.0), DVec3::ZERO, model);
    let disk = |center, normal, radius| GeometryDescription::Disk {
        center,
        normal,
        radius,
    };
    let floor = disk(DVec3::ZERO, DVec3::Z, 0.5);
    let lamp = disk(DVec3::new(0.0, 1.0, 1.0), DVec3::new(0.0, -1.0, -1.0), 0.3);
    scene.shapes = vec![surface(floor, 0.0), surface(lamp, 1.0)];
    scene
}

#[test]
fn russian_roulette_is_unbiased_on_a_glossy_highlight() {
    let scene = highlight();
    let with = |roulette| see(&scene, Backend::ALL[0], 1 << 13, Some(1), roulette);
    let never = with(Roulette::None);
    let window = Roulette::Window(WeightWindow::reciprocal_of(4).expect("it is at most 64"));
    for roulette in [Roulette::Albedo, Roulette::Throughput, window] {
        let seen = with(roulette);
        let [a, b] = [never, seen].map(|m| m.standard_error().expect("32 pixels"));
        let (apart, joint) = ((seen.mean() - never.mean()).abs(), a.hypot(b));
        let what = format!("{}: {seen:?} instead of {never:?}", roulette);
        assert!(apart <= 5.2 * joint, "{what}");
        assert!(joint <= 5e-3 * never.mean(), "too noisy to tell, {what}");
    }
}

/// Paths leave open scenes, where the smaller window is taken, as beside light paths all of which are connected to the lens
/// (shaded-lamps); other closed rooms keep the usual one, and what is named stays.
#[test]
fn weight_window_is_smaller_in_open_scenes_and_beside_all_light_paths() {
    let scenes = [
        ("environment", 4),
        ("motion-blur", 4),
        ("shaded-lamps", 4),
        ("ajar-door", 2),
        ("suzanne-room", 2),
    ];
    for (name, parts) in scenes {
        let path = in_repository(&format!("scenes/{name}/{name}.toml"));
        let scene = load(&path).expect("it is valid");
        let session = Session::new(scene, tracing()).expect("it is valid");
        for seed in 1..4 {
            let mut options = RenderOptions::samples(4);
            options.seed = Some(seed);
            options.integrator = Some(IntegratorKind::Path);
            let chosen = |options: &RenderOptions| {
                let rendering = session.start(options).expect("valid options");
                rendering.settings().roulette()
            };
            let window = WeightWindow::reciprocal_of(parts).map(Roulette::Window);
            assert_eq!(Some(chosen(&options)), window, "{name}");
            options.roulette = Some(Roulette::Albedo);
            assert_eq!(chosen(&options), Roulette::Albedo, "{name}");
        }
    }
}
