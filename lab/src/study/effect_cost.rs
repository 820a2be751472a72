//! The cost of each effect of a scene: its time, and the light that it carries, measured by rendering with and without
//! it in turn.
//!
//! Both renders of a pair use the same random numbers, so that they differ in the effect only.
//!
//! Measure: shares of the time and of the image's mean luminance. A negative share of time is an effect that saves
//! time, such as one that terminates paths early.
//! Range: at least two rounds; each has a seed of its own.
//! Source: docs/architecture.md, "Effects". Tested in `cli/tests/command/plan.rs`.

use etendue::Result;
use etendue::internals::accel::AccelOptions;
use etendue::internals::effects::{Effect, Kernel};
use etendue::internals::film::filter::Filter;
use etendue::internals::math::rgb::Rgb;
use etendue::internals::math::stats::{Moments, Spread, student_quantile};
use etendue::internals::plan::{Plan, without};
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::render::{RenderObserver, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::prepare::prepare;

/// The settings of a measurement.
#[derive(Debug, Clone, Copy)]
pub struct CostSettings {
    /// Options of the acceleration structures.
    pub accel: AccelOptions,
    /// Samples per pixel of each render, at least 1.
    pub spp: u64,
    /// Number of pairs of renders for each result, at least 2.
    pub rounds: u64,
}

/// The cost of one effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectCost {
    /// The effect.
    pub effect: Effect,
    /// 1 - time without / time with.
    pub time: Spread,
    /// 1 - luminance without / luminance with; NaN for a black image.
    pub energy: f64,
    /// The standard error of `energy` over the rounds.
    pub energy_error: f64,
    /// The half width of the interval of `energy` with a confidence of 95 %.
    pub energy_margin: f64,
}

/// The costs of all effects of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCosts {
    /// The effects that are on.
    pub effects: Vec<EffectCost>,
    /// Time of the kernel with all effects over that of the selected kernel.
    pub everything: Spread,
}

/// Measures the costs; calls `done` with the completed fraction. `None` if the observer cancelled.
///
/// # Errors
/// A scene that becomes invalid, or a render that fails.
pub fn effect_costs(
    description: &SceneDescription,
    plan: &Plan,
    settings: &CostSettings,
    observer: &dyn RenderObserver,
    mut done: impl FnMut(f64),
) -> Result<Option<EffectCosts>> {
    let scene = prepare(description, settings.accel)?.scene;
    let filter = Filter::new(&description.film.filter);
    let bench = EffectBench {
        scene: &scene,
        filter: &filter,
        size: description.film.size,
        settings,
        observer,
    };
    let on: Vec<Effect> = plan.on().collect();
    let steps = on.len() as f64 + 1.0;
    let Some(pairs) = bench.pairs(&scene, Some(Kernel::Everything))? else {
        return Ok(None);
    };
    let everything = pairs
        .iter()
        .map(|[chosen, all]| all.seconds / chosen.seconds);
    let everything = Spread::of(everything.collect());
    done(1.0 / steps);
    let mut effects = Vec::new();
    for (index, effect) in on.into_iter().enumerate() {
        let other = prepare(&without(description, effect), settings.accel)?.scene;
        let Some(pairs) = bench.pairs(&other, None)? else {
            return Ok(None);
        };
        effects.push(cost(effect, &pairs));
        done((index as f64 + 2.0) / steps);
    }
    Ok(Some(EffectCosts {
        effects,
        everything,
    }))
}

/// The result of one render.
#[derive(Debug, Clone, Copy)]
struct RenderCost {
    seconds: f64,
    luminance: f64,
}

struct EffectBench<'a> {
    scene: &'a Scene,
    filter: &'a Filter,
    size: (u32, u32),
    settings: &'a CostSettings,
    observer: &'a dyn RenderObserver,
}

impl EffectBench<'_> {
    /// Renders the scene and another one in turn; `None` if cancelled.
    fn pairs(&self, other: &Scene, kernel: Option<Kernel>) -> Result<Option<Vec<[RenderCost; 2]>>> {
        let mut pairs = Vec::new();
        // The first round warms up the caches and is discarded.
        for round in 0..=self.settings.rounds {
            let Some(with) = self.outcome(self.scene, None, round)? else {
                return Ok(None);
            };
            let Some(without) = self.outcome(other, kernel, round)? else {
                return Ok(None);
            };
            if round > 0 {
                pairs.push([with, without]);
            }
        }
        Ok(Some(pairs))
    }

    fn outcome(
        &self,
        scene: &Scene,
        kernel: Option<Kernel>,
        seed: u64,
    ) -> Result<Option<RenderCost>> {
        let settings = RenderSettings {
            seed,
            kernel,
            threads: self.settings.accel.threads,
            ..RenderSettings::new(self.size, self.settings.spp)
        };
        let rendered = render(scene, self.filter, self.size, &settings, self.observer)?;
        let mean = rendered.film.mean().map(|x| x as f32);
        Ok((!rendered.cancelled).then(|| RenderCost {
            seconds: rendered.elapsed.as_secs_f64(),
            luminance: f64::from(<Rgb>::from(mean).luminance()),
        }))
    }
}

fn cost(effect: Effect, pairs: &[[RenderCost; 2]]) -> EffectCost {
    let share = |value: fn(&RenderCost) -> f64| {
        let shares = pairs
            .iter()
            .map(move |[with, without]| 1.0 - value(without) / value(with));
        shares.collect::<Vec<f64>>()
    };
    let energy = Moments::of(share(|outcome| outcome.luminance));
    let energy_error = energy.standard_error();
    let margin = energy_error.map(|error| student_quantile(energy.count(), 0.95) * error);
    EffectCost {
        effect,
        time: Spread::of(share(|outcome| outcome.seconds)),
        energy: energy.mean(),
        energy_error: energy_error.unwrap_or(f64::NAN),
        energy_margin: margin.unwrap_or(f64::NAN),
    }
}
