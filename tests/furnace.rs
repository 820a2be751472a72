//! White furnaces and limits: how much light each scattering model gives back, against exact answers.

mod common;

use common::TestRng;
use common::closed_forms::{FRESNEL_MEAN_INSIDE, FRESNEL_MEAN_OUTSIDE, GGX_NORMAL_ALBEDO};
use common::quadrature::{Adaptive, Rectangle, integrate};
use common::scene::{diffuse, looking, see, shape, sky};
use common::verdict::assert_mean;
use etendue::accel::Backend;
use etendue::bsdf::albedo::single_scatter;
use etendue::bsdf::microfacet::Ggx;
use etendue::bsdf::{
    Bsdf, Conductor, Dielectric, Diffuse, Lobe, Mirror, Phong, Principled, PrincipledParameters,
    fresnel,
};
use etendue::effects::kernel::types::Everything;
use etendue::integrator::Roulette;
use etendue::math::rgb::Rgb;
use etendue::math::stats::Moments;
use etendue::math::vec::{DVec3, Vec2, Vec3, reflect};
use etendue::scene::description::{
    ColourDescription, GeometryDescription, MaterialDescription, MaterialModel, Place,
};
use etendue::scene::material::Material;
use std::f64::consts::{FRAC_PI_2, PI};

/// A metal that reflects everything: in f32, |k| = 1e6 leaves nothing to absorb.
fn white_metal(roughness: f32) -> Bsdf {
    Bsdf::Conductor(Conductor::new(Rgb::WHITE, Rgb::grey(1e6), roughness))
}

fn principled(metallic: f32, roughness: f32, transmission: f32) -> Bsdf {
    Bsdf::Principled(Principled::new(&PrincipledParameters {
        base_color: Rgb::WHITE,
        metallic,
        roughness,
        ior: 1.5,
        transmission,
    }))
}

fn view(cos: f32) -> Vec3 {
    Vec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos)
}

/// The green albedo towards `wo`, as the means of `replicates` jittered grids. Refraction is counted in basic radiance,
/// L / n^2, which a furnace has the same of in both media.
fn albedo(bsdf: &Bsdf, ior: f32, wo: Vec3, replicates: u64, grid: u32) -> Moments {
    let index = |w: Vec3| if w.z > 0.0 { 1.0 } else { ior };
    Moments::of((0..replicates).map(|replicate| {
        let mut rng = TestRng::new(replicate);
        let cells = grid * grid;
        let mut sum = 0.0;
        for cell in 0..cells {
            let jitter = rng.uniform_2d();
            let u = (Vec2::new((cell % grid) as f32, (cell / grid) as f32) + jitter) / grid as f32;
            // A golden-ratio walk spreads the choice of lobe over the grid.
            let u_lobe =
                (f64::from(cell) * 0.618_033_988_749_895 + replicate as f64 / 17.3).fract();
            if let Some(s) =
                bsdf.sample::<Everything>(wo, u_lobe as f32, u.min(Vec2::splat(1.0 - 6e-8)))
            {
                let ratio = f64::from(index(s.wi)) / f64::from(index(wo));
                sum += f64::from(s.weight.to_array()[1]) * ratio * ratio;
            }
        }
        sum / f64::from(cells)
    }))
}

/// [`albedo`] of one medium, to a standard error of 1e-3: narrow lobes with little light between facets need more samples.
fn precise_albedo(bsdf: &Bsdf, wo: Vec3) -> Moments {
    let moments = albedo(bsdf, 1.0, wo, 16, 48);
    if moments.standard_error() < Some(0.7e-3) {
        return moments;
    }
    albedo(bsdf, 1.0, wo, 16, 256)
}

#[test]
fn white_diffuse_and_mirror_give_everything_back() {
    for cos in [1.0, 0.3, 1e-3] {
        for bsdf in [
            Bsdf::Diffuse(Diffuse::new(Rgb::WHITE)),
            Bsdf::Mirror(Mirror::new(Rgb::WHITE)),
        ] {
            let moments = albedo(&bsdf, 1.0, view(cos), 16, 8);
            assert!((moments.mean() - 1.0).abs() < 2e-6);
            assert_eq!(moments.variance(), Some(0.0));
        }
    }
}

