//! Materials in whole renders: alpha, normal and bump maps, and one-sided surfaces.

use crate::common::closed_forms::parallel_rectangle;
use crate::common::nightly::backends;
use crate::common::scene::{diffuse, patch_scene, ready, rectangle, see, sky, surface};
use crate::common::verdict::assert_mean;
use etendue::internals::accel::Backend;
use etendue::internals::effects::kernel::types::Everything;
use etendue::internals::effects::{Effect, EffectSet};
use etendue::internals::geometry::texture::Texture;
use etendue::internals::image::Image;
use etendue::internals::integrator::Roulette;
use etendue::internals::math::ray::Ray;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DVec2, DVec3, ONE_MINUS_EPSILON, Vec2, Vec3};
use etendue::internals::scene::description::{
    BumpMapDescription, ColourDescription, GeometryDescription, MaterialDescription, MaterialModel,
    MeshDescription, NormalMapDescription, Place, SceneDescription, ShapeDescription,
};
use etendue::internals::scene::material::Material;
use std::f64::consts::TAU;
use std::sync::Arc;

const ALBEDO: f32 = 0.5;

fn grey(value: f32) -> ColourDescription {
    ColourDescription::Constant(Rgb::grey(value))
}

fn checker(colours: [f32; 2], repeat: Vec2) -> Arc<Texture> {
    let colours = colours.map(Rgb::grey);
    Arc::new(Texture::Checker { colours, repeat })
}

/// A black material with this alpha.
fn partly_there(alpha: ColourDescription) -> MaterialDescription {
    MaterialDescription {
        alpha,
        ..MaterialDescription::new("veil", Place::default(), diffuse(0.0))
    }
}

