//! A render with everything that is known before it starts.
//!
//! Measure: as in its parts.
//! Range: any scene that is ready to render.
//! Source: none needed. Tested in `cli/tests/command/render.rs`.

use crate::args::RenderArguments;
use crate::recommendation::{LightPathReport, ReuseReport};
use etendue::internals::effects::Effect;
use etendue::internals::film::filter::Filter;
use etendue::internals::render::auto::{PathChoices, Recommendation};
use etendue::internals::render::kernel;
use etendue::internals::render::settings::RenderSettings;
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;

/// A render with everything that is known before it starts.
pub struct RenderJob<'a> {
    pub arguments: &'a RenderArguments,
    pub description: &'a SceneDescription,
    pub scene: &'a Scene,
    pub settings: &'a RenderSettings,
    /// The recommendation of `auto`, if it was requested.
    pub auto: Option<&'a Recommendation>,
    /// The choices of pilots for a render by `path`.
    pub choices: PathChoices,
}

impl RenderJob<'_> {
    /// Returns descriptions of everything that biases the image.
    pub fn bias(&self) -> Vec<String> {
        let mut bias = self.settings.bias(self.scene.effects);
        bias.extend(
            self.arguments
                .denoise
                .map(|filter| filter.bias().to_owned()),
        );
        bias
    }

    /// Describes the reconstruction filter and how it is estimated.
    pub fn filter(&self) -> String {
        let description = self.description.film.filter;
        let sampling = self.settings.filter_sampling_of(&Filter::new(&description));
        format!("{}, {}", description.name(), sampling.name())
    }

    /// Summarises the scene, the tracing options and the kernel.
    pub fn summary(&self) -> String {
        let world = &self.scene.world;
        let shapes = world
            .geometries()
            .iter()
            .chain(world.groups().iter().flatten());
        let (shapes, primitives) = shapes.fold((0_usize, 0), |(shapes, primitives), shape| {
            (shapes + 1, primitives + shape.primitive_count())
        });
        let instances = match world.instances().len() {
            0 => String::new(),
            count => format!("{count} instances, "),
        };
        let (width, height) = self.description.film.size;
        let effects = self.settings.effects(self.scene.effects);
        let effects: Vec<&str> = effects.iter().map(Effect::name).collect();
        let effects = if effects.is_empty() {
            "the scene needs no effect".to_owned()
        } else {
            format!("effects {}", effects.join(", "))
        };
        let light_paths = match self.choices.light_paths.map(LightPathReport::from) {
            Some(choice) => choice.describe(),
            None => self.settings.light_path_rule().name().to_owned(),
        };
        let reuse = match self.choices.reuse.map(ReuseReport::from) {
            Some(choice) => choice.describe(),
            None => self.settings.reuse().name().to_owned(),
        };
        format!(
            "scene: {shapes} shapes, {primitives} primitives, {instances}{} materials, {} lights; {width} x {height} pixels\n\
             tracing: {}, {}, {} quality; {:.1} MB\n\
             plan: kernel {}; {}\n\
             filter: {}\n\
             roulette: {}\n\
             light paths: {}\n\
             reuse: {}\n",
            self.description.materials.len(),
            self.scene.lights.len(),
            self.arguments.tracing.backend.name(),
            self.arguments.tracing.precision.name(),
            self.arguments.tracing.options().quality().name(),
            self.scene.accel.memory() as f64 / 1e6,
            kernel(self.scene, self.settings).name(),
            effects,
            self.filter(),
            self.settings.roulette(),
            light_paths,
            reuse,
        )
    }
}