#[test]
fn smooth_glass_gives_everything_back() {
    // Hard case 11: indices next to 1.
    for ior in [1.0, 1.000_001, 1.0001, 1.5, 1.0 / 1.5, 2.4] {
        let glass = Bsdf::Dielectric(Dielectric::new(ior, 0.0, Rgb::WHITE));
        for cos in [1.0, 0.5, 0.1, 1e-3] {
            for wo in [view(cos), -view(cos)] {
                let moments = albedo(&glass, ior, wo, 16, 8);
                assert!(
                    (moments.mean() - 1.0).abs() < 2e-6,
                    "{ior} {wo} {}",
                    moments.mean()
                );
            }
        }
    }
}

#[test]
fn an_index_of_one_is_no_surface() {
    let tint = Rgb::new(0.9, 0.5, 0.1);
    for roughness in [0.0, 0.1, 0.5, 1.0] {
        let glass = Dielectric::new(1.0, roughness, tint);
        for wo in [view(1.0), view(0.3), -view(0.3), view(1e-6)] {
            for u_lobe in [0.0, 0.5, 1.0 - 6e-8] {
                let s = glass
                    .sample(wo, u_lobe, Vec2::splat(0.3))
                    .expect("light passes");
                assert_eq!(s.lobe, Lobe::SpecularTransmission);
                assert!((s.wi + wo).length() < 1e-6, "{wo} {}", s.wi);
                assert_eq!(s.weight, tint);
            }
        }
    }
}

#[test]
fn single_scattering_loses_what_theory_says() {
    for (alpha, exact) in GGX_NORMAL_ALBEDO {
        let ggx = Ggx::new(alpha);
        let moments = Moments::of((0..64).map(|replicate| {
            let mut rng = TestRng::new(replicate);
            let mut sum = 0.0;
            for cell in 0..4096 {
                let u =
                    (Vec2::new((cell % 64) as f32, (cell / 64) as f32) + rng.uniform_2d()) / 64.0;
                let wi = reflect(Vec3::Z, ggx.sample_visible(Vec3::Z, u));
                if wi.z > 0.0 {
                    sum += f64::from(1.0 - ggx.shadowed(Vec3::Z, wi));
                }
            }
            sum / 4096.0
        }));
        assert_mean(&format!("alpha {alpha}"), &moments, exact, 1e-3);
        let tabulated = 1.0 - single_scatter(&ggx, 1.0, 4181, 2584).loss;
        assert!(
            (f64::from(tabulated) - exact).abs() < 1e-3 * exact,
            "{alpha} {tabulated}"
        );
    }
}

#[test]
fn compensated_white_metal_gives_everything_back() {
    let mut worst = 0.0_f64;
    for roughness in [
        0.0101, 0.015, 0.03, 0.06, 0.1, 0.2, 0.3, 0.42, 0.55, 0.7, 0.85, 1.0,
    ] {
        let metal = white_metal(roughness);
        for cos in [1.0, 0.9, 0.7, 0.4, 0.2, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4] {
            let moments = precise_albedo(&metal, view(cos));
            let error = moments.mean() - 1.0;
            let standard_error = moments.standard_error().expect("16 replicates");
            worst = worst.max(error.abs());
            assert!(standard_error <= 1e-3, "{roughness} {cos} {standard_error}");
            assert!(
                error.abs() <= 2e-3 + 5.2 * standard_error,
                "{roughness} {cos} {error}"
            );
        }
    }
    println!("white metal: worst furnace error {worst:.1e}");
}