/// The square of half width 1 at height z, facing up, of the scene's material number `material`.
fn square(z: f64, material: usize) -> ShapeDescription {
    let form = rectangle([-1.0, -1.0, z], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    ShapeDescription {
        material,
        ..surface(form, 0.0)
    }
}

/// A floor at z = 0 of radiance 1, seen from straight above through squares of the material `veil`.
fn glowing_floor(veil: MaterialDescription, heights: &[f64]) -> SceneDescription {
    let eye = DVec3::new(0.1, 0.2, 3.0);
    let mut scene = patch_scene(eye, DVec3::new(0.1, 0.2, 0.0), diffuse(0.0));
    scene.materials.push(veil);
    let emission = Some(grey(1.0));
    let floor = ShapeDescription {
        emission,
        ..square(0.0, 0)
    };
    scene.shapes = vec![floor];
    scene.shapes.extend(heights.iter().map(|&z| square(z, 1)));
    scene
}

/// A surface with alpha is composited over what is behind it.
#[test]
fn alpha_composites_over_the_background() {
    for alpha in [0.25, 0.5, 0.9] {
        for &backend in backends(&alpha.to_string()) {
            let scene = glowing_floor(partly_there(grey(alpha)), &[1.0]);
            let seen = see(&scene, backend, 1 << 12, Some(0), Roulette::None);
            let exact = 1.0 - f64::from(alpha);
            assert_mean(&format!("veil of {alpha}"), &seen, exact, 1e-2);

            // The veil's emission and the floor's.
            let mut bright = scene;
            bright.shapes[1].emission = Some(grey(3.0));
            let seen = see(&bright, backend, 1 << 12, Some(0), Roulette::None);
            assert_mean(
                &format!("bright veil of {alpha}"),
                &seen,
                exact + 3.0 * f64::from(alpha),
                1e-2,
            );
        }
    }
    let heights: Vec<f64> = (1..=30).map(|i| 0.05 * f64::from(i)).collect();
    let stack = glowing_floor(partly_there(grey(0.1)), &heights);
    for &backend in backends("30 veils") {
        let seen = see(&stack, backend, 1 << 14, Some(0), Roulette::None);
        let exact = (1.0 - f64::from(0.1_f32)).powi(30);
        assert_mean("30 veils", &seen, exact, 1e-2);
    }
}

/// A sphere of alpha a transmits the share (1 - a)^2; of its emission, which is on the outside only, that of the front is
/// seen.
#[test]
fn alpha_sphere_attenuates_twice_and_emits_once() {
    for &backend in Backend::ALL {
        let alpha = 0.3_f32;
        let exact = 1.0 - f64::from(alpha);
        for (radiance, expected) in [(0.0, exact * exact), (2.0, exact * exact + 0.6)] {
            let mut scene = glowing_floor(partly_there(grey(alpha)), &[]);
            let sphere = GeometryDescription::Sphere {
                center: DVec3::new(0.0, 0.0, 1.0),
                radius: 0.5,
            };
            scene.shapes.push(ShapeDescription {
                material: 1,
                ..surface(sphere, radiance)
            });
            let seen = see(&scene, backend, 1 << 12, Some(0), Roulette::None);
            assert_mean(
                &format!("veiled sphere of {radiance}"),
                &seen,
                expected,
                1e-2,
            );
        }
    }
}

#[test]
fn shadow_ray_transmittance_through_alpha_is_exact() {
    for &backend in Backend::ALL {
        let heights: Vec<f64> = (1..=30).map(|i| 0.05 * f64::from(i)).collect();
        for (alpha, heights) in [(0.25_f32, &heights[..1]), (0.1, &heights[..])] {
            let scene = ready(&glowing_floor(partly_there(grey(alpha)), heights), backend);
            let middle = |z: f64| scene.normalisation.point(DVec3::new(0.1, 0.2, z));
            let ray = Ray::between(middle(0.01), middle(2.0));
            let visible = scene.visibility::<Everything>(&ray, 0.0);
            let expected = (0..heights.len()).fold(1.0, |v, _| v * (1.0 - alpha));
            assert_eq!(visible, expected, "{} veils of {alpha}", heights.len());
        }

        // Also for light that is sampled by NEE and by the BSDF: a floor under a lamp, with a veil between.
        let eye = DVec3::new(0.3, 0.2, 0.4);
        let mut scene = patch_scene(eye, DVec3::ZERO, diffuse(ALBEDO));
        let alpha = 0.75_f32;
        scene.materials.push(partly_there(grey(alpha)));
        let lamp = rectangle([-1.0, -1.0, 1.5], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]);
        let mut veil = square(1.0, 1);
        veil.geometry = rectangle([-4.0, -4.0, 1.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
        scene.shapes = vec![square(0.0, 0), veil, surface(lamp, 1.0)];
        let factor = 4.0 * parallel_rectangle(1.0, 1.0, 1.5);
        let exact = f64::from(ALBEDO) * factor * f64::from(1.0 - alpha);
        let seen = see(&scene, backend, 1 << 14, Some(1), Roulette::None);
        assert_mean("lamp behind a veil", &seen, exact, 2e-3);
    }
}

#[test]
fn binary_alpha_cutouts_are_opaque_or_invisible() {
    // Checker fields of half the square's edge: the view ray hits the one at u, v = 0.55, 0.6.
    for (colours, expected) in [([1.0, 0.0], 0.0), ([0.0, 1.0], 1.0)] {
        let alpha = ColourDescription::Texture(checker(colours, Vec2::splat(2.0)));
        for &backend in Backend::ALL {
            let description = glowing_floor(partly_there(alpha.clone()), &[1.0]);
            let seen = see(&description, backend, 64, Some(0), Roulette::None);
            assert_eq!((seen.mean(), seen.variance()), (expected, Some(0.0)));
            let scene = ready(&description, backend);
            let at = |x: f64, z: f64| scene.normalisation.point(DVec3::new(x, 0.2, z));
            let visible = |x: f64| {
                let ray = Ray::between(at(x, 0.5), at(x, 2.0));
                f64::from(scene.visibility::<Everything>(&ray, 0.0))
            };
            assert_eq!([visible(0.1), visible(-0.1)], [expected, 1.0 - expected]);
        }
    }
}

/// The light of an emitter is scaled by its alpha, whether sampled by NEE or by the BSDF.
#[test]
fn emission_is_scaled_by_alpha() {
    let lit = |alpha: ColourDescription, lamp| {
        let mut scene = patch_scene(
            DVec3::new(0.3, 0.2, 2.4),
            DVec3::new(0.1, 0.3, 0.0),
            diffuse(ALBEDO),
        );
        scene.materials.push(partly_there(alpha));
        let lamp = ShapeDescription {
            material: 1,
            ..surface(lamp, 1.0)
        };
        scene.shapes = vec![square(0.0, 0), lamp];
        see(&scene, Backend::ALL[0], 1 << 11, Some(1), Roulette::None)
    };
    let lamps = [
        rectangle([-1.0, -1.0, 1.5], [0.0, 0.5, 0.0], [2.0, 0.0, 0.0]),
        GeometryDescription::Sphere {
            center: DVec3::new(0.5, 0.5, 1.5),
            radius: 0.3,
        },
    ];
    for lamp in lamps {
        let whole = lit(grey(1.0), lamp.clone());
        let half = lit(grey(0.25), lamp.clone());
        // Behind the near side of a sphere a ray hits the far side from the inside, which does not emit.
        assert_mean("a quarter of a lamp", &half, 0.25 * whole.mean(), 3e-3);
        let fields = checker([1.0, 0.0], Vec2::new(64.0, 64.0));
        let cut = lit(ColourDescription::Texture(fields), lamp);
        assert_mean("a lamp with holes", &cut, 0.5 * whole.mean(), 1e-2);
    }
}

#[test]
fn zero_alpha_surfaces_do_not_change_the_image() {
    for &backend in Backend::ALL {
        let eye = DVec3::new(0.3, 0.2, 2.4);
        // Not on the diagonal, where either of two triangles may be hit.
        let target = DVec3::new(0.1, 0.3, 0.0);
        let mut without = patch_scene(eye, target, diffuse(ALBEDO));
        let lamp = rectangle([-1.0, -1.0, 1.5], [0.0, 0.5, 0.0], [2.0, 0.0, 0.0]);
        without.shapes = vec![square(0.0, 0), surface(lamp, 1.0)];
        // The scene's coordinates are normalised about the middle of most shapes: these shapes keep it in place.
        without.shapes.extend(vec![square(-0.5, 0); 9]);
        let mut with = without.clone();
        with.materials.push(partly_there(grey(0.0)));
        with.shapes.extend([square(0.5, 1), square(1.0, 1)]);
        let [a, b] = [&without, &with].map(|scene| {
            let seen = see(scene, backend, 256, Some(3), Roulette::Throughput);
            (seen.mean(), seen.variance())
        });
        assert!(a.0 > 0.0);
        assert_eq!(a, b);
    }
}

/// The largest random number, rescaled behind a veil, may round to 1; an opaque surface is hit nevertheless.
#[test]
fn largest_random_number_does_not_pass_opaque_surfaces() {
    let u = ONE_MINUS_EPSILON;
    let alphas = (1..200).map(|k| k as f32 * 2.0_f32.powi(-27));
    let rounds_up = |alpha: &f32| {
        let alpha = Rgb::grey(*alpha).luminance();
        (u - alpha) / (1.0 - alpha) >= 1.0
    };
    let alphas: Vec<f32> = alphas.filter(rounds_up).step_by(10).collect();
    assert!(!alphas.is_empty());
    for alpha in alphas {
        let mut description = glowing_floor(partly_there(grey(alpha)), &[2.0, 1.0]);
        let here = checker([1.0, 0.0], Vec2::splat(2.0));
        let cut_out = partly_there(ColourDescription::Texture(here));
        description.materials.push(cut_out);
        description.shapes[2].material = 2;
        for &backend in Backend::ALL {
            let scene = ready(&description, backend);
            let at = |z: f64| scene.normalisation.point(DVec3::new(0.1, 0.2, z));
            let ray = Ray::between(at(2.5), at(-1.0));
            let met = scene.intersect::<Everything>(&ray, 0.0, None, u);
            assert_eq!(met.map(|at| at.id.shape), Some(2), "{alpha:e}");
        }
    }
}

/// Alpha that is 1 everywhere and a normal map without tilt require no effects of a kernel.
#[test]
fn no_op_material_features_require_no_effects() {
    let all_there = |alpha| Material::new(&partly_there(alpha), 1.0).effects();
    for alpha in [
        grey(1.0),
        ColourDescription::Texture(checker([1.0; 2], Vec2::ONE)),
    ] {
        assert_eq!(all_there(alpha), EffectSet::NONE);
    }
    let half = all_there(grey(0.5));
    assert_eq!(half, EffectSet::NONE.with(Effect::Alpha));
    let cut_out = all_there(ColourDescription::Texture(checker([1.0, 0.0], Vec2::ONE)));
    assert_eq!(cut_out, half.with(Effect::Textures));
    let level = MaterialDescription {
        normal_map: Some(tilted(Vec3::Z, 1.0)),
        ..partly_there(grey(1.0))
    };
    assert_eq!(Material::new(&level, 1.0).effects(), EffectSet::NONE);
    let one_sided = MaterialDescription {
        two_sided: false,
        ..partly_there(grey(1.0))
    };
    let effects = Material::new(&one_sided, 1.0).effects();
    assert_eq!(effects, EffectSet::NONE.with(Effect::OneSided));
}

/// A black texture of roughness makes glass smooth, which light sampling cannot find.
#[test]
fn glass_of_mapped_roughness_may_be_specular() {
    let map = |roughness: [f32; 2]| MaterialDescription {
        metallic_roughness_map: Some(checker(roughness, Vec2::ONE)),
        model: MaterialModel::Principled {
            base_color: grey(1.0),
            metallic: 1.0,
            roughness: 1.0,
            ior: 1.5,
            transmission: 0.5,
        },
        ..partly_there(grey(1.0))
    };
    let effects = Material::new(&map([0.0, 0.5]), 1.0).effects();
    assert!(effects.has(Effect::Specular) && effects.has(Effect::Glossy));
}

/// A coat whose index is so large that it reflects all light by rounding.
#[test]
fn coats_of_huge_index_give_finite_values() {
    for ior in [1e6, 3e7, 1e9, 1e30] {
        for (metallic, roughness) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.5)] {
            let material = MaterialDescription {
                model: MaterialModel::Principled {
                    base_color: grey(0.5),
                    metallic,
                    roughness,
                    ior,
                    transmission: 0.0,
                },
                ..partly_there(grey(1.0))
            };
            let material = Material::new(&material, 1.0);
            let [wo, wi] = [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.8)];
            let value = material
                .bsdf::<Everything>(Vec2::ZERO)
                .eval::<Everything>(wo, wi);
            assert!(
                value.f.is_finite(),
                "{ior} {metallic} {roughness}: {value:?}"
            );
        }
    }
}

