//! The bench's own scenes, generated in code: each is difficult for an acceleration structure in its own way.
//!
//! Measure: world units; sizes as the approximate number of triangles.
//! Range: any size; the smallest have a few dozen triangles. The same size gives the same scene everywhere.
//! Source: none needed. Tested in `lab/tests/bench/scenes.rs`.

use super::cornell_box::cornell_box;
use super::random::Random;
use crate::scene_builder::terrain::{fractal, grid};
use crate::scene_builder::{emitting, matte, mesh, named_shape, scene, sky, sun};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::{DVec2, DVec3};
use etendue::internals::scene::description::{
    GeometryDescription, SceneDescription, ShapeDescription,
};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// A scene that the bench generates.
#[derive(Debug, Clone, Copy)]
pub struct BenchScene {
    /// Name on the command line.
    pub name: &'static str,
    /// A sentence about the scene.
    pub sentence: &'static str,
    /// Triangles at full size.
    pub triangles: usize,
    make: fn(usize) -> SceneDescription,
}

impl BenchScene {
    /// Builds the scene with about `triangles` triangles.
    pub fn describe(&self, triangles: usize) -> SceneDescription {
        (self.make)(triangles)
    }
}

/// All generated scenes, the small ones first.
pub const SCENES: &[BenchScene] = &[
    BenchScene {
        name: "cornell-box",
        sentence: "The Cornell box: a few large triangles, so that traversal is short.",
        triangles: 32,
        make: |_| cornell_box(),
    },
    BenchScene {
        name: "needles",
        sentence: "A ball of long thin triangles like hair, whose boxes are mostly empty.",
        triangles: 10_000,
        make: needles,
    },
    BenchScene {
        name: "soup",
        sentence: "Triangles of all sizes and directions at random, which share no edges.",
        triangles: 50_000,
        make: soup,
    },
    BenchScene {
        name: "stadium",
        sentence: "A small finely tessellated knot in a plain bowl ten thousand times its size.",
        triangles: 200_000,
        make: stadium,
    },
    BenchScene {
        name: "terrain",
        sentence: "Mountains of fractal height, one large mesh, under sun and sky.",
        triangles: 2_000_000,
        make: terrain,
    },
];

/// The file of a furnished room, a scene that is too large to be compiled into the program: below the current folder,
/// or in the sources from which the program was built. `None` if neither exists.
pub fn suzanne_room() -> Option<PathBuf> {
    let file = Path::new("scenes/suzanne-room/suzanne-room.toml");
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    let in_sources = sources.map(|folder| folder.join(file));
    let places = [Some(file.to_path_buf()), in_sources];
    places.into_iter().flatten().find(|place| place.is_file())
}

/// Fractal mountains on a square of side 2 centred at the origin, a fifth of that high, seen from above one edge.
fn terrain(triangles: usize) -> SceneDescription {
    let squares = f64::from(triangles as u32 / 2).sqrt().round().max(4.0) as u32;
    let height = |p: DVec2| {
        let rough = fractal(11, 3.0 * p, 12, 0.45);
        0.25 * rough * rough.abs().sqrt()
    };
    let (positions, indices) = grid(squares, squares, |u| {
        let p = 2.0 * u - 1.0;
        DVec3::new(p.x, height(p), p.y)
    });
    let eye = DVec3::new(0.1, 0.45, 1.15);
    let mut scene = scene("terrain", eye, DVec3::new(0.0, -0.05, 0.0), 55.0);
    scene.materials = vec![matte("rock", Rgb::new(0.42, 0.38, 0.33))];
    scene.shapes = vec![named_shape("mountains", 0, mesh(positions, indices))];
    scene.lights = vec![
        sun(DVec3::new(-0.7, 0.45, -0.2), Rgb::new(2.6, 2.4, 2.1)),
        sky(Rgb::new(0.3, 0.38, 0.5)),
    ];
    scene
}

/// A ball of hairs: each is one triangle that stands on a sphere of radius 0.6, a thousandth as wide as long.
fn needles(triangles: usize) -> SceneDescription {
    let mut random = Random::new(12, 0);
    let mut positions = Vec::with_capacity(3 * triangles);
    for _ in 0..triangles.max(1) {
        let direction = random.direction().as_dvec3();
        let root = 0.6 * direction;
        let tip = random.between(0.8, 1.0) * direction + 0.1 * random.in_cube();
        let across = (tip - root).cross(random.in_cube()).normalize_or(DVec3::X);
        let half_width = 0.5e-3 * (tip - root).length() * across;
        positions.extend([root - half_width, root + half_width, tip]);
    }
    let hairs = separate(positions);
    let mut scene = scene("needles", DVec3::new(0.0, 0.5, 3.4), DVec3::ZERO, 40.0);
    scene.materials = vec![
        matte("hair", Rgb::new(0.6, 0.42, 0.25)),
        matte("ground", Rgb::grey(0.5)),
        matte("black", Rgb::BLACK),
    ];
    scene.shapes = vec![
        named_shape("hairs", 0, hairs),
        ground(1, -1.2, 6.0),
        lamp(2, 4.0, 1.5, Rgb::grey(14.0)),
    ];
    scene.lights = vec![sky(Rgb::grey(0.25))];
    scene
}

