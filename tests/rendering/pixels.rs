//! Tests of pixel reconstruction: a pixel is the mean radiance weighted by the reconstruction filter about its centre. At
//! a straight edge it is the filter's integral beyond the edge, which has a closed form.

use crate::common::scene::{diffuse, patch_scene, ready, rectangle, surface};
use etendue::internals::accel::Backend;
use etendue::internals::film::filter::{Filter, FilterDescription, FilterKind};
use etendue::internals::math::stats::Moments;
use etendue::internals::math::vec::{DAffine3, DVec3};
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{NullRenderObserver, render};
use etendue::internals::scene::description::{CameraDescription, SceneDescription};

/// Number of pixels across the edge. Pixels along the edge are replicates.
const ACROSS: u32 = 10;
const ALONG: u32 = 32;

/// A scene with radiance 1 beyond an edge, which is `edge` pixels from the image's left or, if `turned`, from its top.
fn half_lit(edge: f64, turned: bool) -> SceneDescription {
    let mut scene = patch_scene(DVec3::Z, DVec3::ZERO, diffuse(0.0));
    scene.film.size = if turned {
        (ALONG, ACROSS)
    } else {
        (ACROSS, ALONG)
    };
    // A pixel has width 1/100 at distance 1; rows run downwards.
    let pixel = 0.01;
    let fov = 2.0 * (0.5 * pixel * f64::from(scene.film.size.1)).atan();
    scene.camera = CameraDescription::pinhole(DAffine3::from_translation(DVec3::Z), fov);
    let from_middle = pixel * (edge - 0.5 * f64::from(ACROSS));
    let lit = if turned {
        rectangle(
            [-1.0, -1.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 1.0 - from_middle, 0.0],
        )
    } else {
        rectangle([from_middle, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])
    };
    scene.shapes = vec![surface(lit, 1.0)];
    scene
}

/// The integral of a filter over the half-plane more than `d` pixels to one side of its centre.
fn beyond(filter: FilterDescription, d: f64) -> f64 {
    if d < 0.0 {
        return 1.0 - beyond(filter, -d);
    }
    let left = (filter.radius - d).max(0.0);
    match filter.kind {
        FilterKind::Box => 0.5 * left / filter.radius,
        FilterKind::Tent => 0.5 * (left / filter.radius).powi(2),
        // From the published cubics, for a radius of 2.
        FilterKind::Mitchell if d < 1.0 => {
            0.5 - (5.25 * d.powi(4) - 12.0 * d.powi(3) + 16.0 * d) / 18.0
        }
        FilterKind::Mitchell => (1.75 * left.powi(4) - 2.0 * left.powi(3)) / 18.0,
        kind => unreachable!("{kind:?} is not asked for"),
    }
}

#[test]
fn pixel_values_at_an_edge_match_the_filter_integral() {
    for (kind, radius) in [
        (FilterKind::Box, 0.5),
        (FilterKind::Box, 1.3),
        (FilterKind::Tent, 1.0),
        (FilterKind::Mitchell, 2.0),
    ] {
        let description = FilterDescription { kind, radius };
        for (edge, turned) in [(4.3, false), (5.0, false), (4.3, true)] {
            let scene = half_lit(edge, turned);
            let size = scene.film.size;
            let settings = RenderSettings::new(size, 1 << 10);
            let filter = Filter::new(&description);
            let scene = ready(&scene, Backend::ALL[0]);
            let rendered = render(&scene, &filter, size, &settings, &NullRenderObserver);
            let image = rendered.expect("valid settings").film.develop();
            for i in 0..ACROSS {
                let seen = Moments::of((0..ALONG).map(|j| {
                    let [x, y] = if turned { [j, i] } else { [i, j] };
                    f64::from(image.get(x, y).to_array()[1])
                }));
                let exact = beyond(description, edge - (f64::from(i) + 0.5));
                let error = seen.standard_error().expect("32 pixels");
                let what = format!("{kind:?} {edge} {turned} {i}: {seen:?}, exact {exact}");
                // The filter's table has an error of at most 1e-4.
                assert!((seen.mean() - exact).abs() <= 5.2 * error + 2e-4, "{what}");
                assert!(error <= 2e-3, "{what}");
            }
        }
    }
}