/// Hard case 10. Along the normal the lobe gives back `specular` for any exponent. Elsewhere there are closed forms: the
/// integral of cos over two half spaces at an angle t is pi (1 + cos t) / 2, and that of both cosines is
/// 2 / 3 (sin t + (pi - t) cos t). A narrow lobe keeps cos t of the light.
#[test]
fn phong_gives_back_what_its_closed_forms_say() {
    let specular = 0.75;
    for exponent in [0.0, 1.0, 1e2, 1e4, 1e6] {
        let lobe = Bsdf::Phong(Phong::new(Rgb::BLACK, Rgb::grey(specular), exponent));
        print!("phong of exponent {exponent} keeps");
        for cos in [1.0, 0.8, 0.5, 0.1] {
            let moments = albedo(&lobe, 1.0, view(cos), 64, 64);
            let standard_error = moments.standard_error().expect("64 replicates");
            let kept = moments.mean() / f64::from(specular);
            print!(" {kept:.4} at cos {cos},");
            assert!(
                kept <= 1.0 + 5.2 * standard_error,
                "{exponent} {cos} {kept}"
            );
            let (t, cos) = (f64::from(cos).acos(), f64::from(cos));
            let exact = if cos == 1.0 {
                1.0
            } else if exponent == 0.0 {
                0.5 * (1.0 + cos)
            } else if exponent == 1.0 {
                (t.sin() + (PI - t) * cos) / PI
            } else if exponent >= 1e4 && cos > 0.2 {
                // The mean cosine about the mirror direction is (n + 1) / (n + 2), which the normalisation takes out.
                cos
            } else {
                continue;
            };
            let what = format!("exponent {exponent}, cos {cos}");
            assert_mean(&what, &moments, f64::from(specular) * exact, 1e-3);
        }
        println!();
    }
    // With a matte part, never more than both together.
    for exponent in [0.0, 1.0, 1e2, 1e4, 1e6] {
        let phong = Bsdf::Phong(Phong::new(Rgb::grey(0.6), Rgb::grey(0.4), exponent));
        let normal = albedo(&phong, 1.0, view(1.0), 64, 64);
        assert_mean(&format!("white phong {exponent}"), &normal, 1.0, 1e-3);
        for cos in [0.9, 0.5, 0.2, 0.01] {
            for wo in [view(cos), -view(cos)] {
                let moments = albedo(&phong, 1.0, wo, 16, 64);
                let standard_error = moments.standard_error().expect("16 replicates");
                assert!(
                    moments.mean() <= 1.0 + 5.2 * standard_error,
                    "{exponent} {wo}"
                );
                assert!(
                    moments.mean() >= 0.6 - 5.2 * standard_error,
                    "{exponent} {wo}"
                );
            }
        }
    }
}

#[test]
fn visible_normals_are_a_density() {
    // Row 6, the weak white furnace: reflecting every visible normal, without shadowing towards wi, loses nothing.
    let quadrature = Adaptive::new(1e-7, 60);
    for alpha in [1e-4, 3e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0] {
        let ggx = Ggx::new(alpha);
        for cos in [1e-3, 1e-2, 0.1, 0.5, 1.0] {
            let wo = view(cos);
            let density = |below_pole: f64, azimuth: f64| {
                let r = (below_pole * (2.0 - below_pole)).sqrt();
                let (x, y) = (r * azimuth.cos(), r * azimuth.sin());
                let m = Vec3::new(x as f32, y as f32, (1.0 - below_pole) as f32);
                f64::from(ggx.pdf_visible(wo, m))
            };
            // The peak is at the pole; quarters of the circle put it into a corner.
            let sum: f64 = (0..4)
                .map(|k| {
                    let from = f64::from(k) * FRAC_PI_2;
                    let domain = Rectangle {
                        x: (0.0, 1.0),
                        y: (from, from + FRAC_PI_2),
                    };
                    quadrature.integrate(&density, domain)
                })
                .sum();
            assert!((sum - 1.0).abs() < 1e-4, "{alpha} {cos} {sum}");
        }
    }
}

#[test]
fn rough_glass_loses_what_facets_shadow() {
    println!(
        "rough glass of 1.5, single scattering: albedo at cos 1 and 0.1, from outside and inside"
    );
    for alpha in [0.1_f32, 0.3, 0.5, 1.0] {
        let glass = Bsdf::Dielectric(Dielectric::new(1.5, alpha.sqrt(), Rgb::WHITE));
        let [a, b, c, d] = [view(1.0), view(0.1), -view(1.0), -view(0.1)].map(|wo| {
            let moments = albedo(&glass, 1.5, wo, 16, 64);
            let standard_error = moments.standard_error().expect("16 replicates");
            assert!(standard_error < 1e-3 * moments.mean(), "{alpha} {wo}");
            assert!(moments.mean() <= 1.0 + 5.2 * standard_error, "{alpha} {wo}");
            moments.mean()
        });
        println!("  alpha {alpha}: {a:.4} {b:.4}   {c:.4} {d:.4}");
        // A loss as in other single-scattering models, no more.
        let least = [(0.1, 0.98), (0.3, 0.85), (0.5, 0.66), (1.0, 0.3)]
            .iter()
            .find(|&&(known, _)| known == alpha)
            .map_or(0.0, |&(_, least)| least);
        assert!(a > least, "{alpha} {a}");
    }
}

