//! The Cornell box as measured in 1985.
//!
//! Measure: millimetres; reflectances as linear Rec. 709.
//! Range: one scene.
//! Source: the Cornell University Program of Computer Graphics' published measurements, as in `scenes/cornell-box`,
//! with which `lab/tests/bench/scenes.rs` compares it.

use crate::scene_builder::{emitting, matte, mesh, named_shape, scene};
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::vec::DVec3;
use etendue::internals::scene::description::{GeometryDescription, SceneDescription};

const WHITE: usize = 0;
const RED: usize = 1;
const GREEN: usize = 2;
const BLACK: usize = 3;

type Corners = [[f64; 3]; 4];

const FLOOR: Corners = [
    [552.8, 0.0, 0.0],
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 559.2],
    [549.6, 0.0, 559.2],
];
const CEILING: Corners = [
    [556.0, 548.8, 0.0],
    [556.0, 548.8, 559.2],
    [0.0, 548.8, 559.2],
    [0.0, 548.8, 0.0],
];
const BACK: Corners = [
    [549.6, 0.0, 559.2],
    [0.0, 0.0, 559.2],
    [0.0, 548.8, 559.2],
    [556.0, 548.8, 559.2],
];
const RIGHT: Corners = [
    [0.0, 0.0, 559.2],
    [0.0, 0.0, 0.0],
    [0.0, 548.8, 0.0],
    [0.0, 548.8, 559.2],
];
const LEFT: Corners = [
    [552.8, 0.0, 0.0],
    [549.6, 0.0, 559.2],
    [556.0, 548.8, 559.2],
    [556.0, 548.8, 0.0],
];

/// The top faces of both blocks, which stand on the floor.
const SHORT: Corners = [
    [130.0, 165.0, 65.0],
    [82.0, 165.0, 225.0],
    [240.0, 165.0, 272.0],
    [290.0, 165.0, 114.0],
];
const TALL: Corners = [
    [423.0, 330.0, 247.0],
    [265.0, 330.0, 296.0],
    [314.0, 330.0, 456.0],
    [472.0, 330.0, 406.0],
];

/// The description of the Cornell box.
pub fn cornell_box() -> SceneDescription {
    let eye = DVec3::new(278.0, 273.0, -800.0);
    let mut scene = scene("cornell-box", eye, DVec3::new(278.0, 273.0, 0.0), 39.3077);
    scene.materials = vec![
        matte("white", Rgb::new(0.725, 0.71, 0.68)),
        matte("red", Rgb::new(0.63, 0.065, 0.05)),
        matte("green", Rgb::new(0.14, 0.45, 0.091)),
        matte("black", Rgb::BLACK),
    ];
    scene.film.size = (512, 512);
    // The light is slightly below the ceiling, whose opening for it is not modelled, and shines down.
    let light = GeometryDescription::Rectangle {
        corner: DVec3::new(213.0, 548.3, 227.0),
        edge_u: DVec3::new(130.0, 0.0, 0.0),
        edge_v: DVec3::new(0.0, 0.0, 105.0),
    };
    scene.shapes = vec![
        named_shape("floor", WHITE, wall(&FLOOR)),
        named_shape("ceiling", WHITE, wall(&CEILING)),
        named_shape("back wall", WHITE, wall(&BACK)),
        named_shape("right wall", GREEN, wall(&RIGHT)),
        named_shape("left wall", RED, wall(&LEFT)),
        emitting(
            named_shape("light", BLACK, light),
            Rgb::new(17.0, 12.0, 4.0),
        ),
        named_shape("short block", WHITE, block(&SHORT)),
        named_shape("tall block", WHITE, block(&TALL)),
    ];
    scene
}

fn wall(corners: &Corners) -> GeometryDescription {
    let positions = corners.map(DVec3::from_array).to_vec();
    mesh(positions, vec![[0, 1, 2], [0, 2, 3]])
}

fn block(top: &Corners) -> GeometryDescription {
    let top = top.map(DVec3::from_array);
    let bottom = top.map(|p| p.with_y(0.0));
    let side = |i: u32| {
        let next = (i + 1) % 4;
        [[next, i, i + 4], [next, i + 4, next + 4]]
    };
    let sides = (0..4).flat_map(side);
    let indices = [[0, 1, 2], [0, 2, 3]].into_iter().chain(sides).collect();
    mesh([top, bottom].concat(), indices)
}
