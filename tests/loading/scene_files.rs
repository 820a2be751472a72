//! Scene files: every key is read as docs/scene-format.md specifies.

use crate::common::scene_folder::{HEAD, SceneFolder, TRIANGLE, in_repository, load_text};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DVec2, DVec3};
use etendue::internals::scene::description::{
    CameraDescription, ColourDescription, FilterDescription, FilterKind, GeometryDescription,
    MaterialModel, MeshDescription, RenderDescription, ShapeDescription,
};

/// The only material of a scene.
fn material(body: &str) -> MaterialModel {
    let text = format!("{HEAD}[[material]]\nname = \"it\"\n{body}");
    let mut scene = load_text(&text);
    assert_eq!(scene.materials.len(), 1);
    let material = scene.materials.remove(0);
    assert_eq!(
        (material.name.as_str(), material.place.line),
        ("it", Some(5))
    );
    material.model
}

/// The only shape of a scene, of the default material.
fn shape(body: &str) -> ShapeDescription {
    let mut scene = load_text(&format!("{HEAD}[[shape]]\n{body}"));
    assert_eq!((scene.shapes.len(), scene.materials.len()), (1, 1));
    scene.shapes.remove(0)
}

fn constant(colour: &ColourDescription) -> Rgb {
    match colour {
        ColourDescription::Constant(rgb) => *rgb,
        ColourDescription::Texture(_) => panic!("a texture instead of a constant"),
    }
}

#[track_caller]
fn assert_near(got: DVec3, want: [f64; 3]) {
    let want = DVec3::from_array(want);
    assert!((got - want).length() < 1e-12, "{got} instead of {want}");
}

#[test]
fn missing_keys_take_their_default_values() {
    let scene = load_text(HEAD);
    let CameraDescription {
        to_world,
        fov,
        lens_radius,
        focus_distance,
        ref motion,
        shutter,
        ..
    } = scene.camera;
    assert!(motion.is_empty() && shutter == [0.0; 2]);
    assert_near(to_world.translation, [0.0, 0.0, 5.0]);
    assert_near(to_world.transform_vector3(DVec3::Y), [0.0, 1.0, 0.0]);
    assert_eq!(
        (fov, lens_radius, focus_distance),
        (40_f64.to_radians(), 0.0, 5.0)
    );
    assert_eq!(scene.film.size, (768, 512));
    let gaussian = FilterDescription {
        kind: FilterKind::Gaussian,
        radius: 1.5,
    };
    assert_eq!(scene.film.filter, gaussian);
    assert_eq!(scene.render, RenderDescription::default());
    assert_eq!(scene.constant_environment(), Rgb::BLACK);
    assert!(scene.materials.is_empty() && scene.shapes.is_empty() && scene.notes.is_empty());

    let MaterialModel::Diffuse { reflectance } = material("type = \"diffuse\"") else {
        panic!()
    };
    assert_eq!(constant(&reflectance), Rgb::grey(0.5));
    let MaterialModel::Mirror { reflectance } = material("type = \"mirror\"") else {
        panic!()
    };
    assert_eq!(constant(&reflectance), Rgb::WHITE);
    let model = material("type = \"dielectric\"");
    let MaterialModel::Dielectric {
        ior,
        roughness,
        tint,
    } = model
    else {
        panic!()
    };
    assert_eq!((ior, roughness, constant(&tint)), (1.5, 0.0, Rgb::WHITE));
    let model = material("type = \"principled\"");
    let MaterialModel::Principled {
        base_color,
        metallic,
        roughness,
        ior,
        transmission,
    } = model
    else {
        panic!()
    };
    assert_eq!(constant(&base_color), Rgb::grey(0.8));
    assert_eq!(
        (metallic, roughness, ior, transmission),
        (0.0, 0.5, 1.5, 0.0)
    );

    let sphere = shape("type = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1");
    assert!(sphere.name == "sphere 1" && sphere.emission.is_none());
    assert!(!sphere.two_sided_emission);
    assert_eq!(
        sphere.transform,
        etendue::internals::math::vec::DAffine3::IDENTITY
    );
}