/// A lamp of which one half emits is equivalent to a lamp of half the size; the irradiance has a closed form.
#[test]
fn textured_emission_matches_closed_form_irradiance() {
    let corner = [-1.0, -1.0, 1.5];
    let (along_u, along_v) = ([0.0, 2.0, 0.0], [2.0, 0.0, 0.0]);
    let whole = rectangle(corner, along_u, along_v);
    let [a, u, v] = [corner, along_u, along_v].map(DVec3::from_array);
    let mesh = MeshDescription {
        positions: vec![a, a + u, a + u + v, a + v],
        normals: vec![],
        uvs: vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
        indices: vec![[0, 1, 2], [0, 2, 3]],
    };
    let mesh = GeometryDescription::Mesh(Arc::new(mesh));
    let bright = 3.0 * 2.0 * parallel_rectangle(1.0, 1.0, 1.5);
    let dark = 2.0 * parallel_rectangle(1.0, 1.0, 1.5);
    for (name, form) in [("rectangle", whole), ("mesh", mesh)] {
        for (colours, repeat, exact) in [
            ([3.0, 0.0], Vec2::new(2.0, 1.0), bright),
            ([0.0, 3.0], Vec2::new(1.0, 2.0), bright),
            ([3.0, 1.0], Vec2::new(2.0, 2.0), bright + dark),
        ] {
            let mut scene = patch_scene(DVec3::new(0.3, 0.2, 0.4), DVec3::ZERO, diffuse(ALBEDO));
            let emission = ColourDescription::Texture(checker(colours, repeat));
            let lamp = ShapeDescription {
                emission: Some(emission),
                ..surface(form.clone(), 0.0)
            };
            scene.shapes = vec![square(0.0, 0), lamp];
            for &backend in backends(&format!("{name} {colours:?}")) {
                let seen = see(&scene, backend, 1 << 12, Some(1), Roulette::None);
                let exact = f64::from(ALBEDO) * exact;
                let what = format!("{name} {colours:?} {}", backend.name());
                assert_mean(&what, &seen, exact, 2e-3);
            }
        }
    }
}

