//! Colours in scene files: every notation, and images in their colour space.

use crate::common::scene_folder::{HEAD, SceneFolder, load_text};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::srgb;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec2;
use etendue::internals::scene::description::{ColourDescription, MaterialModel};

/// Reads a colour as the reflectance of a mirror.
fn read(text: &str) -> ColourDescription {
    let material = "[[material]]\nname = \"it\"\ntype = \"mirror\"\nreflectance = ";
    let scene = load_text(&format!("{HEAD}{material}{text}"));
    match &scene.materials[0].model {
        MaterialModel::Mirror { reflectance } => reflectance.clone(),
        other => panic!("{other:?}"),
    }
}

fn constant(colour: &ColourDescription) -> Rgb {
    match colour {
        ColourDescription::Constant(rgb) => *rgb,
        ColourDescription::Texture(_) => panic!("a texture instead of a constant"),
    }
}

fn texture(colour: &ColourDescription) -> &Texture {
    match colour {
        ColourDescription::Texture(texture) => texture,
        ColourDescription::Constant(rgb) => panic!("the constant {rgb:?} instead of a texture"),
    }
}

#[test]
fn colour_arrays_scalars_hex_codes_and_checkers_are_read() {
    assert_eq!(constant(&read("[0.25, 0.5, 1]")), Rgb::new(0.25, 0.5, 1.0));
    assert_eq!(constant(&read("0.25")), Rgb::grey(0.25));
    let code = |code: u8| srgb::to_linear(f64::from(code) / 255.0) as f32;
    let hexadecimal = constant(&read("\"#00fF80\""));
    assert_eq!(hexadecimal, Rgb::new(0.0, 1.0, code(0x80)));

    let checker = read("{ checker = [\"#000000\", 0.5], repeat = [2, 4] }");
    let Texture::Checker { colours, repeat } = texture(&checker) else {
        panic!()
    };
    assert_eq!(
        (*colours, *repeat),
        ([Rgb::BLACK, Rgb::grey(0.5)], Vec2::new(2.0, 4.0))
    );
    let plain = read("{ checker = [0, 1] }");
    let Texture::Checker { repeat, .. } = texture(&plain) else {
        panic!()
    };
    assert_eq!(*repeat, Vec2::ONE);
}

#[test]
fn image_textures_are_read_with_colour_space_and_scale() {
    let material = |name: &str, rest: &str| {
        let table = "[[material]]\ntype = \"diffuse\"\n";
        format!("{table}name = \"{name}\"\nreflectance = {{ texture = \"t.png\"{rest} }}\n")
    };
    let text = [
        HEAD.to_owned(),
        material("a", ""),
        material("b", ", scale = 0.5, space = \"srgb\""),
        material("c", ", space = \"linear\""),
    ]
    .concat();
    let folder = SceneFolder::new([("a.toml", text)]);
    let grey = image::RgbImage::from_pixel(2, 1, image::Rgb([128; 3]));
    grey.save(folder.path("t.png"))
        .expect("the folder is writable");
    let scene = folder.load("a.toml");
    let values = scene
        .materials
        .iter()
        .map(|material| match &material.model {
            MaterialModel::Diffuse { reflectance } => texture(reflectance).lookup(Vec2::ZERO),
            other => panic!("{other:?}"),
        });
    let code: f32 = 128.0 / 255.0;
    let linear = srgb::to_linear(f64::from(code)) as f32;
    let wanted = [linear, 0.5 * linear, code].map(Rgb::grey);
    for (got, want) in values.zip(wanted) {
        assert!(
            (got - want).max_channel().abs() < 1e-6,
            "{got:?} instead of {want:?}"
        );
    }
}
