//! Light tables: every key is read as docs/scene-format.md says, and every mistake is an error that names it.

use crate::common::scene_folder::{HEAD, SceneFolder, load_text};
use etendue::ErrorKind;
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::{Image, WriteOptions, write};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DMat3, DVec3};
use etendue::internals::scene::description::{ColourDescription, LightModel};
use etendue::internals::scene::load::load;

/// The only light of a scene; its table starts on line 5.
fn light(body: &str) -> LightModel {
    let mut scene = load_text(&format!("{HEAD}[[light]]\n{body}"));
    assert_eq!(scene.lights.len(), 1);
    let light = scene.lights.remove(0);
    assert_eq!(light.place.line, Some(5));
    light.model
}

/// The line and the message of the error of a light table, in a folder with these images.
fn refusal(folder: &SceneFolder, body: &str) -> (Option<usize>, String) {
    let path = folder.path("scene.toml");
    std::fs::write(&path, format!("{HEAD}{body}")).expect("the folder is writable");
    let error = load(&path).expect_err(body);
    assert_eq!(error.kind(), ErrorKind::Scene, "{error}");
    (error.line(), error.to_string())
}

#[test]
fn point_spot_and_distant_lights_are_read() {
    let model = light("type = \"point\"\nposition = [1, 2, 3]\nintensity = [4, 5, 6]");
    let LightModel::Point {
        position,
        intensity,
    } = model
    else {
        panic!()
    };
    assert_eq!(
        (position, intensity),
        (DVec3::new(1.0, 2.0, 3.0), Rgb::new(4.0, 5.0, 6.0))
    );

    let spot = "type = \"spot\"\nposition = [1, 2, 3]\ntarget = [1, 0, 3]\nintensity = 7\n";
    for (angles, degrees) in [
        ("cone = 30", [30.0, 5.0]),
        ("cone = 3", [3.0, 3.0]),
        ("cone = 180\npenumbra = 180", [180.0, 180.0]),
        ("cone = 45\npenumbra = 0", [45.0, 0.0_f64]),
    ] {
        let LightModel::Spot {
            position,
            target,
            intensity,
            cone,
            penumbra,
        } = light(&format!("{spot}{angles}"))
        else {
            panic!()
        };
        assert_eq!(
            (position, target),
            (DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 0.0, 3.0))
        );
        assert_eq!(
            (intensity, [cone, penumbra]),
            (Rgb::grey(7.0), degrees.map(f64::to_radians))
        );
    }

    let model = light("type = \"distant\"\ndirection = [0, -2, 0]\nirradiance = \"#ffffff\"");
    let LightModel::Distant {
        direction,
        irradiance,
    } = model
    else {
        panic!()
    };
    assert_eq!(
        (direction, irradiance),
        (DVec3::new(0.0, -2.0, 0.0), Rgb::WHITE)
    );
}

fn with_pictures() -> SceneFolder {
    let folder = SceneFolder::new::<&str>([]);
    let picture = |name, texel| {
        let mut image = Image::filled(4, 3, Rgb::grey(0.5));
        image.pixels_mut()[4 + 3] = texel;
        write(&folder.path(name), &image, &WriteOptions::default()).expect("writable");
    };
    picture("good.pfm", Rgb::grey(2.0));
    picture("negative.pfm", Rgb::new(1.0, -0.25, 1.0));
    picture("nan.pfm", Rgb::new(1.0, 1.0, f32::NAN));
    picture("infinite.pfm", Rgb::new(f32::INFINITY, 1.0, 1.0));
    picture("huge.pfm", Rgb::grey(1e38));
    folder
}

#[test]
fn environment_map_is_read_with_scale_and_rotation() {
    let folder = with_pictures();
    let body = "[[light]]\ntype = \"environment\"\nradiance = { texture = \"good.pfm\", scale = 3 }\n\
                transform = [{ rotate = { axis = [0, 1, 0], angle = 90 } }]\n\
                [[light]]\ntype = \"environment\"\nradiance = 2";
    std::fs::write(folder.path("a.toml"), format!("{HEAD}{body}")).expect("writable");
    let scene = folder.load("a.toml");
    let [sky, plain] = scene.lights.as_slice() else {
        panic!("{:?}", scene.lights)
    };
    let LightModel::Environment { radiance, to_world } = &sky.model else {
        panic!()
    };
    // The middle of the image, along -z, is turned to -x.
    assert!((*to_world * DVec3::NEG_Z - DVec3::NEG_X).length() < 1e-12);
    let ColourDescription::Texture(texture) = radiance else {
        panic!()
    };
    assert!(matches!(&**texture, Texture::Image { image, scale }
        if *scale == 3.0 && image.get(3, 1) == Rgb::grey(2.0)));
    let LightModel::Environment { radiance, to_world } = &plain.model else {
        panic!()
    };
    assert_eq!(
        (radiance.constant(), *to_world),
        (Some(Rgb::grey(2.0)), DMat3::IDENTITY)
    );
}

