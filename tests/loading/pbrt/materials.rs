//! Materials, textures and colours of pbrt files.

use super::{HEAD, constant, model, near, notes, world, world_with};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::{Image, WriteOptions, write};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::Vec2;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, MaterialModel, NoteKind, SceneDescription,
};

/// A world with one sphere of this material.
fn of(material: &str) -> SceneDescription {
    world(&format!("{material}\nShape \"sphere\""))
}

fn reflectance(scene: &SceneDescription) -> &ColourDescription {
    match model(scene) {
        MaterialModel::Diffuse { reflectance } | MaterialModel::Plastic { reflectance, .. } => {
            reflectance
        }
        other => panic!("{other:?} has no reflectance"),
    }
}

#[test]
fn diffuse_and_default_materials_are_read() {
    near(constant(reflectance(&world("Shape \"sphere\""))), [0.5; 3]);
    near(constant(reflectance(&of("Material \"diffuse\""))), [0.5; 3]);
    near(
        constant(reflectance(&of(
            "Material \"diffuse\" \"rgb reflectance\" [ 0.1 0.2 0.3 ]",
        ))),
        [0.1, 0.2, 0.3],
    );
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 1 0 0 ]\nNamedMaterial \"a\"";
    near(constant(reflectance(&of(named))), [1.0, 0.0, 0.0]);
    let spectrum = "Material \"diffuse\" \"spectrum reflectance\" [ 300 0.25 900 0.25 ]";
    near(constant(reflectance(&of(spectrum))), [0.25; 3]);
    let scene = of("Material \"interface\"");
    assert!(scene.shapes.is_empty() && scene.notes.is_empty());
}

#[test]
fn pbrt_roughness_is_remapped_to_native_roughness() {
    let roughness = |more: &str| match model(&of(&format!("Material \"dielectric\" {more}"))) {
        MaterialModel::Dielectric { roughness, .. } => *roughness,
        other => panic!("{other:?}"),
    };
    assert_eq!(roughness(""), 0.0);
    // alpha = sqrt(0.0081) = 0.09 = 0.3^2.
    assert!((roughness("\"float roughness\" 0.0081") - 0.3).abs() < 1e-6);
    assert!(
        (roughness("\"float roughness\" 0.09 \"bool remaproughness\" false") - 0.3).abs() < 1e-6
    );
    assert_eq!(
        roughness("\"float roughness\" 0.0009 \"bool remaproughness\" false"),
        0.0
    );
    let both = "\"float uroughness\" 0.04 \"float vroughness\" 0.25 \"bool remaproughness\" false";
    assert!((roughness(both) - 0.1f32.sqrt()).abs() < 1e-6);
}

#[test]
fn conductors_are_read_from_spectra_rgb_or_reflectance() {
    let index = |more: &str| match model(&of(&format!("Material \"conductor\" {more}"))) {
        MaterialModel::Conductor { eta, k, .. } => (*eta, *k),
        other => panic!("{other:?}"),
    };
    let copper = index("\"spectrum eta\" \"metal-Cu-eta\" \"spectrum k\" \"metal-Cu-k\"");
    assert_eq!(index(""), copper);
    near(copper.0, [0.28, 1.12, 1.25]);
    assert_ne!(
        index("\"spectrum eta\" \"metal-Ag-eta\" \"spectrum k\" \"metal-Ag-k\""),
        copper
    );
    near(
        index("\"rgb eta\" [ 1 2 3 ] \"rgb k\" [ 4 5 6 ]").1,
        [4.0, 5.0, 6.0],
    );
    near(
        index("\"spectrum eta\" [ 400 1 800 5 ] \"rgb k\" [ 4 5 6 ]").0,
        [3.3, 2.32, 1.65],
    );
    // An index of 0 reflects everything.
    let (eta, k) = index("\"rgb eta\" [ 0 0.5 0 ] \"rgb k\" [ 4 5 0 ]");
    near(eta, [1e-4, 0.5, 1e-4]);
    near(k, [4.0, 5.0, 0.0]);
    // The reflectance at normal incidence is the one that is given.
    let (eta, k) = index("\"rgb reflectance\" [ 0.9 0.5 0.1 ]");
    let fresnel = |i: usize| {
        let (eta, k) = (eta.to_array()[i], k.to_array()[i]);
        ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k)
    };
    near(
        Rgb::new(fresnel(0), fresnel(1), fresnel(2)),
        [0.9, 0.5, 0.1],
    );
}

