//! `etendue plan`: every effect with its reason and its cost.

use crate::common::scene::{diffuse, panorama, patch_scene, rectangle, sky, slide, surface};
use crate::common::scene_folder::{SMALL, SceneFolder};
use crate::support::{USAGE, fails, succeed};
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::effects::{Effect, Kernel};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::{Image, WriteOptions, write};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DMat3, DVec3};
use etendue::internals::plan::{Plan, without};
use etendue::internals::render::NullRenderObserver;
use etendue::internals::scene::description::{
    ColourDescription, LightDescription, LightModel, SceneDescription,
};
use etendue::internals::scene::load::load;
use etendue::internals::scene::prepare::prepare;
use etendue_lab::study::effect_cost::{CostSettings, effect_costs};
use serde_json::Value;
use std::sync::Arc;

fn small() -> SceneFolder {
    SceneFolder::new([("small.toml", SMALL)])
}

const OPTIONS: AccelOptions = AccelOptions {
    backend: Backend::ALL[0],
    precision: Precision::Robust,
    quality: None,
    threads: 1,
};

fn plan_of(description: &SceneDescription) -> Plan {
    let prepared = prepare(description, OPTIONS).expect("a valid scene");
    Plan::new(description, &prepared.scene)
}

#[test]
fn plan_table_lists_every_effect_with_reason_and_location() {
    let printed = succeed(&small(), "plan small.toml").stdout;
    for effect in Effect::ALL {
        let row = printed.lines().find(|l| l.starts_with(effect.name()));
        assert!(row.is_some(), "no {} in\n{printed}", effect.name());
    }
    for words in [
        "on   material `floor` has a colour that varies over its surface (small.toml:13)",
        "on   material `glass` transmits light (small.toml:18)",
        "on   shape `lamp` emits (small.toml:",
        "off  lens_radius is 0",
        "left out: a point on the lens for every camera ray",
        "kernel: room (",
    ] {
        assert!(printed.contains(words), "no `{words}` in\n{printed}");
    }
}

#[test]
fn plan_json_lists_scene_kernel_and_every_effect() {
    let printed = succeed(&small(), "plan small.toml --json").stdout;
    let report: Value = serde_json::from_str(&printed).expect("one object");
    assert_eq!(
        (&report["scene"], &report["kernel"]),
        (&"small.toml".into(), &"room".into())
    );
    let effects = report["effects"].as_array().expect("a list");
    assert_eq!(effects.len(), Effect::ALL.len());
    let lens = effects
        .iter()
        .find(|e| e["effect"] == "lens")
        .expect("it is listed");
    assert_eq!((&lens["on"], &lens["where"]), (&false.into(), &Value::Null));
    let glass = effects
        .iter()
        .find(|e| e["effect"] == "transmission")
        .expect("it is listed");
    assert_eq!(
        (&glass["on"], &glass["where"]),
        (&true.into(), &"small.toml:18".into())
    );
    assert!(glass.get("cost").is_none() && report.get("everything").is_none());
}

#[test]
fn costs_are_measured_for_every_enabled_effect() {
    let arguments = "plan small.toml --json --cost --spp 2 --rounds 3 --size 24x16";
    let printed = succeed(&small(), arguments).stdout;
    let report: Value = serde_json::from_str(&printed).expect("one object");
    for effect in report["effects"].as_array().expect("a list") {
        let cost = &effect["cost"];
        if effect["on"] == true {
            let time = &cost["time"];
            let [min, median, max] = ["min", "median", "max"].map(|n| time[n].as_f64());
            assert!(
                min <= median && median <= max && max < Some(1.0),
                "{effect}"
            );
            assert!(
                cost["energy"].is_number() && cost["energy_error"].is_number(),
                "{effect}"
            );
        } else {
            assert!(cost.is_null(), "{effect}");
        }
    }
    assert!(report["everything"]["median"].as_f64() > Some(0.0));
    let table = succeed(
        &small(),
        "plan small.toml --cost --spp 1 --rounds 2 --size 12x8",
    )
    .stdout;
    assert!(
        table.contains("of the time") && table.contains("of the light"),
        "{table}"
    );
    assert!(
        table.contains("the kernel with everything takes"),
        "{table}"
    );
}

#[test]
fn invalid_plan_arguments_are_rejected() {
    fails(&small(), "plan small.toml --spp 4", USAGE, &["--cost"]);
    fails(
        &small(),
        "plan small.toml --cost --rounds 1",
        USAGE,
        &["--rounds"],
    );
    fails(&small(), "plan none.toml", 4, &["none.toml"]);
}

