//! Tests of sessions: rendering, continuing a rendering, ray queries, and no rebuild of unchanged parts.

use crate::common::scene_folder::{SMALL, load_text};
use etendue::ErrorKind;
use etendue::internals::accel::{AccelOptions, Backend};
use etendue::internals::effects::Effect;
use etendue::internals::film::filter::{Filter, FilterSampling};
use etendue::internals::image::Image;
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::integrator::light_paths::LightPathShare;
use etendue::internals::integrator::reuse::PathReuse;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::render::options::RenderOptions;
use etendue::internals::render::settings::{
    Adaptive, BounceLimit, Budget, LightPathRule, PathReuseRule, RenderSettings,
};
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::{
    CameraDescription, FilmDescription, GeometryDescription, InstanceDescription, LightDescription,
    MaterialDescription, MaterialModel, Place, SceneDescription, ShapeDescription,
};
use etendue::internals::session::{QueryRay, Rendering, Session, tracing};
use std::sync::Arc;

const fn can_be_shared<T: Send + Sync>() {}
const _: () = can_be_shared::<Session>();
const _: () = can_be_shared::<Rendering>();

fn traced_by(backend: Backend) -> AccelOptions {
    AccelOptions {
        backend,
        threads: 2,
        ..tracing()
    }
}

fn session(description: SceneDescription, backend: Backend) -> Session {
    Session::new(description, traced_by(backend)).expect("a valid scene")
}

fn picture(session: &Session, spp: u64) -> Image {
    let rendering = session.render(&RenderOptions::samples(spp), &NullRenderObserver);
    rendering.expect("valid options").image()
}

fn sphere(center: DVec3, radius: f64) -> GeometryDescription {
    GeometryDescription::Sphere { center, radius }
}

fn shape(name: &str, geometry: GeometryDescription) -> ShapeDescription {
    ShapeDescription::new(name, Place::default(), geometry)
}

/// A floor of many boxes, and one instance, off the centre, of a group with a stone and a lamp.
fn movable() -> SceneDescription {
    let eye = DVec3::new(0.0, 4.0, 8.0);
    let camera = CameraDescription::look_at(eye, DVec3::ZERO, DVec3::Y, 0.8).expect("a direction");
    let mut scene = SceneDescription::new("movable", camera);
    scene.film.size = (24, 16);
    let reflectance = Rgb::grey(0.6).into();
    let matte = MaterialModel::Diffuse { reflectance };
    let matte = MaterialDescription::new("matte", Place::default(), matte);
    scene.add_material(matte).expect("valid");
    for x in -3..=3 {
        let min = DVec3::new(f64::from(x), -1.0, -3.0);
        let max = min + DVec3::new(0.9, 1.0, 6.0);
        let block = shape("block", GeometryDescription::Box { min, max });
        scene.add_shape(block).expect("valid");
    }
    let group = Some(scene.add_group("lantern"));
    let stone = GeometryDescription::Box {
        min: DVec3::new(-0.3, 0.0, -0.3),
        max: DVec3::new(0.3, 0.5, 0.3),
    };
    scene
        .add_shape(ShapeDescription {
            group,
            ..shape("stone", stone)
        })
        .expect("valid");
    scene
        .add_shape(ShapeDescription {
            group,
            emission: Some(Rgb::grey(20.0).into()),
            ..shape("lamp", sphere(DVec3::new(0.0, 1.0, 0.0), 0.2))
        })
        .expect("valid");
    scene
        .add_instance(InstanceDescription {
            name: "lantern".into(),
            place: Place::default(),
            of: 0,
            group: None,
            transform: DAffine3::from_translation(DVec3::new(1.5, 0.0, 0.0)),
            motion: vec![],
        })
        .expect("valid");
    scene
}

#[test]
fn session_render_is_identical_to_a_direct_render() {
    let description = load_text(SMALL);
    let session = session(description.clone(), Backend::ALL[0]);
    let settings = RenderSettings {
        filter_sampling: FilterSampling::Splatting,
        has_window_pilot: true,
        light_paths: LightPathRule::Auto,
        ..RenderSettings::new(description.film.size, 4)
    };
    let prepared =
        etendue::internals::scene::prepare::prepare(&description, traced_by(Backend::ALL[0]));
    let scene = prepared.expect("valid").scene;
    let filter = Filter::new(&description.film.filter);
    let size = description.film.size;
    let alone = render(&scene, &filter, size, &settings, &NullRenderObserver).expect("valid");
    assert_eq!(picture(&session, 4), alone.film.develop());
}

