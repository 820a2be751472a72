//! `auto`: the choice of an integrator for a scene, from its effects and by a small pilot.
//!
//! The pilot shares no random numbers with the image, so that the image is that of the chosen integrator, bit for bit,
//! and as unbiased. The same scene, seed and settings always give the same choice, on any number of threads: nothing is
//! timed.
//!
//! Measure: as in `rule.rs`.
//! Range: any scene. Among `path`, `bdpt` and `mlt`: biased integrators are mentioned, never chosen.
//! Source: docs/accuracy.md, "Which integrator". Tested in `tests/rendering/auto.rs` and `cli/tests/command/auto.rs`.

mod known;
mod light_paths;
mod pass;
mod pilot;
mod reuse;
mod rule;
mod weight_window;

use super::settings::{Adaptive, Budget, RenderSettings};
use super::{RenderInput, RenderObserver, Rendered, Threads, check, check_is_lit, resume};
use crate::effects::{Effect, EffectSet, Kernel};
use crate::error::{ErrorKind, Result};
use crate::film::Window;
use crate::integrator::Roulette;
use crate::integrator::kind::IntegratorKind;
use crate::integrator::light_paths::LightPathShare;
use crate::sampler::hash;
use crate::scene::Scene;
pub use known::with_known_choices;
pub use light_paths::LightPathChoice;
use pilot::Pilot;
pub use reuse::PathReuseChoice;
pub use rule::Candidate;
use rule::{RuleInput, choose};
pub use weight_window::WeightWindowChoice;

/// The approximate number of pixels of the pilot's images.
const PIXELS: f64 = 5000.0;

/// The samples per pixel of the pilot's images, but for those by `path`.
const SPP: u64 = 16;
/// The samples per pixel of the pilot's images by `path`, which are faster to render.
const SPP_OF_PATH: u64 = 32;

/// The offset of the pilots' seeds, which are combined with the seed of the image.
const SEEDS: u64 = 0x0061_7574_6f00;

/// The integrator that `auto` recommends.
#[derive(Debug, Clone, PartialEq)]
pub struct Recommendation {
    /// The integrator.
    pub integrator: IntegratorKind,
    /// The reason, in words.
    pub why: String,
    /// The integrators that it was compared with, itself among them; empty where no pilot was needed.
    pub candidates: Vec<Candidate>,
    /// A biased integrator that may be more efficient, and its purpose.
    pub option: Option<String>,
    /// The choices for `path`.
    pub choices: PathChoices,
}

/// The choices of pilots for renders by `path`; `None` where no pilot was needed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PathChoices {
    /// The number of light paths.
    pub light_paths: Option<LightPathChoice>,
    /// The number of pixels that share their paths.
    pub reuse: Option<PathReuseChoice>,
    /// The weight window of roulette.
    pub weight_window: Option<WeightWindowChoice>,
}

impl PathChoices {
    /// Settings with the number of light paths in place of `auto`.
    fn apply_light_paths(&self, settings: &RenderSettings) -> RenderSettings {
        settings.with_light_paths(self.light_paths.map(|choice| choice.rule))
    }

    /// Settings with all choices in place of `auto`.
    fn apply(&self, settings: &RenderSettings) -> RenderSettings {
        let settings = self.apply_light_paths(settings);
        let mut settings = settings.with_reuse(self.reuse.map(|choice| choice.reuse));
        if settings.integrator == IntegratorKind::Path {
            let chosen = self.weight_window.map(|choice| choice.roulette);
            settings.roulette = settings.roulette.or(chosen);
        }
        settings
    }
}

