//! Bad scenes and models, through the command: the exit code, the place, what was expected; and nothing is written.
#![cfg(feature = "cli")]

mod common;

use common::command::{INPUT_OUTPUT, SCENE, USAGE, fails};
use common::scene_folder::{HEAD, SceneFolder, TRIANGLE};

/// Renders a scene that ends in `tail`, and expects an error about its `line`, counted from the tail's first.
#[track_caller]
fn scene_fails(tail: &str, line: usize, words: &[&str]) {
    let folder = SceneFolder::new([("a.toml", format!("{HEAD}{tail}"))]);
    let place = format!("a.toml:{}: ", HEAD.lines().count() + line);
    let words = [&[place.as_str()], words].concat();
    fails(&folder, "render a.toml", SCENE, &words);
}

/// Renders a model of these files, and expects an error at `place`.
#[track_caller]
fn model_fails(files: &[(&'static str, &str)], place: &str, code: i32, words: &[&str]) {
    let folder = SceneFolder::new(files.iter().copied());
    fails(&folder, "render a.obj", code, &[&[place], words].concat());
}

#[test]
fn a_scene_that_is_not_there() {
    let folder = SceneFolder::new([("a.png", "")]);
    for missing in ["b.toml", "b.obj"] {
        let arguments = format!("render {missing}");
        fails(
            &folder,
            &arguments,
            INPUT_OUTPUT,
            &[missing, "cannot read", "No such file"],
        );
    }
    fails(
        &folder,
        "render a.png",
        USAGE,
        &["a.png", "ends in .toml", "ends in .obj"],
    );
}

#[test]
fn unknown_keys_are_answered_with_the_nearest() {
    scene_fails(
        "fob = 3",
        1,
        &["camera: ", "unknown key `fob`", "did you mean `fov`?"],
    );
    scene_fails("[filn]", 1, &["unknown key `filn`", "did you mean `film`?"]);
    scene_fails(
        "[[shape]]\ntype = \"spere\"",
        2,
        &["shape[0].type", "did you mean `sphere`?"],
    );
    let sphere = "[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nraduis = 1\nradius = 2";
    scene_fails(
        sphere,
        4,
        &["unknown key `raduis`", "did you mean `radius`?"],
    );
    let material =
        "[[material]]\nname = \"glass\"\ntype = \"dielectric\"\n[[shape]]\ntype = \"box\"\n";
    let shape = "material = \"glas\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]";
    scene_fails(&format!("{material}{shape}"), 6, &["did you mean `glass`?"]);
    scene_fails(
        "[render]\nintegrator = \"pth\"",
        2,
        &["render.integrator", "`path`"],
    );
    scene_fails(
        "[render]\nsampler = \"sobl\"",
        2,
        &["render.sampler", "`sobol`"],
    );
    scene_fails(
        "[[light]]\ntype = \"point\"",
        2,
        &["`point` is not supported by this version"],
    );
}

#[test]
fn values_of_the_wrong_type() {
    scene_fails(
        "fov = \"wide\"",
        1,
        &["camera.fov", "expected an angle", "found \"wide\""],
    );
    scene_fails(
        "up = [0, 1]",
        1,
        &["camera.up", "expected a list of 3 numbers"],
    );
    scene_fails("[film]\nsize = 5", 2, &["film.size", "expected a list"]);
    scene_fails(
        "[film]\nfilter = 1",
        2,
        &["film.filter", "expected a table"],
    );
    scene_fails(
        "[render]\nspp = 1.5",
        2,
        &["render.spp", "a whole number of at least 1"],
    );
    scene_fails(
        "[[shape]]\ntype = true",
        2,
        &["shape[0].type", "a text in quotes, found true"],
    );
    scene_fails(
        "[material]",
        1,
        &["material", "expected a list, found a table"],
    );
    let colour = "[[material]]\nname = \"a\"\ntype = \"diffuse\"\nreflectance = ";
    for wrong in [
        "\"red\"",
        "true",
        "[1]",
        "{}",
        "1.5",
        "-0.1",
        "\"#12345\"",
        "\"#+f+f+f\"",
    ] {
        scene_fails(
            &format!("{colour}{wrong}"),
            4,
            &["material[0].reflectance", "expected a "],
        );
    }
    scene_fails("fov = = 3", 1, &[]);
}

#[test]
fn numbers_that_are_not_finite_or_out_of_range() {
    for wrong in ["nan", "inf", "-inf", "1e999"] {
        scene_fails(
            &format!("up = [0, {wrong}, 0]"),
            1,
            &["camera.up", "a finite number"],
        );
        scene_fails(
            &format!("fov = {wrong}"),
            1,
            &["camera.fov", "expected an angle"],
        );
        let model = format!("v 0 {wrong} 0\n{TRIANGLE}");
        model_fails(
            &[("a.obj", &model)],
            "a.obj:1: ",
            SCENE,
            &["a finite number", wrong],
        );
    }
    // Finite as it is written, infinite in the single precision that shading is done in.
    let glass = "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nior = 1e300";
    scene_fails(glass, 4, &["material[0].ior", "expected a number"]);
    let lamp = "[[shape]]\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nemission = 1e300";
    scene_fails(lamp, 5, &["shape[0].emission"]);
    scene_fails(
        "[film]\nsize = [0, 4]",
        2,
        &["film.size", "from 1 to 65536, found 0"],
    );
    scene_fails(
        "[film]\nsize = [4, 65537]",
        2,
        &["film.size", "from 1 to 65536"],
    );
    scene_fails(
        "[render]\nspp = -1",
        2,
        &["render.spp", "at least 1, found -1"],
    );
    scene_fails(
        "lens_radius = -1",
        1,
        &["camera.lens_radius", "at least 0, found -1"],
    );
}

#[test]
fn geometry_that_collapses() {
    let boxed = "[[shape]]\nname = \"lid\"\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n";
    let flat = format!("{boxed}transform = [{{ scale = [1, 0, 1] }}]");
    scene_fails(&flat, 6, &["shape[0].transform", "lid is singular"]);
    let stretched = "transform = [{ scale = [1, 2, 1] }]";
    scene_fails(
        stretched,
        1,
        &["expected either transform, or eye and target"],
    );
    let sphere = "[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    scene_fails(&format!("{sphere}{stretched}"), 1, &["sphere 1"]);
    scene_fails(
        &sphere.replace("= 1", "= 0"),
        4,
        &["shape[0].radius", "a number above 0, found 0"],
    );
    scene_fails(
        "up = [0, 0, 3]",
        0,
        &["camera.target", "up is along the line"],
    );
    let mesh = "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n";
    let out = format!("{mesh}indices = [[0, 1, 3]]");
    scene_fails(&out, 4, &["shape[0].indices[0][2]", "from 0 to 2, found 3"]);
}

#[test]
fn motion_that_is_none() {
    let moved = |keys: &str| {
        format!(
            "[[shape]]\nname = \"ball\"\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmotion = [\n{keys}]"
        )
    };
    let fails = |keys: &str, line: usize, words: &[&str]| scene_fails(&moved(keys), line, words);
    fails("", 6, &["shape[0].motion: ", "expected at least one key"]);
    let key = |time: &str| format!("{{ time = {time}, transform = [] }},\n");
    for (first, second) in [("1", "0.5"), ("1", "1"), ("-2", "-3")] {
        let order = format!("keys out of order in time: {second} follows {first}");
        let keys = key("-7") + &key(first) + &key(second);
        fails(&keys, 9, &["shape[0].motion[2].time: ", &order]);
    }
    fails(
        &key("nan"),
        7,
        &["shape[0].motion[0].time: ", "a finite number"],
    );
    fails(&key("1e999"), 7, &["a finite number"]);
    fails(
        "{ transform = [] }",
        7,
        &["shape[0].motion[0]: ", "`time` is missing"],
    );
    fails(
        "{ time = 0 }",
        7,
        &["shape[0].motion[0]: ", "`transform` is missing"],
    );
    fails(
        "{ time = 0, transform = [], scale = 2 }",
        7,
        &["unknown key `scale`"],
    );
    let flat = key("0") + "{ time = 1, transform = [{ scale = [1, 1, 0] }] }";
    fails(
        &flat,
        8,
        &["shape[0].motion[1].transform: ", "ball is singular"],
    );
    let number = moved("").replace("[\n]", "3");
    scene_fails(&number, 6, &["shape[0].motion: ", "expected a list"]);
}

#[test]
fn cameras_that_move_wrongly() {
    let key = "{ time = 0, transform = [] }";
    scene_fails(
        &format!("motion = [{key}]"),
        1,
        &[
            "camera.motion: ",
            "expected either motion, or",
            "`eye` is there too",
        ],
    );
    let fails_alone = |body: &str, line: usize, words: &[&str]| {
        let folder = SceneFolder::new([("a.toml", format!("version = 1\n[camera]\n{body}"))]);
        let place = format!("a.toml:{line}: ");
        fails(
            &folder,
            "render a.toml",
            SCENE,
            &[&[place.as_str()], words].concat(),
        );
    };
    for other in ["transform = []", "up = [0, 1, 0]", "target = [0, 0, 1]"] {
        let name = other.split(' ').next().expect("split yields one part");
        fails_alone(
            &format!("{other}\nmotion = [{key}]"),
            4,
            &["camera.motion: ", &format!("`{name}` is there too")],
        );
    }
    fails_alone("motion = []", 3, &["camera.motion: ", "at least one key"]);
    let stretched = format!("motion = [{key},\n{{ time = 1, transform = [{{ scale = 2 }}] }}]");
    fails_alone(
        &stretched,
        4,
        &["camera.motion[1].transform: ", "cannot be stretched"],
    );
    let blind = "motion = [{ time = 1, eye = [0, 0, 1], target = [0, 0, 1] }]";
    fails_alone(blind, 3, &["camera.motion[0].target: ", "the same point"]);
    let both = "motion = [{ time = 1, transform = [], eye = [0, 0, 1] }]";
    fails_alone(
        both,
        3,
        &["camera.motion[0].transform: ", "`eye` is there too"],
    );
    fails_alone(
        "motion = [{ time = 1 }]",
        3,
        &["camera.motion[0]: ", "`eye` is missing"],
    );
    fails_alone(
        &format!("motion = [{key},\n{}]", key.replace('0', "-0.5")),
        4,
        &["camera.motion[1].time: ", "-0.5 follows 0"],
    );
    scene_fails(
        "shutter = [1, 0]",
        1,
        &["camera.shutter: ", "0 is before 1"],
    );
    scene_fails(
        "shutter = 1",
        1,
        &["camera.shutter: ", "expected a list of 2 numbers"],
    );
    scene_fails(
        "shutter = [0, inf]",
        1,
        &["camera.shutter", "a finite number"],
    );
}

#[test]
fn groups_that_are_none_and_groups_in_circles() {
    let member = "[[shape]]\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n";
    let instance = |of: &str, group: &str| {
        let group = if group.is_empty() {
            String::new()
        } else {
            format!("group = \"{group}\"\n")
        };
        format!("[[instance]]\nof = \"{of}\"\n{group}")
    };
    let tree = format!("{member}group = \"tree\"\n");
    let unknown = tree.clone() + &instance("tee", "");
    scene_fails(
        &unknown,
        7,
        &[
            "instance[0].of: ",
            "unknown group `tee`; did you mean `tree`?",
        ],
    );
    scene_fails(
        &instance("tree", ""),
        2,
        &["unknown group `tree`; there are none"],
    );
    // That something is placed as a group does not make it one.
    let twice = instance("b", "a") + &instance("a", "");
    scene_fails(&twice, 2, &["unknown group `b`", "Expected one of: a"]);

    let circle = "groups are placed within one another in a circle: ";
    let own = tree.clone() + &instance("tree", "tree");
    scene_fails(
        &own,
        7,
        &["instance[0].of: ", &format!("{circle}tree -> tree")],
    );
    let two = instance("a", "b") + &instance("b", "a");
    scene_fails(
        &two,
        2,
        &["instance[0].of: ", &format!("{circle}b -> a -> b")],
    );
    // From the world through a way in that is no part of the circle.
    let three = tree
        + &instance("a", "tree")
        + &instance("b", "a")
        + &instance("c", "b")
        + &instance("a", "c")
        + &instance("tree", "");
    scene_fails(
        &three,
        16,
        &["instance[3].of: ", &format!("{circle}a -> b -> c -> a")],
    );

    scene_fails("[[instance]]\n", 1, &["instance[0]: ", "`of` is missing"]);
    scene_fails(
        "[[instance]]\nof = 1",
        2,
        &["instance[0].of: ", "a text in quotes"],
    );
    let tree = format!("{member}group = \"tree\"\n") + &instance("tree", "");
    scene_fails(
        &format!("{tree}transfrom = []"),
        8,
        &["instance[0]: ", "did you mean `transform`?"],
    );
    scene_fails(
        &format!("{tree}transform = [{{ scale = 0 }}]"),
        8,
        &["instance[0].transform: ", "instance 1 is singular"],
    );
    scene_fails(
        &format!("{tree}motion = [{{ time = 0, transform = [{{ scale = 0 }}] }}]"),
        8,
        &[
            "instance[0].motion[0].transform: ",
            "instance 1 is singular",
        ],
    );
    scene_fails(
        &format!("{member}group = 7"),
        5,
        &["shape[0].group: ", "a text in quotes"],
    );
    scene_fails(
        "[instance]",
        1,
        &["instance: ", "expected a list, found a table"],
    );
}

#[test]
fn a_chain_of_groups_may_be_as_long_as_its_file() {
    // Followed by recursion, it would exceed the stack.
    let mut chain = String::new();
    for i in 0..100_000 {
        chain += &format!("[[instance]]\nof = \"{}\"\ngroup = \"{i}\"\n", i + 1);
    }
    chain += "[[instance]]\nof = \"0\"\ngroup = \"100000\"\n";
    scene_fails(
        &chain,
        3 * 99_999 + 2 + 3,
        &["in a circle: 0 -> 1 -> 2", "-> 100000 -> 0"],
    );
}

#[test]
fn emission_that_is_no_colour() {
    let lamp = "[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nemission = ";
    for (colour, words) in [
        ("-1", "of at least 0"),
        ("{ checker = [1, -1] }", "of at least 0"),
        ("{ checker = [1] }", "a list of two colours"),
        ("{ texture = \"none.png\" }", "none.png"),
        ("{}", "expected a colour"),
        ("true", "expected a colour"),
    ] {
        let code = if colour.contains("none") {
            INPUT_OUTPUT
        } else {
            SCENE
        };
        let folder = SceneFolder::new([("a.toml", format!("{HEAD}{lamp}{colour}"))]);
        let place = "a.toml:9: shape[0].emission";
        fails(&folder, "render a.toml", code, &[place, words]);
    }
}

#[test]
fn models_that_are_wrong() {
    model_fails(&[("a.obj", "")], "a.obj: ", SCENE, &["no faces"]);
    model_fails(&[("a.obj", "v 0 0 0\n")], "a.obj: ", SCENE, &["no faces"]);
    let far = format!("{TRIANGLE}f 1 2 4\n");
    model_fails(
        &[("a.obj", &far)],
        "a.obj:5: ",
        SCENE,
        &["vertex 4 is out of range"],
    );
    let long = format!("# {}\nf 1\n", "x".repeat(1 << 20));
    model_fails(&[("a.obj", &long)], "a.obj:2: ", SCENE, &["out of range"]);
    let missing = format!("mtllib none.mtl\n{TRIANGLE}");
    model_fails(
        &[("a.obj", &missing)],
        "a.obj:1: ",
        INPUT_OUTPUT,
        &["none.mtl", "cannot read"],
    );
    let wrong = format!("mtllib a.mtl\nusemtl glas\n{TRIANGLE}");
    let glass = "newmtl glass\nKd 1 1 1\n";
    let files = [("a.obj", wrong.as_str()), ("a.mtl", glass)];
    model_fails(
        &files,
        "a.obj:2: ",
        SCENE,
        &["unknown material `glas`; did you mean `glass`?"],
    );
    for (text, line, word) in [
        ("Kd 1 1 1\n", 1, "newmtl first"),
        ("newmtl a\nKd 1 1\n", 2, "three numbers"),
        ("newmtl a\nKd 2 1 1\n", 2, "from 0 to 1"),
        ("newmtl a\nPr nan\n", 2, "from 0 to 1"),
        ("newmtl a\nNi 1e300\n", 2, "expected a number"),
        ("newmtl\n", 1, "expected a name"),
    ] {
        let model = format!("mtllib a.mtl\n{TRIANGLE}");
        let place = format!("a.mtl:{line}: ");
        model_fails(
            &[("a.obj", &model), ("a.mtl", text)],
            &place,
            SCENE,
            &[word],
        );
    }
}

#[test]
fn a_model_in_a_scene_names_both_places() {
    let scene = format!("{HEAD}[[shape]]\ntype = \"obj\"\nfile = \"a.obj\"\n");
    let folder = SceneFolder::new([("a.toml", scene.as_str()), ("a.obj", "v 0 0 0\nf 1 2 3\n")]);
    fails(
        &folder,
        "render a.toml",
        SCENE,
        &["a.toml:7: ", "a.obj:2: ", "vertex 2"],
    );
    let folder = SceneFolder::new([("a.toml", scene)]);
    fails(
        &folder,
        "render a.toml",
        INPUT_OUTPUT,
        &["a.toml:7: ", "a.obj: cannot read"],
    );
}

#[test]
fn textures_that_are_none() {
    let material =
        "[[material]]\nname = \"a\"\ntype = \"diffuse\"\nreflectance = { texture = \"t.png\" }\n";
    let scene = format!("{HEAD}{material}");
    let folder = SceneFolder::new([("a.toml", scene.as_str()), ("t.png", "hello")]);
    fails(&folder, "render a.toml", SCENE, &["a.toml:8: ", "t.png: "]);
    let folder = SceneFolder::new([("a.toml", scene)]);
    fails(
        &folder,
        "render a.toml",
        INPUT_OUTPUT,
        &["a.toml:8: ", "t.png: cannot read"],
    );
    let model = format!("mtllib a.mtl\nusemtl a\n{TRIANGLE}");
    let library = "newmtl a\nmap_Kd t.png\n";
    let files = [("a.obj", model.as_str()), ("a.mtl", library)];
    model_fails(&files, "a.mtl:2: ", INPUT_OUTPUT, &["t.png: cannot read"]);
    let files = [&files[..], &[("t.png", "hello")]].concat();
    model_fails(&files, "a.mtl:2: ", SCENE, &["t.png: "]);
}

#[test]
fn files_that_are_no_text() {
    let folder = SceneFolder::new([
        ("a.toml", &b"version = 1\n# \xff\xfe\n"[..]),
        ("a.obj", b"v 0 0 0\n\xc3\x28"),
        ("empty.toml", b""),
    ]);
    for scene in ["a.toml", "a.obj"] {
        let place = format!("{scene}:2: ");
        fails(
            &folder,
            &format!("render {scene}"),
            SCENE,
            &[&place, "expected UTF-8"],
        );
    }
    fails(
        &folder,
        "render empty.toml",
        SCENE,
        &["empty.toml:1: ", "`version` is missing"],
    );
    scene_fails(
        &format!("# {}\nfob = 1", "x".repeat(1 << 20)),
        2,
        &["`fov`"],
    );
    scene_fails(&format!("{} = 1", "x".repeat(1 << 20)), 1, &["unknown key"]);
}
