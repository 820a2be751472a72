//! Invalid scenes and models on the command line: the exit code, the place, the expected value; and no file is written.

use crate::common::scene_folder::{HEAD, SceneFolder, TRIANGLE};
use crate::support::{INPUT_OUTPUT, SCENE, USAGE, fails, scene_fails};

/// Renders a model of these files, and expects an error at `place`.
#[track_caller]
fn model_fails(files: &[(&'static str, &str)], place: &str, code: i32, words: &[&str]) {
    let folder = SceneFolder::new(files.iter().copied());
    fails(&folder, "render a.obj", code, &[&[place], words].concat());
}

#[test]
fn missing_or_unsupported_scene_files_are_rejected() {
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
        &["a.png", "ends in one of: .toml, .obj, .ply"],
    );
}

#[test]
fn unknown_keys_are_rejected_with_a_suggestion() {
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
        "[render]\nroulette = \"throughputt\"",
        2,
        &["render.roulette", "`throughput`"],
    );
    scene_fails(
        "[render]\nocclusion_distance = 0",
        2,
        &["render.occlusion_distance", "above 0"],
    );
    scene_fails(
        "[render]\nsampler = \"sobl\"",
        2,
        &["render.sampler", "`sobol`"],
    );
    scene_fails(
        "[[light]]\ntype = \"spit\"",
        2,
        &["unknown name `spit`", "did you mean `spot`?"],
    );
}