#[test]
fn unsupported_materials_are_approximated_with_notes() {
    use NoteKind::{Approximation, Omission};
    for (text, kind) in [
        ("Material \"coateddiffuse\"", Approximation),
        ("Material \"coatedconductor\"", Approximation),
        ("Material \"diffusetransmission\"", Omission),
        ("Material \"subsurface\"", Approximation),
        ("Material \"hair\"", Approximation),
        (
            "Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"",
            Approximation,
        ),
    ] {
        assert!(notes(&of(text)).contains(&(kind, 5)), "{text}");
    }
    let scene = of(
        "Material \"coatedconductor\" \"rgb conductor.eta\" [ 3 3 3 ] \"rgb conductor.k\" [ 6 6 6 ] \"float interface.eta\" 2",
    );
    let coat = scene.materials[0].clear_coat.expect("a coat");
    assert_eq!((coat.weight, coat.roughness, coat.ior), (1.0, 0.0, 2.0));
    let MaterialModel::Conductor { eta, k, .. } = model(&scene) else {
        panic!("{:?}", model(&scene))
    };
    // Relative to the coat.
    assert_eq!((*eta, *k), (Rgb::grey(1.5), Rgb::grey(3.0)));
    let scene =
        of("Material \"coateddiffuse\" \"rgb reflectance\" [ 0.1 0.2 0.3 ] \"float eta\" 1.4");
    assert!(matches!(
        model(&scene),
        MaterialModel::Plastic {
            ior: 1.4,
            roughness: 0.0,
            ..
        }
    ));
    let scene = of("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"");
    assert!(matches!(
        model(&scene),
        MaterialModel::Dielectric { ior: 1.5168, .. }
    ));
    // Without absorption, light comes back.
    let white = "Material \"subsurface\" \"rgb sigma_a\" [ 0 0 1 ] \"rgb sigma_s\" [ 1 1 0 ]";
    near(constant(reflectance(&of(white))), [1.0, 1.0, 0.0]);
}

#[test]
fn diffuse_mixes_are_blended_and_others_pick_the_main_material() {
    let named = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 1 0 0 ]\n\
                 MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 0 0 1 ]\n\
                 MakeNamedMaterial \"c\" \"string type\" \"conductor\"\n";
    let mix = |materials: &str, amount: f32| {
        of(&format!(
            "{named}Material \"mix\" \"string materials\" [ {materials} ] \"float amount\" {amount}"
        ))
    };
    let scene = mix("\"a\" \"b\"", 0.25);
    near(constant(reflectance(&scene)), [0.75, 0.0, 0.25]);
    assert!(scene.notes.is_empty());
    for (amount, is_metal) in [(0.25, false), (0.75, true)] {
        let scene = mix("\"a\" \"c\"", amount);
        assert_eq!(
            matches!(model(&scene), MaterialModel::Conductor { .. }),
            is_metal
        );
        assert_eq!(notes(&scene), [(NoteKind::Approximation, 8)]);
    }
}

/// An image of two pixels, 0.25 and 1, in every channel.
fn picture() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.pfm");
    let image = Image::new(2, 1, vec![Rgb::grey(0.25), Rgb::WHITE]);
    write(&path, &image, &WriteOptions::default()).expect("written");
    std::fs::read(path).expect("read")
}

