//! Tests of every warp: density, inverse, and extreme random numbers; solid angles against closed forms.

use crate::common::TestRng;
use crate::common::chi_square::{ChiSquareTest, pearson, uniformity};
use crate::common::closed_forms::{rectangle_solid_angle, triangle_solid_angle};
use crate::common::verdict::sidak;
use etendue::internals::math::vec::{DVec2, DVec3, LaneVec3, ONE_MINUS_EPSILON, Vec2, Vec3};
use etendue::internals::sampling::clear_triangle::ClearTriangle;
use etendue::internals::sampling::distribution::AliasTable;
use etendue::internals::sampling::linear::LinearSquare;
use etendue::internals::sampling::spherical_rectangle::SphericalRectangle;
use etendue::internals::sampling::{spherical_triangle, warp};

const EXTREMES: [f32; 4] = [0.0, 1.0 / 16_777_216.0, 0.5, ONE_MINUS_EPSILON];

fn extreme_pairs() -> impl Iterator<Item = Vec2> {
    EXTREMES
        .into_iter()
        .flat_map(|x| EXTREMES.map(|y| Vec2::new(x, y)))
}

/// Heights 1 - cos of cones, from a hemisphere down to R / d = 1e-4.
const CONES: [f32; 5] = [1.0, 0.3, 1e-2, 1e-5, 5e-9];

#[test]
fn cosine_and_uniform_sphere_directions_match_their_pdf() {
    let test = ChiSquareTest::default();
    let cosine = |rng: &mut TestRng| Some(warp::sample_hemisphere_cosine(rng.uniform_2d()));
    let sphere = |rng: &mut TestRng| Some(warp::sample_sphere_uniform(rng.uniform_2d()));
    let results = [
        test.run(cosine, |w| warp::pdf_hemisphere_cosine(w.z)),
        test.run(sphere, |_| warp::PDF_SPHERE_UNIFORM),
    ];
    for result in results {
        assert!(result.p_value > sidak(1e-3, 2), "{result:?}");
        assert!((result.integral - 1.0).abs() < 1e-3, "{result:?}");
    }
}

/// The p-value of uniformity of points in [0, 1]^2, counted in 24 x 24 cells.
fn square_uniformity(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let cell = |x: f64| ((24.0 * x) as usize).min(23);
    let mut counts = vec![0; 24 * 24];
    points.for_each(|[x, y]| counts[24 * cell(x) + cell(y)] += 1);
    uniformity(&counts)
}

fn uniform_pairs(seed: u64) -> impl Iterator<Item = Vec2> {
    let mut rng = TestRng::new(seed);
    (0..1 << 17).map(move |_| rng.uniform_2d())
}

#[test]
fn cone_disk_and_triangle_sampling_is_uniform() {
    // Points are mapped to area-preserving coordinates: fraction of the cap's height and azimuth; squared radius and
    // angle; for the triangle 1 - (1 - b1)^2, the area to one side of a line, and the position on that line.
    let turn = |y: f32, x: f32| f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU + 0.5;
    for (seed, h) in (0..).zip(CONES) {
        let p = square_uniformity(uniform_pairs(seed).map(|u| {
            let w: Vec3 = warp::sample_cone_uniform(u, h);
            let sin2 = f64::from(w.x).powi(2) + f64::from(w.y).powi(2);
            let height = sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt());
            [height / f64::from(h), turn(w.y, w.x)]
        }));
        assert!(p > sidak(1e-3, 7), "cone {h}: {p:.1e}");
    }
    let p = square_uniformity(uniform_pairs(10).map(|u| {
        let d = warp::sample_disk_concentric(u).as_dvec2();
        [d.length_squared(), turn(d.y as f32, d.x as f32)]
    }));
    assert!(p > sidak(1e-3, 7), "disk: {p:.1e}");
    let p = square_uniformity(uniform_pairs(11).map(|u| {
        let b = warp::sample_triangle_uniform(u).as_dvec2();
        let rest = 1.0 - b.x;
        [1.0 - rest * rest, if rest > 0.0 { b.y / rest } else { 0.0 }]
    }));
    assert!(p > sidak(1e-3, 7), "triangle: {p:.1e}");
    // Constant densities integrate to one over their domains.
    for h in CONES {
        let area = std::f64::consts::TAU * f64::from(h);
        assert!((f64::from(warp::pdf_cone_uniform(h)) * area - 1.0).abs() < 1e-6);
    }
    assert!(
        (f64::from(warp::pdf_disk_concentric(Vec2::ZERO)) * std::f64::consts::PI - 1.0).abs()
            < 1e-6
    );
    assert_eq!(warp::pdf_disk_concentric(Vec2::ONE), 0.0);
}