#[test]
fn camera_and_film_settings_are_read() {
    let scene = load_text(
        "version = 1\n[camera]\neye = [1, 2, 3]\ntarget = [1, 2, -1]\nup = [1, 0, 0]\nfov = 60\n\
         lens_radius = 0.25\nfocus_distance = 7\nshutter = [0.5, 0.5]\n\
         [film]\nsize = [12, 34]\nfilter = { type = \"mitchell\", radius = 3 }",
    );
    let camera = &scene.camera;
    assert_near(camera.to_world.translation, [1.0, 2.0, 3.0]);
    assert_near(
        camera.to_world.transform_vector3(DVec3::NEG_Z),
        [0.0, 0.0, -1.0],
    );
    assert_near(camera.to_world.transform_vector3(DVec3::Y), [1.0, 0.0, 0.0]);
    assert_eq!(camera.fov, 60_f64.to_radians());
    assert_eq!((camera.lens_radius, camera.focus_distance), (0.25, 7.0));
    assert_eq!(scene.film.size, (12, 34));
    let mitchell = FilterDescription {
        kind: FilterKind::Mitchell,
        radius: 3.0,
    };
    assert_eq!(scene.film.filter, mitchell);

    let turn = "[{ rotate = { axis = [0, 2, 0], angle = 90 } }, { translate = [1, 2, 3] }]";
    let placed = load_text(&format!("version = 1\n[camera]\ntransform = {turn}")).camera;
    assert_near(
        placed.to_world.transform_vector3(DVec3::NEG_Z),
        [-1.0, 0.0, 0.0],
    );
    assert_near(placed.to_world.translation, [1.0, 2.0, 3.0]);
    assert_eq!(placed.focus_distance, 1.0);

    for (name, kind) in FilterKind::ALL {
        let filter = load_text(&format!("{HEAD}[film]\nfilter = \"{name}\""))
            .film
            .filter;
        assert_eq!(
            filter,
            FilterDescription {
                kind: *kind,
                radius: kind.default_radius()
            }
        );
    }
}

#[test]
fn camera_motion_keyframes_are_read() {
    let camera = |keys: &str| {
        let text = format!("version = 1\n[camera]\nshutter = [-1, 2.5]\nmotion = [{keys}]");
        load_text(&text).camera
    };
    let first = "{ time = 0.5, eye = [0, 0, 7], target = [0, 0, 0] }";
    let moving = camera(&format!(
        "{first}, {{ time = 2, transform = [{{ translate = [1, 2, 3] }}] }}"
    ));
    assert_eq!(moving.shutter, [-1.0, 2.5]);
    assert_eq!(
        moving.motion.iter().map(|key| key.time).collect::<Vec<_>>(),
        [0.5, 2.0]
    );
    assert_near(moving.motion[0].transform.translation, [0.0, 0.0, 7.0]);
    assert_near(moving.motion[1].transform.translation, [1.0, 2.0, 3.0]);
    // `to_world` is the transform of the first key, and the lens is focused on that key's target.
    assert_eq!(moving.to_world, moving.motion[0].transform);
    assert_eq!(moving.focus_distance, 7.0);
    let placed = "{ time = 0, transform = [] }";
    assert_eq!(camera(placed).focus_distance, 1.0);
}

#[test]
fn shape_motion_keyframes_are_read() {
    let sphere = "type = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    assert!(shape(sphere).motion.is_empty());
    let keys = "motion = [{ time = -1, transform = [] }, { time = 1e9, transform = [{ scale = 2 }, { translate = [1, 2, 3] }] }]";
    let moved = shape(&format!(
        "{sphere}transform = [{{ translate = [4, 5, 6] }}]\n{keys}"
    ));
    assert_near(moved.transform.translation, [4.0, 5.0, 6.0]);
    let [from, to] = moved.motion.as_slice() else {
        panic!("{:?}", moved.motion)
    };
    assert_eq!((from.time, to.time), (-1.0, 1e9));
    assert_near(from.transform.transform_point3(DVec3::ONE), [1.0; 3]);
    assert_near(to.transform.transform_point3(DVec3::ONE), [3.0, 4.0, 5.0]);
}

