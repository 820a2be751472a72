//! The settings of a render: the command line over the scene over the defaults.
//!
//! Measure: as in `render/settings.rs`.
//! Range: what is out of it is an error that names the flag, or the scene's line.
//! Source: none needed. Tested in `tests/command/render.rs` and `tests/loading/bad_input.rs`.

use super::args::RenderArguments;
use crate::error::{Error, Result};
use crate::film::Window;
use crate::integrator::Roulette;
use crate::integrator::technique::EmissionRule;
use crate::render::settings::{Budget, ErrorTarget, RenderSettings};
use crate::scene::description::SceneDescription;

/// The command line over the scene over the defaults.
pub fn settings(
    arguments: &RenderArguments,
    description: &SceneDescription,
) -> Result<RenderSettings> {
    let of_scene = RenderSettings::of_scene(description)?;
    let (width, height) = description.film.size;
    let window = match arguments.crop {
        None => Window {
            x: 0,
            y: 0,
            width,
            height,
        },
        Some([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 && x1 <= width && y1 <= height => Window {
            x: x0,
            y: y0,
            width: x1 - x0,
            height: y1 - y0,
        },
        Some([x0, y0, x1, y1]) => {
            return Err(Error::usage(format!(
                "--crop {x0},{y0},{x1},{y1} is not a part of the picture of {width}x{height} pixels"
            )));
        }
    };
    let settings = RenderSettings {
        integrator: arguments.integrator.unwrap_or(of_scene.integrator),
        sampler: arguments.sampler.unwrap_or(of_scene.sampler),
        seed: arguments.seed.unwrap_or(of_scene.seed),
        budget: Budget {
            // A time or an error that is asked for is not cut short by what the scene says by default.
            spp: if arguments.time.is_some() || arguments.error.is_some() {
                arguments.spp
            } else {
                arguments.spp.or(of_scene.budget.spp)
            },
            time: arguments.time.or(arguments.max_time),
            error: arguments.error.map(|rel_rmse| ErrorTarget {
                rel_rmse,
                confidence: arguments.confidence,
            }),
        },
        adaptive: arguments.adaptive.unwrap_or(of_scene.adaptive),
        bars: arguments.layers || arguments.denoise.is_some(),
        max_bounces: arguments.max_bounces.or(of_scene.max_bounces),
        roulette: arguments.roulette.or(of_scene.roulette),
        occlusion_distance: arguments.occlusion_distance.or(of_scene.occlusion_distance),
        kernel: arguments.kernel,
        threads: arguments.tracing.options().threads,
        window,
        ..of_scene
    };
    refuse_endless(&settings)?;
    Ok(settings)
}

/// Refuses settings with which a path may never end.
pub fn refuse_endless(settings: &RenderSettings) -> Result<()> {
    match may_be_endless(settings) {
        true => Err(Error::usage(
            "without roulette a path between white walls never ends: give --max-bounces too, such as --max-bounces 1000",
        )),
        false => Ok(()),
    }
}

/// Whether nothing but absorption ends a path.
fn may_be_endless(settings: &RenderSettings) -> bool {
    let has_coin = settings.integrator.technique().is_none_or(
        |technique| matches!(technique.emission, EmissionRule::Coin { unlit, .. } if unlit > 0.0),
    );
    settings.roulette() == Roulette::None && settings.most_bounces().is_none() && !has_coin
}
