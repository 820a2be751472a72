//! glTF files that are read although a part of them is not as usual: animations of properties, names with backslashes, thin
//! sheets, samplers without interpolation.
//!
//! Measure: none.
//! Range: small valid files, and one that is not valid.
//! Source: glTF 2.0, KHR_animation_pointer, KHR_materials_transmission and KHR_materials_volume.

use crate::common::scene_folder::SceneFolder;
use crate::gltf_builder::{Builder, U8, mesh, one_mesh, picture, refused, square, with_material};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::scene::description::{MaterialModel, NoteKind, SceneDescription};

/// The texts of the notes of a kind.
fn noted(scene: &SceneDescription, kind: NoteKind) -> Vec<&str> {
    let notes = scene.notes.iter().filter(|note| note.kind == kind);
    notes.map(|note| note.text.as_str()).collect()
}

/// An animation of a property that belongs to no node, over several lines.
const POINTER: &str = "\"animations\":[{\"samplers\":[],\n\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"pointer\",\n\
    \"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/materials/0/emissiveFactor\"}}}}]}],\n";

#[test]
fn animations_without_a_node_are_left_out_with_a_note() {
    let (builder, [all, _, indices]) = square();
    let keys = one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}"
    ));
    let scene = builder.load(&format!("{POINTER}{keys}"));
    assert_eq!(mesh(&scene, 0).indices, [[0, 1, 2], [0, 2, 3]]);
    let text = "animations that could not be read were left out";
    assert_eq!(noted(&scene, NoteKind::Omission), [text]);
    assert!(scene.check_faithful().is_err());

    // Errors in the rest keep their lines and places.
    let wrong = |from: &str, to: &str| {
        let text = builder.gltf(&format!("{POINTER}{keys}"));
        assert!(text.contains(from), "{from}");
        refused(&text.replacen(from, to, 1))
    };
    let message = wrong("\"mesh\":0", "\"mesh\":\"0\"");
    assert!(message.starts_with("a.gltf:8: expected JSON"), "{message}");
    let message = wrong("\"mesh\":0", "\"mesh\":5");
    assert!(
        message.contains("nodes[0].mesh: expected an index"),
        "{message}"
    );
}

#[test]
fn uris_with_backslashes_name_files_in_folders() {
    let (builder, [all, _, indices]) = square();
    let keys = one_mesh(&format!(
        "\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}"
    ));
    for uri in ["data\\\\b c.bin", "data%5Cb%20c.bin"] {
        let folder = SceneFolder::new([("a.gltf", builder.gltf_beside(&keys, uri))]);
        let within = folder.path("data");
        std::fs::create_dir(&within).expect("the folder is writable");
        std::fs::write(within.join("b c.bin"), &builder.bytes).expect("it is writable");
        assert_eq!(mesh(&folder.load("a.gltf"), 0).positions.len(), 4, "{uri}");
    }
}

/// The keys of glass of this roughness, with further extensions.
fn glass(roughness: f32, extensions: &str) -> String {
    format!(
        "\"pbrMetallicRoughness\":{{\"baseColorFactor\":[0.5,0.75,1,1],\"metallicFactor\":0,\"roughnessFactor\":{roughness}}},\
         \"extensions\":{{\"KHR_materials_transmission\":{{\"transmissionFactor\":1}}{extensions}}}"
    )
}

fn models(scene: &SceneDescription) -> Vec<&MaterialModel> {
    let shapes = scene.shapes.iter();
    shapes
        .map(|it| &scene.materials[it.material].model)
        .collect()
}

#[test]
fn required_specular_glossiness_becomes_a_dielectric_or_metal() {
    let required = ",\"extensionsRequired\":[\"KHR_materials_pbrSpecularGlossiness\"]";
    let model = |specular: f32| {
        let keys = format!(
            "\"extensions\":{{\"KHR_materials_pbrSpecularGlossiness\":{{\"diffuseFactor\":[0.5,0.25,0.125,1],\
             \"specularFactor\":[{specular},{specular},{specular}],\"glossinessFactor\":0.75}}}}"
        );
        with_material(&keys, required)
    };
    let scene = model(0.04);
    let [
        MaterialModel::Principled {
            base_color,
            metallic,
            roughness,
            ior,
            ..
        },
    ] = models(&scene)[..]
    else {
        panic!("{:?}", models(&scene))
    };
    assert_eq!(base_color.constant(), Some(Rgb::new(0.5, 0.25, 0.125)));
    assert_eq!((*metallic, *roughness), (0.0, 0.25));
    assert!((ior - 1.5).abs() < 1e-6, "{ior}");
    let scene = model(0.75);
    let [
        MaterialModel::Principled {
            base_color,
            metallic,
            ..
        },
    ] = models(&scene)[..]
    else {
        panic!("{:?}", models(&scene))
    };
    assert_eq!(
        (base_color.constant(), *metallic),
        (Some(Rgb::grey(0.75)), 1.0)
    );
}

