//! Constructors for scenes built in code: cameras, materials, lights and shapes in one line each.
//!
//! Measure: world units; radiance.
//! Range: that of the scene's description.
//! Source: none needed. Tested through the tests of all modules that use it.

pub mod terrain;

use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DAffine3, DMat3, DVec3};
use etendue::internals::scene::description::{
    CameraDescription, ColourDescription, GeometryDescription, LightDescription, LightModel,
    MaterialDescription, MaterialModel, MeshDescription, Place, SceneDescription, ShapeDescription,
};
use std::sync::Arc;

/// An empty scene with the given name and a pinhole camera whose up vector is y.
pub fn scene(name: &str, eye: DVec3, target: DVec3, fov_degrees: f64) -> SceneDescription {
    let back = (eye - target).normalize_or(DVec3::Z);
    let right = DVec3::Y.cross(back).normalize_or(DVec3::X);
    let to_world = DAffine3 {
        matrix3: DMat3::from_cols(right, back.cross(right), back),
        translation: eye,
    };
    let camera = CameraDescription::pinhole(to_world, fov_degrees.to_radians());
    SceneDescription::new(name, camera)
}

/// A diffuse material with the given name.
pub fn matte(name: &str, reflectance: Rgb) -> MaterialDescription {
    let reflectance = ColourDescription::Constant(reflectance);
    let model = MaterialModel::Diffuse { reflectance };
    MaterialDescription::new(name, Place::default(), model)
}

/// A constant grey colour.
pub fn grey(value: f32) -> ColourDescription {
    ColourDescription::Constant(Rgb::grey(value))
}

/// The Lambertian model.
pub fn diffuse(albedo: f32) -> MaterialModel {
    MaterialModel::Diffuse {
        reflectance: grey(albedo),
    }
}

/// A perfect mirror.
pub fn mirror(reflectance: f32) -> MaterialModel {
    MaterialModel::Mirror {
        reflectance: grey(reflectance),
    }
}

/// Clear glass.
pub fn glass(ior: f32, roughness: f32) -> MaterialModel {
    MaterialModel::Dielectric {
        ior,
        roughness,
        tint: grey(1.0),
    }
}

/// A shape with the given name and the index of its material in the scene.
pub fn named_shape(name: &str, material: usize, geometry: GeometryDescription) -> ShapeDescription {
    ShapeDescription {
        material,
        ..ShapeDescription::new(name, Place::default(), geometry)
    }
}

/// A shape with the scene's first material that emits `radiance`, if positive, on the side of its normal.
pub fn surface(geometry: GeometryDescription, radiance: f32) -> ShapeDescription {
    ShapeDescription {
        emission: (radiance > 0.0).then_some(grey(radiance)),
        ..ShapeDescription::new("shape", Place::default(), geometry)
    }
}

/// The given shape with emission `radiance`.
pub fn emitting(shape: ShapeDescription, radiance: Rgb) -> ShapeDescription {
    ShapeDescription {
        emission: Some(ColourDescription::Constant(radiance)),
        ..shape
    }
}

/// A triangle mesh without normals or texture coordinates.
pub fn mesh(positions: Vec<DVec3>, indices: Vec<[u32; 3]>) -> GeometryDescription {
    GeometryDescription::Mesh(Arc::new(MeshDescription {
        positions,
        indices,
        ..MeshDescription::default()
    }))
}

/// A convex polygon as a fan of triangles.
pub fn polygon(positions: Vec<DVec3>) -> GeometryDescription {
    let indices = (2..positions.len() as u32).map(|i| [0, i - 1, i]).collect();
    mesh(positions, indices)
}

/// The rectangle at `corner` with edges u and v and the normal u x v.
pub fn rectangle(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> GeometryDescription {
    GeometryDescription::Rectangle {
        corner: corner.into(),
        edge_u: u.into(),
        edge_v: v.into(),
    }
}

/// A rectangle at height `z` over [x0, x1] x [y0, y1] whose normal points down.
pub fn ceiling([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> GeometryDescription {
    rectangle([x0, y0, z], [0.0, y1 - y0, 0.0], [x1 - x0, 0.0, 0.0])
}

/// A sphere.
pub fn sphere(center: DVec3, radius: f64) -> GeometryDescription {
    GeometryDescription::Sphere { center, radius }
}

/// A constant environment light.
pub fn sky(radiance: Rgb) -> LightDescription {
    LightDescription::sky(Place::default(), radiance)
}

/// A distant light that shines from the given direction.
pub fn sun(from: DVec3, irradiance: Rgb) -> LightDescription {
    let model = LightModel::Distant {
        direction: -from,
        irradiance,
    };
    let place = Place::default();
    LightDescription { place, model }
}

/// A light that is not a shape.
pub fn light(model: LightModel) -> LightDescription {
    LightDescription {
        place: Place::default(),
        model,
    }
}