/// A normal map with the same normal everywhere, in the axes of u, v and the surface.
fn tilted(n: Vec3, strength: f32) -> NormalMapDescription {
    let texel = 0.5 * (n + Vec3::ONE);
    let colours = [Rgb::new(texel.x, texel.y, texel.z); 2];
    let repeat = Vec2::ONE;
    NormalMapDescription {
        texture: Arc::new(Texture::Checker { colours, repeat }),
        strength,
        is_right_handed: false,
    }
}

/// A triangle around the origin, in z = 0, whose texture coordinates are `uv` of each vertex's position.
fn triangle(uv: impl Fn(DVec2) -> DVec2) -> GeometryDescription {
    let corners = [(-3.0, -3.0), (3.0, -3.0), (0.0, 4.0)];
    GeometryDescription::Mesh(Arc::new(MeshDescription {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        normals: vec![],
        uvs: corners.map(|(x, y)| uv(DVec2::new(x, y))).to_vec(),
        indices: vec![[0, 1, 2]],
    }))
}

/// A matte surface of normal n under a small sphere of radiance 1, all above both horizons, has the radiance
/// rho (R / d)^2 (n . w), exactly.
#[test]
fn normal_map_shading_matches_closed_forms() {
    let n = Vec3::new(0.4, -0.2, 0.9).normalize();
    let ahead = |s: DVec3, t: DVec3| f64::from(n.x) * s + f64::from(n.y) * t;
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let up = |s: DVec3, t: DVec3| ahead(s, t) + f64::from(n.z) * z;
    let flat = rectangle([-3.0, -3.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]);
    let turned = rectangle([3.0, -3.0, 0.0], [0.0, 6.0, 0.0], [-6.0, 0.0, 0.0]);
    let disk = GeometryDescription::Disk {
        center: DVec3::ZERO,
        normal: z,
        radius: 3.0,
    };
    // Its point nearest to the camera has u along -x and v along y.
    let sphere = GeometryDescription::Sphere {
        center: -z,
        radius: 1.0,
    };
    let mirrored = |p: DVec2| DVec2::new(-p.x, p.y);
    let skewed = |p: DVec2| DVec2::new(p.x, p.y + 0.5 * p.x);
    let cases = [
        ("rectangle", flat, 1.0, up(x, y)),
        ("turned", turned, 1.0, up(y, -x)),
        ("disk", disk, 1.0, up(x, y)),
        ("sphere", sphere, 1.0, up(-x, y)),
        ("mesh", triangle(|p| p), 1.0, up(x, y)),
        ("mirrored", triangle(mirrored), 1.0, up(-x, y)),
        (
            "rotated",
            triangle(|p| DVec2::new(p.y, -p.x)),
            1.0,
            up(y, -x),
        ),
        (
            "skewed",
            triangle(skewed),
            1.0,
            up((x - 0.5 * y).normalize(), (0.5 * x + y).normalize()),
        ),
        ("no coordinates", triangle(|_| DVec2::ZERO), 1.0, z),
        (
            "half",
            triangle(|p| p),
            0.5,
            (0.5 * ahead(x, y) + f64::from(n.z) * z).normalize(),
        ),
    ];
    let to_lamp = DVec3::new(0.5, 0.3, 0.8).normalize();
    let (distance, radius) = (10.0, 1.0);
    for (name, form, strength, normal) in cases {
        let mut scene = patch_scene(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, diffuse(ALBEDO));
        scene.materials[0].normal_map = Some(tilted(n, strength));
        let center = distance * to_lamp;
        let lamp = GeometryDescription::Sphere { center, radius };
        scene.shapes = vec![surface(form, 0.0), surface(lamp, 1.0)];
        let exact = f64::from(ALBEDO) * (radius / distance).powi(2) * normal.dot(to_lamp);
        for &backend in Backend::ALL {
            let seen = see(&scene, backend, 1 << 11, Some(1), Roulette::None);
            let name = format!("{name}, {}", backend.name());
            assert_mean(&name, &seen, exact, 1e-3);
        }
    }
}

