//! The handedness of pbrt's world: what is seen is that of scenes of our own, bit by bit.

use super::{HEAD, file, world};
use crate::common::scene_folder::{load_text, picture};
use etendue::internals::math::transform::is_rotation;
use etendue::internals::math::vec::{DMat3, DVec3};
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::description::{GeometryDescription, LightModel, SceneDescription};

/// Options of a small image.
const OPTIONS: &str = r#"
Film "rgb" "integer xresolution" 24 "integer yresolution" 16
PixelFilter "gaussian"
Sampler "independent" "integer pixelsamples" 4
Integrator "path" "integer maxdepth" 4
"#;

/// A world without symmetry, with `$` for the sign of x.
const WORLD: &str = r#"
WorldBegin
AttributeBegin
  Translate $2 3 1
  AreaLightSource "diffuse" "rgb L" [ 12 11 10 ]
  Shape "sphere" "float radius" 0.5
AttributeEnd
LightSource "spot" "point3 from" [ $-2 2 2 ] "point3 to" [ $-0.5 0 0 ] "rgb I" [ 9 3 1 ]
  "float coneangle" 40 "float conedeltaangle" 10
Texture "checks" "spectrum" "checkerboard" "float uscale" 4 "float vscale" 2
  "rgb tex1" [ 0.8 0.7 0.1 ] "rgb tex2" [ 0.1 0.1 0.5 ]
Material "diffuse" "texture reflectance" "checks"
Shape "trianglemesh" "point3 P" [ $-3 -1 2  $3 -1 2  $3 -1 -4  $-3 -1 -4 ]
  "point2 uv" [ 0 0 1 0 1 1 0 1 ] "integer indices" [ 0 1 2 0 2 3 ]
Material "dielectric" "float eta" 1.5
Shape "trianglemesh" "point3 P" [ $0 0 1  $1 0 0  $0 1 0  $-1 0 0 ]
  "integer indices" [ 0 1 2  0 2 3  1 3 2  0 3 1 ]
"#;

/// The scene of our own that shows what `WORLD` does in a right-handed world.
const OURS: &str = r#"
version = 1
[camera]
eye = [0, 0.5, 5]
target = [0, 0.5, 0]
fov = 45
[film]
size = [24, 16]
[render]
integrator = "path"
sampler = "independent"
spp = 4
max_bounces = 4
[[material]]
name = "grey"
type = "diffuse"
reflectance = 0.5
[[material]]
name = "checks"
type = "diffuse"
reflectance = { checker = [[0.8, 0.7, 0.1], [0.1, 0.1, 0.5]], repeat = [4, 2] }
[[material]]
name = "glass"
type = "dielectric"
[[shape]]
type = "sphere"
material = "grey"
center = [0, 0, 0]
radius = 0.5
transform = [{ translate = [2, 3, 1] }]
emission = [12, 11, 10]
[[shape]]
type = "mesh"
material = "checks"
positions = [[-3, -1, 2], [3, -1, 2], [3, -1, -4], [-3, -1, -4]]
uvs = [[0, 0], [1, 0], [1, 1], [0, 1]]
indices = [[0, 1, 2], [0, 2, 3]]
[[shape]]
type = "mesh"
material = "glass"
positions = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]]
indices = [[0, 1, 2], [0, 2, 3], [1, 3, 2], [0, 3, 1]]
[[light]]
type = "spot"
position = [-2, 2, 2]
target = [-0.5, 0, 0]
intensity = [9, 3, 1]
cone = 40
penumbra = 10
"#;

fn pixels(scene: &SceneDescription) -> Vec<[f32; 3]> {
    let settings = RenderSettings::of_scene(scene).expect("valid");
    let image = picture(scene, &settings);
    image
        .pixels()
        .iter()
        .map(|pixel| pixel.to_array())
        .collect()
}

#[test]
fn right_and_left_handed_pbrt_worlds_match_the_native_scene() {
    let expected = pixels(&load_text(OURS));
    assert!(expected.iter().any(|pixel| pixel[0] > 0.0));
    let view = "LookAt 0 0.5 5  0 0.5 0  0 1 0\nCamera \"perspective\" \"float fov\" 45\n";
    let right = format!("Scale -1 1 1\n{view}{OPTIONS}{}", WORLD.replace('$', ""));
    assert_eq!(pixels(&file(&right)), expected);

    // A left-handed world in which every x has the other sign. A mirrored tetrahedron has its corners in the other order.
    let negated = |text: &str| text.replace("$-", "").replace('$', "-");
    let order = |text: String| {
        text.replace(
            "[ 0 1 2  0 2 3  1 3 2  0 3 1 ]",
            "[ 0 2 1  0 3 2  1 2 3  0 1 3 ]",
        )
    };
    let left = file(&format!("{view}{OPTIONS}{}", order(negated(WORLD))));
    assert_eq!(
        left.shapes[0].transform.translation,
        DVec3::new(2.0, 3.0, 1.0)
    );
    let found = pixels(&left);
    let brightness = |pixels: &[[f32; 3]]| pixels.iter().map(|p| f64::from(p[0])).sum::<f64>();
    // Its glass begins with another corner, so that only rounding and the choice of points on triangles may differ.
    let (a, b) = (brightness(&found), brightness(&expected));
    assert!((a - b).abs() < 1e-4 * b, "{a} {b}");
}