#[test]
fn clear_coat_is_read_without_its_textures() {
    let coated = |keys: &str, others: &str| {
        let extension = format!("\"KHR_materials_clearcoat\":{{{keys}}}{others}");
        with_material(&format!("\"extensions\":{{{extension}}}"), "")
    };
    let coat = |scene: &SceneDescription| scene.materials[scene.shapes[0].material].clear_coat;
    let factors = "\"clearcoatFactor\":0.75,\"clearcoatRoughnessFactor\":0.25";
    let scene = coated(factors, "");
    let found = coat(&scene).map(|it| (it.weight, it.roughness, it.ior));
    assert_eq!(found, Some((0.75, 0.25, 1.5)));
    scene.check_faithful().expect("it is as the file says");
    assert!(coat(&coated("", "")).is_none());

    let textured = format!("{factors},\"clearcoatTexture\":{{\"index\":0}}");
    let scene = coated(&textured, "");
    assert!(coat(&scene).is_some());
    assert_eq!(noted(&scene, NoteKind::Approximation).len(), 1);
    let glass = ",\"KHR_materials_transmission\":{\"transmissionFactor\":1}";
    let scene = coated(factors, glass);
    assert!(coat(&scene).is_none());
    assert_eq!(noted(&scene, NoteKind::Omission).len(), 1);
}

#[test]
fn transmission_of_an_open_mesh_without_a_volume_is_that_of_a_sheet() {
    let clear = with_material(&glass(0.0, ""), "");
    let tint = Rgb::new(0.5, 0.75, 1.0).into();
    assert_eq!(
        models(&clear),
        [&MaterialModel::ThinDielectric { ior: 1.5, tint }]
    );
    clear.check_faithful().expect("it is as the file says");

    let rough = with_material(&glass(0.25, ""), "");
    assert!(matches!(
        models(&rough)[..],
        [MaterialModel::Principled { .. }]
    ));
    let notes = noted(&rough, NoteKind::Approximation);
    assert!(
        matches!(notes[..], [note] if note.contains("thin sheet")),
        "{notes:?}"
    );

    let volume = ",\"KHR_materials_volume\":{\"thicknessFactor\":0.5,\"attenuationDistance\":null}";
    for extensions in [volume, &volume.replace("0.5", "0")] {
        let scene = with_material(&glass(0.0, extensions), "");
        let is_solid = matches!(models(&scene)[..], [MaterialModel::Principled { .. }]);
        assert_eq!(is_solid, extensions == volume, "{extensions}");
        assert!(noted(&scene, NoteKind::Approximation).is_empty());
    }
    // A metal transmits nothing.
    let metal = glass(0.0, "").replace("\"metallicFactor\":0", "\"metallicFactor\":1");
    assert!(noted(&with_material(&metal, ""), NoteKind::Approximation).is_empty());
}

/// A square of two sides, in a primitive each, with glass on the first and another material on the second.
fn two_sides(builder: &mut Builder, all: usize, sides: &[(&[u8], usize)]) -> SceneDescription {
    let primitives: Vec<String> = sides
        .iter()
        .map(|(corners, material)| {
            let indices = builder.add("SCALAR", U8, corners.len(), corners);
            format!("{{\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices},\"material\":{material}}}")
        })
        .collect();
    let keys = format!(
        "\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{}]}}],\"materials\":[{{{}}},{{\"name\":\"label\"}}]",
        primitives.join(","),
        glass(0.0, "")
    );
    builder.load(&keys)
}

#[test]
fn transmission_of_a_closed_mesh_is_solid_also_if_its_parts_are_open() {
    let (mut builder, [all, ..]) = square();
    let front: &[u8] = &[0, 1, 2, 0, 2, 3];
    let back: &[u8] = &[0, 2, 1, 0, 3, 2];
    let whole = [front, back].concat();
    for sides in [&[(&whole[..], 0)][..], &[(front, 0), (back, 1)]] {
        let scene = two_sides(&mut builder, all, sides);
        assert_eq!(scene.shapes.len(), sides.len());
        let first = models(&scene)[0];
        assert!(
            matches!(
                first,
                MaterialModel::Principled {
                    transmission: 1.0,
                    ..
                }
            ),
            "{first:?}"
        );
        assert!(noted(&scene, NoteKind::Approximation).is_empty());
    }
    let open = two_sides(&mut builder, all, &[(front, 0), (&back[..3], 1)]);
    assert!(matches!(
        models(&open)[0],
        MaterialModel::ThinDielectric { .. }
    ));
}

#[test]
fn sampler_that_asks_for_the_nearest_texel_is_noted() {
    let of = |filter: u32| {
        let textures = format!(
            ",\"images\":[{{\"uri\":\"{}\"}}],\"textures\":[{{\"source\":0,\"sampler\":0}}],\
             \"samplers\":[{{\"magFilter\":{filter}}}]",
            picture()
        );
        with_material(
            "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}",
            &textures,
        )
    };
    let (nearest, linear) = (of(9728), of(9729));
    let notes = noted(&nearest, NoteKind::Approximation);
    assert!(
        matches!(notes[..], [note] if note.contains("nearest texel")),
        "{notes:?}"
    );
    assert!(noted(&linear, NoteKind::Approximation).is_empty());
}