/// The colours of a texture named `a` at the centres of the image's pixels.
fn textured(text: &str) -> [f32; 2] {
    let image = "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"t.pfm\"\n";
    let material = "\nMaterial \"diffuse\" \"texture reflectance\" \"a\"\nShape \"sphere\"";
    let scene = world_with(&format!("{image}{text}{material}"), [("t.pfm", picture())]);
    match reflectance(&scene) {
        ColourDescription::Constant(colour) => [colour.to_array()[0]; 2],
        ColourDescription::Texture(texture) => {
            [0.25, 0.75].map(|u| texture.lookup(Vec2::new(u, 0.5)).to_array()[0])
        }
    }
}

#[test]
fn texture_types_evaluate_to_expected_values() {
    let a = "Texture \"a\" \"spectrum\"";
    for (text, expected) in [
        ("\"imagemap\" \"string filename\" \"t.pfm\"", [0.25, 1.0]),
        (
            "\"imagemap\" \"string filename\" \"t.pfm\" \"float scale\" 0.5",
            [0.125, 0.5],
        ),
        (
            "\"imagemap\" \"string filename\" \"t.pfm\" \"float scale\" 2",
            [0.5, 1.0],
        ),
        (
            "\"imagemap\" \"string filename\" \"t.pfm\" \"bool invert\" true",
            [0.75, 0.0],
        ),
        ("\"constant\" \"rgb value\" [ 0.5 0.5 0.5 ]", [0.5, 0.5]),
        (
            "\"scale\" \"texture tex\" \"i\" \"float scale\" 0.5",
            [0.125, 0.5],
        ),
        (
            "\"mix\" \"texture tex1\" \"i\" \"rgb tex2\" [ 0 0 0 ] \"float amount\" 0.25",
            [0.1875, 0.75],
        ),
        (
            "\"mix\" \"texture tex1\" \"i\" \"texture tex2\" \"i\" \"float amount\" 0.25",
            [0.25, 1.0],
        ),
        (
            "\"checkerboard\" \"float uscale\" 2 \"rgb tex1\" [ 0.5 0 0 ] \"rgb tex2\" [ 0 0 0 ]",
            [0.5, 0.0],
        ),
        (
            "\"bilerp\" \"rgb v00\" [ 1 1 1 ] \"rgb v10\" [ 0 0 0 ]",
            [0.75, 0.75],
        ),
    ] {
        let found = textured(&format!("{a} {text}"));
        let is_near = found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-4);
        assert!(is_near, "{text}: {found:?} {expected:?}");
    }
}

#[test]
fn shapes_with_equal_alpha_share_a_material() {
    let half = "Texture \"half\" \"float\" \"imagemap\" \"string filename\" \"t.pfm\"\n";
    let text = "Material \"diffuse\"\nShape \"sphere\"\nShape \"sphere\" \"float alpha\" 0.5\nShape \"sphere\" \"float alpha\" 0.5\n\
                Shape \"disk\" \"texture alpha\" \"half\"\nShape \"sphere\" \"float alpha\" 1\n";
    let scene = world_with(&format!("{half}{text}"), [("t.pfm", picture())]);
    let materials: Vec<usize> = scene.shapes.iter().map(|shape| shape.material).collect();
    assert_eq!(materials, [0, 1, 1, 2, 0]);
    near(constant(&scene.materials[1].alpha), [0.5; 3]);
    assert!(matches!(
        &scene.materials[2].alpha,
        ColourDescription::Texture(_)
    ));
    // A textured disk needs pbrt's texture coordinates.
    assert!(matches!(
        &scene.shapes[3].geometry,
        GeometryDescription::Mesh(_)
    ));
}