#[test]
fn changing_the_camera_rebuilds_nothing_and_renders_correctly() {
    for &backend in Backend::ALL {
        let mut changed = session(movable(), backend);
        let world = Arc::clone(&changed.scene().world);
        let mut moved = movable();
        let eye = DVec3::new(3.0, 2.0, 6.0);
        let look = CameraDescription::look_at(eye, DVec3::ZERO, DVec3::Y, 0.5);
        moved.camera = CameraDescription {
            lens_radius: 0.1,
            ..look.expect("a direction")
        };
        moved.film = FilmDescription {
            size: (20, 20),
            ..moved.film
        };
        changed.set_camera(moved.camera.clone()).expect("valid");
        changed.set_film(moved.film.clone()).expect("valid");
        let work = changed.work();
        assert_eq!((work.builds, work.cameras, work.placements), (1, 2, 0));
        assert!(Arc::ptr_eq(&world, &changed.scene().world));
        // The kernel in use may support lenses anyway, so the scene's own effects are checked.
        assert!(changed.scene().effects.has(Effect::Lens));
        assert_eq!(picture(&changed, 4), picture(&session(moved, backend), 4));
    }
}

#[test]
fn moving_an_instance_rebuilds_no_group_and_renders_correctly() {
    for &backend in Backend::ALL {
        let mut changed = session(movable(), backend);
        let before = picture(&changed, 4);
        let shapes = changed.scene().world.groups().as_ptr();
        let turned = DAffine3::from_translation(DVec3::new(2.0, 0.5, 1.0))
            * DAffine3::from_rotation_y(0.4)
            * DAffine3::from_scale(DVec3::splat(1.5));
        changed.set_transforms(&[(0, turned)]).expect("valid");
        let work = changed.work();
        assert_eq!((work.builds, work.cameras, work.placements), (1, 0, 1));
        assert_eq!(changed.scene().world.groups().as_ptr(), shapes);
        let mut moved = movable();
        moved.instances[0].transform = turned;
        // Most of the scene has not moved, so its normalisation is unchanged and the images are bit-identical.
        let after = picture(&changed, 4);
        assert_ne!(after, before);
        assert_eq!(after, picture(&session(moved, backend), 4), "{backend:?}");
    }
}

#[test]
fn rejected_changes_leave_the_session_unchanged() {
    let mut session = session(movable(), Backend::ALL[0]);
    let before = picture(&session, 2);
    let mut rendering = session.start(&RenderOptions::samples(2)).expect("valid");
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let far = DAffine3::from_translation(DVec3::splat(1e40));
    let there = DAffine3::IDENTITY;
    for transforms in [
        vec![(0, flat)],
        vec![(0, far)],
        vec![(0, there), (1, there)],
        vec![(0, DAffine3::from_scale(DVec3::NAN))],
    ] {
        session
            .set_transforms(&transforms)
            .expect_err("an invalid transform");
    }
    let mut camera = session.description().camera.clone();
    camera.fov = 4.0;
    session
        .set_camera(camera)
        .expect_err("the field of view is too wide");
    let mut film = session.description().film.clone();
    film.size = (0, 5);
    session.set_film(film).expect_err("the film is empty");
    assert_eq!(session.work().builds + session.work().placements, 1);
    rendering
        .continue_until(&session, Budget::samples(2), &NullRenderObserver)
        .expect("the scene has not changed");
    assert_eq!(rendering.image(), before);
}

#[test]
fn rendering_continues_until_its_scene_changes() {
    let mut here = session(movable(), Backend::ALL[0]);
    let whole = picture(&here, 6);
    let mut rendering = here
        .render(&RenderOptions::samples(2), &NullRenderObserver)
        .expect("valid options");
    rendering
        .add_samples(&here, 4, &NullRenderObserver)
        .expect("valid");
    assert_eq!((rendering.spp(), rendering.image()), (6, whole.clone()));
    let elsewhere = session(movable(), Backend::ALL[0]);
    let camera = here.description().camera.clone();
    here.set_camera(camera).expect("valid");
    for changed in [&here, &elsewhere] {
        let refused = rendering.add_samples(changed, 1, &NullRenderObserver);
        let refused = refused.expect_err("the scene has changed");
        assert_eq!(refused.kind(), ErrorKind::Usage);
    }
    assert_eq!(rendering.image(), whole);
}