/// As above for a bump map: heights that rise by 1 along u over half of the image, on surfaces of different size. The slope
/// at the middle is the height over the distance along the surface, whatever the unit of length.
#[test]
fn bump_map_shading_matches_closed_forms() {
    const HEIGHT: f32 = 0.4;
    let values = [0.0, 0.25, 0.75, 1.0].map(Rgb::grey);
    let image = Arc::new(Image::new(4, 1, values.to_vec()).into());
    let heights = Arc::new(Texture::Image { image, scale: 1.0 });
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    for unit in [1.0, 1e-3] {
        // Between the two texels in the middle, the value rises by 0.5 over a quarter of the range of u.
        let rise = 2.0 * f64::from(HEIGHT);
        let at = |v: [f64; 3]| v.map(|x| unit * x);
        let flat = rectangle(
            at([-3.0, -3.0, 0.0]),
            at([6.0, 0.0, 0.0]),
            at([0.0, 6.0, 0.0]),
        );
        let turned = rectangle(
            at([3.0, -3.0, 0.0]),
            at([0.0, 6.0, 0.0]),
            at([-6.0, 0.0, 0.0]),
        );
        let disk = GeometryDescription::Disk {
            center: DVec3::ZERO,
            normal: z,
            radius: 3.0 * unit,
        };
        // Its point nearest to the camera has u = 1/4, which is along -x, and where the value rises from its least.
        let sphere = GeometryDescription::Sphere {
            center: -unit * z,
            radius: unit,
        };
        let cases = [
            ("rectangle", flat, z - rise / 6.0 * x),
            ("turned", turned, z - rise / 6.0 * y),
            ("disk", disk, z - rise / 6.0 * x),
            ("sphere", sphere, z + rise / (2.0 * TAU) * x),
        ];
        let to_lamp = DVec3::new(0.5, 0.3, 0.8).normalize();
        let (distance, radius) = (10.0 * unit, unit);
        for (name, form, normal) in cases {
            let mut scene = patch_scene(unit * 5.0 * z, DVec3::ZERO, diffuse(ALBEDO));
            scene.materials[0].bump_map = Some(BumpMapDescription {
                texture: Arc::clone(&heights),
                height: HEIGHT * unit as f32,
            });
            let center = distance * to_lamp;
            let lamp = GeometryDescription::Sphere { center, radius };
            scene.shapes = vec![surface(form, 0.0), surface(lamp, 1.0)];
            let cos = normal.normalize().dot(to_lamp);
            let exact = f64::from(ALBEDO) * (radius / distance).powi(2) * cos;
            for &backend in Backend::ALL {
                let seen = see(&scene, backend, 1 << 11, Some(1), Roulette::None);
                let name = format!("{name} of unit {unit}, {}", backend.name());
                assert_mean(&name, &seen, exact, 1e-3);
            }
        }
    }
}

