//! Tests that the command reports invalid motion, groups, instances and emission in scenes with the place in the file
//! and what was expected there.

use crate::common::scene_folder::{HEAD, SceneFolder};
use crate::support::{INPUT_OUTPUT, SCENE, fails, scene_fails};

#[test]
fn invalid_motion_is_rejected_with_file_and_line() {
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
fn invalid_camera_motion_is_rejected_with_file_and_line() {
    let key = "{ time = 0, transform = [] }";
    scene_fails(
        &format!("motion = [{key}]"),
        1,
        &[
            "camera.motion: ",
            "expected either motion, or",
            "`eye` is given too",
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
            &["camera.motion: ", &format!("`{name}` is given too")],
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
        &["camera.motion[0].transform: ", "`eye` is given too"],
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

/// A shape, to which a group can be added.
const MEMBER: &str = "[[shape]]\ntype = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n";

/// A shape of the group `tree`.
fn tree() -> String {
    format!("{MEMBER}group = \"tree\"\n")
}

/// An instance of a group, as a member of another or, with an empty name, of none.
fn instance(of: &str, group: &str) -> String {
    let group = if group.is_empty() {
        String::new()
    } else {
        format!("group = \"{group}\"\n")
    };
    format!("[[instance]]\nof = \"{of}\"\n{group}")
}

#[test]
fn unknown_groups_are_rejected_with_file_and_line() {
    scene_fails(
        &(tree() + &instance("tee", "")),
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
    // An instance that refers to a group does not define it.
    let twice = instance("b", "a") + &instance("a", "");
    scene_fails(&twice, 2, &["unknown group `b`", "Expected one of: a"]);
}

#[test]
fn cyclic_groups_are_rejected_with_file_and_line() {
    let circle = "groups are placed within one another in a cycle: ";
    scene_fails(
        &(tree() + &instance("tree", "tree")),
        7,
        &["instance[0].of: ", &format!("{circle}tree -> tree")],
    );
    let two = instance("a", "b") + &instance("b", "a");
    scene_fails(
        &two,
        5,
        &["instance[1].of: ", &format!("{circle}b -> a -> b")],
    );
    // The cycle is reached from the world through an instance that is not part of it.
    let three = tree()
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
}

#[test]
fn invalid_instance_tables_are_rejected_with_file_and_line() {
    scene_fails("[[instance]]\n", 1, &["instance[0]: ", "`of` is missing"]);
    scene_fails(
        "[[instance]]\nof = 1",
        2,
        &["instance[0].of: ", "a string in quotes"],
    );
    let tree = tree() + &instance("tree", "");
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
        &format!("{MEMBER}group = 7"),
        5,
        &["shape[0].group: ", "a string in quotes"],
    );
    scene_fails(
        "[instance]",
        1,
        &["instance: ", "expected a list, found a table"],
    );
}

#[test]
fn long_group_cycles_are_reported_without_stack_overflow() {
    // Recursion along this chain would overflow the stack.
    let mut chain = String::new();
    for i in 0..100_000 {
        chain += &format!("[[instance]]\nof = \"{}\"\ngroup = \"{i}\"\n", i + 1);
    }
    chain += "[[instance]]\nof = \"0\"\ngroup = \"100000\"\n";
    scene_fails(
        &chain,
        3 * 99_999 + 2 + 3,
        &["in a cycle: 0 -> 1 -> 2", "-> 100000 -> 0"],
    );
}

#[test]
fn invalid_emission_is_rejected_with_file_and_line() {
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
    // One texel of (1, -1, 1), and one of (1e30, 1e30, 1e30).
    let pfm = |texel: [f32; 3]| {
        let numbers = texel.into_iter().flat_map(f32::to_le_bytes);
        [b"PF\n1 1\n-1\n".to_vec(), numbers.collect()].concat()
    };
    for (texel, words) in [
        ([1.0, -1.0, 1.0], "values below 0"),
        ([1e30; 3], "too large for single precision"),
    ] {
        let scene = format!("{HEAD}{lamp}{{ texture = \"t.pfm\", scale = 1e10 }}");
        let folder = SceneFolder::new([("a.toml", scene.into_bytes()), ("t.pfm", pfm(texel))]);
        let place = "a.toml:9: shape[0].emission";
        fails(&folder, "render a.toml", SCENE, &[place, words]);
    }
}

#[test]
fn exponential_and_deeply_nested_groups_are_rejected() {
    let ball = |group: &str| {
        format!(
            "[[shape]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\ngroup = \"{group}\"\n"
        )
    };
    let place =
        |of: usize, group: usize| format!("[[instance]]\nof = \"{of}\"\ngroup = \"{group}\"\n");
    let root = |of: usize| format!("[[instance]]\nof = \"{of}\"\n");
    // Each group holds the next one twice: 2^40 balls.
    let mut doubling = ball("0");
    for level in 1..=40 {
        doubling += &place(level - 1, level).repeat(2);
    }
    doubling += &root(40);
    let folder = SceneFolder::new([("a.toml", format!("{HEAD}{doubling}"))]);
    fails(
        &folder,
        "render a.toml",
        SCENE,
        &["placed more than 4194304 times"],
    );
    // Each group holds the next one once: a chain of 20 000.
    let mut chain = ball("0");
    for level in 1..=20_000 {
        chain += &place(level - 1, level);
    }
    chain += &root(20_000);
    // Each group has already been visited from the world before the chain reaches it.
    let mut known = ball("0");
    for level in 1..=2000 {
        known += &place(level - 1, level);
        known += &root(level);
    }
    for chain in [chain, known] {
        let folder = SceneFolder::new([("a.toml", format!("{HEAD}{chain}"))]);
        fails(&folder, "render a.toml", SCENE, &["nested deeper than 64"]);
    }
}