#[test]
fn wrong_value_types_are_rejected_with_file_and_line() {
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
        &["shape[0].type", "a string in quotes, found true"],
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
fn non_finite_and_out_of_range_numbers_are_rejected() {
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
    // Finite in the file, infinite in the single precision that shading uses.
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
fn shapes_beyond_the_coordinate_limit_are_rejected_by_name() {
    let ball = |center: &str, radius: &str, more: &str| {
        format!("[[shape]]\ntype = \"sphere\"\ncenter = {center}\nradius = {radius}\n{more}")
    };
    let near = ball("[0, 0, 0]", "1", "").repeat(2);
    for far in [
        ball("[1e308, -1e308, 0]", "1e308", ""),
        ball("[0, 1e15, 0]", "1", ""),
        ball("[0, 0, 0]", "1e20", ""),
        // Too large only after its transform.
        ball("[0, 0, 0]", "1e308", "transform = [{ scale = 10 }]\n"),
    ] {
        scene_fails(&format!("{near}{far}"), 9, &["`sphere 3` reaches farther"]);
    }
    let member = ball("[0, 0, 0]", "1", "group = \"a\"\n");
    let placed = "[[instance]]\nof = \"a\"\ntransform = [{ translate = [0, 0, 1e25] }]\n";
    let instance = format!("{near}{member}{placed}");
    scene_fails(&instance, 14, &["`instance 1` reaches farther"]);
}

#[test]
fn degenerate_geometry_is_rejected_with_file_and_line() {
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
fn inconsistent_materials_are_rejected_with_file_and_line() {
    let fails = |kind: &str, line: usize, words: &[&str]| {
        let table = format!("[[material]]\nname = \"a\"\ntype = {kind}");
        scene_fails(&table, line, words);
    };
    let together = ["material[0].", "`diffuse` and `specular`", "at most 1"];
    for sum in [
        "diffuse = 0.9",
        "specular = 0.6",
        "diffuse = { checker = [0, [0.1, 0.9, 0]] }",
    ] {
        fails(&format!("\"phong\"\n{sum}"), 4, &together);
    }
    fails(
        "\"phong\"\ndiffuse = [0, 0.75, 0]\nspecular = [0, 0.5, 0]",
        5,
        &["material[0].specular", "[0, 0.75, 0] and [0, 0.5, 0]"],
    );
    for exponent in ["-1", "1.1e6", "nan"] {
        fails(
            &format!("\"phong\"\nexponent = {exponent}"),
            4,
            &["material[0].exponent", "from 0 to 1e6"],
        );
    }
    let below = ["material[0].ior", "at least 1, found 0.9"];
    fails("\"plastic\"\nior = 0.9", 4, &below);
    fails("\"plastik\"", 3, &["did you mean `plastic`?"]);
    fails("\"phong\"\nexponant = 3", 4, &["did you mean `exponent`?"]);
    fails(
        "\"phong\"\nroughness = 0.5",
        4,
        &["unknown key `roughness`"],
    );

    let sides = ["material[0].two_sided", "has two sides"];
    fails("\"dielectric\"\ntwo_sided = false", 4, &sides);
    let glass = "\"principled\"\ntransmission = 0.1\ntwo_sided = false";
    fails(glass, 5, &sides);
    fails(
        "\"mirror\"\ntwo_sided = 1",
        4,
        &["material[0].two_sided", "true or false, found 1"],
    );

    for alpha in ["1.5", "-0.1", "{ checker = [0, 2] }"] {
        fails(
            &format!("\"mirror\"\nalpha = {alpha}"),
            4,
            &["material[0].alpha", "expected a value from 0 to 1"],
        );
    }
    let map = |text: &str, words: &[&str]| {
        fails(&format!("\"mirror\"\nnormal_map = {text}"), 4, words);
    };
    map("3", &["material[0].normal_map", "a file in quotes"]);
    map("{ strength = 1 }", &["expected a colour"]);
    map(
        "{ texture = \"t.png\", strength = inf }",
        &["material[0].normal_map.strength", "a finite number"],
    );
    map(
        "{ checker = [0.7, 0.2], repeat = [4, 4], weight = 1 }",
        &["unknown key `weight`"],
    );
    let bumps = |text: &str, words: &[&str]| {
        fails(&format!("\"mirror\"\n{text}"), 4, words);
    };
    let bump_map = "bump_map = { checker = [0, 1], height = 1 }";
    bumps(
        "bump_map = \"t.png\"",
        &["material[0].bump_map", "a texture and its `height`"],
    );
    bumps("bump_map = { checker = [0, 1] }", &["`height`"]);
    bumps(
        &format!("{bump_map}\nnormal_map = {{ checker = [0, 1] }}"),
        &["material[0].bump_map", "either normal_map or bump_map"],
    );
}

#[test]
fn invalid_obj_and_mtl_files_are_rejected() {
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
    for (text, line, word) in [
        ("Kd 1 1 1\n", 1, "newmtl first"),
        ("newmtl a\nKd 1 1\n", 2, "three numbers"),
        ("newmtl a\nKd -2 1 1\n", 2, "at least 0"),
        ("newmtl a\nPr nan\n", 2, "at least 0"),
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
fn model_errors_name_both_scene_and_model_location() {
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
fn invalid_and_missing_textures_are_rejected() {
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
    let files = [
        ("a.obj", model.as_str()),
        ("a.mtl", library),
        ("t.png", "hello"),
    ];
    model_fails(&files, "a.mtl:2: ", SCENE, &["t.png: "]);
}

#[test]
fn non_utf8_and_empty_scene_files_are_rejected() {
    let folder = SceneFolder::new([
        ("a.toml", &b"version = 1\n# \xff\xfe\n"[..]),
        ("empty.toml", b""),
    ]);
    fails(
        &folder,
        "render a.toml",
        SCENE,
        &["a.toml:2: ", "expected UTF-8"],
    );
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

#[test]
fn texture_coordinates_beyond_f32_are_rejected() {
    let mesh = "[[shape]]\ntype = \"mesh\"\nindices = [[0, 1, 2]]\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]";
    let words = ["shape[0].uvs[1]", "two numbers within single precision"];
    scene_fails(
        &format!("{mesh}\nuvs = [[0, 0], [1e39, 0], [0, 1]]"),
        5,
        &words,
    );
}