#[test]
fn one_sided_backface_is_black_and_casts_shadows() {
    for &backend in Backend::ALL {
        let seen_from = |z: f64, two_sided: bool| {
            let mut scene = patch_scene(DVec3::new(0.1, 0.2, z), DVec3::ZERO, diffuse(1.0));
            scene.materials[0].two_sided = two_sided;
            scene.lights = vec![sky(Rgb::WHITE)];
            scene.shapes = vec![square(0.0, 0)];
            let seen = see(&scene, backend, 64, Some(1), Roulette::None);
            (seen.mean(), seen.variance())
        };
        let (all, nothing) = ((1.0, Some(0.0)), (0.0, Some(0.0)));
        let seen =
            [(3.0, false), (-3.0, false), (3.0, true), (-3.0, true)].map(|(z, s)| seen_from(z, s));
        assert_eq!(seen, [all, nothing, all, all]);

        // No light passes, from either side.
        let mut scene = patch_scene(DVec3::new(0.1, 0.2, 3.0), DVec3::ZERO, diffuse(1.0));
        scene.materials[0].two_sided = false;
        scene.shapes = vec![square(0.0, 0)];
        let scene = ready(&scene, backend);
        let at = |z: f64| scene.normalisation.point(DVec3::new(0.1, 0.2, z));
        for (from, to) in [(-1.0, 1.0), (1.0, -1.0)] {
            let ray = Ray::between(at(from), at(to));
            assert_eq!(scene.visibility::<Everything>(&ray, 0.0), 0.0);
        }
    }
}