/// Recommends an integrator for these settings, whichever they name, by a pilot on these threads; `path` if `observer`
/// cancels the pilot.
///
/// # Errors
/// The errors of a render by any of the integrators.
pub fn recommend(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<Recommendation> {
    let by_path = RenderSettings {
        integrator: IntegratorKind::Path,
        ..settings.clone()
    };
    let mut choices = choose_for_path(input, threads, &by_path, observer)?;
    let by_path = choices.apply(&by_path);
    let settings = &by_path;
    let kinds = [
        IntegratorKind::Path,
        IntegratorKind::Bidirectional,
        IntegratorKind::Metropolis,
    ];
    let able = kinds.into_iter().filter(|&integrator| {
        let settings = RenderSettings {
            integrator,
            ..settings.clone()
        };
        settings.validate(input.size).is_ok() && check(input.scene, &settings).is_ok()
    });
    let able: Vec<IntegratorKind> = able.collect();
    let effects = input.scene.effects;
    let mut candidates = vec![];
    if able.len() > 1 {
        let pilot_run = PilotRun::new(input, threads, settings, observer);
        match pilot_run.candidates(&able)? {
            Some(measured) => candidates = measured,
            None => return Ok(interrupted()),
        }
    }
    let has_light_paths = by_path.light_path_share() != LightPathShare::None;
    let facts = RuleInput {
        is_missed_by_path: !has_light_paths
            && effects.has(Effect::DeltaLights)
            && effects.has(Effect::Specular),
        has_smooth_surfaces: effects.has(Effect::Specular),
        candidates,
    };
    let (integrator, why) = choose(&facts);
    choices.weight_window = weight_window::choose(input, threads, &by_path, observer)?;
    Ok(Recommendation {
        integrator,
        why,
        candidates: facts.candidates,
        option: option(effects),
        choices,
    })
}

/// Settings in which nothing is left to be chosen, and what was chosen by pilots.
#[derive(Debug, Clone)]
pub struct ResolvedSettings {
    /// The settings.
    pub settings: RenderSettings,
    /// The recommendation of an integrator, if `auto` was requested.
    pub recommendation: Option<Recommendation>,
    /// The choices for `path`.
    pub choices: PathChoices,
}

/// Replaces `auto` in settings by an integrator, a number of light paths and a number of pixels that share paths, and chooses
/// the weight window of `path` if they leave it to a pilot.
///
/// # Errors
/// The errors of [`recommend`].
pub fn resolve_auto(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<ResolvedSettings> {
    let (mut resolved, mut recommendation) = (settings.clone(), None);
    let choices = if settings.integrator == IntegratorKind::Auto {
        let recommended = recommend(input, threads, settings, observer)?;
        resolved.integrator = recommended.integrator;
        recommendation.insert(recommended).choices
    } else {
        let mut choices = choose_for_path(input, threads, settings, observer)?;
        choices.weight_window =
            weight_window::choose(input, threads, &choices.apply(settings), observer)?;
        choices
    };
    Ok(ResolvedSettings {
        settings: choices.apply(&resolved),
        recommendation,
        choices,
    })
}

/// Chooses what settings of a render by `path` leave to pilots, but for the weight window.
fn choose_for_path(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<PathChoices> {
    let mut choices = PathChoices {
        light_paths: light_paths::choose(input, threads, settings, observer)?,
        ..PathChoices::default()
    };
    // Light paths, which exclude shared ones, find what no other path finds well.
    let settings = choices.apply_light_paths(settings);
    choices.reuse = reuse::choose(input, threads, &settings, observer)?;
    Ok(choices)
}

/// Whether light paths and shared paths may find light in the place of the settings' own paths. Settings without
/// roulette ask for plain paths, to compare the work of renderers.
fn takes_other_paths(settings: &RenderSettings) -> bool {
    settings.integrator == IntegratorKind::Path
        && settings.adaptive != Adaptive::Greedy
        && settings.roulette != Some(Roulette::None)
        && settings.bounce_limit().is_none_or(|limit| limit > 1)
}

/// Whether the kernel of the settings, if they name one, has an effect: what a pilot chooses must not make a render fail.
fn may_have(settings: &RenderSettings, effect: Effect) -> bool {
    let has = |kernel: Kernel| kernel.effects().has(effect);
    settings.kernel.is_none_or(has)
}

/// The recommendation after an interrupted pilot.
fn interrupted() -> Recommendation {
    Recommendation {
        integrator: IntegratorKind::Path,
        why: "the pilot was interrupted".to_owned(),
        candidates: vec![],
        option: None,
        choices: PathChoices::default(),
    }
}

/// A biased integrator that is worth trying, with its purpose.
fn option(effects: EffectSet) -> Option<String> {
    let not_matte = [Effect::Glossy, Effect::Specular, Effect::Transmission];
    let is_matte = !not_matte.into_iter().any(|effect| effects.has(effect));
    (is_matte && !effects.has(Effect::Motion)).then(|| {
        "every surface is matte: irradiance-cache may be faster, biased within its --cache-error"
            .to_owned()
    })
}

/// An observer that passes on cancellation, and nothing else.
struct CancellationOnly<'a>(&'a dyn RenderObserver);

impl RenderObserver for CancellationOnly<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }

    fn shows_error(&self) -> bool {
        false
    }
}

