//! Builds a scene in code: a mesh, a sphere of glass, a lamp, and a group that is placed twice; then moves the camera, which
//! builds nothing anew.
//!
//! `cargo run --release --example build_in_code` writes before.png and after.png.

use etendue::description::{
    CameraDescription, GeometryDescription, InstanceDescription, LightDescription,
    MaterialDescription, MaterialModel, MeshDescription, Place, SceneDescription, ShapeDescription,
};
use etendue::vec::{DAffine3, DVec3};
use etendue::{
    NullRenderObserver, RenderOptions, Result, Rgb, Session, WriteOptions, tracing, write,
};
use std::path::Path;
use std::sync::Arc;

fn main() -> Result<()> {
    let mut session = Session::new(scene()?, tracing())?;
    picture(&session, "before.png")?;
    let eye = DVec3::new(3.0, 2.0, 4.0);
    session.set_camera(camera(eye)?)?;
    picture(&session, "after.png")?;
    let work = session.work();
    println!(
        "built {} times; the camera took {:?}",
        work.builds, work.last
    );
    Ok(())
}

fn picture(session: &Session, file: &str) -> Result<()> {
    let rendering = session.render(&RenderOptions::samples(64), &NullRenderObserver)?;
    write(
        Path::new(file),
        &rendering.image(),
        &WriteOptions::default(),
    )
}

fn camera(eye: DVec3) -> Result<CameraDescription> {
    let target = DVec3::new(0.0, 0.7, 0.0);
    CameraDescription::look_at(eye, target, DVec3::Y, 40.0_f64.to_radians())
}

/// The place of an object that was made in code: none in any file.
fn nowhere() -> Place {
    Place::default()
}

fn scene() -> Result<SceneDescription> {
    let mut scene = SceneDescription::new("in code", camera(DVec3::new(0.0, 1.5, 5.0))?);
    scene.film.size = (320, 240);

    let reflectance = Rgb::new(0.7, 0.6, 0.5).into();
    let clay = MaterialModel::Diffuse { reflectance };
    let clay = scene.add_material(MaterialDescription::new("clay", nowhere(), clay))?;
    let glass = MaterialModel::Dielectric {
        ior: 1.5,
        roughness: 0.0,
        tint: Rgb::WHITE.into(),
    };
    let glass = scene.add_material(MaterialDescription::new("glass", nowhere(), glass))?;

    let floor = MeshDescription {
        positions: [[-4.0, 4.0], [4.0, 4.0], [4.0, -4.0], [-4.0, -4.0]]
            .map(|[x, z]| DVec3::new(x, 0.0, z))
            .to_vec(),
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshDescription::default()
    };
    let floor = GeometryDescription::Mesh(Arc::new(floor));
    scene.add_shape(ShapeDescription {
        material: clay,
        ..ShapeDescription::new("floor", nowhere(), floor)
    })?;

    let ball = GeometryDescription::Sphere {
        center: DVec3::new(0.0, 0.6, 0.0),
        radius: 0.6,
    };
    let group = scene.add_group("ball");
    scene.add_shape(ShapeDescription {
        material: glass,
        group: Some(group),
        ..ShapeDescription::new("ball", nowhere(), ball)
    })?;
    for x in [-0.9, 0.9] {
        scene.add_instance(InstanceDescription {
            name: format!("ball at {x}"),
            place: nowhere(),
            of: group,
            group: None,
            transform: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)),
            motion: vec![],
        })?;
    }

    let lamp = GeometryDescription::Disk {
        center: DVec3::new(1.0, 4.0, 2.0),
        normal: -DVec3::Y,
        radius: 0.5,
    };
    scene.add_shape(ShapeDescription {
        emission: Some(Rgb::grey(30.0).into()),
        ..ShapeDescription::new("lamp", nowhere(), lamp)
    })?;
    scene.add_light(LightDescription::sky(nowhere(), Rgb::new(0.2, 0.25, 0.3)))?;
    Ok(scene)
}
