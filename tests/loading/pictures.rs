//! Images of TGA and BMP as textures, and which of an image's channels and encodings count in each format of scenes.
//!
//! Measure: none.
//! Range: images of two pixels.
//! Source: docs/scene-formats.md, docs/scene-format.md.

use crate::common::scene_folder::{SceneFolder, TRIANGLE};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::{Image, WriteOptions, write};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec2;
use etendue::internals::scene::description::{
    ColourDescription, MaterialDescription, MaterialModel, SceneDescription,
};
use image::codecs::bmp::BmpEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::codecs::tga::TgaEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// A file of two pixels side by side, or of more rows of them.
fn encoded(extension: &str, samples: &[u8], channels: ExtendedColorType) -> Vec<u8> {
    let mut bytes = vec![];
    let height = samples.len() as u32 / 2 / u32::from(channels.channel_count());
    let written = match extension {
        "tga" => TgaEncoder::new(&mut bytes).write_image(samples, 2, height, channels),
        "bmp" => BmpEncoder::new(&mut bytes).write_image(samples, 2, height, channels),
        "jpg" => {
            JpegEncoder::new_with_quality(&mut bytes, 100).write_image(samples, 2, height, channels)
        }
        _ => PngEncoder::new(&mut bytes).write_image(samples, 2, height, channels),
    };
    written.expect("encoded");
    bytes
}

const RED_AND_BLUE: [u8; 6] = [255, 0, 0, 0, 0, 255];
/// Red of an alpha of 0.2, and opaque blue.
const WITH_ALPHA: [u8; 8] = [255, 0, 0, 51, 0, 0, 255, 255];

/// The first channel of a texture at the centres of its two pixels.
fn first_channels(colour: &ColourDescription) -> [f32; 2] {
    let ColourDescription::Texture(texture) = colour else {
        panic!("no texture");
    };
    [0.25, 0.75].map(|u| texture.lookup(Vec2::new(u, 0.5)).to_array()[0])
}

fn material(scene: &SceneDescription) -> &MaterialDescription {
    &scene.materials[scene.shapes.last().expect("a shape").material]
}

#[test]
fn tga_and_bmp_textures_of_mtl_are_read_with_their_alpha() {
    for extension in ["tga", "bmp"] {
        let model = format!("mtllib a.mtl\nusemtl it\n{TRIANGLE}");
        let folder = SceneFolder::new([
            ("a.obj", model.into_bytes()),
            (
                "a.mtl",
                b"newmtl it\nmap_Kd colour\nmap_d alpha\nPr 1\n".to_vec(),
            ),
            (
                "colour",
                encoded(extension, &RED_AND_BLUE, ExtendedColorType::Rgb8),
            ),
            (
                "alpha",
                encoded(extension, &WITH_ALPHA, ExtendedColorType::Rgba8),
            ),
        ]);
        let scene = folder.load("a.obj");
        let material = material(&scene);
        let MaterialModel::Diffuse { reflectance } = &material.model else {
            panic!("{:?}", material.model);
        };
        assert_eq!(first_channels(reflectance), [1.0, 0.0], "{extension}");
        assert_eq!(first_channels(&material.alpha), [0.2, 1.0], "{extension}");
    }
}

/// A sphere whose opacity and colour are an image, after `WorldBegin`, in line 2.
fn pbrt(file: &'static str, bytes: Vec<u8>, kind: &str, more: &str) -> SceneDescription {
    let texture =
        format!("Texture \"t\" \"{kind}\" \"imagemap\" \"string filename\" \"{file}\" {more}");
    let used = match kind {
        "float" => "Shape \"sphere\" \"texture alpha\" \"t\"",
        _ => "Material \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"",
    };
    let text =
        format!("LookAt 0 0 5  0 0 0  0 1 0 Camera \"perspective\" WorldBegin\n{texture}\n{used}");
    SceneFolder::new([("a.pbrt", text.into_bytes()), (file, bytes)]).load("a.pbrt")
}

#[test]
fn pbrt_takes_alpha_of_png_only_for_a_number() {
    let of = |file, extension: &str| {
        let bytes = encoded(extension, &WITH_ALPHA, ExtendedColorType::Rgba8);
        first_channels(&material(&pbrt(file, bytes, "float", "")).alpha)
    };
    assert_eq!(of("t.png", "png"), [0.2, 1.0]);
    // Others have the mean of their channels.
    for (file, extension) in [("t.tga", "tga"), ("t.BMP", "bmp")] {
        assert_eq!(of(file, extension), [1.0 / 3.0; 2], "{file}");
    }
}

#[test]
fn pbrt_encoding_counts_for_png_only() {
    let grey = [188_u8; 3 * 2 * 8];
    let floats = tempfile::tempdir().expect("a folder");
    let read = |file: &'static str, encoding: &str| {
        let bytes = match file.rsplit_once('.').expect("an extension").1 {
            "exr" | "hdr" | "pfm" => {
                let path = floats.path().join(file);
                let image = Image::filled(2, 1, Rgb::grey(0.25));
                write(&path, &image, &WriteOptions::default()).expect("written");
                std::fs::read(path).expect("read")
            }
            extension => encoded(extension, &grey, ExtendedColorType::Rgb8),
        };
        let more = format!("\"string encoding\" \"{encoding}\"");
        let scene = pbrt(file, bytes, "spectrum", &more);
        let MaterialModel::Diffuse { reflectance } = &material(&scene).model else {
            panic!("{:?}", material(&scene).model);
        };
        first_channels(reflectance)[0]
    };
    let code: f32 = 188.0 / 255.0;
    let srgb = ((code + 0.055) / 1.055).powf(2.4);
    let cases = [
        ("t.png", "sRGB", srgb),
        ("t.png", "linear", code),
        ("t.png", "gamma 2", code * code),
    ];
    let is_near = |found: f32, expected: f32| (found - expected).abs() < 1e-5;
    for (file, encoding, expected) in cases {
        let found = read(file, encoding);
        assert!(
            is_near(found, expected),
            "{file} {encoding}: {found} {expected}"
        );
    }
    for encoding in ["sRGB", "linear", "gamma 2"] {
        for file in ["t.jpg", "t.tga", "t.bmp"] {
            let found = read(file, encoding);
            assert!(is_near(found, srgb), "{file} {encoding}: {found} {srgb}");
        }
        for file in ["t.exr", "t.hdr", "t.pfm"] {
            assert_eq!(read(file, encoding), 0.25, "{file} {encoding}");
        }
    }
}

#[test]
fn bmp_of_a_gltf_file_is_read() {
    let (builder, [positions, uvs, indices]) = crate::gltf_builder::square();
    let mesh = crate::gltf_builder::one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{positions},\"TEXCOORD_0\":{uvs}}},\"indices\":{indices},\"material\":0"
    ));
    let text = builder.gltf(&format!(
        "{mesh},\"images\":[{{\"uri\":\"t.bmp\"}}],\"textures\":[{{\"source\":0}}],\
         \"materials\":[{{\"pbrMetallicRoughness\":{{\"baseColorTexture\":{{\"index\":0}}}}}}]"
    ));
    let bytes = encoded("bmp", &RED_AND_BLUE, ExtendedColorType::Rgb8);
    let scene = SceneFolder::new([("a.gltf", text.into_bytes()), ("t.bmp", bytes)]).load("a.gltf");
    let MaterialModel::Principled {
        base_color: ColourDescription::Texture(texture),
        ..
    } = &material(&scene).model
    else {
        panic!("{:?}", material(&scene).model);
    };
    assert!(matches!(texture.as_ref(), Texture::Image { image, .. }
        if image.texels().eq([Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0)])));
}