#[test]
fn warp_inverses_recover_the_random_numbers() {
    let close = |what: &str, u: Vec2, back: Vec2, tolerance: f32| {
        // Azimuths are periodic.
        let d = (back - u).abs();
        let d = d.x.max(d.y.min(1.0 - d.y));
        assert!(d < tolerance, "{what} {u} {back}");
    };
    for u in uniform_pairs(3).take(1 << 14) {
        // Near the poles and the centre the inverse is ill-conditioned.
        let u = 0.01 + 0.98 * u;
        let inverse = warp::invert_disk_concentric(warp::sample_disk_concentric(u));
        close("disk", u, inverse, 1e-6);
        let inverse = warp::invert_hemisphere_cosine(warp::sample_hemisphere_cosine(u));
        close("hemisphere", u, inverse, 1e-6);
        let inverse = warp::invert_sphere_uniform(warp::sample_sphere_uniform(u));
        close("sphere", u, inverse, 1e-6);
        let inverse = warp::invert_triangle_uniform(warp::sample_triangle_uniform(u));
        close("triangle", u, inverse, 1e-6);
        for h in CONES {
            let inverse = warp::invert_cone_uniform(warp::sample_cone_uniform(u, h), h);
            close("cone", u, inverse, 3e-6);
        }
    }
}

#[test]
fn warps_of_extreme_random_numbers_stay_in_the_domain() {
    let unit = |w: Vec3| (w.length() - 1.0).abs() < 1e-6;
    for u in extreme_pairs() {
        let d = warp::sample_disk_concentric(u);
        assert!(d.length() <= 1.0 + 1e-7, "{u} {d}");
        let w = warp::sample_hemisphere_cosine(u);
        assert!(unit(w) && warp::pdf_hemisphere_cosine(w.z) > 0.0, "{u} {w}");
        assert!(unit(warp::sample_sphere_uniform(u)), "{u}");
        for h in CONES {
            let w: Vec3 = warp::sample_cone_uniform(u, h);
            assert!(unit(w) && 1.0 - w.z <= h + 6e-8, "{u} {h} {w}");
        }
        let b = warp::sample_triangle_uniform(u);
        assert!(b.min_element() >= 0.0 && b.x + b.y <= 1.0, "{u} {b}");
    }
}

/// Viewpoints relative to a figure of unit size: height above its plane, and foot point along its two axes.
const VIEWS: [[f64; 3]; 8] = [
    [1.0, 0.5, 0.5],
    [1.0, 0.0, 0.0],
    [0.01, 0.5, 0.3],
    [1e-4, 0.2, 0.7],
    [0.1, 3.0, -2.0],
    [1e-3, 5.0, 0.4],
    [30.0, -3.0, 2.0],
    [-1.0, 0.3, 1.5],
];
const SIZES: [f64; 6] = [10.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4];

/// The corner and edges of a figure of this size relative to the viewpoint, in rotated axes; the viewpoint's height and
/// foot point do not depend on `size`.
fn seen(view: [f64; 3], size: f64) -> (DVec3, [DVec3; 2]) {
    let x = DVec3::new(0.36, 0.48, -0.8);
    let y = DVec3::new(-0.8, 0.6, 0.0);
    let z = x.cross(y);
    let corner = view[0] * z - (view[1] * x + view[2] * y);
    (corner, [size * x, 0.7 * size * y])
}