/// Renders the image of a pilot.
fn render_pilot(
    input: &RenderInput<'_>,
    threads: &Threads,
    settings: &RenderSettings,
    observer: &dyn RenderObserver,
) -> Result<Rendered> {
    let mut rendered = Rendered::empty(settings, input.filter);
    resume(
        input,
        threads,
        settings,
        settings.budget,
        &mut rendered,
        &CancellationOnly(observer),
    )?;
    Ok(rendered)
}

/// The context of pilots: the scene on a small film.
struct PilotRun<'a> {
    scene: Scene,
    size: (u32, u32),
    input: &'a RenderInput<'a>,
    threads: &'a Threads,
    settings: &'a RenderSettings,
    observer: &'a dyn RenderObserver,
}

impl<'a> PilotRun<'a> {
    fn new(
        input: &'a RenderInput<'a>,
        threads: &'a Threads,
        settings: &'a RenderSettings,
        observer: &'a dyn RenderObserver,
    ) -> Self {
        let (scene, size) = input.scene.reduced(input.size, PIXELS);
        Self {
            scene,
            size,
            input,
            threads,
            settings,
            observer,
        }
    }

    /// Measures each of the integrators; `None` if the observer cancelled the pilot.
    fn candidates(&self, integrators: &[IntegratorKind]) -> Result<Option<Vec<Candidate>>> {
        let mut pilots = Vec::new();
        for &integrator in integrators {
            pilots.extend(self.pilot(integrator)?);
            if self.observer.is_cancelled() {
                return Ok(None);
            }
        }
        Ok(Some(pilot::inefficiencies(&pilots)))
    }

    /// Renders two images by one integrator; `None` if it found no light to start at.
    fn pilot(&self, integrator: IntegratorKind) -> Result<Option<Pilot>> {
        let one = |index| -> Result<_> {
            let settings = self.settings_of(integrator, index);
            let input = RenderInput {
                scene: &self.scene,
                size: self.size,
                ..*self.input
            };
            let rendered = render_pilot(&input, self.threads, &settings, self.observer)?;
            check_is_lit(&settings, &rendered)?;
            Ok((rendered.film.develop(), rendered.rays.total()))
        };
        let images = one(0).and_then(|first| one(1).map(|second| [first, second]));
        match images {
            Ok([(a, rays_a), (b, rays_b)]) => Ok(Some(Pilot {
                integrator,
                rays: 0.5 * (rays_a + rays_b) as f64,
                images: [a, b],
            })),
            Err(error) if error.kind() == ErrorKind::Render => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The settings of a pilot's image.
    fn settings_of(&self, integrator: IntegratorKind, index: u64) -> RenderSettings {
        let spp = match integrator {
            IntegratorKind::Path => SPP_OF_PATH,
            _ => SPP,
        };
        RenderSettings {
            integrator,
            seed: hash::combine(self.settings.seed, SEEDS + index),
            budget: Budget::samples(spp),
            adaptive: Adaptive::Off,
            layers: false,
            window: Window::whole(self.size),
            ..self.settings.clone()
        }
    }
}