#[test]
fn groups_can_contain_shapes_and_instances() {
    let folder = SceneFolder::new([
        (
            "a.toml",
            format!(
                "{HEAD}\
[[shape]]
type = \"box\"
min = [0, 0, 0]
max = [1, 1, 1]
[[shape]]
type = \"obj\"
file = \"two.obj\"
group = \"leaf\"
transform = [{{ scale = 2 }}]
motion = [{{ time = 0, transform = [{{ translate = [1, 0, 0] }}] }}]
[[instance]]
name = \"oak\"
of = \"tree\"
transform = [{{ translate = [1, 2, 3] }}]
[[instance]]
of = \"leaf\"
group = \"tree\"
motion = [{{ time = 0, transform = [] }}, {{ time = 1, transform = [{{ translate = [0, 1, 0] }}] }}]
"
            ),
        ),
        (
            "two.obj",
            format!("o first\n{TRIANGLE}o second\n{TRIANGLE}"),
        ),
    ]);
    let scene = folder.load("a.toml");
    assert_eq!(scene.groups, ["leaf", "tree"]);
    let groups: Vec<_> = scene.shapes.iter().map(|shape| shape.group).collect();
    assert_eq!(groups, [None, Some(0), Some(0)]);
    for part in &scene.shapes[1..] {
        assert_eq!(part.motion.len(), 1);
        assert_near(part.motion[0].transform.translation, [1.0, 0.0, 0.0]);
        assert_near(part.transform.transform_point3(DVec3::ONE), [2.0; 3]);
    }
    let [oak, leaf] = scene.instances.as_slice() else {
        panic!("{:?}", scene.instances)
    };
    assert_eq!((oak.name.as_str(), oak.of, oak.group), ("oak", 1, None));
    assert_near(oak.transform.translation, [1.0, 2.0, 3.0]);
    assert_eq!(oak.place.line, Some(15));
    assert!(oak.motion.is_empty());
    assert_eq!(
        (leaf.name.as_str(), leaf.of, leaf.group),
        ("instance 2", 0, Some(1))
    );
    assert_eq!(leaf.motion.len(), 2);
    assert!(!scene.notes.iter().any(|note| note.text.contains("group")));
}

#[test]
fn group_without_instance_is_noted() {
    let member = "[[shape]]\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ngroup = ";
    let scene = load_text(&format!(
        "{HEAD}{member}\"a\"\n{member}\"b\"\n{member}\"a\"\n[[instance]]\nof = \"b\""
    ));
    assert_eq!(scene.groups, ["a", "b"]);
    assert_eq!(
        Vec::from_iter(scene.notes.iter().map(ToString::to_string)),
        ["group `a` is placed by no instance: it is not rendered"]
    );
}

#[test]
fn emission_is_read_as_constant_checker_or_image_texture() {
    let lamp = "type = \"rectangle\"\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\nemission = ";
    let emission = |colour: &str| {
        shape(&format!("{lamp}{colour}"))
            .emission
            .expect("it emits")
    };
    assert_eq!(constant(&emission("[1, 20, 3]")), Rgb::new(1.0, 20.0, 3.0));
    let ColourDescription::Texture(checker) = emission("{ checker = [0, 50], repeat = [2, 4] }")
    else {
        panic!("a constant instead of a checker")
    };
    let Texture::Checker { colours, repeat } = *checker else {
        panic!("{checker:?}")
    };
    assert_eq!(colours, [Rgb::BLACK, Rgb::grey(50.0)]);
    assert_eq!(repeat.to_array(), [2.0, 4.0]);

    let glow = "[[shape]]\ntype = \"obj\"\nfile = \"a.obj\"\nemission = { texture = \"t.png\", scale = 300 }";
    let folder = SceneFolder::new([
        ("a.toml", format!("{HEAD}{glow}")),
        ("a.obj", TRIANGLE.to_owned()),
    ]);
    let picture = in_repository("scenes/suzanne-room/planks.png");
    std::fs::copy(picture, folder.path("t.png")).expect("the folder is writable");
    let scene = folder.load("a.toml");
    let Some(ColourDescription::Texture(texture)) = &scene.shapes[0].emission else {
        panic!("no texture")
    };
    assert!(matches!(**texture, Texture::Image { scale: 300.0, .. }));
}

