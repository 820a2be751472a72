//! One scene in two formats: Bitterli's Cornell box and Veach's scene in Mitsuba's XML and in pbrt-v4.

use crate::common::scene_folder::SceneFolder;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, MaterialModel, SceneDescription, ShapeDescription,
};
use std::f64::consts::PI;

/// Loads a scene in Mitsuba's format and in pbrt's.
fn both(xml: &str, pbrt: &str) -> [SceneDescription; 2] {
    let folder = SceneFolder::new([("a.xml", xml), ("a.pbrt", pbrt)]);
    ["a.xml", "a.pbrt"].map(|name| folder.load(name))
}

/// The triangles of a shape in the world; none of a sphere.
fn triangles(shape: &ShapeDescription) -> Vec<[DVec3; 3]> {
    let quad = |[a, b, c, d]: [DVec3; 4]| [[a, b, c], [a, c, d]];
    let local: Vec<[DVec3; 3]> = match &shape.geometry {
        GeometryDescription::Mesh(mesh) => {
            let corner = |i: u32| mesh.positions[i as usize];
            mesh.indices.iter().map(|t| t.map(corner)).collect()
        }
        GeometryDescription::Rectangle {
            corner: c,
            edge_u: u,
            edge_v: v,
        } => quad([*c, *c + *u, *c + *u + *v, *c + *v]).to_vec(),
        GeometryDescription::Box { min, max } => {
            let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * (*max - *min));
            let face = |i: usize| {
                let (u, v) = (axes[(i + 1) % 3], axes[(i + 2) % 3]);
                let far = *min + axes[i];
                [
                    quad([*min, *min + v, *min + u + v, *min + u]),
                    quad([far, far + u, far + u + v, far + v]),
                ]
            };
            (0..3).flat_map(face).flatten().collect()
        }
        _ => vec![],
    };
    let mirrored = shape.transform.matrix3.determinant() < 0.0;
    let placed = local
        .into_iter()
        .map(|t| t.map(|p| shape.transform.transform_point3(p)));
    // The outside of an object stays outside when it is mirrored.
    placed
        .map(|[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] })
        .collect()
}

/// The moments of a surface that do not depend on how it is cut: its area and centroid, and the flux of the constant and
/// of the identity vector field, which tell its sides.
fn moments(shape: &ShapeDescription) -> [f64; 8] {
    if let GeometryDescription::Sphere { center, radius } = shape.geometry {
        let radius = radius * shape.transform.matrix3.determinant().abs().cbrt();
        let [x, y, z] = shape.transform.transform_point3(center).to_array();
        let area = 4.0 * PI * radius * radius;
        return [area, x, y, z, 0.0, 0.0, 0.0, area * radius];
    }
    let (mut area, mut centroid, mut flux, mut volume) = (0.0, DVec3::ZERO, DVec3::ZERO, 0.0);
    for [a, b, c] in triangles(shape) {
        let cross = 0.5 * (b - a).cross(c - a);
        area += cross.length();
        centroid += cross.length() * (a + b + c) / 3.0;
        flux += cross;
        volume += cross.dot(a);
    }
    let ([x, y, z], [u, v, w]) = ((centroid / area).to_array(), flux.to_array());
    [area, x, y, z, u, v, w, volume]
}

#[track_caller]
fn near(a: impl AsRef<[f64]>, b: impl AsRef<[f64]>, what: &str) {
    let (a, b) = (a.as_ref(), b.as_ref());
    let size = a.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
    let is_near = a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * size);
    assert!(is_near, "{what}: {a:?} {b:?}");
}

fn channels(colour: &ColourDescription) -> [f64; 3] {
    let colour: Rgb = colour.constant().expect("one colour");
    colour.to_array().map(f64::from)
}

/// The numbers of the material of a shape.
fn material(scene: &SceneDescription, shape: &ShapeDescription) -> Vec<f64> {
    let material = &scene.materials[shape.material];
    assert!(material.two_sided);
    match &material.model {
        MaterialModel::Diffuse { reflectance } => channels(reflectance).to_vec(),
        MaterialModel::Conductor {
            eta, k, roughness, ..
        } => {
            let numbers = [eta.to_array(), k.to_array()].concat();
            numbers
                .iter()
                .chain([roughness])
                .map(|x| f64::from(*x))
                .collect()
        }
        other => panic!("{other:?} is in neither scene"),
    }
}

fn agree([mitsuba, pbrt]: [SceneDescription; 2]) {
    assert_eq!(mitsuba.film, pbrt.film);
    assert_eq!(mitsuba.render.max_bounces, pbrt.render.max_bounces);
    assert_eq!(mitsuba.render.spp, pbrt.render.spp);
    let camera = |scene: &SceneDescription| {
        let pose = scene.camera.to_world.to_cols_array();
        pose.into_iter()
            .chain([scene.camera.fov, scene.camera.lens_radius])
            .collect::<Vec<_>>()
    };
    near(camera(&mitsuba), camera(&pbrt), "camera");
    assert_eq!(mitsuba.shapes.len(), pbrt.shapes.len());
    assert_eq!((mitsuba.lights.len(), pbrt.lights.len()), (0, 0));
    for (a, b) in mitsuba.shapes.iter().zip(&pbrt.shapes) {
        near(moments(a), moments(b), &a.name);
        near(material(&mitsuba, a), material(&pbrt, b), &a.name);
        let emission = |shape: &ShapeDescription| shape.emission.as_ref().map(channels);
        near(
            emission(a).unwrap_or_default(),
            emission(b).unwrap_or_default(),
            &a.name,
        );
        assert_eq!(a.two_sided_emission, b.two_sided_emission);
    }
}

#[test]
fn cornell_box_is_the_same_in_mitsuba_and_pbrt_formats() {
    agree(both(
        include_str!("cornell-box.xml"),
        include_str!("cornell-box.pbrt"),
    ));
}

/// Except that pbrt's conductors have no factor of their reflectance.
#[test]
fn veach_mis_scene_is_the_same_in_mitsuba_and_pbrt_formats() {
    agree(both(
        include_str!("veach-mis.xml"),
        include_str!("veach-mis.pbrt"),
    ));
}
