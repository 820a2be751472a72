//! glTF files: meshes in every packing, materials, textures, nodes, lights and cameras.

use crate::common::scene_folder::SceneFolder;
use crate::gltf_builder::{
    Builder, F32, U8, U16, U32, floats, loaded, mesh, one_mesh, picture, square, with_material,
};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::geometry::uv_map::Wrap;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DVec2, DVec3, Vec2};
use etendue::internals::scene::description::{
    ColourDescription, LightModel, MaterialDescription, MaterialModel, NoteKind, SceneDescription,
};
use etendue::internals::scene::load::load_with;

const CORNERS: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

fn positions(scene: &SceneDescription) -> Vec<[f64; 3]> {
    let positions = mesh(scene, 0).positions.iter();
    positions.map(|p| p.to_array()).collect()
}

#[test]
fn embedded_external_and_glb_buffers_load_the_same_mesh() {
    let (builder, [positions, _, indices]) = square();
    let keys = format!("\"attributes\":{{\"POSITION\":{positions}}},\"indices\":{indices}");
    let within = builder.load(&one_mesh(&keys));
    let folder = SceneFolder::new([
        ("a.glb", builder.glb(&one_mesh(&keys))),
        (
            "b.gltf",
            builder
                .gltf_beside(&one_mesh(&keys), "my%20data.bin")
                .into_bytes(),
        ),
        ("my data.bin", builder.bytes.clone()),
    ]);
    for scene in [within, folder.load("a.glb"), folder.load("b.gltf")] {
        assert_eq!(mesh(&scene, 0).indices, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh(&scene, 0).positions, CORNERS.map(DVec3::from_array));
        assert_eq!(scene.lights.len(), 1, "a sky");
        assert!(
            scene
                .notes
                .iter()
                .all(|note| note.kind == NoteKind::Decision)
        );
    }
}

