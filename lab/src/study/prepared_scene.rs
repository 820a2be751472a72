//! A scene prepared for rendering by any variant, with the time of each render.
//!
//! Measure: pixels, samples per pixel, seconds.
//! Range: one acceleration structure for each distinct set of options.
//! Source: `render/`. Tested in `lab/tests/reports/study.rs`.

use super::clock::{Seconds, Stopwatch};
use super::variant::Variant;
use etendue::Result;
use etendue::internals::accel::AccelOptions;
use etendue::internals::effects::EffectSet;
use etendue::internals::film::Film;
use etendue::internals::film::filter::Filter;
use etendue::internals::render::auto::{ResolvedSettings, resolve_auto};
use etendue::internals::render::settings::{Budget, RenderSettings};

use etendue::internals::render::{RenderInput, RenderObserver, Threads, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::SceneDescription;
use etendue::internals::scene::prepare::prepare;

/// A prepared scene.
pub struct PreparedScene {
    filter: Filter,
    size: (u32, u32),
    scenes: Vec<(AccelOptions, Scene)>,
    /// Notes from the preparation.
    pub notes: Vec<String>,
    /// Seconds of building each structure, with its options.
    pub builds: Vec<(AccelOptions, f64)>,
}

/// A finished render.
pub struct Shot {
    /// The film.
    pub film: Film,
    /// The duration of the render.
    pub seconds: Seconds,
    /// Number of samples that were not finite.
    pub rejected: u64,
}

impl PreparedScene {
    /// Prepares the scene for all of these options.
    ///
    /// # Errors
    /// A scene that is not valid, or an error of a backend.
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

    /// The effects that the scene needs.
    pub fn effects(&self) -> EffectSet {
        self.scenes[0].1.effects
    }

    /// The size of the image.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The reconstruction filter.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// The scene with the structure for these options.
    ///
    /// # Panics
    /// If the scene was not prepared for them.
    pub fn scene(&self, options: AccelOptions) -> &Scene {
        let found = self.scenes.iter().find(|(known, _)| *known == options);
        &found.expect("it was made ready for every variant").1
    }

    /// Replaces all that pilots choose in settings, as a render does, so that every render of a comparison has the same.
    ///
    /// # Errors
    /// The errors of [`resolve_auto`].
    pub fn resolve_auto(
        &self,
        settings: &RenderSettings,
        options: AccelOptions,
        observer: &dyn RenderObserver,
    ) -> Result<ResolvedSettings> {
        let input = RenderInput {
            scene: self.scene(options),
            filter: &self.filter,
            size: self.size,
        };
        let threads = Threads::new(settings.threads)?;
        resolve_auto(&input, &threads, settings, observer)
    }

    /// The settings of a render of a variant.
    pub fn settings(&self, variant: &Variant, spp: u64, seed: u64) -> RenderSettings {
        RenderSettings {
            budget: Budget::samples(spp),
            seed,
            // Small tiles, so that small images have enough of them for all threads.
            tile_size: 16,
            window: RenderSettings::new(self.size, spp).window,
            ..variant.settings.clone()
        }
    }

    /// The scene on a film of another size; nothing is built again.
    pub fn on_film(&self, size: (u32, u32)) -> Self {
        let scenes = self.scenes.iter();
        let scenes = scenes.map(|(options, scene)| (*options, scene.on_film(self.size, size)));
        Self {
            filter: self.filter.clone(),
            size,
            scenes: scenes.collect(),
            notes: self.notes.clone(),
            builds: self.builds.clone(),
        }
    }

    /// Renders a variant; `None` if it was cancelled.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(
        &self,
        variant: &Variant,
        settings: &RenderSettings,
        observer: &dyn RenderObserver,
    ) -> Result<Option<Shot>> {
        let scene = self.scene(variant.options);
        let stopwatch = Stopwatch::start();
        let rendered = render(scene, &self.filter, self.size, settings, observer)?;
        let seconds = stopwatch.read();
        Ok((!rendered.cancelled).then_some(Shot {
            film: rendered.film,
            seconds,
            rejected: rendered.rejected.count,
        }))
    }
}