#[test]
fn principled_white_gives_everything_back_and_never_more() {
    let mut worst = 0.0_f64;
    for roughness in [0.0, 0.0101, 0.05, 0.2, 0.45, 0.7, 1.0] {
        for metallic in [0.0, 0.4, 1.0] {
            let surface = principled(metallic, roughness, 0.0);
            for cos in [1.0, 0.7, 0.3, 0.1, 0.01, 1e-3] {
                for wo in [view(cos), -view(cos)] {
                    let moments = precise_albedo(&surface, wo);
                    let standard_error = moments.standard_error().expect("16 replicates");
                    let error = moments.mean() - 1.0;
                    worst = worst.max(error.abs());
                    let what = format!("{metallic} {roughness} {cos} {error} {standard_error}");
                    assert!(standard_error <= 1e-3, "{what}");
                    // The tables' error, 0.25 %, bounds both what is lost and what is gained.
                    assert!(error.abs() <= 2.5e-3 + 5.2 * standard_error, "{what}");
                }
            }
        }
        for transmission in [0.3, 1.0] {
            let surface = principled(0.0, roughness, transmission);
            for cos in [1.0, 0.3, 0.01] {
                for wo in [view(cos), -view(cos)] {
                    let moments = albedo(&surface, 1.5, wo, 16, 48);
                    let standard_error = moments.standard_error().expect("16 replicates");
                    assert!(
                        moments.mean() <= 1.0025 + 5.2 * standard_error,
                        "{roughness} {cos}"
                    );
                }
            }
        }
    }
    println!("principled white: worst furnace error {worst:.1e}");
}

/// Hard case 8: the base takes all that the coat lets through, at any index.
#[test]
fn white_plastic_gives_everything_back() {
    let mut worst = 0.0_f64;
    for ior in [1.0, 1.0001, 1.3, 2.4] {
        for roughness in [0.0, 0.1, 0.5, 1.0] {
            let plastic = Material::new(&MaterialDescription::new(
                "plastic",
                Place::default(),
                MaterialModel::Plastic {
                    reflectance: ColourDescription::Constant(Rgb::WHITE),
                    ior,
                    roughness,
                },
            ));
            let bsdf = plastic.bsdf::<Everything>(Vec2::ZERO);
            for cos in [1.0, 0.5, 0.1, 1e-3] {
                let moments = precise_albedo(&bsdf, view(cos));
                let standard_error = moments.standard_error().expect("16 replicates");
                let error = moments.mean() - 1.0;
                worst = worst.max(error.abs());
                let what = format!("{ior} {roughness} {cos} {error} {standard_error}");
                assert!(standard_error <= 1e-3, "{what}");
                assert!(error.abs() <= 2.5e-3 + 5.2 * standard_error, "{what}");
            }
        }
    }
    println!("white plastic: worst furnace error {worst:.1e}");
}

#[test]
fn fresnel_means_have_their_closed_forms() {
    let mean = |n_i: f32, n_t: f32| {
        // The kink at the critical angle ends a panel.
        let critical = (1.0 - f64::from(n_t / n_i).powi(2)).max(0.0).sqrt();
        let f =
            |mu: f64| 2.0 * mu * f64::from(fresnel::dielectric(mu as f32, n_i, n_t).reflectance);
        // mu = critical + t^2 takes the square root out of the kink.
        integrate(f, 0.0, critical, 4)
            + integrate(
                |t| 2.0 * t * f(critical + t * t),
                0.0,
                (1.0 - critical).sqrt(),
                64,
            )
    };
    assert!((mean(1.0, 1.5) / FRESNEL_MEAN_OUTSIDE - 1.0).abs() < 1e-5);
    assert!((mean(1.5, 1.0) / FRESNEL_MEAN_INSIDE - 1.0).abs() < 1e-5);
    assert!((mean(1.0, 1.0001) / 3.329_173e-5 - 1.0).abs() < 1e-3);
    assert!((mean(1.0001, 1.0) / 2.332_551e-4 - 1.0).abs() < 1e-3);
}