#[test]
fn interleaved_accessors_and_all_index_types_are_read() {
    let mut builder = Builder::default();
    // Positions and texture coordinates of 16 bits side by side, with a gap.
    let mut bytes = vec![];
    for [x, y, z] in CORNERS {
        bytes.extend(floats(&[x as f32, y as f32, z as f32]));
        bytes.extend(
            [x, 1.0 - y]
                .map(|x| (65535.0 * x) as u16)
                .map(u16::to_le_bytes)
                .concat(),
        );
        bytes.extend([9; 8]);
    }
    let view = builder.view(&bytes, ",\"byteStride\":24");
    let at = |offset: usize| format!(",\"bufferView\":{view},\"byteOffset\":{offset}");
    let positions_at = builder.accessor("VEC3", F32, 4, &at(0));
    let uvs = builder.accessor("VEC2", U16, 4, &(at(12) + ",\"normalized\":true"));
    for (component, size) in [(U8, 1), (U16, 2), (U32, 4)] {
        let indices = [0_u32, 1, 2, 0, 2, 3].map(|i| i.to_le_bytes()[..size].to_vec());
        let indices = builder.add("SCALAR", component, 6, &indices.concat());
        let scene = builder.load(&one_mesh(&format!(
            "\"attributes\":{{\"POSITION\":{positions_at},\"TEXCOORD_0\":{uvs},\"_OWN\":0}},\"indices\":{indices}"
        )));
        assert_eq!(positions(&scene), CORNERS);
        // v is down in the file.
        let uvs = CORNERS.map(|[x, y, _]| DVec2::new(x, y));
        assert_eq!(mesh(&scene, 0).uvs, uvs);
        assert_eq!(mesh(&scene, 0).indices, [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn sparse_accessors_override_buffer_view_values_or_zeros() {
    for has_view in [true, false] {
        let mut builder = Builder::default();
        let base = floats(&[5.0; 9]);
        let view = builder.view(&base, "");
        let indices = builder.view(&[1, 2], "");
        let values = builder.view(&floats(&[1., 0., 0., 0., 1., 0.]), "");
        let view = if has_view {
            format!(",\"bufferView\":{view}")
        } else {
            String::new()
        };
        let accessor = builder.accessor("VEC3", F32, 3, &format!(
            "{view},\"sparse\":{{\"count\":2,\"indices\":{{\"bufferView\":{indices},\"componentType\":5121}},\
             \"values\":{{\"bufferView\":{values}}}}}"
        ));
        let scene = builder.load(&one_mesh(&format!(
            "\"attributes\":{{\"POSITION\":{accessor}}}"
        )));
        let first = if has_view { [5.0; 3] } else { [0.0; 3] };
        assert_eq!(positions(&scene), [first, [1., 0., 0.], [0., 1., 0.]]);
    }
}

#[test]
fn strip_and_fan_winding_is_kept_and_unused_vertices_dropped() {
    let (mut builder, [all, ..]) = square();
    let zigzag = builder.add("SCALAR", U8, 4, &[0, 1, 3, 2]);
    let modes = [
        ("5", Some(zigzag), vec![[0, 1, 3], [1, 2, 3]]),
        ("6", None, vec![[1, 2, 0], [2, 3, 0]]),
    ];
    for (mode, indices, expected) in modes {
        let indices = indices.map_or(String::new(), |it| format!("\"indices\":{it},"));
        let keys = format!("{indices}\"mode\":{mode},\"attributes\":{{\"POSITION\":{all}}}");
        let scene = builder.load(&one_mesh(&keys));
        let mesh = mesh(&scene, 0);
        assert_eq!(mesh.indices, expected, "mode {mode}");
        for corners in &mesh.indices {
            let [a, b, c] = corners.map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "mode {mode}");
        }
    }
    let one = builder.add("SCALAR", U8, 3, &[1, 2, 3]);
    let keys = format!("\"indices\":{one},\"attributes\":{{\"POSITION\":{all}}}");
    let scene = builder.load(&one_mesh(&keys));
    assert_eq!(positions(&scene), CORNERS[1..]);
    assert_eq!(mesh(&scene, 0).indices, [[0, 1, 2]]);

    let points = format!("{{\"mode\":0,\"attributes\":{{\"POSITION\":{all}}}}}");
    let both = format!(
        "\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{points},{{\"indices\":{one},\"attributes\":{{\"POSITION\":{all}}}}}]}}]"
    );
    let scene = builder.load(&both);
    assert_eq!(scene.shapes.len(), 1);
    assert!(
        scene
            .notes
            .iter()
            .any(|note| note.kind == NoteKind::Omission
                && note.text.contains("1 primitives without triangles"))
    );
}

#[test]
fn shared_meshes_become_instances_and_others_placed_shapes() {
    let (builder, [all, _, indices]) = square();
    let primitive = format!(
        "{{\"primitives\":[{{\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}}}]}}"
    );
    let scene = builder.load(&format!(
        "\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"meshes\":[{primitive},{primitive}],\"nodes\":[\
         {{\"translation\":[1,2,3],\"children\":[1,2,3]}},\
         {{\"mesh\":0,\"scale\":[2,2,2]}},\
         {{\"mesh\":1,\"name\":\"it\",\"rotation\":[0,0,0.70710678,0.70710678]}},\
         {{\"mesh\":0,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1]}}]"
    ));
    assert_eq!(scene.groups.len(), 1);
    let [within, alone] = &scene.shapes[..] else {
        panic!("two shapes");
    };
    assert_eq!((within.group, alone.group), (Some(0), None));
    let at = |p: DVec3| alone.transform.transform_point3(p);
    assert!((at(DVec3::X) - DVec3::new(1.0, 3.0, 3.0)).length() < 1e-6);
    let [first, second] = &scene.instances[..] else {
        panic!("two instances");
    };
    assert_eq!(
        first.transform.transform_point3(DVec3::X),
        DVec3::new(3.0, 2.0, 3.0)
    );
    assert_eq!(second.transform.translation, DVec3::new(6.0, 2.0, 3.0));
}

fn material(scene: &SceneDescription) -> &MaterialDescription {
    &scene.materials[scene.shapes[0].material]
}

#[test]
fn default_material_is_rough_metal_and_factors_are_read() {
    let scene = with_material("\"name\":\"m\"", "");
    let model = MaterialModel::Principled {
        base_color: Rgb::WHITE.into(),
        metallic: 1.0,
        roughness: 1.0,
        ior: 1.5,
        transmission: 0.0,
    };
    assert_eq!(material(&scene).model, model);
    let scene = with_material(
        "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,1,0.5],\"metallicFactor\":0,\"roughnessFactor\":0.25},\
         \"alphaMode\":\"BLEND\",\"doubleSided\":true,\"emissiveFactor\":[1,0.5,0],\"extensions\":{\
         \"KHR_materials_emissive_strength\":{\"emissiveStrength\":8},\"KHR_materials_ior\":{\"ior\":1.25},\
         \"KHR_materials_transmission\":{\"transmissionFactor\":0.75}}",
        "",
    );
    let model = MaterialModel::Principled {
        base_color: Rgb::new(0.5, 0.25, 1.0).into(),
        metallic: 0.0,
        roughness: 0.25,
        ior: 1.25,
        transmission: 0.75,
    };
    assert_eq!(material(&scene).model, model);
    assert_eq!(material(&scene).alpha.constant(), Some(Rgb::grey(0.5)));
    assert_eq!(
        scene.shapes[0].emission,
        Some(Rgb::new(8.0, 4.0, 0.0).into())
    );
    assert!(scene.shapes[0].two_sided_emission);
    assert!(scene.lights.is_empty(), "the surface is a lamp");
}

#[test]
fn glowing_model_without_a_camera_gets_a_sky() {
    let scene = with_material("\"emissiveFactor\":[1,0.5,0]", "");
    assert_eq!(
        scene.shapes[0].emission,
        Some(Rgb::new(1.0, 0.5, 0.0).into())
    );
    assert_eq!(scene.lights.len(), 1, "a sky");
}

#[test]
fn negative_normal_scale_is_read() {
    let keys = "\"normalTexture\":{\"index\":0,\"scale\":-0.5}";
    let scene = with_material(keys, &textures(""));
    let map = material(&scene).normal_map.as_ref().expect("a map");
    assert_eq!(map.strength, -0.5);
}

fn textures(more: &str) -> String {
    format!(
        ",\"images\":[{{\"uri\":\"{}\"}}],\"textures\":[{{\"source\":0,\"sampler\":0}}],\"samplers\":[{{{more}}}]",
        picture()
    )
}

fn texture(colour: &ColourDescription) -> &Texture {
    let ColourDescription::Texture(texture) = colour else {
        panic!("a texture");
    };
    texture
}

#[test]
fn texture_wrap_tint_alpha_cutoff_and_normal_scale_are_read() {
    let scene = with_material(
        "\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5,\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,1,1],\
         \"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{\"index\":0}},\
         \"normalTexture\":{\"index\":0,\"scale\":0.5}",
        &textures("\"wrapS\":33071,\"wrapT\":33648"),
    );
    let material = material(&scene);
    let MaterialModel::Principled { base_color, .. } = &material.model else {
        panic!("principled");
    };
    // Left of the image is its left texel.
    let at = |u: f32| texture(base_color).lookup(Vec2::new(u, 0.5));
    assert_eq!(
        (at(-3.0), at(0.25)),
        (Rgb::new(1.0, 0.0, 0.0), Rgb::new(1.0, 0.0, 0.0))
    );
    assert_eq!(at(7.0), Rgb::new(0.0, 0.5, 0.0));
    assert!(matches!(texture(base_color), Texture::Placed { uv_map, .. }
        if uv_map.wrap == [Wrap::Clamp, Wrap::Mirror]));
    let alpha = texture(&material.alpha);
    assert_eq!(alpha.lookup(Vec2::new(0.25, 0.5)), Rgb::grey(0.4));
    assert_eq!(material.alpha_cutoff, Some(0.5));
    assert!(material.metallic_roughness_map.is_some());
    assert_eq!(
        material.normal_map.as_ref().map(|map| map.strength),
        Some(0.5)
    );
}

#[test]
fn khr_texture_transform_is_applied_with_v_up() {
    let scene = with_material(
        "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":\
         {\"offset\":[0.1,0.2],\"rotation\":1.5707963267948966,\"scale\":[2,3]}}}}",
        &textures(""),
    );
    let MaterialModel::Principled { base_color, .. } = &material(&scene).model else {
        panic!("principled");
    };
    let Texture::Placed { uv_map, .. } = texture(base_color) else {
        panic!("a placed image");
    };
    // With v down, u' = 3 v + 0.1 and v' = -2 u + 0.2 at a quarter turn.
    let (u, v_down) = (0.3, 0.4);
    let expected = Vec2::new(3.0 * v_down + 0.1, 1.0 - (-2.0 * u + 0.2));
    let found = uv_map.apply((2, 1), Vec2::new(u, 1.0 - v_down));
    assert!((found - expected).length() < 1e-6, "{found} {expected}");
}

#[test]
fn vertex_colours_become_a_texture_or_a_constant_colour() {
    for (second, varies) in [([0.0_f32, 1.0, 0.0], true), ([1.0, 0.0, 0.0], false)] {
        let (mut builder, [all, _, indices]) = square();
        let mut colours = floats(&[1.0, 0.0, 0.0].repeat(3));
        colours.extend(floats(&second));
        let colours = builder.add("VEC3", F32, 4, &colours);
        let scene = builder.load(&one_mesh(&format!(
            "\"attributes\":{{\"POSITION\":{all},\"COLOR_0\":{colours}}},\"indices\":{indices}"
        )));
        let MaterialModel::Principled { base_color, .. } = &material(&scene).model else {
            panic!("principled");
        };
        assert_eq!(base_color.constant().is_none(), varies);
        let mesh = mesh(&scene, 0);
        let last = mesh.indices[1].map(|i| i as usize)[2];
        let colour = match base_color {
            ColourDescription::Constant(colour) => *colour,
            ColourDescription::Texture(texture) => texture.lookup(mesh.uvs[last].as_vec2()),
        };
        let difference = colour - Rgb::from(second);
        assert!(
            difference.to_array().iter().all(|x| x.abs() < 1e-5),
            "{colour:?}"
        );
    }
}

const LIGHTS: &str = ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[\
    {\"type\":\"point\",\"intensity\":683,\"color\":[1,0.5,0]},\
    {\"type\":\"directional\",\"intensity\":1366},\
    {\"type\":\"spot\",\"intensity\":683,\"spot\":{\"innerConeAngle\":0.25,\"outerConeAngle\":0.75}}]}}";

#[test]
fn light_intensities_are_converted_at_683_lumens_per_watt() {
    let (builder, [all, _, indices]) = square();
    let light = |index: usize| {
        format!(
            "{{\"translation\":[0,2,0],\"rotation\":[-0.70710678,0,0,0.70710678],\
                 \"extensions\":{{\"KHR_lights_punctual\":{{\"light\":{index}}}}}}}"
        )
    };
    let scene = builder.load(&format!(
        "\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}}}]}}],\
         \"nodes\":[{{\"mesh\":0}},{},{},{}]{LIGHTS}",
        light(0), light(1), light(2)
    ));
    let [point, distant, spot] = &scene.lights[..] else {
        panic!("three lights");
    };
    assert!(
        matches!(point.model, LightModel::Point { position, intensity }
        if position == DVec3::new(0.0, 2.0, 0.0) && intensity == Rgb::new(1.0, 0.5, 0.0))
    );
    assert!(
        matches!(distant.model, LightModel::Distant { direction, irradiance }
        if (direction - DVec3::NEG_Y).length() < 1e-6 && irradiance == Rgb::grey(2.0))
    );
    assert!(
        matches!(spot.model, LightModel::Spot { target, cone: 0.75, penumbra: 0.5, .. }
        if (target - DVec3::Y).length() < 1e-6)
    );
}

/// Blender writes equal angles for a spot with a sharp edge.
#[test]
fn spot_light_of_equal_cone_angles_has_no_penumbra() {
    let (builder, [all, _, indices]) = square();
    let sharp = LIGHTS.replace("0.25", "0.75");
    let scene = builder.load(&format!(
        "\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}}}]}}],\
         \"nodes\":[{{\"mesh\":0}},{{\"extensions\":{{\"KHR_lights_punctual\":{{\"light\":2}}}}}}]{sharp}"
    ));
    assert!(
        matches!(
            scene.lights[0].model,
            LightModel::Spot {
                cone: 0.75,
                penumbra: 0.0,
                ..
            }
        ),
        "{:?}",
        scene.lights
    );
}

#[test]
fn first_or_named_camera_is_used() {
    let (builder, [all, _, indices]) = square();
    let text = builder.gltf(&format!(
        "\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}}}]}}],\
         \"cameras\":[{{\"type\":\"perspective\",\"perspective\":{{\"yfov\":0.5,\"znear\":0.1,\"aspectRatio\":2}}}},\
         {{\"name\":\"side\",\"type\":\"orthographic\",\"orthographic\":{{\"xmag\":1,\"ymag\":1,\"znear\":0,\"zfar\":9}}}}],\
         \"nodes\":[{{\"mesh\":0}},{{\"name\":\"front\",\"camera\":0,\"scale\":[3,3,3],\"translation\":[0,0,4]}},{{\"camera\":1}}]"
    ));
    let first = loaded(&text);
    assert_eq!((first.camera.fov, first.film.size), (0.5, (768, 384)));
    assert_eq!(first.camera.to_world.translation, DVec3::new(0.0, 0.0, 4.0));
    let folder = SceneFolder::new([("a.gltf", &text)]);
    let named = |name| load_with(&folder.path("a.gltf"), Some(name));
    assert_eq!(named("front").expect("there").camera.fov, 0.5);
    let side = named("side").expect("there");
    assert!(side.camera.fov < 0.02);
    assert!(
        side.notes
            .iter()
            .any(|note| note.text.contains("orthographic"))
    );
    let message = named("frnt").expect_err("there is none").to_string();
    assert!(message.contains("did you mean `front`"), "{message}");
}

#[test]
fn unsupported_gltf_features_are_noted() {
    let (builder, [all, _, indices]) = square();
    let scene = builder.load(&format!(
        "\"extensionsUsed\":[\"KHR_materials_sheen\"],\"skins\":[{{\"joints\":[0]}}],\
         \"animations\":[{{\"channels\":[],\"samplers\":[]}}],\
         \"meshes\":[{{\"weights\":[0.5],\"primitives\":[{{\"attributes\":{{\"POSITION\":{all}}},\"indices\":{indices}}}]}}],\
         \"nodes\":[{{\"mesh\":0,\"skin\":0}},{{\"mesh\":0,\"scale\":[0,1,1]}}]"
    ));
    let omitted: Vec<&str> = scene.notes.iter().map(|note| note.text.as_str()).collect();
    for what in [
        "KHR_materials_sheen",
        "1 animations",
        "skins",
        "morph targets",
        "flattened",
    ] {
        assert!(
            omitted.iter().any(|text| text.contains(what)),
            "{what}: {omitted:?}"
        );
    }
    assert!(scene.check_faithful().is_err());
    let unlit = with_material("\"extensions\":{\"KHR_materials_unlit\":{}}", "");
    assert_eq!(unlit.shapes[0].emission, Some(Rgb::WHITE.into()));
    assert!(
        unlit
            .notes
            .iter()
            .any(|note| note.kind == NoteKind::Approximation)
    );
}
