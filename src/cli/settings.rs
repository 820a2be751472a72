//! The settings of a render: the command line over the scene over the defaults.
//!
//! Measure: as in `render/settings.rs`.
//! Range: what is out of it is an error that names the flag, or the scene's line.
//! Source: none needed. Tested in `tests/command.rs` and `tests/bad_input.rs`.

use super::args::RenderArguments;
use crate::error::{Error, Result};
use crate::film::Window;
use crate::integrator::Roulette;
use crate::render::settings::{Budget, IntegratorKind, RenderSettings, SamplerKind};
use crate::scene::description::{SceneDescription, Written};
use crate::scene::load::unknown_name;

/// Samples per pixel where neither scene nor command says.
const DEFAULT_SPP: u64 = 64;

/// The command line over the scene over the defaults.
pub fn settings(
    arguments: &RenderArguments,
    description: &SceneDescription,
) -> Result<RenderSettings> {
    let render = &description.render;
    let integrator = from_scene(
        description,
        "integrator",
        &render.integrator,
        IntegratorKind::ALL,
    )?;
    let sampler = from_scene(description, "sampler", &render.sampler, SamplerKind::ALL)?;
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
    let wanted_spp = arguments.spp.or(render.spp);
    Ok(RenderSettings {
        integrator: arguments.integrator.or(integrator).unwrap_or_default(),
        sampler: arguments.sampler.or(sampler).unwrap_or_default(),
        seed: arguments.seed.or(render.seed).unwrap_or(0),
        budget: Budget {
            // A time that is asked for is not cut short by what the scene says by default.
            spp: match arguments.time {
                Some(_) => arguments.spp,
                None => Some(wanted_spp.unwrap_or(DEFAULT_SPP)),
            },
            time: arguments.time,
        },
        max_bounces: arguments.max_bounces.or(render.max_bounces),
        roulette: Roulette::default(),
        kernel: arguments.kernel,
        threads: arguments.tracing.options().threads,
        window,
        tile_size: 32,
    })
}

/// A choice that the scene names, among those that there are.
fn from_scene<T: Copy + Named>(
    description: &SceneDescription,
    key: &str,
    wanted: &Option<Written<String>>,
    all: &[T],
) -> Result<Option<T>> {
    let Some(wanted) = wanted else {
        return Ok(None);
    };
    if let Some(found) = all.iter().find(|choice| choice.name() == wanted.value) {
        return Ok(Some(*found));
    }
    let names: Vec<&str> = all.iter().map(|choice| choice.name()).collect();
    Err(Error::scene(unknown_name("name", &wanted.value, &names))
        .in_file(&description.file)
        .at_line(wanted.line)
        .in_field(format!("render.{key}")))
}

/// A choice with a name.
trait Named {
    fn name(&self) -> &'static str;
}

impl Named for IntegratorKind {
    fn name(&self) -> &'static str {
        Self::name(*self)
    }
}

impl Named for SamplerKind {
    fn name(&self) -> &'static str {
        Self::name(*self)
    }
}