#[test]
fn invalid_environment_images_are_rejected_with_pixel_and_line() {
    let folder = with_pictures();
    for (name, scale, said) in [
        ("negative.pfm", 1.0, "values below 0"),
        ("nan.pfm", 1.0, "finite"),
        ("infinite.pfm", 1.0, "finite"),
        ("huge.pfm", 1e3, "too large"),
    ] {
        let radiance = format!("radiance = {{ texture = \"{name}\", scale = {scale} }}");
        let (line, message) = refusal(
            &folder,
            &format!("[[light]]\ntype = \"environment\"\n{radiance}"),
        );
        assert_eq!(line, Some(7), "{message}");
        for part in [name, "pixel (3, 1)", said, "light[0].radiance"] {
            assert!(message.contains(part), "{message}: {part}");
        }
    }
}

const POINT: &str = "type = \"point\"\nposition = [0, 0, 0]\nintensity = 1\n";
const SPOT: &str = "type = \"spot\"\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nintensity = 1\n";
const DISTANT: &str = "type = \"distant\"\nirradiance = 1\n";
const SKY: &str = "type = \"environment\"\n";

/// Asserts that light tables, each with further keys, are rejected at a line for a reason.
#[track_caller]
fn assert_refused(cases: &[(&str, &str, usize, &str)]) {
    let folder = with_pictures();
    for &(table, keys, line, said) in cases {
        let (found, message) = refusal(&folder, &format!("[[light]]\n{table}{keys}"));
        assert!(
            found == Some(line) && message.contains(said),
            "{table}{keys}: {message}"
        );
    }
}

#[test]
fn missing_and_foreign_light_keys_are_rejected_with_line_and_reason() {
    assert_refused(&[
        (
            POINT,
            "cone = 3",
            9,
            "only lights of the type spot have this key",
        ),
        (
            POINT,
            "radiance = 3",
            9,
            "only lights of the type environment",
        ),
        (
            SKY,
            "radiance = 1\nintensity = 2",
            8,
            "only lights of the type point",
        ),
        (
            DISTANT,
            "direction = [0, 1, 0]\ntarget = [0, 0, 0]",
            9,
            "type spot",
        ),
        (POINT, "colour = 1", 9, "unknown key `colour`"),
        (SPOT, "", 5, "`cone` is missing"),
        (DISTANT, "", 5, "`direction` is missing"),
        (SKY, "", 5, "`radiance` is missing"),
    ]);
}

#[test]
fn invalid_light_values_are_rejected_with_line_and_reason() {
    assert_refused(&[
        (SPOT, "cone = 0", 10, "above 0, at most 180"),
        (SPOT, "cone = 181", 10, "above 0, at most 180"),
        (
            SPOT,
            "cone = 20\npenumbra = 21",
            11,
            "from 0 to that of the cone, 20",
        ),
        (
            SPOT,
            "cone = 20\npenumbra = -1",
            11,
            "from 0 to that of the cone, 20",
        ),
        (
            DISTANT,
            "direction = [0, 0, 0]",
            8,
            "a direction that is not zero",
        ),
        (
            "type = \"point\"\nposition = [0, 0, 0]\n",
            "intensity = -1",
            8,
            "at least 0",
        ),
        (
            "type = \"spot\"\nposition = [1, 2, 3]\nintensity = 1\ncone = 9\n",
            "target = [1, 2, 3]",
            10,
            "position and target are the same point",
        ),
    ]);
}

#[test]
fn invalid_environments_are_rejected_with_line_and_reason() {
    assert_refused(&[
        (SKY, "radiance = -1", 7, "at least 0"),
        (
            SKY,
            "radiance = { checker = [0, 1] }",
            7,
            "an environment cannot be a checker",
        ),
        (
            SKY,
            "radiance = 1\ntransform = [{ scale = 2 }]",
            8,
            "rotations only",
        ),
        (
            SKY,
            "radiance = 1\ntransform = [{ scale = [1, 1, -1] }]",
            8,
            "rotations only",
        ),
        (
            SKY,
            "radiance = 1\ntransform = [{ translate = [1, 0, 0] }]",
            8,
            "rotations only",
        ),
    ]);
    let picture = "[[light]]\ntype = \"environment\"\nradiance = { texture = \"good.pfm\" }\n";
    let (line, message) = refusal(&with_pictures(), &format!("{picture}{picture}"));
    assert!(
        line == Some(8) && message.contains("at most one"),
        "{message}"
    );
}