#[test]
fn explicit_kernel_renders_a_bit_identical_image() {
    let folder = small();
    succeed(&folder, "render small.toml -q -o a.pfm");
    succeed(&folder, "render small.toml -q -o b.pfm --kernel everything");
    let read = |name| std::fs::read(folder.path(name)).expect("it was written");
    assert!(read("a.pfm") == read("b.pfm"));
    fails(
        &folder,
        "render small.toml -q -o c.pfm --kernel matte",
        USAGE,
        &["matte", "lacks", "textures"],
    );
    let said = succeed(&folder, "render small.toml -v -o a.pfm --progress none").stderr;
    assert!(
        said.contains("plan: kernel caustics; effects textures, glossy"),
        "{said}"
    );
}

#[test]
fn removing_an_effect_disables_it_in_the_plan() {
    let folder = SceneFolder::new([("all.toml", ALL_EFFECTS)]);
    let Texture::Image { image, .. } = panorama() else {
        panic!("the panorama is an image")
    };
    write(
        &folder.path("picture.pfm"),
        &image.to_image(),
        &WriteOptions::default(),
    )
    .expect("it is writable");
    let description = load(&folder.path("all.toml")).unwrap_or_else(|error| panic!("{error}"));
    let plan = plan_of(&description);
    assert_eq!(plan.kernel, Kernel::Everything);
    for effect in Effect::ALL {
        assert!(plan.on().any(|on| on == effect), "{} is off", effect.name());
        let other = plan_of(&without(&description, effect));
        assert!(
            !other.on().any(|on| on == effect),
            "{} stays",
            effect.name()
        );
    }
}

/// A scene that needs every effect.
const ALL_EFFECTS: &str = r#"version = 1
[camera]
eye = [0, 0, 5]
target = [0, 0, 0]
lens_radius = 0.1
shutter = [0, 1]
[[material]]
name = "floor"
type = "diffuse"
reflectance = { checker = [0.7, 0.2], repeat = [4, 4] }
two_sided = false
alpha = 0.9
normal_map = "picture.pfm"
[[material]]
name = "glass"
type = "dielectric"
[[material]]
name = "phong"
type = "phong"
[[shape]]
type = "rectangle"
material = "floor"
corner = [-4, 0, 4]
edge_u = [8, 0, 0]
edge_v = [0, 0, -8]
[[shape]]
type = "sphere"
material = "glass"
center = [0, 1, 0]
radius = 1
group = "ball"
[[shape]]
type = "mesh"
material = "phong"
positions = [[0, 0, 0], [1, 0, 0], [0, 2, 0]]
normals = [[0, 0, 1], [1, 0, 1], [0, 0, 1]]
indices = [[0, 1, 2]]
emission = 1
[[instance]]
of = "ball"
motion = [{ time = 0, transform = [] }, { time = 1, transform = [{ translate = [0, 1, 0] }] }]
[[light]]
type = "point"
position = [0, 5, 0]
intensity = 1
[[light]]
type = "environment"
radiance = { texture = "picture.pfm" }
[render]
light_paths = "1"
reuse = "4"
"#;

#[test]
fn effect_energy_share_matches_closed_form() {
    // An emitting floor under a sky of radiance 1: the contribution of each is known.
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    scene.shapes = vec![surface(
        rectangle([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]),
        3.0,
    )];
    scene.lights = vec![sky(Rgb::WHITE)];
    let settings = CostSettings {
        accel: OPTIONS,
        // Four samples in each batch, so that roulette has its strata.
        spp: 16,
        rounds: 4,
    };
    let plan = plan_of(&scene);
    let costs = effect_costs(&scene, &plan, &settings, &NullRenderObserver, |_| {});
    let costs = costs.expect("valid settings").expect("not cancelled");
    let energy = |effect| {
        let cost = costs.effects.iter().find(|cost| cost.effect == effect);
        cost.expect("it is on").energy
    };
    // The floor emits 3 and reflects 0.5 of the sky.
    assert!((energy(Effect::AreaLights) - 3.0 / 3.5).abs() < 1e-6);
    assert!((energy(Effect::Environment) - 0.5 / 3.5).abs() < 1e-6);
}

#[test]
fn disabled_textures_are_replaced_by_their_mean() {
    let folder = small();
    let description = folder.load("small.toml");
    let flat = without(&description, Effect::Textures);
    let etendue::internals::scene::description::MaterialModel::Diffuse { reflectance } =
        &flat.materials[0].model
    else {
        panic!("the floor is diffuse")
    };
    assert!(matches!(reflectance, ColourDescription::Constant(c) if *c == Rgb::grey(0.45)));
}

#[test]
fn unplaced_instances_do_not_enable_effects() {
    let folder = SceneFolder::new([("lost.toml", LOST_INSTANCE)]);
    let plan = plan_of(&folder.load("lost.toml"));
    for (effect, on, why) in [
        (Effect::Motion, false, "nothing has keyframes"),
        (
            Effect::Instances,
            true,
            "instance `instance 2` places a group",
        ),
    ] {
        let finding = &plan.findings[effect as usize];
        assert_eq!((finding.on, finding.why.as_str()), (on, why));
    }
}