#[test]
fn rectangle_and_triangle_solid_angles_are_accurate() {
    let mut worst = [0.0_f64; 2];
    for view in VIEWS {
        for size in SIZES {
            let (corner, edges) = seen(view, size);
            let lengths = edges.map(|e| e.length());
            let axes = edges.map(|e| e.normalize());
            let rectangle =
                SphericalRectangle::new(corner, axes, lengths).expect("a viewpoint off the plane");
            let exact = rectangle_solid_angle(corner, edges);
            // Below this solid angle both kinds of light are sampled by area.
            if exact < 1e-8 {
                continue;
            }
            let error = rectangle.solid_angle() / exact - 1.0;
            assert!(
                error.abs() < 1e-6,
                "{view:?} {size}: {error:.1e} of {exact:.1e}"
            );
            let triangle = [corner, corner + edges[0], corner + edges[1]];
            let exact = triangle_solid_angle(triangle);
            let triangle_error = spherical_triangle::solid_angle(triangle) / exact - 1.0;
            assert!(
                triangle_error.abs() < 1e-6,
                "{view:?} {size}: {triangle_error:.1e}"
            );
            worst = [
                worst[0].max(error.abs()),
                worst[1].max(triangle_error.abs()),
            ];
        }
    }
    println!(
        "solid angles: rectangle within {:.1e}, triangle {:.1e}",
        worst[0], worst[1]
    );
}

#[test]
fn rectangle_beside_its_plane_has_no_large_solid_angle() {
    // Heights above the plane of a tilted rectangle, down to rounding errors of its corner.
    let tilt = (0.3_f64).sin_cos();
    let axes = [DVec3::new(tilt.1, 0.0, tilt.0), DVec3::Y];
    let normal = axes[0].cross(axes[1]);
    for exponent in 0..40 {
        for beside in [1.0, 1.7, 30.0] {
            let height = f64::exp2(-30.0 - f64::from(exponent));
            let corner = beside * axes[0] + 0.1 * beside * axes[1] + height * normal;
            let Some(seen) = SphericalRectangle::new(corner, axes, [1.0, 1.0]) else {
                continue;
            };
            let omega = seen.solid_angle();
            let limit = 2.0 * height + 64.0 * f64::EPSILON;
            assert!((0.0..=limit).contains(&omega), "{omega} at {height}");
        }
    }
}

#[test]
fn spherical_rectangle_sampling_is_uniform_in_solid_angle() {
    const CELLS: usize = 12;
    let mut checks = Vec::new();
    for (seed, view) in (20..).zip(VIEWS) {
        for size in [10.0, 1.0, 0.01] {
            let (corner, edges) = seen(view, size);
            let lengths = edges.map(|e| e.length());
            let axes = edges.map(|e| e.normalize());
            let rectangle =
                SphericalRectangle::new(corner, axes, lengths).expect("a viewpoint off the plane");
            if rectangle.solid_angle() < 1e-8 {
                continue;
            }
            for u in extreme_pairs() {
                let s = rectangle.sample(u);
                assert!(
                    s.iter().all(|x| (0.0..=1.0).contains(x)),
                    "{view:?} {size} {u} {s:?}"
                );
            }
            let n = 1 << 16;
            let mut cells = Vec::new();
            for i in 0..CELLS * CELLS {
                let [x, y] = [i / CELLS, i % CELLS].map(|k| k as f64 / CELLS as f64);
                let from = corner + x * edges[0] + y * edges[1];
                let part = edges.map(|e| e / CELLS as f64);
                cells.push((
                    f64::from(n) * rectangle_solid_angle(from, part) / rectangle.solid_angle(),
                    0.0,
                ));
            }
            for u in uniform_pairs(seed).take(n as usize) {
                let [x, y] = rectangle
                    .sample(u)
                    .map(|s| ((CELLS as f64 * s) as usize).min(CELLS - 1));
                cells[CELLS * x + y].1 += 1.0;
            }
            checks.push((format!("{view:?} {size}"), pearson(&mut cells)));
        }
    }
    for (what, p) in &checks {
        assert!(*p > sidak(1e-3, checks.len()), "{what}: {p:.1e}");
    }
}

