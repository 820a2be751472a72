//! Hard case 17: shading normals far from the geometric normal, on its other side, and of zero length. No surface reflects
//! more than arrives, and no light leaks through it. The albedo of a diffuse one is row 17 of the battery.

use crate::common::scene::{diffuse, patch_scene, see, sky, surface};
use etendue::internals::accel::Backend;
use etendue::internals::integrator::Roulette;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{
    ColourDescription, GeometryDescription, MaterialModel, MeshDescription, SceneDescription,
};
use std::sync::Arc;

/// The tilt of the shading normal, towards x.
const TILT: f64 = 60.0_f64.to_radians();

fn tilted(angle: f64) -> DVec3 {
    DVec3::new(angle.sin(), 0.0, angle.cos())
}

/// A triangle around the origin in z = 0, facing up, with this shading normal, seen from the direction `wo`.
fn plane(model: MaterialModel, normal: DVec3, wo: DVec3) -> SceneDescription {
    let mut scene = patch_scene(3.0 * wo, DVec3::ZERO, model);
    let corners = [(-3.0, -3.0), (3.0, -3.0), (0.0, 4.0)];
    let mesh = MeshDescription {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        normals: vec![normal; 3],
        uvs: vec![],
        indices: vec![[0, 1, 2]],
    };
    scene.shapes = vec![surface(GeometryDescription::Mesh(Arc::new(mesh)), 0.0)];
    scene
}

/// White materials of every opaque kind, and glass.
fn white_models() -> Vec<(&'static str, MaterialModel)> {
    let grey = |value: f32| ColourDescription::Constant(Rgb::grey(value));
    let principled = |metallic: f32, transmission: f32| MaterialModel::Principled {
        base_color: grey(1.0),
        metallic,
        roughness: 0.5,
        ior: 1.5,
        transmission,
    };
    let dielectric = |roughness: f32| MaterialModel::Dielectric {
        ior: 1.5,
        roughness,
        tint: grey(1.0),
    };
    vec![
        ("diffuse", diffuse(1.0)),
        (
            "mirror",
            MaterialModel::Mirror {
                reflectance: grey(1.0),
            },
        ),
        (
            "metal",
            MaterialModel::Conductor {
                eta: Rgb::WHITE,
                k: Rgb::grey(1e6),
                roughness: 0.6,
                tint: Rgb::WHITE,
            },
        ),
        (
            "phong",
            MaterialModel::Phong {
                diffuse: grey(0.5),
                specular: grey(0.5),
                exponent: 20.0,
            },
        ),
        (
            "plastic",
            MaterialModel::Plastic {
                reflectance: grey(1.0),
                ior: 1.5,
                roughness: 0.3,
            },
        ),
        ("principled", principled(0.5, 0.0)),
        ("frosted", principled(0.0, 0.5)),
        ("glass", dielectric(0.0)),
        ("rough glass", dielectric(0.6)),
    ]
}

#[test]
fn white_materials_gain_no_energy_with_bent_shading_normals() {
    let views = [0.0, 0.7, 1.5, -0.7, -1.5].map(tilted);
    let normals = [tilted(TILT), -tilted(TILT), DVec3::ZERO, -DVec3::Z];
    for (name, model) in white_models() {
        for (wo, normal) in views.iter().flat_map(|&wo| normals.map(|n| (wo, n))) {
            for wo in [wo, -wo] {
                let mut scene = plane(model.clone(), normal, wo);
                scene.lights = vec![sky(Rgb::WHITE)];
                let seen = see(&scene, Backend::ALL[0], 1 << 9, Some(1), Roulette::None);
                let error = seen.standard_error().expect("32 pixels");
                // Refraction into the denser side scales radiance by n^2, and the tables have an error of 0.25 %.
                let through = matches!(name, "frosted" | "glass" | "rough glass");
                let most = if through && wo.z < 0.0 { 2.25 } else { 1.0025 };
                let what = format!("{name} {wo} {normal}: {} +- {error:.1e}", seen.mean());
                // With a corrected normal a mirror reflects along the surface: rounding decides which directions are
                // below it.
                assert!(error <= 1e-2, "{what}");
                assert!(seen.mean() <= most + 5.2 * error, "{what}");
            }
        }
    }
}

#[test]
fn opaque_materials_leak_no_light_with_bent_shading_normals() {
    for (name, model) in white_models() {
        if matches!(name, "frosted" | "glass" | "rough glass") {
            continue;
        }
        for normal in [tilted(TILT), -tilted(TILT), DVec3::ZERO] {
            for wo in [0.3, 1.0, 1.5, -1.0, -1.5].map(tilted) {
                // Lamps on the other side of the surface.
                let mut scene = plane(model.clone(), normal, wo);
                for direction in [-tilted(0.0), -tilted(1.2), -tilted(-1.2)] {
                    let center = 2.0 * direction;
                    let radius = 0.5;
                    scene
                        .shapes
                        .push(surface(GeometryDescription::Sphere { center, radius }, 1.0));
                }
                for &backend in Backend::ALL {
                    let seen = see(&scene, backend, 256, None, Roulette::Throughput);
                    assert_eq!(seen.mean(), 0.0, "{name} {normal} {wo}");
                }
            }
        }
    }
}