#[test]
fn ever_smoother_metal_becomes_a_mirror() {
    // The share of light that stays within half a degree of the mirror direction.
    let wo = view(0.8);
    let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
    let radius = 0.5_f32.to_radians();
    let mut shares = Vec::new();
    for exponent in 1..=8 {
        let alpha = 10.0_f32.powi(-exponent);
        // A breath above: the square of the root may fall below the limit.
        for alpha in [alpha, 1.01 * alpha] {
            let metal = white_metal(alpha.sqrt());
            let mut rng = TestRng::new(5);
            let n = 1 << 15;
            let mut sum = 0.0;
            for _ in 0..n {
                let sample = metal.sample::<Everything>(wo, rng.uniform(), rng.uniform_2d());
                let near = sample.filter(|s| (s.wi - mirror).length() < radius);
                sum += near.map_or(0.0, |s| f64::from(s.weight.to_array()[1]));
            }
            shares.push((alpha, sum / f64::from(n)));
        }
    }
    for &(alpha, share) in &shares {
        let ratio = f64::from(alpha / radius);
        // A tail of slopes beyond the cone: O(alpha^2).
        assert!(
            share <= 1.0 + 2e-3 && share >= 1.0 - 8.0 * ratio * ratio - 2e-3,
            "{alpha} {share}"
        );
    }
    // Either side of the switch to a delta.
    assert!(
        !white_metal(0.010_05).is_delta::<Everything>()
            && white_metal(0.009_95).is_delta::<Everything>()
    );
    assert!(
        shares
            .iter()
            .filter(|s| s.0 <= 1.02e-4)
            .all(|s| (s.1 - 1.0).abs() < 2e-3)
    );
}

#[test]
fn white_spheres_vanish_in_a_constant_environment() {
    let glass = MaterialModel::Dielectric {
        ior: 1.5,
        roughness: 0.0,
        tint: ColourDescription::Constant(Rgb::WHITE),
    };
    for (name, model) in [("diffuse", diffuse(1.0)), ("glass", glass)] {
        // The middle, halfway, and towards the limb.
        for x in [0.0, 0.5, 0.99, 0.999, 0.9999, 0.99999] {
            let target = DVec3::new(x, 0.0, f64::sqrt(1.0 - x * x));
            let mut scene = looking(DVec3::new(x, 0.0, 5.0), target, model.clone());
            scene.lights = vec![sky(Rgb::WHITE)];
            let center = DVec3::ZERO;
            let sphere = GeometryDescription::Sphere {
                center,
                radius: 1.0,
            };
            scene.shapes = vec![shape(sphere, 0.0)];
            for &backend in Backend::ALL {
                let seen = see(&scene, backend, 256, None, Roulette::None);
                let off = (seen.mean() - 1.0).abs();
                assert!(off < 2e-6, "{name} {x} {}: {off:e}", backend.name());
                assert!(seen.variance() < Some(1e-12), "{name} {x}");
            }
        }
    }
}

#[test]
fn a_grey_furnace_glows_by_its_depth() {
    // A closed box that emits 1 and reflects half: sum of 2^-k over the bounces.
    let mut scene = looking(
        DVec3::new(0.1, 0.2, 0.3),
        DVec3::new(0.3, 1.0, 0.1),
        diffuse(0.5),
    );
    let (min, max) = (DVec3::splat(-1.0), DVec3::ONE);
    let mut walls = shape(GeometryDescription::Box { min, max }, 1.0);
    walls.two_sided_emission = true;
    scene.shapes = vec![walls];
    for &backend in Backend::ALL {
        for (depth, roulette) in [
            (Some(0), Roulette::None),
            (Some(1), Roulette::None),
            (Some(8), Roulette::None),
            (Some(8), Roulette::Throughput),
            (None, Roulette::Throughput),
        ] {
            let exact = depth.map_or(2.0, |d| 2.0 * (1.0 - 0.5_f64.powi(d as i32 + 1)));
            // The roulette adds noise.
            let spp = if roulette == Roulette::None {
                1 << 12
            } else {
                1 << 14
            };
            let seen = see(&scene, backend, spp, depth, roulette);
            assert_mean(
                &format!("{depth:?} {roulette:?} {}", backend.name()),
                &seen,
                exact,
                1e-3,
            );
        }
    }
}