#[test]
fn spherical_triangle_sampling_is_uniform_in_solid_angle() {
    const CELLS: usize = 12;
    let mut checks = Vec::new();
    for (seed, view) in (40..).zip(VIEWS) {
        for size in [10.0, 1.0, 0.01] {
            let (corner, edges) = seen(view, size);
            let triangle = [corner, corner + edges[0], corner + edges[1]];
            let omega = spherical_triangle::solid_angle(triangle);
            if omega < 1e-8 {
                continue;
            }
            for u in extreme_pairs() {
                let b = spherical_triangle::sample(triangle, omega, u).expect("a triangle");
                assert!(
                    b.iter().all(|x| (0.0..=1.0).contains(x)) && b[0] + b[1] <= 1.0 + 1e-12,
                    "{view:?} {size} {u} {b:?}"
                );
            }
            // Cells between lines of equal barycentric coordinates: upright triangles and the reversed ones between them.
            let at = |i: usize, j: usize| {
                corner + (i as f64 * edges[0] + j as f64 * edges[1]) / CELLS as f64
            };
            let n = 1 << 16;
            let expected = |t: [DVec3; 3]| f64::from(n) * triangle_solid_angle(t) / omega;
            let mut cells = vec![(0.0, 0.0); 2 * CELLS * CELLS];
            for i in 0..CELLS {
                for j in 0..CELLS - i {
                    cells[2 * (CELLS * i + j)].0 = expected([at(i, j), at(i + 1, j), at(i, j + 1)]);
                    if i + j + 1 < CELLS {
                        cells[2 * (CELLS * i + j) + 1].0 =
                            expected([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
            }
            for u in uniform_pairs(seed).take(n as usize) {
                let b = spherical_triangle::sample(triangle, omega, u).expect("a triangle");
                let [x, y] = b.map(|b| (CELLS as f64 * b).min(CELLS as f64 - 1e-9));
                let reversed = x.fract() + y.fract() > 1.0 && x as usize + y as usize + 1 < CELLS;
                cells[2 * (CELLS * x as usize + y as usize) + usize::from(reversed)].1 += 1.0;
            }
            checks.push((format!("{view:?} {size}"), pearson(&mut cells)));
        }
    }
    for (what, p) in &checks {
        assert!(*p > sidak(1e-3, checks.len()), "{what}: {p:.1e}");
    }
}

/// A random vector with coordinates in [-1, 1).
fn in_cube(rng: &mut TestRng) -> Vec3 {
    let mut coordinate = || 2.0 * rng.uniform() - 1.0;
    Vec3::new(coordinate(), coordinate(), coordinate())
}

/// The random numbers that correspond to a point with these barycentric coordinates. With C' where the line from B
/// through the point intersects AC: the fraction of the triangle's solid angle in A B C', and the fraction of 1 - cos
/// of the arc BC' up to the point.
fn shares_cut_off([a, b, c]: [DVec3; 3], [b1, b2]: [f64; 2]) -> DVec2 {
    let cut = a + b2 / (1.0 - b1) * (c - a);
    let point = (1.0 - b1 - b2) * a + b1 * b + b2 * c;
    let angle = |c| spherical_triangle::solid_angle([a, b, c]);
    let one_minus_cos = |q: DVec3| 0.5 * q.normalize().distance_squared(b.normalize());
    DVec2::new(
        angle(cut) / angle(c),
        one_minus_cos(point) / one_minus_cos(cut),
    )
}

#[test]
fn clear_triangle_sampling_is_accurate_in_single_precision() {
    let mut rng = TestRng::new(60);
    let (mut worst_angle, mut worst_share) = (0.0_f64, 0.0_f64);
    let mut seen = 0;
    let tried = 200_000;
    for _ in 0..tried {
        // Sizes and distances vary over eight orders of magnitude; some triangles are needles.
        let size = 10.0_f32.powf(2.0 - 6.0 * rng.uniform());
        let unit = 10.0_f32.powf(4.0 - 8.0 * rng.uniform());
        let needle = 10.0_f32.powf(-2.0 * rng.uniform());
        let ab = size * in_cube(&mut rng);
        let ac = rng.uniform() * ab + needle * size * in_cube(&mut rng);
        let a = in_cube(&mut rng);
        let vertices = [a, a + ab, a + ac].map(|v| unit * v);
        let exact = vertices.map(|v| v.as_dvec3());
        let cross = (exact[1] - exact[0]).cross(exact[2] - exact[0]);
        let triple = exact[0].dot(cross).abs() as f32;
        let plain = vertices.map(LaneVec3::from);
        let Some(clear) = ClearTriangle::new(plain, triple, cross.length() as f32) else {
            continue;
        };
        seen += 1;
        let omega = spherical_triangle::solid_angle(exact);
        let error = (f64::from(clear.solid_angle()) / omega - 1.0).abs();
        assert!(error < 1e-6, "{vertices:?}: {error:e} of {omega:e}");
        worst_angle = worst_angle.max(error);
        for u in extreme_pairs() {
            let b = clear.sample(u);
            assert!(
                b.iter().all(|x| *x >= 0.0) && b[0] + b[1] <= 1.0 + 1e-7,
                "{u} {b:?}"
            );
        }
        let u = Vec2::splat(0.01) + 0.99 * rng.uniform_2d();
        let shares = shares_cut_off(exact, clear.sample(u).map(f64::from));
        let error = (shares - u.as_dvec2()).abs().max_element();
        assert!(error < 2e-5, "{vertices:?} {u}: {shares}");
        worst_share = worst_share.max(error);
    }
    println!(
        "{seen} of {tried} clearly seen: angle within {worst_angle:.1e}, shares within {worst_share:.1e}"
    );
    assert!(seen > tried / 2, "{seen}");
}

#[test]
fn linear_square_samples_match_their_pdf() {
    const CELLS: usize = 12;
    let mut checks = Vec::new();
    let weights = [
        [1.0, 1.0, 1.0, 1.0],
        [1.0, 2.0, 5.0, 3.0],
        [1e-6, 1.0, 1e6, 1e-6],
        [1e9, 1e9, 0.99e9, 1e9],
    ];
    for (seed, [a, b, c, d]) in (80..).zip(weights) {
        let density = LinearSquare::new(Vec2::new(a, c), Vec2::new(b, d));
        let name = format!("{density:?}");
        for u in extreme_pairs() {
            let at = density.sample(u);
            assert!(
                at.min_element() >= 0.0 && at.max_element() <= 1.0,
                "{name} {u} {at}"
            );
        }
        // The mean of a bilinear function over a cell is the value at its centre.
        let factor = |x: f64, [a, b]: [f32; 2]| {
            let [a, b] = [a, b].map(f64::from);
            2.0 * (a + x * (b - a)) / (a + b)
        };
        let mut cells = Vec::new();
        for i in 0..CELLS * CELLS {
            let [x, y] = [i / CELLS, i % CELLS].map(|k| (k as f64 + 0.5) / CELLS as f64);
            let exact = factor(x, [a, b]) * factor(y, [c, d]);
            let pdf = f64::from(density.pdf(Vec2::new(x as f32, y as f32)));
            assert!((pdf / exact - 1.0).abs() < 1e-5, "{name} {x} {y} {pdf}");
            let count = f64::from(1 << 17) / (CELLS * CELLS) as f64;
            cells.push((count * exact, 0.0));
        }
        for u in uniform_pairs(seed) {
            let at = density.sample(u).to_array();
            let [x, y] = at.map(|s| ((CELLS as f32 * s) as usize).min(CELLS - 1));
            cells[CELLS * x + y].1 += 1.0;
        }
        checks.push((name, pearson(&mut cells)));
    }
    for (what, p) in &checks {
        assert!(*p > sidak(1e-3, checks.len()), "{what}: {p:.1e}");
    }
}

#[test]
fn alias_table_sample_frequencies_match_its_pmf() {
    let weights: Vec<f64> = (0..100)
        .map(|i| {
            if i % 7 == 0 {
                0.0
            } else {
                f64::from(i).powi(3)
            }
        })
        .collect();
    let table = AliasTable::new(&weights).expect("valid weights");
    let total: f64 = (0..weights.len()).map(|i| f64::from(table.pmf(i).0)).sum();
    assert!((total - 1.0).abs() < 1e-6);
    let n = 1 << 17;
    let mut cells: Vec<_> = (0..weights.len())
        .map(|i| (f64::from(n) * f64::from(table.pmf(i).0), 0.0))
        .collect();
    for u in uniform_pairs(60).take(n as usize) {
        let (item, pmf) = table.sample(u.to_array());
        assert!(weights[item] > 0.0 && pmf == table.pmf(item));
        cells[item].1 += 1.0;
    }
    assert!(pearson(&mut cells) > 1e-3);
}
