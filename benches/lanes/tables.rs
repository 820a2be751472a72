//! Scene data for the stages: triangles, reflectances, the light and the camera.

use crate::SIZE;
use crate::light::Light;
use etendue::internals::accel::Accel;
use etendue::internals::accel::embree::EmbreeAccel;
use etendue::internals::effects::kernel::types::Matte;
use etendue::internals::geometry::Geometry;
use etendue::internals::math::vec::{LaneVec3 as Vec3, Vec2};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{ColourDescription, MaterialModel, SceneDescription};

/// The scene's triangles, reflectances, light and camera.
pub struct Tables<'a> {
    pub accel: &'a EmbreeAccel,
    pub triangles: Vec<[[f32; 3]; 3]>,
    /// The index of the first triangle of each shape.
    pub first: Vec<u32>,
    pub reflectance: Vec<[f32; 3]>,
    pub is_light: Vec<f32>,
    pub light: Light,
    pub camera: Camera,
}

/// A pinhole camera.
pub struct Camera {
    pub eye: Vec3,
    /// The direction to the upper left corner, and the steps to the next pixel, at viewing depth 1.
    pub corner: Vec3,
    pub steps: [Vec3; 2],
}

impl Camera {
    pub fn new(scene: &Scene) -> Self {
        let ray = |x: f32, y: f32| {
            let film = SIZE as f32 * Vec2::new(x, y);
            let ray = scene.camera.ray::<Matte>(film, Vec2::ZERO, 0.0);
            [ray.origin, ray.dir].map(|v| Vec3::from(v.to_array()))
        };
        let [eye, axis] = ray(0.5, 0.5);
        let [corner, right, below] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| {
            let [_, dir] = ray(x, y);
            dir / dir.dot(axis)
        });
        Self {
            eye,
            corner,
            steps: [right, below].map(|dir| (dir - corner) / SIZE as f32),
        }
    }
}

pub fn constant(colour: &ColourDescription) -> [f32; 3] {
    let colour = colour.constant().expect("a constant colour");
    colour.to_array()
}

impl<'a> Tables<'a> {
    pub fn new(description: &SceneDescription, scene: &'a Scene) -> Self {
        let Accel::Embree(accel) = &*scene.accel else {
            panic!("the preferred backend is Embree");
        };
        let (mut triangles, mut first) = (Vec::new(), Vec::new());
        let (mut reflectance, mut is_light, mut light) = (Vec::new(), Vec::new(), None);
        for (geometry, shape) in scene.world.geometries().iter().zip(&description.shapes) {
            let Geometry::Mesh(mesh) = geometry else {
                panic!("{} is not a mesh", shape.name);
            };
            let mesh_build_memory = 0..mesh.indices().len() as u32;
            first.push(triangles.len() as u32);
            triangles.extend(mesh_build_memory.map(|t| mesh.triangle(t).map(|v| v.to_array())));
            let model = &description.materials[shape.material].model;
            let MaterialModel::Diffuse {
                reflectance: of_shape,
            } = model
            else {
                panic!("{} is not diffuse", shape.name);
            };
            reflectance.push(constant(of_shape));
            is_light.push(if shape.emission.is_some() { 1.0 } else { 0.0 });
            if let Some(emission) = &shape.emission {
                let corners = mesh.triangle(0).map(|v| Vec3::from(v.to_array()));
                light = Some(Light::new(corners, Vec3::from(constant(emission))));
            }
        }
        Self {
            accel,
            triangles,
            first,
            reflectance,
            is_light,
            light: light.expect("a light"),
            camera: Camera::new(scene),
        }
    }
}