/// pbrt takes the alpha channel of an image for its number, unless the image is opaque.
#[test]
fn float_image_with_alpha_is_its_alpha_channel() {
    let mut png = vec![];
    let samples = [10, 20, 30, 51, 10, 20, 30, 255];
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    image::ImageEncoder::write_image(encoder, &samples, 2, 1, image::ExtendedColorType::Rgba8)
        .expect("encoded");
    let text = "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"t.png\"\n\
        Shape \"sphere\" \"texture alpha\" \"a\"";
    let scene = world_with(text, [("t.png", png)]);
    let material = scene.shapes.last().expect("a sphere").material;
    let ColourDescription::Texture(alpha) = &scene.materials[material].alpha else {
        panic!("a texture")
    };
    let at = |u: f32| alpha.lookup(Vec2::new(u, 0.5)).to_array()[0];
    assert_eq!((at(0.25), at(0.75)), (0.2, 1.0));
}

#[test]
fn values_below_zero_of_images_are_clamped_with_a_note() {
    let text = "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"t.pfm\" \"float scale\" -3\n\
        Shape \"sphere\" \"texture alpha\" \"a\"";
    let scene = world_with(text, [("t.pfm", picture())]);
    assert!(notes(&scene).contains(&(NoteKind::Approximation, HEAD.lines().count() + 1)));
}

#[test]
fn invisible_area_light_stays_a_light() {
    let text =
        "AreaLightSource \"diffuse\" \"rgb L\" [ 3 3 3 ]\nShape \"sphere\" \"float alpha\" 0";
    let scene = world(text);
    let lamp = scene.shapes.last().expect("a lamp");
    assert!(lamp.emission.is_some());
    assert_eq!(constant(&scene.materials[lamp.material].alpha), Rgb::WHITE);
    assert!(notes(&scene).contains(&(NoteKind::Approximation, HEAD.lines().count() + 2)));
}

#[test]
fn normal_map_is_read_as_an_image_texture() {
    let text = "Material \"diffuse\" \"string normalmap\" \"t.pfm\"\nShape \"sphere\"";
    let scene = world_with(text, [("t.pfm", picture())]);
    let map = scene.materials[0].normal_map.as_ref().expect("a map");
    assert!(matches!(map.texture.as_ref(), Texture::Image { .. }));
}

#[test]
fn displacement_becomes_a_bump_map_beside_no_normal_map() {
    let heights =
        "Texture \"h\" \"float\" \"imagemap\" \"string filename\" \"t.pfm\" \"float scale\" 0.25\n";
    let of = |keys: &str| {
        let text = format!(
            "{heights}Material \"diffuse\" \"texture displacement\" \"h\"{keys}\nShape \"sphere\""
        );
        world_with(&text, [("t.pfm", picture())])
    };
    let scene = of("");
    let map = scene.materials[0].bump_map.as_ref().expect("a map");
    assert_eq!((map.height, notes(&scene)), (1.0, vec![]));
    let scene = of(" \"string normalmap\" \"t.pfm\"");
    let material = &scene.materials[0];
    assert!(material.normal_map.is_some() && material.bump_map.is_none());
    assert!(notes(&scene).contains(&(NoteKind::Omission, HEAD.lines().count() + 2)));
    // A constant displacement moves the surface nowhere.
    let scene = world("Material \"diffuse\" \"float displacement\" 0.1\nShape \"sphere\"");
    assert!(scene.materials[0].bump_map.is_none() && notes(&scene).is_empty());
}

#[test]
fn wide_gamut_colours_are_converted_to_rec_709() {
    let colour = |space: &str| {
        let text = format!(
            "ColorSpace \"{space}\"\nMaterial \"diffuse\" \"rgb reflectance\" [ 0.2 0.4 0.2 ]"
        );
        constant(reflectance(&of(&text))).to_array()
    };
    assert_eq!(colour("srgb"), [0.2, 0.4, 0.2]);
    for space in ["dci-p3", "rec2020", "aces2065-1"] {
        let [r, g, b] = colour(space);
        // A green of wider primaries is more saturated.
        assert!(g > 0.4 && r < 0.2 && b < 0.2, "{space}: {r} {g} {b}");
        let white =
            format!("ColorSpace \"{space}\"\nMaterial \"diffuse\" \"rgb reflectance\" [ 1 1 1 ]");
        near(constant(reflectance(&of(&white))), [1.0; 3]);
    }
}