#[test]
fn area_light_side_follows_the_object_under_mirroring() {
    let emitter = "AreaLightSource \"diffuse\"\n";
    let triangle = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]";
    let faces = |text: &str| {
        let scene = world(&format!("{text}{emitter}{triangle}"));
        let shape = &scene.shapes[0];
        let GeometryDescription::Mesh(mesh) = &shape.geometry else {
            panic!("no mesh");
        };
        let [a, b, c] = mesh.indices[0].map(|i| mesh.positions[i as usize]);
        // As `prepare` does, the outside of the object stays outside when it is mirrored.
        let normal = shape.transform.matrix3.inverse().transpose() * (b - a).cross(c - a);
        normal.z > 0.0
    };
    assert!(faces(""));
    assert!(!faces("ReverseOrientation\n"));
    assert!(faces("Scale -1 1 1\n"));
    assert!(!faces("Scale 1 1 -1\n"));
    assert!(faces("ReverseOrientation\nScale 1 1 -1\n"));
}

#[test]
fn mesh_normals_determine_triangle_winding() {
    let triangle = |more: &str| {
        let scene = world(&format!(
            "{more}Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"normal N\" [ 0 0 -1 0 0 -1 0 0 -1 ]"
        ));
        let GeometryDescription::Mesh(mesh) = &scene.shapes[0].geometry else {
            panic!("no mesh");
        };
        (mesh.indices[0], mesh.normals[0].z)
    };
    assert_eq!(triangle(""), ([0, 2, 1], -1.0));
    assert_eq!(triangle("ReverseOrientation\n"), ([0, 1, 2], 1.0));
}

#[test]
fn camera_pose_fov_and_lens_follow_transform_and_film() {
    let scene = file(&format!("{HEAD}Shape \"sphere\""));
    let camera = &scene.camera;
    assert!(camera.to_world.matrix3.abs_diff_eq(DMat3::IDENTITY, 1e-12));
    assert!(
        camera
            .to_world
            .translation
            .abs_diff_eq(DVec3::new(0.0, 0.0, 5.0), 1e-12)
    );
    assert!(is_rotation(&camera.to_world.matrix3));
    assert!((camera.fov - 90f64.to_radians()).abs() < 1e-12);

    // The field of view is of the shorter side; a scale of the camera's space scales its lens.
    let text = "Scale -0.5 0.5 0.5\nTranslate 0 0 -4\n\
                Film \"rgb\" \"integer xresolution\" 100 \"integer yresolution\" 200\n\
                Camera \"perspective\" \"float fov\" 60 \"float lensradius\" 0.1 \"float focaldistance\" 3\nWorldBegin";
    let camera = file(text).camera;
    let expected = 2.0 * (2.0 * 30f64.to_radians().tan()).atan();
    assert!((camera.fov - expected).abs() < 1e-12);
    assert!(
        (camera.lens_radius - 0.2).abs() < 1e-12 && (camera.focus_distance - 6.0).abs() < 1e-12
    );
    let window = text.replace(
        "\"float fov\"",
        "\"float screenwindow\" [ -0.5 0.5 -1 1 ] \"float fov\"",
    );
    let expected = 2.0 * 30f64.to_radians().tan().atan();
    assert!((file(&window).camera.fov - expected).abs() < 1e-12);
}

#[test]
fn point_and_distant_lights_are_placed_in_mirrored_world() {
    let text = "LookAt 0 0 5  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\nTranslate 1 2 3\n\
                LightSource \"point\" \"point3 from\" [ 1 0 0 ]\n\
                LightSource \"distant\" \"point3 from\" [ 1 1 0 ] \"point3 to\" [ 0 0 0 ]\n";
    let scene = file(text);
    let LightModel::Point { position, .. } = &scene.lights[0].model else {
        panic!("no point light");
    };
    assert_eq!(*position, DVec3::new(-2.0, 2.0, 3.0));
    let LightModel::Distant { direction, .. } = &scene.lights[1].model else {
        panic!("no distant light");
    };
    assert_eq!(*direction, DVec3::new(1.0, -1.0, 0.0));
}
