//! The layers of an image: the error estimates of each pixel, and the properties of its first hit.
//!
//! Measure: `se` is the standard error of R, G and B, and of the layers that follow; `freedom` the degrees of freedom
//! of the first three; `spp` the sample count; `flag` is 1 where the standard error is not reliable; `half` the image
//! from one half of the samples, which `etendue denoise` compares with the other half; `cache` the number of records of
//! an irradiance cache that estimate the indirect light; `albedo`, `normal` and `depth` as in `render/first_hit.rs`.
//! Range: renders with layers requested.
//! Source: the channels of docs/accuracy.md. Tested in `cli/tests/command/layers.rs` and `tests/rendering/session.rs`.

use crate::error::{Error, Result};
use crate::film::Film;
use crate::image::{Image, Layer};
use crate::render::cache_prepass::cover;
use crate::render::first_hit::{FirstHit, first_hits};
use crate::render::settings::RenderSettings;
use crate::render::{RenderInput, Rendered};

/// The number of samples that the first hits are averaged over. They have little noise, and are traced in addition to
/// the samples of the image: a few hundredths of the time of a long render, and in a short one enough samples to guide
/// the noise filter.
fn samples_of_first_hits(spp: u64) -> u64 {
    (spp / 16).clamp(16, 64).min(spp).max(1)
}

/// Computes all layers of a render on rayon's current threads.
///
/// # Errors
/// A usage error for a render without layers requested.
pub fn layers(
    input: &RenderInput<'_>,
    settings: &RenderSettings,
    rendered: &Rendered,
) -> Result<Vec<Layer>> {
    if !settings.layers {
        return Err(Error::usage(
            "only a render that was asked for layers has what they are made of",
        ));
    }
    let of_scene = of_scene(input, settings, rendered, rendered.spp);
    Ok(with_film(of_scene, &rendered.film))
}

/// Computes the layers that need the scene, for a render of `spp` samples per pixel, on rayon's current threads.
pub fn of_scene(
    input: &RenderInput<'_>,
    settings: &RenderSettings,
    rendered: &Rendered,
    spp: u64,
) -> Vec<Layer> {
    let spp = samples_of_first_hits(spp);
    let first = first_hits(input.scene, input.filter, settings, spp);
    let of_first = |name: &str, get: &dyn Fn(&FirstHit) -> f32| Layer {
        name: name.to_owned(),
        samples: first.iter().map(get).collect(),
    };
    let mut layers = vec![
        of_first("albedo.R", &|hit| hit.albedo.to_array()[0]),
        of_first("albedo.G", &|hit| hit.albedo.to_array()[1]),
        of_first("albedo.B", &|hit| hit.albedo.to_array()[2]),
        of_first("normal.X", &|hit| hit.normal.x),
        of_first("normal.Y", &|hit| hit.normal.y),
        of_first("normal.Z", &|hit| hit.normal.z),
        of_first("depth.Z", &|hit| hit.distance),
        of_first("se.albedo", &|hit| hit.standard_errors.albedo),
        of_first("se.normal", &|hit| hit.standard_errors.normal),
        of_first("se.depth", &|hit| hit.standard_errors.distance),
    ];
    layers.extend(rendered.cache.as_ref().map(|cache| {
        let cover = cover(input.scene, input.filter, settings, cache);
        Layer {
            name: "cache.Y".to_owned(),
            samples: cover.into_iter().map(|count| count as f32).collect(),
        }
    }));
    layers
}

/// Adds the layers that are computed from the samples to those of the scene.
pub fn with_film(mut layers: Vec<Layer>, film: &Film) -> Vec<Layer> {
    let bars = film.error_bars();
    layers.extend(channels("se", &bars.standard_errors));
    layers.extend(channels("half", &film.develop_half()));
    layers.push(Layer {
        name: "freedom.Y".to_owned(),
        samples: bars.freedom,
    });
    layers.push(Layer {
        name: "flag.Y".to_owned(),
        samples: bars
            .flags
            .into_iter()
            .map(|is| if is { 1.0 } else { 0.0 })
            .collect(),
    });
    layers.push(Layer {
        name: "spp.Y".to_owned(),
        samples: film.sample_counts().iter().map(|&n| n as f32).collect(),
    });
    layers
}

/// The channels of an image, as layers with this name.
pub fn channels(name: &str, image: &Image) -> impl Iterator<Item = Layer> {
    ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(move |(c, channel)| Layer {
            name: format!("{name}.{channel}"),
            samples: image.pixels().iter().map(|it| it.to_array()[c]).collect(),
        })
}