#[test]
fn render_table_values_are_read_unchanged() {
    let render = load_text(&format!(
        "{HEAD}[render]\nintegrator = \"path\"\nspp = 17\nsampler = \"independent\"\nmax_bounces = 0\n\
         seed = 18446744073709551615"
    ))
    .render;
    let names = [render.integrator, render.sampler].map(|name| name.expect("it is written"));
    assert_eq!((names[0].value.as_str(), names[0].line), ("path", 6));
    assert_eq!((names[1].value.as_str(), names[1].line), ("independent", 8));
    assert_eq!(
        (render.spp, render.max_bounces, render.seed),
        (Some(17), Some(0), Some(u64::MAX))
    );
}

#[test]
fn conductor_dielectric_and_principled_materials_are_read() {
    let model = material("type = \"conductor\"\npreset = \"gold\"\nroughness = 0.25\ntint = 0.5");
    let MaterialModel::Conductor {
        eta,
        k,
        roughness,
        tint,
    } = model
    else {
        panic!()
    };
    assert!(eta.to_array()[0] < eta.to_array()[2] && k.to_array()[0] > k.to_array()[2]);
    assert_eq!((roughness, tint), (0.25, Rgb::grey(0.5)));
    let model = material("type = \"conductor\"\neta = [1, 2, 3]\nk = 4");
    let MaterialModel::Conductor {
        eta, k, roughness, ..
    } = model
    else {
        panic!()
    };
    assert_eq!(
        (eta, k, roughness),
        (Rgb::new(1.0, 2.0, 3.0), Rgb::grey(4.0), 0.0)
    );
    let model = material("type = \"dielectric\"\nior = 1.33\nroughness = 0.5\ntint = 0.25");
    let MaterialModel::Dielectric {
        ior,
        roughness,
        tint,
    } = model
    else {
        panic!()
    };
    assert_eq!(
        (ior, roughness, constant(&tint)),
        (1.33, 0.5, Rgb::grey(0.25))
    );
    let model = material(
        "type = \"principled\"\nbase_color = [0, 0.5, 1]\nmetallic = 0.25\nroughness = 1\nior = 2\n\
         transmission = 0.75",
    );
    let MaterialModel::Principled {
        base_color,
        metallic,
        roughness,
        ior,
        transmission,
    } = model
    else {
        panic!()
    };
    assert_eq!(constant(&base_color), Rgb::new(0.0, 0.5, 1.0));
    assert_eq!(
        (metallic, roughness, ior, transmission),
        (0.25, 1.0, 2.0, 0.75)
    );
}

#[test]
fn phong_and_plastic_are_read() {
    let phong = |keys: &str| match material(&format!("type = \"phong\"\n{keys}")) {
        MaterialModel::Phong {
            diffuse,
            specular,
            exponent,
        } => (constant(&diffuse), constant(&specular), exponent),
        other => panic!("{other:?}"),
    };
    assert_eq!(phong(""), (Rgb::grey(0.5), Rgb::grey(0.2), 32.0));
    // The sum of the two is at most 1 in each channel, not over all channels.
    assert_eq!(
        phong("diffuse = [1, 0.7, 0]\nspecular = [0, 0.3, 1]\nexponent = 1e6"),
        (Rgb::new(1.0, 0.7, 0.0), Rgb::new(0.0, 0.3, 1.0), 1e6)
    );
    let plastic = |keys: &str| match material(&format!("type = \"plastic\"\n{keys}")) {
        MaterialModel::Plastic {
            reflectance,
            ior,
            roughness,
        } => (constant(&reflectance), ior, roughness),
        other => panic!("{other:?}"),
    };
    assert_eq!(plastic(""), (Rgb::grey(0.5), 1.5, 0.0));
    assert_eq!(
        plastic("reflectance = 1\nior = 1\nroughness = 0.25"),
        (Rgb::WHITE, 1.0, 0.25)
    );
}

