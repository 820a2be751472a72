//! A scene, ready to be rendered by any variant, with the time that each render takes.
//!
//! Measure: pixels, samples per pixel, seconds.
//! Range: one structure for each way to trace that is asked for.
//! Source: `render/`. Tested in `lab/tests/reports/study.rs`.

use super::clock::{Seconds, Stopwatch};
use super::variant::Variant;
use etendue::Result;
use etendue::internals::accel::AccelOptions;
use etendue::internals::effects::EffectSet;
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::render::settings::{Budget, RenderSettings};
use etendue::internals::render::{RenderObserver, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::prepare::prepare;

/// A scene that is ready.
pub struct PreparedScene {
    filter: Filter,
    size: (u32, u32),
    scenes: Vec<(AccelOptions, Scene)>,
    /// What was noticed on the way.
    pub notes: Vec<String>,
    /// Seconds that building the structures took, with how they trace.
    pub builds: Vec<(AccelOptions, f64)>,
}

/// A finished render.
pub struct Shot {
    /// The picture.
    pub film: Film,
    /// What it took.
    pub seconds: Seconds,
    /// Samples that were not finite.
    pub rejected: u64,
}

impl PreparedScene {
    /// Makes the scene ready for all of these ways to trace.
    ///
    /// # Errors
    /// A scene that is not valid, or what a backend says.
    pub fn new(
        description: &SceneDescription,
        options: impl IntoIterator<Item = AccelOptions>,
    ) -> Result<Self> {
        let mut this = Self {
            filter: Filter::new(&description.film.filter),
            size: description.film.size,
            scenes: Vec::new(),
            notes: Vec::new(),
            builds: Vec::new(),
        };
        for options in options {
            if this.scenes.iter().any(|(known, _)| *known == options) {
                continue;
            }
            let prepared = prepare(description, options)?;
            if this.scenes.is_empty() {
                this.notes = prepared.notes;
            }
            this.builds
                .push((options, prepared.build_time.as_secs_f64()));
            this.scenes.push((options, prepared.scene));
        }
        Ok(this)
    }

    /// What the scene calls for.
    pub fn effects(&self) -> EffectSet {
        self.scenes[0].1.effects
    }

    /// The picture's size.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The filter.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// The scene as a variant traces it.
    ///
    /// # Panics
    /// If it was not made ready for that.
    pub fn scene(&self, options: AccelOptions) -> &Scene {
        let found = self.scenes.iter().find(|(known, _)| *known == options);
        &found.expect("it was made ready for every variant").1
    }

    /// The settings of a render of a variant.
    pub fn settings(&self, variant: &Variant, spp: u64, seed: u64) -> RenderSettings {
        RenderSettings {
            budget: Budget::samples(spp),
            seed,
            // Small pictures are not worth fewer tiles than threads.
            tile_size: 16,
            window: RenderSettings::new(self.size, spp).window,
            ..variant.settings.clone()
        }
    }

    /// Renders; `None` if it was cancelled.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(
        &self,
        variant: &Variant,
        settings: &RenderSettings,
        watch: &dyn RenderObserver,
    ) -> Result<Option<Shot>> {
        let scene = self.scene(variant.options);
        let stopwatch = Stopwatch::start();
        let rendered = render(scene, &self.filter, self.size, settings, watch)?;
        let seconds = stopwatch.read();
        Ok((!rendered.cancelled).then_some(Shot {
            film: rendered.film,
            seconds,
            rejected: rendered.rejected.count,
        }))
    }
}
