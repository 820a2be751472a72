//! The settings that a scene states, and the defaults where it states none.
//!
//! Measure: samples per pixel, relative errors.
//! Range: any loaded scene; an unknown name is an error with its file, line and the nearest valid name.
//! Source: docs/scene-format.md. Tested in `tests/loading/scene_files.rs`.

use super::{Adaptive, LightPathRule, PathReuseRule, RenderSettings, SamplerKind};
use crate::error::{Error, Result};
use crate::film::filter::FilterSampling;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::integrator::roulette::ParseRouletteError;
use crate::scene::description::{SceneDescription, WithLine};
use crate::scene::load::unknown_name;

/// The default number of samples per pixel.
const DEFAULT_SPP: u64 = 64;

/// The default error bound of an irradiance cache.
pub const DEFAULT_CACHE_ERROR: f64 = 0.05;

impl RenderSettings {
    /// The settings of a scene, and the defaults where it has none.
    ///
    /// # Errors
    /// An unknown name, with its line.
    pub fn of_scene(description: &SceneDescription) -> Result<Self> {
        let render = &description.render;
        let integrators = IntegratorKind::ALL.iter().map(|&i| (i.name(), i));
        let integrator = chosen(description, "integrator", &render.integrator, integrators)?;
        let samplers = SamplerKind::ALL.iter().map(|&s| (s.name(), s));
        let sampler = chosen(description, "sampler", &render.sampler, samplers)?;
        let ways = Adaptive::ALL.iter().map(|&a| (a.name(), a));
        let adaptive = chosen(description, "adaptive", &render.adaptive, ways)?;
        let roulette = roulette_of(description)?;
        let rules = LightPathRule::ALL.iter().map(|&rule| (rule.name(), rule));
        let light_paths = chosen(description, "light_paths", &render.light_paths, rules)?;
        let rules = PathReuseRule::ALL.iter().map(|&rule| (rule.name(), rule));
        let reuse = chosen(description, "reuse", &render.reuse, rules)?;
        let spp = render.spp.unwrap_or(DEFAULT_SPP);
        Ok(Self {
            integrator: integrator.unwrap_or_default(),
            sampler: sampler.unwrap_or_default(),
            seed: render.seed.unwrap_or(0),
            adaptive: adaptive.unwrap_or_default(),
            filter_sampling: FilterSampling::default(),
            max_bounces: render.max_bounces,
            roulette,
            has_window_pilot: true,
            light_paths: light_paths.unwrap_or_default(),
            reuse: reuse.unwrap_or_default(),
            occlusion_distance: render.occlusion_distance,
            cache_error: render.cache_error.unwrap_or(DEFAULT_CACHE_ERROR),
            ..Self::new(description.film.size, spp)
        })
    }
}

/// The choice that the scene names, among those that exist.
fn chosen<T>(
    description: &SceneDescription,
    key: &str,
    wanted: &Option<WithLine<String>>,
    mut all: impl Iterator<Item = (&'static str, T)> + Clone,
) -> Result<Option<T>> {
    let Some(wanted) = wanted else {
        return Ok(None);
    };
    let names: Vec<&str> = all.clone().map(|(name, _)| name).collect();
    match all.find(|(name, _)| *name == wanted.value) {
        Some((_, choice)) => Ok(Some(choice)),
        None => Err(Error::scene(unknown_name("name", &wanted.value, &names))
            .in_file(&description.file)
            .at_line(wanted.line)
            .in_field(format!("render.{key}"))),
    }
}

/// The rule of Russian roulette of a scene.
fn roulette_of(description: &SceneDescription) -> Result<Option<Roulette>> {
    let Some(wanted) = &description.render.roulette else {
        return Ok(None);
    };
    let roulette = wanted.value.parse().map_err(|error| {
        let message = match error {
            ParseRouletteError::Name => unknown_name("name", &wanted.value, Roulette::NAMES),
            ParseRouletteError::Window => error.to_string(),
        };
        Error::scene(message)
            .in_file(&description.file)
            .at_line(wanted.line)
            .in_field("render.roulette")
    });
    roulette.map(Some)
}