#[test]
fn clear_coats_are_read_over_opaque_metal_and_principled_surfaces() {
    let read = |keys: &str| {
        let text = format!("{HEAD}[[material]]\nname = \"it\"\n{keys}");
        let folder = SceneFolder::new([("a.toml", text)]);
        etendue::load::load(&folder.path("a.toml"))
            .map(|mut scene| scene.materials.remove(0).clear_coat)
    };
    let gold = "type = \"conductor\"\npreset = \"gold\"\n";
    assert_eq!(read(gold).expect("valid"), None);
    let coat = |keys: &str| {
        let coat = read(&format!("{gold}clear_coat = {keys}")).expect("valid");
        coat.map(|coat| (coat.weight, coat.roughness, coat.ior))
    };
    assert_eq!(coat("{}"), Some((1.0, 0.0, 1.5)));
    let all = "{ weight = 0.5, roughness = 0.25, ior = 1.25 }";
    assert_eq!(coat(all), Some((0.5, 0.25, 1.25)));
    for (keys, words) in [
        ("type = \"mirror\"\nclear_coat = {}", "only conductors"),
        (
            "type = \"principled\"\ntransmission = 1\nclear_coat = {}",
            "without transmission",
        ),
        (
            "type = \"principled\"\nclear_coat = { ior = 0.5 }",
            "a number of at least 1",
        ),
        ("type = \"principled\"\nclear_coat = 1", "`roughness`"),
    ] {
        let error = read(keys).expect_err(keys).to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
}

#[test]
fn alpha_detail_map_and_two_sided_keys_are_read() {
    let read = |keys: &str| {
        let table = "[[material]]\nname = \"it\"\ntype = \"mirror\"\n";
        let text = format!("{HEAD}{table}{keys}");
        let folder = SceneFolder::new([("a.toml", text)]);
        let grey = image::RgbImage::from_pixel(2, 1, image::Rgb([51; 3]));
        grey.save(folder.path("t.png")).expect("it is writable");
        folder.load("a.toml").materials.remove(0)
    };
    let plain = read("");
    assert_eq!(plain.alpha.constant(), Some(Rgb::WHITE));
    assert!(plain.normal_map.is_none() && plain.two_sided);

    // 51 is a fifth of 255: values are linear unless `space` says otherwise.
    let alpha = |text: &str| read(&format!("alpha = {text}")).alpha.constant();
    assert_eq!(alpha("0.25"), Some(Rgb::grey(0.25)));
    assert_eq!(alpha("{ texture = \"t.png\" }"), Some(Rgb::grey(0.2)));
    let coded = alpha("{ texture = \"t.png\", space = \"srgb\" }");
    assert!(coded.is_some_and(|colour| colour.max_channel() < 0.05));
    assert_eq!(alpha("{ checker = [1, 0] }"), None);

    for (text, strength) in [
        ("\"t.png\"", 1.0),
        ("{ texture = \"t.png\", strength = 0.5 }", 0.5),
    ] {
        let map = read(&format!("normal_map = {text}")).normal_map;
        let map = map.expect("it is written");
        let found = (map.texture.constant(), map.strength);
        assert_eq!(found, (Some(Rgb::grey(0.2)), strength));
    }
    let map = read("bump_map = { texture = \"t.png\", height = -0.02 }").bump_map;
    let found = map.map(|map| (map.texture.constant(), map.height));
    assert_eq!(found, Some((Some(Rgb::grey(0.2)), -0.02)));
    assert!(!read("two_sided = false").two_sided && read("two_sided = true").two_sided);
}

#[test]
fn analytic_shapes_and_inline_meshes_are_read() {
    let sphere = shape(
        "name = \"ball\"\ntype = \"sphere\"\ncenter = [1, 2, 3]\nradius = 4\nemission = [1, 2, 3]\ntwo_sided_emission = true",
    );
    let GeometryDescription::Sphere { center, radius } = sphere.geometry else {
        panic!()
    };
    assert_eq!((center, radius), (DVec3::new(1.0, 2.0, 3.0), 4.0));
    assert_eq!((sphere.name.as_str(), sphere.place.line), ("ball", Some(5)));
    let emission = sphere.emission.as_ref().and_then(|e| e.constant());
    assert_eq!(emission, Some(Rgb::new(1.0, 2.0, 3.0)));
    assert!(sphere.two_sided_emission);

    let it =
        shape("type = \"rectangle\"\ncorner = [1, 2, 3]\nedge_u = [1, 0, 0]\nedge_v = [0, 2, 0]");
    let GeometryDescription::Rectangle {
        corner,
        edge_u,
        edge_v,
    } = it.geometry
    else {
        panic!()
    };
    assert_eq!(
        (corner, edge_u, edge_v),
        (DVec3::new(1.0, 2.0, 3.0), DVec3::X, 2.0 * DVec3::Y)
    );

    let it = shape("type = \"disk\"\ncenter = [1, 2, 3]\nnormal = [0, 0, 2]\nradius = 0.5");
    let GeometryDescription::Disk {
        center,
        normal,
        radius,
    } = it.geometry
    else {
        panic!()
    };
    assert_eq!(
        (center, normal, radius),
        (DVec3::new(1.0, 2.0, 3.0), 2.0 * DVec3::Z, 0.5)
    );

    let it = shape("type = \"box\"\nmin = [0, 1, 2]\nmax = [3, 4, 5]");
    let GeometryDescription::Box { min, max } = it.geometry else {
        panic!()
    };
    assert_eq!(
        (min, max),
        (DVec3::new(0.0, 1.0, 2.0), DVec3::new(3.0, 4.0, 5.0))
    );

    let it = shape(
        "type = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nnormals = [[0, 0, 1], [0, 0, 1], [0, 0, 2]]\n\
         uvs = [[0, 0], [1, 0], [0, 1]]\nindices = [[2, 0, 1]]",
    );
    let GeometryDescription::Mesh(mesh) = it.geometry else {
        panic!()
    };
    let wanted = MeshDescription {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: vec![DVec3::Z, DVec3::Z, 2.0 * DVec3::Z],
        uvs: vec![DVec2::ZERO, DVec2::X, DVec2::Y],
        indices: vec![[2, 0, 1]],
    };
    assert_eq!(*mesh, wanted);
}

#[test]
fn transform_steps_are_applied_in_listed_order() {
    let moved = |steps: &str, point: [f64; 3]| {
        let body = "type = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\ntransform = ";
        let transform = shape(&format!("{body}[{steps}]")).transform;
        transform.transform_point3(DVec3::from_array(point))
    };
    let (scale, translate) = ("{ scale = 2 }", "{ translate = [1, 2, 3] }");
    let turn = "{ rotate = { axis = [0, 0, 5], angle = 90 } }";
    let matrix = "{ matrix = [1, 2, 3, 4,  0, 1, 0, 5,  0, 0, 1, 6,  0, 0, 0, 1] }";
    for (steps, wanted) in [
        (String::new(), [1.0, 2.0, 3.0]),
        (format!("{scale}, {translate}"), [3.0, 6.0, 9.0]),
        (format!("{translate}, {scale}"), [4.0, 8.0, 12.0]),
        ("{ scale = [1, 2, -1] }".to_owned(), [1.0, 4.0, -3.0]),
        (turn.to_owned(), [-2.0, 1.0, 3.0]),
        (format!("{turn}, {translate}"), [-1.0, 3.0, 6.0]),
        (matrix.to_owned(), [18.0, 7.0, 9.0]),
        (format!("{scale}, {matrix}, {turn}"), [-9.0, 32.0, 12.0]),
    ] {
        assert_near(moved(&steps, [1.0, 2.0, 3.0]), wanted);
    }
}

#[test]
fn constant_environment_lights_are_summed() {
    let light = "[[light]]\ntype = \"environment\"\nradiance = ";
    let scene = load_text(&format!("{HEAD}{light}[0, 1, 2]\n{light}0.5\n"));
    assert_eq!(scene.constant_environment(), Rgb::new(0.5, 1.5, 2.5));
}

#[test]
fn motion_without_an_open_shutter_is_noted() {
    let ball = "[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmotion = [\
        { time = 0, transform = [] }, { time = 1, transform = [{ translate = [1, 0, 0] }] }]\n";
    let notes = |head: &str| load_text(&format!("{head}{ball}")).notes;
    assert!(notes(HEAD)[0].text.contains("the shutter is never open"));
    assert!(notes(&format!("{HEAD}shutter = [0, 1]\n")).is_empty());
}
