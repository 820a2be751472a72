//! A scene that is rendered by several integrators under equal conditions.
//!
//! Measure: pixels, samples, seconds.
//! Range: scenes in memory. All renders use the kernel with all effects, so that only the estimator differs, and
//! independent random numbers, as the course does.
//! Source: `render/`. Tested in `lab/tests/reports/lesson.rs`.

use super::topic::Lesson;
use etendue::Result;
use etendue::internals::accel::{AccelOptions, Backend, Precision};
use etendue::internals::effects::Kernel;
use etendue::internals::film::filter::Filter;
use etendue::internals::integrator::Roulette;
use etendue::internals::integrator::kind::IntegratorKind;
use etendue::internals::render::settings::{Budget, RenderSettings, SamplerKind};
use etendue::internals::render::{Rendered, render};
use etendue::internals::scene::Scene;
use etendue::internals::scene::description::{FilterDescription, FilterKind, SceneDescription};
use etendue::internals::scene::prepare::prepare;

/// The light paths that are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LessonLight {
    /// Emission, and light reflected once.
    Direct,
    /// All paths.
    Whole,
}

/// A prepared scene.
pub struct LessonScene<'a> {
    lesson: &'a Lesson<'a>,
    scene: Scene,
    filter: Filter,
    size: (u32, u32),
}

impl<'a> LessonScene<'a> {
    /// Prepares the scene for an image of this size, with a box filter, so that pixels share no samples.
    pub fn new(
        lesson: &'a Lesson<'a>,
        mut description: SceneDescription,
        size: (u32, u32),
    ) -> Result<Self> {
        description.film.size = size;
        let kind = FilterKind::Box;
        let radius = kind.default_radius();
        description.film.filter = FilterDescription { kind, radius };
        let options = AccelOptions {
            backend: Backend::ALL[0],
            precision: Precision::default(),
            quality: None,
            threads: lesson.settings.threads,
        };
        Ok(Self {
            lesson,
            scene: prepare(&description, options)?.scene,
            filter: Filter::new(&description.film.filter),
            size,
        })
    }

    /// Renders the scene with the given integrator.
    pub fn render(
        &self,
        integrator: IntegratorKind,
        budget: Budget,
        seed: u64,
        light: LessonLight,
    ) -> Result<Rendered> {
        let (max_bounces, roulette) = match light {
            // After the only bounce roulette has nothing to save, and would add variance.
            LessonLight::Direct => (Some(1), Some(Roulette::None)),
            LessonLight::Whole => (None, None),
        };
        let settings = RenderSettings {
            integrator,
            sampler: SamplerKind::Independent,
            kernel: Some(Kernel::Everything),
            seed,
            budget,
            max_bounces,
            roulette,
            threads: self.lesson.settings.threads,
            tile_size: 16,
            ..RenderSettings::new(self.size, 1)
        };
        render(&self.scene, &self.filter, self.size, &settings, self.lesson)
    }
}