#[test]
fn layers_are_available_only_if_requested() {
    let session = session(load_text(SMALL), Backend::ALL[0]);
    let mut options = RenderOptions::samples(16);
    let bare = session
        .render(&options, &NullRenderObserver)
        .expect("valid");
    assert!(bare.error_bars().is_some() && bare.layered(&session).is_err());
    options.layers = true;
    let layered = session
        .render(&options, &NullRenderObserver)
        .expect("valid");
    let errors = layered
        .error_bars()
        .expect("sixteen samples")
        .standard_errors;
    let picture = layered.layered(&session).expect("layers were requested");
    let red: Vec<f32> = errors.pixels().iter().map(|p| p.to_array()[0]).collect();
    assert_eq!(picture.layer("se.R"), Some(red.as_slice()));
    assert!(picture.layer("albedo.G").is_some());
}

#[test]
fn image_too_large_for_memory_is_rejected() {
    let mut session = session(movable(), Backend::ALL[0]);
    let film = FilmDescription {
        size: (65536, 65536),
        ..session.description().film.clone()
    };
    session.set_film(film).expect("a valid size");
    let mut options = RenderOptions::samples(1);
    options.layers = true;
    // 4 billion pixels of 192 bytes each.
    let error = session.start(&options).expect_err("800 GB are too much");
    assert_eq!(error.kind(), ErrorKind::Memory, "{error}");
}

#[test]
fn ray_queries_return_correct_hits_and_reject_invalid_rays() {
    let session = session(movable(), Backend::ALL[0]);
    // The ray hits the lamp from above, whose top is at a height of 1.2.
    let down = QueryRay::new(DVec3::new(1.5, 5.0, 0.0), DVec3::new(0.0, -7.0, 0.0));
    let met = session.intersect(&down).expect("valid").expect("the lamp");
    assert!((met.distance - 3.8).abs() < 1e-5, "{met:?}");
    assert!((met.position - DVec3::new(1.5, 1.2, 0.0)).length() < 1e-5);
    assert!((met.geometric_normal - DVec3::Y).length() < 1e-4);
    assert_eq!(session.description().shapes[met.shape].name, "lamp");
    assert!(session.occluded(&down).expect("valid"));
    let short = QueryRay {
        max_distance: 3.7,
        ..down
    };
    assert!(!session.occluded(&short).expect("valid"));
    assert_eq!(session.intersect(&short).expect("valid"), None);
    let beyond = QueryRay {
        min_distance: 3.9,
        ..down
    };
    let met = session
        .intersect(&beyond)
        .expect("valid")
        .expect("a hit from inside the lamp");
    assert!((met.distance - 4.2).abs() < 1e-5, "{met:?}");
    let away = QueryRay::new(down.origin, DVec3::Y);
    assert_eq!(session.intersect(&away).expect("valid"), None);
    for wrong in [
        QueryRay::new(DVec3::NAN, DVec3::Y),
        QueryRay::new(DVec3::ZERO, DVec3::ZERO),
        QueryRay { time: 1.5, ..down },
        QueryRay {
            max_distance: f64::NAN,
            ..down
        },
    ] {
        assert!(session.intersect(&wrong).is_err() && session.occluded(&wrong).is_err());
        assert!(
            session
                .radiance(&RenderOptions::default(), &[wrong], 1)
                .is_err()
        );
    }
}

#[test]
fn radiance_queries_match_closed_forms() {
    let camera = CameraDescription::pinhole(DAffine3::IDENTITY, 1.0);
    let mut scene = SceneDescription::new("ball", camera);
    let reflectance = Rgb::new(0.7, 0.5, 0.2).into();
    let matte = MaterialModel::Diffuse { reflectance };
    let matte = MaterialDescription::new("matte", Place::default(), matte);
    scene.add_material(matte).expect("valid");
    let ball = shape("ball", sphere(DVec3::ZERO, 1.0));
    scene.add_shape(ball).expect("valid");
    let sky = LightDescription::sky(Place::default(), Rgb::grey(2.0));
    scene.add_light(sky).expect("valid");
    let session = session(scene, Backend::ALL[0]);
    let at = |y: f64| QueryRay::new(DVec3::new(0.0, y, 5.0), DVec3::new(0.0, 0.0, -1.0));
    let rays = [at(0.0), at(0.5), at(3.0)];
    let mut options = RenderOptions::default();
    options.layers = true;
    options.roulette = Some(Roulette::None);
    options.max_bounces = Some(BounceLimit::AtMost(1));
    let seen = session.radiance(&options, &rays, 100).expect("valid");
    // Under a constant environment a convex body reflects albedo times its radiance in every sample. The third ray misses
    // the body and sees the environment.
    for (along, expected) in seen
        .iter()
        .zip([[1.4, 1.0, 0.4], [1.4, 1.0, 0.4], [2.0; 3]])
    {
        for (mean, expected) in along.mean.to_array().into_iter().zip(expected) {
            assert!((mean - expected).abs() < 1e-5, "{along:?}");
        }
        assert_eq!(along.rejected, 0);
    }
    // No point of a convex body is occluded by it.
    options.integrator = Some(IntegratorKind::AmbientOcclusion);
    let share = session.radiance(&options, &rays[..1], 16).expect("valid");
    assert_eq!(share[0].mean, Rgb::WHITE);
    assert_eq!(share[0].standard_error, Some(Rgb::BLACK));
    options.integrator = Some(IntegratorKind::Bidirectional);
    let refused = session.radiance(&options, &rays[..1], 16);
    assert_eq!(
        refused.expect_err("it needs a camera").kind(),
        ErrorKind::Usage
    );
}

