//! Scenes in the formats of other programs, given to each verb that takes a scene.

use crate::common::scene_folder::SceneFolder;
use crate::convert::assert_converts_bit_identically;
use crate::support::{measured, succeed};

/// A room of Mitsuba of 24 x 16 pixels: a floor, a ball of glass, a lamp and a sky.
pub const MITSUBA: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="45"/>
        <transform name="to_world">
            <lookat origin="0, 1, 5" target="0, 0.5, 0" up="0, 1, 0"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="24"/>
            <integer name="height" value="16"/>
        </film>
        <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="4"/>
            <rotate x="1" angle="-90"/>
        </transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.4, 0.3"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="-0.8" y="0.6" z="0"/>
        <float name="radius" value="0.6"/>
        <bsdf type="dielectric"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="0.4"/>
            <rotate x="1" angle="90"/>
            <translate x="1" y="3" z="1"/>
        </transform>
        <emitter type="area"><rgb name="radiance" value="12, 11, 10"/></emitter>
    </shape>
    <emitter type="constant"><rgb name="radiance" value="0.1, 0.12, 0.15"/></emitter>
</scene>
"#;

/// A floor and a lamp of pbrt.
const PBRT: &str = r#"LookAt 0 1 5  0 0.5 0  0 1 0
Camera "perspective" "float fov" 45
Film "rgb" "integer xresolution" 24 "integer yresolution" 16
Sampler "independent" "integer pixelsamples" 4
WorldBegin
LightSource "infinite" "rgb L" [0.1 0.12 0.15]
Material "diffuse" "rgb reflectance" [0.5 0.4 0.3]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
    "point3 P" [-4 0 4  4 0 4  4 0 -4  -4 0 -4]
AttributeBegin
    AreaLightSource "diffuse" "rgb L" [12 11 10]
    Translate 1 3 1
    Rotate 90 1 0 0
    Shape "disk" "float radius" 0.4
AttributeEnd
"#;

/// A square in glTF: four corners and six indices.
const GLTF: &str = r#"{
    "asset": { "version": "2.0" },
    "scenes": [{ "nodes": [0] }],
    "nodes": [{ "mesh": 0 }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1] },
        { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" }
    ],
    "bufferViews": [
        { "buffer": 0, "byteLength": 48 },
        { "buffer": 0, "byteOffset": 48, "byteLength": 12 }
    ],
    "buffers": [{
        "byteLength": 60,
        "uri": "data:application/octet-stream;base64,AACAvwAAAAAAAIA/AACAPwAAAAAAAIA/AACAPwAAAAAAAIC/AACAvwAAAAAAAIC/AAABAAIAAAACAAMA"
    }]
}
"#;

/// A triangle as PLY.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// A folder with a scene of each format.
fn folder() -> SceneFolder {
    SceneFolder::new([
        ("room.xml", MITSUBA),
        ("room.pbrt", PBRT),
        ("model.gltf", GLTF),
        ("model.ply", PLY),
    ])
}

#[test]
fn each_format_renders_as_its_converted_scene_does() {
    let folder = folder();
    for scene in ["room.xml", "room.pbrt", "model.gltf", "model.ply"] {
        let plan = succeed(&folder, &format!("plan {scene} --size 24x16"));
        assert!(plan.stdout.contains("kernel"), "{scene}: {}", plan.stdout);
        assert_converts_bit_identically(&folder, scene);
    }
}

#[test]
fn verbs_that_measure_take_scenes_of_each_format() {
    let folder = folder();
    let price = measured(&folder, "price room.pbrt -q", |_| false);
    assert!(price.stdout.contains("10 %"), "{}", price.stdout);
    measured(&folder, "study room.xml -q -o study", |_| false);
    assert!(folder.path("study/study.md").exists());
    for scene in ["model.gltf", "model.ply"] {
        let little = "--rays 256 --compare 1000 --segments 1000 --render-time 0.01s -q";
        succeed(&folder, &format!("bench {scene} {little} -o bench-{scene}"));
        let report = std::fs::read_to_string(folder.path(&format!("bench-{scene}/bench.json")));
        assert!(report.expect("a report").contains(scene), "{scene}");
    }
}