/// A moving instance in a group that no instance places, and a second instance that is placed.
const LOST_INSTANCE: &str = r#"version = 1
[camera]
eye = [0, 0, 5]
target = [0, 0, 0]
shutter = [0, 1]
[[shape]]
type = "sphere"
center = [0, 1, 0]
radius = 1
group = "ball"
[[instance]]
of = "ball"
group = "nowhere"
motion = [{ time = 0, transform = [] }, { time = 1, transform = [{ translate = [0, 1, 0] }] }]
[[instance]]
of = "ball"
"#;

#[test]
fn environment_map_is_replaced_by_its_mean_over_the_sphere() {
    // White except the rows at the poles: those between 45 degrees and a pole are 1 - cos(45 degrees) of the sphere.
    let rows = 64;
    let texels = (0..2 * rows * rows).map(|i| {
        let row = i / (2 * rows);
        Rgb::grey(if row < rows / 4 || row >= rows / 4 * 3 {
            0.0
        } else {
            1.0
        })
    });
    let image = Image::new(2 * rows, rows, texels.collect());
    let texture = Texture::Image {
        image: Arc::new(image.into()),
        scale: 2.0,
    };
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    scene.lights = vec![LightDescription {
        model: LightModel::Environment {
            radiance: ColourDescription::Texture(Arc::new(texture)),
            to_world: DMat3::IDENTITY,
        },
        ..sky(Rgb::WHITE)
    }];
    let mean = without(&scene, Effect::EnvironmentMap).constant_environment();
    let exact = 2.0 * std::f32::consts::FRAC_1_SQRT_2;
    assert!((mean.luminance() - exact).abs() < 1e-3, "{mean:?}");
}

#[test]
fn disabling_instances_also_covers_moving_shapes() {
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    let lamp = rectangle([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    scene.camera.shutter = [0.0, 1.0];
    scene.shapes = vec![surface(lamp.clone(), 3.0), surface(lamp, 3.0)];
    scene.shapes[1].motion = slide(DVec3::ZERO, DVec3::X);
    assert!(plan_of(&scene).on().any(|on| on == Effect::Instances));
    let other = plan_of(&without(&scene, Effect::Instances));
    assert!(!other.on().any(|on| on == Effect::Instances));
}

#[test]
fn remaining_light_without_many_lights_is_a_placed_one() {
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.5));
    let lamp = rectangle([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
    scene.groups = vec!["nowhere".to_owned()];
    scene.shapes = (0..3).map(|_| surface(lamp.clone(), 3.0)).collect();
    scene.shapes[0].group = Some(0);
    let lights = |scene: &SceneDescription| {
        let prepared = prepare(scene, OPTIONS).expect("a valid scene");
        prepared.scene.lights.len()
    };
    assert_eq!(lights(&scene), 2);
    assert_eq!(lights(&without(&scene, Effect::ManyLights)), 1);
}

#[test]
fn shard_plan_estimates_spp_for_a_target_error() {
    let matte = "type = \"diffuse\"\nreflectance = 0.5";
    let scene = SMALL
        .replace("type = \"dielectric\"", matte)
        .replace("emission = [12, 11, 10]", "");
    let folder = SceneFolder::new([("small.toml", scene)]);
    let shards = |flags: &str| -> Value {
        let plan = format!("plan small.toml --json --shards --shard-time 0.02s {flags}");
        let json: Value = serde_json::from_str(&succeed(&folder, &plan).stdout).expect("JSON");
        json["shards"].clone()
    };
    let [coarse, fine] = ["--error 2%", "--error 0.2%"].map(shards);
    let number = |plan: &Value, name: &str| plan[name].as_u64().expect("no doubt");
    // An error ten times smaller takes 100 times the samples, or fewer with Sobol' points.
    assert!(
        number(&fine, "spp") > 5 * number(&coarse, "spp"),
        "{coarse} {fine}"
    );
    let length = number(&fine, "spp").div_ceil(number(&fine, "shards"));
    assert_eq!(number(&fine, "spp_of_shard"), length);
    // The pilot is for a render with the same flags: direct light alone needs fewer samples.
    let direct = shards("--error 0.2% --max-bounces 1 --sampler independent");
    assert_ne!(number(&direct, "spp"), number(&fine, "spp"));
    let text = succeed(&folder, "plan small.toml --shards --error 1%").stdout;
    assert!(text.contains("shards to 1.00 %: about"), "{text}");
    fails(&folder, "plan small.toml --shards", USAGE, &["--error"]);
    let both = "plan small.toml --integrator nee --light-paths 1";
    fails(&folder, both, USAGE, &["light paths"]);
}