#[test]
fn radiance_queries_ignore_options_for_images() {
    let session = session(movable(), Backend::ALL[0]);
    let ray = QueryRay::new(DVec3::new(0.0, 5.0, 0.0), DVec3::new(0.1, -1.0, 0.0));
    let seen = |change: &dyn Fn(&mut RenderOptions)| {
        let mut options = RenderOptions::default();
        // With standard errors.
        options.layers = true;
        change(&mut options);
        session.radiance(&options, &[ray], 8).expect("valid")
    };
    let plain = seen(&|_| {});
    for others in [
        seen(&|it| it.adaptive = Some(Adaptive::Greedy)),
        seen(&|it| it.reuse = Some(PathReuseRule::Pixels(PathReuse::Four))),
        seen(&|it| {
            it.light_paths = Some(LightPathRule::Share(LightPathShare::One));
            it.adaptive = Some(Adaptive::TwoPhase);
        }),
    ] {
        assert_eq!(others, plain);
    }
}

/// A black leaf, which half of the light passes, at a distance of 0.5, and a lamp behind it at 10.
fn leaf_before_lamp() -> SceneDescription {
    let camera = CameraDescription::pinhole(DAffine3::IDENTITY, 1.0);
    let mut scene = SceneDescription::new("leaf", camera);
    let black = |name: &str| {
        let reflectance = Rgb::BLACK.into();
        let model = MaterialModel::Diffuse { reflectance };
        MaterialDescription::new(name, Place::default(), model)
    };
    let leaf = MaterialDescription {
        alpha: Rgb::grey(0.5).into(),
        ..black("leaf")
    };
    scene.add_material(leaf).expect("valid");
    scene.add_material(black("lamp")).expect("valid");
    let square = |z: f64| GeometryDescription::Rectangle {
        corner: DVec3::new(-1.0, -1.0, z),
        edge_u: 2.0 * DVec3::X,
        edge_v: 2.0 * DVec3::Y,
    };
    scene.add_shape(shape("leaf", square(0.5))).expect("valid");
    let lamp = ShapeDescription {
        material: 1,
        emission: Some(Rgb::grey(8.0).into()),
        two_sided_emission: true,
        ..shape("lamp", square(10.0))
    };
    scene.add_shape(lamp).expect("valid");
    scene
}

#[test]
fn radiance_behind_partial_alpha_ends_at_the_greatest_distance() {
    let far = QueryRay::new(DVec3::ZERO, DVec3::Z);
    let near = QueryRay {
        max_distance: 1.0,
        ..far
    };
    for &backend in Backend::ALL {
        let session = session(leaf_before_lamp(), backend);
        for (integrator, expected) in [
            (IntegratorKind::Path, [4.0, 0.0]),
            (IntegratorKind::Naive, [4.0, 0.0]),
            // The leaf hardly occludes the lamp, and nothing the leaf.
            (IntegratorKind::AmbientOcclusion, [1.0, 0.5]),
        ] {
            let mut options = RenderOptions::default();
            options.integrator = Some(integrator);
            let seen = session.radiance(&options, &[far, near], 4096);
            let seen = seen.expect("valid");
            for (along, expected) in seen.iter().zip(expected) {
                let [red, _, _] = along.mean.to_array();
                // Six standard deviations of a coin's mean.
                assert!(
                    (red - expected).abs() <= 0.05 * expected,
                    "{integrator:?}: {red} for {expected}"
                );
            }
        }
    }
}

#[test]
fn concurrent_renders_do_not_affect_each_other() {
    let session = session(load_text(SMALL), Backend::ALL[0]);
    let alone = picture(&session, 8);
    let [a, b] = std::thread::scope(|scope| {
        let renders = [(), ()].map(|()| scope.spawn(|| picture(&session, 8)));
        renders.map(|render| render.join().expect("it renders"))
    });
    assert!(a == alone && b == alone);
}