/// A triangle soup with sizes that are log-uniform over two orders of magnitude.
fn soup(triangles: usize) -> SceneDescription {
    let mut random = Random::new(13, 0);
    let mut positions = Vec::with_capacity(3 * triangles);
    for _ in 0..triangles.max(1) {
        let centre = random.in_cube();
        let size = 0.3 * 100.0_f64.powf(-f64::from(random.uniform()));
        positions.extend([0; 3].map(|_| centre + size * random.in_cube()));
    }
    let mut scene = scene("soup", DVec3::new(1.0, 1.0, 3.6), DVec3::ZERO, 40.0);
    scene.materials = vec![
        matte("scraps", Rgb::new(0.75, 0.7, 0.6)),
        matte("black", Rgb::BLACK),
    ];
    scene.shapes = vec![
        named_shape("scraps", 0, separate(positions)),
        lamp(1, 4.0, 2.0, Rgb::grey(10.0)),
    ];
    scene.lights = vec![sky(Rgb::new(0.4, 0.45, 0.5))];
    scene
}

/// A knot 0.1 across in a bowl 1000 across.
fn stadium(triangles: usize) -> SceneDescription {
    let along = f64::from(triangles as u32 / 2 * 8).sqrt().round().max(16.0) as u32;
    let around = (along / 8).max(3);
    let (positions, indices) = grid(along, around, |u| 0.03 * knot(TAU * u.x, TAU * u.y));
    let (bowl, plain) = grid(24, 24, |u| {
        let p = 2.0 * u - 1.0;
        let height = 60.0 * p.length_squared().powi(2);
        DVec3::new(500.0 * p.x, height - 0.0225, 500.0 * p.y)
    });
    let mut scene = scene(
        "stadium",
        DVec3::new(0.0, 0.1, 0.32),
        DVec3::new(0.0, 0.03, 0.0),
        40.0,
    );
    scene.materials = vec![
        matte("knot", Rgb::new(0.7, 0.3, 0.2)),
        matte("bowl", Rgb::new(0.5, 0.55, 0.5)),
        matte("black", Rgb::BLACK),
    ];
    scene.shapes = vec![
        named_shape("knot", 0, mesh(positions, indices)),
        named_shape("bowl", 1, mesh(bowl, plain)),
        lamp(2, 400.0, 60.0, Rgb::grey(20.0)),
    ];
    scene.lights = vec![sky(Rgb::new(0.5, 0.6, 0.8))];
    scene
}

/// A tube around a trefoil, about 3 across in each direction.
fn knot(along: f64, around: f64) -> DVec3 {
    let curve = |s: f64| {
        let radius = 1.1 + 0.5 * (1.5 * s).cos();
        DVec3::new(radius * s.cos(), 0.5 * (1.5 * s).sin(), radius * s.sin())
    };
    // The curve closes after two turns about the axis.
    let s = 2.0 * along;
    let step = TAU / 65_536.0;
    let tangent = (curve(s + step) - curve(s - step)).normalize();
    let side = tangent.cross(DVec3::Y).normalize();
    let up = side.cross(tangent);
    curve(s) + 0.25 * (around.cos() * side + around.sin() * up)
}

/// A mesh of separate triangles, with three vertices each.
fn separate(positions: Vec<DVec3>) -> GeometryDescription {
    let triangles = positions.len() as u32 / 3;
    let indices = (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    mesh(positions, indices.collect())
}

/// A horizontal square at the given height.
fn ground(material: usize, height: f64, half: f64) -> ShapeDescription {
    let square = GeometryDescription::Rectangle {
        corner: DVec3::new(-half, height, -half),
        edge_u: DVec3::new(0.0, 0.0, 2.0 * half),
        edge_v: DVec3::new(2.0 * half, 0.0, 0.0),
    };
    named_shape("ground", material, square)
}

/// A square light above the origin that shines down.
fn lamp(material: usize, height: f64, half: f64, radiance: Rgb) -> ShapeDescription {
    let square = GeometryDescription::Rectangle {
        corner: DVec3::new(-half, height, -half),
        edge_u: DVec3::new(2.0 * half, 0.0, 0.0),
        edge_v: DVec3::new(0.0, 0.0, 2.0 * half),
    };
    emitting(named_shape("lamp", material, square), radiance)
}
